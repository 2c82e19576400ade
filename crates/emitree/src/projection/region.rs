//! Regions of the image plane, between which the view is not smooth.

/// The part of the view at a point of the image plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Region {
    /// Nothing: the point belongs to no image.
    Outside,
    /// A line of sight through all of the view's depth.
    Sky,
    /// A line of sight that ends at an opaque body, by its number in the order given.
    Body(usize),
}
