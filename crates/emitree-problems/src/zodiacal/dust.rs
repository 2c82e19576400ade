//! The interplanetary dust cloud of Kelsall et al. 1998 (<https://doi.org/10.1086/306380>).
//!
//! Heliocentric ecliptic coordinates \[AU\]; densities are cross-sections per volume \[AU⁻¹\]. The
//! parameters have the digits of the model as it was distributed, which are those of ZodiPy 1.1.5;
//! Table 1 of the paper rounds them to three. In two places the distributed model differs from the
//! paper, as Planck 2013 results XIV (<https://doi.org/10.1051/0004-6361/201321562>, section 4.1) says:
//! the bands have 1 + (ζ/δζ)⁴/v for v + (ζ/δζ)⁴, and the ring and the feature have no factors ½ in
//! their exponents.

use core::f64::consts::{PI, TAU};

/// A plane through the Sun, or near it, about which a component is symmetric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SymmetryPlane {
    /// A point of the plane \[AU\].
    pub(super) centre: [f64; 3],
    /// The unit vector to its north.
    pub(super) normal: [f64; 3],
}

impl SymmetryPlane {
    /// The plane of an inclination and the longitude of its ascending node.
    fn new(centre: [f64; 3], inclination_deg: f64, node_deg: f64) -> Self {
        let (inclination, node) = (inclination_deg.to_radians(), node_deg.to_radians());
        let (sin, cos) = (libm::sin(inclination), libm::cos(inclination));
        Self { centre, normal: [libm::sin(node) * sin, -libm::cos(node) * sin, cos] }
    }

    /// The distance from the centre and the height above the plane \[AU\].
    pub(super) fn radius_and_height(&self, position: [f64; 3]) -> (f64, f64) {
        let [x, y, z]: [f64; 3] = core::array::from_fn(|i| position[i] - self.centre[i]);
        let height = x * self.normal[0] + y * self.normal[1] + z * self.normal[2];
        ((x * x + y * y + z * z).sqrt(), height)
    }
}

/// The smooth cloud, eqs. (6) and (7): n₀ R^−α exp(−β g^γ), where g is |ζ| − μ/2, but ζ²/(2 μ) for
/// |ζ| < μ; ζ is the height over the distance R from the centre of the cloud.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cloud {
    pub(super) plane: SymmetryPlane,
    density: f64,
    alpha: f64,
    beta: f64,
    gamma: f64,
    pub(super) mu: f64,
}

impl Cloud {
    fn density(&self, position: [f64; 3]) -> f64 {
        let (radius, height) = self.plane.radius_and_height(position);
        let zeta = (height / radius).abs();
        let fan = if zeta < self.mu { zeta * zeta / (2.0 * self.mu) } else { zeta - 0.5 * self.mu };
        self.density * (-self.alpha * radius.ln() - self.beta * fan.powf(self.gamma)).exp()
    }
}

/// A pair of dust bands, eq. (8): 3 n/R exp(−(ζ/δ)⁶) (1 + (ζ/δ)⁴/v) (1 − exp(−(R/R₀)²⁰)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Band {
    pub(super) plane: SymmetryPlane,
    density: f64,
    /// δ, an angle that stands beside ζ \[rad\].
    half_width: f64,
    shape: f64,
    /// Within this distance from the Sun there is little of it \[AU\].
    pub(super) onset: f64,
}

impl Band {
    fn density(&self, position: [f64; 3]) -> f64 {
        let (radius, height) = self.plane.radius_and_height(position);
        let square = (height / (radius * self.half_width)).powi(2);
        let across = (-square.powi(3)).exp() * (1.0 + square * square / self.shape);
        let inner_edge = -(-(radius / self.onset).powi(20)).exp_m1();
        3.0 * self.density / radius * across * inner_edge
    }
}

/// The ring of dust along the Earth's orbit, or the blob in it that trails the Earth, eq. (9):
/// `n exp(−(R − R₀)²/σ_r² − |Z|/σ_z − θ²/σ_θ²)`; the ring has no last term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ring {
    pub(super) plane: SymmetryPlane,
    density: f64,
    pub(super) radius: f64,
    pub(super) radial_width: f64,
    height: f64,
    blob: Option<Blob>,
}

/// Where a blob is along the ring, and how long.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Blob {
    longitude: f64,
    width: f64,
}

impl Ring {
    fn density(&self, position: [f64; 3]) -> f64 {
        let (radius, height) = self.plane.radius_and_height(position);
        let across = (radius - self.radius) / self.radial_width;
        let along = self.blob.map_or(0.0, |blob| {
            let longitude = position[1].atan2(position[0]) - blob.longitude;
            let from_middle = (longitude + PI).rem_euclid(TAU) - PI;
            (from_middle / blob.width).powi(2)
        });
        self.density * (-across * across - height.abs() / self.height - along).exp()
    }
}

/// All components.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Dust {
    pub(super) cloud: Cloud,
    pub(super) bands: [Band; 3],
    pub(super) rings: [Ring; 2],
}

impl Dust {
    /// The dust with the Earth at a heliocentric position \[AU\], on which only the blob depends.
    pub(super) fn new(earth: [f64; 3]) -> Self {
        let band =
            |[inclination_deg, node_deg]: [f64; 2], density, half_width_deg: f64, shape, onset| {
                Band {
                    plane: SymmetryPlane::new([0.0; 3], inclination_deg, node_deg),
                    density,
                    half_width: half_width_deg.to_radians(),
                    shape,
                    onset,
                }
            };
        let ring_plane =
            SymmetryPlane::new([0.0; 3], 0.487_071_660_068_192_4, 22.278_979_678_854_448);
        Self {
            cloud: Cloud {
                plane: SymmetryPlane::new(
                    [
                        0.011_887_800_744_346_281,
                        0.005_476_506_466_226_378,
                        -0.002_153_090_802_071_074_4,
                    ],
                    2.033_518_807_239_077,
                    77.657_955_554_097_11,
                ),
                density: 1.134_437_388_142_796e-7,
                alpha: 1.337_069_670_593_028,
                beta: 4.141_500_415_758_664,
                gamma: 0.942_061_793_933_580_4,
                mu: 0.188_731_764_890_901_9,
            },
            bands: [
                band(
                    [0.564_382_651_543_897_3, 80.0],
                    5.589_029_040_322_837e-10,
                    8.785_053_440_871_303,
                    0.100_000_001_490_116_12,
                    1.5,
                ),
                band(
                    [1.200_000_047_683_715_8, 30.347_475_578_624_532],
                    1.987_760_942_259_08e-9,
                    1.991_703_242_577_764,
                    0.899_999_976_158_142_1,
                    0.941_218_812_016_511_5,
                ),
                band(
                    [0.800_000_011_920_929, 80.0],
                    1.436_982_728_351_238_4e-10,
                    15.0,
                    0.050_000_000_745_058_06,
                    1.5,
                ),
            ],
            rings: [
                Ring {
                    plane: ring_plane,
                    density: 1.826_052_782_650_167_5e-8,
                    radius: 1.028_192_432_630_875_1,
                    radial_width: 0.025_000_000_372_529_03,
                    height: 0.054_068_037_356_978_1,
                    blob: None,
                },
                Ring {
                    plane: ring_plane,
                    density: 2.009_426_718_359_094_7e-8,
                    radius: 1.057_918_269_452_421_4,
                    radial_width: 0.102_873_146_623_966_11,
                    height: 0.091_442_963_768_716_02,
                    blob: Some(Blob {
                        longitude: earth[1].atan2(earth[0]) - 10_f64.to_radians(),
                        width: 12.115_210_933_938_74f64.to_radians(),
                    }),
                },
            ],
        }
    }

    /// The cross-section per volume of each component \[AU⁻¹\]: the cloud, three bands, the ring, the
    /// blob.
    pub(super) fn densities(&self, position: [f64; 3]) -> [f64; 6] {
        let [first, second, third] = self.bands.map(|band| band.density(position));
        let [ring, blob] = self.rings.map(|ring| ring.density(position));
        [self.cloud.density(position), first, second, third, ring, blob]
    }
}
