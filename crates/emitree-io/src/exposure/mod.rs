//! Exposures: the times of an image, `[time]` of a scene, and what the observer does meanwhile.
//!
//! g depends on the time t as it may depend on an energy: the time is the third axis of a cube, and each bin is the
//! mean over its times. A camera that moves keeps its lines of sight relative to itself; only the points in the world
//! that it sees are others at each time. So the cube is that of the camera as the scene describes it, and each sample
//! is evaluated where and when it is seen: [`Events`].

mod events;
mod path;

pub use events::{Events, Motion};
pub use path::{Path, PathError};

use crate::energies::Energies;
use crate::sky::Pointing;
use emitree::EnergyAxis;

/// The times of an image and the observer's motion: a scene's `[time]`.
///
/// ```
/// use emitree_io::Scene;
///
/// let text = r#"
///     emission.expression = "exp(-t)"
///     projection.type = "canonical"
///     image = { width = 2, height = 2 }
///     time = { start = 0, stop = 1 }
/// "#;
/// let scene = Scene::parse("example", text, &[])?;
/// let exposure = scene.exposure.as_ref().ok_or("no exposure")?;
/// assert_eq!((exposure.range_s(), exposure.times().axis().bins()), ([0.0, 1.0], 1));
/// let found = scene.render(&scene.emission, &scene.render_options())?;
/// let mean = 1.0 - (-1.0_f64).exp();
/// assert!((found.values.bands()[0][(0, 0)] / mean - 1.0).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Exposure {
    times: Energies,
    motion: Option<Motion>,
    light_travels: bool,
}

impl Exposure {
    /// From the first time of an axis to its last \[s\]; `light_travels` if the emission is that of the time at which
    /// the light that is seen was emitted.
    pub fn new(axis: EnergyAxis, motion: Option<Motion>, light_travels: bool) -> Self {
        Self { times: Energies::times(axis), motion, light_travels }
    }

    /// The bins of the time \[s\].
    pub fn times(&self) -> &Energies {
        &self.times
    }

    /// The start and the end \[s\].
    pub fn range_s(&self) -> [f64; 2] {
        [self.times.axis().min(), self.times.axis().max()]
    }

    /// How the observer moves, if it does.
    pub fn motion(&self) -> Option<&Motion> {
        self.motion.as_ref()
    }

    /// Whether the time that light travels counts.
    pub fn light_travels(&self) -> bool {
        self.light_travels
    }

    /// Where and when samples of a camera are evaluated; none if it is where and when they are. `length_m` are the
    /// metres in one length unit, `is_parallel` is whether the lines of sight are.
    pub(crate) fn events(
        &self,
        pointing: &Pointing,
        length_m: Option<f64>,
        is_parallel: bool,
    ) -> Option<Events> {
        let speed =
            length_m.filter(|_| self.light_travels).map(|length_m| SPEED_OF_LIGHT / length_m);
        if self.motion.is_none() && speed.is_none() {
            return None;
        }
        Some(Events::new(*pointing, self.motion.clone(), speed, is_parallel))
    }
}

/// In a vacuum [m s⁻¹], exact since 1983.
const SPEED_OF_LIGHT: f64 = 299_792_458.0;
