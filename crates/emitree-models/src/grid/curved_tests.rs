//! Cylindrical and spherical grids: against functions of their coordinates, and against smooth functions of x, y
//! and z, across the seam of φ and around poles too.

use super::tests::at;
use super::*;
use core::f64::consts::{FRAC_PI_2, PI, TAU};
use emitree::projection::{Bounds, Edge, Ellipsoid};

/// A grid with the values of a function of its coordinates.
fn sampled(coordinates: Coordinates, nodes: [Vec<f64>; 3], g: impl Fn([f64; 3]) -> f64) -> Grid {
    let mut values = Vec::new();
    for &c in &nodes[2] {
        for &b in &nodes[1] {
            values.extend(nodes[0].iter().map(|&a| g([a, b, c])));
        }
    }
    Grid::on(GridAxes::new(coordinates, nodes).unwrap(), values).unwrap()
}

fn position(coordinates: Coordinates, [a, b, c]: [f64; 3]) -> [f64; 3] {
    match coordinates {
        Coordinates::Cylindrical => [a * b.cos(), a * b.sin(), c],
        Coordinates::Spherical => [a * b.sin() * c.cos(), a * b.sin() * c.sin(), a * b.cos()],
        Coordinates::Cartesian => [a, b, c],
    }
}

/// Points between 0 and 1 that fill the cube evenly.
fn even_points(count: i32) -> impl Iterator<Item = [f64; 3]> {
    let steps = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_2];
    (1..=count).map(move |i| steps.map(|step| (f64::from(i) * step).fract()))
}

fn between([low, high]: [f64; 2], t: f64) -> f64 {
    low + t * (high - low)
}

#[test]
fn coordinates_and_positions_agree() {
    for coordinates in Coordinates::ALL {
        for [a, b, c] in even_points(200) {
            let along = match coordinates {
                Coordinates::Cartesian => [a, b, c],
                Coordinates::Cylindrical => [3.0 * a, between([-PI, PI], b), c - 0.5],
                Coordinates::Spherical => [3.0 * a, PI * b, between([-PI, PI], c)],
            };
            let found = coordinates.of(position(coordinates, along));
            let close = (0..3).all(|i| (found[i] - along[i]).abs() < 1e-14);
            assert!(close, "{coordinates:?}: {along:?}, {found:?}");
        }
    }
    // On the z axis all azimuths are one.
    let on_axis = Coordinates::Spherical.of([0.0, 0.0, -2.0]);
    assert_eq!(on_axis.map(f64::to_bits), [2.0, PI, 0.0].map(f64::to_bits));
}

#[test]
fn linear_is_exact_for_trilinear_functions_of_the_coordinates() {
    let g = |[a, b, c]: [f64; 3]| 1.0 + 2.0 * a - b + 0.5 * c + a * b - 0.3 * b * c + a * b * c;
    let wedge = |turn: f64| vec![turn - 0.9, turn - 0.2, turn, turn + 1.3];
    let lengths = vec![1.0, 1.5, 3.0, 3.1];
    for turn in [0.0, PI, -3.0, 3.0 * PI, 11.0] {
        // The azimuths of the function are those of the nodes, whatever their turn.
        let spherical = [lengths.clone(), vec![0.5, 1.0, 2.5], wedge(turn)];
        let cylindrical = [lengths.clone(), wedge(turn), vec![-2.0, 0.0, 0.5]];
        for (coordinates, nodes) in
            [(Coordinates::Spherical, spherical), (Coordinates::Cylindrical, cylindrical)]
        {
            let ends = nodes.each_ref().map(|nodes| [nodes[0], nodes[nodes.len() - 1]]);
            let reversed = nodes.clone().map(|nodes| nodes.into_iter().rev().collect());
            for nodes in [nodes, reversed] {
                let grid = sampled(coordinates, nodes, g);
                for unit in even_points(300) {
                    let along = [0, 1, 2].map(|i| between(ends[i], 0.01 + 0.98 * unit[i]));
                    let (found, expected) = (at(&grid, position(coordinates, along)), g(along));
                    assert!((found - expected).abs() < 1e-12, "{along:?}: {found} {expected}");
                }
            }
        }
    }
}

#[test]
fn logarithmic_axes_are_linear_in_the_logarithm() {
    let g = |[r, theta, phi]: [f64; 3]| 2.0 - r.ln() + theta + 0.1 * phi * r.ln();
    let nodes = [vec![1.0, 1.7, 9.0, 30.0], vec![1.0, 2.0], vec![0.0, 1.0]];
    let axes = GridAxes::new(Coordinates::Spherical, nodes.clone()).unwrap();
    let axes = axes.with_logarithmic(0).unwrap();
    assert_eq!(axes.are_logarithmic(), [true, false, false]);
    let linear = sampled(Coordinates::Spherical, nodes, g);
    let grid = Grid::on(axes, linear.values().to_vec()).unwrap();
    for [a, b, c] in even_points(300) {
        let along = [between([1.01, 29.9], a), between([1.01, 1.99], b), between([0.01, 0.99], c)];
        let found = at(&grid, position(Coordinates::Spherical, along));
        assert!((found - g(along)).abs() < 1e-13, "{along:?}");
    }
}

/// Smooth in x, y and z, and not symmetric about the z axis.
fn smooth([x, y, z]: [f64; 3]) -> f64 {
    (0.4 * x - 0.3 * y + 0.2 * z).exp() + (x * y + 0.5 * z).sin() + 3.0
}

/// The three nodes of a full turn: without and with the last one doubled, and from another start.
fn turns(count: u32) -> [Vec<f64>; 3] {
    let step = TAU / f64::from(count);
    let node = |start: f64| move |i: u32| start + f64::from(i) * step;
    [
        (0..count).map(node(0.0)).collect(),
        (0..=count).map(node(-PI)).collect(),
        (0..count).map(node(2.9)).collect(),
    ]
}

/// Colatitudes with nodes at the poles, at half a spacing from them, and at a spacing.
fn colatitudes(count: u32) -> [Vec<f64>; 3] {
    let nodes = |from: f64, parts: f64, count: u32| {
        (0..count).map(|i| (from + f64::from(i)) * PI / parts).collect()
    };
    let parts = f64::from(count);
    [nodes(0.0, parts, count + 1), nodes(0.5, parts, count), nodes(1.0, parts, count - 1)]
}

/// The root of the mean square error in shells of 1 to 2 around the whole sphere, close to the z axis, and close to the seam of
/// nodes that start at 0, for a number of cells along each axis.
fn errors(interpolation: Interpolation, count: u32, way: usize) -> [f64; 3] {
    let spherical = Coordinates::Spherical;
    let [phi, theta] = [turns(2 * count)[way].clone(), colatitudes(count)[way].clone()];
    let nodes = [uniform_nodes(1.0, 2.0, count as usize + 1), theta, phi];
    let grid = sampled(spherical, nodes, |along| smooth(position(spherical, along)));
    let grid = grid.with_interpolation(interpolation);
    let spacing = PI / f64::from(count);
    let (mut squares, points) = ([0.0_f64; 3], 3000);
    for [a, b, c] in even_points(points) {
        let r = between([1.0001, 1.9999], a);
        let polar = if b < 0.5 { 2.0 * b * spacing } else { PI - (2.0 * b - 1.0) * spacing };
        let beside = (b - 0.5) * spacing;
        let places =
            [[r, (2.0 * b - 1.0).acos(), TAU * c], [r, polar, TAU * c], [r, PI * c, beside]];
        for (square, along) in squares.iter_mut().zip(places) {
            let point = position(spherical, along);
            *square += (at(&grid, point) - smooth(point)).powi(2);
        }
    }
    squares.map(|square| (square / f64::from(points)).sqrt())
}

/// The orders at which the errors decrease, from 32 cells to 128.
fn orders(interpolation: Interpolation, way: usize) -> [f64; 3] {
    let [coarse, fine] = [32, 128].map(|count| errors(interpolation, count, way));
    [0, 1, 2].map(|place| (coarse[place] / fine[place]).log2() / 2.0)
}

#[test]
fn linear_is_of_second_order_across_poles_and_seam() {
    for way in 0..3 {
        let orders = orders(Interpolation::Linear, way);
        assert!(orders.iter().all(|&order| order > 1.9 && order < 2.2), "{way}: {orders:?}");
    }
}

#[test]
fn cubic_is_of_second_order_there_too() {
    for way in 0..3 {
        for interpolation in [Interpolation::MonotoneCubic, Interpolation::Cubic] {
            let orders = orders(interpolation, way);
            assert!(orders.iter().all(|&order| order > 1.95), "{way}: {orders:?}");
        }
    }
}

#[test]
fn nearest_is_of_first_order() {
    for way in 0..3 {
        let orders = orders(Interpolation::Nearest, way);
        assert!(orders.iter().all(|&order| order > 0.95 && order < 1.1), "{way}: {orders:?}");
    }
}

/// Monotone along φ across the seam: the cubic of a closed axis has neighbours there.
#[test]
fn cubic_is_of_third_order_across_the_seam() {
    let cylindrical = Coordinates::Cylindrical;
    let g = |[_, phi, _]: [f64; 3]| phi.sin();
    let error = |count: u32| {
        let nodes = [vec![1.0, 2.0], turns(count)[0].clone(), vec![0.0, 1.0]];
        let grid = sampled(cylindrical, nodes, g);
        let grid = grid.with_interpolation(Interpolation::MonotoneCubic);
        let largest = |largest: f64, [a, b, c]: [f64; 3]| {
            let along = [1.0 + a, between([-0.5, 0.5], b), c];
            let found = at(&grid, position(cylindrical, along));
            largest.max((found - along[1].sin()).abs())
        };
        even_points(2000).fold(0.0, largest)
    };
    let order = (error(32) / error(128)).log2() / 2.0;
    assert!(order > 2.8, "{order}");
}

/// From all sides the values tend to one at a pole, so that nothing jumps on the axis.
#[test]
fn values_meet_at_poles_and_on_the_axis() {
    let theta = colatitudes(9);
    for (way, theta) in theta.into_iter().enumerate() {
        let nodes = [vec![1.0, 2.0], theta, turns(7)[way].clone()];
        let grid = sampled(Coordinates::Spherical, nodes, |[r, theta, phi]| {
            r + theta + (phi - 0.3).cos() + (2.0 * phi).sin()
        });
        for pole in [1.5, -1.5] {
            let on_axis = at(&grid, [0.0, 0.0, pole]);
            for i in 0..12 {
                let beside = position(Coordinates::Cylindrical, [1e-9, f64::from(i), pole]);
                assert!((at(&grid, beside) - on_axis).abs() < 1e-7, "{way}: {beside:?}");
            }
        }
    }
    let nodes = [vec![0.25, 0.75, 1.25], turns(5)[0].clone(), vec![0.0, 1.0]];
    let grid = sampled(Coordinates::Cylindrical, nodes, |[_, phi, z]| phi.cos() + z);
    assert!((at(&grid, [0.0, 0.0, 0.5]) - 0.5).abs() < 1e-15);
}

#[test]
fn equal_values_stay_as_they_are() {
    for interpolation in
        [Interpolation::Nearest, Interpolation::MonotoneCubic, Interpolation::Cubic]
    {
        for way in 0..3 {
            let nodes = [vec![1.0, 2.0], colatitudes(5)[way].clone(), turns(7)[way].clone()];
            let grid = sampled(Coordinates::Spherical, nodes, |_| 0.1);
            let grid = grid.with_interpolation(interpolation);
            for [a, b, c] in even_points(200) {
                let along = [1.0 + a, PI * b, TAU * c];
                let found = at(&grid, position(Coordinates::Spherical, along));
                assert_eq!(found.to_bits(), 0.1_f64.to_bits());
            }
        }
    }
}

#[test]
fn one_azimuth_is_enough_for_all() {
    let nodes = [vec![1.0, 2.0], vec![0.0, FRAC_PI_2, PI], vec![2.0]];
    let grid = sampled(Coordinates::Spherical, nodes, |[r, theta, _]| r * theta);
    for phi in 0..7 {
        let along = [1.25, 0.7, f64::from(phi)];
        let expected = 1.25 * 0.7;
        assert!((at(&grid, position(Coordinates::Spherical, along)) - expected).abs() < 1e-14);
    }
}

#[test]
fn outside_of_the_radii_and_of_a_wedge_is_nothing() {
    let nodes = [vec![1.0, 2.0], vec![1.0, 1.5, 2.0], vec![-0.5, 0.0, 0.5]];
    let grid = sampled(Coordinates::Spherical, nodes, |_| 1.0);
    let rate = |along| at(&grid, position(Coordinates::Spherical, along));
    assert!((rate([1.5, 1.5, 0.4]) - 1.0).abs() < 1e-15);
    for outside in [
        [0.99, 1.5, 0.0],
        [2.01, 1.5, 0.0],
        [1.5, 0.99, 0.0],
        [1.5, 2.01, 0.0],
        [1.5, 1.5, 0.51],
        [1.5, 1.5, -0.51],
        [1.5, 1.5, PI],
    ] {
        assert_eq!(rate(outside).to_bits(), 0.0_f64.to_bits(), "{outside:?}");
    }
    // A hole about the axis that is wider than a cell is one.
    let nodes = [vec![1.0, 1.5, 2.0], turns(6)[0].clone(), vec![-1.0, 1.0]];
    let tokamak = sampled(Coordinates::Cylindrical, nodes, |_| 1.0);
    assert_eq!(at(&tokamak, [0.9, 0.0, 0.0]).to_bits(), 0.0_f64.to_bits());
    let strict = tokamak.with_outside(Outside::Error);
    let samples = emitree::Samples::new(&[[0.6, 0.0, 0.0]], &[[0.0, 0.0, 1.0]]);
    let error = emitree::Emission::emission_rates(&strict, &samples, &mut [0.0]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the position [0.6, 0.0, 0.0] is outside the grid: its rho is 0.6, expected 1 to 2"
    );
}

#[test]
fn logarithmic_radii_have_a_hole_about_the_axis() {
    let nodes = [vec![1.0, 2.0, 4.0], vec![0.0], vec![-1.0, 1.0]];
    let axes = GridAxes::new(Coordinates::Cylindrical, nodes).unwrap();
    assert_eq!(axes.nodes()[0], [0.0, 1.0, 2.0, 4.0]);
    let axes = axes.with_logarithmic(0).unwrap();
    assert_eq!(axes.nodes()[0], [1.0, 2.0, 4.0]);
    let grid = Grid::on(axes, vec![3.0; 6]).unwrap();
    assert_eq!(at(&grid, [0.5, 0.0, 0.0]).to_bits(), 0.0_f64.to_bits());
    assert_eq!(at(&grid, [0.0, 1.5, 0.0]).to_bits(), 3.0_f64.to_bits());
}

#[test]
fn cameras_can_declare_where_the_data_end() {
    let sphere = |radius| Ellipsoid::sphere([0.0; 3], radius).unwrap();
    let axes = |coordinates, nodes| GridAxes::new(coordinates, nodes).unwrap();
    let shell = axes(Coordinates::Spherical, [vec![1.0, 3.0], vec![0.0, PI], vec![0.0]]);
    assert_eq!(shell.bounds(), Some(Bounds::Ellipsoid(sphere(3.0))));
    assert_eq!(shell.edges(), [1.0, 3.0].map(|radius| Edge::Ellipsoid(sphere(radius))));
    let ball = axes(Coordinates::Spherical, [vec![0.0, 3.0], vec![0.0, PI], vec![0.0]]);
    assert_eq!(ball.edges(), [Edge::Ellipsoid(sphere(3.0))]);
    let drum = axes(Coordinates::Cylindrical, [vec![0.0, 3.0], vec![0.0], vec![-1.0, 2.0]]);
    assert_eq!(drum.bounds(), Bounds::cuboid([-3.0, -3.0, -1.0], [3.0, 3.0, 2.0]).ok());
    assert!(drum.edges().is_empty());
}

#[test]
fn angles_and_radii_out_of_range_are_refused() {
    let message = |coordinates, nodes| GridAxes::new(coordinates, nodes).unwrap_err().to_string();
    let spherical = |r: &[f64], theta: &[f64], phi: &[f64]| {
        message(Coordinates::Spherical, [r.to_vec(), theta.to_vec(), phi.to_vec()])
    };
    assert_eq!(
        spherical(&[1.0, 2.0], &[0.0, 90.0, 180.0], &[0.0]),
        "node 1 of the theta axis is 90: expected a colatitude from 0 to pi, in radians (degrees have \
         to be converted)"
    );
    assert_eq!(
        spherical(&[1.0, 2.0], &[0.0, 1.0], &[0.0, 120.0, 240.0, 360.0]),
        "the phi axis spans 360 rad, from 0 to 360: expected at most a full turn, 2 pi (degrees have to \
         be converted)"
    );
    assert_eq!(
        spherical(&[-1.0, 2.0], &[0.0, 1.0], &[0.0]),
        "node 0 of the r axis is -1: expected a distance, 0 or more"
    );
    assert_eq!(
        spherical(&[1.0, 2.0], &[0.5], &[0.0]),
        "the theta axis has 1 node(s): expected at least 2, since a plane has no volume"
    );
    let axes = GridAxes::new(Coordinates::Spherical, [vec![1.0, 2.0], vec![0.0, 1.0], vec![0.0]]);
    let axes = axes.unwrap();
    assert_eq!(
        axes.clone().with_logarithmic(2).unwrap_err().to_string(),
        "the phi axis has angles: expected a length to be interpolated in its logarithm"
    );
    assert_eq!(
        Grid::on(axes, vec![0.0; 3]).unwrap_err().to_string(),
        "3 values for a grid of 2 x 2 x 1 nodes (r, theta, phi): expected one for each node"
    );
}

/// In blocks and one by one, inside and outside, for all ways in which cells are found.
#[test]
fn many_values_have_the_bits_of_one() {
    let uneven = |low: f64, high: f64| uniform_nodes(low, high, 24).into_iter();
    let radii = || logarithmic_nodes(0.2, 2.0, 30);
    let turn = || uniform_nodes(-PI, PI, 25);
    let colatitudes = || uniform_nodes(0.05, PI - 0.3, 20);
    let cases = [
        (Coordinates::Cartesian, [0, 1, 2].map(|_| uniform_nodes(-1.5, 1.5, 17)), false),
        (
            Coordinates::Cartesian,
            [0.8, 1.0, 0.7].map(|s| uneven(-s, s).map(|u| u + u * u * u).collect()),
            false,
        ),
        (Coordinates::Cylindrical, [radii(), turn(), uniform_nodes(-1.0, 1.6, 9)], true),
        (Coordinates::Cylindrical, [radii(), uniform_nodes(0.3, 2.0, 9), turn()], false),
        (Coordinates::Spherical, [radii(), colatitudes(), turn()], false),
        (Coordinates::Spherical, [radii(), colatitudes(), turn()], true),
    ];
    let mut positions: Vec<[f64; 3]> =
        even_points(1500).map(|point| point.map(|u| between([-1.6, 1.6], u))).collect();
    positions.extend([
        [0.0; 3],
        [-0.0, 0.0, -1.0],
        [f64::NAN, 0.0, 0.5],
        [0.0, f64::INFINITY, 0.0],
    ]);
    for (coordinates, nodes, is_logarithmic) in cases {
        let g = |[a, b, c]: [f64; 3]| 2.0 + (3.0 * a).sin() + b * c;
        let mut grid = sampled(coordinates, nodes.clone(), g);
        if is_logarithmic {
            let axes = GridAxes::new(coordinates, nodes).unwrap().with_logarithmic(0).unwrap();
            let count: usize = axes.shape().iter().product();
            let values = (0..count).map(|i| (i % 7) as f64).collect();
            grid = Grid::on(axes, values).unwrap();
        }
        let places = grid.nodes();
        let of_nodes =
            (0..20).map(|i| position(coordinates, places.map(|nodes| nodes[i % nodes.len()])));
        let positions: Vec<[f64; 3]> = positions.iter().copied().chain(of_nodes).collect();
        for interpolation in [
            Interpolation::Nearest,
            Interpolation::Linear,
            Interpolation::MonotoneCubic,
            Interpolation::Cubic,
        ] {
            let grid = grid.clone().with_interpolation(interpolation);
            let mut values = vec![0.0; positions.len()];
            grid.values_at(&positions, -9.0, &mut values);
            let mut inside = 0;
            for (&position, value) in positions.iter().zip(values) {
                let one = grid.value(position);
                inside += usize::from(one.is_some());
                let expected = one.unwrap_or(-9.0);
                assert_eq!(value.to_bits(), expected.to_bits(), "{grid:?} at {position:?}");
            }
            assert!((100..positions.len() - 100).contains(&inside), "{inside} of {coordinates:?}");
        }
    }
}
