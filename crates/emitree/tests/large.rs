//! Images and cubes that are made row by row: the values of a rendering, and errors for other views.

use emitree::large::{render_large, render_large_cube};
use emitree::{
    Canonical, EnergyAxis, EnergyScale, FromFn, FromSpectralFn, Image, RenderError, RenderOptions,
    VolOptions, render, render_cube,
};

const PEAK: f64 = 30.0;

fn peak([x, y, z]: [f64; 3]) -> f64 {
    (-PEAK * ((x - 0.4).powi(2) + (y - 0.6).powi(2) + (z - 0.5).powi(2))).exp()
}

fn options(tolerance: f64) -> RenderOptions<'static> {
    RenderOptions::new(VolOptions::new(tolerance))
}

/// The block of rows has the bits of the rendering, and so have the errors, if the search has all pixels.
#[test]
fn rows_have_the_bits_of_a_rendering() {
    let glow = FromFn(|at: [f64; 3], _| peak(at));
    let shape = [300, 350];
    let whole = render(&glow, &Canonical, shape, &options(1e-4)).unwrap();
    let rows = render_large(&glow, &Canonical, shape, &options(1e-4)).unwrap();
    assert!(rows.converged());
    // Rates are kept, so that no point is evaluated twice.
    assert!(rows.stats().evaluations <= whole.stats.evaluations);
    let same = |block: &Image, of: &Image, first: usize| {
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        for (number, row) in block.rows().enumerate() {
            assert_eq!(bits(row), bits(of.row(first + number)), "row {}", first + number);
        }
    };
    same(&rows.values(123..221), &whole.values, 123);
    same(&rows.errors(290..300), whole.error.as_ref().unwrap(), 290);
    assert_eq!(Some(rows.estimated_error()), whole.estimated_error());
    let covered: usize = rows.blocks().map(|block| block.len()).sum();
    assert_eq!(covered, 300);
}

/// With more pixels than the search has, both images are within their errors of each other.
#[test]
fn rows_of_many_pixels_are_within_the_errors_of_a_rendering() {
    let glow = FromFn(|at: [f64; 3], _| peak(at));
    let shape = [600, 700];
    let whole = render(&glow, &Canonical, shape, &options(1e-4)).unwrap();
    let rows = render_large(&glow, &Canonical, shape, &options(1e-4)).unwrap();
    let (values, errors) = (rows.values(0..600), rows.errors(0..600));
    let of_whole = whole.error.as_ref().unwrap();
    let both = values.pixels().iter().zip(whole.values.pixels());
    let allowed = errors.pixels().iter().zip(of_whole.pixels());
    for ((a, b), (of_a, of_b)) in both.zip(allowed) {
        assert!((a - b).abs() <= of_a + of_b, "{a} {b}");
    }
    assert!(rows.estimated_error() <= 1e-4);
}

/// Pixels of a large image against the closed form of a Gaussian, at single points: a pixel is that small.
#[test]
fn small_pixels_are_within_the_tolerance() {
    let glow = FromFn(|at: [f64; 3], _| peak(at));
    let (shape, tolerance) = ([2000, 3000], 1e-4);
    let rows = render_large(&glow, &Canonical, shape, &options(tolerance)).unwrap();
    assert!(rows.estimated_error() <= tolerance);
    // ∫ exp(−30 (z − 1/2)²) dz from 0 to 1, by the trapezoidal rule with 4000 intervals.
    let n = 4000;
    let of_depth = |k: i32| peak([0.4, 0.6, f64::from(k) / f64::from(n)]);
    let depth = (0..=n)
        .map(|k| if k == 0 || k == n { 0.5 * of_depth(k) } else { of_depth(k) })
        .sum::<f64>()
        / f64::from(n);
    for row in [0, 777, 1200, 1999] {
        let values = rows.values(row..row + 1);
        for column in [0, 1200, 1700, 2999] {
            let [x, y] = [(column, 3000.0), (row, 2000.0)].map(|(k, n)| (k as f64 + 0.5) / n);
            let exact = depth * (-PEAK * ((x - 0.4).powi(2) + (y - 0.6).powi(2))).exp();
            let error = (values[(0, column)] - exact).abs();
            assert!(error <= tolerance * depth, "{row} {column}: {error:e}");
        }
    }
}

/// Two sources of different spectra.
fn spectral(at @ [x, y, z]: [f64; 3], energy: f64) -> f64 {
    let other = (-20.0 * ((x - 0.7).powi(2) + (y - 0.3).powi(2) + (z - 0.4).powi(2))).exp();
    peak(at) * (-energy).exp() + other / (1.0 + energy * energy)
}

/// Bands have the values and the errors of a cube that is rendered as a whole, up to rounding.
#[test]
fn bands_have_the_values_of_a_rendering() {
    let glow = FromSpectralFn(|at, _, energy| spectral(at, energy));
    let axis = EnergyAxis::new(0.5, 4.0, 8, EnergyScale::Log).unwrap();
    let (shape, options) = ([150, 170], options(1e-3));
    let whole = render_cube(&glow, &Canonical, shape, &axis, &options).unwrap();
    let rows = render_large_cube(&glow, &Canonical, shape, Some(&axis), &options).unwrap();
    assert!(rows.converged() && rows.shape() == [8, 150, 170]);
    assert!(rows.stats().energies.len() > 1);
    assert_eq!(rows.stats().energies, whole.stats.energies);
    assert!(rows.stats().evaluations <= whole.stats.evaluations);
    let largest = whole.values.largest();
    let near = |block: &Image, of: &Image, first: usize| {
        for (number, row) in block.rows().enumerate() {
            for (a, b) in row.iter().zip(of.row(first + number)) {
                assert!((a - b).abs() <= 1e-13 * largest, "{a} {b}");
            }
        }
    };
    let of_whole = whole.values.bands().iter().zip(whole.error.as_ref().unwrap().bands());
    for (band, (values, errors)) in rows.bands().iter().zip(of_whole) {
        near(&band.values(40..75), values, 40);
        near(&band.errors(75..150), errors, 75);
    }
    let [a, b] = [rows.estimated_error(), whole.estimated_error().unwrap()];
    assert!((a - b).abs() <= 1e-9 * b, "{a} {b}");
}

/// Voxels of a large cube against closed forms at single points, in all bins.
#[test]
fn small_voxels_are_within_the_tolerance() {
    let glow = FromSpectralFn(|at, _, energy: f64| peak(at) * (-energy).exp());
    let axis = EnergyAxis::new(0.5, 4.0, 6, EnergyScale::Linear).unwrap();
    let (shape, tolerance) = ([600, 700], 1e-3);
    let cube =
        render_large_cube(&glow, &Canonical, shape, Some(&axis), &options(tolerance)).unwrap();
    assert!(cube.converged() && cube.estimated_error() <= tolerance);
    // ∫ exp(−30 (z − 1/2)²) dz from 0 to 1: erfc(√30/2) is 1.07e-4.
    let depth = (core::f64::consts::PI / PEAK).sqrt() * (1.0 - 1.07e-4);
    let mean = |edges: &[f64]| ((-edges[0]).exp() - (-edges[1]).exp()) / (edges[1] - edges[0]);
    let largest = depth * mean(&axis.edges());
    for (band, edges) in cube.bands().iter().zip(axis.edges().windows(2)) {
        for row in [0, 240, 599] {
            let values = band.values(row..row + 1);
            for column in [0, 280, 699] {
                let [x, y] = [(column, 700.0), (row, 600.0)].map(|(k, n)| (k as f64 + 0.5) / n);
                let exact =
                    depth * mean(edges) * (-PEAK * ((x - 0.4).powi(2) + (y - 0.6).powi(2))).exp();
                let error = (values[(0, column)] - exact).abs();
                assert!(error <= tolerance * largest, "{row} {column}: {error:e}");
            }
        }
    }
}

#[test]
fn what_has_no_products_is_refused_with_a_reason() {
    let jump = FromFn(|[x, y, z]: [f64; 3], _| f64::from(u8::from(x + 0.7 * y * y + z < 1.1)));
    let mut limited = options(1e-3);
    limited.max_memory_bytes = 1 << 30;
    let error = render_large(&jump, &Canonical, [20_000, 20_000], &limited).unwrap_err();
    let RenderError::NotByRows { shape, fits, .. } = error else { panic!("{error}") };
    assert_eq!(shape, [20_000; 2]);
    assert!(fits[0] > 1000 && fits[0] < 20_000, "{fits:?}");
    let mut by_pixel = VolOptions::new(1e-3);
    by_pixel.per_band = true;
    let glow = FromFn(|at: [f64; 3], _| peak(at));
    let refused = render_large(&glow, &Canonical, [64, 64], &RenderOptions::new(by_pixel));
    assert!(matches!(refused, Err(RenderError::NotByRows { .. })));
}
