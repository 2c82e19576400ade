//! Rendering with an energy axis: from an emission, a projection and the bins to a spectral cube.

use crate::cube::Cube;
use crate::emission::Emission;
use crate::energy::EnergyAxis;
use crate::error::RenderError;
use crate::projection::Projection;
use crate::render::RenderOptions;
use crate::session::{Ended, Session};
use crate::tally::EvaluationCounts;
use crate::tree::Ending;
use core::time::Duration;

/// A spectral cube and its bill.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct CubeRendering {
    /// Radiance per unit of energy, the mean over each pixel and energy bin: the unit of g times the
    /// length unit of the scene.
    pub cube: Cube,
    /// The estimated |error| of each voxel, in the unit of the cube, if the method has one; see
    /// [`Rendering::error`](crate::Rendering::error).
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
    /// The smallest feature that would have been seen; see [`Rendering::smallest_feature`](crate::Rendering::smallest_feature).
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
/// [`Method::Paper`](crate::Method::Paper) builds one tree along x, y, z and the energy axis and projects it along z; its
/// absolute threshold is in the unit of g, with dE/du in the middle of the axis. The tolerance of
/// [`Method::Vol`](crate::Method::Vol) is relative to the largest |voxel|; `Los` takes as many energies in each bin as
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
    Ok(Session::new(projection, shape, Some(axis), options, emission.takes_whole_batches())?
        .run(emission, options.progress)?
        .into())
}

impl From<Ended> for CubeRendering {
    fn from(Ended { made, cost }: Ended) -> Self {
        Self {
            cube: made.cube,
            error: made.error,
            evaluations: cost.evaluations,
            evaluations_of_pixels: cost.evaluations_of_pixels,
            batches: cost.batches,
            ending: made.ending,
            energies: made.energies,
            base_level: made.base_level,
            smallest_feature: made.smallest_feature,
            emission_time: cost.emission_time,
            total_time: cost.total_time,
        }
    }
}
