//! The emission of a view, and its integral along a line.

use super::shapes::{Ball, Vector, advanced, dot, less, norm};
use crate::family::generator::Generator;
use crate::gauss::Gauss;

/// How an emission falls with the distance from a body's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fall {
    /// exp(−(max(r, R) − R)/h).
    Exponential(f64),
    /// (max(r, R)/R)^(−n).
    Power(i32),
}

/// An emission rate.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Glow {
    Uniform,
    /// Around `centre`, level within `radius`; 1 + `tilt` times the cosine of the angle from `pole`.
    Radial {
        centre: Vector,
        radius: f64,
        fall: Fall,
        tilt: f64,
        pole: Vector,
    },
    /// exp(−|r − centre|²/width²) for each, and a level rate.
    Blobs {
        level: f64,
        blobs: Vec<(Vector, f64)>,
    },
}

impl Glow {
    /// One of the kinds around a body of `radius`, with lengths that suit a view of so much `width`.
    pub(super) fn draw(
        generator: &mut Generator,
        kind: u32,
        centre: Vector,
        radius: f64,
        width: f64,
    ) -> Self {
        let tilt = if kind == 3 { generator.between(0.3, 0.9) } else { 0.0 };
        let [pole, ..] = generator.axes();
        match kind {
            0 => Self::Uniform,
            1 | 3 => {
                let fall = match generator.whole(0..=1) {
                    0 => Fall::Exponential(generator.log_between(0.05, 0.5) * width),
                    // Below radii as long as that the rate would fall within a small part of the view.
                    _ => Fall::Power([2, 3, 4, 6][generator.whole(0..=3) as usize]),
                };
                Self::Radial { centre, radius, fall, tilt, pole }
            }
            _ => {
                let blobs = (0..generator.whole(1..=3)).map(|_| {
                    let [towards, ..] = generator.axes();
                    let away = radius + generator.between(0.0, 0.6) * width;
                    let size = generator.log_between(0.12, 0.5) * width;
                    (advanced(centre, away, towards), size)
                });
                let blobs = blobs.collect();
                Self::Blobs { level: generator.between(0.0, 0.1), blobs }
            }
        }
    }

    /// The same kind of emission with other parameters: positions by up to `change` of their lengths, lengths
    /// by that factor, at random. A uniform one stays as it is.
    pub(super) fn changed(&self, generator: &mut Generator, change: f64) -> Self {
        let mut factor = |of: f64| of * (1.0 + change * generator.between(-1.0, 1.0));
        match self {
            Self::Uniform => Self::Uniform,
            Self::Radial { centre, radius, fall, tilt, pole } => {
                let fall = match *fall {
                    Fall::Exponential(scale) => Fall::Exponential(factor(scale)),
                    power @ Fall::Power(_) => power,
                };
                let tilt = tilt + factor(change) - change;
                let pole = pole.map(&mut factor);
                let pole = pole.map(|along| along / norm(pole));
                Self::Radial { centre: *centre, radius: *radius, fall, tilt, pole }
            }
            Self::Blobs { level, blobs } => {
                let blob = |&(centre, size): &(Vector, f64)| {
                    let centre = centre.map(|along| along + factor(size) - size);
                    (centre, factor(size))
                };
                let blobs = blobs.iter().map(blob).collect();
                Self::Blobs { level: *level, blobs }
            }
        }
    }

    pub(super) fn rate(&self, position: Vector) -> f64 {
        match self {
            Self::Uniform => 1.0,
            Self::Radial { centre, radius, fall, tilt, pole } => {
                let offset = less(position, *centre);
                let distance = norm(offset);
                let outside = distance.max(*radius);
                let falls = match fall {
                    Fall::Exponential(scale) => libm::exp(-(outside - radius) / scale),
                    Fall::Power(power) => (outside / radius).powi(-power),
                };
                falls * (1.0 + tilt * dot(offset, *pole) / outside)
            }
            Self::Blobs { level, blobs } => {
                let of_blob = |(centre, size): &(Vector, f64)| {
                    let offset = less(position, *centre);
                    libm::exp(-dot(offset, offset) / (size * size))
                };
                level + blobs.iter().map(of_blob).sum::<f64>()
            }
        }
    }

    /// Whether its integral to infinity is infinite.
    pub(super) fn is_endless(&self) -> bool {
        matches!(self, Self::Uniform | Self::Blobs { .. })
    }

    /// The sphere at which the rate has a kink.
    pub(super) fn kink(&self) -> Option<Ball> {
        match self {
            Self::Radial { centre, radius, .. } => Some(Ball::sphere(*centre, *radius)),
            Self::Uniform | Self::Blobs { .. } => None,
        }
    }

    /// ∫ of the rate along a line from `from` to `to`, possibly ∞, by a `rule` between breaks.
    pub(super) fn integral(
        &self,
        origin: Vector,
        direction: Vector,
        [from, to]: [f64; 2],
        rule: &Gauss,
    ) -> f64 {
        if let Self::Uniform = self {
            return to - from;
        }
        let mut breaks = vec![from];
        if to.is_finite() {
            breaks.push(to);
        }
        let mut around = |centre: Vector, scale: f64, reach: f64| {
            let closest = dot(less(centre, origin), direction);
            breaks.push(closest);
            let mut distance = 0.5 * scale;
            while distance < reach {
                breaks.extend([closest - distance, closest + distance]);
                distance *= 1.6;
            }
        };
        match self {
            Self::Uniform => {}
            Self::Radial { centre, fall, radius, .. } => {
                // The closest point is at the distance b from the centre: on the line the rate changes
                // over the root of b h.
                let along = dot(less(*centre, origin), direction);
                let b = norm(less(advanced(origin, along, direction), *centre)).max(0.3 * radius);
                let scale = match fall {
                    Fall::Exponential(scale) => (scale * b).sqrt().min(b),
                    Fall::Power(_) => 0.5 * b,
                };
                around(*centre, scale, 50.0 * (b + scale));
            }
            Self::Blobs { blobs, .. } => {
                blobs.iter().for_each(|(centre, size)| around(*centre, *size, 8.0 * size));
            }
        }
        if let Some([enter, leave]) = self.kink().and_then(|ball| ball.crossing(origin, direction))
        {
            breaks.extend([enter, leave]);
        }
        breaks.retain(|t| (from..=to).contains(t));
        breaks.sort_by(f64::total_cmp);
        let rate = |t: f64| self.rate(advanced(origin, t, direction));
        let inner: f64 = breaks.windows(2).map(|ends| rule.integrate(ends[0], ends[1], rate)).sum();
        if to.is_finite() {
            return inner;
        }
        // What is beyond the last break: over 1/s, in which powers are polynomials.
        let last = breaks.last().copied().unwrap_or(from);
        let shift = last.abs() + 1.0;
        let tail = |u: f64| {
            let s = shift / u;
            rate(last - shift + s) * s / u
        };
        inner + rule.integrate_panels([0.0, 1.0], 4, |u| if u > 0.0 { tail(u) } else { 0.0 })
    }
}
