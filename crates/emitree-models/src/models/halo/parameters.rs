//! The parameters that all halos have.

use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription};
use crate::models::radial;

pub(super) const LOCAL_DENSITY: ParameterDescription = ParameterDescription {
    name: "local_density",
    unit: "GeV cm-3",
    default: ParameterDefault::Value(0.3),
    meaning: "density at local_radius, as at the Sun",
    range: AcceptedRange::NonNegative,
};
pub(super) const LOCAL_RADIUS: ParameterDescription = ParameterDescription {
    name: "local_radius",
    unit: "kpc",
    default: ParameterDefault::Value(8.33),
    meaning: "distance from the centre at which the density is local_density",
    range: AcceptedRange::Positive,
};
pub(super) const OUTER_RADIUS: ParameterDescription = ParameterDescription {
    name: "outer_radius",
    unit: "kpc",
    default: ParameterDefault::Value(250.0),
    meaning: "distance from the centre beyond which there is nothing; about the virial radius",
    range: AcceptedRange::Positive,
};
pub(super) const CORE_RADIUS: ParameterDescription = ParameterDescription {
    name: "core_radius",
    unit: "kpc",
    default: ParameterDefault::Value(0.0),
    meaning: "c of sqrt(r^2 + c^2), which replaces r in the profile: 0 for none",
    range: AcceptedRange::NonNegative,
};
pub(super) const CENTRE_X: ParameterDescription =
    ParameterDescription { unit: "kpc", meaning: "x of the centre", ..radial::CENTRE_X };
pub(super) const CENTRE_Y: ParameterDescription =
    ParameterDescription { unit: "kpc", meaning: "y of the centre", ..radial::CENTRE_Y };
pub(super) const CENTRE_Z: ParameterDescription =
    ParameterDescription { unit: "kpc", meaning: "z of the centre", ..radial::CENTRE_Z };

/// The scale radius of a profile; the defaults are those of Cirelli et al. 2011 for the Milky Way.
pub(super) const fn scale_radius(default_kpc: f64) -> ParameterDescription {
    ParameterDescription {
        name: "scale_radius",
        unit: "kpc",
        default: ParameterDefault::Value(default_kpc),
        meaning: "radius at which the slope of the profile changes",
        range: AcceptedRange::Positive,
    }
}

/// What the outer border of a halo moves with.
pub(super) const JUMPS_MOVE_WITH: &[&str] =
    &[OUTER_RADIUS.name, CENTRE_X.name, CENTRE_Y.name, CENTRE_Z.name];

/// The unit of an image of ρ².
pub(super) const J_FACTOR: &str = "GeV2 cm-5 sr-1";
/// The unit of an image of ρ.
pub(super) const D_FACTOR: &str = "GeV cm-2 sr-1";
