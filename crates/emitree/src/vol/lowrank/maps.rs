//! Image and error of a part from the present interpolant.

use crate::cube::Cube;
use crate::image::Image;
use crate::parallel::prelude::*;
use crate::radiance::rows_at_once;
use crate::tree::StopReason;
use crate::vol::lowrank::Attempt;
use crate::vol::lowrank::probes::CellResiduals;
use crate::vol::lowrank::search::Assessment;

impl Attempt<'_> {
    /// Computes the image for the largest of its pixels, which replaces that of the raster.
    pub(super) fn find_pixel_share(&mut self, maps: &mut Maps) {
        let footing = &self.part.footing;
        if !footing.is_raster_of_pixels() && maps.largest > 0.0 {
            let means = |shape| self.search.interpolant.means(shape);
            let (_, image) = footing.image(means, &self.part.scale);
            self.pixel_share = (image.largest() / maps.largest).min(1.0);
            maps.largest *= self.pixel_share;
        }
    }

    /// Image and error on the raster of the part.
    pub(super) fn maps(&self, assessment: &Assessment) -> Maps {
        let shape @ [height, width] = shape_of(&self.part.scale);
        let (pixels, errors) =
            (self.search.interpolant.pixels(shape), assessment.cell_residuals.errors(shape));
        let (mut image, mut error) = (Image::zeros(height, width), Image::zeros(height, width));
        let of_row = |(row, (image, error)): (usize, (&mut [f64], &mut [f64]))| {
            let scale = self.part.scale.row(row);
            pixels.row(row, image);
            errors.row(row, error);
            [image, error].map(|values| scale_and_find_largest(values, scale))
        };
        let image_rows = image.pixels_mut().par_chunks_mut(width);
        let [largest, largest_error] = image_rows
            .zip(error.pixels_mut().par_chunks_mut(width))
            .enumerate()
            .with_min_len(rows_at_once(width))
            .map(of_row)
            .reduce(|| [0.0; 2], |a, b| [larger(a[0], b[0]), larger(a[1], b[1])]);
        self.remove_weights(&mut error, assessment);
        let residuals = assessment.cell_residuals.clone();
        Maps { image, error, largest, largest_error, residuals }
    }

    /// Passes the current image to the observer of the rendering, if there is one, the rank is not
    /// 0 and the image is that of the only part.
    pub(super) fn show(&self, assessment: &Assessment) {
        if self.shows() && !self.search.interpolant.ranks().contains(&0) {
            self.show_maps(&self.maps(assessment));
        }
    }

    /// Whether the image is that which an observer waits for, and not one of the energies of a cube.
    pub(super) fn shows(&self) -> bool {
        self.meter.keeps_images() && self.search.view.energies.is_empty()
    }

    pub(super) fn show_maps(&self, maps: &Maps) {
        if self.shows() && self.parts == 1 {
            self.meter.show(self.cubes(maps));
        }
    }

    /// Image and error of the only part, as those of the view.
    pub(super) fn cubes(&self, Maps { image, error, .. }: &Maps) -> [Cube; 2] {
        let footing = &self.part.footing;
        let [image, error] = if footing.is_raster_of_pixels() {
            [image.clone(), error.clone()]
        } else {
            let means = |shape| self.search.interpolant.means(shape);
            [footing.image(means, &self.part.scale).1, footing.errors(error.clone())]
        };
        [image, error].map(|mut map| {
            self.outside.iter().for_each(|&pixel| map.pixels_mut()[pixel] = f64::NAN);
            Cube::from_bands(vec![map])
        })
    }

    /// The image of a search that ended before its goal.
    pub(super) fn unfinished(&mut self) -> (Maps, StopReason) {
        let assessment = self.search.assess();
        (self.maps(&assessment), StopReason::Budget)
    }
}

/// An image and its error, with the largest |pixel| and the largest weighted error, which are infinite or
/// NaN if a pixel is.
pub(super) struct Maps {
    pub(super) image: Image,
    pub(super) error: Image,
    pub(super) largest: f64,
    pub(super) largest_error: f64,
    /// What the error follows from, unless errors have weights.
    pub(super) residuals: CellResiduals,
}

pub(super) fn shape_of(image: &Image) -> [usize; 2] {
    [image.height(), image.width()]
}

/// The [larger] of all |value| that `fill` writes to rows, times the scale.
pub(super) fn largest_of_rows(scale: &Image, fill: impl Fn(usize, &mut [f64])) -> f64 {
    let mut values = vec![0.0; scale.width()];
    let of_row = |(row, scale): (usize, &[f64])| {
        fill(row, &mut values);
        scale_and_find_largest(&mut values, scale)
    };
    scale.rows().enumerate().map(of_row).fold(0.0, larger)
}

/// Multiplies each value with its scale, and finds the [larger] of all their |value|.
fn scale_and_find_largest(values: &mut [f64], scale: &[f64]) -> f64 {
    let mut largest = 0.0;
    for (value, scale) in values.iter_mut().zip(scale) {
        *value *= scale;
        largest = larger(largest, value.abs());
    }
    largest
}

/// The larger of two numbers; NaN if one is NaN.
fn larger(a: f64, b: f64) -> f64 {
    if a < b || b.is_nan() { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::testing::assert_close;

    #[test]
    fn the_larger_of_two_numbers_is_nan_if_one_is() {
        for larger in [larger(1.0, 2.0), larger(2.0, 1.0)] {
            assert_close(larger, 2.0, 0.0);
        }
        assert!(larger(1.0, f64::NAN).is_nan() && larger(f64::NAN, 1.0).is_nan());
        let mut values = [1.0, -4.0, 2.0];
        assert_close(scale_and_find_largest(&mut values, &[2.0, 0.5, 0.0]), 2.0, 1e-15);
        assert_eq!(values.map(f64::to_bits), [2.0_f64, -2.0, 0.0].map(f64::to_bits));
    }
}
