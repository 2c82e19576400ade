//! Image trees that begin with those of another emission: as the first samples of a refinement, or as they
//! are, with the error that they have for this emission.

use crate::exchange::MethodError;
use crate::tree::StopReason;
use crate::vol::engine::current_image::CurrentImage;
use crate::vol::engine::verification::Verdict;
use crate::vol::engine::{Engine, within_budget};
use crate::vol::image::remaining::guarded_details;
use crate::vol::sampling::Stop;
use crate::vol::tuning::TUNING;
use crate::vol::view::sheet::Sheet;
use crate::vol::view::tree_start::TreeStart;

impl Engine<'_> {
    /// The image of these trees. Its error follows from their details and lines, as that of any tree, and from
    /// lines and points that took no part in them.
    pub(crate) async fn run_fixed(
        &mut self,
        start: &TreeStart,
    ) -> Result<(CurrentImage, StopReason), MethodError> {
        let mut within_budget = self.sample_start(start, true).await?;
        let mut current = self.assemble()?;
        let brightest = TUNING.engine.cancellation_share * self.brightest();
        let target = self.requested * current.largest_pixel().max(brightest);
        if self.settle_quadrature(&current, target) {
            current = self.assemble()?;
        }
        let shown = self.examine(&current, target).await?;
        within_budget &= shown.is_some();
        self.of_exam = shown.unwrap_or(0.0);
        if within_budget && self.spectra.is_some() {
            let verdict = self.verify_energies(target, current.largest_pixel()).await?;
            within_budget &= verdict != Verdict::Unaffordable;
        }
        current = self.assemble()?;
        self.show(&current);
        let suffices = self.has_required_nodes(&current)
            && self.coverage.is_sufficient()
            && current.largest_error() <= target;
        let ending = match (within_budget, suffices) {
            (false, _) => StopReason::Budget,
            (true, true) => StopReason::Complete,
            (true, false) => StopReason::FixedMesh,
        };
        Ok((current, ending))
    }

    /// Samples the trees of another emission. Unless they are fixed, their lines are then refined to the
    /// tolerance. Returns whether the budget sufficed.
    pub(crate) async fn sample_start(
        &mut self,
        start: &TreeStart,
        is_fixed: bool,
    ) -> Result<bool, MethodError> {
        self.energies = start.energies.clone();
        self.is_fixed = is_fixed;
        for energy in &start.energies.selected {
            self.add_sheets(self.spectra.is_some().then_some(energy.place));
        }
        for (sheet, start) in self.sheets.iter_mut().zip(&start.sheets) {
            if !within_budget(sheet.sample_start(start, is_fixed).await)? {
                return Ok(false);
            }
        }
        let lines = self.sheets.iter().map(Sheet::largest_line).fold(self.largest_done, f64::max);
        let largest = lines.max(TUNING.engine.cancellation_share * self.brightest());
        self.assess_start(largest);
        self.set_values(0);
        if !is_fixed {
            self.sheets.iter_mut().for_each(|sheet| sheet.choose_order(TUNING.view.rough_share));
            self.set_values(0);
            match self.refine_start(largest).await {
                Err(Stop::Budget) => return Ok(false),
                Err(Stop::Failed(error)) => return Err(error),
                Ok(()) => self.set_values(0),
            }
        }
        match self.spectra {
            None => Ok(true),
            Some(_) => self.sample_spectra_of_start().await,
        }
    }

    /// Sets the errors of all lines.
    fn assess_start(&mut self, largest: f64) {
        let tolerances = self.line_tolerances(self.tolerance * largest);
        for sheet in &mut self.sheets {
            let tolerance = sheet.line_tolerance(&tolerances);
            let depth_level = sheet.scan.depth_level;
            sheet.scan.node_lines.assess_all(tolerance, depth_level);
            sheet.scan.assess_rules();
        }
    }

    /// Refines the lines whose errors are beyond the tolerance.
    async fn refine_start(&mut self, largest: f64) -> Result<(), Stop> {
        let tolerances = self.line_tolerances(self.tolerance * largest);
        for sheet in &mut self.sheets {
            let tolerance = sheet.line_tolerance(&tolerances);
            let guarded = guarded_details(&sheet.scan.tree);
            sheet.sample_nodes(&[], &guarded, tolerance).await?;
        }
        Ok(())
    }
}
