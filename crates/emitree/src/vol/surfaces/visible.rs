//! Where lines of sight end: what is behind opaque bodies needs no surfaces, and no evaluations.
//!
//! On the image plane, bodies end lines of sight but not the coordinates. G need not be known behind and
//! in them, and is not evaluated there; the ends of the lines and the limbs are known by geometry.

use crate::projection::Chart;
use crate::vol::view::part::Parts;
use crate::vol::view::pixel_rule::RuleNode;

/// The ends of lines of sight at opaque bodies.
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

    /// The depth at which the line at canonical (x, y) ends.
    pub(super) fn depth(&self, xy: [f64; 2]) -> f64 {
        self.chart.visible_end(xy).map_or(1.0, |(_, depth)| depth)
    }

    /// Whether all lines in a rectangle of the image end before a depth: those at its corners do, at one
    /// body. A body is convex, so that all lines between them meet it, none further away than at a corner.
    pub(super) fn end_before(&self, [low, high]: [[f64; 2]; 2], depth: f64) -> bool {
        let corners = [low, [high[0], low[1]], [low[0], high[1]], high];
        let ends = corners.map(|xy| self.chart.visible_end(xy));
        let [Some((first, _)), ..] = ends else { return false };
        ends.iter().all(|end| end.is_some_and(|(body, end)| body == first && end < depth))
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
