//! Random views with opaque bodies and bounds, by number: for tests that must hold on more views than a
//! few chosen ones.
//!
//! [`random_view`] makes one or two bodies (spheres, ellipsoids; one in five a large sphere of which only
//! a part of the surface is near), bounds (none, a box, a sphere, an ellipsoid; the observer may be inside
//! of them or outside), a camera of any kind but the canonical one, and an emission: g = 1, an
//! exponential or a power of the distance from a body, the same brighter on one side, Gaussians off
//! centre. Bodies may be partly out of view, or fill it but for a corner. Lengths are at least a
//! twentieth of the width of the view. Every seed is a view for ever: [`random_view`] must not change.
//!
//! # The reference image
//!
//! Lines are those of the bare camera; where they meet bodies and bounds is computed by geometry of its
//! own (`shapes.rs`). A line's integral is g times a length, or Gauss–Legendre quadrature between breaks
//! at all surfaces and about the closest points. A pixel is the mean over lines, weighted with solid
//! angles: a tensor Gauss–Legendre rule where no edge is near, else rows parted where an edge crosses
//! them, and the rows parted where the sequence of edges along them changes. Each pixel is done with finer
//! rules until two agree, and in quarters if none do; the largest difference of the last two is the error.

mod glow;
mod outcome;
mod reference;
mod rooms;
mod shapes;

use crate::family::Reference;
use crate::family::generator::Generator;
use core::f64::consts::{PI, TAU};
use emitree::projection::{Bounds, DiscMapping, Ellipsoid, GeometryError};
use emitree::{
    Equirectangular, Fisheye, Healpix, Orthographic, Perspective, Polar, Projection, Viewpoint,
};
use glow::Glow;
pub use outcome::Outcome;
use reference::{Scene, Scenery};
pub use rooms::random_room;
use shapes::{Ball, Room, Vector, advanced, less, norm};
use std::sync::Arc;

/// The kinds of cameras.
const KINDS: [&str; 6] =
    ["orthographic", "perspective", "equirectangular", "polar", "fisheye", "healpix"];
/// The number of the one whose image is a disc.
const DISC: usize = 4;
/// A view whose brightest line of a coarse lattice is shorter than this part of the distance is drawn
/// anew: there is next to nothing in it.
const LEAST_PATH: f64 = 0.02;
/// Lines along each axis of that lattice.
const LATTICE: usize = 12;
/// What the numbers for other parameters are apart from those of the seed.
const CHANGED: u64 = 1 << 40;
/// What draws of one seed are apart.
const NEXT_DRAW: u64 = 1 << 32;

/// A view with bodies: the emission and the camera.
#[derive(Debug)]
pub struct RandomView {
    seed: u64,
    kind: usize,
    camera: Arc<dyn Projection + Send>,
    bare: Arc<dyn Projection + Send>,
    shape: [usize; 2],
    scenery: Scenery,
}

/// The view of a seed; its camera's kind is the seed modulo 6.
///
/// ```
/// use emitree_problems::views::random_view;
///
/// let view = random_view(3);
/// assert_eq!(view.name(), "polar-3");
/// assert!(view.reference().error < 1e-3);
/// ```
pub fn random_view(seed: u64) -> RandomView {
    // Another stream than those of the smooth scene and of the solids of this seed.
    let first = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mut number = 7;
    loop {
        // A draw that the library refuses, or that has next to nothing in view, is followed by another.
        if let Ok(Some(view)) = draw(seed, &mut Generator::new(first ^ number)) {
            return view;
        }
        number += NEXT_DRAW;
    }
}

/// One draw; none if there is next to nothing in view.
fn draw(seed: u64, generator: &mut Generator) -> Result<Option<RandomView>, GeometryError> {
    let kind = KINDS.iter().zip(0..).position(|(_, number)| number == seed % 6).unwrap_or(0);
    let is_large = generator.whole(0..=4) == 0;
    let radius = if is_large { generator.log_between(4.0, 30.0) } else { 1.0 };
    let bodies = bodies(generator, is_large, radius);
    let [axis, aside, up] = generator.axes();
    let main = bodies[0];
    // Altitudes above a large body are those of the scale 1.
    let height = generator.log_between(0.15, 5.0);
    let position = advanced(main.centre, radius + height, axis);
    let (target, width) = target(generator, kind, &main, position, [axis, aside, up]);
    let distance = norm(less(target, position));
    let room = room(generator, is_large, advanced(main.centre, radius, axis), main.centre);
    let glow_kind = generator.whole(0..=4);
    let glow = Glow::draw(generator, glow_kind, main.centre, radius, width);
    let far = if matches!(room, Room::Everywhere) && glow.is_endless() {
        distance * generator.between(1.0, 2.0)
    } else {
        f64::INFINITY
    };
    let is_parallel = kind == 0;
    let near = if is_parallel && !matches!(room, Room::Everywhere) { -far } else { 0.0 };
    let viewpoint = Viewpoint { position, target, up };
    let lens = Lens { kind, viewpoint, width, height: generator.between(0.6, 1.4), distance };
    let bounds = room.bounds()?;
    let opaque: Vec<Ellipsoid> = bodies.iter().map(Ball::ellipsoid).collect::<Result<_, _>>()?;
    let camera = lens.camera([near, far], bounds, opaque)?;
    // For where lines begin and point to: at depth 0.
    let bare = lens.camera([0.0, 1.0], None, Vec::new())?;
    let scenery = Scenery { bodies, room, glow, depth: [near, far] };
    let shape = match kind {
        5 => Healpix::shape(4),
        _ => [generator.whole(12..=20) as usize, generator.whole(12..=20) as usize],
    };
    let view = RandomView { seed, kind, camera, bare, shape, scenery };
    let brightest = view.longest_path();
    Ok((brightest > LEAST_PATH * distance).then_some(view))
}

/// The bodies of a view; the first is the main one.
fn bodies(generator: &mut Generator, is_large: bool, radius: f64) -> Vec<Ball> {
    let centre = core::array::from_fn(|_| generator.between(-0.3, 0.3));
    let mut main = Ball::sphere(centre, radius);
    if !is_large && generator.whole(0..=2) == 0 {
        main.semi_axes = core::array::from_fn(|_| generator.between(0.6, 1.0));
        main.axes = generator.axes();
    }
    let mut bodies = vec![main];
    if generator.whole(0..=2) == 0 {
        let [towards, ..] = generator.axes();
        let size = generator.log_between(0.15, 0.6);
        let away = radius + size + generator.between(0.1, 1.5);
        let mut moon = Ball::sphere(advanced(main.centre, away, towards), size);
        if generator.whole(0..=1) == 0 {
            moon.semi_axes = core::array::from_fn(|_| size * generator.between(0.6, 1.0));
            moon.axes = generator.axes();
        }
        bodies.push(moon);
    }
    bodies
}

/// The target of a camera, and the width of its view there.
fn target(
    generator: &mut Generator,
    kind: usize,
    main: &Ball,
    position: Vector,
    [axis, aside, up]: [Vector; 3],
) -> (Vector, f64) {
    let radius = main.semi_axes[0].max(main.semi_axes[1]).max(main.semi_axes[2]);
    let height = norm(less(position, main.centre)) - radius;
    // Where lines touch the body; it hides all that is within, of a plane across through its centre.
    let distance = height + radius;
    let limb = radius * distance / (distance * distance - radius * radius).sqrt();
    let reach = limb.min(3.0 * height.max(0.3));
    let width = match kind {
        5 => 2.0 * height.max(0.5),
        _ => reach * generator.log_between(0.3, 3.0),
    };
    // On the disc, at its limb, or beside it.
    let offset = limb + generator.between(-1.0, 0.7) * width;
    let turn = generator.between(0.0, TAU);
    let sideways = advanced([0.0; 3], libm::cos(turn), aside);
    let sideways = advanced(sideways, libm::sin(turn), up);
    let target = advanced(main.centre, offset.max(0.0), sideways);
    let target = if kind == 5 { advanced(target, -1e-3, axis) } else { target };
    (target, width)
}

/// Bounds around what is near the surface of a large body, or around all of a small one.
fn room(generator: &mut Generator, is_large: bool, surface: Vector, centre: Vector) -> Room {
    let middle = if is_large { surface } else { centre };
    let middle = core::array::from_fn(|i| middle[i] + generator.between(-0.5, 0.5));
    let mut half = || -> Vector { core::array::from_fn(|_| generator.log_between(1.2, 4.0)) };
    let (one, other) = (half(), half());
    let axes = generator.axes();
    match generator.whole(0..=3) {
        0 => Room::Everywhere,
        1 => Room::Cuboid([less(middle, one), advanced(middle, 1.0, other)]),
        2 => Room::Ball(Ball::sphere(middle, one[0])),
        _ => Room::Ball(Ball { centre: middle, semi_axes: one, axes }),
    }
}

/// A camera without depths, bounds and bodies.
struct Lens {
    kind: usize,
    viewpoint: Viewpoint,
    /// Of the view at the target.
    width: f64,
    /// The height over the width.
    height: f64,
    distance: f64,
}

impl Lens {
    fn camera(
        &self,
        depth: [f64; 2],
        bounds: Option<Bounds>,
        bodies: Vec<Ellipsoid>,
    ) -> Result<Arc<dyn Projection + Send>, GeometryError> {
        let &Self { kind, viewpoint, width, height, distance } = self;
        let angle = 2.0 * libm::atan(0.5 * width / distance);
        // A cone about as wide as the field of view, or half of the sky, or all of it.
        let cone = if width > 3.0 * distance { TAU } else { (1.4 * angle).min(PI) };
        macro_rules! furnished {
            ($camera:expr) => {{
                let camera = $camera;
                let camera = match bounds {
                    Some(bounds) => camera.with_bounds(bounds),
                    None => camera,
                };
                Arc::new(camera.with_occulters(bodies)?)
            }};
        }
        Ok(match kind {
            0 => furnished!(Orthographic::new(viewpoint, [width, width * height], depth)?),
            1 => furnished!(Perspective::new(viewpoint, [angle, angle * height.min(1.1)], depth)?),
            2 => {
                furnished!(Equirectangular::new(viewpoint, [cone, angle * height.min(1.0)], depth)?)
            }
            3 => furnished!(Polar::new(viewpoint, cone, depth)?),
            4 => {
                let mapping =
                    if height < 1.0 { DiscMapping::Equidistant } else { DiscMapping::EqualArea };
                furnished!(Fisheye::new(viewpoint, cone, mapping, depth)?)
            }
            _ => furnished!(Healpix::new(viewpoint.position, depth)?),
        })
    }
}

impl RandomView {
    /// The camera's kind and the seed.
    pub fn name(&self) -> String {
        format!("{}-{}", KINDS[self.kind], self.seed)
    }

    /// The camera, with bounds and bodies.
    pub fn camera(&self) -> &dyn Projection {
        &*self.camera
    }

    /// The same, shared.
    pub fn shared_camera(&self) -> Arc<dyn Projection + Send> {
        self.camera.clone()
    }

    /// Height and width of the image in pixels.
    pub fn shape(&self) -> [usize; 2] {
        self.shape
    }

    /// The emission rate, which is not negative; NaN inside of a body, where it must not be evaluated.
    ///
    /// ```
    /// assert!(emitree_problems::views::random_view(1).rate([5.0; 3]) >= 0.0);
    /// ```
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        self.scenery.rate(position)
    }

    /// The image and its error, by [quadrature](self#the-reference-image). Pixels without an image are
    /// NaN, as in renderings.
    pub fn reference(&self) -> Reference {
        reference::image(self.scene(), self.shape)
    }

    /// The same view of an emission with other parameters: they differ by up to the fraction `change`.
    ///
    /// ```
    /// let view = emitree_problems::views::random_view(2).changed(0.1);
    /// assert_eq!(view.name(), "equirectangular-2");
    /// ```
    #[must_use]
    pub fn changed(mut self, change: f64) -> Self {
        let generator = &mut Generator::new(self.seed ^ CHANGED);
        self.scenery.glow = self.scenery.glow.changed(generator, change);
        self
    }

    fn scene(&self) -> Scene<'_> {
        Scene { scenery: &self.scenery, bare: &*self.bare, is_disc: self.kind == DISC }
    }

    /// The longest path with emission, on some lines.
    fn longest_path(&self) -> f64 {
        let place = |k: usize| (k as f64 + 0.5) / LATTICE as f64;
        let of_line = |k: usize| {
            let xy = [place(k % LATTICE), place(k / LATTICE)];
            self.scenery.path(&*self.bare, xy)
        };
        (0..LATTICE * LATTICE).map(of_line).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests;
