//! A scene of several components as several scenes, which share their rates.

use super::emission::{ComponentEmission, ComponentRates, EmissionSource};
use super::{Scene, SceneEmission};
use std::sync::Arc;

/// The components of a scene, each as a scene with one emission rate. A point that several of them need is
/// evaluated once.
///
/// ```
/// use emitree_io::Scene;
///
/// let text = r#"
///     [emission]
///     expressions = ["exp(-a*x^2)", "y*exp(-a*x^2)"]
///     components = ["total", "polarised"]
///     constants = { a = 4 }
///     [projection]
///     type = "canonical"
///     [image]
///     width = 8
///     height = 8
/// "#;
/// let scene = Scene::parse("example", text, &[])?;
/// let components = scene.components().unwrap();
/// assert_eq!(components.names(), ["total", "polarised"]);
/// let mut alone = 0;
/// for scene in components.scenes() {
///     alone += scene.render(&scene.emission, &scene.render_options())?.stats.evaluations;
/// }
/// assert!(components.evaluations() < alone);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SceneComponents {
    scenes: Vec<Scene>,
    rates: Arc<ComponentRates>,
}

impl SceneComponents {
    /// The scene of each component, in the order of the expressions. The limits of the scene are those of each.
    pub fn scenes(&self) -> &[Scene] {
        &self.scenes
    }

    /// Their names.
    pub fn names(&self) -> &[String] {
        self.rates.names()
    }

    /// At how many points the rates of all components have been evaluated so far, for all scenes together.
    pub fn evaluations(&self) -> u64 {
        self.rates.evaluations()
    }
}

impl Scene {
    /// The components of a scene with `expressions`; none if its emission is a single rate. Nothing is known of
    /// their rates yet.
    pub fn components(&self) -> Option<SceneComponents> {
        let EmissionSource::Components(rates) = &self.emission.source else { return None };
        let rates = Arc::new(rates.anew());
        let scene_of = |number| {
            let source = EmissionSource::Component(ComponentEmission::new(&rates, number));
            let emission = SceneEmission { source, ..self.emission.clone() };
            Self { emission, ..self.clone() }
        };
        let scenes = (0..rates.names().len()).map(scene_of).collect();
        Some(SceneComponents { scenes, rates })
    }

    /// The names of the components of a scene with `expressions`; none if its emission is a single rate.
    pub fn component_names(&self) -> Option<&[String]> {
        match &self.emission.source {
            EmissionSource::Components(rates) => Some(rates.names()),
            _ => None,
        }
    }
}
