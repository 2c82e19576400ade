//! `emission.expressions`: several emission rates at each point, each of which has an image of its own.

use super::super::document::{Node, Value};
use super::super::error::SceneError;
use super::super::source::Place;
use super::super::table::Table;
use super::{Spectrum, parse_expression, place_in, refuse_unused};
use emitree::Samples;
use emitree_models::expression::Expressions;
use std::collections::{BTreeSet, HashMap};
use std::sync::{Arc, PoisonError, RwLock};

/// The most components: keywords of FITS have room for their numbers.
const MOST_COMPONENTS: usize = 999;

/// The most points whose rates are kept: some 300 MB with their places in a hash table. Rates at further points
/// are evaluated again for each component.
const MOST_KNOWN_POINTS: usize = 1 << 21;

/// The rates of all components of a scene, by expressions of the same constants.
///
/// All components of a point are evaluated together when one of them is asked for, and kept: a point that the
/// images of several components need is evaluated once.
#[derive(Debug)]
pub struct ComponentRates {
    expressions: Expressions,
    names: Vec<String>,
    known: RwLock<KnownRates>,
}

/// The bits of a point: position, direction, and energy if there is an axis.
type Point = [u64; 7];

#[derive(Debug, Default)]
struct KnownRates {
    /// The row of each point.
    rows: HashMap<Point, usize>,
    /// The rates of all components, row by row.
    rates: Vec<f64>,
    evaluations: u64,
}

impl ComponentRates {
    /// The names of the components.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The expressions as they were given.
    pub fn texts(&self) -> &[String] {
        self.expressions.texts()
    }

    /// At how many points all components were evaluated.
    pub fn evaluations(&self) -> u64 {
        self.known.read().unwrap_or_else(PoisonError::into_inner).evaluations
    }

    /// The same expressions without any known rates.
    pub(in crate::scene) fn anew(&self) -> Self {
        let (expressions, names) = (self.expressions.clone(), self.names.clone());
        Self { expressions, names, known: RwLock::default() }
    }

    /// Writes the rates of one component at some samples.
    pub(super) fn of(&self, component: usize, samples: &Samples<'_>, rates: &mut [f64]) {
        let count = self.names.len();
        let points: Vec<Point> = (0..samples.len()).map(|at| point(samples, at)).collect();
        let mut new = Vec::new();
        {
            let known = self.known.read().unwrap_or_else(PoisonError::into_inner);
            for (at, point) in points.iter().enumerate() {
                match known.rows.get(point) {
                    Some(row) => rates[at] = known.rates[row * count + component],
                    None => new.push(at),
                }
            }
        }
        if new.is_empty() {
            return;
        }
        let positions: Vec<[f64; 3]> = new.iter().map(|&at| samples.positions()[at]).collect();
        let directions: Vec<[f64; 3]> = new.iter().map(|&at| samples.directions()[at]).collect();
        let energies: Vec<f64> =
            new.iter().filter_map(|&at| samples.energies().get(at).copied()).collect();
        let mut found = vec![0.0; new.len() * count];
        let of_new = Samples::new(&positions, &directions).at_energies(&energies);
        self.expressions.rates(&of_new, &mut found);
        let mut known = self.known.write().unwrap_or_else(PoisonError::into_inner);
        let KnownRates { rows, rates: all, evaluations } = &mut *known;
        for (place, &at) in new.iter().enumerate() {
            rates[at] = found[component * new.len() + place];
            // Another thread may have evaluated the same point meanwhile.
            if rows.contains_key(&points[at]) {
                continue;
            }
            *evaluations += 1;
            if rows.len() < MOST_KNOWN_POINTS {
                rows.insert(points[at], rows.len());
                all.extend((0..count).map(|number| found[number * new.len() + place]));
            }
        }
    }
}

fn point(samples: &Samples<'_>, at: usize) -> Point {
    let ([x, y, z], [dx, dy, dz]) = (samples.positions()[at], samples.directions()[at]);
    let energy = samples.energies().get(at).copied().unwrap_or(f64::NAN);
    [x, y, z, dx, dy, dz, energy].map(f64::to_bits)
}

/// One component of several.
#[derive(Clone, Debug)]
pub struct ComponentEmission {
    pub(super) rates: Arc<ComponentRates>,
    pub(super) number: usize,
}

impl ComponentEmission {
    /// Of these rates the ones of the component with this number.
    pub(in crate::scene) fn new(rates: &Arc<ComponentRates>, number: usize) -> Self {
        Self { rates: Arc::clone(rates), number }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.rates.names[self.number]
    }

    /// At how many points all components have been evaluated so far.
    pub fn evaluations(&self) -> u64 {
        self.rates.evaluations()
    }

    /// Its expression.
    pub fn text(&self) -> &str {
        &self.rates.texts()[self.number]
    }
}

/// The expressions of a scene, with the names of their components, if it has such a list.
pub(super) fn read(
    expressions: Node,
    names: Option<Node>,
    constants: Option<Table>,
    spectrum: Spectrum,
) -> Result<ComponentRates, SceneError> {
    const EXPRESSIONS: &str = "a list of 1 to 999 expressions, each a string";
    let texts = strings(&expressions, EXPRESSIONS)?;
    if texts.is_empty() || texts.len() > MOST_COMPONENTS {
        return Err(expressions.refuse(&format!("a list of {}", texts.len()), EXPRESSIONS));
    }
    let names = match names {
        Some(names) => read_names(&names, texts.len())?,
        None => (1..=texts.len()).map(|number| format!("component_{number}")).collect(),
    };
    let constants = constants.map(Table::numbers).transpose()?.unwrap_or_default();
    let values = constants.iter().map(|(name, (value, _))| (name.clone(), *value)).collect();
    let mut unused: BTreeSet<&String> = constants.keys().collect();
    for (number, text) in texts.iter().enumerate() {
        let key = format!("emission.expressions[{number}]");
        let expression = parse_expression(&key, text, &values, spectrum)?;
        let of_this: BTreeSet<&String> = expression.unused_constants().iter().collect();
        unused.retain(|name| of_this.contains(name));
    }
    if let Some(name) = unused.into_iter().next() {
        return Err(refuse_unused(
            "constant",
            name,
            &constants[name].1.key,
            "emission.expressions",
        ));
    }
    let texts: Vec<String> = texts.into_iter().map(|(text, _)| text).collect();
    let expressions = match spectrum {
        Spectrum::InTime => Expressions::of_time(&texts, &values),
        _ => Expressions::parse(&texts, &values),
    }
    .map_err(|error| place_in("emission.expressions", &error, &expressions.place))?;
    Ok(ComponentRates { expressions, names, known: RwLock::default() })
}

/// The texts of a list, each with its place.
fn strings(node: &Node, expected: &str) -> Result<Vec<(String, Place)>, SceneError> {
    match &node.value {
        Value::Array(items) => items.iter().map(Node::text).collect(),
        other => Err(node.refuse(other.kind(), expected)),
    }
}

/// Names that can be those of HDUs, columns and files.
fn read_names(node: &Node, count: usize) -> Result<Vec<String>, SceneError> {
    const NAME: &str = "1 to 40 of A-Z, a-z, 0-9, _ and -";
    let found = strings(node, "a list of names, each a string")?;
    if found.len() != count {
        let names = if found.len() == 1 { "name" } else { "names" };
        let message = format!("`{}` has {} {names}", node.path, found.len());
        return Err(SceneError::at(&node.place, message)
            .label(format!("expected {count}, one for each of `emission.expressions`")));
    }
    let mut names: Vec<String> = Vec::with_capacity(count);
    for (number, (name, place)) in found.into_iter().enumerate() {
        let is_part = |byte: u8| byte.is_ascii_alphanumeric() || b"_-".contains(&byte);
        let refuse = |expected: &str| {
            let message = format!("`{}[{number}]` is \"{name}\"", node.path);
            Err(SceneError::at(&place, message).label(format!("expected {expected}")))
        };
        if !(1..=40).contains(&name.len()) || !name.bytes().all(is_part) {
            return refuse(NAME);
        }
        // Names of HDUs are the same in upper and lower case, and those of errors and other maps follow from them.
        let upper = name.to_uppercase();
        if ["_ERROR", "_EVALUATIONS", "_BAND"].iter().any(|ending| upper.ends_with(ending)) {
            return refuse("another ending: _ERROR, _EVALUATIONS and _BAND are those of its maps");
        }
        if names.iter().any(|other| other.eq_ignore_ascii_case(&name)) {
            return refuse("each name once, in upper or lower case");
        }
        names.push(name);
    }
    // Columns of a sky have the number of their band after the name.
    let numbered = |name: &str, other: &str| {
        let after = name.to_uppercase();
        let after = after.strip_prefix(&format!("{}_", other.to_uppercase())).map(str::to_owned);
        after.is_some_and(|after| after.bytes().all(|byte| byte.is_ascii_digit()))
    };
    for name in &names {
        if let Some(other) = names.iter().find(|other| numbered(name, other)) {
            let message = format!("`{}` has \"{name}\" and \"{other}\"", node.path);
            return Err(SceneError::at(&node.place, message)
                .label("expected names that are not another one with a number"));
        }
    }
    Ok(names)
}

#[cfg(test)]
mod tests;
