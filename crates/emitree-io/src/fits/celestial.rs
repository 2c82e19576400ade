//! The header records of coordinates of the sky: rotation, pole, frame, time and observer.
//!
//! Calabretta & Greisen 2002 (doi:10.1051/0004-6361:20021327) for projections, Thompson 2006
//! (doi:10.1051/0004-6361:20054262) for helioprojective coordinates and the keywords of observers.

use super::card::{Card, CardValue};
use crate::sky::Sky;
use serde::{Deserialize, Serialize};

/// What a header of coordinates of the sky has beside its axes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Celestial {
    /// The rotation from pixels to the plane (`PCi_j`); none where the axes are along the pixels.
    pub rotation: Option<[[f64; 2]; 2]>,
    /// The native longitude of the pole \[deg\] (`LONPOLE`).
    pub longitude_of_pole_deg: f64,
    /// The latitude of the native pole \[deg\] (`LATPOLE`), where it is needed.
    pub latitude_of_pole_deg: Option<f64>,
    /// Whether the reference point is the native pole of a plate carrée (`PV1_0` to `PV1_2`).
    pub refers_to_pole: bool,
    /// The numbers of the frame, of the time and of the observer.
    pub sky: Option<Sky>,
}

impl Celestial {
    /// The rotation, as header records.
    pub(super) fn rotation_cards(&self) -> Vec<Card> {
        let rows = self.rotation.iter().flatten().zip(1..);
        let elements = rows.flat_map(|(row, i)| row.iter().zip(1..).map(move |(of, j)| (i, j, of)));
        let card = |(i, j, of): (i32, i32, &f64)| {
            Card::new(format!("PC{i}_{j}"), *of, "rotation of the axes")
        };
        elements.map(card).collect()
    }

    /// All others.
    pub(super) fn cards(&self) -> Vec<Card> {
        let degrees = "[deg] native longitude of the pole";
        let mut cards = vec![Card::new("LONPOLE", self.longitude_of_pole_deg, degrees)];
        if let Some(latitude) = self.latitude_of_pole_deg {
            cards.push(Card::new("LATPOLE", latitude, "[deg] of the native pole"));
        }
        if self.refers_to_pole {
            for (number, value) in [(0, 0.0), (1, 0.0), (2, 90.0)] {
                let card = Card::new(format!("PV1_{number}"), value, "reference point: the pole");
                cards.push(card);
            }
        }
        cards.extend(self.sky.iter().flat_map(cards_of_frame));
        cards
    }
}

/// The keywords of a frame: its equinox, the time, and the observer of the Sun.
fn cards_of_frame(sky: &Sky) -> Vec<Card> {
    let mut cards = Vec::new();
    let mut add = |keyword: &str, value: CardValue, comment: &str| {
        cards.push(Card::new(keyword, value, comment));
    };
    let of = sky.coordinates.description();
    if let Some(reference) = of.reference {
        add("RADESYS", reference.into(), "reference frame of the coordinates");
    }
    if let Some(equinox) = sky.equinox {
        add("EQUINOX", equinox.into(), "[yr] mean equinox");
    }
    if let Some(date) = &sky.date {
        add("TIMESYS", "UTC".into(), "scale of times");
        add("DATE-OBS", date.text.as_str().into(), "time of the observer and of the frames");
        add("MJD-OBS", date.mjd.into(), "[d] the same as a modified Julian date");
    }
    if let Some(observer) = &sky.observer {
        let stonyhurst = "[deg] Stonyhurst longitude of observer";
        add("RSUN_REF", observer.sun_radius_m.into(), "[m] radius of the Sun");
        add("DSUN_OBS", observer.distance_m.into(), "[m] from the observer to its centre");
        add("HGLN_OBS", observer.longitude_deg.into(), stonyhurst);
        add("HGLT_OBS", observer.latitude_deg.into(), "[deg] its latitude");
    }
    cards
}
