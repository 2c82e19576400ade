//! The nodes of a pixel without edges at its corners, whose lines of sight are those of four pixels, and in its middle.
//!
//! The weights are those of Simpson's rule without the middles of sides: exact for polynomials of degree 3.

use crate::projection::charts::{Atlas, PieceOfLine};
use crate::vol::view::crossings::Corner;
use crate::vol::view::windows::{NaturalNode, PixelNodes};

/// The weights of the middle of a pixel and of each corner.
const MIDDLE: f64 = 2.0 / 3.0;
const OF_CORNER: f64 = 1.0 / 12.0;

/// The line of sight at a corner of pixels, or in the middle of one.
pub(crate) struct LineAtCorner {
    /// The density of solid angle.
    density: f64,
    pieces: Vec<PieceOfLine>,
}

impl LineAtCorner {
    pub(crate) fn new(corner: &Corner, atlas: &Atlas<'_>) -> Self {
        Self { density: corner.density, pieces: corner.pieces(atlas) }
    }
}

/// The nodes of a pixel, given the lines at its corners, two of each border, and in its middle.
pub(crate) fn nodes_of_corners(
    pixel: usize,
    borders: [&[LineAtCorner]; 2],
    middle: &LineAtCorner,
) -> PixelNodes {
    let corners = borders.into_iter().flatten().map(|line| (line, OF_CORNER));
    let lines = || corners.clone().chain([(middle, MIDDLE)]);
    let whole: f64 = lines().map(|(line, weight)| weight * line.density).sum();
    let is_outside = whole.is_nan() || whole <= 0.0;
    let mut nodes = Vec::new();
    if !is_outside {
        for (line, weight) in lines() {
            let weight = weight / whole * line.density;
            let of_pieces =
                line.pieces.iter().map(|piece| NaturalNode::of_piece(piece, pixel, weight));
            nodes.extend(of_pieces.filter(|node| node.weight != 0.0));
        }
    }
    let most_pieces = lines().map(|(line, _)| line.pieces.len()).max().unwrap_or(0);
    PixelNodes { pixel, nodes, most_pieces, is_outside }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(place: [f64; 2], density: f64) -> LineAtCorner {
        LineAtCorner { density, pieces: vec![PieceOfLine { chart: 0, place, density: 1.0 }] }
    }

    /// The nodes of the pixel from (1, 2) to (1.5, 2.5), with this density of solid angle.
    fn nodes(density: impl Fn([f64; 2]) -> f64) -> PixelNodes {
        let at = |x: f64, y: f64| line([x, y], density([x, y]));
        let [below, above] = [2.0, 2.5].map(|y| [at(1.0, y), at(1.5, y)]);
        nodes_of_corners(7, [&below, &above], &at(1.25, 2.25))
    }

    #[test]
    fn means_of_cubics_are_exact() {
        let found = nodes(|_| 0.3);
        assert!(found.nodes.len() == 5 && !found.is_outside && found.most_pieces == 1);
        // The mean of xⁿ over the interval.
        let mean = |[from, to]: [f64; 2], n: i32| {
            (to.powi(n + 1) - from.powi(n + 1)) / (f64::from(n + 1) * (to - from))
        };
        for (n, m) in [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (3, 0), (2, 1), (1, 2), (0, 3)] {
            let value = |node: &NaturalNode| node.place[0].powi(n) * node.place[1].powi(m);
            let sum: f64 = found.nodes.iter().map(|node| node.weight * value(node)).sum();
            let exact = mean([1.0, 1.5], n) * mean([2.0, 2.5], m);
            assert!((sum / exact - 1.0).abs() < 1e-14, "{n} {m}: {sum} {exact}");
        }
    }

    #[test]
    fn lines_weigh_as_much_as_their_solid_angle() {
        // Beside a pole the density falls to 0: these corners are no nodes.
        let found = nodes(|[_, y]| 2.5 - y);
        assert_eq!(found.nodes.len(), 3);
        let sum: f64 = found.nodes.iter().map(|node| node.weight).sum();
        assert!((sum - 1.0).abs() < 1e-15, "{sum}");
        assert!(nodes(|_| 0.0).is_outside && nodes(|_| f64::NAN).nodes.is_empty());
    }
}
