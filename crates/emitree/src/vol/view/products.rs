//! The products of a part as a function on its chart, and without the values of G.

use crate::site::Site;
use core::fmt::Debug;
use std::sync::Arc;

/// An interpolant as a linear map from its values at nodes.
pub(crate) trait CoreToMeans: Send + Sync + Debug {
    /// The means over a raster of this shape, row by row.
    fn means(&self, core: &[f64], shape: [usize; 2]) -> Vec<f64>;
}

/// A function on a chart, by its means over rasters.
pub(crate) trait RasterMeans: Send + Sync + Debug {
    /// The means over a raster of this shape, row by row.
    fn means(&self, shape: [usize; 2]) -> Vec<f64>;
}

/// The frozen products of a part.
#[derive(Clone, Debug)]
pub(crate) struct FrozenProducts {
    /// What makes the value at each node.
    pub(crate) nodes: Arc<Vec<Vec<(Site, f64)>>>,
    pub(crate) interpolant: Arc<dyn CoreToMeans>,
}
