//! Parts of views, sheets, verification lines and scattered samples of synthetic views.

mod parts;
mod samples;
mod sheets;
mod verification;
