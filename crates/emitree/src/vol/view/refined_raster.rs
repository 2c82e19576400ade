//! The raster from which the values of a function on a chart are computed: as fine as its error requires.
//!
//! Values by the means over the cells of a raster converge with the fourth power of the size of a cell where
//! the function is smooth, and with the first power at kinks: where bounds of another shape end the lines of
//! sight to a body, the image is 0 on one side, and the nodes of pixels are on the other one alone. So
//! their values are too small, in each pixel along the kink. With half as many rows and columns the error is
//! twice as large there, and larger elsewhere: the difference of the two images is a bound of it.

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
