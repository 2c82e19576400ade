//! Random solids with sharp surfaces, by number: for tests that must hold on more discontinuous
//! emissions than a few chosen ones.
//!
//! [`random_solids`] makes 1 to 4 ellipsoids, half of them hollow, in any orientation: semi-axes
//! from 0.08 to 0.45, shells 0.03 to 0.15 thick, rates from 0.2 to 1. They may overlap and stick out
//! of the cube. g is constant within each of them and the sum where they overlap, so ∫ g dz is a sum
//! of chords in closed form. Every seed is a scene for ever: [`random_solids`] must not change.

use crate::family::Reference;
use crate::family::generator::Generator;
use emitree::Image;
use rayon::prelude::*;

/// Lines for each pixel along each axis. The root at a limb is what they find hardest: their mean
/// is then wrong in proportion to their distance to the power 3/2.
pub(crate) const LINES: usize = 32;
/// A cavity leaves at least this share of the shortest semi-axis to itself.
const LEAST_CAVITY: f64 = 0.3;
/// What rounding can do to an image, relative to its largest pixel.
const ROUNDING: f64 = 1e-13;

/// One ellipsoid of constant emission rate, full or hollow.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Solid {
    rate: f64,
    centre: [f64; 3],
    axes: [[f64; 3]; 3],
    semi_axes: [f64; 3],
    /// The semi-axes of the cavity, if it is hollow.
    cavity: Option<[f64; 3]>,
}

impl Solid {
    fn draw(generator: &mut Generator) -> Self {
        let rate = generator.between(0.2, 1.0);
        let centre = core::array::from_fn(|_| generator.between(0.1, 0.9));
        let axes = generator.axes();
        let semi_axes: [f64; 3] = core::array::from_fn(|_| generator.between(0.08, 0.45));
        let thickness = generator.between(0.03, 0.15);
        let shortest = semi_axes.iter().copied().fold(f64::INFINITY, f64::min);
        let thickness = thickness.min((1.0 - LEAST_CAVITY) * shortest);
        let is_hollow = generator.whole(0..=1) == 1;
        let cavity = is_hollow.then(|| semi_axes.map(|semi_axis| semi_axis - thickness));
        Self { rate, centre, axes, semi_axes, cavity }
    }

    /// Coordinates along the axes in units of `semi_axes`, of a direction.
    fn scaled(&self, direction: [f64; 3], semi_axes: [f64; 3]) -> [f64; 3] {
        core::array::from_fn(|i| dot(self.axes[i], direction) / semi_axes[i])
    }

    fn rate(&self, position: [f64; 3]) -> f64 {
        let offset = core::array::from_fn(|i| position[i] - self.centre[i]);
        let contains = |semi_axes| {
            let scaled = self.scaled(offset, semi_axes);
            dot(scaled, scaled) < 1.0
        };
        if contains(self.semi_axes) && !self.cavity.is_some_and(contains) { self.rate } else { 0.0 }
    }

    /// The length of the chord, within 0 ≤ z ≤ 1, that the line at (x, y) cuts from an ellipsoid.
    fn chord(&self, [x, y]: [f64; 2], semi_axes: [f64; 3]) -> f64 {
        let from =
            self.scaled([x - self.centre[0], y - self.centre[1], -self.centre[2]], semi_axes);
        let along = self.scaled([0.0, 0.0, 1.0], semi_axes);
        // |from + z along|² = 1.
        let (square, half) = (dot(along, along), dot(from, along));
        let discriminant = half * half - square * (dot(from, from) - 1.0);
        if discriminant <= 0.0 {
            return 0.0;
        }
        let root = discriminant.sqrt();
        let ends = [(-half - root) / square, (-half + root) / square].map(|z| z.clamp(0.0, 1.0));
        ends[1] - ends[0]
    }

    fn line_integral(&self, line: [f64; 2]) -> f64 {
        let cavity = self.cavity.map_or(0.0, |semi_axes| self.chord(line, semi_axes));
        self.rate * (self.chord(line, self.semi_axes) - cavity)
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Some ellipsoids and ellipsoidal shells of constant emission rates.
#[derive(Clone, Debug, PartialEq)]
pub struct Solids {
    solids: Vec<Solid>,
}

/// The solids of a seed.
///
/// ```
/// let solids = emitree_problems::solids::random_solids(7);
/// let reference = solids.reference_image([8, 8]);
/// assert!(reference.error < 1e-2);
/// ```
pub fn random_solids(seed: u64) -> Solids {
    // Another stream than that of the smooth scene of this seed.
    let mut generator = Generator::new(!seed);
    let count = generator.whole(1..=4);
    Solids { solids: (0..count).map(|_| Solid::draw(&mut generator)).collect() }
}

/// Two balls that overlap, of radii 0.25 and 0.2, with g = 1 in the first and 2.3 in the second: three regions.
///
/// ```
/// let balls = emitree_problems::solids::two_balls();
/// assert_eq!(balls.rate([0.3, 0.4, 0.4]), 1.0);
/// assert_eq!(balls.rate([0.5, 0.52, 0.53]), 3.3);
/// ```
pub fn two_balls() -> Solids {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let ball = |rate: f64, centre: [f64; 3], radius: f64| Solid {
        rate,
        centre,
        axes,
        semi_axes: [radius; 3],
        cavity: None,
    };
    let solids = vec![ball(1.0, [0.4, 0.45, 0.45], 0.25), ball(2.3, [0.6, 0.58, 0.6], 0.2)];
    Solids { solids }
}

impl Solids {
    /// The emission rate at a point of the unit cube.
    ///
    /// ```
    /// assert!(emitree_problems::solids::random_solids(1).rate([0.5; 3]) >= 0.0);
    /// ```
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        self.solids.iter().map(|solid| solid.rate(position)).sum()
    }

    /// ∫ g dz over 0 ≤ z ≤ 1 at (x, y), in closed form.
    ///
    /// ```
    /// assert!(emitree_problems::solids::random_solids(1).line_integral([0.5, 0.5]) >= 0.0);
    /// ```
    pub fn line_integral(&self, line: [f64; 2]) -> f64 {
        self.solids.iter().map(|solid| solid.line_integral(line)).sum()
    }

    /// The image of `shape` = \[height, width\] pixels in the canonical projection: the mean of
    /// 32 × 32 lines for each pixel. Its error is the difference to the mean of 16 × 16: about three
    /// times as much as is left.
    ///
    /// ```
    /// let reference = emitree_problems::solids::random_solids(3).reference_image([4, 6]);
    /// assert_eq!((reference.image.height(), reference.image.width()), (4, 6));
    /// ```
    pub fn reference_image(&self, shape: [usize; 2]) -> Reference {
        mean_of_lines(shape, |line| self.line_integral(line))
    }
}

/// The means of 32 × 32 lines for each pixel, their error the difference to those of 16 × 16.
pub(crate) fn mean_of_lines(
    shape: [usize; 2],
    line_integral: impl Fn([f64; 2]) -> f64 + Sync,
) -> Reference {
    let mean = |lines: usize| means(shape, lines, &line_integral);
    reference(mean(LINES), &mean(LINES / 2))
}

/// An image whose error is the difference to a coarser one.
pub(crate) fn reference(image: Image, coarser: &Image) -> Reference {
    let (_, largest) = image.min_max();
    let error = image.max_difference(coarser) / largest + ROUNDING;
    Reference { image, error }
}

/// The mean of `lines` × `lines` lines for each pixel, weighted with the density of solid angle.
pub(crate) fn weighted_means(
    shape: [usize; 2],
    lines: usize,
    density: &(impl Fn([f64; 2]) -> f64 + Sync),
    line_integral: &(impl Fn([f64; 2]) -> f64 + Sync),
) -> Image {
    let mut image = means(shape, lines, &|xy| density(xy) * line_integral(xy));
    let weights = means(shape, lines, density);
    let pixels = image.pixels_mut().iter_mut().zip(weights.pixels());
    pixels.for_each(|(pixel, weight)| *pixel /= weight);
    image
}

/// The mean of `lines` × `lines` lines for each pixel.
fn means(
    [height, width]: [usize; 2],
    lines: usize,
    line_integral: &(impl Fn([f64; 2]) -> f64 + Sync),
) -> Image {
    let mean = |pixel: usize| {
        let [row, column] = [pixel / width, pixel % width].map(|k| k as f64);
        let place = |k: usize| (k as f64 + 0.5) / lines as f64;
        let of_line = |k: usize| {
            let x = (column + place(k % lines)) / width as f64;
            let y = (row + place(k / lines)) / height as f64;
            line_integral([x, y])
        };
        (0..lines * lines).map(of_line).sum::<f64>() / (lines * lines) as f64
    };
    let pixels = (0..height * width).into_par_iter().map(mean).collect();
    Image::from_pixels(height, width, pixels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brute::check_line_integrals;

    #[test]
    fn line_integrals_agree_with_many_samples_of_the_rate() {
        for seed in 0..30 {
            let solids = random_solids(seed);
            let (rate, integral) = (|r| solids.rate(r), |line| solids.line_integral(line));
            check_line_integrals(&seed.to_string(), rate, integral, 4.0, 4.0);
        }
    }

    #[test]
    fn reference_images_are_good_enough_for_a_tolerance_of_a_hundredth() {
        for seed in 0..8 {
            let reference = random_solids(seed).reference_image([64, 64]);
            assert!(reference.error < 2e-3, "{seed}: {}", reference.error);
        }
    }
}
