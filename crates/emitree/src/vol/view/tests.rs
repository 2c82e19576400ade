//! Sheets, layers in view, verification lines and scattered samples of synthetic views.

mod samples;
mod sheets;
mod verification;
mod visible;
