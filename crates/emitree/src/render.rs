//! Rendering in one call: from an emission and a projection to an image or a cube.

use crate::absorption;
use crate::cube::Cube;
use crate::emission::Emission;
use crate::energy::EnergyAxis;
use crate::erased::{AnyEmission, AnyError, Erased, typed};
use crate::error::RenderError;
use crate::image::Image;
use crate::options::RenderOptions;
use crate::projection::Projection;
use crate::rendering::Rendering;
use crate::session::{Kept, Session};
use crate::values::Values;

/// The image of an emission from a camera, of `shape` = \[height, width\] pixels.
///
/// ```
/// use emitree::tree::BuildOptions;
/// use emitree::{Canonical, FromFn, RenderOptions, render};
///
/// let peak = FromFn(|[x, y, z]: [f64; 3], _| (-30.0 * (x * x + y * y + z * z)).exp());
/// let options = RenderOptions::new(BuildOptions::default());
/// let rendering = render(&peak, &Canonical, [48, 64], &options)?;
/// assert_eq!((rendering.values.height(), rendering.values.width()), (48, 64));
/// println!("{} evaluations", rendering.stats.evaluations);
/// # Ok::<(), emitree::RenderError<std::convert::Infallible>>(())
/// ```
///
/// # Errors
///
/// [`RenderError`]: options out of range, an image or grid beyond the memory allowed, an emission
/// that failed or is not finite somewhere, a progress callback that broke off.
pub fn render<E: Emission>(
    emission: &E,
    projection: &dyn Projection,
    shape: [usize; 2],
    options: &RenderOptions<'_>,
) -> Result<Rendering, RenderError<E::Error>> {
    run::<Image>(&Erased(emission), projection, shape, None, options).map_err(typed)
}

/// The spectral cube of an emission from a camera, of `shape` = \[height, width\] pixels and the bins
/// of `axis`: each voxel is the mean of the radiance per unit of energy over its pixel and bin.
///
/// g is the rate per unit of energy; [`Samples`](crate::Samples) contains the energies.
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
/// let options = RenderOptions::new(VolOptions::default());
/// let rendering = render_cube(&glow, &Canonical, [16, 16], &axis, &options)?;
/// assert_eq!(rendering.values.shape(), [8, 16, 16]);
/// let all_energies = rendering.values.sum_over_energy(&axis);
/// println!("{} from {} evaluations", all_energies[(0, 0)], rendering.stats.evaluations);
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
) -> Result<Rendering<Cube>, RenderError<E::Error>> {
    run::<Cube>(&Erased(emission), projection, shape, Some(axis), options).map_err(typed)
}

/// Runs a session to its end, with all limits and callbacks of the options.
fn run<V: Values>(
    emission: &AnyEmission<'_>,
    projection: &dyn Projection,
    shape: [usize; 2],
    axis: Option<&EnergyAxis>,
    options: &RenderOptions<'_>,
) -> Result<Rendering<V>, RenderError<AnyError>> {
    let kept = Kept { rates: None, images: options.frame.is_some(), repeats: false, rows: None };
    let of_method = emission.absorbs().then(|| absorption::of_method(options));
    let options = of_method.as_ref().unwrap_or(options);
    let whole_batches = emission.takes_whole_batches();
    let mut session: Session<'_, V> =
        Session::start(projection, shape, axis.cloned(), options, kept, whole_batches)?;
    session.show_new_images(options.frame)?;
    while !session.is_done() {
        session.evaluate(emission, options.progress)?;
        session.show_new_images(options.frame)?;
    }
    session.into_rendering()
}
