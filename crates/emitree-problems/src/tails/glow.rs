//! The emission, and its integral along a line.

use super::line::{Line, dot, panels};
use crate::family::generator::Generator;
use crate::gauss::Gauss;
use core::f64::consts::{PI, TAU};

/// How many clumps there are, between which distances from the origin, and how much of what is there is
/// smooth.
const CLUMPS: u32 = 150;
const CLUMPS_BETWEEN: [f64; 2] = [1.0, 40.0];
const SMOOTH_SHARE: f64 = 0.1;
/// The radius of the hole along the axis of a spiral, where the azimuth changes fast.
const HOLE: f64 = 0.5;
/// Over so many periods what oscillates is blended into its mean, and the erfc that does it goes from
/// −`SOFTNESS` to `SOFTNESS`, where it is within 1e-8 of its end. Its derivative has a standard deviation
/// of 0.088 of the ten periods, so that a wave is damped by exp(−(2π · 0.88)²/2) = 2e-7, of a tail that is
/// some hundredths of the whole.
const BLEND_PERIODS: f64 = 10.0;
const SOFTNESS: f64 = 4.0;

/// An emission about the origin that reaches to infinity.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Glow {
    Powers(Vec<Core>),
    Waves(Waves),
    Clumps(Vec<Clump>),
}

/// amplitude (1 + ρ²/a²)^(−p/2), ρ² = r² + flattening (r · axis)².
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Core {
    amplitude: f64,
    radius: f64,
    power: f64,
    axis: [f64; 3],
    flattening: f64,
}

/// A Gaussian of half width `width` at 1/e.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Clump {
    amplitude: f64,
    place: [f64; 3],
    width: f64,
}

/// R^−p times a periodic function of a phase that grows as k R, with R² = 1 + r².
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Waves {
    power: f64,
    wave_number: f64,
    phase: f64,
    profile: Profile,
}

/// What is periodic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Profile {
    /// cos² of half the phase.
    Cosine,
    /// exp(κ (cos − 1)): thin sheets, `arms` of them around the axis (the last of the axes), whose height
    /// flares as `flare` R.
    Sheet { sharpness: f64, arms: f64, flare: f64, axes: [[f64; 3]; 3] },
}

impl Glow {
    pub(super) fn draw(kind: u64, generator: &mut Generator) -> Self {
        match kind {
            0 => {
                let count = generator.whole(1..=2);
                Self::Powers((0..count).map(|_| Core::draw(generator)).collect())
            }
            1 => Self::Waves(Waves {
                power: generator.between(2.0, 3.0),
                // cos² has two maxima a period of the cosine.
                wave_number: 2.0 * generator.log_between(1.0, 5.0),
                phase: generator.between(0.0, TAU),
                profile: Profile::Cosine,
            }),
            2 => Self::Waves(Waves {
                power: 2.0,
                wave_number: generator.between(0.8, 2.0),
                phase: generator.between(0.0, TAU),
                profile: Profile::Sheet {
                    sharpness: generator.log_between(4.0, 25.0),
                    arms: f64::from(generator.whole(1..=2)),
                    flare: generator.between(0.4, 1.2),
                    axes: generator.axes(),
                },
            }),
            _ => Self::Clumps((0..CLUMPS).map(|_| Clump::draw(generator)).collect()),
        }
    }

    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Powers(_) => "powers",
            Self::Waves(Waves { profile: Profile::Cosine, .. }) => "oscillations",
            Self::Waves(_) => "spiral",
            Self::Clumps(_) => "clumps",
        }
    }

    pub(super) fn rate(&self, position: [f64; 3]) -> f64 {
        match self {
            Self::Powers(cores) => cores.iter().map(|core| core.rate(position)).sum(),
            Self::Waves(waves) => waves.rate(position),
            Self::Clumps(clumps) => {
                let clumpy: f64 = clumps.iter().map(|clump| clump.rate(position)).sum();
                SMOOTH_SHARE * envelope(position) + clumpy
            }
        }
    }

    /// ∫ g ds along a line, with panels of this rule.
    pub(super) fn radiance(&self, line: &Line, rule: &Gauss) -> f64 {
        match self {
            Self::Powers(cores) => cores.iter().map(|core| core.radiance(line, rule)).sum(),
            Self::Waves(waves) => waves.radiance(line, rule),
            Self::Clumps(clumps) => {
                let (middle, square) = line.nearest([0.0; 3]);
                let scale = (1.0 + square).sqrt();
                let smooth = line.integrate((middle, scale), rule, envelope);
                let clumpy: f64 = clumps.iter().map(|clump| clump.radiance(line)).sum();
                SMOOTH_SHARE * smooth + clumpy
            }
        }
    }
}

/// R^−2.
fn envelope(position: [f64; 3]) -> f64 {
    1.0 / (1.0 + dot(position, position))
}

impl Core {
    fn draw(generator: &mut Generator) -> Self {
        let [axis, _, _] = generator.axes();
        Self {
            amplitude: generator.between(0.3, 1.0),
            radius: generator.log_between(0.3, 1.0),
            power: [1.5, 2.0, 2.2, 2.5, 3.0][generator.whole(0..=4) as usize],
            axis,
            flattening: generator.between(0.0, 3.0),
        }
    }

    fn rate(&self, position: [f64; 3]) -> f64 {
        let along = dot(position, self.axis);
        let square = dot(position, position) + self.flattening * along * along;
        self.amplitude * (1.0 + square / (self.radius * self.radius)).powf(-0.5 * self.power)
    }

    /// ρ² is quadratic in s: about its vertex the integrand is (c² + t²)^(−p/2), up to factors.
    fn radiance(&self, line: &Line, rule: &Gauss) -> f64 {
        let (along, start) = (dot(line.direction, self.axis), dot(line.origin, self.axis));
        let square = 1.0 + self.flattening * along * along;
        let half = dot(line.origin, line.direction) + self.flattening * along * start;
        let constant = self.radius * self.radius
            + dot(line.origin, line.origin)
            + self.flattening * start * start;
        let scale = ((constant - half * half / square) / square).sqrt();
        line.integrate((-half / square, scale), rule, |position| self.rate(position))
    }
}

impl Clump {
    fn draw(generator: &mut Generator) -> Self {
        let distance = generator.log_between(CLUMPS_BETWEEN[0], CLUMPS_BETWEEN[1]);
        let [direction, _, _] = generator.axes();
        let place = direction.map(|x| distance * x);
        let width = distance * generator.between(0.2, 0.5);
        Self { amplitude: generator.between(0.2, 1.0) * envelope(place), place, width }
    }

    fn rate(&self, position: [f64; 3]) -> f64 {
        let square: f64 = position.iter().zip(self.place).map(|(x, c)| (x - c) * (x - c)).sum();
        self.amplitude * (-square / (self.width * self.width)).exp()
    }

    fn radiance(&self, line: &Line) -> f64 {
        let (middle, square) = line.nearest(self.place);
        let across = (-square / (self.width * self.width)).exp();
        let from = libm::erfc((line.near - middle) / self.width);
        self.amplitude * across * 0.5 * PI.sqrt() * self.width * from
    }
}

impl Waves {
    fn rate(&self, position: [f64; 3]) -> f64 {
        let scale = (1.0 + dot(position, position)).sqrt();
        let phase = self.wave_number * scale + self.phase;
        let periodic = match &self.profile {
            Profile::Cosine => 0.5 * (1.0 + phase.cos()),
            Profile::Sheet { sharpness, arms, axes, .. } => {
                let azimuth = dot(position, axes[1]).atan2(dot(position, axes[0]));
                (sharpness * ((arms * azimuth + phase).cos() - 1.0)).exp()
            }
        };
        periodic * self.envelope(position, scale)
    }

    /// The mean of the rate over the phase.
    fn mean(&self, position: [f64; 3]) -> f64 {
        let scale = (1.0 + dot(position, position)).sqrt();
        self.profile.mean() * self.envelope(position, scale)
    }

    fn envelope(&self, position: [f64; 3], scale: f64) -> f64 {
        let shape = match &self.profile {
            Profile::Cosine => 1.0,
            Profile::Sheet { flare, axes, .. } => {
                let [x, y, z] = axes.map(|axis| dot(position, axis));
                let height = z / (flare * scale);
                let square = (x * x + y * y) / (HOLE * HOLE);
                (-height * height).exp() * square * square / (1.0 + square * square)
            }
        };
        scale.powf(-self.power) * shape
    }

    fn radiance(&self, line: &Line, rule: &Gauss) -> f64 {
        let (middle, square) = line.nearest([0.0; 3]);
        let nearest = (1.0 + square).sqrt();
        let at_start = line.near - middle;
        let start = if line.near.is_finite() { nearest.hypot(at_start) } else { 0.0 };
        // Twice as far as the nearest point the phase grows along the line almost as in R. Beyond the
        // start there is no blending, which would need the waves on its other side.
        let blend_from = start.max(2.0 * nearest);
        let period = TAU / self.wave_number;
        let blend_to = blend_from + BLEND_PERIODS * period;
        let distance = |scale: f64| (scale * scale - nearest * nearest).sqrt();
        let mean = self.profile.mean();
        let blended = |s: f64| {
            let position = line.at(s);
            let scale = (1.0 + dot(position, position)).sqrt();
            let place = (scale - blend_from) / (blend_to - blend_from);
            if place <= 0.0 {
                return self.rate(position);
            }
            let left = 0.5 * libm::erfc(SOFTNESS * (2.0 * place - 1.0));
            left * self.rate(position) + (1.0 - left) * mean * self.envelope(position, scale)
        };
        let end = distance(blend_to);
        let from = if line.near.is_finite() { at_start } else { -end };
        // Four widths a panel, as elsewhere.
        let panel = 4.0 * self.profile.width() / self.wave_number;
        // The azimuth changes as fast as the line passes the axis: borders there.
        let mut borders = vec![from, end];
        if let Profile::Sheet { axes, .. } = &self.profile {
            let along = axes[2];
            let slope = dot(line.direction, along);
            let across: [f64; 3] = core::array::from_fn(|i| line.direction[i] - slope * along[i]);
            let nearest_to_axis = -dot(line.origin, across) / dot(across, across) - middle;
            let steps = [-1.0, -0.5, -0.25, -0.1, 0.0, 0.1, 0.25, 0.5, 1.0];
            borders.extend(steps.map(|step| nearest_to_axis + step));
        }
        borders.retain(|s| (from..=end).contains(s));
        borders.sort_by(f64::total_cmp);
        let waves: f64 = borders
            .windows(2)
            .map(|ends| {
                let count = panels(ends[1] - ends[0], panel);
                rule.integrate_panels([ends[0], ends[1]], count, |t| blended(middle + t))
            })
            .sum();
        let beyond = |ends| {
            line.integrate_part(ends, (middle, nearest), rule, |position| self.mean(position))
        };
        let after = beyond([middle + end, f64::INFINITY]);
        let before =
            if line.near.is_finite() { 0.0 } else { beyond([f64::NEG_INFINITY, middle - end]) };
        before + waves + after
    }
}

impl Profile {
    /// The mean over the phase.
    fn mean(&self) -> f64 {
        match self {
            Self::Cosine => 0.5,
            Self::Sheet { sharpness, .. } => {
                // The midpoint rule converges faster than any power for a periodic function: with 64
                // nodes to rounding for all that are drawn.
                let value = |i: u32| (sharpness * ((f64::from(i) * TAU / 64.0).cos() - 1.0)).exp();
                (0..64).map(value).sum::<f64>() / 64.0
            }
        }
    }

    /// The phase on which it changes \[rad\].
    fn width(&self) -> f64 {
        match self {
            Self::Cosine => 1.0,
            Self::Sheet { sharpness, .. } => 1.0 / sharpness.sqrt(),
        }
    }
}
