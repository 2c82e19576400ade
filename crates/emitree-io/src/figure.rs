//! Annotated pictures and plots: axes, labels, colour bars and legends for the documentation.
//!
//! A [`Heatmap`] shows images side by side, a [`Sheet`] many in a grid, a [`Plot`] lines and markers.
//! All draw a [`Figure`]:
//! an SVG text, turned into PNG with a renderer and a font that are part of this crate, so that a
//! figure looks the same on every machine.
//!
//! ```
//! use emitree_io::figure::{Axis, Plot, Series};
//!
//! let figure = Plot::new(Axis::log("evaluations"), Axis::log("largest error / largest pixel"))
//!     .series(Series::line("trees", [[512.0, 0.3], [4096.0, 0.04], [19136.0, 0.006]]).marked())
//!     .horizontal_line(0.01, "1 %")
//!     .draw()?;
//! let bytes = figure.png(2.0)?; // two device pixels for each unit of the SVG
//! # Ok::<(), emitree_io::figure::FigureError>(())
//! ```

mod axis;
mod font;
mod frame;
mod heatmap;
mod marker;
mod panel;
mod placement;
mod plot;
mod sheet;
mod svg;
mod ticks;

pub use axis::Axis;
pub use heatmap::Heatmap;
pub use marker::Series;
pub use panel::Panel;
pub use plot::Plot;
pub use sheet::Sheet;

use crate::png::PictureError;
use resvg::{tiny_skia, usvg};

/// A figure that can't be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FigureError {
    /// There is nothing to see.
    #[error("a figure without {missing}: expected at least one")]
    Empty {
        /// What there is none of.
        missing: &'static str,
    },
    /// The ends of an axis are not in order, or not positive where the axis is logarithmic.
    #[error("the axis `{label}` from {low} to {high}: expected {expected}")]
    Range {
        /// The label of the axis.
        label: String,
        /// The lower end.
        low: f64,
        /// The upper end.
        high: f64,
        /// What would do.
        expected: &'static str,
    },
    /// The logarithm does not exist.
    #[error("{value} on the logarithmic axis `{label}`: expected positive values")]
    NotPositive {
        /// The label of the axis.
        label: String,
        /// The value.
        value: f64,
    },
    /// The pixels of a panel could not be encoded.
    #[error("a panel: {0}")]
    Picture(#[from] PictureError),
    /// The picture would have no pixels or too many.
    #[error("a picture of {width} x {height} units at scale {scale}: expected a smaller one")]
    Size {
        /// The width in units of the SVG.
        width: f64,
        /// The height in units of the SVG.
        height: f64,
        /// Device pixels in a unit.
        scale: f64,
    },
    /// The renderer refused the SVG.
    #[error("cannot render the figure: {0}")]
    Render(String),
}

/// A drawn figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    svg: String,
    width: f64,
    height: f64,
}

impl Figure {
    /// The figure as SVG. It names the font `DejaVu Sans` without holding it.
    pub fn svg(&self) -> &str {
        &self.svg
    }

    /// The bytes of a PNG file with `scale` device pixels in each unit of the SVG; 2 is good for
    /// screens and text.
    ///
    /// # Errors
    ///
    /// [`FigureError::Size`] if there would be no pixels or too many for the memory's addresses.
    pub fn png(&self, scale: f64) -> Result<Vec<u8>, FigureError> {
        let (width, height) = (self.width, self.height);
        let options = font::options();
        let tree = usvg::Tree::from_str(&self.svg, &options)
            .map_err(|error| FigureError::Render(error.to_string()))?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "saturates; a picture of that size is refused"
        )]
        let pixels = |length: f64| (length * scale).ceil() as u32;
        let mut picture = tiny_skia::Pixmap::new(pixels(width), pixels(height))
            .ok_or(FigureError::Size { width, height, scale })?;
        #[expect(clippy::cast_possible_truncation, reason = "the renderer computes with f32")]
        let transform = tiny_skia::Transform::from_scale(scale as f32, scale as f32);
        resvg::render(&tree, transform, &mut picture.as_mut());
        picture.encode_png().map_err(|error| FigureError::Render(error.to_string()))
    }
}
