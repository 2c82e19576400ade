//! The parts of a [`Rendering`](crate::Rendering): the number of evaluations and how it ended, the
//! evaluations of each pixel, the tree behind an image.

pub use crate::rendering::{RenderStats, RenderedTree, Values};
pub use crate::tally::EvaluationCounts;
