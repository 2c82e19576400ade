//! The loop: sample, assemble the image and its error, refine, until the tolerance is met.

use crate::cell::whole;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::tree::StopReason;
use crate::vol::dyadic::Place;
use crate::vol::engine::base::FirstSamples;
use crate::vol::engine::current_image::CurrentImage;
use crate::vol::engine::spectra::Spectra;
use crate::vol::engine::verification::Verdict;
use crate::vol::engine::{Engine, within_budget};
use crate::vol::image::opening::{Choice, ChoiceLimits, worthwhile};
use crate::vol::tuning::TUNING;
use crate::vol::view::sheet::Sheet;
use crate::vol::view::tree_start::TreeStart;
use std::borrow::Cow;

/// What the trees begin with.
pub(crate) enum Beginning<'a> {
    Samples(FirstSamples),
    /// The trees of another emission.
    Trees(&'a TreeStart),
    /// The same, which stay as they are.
    FixedTrees(&'a TreeStart),
}

impl Engine<'_> {
    /// Refines the trees until the tolerance is met, beginning with those of another emission or with the first
    /// samples.
    pub(crate) async fn run(
        &mut self,
        beginning: Beginning<'_>,
    ) -> Result<(CurrentImage, StopReason), MethodError> {
        let before = self.evaluations_before;
        let mut within_budget = match beginning {
            Beginning::Samples(first) => self.sample_further_energies(&first).await?,
            Beginning::Trees(start) => self.sample_start(start, false).await?,
            Beginning::FixedTrees(start) => return self.run_fixed(start).await,
        };
        if !within_budget && self.sheets.iter().any(Sheet::has_no_samples) {
            // Where the time has ended there is no image of these lines.
            self.meter.check_time()?;
        }
        let mut current = self.assemble()?;
        // The first lines were refined individually, so that this is an upper limit: depth rules
        // cost less.
        let nodes: usize = self.sheets.iter().map(|sheet| sheet.scan.tree.len()).sum();
        let mut cost_per_node = (self.meter.evaluations() - before) as f64 / nodes as f64;
        let mut halvings = 0;
        loop {
            let meter = self.meter;
            self.show(&current);
            let largest =
                current.largest_pixel().max(TUNING.engine.cancellation_share * self.brightest());
            let [meets_goal, meets_tolerance] =
                [self.goal, self.tolerance].map(|of| self.meets(&current, of, largest));
            if meets_goal && self.settle_quadrature(&current, self.requested * largest) {
                current = self.assemble()?;
                continue;
            }
            if meets_goal {
                match self.verify(&current, self.requested * largest).await? {
                    Verdict::Passed => {
                        // Spectra of the verification may differ more from those explained.
                        if self.spectra.is_some() {
                            current = self.assemble()?;
                        }
                        if self.meets(&current, self.goal, largest) {
                            self.show(&current);
                            return Ok((current, StopReason::Complete));
                        }
                    }
                    Verdict::AtFinestLevel => return Ok((current, StopReason::MaxLevel)),
                    Verdict::Unaffordable => return Ok((current, StopReason::Budget)),
                    Verdict::Failed => current = self.assemble()?,
                }
            }
            if !within_budget {
                return self.conclude(current, StopReason::Budget).await;
            }
            if meets_tolerance && !meets_goal {
                self.tolerance = self.next_tolerance();
            }
            let target = self.tolerance * largest;
            let mut places = self.choose(&current, target);
            let count = total(&places);
            if count == 0 {
                if halvings == TUNING.engine.most_halvings {
                    return self.conclude(current, StopReason::MaxLevel).await;
                }
                halvings += 1;
                self.line_share *= 0.5;
                self.spectra.iter_mut().for_each(Spectra::tighten);
            }
            let affordable =
                meter.evaluations_left() as f64 / (TUNING.engine.cost_margin * cost_per_node);
            if count as f64 > affordable {
                // Each sheet keeps the nodes with the largest contributions.
                let kept = whole(affordable);
                places.iter_mut().for_each(|places| places.truncate(places.len() * kept / count));
                within_budget = total(&places) >= TUNING.engine.least_round;
            }
            for places in &mut places {
                places.sort_unstable();
                places.dedup();
            }
            let sampled = total(&places);
            let before = meter.evaluations();
            if self.sample_nodes(&places, &current, target).await? {
                let spent = (meter.evaluations() - before) as f64;
                if sampled > 0 {
                    cost_per_node = spent / sampled as f64;
                }
            } else {
                // The rest of the budget may suffice for fewer nodes. Nodes outside the view cost
                // nothing, and all former ones may have been such.
                cost_per_node = cost_per_node.max(1.0) * TUNING.engine.overrun_factor;
                within_budget &= sampled >= TUNING.engine.least_round;
            }
            let largest = current.largest_pixel();
            current = self.assemble()?;
            if within_budget && self.spectra.is_some() {
                within_budget = self.sample_spectra(largest).await?;
                current = self.assemble()?;
            }
        }
    }

    /// Whether the estimated error is sufficiently below a tolerance, given the `largest` pixel.
    fn meets(&self, current: &CurrentImage, tolerance: f64, largest: f64) -> bool {
        self.has_required_nodes(current)
            && current.largest_error() <= TUNING.engine.stopping_share * tolerance * largest
    }

    /// Ends a search that a limit has stopped. The requested tolerance may be met although that of
    /// the search is not, since it is stricter.
    async fn conclude(
        &mut self,
        mut current: CurrentImage,
        ending: StopReason,
    ) -> Result<(CurrentImage, StopReason), MethodError> {
        let target = self.requested * current.largest_pixel();
        let met = self.has_required_nodes(&current) && current.largest_error() <= target;
        let mut passed = met && self.verify(&current, target).await? == Verdict::Passed;
        if passed && self.spectra.is_some() {
            current = self.assemble()?;
            passed = current.largest_error() <= target;
        }
        Ok((current, if passed { StopReason::Complete } else { ending }))
    }

    /// The tolerance that the rest of the budget is expected to suffice for.
    fn next_tolerance(&self) -> f64 {
        let meter = self.meter;
        let (spent, left) = (meter.kept_evaluations() as f64, meter.evaluations_left() as f64);
        let finer = ((spent + left) / spent).powf(-1.0 / TUNING.engine.cost_exponent);
        // The tolerance is at least halved: smaller steps cost more than they improve.
        (self.tolerance * finer.min(0.5)).max(self.goal)
    }

    /// Samples nodes at new `places` of each sheet. Returns whether the budget sufficed.
    async fn sample_nodes(
        &mut self,
        places: &[Vec<Place>],
        current: &CurrentImage,
        target: f64,
    ) -> Result<bool, MethodError> {
        let mut allowed = true;
        let tolerances = self.line_tolerances(target);
        let sheets = self.sheets.iter_mut().zip(places).zip(&current.states);
        for ((sheet, places), state) in sheets {
            let tolerance = sheet.line_tolerance(&tolerances);
            allowed &= within_budget(sheet.sample_nodes(places, &state.guarded, tolerance).await)?;
            // Most nodes may be at a small shape that few base lines met.
            sheet.choose_order(TUNING.view.rough_share_of_nodes);
        }
        self.set_values(0);
        Ok(allowed)
    }

    /// Whether the nodes of all required levels and of all seeds exist.
    pub(crate) fn has_required_nodes(&self, current: &CurrentImage) -> bool {
        current.states.iter().all(|state| state.has_required)
            && self.sheets.iter().all(|sheet| sheet.missing_seed_places().is_empty())
    }

    /// The places of the next nodes on each sheet, the largest contributions first. The sheets of a
    /// part compete for its error.
    fn choose(&self, current: &CurrentImage, target: f64) -> Vec<Vec<Place>> {
        let finest_level = self.finest_level;
        let mut places = vec![Vec::new(); self.sheets.len()];
        for (number, part) in self.parts.iter().enumerate() {
            let of_part: Vec<usize> =
                (0..self.sheets.len()).filter(|&i| self.sheets[i].id.part == number).collect();
            let scales = current.weighted_scales(number, part);
            let choice = |&i: &usize| {
                let weights = &self.energies.selected[self.sheets[i].id.energy].weights;
                let required_level = self.sheets[i].required_level();
                let limits = ChoiceLimits { tolerance: target, finest_level, required_level };
                self.sheets[i].choice(&current.states[i], weights, &scales, &limits)
            };
            let choices: Vec<Choice<'_>> = of_part.iter().map(choice).collect();
            let errors = current.errors(part);
            let errors: Vec<&Image> = errors.iter().map(Cow::as_ref).collect();
            let nodes = worthwhile(&choices, &errors);
            for ((&i, choice), nodes) in of_part.iter().zip(&choices).zip(nodes) {
                places[i] = self.sheets[i].places(&current.states[i], choice, nodes);
            }
        }
        places
    }
}

fn total(places: &[Vec<Place>]) -> usize {
    places.iter().map(Vec::len).sum()
}
