//! Angles of a point from the Earth with the Sun on +x: shared by the magnetosheath models.

/// Distance and angles of a point other than the origin: θ in [0, π] from +x, φ = atan2(z, y).
///
/// Sines and cosines come from ratios of lengths, without the angles, and keep their digits at the
/// poles θ = 0 and π.
#[derive(Clone, Copy, Debug)]
pub(super) struct SunAngles {
    pub(super) r: f64,
    pub(super) cos_theta: f64,
    pub(super) sin_theta: f64,
    /// cos²(θ/2)
    pub(super) cos2_half_theta: f64,
    pub(super) cos_phi: f64,
    pub(super) sin_phi: f64,
}

impl SunAngles {
    /// The angles of `position`; `None` so close to the origin that they are undefined.
    ///
    /// Distances below 10⁻⁶ (in `R_E`: some metres) count as the origin, so that powers of r stay
    /// finite.
    pub(super) fn new([x, y, z]: [f64; 3]) -> Option<Self> {
        let rho2 = y * y + z * z;
        let (rho, r) = (rho2.sqrt(), (x * x + rho2).sqrt());
        if r < 1e-6 {
            return None;
        }
        let (cos_phi, sin_phi) = if rho > 0.0 { (y / rho, z / rho) } else { (1.0, 0.0) };
        // (r + x)/(2r), without the cancellation towards the tail.
        let cos2_half_theta =
            if x >= 0.0 { (r + x) / (2.0 * r) } else { rho2 / (2.0 * r * (r - x)) };
        let (cos_theta, sin_theta) = (x / r, rho / r);
        Some(Self { r, cos_theta, sin_theta, cos2_half_theta, cos_phi, sin_phi })
    }

    /// θ \[rad\]
    pub(super) fn theta(&self) -> f64 {
        self.sin_theta.atan2(self.cos_theta)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    #[test]
    fn agrees_with_the_angles() {
        for (theta, phi) in [(0.3, 0.2), (1.5, -2.0), (2.9, 3.0), (PI - 1e-7, 1.0)] {
            let (sin, cos) = f64::sin_cos(theta);
            let at =
                SunAngles::new([5.0 * cos, 5.0 * sin * f64::cos(phi), 5.0 * sin * f64::sin(phi)]);
            let at = at.unwrap();
            let half = f64::cos(0.5 * theta).powi(2);
            assert!((at.r - 5.0).abs() < 1e-14);
            assert!((at.theta() - theta).abs() < 1e-14);
            assert!((at.cos2_half_theta / half - 1.0).abs() < 1e-7, "{theta}");
            assert!((at.cos_phi - f64::cos(phi)).abs() < 1e-14);
            assert!((at.sin_phi - f64::sin(phi)).abs() < 1e-14);
        }
    }

    #[test]
    fn poles_and_origin() {
        let nose = SunAngles::new([2.0, 0.0, 0.0]).unwrap();
        assert!((nose.theta()).abs() <= 0.0 && (nose.cos2_half_theta - 1.0).abs() <= 0.0);
        let tail = SunAngles::new([-2.0, 0.0, -0.0]).unwrap();
        assert!((tail.theta() - PI).abs() <= 0.0 && tail.cos2_half_theta.abs() <= 0.0);
        assert!(SunAngles::new([0.0; 3]).is_none());
    }
}
