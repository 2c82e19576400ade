//! The forecast: the expected cost of the rest of a search, compared with that of the image tree.

use crate::meter::Deadline;
use crate::vol::PixelTolerance;
use crate::vol::lowrank::interpolant::Interpolant;
use crate::vol::lowrank::trial_run::evaluations_of_tree;
use crate::vol::tuning::TUNING;

/// The upper limit of the extrapolated cost: all larger ones are equally impossible.
const MOST_EXPENSIVE: f64 = 1e6;

/// The error as a function of the rank so far, and its extrapolation.
pub(super) struct Forecast {
    /// The error that ends the search, relative to the largest pixel.
    goal: f64,
    /// Whether errors are relative to the pixel, and not to the largest one.
    is_relative: bool,
    /// The error allowed in the darkest pixel in terms of that in the largest one.
    pub(super) darkest: f64,
    /// Ranks, with the smallest error up to each.
    course: Vec<(f64, f64)>,
    /// The number of evaluations at the next forecast.
    next: f64,
    /// The number of successive forecasts that preferred the image tree.
    for_tree: u32,
    /// The last trial run.
    former: Option<TrialRun>,
}

/// What a trial run has shown.
#[derive(Clone, Copy)]
struct TrialRun {
    /// The expected evaluations of the image tree; at least so many if the run did not end.
    cost: f64,
    has_ended: bool,
}

impl TrialRun {
    /// Whether the image tree takes fewer evaluations than what is allowed now; `None` if the run does not show it for an
    /// interpolant that has changed since.
    fn is_below(&self, allowed: f64) -> Option<bool> {
        if self.cost > TUNING.lowrank.former_excess * allowed {
            Some(false)
        } else if self.has_ended && TUNING.lowrank.former_saving * self.cost < allowed {
            Some(true)
        } else {
            None
        }
    }
}

impl Forecast {
    pub(super) fn new(goal: f64, is_relative: bool) -> Self {
        let next = TUNING.lowrank.first_forecast;
        Self {
            goal,
            is_relative,
            darkest: 1.0,
            course: Vec::new(),
            next,
            for_tree: 0,
            former: None,
        }
    }

    /// Records the relative error for the given `ranks` along the axes.
    pub(super) fn record(&mut self, ranks: [usize; 3], error: f64) {
        if error.is_finite() {
            let rank = (ranks.iter().product::<usize>() as f64).cbrt();
            let least = self.course.last().map_or(error, |(_, least)| least.min(error));
            self.course.push((rank, least));
        }
    }

    /// Whether the image tree is expected to cost less than the rest of the search, after `spent`
    /// evaluations and with `missing` probes to be sampled.
    pub(super) fn prefers_tree(
        &mut self,
        interpolant: &Interpolant,
        spent: f64,
        missing: usize,
        shape: [usize; 2],
        deadline: Option<Deadline>,
    ) -> bool {
        let Some(&(_, error)) = self.course.last() else { return false };
        if spent <= self.next
            || (error > TUNING.lowrank.unknown_error
                && spent <= TUNING.lowrank.first_forecast_if_unknown)
        {
            return false;
        }
        self.next = TUNING.lowrank.forecast_interval * spent;
        let remaining = (self.remaining_cost(interpolant) + missing as f64).min(MOST_EXPENSIVE);
        // The interpolant is not accurate enough for the tolerance itself: the tolerance of the
        // trial run is between that and the loosest one.
        let trial = |tolerance: f64| (tolerance * TUNING.engine.loosest_tolerance).sqrt();
        let of_largest = self.goal / TUNING.engine.stopping_share;
        let of_darkest = self.darkest * of_largest;
        let trial_tolerance = trial(if self.is_relative { of_largest } else { of_darkest });
        let trial_floor = trial(of_darkest) / trial_tolerance;
        let by_pixel = PixelTolerance::relative(trial_tolerance).with_floor(trial_floor);
        let by_pixel = self.is_relative.then_some(by_pixel);
        let cost_ratio = (trial(of_darkest) / of_darkest).powf(TUNING.engine.cost_exponent);
        let allowed = TUNING.lowrank.safety_factor * remaining;
        let former = self.former.and_then(|former| former.is_below(allowed));
        let is_cheaper = former.unwrap_or_else(|| {
            let most = allowed / cost_ratio;
            let tree =
                evaluations_of_tree(interpolant, shape, trial_tolerance, by_pixel, most, deadline);
            let cost = tree.map_or(allowed, |tree| cost_ratio * tree);
            let has_ended = tree.is_some();
            self.former = Some(TrialRun { cost, has_ended });
            has_ended && cost < allowed
        });
        self.for_tree = if is_cheaper { self.for_tree + 1 } else { 0 };
        self.for_tree
            >= if cost_ratio > TUNING.lowrank.extrapolation_ratio {
                TUNING.lowrank.forecasts_for_tree
            } else {
                1
            }
    }

    /// The number of evaluations from here to the goal, if the error continues to decrease
    /// exponentially as it has since half of the present rank.
    fn remaining_cost(&self, interpolant: &Interpolant) -> f64 {
        let Some(&(rank, error)) = self.course.last() else { return 0.0 };
        let half = self.course.iter().rev().find(|(before, _)| *before <= 0.5 * rank);
        let &(before, larger) = half.unwrap_or(&self.course[0]);
        let slope =
            ((larger / error).ln() / (rank - before).max(1.0)).max(TUNING.lowrank.least_slope);
        let last = rank + (error / (self.darkest * self.goal)).ln().max(0.0) / slope;
        // A fiber along each axis for each rank, and all triples of pivots.
        interpolant.places() as f64 * (last - rank) + last.powi(3) - rank.powi(3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_that_falls_exponentially_ends_at_the_rank_that_it_reaches_the_goal_with() {
        let mut forecast = Forecast::new(1e-3, false);
        for rank in 1..=6 {
            forecast.record([rank; 3], 10.0_f64.powf(-0.25 * rank as f64));
        }
        // A single larger error does not count.
        forecast.record([6, 6, 6], 1.0);
        let interpolant = Interpolant::new(4, None);
        let remaining = 51.0 * 6.0 + 12.0_f64.powi(3) - 6.0_f64.powi(3);
        assert!((forecast.remaining_cost(&interpolant) / remaining - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_former_trial_run_decides_where_it_is_far_from_what_is_allowed() {
        let run = |has_ended| TrialRun { cost: 1000.0, has_ended };
        for has_ended in [true, false] {
            assert_eq!(run(has_ended).is_below(600.0), Some(false));
            assert_eq!(run(has_ended).is_below(700.0), None);
            assert_eq!(run(has_ended).is_below(3900.0), None);
            // A run that did not end may have needed any number.
            assert_eq!(run(has_ended).is_below(4100.0), has_ended.then_some(true));
        }
    }

    #[test]
    fn there_is_no_forecast_before_the_first_error_estimates() {
        let mut forecast = Forecast::new(1e-3, false);
        let interpolant = Interpolant::new(4, None);
        assert!(!forecast.prefers_tree(&interpolant, 1e5, 0, [16, 16], None));
        forecast.record([1, 1, 1], 5.0);
        assert!(!forecast.prefers_tree(
            &interpolant,
            TUNING.lowrank.first_forecast_if_unknown,
            0,
            [16, 16],
            None
        ));
        // An image tree of an interpolant that is 0 ends at once; the second forecast confirms it.
        let mut prefers_tree =
            |spent| forecast.prefers_tree(&interpolant, spent, 0, [16, 16], None);
        assert!(!prefers_tree(TUNING.lowrank.first_forecast_if_unknown + 1.0));
        assert!(prefers_tree(
            1.01 * TUNING.lowrank.forecast_interval
                * (TUNING.lowrank.first_forecast_if_unknown + 1.0)
        ));
    }
}
