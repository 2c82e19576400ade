//! Points of a region, where the image is made of a function of three coordinates: a point costs one
//! evaluation, and its difference from that function has the error of the sum as its expectation.

use crate::output::Model;
use crate::projection::charts::stretch::Stretch;
use crate::site::Site;
use crate::vol::sampling::{Stop, evaluate};
use crate::vol::sums::View;
use crate::vol::sums::scattered::PlacePair;

/// Points with G · dΩ/(dx dy) there.
#[derive(Debug, Default)]
pub(super) struct Points {
    /// The depths of the function, once there are points.
    stretch: Option<Stretch>,
    points: Vec<[f64; 3]>,
    rates: Vec<f64>,
    /// The coefficient of a pixel over its probability, times its radiance over the mean of G dΩ/(dx dy).
    weights: Vec<f64>,
}

impl Points {
    pub(super) fn len(&self) -> usize {
        self.rates.len()
    }

    /// Samples up to `wanted` points, at the places of `pair`.
    pub(super) async fn sample(
        &mut self,
        view: View<'_>,
        stretch: Option<Stretch>,
        pair: &(dyn Fn(usize) -> PlacePair + Sync),
        wanted: usize,
    ) -> Result<(), Stop> {
        if self.stretch != stretch {
            *self = Self { stretch, ..Self::default() };
        }
        let mut points = Vec::new();
        let mut weights = Vec::new();
        for i in self.len()..wanted {
            let pair = pair(i);
            let tile = &view.tiles[pair.tile(view.tiles)];
            let [height, width] = tile.shape;
            let pixel = pair.voxel.pixel;
            let (row, column) = (pixel / width % height, pixel % width);
            let [u, v, depth] = pair.offset;
            let x = (column as f64 + 0.5 + u) / width as f64;
            let y = (row as f64 + 0.5 + v) / height as f64;
            points.push([x, y, depth + 0.5]);
            let area = 1.0 / (height as f64 * width as f64);
            weights.push(pair.weight * area / view.solid_angles.pixels()[pixel]);
        }
        let site = |k: usize| site(view, stretch, points[k]);
        let rates = evaluate(view.meter, points.len(), &site).await?;
        self.rates.extend(rates);
        self.points.extend(points);
        self.weights.extend(weights);
        Ok(())
    }

    /// The differences from a function, each an estimate of the error of the sum.
    pub(super) fn differences(&self, model: &dyn Model) -> Vec<f64> {
        let all = self.rates.iter().zip(model.values(&self.points)).zip(&self.weights);
        all.map(|((rate, value), weight)| weight * (rate - value)).collect()
    }
}

/// One sample of G · dΩ/(dx dy) in the only tile.
fn site(view: View<'_>, stretch: Option<Stretch>, [x, y, t]: [f64; 3]) -> Site {
    let (z, slope) = stretch.map_or((t, 1.0), |stretch| stretch.at(t));
    let projection = view.tiles[0].projection;
    let mut point = projection.world_from_canonical([x, y, z]);
    point.path_per_depth *= slope * projection.solid_angle_density([x, y]);
    Site { xy: [x, y], point, energy: None, tile: (0, view.tiles.len()) }
}
