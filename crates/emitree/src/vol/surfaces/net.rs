//! The surfaces as triangles: a vertex in each cell of a lattice through which a surface passes, and two
//! triangles for each edge that crosses it (surface nets: Gibson 1998, doi:10.1007/BFb0056277).
//!
//! The lattice is one for the whole view, so that triangles meet, whatever the sizes of the leaves are.
//! Vertices are moved onto the patches, so that they have the accuracy of these. A cell beyond the border of the
//! view, of no width, has a vertex on the border, so that surfaces end there.

use crate::parallel::prelude::*;
use crate::projection::vector::{along, difference, norm, unit};
use crate::vol::surfaces::octree::{Cell, Facet, HIDDEN, Label, Leaf, Octree};
use crate::vol::tuning::TUNING;
use rustc_hash::FxHashMap;

/// The cells that surfaces pass through, about: the lattice is the finest one with no more of them. It
/// decides neither the image nor the places of vertices.
const CELLS: f64 = 20_000.0;
/// The halvings of an edge that a surface crosses, before the vertex is moved onto its patch.
const HALVINGS: usize = 12;
/// The most moves onto a patch: where patches meet each one is towards another of them.
const MOVES: usize = 8;

/// A vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Vertex {
    pub(super) at: [f64; 3],
    /// The regions on both sides.
    pub(super) sides: [Label; 2],
    /// The unit normal, from the first to the second of them.
    pub(super) normal: [f64; 3],
    /// The expected displacement along the normal.
    pub(super) error: f64,
}

/// Vertices, and triangles of their numbers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Net {
    pub(super) vertices: Vec<Vertex>,
    /// The longest edge of a cell of the lattice.
    pub(super) cell_size: f64,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// An edge of the lattice that crosses a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct CrossedEdge {
    /// Its lower end.
    corner: [u32; 3],
    axis: usize,
    /// The regions at its lower and at its upper end.
    ends: [Label; 2],
}

impl CrossedEdge {
    /// The regions on both sides, the smaller label first.
    fn sides(&self) -> [Label; 2] {
        let [a, b] = self.ends;
        [a.min(b), a.max(b)]
    }

    /// The four cells around it, one after the other, in the numbers of a `Place`.
    fn cells_around(&self) -> [[u32; 3]; 4] {
        let (u, v) = ((self.axis + 1) % 3, (self.axis + 2) % 3);
        [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[below_u, below_v]| {
            let mut cell = self.corner.map(|k| k + 1);
            cell[u] -= below_u;
            cell[v] -= below_v;
            cell
        })
    }
}

/// What the edges of a cell say of a surface in it.
#[derive(Clone, Debug, Default)]
struct Crossings {
    sum: [f64; 3],
    count: f64,
    /// The sum of the directions from the first to the second region.
    direction: [f64; 3],
    /// The leaves in which they are.
    leaves: Vec<usize>,
}

/// A cell of the lattice, and the regions on both sides of a surface in it. The numbers of cells begin with 1: 0 is
/// the cell before the border of the view, and the one after the last is beyond the other border.
type Place = ([u32; 3], [Label; 2]);

impl Net {
    /// The net of all surfaces between leaves.
    pub(super) fn new(tree: &Octree) -> Self {
        let lattice = Lattice { tree, level: level(tree) };
        let edges = lattice.crossed_edges();
        let crossings: Vec<([f64; 3], usize)> =
            edges.par_iter().map(|edge| lattice.crossing(edge)).collect();
        let mut numbers: FxHashMap<Place, u32> = FxHashMap::default();
        let mut places: Vec<(Place, Crossings)> = Vec::new();
        let mut triangles = Vec::new();
        let mut quads = Vec::new();
        for (edge, (at, leaf)) in edges.iter().zip(crossings) {
            quads.push(edge.cells_around().map(|cell| {
                let place = (cell, edge.sides());
                let number = *numbers.entry(place).or_insert_with(|| {
                    places.push((place, Crossings::default()));
                    u32::try_from(places.len() - 1).unwrap_or(u32::MAX)
                });
                if let Some((_, found)) = places.get_mut(number as usize) {
                    found.sum = along(found.sum, 1.0, at);
                    found.count += 1.0;
                    let sign = if edge.ends[0] < edge.ends[1] { 1.0 } else { -1.0 };
                    found.direction[edge.axis] += sign;
                    if !found.leaves.contains(&leaf) {
                        found.leaves.push(leaf);
                    }
                }
                number
            }));
        }
        let vertices: Vec<Vertex> =
            places.par_iter().map(|(place, found)| lattice.vertex(*place, found)).collect();
        for [a, b, c, d] in quads {
            let place = |vertex: u32| vertices[vertex as usize].at;
            let length = |a: u32, b: u32| norm(difference(place(a), place(b)));
            let halves = if length(a, c) <= length(b, d) {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            };
            triangles.extend(halves);
        }
        Self { vertices, cell_size: tree.grid.cell_size(lattice.level), triangles }
    }
}

/// The level of the lattice.
fn level(tree: &Octree) -> u8 {
    let cells = |level: u8| {
        let cut = tree.leaves.iter().filter(|(_, leaf)| matches!(leaf, Leaf::Cut(_)));
        cut.map(|((of_leaf, _), _)| 4.0_f64.powi(i32::from(level) - i32::from(*of_leaf))).sum()
    };
    let is_small = |level: &u8| {
        let cells: f64 = cells(*level);
        cells <= CELLS
    };
    (0..=tree.grid.finest).rev().find(is_small).unwrap_or(0)
}

/// The lattice of a level.
#[derive(Clone, Copy)]
struct Lattice<'a> {
    tree: &'a Octree,
    level: u8,
}

impl Lattice<'_> {
    /// The number of cells along each axis.
    fn cells(&self) -> [u32; 3] {
        self.tree.grid.base.map(|cells| cells << self.level)
    }

    fn point(&self, corner: [u32; 3]) -> [f64; 3] {
        self.tree.grid.point(self.level, corner.map(f64::from))
    }

    /// The edges between corners in different regions, in ascending order.
    fn crossed_edges(&self) -> Vec<CrossedEdge> {
        let cut = self
            .tree
            .leaves
            .iter()
            .filter(|(_, leaf)| !matches!(leaf, Leaf::Uncut(_) | Leaf::Hidden));
        let cut: Vec<Cell> = cut.map(|(cell, _)| *cell).collect();
        let found = cut.par_iter().map(|cell| self.crossed_edges_near(*cell));
        let found: Vec<Vec<CrossedEdge>> = found.collect();
        let mut edges: Vec<CrossedEdge> = found.into_iter().flatten().collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// Those in a cell of the tree and next to it: patches of neighbours may be apart by their errors, and
    /// then a region ends in a cell of the lattice beside theirs.
    fn crossed_edges_near(&self, (level, at): Cell) -> Vec<CrossedEdge> {
        let ends = |k: usize| {
            let [low, high] = if level <= self.level {
                [at[k], at[k] + 1].map(|k| k << (self.level - level))
            } else {
                let low = at[k] >> (level - self.level);
                [low, low + 1]
            };
            [low.saturating_sub(1), (high + 1).min(self.cells()[k])]
        };
        let ends = [0, 1, 2].map(ends);
        let [nx, ny, nz] = ends.map(|[low, high]| (high - low + 1) as usize);
        let corner = |number: usize| {
            let place = [number / (ny * nz), number / nz % ny, number % nz];
            core::array::from_fn(|k| ends[k][0] + u32::try_from(place[k]).unwrap_or(0))
        };
        let labels: Vec<Label> = (0..nx * ny * nz)
            .map(|number| {
                let point = self.point(corner(number));
                self.tree.leaf(point).region(point)
            })
            .collect();
        let mut found = Vec::new();
        for (number, label) in labels.iter().enumerate() {
            let corner = corner(number);
            for (axis, step) in [ny * nz, nz, 1].into_iter().enumerate() {
                if corner[axis] == ends[axis][1] {
                    continue;
                }
                let ends = [*label, labels[number + step]];
                if ends[0] != ends[1] && !ends.contains(&HIDDEN) {
                    found.push(CrossedEdge { corner, axis, ends });
                }
            }
        }
        found
    }

    /// Where an edge crosses the surface, and the leaf there.
    fn crossing(&self, edge: &CrossedEdge) -> ([f64; 3], usize) {
        let mut ends = [edge.corner; 2];
        ends[1][edge.axis] += 1;
        let [mut low, mut high] = ends.map(|corner| self.point(corner));
        for _ in 0..HALVINGS {
            let middle = middle(low, high);
            let is_low = self.tree.leaf(middle).region(middle) == edge.ends[0];
            (low, high) = if is_low { (middle, high) } else { (low, middle) };
        }
        let at = middle(low, high);
        (at, self.tree.find(at))
    }

    /// The vertex of a cell: the mean of its crossings, moved onto the nearest wall between its regions; on the
    /// border of the view for a cell beyond it.
    fn vertex(&self, (cell, sides): Place, found: &Crossings) -> Vertex {
        let mean = found.sum.map(|sum| sum / found.count.max(1.0));
        let size = self.tree.grid.cell_size(self.level);
        let facets = |leaf: usize| match &self.tree.leaves[leaf].1 {
            Leaf::Cut(facets) => &facets[..],
            Leaf::Uncut(_) | Leaf::Unresolved(..) | Leaf::Hidden => &[],
        };
        let between = |of: &&Facet| sides.contains(&of.below) && sides.contains(&of.above);
        // The patches of other leaves are continued to this place.
        let own = self.tree.find(mean);
        let has_own = facets(own).iter().any(|of| between(&of));
        let leaves = if has_own { &[own][..] } else { &found.leaves[..] };
        let walls = leaves.iter().flat_map(|leaf| facets(*leaf)).filter(between);
        let walls = walls.map(|of| (of, of.wall.above(mean).abs()));
        let Some((facet, _)) = walls.min_by(|a, b| a.1.total_cmp(&b.1)) else {
            // The place of the surface in its leaf is not known.
            let normal = unit(found.direction).unwrap_or([0.0, 0.0, 1.0]);
            let sizes =
                leaves.iter().map(|leaf| self.tree.grid.cell_size(self.tree.leaves[*leaf].0.0));
            let error = 0.5 * sizes.fold(size, f64::max);
            return Vertex { at: mean, sides, normal, error };
        };
        let mut at = mean;
        for _ in 0..MOVES {
            at = facet.wall.patch_at(at).foot(at);
            for k in (0..3).filter(|&k| cell[k] == 0 || cell[k] > self.cells()[k]) {
                at[k] = mean[k];
            }
        }
        if norm(difference(at, mean)) > size {
            at = mean;
        }
        let normal = facet.wall.normal(at);
        let normal = if facet.below == sides[0] { normal } else { normal.map(|x| -x) };
        // The points that a patch is fitted to are known to their brackets.
        let error = facet.error.max(TUNING.surfaces.root_share * facet.allowed);
        Vertex { at, sides, normal, error }
    }
}

fn middle(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|k| 0.5 * (a[k] + b[k]))
}

#[cfg(test)]
mod tests;
