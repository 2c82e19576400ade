//! Rendering: from an emission and a projection to an image, its error and its bill.

use crate::emission::Emission;
use crate::error::RenderError;
use crate::image::Image;
use crate::los::{LosOptions, Steps, adaptive, fixed};
use crate::meter::{CanonicalIntegrand, Meter, Progress};
use crate::projection::Projection;
use crate::quadrature::CellRule;
use crate::refinement::Threshold;
use crate::tree::{BuildOptions, Ending, SparseTree, build};
use core::time::Duration;
use std::time::Instant;

/// The way from g to the image.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Method {
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
            Self::Paper(_) => "paper",
            Self::Los(_) => "los",
        }
    }
}

/// Options of a rendering.
#[derive(Clone, Copy)]
pub struct RenderOptions<'a> {
    /// The way from g to the image.
    pub method: Method,
    /// The largest number of evaluations of g.
    pub max_evaluations: u64,
    /// What the image and the coarsest grid may take \[bytes\]; more is refused before anything is
    /// allocated.
    pub max_memory_bytes: u64,
    /// Called after each call of g, from any thread, with the evaluations so far; may break.
    pub progress: Option<&'a Progress<'a>>,
}

/// A budget that ends a runaway refinement (a jump and a tiny threshold) while its tree still fits
/// in a few GiB.
pub const DEFAULT_MAX_EVALUATIONS: u64 = 50_000_000;

/// Memory that any workstation has.
const DEFAULT_MAX_MEMORY_BYTES: u64 = 8 << 30;

/// Memory that one cell of a tree takes while the tree is built, at the most, with its share of the
/// ghosts, of the tree without the last generation and of the evaluations that are kept.
///
/// Measured on trees of 10⁴ to 10⁶ cells (`tests/alloc.rs`), 33 to 47 bytes and 360 to 520, and
/// rounded up: a hash table that has just grown is larger.
fn bytes_per_cell(rule: CellRule) -> u64 {
    match rule {
        CellRule::Midpoint => 64,
        CellRule::Simpson => 640,
    }
}

impl RenderOptions<'_> {
    /// The given method with the default limits: equal steps along lines are counted beforehand and
    /// have none, all else may make [`DEFAULT_MAX_EVALUATIONS`].
    pub fn new(method: Method) -> Self {
        let max_evaluations = match method {
            Method::Los(LosOptions { steps: Steps::Fixed(_), .. }) => u64::MAX,
            _ => DEFAULT_MAX_EVALUATIONS,
        };
        Self { method, max_evaluations, max_memory_bytes: DEFAULT_MAX_MEMORY_BYTES, progress: None }
    }
}

impl core::fmt::Debug for RenderOptions<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("RenderOptions")
            .field("method", &self.method)
            .field("max_evaluations", &self.max_evaluations)
            .field("max_memory_bytes", &self.max_memory_bytes)
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
    /// `Paper`: what the last generation of cells changed. Adaptive `Los`: the error along the
    /// lines; that of too few lines for a pixel is not in it. Fixed steps have no estimate.
    pub error: Option<Image>,
    /// How often g was evaluated.
    pub evaluations: u64,
    /// The number of batches in which that was done: one for each refinement step.
    pub batches: u64,
    /// What ended the rendering.
    pub ending: Ending,
    /// The tree that was built, if the method builds one.
    pub tree: Option<RenderedTree>,
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
        let largest = |image: &Image| image.pixels().iter().fold(0.0, |m: f64, p| m.max(p.abs()));
        let error = largest(self.error.as_ref()?);
        let image = largest(&self.image);
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
    let start = Instant::now();
    check_size(shape, options)?;
    let max_evaluations = options.max_evaluations.min(evaluations_in_memory(options));
    let meter = Meter::new(emission, projection, max_evaluations, options.progress);
    let mut rendering = match options.method {
        Method::Paper(build_options) => render_tree(&meter, projection, shape, &build_options)?,
        Method::Los(LosOptions { lines, steps }) => {
            render_los(&meter, projection, shape, lines, steps)?
        }
    };
    rendering.evaluations = meter.evaluations();
    rendering.batches = meter.batches();
    rendering.emission_time = meter.emission_time();
    rendering.total_time = start.elapsed();
    let mut pixels = rendering.image.pixels().iter();
    if let Some(pixel) = pixels.position(|pixel| !pixel.is_finite()) {
        let (row, column) = (pixel / shape[1], pixel % shape[1]);
        let value = rendering.image[(row, column)];
        return Err(RenderError::ImageNotFinite { row, column, value });
    }
    Ok(rendering)
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
    fn new(image: Image, error: Option<Image>, ending: Ending) -> Self {
        Self {
            image,
            error,
            ending,
            evaluations: 0,
            batches: 0,
            tree: None,
            emission_time: Duration::ZERO,
            total_time: Duration::ZERO,
        }
    }
}

fn render_tree<E: Emission>(
    meter: &Meter<'_, E>,
    projection: &dyn Projection,
    shape: [usize; 2],
    options: &BuildOptions,
) -> Result<Rendering, RenderError<E::Error>> {
    let middle = projection.world_from_canonical([0.5; 3]);
    let weight = middle.path_per_depth * projection.solid_angle([0.0; 2], [1.0; 2]);
    let threshold = match options.threshold {
        Threshold::Absolute(size) => Threshold::Absolute(size * weight),
        relative @ Threshold::Relative(_) => relative,
    };
    let options = BuildOptions { threshold, ..*options };
    let built = build(&CanonicalIntegrand(meter), projection.periodic(), &options)?;
    let image = image_of_tree(&built.tree.project(2), projection, shape);
    let mut error = image_of_tree(&built.previous.project(2), projection, shape);
    for (error, pixel) in error.pixels_mut().iter_mut().zip(image.pixels()) {
        *error = (*error - pixel).abs();
    }
    let mut rendering = Rendering::new(image, Some(error), built.ending);
    let threshold = built.threshold / weight;
    rendering.tree = Some(RenderedTree { tree: built.tree, threshold });
    Ok(rendering)
}

fn render_los<E: Emission>(
    meter: &Meter<'_, E>,
    projection: &dyn Projection,
    shape: [usize; 2],
    lines: usize,
    steps: Steps,
) -> Result<Rendering, RenderError<E::Error>> {
    let option = |name, value: String, expected| Err(RenderError::Option { name, value, expected });
    if lines == 0 {
        return option("lines", lines.to_string(), "1 or more lines along each side of a pixel");
    }
    match steps {
        Steps::Fixed(0) => option("steps", "0".into(), "1 or more steps along each line"),
        Steps::Fixed(steps) => {
            let image = fixed::render(meter, projection, shape, lines, steps)?;
            Ok(Rendering::new(image, None, Ending::Complete))
        }
        Steps::Adaptive(tolerance) if !(tolerance > 0.0 && tolerance.is_finite()) => {
            option("tolerance", tolerance.to_string(), "a number above 0")
        }
        Steps::Adaptive(tolerance) => {
            let found = adaptive::render(meter, projection, shape, lines, tolerance)?;
            let ending = if found.converged { Ending::Complete } else { Ending::Budget };
            Ok(Rendering::new(found.image, Some(found.error), ending))
        }
    }
}

/// The radiance of each pixel from the tree of the irradiance density on the image plane.
///
/// # Panics
///
/// If the shape is one that [`SparseTree::sample`] can't make.
pub fn image_of_tree(
    tree: &SparseTree<2>,
    projection: &dyn Projection,
    [height, width]: [usize; 2],
) -> Image {
    let mut image = tree.sample(height, width);
    let (dx, dy) = (1.0 / width as f64, 1.0 / height as f64);
    for row in 0..height {
        // Borders of pixels as quotients, so that neighbours share them to the last bit.
        let y = [row as f64 / height as f64, (row + 1) as f64 / height as f64];
        for column in 0..width {
            let x = [column as f64 / width as f64, (column + 1) as f64 / width as f64];
            let solid_angle = projection.solid_angle([x[0], y[0]], [x[1], y[1]]);
            image[(row, column)] *= dx * dy / solid_angle;
        }
    }
    image
}

/// Sampling counts the pixels of an axis in 24 bits.
const MAX_PIXELS_ALONG: usize = 1 << 24;
/// Numbers that the weights of a pixel's row or column take, with their bookkeeping.
const WEIGHTS_PER_PIXEL: u64 = 24;
/// Numbers for each pixel: the image, its error and what the latter is the difference of, and the
/// bytes of a file made of each.
const MAPS: u64 = 6;

/// How many evaluations a tree may make before it fills the memory allowed.
fn evaluations_in_memory(options: &RenderOptions<'_>) -> u64 {
    match options.method {
        Method::Paper(BuildOptions { rule, .. }) => options.max_memory_bytes / bytes_per_cell(rule),
        Method::Los(_) => u64::MAX,
    }
}

/// Refuses what can't fit in memory, before anything is allocated.
fn check_size<E>(
    [height, width]: [usize; 2],
    options: &RenderOptions<'_>,
) -> Result<(), RenderError<E>> {
    if height == 0 || width == 0 {
        return Err(RenderError::EmptyImage { height, width });
    }
    let refuse = |what: String, needed: u64| {
        let allowed = options.max_memory_bytes;
        if needed > allowed { Err(RenderError::TooLarge { what, needed, allowed }) } else { Ok(()) }
    };
    let longest = height.max(width);
    if longest > MAX_PIXELS_ALONG {
        let name = if longest == width { "width" } else { "height" };
        let expected = "at most 2^24 pixels along an axis";
        return Err(RenderError::Option { name, value: longest.to_string(), expected });
    }
    let (height, width) = (height as u64, width as u64);
    let number = size_of::<f64>() as u64;
    let needed = match options.method {
        Method::Paper(BuildOptions { base_level, .. }) => {
            // The grid that the image is sampled from, its cells no larger than pixels along the
            // narrower axis, and half of it again while it is made; then that grid with the pixels
            // of one axis; then the weights of an axis; then maps.
            let level = u64::from(base_level.min(16));
            let cells = height.min(width).next_power_of_two().max(1 << level);
            let grid = cells.saturating_mul(cells.saturating_mul(3) / 2 + width);
            let weights = (height + width).saturating_mul(WEIGHTS_PER_PIXEL);
            grid.saturating_add(weights).saturating_add(height.saturating_mul(width * MAPS))
        }
        Method::Los(LosOptions { lines, steps }) => {
            let per_line = match steps {
                Steps::Fixed(_) => 1,
                Steps::Adaptive(_) => adaptive::BYTES_PER_LINE / number,
            };
            let of_lines = (lines as u64).saturating_mul(lines as u64).saturating_mul(per_line);
            height.saturating_mul(width).saturating_mul(of_lines.saturating_add(MAPS))
        }
    };
    let image = format!("an image of {height} x {width} pixels (height x width)");
    refuse(image, needed.saturating_mul(number))?;
    if let Method::Paper(build_options) = options.method {
        let level = build_options.base_level;
        // Each base cell is split at once.
        let cells = build_options.base_cells::<3>().saturating_mul(8);
        refuse(
            format!("a base grid of level {level} (2^{level} cells along each axis, split once)"),
            cells.saturating_mul(bytes_per_cell(build_options.rule)),
        )?;
    }
    Ok(())
}
