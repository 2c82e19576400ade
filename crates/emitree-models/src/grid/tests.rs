use super::*;
use emitree::{Emission, Samples};
use proptest::prelude::*;

const BOTH: [Interpolation; 2] = [Interpolation::Linear, Interpolation::MonotoneCubic];

pub(super) fn at(grid: &Grid, position: [f64; 3]) -> f64 {
    let mut rate = [f64::NAN];
    grid.emission_rates(&Samples::new(&[position], &[[0.0, 0.0, 1.0]]), &mut rate).unwrap();
    rate[0]
}

/// A grid with the values of a function.
fn sampled(nodes: [Vec<f64>; 3], g: impl Fn([f64; 3]) -> f64) -> Grid {
    let mut values = Vec::new();
    for &z in &nodes[2] {
        for &y in &nodes[1] {
            values.extend(nodes[0].iter().map(|&x| g([x, y, z])));
        }
    }
    Grid::new(nodes, values).unwrap()
}

/// Nodes of different spacings, 0 to 1, and even ones if `uneven` is 0.
fn warped(count: usize, uneven: f64) -> Vec<f64> {
    let warp = |u: f64| u + uneven * (core::f64::consts::TAU * u).sin();
    uniform_nodes(0.0, 1.0, count).into_iter().map(warp).collect()
}

/// The largest error at 4000 points that fill the unit cube evenly and are no nodes.
fn largest_error(grid: &Grid, g: impl Fn([f64; 3]) -> f64) -> f64 {
    // Powers of 1/q with q^4 = q + 1: what the golden ratio is on a line.
    let steps = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_2];
    let position = |i: i32| steps.map(|step| (f64::from(i) * step).fract());
    let error = |position| (at(grid, position) - g(position)).abs();
    (1..=4000).map(|i| error(position(i))).fold(0.0, f64::max)
}

/// Each error over the next one, as powers of 2, for 9, 17, 33 and 65 nodes along each axis.
fn orders(interpolation: Interpolation, uneven: f64, g: impl Fn([f64; 3]) -> f64) -> Vec<f64> {
    let errors = [9, 17, 33, 65].map(|count| {
        let nodes = [0, 1, 2].map(|_| warped(count, uneven));
        largest_error(&sampled(nodes, &g).with_interpolation(interpolation), &g)
    });
    errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect()
}

/// Smooth and without an extremum along any axis.
fn smooth([x, y, z]: [f64; 3]) -> f64 {
    (1.3 * x + 0.4 * y * z).exp() + (0.2 + y + 0.5 * x).ln_1p() + (0.7 * z - 0.6).sin()
}

#[test]
fn linear_is_of_second_order() {
    for uneven in [0.0, 0.1] {
        let orders = orders(Interpolation::Linear, uneven, smooth);
        assert!(orders.iter().all(|&order| order > 1.7 && order < 2.3), "{uneven}: {orders:?}");
    }
}

#[test]
fn cubic_is_of_third_order_away_from_extrema() {
    for uneven in [0.0, 0.1] {
        let orders = orders(Interpolation::MonotoneCubic, uneven, smooth);
        assert!(orders.iter().all(|&order| order > 2.6), "{uneven}: {orders:?}");
        assert!(orders.iter().sum::<f64>() > 3.0 * 2.8, "{uneven}: {orders:?}");
    }
}

#[test]
fn smooth_cubic_is_of_third_order_at_extrema_too() {
    let hill = |[x, y, z]: [f64; 3]| (-4.0 * (x - 0.47).powi(2) - (y - 0.2 * z).powi(2)).exp();
    for uneven in [0.0, 0.1] {
        let orders_of_both = [
            orders(Interpolation::Cubic, uneven, smooth),
            orders(Interpolation::Cubic, uneven, hill),
        ];
        let all_above = orders_of_both.iter().flatten().all(|&order| order > 2.6);
        assert!(all_above, "{uneven}: {orders_of_both:?}");
    }
}

#[test]
fn smooth_cubic_is_exact_for_quadratics_and_lines() {
    let quadratic = |[x, y, z]: [f64; 3]| (x - 0.4).powi(2) + 3.0 * y + 0.5 * y * z - z * z;
    let nodes = [warped(5, 0.1), vec![0.0, 0.3, 1.0], warped(4, -0.05)];
    let grid = sampled(nodes, quadratic).with_interpolation(Interpolation::Cubic);
    let error = largest_error(&grid, quadratic);
    assert!(error < 1e-14, "{error:e}");
    let line = |[x, y, z]: [f64; 3]| 2.0 * x - y + z;
    let grid = sampled([vec![0.0, 1.0], vec![0.0, 1.0], warped(4, 0.1)], line);
    let error = largest_error(&grid.with_interpolation(Interpolation::Cubic), line);
    assert!(error < 1e-14, "{error:e}");
}

/// The slope along x from both sides of each plane of nodes, by differences.
#[test]
fn derivatives_of_smooth_cubics_are_continuous() {
    let nodes = [warped(6, 0.1), warped(5, -0.1), warped(4, 0.05)];
    let planes = nodes[0].clone();
    let grid = sampled(nodes, smooth).with_interpolation(Interpolation::Cubic);
    for x in &planes[1..5] {
        let rate = |offset: f64| at(&grid, [x + offset, 0.37, 0.61]);
        let slopes = [(rate(0.0) - rate(-1e-6)) / 1e-6, (rate(1e-6) - rate(0.0)) / 1e-6];
        assert!((slopes[0] - slopes[1]).abs() < 1e-4, "{x}: {slopes:?}");
    }
}

/// Beside a step the cubic is below 0, which emission rates never are.
#[test]
fn smooth_cubics_of_data_that_are_not_negative_are_not_negative() {
    let nodes = [uniform_nodes(0.0, 1.0, 9), vec![0.0, 1.0], vec![0.0, 1.0]];
    let step = |height: f64| move |[x, _, _]: [f64; 3]| if x < 0.5 { height } else { height + 1.0 };
    let least = |height: f64| {
        let grid = sampled(nodes.clone(), step(height)).with_interpolation(Interpolation::Cubic);
        let rates = (0..=240).map(|i| at(&grid, [f64::from(i) / 240.0, 0.5, 0.5]));
        rates.fold(f64::INFINITY, f64::min)
    };
    assert_eq!(least(0.0).to_bits(), 0.0_f64.to_bits());
    // 2/27 of the step, at two thirds of the cell beside it.
    assert!((least(-1.0) + 1.0 + 2.0 / 27.0).abs() < 1e-4, "{}", least(-1.0));
}

#[test]
fn cubic_is_of_second_order_at_an_extremum() {
    let hill = |[x, y, z]: [f64; 3]| (-4.0 * (x - 0.47).powi(2) - (y - 0.2 * z).powi(2)).exp();
    let orders = orders(Interpolation::MonotoneCubic, 0.1, hill);
    assert!(orders.iter().all(|&order| order > 1.6), "{orders:?}");
}

#[test]
fn cubic_is_as_computed_by_others() {
    let table = include_str!("../../tests/reference/grid_cubic.csv");
    let (mut nodes, mut values, mut compared) = (Vec::new(), Vec::new(), 0);
    for line in table.lines() {
        let (kind, numbers) = line.split_once(',').unwrap();
        let numbers: Vec<f64> = numbers.split(',').map(|n| n.parse().unwrap()).collect();
        match kind {
            "v" => values = numbers,
            "p" => {
                let axes: [Vec<f64>; 3] = nodes.clone().try_into().unwrap();
                let grid = Grid::new(axes, values.clone()).unwrap();
                let rate = at(
                    &grid.with_interpolation(Interpolation::MonotoneCubic),
                    [numbers[0], numbers[1], numbers[2]],
                );
                assert!((rate - numbers[3]).abs() < 1e-14, "{numbers:?}: {rate}");
                compared += 1;
            }
            _ => nodes.push(numbers),
        }
    }
    assert_eq!(compared, 60);
}

#[test]
fn cubic_is_exact_for_quadratics_without_extrema() {
    let quadratic = |[x, y, z]: [f64; 3]| 2.0 * x + x * x + 3.0 * y + 0.5 * y * z + z * (5.0 - z);
    let nodes = [warped(5, 0.1), vec![0.0, 0.3, 1.0], warped(4, -0.05)];
    let grid = sampled(nodes, quadratic).with_interpolation(Interpolation::MonotoneCubic);
    let error = largest_error(&grid, quadratic);
    assert!(error < 1e-14, "{error:e}");
    // Two nodes along an axis leave a line.
    let nodes = [vec![0.0, 1.0], vec![0.0, 1.0], warped(4, 0.1)];
    let line = |[x, y, z]: [f64; 3]| 2.0 * x - y + z * (5.0 - z);
    let grid = sampled(nodes, line).with_interpolation(Interpolation::MonotoneCubic);
    let error = largest_error(&grid, line);
    assert!(error < 1e-14, "{error:e}");
}

#[test]
fn even_and_uneven_axes_give_the_same_bits() {
    let even = sampled([0, 1, 2].map(|_| uniform_nodes(0.0, 1.0, 9)), smooth);
    // A far node: the cells before it are found by bisection now, and are the same but for the
    // cubic of the last one.
    let far = sampled(
        [0, 1, 2].map(|_| {
            let mut nodes = uniform_nodes(0.0, 1.0, 9);
            nodes.push(40.0);
            nodes
        }),
        smooth,
    );
    for interpolation in BOTH {
        let grids = [&even, &far].map(|grid| grid.clone().with_interpolation(interpolation));
        for i in 0..1000 {
            let position = [0.1234, 0.377, 0.711].map(|step| (f64::from(i) * step).fract() * 0.875);
            let [one, other] = grids.each_ref().map(|grid| at(grid, position).to_bits());
            assert_eq!(one, other, "{interpolation:?} at {position:?}");
        }
    }
}

#[test]
fn the_nearest_node_has_the_value() {
    let nodes = [warped(7, 0.1), warped(5, -0.08), vec![0.0, 0.3, 1.0]];
    let grid = sampled(nodes.clone(), smooth).with_interpolation(Interpolation::Nearest);
    for i in 0..1000 {
        let position = [0.1234, 0.377, 0.711].map(|step| (f64::from(i) * step).fract());
        let nearest = [0, 1, 2].map(|axis| {
            let distance = |node: &f64| (node - position[axis]).abs();
            let closer = |a: &&f64, b: &&f64| distance(a).total_cmp(&distance(b));
            nodes[axis].iter().min_by(closer).copied().unwrap()
        });
        assert_eq!(at(&grid, position).to_bits(), smooth(nearest).to_bits(), "{position:?}");
    }
}

#[test]
fn descending_axes_are_turned_around() {
    let ascending = [warped(6, 0.1), warped(5, -0.1), warped(4, 0.0)];
    let grid = sampled(ascending.clone(), smooth);
    for turned in 0..8 {
        let mut nodes = ascending.clone();
        for (axis, nodes) in nodes.iter_mut().enumerate() {
            if turned >> axis & 1 == 1 {
                nodes.reverse();
            }
        }
        let turned = sampled(nodes, smooth);
        assert_eq!((turned.nodes(), turned.values()), (grid.nodes(), grid.values()));
    }
}

#[test]
fn nothing_or_an_error_is_outside() {
    let grid = sampled([vec![-1.0, 0.0, 2.0], vec![0.0, 1.0], vec![5.0, 6.0]], |_| 3.0);
    for interpolation in BOTH {
        let grid = grid.clone().with_interpolation(interpolation);
        for inside in [[-1.0, 0.0, 5.0], [2.0, 1.0, 6.0], [0.5, 0.5, 5.5]] {
            assert_eq!(at(&grid, inside).to_bits(), 3.0_f64.to_bits());
        }
        let strict = grid.clone().with_outside(Outside::Error);
        let outside = [
            ([2.0_f64.next_up(), 0.0, 5.0], "x", [-1.0, 2.0]),
            ([0.0, -1e-300, 9.0], "y", [0.0, 1.0]),
            ([0.0, 0.5, f64::NAN], "z", [5.0, 6.0]),
        ];
        for (position, axis, [min, max]) in outside {
            assert_eq!(at(&grid, position).to_bits(), 0.0_f64.to_bits());
            let samples = [[0.0, 0.0, 5.0], position];
            let samples = Samples::new(&samples, &[[1.0, 0.0, 0.0]; 2]);
            let error = strict.emission_rates(&samples, &mut [0.0; 2]).unwrap_err();
            assert_eq!((error.axis, error.min, error.max), (axis, min, max));
            assert_eq!(error.position.map(f64::to_bits), position.map(f64::to_bits));
        }
    }
}

#[test]
fn what_makes_no_grid_is_refused() {
    let axis = || vec![0.0, 1.0];
    let message = |nodes: [Vec<f64>; 3], values: Vec<f64>| {
        Grid::new(nodes, values).map_err(|error| error.to_string()).map(|grid| grid.shape())
    };
    let cases = [
        (
            [axis(), axis(), vec![7.0]],
            vec![0.0; 4],
            "the z axis has 1 node(s): expected at least 2, since a plane has no volume",
        ),
        (
            [axis(), vec![0.0, f64::INFINITY], axis()],
            vec![0.0; 8],
            "node 1 of the y axis is inf: expected a finite number",
        ),
        (
            [vec![0.0, 2.0, 2.0], axis(), axis()],
            vec![0.0; 12],
            "node 2 of the x axis is 2 and follows 2: expected nodes that all increase or all decrease",
        ),
        (
            [axis(), vec![4.0, 2.0, 3.0], axis()],
            vec![0.0; 12],
            "node 2 of the y axis is 3 and follows 2: expected nodes that all increase or all decrease",
        ),
        (
            [vec![0.0, 2.0, 3.0], axis(), axis()],
            vec![0.0; 11],
            "11 values for a grid of 3 x 2 x 2 nodes (x, y, z): expected one for each node",
        ),
        (
            [vec![0.0, 2.0, 3.0], axis(), axis()],
            (0..12).map(|i| if i == 10 { f64::NAN } else { 1.0 }).collect(),
            "the value at the node with indices (x, y, z) = (1, 1, 1) is NaN: \
             expected a finite number",
        ),
    ];
    for (nodes, values, expected) in cases {
        assert_eq!(message(nodes, values), Err(expected.to_owned()));
    }
}

#[test]
fn a_grid_has_accessors() {
    let nodes = [vec![0.0, 1.0, 5.0], vec![0.0, 1.0], vec![2.0, 3.0]];
    let grid = sampled(nodes.clone(), |[x, ..]| x).with_outside(Outside::Error);
    assert_eq!(grid.shape(), [3, 2, 2]);
    assert_eq!(grid.nodes(), nodes.each_ref().map(Vec::as_slice));
    assert_eq!(grid.values()[..4], [0.0, 1.0, 5.0, 0.0]);
    assert_eq!((grid.interpolation(), grid.outside()), (Interpolation::Linear, Outside::Error));
    let debug = format!("{grid:?}");
    assert!(debug.contains("shape: [3, 2, 2]") && !debug.contains("values"), "{debug}");
}

/// Three axes of 2 to 6 nodes, and a value for each node.
fn any_grid(value: impl Strategy<Value = f64> + Clone) -> impl Strategy<Value = Grid> {
    let axis = || {
        prop::collection::vec(0.01..3.0_f64, 2..=6).prop_map(|steps| {
            let node = |sum: &mut f64, step: f64| {
                *sum += step;
                Some(*sum)
            };
            steps.into_iter().scan(-2.0, node).collect::<Vec<f64>>()
        })
    };
    [axis(), axis(), axis()]
        .prop_flat_map(move |nodes| {
            let count = nodes.iter().map(Vec::len).product::<usize>();
            (Just(nodes), prop::collection::vec(value.clone(), count))
        })
        .prop_map(|(nodes, values)| Grid::new(nodes, values).map_err(drop))
        .prop_filter_map("a grid", Result::ok)
}

/// The position at fractions of the three axes.
fn position_in(grid: &Grid, fractions: [f64; 3]) -> [f64; 3] {
    let nodes = grid.nodes();
    [0, 1, 2].map(|i| {
        let (first, last) = (nodes[i][0], nodes[i][nodes[i].len() - 1]);
        (first + fractions[i] * (last - first)).min(last)
    })
}

fn fractions() -> impl Strategy<Value = [f64; 3]> {
    [0.0..=1.0, 0.0..=1.0, 0.0..=1.0]
}

proptest! {
    #[test]
    fn linear_is_exact_for_trilinear_functions(
        grid in any_grid(Just(0.0)),
        c in prop::array::uniform8(-1.0..1.0_f64),
        fractions in fractions(),
    ) {
        let g = |[x, y, z]: [f64; 3]| {
            c[0] + c[1] * x + c[2] * y + c[3] * z
                + c[4] * x * y + c[5] * y * z + c[6] * z * x + c[7] * x * y * z
        };
        let grid = sampled(grid.nodes().map(<[f64]>::to_vec), g);
        let position = position_in(&grid, fractions);
        let scale = grid.values().iter().fold(1.0, |scale: f64, value| scale.max(value.abs()));
        prop_assert!((at(&grid, position) - g(position)).abs() <= 1e-14 * scale);
    }

    #[test]
    fn nodes_have_the_data_bit_for_bit(grid in any_grid(-1e3..1e3_f64)) {
        for interpolation in BOTH.into_iter().chain([Interpolation::Nearest]) {
            let grid = grid.clone().with_interpolation(interpolation);
            let [xs, ys, zs] = grid.nodes();
            let mut values = grid.values().iter();
            for &z in zs {
                for &y in ys {
                    for &x in xs {
                        let value = values.next().copied().map(f64::to_bits);
                        prop_assert_eq!(Some(at(&grid, [x, y, z]).to_bits()), value);
                    }
                }
            }
        }
    }

    /// Between the smallest and the largest of the eight values around: so never negative where
    /// the data are not. A third of the data is 0, as outside a magnetopause.
    #[test]
    fn nothing_leaves_the_range_of_the_cell(
        grid in any_grid((-1.0..2.0_f64).prop_map(|value| value.max(0.0))),
        fractions in fractions(),
    ) {
        let position = position_in(&grid, fractions);
        let nodes = grid.nodes();
        let [nx, ny, _] = grid.shape();
        let cell = [0, 1, 2].map(|i| {
            let above = nodes[i].iter().filter(|&&node| node <= position[i]).count();
            (above - 1).min(nodes[i].len() - 2)
        });
        let corners = (0..8).map(|corner| {
            let [x, y, z] = [0, 1, 2].map(|i| cell[i] + (corner >> i & 1));
            grid.values()[x + nx * (y + ny * z)]
        });
        let (min, max) = corners.fold((f64::INFINITY, 0.0_f64), |(min, max), value| {
            (min.min(value), max.max(value))
        });
        for interpolation in BOTH {
            let rate = at(&grid.clone().with_interpolation(interpolation), position);
            // The trilinear sum of 1 - t and t may round by an ulp.
            let slack = if interpolation == Interpolation::Linear { 4.0 * f64::EPSILON } else { 0.0 };
            prop_assert!(min * (1.0 - slack) <= rate && rate <= max * (1.0 + slack));
        }
    }

    /// Along each line of nodes the cubic is monotone from node to node.
    #[test]
    fn cubic_is_monotone_between_nodes(
        steps in prop::collection::vec((0.01..3.0_f64, -1.0..1.0_f64), 2..8),
        axis in 0..3_usize,
        [from, to] in [0.0..=1.0_f64, 0.0..=1.0_f64],
    ) {
        let mut nodes = [0, 1, 2].map(|_| vec![0.0, 0.5, 1.5]);
        let mut sum = 0.0;
        nodes[axis] = steps.iter().map(|(step, _)| { sum += step; sum }).collect();
        let data: Vec<f64> = steps.iter().map(|(_, value)| *value).collect();
        let line = nodes[axis].clone();
        let value_at = |p: [f64; 3]| {
            data[line.iter().filter(|&&node| node <= p[axis]).count() - 1]
        };
        let grid = sampled(nodes, value_at).with_interpolation(Interpolation::MonotoneCubic);
        let (from, to) = (from.min(to), from.max(to));
        for (cell, pair) in line.windows(2).enumerate() {
            let rate = |fraction: f64| {
                let mut position = [0.7; 3];
                position[axis] = (pair[0] + fraction * (pair[1] - pair[0])).min(pair[1]);
                at(&grid, position)
            };
            let rises = data[cell + 1] >= data[cell];
            let (before, after) = (rate(from), rate(to));
            let change = if rises { after - before } else { before - after };
            prop_assert!(change >= -1e-15, "{before} {after}");
        }
    }
}
