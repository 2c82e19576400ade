//! The magnetopause of Lin et al. 2010, with its two cusps.

use super::solar_wind::SolarWind;
use super::sun_angles::SunAngles;

/// Coefficients a0 to a21 of Lin et al. 2010 (doi:10.1029/2009JA014235).
const A: [f64; 22] = [
    12.544, -0.194, 0.305, 0.0573, 2.178, 0.0571, -0.999, 16.473, 0.00152, 0.382, 0.0431, -0.00763,
    -0.210, 0.0405, -4.430, -0.636, -2.600, 0.832, -5.328, 1.103, -0.907, 1.450,
];

/// The magnetopause R(θ, φ) = p0 r0 f + Q of Lin et al. 2010 (doi:10.1029/2009JA014235), scaled as
/// in CMEM; p0 = p1 = p2 = p3 = 1 is the published one.
///
/// f = (cos(θ/2) + a5 sin 2θ (1 − e^−θ))^(p1 (b0 + b1 cos φ + b2 sin φ + b3 sin² φ)) is the shape,
/// Q = p2 c (exp(p3 dn ψn^a21) + exp(p3 ds ψs^a21)) the dents of the cusps (c is negative), with
/// ψ the angle from each cusp. R can be negative within a deep dent: then nothing is inside there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LinMagnetopause {
    /// p0 r0 \[`R_E`\]
    nose: f64,
    /// p1 b0 to p1 b3
    power: [f64; 4],
    /// p2 c \[`R_E`\]
    dent: f64,
    north: Cusp,
    south: Cusp,
}

/// One dent: the direction of its axis in the plane y = 0 and how fast it ends away from it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cusp {
    /// p3 d
    steepness: f64,
    /// Cosine of the angle from +x, and the sine towards +z.
    axis: [f64; 2],
}

impl Cusp {
    /// The northern cusp has `side` 1, the southern −1.
    fn new(p3: f64, tilt: f64, side: f64) -> Self {
        let angle = A[19] + side * A[20] * tilt;
        Self {
            steepness: p3 * (A[16] + side * A[17] * tilt + A[18] * tilt * tilt),
            axis: [angle.cos(), side * angle.sin()],
        }
    }

    /// exp(p3 d ψ^a21)
    fn depth(&self, at: &SunAngles) -> f64 {
        // cos ψ = cos θ cos t + sin θ sin t cos(φ ∓ π/2), where the last factor is ± sin φ.
        let cosine = at.cos_theta * self.axis[0] + at.sin_theta * at.sin_phi * self.axis[1];
        (self.steepness * cosine.clamp(-1.0, 1.0).acos().powf(A[21])).exp()
    }
}

impl LinMagnetopause {
    /// The magnetopause in a solar wind, scaled by `p` = \[p0, p1, p2, p3\].
    pub(super) fn new(wind: &SolarWind, [p0, p1, p2, p3]: [f64; 4]) -> Self {
        let pressure = wind.dynamic_pressure_npa() + wind.magnetic_pressure_npa();
        let (bz, tilt) = (wind.bz, wind.dipole_tilt);
        let step = |up: f64, down: f64| (up * bz).exp_m1() / ((down * bz).exp() + 1.0);
        let r0 = A[0] * pressure.powf(A[1]) * (1.0 + A[2] * step(A[3], A[4]));
        let power = [A[6] + A[7] * step(A[8], A[9]), A[10], A[11] + A[12] * tilt, A[13]];
        Self {
            nose: p0 * r0,
            power: power.map(|b| p1 * b),
            dent: p2 * A[14] * pressure.powf(A[15]),
            north: Cusp::new(p3, tilt, 1.0),
            south: Cusp::new(p3, tilt, -1.0),
        }
    }

    /// Whether the point, at the angle `theta` from +x, lies inside: r < R.
    pub(super) fn contains(&self, at: &SunAngles, theta: f64) -> bool {
        // The dents only take away, so that what is outside without them is outside.
        let without_cusps = self.nose * self.shape(at, theta);
        at.r < without_cusps
            && at.r < without_cusps + self.dent * (self.north.depth(at) + self.south.depth(at))
    }

    /// f, infinite along −x.
    fn shape(&self, at: &SunAngles, theta: f64) -> f64 {
        let sin_2_theta = 2.0 * at.sin_theta * at.cos_theta;
        let base = at.cos2_half_theta.sqrt() - A[5] * sin_2_theta * (-theta).exp_m1();
        let [b0, b1, b2, b3] = self.power;
        base.powf(b0 + b1 * at.cos_phi + (b2 + b3 * at.sin_phi) * at.sin_phi)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wind(dipole_tilt: f64) -> SolarWind {
        let velocity = 400.0;
        SolarWind { density: 5.0, velocity, magnetic_field: [0.0, 0.0, 5.0], bz: 5.0, dipole_tilt }
    }

    #[test]
    fn the_tail_is_inside_and_far_upstream_is_not() {
        let magnetopause = LinMagnetopause::new(&wind(0.0), [1.0; 4]);
        let contains = |position| {
            let at = SunAngles::new(position).unwrap();
            magnetopause.contains(&at, at.theta())
        };
        assert!(contains([-1e5, 0.0, 0.0]));
        assert!(contains([-1e5, -0.0, 0.0]));
        assert!(!contains([1e5, 0.0, 0.0]));
        assert!(contains([9.0, 0.0, 0.0]));
    }

    #[test]
    fn a_tilt_turns_the_cusps_against_each_other() {
        let tilted = LinMagnetopause::new(&wind(0.3), [1.0; 4]);
        let opposite = LinMagnetopause::new(&wind(-0.3), [1.0; 4]);
        assert_eq!(tilted.north.steepness.to_bits(), opposite.south.steepness.to_bits());
        assert_eq!(tilted.north.axis[1].to_bits(), (-opposite.south.axis[1]).to_bits());
    }

    #[test]
    fn the_base_of_the_shape_is_never_negative() {
        let magnetopause = LinMagnetopause::new(&wind(0.2), [1.0, 1.0, 3.0, 4.0]);
        for k in 0..=100_000 {
            let (sin, cos) = (f64::from(k) * 1e-5 * core::f64::consts::PI).sin_cos();
            let at = SunAngles::new([cos, sin, 0.0]).unwrap();
            assert!(magnetopause.shape(&at, at.theta()) > 0.0, "{k}");
        }
    }
}
