//! The published models: one file each, and what they share.
//!
//! To add one, write its file with a description (the table of its parameters is all that scenes
//! depend on it) and name it in the [catalogue](mod@crate::catalogue).

/// The emission of a model: its formula over numbers of 64 bits.
macro_rules! emission_of_formula {
    ($model:ty) => {
        impl emitree::Emission for $model {
            type Error = core::convert::Infallible;

            fn emission_rates(
                &self,
                samples: &emitree::Samples<'_>,
                rates: &mut [f64],
            ) -> Result<(), Self::Error> {
                $crate::catalogue::model::Formula::fill(self, samples, rates);
                Ok(())
            }
        }
    };
}

mod airglow;
mod beta_model;
mod bremsstrahlung;
mod chamberlain;
mod charge_exchange;
mod cmem;
mod constants;
mod ena;
mod ena_ring;
mod geocorona;
mod halo;
mod holmstrom;
mod incomplete_gamma;
mod jorgensen;
mod k_corona;
mod k_corona_polarised;
mod lin;
mod magnetosheath;
mod mars_exosphere;
mod power_law;
mod radial;
mod shell_nebula;
mod shue;
mod solar_wind;
mod speed_integral;
mod sun_angles;
mod thomson;
mod uniform;

pub use airglow::Airglow;
pub use beta_model::BetaModel;
pub use bremsstrahlung::Bremsstrahlung;
pub use chamberlain::Chamberlain;
pub use cmem::Cmem;
pub use ena::Ena;
pub use ena_ring::EnaRing;
pub use geocorona::Geocorona;
pub use halo::{Halo, Process};
pub use holmstrom::Holmstrom;
pub use jorgensen::Jorgensen;
pub use k_corona::KCorona;
pub use k_corona_polarised::PolarisedKCorona;
pub use mars_exosphere::MarsExosphere;
pub use power_law::PowerLaw;
pub use shell_nebula::ShellNebula;
pub use uniform::Uniform;

pub(crate) use airglow::DESCRIPTION as AIRGLOW;
pub(crate) use beta_model::DESCRIPTION as BETA_MODEL;
pub(crate) use bremsstrahlung::DESCRIPTION as BREMSSTRAHLUNG;
pub(crate) use chamberlain::DESCRIPTION as CHAMBERLAIN;
pub(crate) use cmem::DESCRIPTION as CMEM;
pub(crate) use ena::DESCRIPTION as ENA;
pub(crate) use ena_ring::DESCRIPTION as ENA_RING;
pub(crate) use geocorona::DESCRIPTION as GEOCORONA;
pub(crate) use halo::{BURKERT, BURKERT_DECAY, EINASTO, EINASTO_DECAY, NFW, NFW_DECAY};
pub(crate) use holmstrom::DESCRIPTION as HOLMSTROM;
pub(crate) use jorgensen::DESCRIPTION as JORGENSEN;
pub(crate) use k_corona::DESCRIPTION as K_CORONA;
pub(crate) use k_corona_polarised::DESCRIPTION as K_CORONA_POLARISED;
pub(crate) use mars_exosphere::HYDROGEN as MARS_HYDROGEN;
pub(crate) use mars_exosphere::OXYGEN as MARS_OXYGEN;
pub(crate) use power_law::DESCRIPTION as POWER_LAW;
pub(crate) use shell_nebula::DESCRIPTION as SHELL_NEBULA;
pub(crate) use uniform::DESCRIPTION as UNIFORM;

use crate::scalar::Scalar;
use emitree::Samples;

/// Writes `g` at every position to `rates`, for isotropic models.
fn fill_rates<T: Scalar>(samples: &Samples<'_>, rates: &mut [T], g: impl Fn([f64; 3]) -> T) {
    for (rate, &position) in rates.iter_mut().zip(samples.positions()) {
        *rate = g(position);
    }
}

/// Samples that a model works on at once: its numbers stay in the fastest cache.
const BLOCK: usize = 256;

/// Has `g` write the rates of every block of positions.
fn fill_blocks<T: Scalar>(
    samples: &Samples<'_>,
    rates: &mut [T],
    g: impl Fn(&[[f64; 3]], &mut [T]),
) {
    for (positions, rates) in samples.positions().chunks(BLOCK).zip(rates.chunks_mut(BLOCK)) {
        g(positions, rates);
    }
}

/// Writes the rates of a model with emission from distance `from` on up to `to` at a block of
/// positions: `g` turns distances into rates.
fn fill_radial_block<T: Scalar>(
    positions: &[[f64; 3]],
    rates: &mut [T],
    centre: [T; 3],
    [from, to]: [T; 2],
    g: impl Fn(&mut [T]),
) {
    let mut distances = [T::of(0.0); BLOCK];
    let distances = &mut distances[..positions.len()];
    radial::distances(positions, centre, distances);
    let (least, most) = (from.value(), to.value());
    let is_dark = |distance: T| (distance.value() < least) | (distance.value() > most);
    if distances.iter().all(|&distance| is_dark(distance)) {
        return rates.fill(T::of(0.0));
    }
    for (rate, &distance) in rates.iter_mut().zip(&*distances) {
        // What is dark is like the border until it is made dark, so that it costs no more.
        *rate = if is_dark(distance) { T::of(least) } else { distance };
    }
    g(rates);
    for (rate, &distance) in rates.iter_mut().zip(&*distances) {
        *rate = if is_dark(distance) { T::of(0.0) } else { *rate };
    }
}

/// As [`fill_radial_block`], at all positions.
fn fill_radial_rates<T: Scalar>(
    samples: &Samples<'_>,
    rates: &mut [T],
    centre: [T; 3],
    range: [T; 2],
    g: impl Fn(&mut [T]),
) {
    fill_blocks(samples, rates, |positions, rates| {
        fill_radial_block(positions, rates, centre, range, &g);
    });
}

/// Has every number multiplied by the same.
fn scale<T: Scalar>(numbers: &mut [T], factor: T) {
    numbers.iter_mut().for_each(|number| *number = *number * factor);
}

/// One value of a function that changes many in place.
fn one<T: Scalar>(x: T, function: impl Fn(&mut [T])) -> T {
    let mut values = [x];
    function(&mut values);
    values[0]
}

/// Writes `g` at every position in its direction to `rates`.
fn fill_directional_rates<T: Scalar>(
    samples: &Samples<'_>,
    rates: &mut [T],
    g: impl Fn([f64; 3], [f64; 3]) -> T,
) {
    let points = samples.positions().iter().zip(samples.directions());
    for (rate, (&position, &direction)) in rates.iter_mut().zip(points) {
        *rate = g(position, direction);
    }
}
