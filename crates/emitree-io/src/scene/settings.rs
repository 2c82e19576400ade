//! `[render]`: the method and its options, as the library takes them.

use super::accuracy::{Accuracy, RenderedView};
use super::document::{Node, Value};
use super::error::SceneError;
use super::feature;
use super::source::Place;
use super::sums::{self, SceneSum};
use super::table::Table;
use emitree::cell::CellIndex;
use emitree::los::{LosOptions, Steps};
use emitree::prediction::{MAX_ORDER, Predictor};
use emitree::quadrature::CellRule;
use emitree::refinement::Threshold;
use emitree::tree::BuildOptions;
use emitree::vol::{BASE_LEVELS, Minimize, Seed};
use emitree::{Method, VolOptions};
use std::ops::RangeInclusive;
use std::sync::Arc;

/// How a scene is rendered.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RenderSettings {
    /// The method with its options.
    pub method: Method,
    /// The tolerance, relative to the largest pixel, where the method has one.
    pub tolerance: Option<f64>,
    /// The largest number of evaluations; the method's default if it is not given.
    pub max_evaluations: Option<u64>,
    /// The longest time that the rendering may take \[s\]; no limit if it is not given.
    pub max_seconds: Option<f64>,
    /// The largest number of evaluations in one batch; no limit if it is not given.
    pub batch_size: Option<u64>,
    /// The number of batches that is aimed at; as few evaluations as possible if it is not given.
    pub rounds: Option<u32>,
    /// Sums over regions, in the order of those of the method.
    pub sums: Vec<SceneSum>,
    /// Options that the scene or the command line has and the method has not.
    pub ignored: Vec<&'static str>,
}

const METHODS: &str = "`vol`, `paper` or `los`";

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Vol,
    Paper,
    Los,
}

/// `line_energies` are in the unit of the energy axis.
pub(super) fn read(
    mut table: Table,
    seeds: Vec<Seed>,
    line_energies: Vec<f64>,
    view: &RenderedView<'_>,
) -> Result<RenderSettings, SceneError> {
    let kind = match table.text("method")? {
        None => Kind::Vol,
        Some(name) => kind_of_name(&name)?,
    };
    let max_evaluations = table.take("max_evaluations");
    let max_seconds = table.take("max_seconds");
    let batch_size = table.take("batch_size");
    let rounds = table.take("rounds");
    let smallest_feature = table.take("smallest_feature");
    let tolerance = table.take("tolerance");
    let accuracy = Accuracy::take(&mut table);
    let sums = table.take("sums");
    let base_level = table.take("base_level");
    let minimize = table.take("minimize");
    let of_trees = ["order", "finest_level", "rule", "threshold"].map(|key| (key, table.take(key)));
    let of_lines = ["lines", "steps"].map(|key| (key, table.take(key)));
    table.finish()?;

    let max_evaluations = max_evaluations
        .map(|node| at_least_one(&node, "a number of evaluations, 1 or more"))
        .transpose()?;
    let max_seconds = max_seconds.map(|node| seconds(&node)).transpose()?;
    let smallest_feature =
        smallest_feature.map(|node| feature::read(node, view.length_unit)).transpose()?;
    let batch_size = batch_size
        .map(|node| at_least_one(&node, "a number of evaluations in a batch, 1 or more"))
        .transpose()?;
    let rounds =
        rounds.map(|node| at_least_one(&node, "a number of rounds, 1 or more")).transpose()?;
    if let Some(node) = &tolerance {
        check_tolerance(node, kind, sums.is_some())?;
    }
    if let (Some(node), Kind::Paper | Kind::Los) = (&sums, kind) {
        return Err(SceneError::at(&node.place, "`render.sums` is given")
            .label("expected none, or method `vol`: the others have no errors of sums"));
    }
    let base_levels = match kind {
        Kind::Vol => BASE_LEVELS,
        Kind::Paper | Kind::Los => 1..=BuildOptions::deepest_base_level::<3>(),
    };
    let base_level = base_level.map(|node| level(&node, base_levels)).transpose()?;
    let minimize = minimize.map(|node| minimized(&node.text()?)).transpose()?;
    let build_options = build_options(base_level, &of_trees)?;
    // Where the tolerance is not one of lines, it does not contradict uniform steps.
    let of_line = tolerance.as_ref().filter(|_| kind == Kind::Los);
    let los_options = los_options(&of_lines, of_line)?;

    let given = |options: &[(&'static str, Option<Node>)]| -> Vec<&'static str> {
        options.iter().filter(|(_, node)| node.is_some()).map(|(key, _)| *key).collect()
    };
    let mut ignored = Vec::new();
    let has_seeds = !seeds.is_empty();
    let (sums, of_method) =
        sums.map_or_else(|| Ok(Default::default()), |node| sums::read(node, view))?;
    let (method, tolerance) = match kind {
        Kind::Vol => {
            ignored.extend(given(&of_trees));
            ignored.extend(given(&of_lines));
            let mut options = VolOptions::default();
            if let Some(node) = &tolerance {
                options.tolerance = node.number()?;
            }
            accuracy.set(&mut options, tolerance.as_ref(), view)?;
            options.sums = of_method;
            options.base_level = base_level.unwrap_or(options.base_level);
            options.smallest_feature = smallest_feature;
            options.minimize = minimize.unwrap_or_default();
            options.seeds = seeds;
            options.line_energies = line_energies;
            let tolerance = options.by_pixel.is_none().then_some(options.tolerance);
            (Method::Vol(options), tolerance)
        }
        Kind::Paper => {
            ignored.extend(given(&of_lines));
            ignored.extend(tolerance.map(|_| "tolerance"));
            ignored.extend(accuracy.given());
            (Method::Paper(build_options), None)
        }
        Kind::Los => {
            ignored.extend(base_level.map(|_| "base_level"));
            ignored.extend(given(&of_trees));
            ignored.extend(accuracy.given());
            let tolerance = match los_options.steps {
                Steps::Adaptive(tolerance) => Some(tolerance),
                Steps::Fixed(_) => None,
            };
            (Method::Los(los_options), tolerance)
        }
    };
    if kind != Kind::Vol {
        ignored.extend(smallest_feature.map(|_| "smallest_feature"));
        ignored.extend(minimize.map(|_| "minimize"));
        ignored.extend(has_seeds.then_some("seed"));
    }
    Ok(RenderSettings {
        method,
        tolerance,
        max_evaluations,
        max_seconds,
        batch_size,
        rounds,
        sums,
        ignored,
    })
}

fn kind_of_name((name, place): &(String, Place)) -> Result<Kind, SceneError> {
    match name.as_str() {
        "vol" => Ok(Kind::Vol),
        "paper" => Ok(Kind::Paper),
        "los" => Ok(Kind::Los),
        unknown => Err(SceneError::at(place, format!("unknown method `{unknown}`"))
            .label(format!("expected {METHODS}"))),
    }
}

fn seconds(node: &Node) -> Result<f64, SceneError> {
    let seconds = node.number()?;
    if seconds > 0.0 {
        Ok(seconds)
    } else {
        Err(node.refuse(&seconds.to_string(), "a time in seconds above 0"))
    }
}

fn check_tolerance(node: &Node, kind: Kind, has_sums: bool) -> Result<(), SceneError> {
    let tolerance = node.number()?;
    let (fits, expected) = match kind {
        Kind::Vol if has_sums => {
            (tolerance > 0.0 && tolerance <= 1.0, "a fraction above 0, at most 1")
        }
        Kind::Vol => {
            (tolerance > 0.0 && tolerance < 1.0, "a fraction above 0 and below 1, as in 0.01")
        }
        Kind::Paper | Kind::Los => (tolerance > 0.0, "a fraction above 0, as in 0.01"),
    };
    if fits { Ok(()) } else { Err(node.refuse(&tolerance.to_string(), expected)) }
}

fn level(node: &Node, levels: RangeInclusive<u8>) -> Result<u8, SceneError> {
    let expected = format!("a level from {} to {}", levels.start(), levels.end());
    let level: u8 = node.count(&expected)?;
    if levels.contains(&level) {
        Ok(level)
    } else {
        Err(node.refuse(&level.to_string(), &expected))
    }
}

/// Options of the tree, checked here so that an error has its place.
fn build_options(
    base_level: Option<u8>,
    [order, finest_level, rule, threshold]: &[(&'static str, Option<Node>); 4],
) -> Result<BuildOptions, SceneError> {
    let mut options = BuildOptions::default();
    if let (_, Some(node)) = order {
        let expected = format!("an odd number from 1 to {MAX_ORDER}");
        options.order = node.count(&expected)?;
        if Predictor::new(options.order).is_err() {
            return Err(node.refuse(&options.order.to_string(), &expected));
        }
    }
    options.base_level = base_level.unwrap_or(options.base_level);
    if let (_, Some(node)) = finest_level {
        let above = options.base_level + 1;
        options.finest_level = Some(level(node, above..=CellIndex::<3>::MAX_LEVEL)?);
    }
    if let (_, Some(node)) = rule {
        options.rule = cell_rule(&node.text()?)?;
    }
    if let (_, Some(node)) = threshold {
        options.threshold = read_threshold(node)?;
    }
    Ok(options)
}

fn los_options(
    [lines, steps]: &[(&'static str, Option<Node>); 2],
    tolerance: Option<&Node>,
) -> Result<LosOptions, SceneError> {
    let mut options = LosOptions::default();
    if let (_, Some(node)) = lines {
        options.lines =
            at_least_one(node, "a number of lines along each side of a pixel, 1 or more")?;
    }
    let (_, steps) = steps;
    options.steps = line_steps(tolerance, steps.as_ref())?;
    Ok(options)
}

fn at_least_one<T: TryFrom<i64> + Default + PartialEq>(
    node: &Node,
    expected: &str,
) -> Result<T, SceneError> {
    let count = node.count(expected)?;
    if count == T::default() { Err(node.refuse("0", expected)) } else { Ok(count) }
}

fn minimized((name, place): &(String, Place)) -> Result<Minimize, SceneError> {
    match name.as_str() {
        "evaluations" => Ok(Minimize::Evaluations),
        "time" => Ok(Minimize::Time),
        unknown => Err(SceneError::at(place, format!("`render.minimize` is \"{unknown}\""))
            .label("expected `evaluations` or `time`")),
    }
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

/// Uniform or adaptive steps; where both are given, the later one counts, and the command
/// line is later than the scene.
fn line_steps(tolerance: Option<&Node>, steps: Option<&Node>) -> Result<Steps, SceneError> {
    let count = |node: &Node| at_least_one(node, "a number of steps along each line, 1 or more");
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
                        .label("expected one of them: adaptive or uniform steps along each line"))
                }
            }
        }
    }
}
