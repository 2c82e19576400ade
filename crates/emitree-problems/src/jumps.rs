//! Shapes with sharp surfaces seen by cameras of all kinds, by name and by number.
//!
//! The emission is that of [`crate::shapes`] in and around the unit cube. The observer is outside of the cube
//! or in it, and cameras are perspective, equirectangular, polar, a disc and `HEALPix`: the views of
//! [`named_jump`] are of the whole sky (but for the perspective one), those of [`random_jump`] of a part of it
//! or of all. There may be an opaque sphere, in which g is NaN, and spherical bounds. The emission ends where the
//! depths of the camera do. Every seed is a view for ever: [`random_jump`] must not change.

use crate::family::Reference;
use crate::family::generator::Generator;
use crate::shapes::{Line, Shape, named_shape, random_shape};
use crate::solids::{reference, weighted_means};
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use emitree::projection::{Bounds, DiscMapping, Ellipsoid, GeometryError};
use emitree::{Equirectangular, Fisheye, Healpix, Perspective, Polar, Projection, Viewpoint};

/// The kinds of cameras.
pub const CAMERAS: [&str; 5] = ["perspective", "equirectangular", "polar", "fisheye", "healpix"];
/// What [`named_jump`] shows.
pub const SCENES: [&str; 3] = ["ball", "two balls", "shell"];
/// What may be around the emission of [`named_jump`].
pub const SURROUNDINGS: [&str; 3] = ["nothing", "bounds", "body"];

/// Lines along each axis of a pixel of the reference image.
const LINES: usize = 48;
/// Pixels along each side, of a face of `HEALPix` those of the second number.
const PIXELS: [usize; 2] = [48, 12];
/// The middle of the cube.
const MIDDLE: [f64; 3] = [0.5; 3];
/// A point on the surface is not in the body, whatever rounding does.
const ROUNDING: f64 = 1e-9;

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sphere {
    centre: [f64; 3],
    radius: f64,
}

impl Sphere {
    /// The distances between which a line is in it.
    fn crossing(&self, origin: [f64; 3], direction: [f64; 3]) -> Option<[f64; 2]> {
        let from: [f64; 3] = core::array::from_fn(|k| origin[k] - self.centre[k]);
        let product = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
        let half = product(from, direction);
        let discriminant = half * half - product(from, from) + self.radius * self.radius;
        (discriminant > 0.0).then(|| [-half - discriminant.sqrt(), -half + discriminant.sqrt()])
    }

    fn ellipsoid(&self) -> Result<Ellipsoid, GeometryError> {
        Ellipsoid::sphere(self.centre, self.radius)
    }
}

/// A shape, and the camera that sees it.
#[derive(Debug)]
pub struct Jump {
    name: String,
    shape: Shape,
    camera: Box<dyn Projection + Send>,
    /// The camera without the body and the bounds.
    bare: Box<dyn Projection + Send>,
    body: Option<Sphere>,
    bounds: Option<Sphere>,
    pixels: [usize; 2],
    /// The length of all lines of sight without bounds.
    length: f64,
}

/// A camera without depths, bounds and bodies.
struct Lens {
    kind: usize,
    viewpoint: Viewpoint,
    /// Angles (rad): of a perspective camera, and of others.
    angle_rad: f64,
    cone_rad: f64,
}

impl Lens {
    fn camera(
        &self,
        length: f64,
        body: Option<Sphere>,
        bounds: Option<Sphere>,
    ) -> Result<Box<dyn Projection + Send>, GeometryError> {
        let &Self { kind, viewpoint, angle_rad, cone_rad } = self;
        let depth = [0.0, length];
        let bodies: Vec<Ellipsoid> =
            body.iter().map(Sphere::ellipsoid).collect::<Result<_, _>>()?;
        macro_rules! furnished {
            ($camera:expr) => {{
                let camera = $camera;
                let camera = match bounds {
                    Some(bounds) => camera.with_bounds(Bounds::Ellipsoid(bounds.ellipsoid()?)),
                    None => camera,
                };
                Box::new(camera.with_occulters(bodies)?)
            }};
        }
        Ok(match kind {
            0 => furnished!(Perspective::new(viewpoint, [angle_rad; 2], depth)?),
            1 => {
                let angles = [cone_rad, 0.5 * cone_rad];
                furnished!(Equirectangular::new(viewpoint, angles, depth)?)
            }
            2 => furnished!(Polar::new(viewpoint, cone_rad, depth)?),
            3 => furnished!(Fisheye::new(viewpoint, cone_rad, DiscMapping::Equidistant, depth)?),
            _ => furnished!(Healpix::new(viewpoint.position, depth)?),
        })
    }
}

/// A view by name: of [`SCENES`], [`CAMERAS`], from the outside or the inside, and of [`SURROUNDINGS`]. A view
/// that the library refuses is none.
///
/// ```
/// let view = emitree_problems::jumps::named_jump("ball", "polar", false, "nothing").unwrap();
/// assert_eq!(view.name(), "ball, polar, outside, nothing");
/// ```
pub fn named_jump(scene: &str, camera: &str, is_inside: bool, around: &str) -> Option<Jump> {
    let kind = CAMERAS.iter().position(|kind| *kind == camera)?;
    let shape = named_shape(scene)?;
    let position = if is_inside { [0.42, 0.55, 0.47] } else { [1.2, -0.1, 1.0] };
    // Not towards the middle, so that the whole sky has no symmetry.
    let target = if kind == 0 { MIDDLE } else { [0.1, 0.9, 0.7] };
    let viewpoint = Viewpoint { position, target, up: [0.0, 0.0, 1.0] };
    let angle_rad = if is_inside { FRAC_PI_2 } else { 0.8 };
    let lens = Lens { kind, viewpoint, angle_rad, cone_rad: TAU };
    let body = (around == "body").then_some(Sphere { centre: [0.62, 0.4, 0.58], radius: 0.08 });
    let bounds = (around == "bounds").then_some(Sphere { centre: MIDDLE, radius: 0.8 });
    let place = if is_inside { "inside" } else { "outside" };
    let name = format!("{scene}, {camera}, {place}, {around}");
    Jump::new(name, shape, &lens, if is_inside { 2.0 } else { 2.5 }, body, bounds).ok()
}

/// The view of a seed; its shape is that of [`random_shape`], and its camera's kind is a fifth of the seed,
/// modulo 5.
///
/// ```
/// let view = emitree_problems::jumps::random_jump(13);
/// assert!(view.name().starts_with("union-polar-"));
/// ```
pub fn random_jump(seed: u64) -> Jump {
    // Another stream than those of the other families.
    let mut generator = Generator::new(seed ^ 0x10b5_0a11_0000_0000);
    loop {
        // A draw that the library refuses is followed by another.
        if let Ok(view) = draw(seed, &mut generator) {
            return view;
        }
    }
}

fn draw(seed: u64, generator: &mut Generator) -> Result<Jump, GeometryError> {
    let kind = usize::try_from(seed / 5 % 5).unwrap_or(0);
    let is_inside = generator.whole(0..=2) == 0;
    let [towards, aside, up] = generator.axes();
    let middle: [f64; 3] = core::array::from_fn(|_| generator.between(0.4, 0.6));
    let distance =
        if is_inside { generator.between(0.0, 0.25) } else { generator.between(1.2, 3.0) };
    let position: [f64; 3] = core::array::from_fn(|k| middle[k] + distance * towards[k]);
    let angle_rad = if is_inside { FRAC_PI_2 } else { 2.0 * libm::atan(0.6 / distance) };
    let extent = generator.whole(0..=2);
    let cone_rad = match extent {
        0 => (1.6 * angle_rad).min(TAU),
        1 => PI,
        _ => TAU,
    };
    // What is a part of the sky points about to the middle of the cube, what is all of it anywhere.
    let offset = if kind == 0 || extent == 0 { 0.1 } else { 1.5 };
    let target = core::array::from_fn(|k| middle[k] + offset * aside[k] + 1e-3 * up[k]);
    let viewpoint = Viewpoint { position, target, up };
    let lens = Lens { kind, viewpoint, angle_rad, cone_rad };
    let mut sphere = |least: f64, most: f64| Sphere {
        centre: core::array::from_fn(|_| generator.between(0.2, 0.8)),
        radius: generator.between(least, most),
    };
    let (body, bounds) = (sphere(0.06, 0.2), sphere(0.5, 0.9));
    let body = (generator.whole(0..=3) == 0).then_some(body);
    let bounds = (generator.whole(0..=3) == 0).then_some(bounds);
    let length = if is_inside { 2.0 } else { 2.0 * distance };
    let shape = random_shape(seed);
    let place = if is_inside { "inside" } else { "outside" };
    let around = match (body.is_some(), bounds.is_some()) {
        (false, false) => "",
        (true, false) => "-body",
        (false, true) => "-bounds",
        (true, true) => "-body-bounds",
    };
    let name = format!("{}-{}-{place}{around}-{seed}", shape.kind(), CAMERAS[kind]);
    Jump::new(name, shape, &lens, length, body, bounds)
}

impl Jump {
    fn new(
        name: String,
        shape: Shape,
        lens: &Lens,
        length: f64,
        body: Option<Sphere>,
        bounds: Option<Sphere>,
    ) -> Result<Self, GeometryError> {
        let camera = lens.camera(length, body, bounds)?;
        let bare = lens.camera(length, None, None)?;
        let [side, of_face] = PIXELS;
        let pixels = if lens.kind == 4 { Healpix::shape(of_face) } else { [side; 2] };
        Ok(Self { name, shape, camera, bare, body, bounds, pixels, length })
    }

    /// What it is: the shape, the camera, the place of the observer, and the surroundings or the seed.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The camera.
    pub fn camera(&self) -> &(dyn Projection + Send) {
        &*self.camera
    }

    /// Height and width of the image in pixels.
    pub fn pixels(&self) -> [usize; 2] {
        self.pixels
    }

    /// The emission rate at a point; NaN inside the body.
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        if self.is_in_body(position) { f64::NAN } else { self.shape.rate(position) }
    }

    /// Whether a point is inside the body.
    pub(crate) fn is_in_body(&self, position: [f64; 3]) -> bool {
        let is_in = |body: &Sphere| {
            let square: f64 = (0..3).map(|k| (position[k] - body.centre[k]).powi(2)).sum();
            square < body.radius.powi(2) * (1.0 - ROUNDING)
        };
        self.body.as_ref().is_some_and(is_in)
    }

    /// The radiance of the line of sight at canonical (x, y), in closed form.
    pub fn line_integral(&self, xy: [f64; 2]) -> f64 {
        self.integral_of(&self.shape, xy)
    }

    /// That of another shape.
    fn integral_of(&self, shape: &Shape, [x, y]: [f64; 2]) -> f64 {
        let first = self.bare.world_from_canonical([x, y, 0.0]);
        let (origin, direction) = (first.position, first.direction.map(|along| -along));
        let mut ends = [0.0, self.length];
        if let Some(bounds) = &self.bounds {
            let Some([enter, leave]) = bounds.crossing(origin, direction) else { return 0.0 };
            ends = [ends[0].max(enter), ends[1].min(leave)];
        }
        if let Some([enter, leave]) = self.body.and_then(|of| of.crossing(origin, direction))
            && leave > ends[0]
        {
            ends[1] = ends[1].min(enter.max(ends[0]));
        }
        if ends[0] >= ends[1] {
            return 0.0;
        }
        shape.integral_along(&Line { origin, direction, ends })
    }

    /// The image: means of 48 × 48 lines, weighted with solid angle; NaN without an image. Its error is the
    /// difference to 24 × 24.
    pub fn reference_image(&self) -> Reference {
        self.image_of(&self.shape)
    }

    /// That of another shape.
    pub(crate) fn image_of(&self, shape: &Shape) -> Reference {
        let density = |xy| self.bare.solid_angle_density(xy);
        let of_line = |xy| if density(xy) > 0.0 { self.integral_of(shape, xy) } else { 0.0 };
        let mean = |lines: usize| weighted_means(self.pixels, lines, &density, &of_line);
        reference(mean(LINES), &mean(LINES / 2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines end at bodies and at bounds, and their integrals are those of many samples of the rate.
    #[test]
    fn line_integrals_agree_with_many_samples_of_the_rate() {
        const SAMPLES: u32 = 20_000;
        for seed in 0..50 {
            let view = random_jump(seed);
            for k in 0..8 {
                let xy = [0.13 + 0.11 * f64::from(k), 0.91 - 0.1 * f64::from(k)];
                if view.bare.solid_angle_density(xy) == 0.0 {
                    continue;
                }
                let rates = (0..SAMPLES).map(|i| {
                    let z = (f64::from(i) + 0.5) / f64::from(SAMPLES);
                    let at = view.camera.world_from_canonical([xy[0], xy[1], z]);
                    view.rate(at.position) * at.path_per_depth
                });
                let sum = rates.sum::<f64>() / f64::from(SAMPLES);
                let exact = view.line_integral(xy);
                let name = view.name();
                assert!(
                    (sum - exact).abs() < 4.0 * view.length / f64::from(SAMPLES),
                    "{name}, {k}"
                );
            }
        }
    }

    #[test]
    fn all_names_are_views_with_light() {
        for (scene, camera) in SCENES.iter().flat_map(|s| CAMERAS.map(|c| (s, c))) {
            for (is_inside, around) in [(false, "nothing"), (true, "bounds"), (false, "body")] {
                let view = named_jump(scene, camera, is_inside, around).unwrap();
                let [rows, columns] = view.pixels();
                let middle = |k: usize, count: usize| (k as f64 + 0.5) / count as f64;
                let lines = (0..rows * columns)
                    .map(|k| [middle(k % columns, columns), middle(k / columns, rows)]);
                let brightest = lines.map(|xy| view.line_integral(xy)).fold(0.0, f64::max);
                assert!(brightest > 0.05, "{scene} {camera} {is_inside} {around}: {brightest}");
            }
        }
        assert!(named_jump("cube", "polar", false, "nothing").is_none());
    }
}
