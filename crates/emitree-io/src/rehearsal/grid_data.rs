//! What data on a grid allow: linear interpolation between them is an error of its own.

use super::Remark;
use crate::data_error;
use crate::scene::{EmissionSource, Scene};

/// The remark that interpolation between data changes the image by more than the tolerance.
pub(super) fn remark(scene: &Scene) -> Option<Remark> {
    let EmissionSource::Grid(emission) = &scene.emission.source else { return None };
    let (error, tolerance) = (data_error::of(scene)?, scene.render.tolerance?);
    (error > tolerance).then(|| {
        let [nx, ny, nz] = emission.grid.shape();
        let text = format!(
            "linear interpolation between {nx} x {ny} x {nz} data makes an error of some {error:.1e} of the largest \
             pixel, more than the tolerance {tolerance:e}: a tighter one than that error tells of the interpolant \
             alone"
        );
        Remark::new("data", text)
    })
}
