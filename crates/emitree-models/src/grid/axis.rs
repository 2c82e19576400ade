//! The nodes of one axis, and the cell between two of them that a coordinate lies in.

use super::error::GridError;

/// An axis: finite coordinates of at least two nodes, strictly increasing.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    nodes: Vec<f64>,
    /// Cells per length, where the nodes are so even that a product finds the cell or a neighbour
    /// of it; otherwise cells are found by bisection.
    cells_per_length: Option<f64>,
}

/// A cell of an axis: where it starts, and where in it a coordinate is, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Location {
    /// The node at the lower end of the cell.
    pub(super) cell: usize,
    /// 0 at the lower node, 1 at the upper one.
    pub(super) fraction: f64,
}

impl Axis {
    pub(super) fn new(name: char, nodes: Vec<f64>) -> Result<Self, GridError> {
        if nodes.len() < 2 {
            return Err(GridError::TooFewNodes { axis: name, count: nodes.len() });
        }
        if let Some(index) = nodes.iter().position(|node| !node.is_finite()) {
            return Err(GridError::NodeNotFinite { axis: name, index, value: nodes[index] });
        }
        if let Some(index) = nodes.windows(2).position(|pair| pair[0] >= pair[1]) {
            let (previous, value) = (nodes[index], nodes[index + 1]);
            return Err(GridError::NotIncreasing { axis: name, index: index + 1, previous, value });
        }
        let cells_per_length = cells_per_length(&nodes);
        Ok(Self { nodes, cells_per_length })
    }

    pub(super) fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    pub(super) fn min(&self) -> f64 {
        self.nodes[0]
    }

    pub(super) fn max(&self) -> f64 {
        self.nodes[self.nodes.len() - 1]
    }

    /// The cell of a coordinate; a node belongs to the cell above it, the last one to the cell
    /// below. `None` outside the axis, and for NaN.
    pub(super) fn locate(&self, coordinate: f64) -> Option<Location> {
        if !(self.min() <= coordinate && coordinate <= self.max()) {
            return None;
        }
        let cell = match self.cells_per_length {
            Some(cells_per_length) => self.cell_of_even(coordinate, cells_per_length),
            None => self.cell_by_bisection(coordinate),
        };
        let (lower, upper) = (self.nodes[cell], self.nodes[cell + 1]);
        Some(Location { cell, fraction: (coordinate - lower) / (upper - lower) })
    }

    fn last_cell(&self) -> usize {
        self.nodes.len() - 2
    }

    fn cell_by_bisection(&self, coordinate: f64) -> usize {
        let above = self.nodes.partition_point(|&node| node <= coordinate);
        above.saturating_sub(1).min(self.last_cell())
    }

    /// A guess, mended by at most one cell: the answer depends on the nodes alone.
    fn cell_of_even(&self, coordinate: f64, cells_per_length: f64) -> usize {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between the first and the last node it is a number of cells, 0 or more"
        )]
        let guess = ((coordinate - self.min()) * cells_per_length) as usize;
        let guess = guess.min(self.last_cell());
        if coordinate < self.nodes[guess] {
            guess - 1
        } else if guess < self.last_cell() && coordinate >= self.nodes[guess + 1] {
            guess + 1
        } else {
            guess
        }
    }
}

/// The inverse of the mean spacing, if no node is further than a quarter of it from its even place:
/// then the even cell of any coordinate is its cell or a neighbour.
fn cells_per_length(nodes: &[f64]) -> Option<f64> {
    let (min, max) = (nodes[0], nodes[nodes.len() - 1]);
    let cells_per_length = (nodes.len() - 1) as f64 / (max - min);
    let even = |(index, &node): (usize, &f64)| {
        ((node - min) * cells_per_length - index as f64).abs() <= 0.25
    };
    nodes.iter().enumerate().all(even).then_some(cells_per_length)
}

/// The coordinates of `count` nodes at equal distances, the first at `first` and the last at
/// `last`; `first` alone for a count of 1.
///
/// ```
/// use emitree_models::grid::uniform_nodes;
///
/// assert_eq!(uniform_nodes(-1.0, 2.0, 4), [-1.0, 0.0, 1.0, 2.0]);
/// ```
pub fn uniform_nodes(first: f64, last: f64, count: usize) -> Vec<f64> {
    let cells = count.saturating_sub(1);
    let node = |index: usize| match index {
        0 => first,
        _ if index == cells => last,
        _ => first + (last - first) * index as f64 / cells as f64,
    };
    (0..count).map(node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn nodes_belong_to_the_cell_above() {
        for nodes in [vec![1.0, 2.0, 3.0, 4.0], vec![1.0, 1.5, 30.0, 31.0]] {
            let axis = Axis::new('x', nodes.clone()).unwrap();
            for (cell, &node) in nodes[..3].iter().enumerate() {
                assert_eq!(axis.locate(node), Some(Location { cell, fraction: 0.0 }));
            }
            assert_eq!(axis.locate(nodes[3]), Some(Location { cell: 2, fraction: 1.0 }));
            for outside in [nodes[0].next_down(), nodes[3].next_up(), f64::NAN, f64::INFINITY] {
                assert_eq!(axis.locate(outside), None);
            }
        }
    }

    #[test]
    fn only_even_nodes_are_found_by_a_product() {
        let even = |nodes: &[f64]| Axis::new('x', nodes.to_vec()).unwrap().cells_per_length;
        assert_eq!(even(&[0.0, 0.5, 1.0]), Some(2.0));
        assert_eq!(even(&[0.0, 0.37, 1.0]), None);
        // Coordinates that were once of 32 bits are even enough.
        let rounded: Vec<f64> = (0..101).map(|i| f64::from(0.1_f32 * i as f32)).collect();
        assert!(even(&rounded).is_some());
        // The span of these exceeds the largest number: bisection needs none.
        assert_eq!(even(&[-f64::MAX, 0.0, f64::MAX]), None);
    }

    #[test]
    fn even_nodes_meet_both_ends() {
        let nodes = uniform_nodes(-0.1, 0.7, 6);
        assert_eq!((nodes[0], nodes[5], nodes.len()), (-0.1, 0.7, 6));
        assert!((nodes[3] - 0.38).abs() < 1e-15);
        assert_eq!(uniform_nodes(3.0, 9.0, 1), [3.0]);
        assert!(uniform_nodes(0.0, 1.0, 0).is_empty());
    }

    proptest! {
        /// A product and bisection find the same cell, at nodes and beside them too.
        #[test]
        fn both_searches_agree(
            shifts in prop::collection::vec(-0.24..0.24_f64, 2..40),
            at in 0.0..=1.0_f64,
            node in 0..40_usize,
        ) {
            let nodes: Vec<f64> =
                shifts.iter().enumerate().map(|(i, shift)| 7.0 + 0.3 * (i as f64 + shift)).collect();
            let axis = Axis::new('x', nodes.clone()).unwrap();
            let by_bisection = Axis { cells_per_length: None, ..axis.clone() };
            let node = nodes[node % nodes.len()];
            let between = axis.min() + at * (axis.max() - axis.min());
            for coordinate in [between, node, node.next_up(), node.next_down()] {
                prop_assert_eq!(axis.locate(coordinate), by_bisection.locate(coordinate));
            }
        }
    }
}
