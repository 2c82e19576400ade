//! κ as sums of products: where method `vol` finds a low-rank approximation of it in the view, κ is known everywhere
//! from few evaluations.

use crate::calls::Calls;
use crate::cube::Cube;
use crate::emission::{Emission, Samples};
use crate::erased::{AnyEmission, AnyError};
use crate::error::RenderError;
use crate::meter::{Limits, Meter};
use crate::method;
use crate::options::Method;
use crate::output::Model;
use crate::projection::charts::stretch::Stretch;
use crate::projection::{MappedPoint, Projection};
use crate::tile::Tile;
use crate::tree::StopReason;
use crate::vol::{PixelTolerance, VolOptions};
use core::ops::ControlFlow;
use std::sync::Arc;

/// Evaluations after which there is no approximation: without one there are 64 on each of several hundred lines.
const MOST_EVALUATIONS: u64 = 20_000;
/// Pixels along each side of the image of the optical depth, whose errors are those of optical depths.
const PIXELS: usize = 32;

/// κ · ds/dz · dΩ/(dx dy) as a function of x, y and the depth.
#[derive(Clone, Debug)]
pub(super) struct KnownCoefficient {
    model: Arc<dyn Model>,
    stretch: Option<Stretch>,
    /// The largest estimated error of an optical depth.
    pub(super) error: f64,
}

/// κ as an emission.
struct Coefficient<'a>(&'a AnyEmission<'a>);

impl Emission for Coefficient<'_> {
    type Error = AnyError;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), AnyError> {
        self.0.absorption_coefficients(samples, rates)
    }

    fn takes_whole_batches(&self) -> bool {
        self.0.takes_whole_batches()
    }
}

/// κ of an emission in the view of a projection, with optical depths to an absolute error of `allowed`; `None` if it
/// has no such approximation, or the view none of one piece.
pub(super) fn find(
    calls: &Calls<'_>,
    projection: &dyn Projection,
    allowed: f64,
) -> Result<Option<KnownCoefficient>, RenderError<AnyError>> {
    let is_one_piece = projection.view_geometry().is_none_or(|geometry| {
        geometry.tiles().is_empty()
            && !geometry.has_rim()
            && geometry.surroundings().is_none_or(|around| !around.has_surfaces())
    });
    if !is_one_piece {
        return Ok(None);
    }
    let (shape, outer) = ([PIXELS; 2], calls.meter());
    let limits = Limits { max_evaluations: MOST_EVALUATIONS, ..outer.limits() };
    let meter = Meter::new(shape, limits, None, false).with_model();
    let tiles = Tile::of(projection, shape)?;
    let vol = VolOptions::default().with_pixel_tolerance(PixelTolerance::absolute(allowed));
    let coefficient = Coefficient(calls.emission());
    let progress = |_: u64| match calls.progress() {
        Some(progress) => progress(outer.new_evaluations()),
        None => ControlFlow::Continue(()),
    };
    let method = Method::Vol(vol);
    let made = Calls::new(&coefficient, &meter, Some(&progress))
        .drive(method::begin(&meter, &tiles, None, &method).as_mut());
    let evaluations = usize::try_from(meter.new_evaluations()).unwrap_or(usize::MAX);
    outer.count_absorption(evaluations);
    outer.count_time(0, u64::try_from(meter.emission_time().as_nanos()).unwrap_or(u64::MAX));
    let made = match made {
        Ok(made) => made,
        Err(RenderError::Budget { .. }) => return Ok(None),
        Err(RenderError::NotFinite { rate, position, direction, energy }) => {
            return Err(RenderError::AbsorptionNotFinite {
                coefficient: rate,
                position,
                direction,
                energy,
            });
        }
        Err(error) => return Err(error),
    };
    let error = made.error.as_ref().map_or(f64::INFINITY, Cube::largest);
    let is_known = made.ending == StopReason::Complete && error <= allowed;
    let stretch = made.stretch;
    Ok(made.model.filter(|_| is_known).map(|model| KnownCoefficient { model, stretch, error }))
}

impl KnownCoefficient {
    /// κ at positions in the view of a projection.
    pub(super) fn coefficients(
        &self,
        projection: &dyn Projection,
        positions: &[[f64; 3]],
    ) -> Vec<f64> {
        // x, y and z; a rounding beside the view is in it.
        let place = |&position: &[f64; 3]| {
            let place = projection.canonical_from_world(position).unwrap_or([0.5; 3]);
            place.map(|along| along.clamp(0.0, 1.0))
        };
        let places: Vec<[f64; 3]> = positions.iter().map(place).collect();
        let stretched =
            |&[x, y, z]: &[f64; 3]| [x, y, self.stretch.map_or(z, |stretch| stretch.place_of(z))];
        let values = self.model.values(&places.iter().map(stretched).collect::<Vec<[f64; 3]>>());
        let coefficient = |(&[x, y, z], value): (&[f64; 3], f64)| {
            let MappedPoint { path_per_depth, .. } = projection.world_from_canonical([x, y, z]);
            let slope = self.stretch.map_or(1.0, |stretch| stretch.slope_at(z));
            let weight = path_per_depth * slope * projection.solid_angle_density([x, y]);
            if weight > 0.0 { value / weight } else { 0.0 }
        };
        places.iter().zip(values).map(coefficient).collect()
    }
}
