//! The image plane: a tree of nodes, the errors that remain between them, and means over pixels.

pub(crate) mod block;
pub(crate) mod error_map;
pub(crate) mod nearest;
pub(crate) mod opening;
pub(crate) mod pixels;
pub(crate) mod remaining;
pub(crate) mod tree;

#[cfg(test)]
mod tests;
