//! Depth rules: a few depths that integrate all lines of a block of the image.

mod contradicted;
pub(crate) mod depth_rule;
mod given;
pub(crate) mod plan;
mod round;
pub(crate) mod scan;

#[cfg(test)]
mod tests;
