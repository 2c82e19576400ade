//! The part of a chart that the nodes of pixels are in.

use crate::projection::charts::PieceOfLine;
use crate::projection::charts::chart::Window;
use crate::vol::view::chart_nodes::ChartNode;
use core::f64::consts::{PI, TAU};

/// A window ends at a limb, or at the axis, if that is within this share of its width.
const SNAP: f64 = 0.02;
/// Elsewhere it extends beyond the nodes by this share.
const MARGIN: f64 = 0.01;
/// An azimuth is closed if the largest gap in view is smaller \[rad\].
const LEAST_GAP_RAD: f64 = 0.6;

/// A node of a pixel before the windows are known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NaturalNode {
    pub(crate) chart: usize,
    pub(crate) pixel: usize,
    /// The coordinates (c, φ).
    pub(crate) place: [f64; 2],
    pub(crate) weight: f64,
}

impl NaturalNode {
    /// At a piece of a line of sight with a weight in the pixel.
    pub(crate) fn of_piece(piece: &PieceOfLine, pixel: usize, weight: f64) -> Self {
        let PieceOfLine { chart, place, density } = *piece;
        Self { chart, pixel, place, weight: weight / density }
    }
}

/// The nodes of one pixel.
pub(crate) struct PixelNodes {
    /// Its number.
    pub(super) pixel: usize,
    pub(crate) nodes: Vec<NaturalNode>,
    /// The largest number of pieces of a line.
    pub(super) most_pieces: usize,
    pub(super) is_outside: bool,
}

/// A node in the coordinates of a window.
pub(crate) fn in_window(window: &Window, node: &NaturalNode) -> ChartNode {
    #[expect(clippy::cast_possible_truncation, reason = "a place in single precision")]
    let place = window.unit(node.place).map(|along| along.clamp(0.0, 1.0) as f32);
    ChartNode { pixel: crate::cell::to_u32(node.pixel), place, weight: node.weight }
}

/// Whether a node is in a window, up to rounding.
pub(crate) fn is_in(window: &Window, node: &NaturalNode) -> bool {
    const ROUNDING: f64 = 1e-6;
    window.unit(node.place).iter().all(|along| (-ROUNDING..=1.0 + ROUNDING).contains(along))
}

/// The part of a chart that the nodes at these `places` are in, within natural ends of c and a `sector` of azimuth.
pub(crate) fn window(
    ends: [f64; 2],
    sector: Option<[f64; 2]>,
    places: impl Iterator<Item = [f64; 2]> + Clone,
) -> Window {
    let c = seen(ends, places.clone().map(|place| place[0]));
    if let Some(azimuth_rad @ [begin, width]) = sector {
        let sector = Window { c, azimuth_rad };
        let [low, high] = seen([0.0, 1.0], places.map(|place| sector.unit(place)[1]));
        let [low, high] = [low.max(0.0), high.min(1.0)];
        return Window { c, azimuth_rad: [begin + low * width, (high - low) * width] };
    }
    let azimuth_rad = match widest_gap(places.map(|place| place[1])) {
        Some([before, after]) => {
            let width = (TAU - (after - before)).max(1e-9);
            [(after - MARGIN * width).rem_euclid(TAU), (1.0 + 2.0 * MARGIN) * width]
        }
        None => [0.0, TAU],
    };
    Window { c, azimuth_rad }
}

/// The widest gap of azimuths from −π to π, if it is wider than the least one.
fn widest_gap(azimuths_rad: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    /// Gaps within one of so many parts of the circle are too small to matter.
    const PARTS: usize = 64;
    let mut parts = [[f64::INFINITY, f64::NEG_INFINITY]; PARTS];
    for azimuth in azimuths_rad {
        let share = (azimuth + PI) / TAU;
        let part = crate::cell::whole((share * PARTS as f64).max(0.0)).min(PARTS - 1);
        let [low, high] = parts[part];
        parts[part] = [low.min(azimuth), high.max(azimuth)];
    }
    let seen: Vec<[f64; 2]> = parts.into_iter().filter(|[low, high]| low <= high).collect();
    let around = seen.last().map(|last| [last[1], seen[0][0] + TAU]);
    let gaps = seen.windows(2).map(|pair| [pair[0][1], pair[1][0]]).chain(around);
    let widest = gaps.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
    widest.filter(|[before, after]| after - before >= LEAST_GAP_RAD)
}

/// The part in view of a coordinate with natural ends.
fn seen([first, last]: [f64; 2], along: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let (mut low, mut high) =
        (along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max));
    let width = high - low;
    // Nodes that are added later may be farther out.
    low = if low - first < SNAP * width { first } else { low - MARGIN * width };
    high = if last - high < SNAP * width { last } else { high + MARGIN * width };
    if high <= low {
        // One line of sight: any width will do.
        high = low + 1e-9 * low.abs().max(1e-9);
    }
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_widest_gap_is_between_the_azimuths_beside_it() {
        let gap = |azimuths: &[f64]| widest_gap(azimuths.iter().copied());
        assert_eq!(gap(&[2.5, -3.0, 0.3, 0.2]), Some([-3.0, 0.2]));
        // Across the end of the circle.
        assert_eq!(gap(&[1.0, -1.0, 0.1, -0.1, 0.5, -0.5]), Some([1.0, -1.0 + TAU]));
        assert_eq!(gap(&[]), None);
        assert_eq!(gap(&[0.4]), Some([0.4, 0.4 + TAU]));
        let all: Vec<f64> = (0..20).map(|k| -PI + TAU * f64::from(k) / 20.0).collect();
        assert_eq!(gap(&all), None);
    }
}
