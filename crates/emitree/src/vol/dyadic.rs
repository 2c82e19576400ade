//! Dyadic places on the unit interval, and polynomials through values at them.
//!
//! A place is a number of steps of 2^−24, so that it is the same integer on every level. The
//! lattice of level l consists of the multiples of 2^−l. The level of a place is that of the
//! coarsest lattice that contains it.

use crate::cell::{self, whole};

/// The finest level of a place.
pub(crate) const DEEPEST_LEVEL: u8 = 24;
/// The number of steps in the unit interval.
pub(crate) const STEPS: u32 = 1 << DEEPEST_LEVEL;
/// The number of points of the longest stencil: degree 5, order 6.
pub(crate) const STENCIL: usize = 6;

/// The level of the coarsest lattice that contains `place`.
pub(crate) fn level_of(place: u32) -> u8 {
    if place.is_multiple_of(STEPS) {
        return 0;
    }
    // At most 23 trailing zeros: the ends have returned already.
    DEEPEST_LEVEL.saturating_sub(place.trailing_zeros().try_into().unwrap_or(DEEPEST_LEVEL))
}

/// The distance of neighbours on the lattice of `level`, in steps.
pub(crate) fn spacing(level: u8) -> u32 {
    STEPS >> level
}

/// A place, or a distance, as a fraction of the unit interval.
pub(crate) fn unit(place: u32) -> f64 {
    f64::from(place) / f64::from(STEPS)
}

/// The place at `distance` below `place`, or above it if `up`; `None` outside the interval.
pub(crate) fn beside(place: u32, distance: u32, up: bool) -> Option<u32> {
    if up { Some(place + distance).filter(|&p| p <= STEPS) } else { place.checked_sub(distance) }
}

/// The lowest place from `low` to `high` of the coarsest lattice that has one there.
pub(crate) fn coarsest_between(low: u32, high: u32) -> u32 {
    let place = |level: u8| low.next_multiple_of(spacing(level));
    (1..DEEPEST_LEVEL).map(place).find(|&place| place <= high).unwrap_or(low)
}

/// Weights of the polynomial through the points 0, 1, …, N − 1 at `OFFSET` + ½, for each OFFSET.
const fn halfway<const N: usize>() -> [[f64; N]; N] {
    let mut table = [[1.0; N]; N];
    let mut offset = 0;
    while offset < N {
        let mut k = 0;
        while k < N {
            let mut j = 0;
            while j < N {
                if j != k {
                    table[offset][k] *= (offset as f64 + 0.5 - j as f64) / (k as f64 - j as f64);
                }
                j += 1;
            }
            k += 1;
        }
        offset += 1;
    }
    table
}

static HALFWAY_2: [[f64; 2]; 2] = halfway();
static HALFWAY_3: [[f64; 3]; 3] = halfway();
static HALFWAY_4: [[f64; 4]; 4] = halfway();
static HALFWAY_5: [[f64; 5]; 5] = halfway();
static HALFWAY_6: [[f64; 6]; 6] = halfway();

/// The first index and the weights that predict the value midway between indices `interval` and
/// `interval` + 1 of a lattice of `intervals` = 2^l intervals.
///
/// Interpolating subdivision after Deslauriers & Dubuc 1989 (doi:10.1007/BF01889598) of the given
/// `order`. At the ends of the interval the closest stencil is used, on lattices with fewer points
/// than `order` all points.
pub(crate) fn midpoint_weights(
    order: usize,
    intervals: usize,
    interval: usize,
) -> (usize, &'static [f64]) {
    let points = (intervals + 1).min(order);
    let first = interval.saturating_sub(points / 2 - 1).min(intervals + 1 - points);
    let offset = interval - first;
    let weights: &[f64] = match points {
        2 => &HALFWAY_2[offset],
        3 => &HALFWAY_3[offset],
        4 => &HALFWAY_4[offset],
        5 => &HALFWAY_5[offset],
        _ => &HALFWAY_6[offset],
    };
    (first, weights)
}

/// Nodes and weights of the 3-point Gauss rule on \[0, 1\]: exact for quintics.
pub(crate) const GAUSS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// Weights of the quintic through the points 0, 1, …, 5 at `t`.
pub(crate) fn polynomial_weights(t: f64) -> [f64; STENCIL] {
    core::array::from_fn(|k| {
        let others = (0..STENCIL).filter(|&j| j != k);
        others.fold(1.0, |product, j| product * (t - j as f64) / (k as f64 - j as f64))
    })
}

/// The value at `x` of the polynomial through the first [`STENCIL`] of the `points` (x, value), or
/// through all if there are fewer.
pub(crate) fn polynomial(points: &[(f64, f64)], x: f64) -> f64 {
    // Loops of constant length: this sum is evaluated more often than any other.
    match *points {
        [] => 0.0,
        [a] => through([a], x),
        [a, b] => through([a, b], x),
        [a, b, c] => through([a, b, c], x),
        [a, b, c, d] => through([a, b, c, d], x),
        [a, b, c, d, e] => through([a, b, c, d, e], x),
        [a, b, c, d, e, f, ..] => through([a, b, c, d, e, f], x),
    }
}

fn through<const N: usize>(points: [(f64, f64); N], x: f64) -> f64 {
    let mut terms = points.map(|(_, value)| value);
    for (k, term) in terms.iter_mut().enumerate() {
        for (j, &(x_j, _)) in points.iter().enumerate() {
            if j != k {
                *term = *term * (x - x_j) / (points[k].0 - x_j);
            }
        }
    }
    terms.iter().sum()
}

/// A dyadic place in the image plane, (x, y) in steps.
pub(crate) type Place = [u32; 2];

/// The places in the image at multiples of `distance` from `place`, up to `reach` along each axis,
/// with these multiples.
pub(crate) fn around(
    place: Place,
    distance: u32,
    reach: i8,
) -> impl Iterator<Item = (i8, i8, Place)> {
    let along = move |from: u32, times: i8| {
        beside(from, distance * u32::from(times.unsigned_abs()), times >= 0)
    };
    (-reach..=reach).flat_map(move |i| {
        (-reach..=reach)
            .filter(move |&j| (i, j) != (0, 0))
            .filter_map(move |j| Some((i, j, [along(place[0], i)?, along(place[1], j)?])))
    })
}

/// The place nearest below a coordinate from 0 to 1.
pub(crate) fn from_unit(along: f64) -> u32 {
    cell::to_u32(whole(along * f64::from(STEPS))).min(STEPS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_and_spacings_agree() {
        assert_eq!([0, STEPS, STEPS / 2, STEPS / 4, 1].map(level_of), [0, 0, 1, 2, 24]);
        for level in 1..=DEEPEST_LEVEL {
            assert_eq!(level_of(spacing(level)), level);
            assert_eq!(level_of(STEPS - spacing(level)), level);
        }
        assert_eq!(beside(STEPS, 1, true), None);
        assert_eq!(beside(0, 1, false), None);
        assert_eq!(coarsest_between(1, STEPS - 1), STEPS / 2);
        assert_eq!(coarsest_between(STEPS / 2 + 1, STEPS / 4 * 3 + 1), STEPS / 4 * 3);
        assert_eq!(coarsest_between(5, 5), 5);
    }

    #[test]
    fn polynomials_below_the_order_are_predicted() {
        for (order, degree) in [(4, 3), (6, 5)] {
            let polynomial = |x: f64| (1..=degree).fold(1.0, |sum, k| sum * x - f64::from(k));
            for intervals in [8, 16, 64] {
                for interval in 0..intervals {
                    let (first, weights) = midpoint_weights(order, intervals, interval);
                    assert_eq!(weights.len(), order);
                    let at = |k: f64| polynomial(k / intervals as f64);
                    let predicted: f64 =
                        weights.iter().enumerate().map(|(k, w)| w * at((first + k) as f64)).sum();
                    let exact = at(interval as f64 + 0.5);
                    assert!((predicted - exact).abs() < 1e-13 * exact.abs().max(1.0));
                }
            }
        }
    }

    #[test]
    fn a_quintic_is_interpolated_from_6_points() {
        let quintic = |x: f64| ((((3.0 * x - 1.0) * x + 0.5) * x - 2.0) * x + 1.0) * x - 0.25;
        let points: Vec<_> =
            [0.0, 0.1, 0.15, 0.5, 0.7, 1.0].iter().map(|&x| (x, quintic(x))).collect();
        assert!((polynomial(&points, 0.3) - quintic(0.3)).abs() < 1e-14);
    }
}
