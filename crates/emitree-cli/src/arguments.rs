//! The command line.

use clap::{Args, Parser, Subcommand};
use emitree_io::Override;
use std::path::PathBuf;

/// Images of optically thin volume emissions, with as few evaluations of the emission as possible.
#[derive(Debug, Parser)]
#[command(name = "emitree", version, max_term_width = 100)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene file to images.
    Render(Box<RenderArguments>),
    /// Render a scene at several values of some of its keys, with fewer evaluations than one by one.
    Sweep(Box<SweepArguments>),
    /// Build the tree of a scene's emission: a FITS file that scenes can render from any camera.
    Build(Box<BuildArguments>),
    /// List the built-in emission models, or all about one of them.
    Models {
        /// The model to describe.
        name: Option<String>,
    },
    /// Measure Figures 9, 10 and 11 of the paper anew: CSV files and plots.
    Reproduce {
        /// The folder for the files.
        #[arg(short, long, default_value = "reproduction")]
        output: PathBuf,
    },
}

#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
pub(crate) struct RenderArguments {
    /// The scene file (TOML).
    pub(crate) scene: PathBuf,

    /// Write the image here; .fits, .npy or .png. May be repeated.
    /// Without it: SCENE.fits, SCENE.npy and SCENE.png in this folder.
    #[arg(short, long = "output", value_name = "FILE")]
    pub(crate) outputs: Vec<PathBuf>,
    /// Write the report here (JSON).
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,
    /// Write the estimated error of each pixel here; .fits, .npy or .png.
    #[arg(long, value_name = "FILE")]
    pub(crate) error_map: Option<PathBuf>,
    /// Write the image of the whole energy band here, the sum of a cube over its energies; .fits,
    /// .npy or .png. May be repeated.
    #[arg(long = "band", value_name = "FILE")]
    pub(crate) bands: Vec<PathBuf>,
    /// Write the counts that the scene's [instrument] is expected to make here, a cube of channels;
    /// .fits, .npy or .png. May be repeated.
    #[arg(long = "expected-counts", value_name = "FILE")]
    pub(crate) expected_counts: Vec<PathBuf>,
    /// Write counts drawn from the expected ones here, a Poisson realisation with the seed of the
    /// scene; .fits, .npy or .png. May be repeated.
    #[arg(long = "counts", value_name = "FILE")]
    pub(crate) counts: Vec<PathBuf>,
    /// Write the surfaces found at which the emission rate jumps here, as triangles; .vtp or .npz (vol).
    /// May be repeated.
    #[arg(long, value_name = "FILE")]
    pub(crate) surfaces: Vec<PathBuf>,
    /// Write a series of ever finer images (PNG and NPY) into this folder. vol: the image after
    /// each step and its error; paper: the coefficients projected by size, the largest first.
    #[arg(long, value_name = "DIR")]
    pub(crate) progressive: Option<PathBuf>,

    /// Draw PNG outputs with axes, a title and a colour bar (frames of --progressive stay bare).
    #[arg(long)]
    pub(crate) annotate: bool,
    /// Draw colours on a logarithmic scale, down to 1e-3 of the largest pixel.
    #[arg(long, requires = "annotate")]
    pub(crate) log: bool,

    /// The method: vol, paper or los; vol if the scene names none.
    #[arg(long)]
    method: Option<String>,
    /// The largest image error, relative to the largest pixel (los: along each line).
    #[arg(long, value_name = "T")]
    tolerance: Option<String>,
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
    /// Stop after this many evaluations.
    #[arg(long, value_name = "N")]
    max_evaluations: Option<String>,
    /// Stop after this time, with the best image so far.
    #[arg(long, value_name = "SECONDS")]
    max_seconds: Option<String>,
    /// Detect a Gaussian of this standard deviation with 99 % probability: a fraction of the view's cube,
    /// or a length as in "0.1 R_E" (vol).
    #[arg(long, value_name = "SIZE")]
    smallest_feature: Option<String>,
    /// Make at most this many evaluations in one batch.
    #[arg(long, value_name = "N")]
    batch_size: Option<String>,
    /// Columns of the image.
    #[arg(long, value_name = "PIXELS")]
    width: Option<String>,
    /// Rows of the image.
    #[arg(long, value_name = "PIXELS")]
    height: Option<String>,
    /// N x N lines of sight for each pixel (method los).
    #[arg(long, value_name = "N")]
    lines: Option<String>,
    /// Uniform steps along each line of sight (method los).
    #[arg(long, value_name = "M")]
    steps: Option<String>,
    /// The seed of --counts; another one draws other counts.
    #[arg(long, value_name = "N")]
    seed: Option<String>,
    /// Replace any value of the scene, as in --set emission.constants.a=50. May be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    set: Vec<(String, String)>,

    /// The number of threads; all cores without it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Print neither progress nor summary.
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

impl RenderArguments {
    /// The options that replace values of the scene; --set comes last.
    pub(crate) fn overrides(&self) -> Vec<Override> {
        let options = [
            ("render.method", "method", &self.method),
            ("render.tolerance", "tolerance", &self.tolerance),
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
            ("render.max_evaluations", "max-evaluations", &self.max_evaluations),
            ("render.max_seconds", "max-seconds", &self.max_seconds),
            ("render.smallest_feature", "smallest-feature", &self.smallest_feature),
            ("render.batch_size", "batch-size", &self.batch_size),
            ("image.width", "width", &self.width),
            ("image.height", "height", &self.height),
            ("render.lines", "lines", &self.lines),
            ("render.steps", "steps", &self.steps),
            ("instrument.seed", "seed", &self.seed),
        ];
        let sums = self.sums.iter().map(|(name, region)| Override {
            key: format!("render.sums.\"{name}\""),
            value: region.clone(),
            option: "sum".into(),
        });
        sums.chain(overrides(&options, &self.set)).collect()
    }
}

/// `emitree sweep`: an image for each combination of values.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
pub(crate) struct SweepArguments {
    /// The scene file (TOML).
    pub(crate) scene: PathBuf,

    /// A key of the scene and its values: KEY=START:STOP:COUNT, COUNT values from START to STOP, or KEY=A,B,C.
    /// As in --over emission.parameters.bz=-5:5:11. Of several, all combinations are rendered.
    #[arg(long, value_name = "KEY=VALUES", required = true)]
    pub(crate) over: Vec<String>,
    /// Write the images here; .fits, .npy or .png. May be repeated. {KEY}, or the last part of the key, is its
    /// value, {number} the number of the image from 0: as in images/bz_{bz}.fits.
    #[arg(short, long = "output", value_name = "TEMPLATE", required = true)]
    pub(crate) outputs: Vec<PathBuf>,
    /// Write the estimated error of each pixel here, for each image; .fits, .npy or .png.
    #[arg(long, value_name = "TEMPLATE")]
    pub(crate) error_map: Option<PathBuf>,
    /// Write the report of all images here (JSON).
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,

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
    /// Columns of the images.
    #[arg(long, value_name = "PIXELS")]
    width: Option<String>,
    /// Rows of the images.
    #[arg(long, value_name = "PIXELS")]
    height: Option<String>,
    /// Replace any value of the scene, as in --set emission.constants.a=50. May be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    set: Vec<(String, String)>,

    /// The number of threads; all cores without it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Print neither progress nor summary.
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

impl SweepArguments {
    /// The options that replace values of the scene; --set comes last.
    pub(crate) fn overrides(&self) -> Vec<Override> {
        let options = [
            ("render.method", "method", &self.method),
            ("render.tolerance", "tolerance", &self.tolerance),
            ("render.max_evaluations", "max-evaluations", &self.max_evaluations),
            ("render.max_seconds", "max-seconds", &self.max_seconds),
            ("image.width", "width", &self.width),
            ("image.height", "height", &self.height),
        ];
        overrides(&options, &self.set)
    }
}

/// `emitree build`: the box and all other options are the scene's, in `[build]`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
pub(crate) struct BuildArguments {
    /// The scene file (TOML), with a table [build].
    pub(crate) scene: PathBuf,

    /// Write the tree here; .fits.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Drop details below this fraction of the largest rate.
    #[arg(long, value_name = "T")]
    tolerance: Option<String>,
    /// Stop after this many evaluations.
    #[arg(long, value_name = "N")]
    max_evaluations: Option<String>,
    /// Replace any value of the scene, as in --set emission.constants.a=50. May be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = key_value)]
    set: Vec<(String, String)>,

    /// The number of threads; all cores without it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Print neither progress nor summary.
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

impl BuildArguments {
    /// The options that replace values of the scene; --set comes last.
    pub(crate) fn overrides(&self) -> Vec<Override> {
        let options = [
            ("build.tolerance", "tolerance", &self.tolerance),
            ("build.max_evaluations", "max-evaluations", &self.max_evaluations),
        ];
        overrides(&options, &self.set)
    }
}

/// Overrides of the options that are given, then those of --set.
fn overrides(options: &[(&str, &str, &Option<String>)], set: &[(String, String)]) -> Vec<Override> {
    let given = options.iter().filter_map(|(key, option, value)| {
        let value = (*value).clone()?;
        Some(Override { key: (*key).into(), value, option: (*option).into() })
    });
    let set = set.iter().map(|(key, value)| Override {
        key: key.clone(),
        value: value.clone(),
        option: "set".into(),
    });
    given.chain(set).collect()
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
