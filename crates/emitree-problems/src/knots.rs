//! Knots: one small Gaussian at a random place before a background, to measure how small a structure a
//! method detects without a seed.
//!
//! The unit cube is seen along z. A knot has a standard deviation, a place that is drawn by the number of
//! the set and its own, and an image peak: the largest pixel that it would have alone, relative to the
//! largest pixel of the background. Every place is the same for ever. Images are exact: means of Gaussians
//! by erf, means of modes in closed form.

use crate::family::generator::Generator;
use crate::means;
use core::f64::consts::TAU;
use emitree::Image;

/// Knots stay this far from the border of the cube.
const MARGIN: f64 = 0.1;
/// The standard deviation of the weak background.
const BROAD: f64 = 0.25;
/// How many modes the turbulence has, and the lengths of their waves.
const MODES: u32 = 64;
const WAVES: [f64; 2] = [0.1, 1.0];
/// The root of the mean square of the fluctuations, relative to the mean.
const FLUCTUATION: f64 = 0.25;

/// What a knot is before.
#[derive(Clone, Debug, PartialEq)]
pub enum Background {
    /// A broad Gaussian about the centre of the cube: a few hundred evaluations show all of it.
    Smooth,
    /// 1 + Σ aᵢ cos(kᵢ · r + φᵢ), 64 modes in all directions.
    Turbulence(Vec<Mode>),
}

/// A wave: amplitude, wave vector, phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    amplitude: f64,
    wave: [f64; 3],
    phase: f64,
}

impl Background {
    /// Turbulence of 64 random modes, the same always: wavelengths from 0.1 to 1, all ratios equally
    /// likely, with amplitudes as the cube root of them, which is Kolmogorov's spectrum.
    pub fn turbulence() -> Self {
        let mut generator = Generator::new(64);
        let mut draw = |_| {
            let length = generator.log_between(WAVES[0], WAVES[1]);
            let [direction, _, _] = generator.axes();
            let phase = generator.between(0.0, TAU);
            Mode { amplitude: libm::cbrt(length), wave: direction.map(|x| TAU / length * x), phase }
        };
        let mut modes: Vec<Mode> = (0..MODES).map(&mut draw).collect();
        let power: f64 = modes.iter().map(|mode| 0.5 * mode.amplitude * mode.amplitude).sum();
        let scale = FLUCTUATION / power.sqrt();
        modes.iter_mut().for_each(|mode| mode.amplitude *= scale);
        Self::Turbulence(modes)
    }

    /// What it is called in tables.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Smooth => "smooth",
            Self::Turbulence(_) => "turbulence",
        }
    }

    /// The emission rate at a point of the unit cube.
    ///
    /// ```
    /// use emitree_problems::knots::Background;
    ///
    /// assert!(Background::Smooth.rate([0.5; 3]) > Background::Smooth.rate([0.0; 3]));
    /// ```
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        match self {
            Self::Smooth => gaussian(position, [0.5; 3], BROAD),
            Self::Turbulence(modes) => {
                1.0 + modes.iter().map(|mode| mode.rate(position)).sum::<f64>()
            }
        }
    }

    /// The exact image of `shape` = \[height, width\] pixels.
    pub fn exact_image(&self, shape: [usize; 2]) -> Image {
        match self {
            Self::Smooth => gaussian_image([0.5; 3], BROAD, shape),
            Self::Turbulence(modes) => {
                let mut image = Image::zeros(shape[0], shape[1]);
                for (at, pixel) in image.pixels_mut().iter_mut().enumerate() {
                    let (low, high) = borders(at, shape);
                    let means = modes.iter().map(|mode| mode.mean(low, high));
                    *pixel = 1.0 + means.sum::<f64>();
                }
                image
            }
        }
    }
}

impl Mode {
    fn rate(&self, position: [f64; 3]) -> f64 {
        let phase: f64 = self.wave.iter().zip(position).map(|(k, x)| k * x).sum();
        self.amplitude * (phase + self.phase).cos()
    }

    /// The mean over a box: the value in its middle times sin(h)/h for half the phase along each side.
    fn mean(&self, low: [f64; 3], high: [f64; 3]) -> f64 {
        let middle = core::array::from_fn(|i| 0.5 * (low[i] + high[i]));
        let damping = (0..3).map(|i| {
            let half = 0.5 * self.wave[i] * (high[i] - low[i]);
            if half.abs() < 1e-8 { 1.0 } else { half.sin() / half }
        });
        self.rate(middle) * damping.product::<f64>()
    }
}

/// The lowest and the highest corner of the volume of a pixel, pixels counted row after row.
fn borders(at: usize, [height, width]: [usize; 2]) -> ([f64; 3], [f64; 3]) {
    let (row, column) = ((at / width) as f64, (at % width) as f64);
    let (rows, columns) = (height as f64, width as f64);
    ([column / columns, row / rows, 0.0], [(column + 1.0) / columns, (row + 1.0) / rows, 1.0])
}

/// A knot before a background.
#[derive(Clone, Debug)]
pub struct Knot<'a> {
    background: &'a Background,
    place: [f64; 3],
    width: f64,
    rate: f64,
    image: Image,
}

impl<'a> Knot<'a> {
    /// Knot `number` of a `set`, of standard deviation `width` and image peak `peak`, in the image of
    /// `shape` = \[height, width\] pixels whose background is `behind`, an
    /// [`exact_image`](Background::exact_image).
    ///
    /// ```
    /// use emitree_problems::knots::{Background, Knot};
    ///
    /// let background = Background::Smooth;
    /// let behind = background.exact_image([16, 16]);
    /// let knot = Knot::new((0, 7), 0.02, 0.2, &background, &behind);
    /// let brighter = knot.exact_image().max_difference(&behind) / behind.min_max().1;
    /// assert!((brighter - 0.2).abs() < 1e-12);
    /// ```
    pub fn new(
        (set, number): (u64, u64),
        width: f64,
        peak: f64,
        background: &'a Background,
        behind: &Image,
    ) -> Self {
        let mut generator = Generator::new((set << 32) + number);
        let place = core::array::from_fn(|_| generator.between(MARGIN, 1.0 - MARGIN));
        let shape = [behind.height(), behind.width()];
        let alone = gaussian_image(place, width, shape);
        let rate = peak * behind.min_max().1 / alone.min_max().1;
        let mut image = behind.clone();
        for (pixel, knot) in image.pixels_mut().iter_mut().zip(alone.pixels()) {
            *pixel += rate * knot;
        }
        Self { background, place, width, rate, image }
    }

    /// The emission rate at a point of the unit cube.
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        self.background.rate(position) + self.rate * gaussian(position, self.place, self.width)
    }

    /// Where it is.
    pub fn place(&self) -> [f64; 3] {
        self.place
    }

    /// The exact image, background included.
    pub fn exact_image(&self) -> &Image {
        &self.image
    }
}

/// exp(−r²/(2 s²)).
fn gaussian(position: [f64; 3], centre: [f64; 3], width: f64) -> f64 {
    let square: f64 = position.iter().zip(centre).map(|(x, c)| (x - c) * (x - c)).sum();
    (-0.5 * square / (width * width)).exp()
}

/// The image of that.
fn gaussian_image(centre: [f64; 3], width: f64, shape: [usize; 2]) -> Image {
    let steepness = 0.5 / (width * width);
    let means = |axis: usize, count: usize| -> Vec<f64> {
        let border = |i: usize| i as f64 / count as f64;
        let mean = |i| means::gaussian(steepness, centre[axis], border(i), border(i + 1));
        (0..count).map(mean).collect()
    };
    let (columns, rows, depth) = (means(0, shape[1]), means(1, shape[0]), means(2, 1)[0]);
    let row =
        |row: &f64| columns.iter().map(move |column| row * column * depth).collect::<Vec<_>>();
    let pixels = rows.iter().flat_map(row).collect();
    Image::from_pixels(shape[0], shape[1], pixels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brute;

    #[test]
    fn images_agree_with_brute_force() {
        let shape = [20, 30];
        for background in [Background::Smooth, Background::turbulence()] {
            let behind = background.exact_image(shape);
            let knot = Knot::new((1, 3), 0.03, 0.5, &background, &behind);
            let [x, y, _] = knot.place();
            // The pixel of the knot, and some.
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "small, positive"
            )]
            let of_knot = [(20.0 * y) as usize, (30.0 * x) as usize];
            for at in [of_knot, [0, 0], [3, 29], [11, 17]] {
                let brute = brute::pixel(|position| knot.rate(position), shape, at, 12);
                let far = (knot.exact_image()[at.into()] - brute).abs();
                assert!(far < 1e-9 * behind.min_max().1, "{} {at:?}: {far:e}", background.name());
            }
        }
    }

    #[test]
    fn places_never_change() {
        let background = Background::Smooth;
        let behind = background.exact_image([4, 4]);
        let place = |set, number| Knot::new((set, number), 0.1, 0.1, &background, &behind).place();
        assert_ne!(place(0, 0).map(f64::to_bits), place(1, 0).map(f64::to_bits));
        for set in 0..2 {
            for number in 0..60 {
                assert!(place(set, number).iter().all(|x| (MARGIN..1.0 - MARGIN).contains(x)));
            }
        }
        let expected = [0.563_068_619_855_469_1, 0.626_494_068_268_249_8, 0.560_120_891_945_344_2];
        assert_eq!(place(1, 5).map(f64::to_bits), expected.map(f64::to_bits));
    }

    /// Turbulence is positive, of mean one, and fluctuates.
    #[test]
    fn turbulence_is_positive() {
        let turbulence = Background::turbulence();
        let at = |i: u32, step: f64| (f64::from(i) * step).fract();
        let rates = (0..20_000).map(|i| {
            turbulence.rate([at(i, 0.819_172_513), at(i, 0.671_043_606), at(i, 0.549_700_478)])
        });
        let rates: Vec<f64> = rates.collect();
        let mean = rates.iter().sum::<f64>() / rates.len() as f64;
        let variance =
            rates.iter().map(|g| (g - mean) * (g - mean)).sum::<f64>() / rates.len() as f64;
        assert!((mean - 1.0).abs() < 0.05, "{mean}");
        assert!((variance.sqrt() - FLUCTUATION).abs() < 0.05, "{variance}");
        assert!(rates.iter().all(|&rate| rate > 0.0));
    }
}
