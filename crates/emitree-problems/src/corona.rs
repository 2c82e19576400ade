//! The Sun's K corona above the limb of an opaque Sun, whose brightness spans decades, with a reference by
//! quadrature.
//!
//! The lines of sight are parallel to the Sun's equator. By symmetry a quarter of the image is enough. The
//! square roots at the Sun's surface, at the limb and at the equator are removed by substitutions.

use crate::gauss::Gauss;
use emitree::projection::GeometryError;
use emitree::projection::{Bounds, Ellipsoid};
use emitree::{Image, Orthographic, Viewpoint};
use emitree_models::models::KCorona;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The radius of the bounds of the corona, in `R_sun`.
const RADIUS: f64 = 20.0;

/// The direction in which light is emitted: towards the observer at negative y.
const DIRECTION: [f64; 3] = [0.0, -1.0, 0.0];

/// The corona with the observer's camera.
#[derive(Clone, Copy, Debug)]
pub struct Corona {
    corona: KCorona,
    /// The width and the height of the image, in `R_sun`.
    extent: f64,
}

/// The nodes along each axis of a pixel, and on each of [`PANELS`] of a line.
const FINE: [usize; 2] = [6, 16];
const COARSE: [usize; 2] = [4, 10];
/// The parts of a line of sight. Their ends are at fourth powers, so that those next to the Sun are short.
const PANELS: usize = 12;

impl Corona {
    /// The corona in an image of `extent` × `extent` solar radii.
    #[expect(clippy::missing_panics_doc, reason = "a corona without parameters exists")]
    pub fn new(extent: f64) -> Self {
        #[expect(clippy::expect_used, reason = "a corona without parameters exists")]
        let corona = KCorona::new(&BTreeMap::new()).expect("defaults");
        Self { corona, extent }
    }

    /// The rate at a position, per solar radius.
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        self.corona.rate(position, DIRECTION)
    }

    /// The camera, with the Sun as an opaque body.
    ///
    /// # Errors
    ///
    /// None for an extent above 0.
    pub fn camera(&self) -> Result<Orthographic, GeometryError> {
        let viewpoint =
            Viewpoint { position: [0.0, -215.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
        let bounds = Bounds::Ellipsoid(Ellipsoid::sphere([0.0; 3], RADIUS)?);
        let sun = Ellipsoid::sphere([0.0; 3], 1.0)?;
        let camera = Orthographic::new(viewpoint, [self.extent; 2], [0.0, 430.0])?;
        camera.with_bounds(bounds).with_occulters(vec![sun])
    }

    /// The image on `pixels` × `pixels` pixels, an even number, and the largest difference of a pixel from a
    /// coarser quadrature, relative to that pixel.
    pub fn reference(&self, pixels: usize) -> (Image, f64) {
        let [fine, coarse] = [FINE, COARSE].map(|nodes| self.image(pixels, nodes));
        let both = fine.pixels().iter().zip(coarse.pixels());
        let error = both.map(|(fine, coarse)| ((fine - coarse) / fine).abs()).fold(0.0, f64::max);
        (fine, error)
    }

    fn image(&self, pixels: usize, [in_pixel, on_line]: [usize; 2]) -> Image {
        let [in_pixel, on_line] = [in_pixel, on_line].map(Gauss::new);
        let half = pixels / 2;
        let side = self.extent / pixels as f64;
        let quarter: Vec<f64> = (0..half * half)
            .into_par_iter()
            .map(|k| {
                self.mean([k % half, k / half].map(|i| i as f64 * side), side, &in_pixel, &on_line)
            })
            .collect();
        let mirrored = |i: usize| if i < half { half - 1 - i } else { i - half };
        let value = |i: usize| quarter[mirrored(i / pixels) * half + mirrored(i % pixels)];
        Image::from_pixels(pixels, pixels, (0..pixels * pixels).map(value).collect())
    }

    /// The mean over the pixel whose corner nearest to the centre is at [x, z].
    fn mean(&self, [x, z]: [f64; 2], side: f64, in_pixel: &Gauss, on_line: &Gauss) -> f64 {
        let limb = |a: f64| (1.0 - a * a).max(0.0).sqrt();
        // The columns in which the limb enters or leaves the pixel at its lower or upper side.
        let mut columns = vec![x, x + side];
        columns
            .extend([limb(z), limb(z + side)].into_iter().filter(|at| x < *at && *at < x + side));
        columns.sort_by(f64::total_cmp);
        let of_column = |x: f64| {
            let at = limb(x).clamp(z, z + side);
            let mut sum = 0.0;
            for (from, to) in [(z, at), (at, z + side)].into_iter().filter(|(from, to)| to > from) {
                // Steep at both ends: at the equator, and at the limb on its outer side.
                let middle = 0.5 * (from + to);
                for (end, other) in [(from, middle), (to, middle)] {
                    let length = (other - end).abs();
                    let sign = (other - end).signum();
                    sum += in_pixel.integrate(0.0, 1.0, |t| {
                        let z = end + sign * length * t * t;
                        2.0 * t * length * self.line(x, z, on_line)
                    });
                }
            }
            sum
        };
        let between = |pair: &[f64]| in_pixel.integrate(pair[0], pair[1], of_column);
        columns.windows(2).map(between).sum::<f64>() / (side * side)
    }

    /// The integral along the line of sight at x and z.
    fn line(&self, x: f64, z: f64, rule: &Gauss) -> f64 {
        let square = x * x + z * z;
        let first = (1.0 - square).max(0.0).sqrt();
        let length = (RADIUS * RADIUS - square).max(0.0).sqrt() - first;
        let rate = |t: f64| {
            let y = first + length * t.powi(4);
            4.0 * t.powi(3) * length * self.rate([x, y, z])
        };
        let sides = if first > 0.0 { 1.0 } else { 2.0 };
        sides * rule.integrate_panels([0.0, 1.0], PANELS, rate)
    }
}
