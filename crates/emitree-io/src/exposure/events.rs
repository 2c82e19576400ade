//! Where and when a sample of a camera is evaluated: the camera moves as a rigid body, and light takes time.

use super::path::Path;
use crate::sky::Pointing;
use emitree::Samples;

/// How an observer moves. The camera's `position` and `target` are those of no time in particular: they say which
/// coordinates its samples have.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Motion {
    /// From the position of the camera at a time, without turning.
    Velocity {
        /// The time at which the camera is at its position \[s\].
        start_s: f64,
        /// In length units per second.
        velocity: [f64; 3],
    },
    /// Through points at times.
    Along {
        /// The observer, in length units.
        positions: Path,
        /// The points in the middle of the image; none if the camera does not turn.
        targets: Option<Path>,
        /// The direction that is up in the image.
        up: [f64; 3],
    },
}

/// Maps samples of a camera as it is described to the points that it sees at their times.
///
/// A point r of the camera at p, with the axes A (right, up, forward), is at p(t) + A(t) Aᵀ (r − p) at the time t, and
/// its direction of emission turns with the axes. Light that travels left it at t − distance/c. Aberration is ignored.
#[derive(Clone, Debug, PartialEq)]
pub struct Events {
    camera: Pointing,
    motion: Option<Motion>,
    /// In length units per second, if the light's time counts.
    speed_of_light: Option<f64>,
    is_parallel: bool,
}

/// The camera at a time.
#[derive(Clone, Copy)]
struct Moved {
    position: [f64; 3],
    /// Its axes, if they turn.
    axes: Option<[[f64; 3]; 3]>,
}

impl Events {
    pub(super) fn new(
        camera: Pointing,
        motion: Option<Motion>,
        speed_of_light: Option<f64>,
        is_parallel: bool,
    ) -> Self {
        Self { camera, motion, speed_of_light, is_parallel }
    }

    /// Calls a function with the samples where and when they are seen; their energies are times \[s\].
    pub fn seen<T>(&self, samples: &Samples<'_>, of: impl FnOnce(&Samples<'_>) -> T) -> T {
        let mut positions = samples.positions().to_vec();
        let mut directions = samples.directions().to_vec();
        let mut times = samples.energies().to_vec();
        let mut last: Option<(f64, Moved)> = None;
        let points = positions.iter_mut().zip(&mut directions).zip(&mut times);
        for ((position, direction), time) in points {
            let moved = match last {
                Some((of, moved)) if of.to_bits() == time.to_bits() => moved,
                _ => self.at(*time),
            };
            last = Some((*time, moved));
            if let Some(speed) = self.speed_of_light {
                *time -= self.distance(*position) / speed;
            }
            *position = self.point(&moved, *position);
            *direction = self.vector(&moved, *direction);
        }
        of(&Samples::new(&positions, &directions).at_energies(&times))
    }

    /// Whether the camera moves.
    pub(crate) fn moves(&self) -> bool {
        self.motion.is_some()
    }

    /// Where a point of the camera is at a time.
    pub(crate) fn point_at(&self, time: f64, position: [f64; 3]) -> [f64; 3] {
        self.point(&self.at(time), position)
    }

    /// Where a vector of the camera points at a time.
    pub(crate) fn vector_at(&self, time: f64, vector: [f64; 3]) -> [f64; 3] {
        self.vector(&self.at(time), vector)
    }

    fn at(&self, time: f64) -> Moved {
        match &self.motion {
            None => Moved { position: self.camera.position, axes: None },
            Some(Motion::Velocity { start_s, velocity }) => {
                let along = |i: usize| self.camera.position[i] + velocity[i] * (time - start_s);
                Moved { position: core::array::from_fn(along), axes: None }
            }
            Some(Motion::Along { positions, targets, up }) => {
                let position = positions.at(time);
                let turned = |target: &Path| Pointing::new(position, target.at(time), *up).axes;
                Moved { position, axes: targets.as_ref().and_then(turned) }
            }
        }
    }

    fn point(&self, moved: &Moved, position: [f64; 3]) -> [f64; 3] {
        let from_camera = core::array::from_fn(|i| position[i] - self.camera.position[i]);
        let turned = self.vector(moved, from_camera);
        core::array::from_fn(|i| moved.position[i] + turned[i])
    }

    fn vector(&self, moved: &Moved, vector: [f64; 3]) -> [f64; 3] {
        let (Some(now), Some(axes)) = (moved.axes, self.camera.axes) else { return vector };
        let along = axes.map(|axis| dot(axis, vector));
        core::array::from_fn(|i| (0..3).map(|k| along[k] * now[k][i]).sum())
    }

    /// From a point of the camera to the observer, or of parallel lines to the plane of the image.
    fn distance(&self, position: [f64; 3]) -> f64 {
        let from_camera: [f64; 3] = core::array::from_fn(|i| position[i] - self.camera.position[i]);
        match self.camera.axes {
            Some([_, _, forward]) if self.is_parallel => dot(forward, from_camera),
            _ => dot(from_camera, from_camera).sqrt(),
        }
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOWN: [f64; 3] = [0.0, 0.0, -1.0];

    fn camera() -> Pointing {
        Pointing::new([10.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0])
    }

    fn seen(events: &Events, position: [f64; 3], direction: [f64; 3], time: f64) -> [[f64; 3]; 3] {
        let samples = ([position], [direction], [time]);
        events.seen(&Samples::new(&samples.0, &samples.1).at_energies(&samples.2), |seen| {
            [seen.positions()[0], seen.directions()[0], [seen.energies()[0], 0.0, 0.0]]
        })
    }

    #[test]
    fn a_velocity_moves_points_and_keeps_directions() {
        let motion = Motion::Velocity { start_s: 2.0, velocity: [0.0, 3.0, 0.0] };
        let events = Events::new(camera(), Some(motion), None, false);
        let found = seen(&events, [1.0, 2.0, 3.0], DOWN, 4.0);
        assert_eq!(found, [[1.0, 8.0, 3.0], DOWN, [4.0, 0.0, 0.0]]);
    }

    /// A camera that circles the origin, and looks at it, sees each point turned about the origin.
    #[test]
    fn an_orbit_turns_points_about_its_centre() {
        let times: Vec<f64> = (0..=64).map(|k| f64::from(k) / 64.0).collect();
        let points: Vec<[f64; 3]> =
            times.iter().map(|t| [10.0 * t.cos(), 10.0 * t.sin(), 0.0]).collect();
        let targets = Path::new(&times, &vec![[0.0; 3]; 65]).unwrap();
        let positions = Path::new(&times, &points).unwrap();
        let motion = Motion::Along { positions, targets: Some(targets), up: [0.0, 0.0, 1.0] };
        let events = Events::new(camera(), Some(motion), None, false);
        let [position, direction, _] = seen(&events, [1.0, 2.0, 3.0], [1.0, 0.0, 0.0], 0.7);
        let (cos, sin) = (0.7_f64.cos(), 0.7_f64.sin());
        let exact = [cos - 2.0 * sin, sin + 2.0 * cos, 3.0, cos, sin, 0.0];
        for (found, exact) in position.into_iter().chain(direction).zip(exact) {
            assert!((found - exact).abs() < 1e-8, "{found} {exact}");
        }
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "the distances are whole numbers")]
    fn light_left_earlier_by_the_distance() {
        let from = [10.0, 3.0, 4.0];
        let of = |is_parallel| Events::new(camera(), None, Some(0.5), is_parallel);
        assert_eq!(seen(&of(false), from, DOWN, 7.0)[2][0], 7.0 - 5.0 / 0.5);
        // The plane of the image is at x = 10, and its camera looks towards smaller x.
        assert_eq!(seen(&of(true), [6.0, 3.0, 4.0], DOWN, 7.0)[2][0], 7.0 - 4.0 / 0.5);
    }
}
