//! Lines and markers over a pair of axes.

use super::axis::Axis;
use super::frame::{Frame, MARGIN, TITLE_SIZE};
use super::marker::{Look, Series};
use super::placement::Obstacles;
use super::svg::{Anchor, INK, Rect, Rgb, Stroke, Svg, Text};
use super::{Figure, FigureError};

/// A plot of one or more [`Series`]; its labels and its legend stand where they cover no data.
///
/// ```
/// use emitree_io::figure::{Axis, Plot, Series};
///
/// let figure = Plot::new(Axis::linear("x"), Axis::linear("y"))
///     .title("Two points and a line")
///     .series(Series::line("line", [[0.0, 0.0], [1.0, 1.0]]).dashed())
///     .series(Series::markers("points", [[0.2, 0.3], [0.7, 0.6]]))
///     .vertical_line(0.5, "middle")
///     .annotation([0.2, 0.3], "first")
///     .draw()?;
/// assert!(figure.svg().contains("Two points and a line"));
/// # Ok::<(), emitree_io::figure::FigureError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    title: String,
    axes: [Axis; 2],
    size: [f64; 2],
    series: Vec<Series>,
    lines: Vec<ReferenceLine>,
    annotations: Vec<([f64; 2], String)>,
}

#[derive(Clone, Debug, PartialEq)]
struct ReferenceLine {
    horizontal: bool,
    value: f64,
    label: String,
}

const REFERENCE: Rgb = [110; 3];
const LEGEND_BORDER: Rgb = [190; 3];
const SMALL: f64 = 11.5;
const ROW: f64 = 18.0;
const SAMPLE: f64 = 28.0;

impl Plot {
    /// An empty plot.
    pub fn new(x: Axis, y: Axis) -> Self {
        Self {
            title: String::new(),
            axes: [x, y],
            size: [500.0, 340.0],
            series: Vec::new(),
            lines: Vec::new(),
            annotations: Vec::new(),
        }
    }

    /// The title above the plot.
    #[must_use]
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// The size \[width, height\] of the area between the axes, in units of the SVG.
    #[must_use]
    pub fn size(mut self, size: [f64; 2]) -> Self {
        self.size = size;
        self
    }

    /// One more series, drawn upon those before.
    #[must_use]
    pub fn series(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// A grey line across the plot at this y.
    #[must_use]
    pub fn horizontal_line(mut self, y: f64, label: impl Into<String>) -> Self {
        self.lines.push(ReferenceLine { horizontal: true, value: y, label: label.into() });
        self
    }

    /// A grey line up the plot at this x.
    #[must_use]
    pub fn vertical_line(mut self, x: f64, label: impl Into<String>) -> Self {
        self.lines.push(ReferenceLine { horizontal: false, value: x, label: label.into() });
        self
    }

    /// A text beside the point \[x, y\].
    #[must_use]
    pub fn annotation(mut self, at: [f64; 2], text: impl Into<String>) -> Self {
        self.annotations.push((at, text.into()));
        self
    }

    /// Draws the plot.
    ///
    /// # Errors
    ///
    /// [`FigureError`] if there is no series or no finite point, a range is not in order, or a
    /// value on a logarithmic axis is not positive.
    pub fn draw(&self) -> Result<Figure, FigureError> {
        if self.series.is_empty() {
            return Err(FigureError::Empty { missing: "series" });
        }
        let resolve = |axis: usize| {
            let along = move |line: &&ReferenceLine| line.horizontal == (axis == 1);
            let lines = self.lines.iter().filter(along).map(|line| line.value);
            let points = self.series.iter().flat_map(|series| &series.points);
            self.axes[axis].resolve(points.map(|point| point[axis]).chain(lines))
        };
        let resolved = [resolve(0)?, resolve(1)?];
        let [x, y] = &self.axes;
        let frame = Frame::new([x, y], resolved, self.size);

        let title = Text::new(&self.title, TITLE_SIZE, Anchor::Middle);
        let title_height = if self.title.is_empty() { 0.0 } else { TITLE_SIZE + 8.0 };
        let [width, height] = self.size;
        // A title wider than the plot stands out on both sides.
        let overhang = 0.5 * (title.width() - width);
        let left = (MARGIN + frame.left()).max(MARGIN + overhang).ceil();
        let area = Rect { left, top: (MARGIN + title_height).ceil(), width, height };
        let mut right = (MARGIN + frame.right()).max(MARGIN + overhang);

        let canvas = Canvas { plot: self, frame, area };
        let mut svg = Svg::default();
        let mut obstacles = Obstacles::default();
        canvas.frame.draw_grid(&mut svg, area);
        canvas.draw_series(&mut svg, &mut obstacles);
        canvas.frame.draw(&mut svg, area);
        canvas.draw_annotations(&mut svg, &mut obstacles);
        canvas.draw_reference_labels(&mut svg, &mut obstacles);
        if let Some(legend) = Legend::of(&self.series) {
            let rect = legend.inside(area, &obstacles).unwrap_or_else(|| {
                right = right.max(legend.size[0] + 2.0 * MARGIN);
                legend.at([area.right() + MARGIN, area.top])
            });
            legend.draw(&mut svg, rect);
        }
        svg.text([area.left + 0.5 * width, MARGIN + 0.5 * TITLE_SIZE], title);
        let bottom = canvas.frame.bottom() + MARGIN;
        Ok(svg.finish((area.right() + right).ceil(), (area.bottom() + bottom).ceil()))
    }
}

/// A plot whose place on the figure is settled.
struct Canvas<'a> {
    plot: &'a Plot,
    frame: Frame<'a>,
    area: Rect,
}

impl Canvas<'_> {
    fn ends(&self, line: &ReferenceLine) -> [[f64; 2]; 2] {
        let (area, value) = (self.area, line.value);
        let [x, y] = self.frame.place(area, [value; 2]);
        if line.horizontal {
            [[area.left, y], [area.right(), y]]
        } else {
            [[x, area.top], [x, area.bottom()]]
        }
    }

    fn draw_series(&self, svg: &mut Svg, obstacles: &mut Obstacles) {
        let edge = self.area.grown(0.5);
        let inside = |[x, y]: [f64; 2]| {
            (edge.left..=edge.right()).contains(&x) && (edge.top..=edge.bottom()).contains(&y)
        };
        svg.clipped(self.area, |svg| {
            for line in &self.plot.lines {
                let [from, to] = self.ends(line);
                svg.line(from, to, Stroke { colour: REFERENCE, width: 1.2, dashes: "5 3" });
                obstacles.add_line(from, to);
            }
            for (series, look) in looks(&self.plot.series) {
                let Some(stroke) = look.stroke else { continue };
                let finite = |p: &[f64; 2]| p.iter().all(|value| value.is_finite());
                for part in series.points.split(|point| !finite(point)) {
                    let places: Vec<_> =
                        part.iter().map(|&p| self.frame.place(self.area, p)).collect();
                    svg.polyline(&places, stroke);
                    places.windows(2).for_each(|pair| obstacles.add_line(pair[0], pair[1]));
                }
            }
        });
        for (series, look) in looks(&self.plot.series).filter(|(_, look)| look.marker.is_some()) {
            for point in series.points.iter().filter(|p| p.iter().all(|v| v.is_finite())) {
                let at = self.frame.place(self.area, *point);
                if inside(at) {
                    look.draw_marker(svg, at);
                    for (dx, dy) in [(0.0, 0.0), (-4.0, 0.0), (4.0, 0.0), (0.0, -4.0), (0.0, 4.0)] {
                        obstacles.add_point([at[0] + dx, at[1] + dy]);
                    }
                }
            }
        }
    }

    fn draw_annotations(&self, svg: &mut Svg, obstacles: &mut Obstacles) {
        for (point, text) in &self.plot.annotations {
            let [x, y] = self.frame.place(self.area, *point);
            let width = Text::new(text, SMALL, Anchor::Start).width();
            // Beside the point first, then around it, then farther off.
            let candidates = [9.0, 16.0, 26.0, 40.0].into_iter().flat_map(|away| {
                let (right, left) = (x + away, x - away - width);
                let (above, below) = (y - away - 0.5 * SMALL, y + away + 0.5 * SMALL);
                [
                    [right, y],
                    [left, y],
                    [right, above],
                    [right, below],
                    [left, above],
                    [left, below],
                    [x - 0.5 * width, above],
                    [x - 0.5 * width, below],
                ]
                .map(|[left, middle]| label_rect(left, middle, width))
            });
            self.draw_label(svg, obstacles, text, INK, candidates);
        }
    }

    fn draw_reference_labels(&self, svg: &mut Svg, obstacles: &mut Obstacles) {
        for line in self.plot.lines.iter().filter(|line| !line.label.is_empty()) {
            let [from, to] = self.ends(line);
            let width = Text::new(&line.label, SMALL, Anchor::Start).width();
            // From end to end in steps, on either side of the line.
            let steps = [1.0, 0.0, 0.9, 0.1, 0.8, 0.2, 0.7, 0.3, 0.6, 0.4, 0.5];
            let candidates = steps.into_iter().flat_map(|t| {
                let off = 0.5 * SMALL + 4.0;
                if line.horizontal {
                    let left = from[0] + 6.0 + t * (to[0] - from[0] - width - 12.0);
                    [from[1] - off, from[1] + off].map(|middle| label_rect(left, middle, width))
                } else {
                    let middle = to[1] - off - 2.0 - t * (to[1] - from[1] - 2.0 * off - 4.0);
                    [to[0] + 6.0, to[0] - 6.0 - width].map(|left| label_rect(left, middle, width))
                }
            });
            self.draw_label(svg, obstacles, &line.label, REFERENCE, candidates);
        }
    }

    fn draw_label(
        &self,
        svg: &mut Svg,
        obstacles: &mut Obstacles,
        text: &str,
        colour: Rgb,
        candidates: impl Iterator<Item = Rect>,
    ) {
        let Some((rect, _)) = obstacles.best(self.area, candidates) else {
            return;
        };
        obstacles.take(rect);
        let text = Text { colour, halo: true, ..Text::new(text, SMALL, Anchor::Start) };
        svg.text([rect.left, rect.top + 0.5 * rect.height], text);
    }
}

fn label_rect(left: f64, middle: f64, width: f64) -> Rect {
    Rect { left, top: middle - 0.5 * SMALL, width, height: SMALL }
}

fn looks(series: &[Series]) -> impl Iterator<Item = (&Series, Look)> {
    series.iter().enumerate().map(|(number, series)| (series, series.look(number)))
}

/// The names of the series.
struct Legend<'a> {
    entries: Vec<(&'a str, Look)>,
    size: [f64; 2],
}

impl<'a> Legend<'a> {
    /// None if no series has a name.
    fn of(series: &'a [Series]) -> Option<Self> {
        let entries: Vec<_> = looks(series)
            .filter(|(series, _)| !series.label.is_empty())
            .map(|(series, look)| (&*series.label, look))
            .collect();
        let widths =
            entries.iter().map(|(label, _)| Text::new(label, SMALL, Anchor::Start).width());
        let widest = widths.fold(0.0, f64::max);
        let rows = entries.iter().map(|_| ROW).sum::<f64>();
        let size = [SAMPLE + widest + 24.0, rows + 8.0];
        (!entries.is_empty()).then_some(Self { entries, size })
    }

    fn at(&self, [left, top]: [f64; 2]) -> Rect {
        Rect { left, top, width: self.size[0], height: self.size[1] }
    }

    /// A place within the axes that covers nothing.
    fn inside(&self, area: Rect, obstacles: &Obstacles) -> Option<Rect> {
        let room = area.grown(-8.0);
        let right = room.right() - self.size[0];
        let bottom = room.bottom() - self.size[1];
        let middle = [0.5 * (room.left + right), 0.5 * (room.top + bottom)];
        let corners = [[right, room.top], [room.left, bottom], [right, bottom], room.corner()];
        let sides = [[middle[0], room.top], [middle[0], bottom], [right, middle[1]]];
        let candidates = corners.into_iter().chain(sides).map(|corner| self.at(corner));
        obstacles.best(room, candidates).filter(|(_, covered)| *covered == 0).map(|(rect, _)| rect)
    }

    fn draw(&self, svg: &mut Svg, rect: Rect) {
        svg.rect(rect, Some([255; 3]), Some(Stroke::solid(LEGEND_BORDER, 1.0)));
        let mut y = rect.top + 4.0 + 0.5 * ROW;
        for (label, look) in &self.entries {
            let left = rect.left + 8.0;
            if let Some(stroke) = look.stroke {
                svg.line([left, y], [left + SAMPLE, y], stroke);
            }
            look.draw_marker(svg, [left + 0.5 * SAMPLE, y]);
            svg.text([left + SAMPLE + 8.0, y], Text::new(label, SMALL, Anchor::Start));
            y += ROW;
        }
    }
}

#[cfg(test)]
mod tests;
