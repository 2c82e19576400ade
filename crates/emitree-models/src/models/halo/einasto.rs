//! The descriptions of the halo of Einasto's profile.

use super::parameters::{
    CENTRE_X, CENTRE_Y, CENTRE_Z, CORE_RADIUS, D_FACTOR, J_FACTOR, JUMPS_MOVE_WITH, LOCAL_DENSITY,
    LOCAL_RADIUS, OUTER_RADIUS, scale_radius,
};
use super::profile::Profile;
use super::{Halo, Process, cusp, outer_sphere};
use crate::catalogue::ModelDescription;
use crate::catalogue::model::formula;
use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription, Values};
use crate::scalar::Scalar;

const ALPHA: ParameterDescription = ParameterDescription {
    name: "alpha",
    unit: "1",
    default: ParameterDefault::Value(0.17),
    meaning: "how fast the slope -2 (r/scale_radius)^alpha of the profile changes",
    range: AcceptedRange::Between(0.05, 10.0),
};

fn profile<T: Scalar>(values: &Values<T>) -> Profile<T> {
    Profile::Einasto { alpha: values.of(ALPHA.name) }
}

pub(crate) const EINASTO: ModelDescription = ModelDescription {
    name: "einasto",
    title: "Annihilating dark matter, the halo of Einasto's profile",
    summary: "The square of the density of a halo of dark matter, finite at the centre, which rises \
              by ten decades towards it; an image is the J-factor. The defaults are those of the \
              Milky Way.",
    source: "J. Einasto 1965, Trudy Astrofiz. Inst. Alma-Ata 5, 87; for dark matter: J. F. Navarro \
             et al. 2004, Mon. Not. R. Astron. Soc. 349, 1039, \
             doi:10.1111/j.1365-2966.2004.07586.x, and A. W. Graham et al. 2006, Astron. J. 132, \
             2685, doi:10.1086/508988; defaults: M. Cirelli et al. 2011, J. Cosmol. Astropart. \
             Phys. 03, 051, doi:10.1088/1475-7516/2011/03/051",
    length_unit: "kpc",
    image_unit: J_FACTOR,
    energy_unit: None,
    parameters: &[
        LOCAL_DENSITY,
        LOCAL_RADIUS,
        scale_radius(28.44),
        ALPHA,
        OUTER_RADIUS,
        CORE_RADIUS,
        CENTRE_X,
        CENTRE_Y,
        CENTRE_Z,
    ],
    jumps_move_with: JUMPS_MOVE_WITH,
    edges: outer_sphere,
    singular_points: |values| cusp(values, None),
    build: formula!(|values| Halo::from_values(
        &EINASTO,
        profile(values),
        Process::Annihilation,
        values
    )?),
};

pub(crate) const EINASTO_DECAY: ModelDescription = ModelDescription {
    name: "einasto_decay",
    title: "Decaying dark matter, the halo of Einasto's profile",
    summary: "The density of a halo of dark matter, finite at the centre, which rises by five decades \
              towards it; an image is the D-factor. The defaults are those of the Milky Way.",
    image_unit: D_FACTOR,
    build: formula!(|values| Halo::from_values(
        &EINASTO_DECAY,
        profile(values),
        Process::Decay,
        values
    )?),
    ..EINASTO
};
