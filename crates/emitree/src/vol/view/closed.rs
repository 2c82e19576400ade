//! Closed nodes: nodes of a layer outside the view, at which nothing is evaluated.
//!
//! Beside an edge the stencils of the image tree extend across it. The values that they need there
//! are continued from the open nodes by local least squares, so that the tree's function is smooth
//! across the edge. The expected error of the continuation is stored, since the image beside the
//! edge is interpolated from these values.

use crate::parallel::prelude::*;
use crate::vol::image::nearest::Nearest;
use crate::vol::image::tree::ImageTree;
use crate::vol::least_squares::{DataPoint, Estimate, Fit};
use crate::vol::tuning::TUNING;

/// Sets the values of all `closed` nodes, continued from the others, with their expected errors.
///
/// A node is continued from nodes of its own lattice or of that of level `whole`, which exists on
/// all of the image. With finer nodes nearby, values far away would be extrapolated from a short
/// distance.
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
        let continued = |&i: &usize| continued(tree, &open, i);
        let values: Vec<Estimate> = wanted.par_iter().map(continued).collect();
        for (i, Estimate { value, error }) in wanted.into_iter().zip(values) {
            tree.set_continued(i, value, error);
        }
    }
}

/// The value at node `i`, continued from the open nodes nearest to it.
fn continued(tree: &ImageTree, open: &Nearest, i: usize) -> Estimate {
    let place = tree.nodes()[i].place;
    let nearest = open.find(place, MOST_VALUES);
    let (Some(&(square, _)), Some(&(farthest, _))) = (nearest.first(), nearest.last()) else {
        return Estimate { value: 0.0, error: 0.0 };
    };
    let unit = (farthest as f64).sqrt();
    let (known, weights) = nearest
        .iter()
        .map(|&(squared, k)| {
            let node = &tree.nodes()[k];
            let along = |axis: usize| (f64::from(node.place[axis]) - f64::from(place[axis])) / unit;
            let weight =
                (1.0 + squared as f64 / (TUNING.view.quarter_weight * square as f64)).powi(-2);
            (DataPoint { place: [along(0), along(1)], value: node.value }, weight)
        })
        .unzip();
    fitted(Fit::new(known, weights))
}

/// The most values of a continuation.
const MOST_VALUES: usize = 30;
/// For each degree from 0 to 4, the fewest values for a polynomial and the number of its terms:
/// there are twice as many values as terms, except for the constant.
const DEGREES: [(usize, usize); 5] = [(1, 1), (6, 3), (12, 6), (20, 10), (30, 15)];
/// The value at the origin of the polynomial with the smallest expected error.
///
/// The value at the origin is a weighted sum of the given values, with weights of both signs.
/// Errors of these values, and their deviations from a polynomial, are amplified by the sum of the
/// |weights|. Far away from a few values that are close to each other this is of the order of
/// millions for degree 4, and 1 for a constant. The expected error of a degree is therefore the
/// largest leave-one-out residual, less for values far away, times the amplification. The degree is
/// the one with the smallest expected error, or a higher one with an error that is not much larger.
/// Where the places do not determine the next degree (two rows of nodes contain no curvature across
/// them), residuals do not show this, and the error is at least the change due to the last degree.
fn fitted(mut fit: Fit) -> Estimate {
    let mut best = Estimate { value: 0.0, error: f64::INFINITY };
    let (mut last, mut change) = (0.0, f64::INFINITY);
    for (values, terms) in DEGREES {
        let is_open = fit.len() < values || !fit.add_terms(terms);
        if is_open {
            return Estimate { error: best.error.max(change), ..best };
        }
        let value = fit.at_origin();
        let residual = fit.largest_residual(TUNING.view.least_independence);
        let found = Estimate { value, error: fit.amplification() * residual };
        (last, change) = (found.value, (found.value - last).abs());
        if found.error <= TUNING.view.degree_preference * best.error {
            best = found;
        }
    }
    best
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
        // A disc in the middle is closed, and its values are removed.
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
            assert!(node.continuation_error < 1e-9, "{node:?}");
        }
    }

    /// A few open nodes in a corner, in which the image falls by orders of magnitude: polynomials
    /// through them diverge on the other side of the square.
    #[test]
    fn values_far_from_few_open_nodes_are_of_their_size() {
        // The function varies along diagonals: otherwise five of them would determine a quartic.
        let falling = |x: f64, y: f64| (-18.0 * x - 22.0 * y).exp();
        let mut tree = ImageTree::default();
        let along = || (0..=16_u32).map(|k| k * spacing(4));
        for place in along().flat_map(|x| along().map(move |y| [x, y])) {
            tree.add(place);
            let [x, y] = xy(place);
            tree.set(tree.len() - 1, falling(x, y));
        }
        let in_corner = |[x, y]: [f64; 2]| x + y < 0.45;
        let closed: Vec<bool> =
            tree.nodes().iter().map(|node| !in_corner(xy(node.place))).collect();
        continue_values(&mut tree, &closed, 4);
        for (node, closed) in tree.nodes().iter().zip(closed) {
            let [x, y] = xy(node.place);
            let wrong = (node.value - falling(x, y)).abs();
            assert!(node.value.abs() < 2.0, "{node:?}");
            assert!(!closed || wrong <= node.continuation_error.max(1e-3), "{wrong:.1e}: {node:?}");
        }
    }

    #[test]
    fn without_open_nodes_there_is_no_continuation() {
        let mut tree = ImageTree::default();
        tree.add([0, 0]);
        continue_values(&mut tree, &[true], 4);
        assert_eq!(tree.nodes()[0].value.to_bits(), 0);
    }
}
