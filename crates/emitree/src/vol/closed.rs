//! Closed nodes: places of a layer that no pixel sees, where nothing is evaluated.
//!
//! Beside an edge the stencils of the image tree reach across it. What they find there is continued
//! from the nodes on this side, by local least squares, so that the tree's function is smooth across
//! the edge whatever lies behind it.

use super::image_tree::ImageTree;
use super::nearest::Nearest;
use rayon::prelude::*;

/// Gives all nodes that are `closed` values continued from the others.
///
/// A node of one level is continued from nodes of its own lattice, or that of level `whole`, which is
/// there on all of the image: from finer ones nearby, a long way would be extrapolated from a short
/// one.
pub(crate) fn continue_values(tree: &mut ImageTree, closed: &[bool], whole: u8) {
    for level in 0..=tree.finest_level() {
        let of_level = |i: &usize| closed[*i] && tree.nodes()[*i].level == level;
        let wanted: Vec<usize> = (0..tree.len()).filter(of_level).collect();
        if wanted.is_empty() {
            continue;
        }
        let open =
            (0..tree.len()).filter(|&i| !closed[i] && tree.nodes()[i].level <= level.max(whole));
        let open: Vec<_> = open.map(|i| (tree.nodes()[i].place, i)).collect();
        let open = Nearest::new(open.into_iter());
        let values: Vec<f64> = wanted.par_iter().map(|&i| continued(tree, &open, i)).collect();
        for (i, value) in wanted.into_iter().zip(values) {
            tree.set_continued(i, value);
        }
    }
}

/// The value expected at node `i` from the open nodes nearest to it.
fn continued(tree: &ImageTree, open: &Nearest, i: usize) -> f64 {
    let place = tree.nodes()[i].place;
    let nearest = open.find(place, MOST_VALUES);
    let (Some(&(square, first)), Some(&(farthest, _))) = (nearest.first(), nearest.last()) else {
        return 0.0;
    };
    let unit = (farthest as f64).sqrt();
    let known: Vec<Known> = nearest
        .iter()
        .map(|&(squared, k)| {
            let node = &tree.nodes()[k];
            let along = |axis: usize| (f64::from(node.place[axis]) - f64::from(place[axis])) / unit;
            let weight = (1.0 + squared as f64 / (QUARTER_WEIGHT * square as f64)).powi(-2);
            Known { place: [along(0), along(1)], value: node.value, weight }
        })
        .collect();
    let degrees = DEGREES.iter().filter(|(values, _)| known.len() >= *values);
    let fitted = degrees.map(|(_, degree)| fitted(&known, *degree)).find_map(|value| value);
    fitted.unwrap_or(tree.nodes()[first].value)
}

/// Values that a continuation is made from.
const MOST_VALUES: usize = 30;
/// Values for a polynomial, at the least, and its degree: twice as many as it has coefficients.
const DEGREES: [(usize, i32); 4] = [(30, 4), (20, 3), (12, 2), (6, 1)];
/// The square of the distance at which weights have fallen to a quarter, for a nearest value at 1.
const QUARTER_WEIGHT: f64 = 8.0;
/// A pivot below this, relative to the largest, is none.
const LEAST_PIVOT: f64 = 1e-12;

/// A value near the place where one is wanted, which is the origin.
struct Known {
    place: [f64; 2],
    value: f64,
    weight: f64,
}

/// The value at the origin of the polynomial of a degree that fits best; none if the places leave it
/// open.
fn fitted(known: &[Known], degree: i32) -> Option<f64> {
    let powers = || (0..=degree).flat_map(|sum| (0..=sum).map(move |j| (sum - j, j)));
    let terms = powers().count();
    // The normal equations, with the right side as the last column.
    let mut rows = vec![vec![0.0; terms + 1]; terms];
    for one in known {
        let basis: Vec<f64> =
            powers().map(|(i, j)| one.place[0].powi(i) * one.place[1].powi(j)).collect();
        for (row, of_row) in rows.iter_mut().zip(&basis) {
            for (entry, of_column) in row.iter_mut().zip(basis.iter().chain([&one.value])) {
                *entry += one.weight * of_row * of_column;
            }
        }
    }
    // The constant term comes last, so that it is known first.
    rows.reverse();
    rows.iter_mut().for_each(|row| row[..terms].reverse());
    let largest = rows.iter().flatten().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    for column in 0..terms {
        let (above, below) = rows.split_at_mut(column + 1);
        let row = &above[column];
        if row[column].abs() <= LEAST_PIVOT * largest {
            return None;
        }
        for other in below {
            let factor = other[column] / row[column];
            for (entry, of_row) in other.iter_mut().zip(row).skip(column) {
                *entry -= factor * of_row;
            }
        }
    }
    let last = &rows[terms - 1];
    Some(last[terms] / last[terms - 1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::dyadic::{spacing, unit};

    fn xy(place: [u32; 2]) -> [f64; 2] {
        place.map(unit)
    }

    #[test]
    fn quartics_go_on_across_an_edge() {
        let quartic = |x: f64, y: f64| 1.0 + x - 2.0 * y * x * x + 3.0 * x * y.powi(3) - x * x;
        let mut tree = ImageTree::default();
        let lattice = |level: u8| {
            let along = move || (0..=1_u32 << level).map(move |k| k * spacing(level));
            along().flat_map(move |x| along().map(move |y| [x, y]))
        };
        for place in lattice(3).chain(lattice(4)) {
            if tree.find(place).is_none() {
                tree.add(place);
                let [x, y] = xy(place);
                tree.set(tree.len() - 1, quartic(x, y));
            }
        }
        // A disc in the middle is closed, and what stood there forgotten.
        let in_disc = |[x, y]: [f64; 2]| (x - 0.5).hypot(y - 0.4) < 0.2;
        let closed: Vec<bool> = tree.nodes().iter().map(|node| in_disc(xy(node.place))).collect();
        for i in (0..tree.len()).filter(|&i| closed[i]) {
            tree.set(i, f64::NAN);
        }
        continue_values(&mut tree, &closed, 4);
        for (node, closed) in tree.nodes().iter().zip(closed) {
            let [x, y] = xy(node.place);
            assert_eq!(node.is_continued, closed);
            assert!((node.value - quartic(x, y)).abs() < 1e-9, "{node:?}");
        }
    }

    #[test]
    fn without_open_nodes_there_is_nothing() {
        let mut tree = ImageTree::default();
        tree.add([0, 0]);
        continue_values(&mut tree, &[true], 4);
        assert_eq!(tree.nodes()[0].value.to_bits(), 0);
    }
}
