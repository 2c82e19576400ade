//! The nodes of one axis, and the cell between two of them that a coordinate lies in.

use super::error::GridError;
use super::search::Search;
use crate::elementary::{self, Elementary};

/// An axis: finite coordinates of at least two nodes, strictly increasing.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Axis {
    nodes: Vec<f64>,
    /// The logarithms of the nodes, where it is interpolated in them.
    logarithms: Option<Vec<f64>>,
    search: Search,
    /// The first and the last node that are from the data: others were added beyond them.
    of_data: [usize; 2],
}

/// A cell of an axis: where it starts, and where in it a coordinate is, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Location {
    /// The node at the lower end of the cell.
    pub(crate) cell: usize,
    /// 0 at the lower node, 1 at the upper one.
    pub(crate) fraction: f64,
}

impl Axis {
    /// An axis of nodes that are known to be finite and to increase strictly.
    pub(crate) fn new(nodes: Vec<f64>) -> Self {
        let (search, last) = (Search::new(&nodes), nodes.len() - 1);
        Self { nodes, logarithms: None, search, of_data: [0, last] }
    }

    /// The same axis, with nodes before `first` and after `last` that the data have no values for.
    pub(super) fn with_data_in(self, first: usize, last: usize) -> Self {
        Self { of_data: [first, last], ..self }
    }

    /// The same axis, interpolated in the logarithm of its coordinate; `Err` of a node that has none.
    pub(crate) fn logarithmic(self) -> Result<Self, (usize, f64)> {
        if let Some(index) = self.nodes.iter().position(|&node| node <= 0.0) {
            return Err((index, self.nodes[index]));
        }
        let logarithms: Vec<f64> = self.nodes.iter().map(|&node| elementary::ln(node)).collect();
        // Nodes that differ in their last bits have one logarithm.
        if let Some(index) = logarithms.windows(2).position(|pair| pair[0] >= pair[1]) {
            return Err((index + 1, self.nodes[index + 1]));
        }
        let search = Search::new(&logarithms);
        Ok(Self { logarithms: Some(logarithms), search, ..self })
    }

    pub(crate) fn is_logarithmic(&self) -> bool {
        self.logarithms.is_some()
    }

    pub(crate) fn nodes(&self) -> &[f64] {
        &self.nodes
    }

    /// The nodes in the coordinate that is interpolated in.
    #[inline(always)]
    pub(crate) fn places(&self) -> &[f64] {
        self.logarithms.as_deref().unwrap_or(&self.nodes)
    }

    #[inline(always)]
    pub(crate) fn min(&self) -> f64 {
        self.nodes[0]
    }

    #[inline(always)]
    pub(crate) fn max(&self) -> f64 {
        self.nodes[self.nodes.len() - 1]
    }

    /// The cell of a coordinate; a node belongs to the cell above it, the last one to the cell
    /// below. `None` outside the axis, and for NaN.
    #[inline(always)]
    pub(crate) fn locate(&self, coordinate: f64) -> Option<Location> {
        if !(self.min() <= coordinate && coordinate <= self.max()) {
            return None;
        }
        let (places, place) = match &self.logarithms {
            None => (self.nodes.as_slice(), coordinate),
            Some(logarithms) => {
                let (first, last) = (logarithms[0], logarithms[logarithms.len() - 1]);
                // The logarithm rounds: not out of the axis.
                (logarithms.as_slice(), elementary::ln(coordinate).max(first).min(last))
            }
        };
        let cell = self.search.cell(places, place);
        let (lower, upper) = (places[cell], places[cell + 1]);
        Some(Location { cell, fraction: (place - lower) / (upper - lower) })
    }

    /// The cells of many coordinates, which are replaced by their fractions in them: as [`Self::locate`] of each. Where
    /// there is none `is_inside` is cleared, and the cell is that of an end.
    pub(super) fn locate_all(
        &self,
        coordinates: &mut [f64],
        cells: &mut [usize],
        is_inside: &mut [bool],
    ) {
        let (min, max) = (self.min(), self.max());
        for (coordinate, is_inside) in coordinates.iter_mut().zip(is_inside) {
            *is_inside &= min <= *coordinate && *coordinate <= max;
            *coordinate = coordinate.max(min).min(max);
        }
        if let Some(logarithms) = &self.logarithms {
            let (first, last) = (logarithms[0], logarithms[logarithms.len() - 1]);
            elementary::apply(Elementary::Ln, coordinates);
            for logarithm in coordinates.iter_mut() {
                *logarithm = logarithm.max(first).min(last);
            }
        }
        let places = self.places();
        self.search.cells(places, coordinates, cells);
        for (place, &cell) in coordinates.iter_mut().zip(&*cells) {
            let (lower, upper) = (places[cell], places[cell + 1]);
            *place = (*place - lower) / (upper - lower);
        }
    }

    /// The node of the data nearest to a location, in the coordinate that is interpolated in; the upper one of
    /// two at the same distance.
    #[inline(always)]
    pub(super) fn nearest(&self, at: Location) -> usize {
        let node = if at.fraction < 0.5 { at.cell } else { at.cell + 1 };
        node.max(self.of_data[0]).min(self.of_data[1])
    }
}

/// Refuses nodes along an axis that are not finite, or neither increase nor decrease strictly.
///
/// ```
/// use emitree_models::grid::check_nodes;
///
/// check_nodes("z", &[9.0, 4.0, -1.0])?;
/// let error = check_nodes("r", &[1.0, 3.0, 2.0]).unwrap_err();
/// assert_eq!(
///     error.to_string(),
///     "node 2 of the r axis is 2 and follows 3: expected nodes that all increase or all decrease"
/// );
/// # Ok::<(), emitree_models::GridError>(())
/// ```
///
/// # Errors
///
/// [`GridError::NodeNotFinite`] and [`GridError::NotMonotone`] with the axis, the index and the value.
pub fn check_nodes(axis: &'static str, nodes: &[f64]) -> Result<(), GridError> {
    match flaw(nodes) {
        None => Ok(()),
        Some(Flaw::NotFinite { index, value }) => {
            Err(GridError::NodeNotFinite { axis, index, value })
        }
        Some(Flaw::NotMonotone { index, previous, value }) => {
            Err(GridError::NotMonotone { axis, index, previous, value })
        }
    }
}

/// What is wrong with nodes along an axis, at the first place.
pub(crate) enum Flaw {
    NotFinite { index: usize, value: f64 },
    NotMonotone { index: usize, previous: f64, value: f64 },
}

/// The first node that is not finite, or else the first that ends the increase or the decrease of all.
pub(crate) fn flaw(nodes: &[f64]) -> Option<Flaw> {
    if let Some(index) = nodes.iter().position(|node| !node.is_finite()) {
        return Some(Flaw::NotFinite { index, value: nodes[index] });
    }
    let decreases = is_descending(nodes);
    let is_wrong = |pair: &[f64]| if decreases { pair[0] <= pair[1] } else { pair[0] >= pair[1] };
    let at = nodes.windows(2).position(is_wrong)?;
    Some(Flaw::NotMonotone { index: at + 1, previous: nodes[at], value: nodes[at + 1] })
}

/// Whether an axis ends below its start.
pub(crate) fn is_descending(nodes: &[f64]) -> bool {
    matches!((nodes.first(), nodes.last()), (Some(first), Some(last)) if last < first)
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
    spaced(first, last, count, |t| first + (last - first) * t)
}

/// The coordinates of `count` nodes at equal ratios, the first at `first` and the last at `last`, both above 0;
/// `first` alone for a count of 1.
///
/// ```
/// use emitree_models::grid::logarithmic_nodes;
///
/// assert_eq!(logarithmic_nodes(1.0, 16.0, 3), [1.0, 4.0, 16.0]);
/// ```
pub fn logarithmic_nodes(first: f64, last: f64, count: usize) -> Vec<f64> {
    spaced(first, last, count, |t| first * elementary::pow(last / first, t))
}

fn spaced(first: f64, last: f64, count: usize, between: impl Fn(f64) -> f64) -> Vec<f64> {
    let cells = count.saturating_sub(1);
    let node = |index: usize| match index {
        0 => first,
        _ if index == cells => last,
        _ => between(index as f64 / cells as f64),
    };
    (0..count).map(node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_belong_to_the_cell_above() {
        for nodes in [vec![1.0, 2.0, 3.0, 4.0], vec![1.0, 1.5, 30.0, 31.0]] {
            let axis = Axis::new(nodes.clone());
            for axis in [axis.clone(), axis.logarithmic().unwrap()] {
                for (cell, &node) in nodes[..3].iter().enumerate() {
                    assert_eq!(axis.locate(node), Some(Location { cell, fraction: 0.0 }));
                }
                assert_eq!(axis.locate(nodes[3]), Some(Location { cell: 2, fraction: 1.0 }));
                let beside = [nodes[0].next_down(), nodes[3].next_up()];
                for outside in beside.into_iter().chain([f64::NAN, f64::INFINITY]) {
                    assert_eq!(axis.locate(outside), None);
                }
            }
        }
    }

    #[test]
    fn logarithms_need_positive_nodes_apart() {
        let failure = |nodes: &[f64]| Axis::new(nodes.to_vec()).logarithmic().unwrap_err();
        assert_eq!(failure(&[0.0, 1.0]), (0, 0.0));
        assert_eq!(failure(&[-2.0, -1.0, 1.0]), (0, -2.0));
        assert_eq!(failure(&[1e9, 1e9_f64.next_up()]).0, 1);
        let axis = Axis::new(vec![1.0, 4.0, 16.0]).logarithmic().unwrap();
        let at = axis.locate(8.0).unwrap();
        assert!(at.cell == 1 && (at.fraction - 0.5).abs() < 1e-15, "{at:?}");
    }

    #[test]
    fn the_nearest_node_is_one_of_the_data() {
        let axis = Axis::new(vec![0.0, 1.0, 2.0, 3.0]).with_data_in(1, 2);
        let nearest = |at: f64| axis.nearest(axis.locate(at).unwrap());
        assert_eq!([0.1, 1.4, 1.5, 2.9].map(nearest), [1, 1, 2, 2]);
    }

    #[test]
    fn even_nodes_meet_both_ends() {
        let nodes = uniform_nodes(-0.1, 0.7, 6);
        assert_eq!((nodes[0], nodes[5], nodes.len()), (-0.1, 0.7, 6));
        assert!((nodes[3] - 0.38).abs() < 1e-15);
        assert_eq!(uniform_nodes(3.0, 9.0, 1), [3.0]);
        assert!(uniform_nodes(0.0, 1.0, 0).is_empty());
    }
}
