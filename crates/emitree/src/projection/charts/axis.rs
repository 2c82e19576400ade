//! Lines of sight relative to an axis at which the emission is singular.
//!
//! Seen from a point, the axis and the observer define a plane. A line of sight is given by the angle β between
//! that plane and the one through the line and the observer along the axis, and by its elevation above the
//! plane across the axis. Parallel lines are given by their distance from the axis and by their position along
//! it. Both sides of the axis have charts of their own: the azimuth of shells is the elevation ε on one side, and
//! π − ε on the other.

use crate::projection::charts::aim::{Aim, Angle};
use crate::projection::surroundings::{Observer, SightLine};
use crate::projection::vector::{along, cross, difference, dot, norm, unit};
use core::f64::consts::{FRAC_PI_2, PI};

/// The azimuths between the two sides.
pub(super) const SIDES: [f64; 2] = [FRAC_PI_2, -FRAC_PI_2];

/// An axis as an observer sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SeenAxis {
    /// The point of the axis nearest to the observer, or some point for parallel lines.
    position: [f64; 3],
    direction: [f64; 3],
    /// For an observer at a point, the unit vector to the axis; for parallel lines, their direction.
    towards: [f64; 3],
    /// The unit vector across the axis and the lines of sight to it.
    across: [f64; 3],
    /// The distance of the observer from the axis, infinite for parallel lines.
    pub(super) distance: f64,
    /// For parallel lines the length of the axis over which the elevation changes by π/4.
    length: f64,
}

impl SeenAxis {
    /// The axis through `position` along the unit vector `direction`; `None` if it is seen as a point, or the
    /// observer is on it. Parallel lines are in view over about `length`.
    pub(super) fn new(
        position: [f64; 3],
        direction: [f64; 3],
        observer: Observer,
        length: f64,
    ) -> Option<Self> {
        match observer {
            Observer::Point(from) => {
                let to = difference(position, from);
                let foot = dot(to, direction);
                let perpendicular = along(to, -foot, direction);
                let distance = norm(perpendicular);
                let towards = unit(perpendicular).filter(|_| distance > 1e-9 * norm(to))?;
                let across = cross(direction, towards);
                let position = along(from, 1.0, perpendicular);
                Some(Self { position, direction, towards, across, distance, length })
            }
            Observer::Parallel { direction: towards, .. } => {
                let across = cross(direction, towards);
                let across = unit(across).filter(|_| norm(across) > 1e-6)?;
                let distance = f64::INFINITY;
                Some(Self { position, direction, towards, across, distance, length })
            }
        }
    }

    /// The unit vector along the axis.
    pub(super) fn direction(&self) -> [f64; 3] {
        self.direction
    }

    /// A line of sight relative to the axis.
    pub(super) fn aim(&self, line: &SightLine) -> Aim {
        let rise = dot(line.direction, self.direction);
        let level = along(line.direction, -rise, self.direction);
        let squared = dot(level, level).max(f64::MIN_POSITIVE);
        let stretch = squared.sqrt();
        let from = difference(line.origin, self.position);
        let nearest = -dot(from, level) / squared;
        let beside = |miss: f64, elevation: f64| {
            if miss >= 0.0 { elevation } else { PI - elevation }
        };
        if self.distance == f64::INFINITY {
            let miss = dot(from, self.across);
            let place = dot(from, cross(self.across, self.towards));
            let azimuth = beside(miss, (place / self.length).atan());
            let miss = miss.abs();
            let (angle, azimuth) = (Angle::Known(miss), Angle::Known(azimuth));
            return Aim { angle, azimuth, miss, is_ahead: true, nearest, stretch };
        }
        let (across, ahead) = (dot(line.direction, self.across), dot(line.direction, self.towards));
        Aim {
            angle: Angle::Of { across: across.abs(), along: ahead },
            azimuth: Angle::Known(beside(across, rise.atan2(stretch))),
            miss: self.distance * across.abs() / stretch,
            is_ahead: ahead > 0.0,
            nearest,
            stretch,
        }
    }

    /// The origin and the direction of the line of an angle (a distance from the axis for parallel lines) and an
    /// azimuth.
    pub(super) fn line(
        &self,
        observer: Observer,
        angle: f64,
        azimuth: f64,
    ) -> ([f64; 3], [f64; 3]) {
        let (rise, level) = azimuth.sin_cos();
        let side = 1.0_f64.copysign(level);
        let level = level.abs();
        match observer {
            Observer::Point(origin) => {
                let (sin, cos) = angle.sin_cos();
                let direction: [f64; 3] = core::array::from_fn(|i| {
                    let across = cos * self.towards[i] + side * sin * self.across[i];
                    level * across + rise * self.direction[i]
                });
                (origin, unit(direction).unwrap_or(direction))
            }
            Observer::Parallel { plane_point, direction } => {
                let up = cross(self.across, self.towards);
                let place = self.length * rise / level.max(f64::MIN_POSITIVE);
                let point = along(along(self.position, side * angle, self.across), place, up);
                let back = dot(difference(plane_point, point), direction);
                (along(point, back, direction), direction)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POSITION: [f64; 3] = [0.3, 2.0, -1.0];

    fn direction() -> [f64; 3] {
        unit([0.2, 0.1, 1.0]).unwrap()
    }

    /// The distance between the axis and a line, and how far along the line it is least, by many points.
    fn nearest_of(line: &SightLine) -> (f64, f64) {
        let of = |s: f64| {
            let from = difference(line.at(s), POSITION);
            norm(along(from, -dot(from, direction()), direction()))
        };
        let points = (0..400_000).map(|k| f64::from(k) * 2e-5 - 1.0);
        points.map(|s| (of(s), s)).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    }

    #[test]
    fn lines_lead_back_and_are_as_near_as_they_are() {
        let parallel = Observer::Parallel {
            plane_point: [0.0; 3],
            direction: unit([0.1, 1.0, -0.3]).unwrap(),
        };
        for observer in [Observer::Point([0.5, -1.0, 0.7]), parallel] {
            let axis = SeenAxis::new(POSITION, direction(), observer, 2.0).unwrap();
            for (angle, azimuth) in [(0.02, 0.3), (0.3, -0.4), (1e-7, PI - 0.2), (0.1, PI + 0.5)] {
                let (origin, towards) = axis.line(observer, angle, azimuth);
                let line = SightLine { origin, direction: towards, ends: [0.0, 9.0] };
                let aim = axis.aim(&line);
                assert!((aim.angle() / angle - 1.0).abs() < 1e-6, "{observer:?} {}", aim.angle());
                assert!((aim.azimuth() - azimuth).abs() < 1e-9, "{azimuth} {}", aim.azimuth());
                let (miss, at) = nearest_of(&line);
                assert!((aim.miss - miss).abs() < 1e-4 && (aim.nearest - at).abs() < 0.01);
            }
        }
    }

    #[test]
    fn an_axis_seen_end_on_has_no_coordinates() {
        let on_it = Observer::Point(along(POSITION, 3.0, direction()));
        assert_eq!(SeenAxis::new(POSITION, direction(), on_it, 1.0), None);
        let parallel = Observer::Parallel { plane_point: [0.0; 3], direction: direction() };
        assert_eq!(SeenAxis::new(POSITION, direction(), parallel, 1.0), None);
    }
}
