//! A rendering of a view against the truth.

use crate::family::Reference;
use emitree::{Image, Rendering};

/// What rounding may leave below 0, relative to the largest pixel.
const ROUNDING: f64 = 1e-12;

/// How good the rendering of a view is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// The largest error, relative to the largest pixel; infinite if a pixel is NaN that has an image.
    pub error: f64,
    /// The row and the column of its pixel.
    pub worst: (usize, usize),
    /// Whether a pixel is below minus its own estimate.
    pub is_negative: bool,
}

impl Outcome {
    /// Compares a rendering with the reference image of its view. Pixels without an image, NaN in the
    /// reference, are left out.
    ///
    /// ```
    /// use emitree::{FromFn, RenderOptions, VolOptions, render};
    /// use emitree_problems::views::{Outcome, random_view};
    ///
    /// let view = random_view(4);
    /// let options = RenderOptions::new(VolOptions::default());
    /// let emission = FromFn(|position, _| view.rate(position));
    /// let rendering = render(&emission, view.camera(), view.shape(), &options)?;
    /// let outcome = Outcome::of(&rendering, &view.reference());
    /// assert!(outcome.error < 0.01 && !outcome.is_negative);
    /// # Ok::<(), emitree::RenderError<std::convert::Infallible>>(())
    /// ```
    pub fn of(rendering: &Rendering, reference: &Reference) -> Self {
        let exact = reference.image.pixels();
        let largest = exact.iter().fold(0.0, |m: f64, p| m.max(p.abs()));
        let errors = rendering.values.pixels().iter().zip(exact).map(|(a, b)| (a - b).abs());
        let (mut error, mut pixel) = (0.0, 0);
        for (k, difference) in errors.enumerate().filter(|(k, _)| !exact[*k].is_nan()) {
            if difference > error || difference.is_nan() {
                (error, pixel) = (if difference.is_nan() { f64::INFINITY } else { difference }, k);
            }
        }
        let estimates = rendering.error.iter().flat_map(Image::pixels);
        let mut pairs = rendering.values.pixels().iter().zip(estimates);
        let is_negative = pairs.any(|(value, estimate)| *value < -estimate - ROUNDING * largest);
        let worst = (pixel / rendering.values.width(), pixel % rendering.values.width());
        Self { error: error / largest, worst, is_negative }
    }
}
