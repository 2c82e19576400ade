//! Lines on which g jumps between two steps: the jump is bisected, so that the midpoint rule converges as if g were
//! continuous.
//!
//! Midpoints of uniform steps are the trapezoidal rule between them. Where two neighbouring values differ by far more
//! than those on both sides, the trapezoid between them is replaced by those of bisected steps. The same is done for a
//! third of the steps, with the same bisected ones, so that the difference of the two integrals remains an error.

use crate::exchange::MethodError;
use crate::los::fixed::{PlaceOfLine, march};
use crate::meter::Meter;
use crate::quadrature::Points;
use crate::site::Mapping;
use crate::tile::Tile;

/// The values at two neighbouring steps jump if they differ by more than this times the differences on both sides. A
/// smooth peak that steps resolve has no such pair.
const RATIO: f64 = 3.0;
/// The share of the error allowed in a line beyond which a jump is bisected, and down to which.
const BISECTED: [f64; 2] = [0.1, 0.01];
/// The most bisections of a jump: a jump where g has no bound does not end by itself.
const MOST_BISECTIONS: usize = 40;
/// The steps of lines that are integrated together.
const STEPS_AT_ONCE: usize = 1 << 20;

/// The integrals of a line by all steps and by a third of them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Two {
    pub(super) all: f64,
    pub(super) third: f64,
    /// The error of both because jumps are not resolved further.
    pub(super) at_jumps: f64,
}

/// How far the integral of a line may be wrong.
#[derive(Clone, Copy, Debug)]
pub(super) enum Allowed {
    /// By so much.
    Absolute(f64),
    /// By this share of the largest integral of the lines that are integrated together.
    OfLargest(f64),
}

/// The jumps on some lines.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct JumpsSeen {
    /// The lines that have one.
    pub(super) lines: usize,
    /// The largest difference of rates.
    pub(super) largest: f64,
}

/// The integrals of one line, and its rates where some of them seem to jump.
#[derive(Clone, Debug, Default)]
struct Sampled {
    two: Two,
    rates: Vec<f64>,
}

/// Two depths of a line between which g jumps.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Jump {
    line: usize,
    depths: [f64; 2],
    rates: [f64; 2],
    /// The integral over what has been cut off by bisections, and the error of that.
    settled: f64,
    settled_error: f64,
}

impl Jump {
    /// After a step of a line with these rates.
    fn new(line: usize, step: usize, rates: &[f64]) -> Self {
        let depth = |step: usize| (step as f64 + 0.5) / rates.len() as f64;
        let [depths, rates] = [[depth(step), depth(step + 1)], [rates[step], rates[step + 1]]];
        Self { line, depths, rates, settled: 0.0, settled_error: 0.0 }
    }

    fn middle(&self) -> f64 {
        0.5 * (self.depths[0] + self.depths[1])
    }

    fn integral(&self) -> f64 {
        self.settled + trapezoid(self.depths[1] - self.depths[0], self.rates)
    }

    /// How far the integral may be wrong because the place of the jump is not known better.
    fn error(&self) -> f64 {
        0.5 * (self.depths[1] - self.depths[0]) * (self.rates[1] - self.rates[0]).abs()
    }

    /// Keeps the half with the larger difference, given the rate in the middle.
    fn halve(&mut self, rate: f64) {
        let middle = self.middle();
        let cut = usize::from((rate - self.rates[0]).abs() > (self.rates[1] - rate).abs());
        let half = 0.5 * (self.depths[1] - self.depths[0]);
        self.settled += trapezoid(half, [self.rates[cut], rate]);
        // As if g jumped there, too: a steep slope is a jump on steps that are longer than it.
        self.settled_error += 0.5 * half * (rate - self.rates[cut]).abs();
        (self.depths[cut], self.rates[cut]) = (middle, rate);
    }
}

fn trapezoid(width: f64, [from, to]: [f64; 2]) -> f64 {
    0.5 * width * (from + to)
}

/// The steps after which the rates jump, given the least difference.
fn jumps_of(rates: &[f64], least: f64) -> impl Iterator<Item = usize> + '_ {
    let difference = |step: usize| match rates.get(step..step + 2) {
        Some([from, to]) => (to - from).abs(),
        _ => 0.0,
    };
    (0..rates.len().saturating_sub(1)).filter(move |&step| {
        let before = step.checked_sub(1).map_or(0.0, difference);
        let beside = before.max(difference(step + 1));
        difference(step) > least.max(RATIO * beside)
    })
}

/// What the integrals of a line with jumps after these steps are without the trapezoids there.
fn without_jumps(rates: &[f64], jumps: &[usize]) -> Two {
    let width = 1.0 / rates.len() as f64;
    let between =
        |from: usize, to: usize| trapezoid((to - from) as f64 * width, [rates[from], rates[to]]);
    let mut two = two_of(rates);
    two.all -= jumps.iter().map(|&step| between(step, step + 1)).sum::<f64>();
    // From one step of the third to the next one, and from the outermost ones to the ends.
    let last = rates.len() - 1;
    let middles: Vec<usize> = (1..=last).step_by(3).collect();
    let ends = [[0].as_slice(), &middles, &[last]].concat();
    for pair in ends.windows(2) {
        let &[from, to] = pair else { continue };
        let inside: Vec<usize> =
            jumps.iter().copied().filter(|step| (from..to).contains(step)).collect();
        if inside.is_empty() {
            continue;
        }
        two.third -= match (from, to) {
            (0, _) => 1.5 * width * rates[to] - 0.5 * width * rates[0],
            _ if to == last => 1.5 * width * rates[from] - 0.5 * width * rates[last],
            _ => between(from, to),
        };
        let mut at = from;
        for step in inside {
            two.third += between(at, step);
            at = step + 1;
        }
        two.third += between(at, to);
    }
    two
}

fn two_of(rates: &[f64]) -> Two {
    let width = 1.0 / rates.len() as f64;
    let third = rates.iter().skip(1).step_by(3);
    let [all, third] = [width * rates.iter().sum::<f64>(), 3.0 * width * third.sum::<f64>()];
    Two { all, third, at_jumps: 0.0 }
}

/// What lines are integrated through.
#[derive(Clone, Copy)]
pub(super) struct Medium<'a> {
    pub(super) meter: &'a Meter,
    pub(super) tile: &'a Tile<'a>,
    /// The evaluations that lines leave to other ways to an image.
    pub(super) reserve: u64,
}

impl Medium<'_> {
    /// Whether lines may have so many more evaluations.
    pub(super) fn affords(&self, evaluations: usize) -> bool {
        self.meter.unkept_evaluations_left() >= self.reserve.saturating_add(evaluations as u64)
    }

    /// The integrals of `count` lines in so many steps, a multiple of 3, and the jumps seen; `None` if the budget does
    /// not suffice.
    pub(super) async fn integrals(
        &self,
        place: &PlaceOfLine<'_>,
        count: usize,
        steps: usize,
        allowed: Allowed,
    ) -> Result<Option<(Vec<Two>, JumpsSeen)>, MethodError> {
        if !self.affords(count * steps) {
            return Ok(None);
        }
        let mut found = Vec::with_capacity(count);
        let mut seen = JumpsSeen::default();
        let at_once = (STEPS_AT_ONCE / steps).max(1);
        for first in (0..count).step_by(at_once) {
            let place = |line: usize| place(first + line);
            let mut lines = vec![Sampled::default(); at_once.min(count - first)];
            let add = |of: &mut Sampled, _: usize, rates: &[f64]| {
                of.two = two_of(rates);
                if jumps_of(rates, 0.0).next().is_some() {
                    of.rates = rates.to_vec();
                }
            };
            let before = self.meter.keeps_none();
            march(self.meter, self.tile, &place, steps, None, &mut lines, add).await?;
            let allowed = match allowed {
                Allowed::Absolute(error) => error,
                Allowed::OfLargest(share) => {
                    let radiances = lines.iter().map(|of| of.two.all.abs());
                    share * radiances.fold(0.0, f64::max)
                }
            };
            let mut jumps = without_trapezoids(&mut lines, steps, allowed, &mut seen);
            let is_affordable = self.bisect(&place, &mut jumps, BISECTED[1] * allowed).await?;
            self.meter.keeps_again(before);
            if !is_affordable {
                return Ok(None);
            }
            for jump in jumps {
                seen.largest = seen.largest.max((jump.rates[1] - jump.rates[0]).abs());
                let two = &mut lines[jump.line].two;
                (two.all, two.third) = (two.all + jump.integral(), two.third + jump.integral());
                two.at_jumps += jump.error() + jump.settled_error;
            }
            found.extend(lines.into_iter().map(|of| of.two));
        }
        Ok(Some((found, seen)))
    }

    /// Bisects jumps until each has no more than this error; whether the budget sufficed.
    async fn bisect(
        &self,
        place: &PlaceOfLine<'_>,
        jumps: &mut [Jump],
        allowed: f64,
    ) -> Result<bool, MethodError> {
        let &Tile { projection, place: tile, .. } = self.tile;
        let map = |u| projection.world_from_canonical(u);
        let mapping = Mapping { map: &map, tile, energy: None };
        for _ in 0..MOST_BISECTIONS {
            let mut open: Vec<&mut Jump> =
                jumps.iter_mut().filter(|jump| jump.error() > allowed).collect();
            if open.is_empty() {
                break;
            }
            if !self.affords(open.len()) {
                return Ok(false);
            }
            let point = |number: usize| {
                let [x, y] = place(open[number].line);
                [x, y, open[number].middle()]
            };
            let mut rates = vec![0.0; open.len()];
            self.meter.evaluate(Points::new(rates.len(), &point), mapping, &mut rates).await?;
            open.iter_mut().zip(rates).for_each(|(jump, rate)| jump.halve(rate));
        }
        Ok(true)
    }
}

/// Takes the trapezoids at jumps out of the integrals of lines, and returns the jumps whose integrals replace them.
fn without_trapezoids(
    lines: &mut [Sampled],
    steps: usize,
    allowed: f64,
    seen: &mut JumpsSeen,
) -> Vec<Jump> {
    let mut jumps = Vec::new();
    for (line, of) in lines.iter_mut().enumerate() {
        let rates = core::mem::take(&mut of.rates);
        let least = 2.0 * BISECTED[0] * allowed * steps as f64;
        let after: Vec<usize> = jumps_of(&rates, least).collect();
        if after.is_empty() {
            continue;
        }
        seen.lines += 1;
        of.two = without_jumps(&rates, &after);
        jumps.extend(after.into_iter().map(|step| Jump::new(line, step, &rates)));
    }
    jumps
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rates in the middles of so many steps.
    fn sampled(rate: impl Fn(f64) -> f64, steps: usize) -> Vec<f64> {
        (0..steps).map(|step| rate((step as f64 + 0.5) / steps as f64)).collect()
    }

    /// The integrals after some bisections of all jumps.
    fn integrals(rate: impl Fn(f64) -> f64, steps: usize, bisections: usize) -> (Two, usize) {
        let rates = sampled(&rate, steps);
        let jumps: Vec<usize> = jumps_of(&rates, 0.0).collect();
        let mut two = without_jumps(&rates, &jumps);
        for &step in &jumps {
            let mut jump = Jump::new(0, step, &rates);
            for _ in 0..bisections {
                jump.halve(rate(jump.middle()));
            }
            (two.all, two.third) = (two.all + jump.integral(), two.third + jump.integral());
        }
        (two, jumps.len())
    }

    #[test]
    fn integrals_across_jumps_are_those_of_the_parts() {
        for [from, to] in [[0.31, 0.777], [0.02, 0.5], [0.4, 0.97], [0.45, 0.53]] {
            let rate = |z: f64| if z > from && z < to { 1.0 + z } else { 0.25 };
            let exact = 0.25 * (1.0 - (to - from)) + (to - from) + 0.5 * (to * to - from * from);
            for steps in [27, 45, 81] {
                let (two, jumps) = integrals(rate, steps, 30);
                assert_eq!(jumps, 2, "{from} {to} {steps}");
                // What is left is the trapezoidal rule of a slope from the ends to the outermost midpoints.
                assert!((two.all - exact).abs() < 1e-9, "{from} {to} {steps}: {}", two.all - exact);
                assert!(
                    (two.third - exact).abs() < 1e-9,
                    "{from} {to} {steps}: {}",
                    two.third - exact
                );
            }
        }
    }

    #[test]
    fn without_bisections_nothing_changes_in_all_steps() {
        let rate = |z: f64| if z > 0.4 { 2.0 + z * z } else { z };
        let rates = sampled(rate, 45);
        let (two, jumps) = integrals(rate, 45, 0);
        assert_eq!(jumps, 1);
        assert!((two.all - two_of(&rates).all).abs() < 1e-14);
    }

    #[test]
    fn peaks_that_steps_resolve_have_no_jump() {
        for width in [0.05, 0.1, 0.3] {
            for middle in [0.3, 0.5, 0.61] {
                let rate = |z: f64| (-((z - middle) / width).powi(2)).exp();
                let (_, jumps) = integrals(rate, 45, 0);
                assert_eq!(jumps, 0, "{width} {middle}");
            }
        }
    }
}
