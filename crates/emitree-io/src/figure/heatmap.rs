//! Images as colours, side by side, with axes and colour bars.

use super::axis::{Axis, ResolvedAxis};
use super::frame::{Frame, LABEL_SIZE, MARGIN, SideAxis, TITLE_SIZE};
use super::svg::{Anchor, Rect, Svg, Text};
use super::{Figure, FigureError};
use crate::colour::{ColourMap, ValueRange};
use crate::png::{PictureOptions, encode_png};
use emitree::Image;

/// Images side by side, y up.
///
/// ```
/// use emitree::Image;
/// use emitree_io::figure::{Heatmap, Panel};
///
/// let image = Image::from_pixels(2, 2, vec![0.0, 1.0, 2.0, 3.0]);
/// let figure = Heatmap::new()
///     .panel(
///         Panel::new(&image)
///             .title("four pixels")
///             .x("x", [0.0, 1.0])
///             .y("y", [0.0, 1.0])
///             .colour_bar("radiance [m⁻² sr⁻¹ s⁻¹]"),
///     )
///     .draw()?;
/// assert!(figure.svg().contains("four pixels"));
/// # Ok::<(), emitree_io::figure::FigureError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Heatmap<'a> {
    title: String,
    panels: Vec<Panel<'a>>,
}

/// One image of a [`Heatmap`].
#[derive(Clone, Debug, PartialEq)]
pub struct Panel<'a> {
    image: &'a Image,
    title: String,
    axes: [Axis; 2],
    colour_map: ColourMap,
    range: Option<ValueRange>,
    logarithmic: bool,
    bar: Option<String>,
}

impl<'a> Panel<'a> {
    /// The image with its columns and rows as coordinates, in viridis, without a colour bar.
    pub fn new(image: &'a Image) -> Self {
        Self {
            image,
            title: String::new(),
            axes: [
                Axis::linear("column").range([0.0, length(image.width())]),
                Axis::linear("row").range([0.0, length(image.height())]),
            ],
            colour_map: ColourMap::default(),
            range: None,
            logarithmic: false,
            bar: None,
        }
    }

    /// The title above the panel.
    #[must_use]
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// The label of the x axis, and its values at the left and right edges of the image.
    #[must_use]
    pub fn x(mut self, label: impl Into<String>, edges: [f64; 2]) -> Self {
        self.axes[0] = Axis::linear(label).range(edges);
        self
    }

    /// The label of the y axis, and its values at the lower and upper edges of the image. The panel
    /// has the proportions of the two ranges.
    #[must_use]
    pub fn y(mut self, label: impl Into<String>, edges: [f64; 2]) -> Self {
        self.axes[1] = Axis::linear(label).range(edges);
        self
    }

    /// The colour map.
    #[must_use]
    pub fn colour_map(mut self, map: ColourMap) -> Self {
        self.colour_map = map;
        self
    }

    /// The values of the first and the last colour; without it [`ValueRange::of`] the image.
    #[must_use]
    pub fn range(mut self, range: ValueRange) -> Self {
        self.range = Some(range);
        self
    }

    /// Equal steps of colour for equal ratios, for maps of errors. Without a [`range`](Self::range)
    /// the colours start at the smallest positive pixel; pixels below get the first colour.
    #[must_use]
    pub fn logarithmic(mut self) -> Self {
        self.logarithmic = true;
        self
    }

    /// A colour bar to the right, with what the colours mean and their unit.
    #[must_use]
    pub fn colour_bar(mut self, label: impl Into<String>) -> Self {
        self.bar = Some(label.into());
        self
    }

    /// The axis of colours.
    fn colours(&self) -> Result<ResolvedAxis, FigureError> {
        let label = self.bar.as_deref().unwrap_or("colours");
        let all = ValueRange::of(&[self.image]);
        let ValueRange { low, high } = self.range.unwrap_or(if self.logarithmic {
            let positive = self.image.pixels().iter().filter(|&&pixel| pixel > 0.0);
            let lowest = positive.fold(f64::INFINITY, |lowest, &pixel| lowest.min(pixel));
            // One value alone still needs a span of colours.
            ValueRange { low: lowest.min(0.1 * all.high), ..all }
        } else {
            all
        });
        let axis = if self.logarithmic { Axis::log(label) } else { Axis::linear(label) };
        axis.range([low, high]).resolve(std::iter::empty())
    }

    /// The picture, its colours linear between 0 and 1.
    fn picture(&self, colours: ResolvedAxis) -> Result<Vec<u8>, FigureError> {
        let fraction = |&pixel: &f64| {
            // The logarithm of what is not positive is no number, but the pixel is one.
            if colours.logarithmic && pixel <= 0.0 { 0.0 } else { colours.fraction(pixel) }
        };
        let fractions = self.image.pixels().iter().map(fraction).collect();
        let (height, width) = (self.image.height(), self.image.width());
        encode(&Image::from_pixels(height, width, fractions), self.colour_map)
    }
}

fn encode(fractions: &Image, colour_map: ColourMap) -> Result<Vec<u8>, FigureError> {
    let range = Some(ValueRange { low: 0.0, high: 1.0 });
    Ok(encode_png(fractions, &PictureOptions { colour_map, range, ..Default::default() })?)
}

/// The longer edge of a panel, about; a multiple of many usual numbers of pixels.
const EDGE: f64 = 320.0;
const BAR_GAP: f64 = 12.0;
const BAR_WIDTH: f64 = 14.0;
const PANEL_GAP: f64 = 18.0;

impl<'a> Heatmap<'a> {
    /// A figure without panels.
    pub fn new() -> Self {
        Self::default()
    }

    /// The title above all panels.
    #[must_use]
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// One more panel, to the right of those before.
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
        let ready = self.panels.iter().map(Ready::of).collect::<Result<Vec<_>, _>>()?;
        if ready.is_empty() {
            return Err(FigureError::Empty { missing: "panels" });
        }
        let line = |text: &str, size| if text.is_empty() { 0.0 } else { size + 8.0 };
        let panel_titles = self.panels.iter().map(|p| line(&p.title, LABEL_SIZE));
        let panel_title = panel_titles.fold(0.0, f64::max);
        let top = (MARGIN + line(&self.title, TITLE_SIZE) + panel_title).ceil();
        let tallest = ready.iter().map(|panel| panel.size[1]).fold(0.0, f64::max);

        let mut svg = Svg::default();
        let (mut x, mut bottom) = (MARGIN, 0.0_f64);
        for panel in &ready {
            let [width, height] = panel.size;
            let left = (x + panel.left()).ceil();
            let area = Rect { left, top: top + (0.5 * (tallest - height)).floor(), width, height };
            panel.draw(&mut svg, area)?;
            x = area.right() + panel.right() + PANEL_GAP;
            bottom = bottom.max(area.bottom() + panel.frame.bottom());
        }
        let title = Text::new(&self.title, TITLE_SIZE, Anchor::Middle);
        let right = (x - PANEL_GAP + MARGIN).max(title.width() + 2.0 * MARGIN).ceil();
        svg.text([0.5 * right, MARGIN + 0.5 * TITLE_SIZE], title);
        Ok(svg.finish(right, (bottom + MARGIN).ceil()))
    }
}

/// A panel whose size and ranges are settled.
struct Ready<'a> {
    panel: &'a Panel<'a>,
    size: [f64; 2],
    crisp: bool,
    frame: Frame<'a>,
    colours: ResolvedAxis,
    bar: Option<SideAxis<'a>>,
}

impl<'a> Ready<'a> {
    fn of(panel: &'a Panel<'a>) -> Result<Self, FigureError> {
        let resolve = |axis: &Axis| axis.resolve(std::iter::empty());
        let resolved = [resolve(&panel.axes[0])?, resolve(&panel.axes[1])?];
        let [extent_x, extent_y] = resolved.map(|axis| axis.high - axis.low);
        // A strip thinner than 1:6 would leave no room for its labels.
        let proportion = (extent_x / extent_y).clamp(1.0 / 6.0, 6.0);
        let wanted = [EDGE * proportion.min(1.0), EDGE / proportion.max(1.0)];
        let pixels = [length(panel.image.width()), length(panel.image.height())];
        let size = std::array::from_fn(|i| edge(wanted[i], pixels[i]));
        let crisp = pixels[0] <= 2.0 * size[0] && pixels[1] <= 2.0 * size[1];
        let colours = panel.colours()?;
        let [x, y] = &panel.axes;
        let frame = Frame::new([x, y], resolved, size);
        let bar = panel.bar.as_deref().map(|label| SideAxis::new(label, colours, size[1]));
        Ok(Self { panel, size, crisp, frame, colours, bar })
    }

    fn title(&self) -> Text<'_> {
        Text::new(&self.panel.title, LABEL_SIZE, Anchor::Middle)
    }

    /// Half of what of the title stands out to each side.
    fn overhang(&self) -> f64 {
        0.5 * (self.title().width() - self.size[0])
    }

    fn left(&self) -> f64 {
        self.frame.left().max(self.overhang())
    }

    fn right(&self) -> f64 {
        let bar = self.bar.as_ref().map_or(0.0, |bar| BAR_GAP + BAR_WIDTH + bar.right());
        bar.max(self.frame.right()).max(self.overhang())
    }

    fn draw(&self, svg: &mut Svg, area: Rect) -> Result<(), FigureError> {
        svg.image(area, &self.panel.picture(self.colours)?, self.crisp);
        self.frame.draw(svg, area);
        svg.text([area.left + 0.5 * area.width, area.top - 0.5 * LABEL_SIZE - 4.0], self.title());
        if let Some(bar) = &self.bar {
            let left = area.right() + BAR_GAP;
            let area = Rect { left, width: BAR_WIDTH, ..area };
            let steps = (0_u8..=255).map(|step| f64::from(step) / 255.0).collect();
            let gradient = Image::from_pixels(256, 1, steps);
            svg.image(area, &encode(&gradient, self.panel.colour_map)?, true);
            bar.draw(svg, area);
        }
        Ok(())
    }
}

/// The edge of a panel near the `wanted` one. Where the image's pixels are small, unequal ones would
/// show, so that each gets a whole number of halves, which are device pixels at scale 2.
fn edge(wanted: f64, pixels: f64) -> f64 {
    let halves = 2.0 * wanted / pixels;
    let whole = 0.5 * halves.round().max(1.0) * pixels;
    let near = (whole / wanted - 1.0).abs() < 0.25;
    if halves < 6.0 && near { whole } else { wanted }
}

/// A number of pixels as f64.
#[expect(clippy::cast_precision_loss, reason = "exact below 2^53")]
fn length(pixels: usize) -> f64 {
    pixels as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_pixels_get_whole_device_pixels() {
        for pixels in [3.0, 50.0, 64.0, 100.0, 128.0, 200.0, 256.0, 500.0, 640.0] {
            let edge = edge(EDGE, pixels);
            assert!((edge / EDGE - 1.0).abs() < 0.25, "{pixels}");
            let device = 2.0 * edge / pixels;
            assert!(device >= 6.0 || device.fract() < 1e-9, "{pixels}: {device}");
        }
    }

    #[test]
    fn logarithmic_colours_need_no_positive_pixels_but_one() {
        let image = Image::from_pixels(1, 4, vec![-1.0, 0.0, f64::NAN, 2.0]);
        let panel = Panel::new(&image).logarithmic();
        let colours = panel.colours().unwrap();
        assert!(colours.low > 0.0 && colours.low < colours.high);
        assert!(Heatmap::new().panel(panel).draw().unwrap().png(1.0).is_ok());
        let dark = Image::zeros(2, 2);
        assert!(Heatmap::new().panel(Panel::new(&dark).logarithmic()).draw().is_ok());
    }

    #[test]
    fn what_cannot_be_drawn_is_named() {
        let message = |figure: Heatmap<'_>| figure.draw().unwrap_err().to_string();
        assert_eq!(message(Heatmap::new()), "a figure without panels: expected at least one");
        let empty = Image::zeros(0, 3);
        assert!(message(Heatmap::new().panel(Panel::new(&empty))).contains("`row` from 0 to 0"));
    }
}
