//! Lines of sight, for what integrates along them in Python.

use crate::arrays::vectors;
use emitree::Projection;
use emitree::projection::MappedPoint;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

/// A point on each line, unit vectors away from the observer, the ends of the lines as distances from
/// these points, and dΩ/(dx dy).
pub(crate) type Lines<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
);

/// One line of sight.
struct Line {
    point: [f64; 3],
    /// Away from the observer.
    direction: [f64; 3],
    /// The distances of both ends from the point, infinite ones too; equal if nothing is in view.
    ends: [f64; 2],
    /// dΩ/(dx dy) \[sr\], or an area; 0 where there is no image.
    solid_angle_density: f64,
}

/// The lines of sight at places (x, y) of the canonical image plane.
pub(crate) fn lines<'py>(
    py: Python<'py>,
    camera: &dyn Projection,
    x: &[f64],
    y: &[f64],
) -> PyResult<Lines<'py>> {
    let found: Vec<Line> =
        py.detach(|| x.iter().zip(y).map(|(&x, &y)| line(camera, [x, y])).collect());
    let points: Vec<_> = found.iter().map(|line| line.point).collect();
    let directions: Vec<_> = found.iter().map(|line| line.direction).collect();
    let numbers = |of: fn(&Line) -> f64| PyArray1::from_iter(py, found.iter().map(of));
    Ok((
        vectors(py, &points)?,
        vectors(py, &directions)?,
        numbers(|line| line.ends[0]),
        numbers(|line| line.ends[1]),
        numbers(|line| line.solid_angle_density),
    ))
}

fn line(camera: &dyn Projection, xy: [f64; 2]) -> Line {
    const DEPTHS: [f64; 3] = [0.0, 0.5, 1.0];
    let mut points = [MappedPoint::default(); 3];
    match camera.view_geometry() {
        Some(geometry) => geometry.points_of_line(xy, &DEPTHS, &mut points),
        None => points = DEPTHS.map(|z| camera.world_from_canonical([xy[0], xy[1], z])),
    }
    let [near, middle, far] = points;
    let direction = middle.direction.map(|component| -component);
    let end = |point: &MappedPoint, infinite: f64| match point.path_per_depth {
        0.0 => infinite,
        _ => (0..3).map(|k| (point.position[k] - middle.position[k]) * direction[k]).sum(),
    };
    let ends = match middle.path_per_depth {
        0.0 => [0.0; 2],
        _ => [end(&near, f64::NEG_INFINITY), end(&far, f64::INFINITY)],
    };
    let solid_angle_density = camera.solid_angle_density(xy);
    Line { point: middle.position, direction, ends, solid_angle_density }
}
