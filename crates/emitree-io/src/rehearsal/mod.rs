//! A rehearsal of a rendering: a looser one of the same scene, from which the cost and what looks odd follow.

mod beyond;
mod grid_data;
mod lines;
mod outside;
mod remarks;
mod stage;

pub use remarks::Remark;

use crate::forecast::CostLaw;
use crate::scene::{EmissionFailure, Scene};
use emitree::progress::Progress;
use emitree::{Method, RenderError};
use stage::{Stage, StageEnd};
use std::time::Duration;

/// The forecast of a rendering, and what is odd about its scene.
///
/// ```
/// use emitree_io::{Rehearsal, Scene};
///
/// let text = r#"
///     emission.expression = "exp(-100 * ((x - 0.5)^2 + (y - 0.5)^2))"
///     projection.type = "canonical"
///     image = { width = 32, height = 16 }
///     render.tolerance = 1e-4
/// "#;
/// let scene = Scene::parse("example", text, &[])?;
/// let rehearsal = Rehearsal::of(&scene, 20_000, None)?;
/// let forecast = rehearsal.forecast.unwrap();
/// let rendered = scene.render(&scene.emission, &scene.render_options())?;
/// let true_cost = rendered.stats.evaluations;
/// assert!((forecast.range[0]..=forecast.range[1]).contains(&true_cost));
/// assert!(rehearsal.remarks.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Rehearsal {
    /// The evaluations that the rehearsal took.
    pub evaluations: u64,
    /// What was rendered, for people: "to 5 % of the largest pixel".
    pub how: String,
    /// The evaluations and the time of the rendering; none if the rehearsal has not come far enough.
    pub forecast: Option<Forecast>,
    /// What is odd, the worst first.
    pub remarks: Vec<Remark>,
}

/// What a rendering is expected to cost.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Forecast {
    /// Evaluations of the emission rate.
    pub evaluations: u64,
    /// From the fewest to the most that are to be expected, in nine of ten scenes.
    pub range: [u64; 2],
    /// The time, with as many threads as the rehearsal.
    pub time: Duration,
    /// Whether the rehearsal was the rendering itself, or counts exactly.
    pub is_exact: bool,
}

impl Rehearsal {
    /// Rehearses a scene with some `most` evaluations: `vol` to a looser tolerance, `paper` with larger thresholds,
    /// `los` with fewer pixels. With 0 there are the remarks that need none. `progress` is called after each call
    /// of g; it may break.
    ///
    /// # Errors
    ///
    /// As [`Scene::render`].
    pub fn of(
        scene: &Scene,
        most: u64,
        progress: Option<&Progress<'_>>,
    ) -> Result<Self, RenderError<EmissionFailure>> {
        let mut remarks = remarks::of_settings(scene);
        remarks.extend(grid_data::remark(scene));
        if most == 0 {
            let how = "none".to_owned();
            return Ok(Self { evaluations: 0, how, forecast: None, remarks });
        }
        let (mut spent, mut law, mut forecast, mut last) = (0, None::<CostLaw>, None, None);
        for stage in Stage::all(scene) {
            // The first stage has all evaluations, a further one must be expected to be cheap.
            let left = most.saturating_sub(spent);
            let expected = law.map(|law| law.evaluations_for(stage.looseness));
            if expected.is_some_and(|expected| expected > left / 2) {
                break;
            }
            let run = stage.run(scene, left, progress)?;
            spent += run.evaluations;
            match &run.end {
                StageEnd::Ended(_) => {
                    let needed = stage.whole(run.evaluations);
                    law = match law {
                        Some(law) => law.and(needed, stage.looseness),
                        None => CostLaw::from(needed, stage.looseness),
                    };
                    let law = law.or_else(|| CostLaw::from(needed.max(1), stage.looseness));
                    forecast = law.map(|law| stage.forecast(scene, law, &run, needed));
                }
                StageEnd::Cut => {
                    forecast = forecast.or_else(|| stage.forecast_of_cut(scene, &run));
                }
            }
            let is_cut = matches!(run.end, StageEnd::Cut);
            if !is_cut || last.is_none() {
                last = Some((stage, run));
            }
            if is_cut {
                break;
            }
        }
        let Some((stage, run)) = last else {
            return Ok(Self { evaluations: 0, how: "none".to_owned(), forecast, remarks });
        };
        let how = stage.how(scene, &run);
        if let StageEnd::Ended(rendering) = &run.end {
            remarks.extend(remarks::of_image(scene, rendering));
            for search in [outside::remark, beyond::remark] {
                let left = most.saturating_sub(spent);
                if let Some((remark, evaluations)) = search(scene, rendering, left) {
                    remarks.extend(remark);
                    spent += evaluations;
                }
            }
        }
        if let Some(forecast) = &forecast {
            remarks.extend(remarks::of_forecast(scene, forecast));
        }
        Ok(Self { evaluations: spent, how, forecast, remarks })
    }
}

/// The method of a scene, if it is `vol`.
fn vol_of(scene: &Scene) -> Option<&emitree::VolOptions> {
    match &scene.render.method {
        Method::Vol(vol) => Some(vol),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
