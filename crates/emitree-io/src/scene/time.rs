//! `[time]`: the exposure of an image, and how the observer moves meanwhile.

use super::accuracy::boolean;
use super::camera::{Camera, Shape, ShapeOfScene};
use super::document::{Node, Value};
use super::error::SceneError;
use super::source::Place;
use super::table::Table;
use crate::exposure::{Events, Exposure, Motion, Path, PathError};
use crate::units::Unit;
use emitree::energy::EnergyError;
use emitree::vol::Seed;
use emitree::{EnergyAxis, EnergyScale};

/// How far a shape may be from where it was, relative to its distance from the camera: rounding, and the error of a
/// path through some hundred points.
const KEPT: f64 = 1e-7;
/// Times at which it is tested, beside those of the path.
const TESTS: usize = 33;

/// The exposure as it is written.
pub(super) struct GivenTime {
    pub(super) exposure: Exposure,
    /// Where the table is.
    place: Place,
    /// Where the motion is, and where its targets are.
    observer: Option<Place>,
    targets: Option<Place>,
    /// Where it is said that light travels.
    light: Option<Place>,
}

/// The table; `up` is that of the camera.
pub(super) fn read(mut table: Table, up: [f64; 3]) -> Result<GivenTime, SceneError> {
    const TIME: &str = "a time in seconds";
    const BINS: &str = "a number of bins of the time, 1 to 65536";
    let place = table.place().clone();
    let (start, stop) = (table.require("start", TIME)?, table.require("stop", TIME)?);
    let bins = table.take("bins");
    let light = table.take("light_travel_time");
    let observer = table.table("observer")?;
    table.finish()?;

    let (from, to) = (start.number()?, stop.number()?);
    let count = bins.as_ref().map_or(Ok(1), |bins| bins.count(BINS))?;
    let axis = EnergyAxis::new(from, to, count, EnergyScale::Linear).map_err(|error| {
        let bins = bins.as_ref().unwrap_or(&stop);
        match error {
            EnergyError::Range { .. } => {
                stop.refuse(&to.to_string(), &format!("more than {from}, the `start`"))
            }
            EnergyError::Bins(count) => bins.refuse(&count.to_string(), BINS),
            EnergyError::Narrow { least, .. } if to - from < least => {
                let expected = format!("more than the `start`, {from:?}, by {least:.1e} or more");
                stop.refuse(&format!("{to:?}"), &expected)
            }
            EnergyError::Narrow { bins: count, least, .. } => {
                bins.refuse(&count.to_string(), &format!("bins of {least:.1e} s or more"))
            }
            other => SceneError::at(&place, format!("`[time]`: {other}")),
        }
    })?;
    let light_travels = light.as_ref().map_or(Ok(false), boolean)?;
    let light = light.filter(|_| light_travels).map(|node| node.place);
    let at = observer.as_ref().map(|table| table.place().clone());
    let (motion, targets) = match observer {
        Some(table) => read_observer(table, [from, to], up).map(|(of, at)| (Some(of), at))?,
        None => (None, None),
    };
    let exposure = Exposure::new(axis, motion, light_travels);
    Ok(GivenTime { exposure, place, observer: at, targets, light })
}

/// The motion of the observer, and where its targets are.
fn read_observer(
    mut table: Table,
    [start_s, stop_s]: [f64; 2],
    up: [f64; 3],
) -> Result<(Motion, Option<Place>), SceneError> {
    const VELOCITY: &str = "three numbers [x, y, z] in `length_unit` per second";
    const TIMES: &str = "an array of times in seconds, as in [0, 10, 20]";
    const POINTS: &str = "an array of points [x, y, z] in `length_unit`, one for each time";
    let whole = table.place().clone();
    let velocity = table.take("velocity");
    let (times, positions) = (table.take("times"), table.take("positions"));
    let targets = table.take("targets");
    table.finish()?;
    let place_of_targets = targets.as_ref().map(|node| node.place.clone());
    let (times, positions) = match (velocity, times, positions, &targets) {
        (Some(velocity), None, None, None) => {
            let velocity = velocity.vector(VELOCITY)?;
            return Ok((Motion::Velocity { start_s, velocity }, None));
        }
        (None, Some(times), Some(positions), _) => (times, positions),
        _ => {
            let message = "`[time.observer]` is neither a velocity nor a path";
            return Err(SceneError::at(&whole, message).label(
                "expected `velocity = [x, y, z]`, or `times` and `positions` (and `targets`)",
            ));
        }
    };
    let at: Vec<f64> = times.list(TIMES)?.into_iter().map(|(time, _)| time).collect();
    let path = |node: &Node| {
        Path::new(&at, &vectors(node, POINTS)?).map_err(|error| {
            let node = if matches!(error, PathError::Points { .. }) { node } else { &times };
            SceneError::at(&node.place, format!("`time.observer`: {error}"))
        })
    };
    let along = path(&positions)?;
    let [first, last] = along.range();
    if start_s < first || stop_s > last {
        let expected = format!("times from {start_s} to {stop_s} or beyond, those of the exposure");
        return Err(times.refuse(&format!("from {first} to {last}"), &expected));
    }
    let targets = targets.as_ref().map(path).transpose()?;
    Ok((Motion::Along { positions: along, targets, up }, place_of_targets))
}

fn vectors(node: &Node, expected: &str) -> Result<Vec<[f64; 3]>, SceneError> {
    match &node.value {
        Value::Array(items) => items.iter().map(|item| item.vector(expected)).collect(),
        _ => Err(node.refuse(node.value.kind(), expected)),
    }
}

impl GivenTime {
    /// Refuses energies beside times.
    pub(super) fn refuse_energies(&self) -> SceneError {
        SceneError::at(&self.place, "the scene has `[time]` and `[energy]`")
            .label("expected one of them: the third axis of a cube is the energy or the time")
    }

    /// Whether the observer moves.
    pub(super) fn moves(&self) -> bool {
        self.observer.is_some()
    }

    /// Where and when samples of the camera are evaluated; none if it is where and when they are.
    pub(super) fn events(
        &self,
        camera: &Camera,
        shapes: &[ShapeOfScene],
        seeds: &[Seed],
        length_unit: Option<&str>,
    ) -> Result<Option<Events>, SceneError> {
        let Some(place) = self.observer.as_ref().or(self.light.as_ref()) else { return Ok(None) };
        let Some(pointing) = camera.pointing() else {
            let name = camera.description().name;
            return Err(SceneError::at(place, format!("the projection `{name}` has no observer"))
                .label("expected another `type` in `[projection]`, which has a `position`"));
        };
        if let (Some(place), None) = (&self.targets, pointing.axes) {
            return Err(SceneError::at(place, "`time.observer.targets` are given for a whole sky")
                .label("expected none: it has no point in the middle"));
        }
        let metre =
            |unit: &str| Unit::parse(unit).and_then(|unit| unit.factor_to(&Unit::parse("m")?));
        let length_m = match (&self.light, length_unit) {
            (None, _) => None,
            (Some(place), None) => {
                return Err(SceneError::at(place, "`time.light_travel_time` needs a length unit")
                    .label("expected `length_unit` in `[projection]` too, as in \"km\""));
            }
            (Some(place), Some(unit)) => Some(metre(unit).map_err(|error| {
                SceneError::at(place, format!("`time.light_travel_time`: {error}"))
            })?),
        };
        let is_parallel = !camera.description().has_solid_angles;
        let Some(events) = self.exposure.events(pointing, length_m, is_parallel) else {
            return Ok(None);
        };
        if events.moves() {
            self.check_motion(&events, pointing.position)?;
            self.check_shapes(&events, pointing.position, shapes, seeds)?;
        }
        Ok(Some(events))
    }

    /// The times at which things are tested.
    fn tests(&self) -> Vec<f64> {
        let axis = self.exposure.times().axis();
        let uniform = (0..TESTS).map(|k| axis.energy(k as f64 / (TESTS - 1) as f64));
        let of_path = match self.exposure.motion() {
            Some(Motion::Along { positions, .. }) => positions.times(),
            _ => &[],
        };
        let is_in = |time: &&f64| (axis.min()..=axis.max()).contains(*time);
        uniform.chain(of_path.iter().filter(is_in).copied()).collect()
    }

    /// Refuses a camera that at some time has no direction of its middle, or of up.
    fn check_motion(&self, events: &Events, camera: [f64; 3]) -> Result<(), SceneError> {
        for time in self.tests() {
            let turned = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|of| events.vector_at(time, of));
            let moved = events.point_at(time, camera);
            if turned.as_flattened().iter().chain(&moved).all(|along| along.is_finite()) {
                continue;
            }
            let place = self.targets.as_ref().or(self.observer.as_ref()).unwrap_or(&self.place);
            let message = format!("the camera has no orientation at {time} s");
            return Err(SceneError::at(place, message).label(
                "expected a target that is not at the position, nor straight along `up` from there",
            ));
        }
        Ok(())
    }

    /// Refuses shapes that are not at the same place relative to the camera all the time.
    fn check_shapes(
        &self,
        events: &Events,
        camera: [f64; 3],
        shapes: &[ShapeOfScene],
        seeds: &[Seed],
    ) -> Result<(), SceneError> {
        for time in self.tests() {
            for ShapeOfScene { name, place, shape } in shapes {
                let Some(by) = moved_by(events, time, shape, camera) else { continue };
                let message = format!("{name} does not move with the observer");
                return Err(SceneError::at(place, message)
                    .label(format!(
                        "expected a shape that is at the same place relative to the camera all the time: at {time:.6} \
                         s this one {by}"
                    ))
                    .help(
                        "no bounds, but `near` and `far`; bodies only where the observer turns about them; or many \
                         short exposures, each with a camera that does not move (in Python \
                         `emitree.Exposure(..., snapshots=True)`)",
                    ));
            }
            for (number, seed) in seeds.iter().enumerate() {
                let point = Shape::Point(seed.position);
                if let Some(by) = moved_by(events, time, &point, camera) {
                    let message =
                        format!("`[[seed]]` {} does not move with the observer", number + 1);
                    return Err(SceneError::at(&self.place, message)
                        .label(format!("expected no seeds: at {time:.6} s this one {by}")));
                }
            }
        }
        Ok(())
    }
}

/// How a shape is elsewhere, relative to the camera, at a time; none if it is where the camera has it.
fn moved_by(events: &Events, time: f64, shape: &Shape, camera: [f64; 3]) -> Option<String> {
    let point = |at: [f64; 3]| difference(events.point_at(time, at), at);
    let vector = |of: [f64; 3]| difference(events.vector_at(time, of), of);
    let kept = |at: [f64; 3]| KEPT * length(difference(at, camera));
    let shifted = |by: [f64; 3]| Some(format!("is {:.3e} away", length(by)));
    let turned = || Some("has turned".to_owned());
    let is_turned = |of: [f64; 3]| length(vector(of)) > KEPT * length(of);
    match *shape {
        Shape::Point(at) if length(point(at)) > kept(at) => shifted(point(at)),
        Shape::Ellipsoid { centre, semi_axes } => {
            let [a, b, c] = semi_axes.map(length);
            let is_sphere = (a - b).abs().max((a - c).abs()) <= KEPT * a;
            match length(point(centre)) > kept(centre) {
                true => shifted(point(centre)),
                false if !is_sphere && semi_axes.into_iter().any(is_turned) => turned(),
                false => None,
            }
        }
        // Even if it only turns by a right angle, it does not meanwhile.
        Shape::Box => {
            let moved = point(camera);
            let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
            match axes.into_iter().any(is_turned) {
                true => turned(),
                false if length(moved) > 0.0 => shifted(moved),
                false => None,
            }
        }
        Shape::Plane { position, normal } => {
            let across = dot(point(position), normal);
            match across.abs() > kept(position) {
                true => Some(format!("is {:.3e} away", across.abs())),
                false => is_turned(normal).then(turned).flatten(),
            }
        }
        Shape::Axis { position, direction } => {
            let by = point(position);
            let along = dot(by, direction);
            let across: [f64; 3] = core::array::from_fn(|i| by[i] - along * direction[i]);
            match length(across) > kept(position) {
                true => shifted(across),
                false => is_turned(direction).then(turned).flatten(),
            }
        }
        Shape::Point(_) => None,
    }
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|i| a[i] - b[i])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn length(vector: [f64; 3]) -> f64 {
    dot(vector, vector).sqrt()
}

#[cfg(test)]
mod tests;
