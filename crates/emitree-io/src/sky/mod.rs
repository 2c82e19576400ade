//! Where on the sky an image is: numbers that a scene gives, for the headers of files.
//!
//! Nothing here has an ephemeris. A frame of the model is a name; how its axes lie in the coordinates
//! of the image, when, and where the observer is, are numbers that are checked and copied.

mod date;

pub use date::SkyDate;

use serde::{Deserialize, Serialize};

/// Where on the sky the image of a scene is: the table `[sky]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Sky {
    /// The name of the frame whose axes are those of the model.
    pub frame: String,
    /// The longitudes and latitudes of the image.
    pub coordinates: SkyCoordinates,
    /// The directions of the model's x, y and z in these coordinates.
    pub axes: [[f64; 3]; 3],
    /// The mean equinox of the coordinates \[Julian year\], if they have one.
    pub equinox: Option<f64>,
    /// When the image was seen.
    pub date: Option<SkyDate>,
    /// The observer of the Sun, of helioprojective coordinates.
    pub observer: Option<SolarObserver>,
}

/// The observer of helioprojective coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SolarObserver {
    /// The heliographic longitude of Stonyhurst \[deg\].
    pub longitude_deg: f64,
    /// The heliographic latitude \[deg\].
    pub latitude_deg: f64,
    /// The distance from the centre of the Sun \[m\].
    pub distance_m: f64,
    /// The radius of the Sun \[m\].
    pub sun_radius_m: f64,
}

/// The longitudes and latitudes of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[non_exhaustive]
pub enum SkyCoordinates {
    /// Right ascension and declination of the International Celestial Reference System.
    Icrs,
    /// Right ascension and declination at a mean equinox.
    Fk5,
    /// Galactic.
    Galactic,
    /// Ecliptic, at a mean equinox.
    BarycentricMeanEcliptic,
    /// About the centre of the Sun, as an observer sees it: longitudes to the west.
    Helioprojective,
}

/// What there is to say of coordinates of the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SkyCoordinatesDescription {
    /// The name, which is that of the class of astropy or sunpy.
    pub name: &'static str,
    /// The letters of longitude and latitude in FITS (`CTYPE`).
    pub letters: [&'static str; 2],
    /// The reference system in FITS (`RADESYS`), where it has to be named.
    pub reference: Option<&'static str>,
    /// Whether they depend on an equinox.
    pub has_equinox: bool,
    /// The letter of `COORDSYS` of a `HEALPix` map, if there is one.
    pub healpix: Option<&'static str>,
    /// Whether longitudes increase to the right, as seen from inside.
    pub is_left_handed: bool,
}

impl SkyCoordinates {
    /// All of them, in the order of messages.
    pub const ALL: [Self; 5] = [
        Self::Icrs,
        Self::Fk5,
        Self::Galactic,
        Self::BarycentricMeanEcliptic,
        Self::Helioprojective,
    ];

    /// What there is to say of them.
    ///
    /// ```
    /// use emitree_io::SkyCoordinates;
    ///
    /// assert_eq!(SkyCoordinates::Galactic.description().letters, ["GLON", "GLAT"]);
    /// ```
    pub fn description(self) -> &'static SkyCoordinatesDescription {
        const ICRS: SkyCoordinatesDescription = SkyCoordinatesDescription {
            name: "ICRS",
            letters: ["RA--", "DEC-"],
            reference: Some("ICRS"),
            has_equinox: false,
            healpix: Some("C"),
            is_left_handed: false,
        };
        match self {
            Self::Icrs => &ICRS,
            Self::Fk5 => &SkyCoordinatesDescription {
                name: "FK5",
                reference: Some("FK5"),
                has_equinox: true,
                healpix: None,
                ..ICRS
            },
            Self::Galactic => &SkyCoordinatesDescription {
                name: "Galactic",
                letters: ["GLON", "GLAT"],
                reference: None,
                healpix: Some("G"),
                ..ICRS
            },
            Self::BarycentricMeanEcliptic => &SkyCoordinatesDescription {
                name: "BarycentricMeanEcliptic",
                letters: ["ELON", "ELAT"],
                has_equinox: true,
                healpix: Some("E"),
                ..ICRS
            },
            Self::Helioprojective => &SkyCoordinatesDescription {
                name: "Helioprojective",
                letters: ["HPLN", "HPLT"],
                reference: None,
                healpix: None,
                is_left_handed: true,
                ..ICRS
            },
        }
    }

    /// Those of this name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|of| of.description().name == name)
    }

    /// Those of images of a model in a frame, unless others are named.
    pub(crate) fn for_frame(frame: &str) -> Self {
        if FRAMES_OF_THE_SUN.contains(&frame) {
            return Self::Helioprojective;
        }
        if frame == "Galactocentric" {
            return Self::Galactic;
        }
        Self::named(frame).unwrap_or(Self::Icrs)
    }
}

/// Frames whose images are helioprojective.
const FRAMES_OF_THE_SUN: [&str; 5] = [
    STONYHURST,
    "HeliographicCarrington",
    "Heliocentric",
    "HeliocentricInertial",
    "HeliocentricEarthEcliptic",
];

/// The frame with the centre of the Sun as its origin, solar north along z, and the Earth above the
/// longitude 0: helioprojective coordinates of an observer follow from a position in it.
pub(crate) const STONYHURST: &str = "HeliographicStonyhurst";

/// Where a camera is and how it looks, in the model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Pointing {
    /// The observer, in the length unit of the scene.
    pub position: [f64; 3],
    /// Unit vectors to the right, up and forward; none of a sky in `HEALPix` pixels.
    pub axes: Option<[[f64; 3]; 3]>,
}

impl Pointing {
    /// Of an observer who looks everywhere.
    pub(crate) fn at(position: [f64; 3]) -> Self {
        Self { position, axes: None }
    }

    /// Of an observer at `position` who looks at `target`, `up` being up: the same axes as those of
    /// the camera.
    pub(crate) fn new(position: [f64; 3], target: [f64; 3], up: [f64; 3]) -> Self {
        let forward = unit(core::array::from_fn(|i| target[i] - position[i]));
        let mut across = up;
        // Twice: the first difference loses digits where up is nearly along the pointing.
        for _ in 0..2 {
            let along = dot(across, forward);
            across = unit(core::array::from_fn(|i| across[i] - along * forward[i]));
        }
        let right = cross(forward, across);
        Self { position, axes: Some([right, across, forward]) }
    }
}

impl Sky {
    /// The letter of `COORDSYS` of a `HEALPix` map.
    pub(crate) fn healpix_system(&self) -> Option<&'static str> {
        self.coordinates.description().healpix
    }

    /// A direction of the model in the coordinates of the sky.
    pub(crate) fn of_model(&self, direction: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.axes;
        core::array::from_fn(|i| direction[0] * x[i] + direction[1] * y[i] + direction[2] * z[i])
    }
}

/// The axes of Stonyhurst's frame in the helioprojective coordinates of an observer at a place in it:
/// the first of these is towards the centre of the Sun, the second to the solar west, the third to the
/// north (Thompson 2006, doi:10.1051/0004-6361:20054262). `None` above a pole, and at the centre.
pub(crate) fn helioprojective_axes(position: [f64; 3]) -> Option<[[f64; 3]; 3]> {
    let distance = dot(position, position).sqrt();
    let from_pole = position[0].hypot(position[1]);
    if distance.is_nan() || distance <= 0.0 || from_pole <= 1e-12 * distance {
        return None;
    }
    let towards = position.map(|along| -along / distance);
    let west = [-position[1] / from_pole, position[0] / from_pole, 0.0];
    let north = cross(west, towards);
    Some(core::array::from_fn(|i| [towards[i], west[i], north[i]]))
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(vector: [f64; 3]) -> [f64; 3] {
    let length = dot(vector, vector).sqrt();
    vector.map(|along| along / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_observer_above_the_earth_sees_west_to_the_right() {
        // At (1, 0, 0): x is away from the Sun, y is west, z is north.
        let axes = helioprojective_axes([1.0, 0.0, 0.0]).unwrap();
        assert_eq!(axes, [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        for position in [[0.2, -0.7, 0.4], [-3.0, 1e-6, 2.0]] {
            let [x, y, z] = helioprojective_axes(position).unwrap();
            // They are orthonormal and left-handed; the Sun is at the longitude and latitude 0.
            assert!((dot(x, cross(y, z)) + 1.0).abs() < 1e-14);
            assert!(dot(x, y).abs() < 1e-14 && (dot(x, x) - 1.0).abs() < 1e-14);
            let sun: [f64; 3] = core::array::from_fn(|i| {
                -(position[0] * x[i] + position[1] * y[i] + position[2] * z[i])
            });
            assert!(sun[0] > 0.0 && sun[1].abs() < 1e-14 && sun[2].abs() < 1e-14);
            assert!(z[2] > 0.0);
        }
        assert_eq!(helioprojective_axes([0.0; 3]), None);
        assert_eq!(helioprojective_axes([0.0, 0.0, 2.0]), None);
    }

    #[test]
    fn names_are_those_of_frames() {
        for of in SkyCoordinates::ALL {
            assert_eq!(SkyCoordinates::named(of.description().name), Some(of));
        }
        let of = SkyCoordinates::for_frame;
        assert_eq!(of("HeliocentricInertial"), SkyCoordinates::Helioprojective);
        assert_eq!(of("Galactocentric"), SkyCoordinates::Galactic);
        assert_eq!(of("FK5"), SkyCoordinates::Fk5);
        assert_eq!(of("GeocentricSolarEcliptic"), SkyCoordinates::Icrs);
    }
}
