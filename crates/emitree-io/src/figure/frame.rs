//! The frame around data: ticks, grid and labels of a pair of axes.

use super::axis::{Axis, ResolvedAxis};
use super::svg::{Anchor, INK, Rect, Rgb, Stroke, Svg, Text};
use super::ticks::Ticks;

pub(super) const TITLE_SIZE: f64 = 15.0;
pub(super) const LABEL_SIZE: f64 = 13.0;
pub(super) const TICK_SIZE: f64 = 11.5;

/// White space around a figure.
pub(super) const MARGIN: f64 = 12.0;

/// Length of a tick, and the gap between it and its label.
const TICK: f64 = 5.0;
const GAP: f64 = 5.0;

const GRID: Rgb = [217; 3];
const FINE_GRID: Rgb = [240; 3];

/// A pair of axes around an area of known size but not yet known place.
#[derive(Debug)]
pub(super) struct Frame<'a> {
    labels: [&'a str; 2],
    axes: [ResolvedAxis; 2],
    ticks: [Ticks; 2],
}

impl<'a> Frame<'a> {
    pub(super) fn new(axes: [&'a Axis; 2], resolved: [ResolvedAxis; 2], size: [f64; 2]) -> Self {
        let ticks = [resolved[0].ticks(size[0], 75.0), resolved[1].ticks(size[1], 50.0)];
        Self { labels: axes.map(|axis| &*axis.label), axes: resolved, ticks }
    }

    /// Room to the left of the area: ticks, their labels and the axis label.
    pub(super) fn left(&self) -> f64 {
        let label = if self.labels[1].is_empty() { 0.0 } else { LABEL_SIZE + 8.0 };
        TICK + GAP + widest(&self.ticks[1]) + label
    }

    /// The length of the label that reads upwards.
    pub(super) fn upright_length(&self) -> f64 {
        Text::new(self.labels[1], LABEL_SIZE, Anchor::Middle).width()
    }

    /// Room below the area.
    pub(super) fn bottom(&self) -> f64 {
        let label = if self.labels[0].is_empty() { 0.0 } else { LABEL_SIZE + 8.0 };
        TICK + GAP + TICK_SIZE + label
    }

    /// Room to the right of the area: half of a tick's label may stand out.
    pub(super) fn right(&self) -> f64 {
        0.5 * widest(&self.ticks[0])
    }

    /// The place of a point given in the coordinates of the axes.
    pub(super) fn place(&self, area: Rect, [x, y]: [f64; 2]) -> [f64; 2] {
        // Beyond what renderers draw, yet finite: lines to points far outside keep their slope.
        let fraction = |axis: usize, value| self.axes[axis].fraction(value).clamp(-1e3, 1e3);
        [area.left + fraction(0, x) * area.width, area.bottom() - fraction(1, y) * area.height]
    }

    pub(super) fn draw_grid(&self, svg: &mut Svg, area: Rect) {
        let [x, y] = &self.ticks;
        let vertical = |svg: &mut Svg, value, colour| {
            let at = self.place(area, [value, self.axes[1].low])[0];
            let stroke = Stroke::solid(colour, 1.0);
            svg.line([at, area.top], [at, area.bottom()], stroke);
        };
        let horizontal = |svg: &mut Svg, value, colour| {
            let at = self.place(area, [self.axes[0].low, value])[1];
            let stroke = Stroke::solid(colour, 1.0);
            svg.line([area.left, at], [area.right(), at], stroke);
        };
        x.minor.iter().for_each(|&value| vertical(svg, value, FINE_GRID));
        y.minor.iter().for_each(|&value| horizontal(svg, value, FINE_GRID));
        x.major.iter().for_each(|(value, _)| vertical(svg, *value, GRID));
        y.major.iter().for_each(|(value, _)| horizontal(svg, *value, GRID));
    }

    /// The box, the ticks outside of it, and all labels.
    pub(super) fn draw(&self, svg: &mut Svg, area: Rect) {
        let stroke = Stroke::solid(INK, 1.0);
        svg.rect(area, None, Some(stroke));
        for (value, label) in &self.ticks[0].major {
            let [x, _] = self.place(area, [*value, self.axes[1].low]);
            svg.line([x, area.bottom()], [x, area.bottom() + TICK], stroke);
            let y = area.bottom() + TICK + GAP + 0.4 * TICK_SIZE;
            svg.text([x, y], Text::new(label, TICK_SIZE, Anchor::Middle));
        }
        for (value, label) in &self.ticks[1].major {
            let [_, y] = self.place(area, [self.axes[0].low, *value]);
            svg.line([area.left - TICK, y], [area.left, y], stroke);
            let x = area.left - TICK - GAP;
            svg.text([x, y], Text::new(label, TICK_SIZE, Anchor::End));
        }
        let middle = [area.left + 0.5 * area.width, area.top + 0.5 * area.height];
        let label = Text::new(self.labels[0], LABEL_SIZE, Anchor::Middle);
        svg.text([middle[0], area.bottom() + self.bottom() - 0.5 * LABEL_SIZE], label);
        let label = Text::new(self.labels[1], LABEL_SIZE, Anchor::Middle);
        let left = area.left - self.left() + 0.5 * LABEL_SIZE;
        svg.text([left, middle[1]], Text { upwards: true, ..label });
    }
}

/// An axis of colours to the right of `area`, from its bottom to its top.
#[derive(Debug)]
pub(super) struct SideAxis<'a> {
    label: &'a str,
    axis: ResolvedAxis,
    ticks: Ticks,
}

impl<'a> SideAxis<'a> {
    pub(super) fn new(label: &'a str, axis: ResolvedAxis, height: f64) -> Self {
        Self { label, axis, ticks: axis.ticks(height, 50.0) }
    }

    /// Room to the right of the area.
    pub(super) fn right(&self) -> f64 {
        let label = if self.label.is_empty() { 0.0 } else { LABEL_SIZE + 8.0 };
        TICK + GAP + widest(&self.ticks) + label
    }

    /// The length of the label, which reads upwards.
    pub(super) fn upright_length(&self) -> f64 {
        Text::new(self.label, LABEL_SIZE, Anchor::Middle).width()
    }

    pub(super) fn draw(&self, svg: &mut Svg, area: Rect) {
        let stroke = Stroke::solid(INK, 1.0);
        svg.rect(area, None, Some(stroke));
        for (value, label) in &self.ticks.major {
            let y = area.bottom() - self.axis.fraction(*value) * area.height;
            svg.line([area.right(), y], [area.right() + TICK, y], stroke);
            let x = area.right() + TICK + GAP;
            svg.text([x, y], Text::new(label, TICK_SIZE, Anchor::Start));
        }
        let label = Text::new(self.label, LABEL_SIZE, Anchor::Middle);
        let x = area.right() + self.right() - 0.5 * LABEL_SIZE;
        svg.text([x, area.top + 0.5 * area.height], Text { upwards: true, ..label });
    }
}

fn widest(ticks: &Ticks) -> f64 {
    let widths =
        ticks.major.iter().map(|(_, label)| Text::new(label, TICK_SIZE, Anchor::End).width());
    widths.fold(0.0, f64::max)
}
