//! Cusps by number.

use super::cusp::{Cusp, End, Jet, Radial};
use super::lens::{Kind, Lens, Seen};
use super::{Blob, CuspView};
use crate::family::generator::Generator;
use emitree::projection::GeometryError;

/// Pixels along each side.
const PIXELS: u32 = 32;
/// The powers γ of r^−γ.
const EXPONENTS: [f64; 2] = [0.5, 2.4];
/// What draws of one seed are apart.
const NEXT_DRAW: u64 = 1 << 32;

/// The view of a seed: one or two points with r^−γ, γ from 0.5 to 2.4, that fade as Gaussians, before a smooth
/// background.
///
/// Seeds that are even have parallel lines of sight, the others a perspective camera of 10 to 60 degrees. Half of
/// the emissions depend on the direction from the point. Points are at the centres of pixels, at corners,
/// in pixels anywhere, or out of view, up to a quarter of its width from its border. Images have
/// 32 × 32 pixels, and a width of about 2. Every seed is a view for ever: this function must not change.
///
/// ```
/// let view = emitree_problems::cusps::random_cusps(3);
/// assert_eq!((view.name(), view.shape()), ("cusps-3", [32, 32]));
/// assert!(view.points().all(|(_, exponent)| (0.5..=2.4).contains(&exponent)));
/// ```
pub fn random_cusps(seed: u64) -> CuspView {
    let first = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mut number = 21;
    loop {
        // A draw that the library refuses is followed by another.
        if let Ok(view) = draw(seed, &mut Generator::new(first ^ number)) {
            return view;
        }
        number += NEXT_DRAW;
    }
}

fn draw(seed: u64, generator: &mut Generator) -> Result<CuspView, GeometryError> {
    let lens = lens(seed, generator);
    let distance = -lens.position[1];
    let cusps = (0..generator.whole(1..=2)).map(|_| cusp(generator, &lens, distance)).collect();
    let background = (0..generator.whole(0..=2))
        .map(|_| Blob {
            centre: core::array::from_fn(|_| generator.between(-0.8, 0.8)),
            amplitude: generator.log_between(0.1, 1.0),
            width: generator.between(0.5, 1.5),
        })
        .collect();
    let shape = [PIXELS as usize; 2];
    CuspView::new(format!("cusps-{seed}"), lens, shape, cusps, background)
}

/// A camera whose image is about 2 wide at the origin.
fn lens(seed: u64, generator: &mut Generator) -> Lens {
    let aspect = generator.between(0.7, 1.3);
    if seed.is_multiple_of(2) {
        let (position, depth) = ([0.0, -4.0, 0.0], [0.0, 8.0]);
        return Lens { kind: Kind::Parallel, position, half: [1.0, aspect], depth };
    }
    let half_angle = generator.between(5.0, 30.0).to_radians();
    let half = libm::tan(half_angle);
    let distance = 1.0 / half;
    let position = [0.0, -distance, 0.0];
    Lens {
        kind: Kind::Tangent,
        position,
        half: [half, half * aspect],
        depth: [0.0, distance + 4.0],
    }
}

fn cusp(generator: &mut Generator, lens: &Lens, distance: f64) -> Cusp {
    let gamma = generator.between(EXPONENTS[0], EXPONENTS[1]);
    let where_to = generator.whole(0..=3);
    let mut place = [0.0; 2];
    for (place, half) in place.iter_mut().zip(lens.half) {
        let pixels = f64::from(PIXELS);
        let in_pixels = match where_to {
            0 => f64::from(generator.whole(3..=PIXELS - 4)) + 0.5,
            1 => f64::from(generator.whole(3..=PIXELS - 3)),
            _ => generator.between(2.0, pixels - 2.0),
        };
        *place = half * (2.0 * in_pixels - pixels) / pixels;
    }
    if where_to == 3 {
        let axis = generator.whole(0..=1) as usize;
        let side = if generator.whole(0..=1) == 0 { -1.0 } else { 1.0 };
        place[axis] = side * lens.half[axis] * generator.between(1.0, 1.5);
    }
    let position = lens.point(Seen { place, distance: distance + generator.between(-0.6, 0.6) });
    let radius = generator.log_between(0.3, 1.0);
    let jet = (generator.whole(0..=1) == 0).then(|| {
        let [axis, pole, _] = generator.axes();
        let tilt = generator.between(0.0, 0.8);
        let (strength, sharpness) = (generator.between(0.0, 3.0), generator.between(1.0, 6.0));
        Jet { tilt, pole, strength, sharpness, axis }
    });
    Cusp {
        position,
        // So that lines at the distance of the radius are of order 1.
        amplitude: generator.log_between(0.3, 1.0) * libm::pow(radius, gamma - 1.0),
        radial: Radial::Power(gamma),
        core: 0.0,
        jet,
        end: End::Fading(radius),
    }
}
