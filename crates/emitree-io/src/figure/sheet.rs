//! The bands of a cube: many small images in a grid, all in the same colours.

use super::frame::{LABEL_SIZE, MARGIN, SideAxis, TICK_SIZE, TITLE_SIZE};
use super::heatmap::{BAR_GAP, BAR_WIDTH, draw_bar, draw_picture, is_crisp, proportion};
use super::panel::{Border, Panel, length};
use super::svg::{Anchor, INK, Rect, Stroke, Svg, Text};
use super::{Figure, FigureError};

/// Panels in a grid, in reading order, each with its title above and without ticks.
///
/// The colours and the colour bar of all are those of the first panel, which therefore should have a
/// [`range`](Panel::range) that holds them all; the panels are of one size.
///
/// ```
/// use emitree::Image;
/// use emitree_io::ValueRange;
/// use emitree_io::figure::{Panel, Sheet};
///
/// let bands = [1.0, 2.0, 3.0].map(|v| Image::from_pixels(1, 2, vec![0.0, v]));
/// let mut sheet = Sheet::new(2).title("three bands");
/// for band in &bands {
///     let range = ValueRange { low: 0.0, high: 3.0 };
///     sheet = sheet.panel(Panel::new(band).title("1–2 keV").range(range).colour_bar("R keV⁻¹"));
/// }
/// assert!(sheet.draw()?.svg().contains("three bands"));
/// # Ok::<(), emitree_io::figure::FigureError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet<'a> {
    title: String,
    columns: usize,
    panels: Vec<Panel<'a>>,
}

/// The longer edge of a panel: that of a [`Heatmap`](super::Heatmap) if there is one, and what is
/// left of the width of a page if there are more.
const LONGEST: f64 = 320.0;
const SHORTEST: f64 = 80.0;
const PAGE: f64 = 800.0;
/// Between panels.
const GAP: f64 = 8.0;

impl<'a> Sheet<'a> {
    /// A sheet without panels, to be `columns` wide, at least 1.
    pub fn new(columns: usize) -> Self {
        Self { title: String::new(), columns: columns.max(1), panels: Vec::new() }
    }

    /// The title above all panels.
    #[must_use]
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// One more panel, to the right of those before, or below them at the left.
    #[must_use]
    pub fn panel(mut self, panel: Panel<'a>) -> Self {
        self.panels.push(panel);
        self
    }

    /// Draws the panels.
    ///
    /// # Errors
    ///
    /// [`FigureError`] if there is no panel, an image has no pixels, or a range is not in order.
    pub fn draw(&self) -> Result<Figure, FigureError> {
        let Some(first) = self.panels.first() else {
            return Err(FigureError::Empty { missing: "panels" });
        };
        let colours = first.colours()?;
        let proportion = proportion(first)?;
        let columns = self.columns.min(self.panels.len());
        let rows = self.panels.len().div_ceil(columns);
        let edge = (PAGE / length(columns)).clamp(SHORTEST, LONGEST);
        let [width, height] = [proportion.min(1.0), 1.0 / proportion.max(1.0)]
            .map(|part| (edge * part).max(0.1 * edge).round());
        let widest = self.panels.iter().map(|panel| label(panel).width()).fold(width, f64::max);
        let step = [widest + GAP, height + TICK_SIZE + 6.0 + GAP].map(f64::ceil);

        let title = Text::new(&self.title, TITLE_SIZE, Anchor::Middle);
        let title_height = if self.title.is_empty() { 0.0 } else { TITLE_SIZE + 8.0 };
        let top = (MARGIN + title_height).ceil();
        let mut svg = Svg::default();
        for (number, panel) in self.panels.iter().enumerate() {
            let [column, row] = [number % columns, number / columns].map(length);
            let area = Rect {
                left: (MARGIN + column * step[0] + 0.5 * (widest - width)).floor(),
                top: top + row * step[1] + TICK_SIZE + 6.0,
                width,
                height,
            };
            draw_picture(&mut svg, area, panel, colours, is_crisp(panel, [width, height]))?;
            if panel.border == Border::Axes {
                svg.rect(area, None, Some(Stroke::solid(INK, 0.6)));
            }
            let above = [area.left + 0.5 * width, area.top - 0.5 * TICK_SIZE - 3.0];
            svg.text(above, label(panel));
        }
        let mut right = MARGIN + length(columns) * step[0] - GAP;
        let mut bottom = top + length(rows) * step[1] - GAP;
        if let Some(text) = first.bar.as_deref() {
            let text_height = Text::new(text, LABEL_SIZE, Anchor::Middle).width();
            bottom = bottom.max(top + text_height);
            let above = top + TICK_SIZE + 6.0;
            let bar = SideAxis::new(text, colours, bottom - above);
            let left = right + BAR_GAP;
            let area = Rect { left, top: above, width: BAR_WIDTH, height: bottom - above };
            draw_bar(&mut svg, area, &bar, first.colour_map)?;
            right = area.right() + bar.right();
        }
        let whole = (right + MARGIN).max(title.width() + 2.0 * MARGIN).ceil();
        svg.text([0.5 * whole, MARGIN + 0.5 * TITLE_SIZE], title);
        Ok(svg.finish(whole, (bottom + MARGIN).ceil()))
    }
}

/// The title of a panel.
fn label<'a>(panel: &'a Panel<'_>) -> Text<'a> {
    Text::new(&panel.title, TICK_SIZE, Anchor::Middle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::ValueRange;
    use emitree::Image;

    #[test]
    fn panels_are_read_from_left_to_right_and_down() {
        let image = Image::zeros(3, 4);
        let mut sheet = Sheet::new(2);
        for name in ["a", "b", "c"] {
            sheet = sheet.panel(Panel::new(&image).title(name));
        }
        let figure = sheet.draw().unwrap();
        let place = |name: &str| -> [f64; 2] {
            let text = figure.svg().lines().find(|line| line.ends_with(&format!(">{name}</text>")));
            let number = |key: &str| {
                let (_, after) = text.unwrap().split_once(&format!("{key}=\"")).unwrap();
                after.split_once('"').unwrap().0.parse().unwrap()
            };
            [number(" x"), number(" y")]
        };
        let [a, b, c] = ["a", "b", "c"].map(place);
        assert!(a[0] < b[0] && a[1].total_cmp(&b[1]).is_eq(), "{a:?} {b:?}");
        assert!(c[0].total_cmp(&a[0]).is_eq() && c[1] > a[1] + 80.0, "{a:?} {c:?}");
        assert!(figure.png(1.0).is_ok());
    }

    #[test]
    fn all_panels_have_the_colours_of_the_first() {
        let [dark, bright] = [1.0, 10.0].map(|v| Image::from_pixels(1, 1, vec![v]));
        let range = ValueRange { low: 0.0, high: 10.0 };
        let panel = |image| Panel::new(image).colour_bar("R").range(range);
        let svg =
            |image| Sheet::new(1).panel(panel(&bright)).panel(Panel::new(image)).draw().unwrap();
        // The second panel's own range would make both of them yellow.
        assert_ne!(svg(&dark), svg(&bright));
        assert_eq!(svg(&dark).svg().matches(">10<").count(), 1, "one bar");
    }

    #[test]
    fn long_names_have_room() {
        let image = Image::zeros(1, 1);
        let name = "a name that is wider than its small panel";
        let figure = Sheet::new(9).panel(Panel::new(&image).title(name).ellipse()).draw().unwrap();
        assert!(figure.width > Text::new(name, TICK_SIZE, Anchor::Middle).width());
        let error = Sheet::new(3).draw().unwrap_err().to_string();
        assert_eq!(error, "a figure without panels: expected at least one");
    }
}
