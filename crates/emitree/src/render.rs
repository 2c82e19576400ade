//! Rendering: from an emission and a projection to an image, its error and its cost.

use crate::calls::Progress;
use crate::cube::Cube;
use crate::emission::Emission;
use crate::error::RenderError;
use crate::image::Image;
use crate::los::{LosOptions, Steps};
use crate::memory::check_size;
use crate::projection::Projection;
use crate::session::{Ended, Session};
use crate::tally::EvaluationCounts;
use crate::tree::{BuildOptions, Ending, SparseTree};
use crate::vol::VolOptions;
use core::ops::ControlFlow;
use core::time::Duration;

/// The way from g to the image.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Method {
    /// The image to the error that was asked for: a tree in the image plane whose nodes are lines of
    /// sight.
    Vol(VolOptions),
    /// The paper's: a sparse tree of cell averages, built by conservative subdivision, projected.
    ///
    /// An absolute threshold is in the unit of g. The tree's function is g times a weight of the
    /// view, ds/dz · dΩ/(dx dy); its value for a line through the middle stands for all of them.
    Paper(BuildOptions),
    /// Integration along lines of sight, pixel by pixel.
    Los(LosOptions),
}

impl Method {
    /// The name, as scenes write it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Vol(_) => "vol",
            Self::Paper(_) => "paper",
            Self::Los(_) => "los",
        }
    }
}

/// Where the emission is known to have a structure that a coarse grid would miss: method
/// [`Vol`](Method::Vol) looks there down to the size of the structure.
///
/// ```
/// use emitree::Seed;
///
/// let knot = Seed { position: [0.2, 0.4, 0.9], radius: 0.01 };
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seed {
    /// The middle of the structure, in world coordinates and the scene's length unit.
    pub position: [f64; 3],
    /// Its radius, in the scene's length unit, above 0.
    pub radius: f64,
}

/// An image on the way: what a rendering has after one of its steps.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Frame<'a> {
    /// The image so far, in the unit of the final one.
    pub image: &'a Image,
    /// The estimated |error| of each pixel of it.
    pub error: &'a Image,
    /// Evaluations of g so far.
    pub evaluations: u64,
    /// Batches of evaluations so far.
    pub batches: u64,
}

/// Sees the image on the way, and may end the rendering.
pub type FrameCallback<'a> = dyn Fn(&Frame<'_>) -> ControlFlow<()> + Sync + 'a;

/// Options of a rendering.
#[derive(Clone, Copy)]
pub struct RenderOptions<'a> {
    /// The way from g to the image.
    pub method: Method,
    /// The largest number of evaluations of g.
    pub max_evaluations: u64,
    /// The longest time that the rendering may take \[s\], above 0; infinite for no limit. It ends with
    /// the best image so far and [`Ending::Time`]. A call of g that has begun is waited for.
    pub max_seconds: f64,
    /// What the image and the coarsest grid may take \[bytes\]; more is refused before anything is
    /// allocated.
    pub max_memory_bytes: u64,
    /// The largest number of evaluations in one batch: a larger one is made in parts.
    pub batch_size: u64,
    /// Structures to be looked at; only [`Method::Vol`] does.
    pub seeds: &'a [Seed],
    /// Energies of spectral lines, in the unit of the [energy axis](crate::EnergyAxis), at which
    /// spectra are looked at: a line much narrower than its bin may be missed else. Only
    /// [`Method::Vol`] does, and only for cubes.
    pub line_energies: &'a [f64],
    /// Called after each call of g, from any thread, with the evaluations so far; may break.
    pub progress: Option<&'a Progress<'a>>,
    /// Called after each step that has made a better image, coarse first; may break. Only
    /// [`Method::Vol`] has images on the way.
    pub frame: Option<&'a FrameCallback<'a>>,
}

/// A budget that ends a runaway refinement (a jump and a tiny threshold) while its tree still fits
/// in a few GiB.
pub const DEFAULT_MAX_EVALUATIONS: u64 = 50_000_000;

/// Memory that any workstation has.
const DEFAULT_MAX_MEMORY_BYTES: u64 = 8 << 30;

impl RenderOptions<'_> {
    /// The given method with the default limits: equal steps along lines are counted beforehand and
    /// have none, all else may make [`DEFAULT_MAX_EVALUATIONS`].
    pub fn new(method: Method) -> Self {
        let max_evaluations = match method {
            Method::Los(LosOptions { steps: Steps::Fixed(_), .. }) => u64::MAX,
            _ => DEFAULT_MAX_EVALUATIONS,
        };
        Self {
            method,
            max_evaluations,
            max_seconds: f64::INFINITY,
            max_memory_bytes: DEFAULT_MAX_MEMORY_BYTES,
            batch_size: u64::MAX,
            seeds: &[],
            line_energies: &[],
            progress: None,
            frame: None,
        }
    }
}

impl core::fmt::Debug for RenderOptions<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("RenderOptions")
            .field("method", &self.method)
            .field("max_evaluations", &self.max_evaluations)
            .field("max_seconds", &self.max_seconds)
            .field("max_memory_bytes", &self.max_memory_bytes)
            .field("batch_size", &self.batch_size)
            .field("seeds", &self.seeds)
            .field("line_energies", &self.line_energies)
            .finish_non_exhaustive()
    }
}

/// An image and its bill.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Rendering {
    /// Radiance, F(Ω)/Ω in each pixel: the unit of g times the length unit of the scene.
    pub image: Image,
    /// The estimated |error| of each pixel, in the unit of the image, if the method has one.
    ///
    /// `Vol`: what remains unseen, as the tolerance bounds it. `Paper`: what the last generation of
    /// cells changed. Adaptive `Los`: the error along the lines; that of too few lines for a pixel is
    /// not in it. Fixed steps have no estimate.
    pub error: Option<Image>,
    /// How often g was evaluated.
    pub evaluations: u64,
    /// How often g was evaluated on the lines of sight of each pixel.
    pub evaluations_of_pixels: EvaluationCounts,
    /// The number of batches in which that was done: one for each refinement step.
    pub batches: u64,
    /// What ended the rendering.
    pub ending: Ending,
    /// The tree that was built, if the method builds one, and one only.
    pub tree: Option<RenderedTree>,
    /// The base level that was used, if the method has one: [`Method::Vol`] takes a coarser one than
    /// asked for if the budget does not suffice, and has not converged then.
    pub base_level: Option<u8>,
    /// The standard deviation of the smallest Gaussian that would have been seen with a probability
    /// of 99 %, as a fraction of the edge of the view's cube, if its peak in the image is
    /// [`FEATURE_CONTRAST`](crate::FEATURE_CONTRAST) times the tolerance; only of [`Method::Vol`].
    pub smallest_feature: Option<f64>,
    /// Time spent in g, for one of the threads.
    pub emission_time: Duration,
    /// Time spent altogether.
    pub total_time: Duration,
}

impl Rendering {
    /// Whether the method did all it was asked for; `false` if a limit ended it before.
    pub fn converged(&self) -> bool {
        self.ending == Ending::Complete
    }

    /// The largest estimated error of a pixel over the largest |pixel|.
    pub fn estimated_error(&self) -> Option<f64> {
        let error = self.error.as_ref()?.largest();
        let image = self.image.largest();
        Some(if error > 0.0 { error / image } else { 0.0 })
    }
}

/// The image of `shape` = \[height, width\] pixels that a camera sees of an emission.
///
/// ```
/// use emitree::tree::BuildOptions;
/// use emitree::{Canonical, FromFn, Method, RenderOptions, render};
///
/// let peak = FromFn(|[x, y, z]: [f64; 3], _| (-30.0 * (x * x + y * y + z * z)).exp());
/// let options = RenderOptions::new(Method::Paper(BuildOptions::default()));
/// let rendering = render(&peak, &Canonical, [48, 64], &options)?;
/// assert_eq!((rendering.image.height(), rendering.image.width()), (48, 64));
/// println!("{} evaluations", rendering.evaluations);
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
    Ok(Session::new(projection, shape, None, options, emission.takes_whole_batches())?
        .run(emission, options.progress)?
        .into())
}

/// The tree behind an image.
#[derive(Clone, Debug)]
pub struct RenderedTree {
    /// The canonical integrand g · ds/dz · dΩ/(dx dy) as a tree.
    pub tree: SparseTree<3>,
    /// The threshold of the last step, in the unit of g as in [`Method::Paper`].
    pub threshold: f64,
}

impl From<Ended> for Rendering {
    fn from(Ended { made, cost }: Ended) -> Self {
        Self {
            image: made.cube.into_first(),
            error: made.error.map(Cube::into_first),
            evaluations: cost.evaluations,
            evaluations_of_pixels: cost.evaluations_of_pixels,
            batches: cost.batches,
            ending: made.ending,
            tree: made.tree,
            base_level: made.base_level,
            smallest_feature: made.smallest_feature,
            emission_time: cost.emission_time,
            total_time: cost.total_time,
        }
    }
}

/// Refuses options out of range, and an image, or a cube of `bins` bands, beyond the memory allowed.
pub(crate) fn check_options<E>(
    shape: [usize; 2],
    bins: Option<usize>,
    options: &RenderOptions<'_>,
) -> Result<(), RenderError<E>> {
    if options.batch_size == 0 {
        let (name, expected) = ("batch_size", "1 or more evaluations in a batch");
        return Err(RenderError::Option { name, value: "0".into(), expected });
    }
    if options.max_seconds.is_nan() || options.max_seconds <= 0.0 {
        let (name, value) = ("max_seconds", options.max_seconds.to_string());
        return Err(RenderError::Option { name, value, expected: "a time in seconds above 0" });
    }
    check_seeds(options.seeds)?;
    check_size(shape, bins, options)
}

/// Finds a seed that is no place or has no size.
fn check_seeds<E>(seeds: &[Seed]) -> Result<(), RenderError<E>> {
    for seed in seeds {
        let (name, expected) = if !seed.position.iter().all(|x| x.is_finite()) {
            ("seed.position", "three finite coordinates")
        } else if !(seed.radius > 0.0 && seed.radius.is_finite()) {
            ("seed.radius", "a finite length above 0")
        } else {
            continue;
        };
        return Err(RenderError::Option { name, value: format!("{seed:?}"), expected });
    }
    Ok(())
}
