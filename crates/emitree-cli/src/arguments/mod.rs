//! The command line.

mod overrides;

pub(crate) use overrides::{Running, SceneOptions};

use clap::{Args, Parser, Subcommand};
use emitree_io::Override;
use overrides::{BuildOptions, LimitOptions, ReplacedKeys};
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
    /// Write a commented scene file to start from.
    New(NewArguments),
    /// Tell what a scene would render, what it may cost, and what looks odd, from a small rehearsal.
    Check(Box<CheckArguments>),
    /// Render a scene file to images.
    Render(Box<RenderArguments>),
    /// Write the points at which a rendering needs the rates of another program.
    Plan(Box<PlanArguments>),
    /// Take the rates that a program has made, and write the next points, or the images.
    Resume(Box<ResumeArguments>),
    /// Render a scene at several values of some of its keys, with fewer evaluations than one by one.
    Sweep(Box<SweepArguments>),
    /// Build the tree of a scene's emission: a FITS file that scenes can render from any camera.
    Build(Box<BuildArguments>),
    /// Tell how two images, cubes or skies differ.
    Compare(CompareArguments),
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
    /// Write the man pages and the completions of shells into a folder.
    #[command(hide = true)]
    Manual {
        /// The folder; it is made if there is none.
        folder: PathBuf,
    },
}

/// `emitree new`.
#[derive(Args, Debug)]
pub(crate) struct NewArguments {
    /// The name of the new file; `.toml` is added to a name without an ending. `scene.toml` without a name.
    pub(crate) name: Option<PathBuf>,
    /// What the scene is of.
    #[arg(short, long, default_value = "first")]
    pub(crate) template: String,
    /// List the templates, and write nothing.
    #[arg(short, long)]
    pub(crate) list: bool,
}

/// `emitree check`: the options that change a scene are those of `render`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
pub(crate) struct CheckArguments {
    /// The scene file (TOML).
    pub(crate) scene: PathBuf,
    /// The most evaluations of the rehearsal; 0 for none, and no forecast.
    #[arg(long, value_name = "N", default_value_t = 20_000)]
    pub(crate) rehearsal: u64,

    #[command(flatten)]
    pub(crate) scene_options: SceneOptions,
    #[command(flatten)]
    pub(crate) running: Running,
}

/// `emitree compare`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
pub(crate) struct CompareArguments {
    /// The first image, .fits or .npy: differences are relative to its largest pixel.
    pub(crate) first: PathBuf,
    /// The second image, .fits or .npy, of as many pixels.
    pub(crate) second: PathBuf,
    /// The largest difference that is allowed, relative to the largest pixel of the first image: the exit
    /// code is 1 if it is larger somewhere.
    #[arg(short, long, value_name = "T")]
    pub(crate) tolerance: Option<f64>,
    /// Write a picture of the difference here; .png.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Print nothing.
    #[arg(short, long)]
    pub(crate) quiet: bool,
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

    /// Make the image or the cube row by row in little memory, from low-rank approximations of the emission, and
    /// write it to the one --output, .fits or .fits.gz. Those of `vol` that do not fit in the memory are made so
    /// without this option.
    #[arg(long)]
    pub(crate) by_rows: bool,

    /// Draw PNG outputs with axes, a title and a colour bar (frames of --progressive stay bare).
    #[arg(long)]
    pub(crate) annotate: bool,
    /// Draw colours on a logarithmic scale, down to 1e-3 of the largest pixel.
    #[arg(long, requires = "annotate")]
    pub(crate) log: bool,

    #[command(flatten)]
    pub(crate) scene_options: SceneOptions,
    #[command(flatten)]
    pub(crate) running: Running,
}

/// `emitree plan`: the first points of a rendering.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
pub(crate) struct PlanArguments {
    /// The scene file (TOML); it needs no [emission].
    pub(crate) scene: PathBuf,

    /// Write the points here; .npz, .npy or .csv.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Write the state of the run here; SCENE.state in this folder without it.
    #[arg(long, value_name = "FILE")]
    pub(crate) state: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) scene_options: SceneOptions,
    #[command(flatten)]
    pub(crate) running: Running,
}

/// `emitree resume`: outputs are those of `emitree render`.
#[derive(Args, Debug)]
#[command(allow_negative_numbers = true)]
pub(crate) struct ResumeArguments {
    #[command(flatten)]
    pub(crate) render: RenderArguments,

    /// The rates at the points, in their order; .npz with the array `rate`, .npy, or .csv with a column `rate`. May
    /// be repeated, for rates in parts. Without it the points are written again.
    #[arg(long, value_name = "FILE")]
    pub(crate) rates: Vec<PathBuf>,
    /// Write the next points here; .npz, .npy or .csv.
    #[arg(long, value_name = "FILE")]
    pub(crate) points: PathBuf,
    /// The state of the run; SCENE.state in this folder without it.
    #[arg(long, value_name = "FILE")]
    pub(crate) state: Option<PathBuf>,
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

    #[command(flatten)]
    limits: LimitOptions,
    #[command(flatten)]
    replaced: ReplacedKeys,
    #[command(flatten)]
    pub(crate) running: Running,
}

impl SweepArguments {
    /// The options that replace values of the scene; --set comes last.
    pub(crate) fn overrides(&self) -> Vec<Override> {
        self.limits.overrides().into_iter().chain(self.replaced.overrides()).collect()
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
    #[command(flatten)]
    options: BuildOptions,
    #[command(flatten)]
    replaced: ReplacedKeys,
    #[command(flatten)]
    pub(crate) running: Running,
}

impl BuildArguments {
    /// The options that replace values of the scene; --set comes last.
    pub(crate) fn overrides(&self) -> Vec<Override> {
        self.options.overrides().into_iter().chain(self.replaced.overrides()).collect()
    }
}
