//! The progress: one line on a terminal, nothing in a pipe. Ctrl-C ends the run between two calls of g.

use crate::interrupt;
use crate::numbers::{roughly, short};
use emitree::progress::Frame;
use emitree::{Image, RenderOptions};
use emitree_io::CostLaw;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The line that counts evaluations while g is being called, with the error of the image so far.
pub(crate) struct ProgressLine {
    bar: ProgressBar,
    course: Mutex<Course>,
}

impl ProgressLine {
    /// A line of evaluations alone.
    pub(crate) fn new(quiet: bool) -> Self {
        Self::towards(Goal::default(), quiet)
    }

    /// A line with the error so far against the tolerance, and with the time left.
    pub(crate) fn towards(goal: Goal, quiet: bool) -> Self {
        let bar = match quiet || !std::io::stderr().is_terminal() {
            true => ProgressBar::hidden(),
            false => ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr()),
        };
        if let Ok(style) =
            ProgressStyle::with_template("{spinner} {human_pos} evaluations in {elapsed}{msg}")
        {
            bar.set_style(style);
        }
        Self { bar, course: Mutex::new(Course::new(goal, Instant::now())) }
    }

    /// Whether there is a line to be seen: intermediate images are made for it.
    pub(crate) fn is_seen(&self) -> bool {
        !self.bar.is_hidden()
    }

    /// Takes the number of evaluations so far, from any thread; breaks off after Ctrl-C.
    pub(crate) fn advance(&self, evaluations: u64) -> ControlFlow<()> {
        self.bar.set_position(evaluations);
        if self.is_seen() {
            let course = self.course.lock().unwrap_or_else(PoisonError::into_inner);
            self.bar.set_message(course.text(Instant::now()));
        }
        if interrupt::requested() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Takes an intermediate image with its error.
    pub(crate) fn show(&self, frame: &Frame<'_>) {
        let [largest, error] = [frame.image, frame.error].map(largest_of);
        if largest > 0.0 {
            let error = error / largest;
            let mut course = self.course.lock().unwrap_or_else(PoisonError::into_inner);
            course.reached(frame.evaluations, error, Instant::now());
        }
    }

    /// Removes the line.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        self.finish();
    }
}

/// The largest |pixel|.
fn largest_of(image: &Image) -> f64 {
    image.pixels().iter().fold(0.0, |largest: f64, pixel| largest.max(pixel.abs()))
}

/// What ends a rendering.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Goal {
    /// The error that is allowed, relative to the largest pixel, if it is the same in all pixels.
    pub(crate) tolerance: Option<f64>,
    /// The limit on evaluations, if there is one.
    pub(crate) max_evaluations: Option<u64>,
    /// The limit on time, if there is one.
    pub(crate) max_time: Option<Duration>,
}

impl Goal {
    /// The goal of a rendering; the tolerance is that of all pixels, if they have one.
    pub(crate) fn of(options: &RenderOptions<'_>, tolerance: Option<f64>) -> Self {
        Self {
            tolerance,
            max_evaluations: Some(options.max_evaluations).filter(|&most| most < u64::MAX),
            max_time: Duration::try_from_secs_f64(options.max_seconds).ok(),
        }
    }
}

/// The errors so far, and when the end is expected.
#[derive(Debug)]
struct Course {
    goal: Goal,
    started: Instant,
    law: Option<CostLaw>,
    expected_end: Option<Instant>,
}

impl Course {
    fn new(goal: Goal, started: Instant) -> Self {
        let expected_end = goal.max_time.and_then(|time| started.checked_add(time));
        Self { goal, started, law: None, expected_end }
    }

    /// An image with this error was there `now`, after so many evaluations.
    fn reached(&mut self, evaluations: u64, error: f64, now: Instant) {
        let law = match self.law {
            Some(law) => law.and(evaluations, error),
            None => CostLaw::from(evaluations, error),
        };
        self.law = law.or(self.law);
        let by_tolerance = self.law.zip(self.goal.tolerance).and_then(|(law, tolerance)| {
            let needed = law.evaluations_for(tolerance);
            let needed = self.goal.max_evaluations.map_or(needed, |most| needed.min(most));
            let share = needed.saturating_sub(evaluations) as f64 / evaluations as f64;
            let left = now.duration_since(self.started).as_secs_f64() * share;
            now.checked_add(Duration::try_from_secs_f64(left).ok()?)
        });
        let by_time = self.goal.max_time.and_then(|time| self.started.checked_add(time));
        self.expected_end = by_tolerance.into_iter().chain(by_time).min();
    }

    /// What follows the number of evaluations: ", error 0.034 (0.01 allowed), some 12 s left".
    fn text(&self, now: Instant) -> String {
        let error = self.law.map(|law| match self.goal.tolerance {
            Some(allowed) => format!(", error {} ({} allowed)", short(law.error()), short(allowed)),
            None => format!(", error {}", short(law.error())),
        });
        let is_met = self.law.zip(self.goal.tolerance).is_some_and(|(law, t)| law.error() <= t);
        let left = self.expected_end.map(|end| end.saturating_duration_since(now));
        let left = left.map(|left| match is_met {
            true => ", being verified".to_owned(),
            false => format!(", some {} left", roughly(left)),
        });
        [error, left].into_iter().flatten().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_so_far_is_told_with_the_tolerance_and_the_time_left() {
        let started = Instant::now();
        let at = |tenths: u64| started + Duration::from_millis(100 * tenths);
        let goal = Goal { tolerance: Some(0.01), ..Goal::default() };
        let mut course = Course::new(goal, started);
        assert_eq!(course.text(at(5)), "");
        course.reached(1_000, 0.16, at(10));
        course.reached(2_000, 0.04, at(20));
        // Evaluations double where the error is a quarter: 2,000 more evaluations in two seconds.
        assert_eq!(course.text(at(20)), ", error 0.04 (0.01 allowed), some 2 s left");
        assert_eq!(course.text(at(30)), ", error 0.04 (0.01 allowed), some 1 s left");
        course.reached(4_000, 0.009, at(40));
        assert_eq!(course.text(at(40)), ", error 0.009 (0.01 allowed), being verified");
    }

    #[test]
    fn limits_end_a_rendering_before() {
        let started = Instant::now();
        let goal = Goal {
            tolerance: Some(1e-6),
            max_evaluations: Some(2_000),
            max_time: Some(Duration::from_secs(10)),
        };
        let mut course = Course::new(goal, started);
        assert_eq!(course.text(started), ", some 10 s left");
        course.reached(1_000, 0.1, started + Duration::from_secs(3));
        let text = course.text(started + Duration::from_secs(3));
        assert_eq!(text, ", error 0.1 (1e-6 allowed), some 3 s left");
        course.reached(1_000, 0.1, started + Duration::from_secs(8));
        let text = course.text(started + Duration::from_secs(8));
        assert_eq!(text, ", error 0.1 (1e-6 allowed), some 2 s left");
    }
}
