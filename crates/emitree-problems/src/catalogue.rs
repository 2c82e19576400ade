//! The problems by name, as one type, for tests and studies that loop over them.

use crate::ball::{self, Ball};
use crate::beta_model::{self, BetaModel};
use crate::family::{RandomScene, Reference};
use crate::gaussians::Gaussians;
use crate::nebula::{self, Nebula};
use crate::shapes::bar;
use crate::solids::two_balls;
use crate::{equation8, shell, shock, tube};
use emitree::Image;

/// A bound on the error of images from closed forms alone: rounding.
const CLOSED_FORM: f64 = 1e-13;
/// A bound on the error of the mean of 32 × 32 lines at limbs, for 48 × 48 pixels or more.
const IMAGE_ERROR_OF_LINES: f64 = 5e-4;

/// An emission on the unit cube and its exact image in the canonical projection.
pub struct Problem {
    /// What it is called in tables.
    pub name: String,
    /// Whether g is smooth: without jumps.
    pub smooth: bool,
    /// A bound on the largest error of a pixel of the exact image, relative to the largest pixel.
    pub image_error: f64,
    rate: Box<dyn Fn([f64; 3]) -> f64 + Send + Sync>,
    exact_image: Box<dyn Fn([usize; 2]) -> Image + Send + Sync>,
}

impl Problem {
    /// The emission rate at a point of the unit cube.
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        (self.rate)(position)
    }

    /// The exact image of `shape` = \[height, width\] pixels.
    pub fn exact_image(&self, shape: [usize; 2]) -> Image {
        (self.exact_image)(shape)
    }

    fn new(
        name: &str,
        (smooth, image_error): (bool, f64),
        rate: impl Fn([f64; 3]) -> f64 + Send + Sync + 'static,
        exact_image: impl Fn([usize; 2]) -> Image + Send + Sync + 'static,
    ) -> Self {
        let (rate, exact_image) = (Box::new(rate), Box::new(exact_image));
        Self { name: name.to_owned(), smooth, image_error, rate, exact_image }
    }
}

impl core::fmt::Debug for Problem {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Problem")
            .field("name", &self.name)
            .field("smooth", &self.smooth)
            .field("image_error", &self.image_error)
            .finish_non_exhaustive()
    }
}

/// A scene of the family, with its reference as the exact image.
///
/// ```
/// use emitree_problems::catalogue::Problem;
/// use emitree_problems::family::random_scene;
///
/// let problem = Problem::from(random_scene(2));
/// assert_eq!(problem.name, "cores-2");
/// ```
impl From<RandomScene> for Problem {
    fn from(scene: RandomScene) -> Self {
        let (name, other) = (scene.name(), scene.clone());
        let image = move |shape| other.reference_image(shape).image;
        Self::new(&name, (true, 1e-6), move |position| scene.rate(position), image)
    }
}

/// All named problems: `eq8`, `shell`, `shock`, `beta`, `ball`, `nebula`, `gaussians`.
///
/// ```
/// use emitree_problems::catalogue::problems;
///
/// for problem in problems() {
///     let image = problem.exact_image([4, 4]);
///     assert!(image.min_max().1 > 0.0, "{} is dark", problem.name);
/// }
/// ```
pub fn problems() -> Vec<Problem> {
    let (beta, ball, nebula) = (BetaModel::default(), Ball::default(), Nebula::default());
    let (gaussians, same) = (Gaussians::default(), Gaussians::default());
    let eq8 = |position| equation8::rate(position, equation8::ALPHA);
    let eq8_image = |shape| equation8::exact_image(equation8::ALPHA, shape);
    let (jumps, smooth) = (false, true);
    vec![
        Problem::new("eq8", (smooth, CLOSED_FORM), eq8, eq8_image),
        Problem::new("shell", (smooth, shell::IMAGE_ERROR), shell::rate, shell::exact_image),
        Problem::new("shock", (jumps, shock::IMAGE_ERROR), shock::rate, shock::exact_image),
        Problem::new(
            "beta",
            (smooth, beta_model::IMAGE_ERROR),
            move |position| beta.rate(position),
            move |shape| beta.exact_image(shape),
        ),
        Problem::new(
            "ball",
            (jumps, ball::IMAGE_ERROR),
            move |position| ball.rate(position),
            move |shape| ball.exact_image(shape),
        ),
        Problem::new(
            "nebula",
            (jumps, nebula::IMAGE_ERROR),
            move |position| nebula.rate(position),
            move |shape| nebula.exact_image(shape),
        ),
        Problem::new(
            "gaussians",
            (smooth, CLOSED_FORM),
            move |position| gaussians.rate(position),
            move |shape| same.exact_image(shape),
        ),
    ]
}

/// Further problems with sharp surfaces: `two balls` of different brightness that overlap, a bent `tube` and a `bar`.
/// Images are means of 32 × 32 lines for each pixel.
///
/// ```
/// for problem in emitree_problems::catalogue::surface_problems() {
///     assert!(!problem.smooth);
///     assert!(problem.exact_image([4, 4]).min_max().1 > 0.0, "{} is dark", problem.name);
/// }
/// ```
pub fn surface_problems() -> Vec<Problem> {
    let (balls, same_balls) = (two_balls(), two_balls());
    let (bar, same_bar) = (bar(), bar());
    vec![
        of_lines("two balls", move |at| balls.rate(at), move |of| same_balls.reference_image(of)),
        of_lines("tube", tube::rate, tube::reference_image),
        of_lines("bar", move |at| bar.rate(at), move |of| same_bar.reference_image(of)),
    ]
}

/// A problem with sharp surfaces whose image is the mean of lines.
fn of_lines(
    name: &str,
    rate: impl Fn([f64; 3]) -> f64 + Send + Sync + 'static,
    reference: impl Fn([usize; 2]) -> Reference + Send + Sync + 'static,
) -> Problem {
    Problem::new(name, (false, IMAGE_ERROR_OF_LINES), rate, move |shape| reference(shape).image)
}

/// The problem of this name, if there is one.
///
/// ```
/// use emitree_problems::catalogue::problem;
///
/// assert!(!problem("shock").unwrap().smooth);
/// assert!(problem("sun").is_none());
/// ```
pub fn problem(name: &str) -> Option<Problem> {
    problems().into_iter().find(|problem| problem.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brute;

    /// Images of smooth problems against quadrature of the rate, in an image that is not square:
    /// x is the column and y the row.
    #[test]
    fn smooth_images_agree_with_brute_force() {
        let shape = [50, 36];
        for problem in problems().iter().filter(|problem| problem.smooth) {
            let exact = problem.exact_image(shape);
            let (_, largest) = exact.min_max();
            for at in [[8, 18], [25, 17], [27, 9], [38, 7], [13, 22], [33, 25]] {
                let brute = brute::pixel(|position| problem.rate(position), shape, at, 10);
                let far = (exact[at.into()] - brute).abs() / largest;
                assert!(far < problem.image_error, "{} {at:?}: {far:e}", problem.name);
            }
        }
    }

    /// The means of 32 × 32 and of 16 × 16 lines differ by less than the bound.
    #[test]
    fn means_of_lines_are_within_their_bound() {
        let shape = [48, 48];
        let of_bar = bar().reference_image(shape).error;
        let of_balls = two_balls().reference_image(shape).error;
        for error in [of_balls, tube::reference_image(shape).error, of_bar] {
            assert!(error < IMAGE_ERROR_OF_LINES, "{error:e}");
        }
    }

    /// The mean over all pixels does not depend on how many there are.
    #[test]
    fn images_of_all_shapes_hold_the_same() {
        for problem in problems() {
            let mean = |shape: [usize; 2]| {
                let image = problem.exact_image(shape);
                image.pixels().iter().sum::<f64>() / image.pixels().len() as f64
            };
            let whole = mean([1, 1]);
            for shape in [[37, 53], [2, 128]] {
                let far = (mean(shape) - whole).abs() / whole;
                assert!(far < 10.0 * problem.image_error, "{}: {far:e}", problem.name);
            }
        }
    }
}
