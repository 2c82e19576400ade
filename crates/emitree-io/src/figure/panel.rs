//! One image with its axes and its colours.

use super::FigureError;
use super::axis::{Axis, ResolvedAxis, Scale};
use crate::colour::{ColourMap, ValueRange};
use crate::png::{PictureOptions, encode_png};
use emitree::Image;

/// One image of a [`Heatmap`](super::Heatmap).
#[derive(Clone, Debug, PartialEq)]
pub struct Panel<'a> {
    pub(super) image: &'a Image,
    pub(super) title: String,
    pub(super) axes: [Axis; 2],
    pub(super) border: Border,
    pub(super) square_pixels: bool,
    pub(super) colour_map: ColourMap,
    range: Option<ValueRange>,
    logarithmic: bool,
    pub(super) bar: Option<String>,
}

/// What is around an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Border {
    /// A box with ticks and labels.
    Axes,
    /// A line about the ellipse that fills the image.
    Ellipse,
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
            border: Border::Axes,
            square_pixels: false,
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

    /// Both axes, each with its [`range`](Axis::range): the values at the edges of the image.
    ///
    /// ```
    /// use emitree::Image;
    /// use emitree_io::figure::{Axis, Heatmap, Panel};
    ///
    /// let image = Image::from_pixels(1, 2, vec![0.0, 1.0]);
    /// let across = Axis::tangent("to the right [deg]").range([-20.0, 20.0]);
    /// let up = Axis::tangent("up [deg]").range([-10.0, 10.0]);
    /// let figure = Heatmap::new().panel(Panel::new(&image).axes(across, up)).draw()?;
    /// assert!(figure.svg().contains("to the right [deg]"));
    /// # Ok::<(), emitree_io::figure::FigureError>(())
    /// ```
    #[must_use]
    pub fn axes(mut self, x: Axis, y: Axis) -> Self {
        self.axes = [x, y];
        self
    }

    /// The proportions of the image and not of the axes, for axes that have nothing in common.
    #[must_use]
    pub fn square_pixels(mut self) -> Self {
        self.square_pixels = true;
        self
    }

    /// No axes: a line about the ellipse that fills the image, for a disc or a map of the sphere.
    /// The panel has the proportions of the image.
    ///
    /// ```
    /// use emitree::Image;
    /// use emitree_io::figure::{Heatmap, Panel};
    ///
    /// let image = Image::from_pixels(1, 1, vec![1.0]);
    /// let figure = Heatmap::new().panel(Panel::new(&image).ellipse()).draw()?;
    /// assert!(figure.svg().contains("<ellipse") && !figure.svg().contains("column"));
    /// # Ok::<(), emitree_io::figure::FigureError>(())
    /// ```
    #[must_use]
    pub fn ellipse(mut self) -> Self {
        self.border = Border::Ellipse;
        self.square_pixels = true;
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

    /// Colours on a logarithmic scale, for maps of errors. Without a [`range`](Self::range)
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
    pub(super) fn colours(&self) -> Result<ResolvedAxis, FigureError> {
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

    /// The picture, its colours linear between 0 and 1; what is no number is blank.
    pub(super) fn picture(&self, colours: ResolvedAxis) -> Result<Vec<u8>, FigureError> {
        let fraction = |&pixel: &f64| {
            // The logarithm of what is not positive is no number, but the pixel is one.
            if colours.scale == Scale::Logarithmic && pixel <= 0.0 {
                0.0
            } else {
                colours.fraction(pixel)
            }
        };
        let fractions = self.image.pixels().iter().map(fraction).collect();
        let (height, width) = (self.image.height(), self.image.width());
        encode(&Image::from_pixels(height, width, fractions), self.colour_map)
    }
}

pub(super) fn encode(fractions: &Image, colour_map: ColourMap) -> Result<Vec<u8>, FigureError> {
    let range = Some(ValueRange { low: 0.0, high: 1.0 });
    let blank_outside = fractions.pixels().iter().any(|fraction| fraction.is_nan());
    let options = PictureOptions { colour_map, range, blank_outside, ..Default::default() };
    Ok(encode_png(fractions, &options)?)
}

/// A number of pixels as f64.
#[expect(clippy::cast_precision_loss, reason = "exact below 2^53")]
pub(super) fn length(pixels: usize) -> f64 {
    pixels as f64
}
