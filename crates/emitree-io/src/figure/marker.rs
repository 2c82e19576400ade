//! A series of points, and what distinguishes it from others: colour, dashes, marker.

use super::svg::{Rgb, Stroke, Svg};

/// Colours that differ for colour-blind eyes, too: Okabe & Ito 2008, "Color Universal Design",
/// without the yellow that is lost on white.
pub(super) const PALETTE: [Rgb; 7] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [230, 159, 0],
    [86, 180, 233],
    [0, 0, 0],
];

/// Points of a plot that belong together.
///
/// ```
/// use emitree_io::figure::Series;
///
/// let points = [[512.0, 0.3], [4096.0, 0.04]];
/// let measured = Series::line("measured", points).marked().colour(0);
/// let predicted = Series::line("predicted", points).dashed().colour(0);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    pub(super) label: String,
    pub(super) points: Vec<[f64; 2]>,
    /// The lengths of dashes and gaps; none for no line at all.
    dashes: Option<&'static str>,
    marked: bool,
    colour: Option<usize>,
}

impl Series {
    /// A solid line through `points`, each \[x, y\]; a point that is not finite breaks it. An empty
    /// label keeps it out of the legend.
    pub fn line(label: impl Into<String>, points: impl Into<Vec<[f64; 2]>>) -> Self {
        let (label, points) = (label.into(), points.into());
        Self { label, points, dashes: Some(""), marked: false, colour: None }
    }

    /// A marker at each of `points`, without a line.
    pub fn markers(label: impl Into<String>, points: impl Into<Vec<[f64; 2]>>) -> Self {
        Self { dashes: None, marked: true, ..Self::line(label, points) }
    }

    /// Markers besides the line.
    #[must_use]
    pub fn marked(self) -> Self {
        Self { marked: true, ..self }
    }

    /// A dashed line.
    #[must_use]
    pub fn dashed(self) -> Self {
        Self { dashes: Some("7 4"), ..self }
    }

    /// A dotted line.
    #[must_use]
    pub fn dotted(self) -> Self {
        Self { dashes: Some("2 3"), ..self }
    }

    /// The colour and marker of the series with this `number`, counted from 0, for series that
    /// belong together. Without it each series has the next one.
    #[must_use]
    pub fn colour(self, number: usize) -> Self {
        Self { colour: Some(number), ..self }
    }

    /// The appearance of the series with this `number`.
    pub(super) fn look(&self, number: usize) -> Look {
        let number = self.colour.unwrap_or(number);
        let colour = PALETTE[number % PALETTE.len()];
        // Shapes shift by one when the colours begin again, so that no look comes twice.
        let shape = SHAPES[(number + number / PALETTE.len()) % SHAPES.len()];
        Look {
            stroke: self.dashes.map(|dashes| Stroke { colour, width: 1.8, dashes }),
            marker: self.marked.then_some((shape, colour)),
        }
    }
}

/// What distinguishes a series from others.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    pub(super) stroke: Option<Stroke>,
    pub(super) marker: Option<(Shape, Rgb)>,
}

impl Look {
    pub(super) fn draw_marker(&self, svg: &mut Svg, at: [f64; 2]) {
        let Some((shape, colour)) = self.marker else {
            return;
        };
        match shape {
            Shape::Circle => svg.circle(at, 4.0, colour),
            Shape::Polygon(corners) => {
                let points: Vec<_> =
                    corners.iter().map(|[x, y]| [at[0] + 4.0 * x, at[1] + 4.0 * y]).collect();
                svg.polygon(&points, colour);
            }
        }
    }
}

/// The shape of a marker, in units of its radius.
#[derive(Clone, Copy, Debug)]
pub(super) enum Shape {
    Circle,
    Polygon(&'static [[f64; 2]]),
}

/// Shapes of about the same area.
const SHAPES: [Shape; 7] = [
    Shape::Circle,
    Shape::Polygon(&[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]]),
    Shape::Polygon(&[[0.0, -1.3], [1.2, 0.8], [-1.2, 0.8]]),
    Shape::Polygon(&[[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]]),
    Shape::Polygon(&[[0.0, 1.3], [1.2, -0.8], [-1.2, -0.8]]),
    Shape::Polygon(&[[1.3, 0.0], [-0.8, 1.2], [-0.8, -1.2]]),
    Shape::Polygon(&[[-1.3, 0.0], [0.8, 1.2], [0.8, -1.2]]),
];
