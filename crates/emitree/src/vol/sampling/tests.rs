//! Batches, and what a short budget does to them.

use super::*;
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
