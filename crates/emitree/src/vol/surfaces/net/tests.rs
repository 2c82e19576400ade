//! Nets of known patches.

use super::*;
use crate::vol::surfaces::octree::Grid;
use crate::vol::surfaces::patch::{FitPoint, Patch};

const GRID: Grid = Grid { edges: [1.0; 3], base: [2; 3], finest: 3 };

/// The height of a surface between the regions 0 and 1.
fn height(x: f64, y: f64) -> f64 {
    0.45 + 0.1 * x - 0.05 * y
}

/// Its patch, with an error.
fn facet(error: f64) -> Facet {
    let point = |k: u32| {
        let [x, y] = [f64::from(k % 4) / 3.0, f64::from(k / 4) / 3.0];
        let distance = 0.01 * f64::from(k);
        FitPoint { at: [x, y, height(x, y)], axis: 2, is_upward: true, distance }
    };
    let points: Vec<FitPoint> = (0..16).map(point).collect();
    let (patch, _) = Patch::fit(&points, [0.5; 3], [0.0, 0.0, 1.0], 0.5, 0.0).unwrap();
    Facet { wall: patch.into(), below: 0, above: 1, error, allowed: 1e-4, jump: 3.0 }
}

/// Cells through which the surface passes, one of them divided, below cells that it does not reach.
fn tree(leaf: &Leaf) -> Octree {
    let mut leaves = Vec::new();
    for c in 0..4_u32 {
        let [x, y] = [c & 1, c >> 1];
        leaves.push(((0, [x, y, 1]), Leaf::Cut(vec![facet(1e-3)])));
        if c != 3 {
            leaves.push(((0, [x, y, 0]), Leaf::Cut(vec![facet(1e-3)])));
        }
    }
    for c in 0..8_u32 {
        leaves.push(((1, [2 + (c & 1), 2 + ((c >> 1) & 1), c >> 2]), leaf.clone()));
    }
    Octree::new(GRID, leaves)
}

#[test]
fn vertices_are_on_the_patches_with_their_errors() {
    let net = Net::new(&tree(&Leaf::Cut(vec![facet(2e-3)])));
    assert!(net.vertices.len() >= 16 * 16 && net.triangles.len() >= 2 * 15 * 15);
    let length = 1.0125_f64.sqrt();
    for vertex in &net.vertices {
        let [x, y, z] = vertex.at;
        assert!((z - height(x, y)).abs() < 1e-12, "{vertex:?}");
        assert!((vertex.normal[2] - 1.0 / length).abs() < 1e-9, "{vertex:?}");
        assert_eq!(vertex.sides, [0, 1]);
        // Beside the borders of leaves a vertex may have the patch of either of them.
        if x > 0.55 && y > 0.55 && z < 0.47 {
            assert!((vertex.error - 2e-3).abs() < 1e-12, "{vertex:?}");
        } else if x.min(y) < 0.45 {
            assert!((vertex.error - 1e-3).abs() < 1e-12, "{vertex:?}");
        }
    }
}

#[test]
fn triangles_fill_the_surface_up_to_the_borders() {
    let net = Net::new(&tree(&Leaf::Cut(vec![facet(2e-3)])));
    let area = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| net.vertices[vertex as usize].at);
        let [u, v] = [difference(b, a), difference(c, a)];
        0.5 * (u[0] * v[1] - u[1] * v[0]).abs()
    };
    let all: f64 = net.triangles.iter().map(area).sum();
    assert!((all - 1.0).abs() < 1e-9, "{all}");
    for axis in 0..2 {
        for border in [0.0_f64, 1.0] {
            // One for each cell, and one at both corners.
            let on_border =
                net.vertices.iter().filter(|of| of.at[axis].to_bits() == border.to_bits()).count();
            assert!(on_border >= 18, "{on_border} at {axis} {border}");
        }
    }
}

#[test]
fn an_unresolved_leaf_is_as_uncertain_as_it_is_large() {
    // All of the leaf is in one region, whose other one begins above it.
    let net = Net::new(&tree(&Leaf::Unresolved(0, 1.0)));
    let inside: Vec<&Vertex> =
        net.vertices.iter().filter(|of| of.at[0] > 0.6 && of.at[1] > 0.6).collect();
    assert!(!inside.is_empty());
    for vertex in inside {
        assert!((vertex.at[2] - 0.5).abs() < 0.07, "{vertex:?}");
        assert!(vertex.normal[2] > 0.9, "{vertex:?}");
    }
}
