//! A line of sight relative to a centre or an axis.

/// A line of sight relative to the centre of shells; lengths are scaled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aim {
    /// The angle from the direction to the centre; for parallel lines the distance from the centre.
    pub(super) angle: f64,
    pub(super) azimuth: f64,
    /// The distance of the (infinite) line from the centre.
    pub(super) miss: f64,
    /// Whether the point nearest to the centre is ahead of the observer.
    pub(super) is_ahead: bool,
    /// The distance, in the world, at which the line is nearest to the centre.
    pub(super) nearest: f64,
    /// The scaled length of a unit of length along the line.
    pub(super) stretch: f64,
}
