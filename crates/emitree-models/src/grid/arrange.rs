//! [`Arrangement`]: from axes and values as they were given to those that are interpolated between.
//!
//! Descending axes are turned around. A closed axis of φ gets a node before its first and two after its
//! last, so that the seam is a cell like any other, for cubics too. Nodes at poles, and added ones, get means over φ.

use super::axis::{Axis, is_descending};
use super::coordinates::{ANGLE_ROUNDING, Coordinates};
use core::array::from_fn;
use core::f64::consts::{PI, TAU};

/// Rounding of distances over spacings: nodes at a pole, or one spacing from it, are not always exactly there.
const SPACING_ROUNDING: f64 = 1e-5;
/// The gap that closes a turn over the largest spacing: uneven nodes differ, and a gap of 2 is a wedge.
const MOST_GAP: f64 = 1.5;

/// What is done with the values of given axes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Arrangement {
    /// The number of nodes along the given axes.
    pub(super) given: [usize; 3],
    /// The azimuth at which φ starts, from −π to π.
    pub(super) turn_start: f64,
    /// Which axes are turned around.
    turned: [bool; 3],
    /// Where φ is closed: the axis, and the weights of the nodes of one turn.
    closed: Option<(usize, Vec<f64>)>,
    /// The axis at whose ends all azimuths meet.
    meeting: usize,
    /// What is at those ends.
    ends: [End; 2],
}

/// What is at an end of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    /// Values that stay as they are.
    Free,
    /// A node where all azimuths meet.
    Meets,
    /// Such a node is added.
    Added,
}

impl Arrangement {
    /// The arrangement of axes whose nodes were checked, and the axes then.
    pub(super) fn new(coordinates: Coordinates, mut nodes: [Vec<f64>; 3]) -> (Self, [Axis; 3]) {
        let given = nodes.each_ref().map(Vec::len);
        let turned = nodes.each_ref().map(|nodes| is_descending(nodes));
        for (nodes, _) in nodes.iter_mut().zip(turned).filter(|(_, turned)| *turned) {
            nodes.reverse();
        }
        let mut of_data: [[usize; 2]; 3] = given.map(|count| [0, count - 1]);
        let (mut turn_start, mut closed) = (0.0, None);
        if let Some(phi) = coordinates.azimuth() {
            let nodes = &mut nodes[phi];
            turn_start = to_half_turns(nodes);
            if let Some(weights) = close(nodes) {
                of_data[phi] = [0, nodes.len() - 1];
                closed = Some((phi, weights));
            }
        }
        let (mut meeting, mut ends) = (0, [End::Free; 2]);
        if let (Some((axis, places)), Some(_)) = (coordinates.meeting(), &closed) {
            meeting = axis;
            for (end, &place) in places.iter().enumerate() {
                ends[end] = meet(&mut nodes[axis], end, place);
            }
            let added = ends.map(|end| usize::from(end == End::Added));
            of_data[axis] = [added[0], nodes[axis].len() - 1 - added[1]];
        }
        let mut nodes = nodes.into_iter().zip(of_data);
        let axes = from_fn(|_| {
            let (nodes, [first, last]) = nodes.next().unwrap_or_default();
            Axis::new(nodes).with_data_in(first, last)
        });
        (Self { given, turn_start, turned, closed, meeting, ends }, axes)
    }

    /// The axis of this number without the node that was added at its lower end, if there is one.
    pub(super) fn without_added(&mut self, number: usize, axis: Axis) -> Axis {
        if number != self.meeting || self.ends[0] != End::Added {
            return axis;
        }
        self.ends[0] = End::Free;
        Axis::new(axis.nodes()[1..].to_vec())
    }

    /// The values at all nodes, from those at the given ones.
    pub(super) fn apply(&self, mut values: Vec<f64>) -> Vec<f64> {
        let mut shape = self.given;
        for (axis, _) in self.turned.iter().enumerate().filter(|(_, turned)| **turned) {
            let last = shape[axis] - 1;
            values = picked(&values, shape, axis, &(0..=last).rev().collect::<Vec<_>>());
        }
        let Some((phi, weights)) = &self.closed else { return values };
        let turn = weights.len();
        // A last node that repeats the first keeps its own values.
        let upper = if shape[*phi] > turn { turn } else { 0 };
        let from: Vec<usize> =
            [turn - 1].into_iter().chain(0..turn).chain([upper, 1 % turn]).collect();
        values = picked(&values, shape, *phi, &from);
        shape[*phi] = from.len();
        let (axis, count) = (self.meeting, shape[self.meeting]);
        let mut from: Vec<usize> = (0..count).collect();
        if self.ends[0] == End::Added {
            from.insert(0, 0);
        }
        if self.ends[1] == End::Added {
            from.push(count - 1);
        }
        if from.len() > count {
            values = picked(&values, shape, axis, &from);
            shape[axis] = from.len();
        }
        let last = shape[axis] - 1;
        for (end, _) in [0, last].into_iter().zip(self.ends).filter(|(_, e)| *e != End::Free) {
            replace_by_means(&mut values, shape, [axis, end], (*phi, weights));
        }
        values
    }
}

/// Moves an ascending axis of φ by full turns so that it starts between −π and π; returns its start.
fn to_half_turns(nodes: &mut [f64]) -> f64 {
    let turns = ((nodes[0] + PI) / TAU).floor();
    if turns.abs() > 0.0 && nodes[0].abs() > PI {
        nodes.iter_mut().for_each(|node| *node -= turns * TAU);
    }
    nodes[0]
}

/// Closes an ascending axis of φ if it goes all round; returns the weights of the nodes of one turn in means.
fn close(nodes: &mut Vec<f64>) -> Option<Vec<f64>> {
    let first = nodes[0];
    let span = nodes[nodes.len() - 1] - first;
    if span > TAU - ANGLE_ROUNDING {
        nodes.pop();
    } else {
        let spacings = nodes.windows(2).map(|pair| pair[1] - pair[0]);
        let largest = spacings.fold(if nodes.len() == 1 { TAU } else { 0.0 }, f64::max);
        if TAU - span > MOST_GAP * largest {
            return None;
        }
    }
    let turn = nodes.len();
    let (second, last) = (nodes[1 % turn], nodes[turn - 1]);
    nodes.push(first + TAU);
    nodes.push(if turn == 1 { first + 2.0 * TAU } else { second + TAU });
    nodes.insert(0, last - TAU);
    // The trapezium rule.
    Some(nodes.windows(3).take(turn).map(|near| (near[2] - near[0]) / (2.0 * TAU)).collect())
}

/// What the first (0) or the last (1) end of ascending nodes is, where all azimuths meet at `place`.
fn meet(nodes: &mut Vec<f64>, end: usize, place: f64) -> End {
    let (at, inner) = if end == 0 { (0, 1) } else { (nodes.len() - 1, nodes.len() - 2) };
    let spacing = (nodes[inner] - nodes[at]).abs();
    let distance = if end == 0 { nodes[at] - place } else { place - nodes[at] };
    if distance <= SPACING_ROUNDING * spacing {
        nodes[at] = place;
        End::Meets
    } else if distance <= (1.0 + SPACING_ROUNDING) * spacing {
        nodes.insert(if end == 0 { 0 } else { nodes.len() }, place);
        End::Added
    } else {
        End::Free
    }
}

/// The rows of values along an axis with these numbers, one after the other.
fn picked(values: &[f64], shape: [usize; 3], axis: usize, from: &[usize]) -> Vec<f64> {
    // Numbers that are together whatever the place along the axis.
    let inner: usize = shape[..axis].iter().product();
    let outer = values.chunks_exact(inner * shape[axis]);
    let rows = outer.flat_map(|slab| from.iter().map(move |&row| &slab[row * inner..][..inner]));
    rows.flatten().copied().collect()
}

/// Replaces the values at a place of an axis by their weighted means over one turn of φ.
fn replace_by_means(
    values: &mut [f64],
    shape: [usize; 3],
    [axis, place]: [usize; 2],
    (phi, weights): (usize, &[f64]),
) {
    let strides = [1, shape[0], shape[0] * shape[1]];
    let other = 3 - axis - phi;
    for along in 0..shape[other] {
        let start = place * strides[axis] + along * strides[other];
        let at = |number: usize| start + number * strides[phi];
        // The turn starts at the second node.
        let first = values[at(1)];
        // About the first value, so that equal values stay as they are.
        let mean = weights
            .iter()
            .zip(1..)
            .fold(first, |mean, (weight, number)| mean + weight * (values[at(number)] - first));
        for number in 0..shape[phi] {
            values[at(number)] = mean;
        }
    }
}
