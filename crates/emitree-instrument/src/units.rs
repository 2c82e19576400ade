//! The units that tables of a response are written in.

/// How many keV the unit of an energy is, if it is known.
pub(crate) fn kev_per(unit: &str) -> Option<f64> {
    match &*unit.trim().to_ascii_lowercase() {
        "ev" => Some(1e-3),
        "kev" => Some(1.0),
        "mev" => Some(1e3),
        "gev" => Some(1e6),
        _ => None,
    }
}

/// How many cm² the unit of an area is, if it is known.
pub(crate) fn cm2_per(unit: &str) -> Option<f64> {
    let name: String = unit.chars().filter(|c| !matches!(c, '*' | '^' | ' ')).collect();
    match &*name.to_ascii_lowercase() {
        "mm2" => Some(1e-2),
        "cm2" => Some(1.0),
        "m2" => Some(1e4),
        _ => None,
    }
}

/// What to write for an energy, in messages.
pub(crate) const ENERGY_UNITS: &str = "keV, eV, MeV or GeV";
/// What to write for an area, in messages.
pub(crate) const AREA_UNITS: &str = "cm**2, m**2 or mm**2";
