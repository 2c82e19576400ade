//! Surfaces at which G jumps: found from samples, they become geometry.
//!
//! Where G is smooth on both sides of surfaces that nobody declares, neither products nor polynomials
//! along lines converge. The surfaces are therefore found first, as patches in the cells of an octree
//! in coordinates in which the cells are about cubes; G is represented by polynomials beside them; and
//! the image follows from both without further evaluations.
//!
//! * `columns`, `nearest`: least squares with leave-one-out errors, and what they are fitted to;
//! * `patch`: heights over a tangent plane; `wall`: patches that meet; `octree`: leaves with walls
//!   between regions;
//! * `buckets`: the nearest points; `samples`: samples of G, and the regions that their values belong to;
//! * `visible`: where lines of sight begin and end at bounds and opaque bodies; `sky`: views of several tiles, with a
//!   rim or with a pole; `lines_of_sight`: the view as one part; `hits`: samples of other charts, and other points, that meet a small shape;
//! * `aim`: the displacement of a patch that the tolerance allows;
//! * `roots`: points of surfaces on edges of cells;
//! * `focus`, `extent`: the part of the view that is not constant; `start`: the first samples;
//! * `target`: the error allowed in the first division into leaves;
//! * `search`, `inferred`, `edges`, `corners`, `bisection`, `regions`, `borders`, `cut_edges`, `points`, `facets`,
//!   `leaves`, `comparisons`, `faces`: the division into leaves: regions that follow from patches, edges up to bounds,
//!   whether G jumps between two points, regions of the base lattice, regions that are one, points of surfaces on edges,
//!   patches of cells, what becomes of a cell, the continuation of patches through faces;
//! * `polynomial`, `boxes`, `outline`, `missed`, `pieces`: G within each region, by polynomials in boxes around it, and
//!   surfaces that the first lattice has missed;
//! * `crossings`, `beam`, `rays`, `model`, `pixel`, `raster`: lines of sight, pixels and their errors;
//! * `displaced`, `lines`: requested lines, and what displaced surfaces change of them;
//! * `verification`: samples that took no part; `net`, `cut_net`, `found`: the surfaces as triangles in the world;
//!   `attempt`: all of it, with the decision;
//! * `look`, `steep_pairs`: whether G jumps where no search for products shows it;
//! * `channel`, `spectra`, `cube`: what further energies of a cube add beside the same surfaces.

mod columns;
mod nearest;
mod patch;
mod wall;
mod octree;
mod buckets;
mod samples;
mod visible;
mod sky;
mod aim;
mod roots;
mod points;
mod target;
mod search;
mod inferred;
mod edges;
mod corners;
mod cut_edges;
mod focus;
mod extent;
mod start;
mod bisection;
mod regions;
mod borders;
mod facets;
mod leaves;
mod checks;
mod comparisons;
mod faces;
mod polynomial;
mod boxes;
mod outline;
mod missed;
mod pieces;
mod crossings;
mod beam;
mod rays;
mod model;
mod pixel;
mod raster;
mod displaced;
mod lines;
mod verification;
mod net;
mod cut_net;
mod found;
mod attempt;
mod channel;
mod spectra;
mod cube;
mod render;
mod hits;
mod lines_of_sight;
mod steep_pairs;
mod look;

pub(crate) use hits::few_of_all;
pub(crate) use look::{look, look_beside_few};
pub(crate) use render::{FirstImage, render, render_cube};
