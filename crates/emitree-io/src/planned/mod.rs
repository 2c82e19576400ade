//! A rendering whose rates another program makes, by files: points out, rates in, and a state between.
//!
//! The [`PlannedRun`] of a scene has the points at which rates are needed; a [`PointsFormat`] writes them, and
//! [`read_rates`](PlannedRun::read_rates) reads what a program makes of them. The bytes of its
//! [`state`](PlannedRun::state) continue it in another process.
//!
//! The files of this module: `points.rs` are points and how they are written, `rates.rs` reads rates, `state.rs` is
//! the file of a state, `changes.rs` what of a scene may change, `run.rs` the run, `error.rs` what can be wrong.

mod changes;
mod error;
mod points;
mod rates;
mod run;
mod state;

pub use error::PlannedError;
pub use points::{PlannedPoints, PointsFormat};
pub use run::PlannedRun;

#[cfg(test)]
mod tests;
