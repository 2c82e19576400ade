//! The parts of a [`Rendering`](crate::Rendering): the number of evaluations and how it ended, the
//! evaluations of each pixel, the tree or the surfaces behind an image.

pub use crate::found_surfaces::FoundSurfaces;
pub use crate::line_values::LineValues;
pub use crate::rendering::{RateAt, RenderStats, RenderedTree};
pub use crate::tally::EvaluationCounts;
pub use crate::values::Values;
