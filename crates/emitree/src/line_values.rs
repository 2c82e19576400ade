//! Radiances of lines of sight at places of the image plane, as a result of a rendering.

/// The radiances along lines of sight of an image, at the places that
/// [`VolOptions::with_lines`](crate::VolOptions::with_lines) names, in their order.
///
/// They follow from what the image is made of, without further evaluations of g: from products and image trees in the
/// charts of bodies, up to their limbs, and from found surfaces, beside jumps.
///
/// ```
/// use emitree::{Canonical, FromFn, RenderOptions, VolOptions, render};
///
/// let ball = FromFn(|[x, y, z]: [f64; 3], _| {
///     let square = (x - 0.5).powi(2) + (y - 0.5).powi(2) + (z - 0.5).powi(2);
///     if square < 0.09 { 1.0 } else { 0.0 }
/// });
/// let options = VolOptions::new(0.01).with_lines([[0.5, 0.5], [0.5, 0.74]]);
/// let found = render(&ball, &Canonical, [32, 32], &RenderOptions::new(options))?;
/// let lines = found.lines.ok_or("lines")?;
/// for ((value, error), chord) in lines.values.iter().zip(&lines.errors).zip([0.6, 0.36]) {
///     assert!((value - chord).abs() <= *error);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct LineValues {
    /// The radiance along each line, in the unit of g times the length unit of the scene; 0 where it is not known.
    pub values: Vec<f64>,
    /// The estimated |error| of each; infinite where the radiance is not known.
    pub errors: Vec<f64>,
}

impl LineValues {
    /// Nothing is known of `count` lines.
    pub(crate) fn unknown(count: usize) -> Self {
        Self { values: vec![0.0; count], errors: vec![f64::INFINITY; count] }
    }

    /// Sets the radiance of a line and its error, if they are finite.
    pub(crate) fn set(&mut self, line: usize, [value, error]: [f64; 2]) {
        if value.is_finite() && error.is_finite() {
            (self.values[line], self.errors[line]) = (value, error);
        }
    }

    /// The number of lines.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there is no line.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }
}
