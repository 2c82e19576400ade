//! The part of a chart that the nodes of pixels are in.

use crate::projection::charts::chart::Window;
use crate::vol::view::chart_nodes::ChartNode;
use core::f64::consts::TAU;

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

/// A node in the coordinates of a window.
pub(crate) fn in_window(window: &Window, node: &NaturalNode) -> ChartNode {
    #[expect(clippy::cast_possible_truncation, reason = "a place in single precision")]
    let place = window.unit(node.place).map(|along| along.clamp(0.0, 1.0) as f32);
    ChartNode { pixel: crate::cell::to_u32(node.pixel), place, weight: node.weight }
}

/// The part of a chart that nodes are in, within natural ends of c and a `sector` of azimuth.
pub(crate) fn window(ends: [f64; 2], sector: Option<[f64; 2]>, nodes: &[NaturalNode]) -> Window {
    let c = seen(ends, nodes.iter().map(|node| node.place[0]));
    if let Some(azimuth_rad @ [begin, width]) = sector {
        let sector = Window { c, azimuth_rad };
        let [low, high] = seen([0.0, 1.0], nodes.iter().map(|node| sector.unit(node.place)[1]));
        let [low, high] = [low.max(0.0), high.min(1.0)];
        return Window { c, azimuth_rad: [begin + low * width, (high - low) * width] };
    }
    let mut azimuths: Vec<f64> = nodes.iter().map(|node| node.place[1]).collect();
    azimuths.sort_unstable_by(f64::total_cmp);
    let ends = azimuths.last().map(|last| (*last, azimuths[0] + TAU));
    let gaps = azimuths.windows(2).map(|pair| (pair[0], pair[1])).chain(ends);
    let widest = gaps.max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)));
    let azimuth_rad = match widest {
        Some((before, after)) if after - before >= LEAST_GAP_RAD => {
            let width = (TAU - (after - before)).max(1e-9);
            [(after - MARGIN * width).rem_euclid(TAU), (1.0 + 2.0 * MARGIN) * width]
        }
        _ => [0.0, TAU],
    };
    Window { c, azimuth_rad }
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
