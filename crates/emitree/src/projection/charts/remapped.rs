//! A chart with another depth: stretched, or cut at planes.

use super::chart::{AcrossGap, Chart};
use super::depth::Weights;
use super::layer::Layer;
use super::stretch::StretchTable;
use crate::projection::MappedPoint;
use crate::projection::surroundings::SightLine;

/// Other coordinates.
#[derive(Clone, Debug)]
pub(crate) enum Remap {
    /// More depths where the emission is.
    Stretch(StretchTable),
    /// The part of each line in a region between planes.
    Layer(Layer),
}

/// A chart in other coordinates.
#[derive(Debug)]
pub(crate) struct Remapped<'a> {
    pub(crate) chart: Box<dyn Chart + 'a>,
    pub(crate) remap: Remap,
}

impl Remapped<'_> {
    /// The depth in the chart and its derivative; `None` without lines of sight, which a layer needs.
    fn depth(&self, [u, v, w]: [f64; 3]) -> Option<(f64, f64)> {
        match &self.remap {
            Remap::Stretch(stretch) => Some(stretch.at(w)),
            Remap::Layer(layer) => Some(layer.depths(&*self.chart, [u, v])?.at(w)),
        }
    }

    /// The depth w at the depth z of the chart.
    fn depth_at(&self, [u, v, z]: [f64; 3]) -> Option<f64> {
        match &self.remap {
            Remap::Stretch(stretch) => Some(stretch.place_of(z)),
            Remap::Layer(layer) => Some(layer.depths(&*self.chart, [u, v])?.of(z)),
        }
    }
}

impl Chart for Remapped<'_> {
    fn world_from_chart(&self, uvw @ [u, v, _]: [f64; 3]) -> MappedPoint {
        let Some((z, slope)) = self.depth(uvw) else {
            return self.chart.world_from_chart(uvw);
        };
        let mut point = self.chart.world_from_chart([u, v, z]);
        point.path_per_depth *= slope;
        point
    }

    fn chart_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        let uvz @ [u, v, _] = self.chart.chart_from_world(position)?;
        Some([u, v, self.depth_at(uvz)?])
    }

    fn density(&self, uv: [f64; 2]) -> f64 {
        self.chart.density(uv)
    }

    fn line(&self, uv: [f64; 2]) -> Option<SightLine> {
        self.chart.line(uv)
    }

    fn depth_shares(&self, uvw @ [u, v, _]: [f64; 3]) -> Option<Weights> {
        self.chart.depth_shares([u, v, self.depth(uvw)?.0])
    }

    fn visible_end(&self, uv: [f64; 2]) -> Option<(usize, f64)> {
        let (body, z) = self.chart.visible_end(uv)?;
        match &self.remap {
            Remap::Stretch(stretch) => Some((body, stretch.place_of(z))),
            // Bodies have no layers.
            Remap::Layer(_) => None,
        }
    }

    fn has_gaps(&self) -> bool {
        self.chart.has_gaps()
    }

    fn across_gap(&self, uvw @ [u, v, _]: [f64; 3]) -> Option<AcrossGap> {
        let (z, slope) = self.depth(uvw)?;
        let mut gap = self.chart.across_gap([u, v, z])?;
        gap.weights.iter_mut().for_each(|weight| *weight *= slope);
        Some(gap)
    }

    fn image_place(&self, uv: [f64; 2]) -> (usize, [f64; 2]) {
        self.chart.image_place(uv)
    }
}
