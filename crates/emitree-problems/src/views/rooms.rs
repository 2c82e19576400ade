//! Random views of boxes without bodies, by number.

use super::glow::Glow;
use super::reference::Scenery;
use super::shapes::{Room, Vector, advanced, less, norm};
use super::{KINDS, Lens, RandomView};
use crate::family::generator::Generator;
use core::f64::consts::PI;
use emitree::projection::GeometryError;
use emitree::{Healpix, Viewpoint};

/// A view of a box with emission up to its faces; its camera's kind is the seed modulo 6. One view in three
/// is exactly along an axis of the box. In one of four the observer is inside, but for parallel lines. The emission is
/// uniform or consists of Gaussians, with or without a level rate. Every seed is a view for ever.
///
/// ```
/// use emitree_problems::views::random_room;
///
/// let view = random_room(1);
/// assert_eq!(view.name(), "perspective-1");
/// assert!(view.reference().error < 1e-3);
/// ```
pub fn random_room(seed: u64) -> RandomView {
    let first = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mut number = 11;
    loop {
        if let Ok(Some(view)) = draw(seed, &mut Generator::new(first ^ number)) {
            return view;
        }
        number += super::NEXT_DRAW;
    }
}

/// One draw; none if there is next to nothing in view.
fn draw(seed: u64, generator: &mut Generator) -> Result<Option<RandomView>, GeometryError> {
    let kind = KINDS.iter().zip(0..).position(|(_, number)| number == seed % 6).unwrap_or(0);
    let middle: Vector = core::array::from_fn(|_| generator.between(-0.3, 0.3));
    let half: Vector = core::array::from_fn(|_| generator.log_between(0.6, 2.0));
    let size = norm(half);
    let [mut axis, _, up] = generator.axes();
    let is_along_axis = generator.whole(0..=2) == 0;
    if is_along_axis {
        let along = generator.whole(0..=2) as usize;
        let sign = if generator.whole(0..=1) == 0 { -1.0 } else { 1.0 };
        axis = core::array::from_fn(|i| if i == along { sign } else { 0.0 });
    }
    let is_inside = kind > 0 && generator.whole(0..=3) == 0;
    let distance = if is_inside {
        0.3 * half[0].min(half[1]).min(half[2])
    } else {
        size * generator.log_between(1.1, 5.0)
    };
    let aside: Vector = core::array::from_fn(|i| 0.3 * half[i] * generator.between(-1.0, 1.0));
    let target = if is_along_axis { middle } else { advanced(middle, 1.0, aside) };
    let position = advanced(target, distance, axis);
    let width = 2.0 * size * generator.log_between(0.4, 1.3);
    let blobs = (0..generator.whole(1..=3)).map(|_| {
        let at = core::array::from_fn(|i| middle[i] + half[i] * generator.between(-1.0, 1.0));
        (at, size * generator.log_between(0.15, 1.0))
    });
    let blobs: Vec<(Vector, f64)> = blobs.collect();
    let glow = match generator.whole(0..=3) {
        0 => Glow::Uniform,
        1 => Glow::Blobs { level: generator.between(0.0, 0.3), blobs },
        _ => Glow::Blobs { level: 0.0, blobs },
    };
    let depth = [if kind == 0 { f64::NEG_INFINITY } else { 0.0 }, f64::INFINITY];
    let viewpoint = Viewpoint { position, target, up };
    let lens = Lens {
        kind,
        viewpoint,
        width,
        height: generator.between(0.6, 1.4),
        distance: distance.max(0.3 * size),
    };
    let room = Room::Cuboid([less(middle, half), advanced(middle, 1.0, half)]);
    let camera = lens.camera(depth, room.bounds()?, Vec::new())?;
    let bare = lens.camera([0.0, 1.0], None, Vec::new())?;
    let shape = match kind {
        5 => Healpix::shape(4),
        _ => [generator.whole(12..=20) as usize, generator.whole(12..=20) as usize],
    };
    let scenery = Scenery { bodies: Vec::new(), room, glow, depth };
    let view = RandomView { seed, kind, camera, bare, shape, scenery };
    let least = 0.02 * size / PI;
    Ok((view.longest_path() > least).then_some(view))
}
