//! The places at which patches are checked, and the edges between those of a wall.

use crate::projection::vector::{along, difference, norm};
use crate::vol::lattice;
use crate::vol::surfaces::octree::{Facet, is_smooth, region};
use crate::vol::surfaces::patch::{FitPoint, Patch};
use crate::vol::surfaces::points::PointIndex;
use crate::vol::surfaces::search::{OpenCell, Search};
use crate::vol::tuning::TUNING;

/// The places of a patch, or of it on a face, among which the one furthest from all points is checked; the distance,
/// in sizes of the cell, below which a place is near to a point; and that from a face of the places on it.
const PLACES: usize = 24;
const NEAR: f64 = 0.15;
const BESIDE_FACE: f64 = 0.02;

/// A point of a wall, and a step upwards from there in which the height above it rises by 1.
type Foot = ([f64; 3], [f64; 3]);

impl Search<'_> {
    /// The points on both sides of the patches of cells at which they are checked, with the numbers
    /// of the cells.
    pub(super) fn places_of_checks(&self, cells: &[OpenCell]) -> Vec<(usize, [f64; 3])> {
        let mut places = Vec::new();
        let Some(level) = cells.first().map(|cell| cell.cell.0) else { return places };
        let index = PointIndex::new(self, self.grid.cell_size(level));
        for (number, cell) in cells.iter().enumerate().filter(|(_, cell)| cell.is_done) {
            let facets = cell.facets.as_deref().unwrap_or_default();
            let of_facet = |facet| self.points_of_checks(&index, cell, facets, facet);
            places.extend(facets.iter().flat_map(of_facet).map(|point| (number, point)));
        }
        places
    }

    /// The points on both sides of each patch of a facet where it is furthest from the points of surfaces in its cell,
    /// as far as lines of sight reach both and such places are not near. The same on each face of the cell that is at
    /// the border of the view, since there is no cell beyond it to be compared with, and at the edge between each two
    /// patches: beside it, a patch may be wrong that is good where its own points are.
    fn points_of_checks(
        &self,
        index: &PointIndex,
        cell: &OpenCell,
        facets: &[Facet],
        facet: &Facet,
    ) -> Vec<[f64; 3]> {
        let pair = (facet.below.min(facet.above), facet.below.max(facet.above));
        let known = index.near(self, pair, self.grid.centre(cell.cell), 1);
        let furthest = |face: Option<(usize, bool)>, foot: &dyn Fn([f64; 3]) -> Option<Foot>| {
            let places = (0..PLACES).map(lattice::point).map(|mut u| {
                if let Some((axis, is_upper)) = face {
                    u[axis] = if is_upper { 1.0 - BESIDE_FACE } else { BESIDE_FACE };
                }
                core::array::from_fn(|k| f64::from(cell.cell.1[k]) + u[k])
            });
            let feet = places.filter_map(|place| foot(self.grid.point(cell.cell.0, place)));
            let checks = feet.filter_map(|foot| self.check_at(cell, (facets, facet), &known, foot));
            checks.reduce(|a, b| if b.0 > a.0 { b } else { a }).map(|(_, points)| points)
        };
        let patches = facet.wall.patches();
        let mut found = Vec::new();
        for patch in patches {
            let foot = |at| Some(foot(patch, at));
            found.extend(furthest(None, &foot));
            let faces = self.grid.faces_at_border(cell.cell);
            found.extend(faces.filter_map(|face| furthest(Some(face), &foot)));
        }
        let pairs = (0..patches.len()).flat_map(|i| (0..i).map(move |j| (j, i)));
        found.extend(pairs.filter_map(|pair| furthest(None, &|at| facet.wall.edge(pair, at))));
        found.into_iter().flatten().collect()
    }

    /// The points on both sides of a wall at a point of it, with its distance from all known points.
    fn check_at(
        &self,
        cell: &OpenCell,
        (facets, facet): (&[Facet], &Facet),
        known: &[FitPoint],
        (foot, upward): Foot,
    ) -> Option<(f64, [[f64; 3]; 2])> {
        // An error that is larger than its estimate is that of a fit which does not know a part of the cell.
        let [least, most] = [TUNING.surfaces.check_least, TUNING.surfaces.check_distance];
        let distance = TUNING.surfaces.check_errors * facet.error;
        let distance = distance.clamp(least * facet.allowed, most * facet.allowed);
        let (level, at) = cell.cell;
        let edges = self.grid.cell_edges(level);
        let is_inside = (0..3).all(|k| {
            let along = foot[k] / edges[k] - f64::from(at[k]);
            (-0.02..=1.02).contains(&along)
        });
        let is_seen = |at: &[f64; 3]| self.grid.contains(*at) && !self.hides(*at);
        let beside =
            |distance: f64| [-distance, distance].map(|along_it| along(foot, along_it, upward));
        let points = beside(distance);
        if !(is_inside && points.iter().all(is_seen)) {
            return None;
        }
        if !is_smooth(facets) {
            let regions = beside(2.0 * facet.allowed).map(|at| region(facets, at).0);
            if regions != [facet.below, facet.above] {
                return None;
            }
        }
        let from = |point: &FitPoint| norm(difference(point.at, foot));
        let nearest = known.iter().map(from).fold(f64::INFINITY, f64::min);
        (nearest > NEAR * self.grid.cell_size(level)).then_some((nearest, points))
    }
}

/// The point of a patch below or above a point.
fn foot(patch: &Patch, at: [f64; 3]) -> Foot {
    let foot = patch.foot(at);
    (foot, patch.normal(foot))
}
