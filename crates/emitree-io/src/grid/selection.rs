//! The part of an array that is read: of values with a fourth axis one step.

use super::array::{Container, Described};
use super::error::GridReadError;
use super::order::names_of;
use super::request::GridRequest;
use super::step::StepAt;

/// For each axis of the array the place that is read, or all of them.
pub(super) type Selection = Vec<Option<usize>>;

/// What of the values is read: their three axes.
pub(super) fn selection(
    container: &mut dyn Container,
    request: &GridRequest,
) -> Result<Selection, GridReadError> {
    let Described { shape, axis_names } = container.describe(request.values.as_deref())?;
    let mut found: Selection = vec![None; shape.len()];
    let name = |place: usize| match axis_names.get(place) {
        Some(name) if !name.is_empty() => format!("`{name}`"),
        _ => format!("{place} of the array"),
    };
    let mut others = other_axes(request, &shape, &axis_names)?;
    // Axes of one step need no choice.
    if request.step.is_none() || others.len() > 1 {
        let singles = others.extract_if(.., |&mut place| shape[place] == 1);
        singles.for_each(|place| found[place] = Some(0));
    }
    match (&request.step, others.as_slice()) {
        (None, []) => Ok(found),
        (None, &[place]) => {
            let (count, axis) = (shape[place], name(place));
            Err(GridReadError::WithoutStep { shape, count, axis })
        }
        (Some(step), &[place]) => {
            let nodes = |container: &mut dyn Container| {
                let axis = step.axis.as_deref().or(axis_names.get(place).map(String::as_str));
                match axis.filter(|axis| !axis.is_empty()) {
                    Some(axis) => container.array_beside(axis)?.into_line(),
                    None => Err(GridReadError::StepWithoutAxis),
                }
            };
            let index = match step.at {
                StepAt::Index(index) => index_of(index, shape[place], name(place))?,
                StepAt::Value(value) => nearest(value, &nodes(container)?, shape[place])?,
            };
            found[place] = Some(index);
            Ok(found)
        }
        (Some(_), []) => Err(GridReadError::NoSteps { shape }),
        _ => Err(GridReadError::NotACube { shape }),
    }
}

/// The axes of a grid.
const AXES: usize = 3;

/// The axes of an array that are no coordinates.
fn other_axes(
    request: &GridRequest,
    shape: &[usize],
    axis_names: &[String],
) -> Result<Vec<usize>, GridReadError> {
    let count = shape.len().saturating_sub(AXES);
    if shape.len() < AXES {
        return Err(GridReadError::NotACube { shape: shape.to_vec() });
    }
    let is_coordinate = |name: &String| {
        let name = name.to_lowercase();
        (0..AXES).any(|axis| names_of(request.coordinates, axis).contains(&name.as_str()))
    };
    let chosen = request.step.as_ref().and_then(|step| step.axis.as_ref());
    if let (Some(chosen), true) = (chosen, count == 1)
        && let Some(place) = axis_names.iter().position(|name| name == chosen)
    {
        return Ok(vec![place]);
    }
    let others = || (0..axis_names.len()).filter(|&place| !is_coordinate(&axis_names[place]));
    if others().count() == count && axis_names.len() == shape.len() {
        return Ok(others().collect());
    }
    Ok((0..count).collect())
}

fn index_of(index: i64, count: usize, axis: String) -> Result<usize, GridReadError> {
    let from_end = || usize::try_from(index.unsigned_abs()).ok().and_then(|n| count.checked_sub(n));
    let found = if index < 0 { from_end() } else { usize::try_from(index).ok() };
    let found = found.filter(|&found| found < count);
    found.ok_or(GridReadError::StepBeyond { index, count, axis })
}

fn nearest(value: f64, nodes: &[f64], count: usize) -> Result<usize, GridReadError> {
    if nodes.len() != count {
        return Err(GridReadError::StepNodes { found: nodes.len(), count });
    }
    let (min, max) = nodes.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), &node| {
        (min.min(node), max.max(node))
    });
    let distance = |index: &usize| (nodes[*index] - value).abs();
    let found = (0..count).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let is_within = min <= value && value <= max;
    found.filter(|_| is_within).ok_or(GridReadError::StepOutside { value, min, max })
}

#[cfg(test)]
mod tests;
