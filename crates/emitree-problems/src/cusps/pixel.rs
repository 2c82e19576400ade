//! The integral over a pixel of a function that is singular at a point of the image plane.

use super::cusp::panels;
use crate::gauss::Gauss;

/// A pixel has polar coordinates about a point that is no farther from it, in parts of its longer side.
const POLAR_WITHIN: f64 = 0.5;
/// A triangle that is lower than this part of its base has no area: the roundings of a place that is on
/// the side of a pixel.
const FLAT: f64 = 1e-14;
/// With σ = sᵐ for the radius, the integral of a singularity r^(1 − γ) is one of s to this power less 1.
const SMOOTHNESS: f64 = 6.0;
/// Panels along the radius outside of a core grow by this factor.
const GROWTH: f64 = 1.8;

/// Numbers of nodes.
#[derive(Clone, Debug)]
pub(super) struct Rules {
    /// Between two breaks of a line.
    pub(super) line: Gauss,
    /// Along the radius, from the point to the side of a pixel.
    pub(super) radius: Gauss,
    /// Along a panel of the radius outside of a core.
    pub(super) panel: Gauss,
    /// Along a panel of the side of a pixel.
    pub(super) side: Gauss,
    /// Along each side of a pixel without a singularity: near, farther, and far away.
    pub(super) tensor: [Gauss; 3],
}

impl Rules {
    pub(super) fn new([line, radius, panel, side]: [usize; 4], tensor: [usize; 3]) -> Self {
        let [line, radius, panel, side] = [line, radius, panel, side].map(Gauss::new);
        Self { line, radius, panel, side, tensor: tensor.map(Gauss::new) }
    }
}

/// A pixel on the image plane, relative to the place of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pixel {
    pub(super) low: [f64; 2],
    pub(super) high: [f64; 2],
}

/// What a function is like close to the point at offset 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Singularity {
    /// γ of the emission: lines of sight have the power 1 − γ of the offset.
    pub(super) exponent: f64,
    /// The offset below which it is smooth; 0 for none.
    pub(super) core: f64,
}

impl Pixel {
    fn longer_side(&self) -> f64 {
        (self.high[0] - self.low[0]).max(self.high[1] - self.low[1])
    }

    /// Of the nearest place in the pixel from offset 0, in longer sides.
    fn distance(&self) -> f64 {
        let [x, y] = [0, 1].map(|i| self.low[i].max(-self.high[i]).max(0.0));
        x.hypot(y) / self.longer_side()
    }

    /// ∫ f over the pixel, f of an offset.
    pub(super) fn integral(
        &self,
        singularity: Singularity,
        rules: &Rules,
        mut f: impl FnMut([f64; 2]) -> f64,
    ) -> f64 {
        let distance = self.distance();
        if distance <= POLAR_WITHIN {
            return self.polar(singularity, rules, f);
        }
        let nearness = if distance < 1.5 { 0 } else { usize::from(distance > 4.0) + 1 };
        self.tensor(&rules.tensor[nearness], &mut f)
    }

    /// ∫ f over the pixel by a product of rules.
    pub(super) fn tensor(&self, rule: &Gauss, mut f: impl FnMut([f64; 2]) -> f64) -> f64 {
        let [low, high] = [self.low, self.high];
        rule.integrate(low[1], high[1], |y| rule.integrate(low[0], high[0], |x| f([x, y])))
    }

    /// ∫ f as a sum over the triangles between offset 0 and the sides, negative for those seen from
    /// outside.
    ///
    /// A side at the distance d has places e = d sinh w along it: a triangle is d cosh w high there, and
    /// its angle is dw/cosh w.
    fn polar(
        &self,
        singularity: Singularity,
        rules: &Rules,
        mut f: impl FnMut([f64; 2]) -> f64,
    ) -> f64 {
        let mut sum = 0.0;
        for axis in [0, 1] {
            let along = 1 - axis;
            let [from, to] = [self.low[along], self.high[along]];
            for (border, outward) in [(self.low[axis], -1.0), (self.high[axis], 1.0)] {
                let height = (border * outward).abs();
                if height <= FLAT * (to - from) {
                    continue;
                }
                let [low, high] = [from, to].map(|e| libm::asinh(e / height));
                let count = panels(high - low);
                let triangle = rules.side.integrate_panels([low, high], count, |w| {
                    let mut end = [0.0; 2];
                    end[axis] = border;
                    end[along] = height * libm::sinh(w);
                    let length = height * libm::cosh(w);
                    let radial = radial(singularity, length, rules, |part| {
                        f([part * end[0], part * end[1]])
                    });
                    length * length * radial / libm::cosh(w)
                });
                sum += (border * outward).signum() * triangle;
            }
        }
        sum
    }
}

/// ∫ f(σ) σ dσ from 0 to 1, σ in parts of a `length` on the image plane.
fn radial(
    singularity: Singularity,
    length: f64,
    rules: &Rules,
    mut f: impl FnMut(f64) -> f64,
) -> f64 {
    if singularity.core > 0.0 {
        let mut from = 0.0;
        let mut to = (0.5 * singularity.core / length).min(1.0);
        let mut sum = 0.0;
        loop {
            sum += rules.panel.integrate(from, to, |part| f(part) * part);
            if to >= 1.0 {
                return sum;
            }
            (from, to) = (to, (GROWTH * to).min(1.0));
        }
    }
    let power = SMOOTHNESS / (3.0 - singularity.exponent);
    rules.radius.integrate(0.0, 1.0, |s| {
        let part = libm::pow(s, power);
        // dσ = m sᵐ⁻¹ ds
        f(part) * part * power * part / s
    })
}
