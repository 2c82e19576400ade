//! Scattered samples, and the sizes of features that follow from them.

use crate::error::{OptionError, RenderError};
use crate::projection::Projection;
use crate::tile::Tile;
use crate::vol::FEATURE_CONTRAST;
use crate::vol::FeatureSize::{self, Fraction, Length};
use crate::vol::dyadic::{spacing, unit};
use crate::vol::lattice::{point, smallest_detected};
use crate::vol::sampling::Stop;
use crate::vol::testing::{
    PANE, Pane, answered, assert_close, fill, lattice, meter, sheet, uniform,
};
use crate::vol::tuning::TUNING;
use crate::vol::view::scattered::{
    PartSamples, ScatteredSheet, WIDTH_OF_GAUSSIAN, fraction_of_view, size_detected, steps,
};
use crate::vol::view::sheet::Sheet;
use crate::vol::view::verification_lines::FIRST_LINE;
use crate::{Orthographic, Perspective, Viewpoint};
use std::sync::Arc;

const SHAPE: [usize; 2] = [16, 16];

fn plane([x, y, z]: [f64; 3]) -> f64 {
    1.0 + 2.0 * x - y + z
}

fn viewpoint() -> Viewpoint {
    Viewpoint { position: [0.0; 3], target: [0.0, 0.0, 1.0], up: [0.0, 1.0, 0.0] }
}

/// The size as a fraction of the edge of a view of `tiles` tiles, or the refused option.
fn fraction(
    size: FeatureSize,
    projection: &dyn Projection,
    tiles: usize,
) -> Result<f64, OptionError> {
    let tile = |number| Tile { projection, shape: [8, 8], place: (number, tiles) };
    let tiles: Vec<Tile<'_>> = (0..tiles).map(tile).collect();
    fraction_of_view(size, &tiles).map_err(|error| match error {
        RenderError::Option(option) => {
            assert_eq!(option.name(), "smallest_feature");
            option
        }
        error => panic!("{error}"),
    })
}

#[test]
fn a_length_is_a_fraction_of_the_cube_root_of_the_volume_in_view() {
    // 2 × 8 × 4 = 4³.
    let view = Orthographic::new(viewpoint(), [2.0, 8.0], [1.0, 5.0]).unwrap();
    assert_close(fraction(Length(0.5), &view, 1).unwrap(), 0.125, 1e-9);
    assert_close(fraction(Length(0.5), &view, 8).unwrap(), 0.0625, 1e-9);
    assert_close(fraction(Length(9.0), &view, 1).unwrap(), 1.0, 1e-15);
    // A third of a hemisphere, from a radius of 1 to 2: 2π/3 (8 − 1) / 3.
    let cone = Perspective::new(viewpoint(), [core::f64::consts::FRAC_PI_2; 2], [1.0, 2.0]);
    let expected = 0.5 / (14.0 * core::f64::consts::PI / 9.0).cbrt();
    assert_close(fraction(Length(0.5), &cone.unwrap(), 1).unwrap(), expected, 5e-3 * expected);
}

#[test]
fn sizes_out_of_range_are_refused() {
    let view = Orthographic::new(viewpoint(), [2.0, 8.0], [1.0, 5.0]).unwrap();
    let infinite = Orthographic::new(viewpoint(), [2.0, 8.0], [1.0, f64::INFINITY]).unwrap();
    for size in [0.0, -1.0, f64::NAN, 1.0 + 1e-9] {
        assert!(fraction(Fraction(size), &view, 1).is_err(), "{size}");
    }
    assert_eq!(fraction(Fraction(1.0), &view, 1), Ok(1.0));
    assert_eq!(fraction(Fraction(0.25), &infinite, 1), Ok(0.25));
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(fraction(Length(size), &view, 1).is_err(), "{size}");
    }
    let refused = OptionError::FeatureLengthOfInfiniteView(0.5);
    assert_eq!(fraction(Length(0.5), &infinite, 1), Err(refused));
}

#[test]
fn the_size_detected_is_that_of_the_smallest_gaussian_that_does_not_pass() {
    for (samples, passes) in [(1024, 0.2), (4096, 0.2), (1024, 2.0)] {
        let size = size_detected(samples, passes);
        // Its column is 20 errors, and so its amplitude 20 / (√(2π) size).
        let share = passes / (FEATURE_CONTRAST / (WIDTH_OF_GAUSSIAN * size));
        assert_close(smallest_detected(samples, share) / size, 1.0, 1e-9);
    }
    assert!(size_detected(4096, 0.2) < size_detected(1024, 0.2));
    assert!(size_detected(1024, 0.2) < size_detected(1024, 2.0));
}

#[test]
fn samples_of_a_search_are_rates_without_the_density() {
    let points = [[0.5, 0.1, 0.2], [0.0, 0.3, 0.9], [0.25, 0.7, 0.1]];
    // Two points of the lattice are out of view.
    let samples = PartSamples::of_probes(5, &points, &[3.0, 7.0, 5.0], |[x, _]| 2.0 * x);
    assert_eq!((samples.number, &samples.points[..]), (5, &points[..]));
    assert_eq!(samples.rates, [3.0, 0.0, 10.0]);
}

#[test]
fn points_are_sampled_once_and_those_out_of_view_are_dark() {
    let meter = meter(1000);
    let left = Pane { is_open: |[x, _]| x < 0.5, ..PANE };
    let sheet = sheet(&meter, &left, 3, SHAPE);
    let mut samples = PartSamples::default();
    // The first N = 2^m points have N different abscissas, one in each N-th of the edge.
    for (number, in_view) in [(64, 32), (128, 64), (100, 64)] {
        let task = sheet.sample_scattered(&mut samples, number);
        answered(&meter, |at, _| plane(at), task).unwrap();
        assert_eq!(samples.number, number.max(samples.number));
        let seen = samples.rates.iter().filter(|rate| **rate != 0.0).count();
        assert_eq!((seen, meter.evaluations()), (in_view, in_view as u64));
        assert_eq!((samples.points.len(), samples.rates.len()), (samples.number, samples.number));
    }
    for (at, rate) in samples.points.iter().zip(&samples.rates) {
        assert_close(*rate, if at[0] < 0.5 { plane(*at) } else { 0.0 }, 1e-6);
    }
    let task = sheet.sample_scattered(&mut samples, 1 << 16);
    assert!(matches!(answered(&meter, |_, _| 1.0, task), Err(Stop::Budget)));
    assert_eq!((samples.number, samples.points.len()), (128, 128));
}

fn scattered<'a, 'b>(sheet: &'a Sheet<'b>, target: f64, number: usize) -> ScatteredSheet<'a, 'b> {
    let lines = sheet.scan.node_lines.nearest_full(&sheet.scan.tree, sheet.scan.tree.len());
    ScatteredSheet { sheet, lines, target, number }
}

#[test]
fn the_difference_of_a_sample_is_that_from_the_fit_to_the_lines_around() {
    let meter = meter(0);
    let pane = Pane { density: |_| 2.0, ..PANE };
    let mut sheet = sheet(&meter, &pane, 3, SHAPE);
    sheet.scale = Arc::new(uniform(SHAPE, 3.0));
    sheet.weighted_scale = sheet.scale.clone();
    fill(&mut sheet, &lattice(3), plane);
    let of_target = |target: f64, number: usize, more: f64| {
        let verified = scattered(&sheet, target, number);
        let points: Vec<[f64; 3]> = (0..20).map(point).collect();
        let rates: Vec<f64> = points.iter().map(|at| plane(*at) + more).collect();
        let deviations = verified.deviations(&points, &rates);
        deviations.iter().map(|of| verified.effect(of)).collect::<Vec<_>>()
    };
    for effect in of_target(0.5, 1024, 0.0) {
        assert_close(effect, 0.0, 1e-6);
    }
    let size = smallest_detected(1024, TUNING.verification.detection_share);
    for effect in of_target(0.5, 1024, -0.25) {
        assert_close(effect, 0.25 * 2.0 * 3.0 / 0.5 * WIDTH_OF_GAUSSIAN * size, 1e-5);
    }
}

#[test]
fn a_line_through_a_point_has_depths_around_it_down_to_a_part_of_a_feature() {
    let meter = meter(0);
    let mut sheet = sheet(&meter, &PANE, 3, SHAPE);
    fill(&mut sheet, &lattice(3), plane);
    let at = [0.3, 0.7, 0.4];
    let verified = scattered(&sheet, 1.0, 1024);
    let (place, depths) = verified.line_through(at);
    assert_eq!((place, depths.len() % 2), (steps(&at).0, 0));
    let size = smallest_detected(1024, TUNING.verification.detection_share);
    let finest = size / TUNING.verification.feature_parts;
    for (level, ends) in (3..).zip(depths.chunks(2)) {
        assert_eq!(ends[1] - ends[0], spacing(level));
        assert!(unit(ends[0]) <= at[2] && at[2] <= unit(ends[1]));
    }
    let last = &depths[depths.len() - 2..];
    let distance = unit(last[1] - last[0]);
    assert!(distance <= finest && finest < 2.0 * distance);
    // At the end of the line there is no depth beyond it.
    let (_, depths) = verified.line_through([0.3, 0.7, 1.0]);
    assert!(depths.iter().all(|depth| *depth <= spacing(0)));
}

#[test]
fn the_size_covered_is_detected_by_the_nearest_sample_at_99_percent_of_places() {
    let meter = meter(0);
    let mut sheet = sheet(&meter, &PANE, 3, SHAPE);
    fill(&mut sheet, &lattice(3), plane);
    let number = 256;
    let verified = scattered(&sheet, 1.0, number);
    let points: Vec<[f64; 3]> = (0..number).map(point).collect();
    let rates: Vec<f64> = points.iter().map(|at| plane(*at)).collect();
    let deviations = verified.deviations(&points, &rates);
    let square =
        |a: &[f64; 3], b: &[f64; 3]| -> f64 { (0..3).map(|k| (a[k] - b[k]).powi(2)).sum() };
    let nearest = |k: usize| {
        let place = point(2 * FIRST_LINE + k);
        points.iter().map(|at| square(at, &place)).fold(f64::INFINITY, f64::min)
    };
    let mut squares: Vec<f64> = (0..512).map(nearest).collect();
    squares.sort_by(f64::total_cmp);
    // All but 1 % of the places, which is five of them.
    let farthest = squares[512 - 6];
    let usual = smallest_detected(number, TUNING.verification.detection_share);
    for passed in [0.02, 0.2] {
        let size = verified.size_covered(&points, &deviations, passed);
        // What passes there, over the amplitude of the feature.
        let is_detected = |size: f64| {
            let amplitude = FEATURE_CONTRAST / (WIDTH_OF_GAUSSIAN * size);
            let passes = passed / (WIDTH_OF_GAUSSIAN * usual);
            amplitude * (-0.5 * farthest / (size * size)).exp() >= 1.001 * passes
        };
        assert!(is_detected(1.001 * size) && !is_detected(size / 1.1), "{passed}: {size}");
    }
}
