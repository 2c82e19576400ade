//! Rendering: from an emission and a projection to an image, its error and its bill.

use crate::cube::Cube;
use crate::emission::Emission;
use crate::erased::{Erased, Failure, with_erased};
use crate::error::RenderError;
use crate::image::Image;
use crate::los::{LosOptions, Steps, adaptive, fixed};
use crate::memory::{check_size, evaluations_in_memory};
use crate::meter::{CanonicalIntegrand, Deadline, Limits, Meter, Progress};
use crate::projection::{Projection, Region};
use crate::radiance::{PixelRows, image_of_tree};
use crate::refinement::Threshold;
use crate::tally::EvaluationCounts;
use crate::tree::{BuildOptions, Ending, SparseTree, build};
use crate::vol::{self, Found, VolOptions};
use core::ops::ControlFlow;
use core::time::Duration;
use std::time::Instant;

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
    with_erased(emission, |emission| render_erased(emission, projection, shape, options))
}

fn render_erased(
    emission: &Erased<'_>,
    projection: &dyn Projection,
    shape: [usize; 2],
    options: &RenderOptions<'_>,
) -> Result<Rendering, RenderError<Failure>> {
    let start = Instant::now();
    check_options(shape, None, options)?;
    let tiles = Tile::of(projection, shape)?;
    let meter = Meter::new(emission, shape, limits(options), options.progress);
    let mut rendering = match options.method {
        Method::Vol(vol_options) => {
            vol::render(&meter, &tiles, None, &vol_options, options)?.into()
        }
        Method::Paper(build_options) => {
            stacked(&tiles, |tile| render_tree(&meter, tile, &build_options))?
        }
        Method::Los(LosOptions { lines, steps }) => {
            stacked(&tiles, |tile| render_los(&meter, tile, lines, steps, None))?
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

/// One square of an image: all of it, or one of several that lie one above the other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tile<'a> {
    pub(crate) projection: &'a dyn Projection,
    /// Height and width in pixels.
    pub(crate) shape: [usize; 2],
    /// Its number from the lowest, and the number of all.
    pub(crate) place: (usize, usize),
}

impl<'a> Tile<'a> {
    /// The tiles of a projection's image, the lowest first.
    pub(crate) fn of<E>(
        projection: &'a dyn Projection,
        [height, width]: [usize; 2],
    ) -> Result<Vec<Self>, RenderError<E>> {
        let tiles = projection.tiles();
        let count = tiles.len();
        if count == 0 {
            let shape = [height, width];
            if !has_image(&PixelRows { projection, shape }) {
                return Err(RenderError::NoSolidAngle);
            }
            return Ok(vec![Self { projection, shape, place: (0, 1) }]);
        }
        if !height.is_multiple_of(count) {
            let (name, expected) = ("height", "as many rows for each tile of the projection");
            return Err(RenderError::Option { name, value: height.to_string(), expected });
        }
        let tile = |(number, projection)| Self {
            projection,
            shape: [height / count, width],
            place: (number, count),
        };
        Ok(tiles.into_iter().enumerate().map(tile).collect())
    }

    /// Finds a pixel whose sum is beyond all numbers, although the rates are not.
    pub(crate) fn check_finite<E>(&self, image: &Image) -> Result<(), RenderError<E>> {
        let [height, width] = self.shape;
        for row in 0..height {
            for (column, &value) in image.row(row).iter().enumerate() {
                let middle = [(column, width), (row, height)];
                let middle = middle.map(|(at, pixels)| (at as f64 + 0.5) / pixels as f64);
                if !value.is_finite() && self.projection.region(middle) != Region::Outside {
                    let row = row + self.place.0 * height;
                    return Err(RenderError::ImageNotFinite { row, column, value });
                }
            }
        }
        Ok(())
    }
}

/// Whether any pixel has a solid angle.
fn has_image(rows: &PixelRows<'_>) -> bool {
    let [height, width] = rows.shape;
    let mut solid_angles = vec![0.0; width];
    (0..height).any(|row| {
        rows.solid_angles(row, &mut solid_angles);
        solid_angles.iter().any(|&angle: &f64| angle > 0.0 && angle.is_finite())
    })
}

/// One rendering from those of all tiles.
pub(crate) fn stacked<E>(
    tiles: &[Tile<'_>],
    render: impl Fn(&Tile<'_>) -> Result<Rendering, RenderError<E>>,
) -> Result<Rendering, RenderError<E>> {
    let mut renderings = Vec::with_capacity(tiles.len());
    for tile in tiles {
        let rendering = render(tile)?;
        tile.check_finite(&rendering.image)?;
        renderings.push(rendering);
    }
    if renderings.len() == 1 {
        return Ok(renderings.remove(0));
    }
    let image = Image::stacked(renderings.iter().map(|rendering| &rendering.image));
    let errors: Option<Vec<&Image>> =
        renderings.iter().map(|rendering| rendering.error.as_ref()).collect();
    let error = errors.map(|errors| Image::stacked(errors.into_iter()));
    let stopped = renderings.iter().map(|rendering| rendering.ending);
    let ending = stopped.reduce(|a, b| if a == Ending::Complete { b } else { a });
    let mut rendering = Rendering::new(image, error, ending.unwrap_or(Ending::Complete));
    rendering.base_level = renderings.iter().find_map(|rendering| rendering.base_level);
    Ok(rendering)
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

/// How often g may be called, and until when, counted from now.
pub(crate) fn limits(options: &RenderOptions<'_>) -> Limits {
    let max_evaluations = options.max_evaluations.min(evaluations_in_memory(options));
    let deadline = Deadline::after_seconds(options.max_seconds);
    Limits { max_evaluations, batch_size: options.batch_size, deadline }
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

/// The tree behind an image.
#[derive(Clone, Debug)]
pub struct RenderedTree {
    /// The canonical integrand g · ds/dz · dΩ/(dx dy) as a tree.
    pub tree: SparseTree<3>,
    /// The threshold of the last step, in the unit of g as in [`Method::Paper`].
    pub threshold: f64,
}

impl Rendering {
    /// A rendering whose bill is still to be written.
    pub(crate) fn new(image: Image, error: Option<Image>, ending: Ending) -> Self {
        Self {
            image,
            error,
            ending,
            evaluations: 0,
            evaluations_of_pixels: EvaluationCounts::none(),
            batches: 0,
            tree: None,
            base_level: None,
            smallest_feature: None,
            emission_time: Duration::ZERO,
            total_time: Duration::ZERO,
        }
    }
}

impl From<Found> for Rendering {
    fn from(found: Found) -> Self {
        let [image, error] = [found.cube, found.error].map(Cube::into_first);
        let mut rendering = Self::new(image, Some(error), found.ending);
        rendering.base_level = Some(found.base_level);
        rendering.smallest_feature = found.smallest_feature;
        rendering
    }
}

fn render_tree<E: Emission>(
    meter: &Meter<'_, E>,
    &Tile { projection, shape, place: tile }: &Tile<'_>,
    options: &BuildOptions,
) -> Result<Rendering, RenderError<E::Error>> {
    let middle = projection.world_from_canonical([0.5; 3]);
    let weight = middle.path_per_depth * projection.solid_angle([0.0; 2], [1.0; 2]);
    let threshold = match options.threshold {
        Threshold::Absolute(size) => Threshold::Absolute(size * weight),
        relative @ Threshold::Relative(_) => relative,
    };
    let options = BuildOptions { threshold, ..*options };
    let integrand = CanonicalIntegrand { meter, projection, tile };
    let built = build(&integrand, projection.periodic(), &options)?;
    let image = image_of_tree(&built.tree.project(2), projection, shape);
    let mut error = image_of_tree(&built.previous.project(2), projection, shape);
    for (error, pixel) in error.pixels_mut().iter_mut().zip(image.pixels()) {
        *error = (*error - pixel).abs();
    }
    let mut rendering = Rendering::new(image, Some(error), built.ending);
    let threshold = built.threshold / weight;
    rendering.base_level = Some(options.base_level);
    rendering.tree = Some(RenderedTree { tree: built.tree, threshold });
    Ok(rendering)
}

/// The image by integration along lines of sight, at one `energy` if there is an energy axis.
pub(crate) fn render_los<E: Emission>(
    meter: &Meter<'_, E>,
    tile: &Tile<'_>,
    lines: usize,
    steps: Steps,
    energy: Option<f64>,
) -> Result<Rendering, RenderError<E::Error>> {
    let option = |name, value: String, expected| Err(RenderError::Option { name, value, expected });
    if lines == 0 {
        return option("lines", lines.to_string(), "1 or more lines along each side of a pixel");
    }
    match steps {
        Steps::Fixed(0) => option("steps", "0".into(), "1 or more steps along each line"),
        Steps::Fixed(steps) => {
            let image = fixed::render(meter, tile, lines, steps, energy)?;
            Ok(Rendering::new(image, None, Ending::Complete))
        }
        Steps::Adaptive(tolerance) if !(tolerance > 0.0 && tolerance.is_finite()) => {
            option("tolerance", tolerance.to_string(), "a number above 0")
        }
        Steps::Adaptive(tolerance) => {
            let found = adaptive::render(meter, tile, lines, tolerance, energy)?;
            let ending = if found.converged { Ending::Complete } else { Ending::Budget };
            Ok(Rendering::new(found.image, Some(found.error), ending))
        }
    }
}
