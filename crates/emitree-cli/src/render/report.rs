//! The report of a rendering, for programs to read. Its keys are a contract.

use super::counts::{Counts, total};
use super::hint::nothing_in_view;
use super::rendered::Rendered;
use emitree::Method;
use emitree_instrument::StepSum;
use emitree_io::{Energies, Scene, SceneInstrument, peak_memory_bytes};
use serde::Serialize;

/// report.json.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    evaluations: u64,
    batches: u64,
    method: &'static str,
    tolerance: Option<f64>,
    estimated_error: Option<f64>,
    converged: bool,
    threshold: Option<f64>,
    order: Option<usize>,
    base_level: Option<u8>,
    smallest_feature: Option<f64>,
    leaves_per_level: Vec<usize>,
    seconds: Seconds,
    peak_memory_bytes: Option<u64>,
    image: ImageReport,
    energy: Option<EnergyReport>,
    energies: Option<usize>,
    instrument: Option<InstrumentReport>,
    hint: Option<String>,
    version: &'static str,
    scene: String,
    overrides: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Seconds {
    total: f64,
    emission: f64,
}

#[derive(Debug, Serialize)]
struct ImageReport {
    height: usize,
    width: usize,
    min: f64,
    max: f64,
    quantity: &'static str,
    unit: String,
}

#[derive(Debug, Serialize)]
struct EnergyReport {
    min: f64,
    max: f64,
    unit: String,
    bins: usize,
    scale: &'static str,
}

impl EnergyReport {
    fn new(energies: &Energies) -> Self {
        let axis = energies.axis();
        Self {
            min: axis.min(),
            max: axis.max(),
            unit: energies.unit_name().to_owned(),
            bins: axis.bins(),
            scale: energies.scale_name(),
        }
    }
}

#[derive(Debug, Serialize)]
struct InstrumentReport {
    exposure: f64,
    channels: usize,
    steps: Vec<StepReport>,
    expected_counts: f64,
    counts: Option<f64>,
    seed: u64,
}

#[derive(Debug, Serialize)]
struct StepReport {
    step: &'static str,
    before: f64,
    added: f64,
    lost: f64,
    after: f64,
}

impl InstrumentReport {
    fn new(counts: &Counts, instrument: &SceneInstrument) -> Self {
        Self {
            exposure: instrument.instrument.exposure_s,
            channels: counts.expected.bands().len(),
            steps: counts.steps.iter().map(StepReport::new).collect(),
            expected_counts: total(&counts.expected),
            counts: counts.drawn.as_ref().map(total),
            seed: instrument.seed,
        }
    }
}

impl StepReport {
    fn new(&StepSum { step, before, added, lost, after }: &StepSum) -> Self {
        let step = step.name();
        Self { step, before, added, lost, after }
    }
}

impl Report {
    pub(crate) fn new(scene: &Scene, rendered: &Rendered) -> Self {
        let (min, max) = rendered.map.cube().min_max();
        let order = match scene.render.method {
            Method::Paper(options) => Some(options.order),
            _ => None,
        };
        let tree = rendered.tree.as_ref();
        Self {
            evaluations: rendered.stats.evaluations,
            batches: rendered.stats.batches,
            method: scene.render.method.name(),
            tolerance: scene.render.tolerance,
            estimated_error: rendered.estimated_error(),
            converged: rendered.converged(),
            threshold: tree.map(|built| built.threshold),
            order,
            base_level: rendered.stats.base_level,
            smallest_feature: rendered.stats.smallest_feature,
            leaves_per_level: tree.map_or_else(Vec::new, |built| built.tree.leaves_per_level()),
            seconds: Seconds {
                total: rendered.stats.total_time.as_secs_f64(),
                emission: rendered.stats.emission_time.as_secs_f64(),
            },
            peak_memory_bytes: peak_memory_bytes(),
            image: ImageReport {
                height: scene.height,
                width: scene.width,
                min,
                max,
                quantity: scene.quantity.name(),
                unit: scene.image_unit().to_owned(),
            },
            energy: scene.energy.as_ref().map(EnergyReport::new),
            energies: rendered.energies(),
            instrument: rendered
                .counts
                .as_ref()
                .zip(scene.instrument.as_ref())
                .map(|(counts, instrument)| InstrumentReport::new(counts, instrument)),
            hint: nothing_in_view(rendered),
            version: env!("CARGO_PKG_VERSION"),
            scene: scene.name.clone(),
            overrides: scene.overrides.clone(),
        }
    }

    pub(crate) fn to_json(&self) -> Vec<u8> {
        // All keys are strings and all numbers finite or null, as JSON requires.
        let mut json = serde_json::to_vec_pretty(self).unwrap_or_default();
        json.push(b'\n');
        json
    }
}
