//! Lines of beams against lines on their own.

use super::*;
use crate::vol::lattice;
use crate::vol::surfaces::octree::Cell;
use crate::vol::surfaces::patch::FitPoint;
use crate::vol::surfaces::rays::Ray;

/// A patch through places on a bowl whose normal is about along an axis.
fn patch(axis: usize, centre: [f64; 3]) -> Patch {
    let point = |k: usize| {
        let u = lattice::point(k);
        let mut at: [f64; 3] = core::array::from_fn(|k| centre[k] + 0.5 * (u[k] - 0.5));
        let [a, b] = [(axis + 1) % 3, (axis + 2) % 3].map(|k| at[k] - 0.4);
        at[axis] = centre[axis] + 0.3 * a - 0.5 * a * a + 0.4 * a * b * b;
        let distance = (u[0] - 0.5).hypot(u[1] - 0.5);
        FitPoint { at, axis, is_upward: true, distance }
    };
    let mut points: Vec<FitPoint> = (0..60).map(point).collect();
    points.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    let normal = core::array::from_fn(|k| f64::from(u8::from(k == axis)));
    Patch::fit(&points, centre, normal, 0.5, 0.0).unwrap().0
}

/// Leaves of two levels: without patches, unresolved, and with one or two patches.
fn tree() -> Octree {
    let grid = Grid { edges: [1.0, 0.75, 0.5], base: [2, 2, 2], finest: 3 };
    let facet = |axis: usize, cell: Cell, [below, above]: [Label; 2]| {
        let wall = patch(axis, grid.centre(cell)).into();
        Facet { wall, below, above, error: 1e-3, allowed: 2e-3, jump: 1.0 }
    };
    let leaf = |(level, at): Cell| match (5 * at[0] + 3 * at[1] + 7 * at[2] + u32::from(level)) % 5
    {
        0 => Leaf::Uncut(0),
        1 => Leaf::Uncut(1),
        2 => Leaf::Unresolved(1, 0.5),
        3 => Leaf::Cut(vec![facet(at[0] as usize % 3, (level, at), [0, 1])]),
        _ => {
            let cell = (level, at);
            Leaf::Cut(vec![facet(2, cell, [0, 1]), facet(0, cell, [1, 2])])
        }
    };
    let mut cells: Vec<Cell> = Vec::new();
    for k in 0..8_u32 {
        let at = [k & 1, k >> 1 & 1, k >> 2];
        if k % 3 == 0 {
            cells.push((0, at));
        } else {
            cells.extend((0..8_u32).map(|c| {
                (1, [2 * at[0] + (c & 1), 2 * at[1] + (c >> 1 & 1), 2 * at[2] + (c >> 2)])
            }));
        }
    }
    cells.sort_unstable();
    Octree::new(grid, cells.into_iter().map(|cell| (cell, leaf(cell))).collect())
}

#[test]
fn a_line_of_a_beam_is_the_same_line_on_its_own() {
    let tree = tree();
    let [width, height, end] = tree.grid.edges;
    let (mut crossings, mut parts) = (0, 0);
    for count in [1, 3, 4, 9, 32] {
        let size = [width / f64::from(count), height / f64::from(count)];
        for (row, column) in (0..count).flat_map(|row| (0..count).map(move |k| (row, k))) {
            let place = |u: f64, v: f64| {
                [(f64::from(column) + u) * size[0], (f64::from(row) + v) * size[1]]
            };
            let beam = Beam::new(&tree, [place(0.0, 0.0), place(1.0, 1.0)]);
            parts += beam.parts.len();
            let mut ray = Ray::default();
            for [u, v, _] in (0..20).map(lattice::point).chain([[0.0; 3], [0.5; 3], [1.0; 3]]) {
                ray.follow(&beam, place(u, v), [0.0, end]);
                let own = Ray::new(&tree, place(u, v), [0.0, end]);
                assert_eq!(ray.segments, own.segments, "{count} {row} {column} {u} {v}");
                assert_eq!(ray.crossings, own.crossings);
                assert_eq!(ray.unresolved_leaves, own.unresolved_leaves);
                crossings += own.crossings.len();
            }
        }
    }
    // Small beams have few parts that some of their lines do not pass.
    assert!(crossings > 1000 && parts < 10_000, "{crossings} {parts}");
}

#[test]
fn the_parts_of_a_line_are_the_leaves_at_its_points() {
    let tree = tree();
    let [width, height, depth] = tree.grid.edges;
    let beam = Beam::new(&tree, [[0.0; 2], [width, height]]);
    for [u, v, _] in (0..200).map(lattice::point).chain([[0.5; 3], [0.25; 3], [1.0; 3]]) {
        let xy = [u * width, v * height];
        let mut bottom = 0.0;
        for part in beam.parts(xy) {
            let middle = [xy[0], xy[1], 0.5 * (bottom + part.top)];
            let (_, leaf) = &tree.leaves[tree.find(middle)];
            match &part.content {
                Content::Region(label) => assert_eq!(leaf.region(middle), *label),
                Content::Unresolved(.., number) => assert_eq!(tree.find(middle), *number),
                Content::Cut(facets, _) => assert_eq!(leaf, &Leaf::Cut(facets.to_vec())),
            }
            bottom = part.top;
        }
        assert!((bottom - depth).abs() < 1e-12, "{bottom}");
    }
}
