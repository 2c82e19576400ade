//! Where the time of a rendering goes: how much of it is the emission, and what the rest is for each
//! evaluation.

use crate::heap::measured;
use crate::table::{Table, mebibytes, number};
use emitree::los::{LosOptions, Steps};
use emitree::refinement::Threshold;
use emitree::tree::BuildOptions;
use emitree::{Canonical, FromFn, Method, RenderOptions, VolOptions, render};
use emitree_problems::catalogue::{Problem, problem};
use emitree_problems::relative_error;

const SCENES: [&str; 6] = ["eq8", "shell", "shock", "beta", "gaussians", "nebula"];
const TOLERANCES: [f64; 2] = [0.01, 0.001];
const SHAPE: [usize; 2] = [128, 128];
/// Ends the refinement of `vol` and `paper`: that of the latter does not end by itself where g jumps.
const MAX_EVALUATIONS: u64 = 1_000_000;
/// The fastest of so many runs counts.
const RUNS: usize = 3;
/// A run that takes longer is the last one \[s\].
const LONG_S: f64 = 0.3;

/// One core each: what is done for an evaluation, not how it is divided among threads.
pub(crate) fn tables() -> Result<Vec<Table>, String> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.map_err(|error| error.to_string())?;
    let rows = pool.install(|| {
        let problems = SCENES.into_iter().filter_map(problem).collect::<Vec<_>>();
        problems.iter().map(rows_of).collect::<Result<Vec<_>, String>>()
    })?;
    Ok(vec![Table {
        title: "Where the time of a rendering goes",
        columns: vec![
            "scene",
            "method",
            "tolerance",
            "error",
            "evaluations",
            "total s",
            "emission s",
            "own ns per evaluation",
            "peak MiB",
            "allocations per evaluation",
            "done",
        ],
        rows: rows.into_iter().flatten().collect(),
    }])
}

/// The methods with a tolerance: for `paper` it bounds the details that are dropped, for `los` the
/// error along each line, of which there is one for a pixel.
fn methods(tolerance: f64) -> [Method; 3] {
    let threshold = Threshold::Relative(tolerance);
    [
        Method::Vol(VolOptions::new(tolerance)),
        Method::Paper(BuildOptions::new(threshold)),
        Method::Los(LosOptions::new(1, Steps::Adaptive(tolerance))),
    ]
}

fn rows_of(problem: &Problem) -> Result<Vec<Vec<String>>, String> {
    let exact = problem.exact_image(SHAPE);
    let emission = FromFn(|position, _| problem.rate(position));
    let mut rows = Vec::new();
    for tolerance in TOLERANCES {
        for method in methods(tolerance) {
            let mut options = RenderOptions::new(method.clone());
            if !matches!(method, Method::Los(_)) {
                options.max_evaluations = MAX_EVALUATIONS;
            }
            let mut best = None;
            for _ in 0..RUNS {
                let (rendering, taken) =
                    measured(|| render(&emission, &Canonical, SHAPE, &options));
                let rendering = rendering.map_err(|error| error.to_string())?;
                let long = rendering.stats.total_time.as_secs_f64() > LONG_S;
                best = match best {
                    Some((fastest, of_fastest)) if own_s(&fastest) <= own_s(&rendering) => {
                        Some((fastest, of_fastest))
                    }
                    _ => Some((rendering, taken)),
                };
                if long {
                    break;
                }
            }
            let Some((rendering, taken)) = best else { continue };
            let evaluations = rendering.stats.evaluations as f64;
            rows.push(vec![
                problem.name.clone(),
                method.name().to_owned(),
                tolerance.to_string(),
                number(relative_error(&rendering.values, &exact)),
                rendering.stats.evaluations.to_string(),
                number(rendering.stats.total_time.as_secs_f64()),
                number(rendering.stats.emission_time.as_secs_f64()),
                number(own_s(&rendering) / evaluations * 1e9),
                mebibytes(taken.peak_bytes),
                number(taken.allocations as f64 / evaluations),
                if rendering.converged() { "yes" } else { "no" }.to_owned(),
            ]);
        }
    }
    Ok(rows)
}

/// Time that is not the emission's \[s\].
fn own_s(rendering: &emitree::Rendering) -> f64 {
    (rendering.stats.total_time - rendering.stats.emission_time).as_secs_f64()
}
