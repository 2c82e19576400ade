//! The parts of a view, the quadrature of pixels in their charts, and the image tree of each.

mod chart_nodes;
mod corner_rule;
mod crossings;
pub(crate) mod depths;
pub(crate) mod division;
pub(crate) mod edges;
pub(crate) mod faces;
pub(crate) mod frozen;
mod line_scan;
pub(crate) mod lines;
pub(crate) mod part;
pub(crate) mod pixel_lattices;
pub(crate) mod pixel_rule;
pub(crate) mod products;
pub(crate) mod quadrature;
pub(crate) mod raster;
pub(crate) mod scattered;
mod refined_raster;
pub(crate) mod settle;
pub(crate) mod sheet;
mod squares;
pub(crate) mod tree_start;
pub(crate) mod verification;
mod verification_lines;
mod windows;

#[cfg(test)]
mod tests;
