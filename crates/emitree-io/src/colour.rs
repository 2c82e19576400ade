//! From numbers to colours: perceptual colour maps and the range that they span.

use emitree::Image;

/// A colour map, readable by colour-blind eyes: the lightness grows evenly with the value, but for differences.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ColourMap {
    /// Blue over green to yellow.
    #[default]
    Viridis,
    /// Black over red to light yellow: for emissions.
    Inferno,
    /// Black over violet to light pink.
    Magma,
    /// Blue over grey to yellow, the same for red-green colour-blind eyes.
    Cividis,
    /// Blue over white to red: for differences, with 0 in the middle.
    BlueRed,
}

impl ColourMap {
    /// The colour for a `fraction` of the range, as (red, green, blue); what lies outside of
    /// \[0, 1\] gets the colour of that end, and what is no number is grey.
    ///
    /// ```
    /// use emitree_io::ColourMap;
    ///
    /// assert_eq!(ColourMap::Inferno.rgb(0.0), [0, 0, 4]);
    /// assert_eq!(ColourMap::Inferno.rgb(2.0), ColourMap::Inferno.rgb(1.0));
    /// assert_eq!(ColourMap::Inferno.rgb(f64::NAN), [128, 128, 128]);
    /// ```
    pub fn rgb(self, fraction: f64) -> [u8; 3] {
        if fraction.is_nan() {
            return NOT_A_NUMBER;
        }
        let fraction = if self == Self::BlueRed { 1.0 - fraction } else { fraction };
        let gradient = match self {
            Self::BlueRed => colorous::RED_BLUE,
            Self::Viridis => colorous::VIRIDIS,
            Self::Inferno => colorous::INFERNO,
            Self::Magma => colorous::MAGMA,
            Self::Cividis => colorous::CIVIDIS,
        };
        gradient.eval_continuous(fraction.clamp(0.0, 1.0)).into_array()
    }
}

/// Grey of medium lightness, which occurs in none of the maps.
const NOT_A_NUMBER: [u8; 3] = [128; 3];

/// The values that the ends of a colour map stand for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueRange {
    /// The value of the first colour.
    pub low: f64,
    /// The value of the last colour.
    pub high: f64,
}

impl ValueRange {
    /// From the smaller of zero and the lowest pixel to the largest pixel of all `images`, so that
    /// zero is the darkest colour of a radiance; \[0, 1\] if there is no such span.
    ///
    /// Pixels that are not finite are left out.
    ///
    /// ```
    /// use emitree::Image;
    /// use emitree_io::ValueRange;
    ///
    /// let image = Image::from_pixels(1, 3, vec![2.0, f64::NAN, 5.0]);
    /// assert_eq!(ValueRange::of(&[&image]), ValueRange { low: 0.0, high: 5.0 });
    /// ```
    pub fn of(images: &[&Image]) -> Self {
        let pixels = images.iter().flat_map(|image| image.pixels());
        let finite = pixels.copied().filter(|pixel| pixel.is_finite());
        let (low, high) =
            finite.fold((0.0, f64::NEG_INFINITY), |(low, high), p| (p.min(low), p.max(high)));
        if low < high { Self { low, high } } else { Self { low: 0.0, high: 1.0 } }
    }

    /// Where `value` lies between the ends, 0 at the low and 1 at the high one.
    pub fn fraction(self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_brighten_from_end_to_end() {
        let maps = [ColourMap::Viridis, ColourMap::Inferno, ColourMap::Magma, ColourMap::Cividis];
        for map in maps {
            let lightness = |fraction| {
                let [red, green, blue] = map.rgb(fraction).map(f64::from);
                0.2126 * red + 0.7152 * green + 0.0722 * blue
            };
            for step in 0..8 {
                let fraction = f64::from(step) / 8.0;
                assert!(lightness(fraction) < lightness(fraction + 0.125), "{map:?} {fraction}");
            }
            assert!((0..=1000).all(|i| map.rgb(f64::from(i) / 1000.0) != NOT_A_NUMBER), "{map:?}");
        }
    }

    #[test]
    fn differences_are_white_in_the_middle_and_as_dark_at_both_ends() {
        let [blue, white, red] = [0.0, 0.5, 1.0].map(|at| ColourMap::BlueRed.rgb(at));
        assert!(white.iter().all(|&part| part > 230), "{white:?}");
        assert!(blue[2] > 2 * blue[0] && red[0] > 2 * red[2], "{blue:?} {red:?}");
    }

    #[test]
    fn ranges_hold_zero_and_all_finite_pixels() {
        let range = |pixels: &[f64]| {
            let image = Image::from_pixels(1, pixels.len(), pixels.to_vec());
            ValueRange::of(&[&image])
        };
        assert_eq!(range(&[3.0, 7.0]), ValueRange { low: 0.0, high: 7.0 });
        assert_eq!(range(&[-3.0, 7.0, f64::INFINITY]), ValueRange { low: -3.0, high: 7.0 });
        assert_eq!(range(&[-3.0, -1.0]), ValueRange { low: -3.0, high: -1.0 });
        assert_eq!(range(&[0.0, 0.0]), ValueRange { low: 0.0, high: 1.0 });
        assert_eq!(range(&[f64::NAN]), ValueRange { low: 0.0, high: 1.0 });
    }
}
