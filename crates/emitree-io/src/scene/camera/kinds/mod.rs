//! The kinds of cameras: one row each, and one file each.

mod canonical;
mod equirectangular;
mod fisheye;
mod healpix;
mod orthographic;
mod perspective;
mod polar;

use super::description::CameraDescription;

/// All cameras, in the order of messages and of the guide.
static CAMERAS: [CameraDescription; 7] = [
    canonical::CANONICAL,
    orthographic::ORTHOGRAPHIC,
    perspective::PERSPECTIVE,
    equirectangular::EQUIRECTANGULAR,
    polar::POLAR,
    fisheye::FISHEYE,
    healpix::HEALPIX,
];

/// The descriptions of all kinds of cameras.
///
/// ```
/// use emitree_io::cameras;
///
/// for camera in cameras() {
///     println!("{}: {}", camera.name, camera.summary);
///     for key in camera.keys {
///         println!("    {}: {}, {}", key.name, key.value, key.meaning);
///     }
/// }
/// ```
pub fn cameras() -> &'static [CameraDescription] {
    &CAMERAS
}

#[cfg(test)]
mod tests;
