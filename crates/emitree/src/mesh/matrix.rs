//! The whole map of a mesh as one matrix.

use crate::mesh::frozen::Frozen;
use crate::mesh::sparse::SparseMatrix;
use crate::parallel::prelude::*;

/// Nodes whose images are in memory together.
const NODES_AT_ONCE: usize = 64;

/// The matrix from rates to voxels, from the image of each node alone. Voxels without an image have no
/// weights.
pub(super) fn matrix(frozen: &Frozen) -> SparseMatrix {
    let count = frozen.weights.rows();
    let mut of_voxels: Vec<Vec<(usize, f64)>> = Vec::new();
    for first in (0..count).step_by(NODES_AT_ONCE) {
        let nodes = first..(first + NODES_AT_ONCE).min(count);
        let response = |node: usize| -> Vec<f64> {
            let mut unit = vec![0.0; count];
            unit[node] = 1.0;
            frozen.cube_of_nodes(&unit).voxels().collect()
        };
        let responses: Vec<Vec<f64>> = nodes.clone().into_par_iter().map(response).collect();
        for (node, response) in nodes.zip(responses) {
            of_voxels.resize(response.len(), Vec::new());
            let weights = of_voxels.iter_mut().zip(response);
            weights
                .filter(|(_, weight)| *weight != 0.0 && !weight.is_nan())
                .for_each(|(of_voxel, weight)| of_voxel.push((node, weight)));
        }
    }
    let mut matrix = SparseMatrix::with_columns(frozen.weights.columns());
    for of_voxel in of_voxels {
        let of_nodes = of_voxel.into_iter().flat_map(|(node, of_node)| {
            frozen.weights.row(node).map(move |(point, weight)| (point, of_node * weight))
        });
        matrix.push(of_nodes.collect());
    }
    matrix
}
