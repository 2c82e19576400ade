//! The tests of the crate's public interface.
//!
//! One binary, since each one links the whole library, and its tests share the processors.

mod derivatives;
mod emissivity;
mod model_properties;
mod models;
mod smile_images;
mod smile_view1;
mod spectra;
