//! Rendering with an energy axis: from an emission, a projection and the bins to a spectral cube.

use crate::cube::Cube;
use crate::emission::Emission;
use crate::energy::EnergyAxis;
use crate::erased::{Erased, Failure, with_erased};
use crate::error::RenderError;
use crate::image::Image;
use crate::los::{LosOptions, Steps};
use crate::meter::Meter;
use crate::projection::Projection;
use crate::render::{
    Method, RenderOptions, Rendering, Tile, check_options, limits, render_los, stacked,
};
use crate::spectral_tree;
use crate::tally::EvaluationCounts;
use crate::tree::Ending;
use crate::vol::{self, Found};
use core::time::Duration;
use std::time::Instant;

/// A spectral cube and its bill.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct CubeRendering {
    /// Radiance per unit of energy, the mean over each pixel and energy bin: the unit of g times the
    /// length unit of the scene.
    pub cube: Cube,
    /// The estimated |error| of each voxel, in the unit of the cube, if the method has one; see
    /// [`Rendering::error`].
    pub error: Option<Cube>,
    /// How often g was evaluated.
    pub evaluations: u64,
    /// How often g was evaluated on the lines of sight of each pixel, at all energies.
    pub evaluations_of_pixels: EvaluationCounts,
    /// The number of batches in which that was done.
    pub batches: u64,
    /// What ended the rendering.
    pub ending: Ending,
    /// The energies at which g was integrated along lines of sight, ascending, in the unit of the
    /// axis; none if the method has a tree along the energy axis too.
    pub energies: Vec<f64>,
    /// The base level that was used, if the method has one.
    pub base_level: Option<u8>,
    /// The smallest feature that would have been seen; see [`Rendering::smallest_feature`].
    pub smallest_feature: Option<f64>,
    /// Time spent in g, for one of the threads.
    pub emission_time: Duration,
    /// Time spent altogether.
    pub total_time: Duration,
}

impl CubeRendering {
    /// Whether the method did all it was asked for; `false` if a limit ended it before.
    pub fn converged(&self) -> bool {
        self.ending == Ending::Complete
    }

    /// The largest estimated error of a voxel over the largest |voxel|.
    pub fn estimated_error(&self) -> Option<f64> {
        let error = self.error.as_ref()?.largest();
        Some(if error > 0.0 { error / self.cube.largest() } else { 0.0 })
    }
}

/// The spectral cube of `shape` = \[height, width\] pixels and the bins of `axis` that a camera sees
/// of an emission: each voxel is the mean of the radiance per unit of energy over its pixel and bin.
///
/// g is the rate per unit of energy; it finds the energies in [`Samples`](crate::Samples).
/// [`Method::Paper`] builds one tree along x, y, z and the energy axis and projects it along z; its
/// absolute threshold is in the unit of g, with dE/du in the middle of the axis. The tolerance of
/// [`Method::Vol`] is relative to the largest |voxel|; `Los` takes as many energies in each bin as
/// lines along each side of a pixel.
///
/// ```
/// use emitree::{
///     Canonical, EnergyAxis, EnergyScale, FromSpectralFn, Method, RenderOptions, VolOptions,
///     render_cube,
/// };
///
/// let glow = FromSpectralFn(|[x, y, z]: [f64; 3], _, energy: f64| {
///     (-4.0 * (x * x + y * y + z * z)).exp() * (-energy).exp()
/// });
/// let axis = EnergyAxis::new(0.1, 2.0, 8, EnergyScale::Log)?;
/// let options = RenderOptions::new(Method::Vol(VolOptions::default()));
/// let rendering = render_cube(&glow, &Canonical, [16, 16], &axis, &options)?;
/// assert_eq!(rendering.cube.shape(), [8, 16, 16]);
/// let all_energies = rendering.cube.sum_over_energy(&axis);
/// println!("{} from {} evaluations", all_energies[(0, 0)], rendering.evaluations);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// [`RenderError`], as [`render`](crate::render()).
pub fn render_cube<E: Emission>(
    emission: &E,
    projection: &dyn Projection,
    shape: [usize; 2],
    axis: &EnergyAxis,
    options: &RenderOptions<'_>,
) -> Result<CubeRendering, RenderError<E::Error>> {
    with_erased(emission, |emission| render_erased(emission, projection, shape, axis, options))
}

fn render_erased(
    emission: &Erased<'_>,
    projection: &dyn Projection,
    shape: [usize; 2],
    axis: &EnergyAxis,
    options: &RenderOptions<'_>,
) -> Result<CubeRendering, RenderError<Failure>> {
    let start = Instant::now();
    check_options(shape, Some(axis.bins()), options)?;
    let tiles = Tile::of(projection, shape)?;
    let meter = Meter::new(emission, shape, limits(options), options.progress);
    let mut rendering = match options.method {
        Method::Los(los) => render_cube_los(&meter, &tiles, axis, los)?,
        Method::Vol(vol_options) => {
            vol::render(&meter, &tiles, Some(axis), &vol_options, options)?.into()
        }
        Method::Paper(build_options) => {
            spectral_tree::render(&meter, &tiles, axis, &build_options)?
        }
    };
    rendering.ending = meter.reason_for(rendering.ending);
    rendering.evaluations = meter.evaluations();
    rendering.batches = meter.batches();
    rendering.emission_time = meter.emission_time();
    rendering.evaluations_of_pixels = meter.into_evaluations_of_pixels();
    rendering.total_time = start.elapsed();
    Ok(rendering)
}

impl CubeRendering {
    /// A rendering whose bill is still to be written.
    pub(crate) fn new(cube: Cube, error: Option<Cube>, ending: Ending) -> Self {
        Self {
            cube,
            error,
            ending,
            evaluations: 0,
            evaluations_of_pixels: EvaluationCounts::none(),
            batches: 0,
            energies: Vec::new(),
            base_level: None,
            smallest_feature: None,
            emission_time: Duration::ZERO,
            total_time: Duration::ZERO,
        }
    }
}

impl From<Found> for CubeRendering {
    fn from(found: Found) -> Self {
        let mut rendering = Self::new(found.cube, Some(found.error), found.ending);
        rendering.base_level = Some(found.base_level);
        rendering.smallest_feature = found.smallest_feature;
        rendering.energies = found.energies;
        rendering
    }
}

/// Line-of-sight integration at some energies of each bin, one image after the other.
fn render_cube_los<E: Emission>(
    meter: &Meter<'_, E>,
    tiles: &[Tile<'_>],
    axis: &EnergyAxis,
    LosOptions { lines, steps }: LosOptions,
) -> Result<CubeRendering, RenderError<E::Error>> {
    let [mut bands, mut errors] = [Vec::new(), Vec::new()];
    let (mut energies, mut ending) = (Vec::new(), Ending::Complete);
    for bin in 0..axis.bins() {
        let mut of_bin: Option<[Image; 2]> = None;
        for (energy, weight) in energies_of_bin(axis, bin, lines.max(1)) {
            let image = stacked(tiles, |tile| render_los(meter, tile, lines, steps, Some(energy)))?;
            let Rendering { image, error, ending: of_image, .. } = image;
            if of_image != Ending::Complete {
                ending = of_image;
            }
            energies.push(energy);
            let error = error.unwrap_or_else(|| Image::zeros(0, 0));
            of_bin = Some(match of_bin {
                None => [image.scaled(weight), error.scaled(weight)],
                Some([mut mean, mut mean_error]) => {
                    mean.add_scaled(&image, weight);
                    mean_error.add_scaled(&error, weight);
                    [mean, mean_error]
                }
            });
        }
        let Some([band, error]) = of_bin else { continue };
        bands.push(band);
        errors.push(error);
    }
    let error = matches!(steps, Steps::Adaptive(_)).then(|| Cube::from_bands(errors));
    let mut rendering = CubeRendering::new(Cube::from_bands(bands), error, ending);
    rendering.energies = energies;
    Ok(rendering)
}

/// The energies in the middle of `parts` equal parts of a bin of the canonical axis, each with its
/// share in the mean over the bin.
fn energies_of_bin(axis: &EnergyAxis, bin: usize, parts: usize) -> Vec<(f64, f64)> {
    let middle = |part: usize| {
        let u = (bin as f64 + (part as f64 + 0.5) / parts as f64) / axis.bins() as f64;
        (axis.energy(u), axis.energy_per_canonical(u))
    };
    let middles: Vec<(f64, f64)> = (0..parts).map(middle).collect();
    let of_all: f64 = middles.iter().map(|(_, width)| width).sum();
    middles.into_iter().map(|(energy, width)| (energy, width / of_all)).collect()
}
