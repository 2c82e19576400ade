//! The views of cusps that have a name.

use super::CuspView;
use super::cusp::{Cusp, End, Jet, Radial};
use super::lens::{Kind, Lens};

/// Where the point is in the middle of the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// In the centre of a pixel: images have an odd number of pixels along each side.
    Centre,
    /// In the corner of four pixels: images have an even number of pixels along each side.
    Corner,
}

impl Place {
    fn pixels(self, odd: usize) -> usize {
        match self {
            Self::Centre => odd,
            Self::Corner => odd - 1,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Centre => "centre",
            Self::Corner => "corner",
        }
    }
}

/// Squares of GeV cm⁻³ along one kpc, in GeV² cm⁻⁵: the centimetres of a kpc (IAU 2015 resolution B2).
pub const GEV2_CM5_PER_KPC: f64 = 3.085_677_581_491_367_3e21;
/// The halo: its density at the Sun \[GeV cm⁻³\], the Sun's distance, the scale radius and the radius
/// at which it ends \[kpc\].
const SUN_GEV_CM3: f64 = 0.39;
const SUN_KPC: f64 = 8.5;
const SCALE_KPC: f64 = 20.0;
const END_KPC: f64 = 8.5;
/// The side of a pixel \[degrees\], and how many there are.
const PIXEL_DEG: f64 = 0.05;
const HALO_PIXELS: usize = 61;
/// Pixels of the other images.
const PIXELS: usize = 33;

/// J-factors of the halo of Navarro, Frenk and White 1997 (doi:10.1086/304888) from the Sun: the square
/// of its density, 0.39 GeV cm⁻³ at 8.5 kpc, with a scale radius of 20 kpc and an end at 8.5 kpc. A core
/// \[kpc\] replaces r by √(r² + core²), without a change of the density far away.
///
/// Lengths are in kpc and the rate is in GeV² cm⁻⁵ for each kpc and steradian. The camera is equirectangular,
/// with 61 × 61 pixels of 0.05 degrees about the centre, or 60 × 60 with the centre in a corner of four.
///
/// ```
/// use emitree_problems::cusps::{Place, nfw_halo};
///
/// let halo = nfw_halo(0.0, Place::Centre);
/// let sun = halo.rate([0.0, -8.499_999_999, 0.0]) / 3.085_677_581_491_367e21;
/// assert!((sun / 0.39_f64.powi(2) - 1.0).abs() < 1e-8);
/// ```
///
/// # Panics
///
/// Never: the camera's numbers are accepted.
pub fn nfw_halo(core_kpc: f64, place: Place) -> CuspView {
    let pixels = place.pixels(HALO_PIXELS);
    let half = 0.5 * (pixels as f64) * PIXEL_DEG.to_radians();
    let lens = Lens {
        kind: Kind::Angles,
        position: [0.0, -SUN_KPC, 0.0],
        half: [half; 2],
        depth: [0.0, f64::INFINITY],
    };
    let x = SUN_KPC / SCALE_KPC;
    let at_sun = x * (1.0 + x) * (1.0 + x);
    let density = SUN_GEV_CM3 * at_sun;
    let halo = Cusp {
        position: [0.0; 3],
        amplitude: density * density * GEV2_CM5_PER_KPC,
        radial: Radial::SquareOfNfw(SCALE_KPC),
        core: core_kpc,
        jet: None,
        end: End::Sphere(END_KPC),
    };
    accepted(format!("nfw {core_kpc:e} {}", place.name()), lens, pixels, halo)
}

/// r^−γ within a radius of 3, in parallel lines of sight of a square of side 2 about the point.
///
/// Its lines of sight are known: with T = √(9 − b²), 2 asinh(T/b) for γ = 1, 2 atan(T/b)/b for γ = 2.
///
/// # Panics
///
/// If γ is 3 or more: pixels would be infinite.
pub fn power_law(gamma: f64, place: Place) -> CuspView {
    assert!(gamma < 3.0, "an exponent of {gamma} is below 3");
    let lens = Lens {
        kind: Kind::Parallel,
        position: [0.0, -4.0, 0.0],
        half: [1.0; 2],
        depth: [0.0, f64::INFINITY],
    };
    let law = Cusp {
        position: [0.0; 3],
        amplitude: 1.0,
        radial: Radial::Power(gamma),
        core: 0.0,
        jet: None,
        end: End::Sphere(3.0),
    };
    accepted(format!("r^-{gamma} {}", place.name()), lens, place.pixels(PIXELS), law)
}

/// A comet: the coma, r⁻², within a radius of 3, from a distance of 10, and a jet in it, four times as
/// bright as the coma on its axis and about 50 degrees wide, towards the right, up and the observer.
///
/// # Panics
///
/// Never: the camera's numbers are accepted.
pub fn comet(place: Place) -> CuspView {
    let half = libm::tan(5.0_f64.to_radians());
    let lens = Lens {
        kind: Kind::Tangent,
        position: [0.0, -10.0, 0.0],
        half: [half; 2],
        depth: [0.0, f64::INFINITY],
    };
    let axis = [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0];
    let jet = Jet { tilt: 0.0, pole: axis, strength: 4.0, sharpness: 8.0, axis };
    let coma = Cusp {
        position: [0.0; 3],
        amplitude: 1.0,
        radial: Radial::Power(2.0),
        core: 0.0,
        jet: Some(jet),
        end: End::Sphere(3.0),
    };
    accepted(format!("comet {}", place.name()), lens, place.pixels(PIXELS), coma)
}

#[expect(clippy::panic, reason = "the numbers are constants")]
fn accepted(name: String, lens: Lens, pixels: usize, cusp: Cusp) -> CuspView {
    match CuspView::new(name, lens, [pixels; 2], vec![cusp], Vec::new()) {
        Ok(view) => view,
        Err(error) => panic!("{error}"),
    }
}
