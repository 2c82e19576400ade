//! The test function of the paper that the method comes from: waves and a bump in the unit cube.

use super::{BLOCK, fill_blocks};
use crate::catalogue::model::{Formula, formula};
use crate::catalogue::parameter::{AcceptedRange, ParameterDefault, ParameterDescription, Values};
use crate::catalogue::singular::nowhere;
use crate::catalogue::{ModelDescription, ModelError};
use crate::elementary::Elementary;
use crate::means;
use crate::scalar::Scalar;
use core::f64::consts::SQRT_2;
use emitree::{Image, Samples};
use std::collections::BTreeMap;

pub(crate) const DESCRIPTION: ModelDescription = ModelDescription {
    name: "holmstrom",
    title: "Waves and a bump in the unit cube, Holmström's eq. (8)",
    summary: "A smooth test function with a narrow bump, made to be imaged on the canonical cube, \
              [0, 1]^3.",
    source: "M. Holmström, Fast Visualization of Volume Emissions using Conservative Subdivision, \
             eq. (8)",
    length_unit: "1",
    image_unit: "",
    energy_unit: None,
    parameters: &[ParameterDescription {
        name: "alpha",
        unit: "1",
        default: ParameterDefault::Value(100.0),
        meaning: "sharpness of the bump, whose width falls as 1/sqrt(alpha)",
        range: AcceptedRange::NonNegative,
    }],
    jumps_move_with: &[],
    edges: nowhere,
    singular_points: nowhere,
    build: formula!(|values| Holmstrom::from_values(values)),
};

/// Of the waves along x, y and z.
const WAVE_NUMBERS: [f64; 3] = [5.0, 7.0, 11.0];

/// The test function of Holmström, eq. (8):
///
/// g = (sin 5x sin 7y sin 11z / 10)² + exp(−α (x − √2/3)²/√2 − α (y − √7/5)² √2 − α (z − √6/5)² √3)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Holmstrom<T = f64> {
    centre: [f64; 3],
    /// α times the factor of each axis.
    sharpness: [T; 3],
}

impl Holmstrom {
    /// The function with these parameters: `alpha` or nothing.
    ///
    /// # Errors
    ///
    /// [`ModelError`] for another parameter, or a negative `alpha`.
    ///
    /// ```
    /// use emitree_models::models::Holmstrom;
    /// use std::collections::BTreeMap;
    ///
    /// let function = Holmstrom::new(&BTreeMap::new())?;
    /// let bump = [2.0_f64.sqrt() / 3.0, 7.0_f64.sqrt() / 5.0, 6.0_f64.sqrt() / 5.0];
    /// assert!((function.rate(bump) - 1.0).abs() < 0.01);
    /// # Ok::<(), emitree_models::ModelError>(())
    /// ```
    pub fn new(parameters: &BTreeMap<String, f64>) -> Result<Self, ModelError> {
        Ok(Self::from_values(&DESCRIPTION.values(parameters)?))
    }

    /// The function with this α ≥ 0; 100 in the paper.
    pub fn with_alpha(alpha: f64) -> Self {
        Self::of_alpha(alpha)
    }

    /// The rate g at a position.
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        let mut rates = [0.0];
        self.fill_block(&[position], &mut rates);
        rates[0]
    }

    /// The exact image on the [canonical cube](emitree::Canonical), of `shape` = \[height, width\]
    /// pixels, if α > 0: both terms are products, so the mean of a pixel is a product of means along the
    /// axes.
    ///
    /// ```
    /// use emitree_models::models::Holmstrom;
    ///
    /// let image = Holmstrom::with_alpha(100.0).exact_image([64, 64]);
    /// let (_, brightest) = image.min_max();
    /// assert!((brightest - 0.133_824_707_425_712_45).abs() < 1e-15);
    /// ```
    pub fn exact_image(&self, [height, width]: [usize; 2]) -> Image {
        let along = |axis: usize, pixels: usize| -> Vec<[f64; 2]> {
            let border = |i: usize| i as f64 / pixels as f64;
            (0..pixels).map(|i| self.means(axis, border(i), border(i + 1))).collect()
        };
        let (columns, rows) = (along(0, width), along(1, height));
        let [bump_depth, wave_depth] = self.means(2, 0.0, 1.0);
        let wave_depth = wave_depth / 100.0;
        let pixels = rows.iter().flat_map(|[bump_y, wave_y]| {
            columns.iter().map(move |[bump_x, wave_x]| {
                bump_depth * bump_x * bump_y + wave_depth * wave_x * wave_y
            })
        });
        Image::from_pixels(height, width, pixels.collect())
    }

    /// The means of the factors of both terms, bump and waves, along an axis.
    fn means(&self, axis: usize, from: f64, to: f64) -> [f64; 2] {
        let bump = means::gaussian(self.sharpness[axis], self.centre[axis], from, to);
        [bump, means::sine_squared(WAVE_NUMBERS[axis], from, to)]
    }
}

impl<T: Scalar> Holmstrom<T> {
    fn from_values(values: &Values<T>) -> Self {
        Self::of_alpha(values.of("alpha"))
    }

    fn of_alpha(alpha: T) -> Self {
        Self {
            centre: [SQRT_2 / 3.0, 7.0_f64.sqrt() / 5.0, 6.0_f64.sqrt() / 5.0],
            sharpness: [1.0 / SQRT_2, SQRT_2, 3.0_f64.sqrt()].map(|factor| alpha * factor),
        }
    }

    fn fill_block(&self, positions: &[[f64; 3]], rates: &mut [T]) {
        let mut scratch = [T::of(0.0); BLOCK];
        let scratch = &mut scratch[..positions.len()];
        rates.fill(T::of(0.1));
        for (axis, wave_number) in WAVE_NUMBERS.into_iter().enumerate() {
            for (angle, position) in scratch.iter_mut().zip(positions) {
                *angle = T::of(wave_number * position[axis]);
            }
            T::apply(Elementary::Sin, scratch);
            rates.iter_mut().zip(&*scratch).for_each(|(waves, sine)| *waves = *waves * *sine);
        }
        for (exponent, position) in scratch.iter_mut().zip(positions) {
            let along =
                |axis: usize| self.sharpness[axis] * (position[axis] - self.centre[axis]).powi(2);
            *exponent = -(along(0) + along(1) + along(2));
        }
        T::apply(Elementary::Exp, scratch);
        for (rate, bump) in rates.iter_mut().zip(&*scratch) {
            *rate = *rate * *rate + *bump;
        }
    }
}

impl<T: Scalar> Formula<T> for Holmstrom<T> {
    fn fill(&self, samples: &Samples<'_>, rates: &mut [T]) {
        fill_blocks(samples, rates, |positions, rates| self.fill_block(positions, rates));
    }
}

emission_of_formula!(Holmstrom);
