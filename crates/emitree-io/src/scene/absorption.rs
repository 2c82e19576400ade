//! `[absorption]`: the absorption coefficient of the medium, with the keys of `[emission]`.

use super::emission::{self, EmissionFailure, EmissionSource, Spectrum};
use super::error::SceneError;
use super::radiometry::{energy_factor, length_factor, samples_in_units};
use super::source::Place;
use super::table::Table;
use crate::energies::Energies;
use crate::units::Unit;
use emitree::{Emission, Samples};

/// What messages about `[emission]` say of `[absorption]` instead.
const SECTION: [(&str, &str); 4] = [
    ("`emission.", "`absorption."),
    ("`[emission]`", "`[absorption]`"),
    ("the scene has no emission", "`[absorption]` has no coefficient"),
    ("the scene has two emissions", "`[absorption]` has two coefficients"),
];

/// The same text about `[absorption]`.
pub(super) fn of_section(text: &str) -> String {
    SECTION.iter().fold(text.to_owned(), |text, (of_emission, own)| text.replace(of_emission, own))
}

/// The absorption coefficient as it is written.
pub(super) struct Given {
    source: EmissionSource,
    /// Its unit, and where that is written.
    unit: Option<(String, Place)>,
    /// Where the table is.
    place: Place,
}

/// The absorption coefficient of a scene, in one over the scene's length unit.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SceneAbsorption {
    /// The coefficient, in its own units.
    pub source: EmissionSource,
    /// Length units of the source in one of the scene.
    pub length_factor: f64,
    /// Energy units of the source in one of the scene.
    pub energy_factor: f64,
    /// What the source's coefficients are multiplied with.
    pub factor: f64,
    /// Their unit as it is written, or empty.
    pub unit: String,
}

/// The table; `spectrum` is what the emission of the scene has.
pub(super) fn read(table: Table, spectrum: Spectrum) -> Result<Given, SceneError> {
    let spectrum = if spectrum == Spectrum::Of { Spectrum::OrGrey } else { spectrum };
    let place = table.place().clone();
    let read = emission::read_coefficient(table, spectrum);
    let (source, unit) = read.map_err(|error| error.with_text(of_section))?;
    Ok(Given { source, unit, place })
}

impl Given {
    /// The coefficient in the units of a scene.
    pub(super) fn resolve(
        self,
        length_unit: Option<&str>,
        energies: Option<&Energies>,
    ) -> Result<SceneAbsorption, SceneError> {
        let Self { source, unit, place } = self;
        let factor = match &unit {
            None => 1.0,
            Some((text, place)) => factor_of(text, place, length_unit)?,
        };
        let scene_length = length_unit.map(|unit| (unit.to_owned(), place));
        Ok(SceneAbsorption {
            length_factor: length_factor(source.length_unit(), scene_length.as_ref())?,
            energy_factor: energy_factor(source.energy_unit(), energies),
            factor,
            unit: unit.map(|(text, _)| text).unwrap_or_default(),
            source,
        })
    }
}

/// What coefficients in a unit are multiplied with for one over the length unit of the scene.
fn factor_of(text: &str, place: &Place, length_unit: Option<&str>) -> Result<f64, SceneError> {
    let Some(length) = length_unit else {
        return Err(SceneError::at(place, "`absorption.unit` needs a length unit")
            .label("expected `length_unit` in `[projection]` too, as in \"km\""));
    };
    let factor = Unit::parse(text)
        .and_then(|unit| unit.factor_to(&Unit::parse(length)?.power(-1)))
        .map_err(|error| SceneError::at(place, format!("`absorption.unit`: {error}")));
    factor.map_err(|error| error.label(format!("expected one over a length, as in \"{length}-1\"")))
}

impl SceneAbsorption {
    /// Writes the coefficients at samples in the units of the scene.
    pub(super) fn coefficients(
        &self,
        samples: &Samples<'_>,
        coefficients: &mut [f64],
    ) -> Result<(), EmissionFailure> {
        let factors = [self.length_factor, self.energy_factor];
        let evaluated = samples_in_units(samples, factors, |samples| {
            self.source.emission_rates(samples, coefficients)
        });
        evaluated.map_err(|failure| EmissionFailure::Absorption(Box::new(failure)))?;
        coefficients.iter_mut().for_each(|coefficient| *coefficient *= self.factor);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
