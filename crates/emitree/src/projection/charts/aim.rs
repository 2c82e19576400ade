//! A line of sight relative to a centre or an axis.

/// A line of sight relative to the centre of shells; lengths are scaled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aim {
    pub(super) angle: Angle,
    pub(super) azimuth: Angle,
    /// The distance of the (infinite) line from the centre.
    pub(super) miss: f64,
    /// Whether the point nearest to the centre is ahead of the observer.
    pub(super) is_ahead: bool,
    /// The distance, in the world, at which the line is nearest to the centre.
    pub(super) nearest: f64,
    /// The scaled length of a unit of length along the line.
    pub(super) stretch: f64,
}

/// An angle. Most lines are only asked which zone they are in, and need none.
#[derive(Clone, Copy, Debug)]
pub(super) enum Angle {
    Known(f64),
    /// That of a point from the first axis.
    Of {
        across: f64,
        along: f64,
    },
}

impl Angle {
    fn value(self) -> f64 {
        match self {
            Self::Known(angle) => angle,
            Self::Of { across, along } => across.atan2(along),
        }
    }
}

impl Aim {
    /// The angle from the direction to the centre; for parallel lines the distance from the centre.
    pub(super) fn angle(&self) -> f64 {
        self.angle.value()
    }

    pub(super) fn azimuth(&self) -> f64 {
        self.azimuth.value()
    }
}
