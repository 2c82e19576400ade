//! `[render]`: the method and its options, as the library takes them.

use super::document::{Node, Place, Value};
use super::error::SceneError;
use super::table::Table;
use emitree::quadrature::CellRule;
use emitree::tree::BuildOptions;
use emitree::{DEFAULT_MAX_EVALUATIONS, LosOptions, Method, Steps, Threshold};
use std::sync::Arc;

/// How a scene is rendered.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RenderSettings {
    /// The method with its options.
    pub method: Method,
    /// The image error asked for, relative to the largest pixel, where the method keeps one.
    pub tolerance: Option<f64>,
    /// The largest number of evaluations.
    pub max_evaluations: u64,
}

impl RenderSettings {
    /// The method's name, as scenes write it.
    pub fn method_name(&self) -> &'static str {
        match self.method {
            Method::Paper(_) => "paper",
            Method::Los(_) => "los",
            _ => "vol",
        }
    }
}

const METHODS: &str = "`paper` or `los`";

pub(super) fn read(table: Option<Table>, whole: &Place) -> Result<RenderSettings, SceneError> {
    let Some(mut table) = table else { return Err(no_vol(whole)) };
    let method = table.text("method")?;
    let tolerance = table.take("tolerance");
    let max_evaluations = table.take("max_evaluations");
    let order = table.count("order", "1, 3, 5, 7 or 9")?;
    let base_level = table.count("base_level", "1 to 10")?;
    let finest_level = table.count("finest_level", "a level above `base_level`")?;
    let rule = table.text("rule")?;
    let threshold = table.take("threshold");
    let lines = table.count("lines", "a number of lines along each side of a pixel, 1 or more")?;
    let steps = table.take("steps");
    let place = table.place().clone();
    table.finish()?;

    if let Some(node) = &tolerance
        && node.number()? <= 0.0
    {
        return Err(node.refuse(&node.number()?.to_string(), "a fraction above 0, as in 0.01"));
    }
    let budget = |node: &Node| match node.count("a number of evaluations, 1 or more")? {
        0 => Err(node.refuse("0", "a number of evaluations, 1 or more")),
        budget => Ok(budget),
    };
    let max_evaluations = max_evaluations.as_ref().map_or(Ok(DEFAULT_MAX_EVALUATIONS), budget)?;
    let defaults = BuildOptions::default();
    let build_options = BuildOptions {
        order: order.unwrap_or(defaults.order),
        base_level: base_level.unwrap_or(defaults.base_level),
        rule: rule.map_or(Ok(defaults.rule), |rule| cell_rule(&rule))?,
        threshold: threshold.map_or(Ok(defaults.threshold), |node| read_threshold(&node))?,
        finest_level,
    };
    let (name, place) = method.unwrap_or_else(|| ("vol".to_owned(), place));
    let (method, tolerance) = match name.as_str() {
        "vol" => return Err(no_vol(&place)),
        "paper" => (Method::Paper(build_options), None),
        "los" => {
            let steps = line_steps(tolerance.as_ref(), steps.as_ref())?;
            let tolerance = match steps {
                Steps::Adaptive(tolerance) => Some(tolerance),
                Steps::Fixed(_) => None,
            };
            (Method::Los(LosOptions { lines: lines.unwrap_or(1), steps }), tolerance)
        }
        unknown => {
            return Err(SceneError::at(&place, format!("unknown method `{unknown}`"))
                .label(format!("expected {METHODS}")));
        }
    };
    Ok(RenderSettings { method, tolerance, max_evaluations })
}

fn no_vol(place: &Place) -> SceneError {
    SceneError::at(place, "the method `vol` (the default) is not available in this version")
        .label(format!("expected `method` = {METHODS} here"))
        .help("choose one in `[render]`, or with --method")
}

fn cell_rule((name, place): &(String, Place)) -> Result<CellRule, SceneError> {
    match name.as_str() {
        "midpoint" => Ok(CellRule::Midpoint),
        "simpson" => Ok(CellRule::Simpson),
        unknown => Err(SceneError::at(place, format!("unknown cell rule `{unknown}`"))
            .label("expected `midpoint` or `simpson`")),
    }
}

/// A number is in the units of g; a string that ends in `%` is of the largest cell average.
fn read_threshold(node: &Node) -> Result<Threshold, SceneError> {
    const EXPECTED: &str = "a size above 0 in the units of g, or a string such as \"1%\"";
    let threshold = match &node.value {
        Value::Text(text) => {
            let refuse = || node.refuse(&format!("\"{text}\""), EXPECTED);
            match text.trim().strip_suffix('%') {
                Some(percent) => {
                    let percent: f64 = percent.trim().parse().map_err(|_| refuse())?;
                    Threshold::Relative(percent / 100.0)
                }
                None => Threshold::Absolute(text.trim().parse().map_err(|_| refuse())?),
            }
        }
        _ => Threshold::Absolute(node.number()?),
    };
    let (Threshold::Absolute(size) | Threshold::Relative(size)) = threshold;
    if size > 0.0 && size.is_finite() {
        Ok(threshold)
    } else {
        Err(node.refuse(&size.to_string(), EXPECTED))
    }
}

/// Equal steps or adaptive ones; where both are given, what was said last counts, and the command
/// line is later than the scene.
fn line_steps(tolerance: Option<&Node>, steps: Option<&Node>) -> Result<Steps, SceneError> {
    let count = |node: &Node| node.count("a number of steps along each line, 1 or more");
    match (tolerance, steps) {
        (None, None) => Ok(LosOptions::default().steps),
        (None, Some(steps)) => Ok(Steps::Fixed(count(steps)?)),
        (Some(tolerance), None) => Ok(Steps::Adaptive(tolerance.number()?)),
        (Some(tolerance), Some(steps)) => {
            let by_option = |node: &Node| super::is_option(&node.place.source);
            match (by_option(tolerance), by_option(steps)) {
                (true, false) => Ok(Steps::Adaptive(tolerance.number()?)),
                (false, true) => Ok(Steps::Fixed(count(steps)?)),
                _ => {
                    let same = Arc::ptr_eq(&tolerance.place.source, &steps.place.source);
                    let place = if same { &steps.place } else { &tolerance.place };
                    Err(SceneError::at(place, "both `tolerance` and `steps` are given")
                        .label("expected one of them: adaptive or equal steps along each line"))
                }
            }
        }
    }
}
