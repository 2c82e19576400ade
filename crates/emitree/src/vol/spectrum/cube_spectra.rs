//! The energies of a cube whose volume is represented at one energy after the other.

use crate::vol::sampling::{Stop, View};
use crate::vol::spectrum::bins::Bins;
use crate::vol::spectrum::energies::{Energies, ResidualSpectrum, expected};
use crate::vol::spectrum::probes::{ProbePoint, SpectralProbes, SpotCheck};
use crate::vol::spectrum::selection::SelectionLimits;
use crate::vol::tuning::TUNING;

/// Sampled spectra, and the energies selected from them.
pub(crate) struct CubeSpectra<'a> {
    /// The views of the parts in which spectra are sampled.
    views: Vec<View<'a>>,
    pub(crate) probes: SpectralProbes<'a>,
    pub(crate) energies: Energies,
    /// For each bin the largest error of a voxel that the selected energies leave.
    pub(crate) unexplained: Vec<f64>,
    tolerance: f64,
}

impl<'a> CubeSpectra<'a> {
    /// `lines` are energies, in the unit of the axis, at which every spectrum is sampled; the tolerance is relative to the
    /// largest voxel.
    pub(crate) fn new(views: Vec<View<'a>>, bins: Bins<'a>, lines: &[f64], tolerance: f64) -> Self {
        let unexplained = vec![0.0; bins.factors.len()];
        let mut probes = SpectralProbes::new(bins);
        probes.add_line_energies(lines);
        Self { views, probes, energies: Energies::default(), unexplained, tolerance }
    }

    /// Adds points at which spectra are sampled, with their effective paths.
    pub(crate) fn add_points(&mut self, points: impl Iterator<Item = (ProbePoint, f64)>) {
        for (number, (point, path)) in points.enumerate() {
            let is_full = number.is_multiple_of(TUNING.spectra.full_probe_stride);
            self.probes.add(point, path, is_full);
        }
    }

    /// Selects the first energy, a place of the axis. Returns whether there is emission.
    pub(crate) async fn select_first(&mut self, place: u32) -> Result<bool, Stop> {
        self.probes.add_common_energy(place);
        // The largest voxel is known only after the first samples of the spectra.
        self.probes.sample(&self.views, f64::INFINITY).await?;
        let allowed = self.allowed(self.probes.largest());
        self.probes.sample(&self.views, allowed).await?;
        let first = Energies::first(&self.probes, place);
        let is_bright = first.is_some();
        self.energies = first.unwrap_or_default();
        Ok(is_bright)
    }

    /// Takes the energies of another emission.
    pub(crate) fn take_energies(&mut self, energies: Energies) {
        for one in &energies.selected {
            self.probes.add_common_energy(one.place);
        }
        self.energies = energies;
    }

    /// What the energies leave of all spectra in a cube with this largest voxel.
    pub(crate) async fn residuals(&mut self, largest: f64) -> Result<Vec<ResidualSpectrum>, Stop> {
        self.probes.sample(&self.views, self.allowed(largest)).await?;
        let residuals = self.energies.residuals(&self.probes);
        self.unexplained = expected(&residuals, &self.probes.bins);
        Ok(residuals)
    }

    /// Selects further energies, until all spectra are explained in a cube whose largest voxel so far is `of_image`. Returns
    /// the largest voxel that was expected with them; `None` if there are none.
    pub(crate) async fn select_further(&mut self, of_image: f64) -> Result<Option<f64>, Stop> {
        // The energies so far may be dim: in the whole cube most of what they leave is within the tolerance.
        self.probes.sample(&self.views, f64::INFINITY).await?;
        let of_spectra = TUNING.spectra.largest_share * self.probes.largest();
        if of_spectra > of_image && self.select(of_spectra).await? {
            return Ok(Some(of_spectra));
        }
        Ok(self.select(of_image).await?.then_some(of_image))
    }

    /// Selects further energies, until all spectra are explained in a cube with this largest voxel. Returns whether there
    /// are any.
    async fn select(&mut self, largest: f64) -> Result<bool, Stop> {
        let known = self.energies.len();
        let allowed = self.allowed(largest);
        let mut residuals = self.residuals(largest).await?;
        let most = SelectionLimits::most_of_bins(self.unexplained.len());
        let limits = SelectionLimits { allowed, largest, most };
        self.energies
            .select_until_explained(&mut self.probes, &mut residuals, &self.views, &limits)
            .await?;
        self.unexplained = expected(&residuals, &self.probes.bins);
        if self.energies.len() == known {
            return Ok(false);
        }
        for number in known..self.energies.len() {
            self.probes.add_common_energy(self.energies.selected[number].place);
        }
        self.probes.sample(&self.views, allowed).await?;
        Ok(true)
    }

    /// Compares samples with what the energies explain. Those that differ become points with spectra. Returns their number.
    pub(crate) async fn check(
        &mut self,
        checks: &[SpotCheck],
        largest: f64,
    ) -> Result<usize, Stop> {
        let allowed = TUNING.spectra.failure_share * self.tolerance * largest;
        self.probes.spot_check(&self.views, checks, allowed).await
    }

    /// What the selected energies may leave in a voxel.
    fn allowed(&self, largest: f64) -> f64 {
        TUNING.spectra.energy_share * self.tolerance * largest
    }
}
