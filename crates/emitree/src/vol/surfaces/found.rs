//! The surfaces found in one part of a view, in world coordinates.

use crate::found_surfaces::FoundSurfaces;
use crate::parallel::prelude::*;
use crate::projection::Chart;
use crate::projection::vector::{along, cross, difference, dot, norm, unit};
use crate::vol::surfaces::aim::Aim;
use crate::vol::surfaces::model::Model;
use crate::vol::surfaces::net::{Net, Vertex};
use crate::vol::surfaces::octree::Grid;

/// The step of differences of world coordinates, in canonical ones.
const STEP: f64 = 1e-4;

/// A vertex in the world.
#[derive(Clone, Copy, Debug)]
struct WorldVertex {
    position: [f64; 3],
    normal: [f64; 3],
    jump: f64,
    uncertainty: f64,
}

/// The surfaces of a model in a chart, where they are in view.
pub(super) fn found_surfaces(chart: &dyn Chart, model: &Model, aim: &Aim<'_>) -> FoundSurfaces {
    let grid = &model.tree.grid;
    let net = Net::new(&model.tree);
    let net = match aim.visible {
        Some(_) => net.cut(&|at| aim.hides(grid, at)),
        None => net,
    };
    let vertices = net.vertices.par_iter().map(|vertex| {
        let [x, y, _] = grid.canonical(vertex.at);
        if aim.sky.is_some() && !aim.is_in_view([x, y]) {
            return None;
        }
        let [a, b] = vertex.sides.map(|side| model.value_of(side, vertex.at));
        world_vertex(chart, (grid, net.cell_size), vertex, b - a)
    });
    let vertices: Vec<Option<WorldVertex>> = vertices.collect();
    let mut numbers = Vec::with_capacity(vertices.len());
    let mut surfaces = FoundSurfaces::default();
    for vertex in &vertices {
        numbers.push(vertex.and_then(|_| u32::try_from(surfaces.len()).ok()));
        if let Some(WorldVertex { position, normal, jump, uncertainty }) = vertex {
            surfaces.positions.push(*position);
            surfaces.normals.push(*normal);
            surfaces.jumps.push(*jump);
            surfaces.uncertainties.push(*uncertainty);
        }
    }
    for triangle in net.triangles {
        let [Some(a), Some(b), Some(c)] = triangle.map(|vertex| numbers[vertex as usize]) else {
            continue;
        };
        let at = |vertex: u32| surfaces.positions[vertex as usize];
        let across = cross(difference(at(b), at(a)), difference(at(c), at(a)));
        let normals = [a, b, c].map(|vertex| surfaces.normals[vertex as usize]);
        let upward: f64 = normals.iter().map(|normal| dot(*normal, across)).sum();
        surfaces.triangles.push(if upward < 0.0 { [a, c, b] } else { [a, b, c] });
    }
    surfaces
}

/// A vertex in the world, with the jump of G from its first to its second side; `None` if it is not finite,
/// if there is none, or if lines of sight within a cell of the lattice do not meet the bounds: G may jump
/// between those that do and those that do not.
fn world_vertex(
    chart: &dyn Chart,
    (grid, cell_size): (&Grid, f64),
    vertex: &Vertex,
    jump: f64,
) -> Option<WorldVertex> {
    let at = |place: [f64; 3]| grid.canonical(place);
    let u = at(vertex.at);
    let point = chart.world_from_chart(u);
    let mut around = (0..9).map(|turn| {
        let steps = [turn % 3, turn / 3].map(|k| cell_size * (f64::from(k) - 1.0));
        at([vertex.at[0] + steps[0], vertex.at[1] + steps[1], vertex.at[2]])
    });
    let weight = point.path_per_depth * chart.density([u[0], u[1]]);
    let has_lines = around.all(|u| chart.world_from_chart(u).path_per_depth > 0.0);
    if !(weight > 0.0 && jump.abs() > 0.0 && has_lines) {
        return None;
    }
    // The derivatives of the world by the coordinates of the grid.
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let mut ends = [u; 2];
        ends[0][axis] = (u[axis] - STEP).max(0.0);
        ends[1][axis] = (u[axis] + STEP).min(1.0);
        let width = (ends[1][axis] - ends[0][axis]) * grid.edges[axis];
        let [low, high] = ends.map(|u| chart.world_from_chart(u).position);
        difference(high, low).map(|along| along / width)
    });
    // Normals are transformed by the transposed inverse, here by its cofactors.
    let volume = dot(x, cross(y, z));
    let [a, b, c] = vertex.normal;
    let normal = along(along(cross(y, z).map(|k| a * k), b, cross(z, x)), c, cross(x, y));
    let normal = normal.map(|along| along / volume);
    // A displacement δ along the normal in the grid is one of δ / |normal| along that in the world.
    let uncertainty = vertex.error / norm(normal);
    let upward = if jump < 0.0 { -1.0 } else { 1.0 };
    let normal = unit(normal)?.map(|along| upward * along);
    let jump = jump.abs() / weight;
    let numbers = point.position.into_iter().chain(normal).chain([jump, uncertainty]);
    let is_finite = numbers.into_iter().all(f64::is_finite);
    is_finite.then_some(WorldVertex { position: point.position, normal, jump, uncertainty })
}

#[cfg(test)]
mod tests;
