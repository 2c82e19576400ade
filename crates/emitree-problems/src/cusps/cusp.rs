//! An emission that is singular at a point, and its integral along a line near that point.

use crate::gauss::Gauss;

/// A vector of the world.
pub(super) type Vector = [f64; 3];

/// Where a Gaussian is cut, in its widths: exp(−5.4²) is 2·10⁻¹³.
const END_OF_FADING: f64 = 5.4;
/// The longest part of a line for one rule, in u of t = a sinh u.
const LONGEST_PANEL: f64 = 0.8;
/// Parts of a line on which an emission fades.
const FADING_PANELS: usize = 8;
/// Lines are no closer to a point, so that their integrals are numbers.
const LEAST_DISTANCE: f64 = 1e-200;

/// How the rate depends on the distance from the point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Radial {
    /// s^−γ.
    Power(f64),
    /// \[(s/R) (1 + s/R)²\]⁻²: the square of the density of Navarro, Frenk and White.
    SquareOfNfw(f64),
}

/// Where the emission ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    /// At a sphere.
    Sphere(f64),
    /// Fading as exp(−r²/R²).
    Fading(f64),
}

/// 1 + tilt (n · pole) + strength exp\[sharpness (n · axis − 1)\], n the direction from the point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Jet {
    pub(super) tilt: f64,
    pub(super) pole: Vector,
    pub(super) strength: f64,
    pub(super) sharpness: f64,
    pub(super) axis: Vector,
}

/// g = amplitude · F(s) · J(n) about a point, s = √(r² + core²), n = offset/s, up to an end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cusp {
    pub(super) position: Vector,
    pub(super) amplitude: f64,
    pub(super) radial: Radial,
    pub(super) core: f64,
    pub(super) jet: Option<Jet>,
    pub(super) end: End,
}

/// A line by its point closest to a cusp, as an offset from it, and by distances from that point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    pub(super) offset: Vector,
    pub(super) direction: Vector,
    pub(super) ends: [f64; 2],
}

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// from + length · along.
pub(super) fn advanced(from: Vector, length: f64, along: Vector) -> Vector {
    [0, 1, 2].map(|i| from[i] + length * along[i])
}

impl Radial {
    /// γ of s^−γ close to the point.
    pub(super) fn exponent(self) -> f64 {
        match self {
            Self::Power(gamma) => gamma,
            Self::SquareOfNfw(_) => 2.0,
        }
    }

    fn at(self, distance: f64) -> f64 {
        match self {
            Self::Power(gamma) => libm::pow(distance, -gamma),
            Self::SquareOfNfw(scale) => {
                let x = distance / scale;
                let beyond = 1.0 + x;
                let density = 1.0 / (x * beyond * beyond);
                density * density
            }
        }
    }
}

impl Jet {
    fn at(&self, towards: Vector) -> f64 {
        let jet = libm::exp(self.sharpness * (dot(towards, self.axis) - 1.0));
        1.0 + self.tilt * dot(towards, self.pole) + self.strength * jet
    }
}

impl Cusp {
    /// The emission rate at a point; infinite at a singular one.
    pub(super) fn rate(&self, position: Vector) -> f64 {
        self.at(advanced(position, -1.0, self.position))
    }

    /// The rate at an offset from the point.
    fn at(&self, offset: Vector) -> f64 {
        let square = dot(offset, offset);
        let softened = libm::hypot(square.sqrt(), self.core);
        if matches!(self.end, End::Sphere(radius) if square > radius * radius) {
            return 0.0;
        }
        if softened <= 0.0 {
            return f64::INFINITY;
        }
        let towards = self.jet.map_or(1.0, |jet| jet.at(offset.map(|x| x / softened)));
        self.amplitude * self.fading(softened, square) * towards
    }

    /// ∫ g along a line, with t = a sinh u from its closest point on, a = √(b² + core²): s is a cosh u
    /// then, and the integrand is smooth in u however close the line is.
    pub(super) fn integral(&self, line: &Line, rule: &Gauss) -> f64 {
        let b2 = dot(line.offset, line.offset);
        let (reach, least_panels) = match self.end {
            End::Sphere(radius) => ((radius * radius - b2).max(0.0).sqrt(), 1),
            End::Fading(radius) => (END_OF_FADING * radius, FADING_PANELS),
        };
        let [from, to] = [line.ends[0].max(-reach), line.ends[1].min(reach)];
        if from >= to {
            return 0.0;
        }
        let a = libm::hypot(b2.sqrt(), self.core).max(LEAST_DISTANCE);
        let [low, high] = [from, to].map(|t| libm::asinh(t / a));
        let panels = panels(high - low).max(least_panels);
        rule.integrate_panels([low, high], panels, |u| {
            let grows = libm::exp(u);
            let [sinh, cosh] = [0.5 * (grows - 1.0 / grows), 0.5 * (grows + 1.0 / grows)];
            let along = a * sinh;
            let offset = advanced(line.offset, along, line.direction);
            // Not from the offset, whose square of a tiny length is less exact.
            let softened = a * cosh;
            let towards = self.jet.map_or(1.0, |jet| jet.at(offset.map(|x| x / softened)));
            let square = b2 + along * along;
            self.amplitude * self.fading(softened, square) * towards * softened
        })
    }

    /// F(s), fading, at a distance whose square without a core is `square`, within the end.
    fn fading(&self, softened: f64, square: f64) -> f64 {
        match (self.radial, self.end) {
            (radial, End::Sphere(_)) => radial.at(softened),
            (Radial::Power(gamma), End::Fading(radius)) => {
                libm::exp(-gamma * libm::log(softened) - square / (radius * radius))
            }
            (radial, End::Fading(radius)) => {
                radial.at(softened) * libm::exp(-square / (radius * radius))
            }
        }
    }
}

/// How many equal parts of at most [`LONGEST_PANEL`] an interval has.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a small positive number; a cast of anything else saturates"
)]
pub(super) fn panels(length: f64) -> usize {
    ((length / LONGEST_PANEL).ceil() as usize).max(1)
}
