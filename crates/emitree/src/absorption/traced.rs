//! The optical depth along one line of sight, as far as it is known.

use super::panels::Panel;
use crate::projection::path::Path;

/// A line of sight at one energy.
#[derive(Debug)]
pub(super) struct Traced {
    pub(super) path: Path,
    pub(super) energy: Option<f64>,
    /// The parts whose optical depths are known, from the observer on.
    parts: Vec<Part>,
    /// The sum of the errors of all panels.
    pub(super) error: f64,
}

#[derive(Debug)]
struct Part {
    /// Ascending and without gaps; none inside of an opaque body, where the coefficient is taken to be uniform.
    panels: Vec<Panel>,
    /// The optical depth at the beginning of each panel.
    before: Vec<f64>,
    /// The optical depths at both ends.
    ends: [f64; 2],
}

impl Traced {
    /// A line of which nothing is known.
    pub(super) fn new(path: Path, energy: Option<f64>) -> Self {
        Self { path, energy, parts: Vec::new(), error: 0.0 }
    }

    /// The number of parts that are known.
    pub(super) fn known(&self) -> usize {
        self.parts.len()
    }

    fn end(&self) -> f64 {
        self.parts.last().map_or(0.0, |part| part.ends[1])
    }

    /// Adds the next part, with its panels in ascending order.
    pub(super) fn push_panels(&mut self, panels: Vec<Panel>) {
        let begin = self.end();
        let mut end = begin;
        let mut before = Vec::with_capacity(panels.len());
        for panel in &panels {
            before.push(end);
            end += panel.total();
        }
        self.error += panels.iter().map(|panel| panel.error).sum::<f64>();
        self.parts.push(Part { panels, before, ends: [begin, end] });
    }

    /// Adds the next part, inside of an opaque body, with this optical depth.
    pub(super) fn push_gap(&mut self, depth: f64) {
        let begin = self.end();
        let ends = [begin, begin + depth];
        self.parts.push(Part { panels: Vec::new(), before: Vec::new(), ends });
    }

    /// The optical depth from the observer to the place `z` of a part that is known.
    pub(super) fn up_to(&self, part: usize, z: f64) -> f64 {
        let Part { panels, before, ends: [begin, end] } = &self.parts[part];
        let behind = panels.partition_point(|panel| panel.ends[0] <= z);
        match behind.checked_sub(1) {
            Some(number) => before[number] + panels[number].up_to(z),
            None => begin + z * (end - begin),
        }
    }
}
