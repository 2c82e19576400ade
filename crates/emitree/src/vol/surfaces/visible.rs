//! Where lines of sight end: what is behind opaque bodies needs no surfaces, and no evaluations.
//!
//! On the image plane, bodies end lines of sight but not the coordinates. G need not be known behind and
//! in them, and is not evaluated there; the ends of the lines and the limbs are known by geometry.

use crate::projection::Chart;
use crate::vol::view::part::Parts;
use crate::vol::view::pixel_rule::RuleNode;

/// The places along each edge of a rectangle at which depths are computed. Behind one convex body the
/// corners suffice; the others detect a gap between two.
const PLACES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// The ends of lines of sight at opaque bodies.
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

    /// The depth at which the line at canonical (x, y) ends.
    pub(super) fn depth(&self, xy: [f64; 2]) -> f64 {
        self.chart.visible_depth(xy)
    }

    /// The largest such depth at places of a rectangle.
    pub(super) fn deepest(&self, low: [f64; 2], high: [f64; 2]) -> f64 {
        let along = |k: usize| PLACES.map(|share| low[k] + share * (high[k] - low[k]));
        let [columns, rows] = [along(0), along(1)];
        let places = columns.iter().flat_map(|x| rows.iter().map(move |y| [*x, *y]));
        places.map(|xy| self.depth(xy)).fold(0.0, f64::max)
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
