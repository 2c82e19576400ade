//! Jumps of κ in a panel: the place of one is found by bisection, at one sample a step instead of the 32 of two
//! halves of a panel.

/// Halvings after which a jump is told from a slope.
const STEPS_OF_SLOPES: u8 = 5;
/// The share of the first difference that a jump keeps, and a slope does not.
const SHARE_OF_JUMP: f64 = 0.7;
/// What the place of a jump may contribute to the error of a panel.
const SHARE_OF_ERROR: f64 = 0.1;
/// The width of a bracket that rounding does not let become smaller.
const NARROWEST: f64 = 1e-15;

/// An interval of z with the values at its ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bracket {
    ends: [f64; 2],
    values: [f64; 2],
    /// The difference of the first values.
    first: f64,
    steps: u8,
}

impl Bracket {
    /// The interval between adjacent places with the largest difference; there are two or more.
    pub(super) fn steepest(places: &[f64], values: &[f64]) -> Self {
        let between = places.windows(2).zip(values.windows(2));
        let brackets = between.map(|(ends, values)| Self {
            ends: [ends[0], ends[1]],
            values: [values[0], values[1]],
            first: (values[1] - values[0]).abs(),
            steps: 0,
        });
        let none = Self { ends: [0.0; 2], values: [0.0; 2], first: -1.0, steps: 0 };
        brackets.fold(
            none,
            |steepest, other| {
                if other.first > steepest.first { other } else { steepest }
            },
        )
    }

    fn difference(&self) -> f64 {
        (self.values[1] - self.values[0]).abs()
    }

    fn width(&self) -> f64 {
        self.ends[1] - self.ends[0]
    }

    fn is_slope(&self) -> bool {
        self.first <= 0.0 || self.difference() < SHARE_OF_JUMP * self.first
    }

    /// Whether another step is needed.
    pub(super) fn is_open(&self, allowed: f64) -> bool {
        let is_found = self.difference() * self.width() <= SHARE_OF_ERROR * allowed
            || self.width() <= NARROWEST;
        if self.steps < STEPS_OF_SLOPES {
            self.first > 0.0 && self.width() > NARROWEST
        } else {
            !self.is_slope() && !is_found
        }
    }

    pub(super) fn middle(&self) -> f64 {
        0.5 * (self.ends[0] + self.ends[1])
    }

    /// Keeps the steeper half, given the value in the middle.
    pub(super) fn halve(&mut self, value: f64) {
        let middle = self.middle();
        if (value - self.values[0]).abs() > (self.values[1] - value).abs() {
            (self.ends[1], self.values[1]) = (middle, value);
        } else {
            (self.ends[0], self.values[0]) = (middle, value);
        }
        self.steps = self.steps.saturating_add(1);
    }

    /// The place of the jump; none if it is a slope.
    pub(super) fn jump(&self) -> Option<f64> {
        (!self.is_slope()).then(|| self.middle())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bracket after all its steps, and their number.
    fn closed(f: impl Fn(f64) -> f64, allowed: f64) -> (Bracket, usize) {
        let places: Vec<f64> = (0..16).map(|i| f64::from(i) / 15.0).collect();
        let values: Vec<f64> = places.iter().map(|&z| f(z)).collect();
        let (mut bracket, mut steps) = (Bracket::steepest(&places, &values), 0);
        while bracket.is_open(allowed) {
            bracket.halve(f(bracket.middle()));
            steps += 1;
        }
        (bracket, steps)
    }

    #[test]
    fn a_jump_is_found_to_the_error_allowed() {
        for at in [0.013, 0.4, 0.77, 0.999] {
            let (bracket, steps) = closed(|z| if z < at { 3.0 * z } else { 3.0 * z + 5.0 }, 1e-5);
            let found = bracket.jump().unwrap();
            assert!((found - at).abs() * 5.0 < 1e-6, "{at}: {found}");
            assert!(steps < 22, "{steps}");
        }
    }

    #[test]
    fn slopes_kinks_and_constants_are_no_jumps() {
        let tanh = closed(|z| ((z - 0.4) / 0.05).tanh(), 1e-9);
        let kink = closed(|z| (z - 0.41).abs(), 1e-9);
        assert_eq!((tanh.0.jump(), tanh.1), (None, 5));
        assert_eq!((kink.0.jump(), kink.1), (None, 5));
        assert_eq!(closed(|_| 2.0, 1e-9).1, 0);
        assert_eq!(closed(|_| 2.0, 1e-9).0.jump(), None);
    }
}
