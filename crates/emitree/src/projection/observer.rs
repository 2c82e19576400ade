//! Where lines of sight begin.

/// Where lines of sight begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Observer {
    /// All lines begin at one point.
    Point([f64; 3]),
    /// Lines along one direction begin on the plane across it through a point.
    Parallel { plane_point: [f64; 3], direction: [f64; 3] },
}
