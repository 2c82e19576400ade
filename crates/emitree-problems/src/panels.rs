//! Pixel means of a smooth function of two variables, for images of any shape.
//!
//! Each axis is cut into panels that suit the function, not the pixels. On each panel the function
//! is the polynomial through its values at Gauss–Legendre nodes, and the means of this polynomial
//! over pixels, or over the parts of them that lie in the panel, are exact. So the number of lines
//! of sight does not depend on the number of pixels. A pixel that holds whole panels gets the
//! Gauss–Legendre rule itself.

use crate::gauss::Gauss;
use emitree::Image;
use rayon::prelude::*;

/// The nodes along one axis, and the weights of their values in the means over pixels.
#[derive(Clone, Debug)]
pub(crate) struct PanelAxis {
    nodes: Vec<f64>,
    pixels: Vec<PixelMean>,
}

/// The mean over one pixel: a weight for each of the nodes from `first` on.
#[derive(Clone, Debug)]
struct PixelMean {
    first: usize,
    weights: Vec<f64>,
}

impl PanelAxis {
    /// `pixels` equal pixels on \[0, 1\], from panels between `borders` (increasing, from 0 to 1)
    /// with `per_panel` nodes each.
    pub(crate) fn new(borders: &[f64], per_panel: usize, pixels: usize) -> Self {
        let rule = Gauss::new(per_panel);
        let panels = || borders.windows(2).map(|ends| (ends[0], ends[1]));
        let place = |(from, to): (f64, f64), t: f64| 0.5 * (from + to) + 0.5 * (to - from) * t;
        let nodes = panels().flat_map(|panel| rule.nodes().iter().map(move |&t| place(panel, t)));
        let nodes = nodes.collect();
        let legendre_at_nodes: Vec<Vec<f64>> =
            rule.nodes().iter().map(|&t| legendre(t, per_panel)).collect();

        let mean = |pixel: usize| {
            let (low, high) = (pixel as f64 / pixels as f64, (pixel + 1) as f64 / pixels as f64);
            let mut mean = PixelMean { first: 0, weights: Vec::new() };
            for (i, (from, to)) in panels().enumerate() {
                let (start, end) = (low.max(from), high.min(to));
                if start >= end {
                    continue;
                }
                if mean.weights.is_empty() {
                    mean.first = i * per_panel;
                }
                let reference = |x: f64| (2.0 * x - from - to) / (to - from);
                let integrals = integrals(reference(start), reference(end), per_panel);
                let scale = (to - from) / (2.0 * (high - low));
                let at_nodes = rule.weights().iter().zip(&legendre_at_nodes);
                mean.weights.extend(at_nodes.map(|(weight, legendre)| {
                    let series = legendre.iter().zip(&integrals).map(|(p, integral)| p * integral);
                    scale * weight * series.sum::<f64>()
                }));
            }
            mean
        };
        Self { nodes, pixels: (0..pixels).map(mean).collect() }
    }

    /// As [`new`](Self::new), with panels of equal width, enough of them for a function whose
    /// slices are as narrow as exp(−t²/`width`²).
    pub(crate) fn uniform(width: f64, per_panel: usize, pixels: usize) -> Self {
        let panels = count(1.0, width);
        let borders: Vec<f64> = (0..=panels).map(|i| i as f64 / panels as f64).collect();
        Self::new(&borders, per_panel, pixels)
    }

    /// As [`new`](Self::new), with panels that double in width with the distance from `centre`,
    /// from `length` on: for a function that is singular at `centre` ± i `length` in the complex
    /// plane, as powers of `length`² + (t − `centre`)² are.
    pub(crate) fn graded(centre: f64, length: f64, per_panel: usize, pixels: usize) -> Self {
        let farthest = centre.abs().max((1.0 - centre).abs());
        let distances = core::iter::successors(Some(length), |distance| Some(2.0 * distance));
        let distances = distances.take_while(|&distance| distance < farthest);
        let mut borders: Vec<f64> = distances.flat_map(|d| [centre - d, centre + d]).collect();
        borders.push(centre);
        borders.retain(|&border| border > 0.0 && border < 1.0);
        borders.extend([0.0, 1.0]);
        borders.sort_by(f64::total_cmp);
        Self::new(&borders, per_panel, pixels)
    }

    /// The means over the pixels of `bands` functions of one variable at once: `f` adds their values
    /// at a node to zeros. The bands of a pixel are neighbours in the result.
    fn means(&self, bands: usize, f: impl Fn(f64, &mut [f64])) -> Vec<f64> {
        let mut values = vec![0.0; bands * self.nodes.len()];
        for (&node, values) in self.nodes.iter().zip(values.chunks_exact_mut(bands.max(1))) {
            f(node, values);
        }
        let mut means = vec![0.0; bands * self.pixels.len()];
        for (pixel, means) in self.pixels.iter().zip(means.chunks_exact_mut(bands.max(1))) {
            pixel.add_mean(&values, means);
        }
        means
    }
}

impl PixelMean {
    /// Adds the mean of each column of `values`, which has a row for each node of the axis.
    fn add_mean(&self, values: &[f64], means: &mut [f64]) {
        let rows = values.chunks_exact(means.len().max(1)).skip(self.first);
        for (weight, row) in self.weights.iter().zip(rows) {
            for (mean, value) in means.iter_mut().zip(row) {
                *mean += weight * value;
            }
        }
    }
}

/// The image whose pixels are the means of `line(x, y)`.
pub(crate) fn image(x: &PanelAxis, y: &PanelAxis, line: impl Fn(f64, f64) -> f64 + Sync) -> Image {
    let pixels = means(x, y, 1, |x, y, values| values[0] = line(x, y));
    Image::from_pixels(y.pixels.len(), x.pixels.len(), pixels)
}

/// `bands` images at once: their pixels are the means of what `line(x, y, values)` adds to the zeros
/// in `values`, one a band.
pub(crate) fn images(
    x: &PanelAxis,
    y: &PanelAxis,
    bands: usize,
    line: impl Fn(f64, f64, &mut [f64]) + Sync,
) -> Vec<Image> {
    let means = means(x, y, bands, line);
    let pixels = |band: usize| means.iter().skip(band).step_by(bands).copied().collect();
    let (height, width) = (y.pixels.len(), x.pixels.len());
    (0..bands).map(|band| Image::from_pixels(height, width, pixels(band))).collect()
}

/// The pixel means of `bands` functions, row after row; the bands of a pixel are neighbours.
fn means(
    x: &PanelAxis,
    y: &PanelAxis,
    bands: usize,
    line: impl Fn(f64, f64, &mut [f64]) + Sync,
) -> Vec<f64> {
    let strip = |&at: &f64| x.means(bands, |x_at, values| line(x_at, at, values));
    let strips: Vec<Vec<f64>> = y.nodes.par_iter().map(strip).collect();
    let strips = strips.concat();
    let mut means = vec![0.0; y.pixels.len() * x.pixels.len() * bands];
    let rows = means.par_chunks_exact_mut((x.pixels.len() * bands).max(1));
    rows.zip(&y.pixels).for_each(|(row, mean)| mean.add_mean(&strips, row));
    means
}

/// How many panels of `extent` a function needs whose slices are as narrow as exp(−t²/`width`²).
///
/// A panel is 4 widths long. There the Chebyshev coefficient of degree n is about 1/(n/2)!, which is
/// 3e-6 for n = 18 and 2e-9 for n = 24.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a small positive number; a cast of anything else saturates"
)]
pub(crate) fn count(extent: f64, width: f64) -> usize {
    ((extent / (4.0 * width)).ceil() as usize).max(1)
}

/// The Legendre polynomials of degrees 0 to `count` − 1 at t (DLMF 18.9.1).
fn legendre(t: f64, count: usize) -> Vec<f64> {
    let mut values = vec![1.0, t];
    for degree in 1..count.max(1) {
        let n = degree as f64;
        let next = (2.0 * n + 1.0) * t * values[degree] - n * values[degree - 1];
        values.push(next / (n + 1.0));
    }
    values.truncate(count);
    values
}

/// (2 n + 1)/2 times the integral of each Legendre polynomial of degree n < `count` from s to t,
/// which is half the increment of their neighbours' difference (DLMF 18.9.7): the polynomial
/// through values fⱼ at Gauss nodes has Σⱼ wⱼ fⱼ Pₙ(tⱼ) times this as its integral.
fn integrals(s: f64, t: f64, count: usize) -> Vec<f64> {
    let (at_s, at_t) = (legendre(s, count + 1), legendre(t, count + 1));
    let increment = |degree: usize| at_t[degree] - at_s[degree];
    let half = |n: usize| if n == 0 { t - s } else { increment(n + 1) - increment(n - 1) };
    (0..count).map(|n| 0.5 * half(n)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Exact for polynomials below the number of nodes, wherever pixels and panels meet.
    #[test]
    fn means_of_polynomials_are_exact() {
        let axes = [
            PanelAxis::new(&[0.0, 1.0], 6, 7),
            PanelAxis::new(&[0.0, 0.3, 0.35, 1.0], 6, 5),
            PanelAxis::graded(0.4, 0.03, 6, 3),
            PanelAxis::graded(-0.4, 0.03, 6, 1),
            PanelAxis::uniform(0.02, 6, 4),
        ];
        for axis in axes {
            let means = axis.means(1, |t, values| values[0] = t.powi(5) - t);
            let pixels = means.len() as f64;
            let primitive = |i: usize| {
                let t = i as f64 / pixels;
                t.powi(6) / 6.0 - t * t / 2.0
            };
            for (i, mean) in means.iter().enumerate() {
                assert!((mean - pixels * (primitive(i + 1) - primitive(i))).abs() < 1e-14);
            }
        }
    }

    /// x runs along the columns, y along the rows.
    #[test]
    fn the_image_has_rows_along_y() {
        let axis = |pixels| PanelAxis::new(&[0.0, 1.0], 4, pixels);
        let image = image(&axis(3), &axis(2), |x, y| x + 10.0 * y);
        for (row, column) in [(0, 0), (1, 0), (1, 2)] {
            let expected = (column as f64 + 0.5) / 3.0 + 10.0 * (row as f64 + 0.5) / 2.0;
            assert!((image[(row, column)] - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn bands_are_images_of_their_own() {
        let axis = |pixels| PanelAxis::new(&[0.0, 0.4, 1.0], 5, pixels);
        let (x, y) = (axis(3), axis(2));
        let bands = images(&x, &y, 2, |x, y, values| {
            values[0] = x.exp() * y;
            values[1] = (x - y).powi(2);
        });
        assert_eq!(bands[0], image(&x, &y, |x, y| x.exp() * y));
        assert_eq!(bands[1], image(&x, &y, |x, y| (x - y).powi(2)));
    }
}
