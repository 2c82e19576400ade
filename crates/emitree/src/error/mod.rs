//! Errors: [`RenderError`], and the options that it names.

mod option;
pub(crate) mod render;

pub use option::OptionError;
pub(crate) use render::RenderError;
