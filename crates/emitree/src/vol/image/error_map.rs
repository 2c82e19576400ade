//! The error map: the remaining errors around nodes, distributed over the pixels.

use crate::image::Image;
use crate::vol::dyadic::{spacing, unit};
use crate::vol::image::remaining::Remaining;
use crate::vol::image::tree::Node;
use core::ops::Range;

/// The effect of the remaining error around one node on the image: the mean over each pixel of a
/// hat function that falls to 0 at one spacing of the node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footprint {
    centre: [f64; 2],
    half_width: f64,
    /// The remaining error, times the share that does not cancel within a pixel.
    size: f64,
}

/// Means of a hat function of height 1 over the pixels along one axis.
#[derive(Clone, Debug)]
struct Hat {
    first: usize,
    means: Vec<f64>,
}

impl Hat {
    fn new(centre: f64, half_width: f64, pixels: usize) -> Self {
        // The integral of the hat function from its left end.
        let integral = |x: f64| {
            let t = ((x - centre) / half_width).clamp(-1.0, 1.0);
            let of_unit = if t < 0.0 { 0.5 * (1.0 + t) * (1.0 + t) } else { 0.5 + t - 0.5 * t * t };
            half_width * of_unit
        };
        let number = pixels as f64;
        let Range { start, end } = covered(centre - half_width, centre + half_width, pixels);
        let mean = |pixel: usize| {
            let (low, high) = (pixel as f64 / number, (pixel + 1) as f64 / number);
            (integral(high) - integral(low)) * number
        };
        Self { first: start, means: (start..end).map(mean).collect() }
    }
}

/// The pixels that overlap the interval from `low` to `high`.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the axis")]
fn covered(low: f64, high: f64, pixels: usize) -> Range<usize> {
    let number = pixels as f64;
    let from = (low * number).floor().clamp(0.0, number - 1.0) as usize;
    let to = (high * number).ceil().clamp(1.0, number) as usize;
    from..to
}

impl Footprint {
    pub(crate) fn new(node: &Node, remaining: &Remaining, [height, width]: [usize; 2]) -> Self {
        let half_width = unit(spacing(node.level));
        let [x, y] = node.place.map(unit);
        // Errors on scales below a pixel partly cancel: along a curve their sum grows as the root
        // of their number.
        let left = (half_width * height.max(width) as f64).min(1.0).sqrt();
        Self { centre: [x, y], half_width, size: remaining.size * left }
    }

    /// The hat functions along the columns and the rows of a map. They are not stored, since that
    /// of a coarse node covers much of the map.
    fn hats(&self, map: &Image) -> (Hat, Hat) {
        let [x, y] = self.centre;
        (Hat::new(x, self.half_width, map.width()), Hat::new(y, self.half_width, map.height()))
    }

    /// Adds `times` this footprint to `map`, scaled pixel by pixel with `scale`.
    pub(crate) fn add_to(&self, map: &mut Image, scale: &Image, times: f64) {
        let (along_columns, along_rows) = self.hats(map);
        let columns = along_columns.first..along_columns.first + along_columns.means.len();
        for (row, of_row) in (along_rows.first..).zip(&along_rows.means) {
            let size = times * self.size * of_row;
            let scales = &scale.row(row)[columns.clone()];
            let pixels = &mut map.row_mut(row)[columns.clone()];
            for ((pixel, mean), scale) in pixels.iter_mut().zip(&along_columns.means).zip(scales) {
                *pixel += size * mean * scale;
            }
        }
    }

    /// The largest `scale` of the pixels in the footprint.
    pub(crate) fn largest_scale(&self, scale: &Image) -> f64 {
        let (along_columns, along_rows) = self.hats(scale);
        let columns = along_columns.first..along_columns.first + along_columns.means.len();
        let rows = along_rows.first..along_rows.first + along_rows.means.len();
        rows.flat_map(|row| &scale.row(row)[columns.clone()]).copied().fold(0.0, f64::max)
    }

    /// Whether a pixel in the footprint with a `scale` other than 0 is above `limit`.
    pub(crate) fn touches_above(&self, map: &Image, scale: &Image, limit: f64) -> bool {
        let (along_columns, along_rows) = self.hats(map);
        let columns = along_columns.first..along_columns.first + along_columns.means.len();
        let rows = (along_rows.first..).zip(&along_rows.means).filter(|(_, mean)| **mean > 0.0);
        rows.into_iter().any(|(row, _)| {
            let scales = &scale.row(row)[columns.clone()];
            let pixels = map.row(row)[columns.clone()].iter().zip(&along_columns.means);
            let reached = |((&pixel, &mean), &scale): ((&f64, &f64), &f64)| {
                mean > 0.0 && pixel > limit && scale > 0.0
            };
            pixels.zip(scales).any(reached)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_means_of_a_hat_add_up_to_its_integral() {
        for (centre, half_width, pixels) in [(0.5, 0.125, 64), (0.3, 0.01, 7), (0.75, 0.25, 100)] {
            let hat = Hat::new(centre, half_width, pixels);
            let sum: f64 = hat.means.iter().sum();
            assert!((sum / pixels as f64 - half_width).abs() < 1e-15, "{centre} {half_width}");
        }
        // Half of the hat function lies outside the image.
        let half: f64 = Hat::new(1.0, 0.25, 16).means.iter().sum();
        assert!((half / 16.0 - 0.125).abs() < 1e-15);
    }
}
