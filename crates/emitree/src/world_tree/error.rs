//! What can go wrong in building a tree in the world.

use crate::error::RenderError;

/// A tree in the world that can't be built; `E` is the error of the emission model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorldTreeError<E> {
    /// An option is out of range, or the emission failed: as in a rendering.
    #[error(transparent)]
    Render(#[from] RenderError<E>),
    /// The emission is not the same in all directions.
    #[error(
        "the emission rate at position {position:?} is {} towards {:?} and {} towards {:?}: \
         expected the same in all directions, a tree of positions has only one",
        rates[0], directions[0], rates[1], directions[1]
    )]
    Directional {
        /// Where, in world coordinates and the scene's length unit.
        position: [f64; 3],
        /// The two unit vectors of emission.
        directions: [[f64; 3]; 2],
        /// The rates in these directions.
        rates: [f64; 2],
    },
}
