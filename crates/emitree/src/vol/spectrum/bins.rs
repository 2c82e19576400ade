//! The bins of the energy axis, and means of spectra over them.

use crate::energy::EnergyAxis;
use crate::vol::dyadic::unit;
use crate::vol::sampling::EnergySample;
use crate::vol::spectrum::{BinWeights, FINEST_LEVEL, Spectrum};
use std::sync::OnceLock;

/// The bins of an energy axis, with the weights of means over them.
#[derive(Clone, Debug)]
pub(crate) struct Bins<'a> {
    pub(crate) axis: &'a EnergyAxis,
    /// For each bin, the mean per unit of energy over the mean per unit of the canonical axis.
    pub(crate) factors: Vec<f64>,
    /// The weights for spectra with each finest level, computed on first use.
    weights: Vec<OnceLock<BinWeights>>,
}

impl<'a> Bins<'a> {
    pub(crate) fn new(axis: &'a EnergyAxis) -> Self {
        let bins = axis.bins();
        let whole = (axis.max() - axis.min()) / bins as f64;
        let factors = (0..bins).map(|bin| whole / axis.width(bin)).collect();
        Self { axis, factors, weights: vec![OnceLock::new(); usize::from(FINEST_LEVEL) + 1] }
    }

    /// dE/du over its mean at the canonical coordinate `u`, the weight of G.
    pub(crate) fn density(&self, u: f64) -> f64 {
        self.axis.energy_per_canonical(u) / (self.axis.max() - self.axis.min())
    }

    /// The energy at a dyadic place of the axis, with its density.
    pub(crate) fn sample_at(&self, place: u32) -> EnergySample {
        let u = unit(place);
        EnergySample { energy: self.axis.energy(u), density: self.density(u) }
    }

    /// The mean of a spectrum over each bin, per unit of energy.
    pub(crate) fn means(&self, spectrum: &Spectrum) -> Vec<f64> {
        let finest = spectrum.finest_level().min(FINEST_LEVEL);
        let weights = self.weights[usize::from(finest)]
            .get_or_init(|| BinWeights::new(finest, self.factors.len()));
        let means = spectrum.means(weights);
        means.iter().zip(&self.factors).map(|(mean, factor)| mean * factor).collect()
    }
}
