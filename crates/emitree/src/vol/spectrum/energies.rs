//! Selected energies: a few energies at which lines are integrated, and the spectrum that belongs
//! to each.
//!
//! Where G has a low numerical rank between the volume and the energy, r energies Eₖ suffice:
//! G(r, E) = Σ qₖ(E) Sₖ(r), with Sₖ = G(r, Eₖ) − Σ_{j<k} qⱼ(Eₖ) Sⱼ(r). This is empirical
//! interpolation (Barrault et al. 2004, doi:10.1016/j.crma.2004.08.006): Eₖ is at the largest
//! residual of the sampled spectrum that the former energies explain worst, and qₖ is that
//! residual, normalised to 1 at Eₖ.

use crate::parallel::prelude::*;
use crate::vol::dyadic::unit;
use crate::vol::spectrum::Spectrum;
use crate::vol::spectrum::bins::Bins;
use crate::vol::spectrum::probes::{SpectralProbe, weight_of_bin};
use crate::vol::tuning::TUNING;
use nalgebra::DMatrix;

/// One energy with its function and its weights in the bins.
#[derive(Clone, Debug)]
pub(crate) struct SelectedEnergy {
    /// The dyadic place on the energy axis.
    pub(crate) place: u32,
    /// qⱼ(Eₖ) for each energy j that was selected before.
    pub(crate) of_earlier: Vec<f64>,
    /// The mean of qₖ over each bin, per unit of energy.
    pub(crate) weights: Vec<f64>,
    /// qₖ.
    function: Spectrum,
}

/// The selected energies, in the order of their selection. Since qₖ is 0 at all former energies, an
/// energy is added without changes to these, and the Sₖ decrease with k.
#[derive(Clone, Debug, Default)]
pub(crate) struct Energies {
    pub(crate) selected: Vec<SelectedEnergy>,
}

/// The residual of one sampled spectrum after the selected energies.
#[derive(Clone, Debug)]
pub(crate) struct ResidualSpectrum {
    spectrum: Spectrum,
    /// The effective path along the line of sight, as a fraction of the unit depth.
    path: f64,
    /// The |mean| of the residual over each bin times the path: the error of a voxel.
    pub(crate) effects: Vec<f64>,
    /// The weight of an error in each bin; none if all are 1.
    weights: Vec<f64>,
}

impl ResidualSpectrum {
    fn new(spectrum: Spectrum, path: f64, weights: Vec<f64>, bins: &Bins<'_>) -> Self {
        let effects = bins.means(&spectrum).iter().map(|mean| mean.abs() * path).collect();
        Self { spectrum, path, effects, weights }
    }

    /// The weighted error of a voxel in each bin.
    fn weighted(&self) -> impl Iterator<Item = f64> + '_ {
        let weights = self.weights.iter().copied().chain(core::iter::repeat(1.0));
        self.effects.iter().zip(weights).map(|(effect, weight)| effect * weight)
    }

    /// The largest weighted error of a voxel.
    pub(crate) fn largest(&self) -> f64 {
        self.weighted().fold(0.0, f64::max)
    }

    /// The |residual| at a place of the axis, per unit of energy, times the path.
    pub(crate) fn effect_at(&self, place: u32, bins: &Bins<'_>) -> f64 {
        self.path * size_at(&self.spectrum, bins, place)
    }

    /// The sampled place at which its weighted size is largest, per unit of energy, and that size.
    fn largest_place(&self, bins: &Bins<'_>) -> (u32, f64) {
        let larger = |best: (u32, f64), place: u32| {
            let size = self.weighted_size_at(place, bins);
            if size > best.1 { (place, size) } else { best }
        };
        self.spectrum.places().fold((0, -1.0), larger)
    }

    /// The weighted |residual| at a place of the axis, per unit of energy.
    fn weighted_size_at(&self, place: u32, bins: &Bins<'_>) -> f64 {
        size_at(&self.spectrum, bins, place) * weight_of_bin(&self.weights, place)
    }
}

impl Energies {
    /// The only energy of an image without an energy axis.
    pub(crate) fn none() -> Self {
        let only = SelectedEnergy {
            place: 0,
            of_earlier: vec![],
            weights: vec![1.0],
            function: Spectrum::default(),
        };
        Self { selected: vec![only] }
    }

    /// One energy without a sampled function, with the same `weight` in all bins: 0 where all
    /// spectra are dark, 1 as a guess where none was sampled.
    pub(crate) fn unselected(place: u32, bins: usize, weight: f64) -> Self {
        let weights = vec![weight; bins];
        let only =
            SelectedEnergy { place, of_earlier: vec![], weights, function: Spectrum::default() };
        Self { selected: vec![only] }
    }

    pub(crate) fn len(&self) -> usize {
        self.selected.len()
    }

    /// The residual of the spectrum of a spectral probe, which has been sampled at all selected
    /// energies.
    pub(crate) fn residual(&self, probe: &SpectralProbe, bins: &Bins<'_>) -> ResidualSpectrum {
        let left = self.selected.iter().fold(probe.spectrum.clone(), |residual, one| {
            residual.less(residual.rate(one.place), &one.function)
        });
        ResidualSpectrum::new(left, probe.path, probe.weights.clone(), bins)
    }

    /// Selects an energy whose function is one of the `residuals`, at `place` or where that is
    /// largest, and subtracts its part from all of them. Returns `false` if the residual is too
    /// small there.
    pub(crate) fn select(
        &mut self,
        residuals: &mut [ResidualSpectrum],
        from: usize,
        place: Option<u32>,
        bins: &Bins<'_>,
    ) -> bool {
        let (largest_place, largest) = residuals[from].largest_place(bins);
        let place = place.unwrap_or(largest_place);
        let least = TUNING.spectra.least_pivot * largest;
        let mut function = residuals[from].spectrum.clone();
        let pivot = function.rate(place);
        if !(1.0 / pivot).is_finite() || residuals[from].weighted_size_at(place, bins) < least {
            return false;
        }
        function.scale(1.0 / pivot);
        let of_earlier = self.selected.iter().map(|one| one.function.rate(place)).collect();
        let weights = bins.means(&function);
        residuals.par_iter_mut().for_each(|residual| {
            let left = residual.spectrum.less(residual.spectrum.rate(place), &function);
            let weights = core::mem::take(&mut residual.weights);
            *residual = ResidualSpectrum::new(left, residual.path, weights, bins);
        });
        self.selected.push(SelectedEnergy { place, of_earlier, weights, function });
        true
    }

    /// G at a place of the axis, given G at each of the selected energies.
    pub(crate) fn explained(&self, rates: impl Iterator<Item = f64>, place: u32) -> f64 {
        let mut parts: Vec<f64> = Vec::with_capacity(self.len());
        for (one, rate) in self.selected.iter().zip(rates) {
            let known: f64 = parts.iter().zip(&one.of_earlier).map(|(part, of)| part * of).sum();
            parts.push(rate - known);
        }
        self.sum_of_parts(parts.into_iter(), place)
    }

    /// G at a place of the axis, given what each of the selected energies adds to the former ones, Sₖ.
    pub(crate) fn sum_of_parts(&self, parts: impl Iterator<Item = f64>, place: u32) -> f64 {
        let functions = self.selected.iter().map(|one| one.function.rate(place));
        parts.zip(functions).map(|(part, function)| part * function).sum()
    }

    /// The weights of G at the selected energies up to number `k` in what that one adds, Sₖ.
    pub(crate) fn weights_of_part(&self, k: usize) -> Vec<f64> {
        let mut weights: Vec<Vec<f64>> = Vec::with_capacity(k + 1);
        for (number, one) in self.selected.iter().take(k + 1).enumerate() {
            let mut of_part = vec![0.0; number + 1];
            of_part[number] = 1.0;
            for (earlier, amount) in weights.iter().zip(&one.of_earlier) {
                let targets = of_part.iter_mut().zip(earlier);
                targets.for_each(|(weight, of_earlier)| *weight -= amount * of_earlier);
            }
            weights.push(of_part);
        }
        weights.pop().unwrap_or_default()
    }

    /// The weights of G at each energy for each bin: a vector of energies for each bin.
    ///
    /// With W the weights of the Sₖ and L the matrix of the qⱼ(Eₖ), they are the n in n L = W.
    pub(crate) fn nodal_weights(&self) -> Vec<Vec<f64>> {
        let bins = self.selected.first().map_or(0, |one| one.weights.len());
        let weights = DMatrix::from_fn(self.len(), bins, |k, bin| self.selected[k].weights[bin]);
        let mut lower = DMatrix::identity(self.len(), self.len());
        for (k, one) in self.selected.iter().enumerate() {
            for (j, of_earlier) in one.of_earlier.iter().enumerate() {
                lower[(k, j)] = *of_earlier;
            }
        }
        let nodal = lower.tr_solve_lower_triangular_unchecked(&weights);
        nodal.column_iter().map(|of_bin| of_bin.as_slice().to_vec()).collect()
    }
}

/// The error of a voxel that is expected in each bin from the `residuals` of all sampled spectra.
pub(crate) fn expected(residuals: &[ResidualSpectrum], bins: &Bins<'_>) -> Vec<f64> {
    let left = unexplained(residuals, bins);
    left.into_iter().map(|left| TUNING.spectra.unsampled_margin * left).collect()
}

/// |G| per unit of energy at a place.
fn size_at(spectrum: &Spectrum, bins: &Bins<'_>, place: u32) -> f64 {
    spectrum.rate(place).abs() / bins.density(unit(place))
}

/// The largest weighted error of a voxel in each bin for any of the `residuals`.
pub(crate) fn unexplained(residuals: &[ResidualSpectrum], bins: &Bins<'_>) -> Vec<f64> {
    let mut largest = vec![0.0; bins.factors.len()];
    for residual in residuals {
        largest
            .iter_mut()
            .zip(residual.weighted())
            .for_each(|(most, effect)| *most = effect.max(*most));
    }
    largest
}
