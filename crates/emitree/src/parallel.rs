//! The parallel loops of this crate: those of rayon or, without the feature `rayon`, the same loops
//! in the calling thread.
//!
//! Results do not depend on the number of threads, so they have the same bits either way.

#[cfg(not(feature = "rayon"))]
mod serial;

#[cfg(feature = "rayon")]
pub(crate) use rayon::{current_num_threads, prelude};
#[cfg(not(feature = "rayon"))]
pub(crate) use serial::{current_num_threads, prelude};
