//! The names of units, their factors to SI and where these come from.

use super::Dimension;
use super::magnitude::Magnitude;
use core::f64::consts::{FRAC_1_PI, PI};

/// A unit that has a name.
#[derive(Debug, PartialEq)]
pub struct KnownUnit {
    /// Its names, the one written first.
    pub names: &'static [&'static str],
    /// What it measures.
    pub dimension: Dimension,
    /// Whether it takes metric prefixes.
    pub prefixed: bool,
    /// Whether its first name is in the FITS standard, tables 3 to 5.
    pub in_fits: bool,
    /// Where its factor comes from.
    pub source: &'static str,
    pub(super) size: Magnitude,
}

impl KnownUnit {
    /// The factor to SI: to metres, kilograms, seconds, radians, photons and counts.
    ///
    /// ```
    /// use emitree_io::units::table::KNOWN_UNITS;
    ///
    /// let earth = KNOWN_UNITS.iter().find(|unit| unit.names.contains(&"R_E")).unwrap();
    /// assert_eq!(earth.factor_si(), 6.371e6);
    /// ```
    pub fn factor_si(&self) -> f64 {
        self.size.value()
    }

    const fn new(
        names: &'static [&'static str],
        dimension: Dimension,
        (mantissa, decade): (f64, i32),
        source: &'static str,
    ) -> Self {
        let size = Magnitude { mantissa, decade };
        Self { names, dimension, prefixed: false, in_fits: true, source, size }
    }

    /// One that takes metric prefixes.
    const fn prefixed(self) -> Self {
        Self { prefixed: true, ..self }
    }

    /// The radius of a body that FITS has no name for.
    const fn radius(
        names: &'static [&'static str],
        size: (f64, i32),
        source: &'static str,
    ) -> Self {
        Self { in_fits: false, ..Self::new(names, Dimension::LENGTH, size, source) }
    }
}

/// The SI, ninth edition (2019), doi:10.59161/AUEZ1291.
const SI: &str = "SI, 9th edition (2019)";
/// Archinal et al. 2018, the report of the IAU's working group on cartographic coordinates.
const WGCCRE: &str = "IAU WGCCRE 2015, mean radius, doi:10.1007/s10569-017-9805-5";
const WGCCRE_EQUATOR: &str = "IAU WGCCRE 2015, equatorial radius, doi:10.1007/s10569-017-9805-5";
const IAU_2015_B3: &str = "IAU 2015 resolution B3, nominal value";
/// Tables 3 to 5 of the standard.
const FITS: &str = "FITS standard 4.0, section 4.3";

const RATE: Dimension = Dimension { time: -1, ..Dimension::NONE };
const POWER: Dimension = Dimension { length: 2, mass: 1, time: -3, ..Dimension::NONE };
/// Power over area and frequency.
const FLUX_DENSITY: Dimension = Dimension { mass: 1, time: -2, ..Dimension::NONE };
/// Photons over area, time and solid angle.
const PHOTON_RADIANCE: Dimension =
    Dimension { length: -2, time: -1, angle: -2, photon: 1, ..Dimension::NONE };

/// All units with a name, each written as its mantissa and its power of ten.
///
/// The Earth's radius is that of the magnetospheric community, the mean radius rounded to whole
/// kilometres; astropy's `R_earth`, the equatorial 6378.1 km, is `R_E_eq`.
pub static KNOWN_UNITS: &[KnownUnit] = &[
    KnownUnit::new(&["m"], Dimension::LENGTH, (1.0, 0), SI).prefixed(),
    KnownUnit::new(&["Angstrom", "angstrom", "Å"], Dimension::LENGTH, (1.0, -10), FITS),
    KnownUnit::new(
        &["AU", "au"],
        Dimension::LENGTH,
        (1.495_978_707, 11),
        "IAU 2012 resolution B2, exact",
    ),
    KnownUnit::new(
        &["pc"],
        Dimension::LENGTH,
        (3.085_677_581_491_367_3, 16),
        "IAU 2015 resolution B2: 648000/π AU",
    )
    .prefixed(),
    KnownUnit::new(
        &["lyr", "ly"],
        Dimension::LENGTH,
        (9.460_730_472_580_8, 15),
        "the speed of light (SI) in a Julian year of 365.25 d, exact",
    ),
    KnownUnit::new(&["solRad", "R_sun", "R_Sun"], Dimension::LENGTH, (6.957, 8), IAU_2015_B3),
    KnownUnit::radius(
        &["R_E", "R_earth", "R_Earth"],
        (6.371, 6),
        "mean radius (IUGG 6371.0 km), as the magnetospheric community rounds it",
    ),
    KnownUnit::radius(&["R_E_eq"], (63_781.0, 2), IAU_2015_B3),
    KnownUnit::radius(&["R_mercury"], (2.4394, 6), WGCCRE),
    KnownUnit::radius(&["R_venus"], (6.0518, 6), WGCCRE),
    KnownUnit::radius(&["R_moon"], (1.7374, 6), WGCCRE),
    KnownUnit::radius(&["R_mars"], (3.3895, 6), WGCCRE),
    KnownUnit::radius(&["R_jup", "R_jupiter"], (7.1492, 7), IAU_2015_B3),
    KnownUnit::radius(&["R_saturn"], (6.0268, 7), WGCCRE_EQUATOR),
    KnownUnit::new(&["s"], Dimension::TIME, (1.0, 0), SI).prefixed(),
    KnownUnit::new(&["min"], Dimension::TIME, (6.0, 1), SI),
    KnownUnit::new(&["h"], Dimension::TIME, (3.6, 3), SI),
    KnownUnit::new(&["d"], Dimension::TIME, (8.64, 4), SI),
    KnownUnit::new(&["yr"], Dimension::TIME, (3.155_76, 7), "Julian year of 365.25 d").prefixed(),
    KnownUnit::new(&["Hz"], RATE, (1.0, 0), SI).prefixed(),
    KnownUnit::new(&["g"], Dimension::MASS, (1.0, -3), SI).prefixed(),
    KnownUnit::new(&["J"], Dimension::ENERGY, (1.0, 0), SI).prefixed(),
    KnownUnit::new(&["eV"], Dimension::ENERGY, (1.602_176_634, -19), SI).prefixed(),
    KnownUnit::new(&["erg"], Dimension::ENERGY, (1.0, -7), FITS),
    KnownUnit::new(&["W"], POWER, (1.0, 0), SI).prefixed(),
    KnownUnit::new(&["Jy"], FLUX_DENSITY, (1.0, -26), FITS).prefixed(),
    KnownUnit::new(&["rad"], Dimension::ANGLE, (1.0, 0), SI).prefixed(),
    KnownUnit::new(&["deg"], Dimension::ANGLE, (PI / 1.8, -2), SI),
    KnownUnit::new(&["arcmin"], Dimension::ANGLE, (PI / 1.08, -4), SI),
    KnownUnit::new(&["arcsec"], Dimension::ANGLE, (PI / 6.48, -5), SI),
    KnownUnit::new(&["mas"], Dimension::ANGLE, (PI / 6.48, -8), SI),
    KnownUnit::new(&["sr"], Dimension::SOLID_ANGLE, (1.0, 0), SI).prefixed(),
    KnownUnit::new(&["ph", "photon"], Dimension::PHOTON, (1.0, 0), FITS),
    KnownUnit::new(&["ct", "count"], Dimension::COUNT, (1.0, 0), FITS),
    KnownUnit::new(
        &["R", "rayleigh", "Rayleigh"],
        PHOTON_RADIANCE,
        (0.25 * FRAC_1_PI, 10),
        "Hunten, Roach & Chamberlain 1956, J. Atmos. Terr. Phys. 8, 345",
    )
    .prefixed(),
];

/// Metric prefixes and their powers of ten (SI, table 7, as far as FITS has them).
pub(super) static PREFIXES: &[(&str, i32)] = &[
    ("da", 1),
    ("y", -24),
    ("z", -21),
    ("a", -18),
    ("f", -15),
    ("p", -12),
    ("n", -9),
    ("u", -6),
    ("m", -3),
    ("c", -2),
    ("d", -1),
    ("h", 2),
    ("k", 3),
    ("M", 6),
    ("G", 9),
    ("T", 12),
    ("P", 15),
    ("E", 18),
    ("Z", 21),
    ("Y", 24),
];

/// Usual names of units that have another name here.
const HABITS: &[(&str, &str)] = &[
    ("sec", "s"),
    ("second", "s"),
    ("minute", "min"),
    ("hr", "h"),
    ("hour", "h"),
    ("day", "d"),
    ("year", "yr"),
    ("meter", "m"),
    ("metre", "m"),
    ("micron", "um"),
    ("parsec", "pc"),
    ("lightyear", "lyr"),
    ("RE", "R_E"),
    ("Rs", "R_sun"),
    ("degree", "deg"),
    ("steradian", "sr"),
    ("ster", "sr"),
    ("photons", "ph"),
    ("counts", "ct"),
    ("joule", "J"),
    ("watt", "W"),
    ("jansky", "Jy"),
];

/// The unit called `name` and its prefix: symbol and power of ten.
pub(super) fn find(name: &str) -> Option<((&'static str, i32), &'static KnownUnit)> {
    let called = |name: &str| KNOWN_UNITS.iter().find(|unit| unit.names.contains(&name));
    if let Some(unit) = called(name) {
        return Some((("", 0), unit));
    }
    // The micro sign and the Greek letter.
    let name = &*name.replace(['\u{b5}', '\u{3bc}'], "u");
    PREFIXES.iter().find_map(|&(symbol, decade)| {
        let unit = called(name.strip_prefix(symbol)?)?;
        unit.prefixed.then_some(((symbol, decade), unit))
    })
}

/// The known name that is most like `name`, if any is.
pub(super) fn similar(name: &str) -> Option<String> {
    let singular = name.strip_suffix('s').unwrap_or(name);
    let habit = |name: &str| {
        let same = |&&(written, _): &&(&str, &str)| written.eq_ignore_ascii_case(name);
        HABITS.iter().find(same).map(|(_, known)| (*known).to_owned())
    };
    if let Some(known) = habit(name).or_else(|| habit(singular)) {
        return Some(known);
    }
    let usual = ["", "k", "M", "m", "c", "u", "n"].into_iter();
    let names = usual.flat_map(|prefix| {
        let taking = KNOWN_UNITS.iter().filter(move |unit| prefix.is_empty() || unit.prefixed);
        taking.flat_map(move |unit| unit.names.iter().map(move |name| format!("{prefix}{name}")))
    });
    let lower = name.to_lowercase();
    names
        .map(|known| {
            // Letters of the wrong case are nearest; then one wrong letter in three.
            let case = usize::from(known.to_lowercase() != lower);
            let wrong = strsim::damerau_levenshtein(&known.to_lowercase(), &lower);
            (case, wrong, known)
        })
        .filter(|(case, wrong, known)| *case == 0 || 3 * wrong <= known.chars().count())
        .min_by_key(|(case, wrong, known)| (*case, *wrong, known.len()))
        .map(|(_, _, known)| known)
}
