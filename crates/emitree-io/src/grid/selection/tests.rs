//! Files that `numpy`, astropy, h5py and scipy have written: `tests/reference/steps.py`.

use super::super::{AxisNodes, Step, read_grid};
use super::*;
use std::path::PathBuf;

fn path(name: &str) -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "tests/reference/steps", name].iter().collect()
}

fn request(values: Option<&str>, step: Option<Step>) -> GridRequest {
    GridRequest { values: values.map(str::to_owned), step, ..GridRequest::default() }
}

fn along(axis: &str, step: Step) -> Step {
    Step { axis: Some(axis.to_owned()), ..step }
}

fn check(name: &str, request: &GridRequest, step: f64) {
    let grid = read_grid(&path(name), request).unwrap().grid;
    assert_eq!(grid.nodes()[0], [-1.0, 0.0, 2.0, 6.0], "{name}");
    assert_eq!(grid.shape(), [4, 3, 2], "{name}");
    let mut expected = Vec::new();
    for z in [0.0, 100.0] {
        for y in [0.0, 10.0, 20.0] {
            expected.extend([0.0, 1.0, 2.0, 3.0].map(|x| 1000.0 * step + x + y + z));
        }
    }
    assert_eq!(grid.values(), expected, "{name}");
}

#[test]
fn every_format_has_steps() {
    for (step, number) in [(Step::index(0), 0.0), (Step::index(2), 2.0), (Step::index(-2), 1.0)] {
        let of_values = request(None, Some(step.clone()));
        for name in ["steps.npz", "fortran.npz", "steps.fits"] {
            check(name, &of_values, number);
        }
        let nodes = [[-1.0, 0.0, 2.0, 6.0].to_vec(), vec![0.0, 0.5, 2.0], vec![10.0, 20.0]];
        check("steps.npy", &GridRequest { nodes: nodes.map(AxisNodes::List), ..of_values }, number);
    }
    check("one.npz", &request(None, None), 1.0);
}

#[cfg(feature = "hdf5")]
#[test]
fn dimensions_with_names_tell_which_axis_has_steps() {
    for (step, number) in [(Step::index(1), 1.0), (Step::index(-1), 2.0), (Step::value(3.0), 1.0)] {
        check("records.nc", &request(None, Some(step.clone())), number);
        check("last.h5", &request(Some("run/g"), Some(step)), number);
    }
}

#[cfg(feature = "hdf5")]
#[test]
fn meshes_of_openpmd_have_their_axes_in_attributes() {
    for (name, first) in [("data/100/meshes/rho", 0.0), ("/data/100/meshes/B/x", 1000.0)] {
        let grid = read_grid(&path("openpmd.h5"), &request(Some(name), None)).unwrap().grid;
        let expected = [&[-0.5, 0.0, 0.5, 1.0][..], &[0.125, 0.375, 0.625], &[5.0, 10.0]];
        assert_eq!(grid.nodes(), expected, "{name}");
        assert_eq!(grid.values()[..5], [0.0, 1.0, 2.0, 3.0, 10.0].map(|value| first + value));
    }
}

#[test]
fn a_value_is_that_of_the_nearest_step() {
    for (value, number) in [(0.0, 0.0), (1.2, 0.0), (1.3, 1.0), (10.0, 2.0)] {
        let step = along("t", Step::value(value));
        check("steps.npz", &request(None, Some(step.clone())), number);
        check("steps.fits", &request(None, Some(step)), number);
    }
}

#[test]
fn what_is_wrong_with_a_step_is_said() {
    let message = |name: &str, step: Option<Step>| {
        let error = read_grid(&path(name), &request(None, step)).unwrap_err();
        assert_eq!(error.cause.concerns(), "step");
        error.cause.to_string()
    };
    let cases = [
        (
            None,
            "the values are an array of shape [3, 2, 3, 4]: expected three axes, or `step`, which \
             chooses one of the 3 along the axis 0 of the array",
        ),
        (
            Some(Step::index(3)),
            "the step is 3: expected one of the 3 along the axis 0 of the array, from 0, or from -1 \
             backwards",
        ),
        (
            Some(Step::index(-4)),
            "the step is -4: expected one of the 3 along the axis 0 of the array, from 0, or from -1 \
             backwards",
        ),
        (
            Some(along("t", Step::value(11.0))),
            "the step is that at 11: expected 0 to 10, the range of their coordinates",
        ),
        (
            Some(Step::value(1.0)),
            "the axis of the steps has no name: expected `step.axis`, the array of their coordinates, \
             or `step.index`",
        ),
        (
            Some(along("x", Step::value(1.0))),
            "the axis of the steps has 4 coordinates: expected 3, one for each step",
        ),
    ];
    for (step, expected) in cases {
        assert_eq!(message("steps.npz", step), expected);
    }
    let cube = [env!("CARGO_MANIFEST_DIR"), "tests/reference/grids/plain.npz"];
    let cube: PathBuf = cube.iter().collect();
    let error = read_grid(&cube, &request(None, Some(Step::index(0)))).unwrap_err().cause;
    assert_eq!(
        error.to_string(),
        "the values are an array of shape [2, 3, 4]: expected four axes, or no `step`"
    );
}
