//! Depth: from the canonical z ∈ [0, 1] to the distance s along a line of sight.
//!
//! Between two finite ends s is linear in z. Towards an infinite one it grows like (1 − z)⁻²: then
//! G = g · ds/dz still falls to zero there if g falls faster than s^−1.5, and it is smooth for the
//! powers that coronae have.

use super::frame::GeometryError;

/// The depth range of lines of sight, in the length unit of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Depth {
    near: f64,
    far: f64,
    /// The distance over which an infinite line of sight is resolved: that of the target.
    scale: f64,
}

impl Depth {
    /// Depths from `near` to `far`; parallel lines of sight may begin anywhere, −∞ included, others
    /// at 0 or more.
    pub(crate) fn new(
        [near, far]: [f64; 2],
        scale: f64,
        is_parallel: bool,
    ) -> Result<Self, GeometryError> {
        let refuse =
            |name, value, expected| Err(GeometryError::OutOfRange { name, value, expected });
        let begins =
            if is_parallel { near < f64::INFINITY } else { near >= 0.0 && near.is_finite() };
        if !begins {
            let finite = "a finite depth of 0 or more";
            let expected = if is_parallel { "a depth, or -inf" } else { finite };
            return refuse("near", near, expected);
        }
        if far > near {
            Ok(Self { near, far, scale })
        } else {
            refuse("far", far, "a depth beyond `near`, or inf")
        }
    }

    /// The depths of the canonical cube.
    pub(crate) fn of_unit_cube() -> Self {
        Self { near: 0.0, far: 1.0, scale: 1.0 }
    }

    pub(crate) fn ends(&self) -> [f64; 2] {
        [self.near, self.far]
    }

    /// The distance over which an infinite line of sight is resolved.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }

    /// The part of a line of sight from `from` to `to`; empty if that is not beyond.
    pub(crate) fn span(&self, from: f64, to: f64) -> Span {
        Span { from, to: to.max(from), scale: self.scale }
    }
}

/// A part of one line of sight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span {
    from: f64,
    to: f64,
    scale: f64,
}

impl Span {
    /// The unit interval itself.
    pub(crate) fn of_unit_interval() -> Self {
        Self { from: 0.0, to: 1.0, scale: 1.0 }
    }

    /// The distances of both ends.
    pub(crate) fn ends(&self) -> [f64; 2] {
        [self.from, self.to]
    }

    /// The distance s at `z`, and ds/dz, which is 0 at an infinite end: g is not evaluated there.
    pub(crate) fn at(&self, z: f64) -> (f64, f64) {
        let Self { from, to, scale } = *self;
        let (s, ds_dz) = match (from.is_finite(), to.is_finite()) {
            (true, true) => (from + z * (to - from), to - from),
            (true, false) => {
                let left = 1.0 - z;
                (from + scale * (left.powi(-2) - 1.0), 2.0 * scale * left.powi(-3))
            }
            (false, true) => (to - scale * (z.powi(-2) - 1.0), 2.0 * scale * z.powi(-3)),
            (false, false) => {
                let t = 2.0 * z - 1.0;
                let left = 1.0 - t * t;
                let ds_dt = scale * (1.0 + 3.0 * t * t) * left.powi(-3);
                (scale * (1.0 + t * left.powi(-2)), 2.0 * ds_dt)
            }
        };
        if s.is_finite() && ds_dz.is_finite() { (s, ds_dz) } else { (scale, 0.0) }
    }

    /// The z at which the distance is `s`; beyond [0, 1] outside of the span, 0 if the span is empty.
    pub(crate) fn z_of(&self, s: f64) -> f64 {
        let Self { from, to, scale } = *self;
        match (from.is_finite(), to.is_finite()) {
            (true, true) if to > from => (s - from) / (to - from),
            (true, true) => 0.0,
            (true, false) => 1.0 - (1.0 + ((s - from) / scale).max(-0.99)).powf(-0.5),
            (false, true) => (1.0 + ((to - s) / scale).max(-0.99)).powf(-0.5),
            (false, false) => self.z_by_bisection(s),
        }
    }

    /// The map over an infinite line has no simple inverse.
    fn z_by_bisection(&self, s: f64) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        // One bit a step: all that there are.
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.at(middle).0 < s { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INFINITE: f64 = f64::INFINITY;

    #[test]
    fn distances_lead_back_to_depths_and_slopes_are_slopes() {
        let spans = [(1.0, 5.0), (2.0, INFINITE), (-INFINITE, 7.0), (-INFINITE, INFINITE)];
        for (from, to) in spans {
            let span = Depth::new([from, to], 3.0, true).unwrap().span(from, to);
            for z in [0.05, 0.3, 0.5, 0.77, 0.97] {
                let (s, ds_dz) = span.at(z);
                assert!((span.z_of(s) - z).abs() < 1e-12, "{span:?} {z}: {s}");
                let step = 1e-6;
                let slope = (span.at(z + step).0 - span.at(z - step).0) / (2.0 * step);
                assert!((slope / ds_dz - 1.0).abs() < 1e-7, "{span:?} {z}: {slope} {ds_dz}");
            }
        }
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "ends and the middle are exact")]
    fn an_infinite_end_has_no_weight() {
        let span = Depth::new([0.0, INFINITE], 3.0, false).unwrap().span(0.0, INFINITE);
        assert_eq!(span.at(1.0), (3.0, 0.0));
        let line = Depth::new([-INFINITE, INFINITE], 3.0, true).unwrap();
        let line = line.span(-INFINITE, INFINITE);
        assert_eq!([line.at(0.0).1, line.at(1.0).1], [0.0, 0.0]);
        // The target is in the middle.
        assert_eq!(line.at(0.5).0, 3.0);
    }

    #[test]
    fn depths_that_make_no_line_are_refused() {
        let message =
            |depth, is_parallel| Depth::new(depth, 1.0, is_parallel).unwrap_err().to_string();
        assert_eq!(
            message([-1.0, 2.0], false),
            "`near` is -1: expected a finite depth of 0 or more"
        );
        assert_eq!(message([1.0, 1.0], true), "`far` is 1: expected a depth beyond `near`, or inf");
        assert!(message([f64::NAN, 1.0], true).starts_with("`near` is NaN"));
        assert!(message([0.0, f64::NAN], false).starts_with("`far` is NaN"));
        assert!(message([INFINITE, INFINITE], true).ends_with("a depth, or -inf"));
    }
}
