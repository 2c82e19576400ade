//! The sky as a disc: a fisheye. FITS: ARC and ZEA.

use super::solid_angle::integral;
use super::{ImagePlane, Sight, field_of_view};
use crate::projection::frame::GeometryError;
use core::f64::consts::TAU;

/// How the radius on a disc grows with the angle θ from the pointing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiscMapping {
    /// Like θ: equidistant, FITS code ARC.
    Equidistant,
    /// Like sin(θ/2): equal areas of sky have equal areas on the disc, FITS code ZEA.
    EqualArea,
}

/// A cone about the pointing as a disc that touches the borders of the square; points outside of the
/// disc are not in the image.
///
/// Calabretta & Greisen 2002 (doi:10.1051/0004-6361:20021327), sections 5.1.6 (ARC) and 5.1.7 (ZEA).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscPlane {
    mapping: DiscMapping,
    /// The largest angle from the pointing.
    reach_rad: f64,
}

impl DiscPlane {
    /// A cone of the full angle `fov_rad` \[rad\], above 0 and at most 2π, which is the whole sky.
    pub(crate) fn new(fov_rad: f64, mapping: DiscMapping) -> Result<Self, GeometryError> {
        if fov_rad > 0.0 && fov_rad <= TAU {
            Ok(Self { mapping, reach_rad: 0.5 * fov_rad })
        } else {
            Err(field_of_view(fov_rad, "a full angle of the cone in (0, 360] degrees"))
        }
    }

    /// sin and cos of the angle from the pointing at a radius, 1 at the rim; beyond it the
    /// equidistant map goes on past the antipode, the other one stays there.
    fn angle(&self, radius: f64) -> (f64, f64) {
        match self.mapping {
            DiscMapping::Equidistant => (radius * self.reach_rad).sin_cos(),
            DiscMapping::EqualArea => {
                let half = (radius * (0.5 * self.reach_rad).sin()).min(1.0);
                (2.0 * half * (1.0 - half * half).sqrt(), 1.0 - 2.0 * half * half)
            }
        }
    }

    /// dΩ per area of a disc of radius 1.
    fn density(&self, radius: f64) -> f64 {
        match self.mapping {
            DiscMapping::Equidistant => {
                let angle = radius * self.reach_rad;
                let sinc =
                    if angle < 1e-4 { 1.0 - angle * angle / 6.0 } else { angle.sin() / angle };
                self.reach_rad.powi(2) * sinc
            }
            DiscMapping::EqualArea => 4.0 * (0.5 * self.reach_rad).sin().powi(2),
        }
    }
}

/// From the unit square to the disc of radius 1 in the square [−1, 1]².
fn on_disc(xy: [f64; 2]) -> [f64; 2] {
    xy.map(|along| 2.0 * along - 1.0)
}

impl ImagePlane for DiscPlane {
    fn sight(&self, xy: [f64; 2]) -> Sight {
        let [right, up] = on_disc(xy);
        let radius = right.hypot(up);
        let (sin_angle, cos_angle) = self.angle(radius);
        let across = if radius > 0.0 { sin_angle / radius } else { 0.0 };
        Sight::from_point_observer([across * right, across * up, cos_angle])
    }

    fn xy_of(&self, [right, up, forward]: [f64; 3]) -> Option<[f64; 2]> {
        let across = right.hypot(up);
        let angle = across.atan2(forward);
        let radius = match self.mapping {
            DiscMapping::Equidistant => angle / self.reach_rad,
            DiscMapping::EqualArea => (0.5 * angle).sin() / (0.5 * self.reach_rad).sin(),
        };
        if across > 0.0 {
            Some([right, up].map(|along| 0.5 + 0.5 * radius * along / across))
        } else {
            (forward > 0.0).then_some([0.5; 2])
        }
    }

    fn solid_angle_density(&self, xy: [f64; 2]) -> f64 {
        let [right, up] = on_disc(xy);
        4.0 * self.density(right.hypot(up))
    }

    fn solid_angle(&self, min: [f64; 2], max: [f64; 2]) -> f64 {
        let ([x0, y0], [x1, y1]) = (on_disc(min), on_disc(max));
        // Rows are counted by the angle whose sine they are at: the rim has no vertical tangent.
        let [low, high] = [y0, y1].map(|y| y.clamp(-1.0, 1.0).asin());
        let mut breaks = vec![low, high];
        // Where the rim crosses the left or right border the row's ends begin to follow another curve.
        for x in [x0, x1].into_iter().filter(|x| x.abs() < 1.0) {
            let at = x.abs().acos();
            breaks.extend([-at, at].into_iter().filter(|t| (low..high).contains(t)));
        }
        breaks.sort_by(f64::total_cmp);
        let row = |t: f64| {
            let (y, half_chord) = t.sin_cos();
            let (from, to) = (x0.max(-half_chord), x1.min(half_chord));
            let along = |x: f64| self.density(x.hypot(y));
            if from < to { half_chord * integral(from, to, along) } else { 0.0 }
        };
        breaks.windows(2).map(|ends| integral(ends[0], ends[1], row)).sum()
    }

    fn contains(&self, xy: [f64; 2]) -> bool {
        let [right, up] = on_disc(xy);
        right * right + up * up <= 1.0
    }

    fn is_whole(&self) -> bool {
        false
    }
}
