//! A paraboloid-like surface about the Earth, with one flaring each across and along z.

use super::sun_angles::SunAngles;

/// The surface s(r0, ay, az) of Jorgensen et al. 2019 (doi:10.1029/2018JA026153): Shue's function
/// (Shue et al. 1997, doi:10.1029/97JA00196) with flarings of its own in the planes z = 0 and y = 0,
///
/// ry = r0 (2/(1 + cos θ))^ay, rz likewise with az,
/// R = ry rz / √((rz cos φ)² + (ry sin φ)²).
///
/// Towards the tail (θ → π) R grows without bounds where the flarings are positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shue {
    r0: f64,
    ay: f64,
    az: f64,
}

impl Shue {
    /// The surface with its nose at `r0` > 0 and flarings `ay`, `az` ≥ 0.
    pub(super) fn new(r0: f64, ay: f64, az: f64) -> Self {
        Self { r0, ay, az }
    }

    /// Whether the point lies inside: r < R.
    pub(super) fn contains(&self, at: &SunAngles) -> bool {
        at.r * self.inverse_radius(at) < 1.0
    }

    /// 1/R, which stays finite in the tail: 1/R² = (cos φ/ry)² + (sin φ/rz)².
    fn inverse_radius(&self, at: &SunAngles) -> f64 {
        // (1 + cos θ)/2 = cos²(θ/2)
        let inverse_y = at.cos2_half_theta.powf(self.ay) / self.r0;
        #[expect(clippy::float_cmp, reason = "only the exactly round surface needs one power")]
        let round = self.ay == self.az;
        if round {
            return inverse_y;
        }
        let inverse_z = at.cos2_half_theta.powf(self.az) / self.r0;
        (at.cos_phi * inverse_y).hypot(at.sin_phi * inverse_z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    fn radius(surface: &Shue, theta: f64, phi: f64) -> f64 {
        let (sin, cos) = theta.sin_cos();
        let at = SunAngles::new([cos, sin * phi.cos(), sin * phi.sin()]).unwrap();
        1.0 / surface.inverse_radius(&at)
    }

    #[test]
    fn as_published() {
        let surface = Shue::new(10.0, 0.5, 0.8);
        for (theta, phi) in [(0.0, 0.0), (0.7, 0.4), (1.6, 2.2), (2.8, -1.0)] {
            let flare = |a: f64| 10.0 * (2.0 / (1.0 + f64::cos(theta))).powf(a);
            let (y, z) = (flare(0.5), flare(0.8));
            let expected = y * z / (z * f64::cos(phi)).hypot(y * f64::sin(phi));
            assert!((radius(&surface, theta, phi) / expected - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn the_round_surface_is_the_limit() {
        let (round, almost) = (Shue::new(9.0, 0.6, 0.6), Shue::new(9.0, 0.6, 0.6 + 1e-15));
        assert!((radius(&round, 1.0, 0.5) / radius(&almost, 1.0, 0.5) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn the_tail_is_inside() {
        let tail = SunAngles::new([-1e6, 0.0, 0.0]).unwrap();
        assert!(Shue::new(10.0, 0.5, 0.5).contains(&tail));
        assert!(Shue::new(10.0, 0.5, 0.8).contains(&tail));
        // Without flaring it is a sphere.
        assert!(!Shue::new(10.0, 0.0, 0.0).contains(&tail));
        assert!((radius(&Shue::new(10.0, 0.0, 0.0), PI, 0.0) - 10.0).abs() < 1e-14);
    }
}
