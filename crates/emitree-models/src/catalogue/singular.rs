//! Points at which a model's rate is infinite, or has a peak that is narrower than any other structure.

use super::parameter::Values;

/// A point about which a model is singular, or peaks far more sharply than elsewhere.
///
/// A model declares these points, so that a renderer can refine the image about their places, where
/// samples alone would not find a peak that is narrower than a pixel.
///
/// ```
/// use emitree_models::build_model;
/// use std::collections::BTreeMap;
///
/// let halo = build_model("nfw", &BTreeMap::from([("centre_z".to_owned(), 2.0)]))?;
/// let [cusp] = halo.singular_points()[..] else { panic!("one point") };
/// assert_eq!((cusp.position, cusp.exponent), ([0.0, 0.0, 2.0], Some(2.0)));
/// assert!(build_model("beta_model", &BTreeMap::new())?.singular_points().is_empty());
/// # Ok::<(), emitree_models::ModelError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SingularPoint {
    /// Where it is, in the length unit of the model.
    pub position: [f64; 3],
    /// γ of the rate r^−γ close to the point, at distances r from it; below 3, so that a volume about
    /// the point emits a finite amount. `None` if no single power describes the rate.
    ///
    /// The rate may be softened, and finite at the point itself: the power is that of the distances
    /// outside of the core.
    pub exponent: Option<f64>,
}

impl SingularPoint {
    pub(crate) fn new(position: [f64; 3], exponent: Option<f64>) -> Self {
        Self { position, exponent }
    }
}

/// What a description has for the points, or the edges, of a model without any.
pub(crate) fn nowhere<T>(_: &Values) -> Vec<T> {
    Vec::new()
}
