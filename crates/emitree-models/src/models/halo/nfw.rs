//! The descriptions of the halo of Navarro, Frenk and White.

use super::parameters::{
    CENTRE_X, CENTRE_Y, CENTRE_Z, CORE_RADIUS, D_FACTOR, J_FACTOR, JUMPS_MOVE_WITH, LOCAL_DENSITY,
    LOCAL_RADIUS, OUTER_RADIUS, scale_radius,
};
use super::profile::Profile;
use super::{Halo, Process, cusp, outer_sphere};
use crate::catalogue::ModelDescription;
use crate::catalogue::model::formula;

pub(crate) const NFW: ModelDescription = ModelDescription {
    name: "nfw",
    title: "Annihilating dark matter, the halo of Navarro, Frenk and White",
    summary: "The square of the density of a halo of dark matter, whose cusp rises as 1/r^2; an \
              image is the J-factor. The defaults are those of the Milky Way.",
    source: "J. F. Navarro, C. S. Frenk and S. D. M. White 1996, Astrophys. J. 462, 563, \
             doi:10.1086/177173, and 1997, Astrophys. J. 490, 493, doi:10.1086/304888; defaults: \
             M. Cirelli et al. 2011, J. Cosmol. Astropart. Phys. 03, 051, \
             doi:10.1088/1475-7516/2011/03/051",
    length_unit: "kpc",
    image_unit: J_FACTOR,
    energy_unit: None,
    parameters: &[
        LOCAL_DENSITY,
        LOCAL_RADIUS,
        scale_radius(24.42),
        OUTER_RADIUS,
        CORE_RADIUS,
        CENTRE_X,
        CENTRE_Y,
        CENTRE_Z,
    ],
    jumps_move_with: JUMPS_MOVE_WITH,
    edges: outer_sphere,
    singular_points: |values| cusp(values, Some(2.0)),
    build: formula!(|values| Halo::from_values(&NFW, Profile::Nfw, Process::Annihilation, values)?),
};

pub(crate) const NFW_DECAY: ModelDescription = ModelDescription {
    name: "nfw_decay",
    title: "Decaying dark matter, the halo of Navarro, Frenk and White",
    summary: "The density of a halo of dark matter, whose cusp rises as 1/r; an image is the \
              D-factor. The defaults are those of the Milky Way.",
    image_unit: D_FACTOR,
    singular_points: |values| cusp(values, Some(1.0)),
    build: formula!(|values| Halo::from_values(&NFW_DECAY, Profile::Nfw, Process::Decay, values)?),
    ..NFW
};
