//! The raster from which the values of a function on a chart are computed: as fine as its error requires.
//!
//! Values by the means over the cells of a raster converge with the fourth power of the size of a cell where
//! the function is smooth, and with the first power at kinks: where bounds of another shape end the lines of
//! sight to a body, the image is 0 on one side, and the nodes of pixels are on the other one alone. So
//! their values are mostly too small, in each pixel along the kink. The difference from the image with half as many
//! rows and columns is an estimate of the error: on average over the places of kinks in the cells it is 3.5 to 5 times
//! the error, for pixels of 1 to 13 cells. Of kinks along the raster, at one place in all cells, it is below the
//! error at 10 to 24 % of the places.

use crate::image::Image;
use crate::vol::view::chart_nodes::ChartNodes;
use crate::vol::view::raster::Raster;

/// The most cells along each side: 32 MiB of means.
const MOST_CELLS: usize = 2048;

/// A raster and the error of the image that is made of it.
pub(crate) struct RefinedRaster {
    pub(crate) raster: Raster,
    pub(crate) error: Image,
}

impl RefinedRaster {
    /// The raster of the values of `nodes`, of a function with these `means`, with twice as many rows and columns
    /// until its error in each pixel is at most what is `allowed` there.
    pub(crate) fn new(
        nodes: &ChartNodes,
        means: &dyn Fn([usize; 2]) -> Vec<f64>,
        allowed: &dyn Fn(usize) -> f64,
    ) -> Self {
        let mut shape = nodes.values_shape;
        loop {
            let raster = Raster::new(shape, means(shape));
            let mut error = nodes.image(&raster.halved());
            error.add_scaled(&nodes.image(&raster), -1.0);
            error.pixels_mut().iter_mut().for_each(|error| *error = error.abs());
            let is_within = |(pixel, error): (usize, &f64)| *error <= allowed(pixel);
            let is_fine = error.pixels().iter().enumerate().all(is_within);
            let finer = shape.map(|cells| 2 * cells);
            if is_fine || finer.iter().any(|&cells| cells > MOST_CELLS) {
                return Self { raster, error };
            }
            shape = finer;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::charts::chart::Window;
    use crate::vol::view::windows::{NaturalNode, in_window};

    /// A pixel on the bright side of the kink of max(0, kink − u), with nodes close to it: the error of its value,
    /// the estimate, and the number of columns.
    fn beside(kink: f64, allowed: f64) -> (f64, f64, usize) {
        let width = 0.004;
        let at = |k: usize| kink - width * (k as f64 + 0.5) / 50.0;
        let window = Window { c: [0.0, 1.0], azimuth_rad: [0.0, 1.0] };
        let node = |k: usize| {
            let place = [at(k), 0.4];
            in_window(&window, &NaturalNode { chart: 0, pixel: 0, place, weight: 0.02 })
        };
        let nodes = ChartNodes::new([1, 1], (0..50).map(node).collect());
        let integral = |u: f64| -0.5 * (kink - u).max(0.0).powi(2);
        let means = |[rows, columns]: [usize; 2]| -> Vec<f64> {
            let border = |k: usize| integral(k as f64 / columns as f64) * columns as f64;
            let row: Vec<f64> = (0..columns).map(|k| border(k + 1) - border(k)).collect();
            (0..rows).flat_map(|_| row.clone()).collect()
        };
        let refined = RefinedRaster::new(&nodes, &means, &|_| allowed);
        let error = (nodes.value(0, &refined.raster) - 0.5 * width).abs();
        (error, refined.error.pixels()[0], refined.raster.shape[1])
    }

    #[test]
    fn the_estimate_is_above_the_error_on_average_over_kinks() {
        let (mut error, mut estimate) = (0.0, 0.0);
        // All places of a kink in a cell of the coarser raster.
        for k in 0..64 {
            let (wrong, estimated, columns) = beside(0.5 + f64::from(k) / 64.0 / 128.0, 1.0);
            assert_eq!(columns, 256);
            error += wrong;
            estimate += estimated;
        }
        assert!(error > 64.0 * 1e-5 && estimate > 2.0 * error, "{error} {estimate}");
    }

    #[test]
    fn a_finer_raster_is_closer_to_the_function_at_a_kink() {
        let [(coarse, _, _), (fine, estimate, columns)] = [1.0, 1e-9].map(|of| beside(0.503, of));
        assert_eq!(columns, MOST_CELLS);
        assert!(fine < 0.2 * coarse && estimate > 1e-9, "{coarse} {fine} {estimate}");
    }
}
