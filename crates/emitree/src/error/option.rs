//! Options that are refused.

/// An option that is out of range, or that the method does not use; each variant has the value given.
///
/// ```
/// use emitree::error::OptionError;
/// use emitree::{Canonical, FromFn, RenderError, RenderOptions, VolOptions, render};
///
/// let glow = FromFn(|_: [f64; 3], _: [f64; 3]| 1.0);
/// let options = RenderOptions::new(VolOptions::new(2.0));
/// let error = render(&glow, &Canonical, [8, 8], &options).err();
/// assert_eq!(error, Some(RenderError::Option(OptionError::Tolerance(2.0))));
/// assert_eq!(
///     OptionError::Tolerance(2.0).to_string(),
///     "`tolerance` is 2: expected a fraction above 0 and below 1"
/// );
/// ```
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OptionError {
    /// A tolerance of method `vol`, or of a tree in the world, that is no fraction.
    #[error("`tolerance` is {0}: expected a fraction above 0 and below 1")]
    Tolerance(f64),
    /// A relative tolerance by pixel that is no fraction, or 0 without an absolute one.
    #[error("`rtol` is {0}: expected a fraction above 0 and below 1, or 0 with `atol` above 0")]
    RelativeTolerance(f64),
    /// An absolute tolerance by pixel that is not finite or below 0.
    #[error("`atol` is {0}: expected a finite error of 0 or more, in the unit of the image")]
    AbsoluteTolerance(f64),
    /// A floor of relative tolerances that is no fraction.
    #[error("`floor` is {0}: expected a fraction of the largest pixel from 0 to below 1")]
    Floor(f64),
    /// Weights of pixels in another shape than the image.
    #[error(
        "`weights` have the shape ({}, {}): expected ({}, {}), a weight for each pixel", given[0],
        given[1], expected[0], expected[1]
    )]
    WeightsShape {
        /// Height and width of the weights.
        given: [usize; 2],
        /// Height and width of the image.
        expected: [usize; 2],
    },
    /// A weight that is not finite or below 0.
    #[error(
        "`weights` has {weight} in row {row}, column {column}: expected finite weights of 0 or more"
    )]
    Weight {
        /// The weight.
        weight: f64,
        /// Its row, from the lowest.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// A fixed mesh without functions of all parts of the view.
    #[error(
        "the fixed mesh has neither products nor lines for some part of the view: expected the mesh of a \
         rendering of this view by method vol or los with the same options, or a rendering that may add points"
    )]
    FixedMesh,
    /// Weights that are all 0.
    #[error("`weights` are 0 in all pixels: expected a pixel that matters")]
    NoWeights,
    /// Tolerances by band without an energy axis.
    #[error("`per_band` is given without an energy axis: expected an energy axis")]
    PerBand,
    /// A tolerance of adaptive steps that is not above 0.
    #[error("`tolerance` is {0}: expected a number above 0")]
    StepTolerance(f64),
    /// A base level that method `vol` does not have.
    #[error("`base_level` is {level}: expected {} to {}", expected[0], expected[1])]
    BaseLevel {
        /// The level given.
        level: u8,
        /// The coarsest and the finest level that there are.
        expected: [u8; 2],
    },
    /// A base level that a tree in the world can't have.
    #[error("`base_level` is {0}: expected a level from 3 to 10")]
    WorldTreeBaseLevel(u8),
    /// An order of prediction that a tree in the world does not have.
    #[error("`order` is {0}: expected 3, 5 or 7")]
    WorldTreeOrder(usize),
    /// No line of sight for each pixel.
    #[error("`lines` is {0}: expected 1 or more lines along each side of a pixel")]
    Lines(usize),
    /// No step along each line of sight.
    #[error("`steps` is {0}: expected 1 or more steps along each line")]
    Steps(usize),
    /// A sum without a name, or with that of a former one; its number, from 0.
    #[error(
        "`sums[{0}]` has no name of its own: expected names that differ, of one letter or more"
    )]
    SumName(usize),
    /// The weights of a sum, for an image of another shape.
    #[error(
        "`sums[{sum}]` has {} rows of {} weights: expected those of the image, {} rows of {}",
        given[0], given[1], expected[0], expected[1]
    )]
    SumShape {
        /// The number of the sum, from 0.
        sum: usize,
        /// Height and width of the weights.
        given: [usize; 2],
        /// Height and width of the image.
        expected: [usize; 2],
    },
    /// A weight of a sum that is not a finite number.
    #[error(
        "`sums[{sum}]` has the weight {weight} in row {row}, column {column}: expected a finite number"
    )]
    SumWeight {
        /// The number of the sum, from 0.
        sum: usize,
        /// The weight.
        weight: f64,
        /// Its row, from 0.
        row: usize,
        /// Its column, from 0.
        column: usize,
    },
    /// A sum over no pixel; its number, from 0.
    #[error("`sums[{0}]` is empty: expected a pixel of the image in the region")]
    EmptySum(usize),
    /// A mean over weights that add up to 0; its number, from 0.
    #[error("`sums[{0}]` is a mean, and its weights add up to 0: expected another sum of weights")]
    MeanOfNothing(usize),
    /// A tolerance of a sum that can't be met.
    #[error(
        "`sums[{sum}]` has the tolerance {rtol} and the absolute tolerance {atol}: expected a relative \
         error from 0 to below 1 and an absolute one of 0 or more, one of them above 0"
    )]
    SumTolerance {
        /// The number of the sum, from 0.
        sum: usize,
        /// The relative error.
        rtol: f64,
        /// The absolute error.
        atol: f64,
    },
    /// The size of the smallest feature is no fraction of the view.
    #[error("`smallest_feature` is {0}: expected a fraction of the view's cube above 0, at most 1")]
    FeatureFraction(f64),
    /// The size of the smallest feature is no length.
    #[error("`smallest_feature` is {0}: expected a finite length above 0")]
    FeatureLength(f64),
    /// The size of the smallest feature is a length, and the view has no volume to compare it with.
    #[error(
        "`smallest_feature` is {0}: expected a fraction of the view's cube, as the volume in view is \
         not finite"
    )]
    FeatureLengthOfInfiniteView(f64),
    /// A seed whose position is not finite.
    #[error(
        "`seed.position` is Seed {{ position: {position:?}, radius: {radius:?} }}: expected three \
         finite coordinates"
    )]
    SeedPosition {
        /// The position, in the scene's length unit.
        position: [f64; 3],
        /// The radius, in the same unit.
        radius: f64,
    },
    /// A seed whose radius is not a finite length above 0.
    #[error(
        "`seed.radius` is Seed {{ position: {position:?}, radius: {radius:?} }}: expected a finite \
         length above 0"
    )]
    SeedRadius {
        /// The position, in the scene's length unit.
        position: [f64; 3],
        /// The radius, in the same unit.
        radius: f64,
    },
    /// Energies of spectral lines without an energy axis.
    #[error("`line_energies` are given without an energy axis: expected none, or an energy axis")]
    LineEnergies,
    /// A callback for intermediate images, and a method that has none, by its name.
    #[error(
        "`frame` is given, and method `{0}` has no intermediate images: expected none, or method `vol`"
    )]
    Frame(&'static str),
    /// A callback, by its name, and a session, which calls none.
    #[error("`{0}` is given, and a session calls no callbacks: expected none")]
    CallbackOfSession(&'static str),
    /// A batch without evaluations.
    #[error("`batch_size` is {0}: expected 1 or more evaluations in a batch")]
    BatchSize(u64),
    /// No rounds.
    #[error("`rounds` is {0}: expected 1 or more rounds")]
    Rounds(u32),
    /// A limit on the time that is not above 0 \[s\].
    #[error("`max_seconds` is {0}: expected a time in seconds above 0")]
    MaxSeconds(f64),
    /// More columns than an image can have.
    #[error("`width` is {0}: expected at most 2^24 pixels along an axis")]
    Width(usize),
    /// More rows than an image can have.
    #[error("`height` is {0}: expected at most 2^24 pixels along an axis")]
    Height(usize),
    /// A number of rows that the tiles of a projection do not share equally.
    #[error("`height` is {0}: expected as many rows for each tile of the projection")]
    RowsOfTiles(usize),
}

impl OptionError {
    /// The option, as scenes name it.
    ///
    /// ```
    /// use emitree::error::OptionError;
    ///
    /// assert_eq!(OptionError::MaxSeconds(0.0).name(), "max_seconds");
    /// ```
    pub fn name(&self) -> &'static str {
        match self {
            Self::Tolerance(_) | Self::StepTolerance(_) => "tolerance",
            Self::RelativeTolerance(_) => "rtol",
            Self::AbsoluteTolerance(_) => "atol",
            Self::Floor(_) => "floor",
            Self::WeightsShape { .. } | Self::Weight { .. } | Self::NoWeights => "weights",
            Self::SumName(_)
            | Self::SumShape { .. }
            | Self::SumWeight { .. }
            | Self::EmptySum(_)
            | Self::MeanOfNothing(_)
            | Self::SumTolerance { .. } => "sums",
            Self::FixedMesh => "start",
            Self::PerBand => "per_band",
            Self::BaseLevel { .. } | Self::WorldTreeBaseLevel(_) => "base_level",
            Self::WorldTreeOrder(_) => "order",
            Self::Lines(_) => "lines",
            Self::Steps(_) => "steps",
            Self::FeatureFraction(_)
            | Self::FeatureLength(_)
            | Self::FeatureLengthOfInfiniteView(_) => "smallest_feature",
            Self::SeedPosition { .. } => "seed.position",
            Self::SeedRadius { .. } => "seed.radius",
            Self::LineEnergies => "line_energies",
            Self::Frame(_) => "frame",
            Self::CallbackOfSession(name) => name,
            Self::BatchSize(_) => "batch_size",
            Self::Rounds(_) => "rounds",
            Self::MaxSeconds(_) => "max_seconds",
            Self::Width(_) => "width",
            Self::Height(_) | Self::RowsOfTiles(_) => "height",
        }
    }
}
