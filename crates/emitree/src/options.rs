//! Options of a rendering: the method and its options, the limits, and the callbacks.

use crate::los::{LosOptions, Steps};
use crate::mesh::Mesh;
use crate::mesh::start::Start;
use crate::progress::{FrameCallback, Progress};
use crate::tree::BuildOptions;
use crate::vol::VolOptions;

/// The method that computes the image from g.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Method {
    /// The image to a tolerance: a low-rank approximation of g or, where there is none, a tree of the
    /// image plane whose nodes are lines of sight.
    Vol(VolOptions),
    /// The paper's method: a sparse tree of cell averages, built by conservative subdivision, projected.
    ///
    /// An absolute threshold is in the unit of g. The tree's function is g times a weight of the
    /// view, ds/dz · dΩ/(dx dy), which is taken as its value for a line through the middle.
    Paper(BuildOptions),
    /// Integration along lines of sight, pixel by pixel.
    Los(LosOptions),
}

impl From<VolOptions> for Method {
    fn from(options: VolOptions) -> Self {
        Self::Vol(options)
    }
}

impl From<BuildOptions> for Method {
    fn from(options: BuildOptions) -> Self {
        Self::Paper(options)
    }
}

impl From<LosOptions> for Method {
    fn from(options: LosOptions) -> Self {
        Self::Los(options)
    }
}

impl Method {
    /// Whether the method may request a point again, whose rate has to be stored for that.
    pub(crate) fn repeats_points(&self) -> bool {
        matches!(self, Self::Vol(vol) if !vol.sums.is_empty())
    }

    /// The name in scenes.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Vol(_) => "vol",
            Self::Paper(_) => "paper",
            Self::Los(_) => "los",
        }
    }
}

/// Options of a rendering.
///
/// ```
/// use emitree::{RenderOptions, VolOptions};
/// use std::ops::ControlFlow;
///
/// let stop_soon = |evaluations: u64| {
///     if evaluations < 5_000 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
/// };
/// let options = RenderOptions::new(VolOptions::new(0.01))
///     .with_max_evaluations(1_000_000)
///     .with_max_seconds(60.0)
///     .with_progress(&stop_soon);
/// assert_eq!(options.method.name(), "vol");
/// ```
#[derive(Clone)]
#[non_exhaustive]
pub struct RenderOptions<'a> {
    /// The method that computes the image from g.
    pub method: Method,
    /// The largest number of evaluations of g.
    pub max_evaluations: u64,
    /// The longest time that the rendering may take \[s\], above 0; infinite for no limit. It ends with
    /// the best image so far and [`StopReason::Time`](crate::StopReason::Time), after a call of g that has
    /// begun. [`Method::Vol`] that has no image by then makes one of 27 evaluations (for each chart or tile of the
    /// view), whose errors are those of all of the light; others fail with
    /// [`RenderError::Time`](crate::RenderError::Time).
    pub max_seconds: f64,
    /// The memory that the image and the coarsest grid may take \[bytes\]; more is an error before
    /// anything is allocated.
    pub max_memory_bytes: u64,
    /// The largest number of evaluations in one batch: a larger one is made in parts.
    pub batch_size: u64,
    /// The number of batches that is aimed at, 1 or more; `None` for as few evaluations as possible. Where a batch
    /// takes long, points that are expected to be needed soon are evaluated with those that are needed: a
    /// rendering takes fewer batches and more evaluations, the more so the smaller the number is. It is no limit.
    /// The result has the same bits.
    pub rounds: Option<u32>,
    /// Called after each call of g, from any thread, with the evaluations so far; may break.
    pub progress: Option<&'a Progress<'a>>,
    /// Called after each step that has made a better image, coarse first; may break. Only
    /// [`Method::Vol`] has intermediate images.
    pub frame: Option<&'a FrameCallback<'a>>,
    /// The most evaluations with which the rendering has its [mesh](crate::Rendering::mesh), whose memory
    /// and time grow with them; 0, the default, for no mesh.
    pub mesh_up_to: u64,
    /// What the rendering begins with.
    pub(crate) start: Option<Start>,
}

/// A budget that ends a runaway refinement (a jump and a tiny threshold) while its tree still fits
/// in a few GiB.
pub(crate) const DEFAULT_MAX_EVALUATIONS: u64 = 50_000_000;

/// The memory of a usual workstation.
pub(crate) const DEFAULT_MAX_MEMORY_BYTES: u64 = 8 << 30;

impl<'a> RenderOptions<'a> {
    /// The largest number of evaluations of a rendering, if no other is given.
    pub const DEFAULT_MAX_EVALUATIONS: u64 = DEFAULT_MAX_EVALUATIONS;

    /// The given method, or the method of the given options, with the default limits:
    /// uniform steps along lines are counted beforehand and have no limit, the others
    /// [`DEFAULT_MAX_EVALUATIONS`](Self::DEFAULT_MAX_EVALUATIONS).
    pub fn new(method: impl Into<Method>) -> Self {
        let method = method.into();
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
            rounds: None,
            progress: None,
            frame: None,
            mesh_up_to: 0,
            start: None,
        }
    }

    /// Sets the largest number of evaluations of g.
    #[must_use]
    pub fn with_max_evaluations(mut self, max_evaluations: u64) -> Self {
        self.max_evaluations = max_evaluations;
        self
    }

    /// Sets the longest time that the rendering may take \[s\], above 0; infinite for no limit.
    #[must_use]
    pub fn with_max_seconds(mut self, max_seconds: f64) -> Self {
        self.max_seconds = max_seconds;
        self
    }

    /// Sets the memory that the image and the coarsest grid may take \[bytes\].
    #[must_use]
    pub fn with_max_memory_bytes(mut self, max_memory_bytes: u64) -> Self {
        self.max_memory_bytes = max_memory_bytes;
        self
    }

    /// Sets the largest number of evaluations in one batch, 1 or more.
    #[must_use]
    pub fn with_batch_size(mut self, batch_size: u64) -> Self {
        self.batch_size = batch_size;
        self
    }

    /// Sets the number of batches that is aimed at, 1 or more.
    #[must_use]
    pub fn with_rounds(mut self, rounds: u32) -> Self {
        self.rounds = Some(rounds);
        self
    }

    /// Sets the most evaluations with which the rendering has its mesh.
    #[must_use]
    pub fn with_mesh_up_to(mut self, evaluations: u64) -> Self {
        self.mesh_up_to = evaluations;
        self
    }

    /// Begins with the functions of the mesh of another emission in the same view, or in one like it. Where they
    /// suffice to the tolerance, as they do for an emission of similar structure, a rendering takes fewer
    /// evaluations; where they do not, it begins anew, as without a mesh. Only [products](crate::mesh::Mesh) have such
    /// functions; a mesh without them has no effect.
    #[must_use]
    pub fn with_start<V>(mut self, mesh: &Mesh<V>) -> Self {
        self.start = Some(mesh.start(false));
        self
    }

    /// The same without other functions: g is evaluated at the points of the mesh, and at scattered points
    /// that show the error. If the tolerance is not met the rendering ends with
    /// [`StopReason::FixedMesh`](crate::StopReason::FixedMesh). Its image is [`Mesh::apply`] of the rates.
    ///
    /// A rendering that needs a part of the view for which the mesh has no functions is an error,
    /// [`OptionError::FixedMesh`](crate::error::OptionError::FixedMesh).
    #[must_use]
    pub fn with_fixed_mesh<V>(mut self, mesh: &Mesh<V>) -> Self {
        self.start = Some(mesh.start(true));
        self
    }

    /// Sets the callback after each call of g.
    #[must_use]
    pub fn with_progress(mut self, progress: &'a Progress<'a>) -> Self {
        self.progress = Some(progress);
        self
    }

    /// Sets the callback for each intermediate image; only [`Method::Vol`] has any.
    #[must_use]
    pub fn with_frame(mut self, frame: &'a FrameCallback<'a>) -> Self {
        self.frame = Some(frame);
        self
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
            .field("rounds", &self.rounds)
            .finish_non_exhaustive()
    }
}
