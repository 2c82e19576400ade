//! The integrands of trees in canonical coordinates.

use super::Meter;
use crate::energy::EnergyAxis;
use crate::error::RenderError;
use crate::exchange::MethodError;
use crate::projection::{MappedPoint, Projection};
use crate::quadrature::{AsyncIntegrand, Points};
use crate::site::{Mapping, Site};

/// The canonical integrand of the trees, g · ds/dz · dΩ/(dx dy) on the unit cube: an integral over
/// the cube is an irradiance.
pub(crate) struct CanonicalIntegrand<'a> {
    pub(crate) meter: &'a Meter,
    pub(crate) projection: &'a dyn Projection,
    pub(crate) tile: (usize, usize),
}

/// The canonical integrand with an energy axis, g · ds/dz · dΩ/(dx dy) · dE/du: an integral over the
/// cube of four dimensions is an irradiance in the whole band.
pub(crate) struct SpectralIntegrand<'a> {
    pub(crate) canonical: CanonicalIntegrand<'a>,
    pub(crate) axis: &'a EnergyAxis,
}

impl CanonicalIntegrand<'_> {
    /// The world point at `u`, with the weight ds/dz · dΩ/(dx dy) of g in place of ds/dz.
    fn weighted(&self, u: [f64; 3]) -> MappedPoint {
        let mapped = self.projection.world_from_canonical(u);
        let density = self.projection.solid_angle_density([u[0], u[1]]);
        MappedPoint { path_per_depth: mapped.path_per_depth * density, ..mapped }
    }

    /// One sample point.
    pub(crate) fn site(&self, u: [f64; 3]) -> Site {
        Site { xy: [u[0], u[1]], tile: self.tile, point: self.weighted(u), energy: None }
    }
}

impl SpectralIntegrand<'_> {
    /// One sample point.
    pub(crate) fn site(&self, [x, y, z, u]: [f64; 4]) -> Site {
        let mut site = self.canonical.site([x, y, z]);
        site.point.path_per_depth *= self.axis.energy_per_canonical(u);
        Site { energy: Some(self.axis.energy(u)), ..site }
    }
}

impl AsyncIntegrand<3> for CanonicalIntegrand<'_> {
    type Error = MethodError;

    async fn evaluate(&self, points: Points<'_, 3>, values: &mut [f64]) -> Result<(), Self::Error> {
        let weighted = |u: [f64; 3]| self.weighted(u);
        let mapping = Mapping { map: &weighted, tile: self.tile, energy: None };
        self.meter.evaluate(points, mapping, values).await
    }

    fn evaluations_left(&self) -> u64 {
        self.meter.evaluations_left()
    }

    fn is_out_of_time(error: &Self::Error) -> bool {
        matches!(error, RenderError::Time { .. })
    }
}

impl AsyncIntegrand<4> for SpectralIntegrand<'_> {
    type Error = MethodError;

    async fn evaluate(&self, points: Points<'_, 4>, values: &mut [f64]) -> Result<(), Self::Error> {
        let site = |i: usize| self.site(points.at(i));
        self.canonical.meter.evaluate_sites(&site, values).await
    }

    fn evaluations_left(&self) -> u64 {
        self.canonical.meter.evaluations_left()
    }

    fn is_out_of_time(error: &Self::Error) -> bool {
        matches!(error, RenderError::Time { .. })
    }
}
