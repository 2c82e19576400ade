//! Adaptive steps along each line: bisected Gauss–Kronrod panels with QUADPACK's error estimate
//! (Piessens et al. 1983), every line to the same tolerance.
//!
//! The rule comes from the crate `bilby`, whose interface takes g one point at a time. Here it is
//! run twice: once to collect its nodes, for a batch of panels on many lines, and once with the
//! values there.

use super::{AtEnergy, Lines, StepsTaken};
use crate::error::RenderError;
use crate::exchange::MethodError;
use crate::meter::Meter;
use crate::quadrature::Points;
use crate::site::Mapping;
use crate::tile::Tile;
use bilby::{GKPair, GaussKronrod};
use core::cell::{Cell, RefCell};

/// Evaluations of one panel.
const NODES: usize = 15;
/// Panels of each line at the start. What is thinner than the distance of their nodes, a hundredth
/// of the depth or so, may be stepped over: in the SMILE view 13 of 5 000 lines miss the thin sheath
/// in the cusps; with 2 panels it was 177.
const FIRST_PANELS: usize = 8;
/// Lines that are refined together.
const LINES_PER_BLOCK: usize = 1 << 14;
/// A panel that has been halved this often is a discontinuity resolved to rounding.
const MIN_LENGTH: f64 = 1e-14;

/// An interval of one line's depth, with its integral and the estimate of that one's error.
#[derive(Clone, Copy, Debug)]
struct Panel {
    line: usize,
    from: f64,
    to: f64,
    integral: f64,
    error: f64,
}

/// Memory that one line takes: its first panels, its radiance and its error.
pub(crate) const BYTES_PER_LINE: u64 = (FIRST_PANELS * size_of::<Panel>() + 16) as u64;

/// The panels that lines begin with.
#[derive(Clone, Copy)]
pub(super) struct FirstPanels<'a> {
    /// The line of each panel and its ends, line after line; `None` for equal ones.
    pub(super) given: Option<&'a [(usize, [f64; 2])]>,
    /// Whether they are not halved.
    pub(super) are_fixed: bool,
}

impl FirstPanels<'_> {
    /// The panels of all lines, line after line.
    fn panels(&self, lines: &Lines) -> Vec<Panel> {
        let panel =
            |line, [from, to]: [f64; 2]| Panel { line, from, to, integral: 0.0, error: 0.0 };
        if let Some(given) = self.given {
            return given.iter().map(|(line, ends)| panel(*line, *ends)).collect();
        }
        let end = |k: usize| k as f64 / FIRST_PANELS as f64;
        let of_line = |line| (0..FIRST_PANELS).map(move |k| panel(line, [end(k), end(k + 1)]));
        (0..lines.count()).flat_map(of_line).collect()
    }
}

/// The image by adaptive integration of each line to `tolerance` times the largest line.
pub(super) async fn render(
    meter: &Meter,
    &Tile { projection, shape: [height, width], place: tile }: &Tile<'_>,
    per_side: usize,
    tolerance: f64,
    energy: Option<f64>,
    first: FirstPanels<'_>,
) -> Result<AtEnergy, MethodError> {
    let lines = Lines { height, width, per_side };
    let count = first.given.map_or(lines.count().saturating_mul(FIRST_PANELS), <[_]>::len);
    let needed = (count as u64).saturating_mul(NODES as u64);
    let allowed = meter.evaluations_left();
    if needed > allowed {
        meter.check_time()?;
        let what = format!("the initial sampling of {} lines", lines.count());
        return Err(RenderError::Budget { what, needed, allowed });
    }
    let rule = GaussKronrod::new(GKPair::G7K15);
    let map = |u| projection.world_from_canonical(u);
    let mapping = Mapping { map: &map, tile, energy };
    let mut panels = first.panels(&lines);
    // All lines once: the largest of them sets the scale of the tolerance.
    let is_same_block = |a: &Panel, b: &Panel| a.line / LINES_PER_BLOCK == b.line / LINES_PER_BLOCK;
    for block in panels.chunk_by_mut(is_same_block) {
        integrate(meter, mapping, &lines, &rule, block).await?;
    }
    let largest = panels
        .chunk_by(|a, b| a.line == b.line)
        .map(|line| line.iter().map(|panel| panel.integral).sum::<f64>().abs())
        .fold(0.0, f64::max);

    let (mut radiances, mut errors) = (vec![0.0; lines.count()], vec![0.0; lines.count()]);
    let mut converged = true;
    // Panels whose integrals are in the image.
    let mut taken = Vec::new();
    let mut take = |panels: &[Panel]| {
        if meter.freezes() {
            taken.extend(panels.iter().map(|panel| (panel.line, [panel.from, panel.to])));
        }
    };
    for block in panels.chunk_by(is_same_block) {
        let mut waiting = block.to_vec();
        loop {
            let (settled, split) =
                settle(waiting, tolerance * largest, &mut radiances, &mut errors);
            take(&settled);
            if split.is_empty() {
                break;
            }
            let cost = (split.len() * 2 * NODES) as u64;
            let mut halved = Vec::new();
            let mut integrated = !first.are_fixed && cost <= meter.evaluations_left();
            if integrated {
                halved = split.iter().copied().flat_map(halves).collect();
                integrated = match integrate(meter, mapping, &lines, &rule, &mut halved).await {
                    Err(RenderError::Time { .. }) => false,
                    result => result.map(|()| true)?,
                };
            }
            if !integrated {
                take(&split);
                for panel in split {
                    radiances[panel.line] += panel.integral;
                    errors[panel.line] += panel.error;
                }
                converged = false;
                break;
            }
            waiting = halved;
        }
    }
    let [image, error] = [&radiances, &errors].map(|values| lines.image(projection, values));
    let steps = StepsTaken::Adaptive(taken);
    Ok(AtEnergy { image, error: Some(error), converged, steps })
}

fn halves(panel: Panel) -> [Panel; 2] {
    let middle = 0.5 * (panel.from + panel.to);
    [Panel { to: middle, ..panel }, Panel { from: middle, ..panel }]
}

/// Adds up what is good enough, and returns these panels and those to be halved, lines together.
///
/// A line's error is the sum over its panels; the smallest errors are accepted as long as they take
/// up no more than half of what the tolerance still leaves to the line.
fn settle(
    mut panels: Vec<Panel>,
    tolerance: f64,
    radiances: &mut [f64],
    errors: &mut [f64],
) -> (Vec<Panel>, Vec<Panel>) {
    panels.sort_by(|a, b| a.line.cmp(&b.line).then(a.error.total_cmp(&b.error)));
    let (mut settled, mut split) = (Vec::new(), Vec::new());
    for of_line in panels.chunk_by(|a, b| a.line == b.line) {
        let line = of_line[0].line;
        let left = tolerance - errors[line];
        let total: f64 = of_line.iter().map(|panel| panel.error).sum();
        let allowed = if total <= left { left } else { 0.5 * left };
        let mut taken = 0.0;
        for panel in of_line {
            taken += panel.error;
            if taken <= allowed || panel.to - panel.from < MIN_LENGTH {
                radiances[line] += panel.integral;
                errors[line] += panel.error;
                settled.push(*panel);
            } else {
                split.push(*panel);
            }
        }
    }
    (settled, split)
}

/// The nodes of the rule on the unit interval, in the order in which it takes their values.
fn nodes(rule: &GaussKronrod) -> Vec<f64> {
    let nodes = RefCell::new(Vec::with_capacity(NODES));
    rule.integrate(0.0, 1.0, |z| {
        nodes.borrow_mut().push(z);
        0.0
    });
    nodes.into_inner()
}

/// The nodes of a panel with their weights.
pub(super) fn weighted_nodes([from, to]: [f64; 2]) -> Vec<(f64, f64)> {
    let rule = GaussKronrod::new(GKPair::G7K15);
    let weighted = |(own, z): (usize, f64)| {
        let next = Cell::new(0);
        let is_own = |_: f64| f64::from(u8::from(next.replace(next.get() + 1) == own));
        (from + z * (to - from), rule.integrate(from, to, is_own).0)
    };
    nodes(&rule).into_iter().enumerate().map(weighted).collect()
}

/// Evaluates all nodes of the panels in one batch, and integrates each panel.
async fn integrate(
    meter: &Meter,
    mapping: Mapping<'_>,
    lines: &Lines,
    rule: &GaussKronrod,
    panels: &mut [Panel],
) -> Result<(), MethodError> {
    let unit_nodes = nodes(rule);
    let mut rates = vec![0.0; panels.len() * NODES];
    let point = |i: usize| {
        let panel = &panels[i / NODES];
        let [x, y] = lines.position(panel.line);
        [x, y, panel.from + unit_nodes[i % NODES] * (panel.to - panel.from)]
    };
    meter.evaluate(Points::new(rates.len(), &point), mapping, &mut rates).await?;
    for (panel, rates) in panels.iter_mut().zip(rates.chunks_exact(NODES)) {
        let next = Cell::new(0);
        let evaluated = |_: f64| {
            let i = next.replace(next.get() + 1);
            rates[i]
        };
        (panel.integral, panel.error) = rule.integrate(panel.from, panel.to, evaluated);
    }
    Ok(())
}
