use super::*;
use crate::quadrature::{CellRule, Integrand, Points, Pointwise};
use crate::refinement::Threshold;
use core::cell::Cell;
use core::convert::Infallible;
use proptest::prelude::*;

fn options(order: usize, base_level: u8, threshold: f64) -> BuildOptions {
    let threshold = Threshold::Absolute(threshold);
    BuildOptions { order, base_level, threshold, ..BuildOptions::default() }
}

/// A peak whose place and width make trees that are refined unevenly.
fn peak<const D: usize>(centre: [f64; D], width: f64) -> impl Fn([f64; D]) -> f64 {
    move |u| {
        let square: f64 = (0..D).map(|axis| (u[axis] - centre[axis]).powi(2)).sum();
        (-square / (width * width)).exp() + 0.1 * u[0]
    }
}

fn built<const D: usize>(f: impl Fn([f64; D]) -> f64, options: &BuildOptions) -> SparseTree<D> {
    build(&Pointwise(f), [false; D], options).unwrap().tree
}

/// Eq. (8) of the paper.
fn equation_8([x, y, z]: [f64; 3]) -> f64 {
    let waves = (5.0 * x).sin() * (7.0 * y).sin() * (11.0 * z).sin() / 10.0;
    let (x, y, z) = (x - 2_f64.sqrt() / 3.0, y - 7_f64.sqrt() / 5.0, z - 6_f64.sqrt() / 5.0);
    let square = x * x / 2_f64.sqrt() + y * y * 2_f64.sqrt() + z * z * 3_f64.sqrt();
    waves * waves + (-100.0 * square).exp()
}

/// An integrand with a budget, as the renderer has.
struct Budgeted<F>(F, Cell<u64>);

impl<const D: usize, F: Fn([f64; D]) -> f64> Integrand<D> for Budgeted<F> {
    type Error = Infallible;

    fn evaluate(&self, points: Points<'_, D>, values: &mut [f64]) -> Result<(), Infallible> {
        self.1.set(self.1.get() - points.len() as u64);
        for (i, value) in values.iter_mut().enumerate() {
            *value = (self.0)(points.at(i));
        }
        Ok(())
    }

    fn evaluations_left(&self) -> u64 {
        self.1.get()
    }
}

/// The prototype of the design made exactly these numbers of cells.
#[test]
fn equation_8_costs_what_the_paper_says() {
    let tree = |base_level, threshold| built(equation_8, &options(3, base_level, threshold));
    assert_eq!(tree(2, 0.038).cells(), 4_032);
    assert_eq!(tree(3, 0.02).cells(), 11_328);
    assert_eq!(tree(3, 0.01).cells(), 19_136);
    // The prototype stopped at 128³ cells; without that limit two more levels are significant.
    let fine = tree(3, 0.001);
    assert_eq!(fine.levels[..5].iter().map(Level::own_cells).sum::<usize>(), 111_872);
    assert_eq!((fine.finest_level(), fine.cells()), (9, 272_000));
}

#[test]
fn a_parent_is_the_mean_of_its_children_and_details_cancel() {
    let tree = built(peak([0.3, 0.6, 0.8], 0.1), &options(3, 2, 1e-3));
    assert!(tree.finest_level() >= 5, "the test needs a deep tree");
    for depth in 1..tree.levels.len() {
        let level = &tree.levels[depth];
        for family in 0..level.own {
            let mean = level.family_averages(family).iter().sum::<f64>() / 8.0;
            let parent = tree.levels[depth - 1].averages[level.parents[family] as usize];
            assert!((mean - parent).abs() < 1e-15);
            let details = &level.details[family * 8..][..8];
            assert!(details.iter().sum::<f64>().abs() < 1e-14);
        }
    }
}

#[test]
fn leaves_tile_the_cube() {
    let tree = built(peak([0.2, 0.9], 0.05), &options(5, 2, 1e-3));
    let mut volume = 0.0;
    let mut integral = 0.0;
    tree.for_each_leaf(|cell, average| {
        let size = 4_f64.powi(-i32::from(cell.level()));
        volume += size;
        integral += size * average;
    });
    assert!((volume - 1.0).abs() < 1e-15);
    assert!((integral - tree.integral()).abs() < 1e-15);
    let counted: usize = tree.leaves_per_level().iter().sum();
    let families = tree.levels[1..].iter().map(|level| level.own).sum::<usize>();
    assert_eq!(counted, tree.cells() - families);
}

/// The invariant of the projection, in every dimension that trees have, along every axis.
fn projection_commutes<const D: usize, const E: usize>(tree: &SparseTree<D>, axis: usize) {
    let level = tree.finest_level();
    let cells = 1_usize << level;
    let full = tree.reconstruct(level);
    let mut expected = vec![0.0; full.len() / cells];
    let stride = crate::cell::power(cells, axis);
    for (at, average) in full.iter().enumerate() {
        let (low, high) = (at % stride, at / (stride * cells));
        expected[high * stride + low] += average / cells as f64;
    }
    let projected = tree.project::<E>(axis).reconstruct(level);
    let scale = full.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
    for (projected, expected) in projected.iter().zip(&expected) {
        assert!((projected - expected).abs() < 1e-13 * scale, "{projected} {expected}");
    }
}

#[test]
fn projecting_commutes_with_reconstructing() {
    for order in [1, 3, 5, 7] {
        let two = built(peak([0.3, 0.71], 0.1), &options(order, 2, 1e-2));
        projection_commutes::<2, 1>(&two, 0);
        projection_commutes::<2, 1>(&two, 1);
        let three = built(peak([0.3, 0.71, 0.5], 0.15), &options(order, 2, 3e-2));
        (0..3).for_each(|axis| projection_commutes::<3, 2>(&three, axis));
    }
    let four = built(peak([0.3, 0.71, 0.5, 0.2], 0.3), &options(3, 1, 5e-2));
    assert!(four.finest_level() >= 4);
    projection_commutes::<4, 3>(&four, 2);
    projection_commutes::<4, 3>(&four, 3);
}

#[test]
fn projecting_commutes_with_reconstructing_on_periodic_axes() {
    let wave = |[x, y, z]: [f64; 3]| (4.0 * (core::f64::consts::TAU * (x + y * z)).cos()).exp();
    let periodic = [true, false, false];
    let tree = build(&Pointwise(wave), periodic, &options(5, 2, 1.0)).unwrap().tree;
    projection_commutes::<3, 2>(&tree, 2);
    projection_commutes::<3, 2>(&tree, 0);
}

/// On a periodic axis a shifted function makes a shifted tree.
#[test]
fn periodic_axes_have_no_border() {
    let wave = |x: f64| (2.0 * (core::f64::consts::TAU * x).sin()).exp();
    let make = |shift: f64| {
        let f = move |[x]: [f64; 1]| wave(x + shift);
        build(&Pointwise(f), [true], &options(5, 3, 1e-4)).unwrap().tree
    };
    let (tree, shifted) = (make(0.0), make(0.25));
    assert_eq!(tree.cells(), shifted.cells());
    let level = tree.finest_level();
    let (a, b) = (tree.reconstruct(level), shifted.reconstruct(level));
    for i in 0..a.len() {
        assert!((a[(i + a.len() / 4) % a.len()] - b[i]).abs() < 1e-12);
    }
}

#[test]
fn ghosts_do_not_change_what_a_tree_stands_for() {
    let tree = built(peak([0.1, 0.9, 0.4], 0.08), &options(7, 3, 1e-2));
    assert!(tree.levels.iter().any(|level| level.families.len() > level.own), "ghosts are needed");
    let level = tree.finest_level();
    let full = tree.reconstruct(level);
    tree.for_each_leaf(|cell, average| {
        let shift = level - cell.level();
        let width = 1_usize << shift;
        let [x, y, z] = cell.position().map(|p| (p as usize) << shift);
        let mut mean = 0.0;
        for k in 0..width {
            for j in 0..width {
                let row = ((z + k) << level | (y + j)) << level | x;
                mean += full[row..row + width].iter().sum::<f64>();
            }
        }
        assert!((mean / (width * width * width) as f64 - average).abs() < 1e-13);
    });
}

#[test]
fn polynomials_below_the_order_need_no_refinement() {
    // The midpoint rule turns a quadratic's averages by h²/12.
    for (order, degree) in [(3, 1), (5, 3), (7, 5)] {
        let f = move |[x, y]: [f64; 2]| x.powi(degree) - 2.0 * y.powi(degree) * x;
        let tree = built(f, &options(order, 3, 1e-2));
        assert_eq!(tree.finest_level(), 4, "order {order}");
    }
}

#[test]
fn simpson_evaluations_are_used_again() {
    let rule = CellRule::Simpson;
    let count = Cell::new(0_usize);
    let f = |[x, y, z]: [f64; 3]| {
        count.set(count.get() + 1);
        x * x * x + y * z
    };
    let built = build(&Pointwise(f), [false; 3], &BuildOptions { rule, ..options(3, 2, 0.5) });
    // Two generations of 4³ and 8³ cells: the nodes of the finer one, 17³, include the coarser's.
    assert_eq!(count.get(), 17 * 17 * 17);
    // Simpson's rule is exact for cubics.
    assert!((built.unwrap().tree.integral() - 0.5).abs() < 1e-14);
    // Around a periodic axis the first and the last node are the same.
    count.set(0);
    let options = BuildOptions { rule, ..options(3, 2, 5.0) };
    build(&Pointwise(f), [true, false, false], &options).unwrap();
    assert_eq!(count.get(), 16 * 17 * 17);
}

#[test]
fn a_budget_is_spent_on_the_largest_details_and_never_exceeded() {
    let spend = |budget| {
        let integrand = Budgeted(equation_8, Cell::new(budget));
        let built = build(&integrand, [false; 3], &options(3, 3, 1e-3)).unwrap();
        (budget - integrand.1.get(), built)
    };
    let (used, stopped) = spend(10_000);
    assert!(
        stopped.ending == StopReason::Budget && used <= 10_000 && used > 10_000 - 8,
        "used {used}"
    );
    let (used, finished) = spend(300_000);
    assert_eq!(finished.ending, StopReason::Complete);
    assert_eq!(used, 272_000);
    let starved = Budgeted(equation_8, Cell::new(511));
    let error = build(&starved, [false; 3], &options(3, 3, 1e-3)).unwrap_err().to_string();
    assert_eq!(error, "511 evaluations are allowed, but the base grid of level 3 needs 512");
}

#[test]
fn options_out_of_range_are_refused() {
    let error =
        |options| build(&Pointwise(equation_8), [false; 3], &options).unwrap_err().to_string();
    assert_eq!(error(options(4, 3, 0.1)), "`order` is 4: expected an odd number from 1 to 9");
    assert_eq!(error(options(3, 0, 0.1)), "`base_level` is 0: expected 1 to 10");
    assert_eq!(error(options(3, 11, 0.1)), "`base_level` is 11: expected 1 to 10");
    assert_eq!(error(options(3, 3, 0.0)), "`threshold` is 0: expected a number above 0");
    assert_eq!(error(options(3, 3, f64::NAN)), "`threshold` is NaN: expected a number above 0");
}

#[test]
fn a_relative_threshold_is_of_the_largest_average() {
    let f = peak([0.5, 0.5], 0.2);
    let relative = BuildOptions { threshold: Threshold::Relative(0.01), ..options(3, 3, 1.0) };
    let scaled = built(move |u| 1e-20 * f(u), &relative);
    assert_eq!(scaled.cells(), built(peak([0.5, 0.5], 0.2), &relative).cells());
}

#[test]
fn the_previous_tree_lacks_the_last_generation() {
    let built = build(&Pointwise(equation_8), [false; 3], &options(3, 3, 0.02)).unwrap();
    let (tree, previous) = (&built.tree, &built.previous);
    assert!(previous.cells() < tree.cells());
    for (depth, level) in tree.levels.iter().enumerate().skip(1) {
        let inner = (0..level.own)
            .filter(|f| level.children[f * 8..f * 8 + 8].iter().any(|&c| c != LEAF))
            .count();
        assert_eq!(previous.levels.get(depth).map_or(0, |l| l.own), inner);
    }
    projection_commutes::<3, 2>(previous, 2);
}

#[test]
fn frames_of_a_progression_end_with_the_projection() {
    let tree = built(equation_8, &options(3, 3, 0.01));
    let frames: Vec<_> = tree.progression::<2>(2).collect();
    assert_eq!(frames[0].coefficients, 512);
    assert_eq!(frames.last().unwrap().coefficients, tree.cells());
    let whole = tree.project::<2>(2).sample(64, 64);
    let errors: Vec<f64> =
        frames.iter().map(|f| f.tree.sample(64, 64).max_difference(&whole)).collect();
    assert!(errors.last().unwrap() < &1e-15);
    assert!(errors.windows(2).all(|pair| pair[1] < pair[0] || pair[0] < 1e-15), "{errors:?}");
}

#[test]
fn pixels_that_are_cells_are_averages() {
    let image = built(peak([0.3, 0.7], 0.1), &options(3, 3, 1e-3));
    let cells = image.reconstruct(6);
    assert_eq!(image.sample(64, 64).pixels(), cells);
    let coarse = image.reconstruct(3);
    for (pixel, average) in image.sample(8, 8).pixels().iter().zip(coarse) {
        assert!((pixel - average).abs() < 1e-15);
    }
}

/// Pixels of twice the size are the means of the smaller ones wherever no leaf is subdivided.
#[test]
fn binned_pixels_are_the_larger_pixels() {
    let image = built(peak([0.3, 0.7], 0.05), &options(3, 3, 1e-5));
    let (fine, coarse) = (image.sample(14, 10), image.sample(7, 5));
    for row in 0..7 {
        for column in 0..5 {
            let block = [(0, 0), (0, 1), (1, 0), (1, 1)];
            let mean: f64 =
                block.iter().map(|(j, i)| fine[(2 * row + j, 2 * column + i)] / 4.0).sum();
            assert!((mean - coarse[(row, column)]).abs() < 1e-14);
        }
    }
}

/// As in the plane; with a base grid as fine as the voxels both cubes are of one function.
#[test]
fn binned_voxels_are_the_larger_voxels() {
    let tree = built(peak([0.3, 0.7, 0.4], 0.1), &options(3, 4, 1e-3));
    assert!(tree.finest_level() >= 6, "finer cells are needed");
    let (fine, coarse) = (tree.sample_cube(12, 14, 10), tree.sample_cube(6, 7, 5));
    for bin in 0..6 {
        for row in 0..7 {
            for column in 0..5 {
                let voxel = |n: usize| {
                    let pixel = (2 * row + (n >> 1 & 1), 2 * column + (n & 1));
                    fine.bands()[2 * bin + (n >> 2)][pixel]
                };
                let mean = (0..8).map(voxel).sum::<f64>() / 8.0;
                assert!((mean - coarse.bands()[bin][(row, column)]).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn voxels_that_are_cells_are_averages() {
    let tree = built(peak([0.3, 0.7, 0.5], 0.2), &options(3, 2, 3e-2));
    let voxels: Vec<f64> = tree.sample_cube(16, 16, 16).voxels().collect();
    assert_eq!(voxels, tree.reconstruct(4));
}

/// The mean of 1 + t + … + t^(order − 1) from `from` to `to`.
fn mean_of_powers(order: usize, from: f64, to: f64) -> f64 {
    let degrees = (1..=order).map(|n| i32::try_from(n).unwrap_or(i32::MAX));
    let primitive = |t: f64| degrees.clone().map(|n| t.powi(n) / f64::from(n)).sum::<f64>();
    (primitive(to) - primitive(from)) / (to - from)
}

/// The exact average of [`mean_of_powers`] over the cell that has its centre at `centre`: such a
/// coordinate is odd in units of half an edge.
fn average_of_powers(order: usize, centre: f64) -> f64 {
    let halves = (1..30).map(|level| 0.5_f64.powi(level));
    let half = halves.into_iter().find(|half| (centre / half).fract() == 0.0).unwrap_or(0.0);
    mean_of_powers(order, centre - half, centre + half)
}

#[test]
fn threads_do_not_change_a_bit() {
    let render = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let tree = built(equation_8, &options(3, 3, 0.003));
            tree.project::<2>(2).sample(50, 64)
        })
    };
    assert_eq!(render(1).pixels(), render(4).pixels());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Pixels conserve the integral for any image shape, uneven trees and every order.
    #[test]
    fn the_sum_over_pixels_is_the_integral(
        height in 1_usize..90,
        width in 1_usize..90,
        order in prop::sample::select(vec![1_usize, 3, 5, 7]),
        centre in prop::array::uniform2(0.0..1.0_f64),
        width_of_peak in 0.01..0.3_f64,
        periodic in prop::array::uniform2(any::<bool>()),
    ) {
        // The budget ends the refinement where a periodic axis makes f jump.
        let f = Budgeted(peak(centre, width_of_peak), Cell::new(4_000));
        let tree = build(&f, periodic, &options(order, 2, 1e-3)).unwrap().tree;
        let image = tree.sample(height, width);
        let mean = image.pixels().iter().sum::<f64>() / (height * width) as f64;
        prop_assert!((mean - tree.integral()).abs() < 1e-13, "{mean} {}", tree.integral());
    }

    /// A polynomial that prediction reproduces is sampled exactly, whatever the pixels.
    #[test]
    fn pixels_of_a_polynomial_are_exact(height in 1_usize..60, width in 1_usize..60) {
        let f = |[x, y]: [f64; 2]| 1.0 + x - 2.0 * y + 3.0 * x * y;
        let image = built(f, &options(3, 2, 1e-3)).sample(height, width);
        for row in 0..height {
            for column in 0..width {
                let x = (column as f64 + 0.5) / width as f64;
                let y = (row as f64 + 0.5) / height as f64;
                prop_assert!((image[(row, column)] - f([x, y])).abs() < 1e-13);
            }
        }
    }

    /// Voxels conserve the integral for any shape, uneven trees and every order.
    #[test]
    fn the_sum_over_voxels_is_the_integral(
        shape in prop::array::uniform3(1_usize..24),
        order in prop::sample::select(vec![1_usize, 3, 5, 7]),
        centre in prop::array::uniform3(0.0..1.0_f64),
        width_of_peak in 0.05..0.4_f64,
        periodic in prop::array::uniform3(any::<bool>()),
    ) {
        let f = Budgeted(peak(centre, width_of_peak), Cell::new(6_000));
        let tree = build(&f, periodic, &options(order, 2, 3e-3)).unwrap().tree;
        let [bins, height, width] = shape;
        let cube = tree.sample_cube(bins, height, width);
        prop_assert_eq!(cube.shape(), shape);
        let mean = cube.voxels().sum::<f64>() / (bins * height * width) as f64;
        prop_assert!((mean - tree.integral()).abs() < 1e-13, "{mean} {}", tree.integral());
    }

    /// Products of polynomials below the order are sampled exactly, whatever the voxels.
    #[test]
    fn voxels_of_polynomials_below_the_order_are_exact(
        shape in prop::array::uniform3(1_usize..24),
        order in prop::sample::select(vec![1_usize, 3, 5, 7]),
    ) {
        let f = |u: [f64; 3]| u.map(|t| average_of_powers(order, t)).iter().product::<f64>();
        let tree = built(f, &options(order, 3, 1e3));
        let [bins, height, width] = shape;
        let cube = tree.sample_cube(bins, height, width);
        for (at, voxel) in cube.voxels().enumerate() {
            let place = [(at % width, width), (at / width % height, height), (at / width / height, bins)];
            let mean = |(i, n): (usize, usize)| {
                mean_of_powers(order, i as f64 / n as f64, (i + 1) as f64 / n as f64)
            };
            let exact: f64 = place.map(mean).iter().product();
            prop_assert!((voxel / exact - 1.0).abs() < 1e-11, "{place:?} {voxel} {exact}");
        }
    }

    /// The mean over an axis of the voxels is what the projection along that axis is sampled to, where
    /// all cells are as fine as voxels: beyond, a leaf that is one polynomial here may be subdivided
    /// there.
    #[test]
    fn projecting_and_sampling_commute(
        pixels in prop::array::uniform2(9_usize..17),
        along in 9_usize..17,
        axis in 0_usize..3,
        order in prop::sample::select(vec![1_usize, 3, 5]),
        centre in prop::array::uniform3(0.0..1.0_f64),
    ) {
        let options = BuildOptions { finest_level: Some(4), ..options(order, 2, 1e-2) };
        let tree = built(peak(centre, 0.15), &options);
        let [columns, rows] = pixels;
        let mut shape = vec![columns, rows];
        shape.insert(axis, along);
        let voxels: Vec<f64> = tree.sample_cube(shape[2], shape[1], shape[0]).voxels().collect();
        let stride: usize = shape[..axis].iter().product();
        let image = tree.project::<2>(axis).sample(rows, columns);
        for (at, pixel) in image.pixels().iter().enumerate() {
            let (low, high) = (at % stride, at / stride);
            let of_slice = |i: usize| voxels[(high * along + i) * stride + low];
            let mean = (0..along).map(of_slice).sum::<f64>() / along as f64;
            prop_assert!((mean - pixel).abs() < 1e-13, "{mean} {pixel}");
        }
    }

    /// Trees with the same refinement are linear in the function.
    #[test]
    fn sampling_is_linear(a in -2.0..2.0_f64, b in -2.0..2.0_f64) {
        let (f, g) = (peak([0.2, 0.3], 0.2), peak([0.8, 0.6], 0.3));
        let uniform = options(3, 4, 1e6);
        let sum = built(|u| a * f(u) + b * g(u), &uniform).sample(21, 34);
        let (f, g) = (built(&f, &uniform).sample(21, 34), built(&g, &uniform).sample(21, 34));
        for ((sum, f), g) in sum.pixels().iter().zip(f.pixels()).zip(g.pixels()) {
            prop_assert!((sum - (a * f + b * g)).abs() < 1e-13);
        }
    }

    /// Exchanging the axes of the function exchanges the axes of the tree.
    #[test]
    fn axes_are_equivalent(centre in prop::array::uniform3(0.1..0.9_f64)) {
        let f = peak(centre, 0.2);
        let tree = built(&f, &options(3, 2, 2e-2));
        let swapped = built(|[x, y, z]| f([z, y, x]), &options(3, 2, 2e-2));
        prop_assert_eq!(tree.cells(), swapped.cells());
        let (a, b) = (tree.project::<2>(0), swapped.project::<2>(2));
        let (a, b) = (a.sample(16, 16), b.sample(16, 16));
        for row in 0..16 {
            for column in 0..16 {
                // (y, z) of the one is (z, y) of the other.
                prop_assert!((a[(row, column)] - b[(column, row)]).abs() < 1e-13);
            }
        }
    }
}
