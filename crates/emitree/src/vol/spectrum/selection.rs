//! The selection of energies from the spectra of probes.

use crate::parallel::prelude::*;
use crate::vol::sampling::{Stop, View};
use crate::vol::spectrum::energies::{Energies, ResidualSpectrum};
use crate::vol::spectrum::probes::SpectralProbes;
use crate::vol::tuning::TUNING;

/// What is left to select, in the unit of a voxel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SelectionLimits {
    /// The error that the selected energies may leave in a voxel.
    pub(crate) allowed: f64,
    /// The largest voxel.
    pub(crate) largest: f64,
    /// The most energies.
    pub(crate) most: usize,
}

impl SelectionLimits {
    /// The most energies of a cube with so many bins.
    pub(crate) fn most_of_bins(bins: usize) -> usize {
        TUNING.spectra.energies_per_bin * bins + TUNING.spectra.more_energies
    }
}

impl Energies {
    /// The first energy, whose function is the spectrum that is brightest there; `None` if all are dark.
    pub(crate) fn first(probes: &SpectralProbes<'_>, place: u32) -> Option<Self> {
        let mut energies = Self::default();
        let mut residuals = energies.residuals(probes);
        let effect = |i: &usize| residuals[*i].effect_at(place, &probes.bins);
        let brightest = (0..residuals.len()).max_by(|a, b| effect(a).total_cmp(&effect(b)))?;
        energies.select(&mut residuals, brightest, Some(place), &probes.bins).then_some(energies)
    }

    /// What the selected energies leave of the spectra of all probes.
    pub(crate) fn residuals(&self, probes: &SpectralProbes<'_>) -> Vec<ResidualSpectrum> {
        let residual = |probe| self.residual(probe, &probes.bins);
        probes.probes.par_iter().map(residual).collect()
    }

    /// Adds energies until those that are selected explain all spectra, whose residuals are given. Spectra
    /// that become functions are refined.
    pub(crate) async fn select_until_explained(
        &mut self,
        probes: &mut SpectralProbes<'_>,
        residuals: &mut [ResidualSpectrum],
        views: &[View<'_>],
        limits: &SelectionLimits,
    ) -> Result<(), Stop> {
        let mut goal = limits.allowed;
        while self.len() < limits.most {
            let worst = (0..residuals.len())
                .max_by(|a, b| residuals[*a].largest().total_cmp(&residuals[*b].largest()));
            let Some(worst) = worst.filter(|&i| residuals[i].largest() > goal) else { break };
            probes.raise_precision(worst, residuals[worst].largest(), limits.largest);
            probes.sample(views, limits.allowed).await?;
            residuals[worst] = self.residual(&probes.probes[worst], &probes.bins);
            if residuals[worst].largest() <= goal {
                // It was the error of a spectrum that is steep there.
                continue;
            }
            goal = TUNING.spectra.selection_share * limits.allowed;
            if !self.select(residuals, worst, None, &probes.bins) {
                break;
            }
        }
        Ok(())
    }
}
