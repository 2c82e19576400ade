//! A family of scenes by number: for tests that must hold on more than a few chosen problems.
//!
//! [`random_scene`] makes the scene of a seed. Scenes are smooth, non-negative, of order 1, with
//! most of the emission inside the cube, in any orientation; lengths go down to 0.02, a little more
//! than a pixel of 1/64. A scene's kind is its seed modulo 6:
//!
//! | kind | sum of | g of one of them |
//! | --- | --- | --- |
//! | 0 gaussians | 1–6 | exp(−Σ (tᵢ/wᵢ)²), w from 0.02 to 0.5 |
//! | 1 waves | 1–2 | (1 + s)/2 exp(−r²/w²), s the product or mean of sin(kᵢ tᵢ + φᵢ), k from 3 to 25, w from 0.2 to 0.8 |
//! | 2 cores | 1–3 | (1 + r²/a²)^(−p/2), a from 0.02 to 0.2, p from 2 to 6 |
//! | 3 tori | 1–2 | Gaussian in the distance from a ring, width from 0.03 to 0.1, radius from 0.15 to 0.35 |
//! | 4 sheets | 1–2 | Gaussian across the surface t = b u², width from 0.03 to 0.15, \|b\| < 1, with an envelope |
//! | 5 mixture | 2 | two different ones of the above |
//!
//! tᵢ are coordinates along rotated axes; each part comes times an amplitude from 0.3 to 1. Every
//! seed is a scene for ever: [`random_scene`] must not change.
//!
//! # The reference image
//!
//! Line integrals are closed for gaussians and cores, and composite Gauss–Legendre quadrature along
//! z for the others. Across the image they are taken at the Gauss–Legendre nodes of panels of about
//! four widths, and pixels are exact means of the polynomials through them. The number of nodes is
//! raised until two images in succession agree; the finer one is returned, and the difference is
//! its error.

mod component;
mod ellipsoid;
mod frame;
pub(crate) mod generator;
mod peaks;
mod power_law;
mod sheet;
mod torus;
mod wave;

use component::Component;
use emitree::Image;
use generator::Generator;
pub use peaks::random_peak;

/// Nodes a panel, coarse to fine: a step divides the error by some hundreds.
const RESOLUTIONS: [Resolution; 6] = [
    Resolution { across: 14, along: 9 },
    Resolution { across: 19, along: 12 },
    Resolution { across: 24, along: 15 },
    Resolution { across: 30, along: 19 },
    Resolution { across: 38, along: 24 },
    Resolution { across: 48, along: 30 },
];
/// Images of a part that differ by less than this times its largest pixel agree.
const AGREEMENT: f64 = 2e-7;
/// What the numbers for other parameters are apart from those of the seed.
const CHANGED: u64 = 1 << 40;
/// What rounding can do to an image, relative to its largest pixel.
const ROUNDING: f64 = 1e-13;

/// How many Gauss–Legendre nodes a panel has across the image, and along the line of sight.
#[derive(Clone, Copy, Debug)]
struct Resolution {
    across: usize,
    along: usize,
}

/// A reference image and its error.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// The pixels: means of ∫ g dz.
    pub image: Image,
    /// An estimate of the largest error of a pixel, relative to the largest pixel. It is the
    /// difference to a coarser rule: the error itself is some hundred times smaller.
    pub error: f64,
}

/// What a scene is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Kind {
    /// Rotated Gaussians with three widths each.
    Gaussians,
    /// Waves under an envelope.
    Waves,
    /// Power-law cores.
    Cores,
    /// Rings with a Gaussian cross-section.
    Tori,
    /// Thin, tilted and bent sheets.
    Sheets,
    /// Two of different kinds.
    Mixture,
    /// A narrow Gaussian on a broad one and a background.
    Peak,
}

/// A scene of the family.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomScene {
    seed: u64,
    kind: Kind,
    parts: Vec<(f64, Component)>,
}

/// The scene of a seed; its kind is the seed modulo 6.
///
/// ```
/// use emitree_problems::family::random_scene;
///
/// let scene = random_scene(3);
/// assert_eq!(scene.name(), "tori-3");
/// let reference = scene.reference_image([16, 16]);
/// assert!(reference.error < 1e-6);
/// ```
pub fn random_scene(seed: u64) -> RandomScene {
    let mut generator = Generator::new(seed);
    let (kind, most) = match seed % 6 {
        0 => (Kind::Gaussians, 6),
        1 => (Kind::Waves, 2),
        2 => (Kind::Cores, 3),
        3 => (Kind::Tori, 2),
        4 => (Kind::Sheets, 2),
        _ => (Kind::Mixture, 2),
    };
    let components = match kind {
        Kind::Gaussians => vec![0; generator.whole(1..=most) as usize],
        Kind::Waves => vec![1; generator.whole(1..=most) as usize],
        Kind::Cores => vec![2; generator.whole(1..=most) as usize],
        Kind::Tori => vec![3; generator.whole(1..=most) as usize],
        Kind::Sheets => vec![4; generator.whole(1..=most) as usize],
        Kind::Mixture => {
            let first = generator.whole(0..=4);
            vec![first, (first + generator.whole(1..=4)) % 5]
        }
        Kind::Peak => Vec::new(),
    };
    let mut part =
        |component| (generator.between(0.3, 1.0), Component::draw(component, &mut generator));
    let parts = components.into_iter().map(&mut part).collect();
    RandomScene { seed, kind, parts }
}

impl RandomScene {
    /// The kind and the seed.
    pub fn name(&self) -> String {
        let kind = match self.kind {
            Kind::Gaussians => "gaussians",
            Kind::Waves => "waves",
            Kind::Cores => "cores",
            Kind::Tori => "tori",
            Kind::Sheets => "sheets",
            Kind::Mixture => "mixture",
            Kind::Peak => "peak",
        };
        format!("{kind}-{}", self.seed)
    }

    /// What it is made of.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// The shortest length on which a part of it changes: a width at which a Gaussian has fallen to
    /// 1/e, a core radius, 1/k of a wave. A method that samples points much farther apart than
    /// this can miss it.
    pub fn shortest_length(&self) -> f64 {
        self.parts.iter().fold(f64::INFINITY, |length, (_, part)| length.min(part.length()))
    }

    /// The same scene with other parameters: each part is moved along each axis by up to `change` of its
    /// shortest length, and its amplitude is another one by up to that fraction, at random.
    ///
    /// ```
    /// let scene = emitree_problems::family::random_scene(3);
    /// assert_ne!(scene.clone().changed(0.1).rate([0.5; 3]), scene.rate([0.5; 3]));
    /// ```
    #[must_use]
    pub fn changed(mut self, change: f64) -> Self {
        let generator = &mut Generator::new(self.seed ^ CHANGED);
        for (amplitude, part) in &mut self.parts {
            let most = change * part.length().min(1.0);
            *part = part.moved(core::array::from_fn(|_| most * generator.between(-1.0, 1.0)));
            *amplitude *= 1.0 + change * generator.between(-1.0, 1.0);
        }
        self
    }

    /// The emission rate at a point of the unit cube.
    ///
    /// ```
    /// let scene = emitree_problems::family::random_scene(17);
    /// assert!(scene.rate([0.5; 3]) >= 0.0);
    /// ```
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        self.parts.iter().map(|(amplitude, part)| amplitude * part.rate(position)).sum()
    }

    /// The image of `shape` = \[height, width\] pixels in the canonical projection, by
    /// [quadrature](self#the-reference-image) until two rules agree, and its error: below 3e-7 on
    /// the first 600 seeds.
    ///
    /// ```
    /// let reference = emitree_problems::family::random_scene(0).reference_image([12, 9]);
    /// assert_eq!((reference.image.height(), reference.image.width()), (12, 9));
    /// ```
    pub fn reference_image(&self, shape: [usize; 2]) -> Reference {
        let mut image = Image::zeros(shape[0], shape[1]);
        let mut error = 0.0;
        for (amplitude, part) in &self.parts {
            let (pixels, difference) = converged(part, shape);
            error += amplitude * difference;
            for (sum, pixel) in image.pixels_mut().iter_mut().zip(pixels.pixels()) {
                *sum += amplitude * pixel;
            }
        }
        let (_, largest) = image.min_max();
        Reference { image, error: error / largest + ROUNDING }
    }
}

/// The image of a part, refined until it changes no more, and its last change.
fn converged(part: &Component, shape: [usize; 2]) -> (Image, f64) {
    let mut image = part.image(shape, RESOLUTIONS[0]);
    let mut difference = f64::INFINITY;
    for &resolution in &RESOLUTIONS[1..] {
        let finer = part.image(shape, resolution);
        difference = image.max_difference(&finer);
        image = finer;
        if difference <= AGREEMENT * image.min_max().1 {
            break;
        }
    }
    (image, difference)
}

#[cfg(test)]
mod tests;
