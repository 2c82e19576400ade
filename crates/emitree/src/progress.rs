//! Callbacks while a rendering is made: the number of evaluations, and the image so far.

use crate::image::Image;
use core::ops::ControlFlow;

/// Hears how many evaluations have been made so far, and may end the rendering.
pub type Progress<'a> = dyn Fn(u64) -> ControlFlow<()> + Sync + 'a;

/// An image on the way: what a rendering has after one of its steps.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Frame<'a> {
    /// The image so far, in the unit of the final one.
    pub image: &'a Image,
    /// The estimated |error| of each pixel of it.
    pub error: &'a Image,
    /// Evaluations of g so far.
    pub evaluations: u64,
    /// Batches of evaluations so far.
    pub batches: u64,
}

/// Sees the image on the way, and may end the rendering.
pub type FrameCallback<'a> = dyn Fn(&Frame<'_>) -> ControlFlow<()> + Sync + 'a;
