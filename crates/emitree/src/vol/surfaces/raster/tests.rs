//! Lattices of lines in a pixel.

use super::*;
use crate::vol::lattice;
use crate::vol::surfaces::octree::{Facet, Grid, Leaf, Octree};
use crate::vol::surfaces::patch::{FitPoint, Patch};
use crate::vol::surfaces::pieces::Pieces;

/// A plane that is parallel to the lines of sight, a twentieth of a pixel inside of the border of a pixel: none
/// of the first lines of the pixels is between them.
#[test]
fn an_edge_beside_the_border_of_a_pixel_is_seen() {
    let grid = Grid { edges: [1.0; 3], base: [1; 3], finest: 2 };
    let edge = 0.5 + 0.05 / 8.0;
    let point = |k: usize| {
        let [y, z, _] = lattice::point(k);
        FitPoint { at: [edge, y, z], axis: 0, is_upward: true, distance: 0.01 * k as f64 }
    };
    let points: Vec<FitPoint> = (0..16).map(point).collect();
    let fit = Patch::fit(&points, [edge, 0.5, 0.5], [1.0, 0.0, 0.0], 0.5, 0.0);
    let Some((patch, _)) = fit else { panic!("no patch") };
    let (below, above) = (0, 1);
    let facet = Facet { wall: patch.into(), below, above, error: 1e-6, allowed: 1e-6, jump: 1.0 };
    let tree = Octree::new(grid, vec![((0, [0; 3]), Leaf::Cut(vec![facet]))]);
    let model = Model { tree, pieces: vec![None, Some(Pieces::constant(1.0))] };
    let scale = Image::from_pixels(8, 8, vec![1.0; 64]);
    let aim = Aim { target: 1e-2, scale: &scale, visible: None, sky: None, plane: None };
    let maps = model.maps(&aim, 1e-2, &mut KnownLines::default());
    for row in 0..8 {
        let found = maps.image[(row, 4)];
        assert!((found - 0.95).abs() < 5e-3, "{found}");
        assert!(maps.image[(row, 3)].abs() < 1e-12 && (maps.image[(row, 5)] - 1.0).abs() < 1e-12);
    }
}
