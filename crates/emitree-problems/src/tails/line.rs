//! One line of sight to infinity, and its integral in the variable that suits a power.

use crate::gauss::Gauss;

/// How far u goes, with s = c sinh u: r^−1.5, the slowest, has then fallen to 1e-15 of its integral.
const FARTHEST: f64 = 75.0;

/// The points origin + s direction, from s = `near`, which is −∞ or finite, to ∞.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Line {
    pub(super) origin: [f64; 3],
    /// A unit vector.
    pub(super) direction: [f64; 3],
    pub(super) near: f64,
}

impl Line {
    pub(super) fn at(&self, s: f64) -> [f64; 3] {
        core::array::from_fn(|i| self.origin[i] + s * self.direction[i])
    }

    /// Where the line is nearest to a point, and the square of its distance there.
    pub(super) fn nearest(&self, point: [f64; 3]) -> (f64, f64) {
        let from: [f64; 3] = core::array::from_fn(|i| self.origin[i] - point[i]);
        let s = -dot(from, self.direction);
        (s, (dot(from, from) - s * s).max(0.0))
    }

    /// ∫ f ds over the whole line, in u with s = middle + `scale` sinh u and panels of length 1: for an f
    /// that changes on the scale of its distance from `middle`, but not below `scale`.
    pub(super) fn integrate(
        &self,
        (middle, scale): (f64, f64),
        rule: &Gauss,
        f: impl Fn([f64; 3]) -> f64,
    ) -> f64 {
        let from = if self.near.is_finite() { self.near } else { f64::NEG_INFINITY };
        self.integrate_part([from, f64::INFINITY], (middle, scale), rule, f)
    }

    /// The same over a part of the line, an end of which may be infinite.
    pub(super) fn integrate_part(
        &self,
        ends: [f64; 2],
        (middle, scale): (f64, f64),
        rule: &Gauss,
        f: impl Fn([f64; 3]) -> f64,
    ) -> f64 {
        let [from, to] = ends.map(|s| ((s - middle) / scale).asinh().clamp(-FARTHEST, FARTHEST));
        let panels = panels(to - from, 1.0);
        rule.integrate_panels([from, to], panels, |u| {
            scale * u.cosh() * f(self.at(middle + scale * u.sinh()))
        })
    }
}

/// How many panels of at most `longest` an extent has.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a small number; a cast of a negative one saturates"
)]
pub(super) fn panels(extent: f64, longest: f64) -> usize {
    ((extent / longest).ceil() as usize).max(1)
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
