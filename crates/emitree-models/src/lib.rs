//! Emission models for emitree: expressions parsed at run time, published models, and data on a grid.
//!
//! * [`Expression`]: g as a scene writes it, `"exp(-a*(x^2 + y^2 + z^2))"`, with named constants.
//! * [`build_model`]: a published model by its name, with named parameters; [`catalogue()`] lists
//!   what there is, with units, defaults and sources. Some have a spectrum, and
//!   [need energies](Model::needs_energy). Models of planets and of the Sun glow outside of
//!   the body, and leave it to the camera to make it opaque.
//! * [`means`]: of functions over intervals, for the exact image of a [model](models::Holmstrom) that
//!   has one.
//! * [`Grid`]: values at the nodes of a Cartesian, cylindrical or spherical grid, and interpolation in between.
//! * [`FieldExpression`]: an expression of several grids, and of [tables](table) as functions.
//!
//! Each is an [`Emission`](emitree::Emission), evaluated in batches, and cheap to share between
//! threads. The first two can't fail; a grid can be set to refuse positions outside, a table arguments.
//!
//! ```
//! use emitree::{Emission, Samples};
//! use emitree_models::build_model;
//! use std::collections::BTreeMap;
//!
//! let parameters = BTreeMap::from([("density".to_owned(), 8.0)]);
//! let magnetosheath = build_model("cmem", &parameters)?;
//! let mut rates = [0.0; 2];
//! let samples = Samples::new(&[[11.0, 0.0, 0.0], [5.0, 0.0, 0.0]], &[[0.0, 1.0, 0.0]; 2]);
//! magnetosheath.emission_rates(&samples, &mut rates)?;
//! assert!(rates[0] > 0.0); // between bow shock and magnetopause
//! assert_eq!(rates[1], 0.0); // inside the magnetopause
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod catalogue;
mod elementary;
pub mod expression;
pub mod grid;
pub mod means;
pub mod models;
mod scalar;
mod spelling;
pub mod table;

pub use catalogue::{
    DifferentiableModel, Model, ModelDescription, ModelError, build_model, catalogue,
};
pub use expression::{
    DifferentiableExpression, Expression, ExpressionError, FieldExpression, FieldFailure,
};
pub use grid::{Grid, GridError, Interpolation, Outside, OutsideGrid};

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
