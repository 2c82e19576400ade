//! The parts that scenes are sums of.

use super::Resolution;
use super::ellipsoid::Ellipsoid;
use super::generator::Generator;
use super::power_law::Core;
use super::sheet::Sheet;
use super::torus::Torus;
use super::wave::Wave;
use emitree::Image;

/// A part of a scene: non-negative, smooth, 1 or less everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Component {
    Ellipsoid(Ellipsoid),
    Wave(Wave),
    Core(Core),
    Torus(Torus),
    Sheet(Sheet),
    /// The same everywhere.
    Constant,
}

impl Component {
    /// A part of the given kind, counted in the order above.
    pub(super) fn draw(kind: u32, generator: &mut Generator) -> Self {
        match kind {
            0 => Self::Ellipsoid(Ellipsoid::draw(generator)),
            1 => Self::Wave(Wave::draw(generator)),
            2 => Self::Core(Core::draw(generator)),
            3 => Self::Torus(Torus::draw(generator)),
            _ => Self::Sheet(Sheet::draw(generator)),
        }
    }

    /// The same part at another place.
    pub(super) fn moved(self, by: [f64; 3]) -> Self {
        match self {
            Self::Ellipsoid(part) => Self::Ellipsoid(part.moved(by)),
            Self::Wave(part) => Self::Wave(part.moved(by)),
            Self::Core(part) => Self::Core(part.moved(by)),
            Self::Torus(part) => Self::Torus(part.moved(by)),
            Self::Sheet(part) => Self::Sheet(part.moved(by)),
            Self::Constant => Self::Constant,
        }
    }

    /// The shortest length on which it changes: a width, a core radius, 1/k of a wave.
    pub(super) fn length(&self) -> f64 {
        match self {
            Self::Ellipsoid(part) => part.length(),
            Self::Wave(part) => part.length(),
            Self::Core(part) => part.length(),
            Self::Torus(part) => part.length(),
            Self::Sheet(part) => part.length(),
            Self::Constant => f64::INFINITY,
        }
    }

    pub(super) fn rate(&self, position: [f64; 3]) -> f64 {
        match self {
            Self::Ellipsoid(part) => part.rate(position),
            Self::Wave(part) => part.rate(position),
            Self::Core(part) => part.rate(position),
            Self::Torus(part) => part.rate(position),
            Self::Sheet(part) => part.rate(position),
            Self::Constant => 1.0,
        }
    }

    /// The image with a given number of nodes.
    pub(super) fn image(&self, shape: [usize; 2], resolution: Resolution) -> Image {
        match self {
            Self::Ellipsoid(part) => part.image(shape, resolution),
            Self::Wave(part) => part.image(shape, resolution),
            Self::Core(part) => part.image(shape, resolution),
            Self::Torus(part) => part.image(shape, resolution),
            Self::Sheet(part) => part.image(shape, resolution),
            Self::Constant => {
                let [height, width] = shape;
                Image::from_pixels(height, width, vec![1.0; height * width])
            }
        }
    }
}
