//! The base lattice: the initial sampling of every rendering.

use crate::exchange::MethodError;
use crate::vol::engine::first_energy::FirstEnergy;
use crate::vol::engine::{Engine, within_budget};
use crate::vol::line::node_lines::Wanted;
use crate::vol::rule::scan::Scan;
use crate::vol::sampling::Stop;
use crate::vol::tuning::TUNING;
use crate::vol::view::sheet::Sheet;

/// The samples of the base lattice at the first energy.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FirstSamples {
    /// The place on the energy axis, if there is one.
    pub(crate) energy: Option<u32>,
    pub(crate) within_budget: bool,
}

impl Engine<'_> {
    /// Samples the lines of the base lattice at the first energy.
    pub(crate) async fn sample_initially(
        &mut self,
        first: Option<FirstEnergy>,
    ) -> Result<FirstSamples, MethodError> {
        let energy = first.as_ref().map(|first| first.place);
        self.first_hits = first.map(|first| first.hits).unwrap_or_default();
        self.add_sheets(energy);
        let within_budget = self.sample_base(0, None).await?;
        Ok(FirstSamples { energy, within_budget })
    }

    /// Samples the lines of the base lattice at all further energies that the spectra require. Returns whether the
    /// budget sufficed.
    pub(crate) async fn sample_further_energies(
        &mut self,
        first: &FirstSamples,
    ) -> Result<bool, MethodError> {
        match &self.spectra {
            Some(_) if first.within_budget => self.sample_first_spectra(first.energy).await,
            _ => Ok(first.within_budget),
        }
    }

    /// Samples the lines of the base lattice of the sheets from number `first` on, each refined
    /// individually. The tolerances are those given for all energies, or follow from the largest
    /// line. Returns whether the budget sufficed.
    pub(crate) async fn sample_base(
        &mut self,
        first: usize,
        tolerances: Option<&[f64]>,
    ) -> Result<bool, MethodError> {
        let wanted = self.sheets[first..].iter_mut().map(Sheet::add_base).collect();
        let sampled = self.refine_base(first, wanted, tolerances).await;
        self.sheets[first..]
            .iter_mut()
            .for_each(|sheet| sheet.choose_order(TUNING.view.rough_share));
        self.set_values(first);
        within_budget(sampled)
    }

    /// Refines all base lines step by step. Unless there are fixed tolerances for all energies, the
    /// tolerance follows the largest integral of a line.
    async fn refine_base(
        &mut self,
        first: usize,
        mut wanted: Vec<Wanted>,
        fixed: Option<&[f64]>,
    ) -> Result<(), Stop> {
        let mut tolerances = vec![f64::INFINITY; self.sheets.len()];
        let mut seeded: Vec<Wanted> = self.sheets[first..].iter().map(Sheet::seeded).collect();
        while wanted.iter().any(|wanted| !wanted.is_empty()) {
            let sheets = self.sheets.iter_mut().zip(&tolerances).skip(first);
            for ((sheet, tolerance), wanted) in sheets.zip(&wanted) {
                let Scan { view, tree, node_lines, depth_level, .. } = &mut sheet.scan;
                node_lines.sample(view, tree, wanted).await?;
                node_lines.assess(wanted.iter().map(|(i, _)| *i), *tolerance, *depth_level);
            }
            let largest =
                self.sheets.iter().map(Sheet::largest_line).fold(self.largest_done, f64::max);
            let largest = largest.max(TUNING.engine.cancellation_share * self.brightest());
            let following = self.line_share * self.tolerance * largest;
            for (sheet, tolerance) in self.sheets.iter().zip(&mut tolerances) {
                *tolerance = match fixed {
                    Some(fixed) => sheet.line_tolerance(fixed),
                    None => following / sheet.pieces_of_line as f64,
                };
            }
            let assess = |(sheet, tolerance): (&mut Sheet<'_>, &f64)| {
                let Scan { tree, node_lines, depth_level, .. } = &mut sheet.scan;
                node_lines.assess(0..tree.len(), *tolerance, *depth_level)
            };
            wanted = self.sheets.iter_mut().zip(&tolerances).skip(first).map(assess).collect();
            if wanted.iter().all(Vec::is_empty) {
                wanted = core::mem::take(&mut seeded);
            }
        }
        for (sheet, tolerance) in self.sheets.iter_mut().zip(&tolerances).skip(first) {
            let found: Vec<usize> = (0..sheet.scan.tree.len()).collect();
            sheet.scan.follow(&found, *tolerance).await?;
        }
        Ok(())
    }
}
