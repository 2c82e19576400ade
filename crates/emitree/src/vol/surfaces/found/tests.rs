//! Normals, jumps and uncertainties of single vertices in the world.

use super::*;
use crate::vol::testing::{PANE, Pane};

const GRID: Grid = Grid { edges: [0.5, 1.0, 1.0], base: [4, 8, 8], finest: 3 };

fn vertex() -> Vertex {
    let normal = unit([1.0, 0.0, 1.0]).unwrap();
    Vertex { at: [0.2, 0.5, 0.5], sides: [0, 1], normal, error: 1e-3 }
}

#[test]
fn normals_and_uncertainties_are_those_of_the_world() {
    // The pane is twice as wide as the grid.
    let found = world_vertex(&PANE, (&GRID, 0.01), &vertex(), 3.0).unwrap();
    assert!((found.position[0] - 0.4).abs() < 1e-12);
    let expected = unit([0.5, 0.0, 1.0]).unwrap();
    assert!(norm(difference(found.normal, expected)) < 1e-9, "{found:?}");
    // (2 δ/√2, 0, δ/√2) along that normal.
    let uncertainty = 1e-3 / 2.0_f64.sqrt() * (2.0 * expected[0] + expected[2]);
    assert!((found.uncertainty - uncertainty).abs() < 1e-12, "{found:?}");
}

#[test]
fn jumps_are_those_of_g_and_normals_on_its_larger_side() {
    let pane = Pane { density: |_| 0.5, path: 4.0, ..PANE };
    let up = world_vertex(&pane, (&GRID, 0.01), &vertex(), 3.0).unwrap();
    let down = world_vertex(&pane, (&GRID, 0.01), &vertex(), -3.0).unwrap();
    assert!([up.jump, down.jump].iter().all(|jump| (jump - 1.5).abs() < 1e-12));
    assert!(up.normal[2] > 0.0 && norm(along(up.normal, 1.0, down.normal)) < 1e-12);
    assert!(world_vertex(&pane, (&GRID, 0.01), &vertex(), 0.0).is_none());
}

#[test]
fn where_lines_of_sight_begin_to_meet_the_bounds_there_is_no_surface() {
    let ends_beside = Pane { is_open: |[x, _]| x < 0.41, ..PANE };
    let ends_elsewhere = Pane { is_open: |[x, _]| x < 0.45, ..PANE };
    assert!(world_vertex(&ends_beside, (&GRID, 0.01), &vertex(), 3.0).is_none());
    assert!(world_vertex(&ends_elsewhere, (&GRID, 0.01), &vertex(), 3.0).is_some());
}
