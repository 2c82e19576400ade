//! Batches, and what a short budget does to them.

use super::*;
use crate::projection::MappedPoint;
use crate::vol::testing::{PANE, Pane, answered, assert_close, at, meter, view};

/// The left half of the image is in view, on paths of 3.
const HALF: Pane = Pane { is_open: |[x, _]| x < 0.5, path: 3.0, ..PANE };

fn points(columns: &[u32]) -> Vec<(Place, u32)> {
    columns.iter().map(|&k| (at(3, k, 5), at(3, 2, 0)[0])).collect()
}

#[test]
fn a_rate_is_that_of_its_point_along_its_path() {
    let meter = meter(10);
    let rate = |[x, y, z]: [f64; 3], energy: f64| {
        assert!(energy.is_nan());
        x + 10.0 * y + 100.0 * z
    };
    let view = view(&meter, &HALF);
    let rates = answered(&meter, rate, view.rates(&points(&[0, 1, 7]))).unwrap();
    assert_close(rates[0], 3.0 * (6.25 + 25.0), 1e-12);
    assert_close(rates[1], 3.0 * (0.125 + 6.25 + 25.0), 1e-12);
    assert_eq!(rates[2].to_bits(), 0);
    assert_eq!((meter.evaluations(), meter.batches()), (2, 1));
}

#[test]
fn a_rate_at_an_energy_has_its_density() {
    let meter = meter(10);
    let energy = Some(EnergySample { energy: 7.0, density: 0.25 });
    let view = View { energy, ..view(&meter, &HALF) };
    let rates = answered(&meter, |_, energy| energy, view.rates(&points(&[0]))).unwrap();
    assert_close(rates[0], 3.0 * 7.0 * 0.25, 1e-12);
    let site = view.site([0, 0, 0], None);
    assert_eq!((site.energy, site.point.path_per_depth), (None, 3.0));
    assert_eq!(site.tile, (0, 1));
}

#[test]
fn a_batch_that_the_budget_does_not_allow_is_not_begun() {
    for (allowed, made) in [(2, None), (3, Some(3))] {
        let meter = meter(allowed);
        let view = view(&meter, &HALF);
        let result = answered(&meter, |_, _| 1.0, view.rates(&points(&[0, 1, 2])));
        match made {
            Some(_) => assert_eq!(result.unwrap(), [3.0; 3]),
            None => assert!(matches!(result, Err(Stop::Budget))),
        }
        assert_eq!(meter.evaluations(), made.unwrap_or(0));
    }
}

#[test]
fn points_out_of_view_need_no_budget() {
    let meter = meter(1);
    let view = view(&meter, &HALF);
    let rates = answered(&meter, |_, _| 1.0, view.rates(&points(&[3, 4, 5, 6]))).unwrap();
    assert_eq!(rates, [3.0, 0.0, 0.0, 0.0]);
    assert_eq!(meter.evaluations(), 1);
    let rates = answered(&meter, |_, _| 1.0, view.rates(&points(&[4, 5]))).unwrap();
    assert_eq!(rates, [0.0; 2]);
    assert!(answered(&meter, |_, _| 1.0, view.rates(&points(&[0]))).is_err());
}

#[test]
fn a_rate_that_is_no_number_fails() {
    let meter = meter(10);
    let view = view(&meter, &PANE);
    let rate = |[x, ..]: [f64; 3], _| if x > 0.2 { f64::NAN } else { 1.0 };
    let result = answered(&meter, rate, view.rates(&points(&[0, 2])));
    assert!(matches!(result, Err(Stop::Failed(RenderError::NotFinite { .. }))));
}

/// A pane with bodies between the depths 0.25 and 0.35 and between 0.7 and 0.9, on paths of 3.
#[derive(Debug)]
struct WithBodies;

const BODIES: [[f64; 2]; 2] = [[0.25, 0.35], [0.7, 0.9]];

impl Chart for WithBodies {
    fn world_from_chart(&self, u: [f64; 3]) -> MappedPoint {
        MappedPoint { position: u, direction: [0.0, 0.0, -1.0], path_per_depth: 3.0 }
    }

    fn chart_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        Some(position)
    }

    fn density(&self, _xy: [f64; 2]) -> f64 {
        1.0
    }

    fn has_gaps(&self) -> bool {
        true
    }

    fn across_gap(&self, [x, y, z]: [f64; 3]) -> Option<AcrossGap> {
        let [enter, leave] = BODIES.into_iter().find(|[enter, leave]| *enter < z && z < *leave)?;
        // A straight line through the two points on the surface.
        let share = (z - enter) / (leave - enter);
        let mut gap = AcrossGap { around: [MappedPoint::default(); 10], weights: [0.0; 10] };
        let ends = [(enter, 1.0 - share), (leave, share)].into_iter().chain([(enter, 0.0); 8]);
        for (k, (z, weight)) in ends.enumerate() {
            let point = self.world_from_chart([x, y, z]);
            gap.around[k] = MappedPoint { path_per_depth: 1.0, ..point };
            gap.weights[k] = 3.0 * weight;
        }
        Some(gap)
    }

    fn image_place(&self, uv: [f64; 2]) -> (usize, [f64; 2]) {
        (0, uv)
    }
}

#[test]
fn points_inside_a_body_have_the_sum_of_those_around_it() {
    let energy = Some(EnergySample { energy: 7.0, density: 0.25 });
    let rate = |[x, _, z]: [f64; 3], energy: f64| {
        assert!(BODIES.iter().all(|[enter, leave]| z <= *enter || z >= *leave), "{z}");
        if energy.is_nan() { 1.0 + x + 2.0 * z } else { energy * (1.0 + x + 2.0 * z) }
    };
    let points: Vec<(Place, u32)> = (1..8).map(|k| (at(3, 2, 5), at(3, k, 0)[0])).collect();
    for (energy, scale) in [(None, 3.0), (energy, 3.0 * 0.25 * 7.0)] {
        let meter = meter(100);
        let view = View { energy, ..view(&meter, &WithBodies) };
        let rates = answered(&meter, rate, view.rates(&points)).unwrap();
        for (k, rate) in (1..8).zip(rates) {
            assert_close(rate, scale * (1.25 + 0.25 * f64::from(k)), 1e-12);
        }
        // Ten points instead of the two in the second body.
        assert_eq!((meter.evaluations(), meter.batches()), (5 + 10, 1));
    }
}

#[test]
fn points_in_one_gap_of_a_line_share_those_around_it() {
    let meter = meter(1000);
    let view = view(&meter, &WithBodies);
    let rate = |[x, y, z]: [f64; 3], _| 1.0 + x + 5.0 * y + 2.0 * z;
    // Of the 31 depths of a line 3 are in the first body and 6 in the second.
    let depths = (1..32).map(|k| at(5, k, 0)[0]);
    let points: Vec<(Place, u32)> =
        depths.flat_map(|depth| [2, 3].map(|column| (at(3, column, 5), depth))).collect();
    let rates = answered(&meter, rate, view.rates(&points)).unwrap();
    for (rate, ([x, y], depth)) in rates.iter().zip(&points) {
        let expected = 1.0 + unit(*x) + 5.0 * unit(*y) + 2.0 * unit(*depth);
        assert_close(*rate, 3.0 * expected, 1e-12);
    }
    assert_eq!((meter.evaluations(), meter.batches()), (2 * (31 - 9 + 2 * 10), 1));
}
