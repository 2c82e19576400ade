//! The background: counts that have nothing to do with the scene.

/// A background that can't be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the background is {value} {unit}: expected a finite number, 0 or more")]
pub struct BackgroundError {
    /// The rate.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
}

/// A flat background, the same all over the field.
///
/// ```
/// use emitree_instrument::Background;
///
/// let particles = Background::per_pixel(2e-6)?;
/// // In a channel of 0.01 keV and a pixel of 1e-5 sr.
/// assert_eq!(particles.rate(0.01, 1e-5), 2e-6);
/// let sky = Background::per_kev_sr(50.0)?;
/// assert!((sky.rate(0.01, 1e-5) - 5e-6).abs() < 1e-20);
/// # Ok::<(), emitree_instrument::BackgroundError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Background {
    kind: Kind,
}

/// What the rate is for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    PerPixel(f64),
    PerKevSr(f64),
}

impl Background {
    /// As particles make it in a detector: counts s⁻¹ in each channel of each pixel.
    ///
    /// # Errors
    ///
    /// [`BackgroundError`] if it is negative or not finite.
    pub fn per_pixel(counts_s: f64) -> Result<Self, BackgroundError> {
        let value = checked(counts_s, "counts s-1 in each channel of each pixel")?;
        Ok(Self { kind: Kind::PerPixel(value) })
    }

    /// As a diffuse glow of the sky makes it, counts s⁻¹ keV⁻¹ sr⁻¹: in proportion to the solid angle
    /// of a pixel and to the nominal width of a channel.
    ///
    /// # Errors
    ///
    /// [`BackgroundError`] if it is negative or not finite.
    pub fn per_kev_sr(counts_s_kev_sr: f64) -> Result<Self, BackgroundError> {
        let value = checked(counts_s_kev_sr, "counts s-1 keV-1 sr-1")?;
        Ok(Self { kind: Kind::PerKevSr(value) })
    }

    /// The rate, counts s⁻¹, in a channel \[keV\] wide and a pixel of some solid angle \[sr\].
    pub fn rate(&self, width_kev: f64, solid_angle_sr: f64) -> f64 {
        match self.kind {
            Kind::PerPixel(rate) => rate,
            Kind::PerKevSr(rate) => rate * width_kev * solid_angle_sr,
        }
    }

    /// The rate of `pixels` pixels together, of the solid angle `field_sr` \[sr\], in channels of these
    /// widths \[keV\].
    pub(crate) fn total_rate(
        &self,
        widths_kev: impl ExactSizeIterator<Item = f64>,
        pixels: usize,
        field_sr: f64,
    ) -> f64 {
        match self.kind {
            Kind::PerPixel(rate) => rate * (widths_kev.len() as f64) * pixels as f64,
            Kind::PerKevSr(rate) => rate * field_sr * widths_kev.sum::<f64>(),
        }
    }
}

fn checked(value: f64, unit: &'static str) -> Result<f64, BackgroundError> {
    let counts = value >= 0.0 && value.is_finite();
    if counts { Ok(value) } else { Err(BackgroundError { value, unit }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn totals_are_the_sums_over_pixels_and_channels() {
        let (widths, angles) = ([0.5, 0.25, 1.0], [1e-3, 2e-3]);
        for background in
            [Background::per_pixel(3.0).unwrap(), Background::per_kev_sr(40.0).unwrap()]
        {
            let sum: f64 = widths
                .iter()
                .flat_map(|&width| angles.map(|angle| background.rate(width, angle)))
                .sum();
            let total = background.total_rate(widths.into_iter(), 2, 3e-3);
            assert!((total - sum).abs() < 1e-14, "{total} {sum}");
        }
    }

    #[test]
    fn rates_that_can_not_be_are_refused_by_name() {
        assert_eq!(
            Background::per_pixel(-1.0).unwrap_err().to_string(),
            "the background is -1 counts s-1 in each channel of each pixel: expected a finite \
             number, 0 or more"
        );
        assert_eq!(
            Background::per_kev_sr(f64::NAN).unwrap_err().to_string(),
            "the background is NaN counts s-1 keV-1 sr-1: expected a finite number, 0 or more"
        );
    }
}
