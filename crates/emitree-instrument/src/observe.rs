//! From a spectral cube of radiance to expected counts.

use crate::background::Background;
use crate::effective_area::EffectiveArea;
use crate::field::{total, total_of};
use crate::psf::{Psf, PsfError};
use crate::redistribution::{Channel, Redistribution};
use crate::step::{Step, StepSum};
use emitree::{Cube, EnergyAxis, Image};
use rayon::prelude::*;

/// A camera that counts photons.
///
/// The matrix may be left out: then each bin of the cube is a channel. The area is left out if, and
/// only if, the matrix [includes it](Redistribution::includes_area).
#[derive(Clone, Debug, PartialEq)]
pub struct Instrument {
    /// The effective area.
    pub area: Option<EffectiveArea>,
    /// The redistribution matrix.
    pub redistribution: Option<Redistribution>,
    /// The point-spread function.
    pub psf: Option<Psf>,
    /// The exposure \[s\].
    pub exposure_s: f64,
    /// The background.
    pub background: Option<Background>,
}

/// The expected counts of an instrument.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Observation {
    /// The expected counts, a band for each channel; NaN outside of the field.
    pub counts: Cube,
    /// The channels.
    pub channels: Vec<Channel>,
    /// The steps in their order, each with its sum.
    pub steps: Vec<StepSum>,
}

/// An observation that can't be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ObservationError {
    /// A number that can't be.
    #[error("the {name} is {value}: expected a finite number above 0")]
    Number {
        /// What it is.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// The axis starts at negative energies.
    #[error("the energies start at {0} keV: expected 0 or more")]
    NegativeEnergy(f64),
    /// The cube has not the bins of the axis.
    #[error("the cube has {found} bins: expected {expected}, those of the energy axis")]
    Bins {
        /// Those of the cube.
        found: usize,
        /// Those of the axis.
        expected: usize,
    },
    /// The solid angles are for another image.
    #[error(
        "there are solid angles for {} x {} pixels (height x width): expected {} x {}, as the cube \
         has", found[0], found[1], expected[0], expected[1]
    )]
    Shape {
        /// The height and width of the solid angles.
        found: [usize; 2],
        /// Those of the cube.
        expected: [usize; 2],
    },
    /// A solid angle that can't be.
    #[error(
        "the solid angle of the pixel at row {row}, column {column} is {value} sr: expected a finite \
         number, 0 or more, or NaN outside of the field"
    )]
    SolidAngle {
        /// The row, from 0.
        row: usize,
        /// The column, from 0.
        column: usize,
        /// The solid angle \[sr\].
        value: f64,
    },
    /// A radiance that is infinite.
    #[error(
        "the radiance in bin {bin} at row {row}, column {column} is {value}: expected a finite \
         number, or NaN outside of the field"
    )]
    Radiance {
        /// The bin, from 0.
        bin: usize,
        /// The row, from 0.
        row: usize,
        /// The column, from 0.
        column: usize,
        /// The radiance.
        value: f64,
    },
    /// No area at all.
    #[error(
        "there is no effective area: expected one, or a redistribution matrix that includes it \
         (HDUCLAS3 = 'FULL')"
    )]
    NoArea,
    /// Two areas.
    #[error(
        "the redistribution matrix includes an effective area, and there is another one: expected \
         one of them"
    )]
    TwoAreas,
    /// The point-spread function can't be applied.
    #[error(transparent)]
    Psf(#[from] PsfError),
}

impl Instrument {
    /// The counts that are expected from a cube of radiance \[photons s⁻¹ cm⁻² sr⁻¹ for each unit of
    /// energy of `axis`, of which one is `kev_per_unit` keV\], with the solid angle of each pixel
    /// \[sr\].
    ///
    /// Within a bin photons are spread evenly in energy. A pixel that is NaN in any bin, or whose solid
    /// angle is, is outside of the field. Radiances below 0 count as 0; step [`Step::Photons`] has
    /// their sum. See the [crate] for an example.
    ///
    /// # Errors
    ///
    /// [`ObservationError`] names what can't be, its value and what was expected.
    pub fn expected_counts(
        &self,
        radiance: &Cube,
        axis: &EnergyAxis,
        kev_per_unit: f64,
        solid_angles_sr: &Image,
    ) -> Result<Observation, ObservationError> {
        self.check_itself()?;
        check_input(radiance, axis, kev_per_unit, solid_angles_sr)?;
        let edges_kev: Vec<f64> = axis.edges().iter().map(|edge| edge * kev_per_unit).collect();

        let (mut photons, step) = self.photons(radiance, axis, solid_angles_sr);
        let mut steps = vec![step];
        if let Some(area) = &self.area {
            steps.push(apply_area(area, &edges_kev, &mut photons));
        }
        if let Some(psf) = &self.psf {
            let before = total_of(&photons);
            let blurred = psf.blur(photons)?;
            photons = blurred.photons;
            let (lost, after) = (blurred.lost.iter().sum(), total_of(&photons));
            steps.push(StepSum { step: Step::Psf, before, added: 0.0, lost, after });
        }
        let (mut counts, channels) = match &self.redistribution {
            Some(matrix) => {
                let found = redistribute(matrix, self.area.as_ref(), &edges_kev, &photons);
                steps.extend(found.1);
                (found.0, matrix.channels().to_vec())
            }
            None => (photons, channels_of_bins(&edges_kev)),
        };
        if let Some(background) = &self.background {
            steps.push(self.add(background, &channels, solid_angles_sr, &mut counts));
        }
        Ok(Observation { counts, channels, steps })
    }

    /// The memory that an observation takes at the most, in bytes, beside the cube that it is given, of
    /// `[bins, height, width]`: to be compared with what there is before.
    pub fn memory_bytes(&self, [bins, height, width]: [usize; 3]) -> u64 {
        let channels = self.redistribution.as_ref().map_or(0, |matrix| matrix.channels().len());
        // Each transform is of the field and a kernel, which reaches over the field once on either
        // side; one is the kernel's.
        let transforms = match self.psf {
            Some(_) => 9 * (rayon::current_num_threads() as u64 + 1),
            None => 0,
        };
        let maps = (bins as u64).saturating_add(channels as u64).saturating_add(transforms + 1);
        let pixels = (height as u64).saturating_mul(width as u64);
        pixels.saturating_mul(maps).saturating_mul(size_of::<f64>() as u64)
    }

    fn check_itself(&self) -> Result<(), ObservationError> {
        positive("exposure in s", self.exposure_s)?;
        let included = self.redistribution.as_ref().is_some_and(Redistribution::includes_area);
        match (&self.area, included) {
            (None, false) => Err(ObservationError::NoArea),
            (Some(_), true) => Err(ObservationError::TwoAreas),
            _ => Ok(()),
        }
    }

    /// Photons cm⁻² in each bin and pixel over the exposure.
    fn photons(
        &self,
        radiance: &Cube,
        axis: &EnergyAxis,
        solid_angles_sr: &Image,
    ) -> (Cube, StepSum) {
        let bands = radiance.bands();
        let [_, height, width] = radiance.shape();
        let angles: Vec<f64> = (0..height * width)
            .map(|pixel| {
                let outside = bands.iter().any(|band| band.pixels()[pixel].is_nan());
                if outside { f64::NAN } else { solid_angles_sr.pixels()[pixel] }
            })
            .collect();
        // The band, and its sums before and of what is below 0.
        let of_bin = |(bin, band): (usize, &Image)| {
            let factor = axis.width(bin) * self.exposure_s;
            let (mut before, mut negative) = (0.0, 0.0);
            let photon = |(&radiance, &angle): (&f64, &f64)| {
                if !angle.is_nan() {
                    before += radiance * angle;
                    negative += radiance.min(0.0) * angle;
                }
                if angle.is_nan() { f64::NAN } else { factor * (radiance.max(0.0) * angle) }
            };
            let pixels = band.pixels().iter().zip(&angles).map(photon).collect();
            (Image::from_pixels(height, width, pixels), factor * before, factor * negative)
        };
        let found: Vec<(Image, f64, f64)> = bands.par_iter().enumerate().map(of_bin).collect();
        let before = found.iter().map(|(_, before, _)| before).sum();
        let lost = found.iter().map(|(_, _, negative)| negative).sum();
        let photons = Cube::from_bands(found.into_iter().map(|(band, ..)| band).collect());
        let after = total_of(&photons);
        (photons, StepSum { step: Step::Photons, before, added: 0.0, lost, after })
    }

    fn add(
        &self,
        background: &Background,
        channels: &[Channel],
        solid_angles_sr: &Image,
        counts: &mut Cube,
    ) -> StepSum {
        let before = total_of(counts);
        let field = counts.bands().first().map_or(&[][..], Image::pixels).iter();
        let field = field.zip(solid_angles_sr.pixels()).filter(|(count, _)| !count.is_nan());
        let (pixels, field_sr) = field.fold((0, 0.0), |(n, sum), (_, angle)| (n + 1, sum + angle));
        let widths = channels.iter().map(width_kev);
        let added = self.exposure_s * background.total_rate(widths, pixels, field_sr);
        counts.bands_mut().par_iter_mut().zip(channels).for_each(|(band, channel)| {
            for (count, &angle) in band.pixels_mut().iter_mut().zip(solid_angles_sr.pixels()) {
                *count += self.exposure_s * background.rate(width_kev(channel), angle);
            }
        });
        let after = total_of(counts);
        StepSum { step: Step::Background, before, added, lost: 0.0, after }
    }
}

fn width_kev(channel: &Channel) -> f64 {
    channel.range_kev[1] - channel.range_kev[0]
}

fn apply_area(area: &EffectiveArea, edges_kev: &[f64], photons: &mut Cube) -> StepSum {
    let means: Vec<f64> = edges_kev.windows(2).map(|ends| area.mean([ends[0], ends[1]])).collect();
    let before = photons.bands().iter().zip(&means).map(|(band, mean)| total(band) * mean).sum();
    photons.bands_mut().par_iter_mut().zip(&means).for_each(|(band, mean)| {
        band.pixels_mut().iter_mut().for_each(|pixel| *pixel *= mean);
    });
    let after = total_of(photons);
    StepSum { step: Step::Area, before, added: 0.0, lost: 0.0, after }
}

fn redistribute(
    matrix: &Redistribution,
    area: Option<&EffectiveArea>,
    edges_kev: &[f64],
    photons: &Cube,
) -> (Cube, [StepSum; 2]) {
    let found = matrix.fold(edges_kev, area).apply(photons);
    let before = if matrix.includes_area() { found.expected } else { found.within };
    let energies = StepSum {
        step: Step::Energies,
        before: found.photons,
        added: 0.0,
        lost: found.outside,
        after: found.within,
    };
    let redistribution = StepSum {
        step: Step::Redistribution,
        before,
        added: 0.0,
        lost: found.uncounted,
        after: total_of(&found.counts),
    };
    (found.counts, [energies, redistribution])
}

fn channels_of_bins(edges_kev: &[f64]) -> Vec<Channel> {
    let ranges = edges_kev.windows(2).map(|ends| [ends[0], ends[1]]);
    (0..).zip(ranges).map(|(number, range_kev)| Channel { number, range_kev }).collect()
}

fn positive(name: &'static str, value: f64) -> Result<(), ObservationError> {
    let counts = value > 0.0 && value.is_finite();
    if counts { Ok(()) } else { Err(ObservationError::Number { name, value }) }
}

fn check_input(
    radiance: &Cube,
    axis: &EnergyAxis,
    kev_per_unit: f64,
    solid_angles_sr: &Image,
) -> Result<(), ObservationError> {
    positive("size of the unit of energy in keV", kev_per_unit)?;
    if axis.min() < 0.0 {
        return Err(ObservationError::NegativeEnergy(axis.min() * kev_per_unit));
    }
    let [bins, height, width] = radiance.shape();
    if bins != axis.bins() {
        return Err(ObservationError::Bins { found: bins, expected: axis.bins() });
    }
    let [found, expected] = [[solid_angles_sr.height(), solid_angles_sr.width()], [height, width]];
    if found != expected {
        return Err(ObservationError::Shape { found, expected });
    }
    let wrong = |angle: &f64| *angle < 0.0 || angle.is_infinite();
    if let Some(at) = solid_angles_sr.pixels().iter().position(wrong) {
        let value = solid_angles_sr.pixels()[at];
        return Err(ObservationError::SolidAngle { row: at / width, column: at % width, value });
    }
    for (bin, band) in radiance.bands().iter().enumerate() {
        if let Some(at) = band.pixels().iter().position(|radiance| radiance.is_infinite()) {
            let (row, column, value) = (at / width, at % width, band.pixels()[at]);
            return Err(ObservationError::Radiance { bin, row, column, value });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
