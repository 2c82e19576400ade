//! Callbacks while a rendering is made: the number of evaluations, and the image so far.

use crate::image::Image;
use core::ops::ControlFlow;

/// A callback with the number of evaluations so far, which may end the rendering.
pub type Progress<'a> = dyn Fn(u64) -> ControlFlow<()> + Sync + 'a;

/// An intermediate image, after one step of a rendering.
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

/// A callback with an intermediate image, which may end the rendering.
pub type FrameCallback<'a> = dyn Fn(&Frame<'_>) -> ControlFlow<()> + Sync + 'a;
