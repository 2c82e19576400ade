//! The parts of a view, the quadrature of pixels in their charts, and the image tree of each.

mod chart_nodes;
pub(crate) mod depths;
pub(crate) mod edges;
pub(crate) mod part;
mod pixel_rule;
mod raster;
pub(crate) mod scattered;
pub(crate) mod sheet;
pub(crate) mod verification;
mod verification_lines;

#[cfg(test)]
mod tests;
