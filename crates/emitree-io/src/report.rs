//! The report of a rendering, for programs to read. Its keys are a contract.

use crate::account::{Account, Bins, Exposed, SumAccount};
use emitree::Cube;
use emitree_instrument::StepSum;
use serde::{Serialize, Serializer};

/// report.json, and the report of a rendering in Python.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report<'a> {
    evaluations: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    absorption_evaluations: Option<u64>,
    batches: u64,
    method: &'a str,
    tolerance: Option<f64>,
    rtol: Option<f64>,
    atol: Option<f64>,
    floor: Option<f64>,
    weighted: bool,
    per_band: bool,
    estimated_error: Option<f64>,
    error_over_allowed: Option<f64>,
    data_error: Option<f64>,
    converged: bool,
    ending: &'a str,
    threshold: Option<f64>,
    order: Option<usize>,
    base_level: Option<u8>,
    smallest_feature: Option<f64>,
    line_steps: Option<usize>,
    leaves_per_level: &'a [usize],
    seconds: Seconds,
    peak_memory_bytes: Option<u64>,
    image: ImageReport<'a>,
    #[serde(serialize_with = "by_name")]
    sums: &'a [SumAccount],
    energy: Option<&'a Bins>,
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<&'a Exposed>,
    energies: Option<usize>,
    instrument: Option<CountsReport>,
    hint: Option<String>,
    version: &'a str,
    scene: &'a str,
    overrides: &'a [String],
    ignored: &'a [String],
}

/// Sums as a table whose keys are their names.
fn by_name<S: Serializer>(sums: &&[SumAccount], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(sums.iter().map(|sum| (&sum.name, sum)))
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct Seconds {
    total: f64,
    emission: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct ImageReport<'a> {
    height: usize,
    width: usize,
    min: f64,
    max: f64,
    quantity: &'a str,
    unit: &'a str,
}

/// The counts of an instrument in a report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CountsReport {
    exposure: Option<f64>,
    channels: usize,
    steps: Vec<StepReport>,
    expected_counts: f64,
    counts: Option<f64>,
    seed: Option<u64>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct StepReport {
    step: &'static str,
    before: f64,
    added: f64,
    lost: f64,
    after: f64,
}

impl From<&StepSum> for StepReport {
    fn from(&StepSum { step, before, added, lost, after }: &StepSum) -> Self {
        Self { step: step.name(), before, added, lost, after }
    }
}

impl CountsReport {
    /// Of expected counts, and of those that were drawn from them, if any were.
    pub fn new(
        account: &Account,
        expected: &Cube,
        drawn: Option<&Cube>,
        steps: &[StepSum],
    ) -> Self {
        Self {
            exposure: account.exposure_s,
            channels: expected.bands().len(),
            steps: steps.iter().map(StepReport::from).collect(),
            expected_counts: total(expected),
            counts: drawn.map(total),
            seed: account.seed,
        }
    }
}

/// The sum of a map over all bands, and over the pixels in the field.
fn total(map: &Cube) -> f64 {
    map.voxels().filter(|count| !count.is_nan()).sum()
}

/// The report of several components: what all of them have together, and the report of each under its name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComponentsReport<'a> {
    #[serde(flatten)]
    all: Report<'a>,
    #[serde(serialize_with = "reports_by_name")]
    components: Vec<(&'a str, Report<'a>)>,
}

/// Reports as a table whose keys are the names of their components, in their order.
fn reports_by_name<S: Serializer>(
    components: &[(&str, Report<'_>)],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_map(components.iter().map(|(name, report)| (name, report)))
}

impl<'a> ComponentsReport<'a> {
    pub(crate) fn new(all: Report<'a>, components: Vec<(&'a str, Report<'a>)>) -> Self {
        Self { all, components }
    }

    /// The report as JSON, with a newline at the end.
    pub fn to_json(&self) -> String {
        // All keys are strings and all numbers finite or null, as JSON requires.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}

impl<'a> Report<'a> {
    pub(crate) fn new(
        account: &'a Account,
        [height, width]: [usize; 2],
        [min, max]: [f64; 2],
        instrument: Option<CountsReport>,
        hint: Option<String>,
    ) -> Self {
        Self {
            evaluations: account.evaluations,
            absorption_evaluations: account.absorption_evaluations,
            batches: account.batches,
            method: &account.method,
            tolerance: account.tolerance,
            rtol: account.by_pixel.map(|of| of.rtol).filter(|rtol| *rtol > 0.0),
            atol: account.by_pixel.map(|of| of.atol).filter(|atol| *atol > 0.0),
            floor: account.by_pixel.filter(|of| of.rtol > 0.0).map(|of| of.floor),
            weighted: account.is_weighted,
            per_band: account.per_band,
            estimated_error: account.estimated_error,
            error_over_allowed: account.error_over_allowed,
            data_error: account.data_error,
            converged: account.converged(),
            ending: &account.ending,
            threshold: account.threshold,
            order: account.order,
            base_level: account.base_level,
            smallest_feature: account.smallest_feature,
            line_steps: account.line_steps,
            leaves_per_level: &account.leaves_per_level,
            seconds: Seconds { total: account.total_seconds, emission: account.emission_seconds },
            peak_memory_bytes: account.peak_memory_bytes,
            image: ImageReport {
                height,
                width,
                min,
                max,
                quantity: &account.quantity,
                unit: &account.unit,
            },
            sums: &account.sums,
            energy: account.bins.as_ref().filter(|_| account.exposed.is_none()),
            time: account.exposed.as_ref(),
            energies: account.energies,
            instrument,
            hint,
            version: &account.version,
            scene: &account.scene,
            overrides: &account.overrides,
            ignored: &account.ignored,
        }
    }

    /// How often g was evaluated.
    pub fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// The largest estimated error of a pixel over the largest pixel, if there is one.
    pub fn estimated_error(&self) -> Option<f64> {
        self.estimated_error
    }

    /// Whether the tolerance was met.
    pub fn converged(&self) -> bool {
        self.converged
    }

    /// The report as JSON, with a newline at the end.
    pub fn to_json(&self) -> String {
        // All keys are strings and all numbers finite or null, as JSON requires.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}
