//! Random shapes with sharp surfaces, one of each kind in turn: a rotated box, an ellipsoid, a
//! cylinder, a union of two of these, and a shell.
//!
//! Semi-axes are 0.08 to 0.35, centres 0.25 to 0.75, orientations random; shells are 0.03 to 0.12
//! thick. Within a shape g is linear in the position, in half of the scenes constant; around it g is
//! zero in half of them, or constant. A line of sight is in a convex shape from one depth to another,
//! so ∫ g dz is known in closed form. Every seed is a scene for ever: [`random_shape`] must not
//! change. [`crate::solids`] are several bodies whose emissions add up.

use crate::family::Reference;
use crate::family::generator::Generator;
use crate::solids::mean_of_lines;

/// The kinds of scenes, in the order of the seeds.
const KINDS: [&str; 5] = ["box", "ellipsoid", "cylinder", "union", "shell"];
/// A cavity leaves at least this share of the shortest semi-axis to itself.
const LEAST_CAVITY: f64 = 0.3;

/// The form of a convex body in coordinates along its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    Cuboid,
    Ellipsoid,
    /// An ellipse in the first two axes, straight along the third.
    Cylinder,
}

/// A convex body.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Body {
    form: Form,
    centre: [f64; 3],
    axes: [[f64; 3]; 3],
    semi_axes: [f64; 3],
}

/// A part of a line: its origin, a unit vector along it, and the distances of its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    pub(crate) origin: [f64; 3],
    pub(crate) direction: [f64; 3],
    pub(crate) ends: [f64; 2],
}

/// One scene of the family.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    kind: &'static str,
    /// The bodies of which one or more contain each point of the shape.
    bodies: Vec<Body>,
    /// What is cut out.
    cavity: Option<Body>,
    inside: f64,
    gradient: [f64; 3],
    outside: f64,
}

/// The scene of a seed.
///
/// ```
/// let shape = emitree_problems::shapes::random_shape(3);
/// assert_eq!(shape.kind(), "union");
/// ```
pub fn random_shape(seed: u64) -> Shape {
    // Another stream than those of the other families.
    let mut generator = Generator::new(seed ^ 0x5ca1_ab1e_0000_0000);
    let number = usize::try_from(seed % 5).unwrap_or(0);
    let kind = KINDS[number];
    let any = |generator: &mut Generator| {
        [Form::Cuboid, Form::Ellipsoid, Form::Cylinder][generator.whole(0..=2) as usize]
    };
    let bodies = match number {
        0 => vec![Body::draw(&mut generator, Form::Cuboid)],
        1 => vec![Body::draw(&mut generator, Form::Ellipsoid)],
        2 => vec![Body::draw(&mut generator, Form::Cylinder)],
        3 => (0..2)
            .map(|_| {
                let form = any(&mut generator);
                Body::draw(&mut generator, form)
            })
            .collect(),
        _ => {
            let form = any(&mut generator);
            vec![Body::draw(&mut generator, form)]
        }
    };
    let thickness = generator.between(0.03, 0.12);
    let cavity = (kind == "shell").then(|| bodies[0].shrunk(thickness));
    let inside = generator.between(0.5, 1.0);
    let is_linear = generator.whole(0..=1) == 1;
    let gradient = core::array::from_fn(|_| {
        let slope = generator.between(-0.25, 0.25);
        if is_linear { slope } else { 0.0 }
    });
    let is_bright = generator.whole(0..=1) == 1;
    let outside = generator.between(0.02, 0.1);
    let outside = if is_bright { outside } else { 0.0 };
    Shape { kind, bodies, cavity, inside, gradient, outside }
}

/// A shape by name, of constant emission rates and nothing around it: a `ball`, `two balls` that overlap, or a
/// spherical `shell`.
///
/// ```
/// let shell = emitree_problems::shapes::named_shape("shell").unwrap();
/// assert_eq!(shape_at(&shell, 0.5), 0.0);
/// assert_eq!(shape_at(&shell, 0.77), 1.0);
/// # fn shape_at(shape: &emitree_problems::shapes::Shape, z: f64) -> f64 { shape.rate([0.5, 0.5, z]) }
/// ```
pub fn named_shape(name: &str) -> Option<Shape> {
    const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let ball = |centre: [f64; 3], radius: f64| Body {
        form: Form::Ellipsoid,
        centre,
        axes: AXES,
        semi_axes: [radius; 3],
    };
    let (kind, bodies, cavity) = match name {
        "ball" => ("ellipsoid", vec![ball([0.5; 3], 0.3)], None),
        "two balls" => {
            ("union", vec![ball([0.42, 0.45, 0.5], 0.24), ball([0.62, 0.58, 0.45], 0.2)], None)
        }
        "shell" => ("shell", vec![ball([0.5; 3], 0.3)], Some(ball([0.5; 3], 0.24))),
        _ => return None,
    };
    Some(Shape { kind, bodies, cavity, inside: 1.0, gradient: [0.0; 3], outside: 0.0 })
}

/// A tilted bar with sharp edges, of a constant emission rate: four times as long as wide, ten times as long as high.
///
/// ```
/// let bar = emitree_problems::shapes::bar();
/// assert_eq!(bar.kind(), "box");
/// assert_eq!((bar.rate([0.5; 3]), bar.rate([0.5, 0.5, 0.7])), (1.0, 0.0));
/// ```
pub fn bar() -> Shape {
    let axes = [[0.48, 0.6, 0.64], [0.8, 0.0, -0.6], [-0.36, 0.8, -0.48]];
    let (form, centre, semi_axes) = (Form::Cuboid, [0.5; 3], [0.4, 0.1, 0.04]);
    let bodies = vec![Body { form, centre, axes, semi_axes }];
    Shape { kind: "box", bodies, cavity: None, inside: 1.0, gradient: [0.0; 3], outside: 0.0 }
}

impl Body {
    fn draw(generator: &mut Generator, form: Form) -> Self {
        let centre = core::array::from_fn(|_| generator.between(0.25, 0.75));
        let axes = generator.axes();
        let semi_axes = core::array::from_fn(|_| generator.between(0.08, 0.35));
        Self { form, centre, axes, semi_axes }
    }

    /// The body with semi-axes that are shorter by `thickness`, or less.
    fn shrunk(&self, thickness: f64) -> Self {
        let shortest = self.semi_axes.iter().copied().fold(f64::INFINITY, f64::min);
        let thickness = thickness.min((1.0 - LEAST_CAVITY) * shortest);
        Self { semi_axes: self.semi_axes.map(|semi_axis| semi_axis - thickness), ..*self }
    }

    /// A direction along the axes, in units of the semi-axes.
    fn scaled(&self, direction: [f64; 3]) -> [f64; 3] {
        core::array::from_fn(|i| {
            let along: f64 = (0..3).map(|k| self.axes[i][k] * direction[k]).sum();
            along / self.semi_axes[i]
        })
    }

    fn contains(&self, position: [f64; 3]) -> bool {
        let [u, v, w] = self.scaled(core::array::from_fn(|k| position[k] - self.centre[k]));
        match self.form {
            Form::Cuboid => u.abs() < 1.0 && v.abs() < 1.0 && w.abs() < 1.0,
            Form::Ellipsoid => u * u + v * v + w * w < 1.0,
            Form::Cylinder => u * u + v * v < 1.0 && w.abs() < 1.0,
        }
    }

    /// The distances between which a line is in the body, within its ends; equal ones if it is nowhere.
    fn distances(&self, line: &Line) -> [f64; 2] {
        let from = self.scaled(core::array::from_fn(|k| line.origin[k] - self.centre[k]));
        let step = self.scaled(line.direction);
        let [first, last] = line.ends;
        let slabs = |axes: &[usize]| {
            axes.iter().fold([first, last], |[low, high], &k| {
                let [a, b] = slab(from[k], step[k]);
                [low.max(a), high.min(b)]
            })
        };
        let [low, high] = match self.form {
            Form::Cuboid => slabs(&[0, 1, 2]),
            Form::Ellipsoid => quadric(&from, &step),
            Form::Cylinder => {
                let ([a, b], [c, d]) = (slabs(&[2]), quadric(&from[..2], &step[..2]));
                [a.max(c), b.min(d)]
            }
        };
        let [low, high] = [low.clamp(first, last), high.clamp(first, last)];
        [low, high.max(low)]
    }
}

/// The distances between which something is true of a line.
const ALWAYS: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
const NEVER: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];

/// Where |from + z step| < 1.
fn slab(from: f64, step: f64) -> [f64; 2] {
    if step.abs() < 1e-300 {
        return if from.abs() < 1.0 { ALWAYS } else { NEVER };
    }
    let [a, b] = [(-1.0 - from) / step, (1.0 - from) / step];
    [a.min(b), a.max(b)]
}

/// Where the sum of the squares of from + z step is below 1.
fn quadric(from: &[f64], step: &[f64]) -> [f64; 2] {
    let product = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let (square, half) = (product(step, step), product(from, step));
    let discriminant = half * half - square * (product(from, from) - 1.0);
    if discriminant <= 0.0 {
        return NEVER;
    }
    if square < 1e-300 {
        return ALWAYS;
    }
    let root = discriminant.sqrt();
    [(-half - root) / square, (-half + root) / square]
}

impl Shape {
    /// What it is: `box`, `ellipsoid`, `cylinder`, `union` or `shell`.
    ///
    /// ```
    /// assert_eq!(emitree_problems::shapes::random_shape(5).kind(), "box");
    /// ```
    pub fn kind(&self) -> &'static str {
        self.kind
    }

    /// The emission rate at a point of the unit cube.
    ///
    /// ```
    /// assert!(emitree_problems::shapes::random_shape(1).rate([0.5; 3]) >= 0.0);
    /// ```
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        let is_in = |body: &Body| body.contains(position);
        if self.bodies.iter().any(is_in) && !self.cavity.as_ref().is_some_and(is_in) {
            self.within(position)
        } else {
            self.outside
        }
    }

    /// g in the shape, continued to all points.
    fn within(&self, position: [f64; 3]) -> f64 {
        let slope: f64 = (0..3).map(|k| self.gradient[k] * (position[k] - 0.5)).sum();
        self.inside + slope
    }

    /// The emission of the shape alone, and that around it alone.
    pub(crate) fn inside_and_outside(&self) -> [Self; 2] {
        [Self { outside: 0.0, ..self.clone() }, self.around(self.outside)]
    }

    /// An emission of a constant rate around the shape, and none in it.
    pub(crate) fn around(&self, rate: f64) -> Self {
        Self { inside: 0.0, gradient: [0.0; 3], outside: rate, ..self.clone() }
    }

    /// g in the middle of the shape.
    pub(crate) fn inside_rate(&self) -> f64 {
        self.inside
    }

    /// ∫ g dz over 0 ≤ z ≤ 1 at (x, y), in closed form.
    ///
    /// ```
    /// assert!(emitree_problems::shapes::random_shape(1).line_integral([0.5, 0.5]) >= 0.0);
    /// ```
    pub fn line_integral(&self, [x, y]: [f64; 2]) -> f64 {
        let (origin, direction) = ([x, y, 0.0], [0.0, 0.0, 1.0]);
        self.integral_along(&Line { origin, direction, ends: [0.0, 1.0] })
    }

    /// ∫ g ds along a part of a line, in closed form.
    pub(crate) fn integral_along(&self, line: &Line) -> f64 {
        let of_body = |body: &Body| body.distances(line);
        let mut parts: Vec<[f64; 2]> = self.bodies.iter().map(of_body).collect();
        parts.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let [first, end] = line.ends;
        let (mut sum, mut last) = (self.outside * (end - first), first);
        let of = |[from, to]: [f64; 2]| {
            // The mean of a linear function is its value in the middle.
            let middle = 0.5 * (from + to);
            let at = core::array::from_fn(|k| line.origin[k] + middle * line.direction[k]);
            (to - from).max(0.0) * (self.within(at) - self.outside)
        };
        for [from, to] in parts {
            sum += of([from.max(last), to.max(from.max(last))]);
            last = last.max(to);
        }
        sum - self.cavity.as_ref().map_or(0.0, |cavity| of(cavity.distances(line)))
    }

    /// The image of `shape` = \[height, width\] pixels in the canonical projection: the mean of
    /// 32 × 32 lines for each pixel. Its error is the difference to the mean of 16 × 16.
    ///
    /// ```
    /// let reference = emitree_problems::shapes::random_shape(3).reference_image([4, 6]);
    /// assert_eq!((reference.image.height(), reference.image.width()), (4, 6));
    /// ```
    pub fn reference_image(&self, shape: [usize; 2]) -> Reference {
        mean_of_lines(shape, |line| self.line_integral(line))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brute::check_line_integrals;

    /// A line crosses up to four surfaces.
    #[test]
    fn line_integrals_agree_with_many_samples_of_the_rate() {
        for seed in 0..40 {
            let shape = random_shape(seed);
            let (rate, integral) = (|r| shape.rate(r), |line| shape.line_integral(line));
            check_line_integrals(&seed.to_string(), rate, integral, 4.0, 1.5);
        }
    }

    /// That of the bar is the product of its sides: they are perpendicular.
    #[test]
    fn shapes_by_name_hold_their_volumes() {
        let ball = |radius: f64| 4.0 / 3.0 * core::f64::consts::PI * radius.powi(3);
        let named = ["ball", "shell"].map(named_shape);
        let volumes = [ball(0.3), ball(0.3) - ball(0.24), 8.0 * 0.4 * 0.1 * 0.04];
        let shapes: Vec<Shape> = named.into_iter().flatten().chain([bar()]).collect();
        assert_eq!(shapes.len(), volumes.len());
        for (shape, volume) in shapes.iter().zip(volumes) {
            let image = shape.reference_image([32, 32]).image;
            let mean = image.pixels().iter().sum::<f64>() / 1024.0;
            assert!((mean - volume).abs() < 1e-4 * volume, "{mean} instead of {volume}");
        }
        assert_eq!(named_shape("sun"), None);
    }

    /// 200 seeds: each kind in turn, and no shape without a bright pixel.
    #[test]
    fn every_seed_is_a_shape_in_view() {
        for seed in 0..200_u64 {
            let shape = random_shape(seed);
            assert_eq!(shape.kind(), KINDS[(seed % 5) as usize]);
            let image = shape.reference_image([8, 8]).image;
            let (least, most) = image.min_max();
            assert!(least >= 0.0 && most > shape.outside + 0.01, "{seed}: {least} to {most}");
        }
    }
}
