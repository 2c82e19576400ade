//! Spheres at which a model's rate jumps.

/// A sphere on which the rate of a model jumps, or has a kink.
///
/// A model declares these, so that a renderer can divide lines of sight there, instead of refining the image
/// beside their limbs.
///
/// ```
/// use emitree_models::build_model;
/// use std::collections::BTreeMap;
///
/// let shell = build_model("shell_nebula", &BTreeMap::from([("centre_z".to_owned(), 2.0)]))?;
/// let [inner, outer] = shell.edges()[..] else { panic!("two spheres") };
/// assert_eq!((inner.centre, inner.radius), ([0.0, 0.0, 2.0], 0.8));
/// assert_eq!((outer.centre, outer.radius), ([0.0, 0.0, 2.0], 1.0));
/// assert!(build_model("beta_model", &BTreeMap::new())?.edges().is_empty());
/// # Ok::<(), emitree_models::ModelError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SphericalEdge {
    /// Its centre, in the length unit of the model.
    pub centre: [f64; 3],
    /// Its radius, in the length unit of the model; more than 0.
    pub radius: f64,
}

/// Spheres about a centre; those with a radius of 0 are left out.
pub(crate) fn spheres(
    centre: [f64; 3],
    radii: impl IntoIterator<Item = f64>,
) -> Vec<SphericalEdge> {
    let radii = radii.into_iter().filter(|&radius| radius > 0.0);
    radii.map(|radius| SphericalEdge { centre, radius }).collect()
}
