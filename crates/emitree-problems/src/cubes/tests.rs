//! All problems: against quadrature of the rate alone, against line-of-sight integration, and the
//! same light in all shapes and bins.

use super::*;
use crate::brute;
use crate::gauss::Gauss;
use emitree::los::{LosOptions, Steps};
use emitree::{Canonical, FromSpectralFn, RenderOptions, render_cube};

/// Energies that a rule must not integrate across: the edge, and the narrow line.
const CUTS: [f64; 4] = [
    edge::EDGE_ENERGY,
    mixture::LINE_ENERGY - 0.1,
    mixture::LINE_ENERGY,
    mixture::LINE_ENERGY + 0.1,
];

/// The mean over a voxel by quadrature of the rate.
fn brute_voxel(
    problem: &CubeProblem,
    shape: [usize; 2],
    [from, to]: [f64; 2],
    at: [usize; 2],
) -> f64 {
    let mut ends = vec![from];
    ends.extend(CUTS.into_iter().filter(|cut| (from..to).contains(cut)));
    ends.push(to);
    let rule = Gauss::new(16);
    let mean = |position| {
        let piece = |ends: &[f64]| {
            rule.integrate(ends[0], ends[1], |energy| problem.rate(position, energy))
        };
        ends.windows(2).map(piece).sum::<f64>() / (to - from)
    };
    brute::pixel(mean, shape, at, 8)
}

/// In an image that is not square: x is the column and y the row.
#[test]
fn voxels_agree_with_brute_force() {
    let shape = [25, 18];
    for problem in problems() {
        let axis = problem.default_axis(24).unwrap();
        let (edges, exact) = (axis.edges(), problem.exact(shape, &axis));
        for (bin, at) in [(0, [13, 9]), (11, [13, 5]), (13, [10, 12]), (16, [18, 5])] {
            let brute = brute_voxel(&problem, shape, [edges[bin], edges[bin + 1]], at);
            let far = (exact.bands()[bin][at.into()] - brute).abs() / exact.largest();
            assert!(far < problem.cube_error + 1e-10, "{} {bin} {at:?}: {far:e}", problem.name);
        }
    }
}

/// The mean over all voxels, each with the width of its bin, does not depend on how many there are,
/// not even by the error of the cube.
#[test]
fn cubes_of_all_shapes_and_bins_hold_the_same() {
    for problem in problems() {
        let mean = |shape: [usize; 2], bins, scale| {
            let [min, max] = problem.band;
            let axis = EnergyAxis::new(min, max, bins, scale).unwrap();
            let image = problem.exact(shape, &axis).sum_over_energy(&axis);
            image.pixels().iter().sum::<f64>() / image.pixels().len() as f64
        };
        let whole = mean([1, 1], 1, EnergyScale::Linear);
        for (shape, bins, scale) in
            [([7, 3], 32, EnergyScale::Linear), ([2, 9], 19, EnergyScale::Log)]
        {
            let far = (mean(shape, bins, scale) - whole).abs() / whole;
            assert!(far < CLOSED_FORM, "{} {bins}: {far:e}", problem.name);
        }
    }
}

/// Half as wide steps along x, y, z and E leave a quarter of the error of the midpoint rule, if the
/// edge is a border of bins and the bins are not much wider than the narrow line.
#[test]
fn line_of_sight_integration_goes_to_the_exact_cube() {
    for problem in problems() {
        let (log, linear) = (EnergyScale::Log, EnergyScale::Linear);
        let (axis, lines) = match problem.name {
            "edge" => (EnergyAxis::new(1.0, edge::EDGE_ENERGY.powi(2), 4, log), 4),
            "narrow-line" => (EnergyAxis::new(6.3, 6.5, 4, linear), 4),
            "doppler" => (EnergyAxis::new(6.2, 6.6, 4, linear), 6),
            _ => (problem.default_axis(6), 4),
        };
        let axis = axis.unwrap();
        let exact = problem.exact([3, 5], &axis);
        let emission = FromSpectralFn(|position, _, energy| problem.rate(position, energy));
        let far = |lines: usize| {
            let los = LosOptions::new(lines, Steps::Fixed(6 * lines));
            let options = RenderOptions::new(los);
            let rendering = render_cube(&emission, &Canonical, [3, 5], &axis, &options).unwrap();
            rendering.values.max_difference(&exact) / exact.largest()
        };
        let (coarse, fine) = (far(lines), far(2 * lines));
        assert!(coarse < 0.05, "{}: {coarse:e}", problem.name);
        assert!((0.2..0.3).contains(&(fine / coarse)), "{}: {coarse:e} to {fine:e}", problem.name);
    }
}
