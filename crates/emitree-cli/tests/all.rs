//! The tests of the command.
//!
//! One binary, since each one links the whole library, and its tests share the processors.

mod absorption;
mod build;
mod by_rows;
mod cameras;
mod command;
mod compare;
mod components;
mod energy;
mod failures;
mod fields;
mod gallery;
mod grid;
mod instrument;
mod mutated_files;
mod mutated_scenes;
mod plan;
mod robustness;
mod start;
mod support;
mod surfaces;
mod sweep;
mod time;
