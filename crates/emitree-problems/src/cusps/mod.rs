//! Cusps: emissions that are infinite at a point, or finite and far narrower than a pixel there, and
//! their exact images.
//!
//! g = F(s) about a point, s = √(r² + core²), as r^−γ with γ below 3. Its line of sight at a distance b
//! has about b^(1 − γ), so that the radiance is infinite through the point for γ ≥ 1, and the mean over a
//! pixel is finite. There are
//!
//! * [`nfw_halo`]: annihilating dark matter in the centre of the Milky Way, g ~ r⁻²;
//! * [`power_law`]: r^−γ in parallel lines of sight;
//! * [`comet`]: a coma, r⁻², with a jet, which depends on the direction from the nucleus;
//! * [`random_cusps`]: a family by number, with one or two points.
//!
//! # The reference image
//!
//! A line of sight is integrated over u, t = a sinh u from its closest point, a = √(b² + core²):
//! the integrand is smooth in u at any distance. Its closest point comes from the offset on the image
//! plane, without differences of nearly equal numbers (`lens.rs`). A pixel that contains the point, or is less
//! than half a pixel from it, is a sum of triangles between the point and its sides, in polar coordinates
//! with σ = sᵐ for the radius, which makes the singularity smooth (`pixel.rs`). Other pixels have
//! products of Gauss–Legendre rules. Everything is done with two sets of rules; the largest relative
//! difference of a pixel is the error.

mod cusp;
mod lens;
mod named;
mod pixel;
mod random;
mod reference;

use crate::family::Reference;
use cusp::{Cusp, End};
use emitree::Projection;
use emitree::projection::{Bounds, Ellipsoid, GeometryError, Singularity};
use lens::{Kind, Lens, Seen};
pub use named::{GEV2_CM5_PER_KPC, Place, comet, nfw_halo, power_law};
use pixel::Pixel;
pub use random::random_cusps;

/// One Gaussian of a smooth background: amplitude · exp(−|r − centre|²/width²).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Blob {
    centre: [f64; 3],
    amplitude: f64,
    width: f64,
}

/// An emission with cusps, and a camera.
#[derive(Debug)]
pub struct CuspView {
    name: String,
    lens: Lens,
    camera: Box<dyn Projection>,
    shape: [usize; 2],
    cusps: Vec<Cusp>,
    seen: Vec<Seen>,
    background: Vec<Blob>,
}

impl CuspView {
    fn new(
        name: String,
        lens: Lens,
        shape: [usize; 2],
        cusps: Vec<Cusp>,
        background: Vec<Blob>,
    ) -> Result<Self, GeometryError> {
        let end = cusps.iter().find_map(|cusp| match cusp.end {
            End::Sphere(radius) => {
                Some(Ellipsoid::sphere(cusp.position, radius).map(Bounds::Ellipsoid))
            }
            End::Fading(_) => None,
        });
        let declared =
            |cusp: &Cusp| Singularity::point(cusp.position)?.with_exponent(cusp.radial.exponent());
        let declared = cusps.iter().map(declared).collect::<Result<_, _>>()?;
        let camera = lens.camera(end.transpose()?, declared)?;
        let seen = cusps.iter().map(|cusp| lens.seen(cusp.position)).collect();
        Ok(Self { name, lens, camera, shape, cusps, seen, background })
    }

    /// What it is called in tables.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The camera, with its singular points, and with bounds if the emission has an end.
    pub fn camera(&self) -> &dyn Projection {
        &*self.camera
    }

    /// Height and width of the image in pixels.
    pub fn shape(&self) -> [usize; 2] {
        self.shape
    }

    /// The emission rate; infinite at a point without a core.
    ///
    /// ```
    /// use emitree_problems::cusps::{Place, power_law};
    ///
    /// let view = power_law(1.5, Place::Centre);
    /// assert!((view.rate([0.0, 0.25, 0.0]) - 8.0).abs() < 1e-14);
    /// assert_eq!(view.rate([0.0; 3]), f64::INFINITY);
    /// ```
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        let of_blob = |blob: &Blob| {
            let offset = cusp::advanced(position, -1.0, blob.centre);
            blob.amplitude * libm::exp(-cusp::dot(offset, offset) / (blob.width * blob.width))
        };
        self.cusps.iter().map(|cusp| cusp.rate(position)).sum::<f64>()
            + self.background.iter().map(of_blob).sum::<f64>()
    }

    /// The points, each with γ of the rate r^−γ close to it: what a renderer may be told. A point may be
    /// out of view.
    pub fn points(&self) -> impl ExactSizeIterator<Item = ([f64; 3], f64)> {
        self.cusps.iter().map(|cusp| (cusp.position, cusp.radial.exponent()))
    }

    /// The image, radiances, and a bound on the error of each pixel relative to that pixel, by
    /// [quadrature](self#the-reference-image).
    pub fn reference(&self) -> Reference {
        reference::image(self)
    }

    /// The solid angle of each pixel \[sr\], row after row; the area for parallel lines of sight.
    pub fn solid_angles(&self) -> Vec<f64> {
        let [height, width] = self.shape;
        let rule = crate::gauss::Gauss::new(7);
        let solid_angle =
            |number| self.pixel(number).tensor(&rule, |place| self.lens.density(place));
        (0..height * width).map(solid_angle).collect()
    }

    /// A pixel on the image plane, counted row after row.
    fn pixel(&self, number: usize) -> Pixel {
        let [height, width] = self.shape;
        let [half_width, half_height] = self.lens.half;
        let border = |at: usize, count: usize, half: f64| {
            // 0 in the middle, exactly.
            half * (2.0 * at as f64 - count as f64) / count as f64
        };
        let (row, column) = (number / width, number % width);
        let corner = |row: usize, column: usize| {
            [border(column, width, half_width), border(row, height, half_height)]
        };
        Pixel { low: corner(row, column), high: corner(row + 1, column + 1) }
    }
}

impl Lens {
    fn is_parallel(&self) -> bool {
        self.kind == Kind::Parallel
    }
}

#[cfg(test)]
mod tests;
