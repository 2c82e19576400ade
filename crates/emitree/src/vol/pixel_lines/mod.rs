//! Lines of sight on a lattice of pixels, to the tolerance: where that takes less time than fewer evaluations.
//!
//! Rates that take some ten nanoseconds cost less than the choice of the next point. If time is to be minimized, and
//! evaluations turn out to be that cheap, square blocks of pixels have a line through their middle, in the fewest
//! uniform steps that scattered lines allow (`steps`). Differences between blocks give the means over pixels and
//! their errors (`lattice_image`); blocks become smaller until few pixels have larger errors, and these have lines of
//! their own (`divided`), as pixels that limbs cross (`limbs`). Jumps along lines are bisected (`jumps`). The scattered
//! lines are compared with the image. If the error of a pixel stays beyond the tolerance there is no such image.
//!
//! Where lines through all pixels are expected to take longer than a search for products, they follow it, unless it
//! has found an image.

mod divided;
mod jumps;
mod lattice_image;
mod limbs;
mod steps;

use crate::cube::Cube;
use crate::energy::EnergyAxis;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::meter::Meter;
use crate::output::MethodOutput;
use crate::radiance::map_of_rows;
use crate::tile::Tile;
use crate::tree::StopReason;
use crate::vol::options::{Minimize, VolOptions};
use crate::vol::tuning::TUNING;
use divided::Divided;
use jumps::Medium;
use lattice_image::{LatticeImage, largest_around};
use limbs::Limbs;
use steps::{CheckLine, Steps};

/// What products take where they serve the view, without the time of g: a tenth of a second, and 3 microseconds for
/// each pixel.
const OF_PRODUCTS: Seconds = Seconds { of_image: 0.1, of_pixel: 3e-6 };
/// What surfaces and image trees take, which follow where products do not serve the view.
const OF_OTHERS: Seconds = Seconds { of_image: 2.0, of_pixel: 5e-5 };
/// The share of the error allowed that the mean over a pixel may have: one with more has lines of its own.
const OF_PIXEL: f64 = 0.4;
/// The pixels along each side of a block that has one line, and the largest share of pixels that may have lines of
/// their own, which take as long as 27 others: with more, blocks of half the size and an eighth of the share have less
/// to integrate.
const BLOCKS: [(usize, f64); 4] = [(8, 0.002), (4, 0.008), (2, 0.032), (1, 0.5)];
/// Errors fall at least with this power of the size of a block where the image is smooth.
const ERROR_EXPONENT: i32 = 3;
/// The fewest blocks along each side.
const FEWEST: usize = 16;
/// One in so many of the evaluations left is kept for other ways to an image: by default about as many as fit in memory.
const RESERVED: u64 = 4;
/// The share of the time left that lines may take, up to three times: for two lattices and for divided pixels.
const SHARE_OF_TIME: f64 = 0.1;
/// One of so many scattered lines may be far from the image: its pixel has more lines then.
const LINES_OF_A_MISS: usize = 64;

/// The time of an image.
struct Seconds {
    of_image: f64,
    of_pixel: f64,
}

/// Lines through all pixels that have not been integrated yet.
pub(super) struct PixelLines<'a> {
    medium: Medium<'a>,
    tolerance: f64,
    steps: Steps,
    limbs: Limbs<'a>,
    /// Whether lines through all pixels are expected to take less time than products.
    pub(super) precede_products: bool,
    /// The time that lines may take \[s\].
    most_seconds: f64,
}

/// The image of blocks.
struct OfBlocks {
    image: Image,
    errors: Image,
    /// For each pixel the error of its mean without that of lines, over what is allowed; infinite where a scattered
    /// line is far from the image.
    shares: Image,
    /// The error allowed.
    allowed: f64,
}

impl OfBlocks {
    /// The share of pixels whose errors are too large if all are multiplied by a factor.
    fn share_above(&self, factor: f64) -> f64 {
        let above = self.shares.pixels().iter().filter(|share| factor * *share > 1.0).count();
        above as f64 / self.shares.pixels().len() as f64
    }

    /// Whether no pixel has an error.
    fn is_unknown(&self) -> bool {
        self.shares.pixels().iter().all(|share| share.is_infinite())
    }

    /// The pixels whose errors are too large.
    fn divided(&self) -> Vec<usize> {
        let shares = self.shares.pixels().iter().enumerate();
        shares.filter(|(_, share)| **share > 1.0).map(|(pixel, _)| pixel).collect()
    }
}

impl<'a> PixelLines<'a> {
    /// Lines that are expected to take less time than surfaces and image trees; `None` if evaluations are to be few, or
    /// are not cheap enough, and for cubes, views and options that such lines do not serve.
    pub(super) async fn expected(
        meter: &'a Meter,
        tiles: &'a [Tile<'a>],
        axis: Option<&EnergyAxis>,
        vol: &VolOptions,
    ) -> Result<Option<Self>, MethodError> {
        let [tile] = tiles else { return Ok(None) };
        let geometry = tile.projection.view_geometry();
        let may_be = vol.minimize == Minimize::Time
            && axis.is_none()
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
            && tile.shape.iter().all(|pixels| *pixels >= FEWEST)
            && geometry.is_none_or(|geometry| !geometry.has_rim());
        if !may_be {
            return Ok(None);
        }
        let Some(limbs) = Limbs::of(tiles) else { return Ok(None) };
        let pixels = (tile.shape[0] * tile.shape[1]) as f64;
        let most = SHARE_OF_TIME * meter.seconds_left();
        let [of_products, of_others] = [OF_PRODUCTS, OF_OTHERS]
            .map(|Seconds { of_image, of_pixel }| (of_image + of_pixel * pixels).min(most));
        // As loose as those of other images are.
        let tolerance = vol.tolerance.min(TUNING.engine.loosest_tolerance);
        let reserve = meter.unkept_evaluations_left() / RESERVED;
        let medium = Medium { meter, tile, reserve };
        let steps = Steps::find(medium, tolerance, [of_products, of_others]).await?;
        Ok(steps.map(|steps| {
            // Where limbs cross pixels, lines of all pixels hardly ever suffice.
            let precede_products = !limbs.cross_pixels()
                && steps.seconds * pixels * steps.number as f64 <= of_products;
            let is_usual = precede_products && !steps.has_jumps;
            let most_seconds = if is_usual { of_products } else { of_others };
            Self { medium, tolerance, steps, limbs, precede_products, most_seconds }
        }))
    }

    /// The time that so many lines are expected to take, in `finer` times as many steps as usual.
    fn seconds_of(&self, lines: usize, finer: usize) -> f64 {
        self.steps.seconds * (lines * finer * self.steps.number) as f64
    }

    /// The image; `None` if some of its errors would be beyond the tolerance, or if it would take too long.
    pub(super) async fn render(&self) -> Result<Option<MethodOutput>, MethodError> {
        let shape = self.medium.tile.shape;
        let fits = |block: usize| {
            shape.iter().all(|pixels| pixels.is_multiple_of(block) && pixels / block >= FEWEST)
        };
        // The largest block that is expected to suffice.
        let mut expected = usize::MAX;
        for (block, most_divided) in BLOCKS {
            if block > expected || !fits(block) {
                continue;
            }
            let Some(found) = self.of_blocks(block).await? else { return Ok(None) };
            if found.share_above(1.0) <= most_divided {
                return self.finished(found).await;
            }
            let suffices = |&(finer, most_divided): &(usize, f64)| {
                let ratio = finer as f64 / block as f64;
                finer < block && found.share_above(ratio.powi(ERROR_EXPONENT)) <= most_divided
            };
            // Where scattered lines are far from the image, nothing is known of finer blocks.
            expected = if found.is_unknown() {
                block / 2
            } else {
                BLOCKS.iter().find(|of| suffices(of)).map_or(1, |(finer, _)| *finer)
            };
        }
        Ok(None)
    }

    /// The image of blocks of so many pixels along each side; `None` if it would take too long.
    async fn of_blocks(&self, block: usize) -> Result<Option<OfBlocks>, MethodError> {
        let tile = self.medium.tile;
        let blocks @ [rows, columns] = tile.shape.map(|pixels| pixels / block);
        let count = rows * columns;
        if self.seconds_of(count, 1) > self.most_seconds {
            return Ok(None);
        }
        let place = |line: usize| place_in_cell(blocks, line, [0.5, 0.5]);
        let lines = self.steps.radiances(self.medium, &place, count, 1).await?;
        let Some(lines) = lines else { return Ok(None) };
        let density = |line| tile.projection.solid_angle_density(place(line));
        let densities: Vec<f64> = (0..count).map(density).collect();
        // Some projections have no image in parts of the square.
        if densities.iter().any(|density| density.is_nan() || *density <= 0.0) {
            return Ok(None);
        }
        let values: Vec<f64> =
            lines.iter().zip(&densities).map(|(line, density)| line.radiance * density).collect();
        let of_values = LatticeImage { values: &values, shape: blocks, block };
        let of_densities = LatticeImage { values: &densities, shape: blocks, block };
        let (mut image, whole) = (of_values.means(), of_densities.means());
        image.pixels_mut().iter_mut().zip(whole.pixels()).for_each(|(mean, of)| *mean /= of);
        tile.check_finite(&image, 0)?;
        let largest = image.largest().max(self.steps.largest);
        let allowed = self.tolerance * largest;
        let [errors, variation] = of_values.errors();
        let line_errors = of_values.map(|row, column| lines[row * columns + column].error);
        let of_lines = largest_around(&line_errors);
        // Scattered lines took no part in the image. A line differs from the mean over its pixel.
        let pixels_of_block = (block * block) as f64;
        let is_beyond = |check: &&CheckLine| {
            let (value, line) = of_values.at(check.place);
            let density = tile.projection.solid_angle_density(check.place);
            let of_pixel = variation.pixels()[line] / (pixels_of_block * densities[line]);
            (value / density - check.radiance).abs() > allowed + of_pixel
        };
        // The pixels of blocks that a limb crosses have lines of their own.
        let mut is_far = self.limbs.blocks(tile.shape, block);
        let others = |check: &&CheckLine| !is_far[of_values.at(check.place).1];
        let checks: Vec<&CheckLine> = self.steps.checks.iter().filter(others).collect();
        let far: Vec<&CheckLine> = checks.iter().copied().filter(is_beyond).collect();
        if far.len() * LINES_OF_A_MISS > checks.len() {
            is_far.fill(true);
        }
        far.iter().for_each(|check| is_far[of_values.at(check.place).1] = true);
        // The density of a pixel may be far below that in the middle of its block, as beside the poles of a sky.
        let on_pixels = |of_pixel: &(dyn Fn(usize, f64) -> f64 + Sync)| {
            map_of_rows(tile.shape, |row, pixels| {
                for (column, (pixel, density)) in pixels.iter_mut().zip(whole.row(row)).enumerate()
                {
                    *pixel = of_pixel(row / block * columns + column / block, *density);
                }
            })
        };
        let of_mean = |of: usize, density: f64| errors.pixels()[of] / density.abs();
        let share = |of: usize, density: f64| {
            if is_far[of] { f64::INFINITY } else { of_mean(of, density) / (OF_PIXEL * allowed) }
        };
        let error = |of: usize, density: f64| of_lines.pixels()[of] + of_mean(of, density);
        let (errors, mut shares) = (on_pixels(&error), on_pixels(&share));
        if self.steps.has_jumps {
            // An edge of the image may lie between a line and the border.
            let [height, width] = tile.shape;
            let is_at_border = |pixel: usize| {
                let (row, column) = (pixel / width, pixel % width);
                row == 0 || row + 1 == height || column == 0 || column + 1 == width
            };
            let pixels = shares.pixels_mut().iter_mut().enumerate();
            pixels
                .filter(|(pixel, _)| is_at_border(*pixel))
                .for_each(|(_, of)| *of = f64::INFINITY);
        }
        Ok(Some(OfBlocks { image, errors, shares, allowed }))
    }

    /// The image, whose divided pixels have lines of their own.
    async fn finished(&self, found: OfBlocks) -> Result<Option<MethodOutput>, MethodError> {
        let divided = found.divided();
        let OfBlocks { mut image, mut errors, allowed, .. } = found;
        let is_negative = image.pixels().iter().any(|pixel| *pixel < -allowed);
        let Some(divided) = self.divide(&divided, OF_PIXEL * allowed).await? else {
            return Ok(None);
        };
        for Divided { pixel, mean, error, .. } in divided {
            image.pixels_mut()[pixel] = mean;
            errors.pixels_mut()[pixel] = error;
        }
        // If g is nowhere negative, a negative pixel has at least the error of its size.
        if !is_negative {
            let pixels = errors.pixels_mut().iter_mut().zip(image.pixels());
            pixels.for_each(|(error, pixel)| *error = error.max(-pixel));
        }
        self.medium.tile.check_finite(&image, 0)?;
        if errors.largest() > self.tolerance * image.largest() {
            return Ok(None);
        }
        let [cube, errors] = [image, errors].map(|map| Cube::from_bands(vec![map]));
        let mut made = MethodOutput::new(cube, Some(errors), StopReason::Complete);
        made.line_steps = Some(self.steps.number);
        Ok(Some(made))
    }
}

/// Canonical (x, y) of a place in a cell of an image of so many rows and columns, from 0 to 1.
fn place_in_cell([rows, columns]: [usize; 2], cell: usize, [x, y]: [f64; 2]) -> [f64; 2] {
    [((cell % columns) as f64 + x) / columns as f64, ((cell / columns) as f64 + y) / rows as f64]
}
