//! The final verification: the image tree against lines of sight that are no nodes of it.
//!
//! An error estimate is computed from nodes and contains nothing of the structure between them. A
//! tree whose estimate is within the tolerance is therefore compared with other lines, which are
//! integrated in full from finer depths. Where one differs, the tree is refined, and the
//! verification is repeated with new lines; the former ones are compared again.

use crate::cell::whole;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::vol::engine::current_image::CurrentImage;
use crate::vol::engine::{Engine, within_budget};
use crate::vol::rule::scan::Scan;
use crate::vol::sampling::Stop;
use crate::vol::tuning::TUNING;
use crate::vol::view::sheet::Sheet;
use crate::vol::view::verification::Lines;
use std::borrow::Cow;

/// The outcome of a verification.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// No line differs by more than is allowed.
    Passed,
    /// New nodes are required.
    Failed,
    /// A line differs, and the nodes around it are of the finest level.
    AtFinestLevel,
    /// The budget did not suffice for the verification.
    Unaffordable,
}

/// The difference of a line of the verification from the tree.
#[derive(Clone, Copy, Debug)]
struct Difference {
    sheet: usize,
    /// The number of the line in the verification of its sheet.
    line: usize,
    /// The difference in the image, in units of the error allowed.
    size: f64,
}

/// Lines of a verification compared with the image.
struct Compared {
    /// For each sheet the number of its first line in this verification.
    first: Vec<usize>,
    /// Of all lines of all verifications, the largest first.
    differences: Vec<Difference>,
    /// The tolerance of a line at each energy.
    tolerances: Vec<f64>,
}

impl Engine<'_> {
    /// Compares the image with lines that it was not computed from, and requests nodes where they
    /// differ; `target` is the error allowed, in the unit of the image.
    pub(crate) async fn verify(
        &mut self,
        current: &CurrentImage,
        target: f64,
    ) -> Result<Verdict, MethodError> {
        let Some(compared) = self.compare(current, target).await? else {
            return Ok(Verdict::Unaffordable);
        };
        let Compared { first, mut differences, tolerances } = compared;
        let verdict = self.refine_lines(&first, current, target).await?;
        if verdict != Verdict::Passed {
            return Ok(verdict);
        }
        let errors = self.errors_of_parts(current);
        differences.retain(|of| self.has_failed(of, &errors, target));
        let verdict = self.refine_around(&differences, &tolerances).await?;
        if verdict == Verdict::Passed && !self.coverage.is_sufficient() {
            return Ok(Verdict::Unaffordable);
        }
        self.verification_lines =
            (2 * self.verification_lines).min(TUNING.verification.most_line_factor);
        match verdict {
            Verdict::Passed => self.verify_energies(target, current.largest_pixel()).await,
            verdict => Ok(verdict),
        }
    }

    /// The same without new nodes: the weighted error of pixels that the lines show beyond the
    /// estimated one; `None` if the budget did not suffice.
    pub(crate) async fn examine(
        &mut self,
        current: &CurrentImage,
        target: f64,
    ) -> Result<Option<f64>, MethodError> {
        let Some(Compared { first, differences, .. }) = self.compare(current, target).await? else {
            return Ok(None);
        };
        let errors = self.errors_of_parts(current);
        let failed = differences.iter().filter(|of| self.has_failed(of, &errors, target));
        let beyond = |of: &Difference| target * of.size - self.estimate_at(of, &errors);
        let by_places = failed.map(beyond).fold(0.0, f64::max);
        let by_depths = self
            .sheets_changed_by_depths(&first, target)
            .into_iter()
            .map(|i| self.largest_weight(i) * self.sheets[i].largest_change_by_depths(first[i]));
        let by_depths = by_depths.fold(0.0, f64::max);
        Ok(Some(TUNING.verification.fixed_margin * (by_places + by_depths)))
    }

    /// Samples points and lines that the image was not computed from, and compares them with it;
    /// `None` if the budget did not suffice.
    async fn compare(
        &mut self,
        current: &CurrentImage,
        target: f64,
    ) -> Result<Option<Compared>, MethodError> {
        let from_samples = match self.verify_samples(target).await {
            Err(Stop::Budget) => return Ok(None),
            Err(Stop::Failed(error)) => return Err(error),
            Ok(from_samples) => from_samples,
        };
        let mut places: Vec<Lines> = Vec::with_capacity(self.sheets.len());
        let made = self.meter.evaluations() - self.evaluations_before;
        let affordable = TUNING.verification.share_of_evaluations * made as f64;
        let affordable = affordable / (TUNING.verification.cost_of_line * self.cost_of_full_line());
        let verified: usize = self.sheets.iter().map(|sheet| sheet.verification.places.len()).sum();
        let times = self.verification_lines;
        let lines = (whole(affordable) * times)
            .saturating_sub(verified)
            .max(TUNING.verification.least_lines * times);
        let ascents = lines.div_ceil(TUNING.verification.lines_per_ascent);
        let lines = lines.div_ceil(self.sheets.len().max(1));
        for (i, sheet) in self.sheets.iter_mut().enumerate() {
            let mut of_sheet = sheet.scattered_lines(lines);
            let worst = whole((TUNING.verification.worst_share * lines as f64).ceil());
            of_sheet.extend(sheet.worst_lines(&current.errors(&self.parts[sheet.id.part]), worst));
            of_sheet.extend(from_samples[i].iter().cloned());
            places.push(of_sheet);
        }
        let tolerances = self.line_tolerances(target);
        let mut differences = Vec::new();
        let mut sizes = vec![Vec::new(); self.sheets.len()];
        let first: Vec<usize> =
            self.sheets.iter().map(|sheet| sheet.verification.places.len()).collect();
        for step in 0..=TUNING.verification.line_ascent_steps {
            for (sheet, of_sheet) in self.sheets.iter_mut().zip(&mut places) {
                let tolerance = sheet.line_tolerance(&tolerances);
                let of_sheet = core::mem::take(of_sheet);
                if !within_budget(sheet.verify_lines(of_sheet, tolerance).await)? {
                    return Ok(None);
                }
            }
            differences = self.differences(target, &mut sizes);
            if step < TUNING.verification.line_ascent_steps {
                let rising = differences
                    .iter()
                    .filter(|of| of.size > TUNING.verification.line_ascent_from)
                    .take(ascents);
                for of in rising {
                    places[of.sheet].extend(self.sheets[of.sheet].beside(of.line));
                }
            }
        }
        Ok(Some(Compared { first, differences, tolerances }))
    }

    /// The weighted error of each energy bin on the raster of each part.
    fn errors_of_parts<'c>(&self, current: &'c CurrentImage) -> Vec<Vec<Cow<'c, Image>>> {
        self.parts.iter().map(|part| current.errors(part)).collect()
    }

    /// The error estimated where a line is, the largest of all energy bins.
    fn estimate_at(&self, of: &Difference, errors: &[Vec<Cow<'_, Image>>]) -> f64 {
        let sheet = &self.sheets[of.sheet];
        let [row, column] = sheet.pixel(sheet.verification.places.nodes()[of.line].place);
        errors[sheet.id.part].iter().map(|error| error[(row, column)]).fold(0.0, f64::max)
    }

    /// Whether a line differs by more than the error estimated there allows.
    fn has_failed(&self, of: &Difference, errors: &[Vec<Cow<'_, Image>>], target: f64) -> bool {
        let estimate = self.estimate_at(of, errors);
        of.size > TUNING.verification.failure_share
            && of.size > (TUNING.verification.estimate_margin * estimate / target).min(1.0)
    }

    /// The mean number of evaluations of a line that is integrated in full.
    fn cost_of_full_line(&self) -> f64 {
        let of_sheet = |sheet: &Sheet<'_>| {
            let node_lines = &sheet.scan.node_lines;
            let full = (0..node_lines.lines.len()).filter(|&i| node_lines.is_full(i));
            full.fold([0, 0], |[lines, samples], i| {
                [lines + 1, samples + node_lines.lines[i].samples.len()]
            })
        };
        let [lines, samples] = self
            .sheets
            .iter()
            .map(of_sheet)
            .fold([0, 0], |sum, of_sheet| core::array::from_fn(|k| sum[k] + of_sheet[k]));
        samples.max(1) as f64 / lines.max(1) as f64
    }

    /// The sheets of which the finer depths of a line of this verification, one from number `first` on, have
    /// changed its integral.
    fn sheets_changed_by_depths(&self, first: &[usize], target: f64) -> Vec<usize> {
        let steps_over = |&i: &usize| {
            let (sheet, weight) = (&self.sheets[i], self.largest_weight(i));
            let Scan { base_level, depth_level, .. } = sheet.scan;
            // Where g jumps, a line that grazes a surface has structure that its neighbours do not
            // have.
            !sheet.scan.node_lines.tracks_jumps
                && depth_level < base_level + TUNING.verification.most_depth_levels
                && sheet.is_changed_by_depths(
                    first[i],
                    TUNING.verification.depth_change_share * target / weight,
                )
        };
        (0..self.sheets.len()).filter(steps_over).collect()
    }

    /// Integrates all lines of a sheet more carefully if the finer depths of a line of this
    /// verification, one from number `first` on, have changed its integral. The verification has
    /// failed if there is such a sheet.
    async fn refine_lines(
        &mut self,
        first: &[usize],
        current: &CurrentImage,
        target: f64,
    ) -> Result<Verdict, MethodError> {
        let sheets = self.sheets_changed_by_depths(first, target);
        if sheets.is_empty() {
            return Ok(Verdict::Passed);
        }
        let is_first = !core::mem::replace(&mut self.is_strict, true);
        if is_first {
            self.line_share *= TUNING.verification.stricter_factor;
        }
        let tolerances = self.line_tolerances(target);
        for i in sheets {
            let tolerance = self.sheets[i].line_tolerance(&tolerances);
            let scan = &mut self.sheets[i].scan;
            let guarded = current.guarded(i);
            let snapshot = scan.node_lines.snapshot();
            let refined = match is_first {
                true => scan.scan(scan.tree.len(), guarded, tolerance).await,
                false => {
                    scan.refine_depths(
                        TUNING.verification.depth_levels_per_step,
                        guarded,
                        tolerance,
                    )
                    .await
                }
            };
            if !within_budget(refined)? {
                self.sheets[i].scan.node_lines.restore(&snapshot);
                return Ok(Verdict::Unaffordable);
            }
        }
        self.set_values(0);
        Ok(Verdict::Failed)
    }

    /// The largest |weight| of a sheet in an energy bin.
    fn largest_weight(&self, sheet: usize) -> f64 {
        let weights = &self.energies.selected[self.sheets[sheet].id.energy].weights;
        weights.iter().fold(0.0, |most: f64, weight| most.max(weight.abs()))
    }

    /// The differences of all lines of all verifications, the largest first. For each sheet `sizes`
    /// has the changes of a pixel by the first lines; those of the others are added.
    fn differences(&self, target: f64, sizes: &mut [Vec<f64>]) -> Vec<Difference> {
        let mut differences = Vec::new();
        for (i, sheet) in self.sheets.iter().enumerate() {
            let earlier: Vec<&Sheet<'_>> = self.sheets[..i]
                .iter()
                .filter(|earlier| earlier.id.part == sheet.id.part)
                .collect();
            let selected = &self.energies.selected[sheet.id.energy];
            let weight = self.largest_weight(i);
            let known = sizes[i].len();
            sizes[i].extend(sheet.differences(known, &earlier, &selected.of_earlier));
            let of_line = |(line, &size): (usize, &f64)| Difference {
                sheet: i,
                line,
                size: size * weight / target,
            };
            differences.extend(sizes[i].iter().enumerate().map(of_line));
        }
        let order = |of: &Difference| (of.sheet, of.line);
        differences.sort_by(|a, b| b.size.total_cmp(&a.size).then(order(a).cmp(&order(b))));
        differences
    }

    /// Requests nodes around lines that failed, and samples the nodes nearby at the significant
    /// depths of these lines.
    async fn refine_around(
        &mut self,
        failed: &[Difference],
        tolerances: &[f64],
    ) -> Result<Verdict, MethodError> {
        let mut verdict = Verdict::Passed;
        for of in failed {
            let sheet = &mut self.sheets[of.sheet];
            let tolerance = sheet.line_tolerance(tolerances);
            let place = sheet.verification.places.nodes()[of.line].place;
            let level = sheet.level_around(place);
            if level >= self.finest_level {
                return Ok(Verdict::AtFinestLevel);
            }
            verdict = Verdict::Failed;
            let depths = sheet.verification.significant_depths(of.line, tolerance);
            if !within_budget(sheet.scan.sample_around(place, level, &depths, tolerance).await)? {
                return Ok(Verdict::Unaffordable);
            }
            sheet.scan.seeds.add_depths_around(place, level + 1, &depths);
        }
        if verdict == Verdict::Failed {
            self.set_values(0);
        }
        Ok(verdict)
    }
}
