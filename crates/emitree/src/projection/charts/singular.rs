//! Coordinates about a singularity: the logarithm of the distance of a line of sight from it, and the
//! depth in units of that distance.
//!
//! Near a point where g ~ r^−γ the radiance is L ~ ψ^(1−γ), with the angle ψ from the direction to the point.
//! In c = ln(ψ/ψ₀) it has the same relative structure on all scales, and a softened core of any size takes a few
//! nodes. What is represented is h L, with the density h = (ψ² / (ψ² + p²))^(q/2) for pixels with a half side of p
//! and γ − 1 < q < 2: h L is bounded, and an error of it far inside a pixel changes the pixel by no more than one
//! at its border. Lines with ψ < ψ₀ have the value at ψ₀; they contribute (ψ₀/p)^(3−γ) of the pixel. About an axis
//! one dimension is missing: γ − 1 < q < 1, and (ψ₀/p)^(2−γ).
//!
//! Along a line at the distance b from the singularity, g ~ (b² + t²)^(−γ/2). The depth is the mean of the
//! angle atan(t/b), in which this is constant for γ = 2, and of asinh(t/b), for γ = 1.

use crate::projection::singularity::Singularity;

/// The share of a pixel that the lines closer than ψ₀ to a singularity contribute; for a peak without a power law ψ₀ itself,
/// in units of half of the side of a pixel.
const INNER_SHARE: f64 = 1e-5;
/// The smallest ψ₀, in units of half of the side of a pixel, so that positions are known to some digits.
const LEAST_INNER: f64 = 1e-9;
/// The relative change of asinh(t/b) at which an inversion ends, and the most steps.
const INVERTED: f64 = 1e-15;
const MOST_STEPS: usize = 64;

/// The logarithmic coordinate of the distance from a singularity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Logarithm {
    /// The distance at which it is 0.
    inner: f64,
    /// Half of the side of a pixel.
    pub(super) pixel: f64,
    /// The power of the distance that the density has inside a pixel.
    power: f64,
}

impl Logarithm {
    /// For a singularity, and half of the side of a pixel as an angle, or as a length for parallel lines.
    pub(super) fn new(singularity: &Singularity, pixel: f64) -> Self {
        let dimensions = if singularity.axis.is_some() { 1.0 } else { 2.0 };
        let exponent = singularity.exponent;
        // Without a power law it is a peak, of any width down to this part of a pixel.
        let (order, least) = match exponent > 0.0 {
            true => (dimensions + 1.0 - exponent, 0.0),
            false => (1.0, dimensions - 1.0),
        };
        let inner = INNER_SHARE.powf(1.0 / order).max(LEAST_INNER) * pixel;
        let power = 0.5 * (exponent - 1.0).max(least) + 0.5 * dimensions;
        Self { inner, pixel, power }
    }

    /// The same for distances in units of which `slope` are the present unit.
    pub(super) fn in_units(self, slope: f64) -> Self {
        Self { inner: self.inner / slope, pixel: self.pixel / slope, ..self }
    }

    /// The coordinate of a distance.
    pub(super) fn of(&self, distance: f64) -> f64 {
        (distance / self.inner).max(1.0).ln()
    }

    /// The distance of a coordinate.
    pub(super) fn distance(&self, logarithm: f64) -> f64 {
        self.inner * logarithm.exp()
    }

    /// The density h at a coordinate.
    pub(super) fn density(&self, logarithm: f64) -> f64 {
        let squared = (self.distance(logarithm.max(0.0)) / self.pixel).powi(2);
        (squared / (1.0 + squared)).powf(0.5 * self.power)
    }
}

/// The distance along a line from its point nearest to a singularity, and its derivative, at the part `z` between
/// two such distances; `miss` is how near the line is.
pub(super) fn at_part(ends: [f64; 2], miss: f64, z: f64) -> (f64, f64) {
    let along = Along::new(ends, miss);
    let (mut low, mut high) = (along.ends[0], along.ends[1]);
    let mut u = low + z * (high - low);
    for _ in 0..MOST_STEPS {
        let (part, slope) = along.part(u);
        *(if part > z { &mut high } else { &mut low }) = u;
        let next = u - (part - z) / slope;
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        let change = (next - u).abs();
        u = next;
        if change <= INVERTED * u.abs().max(1.0) {
            break;
        }
    }
    let u = if z >= 1.0 { along.ends[1] } else { u };
    (along.miss * u.sinh(), along.miss * u.cosh() / along.part(u).1)
}

/// The part between two distances from the point nearest to a singularity at which a third is.
pub(super) fn part_of(ends: [f64; 2], miss: f64, distance: f64) -> f64 {
    let along = Along::new(ends, miss);
    along.part((distance / along.miss).asinh()).0
}

/// A part of a line, in terms of u = asinh(t/b).
struct Along {
    miss: f64,
    ends: [f64; 2],
    /// The angles at both ends.
    angles: [f64; 2],
}

impl Along {
    fn new([from, to]: [f64; 2], miss: f64) -> Self {
        let miss = miss.max(1e-14 * (from.abs() + to.abs())).max(f64::MIN_POSITIVE);
        let ends = [from, to].map(|t| (t / miss).asinh());
        Self { miss, ends, angles: ends.map(|u| u.sinh().atan()) }
    }

    /// The part z at u, and its derivative.
    fn part(&self, u: f64) -> (f64, f64) {
        let [from, to] = self.ends;
        let even = 1.0 / (to - from);
        let of_angle = 1.0 / (self.angles[1] - self.angles[0]);
        let angle = u.sinh().atan() - self.angles[0];
        (0.5 * ((u - from) * even + angle * of_angle), 0.5 * (even + of_angle / u.cosh()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_lines_lead_back_and_rates_are_slopes() {
        for (ends, miss) in [([-8.5, 8.5], 1e-9), ([-3.0, 0.5], 2.0), ([4.0, 60.0], 1e-3)] {
            for z in [1e-3, 0.1, 0.4, 0.5, 0.73, 0.999] {
                let (t, slope) = at_part(ends, miss, z);
                assert!((part_of(ends, miss, t) - z).abs() < 1e-12, "{ends:?} {z} {t}");
                let step = 1e-5 * f64::min(z, 1.0 - z);
                let [before, after] = [-step, step].map(|by| at_part(ends, miss, z + by).0);
                let difference = (after - before) / (2.0 * step);
                assert!((difference / slope - 1.0).abs() < 1e-4, "{ends:?} {z}: {difference}");
            }
            for (z, end) in [0.0, 1.0].into_iter().zip(ends) {
                assert!((at_part(ends, miss, z).0 - end).abs() < 1e-9 * end.abs());
            }
        }
    }

    #[test]
    fn power_laws_are_bounded_along_lines_and_across() {
        for exponent in [1.0, 1.5, 2.0, 2.5] {
            let point = Singularity::point([0.0; 3]).unwrap().with_exponent(exponent).unwrap();
            let logarithm = Logarithm::new(&point, 1e-3);
            assert!((logarithm.distance(logarithm.of(3e-4)) / 3e-4 - 1.0).abs() < 1e-12);
            let radiance = |c: f64| logarithm.distance(c).powf(1.0 - exponent);
            let of = |c: f64| logarithm.density(c) * radiance(c);
            let at_pixel = of(logarithm.of(1e-3));
            assert!((0..60).all(|k| of(0.1 * f64::from(k)) < 3.0 * at_pixel), "{exponent}");
            let rate = |z: f64| {
                let (t, slope) = at_part([-8.0, 8.0], 1e-6, z);
                (1e-12 + t * t).powf(-0.5 * exponent) * slope
            };
            let mean = (0..2000).map(|k| rate((f64::from(k) + 0.5) / 2000.0)).sum::<f64>() / 2000.0;
            assert!((0..2000).all(|k| rate((f64::from(k) + 0.5) / 2000.0) < 5.0 * mean));
        }
    }
}
