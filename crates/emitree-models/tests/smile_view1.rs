//! CMEM in the view of the SMILE SXI camera, against an image computed by `reference/smile_view1.py`:
//! the model and the camera's orientation together.

use emitree::projection::{GeometryError, MappedPoint};
use emitree::{Emission, Equirectangular, Projection, Samples, Viewpoint};
use emitree_models::{Model, build_model};
use std::collections::BTreeMap;

const REFERENCE: &str = include_str!("reference/smile_view1.csv");

const HEIGHT: f64 = 100.0;
const WIDTH: f64 = 50.0;

fn camera() -> Result<Equirectangular, GeometryError> {
    let viewpoint =
        Viewpoint { position: [10.0, -30.0, 0.0], target: [6.0, 0.0, 0.0], up: [0.0, 0.0, 1.0] };
    let fov_rad = [16.0_f64.to_radians(), 27.0_f64.to_radians()];
    Equirectangular::new(viewpoint, fov_rad, [0.0, 80.0])
}

/// The midpoint rule with `steps` steps on the line of sight through a pixel's centre.
fn radiance(model: &Model, camera: &Equirectangular, [row, column]: [f64; 2], steps: u32) -> f64 {
    let depth = |step: u32| (f64::from(step) + 0.5) / f64::from(steps);
    let [x, y] = [(column + 0.5) / WIDTH, (row + 0.5) / HEIGHT];
    let points: Vec<MappedPoint> =
        (0..steps).map(|step| camera.world_from_canonical([x, y, depth(step)])).collect();
    let positions: Vec<_> = points.iter().map(|point| point.position).collect();
    let directions: Vec<_> = points.iter().map(|point| point.direction).collect();
    let mut rates = vec![f64::NAN; points.len()];
    let Ok(()) = model.emission_rates(&Samples::new(&positions, &directions), &mut rates);
    let weighted = rates.iter().zip(&points).map(|(rate, point)| rate * point.path_per_depth);
    weighted.sum::<f64>() / f64::from(steps)
}

#[test]
fn pixels_of_view_1() {
    let (model, camera) = (build_model("cmem", &BTreeMap::new()).unwrap(), camera().unwrap());
    let mut checked = 0;
    for line in REFERENCE.lines().skip(1) {
        let numbers: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
        let [row, column, converged, midpoint] = numbers[..] else { panic!("{line}") };
        let coarse = radiance(&model, &camera, [row, column], 160);
        assert!((coarse / midpoint - 1.0).abs() < 1e-12, "{row}, {column}: {coarse}, {midpoint}");
        // Steps of 0.008 R_E: each surface crossed adds an error of up to half a step.
        let fine = radiance(&model, &camera, [row, column], 10_000);
        assert!((fine / converged - 1.0).abs() < 1e-3, "{row}, {column}: {fine}, {converged}");
        checked += 1;
    }
    assert_eq!(checked, 22);
}
