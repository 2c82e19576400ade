//! Line-of-sight integration: the baseline, and the usual method of other codes.
//!
//! Each pixel is the mean over n × n lines of sight through the centres of its n × n parts, weighted
//! with their solid angles. The steps along a line are uniform (`fixed`) or follow an error estimate
//! (`adaptive`). Nothing is shared between lines.

pub(crate) mod adaptive;
pub(crate) mod fixed;
mod mesh;
mod start;

use crate::cube::Cube;
use crate::energy::EnergyAxis;
use crate::error::OptionError;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::los::adaptive::FirstPanels;
use crate::los::mesh::FrozenLines;
use crate::los::start::LinesStart;
use crate::mesh::start::Structure;
use crate::meter::Meter;
use crate::output::MethodOutput;
use crate::projection::Projection;
use crate::radiance::map_of_rows;
use crate::tile::Tile;
use crate::tree::StopReason;
use std::sync::Arc;

/// How each line of sight is integrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Steps {
    /// This many uniform steps, with g at the middle of each.
    Fixed(usize),
    /// Bisected panels of the 15-point Gauss–Kronrod rule, until the estimated error **along each
    /// line** is below this fraction of the largest line's radiance.
    Adaptive(f64),
}

/// Options of method [`Los`](crate::Method::Los).
///
/// ```
/// use emitree::los::{LosOptions, Steps};
///
/// assert_eq!(LosOptions::default(), LosOptions::new(1, Steps::Fixed(64)));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LosOptions {
    /// n of n × n lines of sight for each pixel.
    pub lines: usize,
    /// How each is integrated.
    pub steps: Steps,
}

impl LosOptions {
    /// `lines` × `lines` lines of sight for each pixel, 1 or more, integrated in `steps`.
    pub fn new(lines: usize, steps: Steps) -> Self {
        Self { lines, steps }
    }
}

impl Default for LosOptions {
    /// One line for each pixel, 64 uniform steps.
    fn default() -> Self {
        Self { lines: 1, steps: Steps::Fixed(64) }
    }
}

/// The image, or the cube in the bins of `axis`, from as many energies in each bin as there are lines along
/// each side of a pixel.
pub(crate) async fn render(
    meter: &Meter,
    tiles: &[Tile<'_>],
    axis: Option<&EnergyAxis>,
    options: &LosOptions,
) -> Result<MethodOutput, MethodError> {
    check(options)?;
    let start = LinesStart::of(meter, tiles, axis, options)?;
    let are_fixed = meter.start().is_some_and(|start| start.is_fixed);
    let mut steps = meter.freezes().then(|| LinesStart::new(tiles, axis, options));
    // The energies of each bin and their weights.
    let bins: Vec<Vec<(Option<f64>, f64)>> = match axis {
        None => vec![vec![(None, 1.0)]],
        Some(axis) => {
            (0..axis.bins()).map(|bin| energies_of_bin(axis, bin, options.lines)).collect()
        }
    };
    let mut of_tiles = Vec::with_capacity(tiles.len());
    for (number, tile) in tiles.iter().enumerate() {
        let mut numbers = 0..;
        let [mut bands, mut errors] = [Vec::new(), Vec::new()];
        let mut ending = StopReason::Complete;
        let mut frozen = meter.freezes().then(|| FrozenLines::new(tile, options.lines));
        for energies in &bins {
            let [height, width] = tile.shape;
            let mut mean = [Image::zeros(height, width), Image::zeros(height, width)];
            for &(energy, weight) in energies {
                let given = start.zip(numbers.next());
                let given = given.and_then(|(start, energy)| start.panels(number, energy));
                let first = FirstPanels { given, are_fixed };
                let found = at_energy(meter, tile, options, energy, first).await?;
                tile.check_finite(&found.image, 0)?;
                if !found.converged {
                    ending = if are_fixed { StopReason::FixedMesh } else { StopReason::Budget };
                }
                frozen = frozen.filter(|_| meter.freezes());
                if let Some(frozen) = &mut frozen {
                    frozen.add(tile, &found.steps, energy, weight);
                }
                steps = steps.filter(|_| meter.freezes());
                if let Some(steps) = &mut steps {
                    steps.add(number, found.steps);
                }
                for (mean, map) in mean.iter_mut().zip([Some(found.image), found.error]) {
                    map.iter().for_each(|map| mean.add_scaled(map, weight));
                }
            }
            frozen.iter_mut().for_each(FrozenLines::end_bin);
            let [band, error] = mean;
            bands.push(band);
            errors.push(error);
        }
        let has_error = matches!(options.steps, Steps::Adaptive(_));
        let error = has_error.then(|| Cube::from_bands(errors));
        let mut made = MethodOutput::new(Cube::from_bands(bands), error, ending);
        made.energies = bins.iter().flatten().filter_map(|(energy, _)| *energy).collect();
        made.frozen = frozen.map(|frozen| Arc::new(frozen.finish()));
        of_tiles.push(made);
    }
    let mut made = MethodOutput::stacked(of_tiles);
    if let Some(frozen) = made.frozen.as_mut().and_then(Arc::get_mut) {
        frozen.structure = steps.map(|steps| Structure::new(steps, false));
    }
    Ok(made)
}

/// An image at one energy.
struct AtEnergy {
    image: Image,
    /// The estimated error along the lines, averaged over each pixel, if there is an estimate.
    error: Option<Image>,
    /// Whether every line met the tolerance.
    converged: bool,
    steps: StepsTaken,
}

/// The steps along all lines.
#[derive(Clone, Debug)]
enum StepsTaken {
    /// This many uniform steps.
    Fixed(usize),
    /// Panels: line, from and to; none unless a frozen quadrature is made.
    Adaptive(Vec<(usize, [f64; 2])>),
}

async fn at_energy(
    meter: &Meter,
    tile: &Tile<'_>,
    &LosOptions { lines, steps }: &LosOptions,
    energy: Option<f64>,
    first: FirstPanels<'_>,
) -> Result<AtEnergy, MethodError> {
    match steps {
        Steps::Fixed(steps) => {
            let image = fixed::render(meter, tile, lines, steps, energy).await?;
            let steps = StepsTaken::Fixed(steps);
            Ok(AtEnergy { image, error: None, converged: true, steps })
        }
        Steps::Adaptive(tolerance) => {
            adaptive::render(meter, tile, lines, tolerance, energy, first).await
        }
    }
}

/// Refuses options out of range.
fn check(&LosOptions { lines, steps }: &LosOptions) -> Result<(), MethodError> {
    if lines == 0 {
        return Err(OptionError::Lines(lines).into());
    }
    match steps {
        Steps::Fixed(0) => Err(OptionError::Steps(0).into()),
        Steps::Adaptive(tolerance) if !(tolerance > 0.0 && tolerance.is_finite()) => {
            Err(OptionError::StepTolerance(tolerance).into())
        }
        Steps::Fixed(_) | Steps::Adaptive(_) => Ok(()),
    }
}

/// The energies in the middle of `parts` equal parts of a bin of the canonical axis, each with its
/// share in the mean over the bin.
fn energies_of_bin(axis: &EnergyAxis, bin: usize, parts: usize) -> Vec<(Option<f64>, f64)> {
    let middle = |part: usize| {
        let u = (bin as f64 + (part as f64 + 0.5) / parts as f64) / axis.bins() as f64;
        (axis.energy(u), axis.energy_per_canonical(u))
    };
    let middles: Vec<(f64, f64)> = (0..parts).map(middle).collect();
    let of_all: f64 = middles.iter().map(|(_, width)| width).sum();
    middles.into_iter().map(|(energy, width)| (Some(energy), width / of_all)).collect()
}

/// All lines of sight of an image, pixel after pixel.
#[derive(Clone, Copy, Debug)]
struct Lines {
    height: usize,
    width: usize,
    /// n of n × n lines for each pixel.
    per_side: usize,
}

impl Lines {
    fn per_pixel(&self) -> usize {
        self.per_side * self.per_side
    }

    fn count(&self) -> usize {
        self.height * self.width * self.per_pixel()
    }

    /// Canonical (x, y) of a line.
    fn position(&self, line: usize) -> [f64; 2] {
        let (pixel, part) = (line / self.per_pixel(), line % self.per_pixel());
        let at = |pixel: usize, part: usize, pixels: usize| {
            (pixel as f64 + (part as f64 + 0.5) / self.per_side as f64) / pixels as f64
        };
        [
            at(pixel % self.width, part % self.per_side, self.width),
            at(pixel / self.width, part / self.per_side, self.height),
        ]
    }

    /// The image of one value for each line: means over each pixel's lines, weighted with the solid
    /// angle that each stands for.
    fn image(&self, projection: &dyn Projection, values: &[f64]) -> Image {
        self.weighted(values, |line| projection.solid_angle_density(self.position(line)))
    }

    /// The same with given weights of the lines.
    fn weighted(&self, values: &[f64], weight: impl Fn(usize) -> f64 + Sync) -> Image {
        let per_row = self.width * self.per_pixel();
        map_of_rows([self.height, self.width], |row, pixels| {
            let values = &values[row * per_row..][..per_row];
            let of_pixels = values.chunks_exact(self.per_pixel()).enumerate();
            for (pixel, (column, values)) in pixels.iter_mut().zip(of_pixels) {
                let (mut sum, mut weights) = (0.0, 0.0);
                for (part, value) in values.iter().enumerate() {
                    let line = row * per_row + column * self.per_pixel() + part;
                    let weight = weight(line);
                    sum += weight * value;
                    weights += weight;
                }
                *pixel = sum / weights;
            }
        })
    }
}

#[cfg(test)]
mod tests;
