//! The errors of a rendering.

use super::OptionError;
use crate::tree::BuildError;

/// A rendering that failed; `E` is the error of the emission model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError<E> {
    /// The image has no pixels.
    #[error("the image has {height} x {width} pixels (height x width): expected at least 1 x 1")]
    EmptyImage {
        /// Rows requested.
        height: usize,
        /// Columns requested.
        width: usize,
    },
    /// No pixel has a solid angle, or an area, that a radiance could be the mean over.
    #[error(
        "no pixel has a solid angle or an area that is a finite number above 0: expected a larger \
         `field_of_view` or `extent`"
    )]
    NoSolidAngle,
    /// The request does not fit in the memory allowed; nothing was allocated.
    #[error("{what} would take {} of memory: at most {} are allowed", bytes(*needed), bytes(*allowed))]
    TooLarge {
        /// The thing that is too large, with its size.
        what: String,
        /// The memory that it needs \[bytes\].
        needed: u64,
        /// The memory that is allowed \[bytes\].
        allowed: u64,
    },
    /// The image or the cube can't be made row by row; nothing of its size was allocated.
    #[error(
        "{} x {} pixels (height x width) can't be made row by row: {reason}: expected an emission \
         with a low-rank approximation{}",
        shape[0], shape[1], or_as_a_whole(*shape, *fits)
    )]
    NotByRows {
        /// Why not.
        reason: String,
        /// The height and width requested.
        shape: [usize; 2],
        /// The height and width of the largest image of these proportions that fits in the memory.
        fits: [usize; 2],
    },
    /// An option is outside its range, or has no effect.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// The tree can't be built with these options.
    #[error(transparent)]
    Build(BuildError<core::convert::Infallible>),
    /// The budget does not suffice for the coarsest image of the method.
    #[error("`max_evaluations` allows {allowed} evaluations, but {what} needs {needed}")]
    Budget {
        /// The smallest possible sampling.
        what: String,
        /// The evaluations that it needs.
        needed: u64,
        /// The evaluations allowed.
        allowed: u64,
    },
    /// The time ended before the method had an image.
    #[error(
        "`max_seconds` is {seconds}: the time ended before there was an image: expected more time, fewer \
         pixels or lines, or the method `vol`, which has a coarse image early"
    )]
    Time {
        /// The time allowed \[s\].
        seconds: f64,
    },
    /// g returned NaN or an infinite value.
    #[error(
        "the emission rate is {rate:e} at position {position:?}, emission direction {direction:?}{}: \
         expected a finite number, along the line of sight too{}",
        energy.map(|energy| format!(", energy {energy}")).unwrap_or_default(),
        if rate.is_infinite() { " (where g is singular, declare a singularity)" } else { "" }
    )]
    NotFinite {
        /// The value returned.
        rate: f64,
        /// Where, in world coordinates and the scene's length unit.
        position: [f64; 3],
        /// The unit vector of emission.
        direction: [f64; 3],
        /// The energy, in the unit of the energy axis, if there is one.
        energy: Option<f64>,
    },
    /// The absorption coefficient is NaN or infinite.
    #[error(
        "the absorption coefficient is {coefficient:e} at position {position:?}, emission direction \
         {direction:?}{}: expected a finite number",
        energy.map(|energy| format!(", energy {energy}")).unwrap_or_default()
    )]
    AbsorptionNotFinite {
        /// The value returned.
        coefficient: f64,
        /// Where, in world coordinates and the scene's length unit.
        position: [f64; 3],
        /// The unit vector of emission.
        direction: [f64; 3],
        /// The energy, in the unit of the energy axis, if there is one.
        energy: Option<f64>,
    },
    /// The rates are finite, but so large that a pixel's sum is not.
    #[error("the image is {value} in row {row}, column {column}: expected smaller emission rates")]
    ImageNotFinite {
        /// The row, from the lowest.
        row: usize,
        /// The column.
        column: usize,
        /// The value of the pixel.
        value: f64,
    },
    /// The number of rates is not that of the requested points.
    #[error("{number} rates were given: expected {expected}")]
    Rates {
        /// The number of rates given.
        number: usize,
        /// How many were expected.
        expected: String,
    },
    /// The emission model failed.
    #[error("the emission model failed: {0}")]
    Emission(#[source] E),
    /// A callback ended the rendering.
    #[error("the rendering was interrupted")]
    Interrupted,
}

impl<E> RenderError<E> {
    /// The same with another error of the emission.
    ///
    /// ```
    /// use emitree::RenderError;
    ///
    /// let error = RenderError::Emission("no file".to_owned());
    /// assert_eq!(error.map_emission(|error| error.len()), RenderError::Emission(7));
    /// ```
    pub fn map_emission<F>(self, of_emission: impl FnOnce(E) -> F) -> RenderError<F> {
        self.with_emission_error(|error| Some(of_emission(error)))
    }

    /// The same with the error of another emission; an interruption if there is none.
    pub(crate) fn with_emission_error<F>(
        self,
        of_emission: impl FnOnce(E) -> Option<F>,
    ) -> RenderError<F> {
        match self {
            Self::Emission(error) => match of_emission(error) {
                Some(error) => RenderError::Emission(error),
                None => RenderError::Interrupted,
            },
            Self::EmptyImage { height, width } => RenderError::EmptyImage { height, width },
            Self::NoSolidAngle => RenderError::NoSolidAngle,
            Self::TooLarge { what, needed, allowed } => {
                RenderError::TooLarge { what, needed, allowed }
            }
            Self::NotByRows { reason, shape, fits } => {
                RenderError::NotByRows { reason, shape, fits }
            }
            Self::Option(error) => RenderError::Option(error),
            Self::Build(error) => RenderError::Build(error),
            Self::Budget { what, needed, allowed } => RenderError::Budget { what, needed, allowed },
            Self::Time { seconds } => RenderError::Time { seconds },
            Self::NotFinite { rate, position, direction, energy } => {
                RenderError::NotFinite { rate, position, direction, energy }
            }
            Self::AbsorptionNotFinite { coefficient, position, direction, energy } => {
                RenderError::AbsorptionNotFinite { coefficient, position, direction, energy }
            }
            Self::ImageNotFinite { row, column, value } => {
                RenderError::ImageNotFinite { row, column, value }
            }
            Self::Rates { number, expected } => RenderError::Rates { number, expected },
            Self::Interrupted => RenderError::Interrupted,
        }
    }
}

impl<E> From<BuildError<Self>> for RenderError<E> {
    fn from(error: BuildError<Self>) -> Self {
        match error {
            BuildError::Integrand(error) => error,
            BuildError::Order(order) => Self::Build(BuildError::Order(order)),
            BuildError::BaseLevel { level, deepest } => {
                Self::Build(BuildError::BaseLevel { level, deepest })
            }
            BuildError::FinestLevel { level, base_level, deepest } => {
                Self::Build(BuildError::FinestLevel { level, base_level, deepest })
            }
            BuildError::Threshold(threshold) => Self::Build(BuildError::Threshold(threshold)),
            BuildError::BudgetBelowBase { needed, left, level } => Self::Budget {
                what: format!("the base grid of level {level}"),
                needed,
                allowed: left,
            },
        }
    }
}

/// A number of bytes as text: "1.5 GiB".
fn bytes(count: u64) -> String {
    let units = ["bytes", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"];
    let power = (count.max(1).ilog2() / 10) as usize;
    if power == 0 {
        return format!("{count} bytes");
    }
    let mut scaled = count;
    // Tenths are enough, and integers up to here keep huge counts exact.
    for _ in 1..power {
        scaled /= 1024;
    }
    format!("{:.1} {}", scaled as f64 / 1024.0, units[power])
}

/// What else is possible: the image as a whole, if one of so many pixels fits in the memory.
fn or_as_a_whole(shape: [usize; 2], fits: [usize; 2]) -> String {
    if shape == fits {
        return ", or all of it at once, which fits in the memory".to_owned();
    }
    format!(", or at most {} x {} pixels, which fit in the memory as a whole", fits[0], fits[1])
}
