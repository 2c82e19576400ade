//! The layers of a view: their coverage fractions in each pixel, and the image tree of each.

pub(crate) mod closed;
pub(crate) mod verification;
mod verification_lines;
pub(crate) mod fractions;
pub(crate) mod scattered;
pub(crate) mod sheet;
pub(crate) mod visible;

#[cfg(test)]
mod tests;
