//! The depth along a piece of a line of sight: the weighted mean of several coordinates.
//!
//! Each coordinate runs from 0 to 1 along the piece. The *own* one resolves what is close to the
//! surfaces of the piece; what is far from them, in units of their radius, would occupy so small a
//! part of it that no sample meets it. The *plain* one is that of lines without surfaces, and there
//! is one for each other centre, the angle there. A feature occupies at least its share in each of
//! them, times a constant weight.

use crate::projection::charts::singular;
use crate::projection::ellipsoid::Ellipsoid;
use crate::projection::span::Span;
use crate::projection::surroundings::SightLine;
use crate::projection::vector::{along, dot, norm};
use core::f64::consts::{FRAC_PI_2, PI};

/// The largest number of other centres.
pub(super) const MOST_CENTRES: usize = 4;

/// A coordinate that resolves what is close to surfaces.
#[derive(Clone, Copy, Debug)]
pub(super) enum Own {
    /// Even in the distance.
    Even,
    /// From the far end, which is on a surface with this scale, to the near end.
    Inwards(f64),
    /// From the near end, which is on a surface with this scale, to the far end.
    Outwards(f64),
    /// Even in the angle at the centre, given the distance at which the line is nearest to it, and how
    /// near.
    Angle { nearest: f64, miss: f64 },
    /// About a singularity, given the distance at which the line is nearest to it, and how near.
    Singular { nearest: f64, miss: f64 },
    /// As on lines without surfaces.
    Plain,
}

/// The depth of one piece of a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Depth {
    own: Own,
    /// The distances of the ends.
    ends: [f64; 2],
    /// As on a line without surfaces.
    plain: Span,
    weights: Weights,
    centres: [Option<Centre>; MOST_CENTRES],
}

/// The number of coordinates: the own and the plain one, and those of centres.
pub(crate) const COORDINATES: usize = 2 + MOST_CENTRES;
/// The weights of all coordinates; their sum is 1.
pub(crate) type Weights = [f64; COORDINATES];

/// A centre beside a line of sight.
#[derive(Clone, Copy, Debug)]
struct Centre {
    /// The distance at which the line is nearest.
    nearest: f64,
    /// The length over which the angle changes.
    reach: f64,
    /// The angle from one end to the other.
    whole: f64,
}

/// The weight of the plain coordinate before anything is known of the emission. With 0.1 to 0.25 the
/// gallery's views with bodies take the same number of evaluations within 30 %; with 0 a cloud between
/// the observer and a small body was overlooked.
const PLAIN_WEIGHT: f64 = 0.2;
/// The share of the rest that larger bodies around other centres have, in proportion to the squares
/// of their sizes. Without it a planet's corona beside its moon took twice as many evaluations.
const SHARE_OF_CENTRES: f64 = 0.5;
/// The relative change of the own coordinate at which an inversion ends.
const INVERTED: f64 = 1e-15;
/// The most steps of an inversion: bisections alone end after so many.
const MOST_STEPS: usize = 64;

/// The weights before anything is known of the emission, for surfaces of a size beside other centres;
/// where the own coordinate is the plain one there is no other.
pub(super) fn usual_weights(is_plain: bool, size: f64, centres: &[Ellipsoid]) -> Weights {
    let plain = if is_plain { 0.0 } else { PLAIN_WEIGHT };
    let of_centres = || centres.iter().map(|centre| centre.longest().powi(2));
    let scale = SHARE_OF_CENTRES * (1.0 - plain) / (size * size + of_centres().sum::<f64>());
    let mut weights = [0.0; COORDINATES];
    weights[1] = plain;
    weights[2..].iter_mut().zip(of_centres()).for_each(|(weight, of)| *weight = scale * of);
    weights[0] = 1.0 - weights[1..].iter().sum::<f64>();
    weights
}

impl Depth {
    /// The depth along the part of a line with the ends of `plain`.
    pub(super) fn new(own: Own, plain: Span, weights: Weights) -> Self {
        let centres = [None; MOST_CENTRES];
        let own = match own {
            // The logarithm of the distance has no infinite end; the angle has.
            Own::Singular { nearest, miss } if !plain.ends().iter().all(|end| end.is_finite()) => {
                Own::Angle { nearest, miss }
            }
            own => own,
        };
        Self { own, ends: plain.ends(), plain, weights, centres }
    }

    /// The same with the angles at other centres.
    pub(super) fn beside(mut self, line: &SightLine, centres: &[Ellipsoid]) -> Self {
        for (found, centre) in self.centres.iter_mut().zip(centres) {
            *found = Some(Centre::new(centre, line, self.ends));
        }
        self
    }

    /// The distance at `z`, and ds/dz; `None` at an infinite end, where the rate falls to 0 faster
    /// than the path grows, and if the piece is empty.
    pub(super) fn at(&self, z: f64) -> Option<(f64, f64)> {
        let [from, to] = self.ends;
        // At the ends all coordinates are the same.
        let is_own = self.weights[0] >= 1.0 || z <= 0.0 || z >= 1.0;
        let own = if is_own { z } else { self.own_at_z(z) };
        let (distance, path_of_own) = self.own_at(own);
        let path = path_of_own / self.slope(distance, path_of_own);
        let is_known = to > from && distance.is_finite() && path.is_finite();
        // Rounding may move a distance beyond the ends.
        is_known.then_some((distance.clamp(from, to), path))
    }

    /// The z of a distance; beyond [0, 1] outside of the piece.
    pub(super) fn z_of(&self, distance: f64) -> f64 {
        self.weights[0] * self.own_of(distance) + self.others_of(distance)
    }

    /// The own coordinate where z has a value: by Newton's method, with bisections where it fails.
    fn own_at_z(&self, z: f64) -> f64 {
        let (mut low, mut high) = (0.0_f64, 1.0_f64);
        let mut own = z;
        for _ in 0..MOST_STEPS {
            let (distance, path) = self.own_at(own);
            let excess = self.weights[0] * own + self.others_of(distance) - z;
            *(if excess > 0.0 { &mut high } else { &mut low }) = own;
            let step = excess / self.slope(distance, path);
            let next = own - step;
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            let change = (next - own).abs();
            own = next;
            if change <= INVERTED * own {
                break;
            }
        }
        own
    }

    /// dz over the change of the own coordinate.
    fn slope(&self, distance: f64, path: f64) -> f64 {
        let slopes = self.slopes(distance, path);
        self.weights.iter().zip(slopes).map(|(weight, slope)| weight * slope).sum()
    }

    /// The change of each coordinate with z; `None` at infinite ends.
    pub(super) fn shares(&self, z: f64) -> Option<Weights> {
        let (distance, path) = self.at(z)?;
        let (_, own) = self.own_at(self.own_of(distance));
        let mut shares = self.slopes(distance, path);
        shares[0] = path / own;
        shares.iter().all(|share| share.is_finite()).then_some(shares)
    }

    /// The change of each coordinate along a path, for the own one that on which it changes by 1.
    fn slopes(&self, distance: f64, path: f64) -> Weights {
        let mut slopes = [0.0; COORDINATES];
        slopes[0] = 1.0;
        if !path.is_finite() {
            return slopes;
        }
        let (_, plain) = self.plain.at(self.plain.z_of(distance));
        if plain > 0.0 {
            slopes[1] = path / plain;
        }
        for (slope, centre) in slopes[2..].iter_mut().zip(self.centres.iter().flatten()) {
            *slope = path * centre.angle_per_length(distance) / centre.whole;
        }
        slopes
    }

    /// The part of z from all coordinates but the own one.
    fn others_of(&self, distance: f64) -> f64 {
        let centres = self.weights[2..].iter().zip(self.centres.iter().flatten());
        let of_centre = |(weight, centre): (&f64, &Centre)| {
            weight * centre.angle([self.ends[0], distance]) / centre.whole
        };
        let of_plain =
            if self.weights[1] > 0.0 { self.weights[1] * self.plain.z_of(distance) } else { 0.0 };
        of_plain + centres.map(of_centre).sum::<f64>()
    }

    /// The distance and its derivative at a value of the own coordinate.
    fn own_at(&self, z: f64) -> (f64, f64) {
        let [from, to] = self.ends;
        match self.own {
            Own::Even => (from + z * (to - from), to - from),
            Own::Plain => self.plain.at(z),
            Own::Outwards(scale) => {
                let (t, dt_dz) = outwards(to - from, scale, z);
                (from + t, dt_dz)
            }
            Own::Inwards(scale) => {
                let (t, dt_dz) = outwards(to - from, scale, 1.0 - z);
                (to - t, dt_dz)
            }
            Own::Angle { nearest, miss } => {
                let (t, dt_dz) = by_angle([from - nearest, to - nearest], miss, z);
                (nearest + t, dt_dz)
            }
            Own::Singular { nearest, miss } => {
                let (t, dt_dz) = singular::at_part([from - nearest, to - nearest], miss, z);
                (nearest + t, dt_dz)
            }
        }
    }

    /// The own coordinate of a distance.
    fn own_of(&self, distance: f64) -> f64 {
        let [from, to] = self.ends;
        match self.own {
            Own::Even if to > from => (distance - from) / (to - from),
            Own::Even => 0.0,
            Own::Plain => self.plain.z_of(distance),
            Own::Outwards(scale) => outwards_z(to - from, scale, distance - from),
            Own::Inwards(scale) => 1.0 - outwards_z(to - from, scale, to - distance),
            Own::Angle { nearest, miss } => {
                let angle = |at: f64| angle_between(from - nearest, at - nearest, miss);
                let whole = angle(to);
                if whole > 0.0 { angle(distance) / whole } else { 0.0 }
            }
            Own::Singular { nearest, miss } => {
                singular::part_of([from - nearest, to - nearest], miss, distance - nearest)
            }
        }
    }
}

impl Centre {
    fn new(centre: &Ellipsoid, line: &SightLine, ends: [f64; 2]) -> Self {
        let (from, direction) = (centre.scaled_point(line.origin), centre.scaled(line.direction));
        let squared = dot(direction, direction);
        let nearest = -dot(from, direction) / squared;
        let miss = norm(along(from, nearest, direction));
        let reach = miss.hypot(1.0) / squared.sqrt();
        let mut centre = Self { nearest, reach, whole: 1.0 };
        centre.whole = centre.angle(ends);
        centre
    }

    fn angle_per_length(&self, distance: f64) -> f64 {
        let away = distance - self.nearest;
        self.reach / (self.reach * self.reach + away * away)
    }

    /// The angle between two distances.
    fn angle(&self, [from, to]: [f64; 2]) -> f64 {
        angle_between(from - self.nearest, to - self.nearest, self.reach)
    }
}

/// The distance t from a surface at `z` of a length, which may be infinite, and dt/dz.
fn outwards(length: f64, scale: f64, z: f64) -> (f64, f64) {
    let scale = scale.min(length);
    let bend = if length > 0.0 { 1.0 - scale / length } else { 0.0 };
    let v = z * z;
    let left = 1.0 - v * bend;
    (scale * v / left, 2.0 * z * scale / (left * left))
}

/// The z at a distance t from a surface; beyond [0, 1] outside of the length.
fn outwards_z(length: f64, scale: f64, t: f64) -> f64 {
    let scale = scale.min(length);
    let bend = if length > 0.0 { 1.0 - scale / length } else { 0.0 };
    let v = t / (scale + t * bend).max(f64::MIN_POSITIVE);
    v.abs().sqrt().copysign(v)
}

/// The angle between the points of a line at two distances from its point nearest to a centre.
fn angle_between(from: f64, to: f64, miss: f64) -> f64 {
    let miss = miss.max(f64::MIN_POSITIVE);
    match (from.is_finite(), to.is_finite()) {
        (true, true) => (miss * (to - from)).atan2(miss * miss + from * to),
        (true, false) => FRAC_PI_2 - (from / miss).atan(),
        (false, true) => FRAC_PI_2 + (to / miss).atan(),
        (false, false) => PI,
    }
}

/// The distance along a line from its point nearest to a centre, at the part `z` of the angle
/// between two points, and its derivative. The tangents are added without their poles: a line that
/// looks away from the centre has a `miss` near 0, and angles near π/2.
fn by_angle([from, to]: [f64; 2], miss: f64, z: f64) -> (f64, f64) {
    let least = if from.is_finite() { 1e-12 * from.abs() } else { 0.0 };
    let miss = miss.max(least).max(f64::MIN_POSITIVE);
    let whole = angle_between(from, to, miss);
    let part = z * whole;
    let t = if from.is_finite() {
        let (sin, cos) = part.sin_cos();
        miss * (from * cos + miss * sin) / (miss * cos - from * sin)
    } else {
        -miss / part.tan()
    };
    // The end itself, which rounding may move beyond infinity.
    let t = if z >= 1.0 { to } else { t };
    (t, whole * (miss * miss + t * t) / miss)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::span;

    const INFINITE: f64 = f64::INFINITY;
    const LINE: SightLine = SightLine {
        origin: [0.0, -6.0, 0.0],
        direction: [0.36, 0.8, 0.48],
        ends: [-INFINITE, INFINITE],
    };

    fn sphere(centre: [f64; 3], radius: f64) -> Ellipsoid {
        Ellipsoid::sphere(centre, radius).unwrap()
    }

    fn plain([from, to]: [f64; 2]) -> Span {
        span::Depth::new([-INFINITE, INFINITE], 6.0, true).unwrap().span(from, to)
    }

    /// The line as seen from a body that it misses.
    /// The angle at the origin.
    const ANGLE: Own = Own::Angle { nearest: 4.8, miss: 3.6 };

    fn is_plain(own: Own) -> bool {
        matches!(own, Own::Even | Own::Plain)
    }

    /// Every kind of own coordinate with the ends that it may have.
    const ALL: [(Own, [f64; 2]); 14] = [
        (Own::Even, [1.0, 5.0]),
        (Own::Inwards(0.3), [1.0, 5.0]),
        (Own::Inwards(9.0), [1.0, 5.0]),
        (Own::Inwards(0.3), [-INFINITE, 5.0]),
        (Own::Outwards(0.3), [1.0, 5.0]),
        (Own::Outwards(9.0), [1.0, 5.0]),
        (Own::Outwards(0.3), [5.0, INFINITE]),
        (ANGLE, [1.0, 9.0]),
        (ANGLE, [1.0, INFINITE]),
        (ANGLE, [-INFINITE, 9.0]),
        (ANGLE, [-INFINITE, INFINITE]),
        (Own::Plain, [1.0, 5.0]),
        (Own::Plain, [1.0, INFINITE]),
        (Own::Plain, [-INFINITE, INFINITE]),
    ];

    fn centres() -> [Ellipsoid; 2] {
        [sphere([1.0, -3.0, 2.5], 0.7), sphere([4.0, 7.0, -20.0], 3.0)]
    }

    /// The depths of all kinds, with weights from the own coordinate alone to others alone.
    fn depths() -> impl Iterator<Item = Depth> {
        let of_kind = |(own, ends): (Own, [f64; 2])| {
            let alone = Depth::new(own, plain(ends), usual_weights(is_plain(own), 1.0, &[]));
            let usual = usual_weights(is_plain(own), 1.0, &centres());
            let few = [1e-3, 0.199, 0.3, 0.5, 0.0, 0.0];
            let all = [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0], usual, few];
            let beside =
                all.map(|weights| Depth::new(own, plain(ends), weights).beside(&LINE, &centres()));
            [alone].into_iter().chain(beside)
        };
        ALL.into_iter().flat_map(of_kind)
    }

    #[test]
    fn depths_lead_back_and_rates_are_slopes() {
        for depth in depths() {
            for z in [1e-3, 0.03, 0.2, 0.5, 0.77, 0.96, 0.999] {
                let (distance, path) = depth.at(z).unwrap();
                let back = depth.z_of(distance);
                assert!((back - z).abs() < 1e-9, "{depth:?} {z}: {back}");
                let step = 1e-3 * f64::min(z, 1.0 - z);
                let rise =
                    |k: f64| [-0.5, 0.5].map(|half| depth.at(z + half * k * step).unwrap().0);
                let slope = |k: f64| (rise(k)[1] - rise(k)[0]) / (k * step);
                // Without the error of second order.
                let slope = (4.0 * slope(1.0) - slope(2.0)) / 3.0;
                // Of the distance, and of an own coordinate that changes little there.
                let (_, path_of_own) = depth.own_at(depth.own_of(distance));
                let rounding = 1e-14 * distance.abs().max(path_of_own) / (step * path);
                let wrong = (slope / path - 1.0).abs();
                assert!(wrong < 1e-6 + rounding, "{depth:?} {z}: {slope} {path}");
            }
        }
    }

    #[test]
    fn depths_begin_and_end_where_the_piece_does() {
        for depth in depths() {
            for (z, end) in [0.0, 1.0].into_iter().zip(depth.ends) {
                let found = depth.at(z);
                if end.is_finite() {
                    assert!(found.is_some(), "{depth:?} {z}");
                    let (distance, path) = found.unwrap();
                    assert!((distance - end).abs() < 1e-12 && path >= 0.0, "{depth:?} {found:?}");
                } else {
                    assert!(found.is_none_or(|(_, path)| path <= 0.0), "{depth:?} {found:?}");
                }
            }
        }
        for own in [Own::Even, Own::Inwards(0.3), Own::Outwards(0.3), ANGLE, Own::Plain] {
            let weights = usual_weights(is_plain(own), 1.0, &centres());
            let empty = Depth::new(own, plain([3.0; 2]), weights);
            assert!(empty.beside(&LINE, &centres()).at(0.5).is_none());
        }
    }

    #[test]
    fn usual_weights_sum_to_1() {
        for (own, _) in ALL {
            for (size, centres) in [(1.0, &centres()[..]), (0.01, &centres()[1..]), (1.0, &[])] {
                let weights = usual_weights(is_plain(own), size, centres);
                assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-15, "{weights:?}");
                assert!(weights.iter().all(|weight| *weight >= 0.0) && weights[0] > 0.3);
                let of_centres = weights[2..].iter().filter(|weight| **weight > 0.0).count();
                assert_eq!(of_centres, centres.len());
            }
        }
    }

    #[test]
    fn changes_of_coordinates_have_means_of_1() {
        for depth in depths() {
            let steps = 2000;
            let at = |k: u32| depth.shares((f64::from(k) + 0.5) / f64::from(steps)).unwrap();
            let mut means = [0.0; COORDINATES];
            for shares in (0..steps).map(at) {
                let of_z: f64 = depth.weights.iter().zip(shares).map(|(w, share)| w * share).sum();
                // Close to a surface the distance from it has few digits.
                assert!((of_z - 1.0).abs() < 1e-6, "{depth:?}: {shares:?}");
                means.iter_mut().zip(shares).for_each(|(mean, share)| {
                    *mean += share / f64::from(steps);
                });
            }
            let known = 2 + depth.centres.iter().flatten().count();
            for (mean, weight) in means[..known].iter().zip(depth.weights) {
                // Coordinates with little weight may change between all samples.
                assert!(weight < 0.01 || (mean - 1.0).abs() < 0.02, "{depth:?}: {means:?}");
            }
        }
    }

    #[test]
    fn what_is_far_from_a_small_body_is_resolved() {
        let own = Own::Inwards(0.27 / 3.0);
        let part = |weights: Weights, ends: [f64; 2]| {
            let depth = Depth::new(own, plain(ends), weights);
            depth.z_of(22.0) - depth.z_of(18.0)
        };
        for from in [0.0, -100.0, -INFINITE] {
            let ends = [from, 59.73];
            let share = plain(ends).z_of(22.0) - plain(ends).z_of(18.0);
            let found = part(usual_weights(is_plain(own), 0.27, &[]), ends);
            assert!(found >= PLAIN_WEIGHT * share, "{from}: {found} of {share}");
            let own_alone = part([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], ends);
            assert!(own_alone < 0.3 * found, "{from}: {own_alone} {found}");
        }
    }
}
