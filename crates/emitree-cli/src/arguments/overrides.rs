//! Options that replace values of the scene, and those of every run: each stands here once.

use clap::Args;
use emitree_io::Override;

/// How a command runs.
#[derive(Args, Debug)]
pub(crate) struct Running {
    /// The number of threads; all cores without it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Print neither progress nor summary.
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

/// Any key of the scene.
#[derive(Args, Debug)]
pub(super) struct ReplacedKeys {
    /// Replace any value of the scene, as in --set emission.constants.a=50. May be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    set: Vec<(String, String)>,
}

impl ReplacedKeys {
    pub(super) fn overrides(&self) -> impl Iterator<Item = Override> {
        self.set.iter().map(|(key, value)| Override {
            key: key.clone(),
            value: value.clone(),
            option: "set".into(),
        })
    }
}

/// The method, its tolerance and its limits, and the number of pixels.
#[derive(Args, Debug)]
pub(super) struct LimitOptions {
    /// The method: vol, paper or los; vol if the scene names none.
    #[arg(long)]
    method: Option<String>,
    /// The largest image error, relative to the largest pixel (los: along each line).
    #[arg(long, value_name = "T")]
    tolerance: Option<String>,
    /// Stop each rendering after this many evaluations.
    #[arg(long, value_name = "N")]
    max_evaluations: Option<String>,
    /// Stop each rendering after this time, with the best image so far.
    #[arg(long, value_name = "SECONDS")]
    max_seconds: Option<String>,
    /// Columns of the image.
    #[arg(long, value_name = "PIXELS")]
    width: Option<String>,
    /// Rows of the image.
    #[arg(long, value_name = "PIXELS")]
    height: Option<String>,
}

impl LimitOptions {
    pub(super) fn overrides(&self) -> Vec<Override> {
        given(&[
            ("render.method", "method", &self.method),
            ("render.tolerance", "tolerance", &self.tolerance),
            ("render.max_evaluations", "max-evaluations", &self.max_evaluations),
            ("render.max_seconds", "max-seconds", &self.max_seconds),
            ("image.width", "width", &self.width),
            ("image.height", "height", &self.height),
        ])
    }
}

/// The options of a tree.
#[derive(Args, Debug)]
pub(super) struct BuildOptions {
    /// Drop details below this fraction of the largest rate.
    #[arg(long, value_name = "T")]
    tolerance: Option<String>,
    /// Stop after this many evaluations.
    #[arg(long, value_name = "N")]
    max_evaluations: Option<String>,
}

impl BuildOptions {
    pub(super) fn overrides(&self) -> Vec<Override> {
        given(&[
            ("build.tolerance", "tolerance", &self.tolerance),
            ("build.max_evaluations", "max-evaluations", &self.max_evaluations),
        ])
    }
}

/// All options that replace values of a scene that is rendered.
#[derive(Args, Debug)]
pub(crate) struct SceneOptions {
    #[command(flatten)]
    limits: LimitOptions,
    /// The error allowed relative to each pixel, instead of --tolerance (vol).
    #[arg(long, value_name = "R")]
    rtol: Option<String>,
    /// The error allowed in every pixel, in the unit of the image; with --rtol the sum of both (vol).
    #[arg(long, value_name = "A")]
    atol: Option<String>,
    /// Below this fraction of the largest pixel, --rtol is relative to that brightness; 1e-5 without it.
    #[arg(long, value_name = "F")]
    floor: Option<String>,
    /// A weight for each pixel, which its error is multiplied with; 0: it does not matter. .fits, .npy (vol).
    #[arg(long, value_name = "FILE")]
    weights: Option<String>,
    /// The pixels that matter: those that are not 0 in this map; .fits, .npy (vol).
    #[arg(long, value_name = "FILE")]
    mask: Option<String>,
    /// Render each band of a cube to its own largest voxel (vol).
    #[arg(long)]
    per_band: bool,
    /// A sum over a region, to a tolerance of its own: a mask (.fits, .npy), or as in
    /// --sum 'on={circle={center=[32,24],radius=10},tolerance=1e-3}'. May be repeated (vol).
    #[arg(long = "sum", value_name = "NAME=REGION", value_parser = name_value)]
    sums: Vec<(String, String)>,
    /// Drop details below this, in the units of g, or of the largest cell average with a %.
    #[arg(long, value_name = "SIZE")]
    threshold: Option<String>,
    /// The order of the prediction: 1, 3, 5, 7 or 9.
    #[arg(long, value_name = "P")]
    order: Option<String>,
    /// The base grid has 2^L cells along each axis (vol: intervals).
    #[arg(long, value_name = "L")]
    base_level: Option<String>,
    /// Split no cell of level L, however large its details.
    #[arg(long, value_name = "L")]
    finest_level: Option<String>,
    /// How cell averages are made: midpoint or simpson.
    #[arg(long)]
    rule: Option<String>,
    /// Detect a Gaussian of this standard deviation with 99 % probability: a fraction of the view's cube,
    /// or a length as in "0.1 R_E" (vol).
    #[arg(long, value_name = "SIZE")]
    smallest_feature: Option<String>,
    /// What is to be little: evaluations, or time. With time, rates that take nanoseconds are integrated along lines of
    /// sight on a lattice of pixels where that is faster, to the same tolerance (vol).
    #[arg(long, value_name = "WHAT")]
    minimize: Option<String>,
    /// Make at most this many evaluations in one batch.
    #[arg(long, value_name = "N")]
    batch_size: Option<String>,
    /// Aim at this number of batches, for up to some times the evaluations: where a batch takes long, however small.
    #[arg(long, value_name = "N")]
    rounds: Option<String>,
    /// N x N lines of sight for each pixel (method los).
    #[arg(long, value_name = "N")]
    lines: Option<String>,
    /// Uniform steps along each line of sight (method los).
    #[arg(long, value_name = "M")]
    steps: Option<String>,
    /// The seed of --counts; another one draws other counts.
    #[arg(long, value_name = "N")]
    seed: Option<String>,
    #[command(flatten)]
    replaced: ReplacedKeys,
}

impl SceneOptions {
    /// The options that replace values of the scene; --set comes last.
    pub(crate) fn overrides(&self) -> Vec<Override> {
        let options = given(&[
            ("render.rtol", "rtol", &self.rtol),
            ("render.atol", "atol", &self.atol),
            ("render.floor", "floor", &self.floor),
            ("render.weights", "weights", &self.weights),
            ("render.mask", "mask", &self.mask),
            ("render.per_band", "per-band", &self.per_band.then(|| "true".to_owned())),
            ("render.threshold", "threshold", &self.threshold),
            ("render.order", "order", &self.order),
            ("render.base_level", "base-level", &self.base_level),
            ("render.finest_level", "finest-level", &self.finest_level),
            ("render.rule", "rule", &self.rule),
            ("render.smallest_feature", "smallest-feature", &self.smallest_feature),
            ("render.minimize", "minimize", &self.minimize),
            ("render.batch_size", "batch-size", &self.batch_size),
            ("render.rounds", "rounds", &self.rounds),
            ("render.lines", "lines", &self.lines),
            ("render.steps", "steps", &self.steps),
            ("instrument.seed", "seed", &self.seed),
        ]);
        let sums = self.sums.iter().map(|(name, region)| Override {
            key: format!("render.sums.\"{name}\""),
            value: region.clone(),
            option: "sum".into(),
        });
        let limits = self.limits.overrides().into_iter();
        limits.chain(sums).chain(options).chain(self.replaced.overrides()).collect()
    }
}

/// Overrides of the options that are given.
fn given(options: &[(&str, &str, &Option<String>)]) -> Vec<Override> {
    let given = options.iter().filter_map(|(key, option, value)| {
        let value = (*value).clone()?;
        Some(Override { key: (*key).into(), value, option: (*option).into() })
    });
    given.collect()
}

fn key_value(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() => {
            Ok((key.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err("expected KEY=VALUE, as in image.width=100".to_owned()),
    }
}

fn name_value(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, region)) if !name.trim().is_empty() && !name.contains(['"', '\\']) => {
            Ok((name.trim().to_owned(), region.trim().to_owned()))
        }
        _ => Err("expected NAME=REGION, as in on=mask.fits".to_owned()),
    }
}
