//! From longitudes about the pointing to those of a frame of the sky.
//!
//! Calabretta & Greisen 2002 (doi:10.1051/0004-6361:20021327) for projections.

use super::{Celestial, Wcs};
use crate::sky::{Pointing, Sky, SkyCoordinates, cross, dot};

/// How far the pole of the sky has to be from the great circles on which the middle of a plate carrée
/// does not determine its rotation \[rad\]: here ten of sixteen digits are left.
const BESIDE: f64 = 1e-3;

/// Elements of rotations that are rounding errors.
const ROUNDING: f64 = 1e-14;

impl Wcs {
    /// The same pixels in coordinates of the sky; unchanged where they are none about a pointing.
    #[must_use]
    pub fn on_sky(mut self, sky: &Sky, pointing: &Pointing) -> Self {
        let Some(axes) = pointing.axes else { return self };
        let [first, second, ..] = &mut self.axes[..] else { return self };
        let Some(code) = first.ctype.strip_prefix("XLON-").map(str::to_owned) else {
            return self;
        };
        let of = sky.coordinates.description();
        let [longitude, latitude] = of.letters;
        first.ctype = format!("{longitude}-{code}");
        second.ctype = format!("{latitude}-{code}");
        of.name.clone_into(&mut self.name);
        let steps = [first.cdelt, second.cdelt];
        // Seen from inside, right-handed longitudes increase to the left, and so does the first axis.
        let hand = if of.is_left_handed { 1.0 } else { -1.0 };
        first.cdelt *= hand;
        let [mut right, up, mut forward] = axes.map(|axis| sky.of_model(axis));
        let mut celestial = Celestial {
            longitude_of_pole_deg: 180.0,
            sky: Some(sky.clone()),
            ..Celestial::default()
        };
        let mut reference = forward;
        if code == "CAR" {
            // The native pole is up; the pole of the sky is at this native longitude.
            let mut from_up = right[2].hypot(forward[2]);
            if from_up < ROUNDING {
                (right[2], forward[2], from_up) = (0.0, 0.0, 0.0);
            }
            celestial.longitude_of_pole_deg = (hand * right[2]).atan2(forward[2]).to_degrees();
            if forward[2].abs() < BESIDE * from_up || up[2].abs() < BESIDE {
                // The middle does not determine the rotation: the native pole is the reference.
                reference = up;
                celestial.refers_to_pole = true;
            } else {
                celestial.latitude_of_pole_deg = Some(up[2].clamp(-1.0, 1.0).asin().to_degrees());
            }
        }
        let longitude_rad = reference[1].atan2(reference[0]);
        let latitude_rad = reference[2].atan2(reference[0].hypot(reference[1]));
        let degrees = longitude_rad.to_degrees();
        // Longitudes of the Sun are about its centre, others from 0 to 360 degrees.
        let is_of_sun = sky.coordinates == SkyCoordinates::Helioprojective;
        first.crval = if is_of_sun { degrees } else { degrees.rem_euclid(360.0) };
        second.crval = latitude_rad.to_degrees();
        if code != "CAR" {
            let (sine, cosine) = longitude_rad.sin_cos();
            let east = [-sine, cosine, 0.0];
            let normal =
                [latitude_rad.cos() * cosine, latitude_rad.cos() * sine, latitude_rad.sin()];
            let north = cross(normal, east);
            let turned = [[dot(east, right), dot(east, up)], [dot(north, right), dot(north, up)]];
            let signed = [hand * steps[0], steps[1]];
            celestial.rotation = Some(core::array::from_fn(|row| {
                core::array::from_fn(|column| {
                    let element = turned[row][column] * steps[column] / signed[row];
                    let unity = if row == column { 1.0 } else { 0.0 };
                    let near = [0.0, unity].into_iter().find(|of| (element - of).abs() < ROUNDING);
                    near.unwrap_or(element)
                })
            }));
        }
        for axis in [first, second] {
            axis.cname.clear();
        }
        self.pole_deg = None;
        self.celestial = Some(celestial);
        self
    }
}
