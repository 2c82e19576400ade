//! A line of sight through each pixel, to the tolerance: where that takes less time than fewer evaluations.
//!
//! Rates that take some ten nanoseconds cost less than the choice of the next point. If time is to be minimized, and
//! evaluations turn out to be that cheap, all pixels have a line through their middle, in the fewest uniform steps that
//! scattered lines allow (`steps`). Differences between pixels give the means over pixels and their errors
//! (`differences`); pixels with larger errors have more lines. The scattered lines, whose places are in no pixel's middle,
//! are compared with the image. If the error of a pixel stays beyond the tolerance there is no such image.

mod differences;
mod steps;

use crate::cube::Cube;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::meter::Meter;
use crate::output::MethodOutput;
use crate::tile::Tile;
use crate::tree::StopReason;
use crate::vol::options::{Minimize, VolOptions};
use crate::vol::tuning::TUNING;
use crate::vol::view::part::atlas;
use differences::{FEWEST, Middles};
use steps::Steps;

/// What the other ways to an image take without the time of g, some times as much where they need many lines: a
/// tenth of a second, and 3 microseconds for each pixel in charts.
const SECONDS: f64 = 0.1;
const SECONDS_OF_PIXEL: f64 = 3e-6;
/// Products take no longer than that.
const SECONDS_OF_PRODUCTS: f64 = 0.02;
/// The share of the error allowed that the mean over a pixel may have: one with more has more lines.
const OF_PIXEL: f64 = 0.4;
/// Lines along each side of a pixel with more of them, in the order in which they are tried.
const PER_SIDE: [usize; 4] = [2, 4, 8, 16];
/// Their steps are finer so many times: structure of the image between pixels is often narrow in depth, too.
const FINER: usize = 3;
/// The largest share of pixels with more lines.
const MOST_DIVIDED: f64 = 0.2;
/// One of so many scattered lines may be far from the image: its pixel has more lines then.
const LINES_OF_A_MISS: usize = 64;

/// Lines through all pixels that have not been integrated yet.
pub(super) struct PixelLines<'a> {
    meter: &'a Meter,
    tile: &'a Tile<'a>,
    tolerance: f64,
    steps: Steps,
    most_seconds: f64,
}

/// The values of a pixel with several lines.
#[derive(Clone, Copy, Debug)]
struct Divided {
    pixel: usize,
    mean: f64,
    error: f64,
    is_settled: bool,
}

impl<'a> PixelLines<'a> {
    /// Lines that are expected to take less time than anything else; `None` if evaluations are to be few, or are not
    /// cheap enough, and for views and options that such lines do not serve.
    pub(super) async fn expected(
        meter: &'a Meter,
        tiles: &'a [Tile<'a>],
        vol: &VolOptions,
    ) -> Result<Option<Self>, MethodError> {
        let [tile] = tiles else { return Ok(None) };
        let geometry = tile.projection.view_geometry();
        let may_be = vol.minimize == Minimize::Time
            && vol.is_uniform()
            && vol.sums.is_empty()
            && vol.lines.is_none()
            && vol.seeds.is_empty()
            && vol.smallest_feature.is_none()
            && vol.base_level <= VolOptions::default().base_level
            // What is done depends on time: no method that is repeated may do it.
            && !meter.keeps_rates()
            && !meter.freezes()
            && meter.start().is_none()
            && meter.rows_wanted().is_none()
            && tile.shape.iter().all(|&pixels| pixels >= FEWEST)
            && geometry.is_none_or(|geometry| !geometry.has_rim())
            && !atlas(tiles, &[]).is_some_and(|atlas| atlas.has_singularities());
        if !may_be {
            return Ok(None);
        }
        let pixels = (tile.shape[0] * tile.shape[1]) as f64;
        let most_seconds = SECONDS + SECONDS_OF_PIXEL * pixels;
        // As loose as those of other images are.
        let tolerance = vol.tolerance.min(TUNING.engine.loosest_tolerance);
        let steps = Steps::find(meter, tile, tolerance, most_seconds).await?;
        Ok(steps.map(|steps| Self { meter, tile, tolerance, steps, most_seconds }))
    }

    /// Whether they are expected to take no longer than products, which serve many images.
    pub(super) fn are_few(&self) -> bool {
        let [height, width] = self.tile.shape;
        self.steps.seconds * (height * width * self.steps.number) as f64 <= SECONDS_OF_PRODUCTS
    }

    /// The image; `None` if some of its errors would be beyond the tolerance.
    pub(super) async fn render(&self) -> Result<Option<MethodOutput>, MethodError> {
        let (tile, shape @ [height, width]) = (self.tile, self.tile.shape);
        let count = height * width;
        let place = |pixel: usize| place_in_pixel(shape, pixel, [0.5, 0.5]);
        let lines = self.steps.radiances(self.meter, tile, &place, count, 1).await?;
        let Some(lines) = lines else { return Ok(None) };
        let densities: Vec<f64> =
            (0..count).map(|pixel| tile.projection.solid_angle_density(place(pixel))).collect();
        let values: Vec<f64> =
            lines.iter().zip(&densities).map(|(line, density)| line.radiance * density).collect();
        let middles = Middles { values: &values, shape };
        let means = middles.means();
        let of_densities = Middles { values: &densities, shape }.means();
        let mut image = Image::zeros(height, width);
        let mut errors = Image::zeros(height, width);
        let mut largest = self.steps.largest;
        for pixel in 0..count {
            let density = densities[pixel] + of_densities.corrections.pixels()[pixel];
            let mean = (values[pixel] + means.corrections.pixels()[pixel]) / density;
            image.pixels_mut()[pixel] = mean;
            errors.pixels_mut()[pixel] = lines[pixel].error + means.errors.pixels()[pixel] / density;
            largest = largest.max(mean.abs());
        }
        tile.check_finite(&image, 0)?;
        let allowed = self.tolerance * largest;
        let has_large = |pixel: &usize| {
            errors.pixels()[*pixel] - lines[*pixel].error > OF_PIXEL * allowed
        };
        let mut divided: Vec<usize> = (0..count).filter(has_large).collect();
        // Scattered lines took no part in the image.
        let far = self.steps.checks.iter().filter_map(|check| {
            let (value, pixel) = middles.at(check.place);
            let density = tile.projection.solid_angle_density(check.place);
            let beyond = (value / density - check.radiance).abs()
                - means.variation.pixels()[pixel] / densities[pixel];
            (beyond > allowed).then_some(pixel)
        });
        let far: Vec<usize> = far.collect();
        if far.len() * LINES_OF_A_MISS > self.steps.checks.len() {
            return Ok(None);
        }
        divided.extend(far);
        divided.sort_unstable();
        divided.dedup();
        let Some(divided) = self.divide(&divided, &lines, OF_PIXEL * allowed).await? else {
            return Ok(None);
        };
        for Divided { pixel, mean, error, .. } in divided {
            image.pixels_mut()[pixel] = mean;
            errors.pixels_mut()[pixel] = error;
        }
        // If no line is negative, a negative pixel has at least the error of its size.
        if lines.iter().all(|line| line.radiance >= 0.0) {
            let pixels = errors.pixels_mut().iter_mut().zip(image.pixels());
            pixels.for_each(|(error, pixel)| *error = error.max(-pixel));
        }
        tile.check_finite(&image, 0)?;
        if errors.largest() > self.tolerance * image.largest() {
            return Ok(None);
        }
        let [cube, errors] = [image, errors].map(|map| Cube::from_bands(vec![map]));
        let mut made = MethodOutput::new(cube, Some(errors), StopReason::Complete);
        made.steps_of_pixels = Some(self.steps.number);
        Ok(Some(made))
    }

    /// The means of some pixels from more lines, until one more division changes them by no more than what is `allowed`;
    /// `None` if that takes too long.
    async fn divide(
        &self,
        pixels: &[usize],
        lines: &[steps::LineValue],
        allowed: f64,
    ) -> Result<Option<Vec<Divided>>, MethodError> {
        let shape = self.tile.shape;
        if pixels.len() as f64 > MOST_DIVIDED * lines.len() as f64 {
            return Ok(None);
        }
        let of_middle = |&pixel: &usize| {
            let steps::LineValue { radiance: mean, error } = lines[pixel];
            Divided { pixel, mean, error, is_settled: false }
        };
        let mut divided: Vec<Divided> = pixels.iter().map(of_middle).collect();
        let mut seconds_left = self.most_seconds;
        for per_side in PER_SIDE {
            let open: Vec<usize> =
                (0..divided.len()).filter(|&of| !divided[of].is_settled).collect();
            let per_pixel = per_side * per_side;
            let count = open.len() * per_pixel;
            seconds_left -= self.steps.seconds * (count * FINER * self.steps.number) as f64;
            if seconds_left < 0.0 {
                return Ok(None);
            }
            let place = |line: usize| {
                let part = line % per_pixel;
                let within = [part % per_side, part / per_side];
                let within = within.map(|k| (k as f64 + 0.5) / per_side as f64);
                place_in_pixel(shape, divided[open[line / per_pixel]].pixel, within)
            };
            let found = self.steps.radiances(self.meter, self.tile, &place, count, FINER).await?;
            let Some(found) = found else { return Ok(None) };
            let density = |line| self.tile.projection.solid_angle_density(place(line));
            let mean_of = |(number, of_pixel): (usize, &[steps::LineValue])| {
                let first = number * per_pixel;
                let weights: Vec<f64> = (first..first + per_pixel).map(density).collect();
                let whole: f64 = weights.iter().sum();
                let weighted = |value: &dyn Fn(&steps::LineValue) -> f64| {
                    let values = of_pixel.iter().zip(&weights);
                    values.map(|(line, weight)| value(line) * weight).sum::<f64>() / whole
                };
                [weighted(&|line| line.radiance), weighted(&|line| line.error)]
            };
            let means: Vec<[f64; 2]> =
                found.chunks_exact(per_pixel).enumerate().map(mean_of).collect();
            for (&of, [mean, of_lines]) in open.iter().zip(means) {
                let change = (mean - divided[of].mean).abs();
                let pixel = divided[of].pixel;
                let is_settled = change <= allowed;
                divided[of] = Divided { pixel, mean, error: change + of_lines, is_settled };
            }
        }
        Ok(Some(divided))
    }
}

/// Canonical (x, y) of a place in a pixel, from 0 to 1.
fn place_in_pixel([height, width]: [usize; 2], pixel: usize, [x, y]: [f64; 2]) -> [f64; 2] {
    [((pixel % width) as f64 + x) / width as f64, ((pixel / width) as f64 + y) / height as f64]
}
