//! emitree in Python: the compiled half of the package.
//!
//! Thin, frozen classes around one Rust type each. What is convenient rather than needed (cameras
//! with keywords, units, plots, executors, caches) is written in Python, beside this module.
//!
//! * `scene`: a scene that was read and checked, and what is made of it;
//! * `session`: a rendering in ask-and-tell form;
//! * `mesh`: the frozen quadrature of a session;
//! * `bridge`: the rendering works on threads of its own and hands batches to the thread that
//!   called, which alone runs Python;
//! * `emission`: the emission of a scene, or a function in Python, for the library;
//! * `expression`, `model`: expressions and built-in models with their derivatives; `points`: arrays of points
//!   for them;
//! * `table`: tables of functions, for expressions;
//! * `rendering`: an image or a cube with its error and its cost;
//! * `cameras`: the kinds of cameras that scenes have, for the classes in Python;
//! * `lines`: lines of sight, for what integrates along them in Python;
//! * `arrays`: images and cubes as arrays of `NumPy`; the memory for others;
//! * `output`: files that are whole or absent;
//! * `error`: errors as exceptions, all in one place.

mod arrays;
mod bridge;
mod cameras;
mod emission;
mod error;
mod expression;
mod lines;
mod mesh;
mod model;
mod output;
mod points;
mod rendering;
mod scene;
mod session;
mod surfaces;
mod table;

/// emitree's compiled half: use `emitree`.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use crate::arrays::available_memory_bytes;
    #[pymodule_export]
    use crate::cameras::{cameras, sky_coordinates};
    #[pymodule_export]
    use crate::error::{EmissionError, RenderError, SceneError};
    #[pymodule_export]
    use crate::expression::Expression;
    #[pymodule_export]
    use crate::mesh::Mesh;
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::output::OutputFile;
    #[pymodule_export]
    use crate::rendering::{Rendered, components_fits, draw_counts};
    #[pymodule_export]
    use crate::scene::Scene;
    #[pymodule_export]
    use crate::session::Session;
    #[pymodule_export]
    use crate::table::Table;

    /// The version of the package.
    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "the name that Python has for it")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
