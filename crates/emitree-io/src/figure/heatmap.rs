//! Images as colours, side by side, with axes and colour bars.

use super::axis::{Axis, ResolvedAxis};
use super::frame::{Frame, LABEL_SIZE, MARGIN, SideAxis, TITLE_SIZE};
use super::panel::{Border, Panel, encode, length};
use super::svg::{Anchor, INK, Rect, Stroke, Svg, Text};
use super::{Figure, FigureError};
use crate::colour::ColourMap;
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

/// The longer edge of a panel, about; a multiple of many usual numbers of pixels.
const EDGE: f64 = 320.0;
pub(super) const BAR_GAP: f64 = 12.0;
pub(super) const BAR_WIDTH: f64 = 14.0;
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
        // A label that reads upwards may be longer than its panel is high.
        let tallest = ready.iter().map(Ready::height).fold(0.0, f64::max);

        let mut svg = Svg::default();
        let (mut x, mut bottom) = (MARGIN, 0.0_f64);
        for panel in &ready {
            let [width, height] = panel.size;
            let left = (x + panel.left()).ceil();
            let area = Rect { left, top: top + (0.5 * (tallest - height)).floor(), width, height };
            panel.draw(&mut svg, area)?;
            x = area.right() + panel.right() + PANEL_GAP;
            bottom = bottom.max(area.bottom() + panel.below()).max(top + tallest);
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
    /// None without axes.
    frame: Option<Frame<'a>>,
    colours: ResolvedAxis,
    bar: Option<SideAxis<'a>>,
}

impl<'a> Ready<'a> {
    fn of(panel: &'a Panel<'a>) -> Result<Self, FigureError> {
        let resolve = |axis: &Axis| axis.resolve(std::iter::empty());
        let resolved = [resolve(&panel.axes[0])?, resolve(&panel.axes[1])?];
        let size = edges(proportion(panel)?, pixels(panel));
        let crisp = is_crisp(panel, size);
        let colours = panel.colours()?;
        let [x, y] = &panel.axes;
        let has_axes = panel.border == Border::Axes;
        let frame = has_axes.then(|| Frame::new([x, y], resolved, size));
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

    /// The height of the panel or of its longest label beside it.
    fn height(&self) -> f64 {
        let of_axis = self.frame.as_ref().map_or(0.0, Frame::upright_length);
        let of_bar = self.bar.as_ref().map_or(0.0, SideAxis::upright_length);
        self.size[1].max(of_axis).max(of_bar)
    }

    fn left(&self) -> f64 {
        self.frame.as_ref().map_or(0.0, Frame::left).max(self.overhang())
    }

    fn right(&self) -> f64 {
        let bar = self.bar.as_ref().map_or(0.0, |bar| BAR_GAP + BAR_WIDTH + bar.right());
        bar.max(self.frame.as_ref().map_or(0.0, Frame::right)).max(self.overhang())
    }

    fn below(&self) -> f64 {
        self.frame.as_ref().map_or(0.0, Frame::bottom)
    }

    fn draw(&self, svg: &mut Svg, area: Rect) -> Result<(), FigureError> {
        draw_picture(svg, area, self.panel, self.colours, self.crisp)?;
        if let Some(frame) = &self.frame {
            frame.draw(svg, area);
        }
        svg.text([area.left + 0.5 * area.width, area.top - 0.5 * LABEL_SIZE - 4.0], self.title());
        if let Some(bar) = &self.bar {
            let left = area.right() + BAR_GAP;
            let area = Rect { left, width: BAR_WIDTH, ..area };
            draw_bar(svg, area, bar, self.panel.colour_map)?;
        }
        Ok(())
    }
}

/// Columns and rows.
fn pixels(panel: &Panel<'_>) -> [f64; 2] {
    [length(panel.image.width()), length(panel.image.height())]
}

/// The width of a panel over its height.
pub(super) fn proportion(panel: &Panel<'_>) -> Result<f64, FigureError> {
    let resolve = |axis: &Axis| axis.resolve(std::iter::empty());
    let resolved = [resolve(&panel.axes[0])?, resolve(&panel.axes[1])?];
    let [x, y] = if panel.square_pixels { pixels(panel) } else { resolved.map(|a| a.extent()) };
    Ok(x / y)
}

/// Whether the pixels of a panel of this size are to have sharp edges.
pub(super) fn is_crisp(panel: &Panel<'_>, size: [f64; 2]) -> bool {
    pixels(panel).iter().zip(size).all(|(pixels, edge)| *pixels <= 2.0 * edge)
}

/// The pixels of a panel, with the line about its ellipse if it has one.
pub(super) fn draw_picture(
    svg: &mut Svg,
    area: Rect,
    panel: &Panel<'_>,
    colours: ResolvedAxis,
    crisp: bool,
) -> Result<(), FigureError> {
    let picture = panel.picture(colours)?;
    match panel.border {
        Border::Axes => svg.image(area, &picture, crisp),
        // Pixels at the rim are partly outside.
        Border::Ellipse => {
            svg.clipped_to_ellipse(area, |svg| svg.image(area, &picture, crisp));
            svg.ellipse(area, None, Some(Stroke::solid(INK, 1.0)));
        }
    }
    Ok(())
}

/// A colour bar with its axis.
pub(super) fn draw_bar(
    svg: &mut Svg,
    area: Rect,
    bar: &SideAxis<'_>,
    colour_map: ColourMap,
) -> Result<(), FigureError> {
    let steps = (0_u8..=255).map(|step| f64::from(step) / 255.0).collect();
    let gradient = Image::from_pixels(256, 1, steps);
    svg.image(area, &encode(&gradient, colour_map)?, true);
    bar.draw(svg, area);
    Ok(())
}

/// Width and height of a panel of this proportion. A thin strip is longer than others, so that its
/// labels have room; one thinner than 1:24 loses its proportion.
fn edges(proportion: f64, pixels: [f64; 2]) -> [f64; 2] {
    const THINNEST: f64 = EDGE / 6.0;
    const LONGEST: f64 = 4.0 * EDGE;
    let shape = [proportion.min(1.0), 1.0 / proportion.max(1.0)];
    let longer = (THINNEST / (EDGE * shape[0].min(shape[1]))).clamp(1.0, LONGEST / EDGE);
    let wanted = shape.map(|along| (EDGE * longer * along).max(THINNEST));
    let whole: [f64; 2] = std::array::from_fn(|i| edge(wanted[i], pixels[i]));
    // Whole pixels must not cost the proportion: not all pixels are square.
    let skew = (whole[0] / whole[1]) / (wanted[0] / wanted[1]) - 1.0;
    if skew.abs() < 0.01 { whole } else { wanted }
}

/// The edge of a panel near the `wanted` one. Where the image's pixels are small, unequal ones would
/// show, so that each gets a whole number of halves, which are device pixels at scale 2.
fn edge(wanted: f64, pixels: f64) -> f64 {
    let halves = 2.0 * wanted / pixels;
    let whole = 0.5 * halves.round().max(1.0) * pixels;
    let near = (whole / wanted - 1.0).abs() < 0.25;
    if halves < 6.0 && near { whole } else { wanted }
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
    fn panels_keep_their_proportions() {
        for proportion in [0.05, 0.2, 0.59, 1.0, 1.5, 2.0, 7.0, 20.0] {
            for pixels in [[50.0, 100.0], [64.0, 64.0], [240.0, 180.0], [500.0, 20.0]] {
                let [width, height] = edges(proportion, pixels);
                assert!((width / height / proportion - 1.0).abs() < 0.0101, "{proportion}");
                assert!(width.min(height) > 0.75 * EDGE / 6.0, "{proportion} {pixels:?}");
            }
        }
        assert!(edges(1.0, [64.0, 64.0]).iter().all(|edge| (edge - EDGE).abs() < 1e-9));
        let [width, height] = edges(1e9, [64.0, 64.0]);
        assert!(width / height > 20.0 && height > 50.0, "{width} {height}");
    }

    /// Colours of the pixels of a figure at scale 1.
    fn pixels(figure: &Figure) -> (usize, Vec<[u8; 4]>) {
        let bytes = figure.png(1.0).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        let colours = pixels.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect();
        (info.width as usize, colours)
    }

    #[test]
    fn what_is_no_number_is_blank() {
        let image = Image::from_pixels(1, 2, vec![1.0, f64::NAN]);
        for panel in [Panel::new(&image), Panel::new(&image).logarithmic()] {
            let figure = Heatmap::new().panel(panel).draw().unwrap();
            let (width, colours) = pixels(&figure);
            let row = colours.len() / width / 2;
            let row = &colours[row * width..(row + 1) * width];
            let yellow = ColourMap::Viridis.rgb(1.0);
            let is_yellow = |c: &&[u8; 4]| c[..3] == yellow;
            assert!(row.iter().filter(is_yellow).count() > 100);
            assert!(!row.contains(&[128, 128, 128, 255]));
            assert!(row.iter().filter(|c| **c == [255; 4]).count() > 100);
        }
    }

    #[test]
    fn tiny_values_have_labels() {
        let image = Image::from_pixels(1, 2, vec![1e-23, 3.2e-23]);
        let panel = || Panel::new(&image).colour_bar("radiance");
        let svg = |panel: Panel<'_>| Heatmap::new().panel(panel).draw().unwrap().svg().to_owned();
        assert!(svg(panel()).contains(">3×10⁻²³<"));
        assert!(svg(panel().logarithmic()).contains(">2×10⁻²³<"));
    }

    #[test]
    fn long_labels_of_low_panels_are_not_cut_off() {
        let image = Image::zeros(1, 24);
        let label = "a label that is much longer than its panel is high, by far";
        let panel = Panel::new(&image).square_pixels().colour_bar(label);
        let figure = Heatmap::new().panel(panel).draw().unwrap();
        assert!(figure.height > Text::new(label, LABEL_SIZE, Anchor::Middle).width());
    }

    #[test]
    fn what_cannot_be_drawn_is_named() {
        let message = |figure: Heatmap<'_>| figure.draw().unwrap_err().to_string();
        assert_eq!(message(Heatmap::new()), "a figure without panels: expected at least one");
        let empty = Image::zeros(0, 3);
        assert!(message(Heatmap::new().panel(Panel::new(&empty))).contains("`row` from 0 to 0"));
    }
}
