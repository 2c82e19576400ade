//! The error of linear interpolation between data on a grid, which no tolerance of a rendering contains.

use crate::scene::{EmissionSource, Scene};
use emitree_models::grid::Coordinates;
use emitree_models::{Grid, Interpolation};

/// More values than this are not summed for each rendering: it takes a tenth of a second.
const MOST_VALUES: usize = 1 << 24;

/// The error of the image by linear interpolation between the data of a scene, over the largest pixel, if it has
/// data of which that is known.
pub(crate) fn of(scene: &Scene) -> Option<f64> {
    let EmissionSource::Grid(emission) = &scene.emission.source else { return None };
    interpolation_error(&emission.grid)
}

/// The same for the account of a rendering: not of very large data.
pub(crate) fn for_account(scene: &Scene) -> Option<f64> {
    let EmissionSource::Grid(emission) = &scene.emission.source else { return None };
    (emission.grid.values().len() <= MOST_VALUES).then(|| of(scene)).flatten()
}

/// The error of linear interpolation, h²/12 |∂²| on average over a cell, of the sums of the data along an axis, over
/// the largest of them: along the axis for which it is smallest. None for other coordinates and interpolations.
fn interpolation_error(grid: &Grid) -> Option<f64> {
    let is_linear = grid.interpolation() == Interpolation::Linear;
    let is_cartesian = grid.axes().coordinates() == Coordinates::Cartesian;
    if !is_linear || !is_cartesian {
        return None;
    }
    (0..3).map(|axis| error_of_sums(grid, axis)).reduce(f64::min)
}

/// The same of the sums along one axis.
fn error_of_sums(grid: &Grid, axis: usize) -> f64 {
    let nodes = grid.nodes();
    let lengths = nodes.map(<[f64]>::len);
    let strides = [1, lengths[0], lengths[0] * lengths[1]];
    let [a, b] = [(axis + 1) % 3, (axis + 2) % 3];
    // The trapezoidal rule.
    let weight = |k: usize| {
        let [before, after] = [k.saturating_sub(1), (k + 1).min(lengths[axis] - 1)];
        0.5 * (nodes[axis][after] - nodes[axis][before]).abs()
    };
    let sum = |i: usize, j: usize| -> f64 {
        let first = i * strides[a] + j * strides[b];
        (0..lengths[axis]).map(|k| weight(k) * grid.values()[first + k * strides[axis]]).sum()
    };
    let columns = lengths[a];
    let sums: Vec<f64> = (0..lengths[b])
        .flat_map(|j| (0..columns).map(move |i| (i, j)))
        .map(|(i, j)| sum(i, j))
        .collect();
    let largest = sums.iter().fold(0.0, |largest: f64, sum| largest.max(sum.abs()));
    if largest == 0.0 {
        return 0.0;
    }
    let at = |i: usize, j: usize| sums[i + j * columns];
    let bend = |nodes: &[f64], k: usize, value: &dyn Fn(usize) -> f64| {
        if k == 0 || k + 1 >= nodes.len() {
            return 0.0;
        }
        let [before, after] = [nodes[k] - nodes[k - 1], nodes[k + 1] - nodes[k]];
        let slopes = [(value(k) - value(k - 1)) / before, (value(k + 1) - value(k)) / after];
        // h² |∂²| with h the mean of both steps.
        (0.5 * (before + after) * (slopes[1] - slopes[0])).abs()
    };
    let of_node =
        |i: usize, j: usize| bend(nodes[a], i, &|i| at(i, j)) + bend(nodes[b], j, &|j| at(i, j));
    let all = (0..lengths[b]).flat_map(|j| (0..columns).map(move |i| (i, j)));
    all.map(|(i, j)| of_node(i, j)).fold(0.0, f64::max) / (12.0 * largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A Gaussian of the standard deviation 1 on nodes h apart: h²/12 · 2 in the middle of the sums.
    #[test]
    fn a_gaussian_has_the_error_of_its_second_derivatives() {
        let nodes: Vec<f64> = (-16..=16).map(|k| 0.25 * f64::from(k)).collect();
        let gaussian = |x: f64, y: f64, z: f64| (-0.5 * (x * x + y * y + z * z)).exp();
        let mut values = Vec::new();
        for z in &nodes {
            for y in &nodes {
                values.extend(nodes.iter().map(|x| gaussian(*x, *y, *z)));
            }
        }
        let grid = Grid::new([nodes.clone(), nodes.clone(), nodes], values).unwrap();
        let exact = 0.25_f64.powi(2) / 6.0;
        let found = interpolation_error(&grid).unwrap();
        assert!((found / exact - 1.0).abs() < 0.02, "{found} {exact}");
        let cubic = grid.with_interpolation(Interpolation::MonotoneCubic);
        assert_eq!(interpolation_error(&cubic), None);
    }

    #[test]
    fn linear_data_and_no_emission_have_no_error() {
        let nodes = || [0.0, 1.0, 3.0, 4.0].to_vec();
        let grid = |value: fn(f64, f64, f64) -> f64| {
            let mut values = Vec::new();
            for z in nodes() {
                for y in nodes() {
                    values.extend(nodes().iter().map(|x| value(*x, y, z)));
                }
            }
            Grid::new([nodes(), nodes(), nodes()], values).unwrap()
        };
        let found = interpolation_error(&grid(|x, y, z| 1.0 + 2.0 * x + y - 0.5 * z)).unwrap();
        assert!(found < 1e-14, "{found}");
        assert_eq!(interpolation_error(&grid(|_, _, _| 0.0)), Some(0.0));
    }
}
