//! The tests of the crate's public interface, but those that count the allocations of a process.
//!
//! One binary, since each one links the whole library, and its tests share the processors.

mod absorption;
mod analytic;
mod cameras;
mod documents;
mod found_surfaces;
mod large;
mod large_divided;
mod limits;
mod lines;
mod mesh;
mod mesh_of_lines;
mod mesh_start;
mod minimize;
mod occulters;
mod options;
mod paper;
mod paper_cube;
mod planes;
mod session;
mod sweep;
mod vol;
mod vol_bounds;
mod vol_by_pixel;
mod vol_cube;
mod vol_family;
mod vol_jumps;
mod vol_planets;
mod vol_rooms;
mod vol_shapes;
mod vol_singular;
mod vol_smile;
mod vol_solids;
mod vol_sums;
mod vol_views;
mod vol_wires;
mod world_tree;
