//! The descriptions of the halo of Burkert.

use super::parameters::{
    CENTRE_X, CENTRE_Y, CENTRE_Z, CORE_RADIUS, D_FACTOR, J_FACTOR, JUMPS_MOVE_WITH, LOCAL_DENSITY,
    LOCAL_RADIUS, OUTER_RADIUS, scale_radius,
};
use super::profile::Profile;
use super::{Halo, Process, outer_sphere};
use crate::catalogue::ModelDescription;
use crate::catalogue::model::formula;
use crate::catalogue::singular::nowhere;

pub(crate) const BURKERT: ModelDescription = ModelDescription {
    name: "burkert",
    title: "Annihilating dark matter, the halo of Burkert",
    summary: "The square of the density of a halo of dark matter with a wide core; an image is the \
              J-factor. The defaults are those of the Milky Way.",
    source: "A. Burkert 1995, Astrophys. J. 447, L25, doi:10.1086/309560; defaults: M. Cirelli et \
             al. 2011, J. Cosmol. Astropart. Phys. 03, 051, doi:10.1088/1475-7516/2011/03/051",
    length_unit: "kpc",
    image_unit: J_FACTOR,
    energy_unit: None,
    parameters: &[
        LOCAL_DENSITY,
        LOCAL_RADIUS,
        scale_radius(12.67),
        OUTER_RADIUS,
        CORE_RADIUS,
        CENTRE_X,
        CENTRE_Y,
        CENTRE_Z,
    ],
    jumps_move_with: JUMPS_MOVE_WITH,
    edges: outer_sphere,
    singular_points: nowhere,
    build: formula!(|values| Halo::from_values(
        &BURKERT,
        Profile::Burkert,
        Process::Annihilation,
        values
    )?),
};

pub(crate) const BURKERT_DECAY: ModelDescription = ModelDescription {
    name: "burkert_decay",
    title: "Decaying dark matter, the halo of Burkert",
    summary: "The density of a halo of dark matter with a wide core; an image is the D-factor. The \
              defaults are those of the Milky Way.",
    image_unit: D_FACTOR,
    build: formula!(|values| Halo::from_values(
        &BURKERT_DECAY,
        Profile::Burkert,
        Process::Decay,
        values
    )?),
    ..BURKERT
};
