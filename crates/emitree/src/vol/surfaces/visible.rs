//! Where lines of sight begin and end: what is outside of bounds and behind opaque bodies needs no surfaces, and no
//! evaluations.
//!
//! Bounds and bodies end lines of sight but not the coordinates. G need not be known beyond them, and is not evaluated
//! there; the ends of the lines and the limbs are known by geometry.

use crate::projection::Chart;
use crate::vol::view::part::Parts;
use crate::vol::view::pixel_rule::RuleNode;

/// Lines along each axis of a cell on which places in view are looked for.
const LINES_OF_CELL: usize = 5;

/// The ends of lines of sight at opaque bodies and bounds.
#[derive(Clone, Copy)]
pub(super) struct Visible<'a> {
    chart: &'a dyn Chart,
    /// The parts of the view, which know the limbs.
    parts: &'a Parts<'a>,
}

impl<'a> Visible<'a> {
    /// For the chart of the image plane.
    pub(super) fn new(chart: &'a dyn Chart, parts: &'a Parts<'a>) -> Self {
        Self { chart, parts }
    }

    /// The depths between which the line at canonical (x, y) is seen; none if the first one is above the second one.
    pub(super) fn ends(&self, xy: [f64; 2]) -> [f64; 2] {
        self.chart.visible_ends(xy)
    }

    /// The middle of the longest part of a line that is seen, of some lines in a box of the chart: those at its corners
    /// are among them. `None` if no such line is seen there.
    pub(super) fn place_in_view(&self, [low, high]: [[f64; 3]; 2]) -> Option<[f64; 3]> {
        let at = |axis: usize, k: usize| {
            let share = k as f64 / (LINES_OF_CELL - 1) as f64;
            low[axis] + share * (high[axis] - low[axis])
        };
        let part = |k: usize| {
            let xy = [at(0, k % LINES_OF_CELL), at(1, k / LINES_OF_CELL)];
            let [from, to] = self.ends(xy);
            let [from, to] = [from.max(low[2]), to.min(high[2])];
            (to - from, [xy[0], xy[1], 0.5 * (from + to)])
        };
        let parts =
            (0..LINES_OF_CELL * LINES_OF_CELL).map(part).filter(|(length, _)| *length > 0.0);
        parts.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, at)| at)
    }

    /// Whether a limb crosses a pixel.
    pub(super) fn is_at_limb(&self, pixel: usize) -> bool {
        self.parts.parts_at_limb(pixel).is_some()
    }

    /// The nodes of the quadrature of a pixel that a limb crosses, with the sides of its parts halved
    /// `level` times; none for other pixels.
    pub(super) fn nodes_at_limb(&self, pixel: usize, level: usize) -> Vec<RuleNode> {
        let parts = self.parts.parts_at_limb(pixel);
        parts.map_or_else(Vec::new, |parts| self.parts.nodes_at_limb(pixel, parts << level))
    }
}
