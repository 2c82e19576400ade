//! Detection of discontinuities, for which neither polynomials nor sums of products converge.
//!
//! The interval of a fiber between the neighbouring places with the largest change is divided
//! repeatedly. If G is smooth, the change is soon distributed over the parts; that of a jump stays
//! in one part.

use crate::vol::lowrank::fibers::Fibers;
use crate::vol::tuning::TUNING;

/// An interval of a fiber on which G changes much.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Steep {
    ends: [f64; 2],
    rates: [f64; 2],
}

impl Steep {
    /// The interval between two places with these rates.
    pub(crate) fn between(ends: [f64; 2], rates: [f64; 2]) -> Self {
        Self { ends, rates }
    }

    /// The interval of the newest fiber with the largest change, if that is large enough compared
    /// with the largest residual `most`.
    pub(super) fn of_newest(fibers: &Fibers, most: f64) -> Option<Self> {
        let rates = fibers.rates.last()?;
        let change = |i: &usize| (rates[i + 1] - rates[*i]).abs();
        let i = (0..rates.len() - 1).max_by(|a, b| change(a).total_cmp(&change(b)))?;
        let ends = [fibers.places()[i], fibers.places()[i + 1]];
        (change(&i) > TUNING.lowrank.least_steep_share * most)
            .then(|| Self { ends, rates: [rates[i], rates[i + 1]] })
    }

    /// The start of equal part number `part`.
    fn place(&self, part: usize) -> f64 {
        let [from, to] = self.ends;
        from + (to - from) * part as f64 / TUNING.lowrank.steep_parts as f64
    }

    /// The places that divide the interval into equal parts.
    pub(crate) fn inside(&self) -> Vec<f64> {
        (1..TUNING.lowrank.steep_parts).map(|part| self.place(part)).collect()
    }

    /// The part with nearly all of the change, if there is one, given the rates `inside`.
    pub(crate) fn steepest_part(&self, inside: &[f64]) -> Option<Self> {
        let rates: Vec<f64> =
            [&self.rates[..1], inside, &self.rates[1..]].into_iter().flatten().copied().collect();
        let whole = (self.rates[1] - self.rates[0]).abs();
        let part = (0..TUNING.lowrank.steep_parts)
            .find(|&i| (rates[i + 1] - rates[i]).abs() > TUNING.lowrank.jump_share * whole)?;
        let ends = [self.place(part), self.place(part + 1)];
        Some(Self { ends, rates: [rates[part], rates[part + 1]] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a jump is detected on the places of level 4.
    fn jumps(f: impl Fn(f64) -> f64) -> bool {
        let mut fibers = Fibers::new(4);
        let rates = fibers.places().iter().copied().map(&f).collect();
        fibers.add([0.5; 2], rates);
        let mut steep = Steep::of_newest(&fibers, 1.0);
        for _ in 0..TUNING.lowrank.steep_steps {
            let Some(before) = steep else { return false };
            let inside: Vec<f64> = before.inside().into_iter().map(&f).collect();
            steep = before.steepest_part(&inside);
        }
        steep.is_some()
    }

    #[test]
    fn steps_are_distinguished_from_slopes() {
        for at in [0.03, 0.2, 0.5, 0.77, 0.9] {
            assert!(jumps(|x| if x < at { 0.1 } else { 1.0 }), "{at}");
            assert!(!jumps(|x| (-((x - at) / 0.03).powi(2)).exp()), "{at}");
            assert!(!jumps(|x| 0.5 * ((x - at) / 0.02).tanh()), "{at}");
        }
        // A jump that is small compared with the residual does not matter.
        assert!(!jumps(|x| if x < 0.4 { 0.0 } else { 0.2 }));
    }
}
