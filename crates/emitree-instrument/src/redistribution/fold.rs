//! A matrix on the bins of a spectral cube.
//!
//! A cube has bins of its own. Within one the photons are spread evenly in energy, and those that are
//! counted as the effective area has it; so of a bin b the fraction ∫ A dE over its overlap with row e,
//! divided by ∫ A dE over all of b, is redistributed by row e. What of a bin is beyond the energies of
//! the matrix, or between its rows, is lost, and counted.

use super::{Channel, Redistribution, responses};
use crate::effective_area::EffectiveArea;
use crate::field::total;
use emitree::{Cube, Image};
use rayon::prelude::*;

/// A [`Redistribution`] on the bins of a cube.
#[derive(Clone, Debug, PartialEq)]
pub struct FoldedResponse {
    channels: Vec<Channel>,
    /// For each channel, the bins that reach it, ascending, with the response.
    responses: Vec<Vec<(usize, f64)>>,
    /// For each bin, the fraction of its photons within the rows of the matrix.
    within: Vec<f64>,
    /// And the fraction beyond or between them.
    outside: Vec<f64>,
    /// For each bin, what a photon in it gives to all channels together.
    sums: Vec<f64>,
    includes_area: bool,
}

/// Counts in channels, and the sums to check them by; pixels that are not numbers are left out.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Redistributed {
    /// The counts, a band for each channel.
    pub counts: Cube,
    /// The sum of the photons that were given, all bins and pixels.
    pub photons: f64,
    /// Those of them within the rows of the matrix.
    pub within: f64,
    /// Those of them beyond the energies of the matrix, or between its rows.
    pub outside: f64,
    /// Those of them within the matrix that its rows leave uncounted, each row 1 − its sum; 0 for a
    /// matrix that includes the area.
    pub uncounted: f64,
    /// What the sum of the counts should be, from the sums of the bins and of the rows alone.
    pub expected: f64,
}

impl Redistribution {
    /// The matrix on bins with the borders `edges_kev`, ascending \[keV\], for photons that an
    /// effective area has weighted; without one they are spread evenly within each bin.
    ///
    /// ```
    /// use emitree_instrument::{Channel, EffectiveArea, Group, Redistribution, ResponseRow};
    ///
    /// let ranges = [[1.0, 2.0], [2.0, 3.0]];
    /// let rows = ranges.iter().enumerate().map(|(first, &range_kev)| ResponseRow {
    ///     range_kev,
    ///     groups: vec![Group { first, responses: vec![1.0] }],
    /// });
    /// let channels = (0..).zip(ranges).map(|(number, range_kev)| Channel { number, range_kev });
    /// let matrix = Redistribution::new(rows.collect(), channels.collect(), false)?;
    /// let area = EffectiveArea::from_points(&[1.0, 3.0], &[0.0, 20.0])?;
    /// // One bin of the cube over both rows: the upper has three quarters of ∫ A dE.
    /// let folded = matrix.fold(&[1.0, 3.0], Some(&area));
    /// assert_eq!([folded.response(0, 0), folded.response(0, 1)], [0.25, 0.75]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn fold(&self, edges_kev: &[f64], area: Option<&EffectiveArea>) -> FoldedResponse {
        let weight = |range: [f64; 2]| match area {
            Some(area) => area.integral(range),
            None => range[1] - range[0],
        };
        let bins = edges_kev.len().saturating_sub(1);
        let mut folded = FoldedResponse {
            channels: self.channels.clone(),
            responses: vec![Vec::new(); self.channels.len()],
            within: Vec::with_capacity(bins),
            outside: Vec::with_capacity(bins),
            sums: Vec::with_capacity(bins),
            includes_area: self.includes_area,
        };
        let mut of_bin = vec![0.0; self.channels.len()];
        for (bin, ends) in edges_kev.windows(2).enumerate() {
            let whole = weight([ends[0], ends[1]]);
            // A bin without weight has no photons to place.
            let fraction_of = |range| if whole > 0.0 { weight(range) / whole } else { 0.0 };
            let (mut within, mut outside, mut sum) = (0.0, 0.0, 0.0);
            let mut reached = ends[0];
            for (row, part) in self.bins.between([ends[0], ends[1]]) {
                let fraction = fraction_of(part);
                within += fraction;
                outside += fraction_of([reached, part[0]]);
                reached = part[1];
                sum += fraction * self.row_sums[row];
                for (channel, response) in responses(&self.rows[row]) {
                    of_bin[channel] += fraction * response;
                }
            }
            folded.within.push(within);
            folded.outside.push(outside + fraction_of([reached, ends[1]]));
            folded.sums.push(sum);
            for (of_channel, response) in folded.responses.iter_mut().zip(&mut of_bin) {
                if *response > 0.0 {
                    of_channel.push((bin, core::mem::take(response)));
                }
            }
        }
        folded
    }

    /// Photons in bins with the borders `edges_kev`, ascending \[keV\], spread evenly within each, as
    /// counts in channels.
    ///
    /// # Panics
    ///
    /// If `photons` has another number of bins.
    pub fn apply(&self, photons: &Cube, edges_kev: &[f64]) -> Redistributed {
        self.fold(edges_kev, None).apply(photons)
    }
}

impl FoldedResponse {
    /// The channels, in the order of the matrix.
    pub fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// What a photon in bin `bin` gives to channel `channel`, both from 0.
    ///
    /// # Panics
    ///
    /// If there is no such channel.
    pub fn response(&self, bin: usize, channel: usize) -> f64 {
        let found = self.responses[channel].iter().find(|(at, _)| *at == bin);
        found.map_or(0.0, |&(_, response)| response)
    }

    /// Photons, or photons cm⁻² if the matrix includes the area, as counts in channels. A pixel that
    /// is not a number in the first bin is none in all channels.
    ///
    /// # Panics
    ///
    /// If `photons` has another number of bins.
    pub fn apply(&self, photons: &Cube) -> Redistributed {
        let bands = photons.bands();
        assert_eq!(bands.len(), self.sums.len(), "one band for each bin of the fold");
        let [_, height, width] = photons.shape();
        let empty = match bands.first() {
            Some(band) => band.pixels().iter().map(|p| if p.is_nan() { *p } else { 0.0 }).collect(),
            None => Vec::new(),
        };
        let empty = Image::from_pixels(height, width, empty);
        let channels = self.responses.par_iter().map(|of_channel| {
            let mut counts = empty.clone();
            for &(bin, response) in of_channel {
                for (count, photons) in counts.pixels_mut().iter_mut().zip(bands[bin].pixels()) {
                    *count += response * photons;
                }
            }
            counts
        });
        let totals: Vec<f64> = bands.iter().map(total).collect();
        let sum = |of_photon: &dyn Fn(usize) -> f64| -> f64 {
            totals.iter().enumerate().map(|(bin, photons)| photons * of_photon(bin)).sum()
        };
        let lacking = |bin: usize| self.within[bin] - self.sums[bin];
        Redistributed {
            counts: Cube::from_bands(channels.collect()),
            photons: totals.iter().sum(),
            within: sum(&|bin| self.within[bin]),
            outside: sum(&|bin| self.outside[bin]),
            uncounted: if self.includes_area { 0.0 } else { sum(&lacking) },
            expected: sum(&|bin| self.sums[bin]),
        }
    }
}
