//! Angles as files and scenes have them, and as grids do: colatitudes and azimuths in radians.

use super::angle_unit::AngleUnit;
use super::error::GridReadError;
use emitree_models::grid::check_nodes;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// What angles along an axis are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AngleKind {
    Colatitude,
    Latitude,
    Azimuth,
}

/// How far rounded angles may be beyond their range, over a full turn.
const ROUNDING: f64 = 1e-6;
/// How close angles in degrees have to be to π or 2π to be taken for radians.
const CLOSE: f64 = 1e-3;

/// The nodes of an axis as colatitudes or azimuths in radians.
pub(super) fn in_radians(
    axis: &'static str,
    kind: AngleKind,
    unit: AngleUnit,
    nodes: Vec<f64>,
) -> Result<Vec<f64>, GridReadError> {
    check_nodes(axis, &nodes).map_err(GridReadError::Grid)?;
    check_range(kind, unit, &nodes)?;
    let radians = |node: f64| match unit {
        AngleUnit::Degrees => node.to_radians(),
        AngleUnit::Radians => node,
    };
    Ok(match kind {
        AngleKind::Latitude => {
            // Rounding takes a pole no further than the pole.
            nodes.into_iter().map(|node| (FRAC_PI_2 - radians(node)).clamp(0.0, PI)).collect()
        }
        _ => nodes.into_iter().map(radians).collect(),
    })
}

/// Refuses angles out of their range, and those that were taken for another unit.
fn check_range(kind: AngleKind, unit: AngleUnit, nodes: &[f64]) -> Result<(), GridReadError> {
    let turn = unit.turn();
    let (name, [low, high]) = match kind {
        AngleKind::Colatitude => ("colatitude", [0.0, turn / 2.0]),
        AngleKind::Latitude => ("latitude", [-turn / 4.0, turn / 4.0]),
        AngleKind::Azimuth => {
            let (first, last) = match (nodes.first(), nodes.last()) {
                (Some(first), Some(last)) => (*first, *last),
                _ => return Ok(()),
            };
            let span = (last - first).abs();
            // The gap that closes a turn of even nodes.
            let spacing = span / (nodes.len().max(2) - 1) as f64;
            let is_turn = |span: f64| (span - TAU).abs() < CLOSE;
            return if span > turn * (1.0 + ROUNDING) {
                Err(GridReadError::MoreThanATurn { first, last, unit, turn })
            } else if unit == AngleUnit::Degrees && (is_turn(span) || is_turn(span + spacing)) {
                Err(GridReadError::RatherRadians { first, last, limit: "2 pi" })
            } else {
                Ok(())
            };
        }
    };
    let slack = turn * ROUNDING;
    let is_out = |node: &f64| !(low - slack..=high + slack).contains(node);
    if let Some(index) = nodes.iter().position(is_out) {
        let value = nodes[index];
        return Err(GridReadError::AngleOutOfRange { index, value, unit, name, low, high });
    }
    let (first, last) = (nodes.first().copied(), nodes.last().copied());
    let (first, last) = (first.unwrap_or_default(), last.unwrap_or_default());
    let (limit, [low, high]) = match kind {
        AngleKind::Latitude => ("pi/2", [-FRAC_PI_2, FRAC_PI_2]),
        _ => ("pi", [0.0, PI]),
    };
    let ends = [first.min(last), first.max(last)];
    let is_close = |(end, limit): (f64, f64)| (end - limit).abs() < CLOSE;
    if unit == AngleUnit::Degrees && ends.into_iter().zip([low, high]).all(is_close) {
        return Err(GridReadError::RatherRadians { first, last, limit });
    }
    Ok(())
}
