//! The runs behind the figures: eq. (8) on 64 × 64 pixels, by both methods of the paper.

use crate::failure::Failure;
use crate::interrupt;
use emitree::los::{LosOptions, Steps};
use emitree::refinement::Threshold;
use emitree::tree::BuildOptions;
use emitree::{Canonical, Image, Method, RenderOptions, render};
use emitree_models::models::Holmstrom;
use std::ops::ControlFlow;

const SHAPE: [usize; 2] = [64, 64];
/// The α of the paper.
const ALPHA: f64 = 100.0;

/// One rendering.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    pub(crate) method: String,
    /// The threshold ε, or the number of steps along each line.
    pub(crate) parameter: f64,
    pub(crate) evaluations: u64,
    /// The largest error over the largest pixel.
    pub(crate) error: f64,
}

/// All runs, each series from coarse to fine.
#[derive(Debug)]
pub(crate) struct Measurements {
    pub(crate) exact: Image,
    pub(crate) figure_9_image: Image,
    pub(crate) figure_9: Run,
    pub(crate) paper_4: Vec<Run>,
    pub(crate) paper_8: Vec<Run>,
    /// Uniform steps, by the number of lines for each pixel.
    pub(crate) los: Vec<(usize, Vec<Run>)>,
}

impl Measurements {
    pub(crate) fn make() -> Result<Self, Failure> {
        let exact = Holmstrom::with_alpha(ALPHA).exact_image(SHAPE);
        // The threshold of the prototype with which the design found the paper's 4,032.
        let (figure_9_image, figure_9) = paper(2, 0.038, &exact)?;
        // Five thresholds a decade, from 0.5 down.
        let sweep = |level, count: i32| -> Result<Vec<Run>, Failure> {
            let threshold = |i: i32| 0.5 * 10_f64.powf(-0.2 * f64::from(i));
            (0..count).map(|i| Ok(paper(level, threshold(i), &exact)?.1)).collect()
        };
        let steps = [4, 6, 8, 9, 10, 11, 12, 14, 16, 20, 24, 32, 48, 64];
        let los_series = |per_side: usize| -> Result<(usize, Vec<Run>), Failure> {
            let runs = steps.iter().map(|&steps| los(per_side, steps, &exact));
            Ok((per_side * per_side, runs.collect::<Result<_, _>>()?))
        };
        Ok(Self {
            paper_4: sweep(2, 16)?,
            paper_8: sweep(3, 18)?,
            los: [1, 2, 4].into_iter().map(los_series).collect::<Result<_, _>>()?,
            exact,
            figure_9_image,
            figure_9,
        })
    }

    /// The runs of the hierarchical method.
    pub(crate) fn paper(&self) -> impl Iterator<Item = &Run> {
        self.paper_4.iter().chain(&self.paper_8)
    }

    pub(crate) fn all(&self) -> impl Iterator<Item = &Run> {
        self.paper().chain(self.los.iter().flat_map(|(_, runs)| runs))
    }
}

fn paper(base_level: u8, threshold: f64, exact: &Image) -> Result<(Image, Run), Failure> {
    let options = BuildOptions::new(Threshold::Absolute(threshold)).with_base_level(base_level);
    let name = format!("paper, base grid {}^3", 1 << base_level);
    measure(Method::Paper(options), name, threshold, exact)
}

fn los(per_side: usize, steps: usize, exact: &Image) -> Result<Run, Failure> {
    let options = LosOptions::new(per_side, Steps::Fixed(steps));
    let name = format!("los, {} for each pixel", super::counted_lines(per_side * per_side));
    Ok(measure(Method::Los(options), name, steps as f64, exact)?.1)
}

fn measure(
    method: Method,
    name: String,
    parameter: f64,
    exact: &Image,
) -> Result<(Image, Run), Failure> {
    let stop =
        |_| if interrupt::requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let options = RenderOptions::new(method).with_progress(&stop);
    let rendering = render(&Holmstrom::with_alpha(ALPHA), &Canonical, SHAPE, &options)?;
    let (_, brightest) = exact.min_max();
    let error = rendering.values.max_difference(exact) / brightest;
    let run = Run { method: name, parameter, evaluations: rendering.stats.evaluations, error };
    Ok((rendering.values, run))
}
