//! Refinement: which cells are split, given their details.

/// The size below which a detail is dropped.
///
/// It bounds the details, **not** the error of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Threshold {
    /// In the units of the function that the tree represents.
    Absolute(f64),
    /// A fraction of the largest |cell average| so far in the build.
    Relative(f64),
}

impl Threshold {
    /// The threshold in the units of the function, when its largest |average| is `largest`.
    pub fn absolute(self, largest: f64) -> f64 {
        match self {
            Self::Absolute(threshold) => threshold,
            Self::Relative(fraction) => fraction * largest,
        }
    }
}

/// The size of a family's details: the largest |detail|.
pub(crate) fn detail_size(details: &[f64]) -> f64 {
    details.iter().fold(0.0, |largest: f64, detail| largest.max(detail.abs()))
}
