//! Images of optically thin volume emissions, with as few evaluations as possible.
pub mod cell;
pub mod emission;
mod error;
pub mod image;
pub mod los;
mod meter;
pub mod prediction;
pub mod projection;
pub mod quadrature;
pub mod refinement;
mod render;
pub mod tree;

pub use cell::CellIndex;
pub use emission::{Emission, FromFn, Samples};
pub use error::RenderError;
pub use image::Image;
pub use los::{LosOptions, Steps};
pub use meter::Progress;
pub use prediction::Predictor;
pub use projection::{
    Canonical, Equirectangular, GeometryError, MappedPoint, Projection, Viewpoint,
};
pub use refinement::Threshold;
pub use render::{
    DEFAULT_MAX_EVALUATIONS, Method, RenderOptions, Rendering, image_of_tree, render,
};
pub use tree::SparseTree;
