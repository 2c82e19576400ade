//! The raster from which the values of a function on a chart are computed: as fine as its error requires.
//!
//! Values by the means over the cells of a raster converge with the fourth power of the size of a cell where
//! the function is smooth, and with the first power at kinks: where bounds of another shape end the lines of
//! sight to a body, the image is 0 on one side, and the nodes of pixels are on the other one alone. So
//! their values are mostly too small, in each pixel along the kink. Differences between the images of rasters that
//! have half, a quarter and an eighth as many rows and columns estimate the error, each divided by 4 for each step as errors
//! at kinks fall. One difference alone is below the error at 9 to 22 % of the places of kinks along the raster, by any
//! factor; the largest of the three at 0 to 4 %, by a factor of 1.8 at most, and on average it is 5 to 8 times the error, for
//! pixels of 1 to 13 cells.

use crate::image::Image;
use crate::vol::view::chart_nodes::ChartNodes;
use crate::vol::view::raster::Raster;

/// The most cells along each side: 32 MiB of means.
const MOST_CELLS: usize = 2048;

/// The number of coarser rasters, each half as fine as the one before.
const COARSER: usize = 3;
/// The ratio of errors at kinks on a raster to those on one half as fine.
const RATIO: f64 = 0.25;

/// A raster, the image that is made of it, and the error of that.
pub(crate) struct RefinedRaster {
    pub(crate) raster: Raster,
    pub(crate) image: Image,
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
            let [image, error] = with_error(nodes, &raster);
            let is_within = |(pixel, error): (usize, &f64)| *error <= allowed(pixel);
            let is_fine = error.pixels().iter().enumerate().all(is_within);
            let finer = shape.map(|cells| 2 * cells);
            if is_fine || finer.iter().any(|&cells| cells > MOST_CELLS) {
                return Self { raster, image, error };
            }
            shape = finer;
        }
    }
}

/// The image and the estimated error of each pixel.
fn with_error(nodes: &ChartNodes, raster: &Raster) -> [Image; 2] {
    let of_raster = nodes.image(raster);
    let mut image = of_raster.clone();
    let mut error = Image::zeros(image.height(), image.width());
    let (mut coarser, mut ratio) = (raster.halved(), 1.0);
    for _ in 0..COARSER {
        let of_coarser = nodes.image(&coarser);
        image.add_scaled(&of_coarser, -1.0);
        for (error, change) in error.pixels_mut().iter_mut().zip(image.pixels()) {
            *error = error.max(ratio * change.abs());
        }
        (image, coarser, ratio) = (of_coarser, coarser.halved(), RATIO * ratio);
    }
    [of_raster, error]
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
        let error = (refined.image.pixels()[0] - 0.5 * width).abs();
        (error, refined.error.pixels()[0], refined.raster.shape[1])
    }

    #[test]
    fn the_estimate_is_above_the_error_of_nearly_all_kinks() {
        let (mut error, mut estimate, mut below) = (0.0, 0.0, 0);
        // All places of a kink in a cell of the raster half as fine.
        for k in 0..64 {
            let (wrong, estimated, columns) = beside(0.5 + f64::from(k) / 64.0 / 128.0, 1.0);
            assert_eq!(columns, 256);
            error += wrong;
            estimate += estimated;
            below += usize::from(estimated < wrong);
            assert!(estimated > wrong / 1.8, "{k}: {wrong} {estimated}");
        }
        assert!(error > 64.0 * 1e-5 && estimate > 4.0 * error, "{error} {estimate}");
        assert!(below <= 2, "{below}");
    }

    #[test]
    fn a_finer_raster_is_closer_to_the_function_at_a_kink() {
        let [(coarse, _, _), (fine, estimate, columns)] = [1.0, 1e-9].map(|of| beside(0.503, of));
        assert_eq!(columns, MOST_CELLS);
        assert!(fine < 0.2 * coarse && estimate > 1e-9, "{coarse} {fine} {estimate}");
    }
}
