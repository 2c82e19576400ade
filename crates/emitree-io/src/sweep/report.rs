//! The report of a sweep, for programs to read. Its keys are a contract.

use super::SceneSweep;
use crate::report::Report;
use serde::{Serialize, Serializer};
use std::path::PathBuf;

/// The report of all images of a sweep.
#[derive(Clone, Debug, Serialize)]
pub struct SweepReport {
    keys: Vec<String>,
    evaluations: u64,
    converged: bool,
    images: Vec<SweptImage>,
}

/// What was made of one image.
#[derive(Clone, Debug, Serialize)]
pub struct SweptImage {
    /// The value of each key, in their order.
    pub values: Vec<f64>,
    /// How often g was evaluated for it, with what was tried and with the finer points that serve others.
    pub evaluations: u64,
    /// The largest estimated error of a pixel over the largest pixel, if there is one.
    pub estimated_error: Option<f64>,
    /// Whether the tolerance was met.
    pub converged: bool,
    /// The exit code that a rendering of this image alone has.
    pub exit_code: u8,
    /// Why there is no image.
    pub error: Option<String>,
    /// The files, if there is an image.
    pub outputs: Vec<PathBuf>,
    /// The report of the rendering, as of `emitree render`.
    #[serde(serialize_with = "as_json")]
    pub report: Option<String>,
}

impl SweptImage {
    /// An image with its rendering.
    pub fn new(
        values: Vec<f64>,
        exit_code: u8,
        report: &Report<'_>,
        outputs: Vec<PathBuf>,
    ) -> Self {
        Self {
            values,
            evaluations: report.evaluations(),
            estimated_error: report.estimated_error(),
            converged: report.converged(),
            exit_code,
            error: None,
            outputs,
            report: Some(report.to_json()),
        }
    }

    /// An image that could not be made.
    pub fn failed(values: Vec<f64>, exit_code: u8, error: String) -> Self {
        let (evaluations, estimated_error, converged) = (0, None, false);
        let (error, outputs, report) = (Some(error), Vec::new(), None);
        Self { values, evaluations, estimated_error, converged, exit_code, error, outputs, report }
    }
}

/// A text of JSON as the value that it stands for.
fn as_json<S: Serializer>(text: &Option<String>, serializer: S) -> Result<S::Ok, S::Error> {
    let value = text.as_ref().and_then(|text| serde_json::from_str(text).ok());
    serde_json::Value::serialize(&value.unwrap_or(serde_json::Value::Null), serializer)
}

impl SweepReport {
    /// The report of all images of a sweep, in their order; `evaluations` are those of all.
    pub fn new(sweep: &SceneSweep, evaluations: u64, images: Vec<SweptImage>) -> Self {
        let keys = sweep.keys().iter().map(|key| key.name().to_owned()).collect();
        let converged = images.iter().all(|image| image.converged);
        Self { keys, evaluations, converged, images }
    }

    /// The keys, in their order.
    pub fn keys(&self) -> &[String] {
        &self.keys
    }

    /// How often g was evaluated for all images.
    pub fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// The images, in the order of their numbers.
    pub fn images(&self) -> &[SweptImage] {
        &self.images
    }

    /// The report as JSON, with a newline at the end.
    pub fn to_json(&self) -> String {
        // All keys are strings and all numbers finite or null, as JSON requires.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}
