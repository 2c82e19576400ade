//! How evaluations grow with accuracy: a power law through renderings that have been made.

/// Evaluations as a power of the error, N ∝ error^−exponent, through the last two points known.
///
/// It is a forecast and no bound: jumps that have not been resolved yet, and structure that has not been
/// found, cost more than it says.
///
/// ```
/// use emitree_io::CostLaw;
///
/// let law = CostLaw::from(1_000, 0.16).and_then(|law| law.and(2_000, 0.04)).unwrap();
/// assert_eq!(law.evaluations_for(0.01), 4_000);
/// assert_eq!(law.evaluations_for(0.05), 2_000); // fewer than have been made are of no use
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CostLaw {
    evaluations: u64,
    error: f64,
    exponent: f64,
}

/// The exponent of one point alone: from 5 % to 1 % the scenes of the gallery have 0 to 0.5, 0.28 in the mean.
const USUAL_EXPONENT: f64 = 0.3;
/// Exponents of products, whose cost grows with the logarithm of 1/error, and of jumps on a pixel raster.
const EXPONENTS: [f64; 2] = [0.05, 1.0];

impl CostLaw {
    /// A law through one point, with an exponent that is usual; none if the error is not above 0.
    pub fn from(evaluations: u64, error: f64) -> Option<Self> {
        let is_point = evaluations > 0 && error > 0.0 && error.is_finite();
        is_point.then_some(Self { evaluations, error, exponent: USUAL_EXPONENT })
    }

    /// A law through this point and the last one of `self`. A point that is no more accurate than that one
    /// replaces it and keeps the exponent.
    pub fn and(self, evaluations: u64, error: f64) -> Option<Self> {
        let point = Self::from(evaluations, error)?;
        if error >= self.error || evaluations <= self.evaluations {
            return Some(Self { exponent: self.exponent, ..point });
        }
        let growth = (evaluations as f64 / self.evaluations as f64).ln();
        let exponent = growth / (self.error / error).ln();
        Some(Self { exponent: exponent.clamp(EXPONENTS[0], EXPONENTS[1]), ..point })
    }

    /// The law at the point of `self` with the exponent of the intermediate images of a rendering: of the first that
    /// has half of the error of an earlier one, from the last one on; none if no errors halved.
    pub(crate) fn of_course(course: &[(u64, f64)], last: Self) -> Option<Self> {
        let &(evaluations, error) = course.last()?;
        let before = course.iter().rev().find(|(_, larger)| *larger >= 2.0 * error)?;
        let law = Self::from(before.0, before.1)?.and(evaluations, error)?;
        Some(Self { exponent: law.exponent, ..last })
    }

    /// The error at the last point.
    pub fn error(self) -> f64 {
        self.error
    }

    /// The evaluations that an error of `tolerance` is expected to take, at least those of the last point.
    pub fn evaluations_for(self, tolerance: f64) -> u64 {
        let ratio = (self.error / tolerance).max(1.0).powf(self.exponent);
        let evaluations = self.evaluations as f64 * ratio;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a positive number, which saturates"
        )]
        let whole = evaluations.round() as u64;
        whole
    }
}

#[cfg(test)]
mod tests {
    use super::CostLaw;

    #[test]
    fn exponents_are_those_of_the_last_two_points_within_limits() {
        let through = |points: &[(u64, f64)]| {
            let first = CostLaw::from(points[0].0, points[0].1).unwrap();
            points[1..].iter().fold(first, |law, &(n, error)| law.and(n, error).unwrap())
        };
        // 10^(2 * 0.3).
        assert_eq!(through(&[(100, 0.1)]).evaluations_for(0.001), 398);
        assert_eq!(through(&[(100, 0.1), (400, 0.01)]).evaluations_for(0.001), 1_600);
        // As many evaluations as accuracy, and hardly more than before.
        assert_eq!(through(&[(100, 0.1), (5_000, 0.01)]).evaluations_for(0.001), 50_000);
        assert_eq!(through(&[(100, 0.1), (101, 0.001)]).evaluations_for(1e-5), 127);
        // A worse image of another method starts anew.
        let law = through(&[(100, 0.1), (400, 0.01), (500, 0.05)]);
        assert_eq!((law.error(), law.evaluations_for(0.05)), (0.05, 500));
        assert_eq!(CostLaw::from(100, 0.0), None);
        assert_eq!(CostLaw::from(100, f64::INFINITY), None);
    }
}
