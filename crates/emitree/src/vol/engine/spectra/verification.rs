//! The verification of the selected energies: samples at energies that took no part in their
//! selection.
//!
//! Each new line of the final verification is sampled at one depth, at all selected energies and at
//! others. What the selected energies do not explain there becomes a spectral probe, from which
//! further energies are selected.

use crate::cell::whole;
use crate::exchange::MethodError;
use crate::vol::dyadic::unit;
use crate::vol::engine::Engine;
use crate::vol::engine::spectra::path_of;
use crate::vol::engine::verification::Verdict;
use crate::vol::line::Line;
use crate::vol::sampling::Stop;
use crate::vol::spectrum::probes::{ProbePoint, SpotCheck, energies_of_line, spectral_rates};
use crate::vol::tuning::TUNING;
use crate::vol::view::sheet::Sheet;

/// A point of a line of the verification, with G at the energy of the line.
struct LinePoint {
    point: ProbePoint,
    path: f64,
    rate: f64,
    /// The number of the energy of its sheet.
    energy: usize,
    /// The number of the line among all that have been compared.
    number: usize,
}

impl Engine<'_> {
    /// Compares samples on the lines that the final verification has added with what the selected
    /// energies explain; `target` is the error allowed and `largest` the largest voxel. Energies
    /// are added where that is too little.
    pub(crate) async fn verify_energies(
        &mut self,
        target: f64,
        largest: f64,
    ) -> Result<Verdict, MethodError> {
        let points = self.points_on_new_lines();
        let checks = match self.checks_at(&points).await {
            Err(Stop::Budget) => return Ok(Verdict::Unaffordable),
            Err(Stop::Failed(error)) => return Err(error),
            Ok(checks) => checks,
        };
        let views = self.views();
        let Some(spectra) = &mut self.spectra else { return Ok(Verdict::Passed) };
        let allowed = TUNING.spectra.failure_share * target;
        let found = match spectra.probes.spot_check(&views, &checks, allowed).await {
            Err(Stop::Budget) => return Ok(Verdict::Unaffordable),
            Err(Stop::Failed(error)) => return Err(error),
            Ok(found) => found,
        };
        if found == 0 {
            return Ok(Verdict::Passed);
        }
        let known = self.energies.len();
        if !self.select_energies(largest).await? {
            return Ok(Verdict::Unaffordable);
        }
        Ok(if self.energies.len() > known { Verdict::Failed } else { Verdict::Passed })
    }

    /// One point of each line that has not been compared before, in turn at the brightest depth and
    /// at others. If that would cost too much, a part of the lines is left out.
    fn points_on_new_lines(&mut self) -> Vec<LinePoint> {
        let made = self.meter.evaluations() - self.evaluations_before;
        let Some(spectra) = &mut self.spectra else { return Vec::new() };
        spectra.verified.resize(self.sheets.len(), 0);
        let of_sheet = |(sheet, verified): (&Sheet<'_>, &usize)| {
            *verified..sheet.verification.node_lines.lines.len()
        };
        let new = self.sheets.iter().zip(&spectra.verified).enumerate();
        let new: Vec<(usize, usize)> =
            new.flat_map(|(i, of)| of_sheet(of).map(move |line| (i, line))).collect();
        let of_sheet = |sheet: &Sheet<'_>| sheet.verification.node_lines.lines.len();
        spectra.verified = self.sheets.iter().map(of_sheet).collect();
        let of_line = TUNING.spectra.energies_per_line as usize + self.energies.len() - 1;
        let affordable = whole(TUNING.spectra.verified_share * made as f64) / of_line;
        let most = affordable
            .saturating_sub(spectra.verified_lines)
            .max(TUNING.verification.least_lines)
            .min(new.len());
        let mut points = Vec::new();
        for (i, line) in (0..most).map(|k| new[k * new.len() / most]) {
            let number = spectra.verified_lines;
            spectra.verified_lines += 1;
            let Sheet { id, scan, verification, .. } = &self.sheets[i];
            let (place, line) =
                (verification.places.nodes()[line].place, &verification.node_lines.lines[line]);
            let Some(sample) = sample_of(line, number) else { continue };
            let (depth, rate) = (line.samples[sample].depth, line.samples[sample].rate);
            let at = [place[0], place[1], depth].map(unit);
            // Inside an opaque body g is not evaluated.
            let chart = scan.view.chart;
            if !chart.has_gaps() || chart.across_gap(at).is_none() {
                let point = ProbePoint { part: id.part, place, depth };
                let path = path_of(line, rate);
                points.push(LinePoint { point, path, rate, energy: id.energy, number });
            }
        }
        points
    }

    /// The comparisons at some points, each with what the selected energies explain, which are
    /// sampled for that.
    async fn checks_at(&self, points: &[LinePoint]) -> Result<Vec<SpotCheck>, Stop> {
        let Some(spectra) = &self.spectra else { return Ok(Vec::new()) };
        let selected = &self.energies.selected;
        let others =
            |of: &LinePoint| (0..selected.len()).filter(|k| *k != of.energy).collect::<Vec<_>>();
        let wanted: Vec<(ProbePoint, u32)> = points
            .iter()
            .flat_map(|of| others(of).into_iter().map(|k| (of.point, selected[k].place)))
            .collect();
        let mut rates =
            spectral_rates(&self.views(), &wanted, &spectra.probes.bins).await?.into_iter();
        let mut checks = Vec::new();
        for of in points {
            let mut known = vec![of.rate; selected.len()];
            others(of).into_iter().zip(rates.by_ref()).for_each(|(k, rate)| known[k] = rate);
            checks.extend(energies_of_line(of.number).map(|energy| SpotCheck {
                point: of.point,
                energy,
                path: of.path,
                weight: spectra.probes.weight_at(&of.point, energy),
                expected: self.energies.explained(known.iter().copied(), energy),
            }));
        }
        Ok(checks)
    }
}

/// The sample of a line at which line `number` of all is compared: the brightest, or in every second
/// line another one.
fn sample_of(line: &Line, number: usize) -> Option<usize> {
    let size = |k: &usize| line.samples[*k].rate.abs();
    match number % 2 {
        0 => (0..line.samples.len()).max_by(|a, b| size(a).total_cmp(&size(b)).then(b.cmp(a))),
        _ => (TUNING.spectra.depth_stride * number).checked_rem(line.samples.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::testing::line_of;

    #[test]
    fn a_line_has_an_energy_in_each_part_of_the_band_and_others_than_the_lines_before() {
        let parts = TUNING.spectra.energies_per_line;
        let mut all: Vec<u32> = Vec::new();
        for number in 0..64 {
            let energies: Vec<u32> = energies_of_line(number).collect();
            assert_eq!(energies.len(), parts as usize);
            for (part, energy) in (0..parts).zip(&energies) {
                let part = f64::from(part)..=f64::from(part + 1);
                assert!(part.contains(&(f64::from(parts) * unit(*energy))));
            }
            all.extend(energies);
        }
        all.sort_unstable();
        let gaps = all.windows(2).map(|pair| unit(pair[1] - pair[0]));
        let mean = 1.0 / (64.0 * f64::from(parts));
        assert!(gaps.clone().fold(f64::INFINITY, f64::min) > 0.3 * mean);
        assert!(gaps.fold(0.0, f64::max) < 2.5 * mean);
    }

    #[test]
    fn every_second_line_is_compared_at_its_brightest_depth() {
        let line = line_of(3, |z| (-(z - 0.375).powi(2)).exp());
        assert_eq!([0, 2, 100].map(|number| sample_of(&line, number)), [Some(3); 3]);
        let others: Vec<_> = (0..9).map(|k| sample_of(&line, 2 * k + 1)).collect();
        assert!((0..9).all(|k| others.contains(&Some(k))));
        assert_eq!(sample_of(&Line::default(), 0), None);
        assert_eq!(sample_of(&Line::default(), 1), None);
    }
}
