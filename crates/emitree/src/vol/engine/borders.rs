//! Samples at the border of a tile, as samples of the tiles beside it.
//!
//! A structure that is resolved in one tile may reach a small way across its border, where the lines of the other
//! tile are too coarse to meet it. Rates that are known at the border are therefore compared with the lines of
//! all other tiles that contain the same point: they cost no evaluation. The borders of charts are limbs and edges,
//! which have structure of their own.

use crate::projection::Chart;
use crate::vol::dyadic::{STEPS, from_unit, unit};
use crate::vol::view::scattered::PartSamples;
use crate::vol::view::sheet::Sheet;

/// A point on the border of two tiles is in both, whatever rounding does.
const ROUNDING: f64 = 1e-9;

/// For each sheet of a tile, the samples of the others that are at their borders and in its chart; none of charts at
/// bodies.
pub(crate) fn border_samples(sheets: &[Sheet<'_>]) -> Vec<PartSamples> {
    let mut found: Vec<PartSamples> = (0..sheets.len()).map(|_| PartSamples::default()).collect();
    if sheets.len() < 2 || !sheets.iter().all(|sheet| sheet.footing.is_of_pixels()) {
        return found;
    }
    for (from, sheet) in sheets.iter().enumerate() {
        for (position, rate) in sheet.rates_at_border() {
            for (to, other) in sheets.iter().enumerate().filter(|(to, _)| *to != from) {
                if let Some((point, path)) = place_in(other.scan.view.chart, position) {
                    found[to].points.push(point);
                    found[to].rates.push(rate * path);
                }
            }
        }
    }
    found
}

/// The coordinates of a world point in a chart, if it is in its tile, and ds/dz there.
fn place_in(chart: &dyn Chart, position: [f64; 3]) -> Option<([f64; 3], f64)> {
    let u = chart.chart_from_world(position)?;
    if !u.iter().all(|along| (-ROUNDING..=1.0 + ROUNDING).contains(along)) {
        return None;
    }
    let point = u.map(|along| unit(from_unit(along.clamp(0.0, 1.0))));
    if chart.across_gap(point).is_some() {
        return None;
    }
    let path = chart.world_from_chart(point).path_per_depth;
    (path > 0.0).then_some((point, path))
}

impl Sheet<'_> {
    /// The positions of the samples on its border at which G is not 0, and g there.
    fn rates_at_border(&self) -> Vec<([f64; 3], f64)> {
        let (chart, node_lines) = (self.scan.view.chart, &self.scan.node_lines);
        let mut rates = Vec::new();
        for (i, (node, line)) in self.scan.tree.nodes().iter().zip(&node_lines.lines).enumerate() {
            let is_at_border = node.place.iter().any(|along| [0, STEPS].contains(along));
            if !is_at_border || !node_lines.is_full(i) {
                continue;
            }
            let [x, y] = node.place.map(unit);
            for sample in line.samples.iter().filter(|sample| sample.rate != 0.0) {
                let u = [x, y, unit(sample.depth)];
                let at = chart.world_from_chart(u);
                if at.path_per_depth > 0.0 && chart.across_gap(u).is_none() {
                    rates.push((at.position, sample.rate / at.path_per_depth));
                }
            }
        }
        rates
    }
}
