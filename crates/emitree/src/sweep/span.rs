//! Rates at many points as combinations of those of other emissions (a reduced basis).
//!
//! The rates of a model at fixed points, for many values of its parameters, are often in the span of a few
//! of them. A sample of the points shows whether those of another value are.

/// Directions of the rates below this share of the rates that they come from are rounding.
const LEAST: f64 = 1e-9;
/// Rates are taken as combinations if they differ at the sample by less than this fraction of the largest:
/// more shows in the image, whose tolerance is 0.01 by default.
const SIMILAR: f64 = 3e-3;

/// Directions that span the rates of some emissions, and a point for each at which all later ones are 0.
pub(super) struct Span {
    directions: Vec<Vec<f64>>,
    pivots: Vec<usize>,
}

impl Span {
    /// The span of the rates of emissions at the same points.
    ///
    /// Elimination with the largest entry as pivot, one emission after the other: the points of the
    /// empirical interpolation method (doi:10.1016/j.crma.2004.08.006).
    pub(super) fn of(emissions: &[Vec<f64>]) -> Self {
        let (mut directions, mut pivots): (Vec<Vec<f64>>, Vec<usize>) = (Vec::new(), Vec::new());
        for rates in emissions {
            let mut direction = rates.clone();
            for (former, &pivot) in directions.iter().zip(&pivots) {
                let factor = direction[pivot] / former[pivot];
                subtract(&mut direction, former, factor);
            }
            let Some(pivot) = place_of_largest(&direction) else { continue };
            if direction[pivot].abs() > LEAST * largest(rates) {
                directions.push(direction);
                pivots.push(pivot);
            }
        }
        Self { directions, pivots }
    }

    /// The numbers of some points, ascending: `count` of them spread over all `points`, and the pivots.
    pub(super) fn sample(&self, points: usize, count: usize) -> Vec<usize> {
        let mut sample: Vec<usize> = (0..count).map(|i| i * points / count).collect();
        sample.extend(&self.pivots);
        sample.sort_unstable();
        sample.dedup();
        sample
    }

    /// The rates at all points from those at a sample of them; `None` if these are not in the span.
    pub(super) fn combined(&self, sample: &[usize], rates: &[f64]) -> Option<Vec<f64>> {
        let at_sample =
            |of_all: &Vec<f64>| -> Vec<f64> { sample.iter().map(|&i| of_all[i]).collect() };
        let mut found = vec![0.0; self.directions.first()?.len()];
        let mut residual = rates.to_vec();
        // Least squares by Gram–Schmidt at the sample, with the same steps at all points.
        let mut former: Vec<[Vec<f64>; 2]> = Vec::new();
        for direction in &self.directions {
            let [mut here, mut everywhere] = [at_sample(direction), direction.clone()];
            for _ in 0..2 {
                for [other, of_other] in &former {
                    let common = dot(&here, other);
                    subtract(&mut here, other, common);
                    subtract(&mut everywhere, of_other, common);
                }
            }
            let length = dot(&here, &here).sqrt();
            if length == 0.0 {
                continue;
            }
            here.iter_mut().chain(&mut everywhere).for_each(|entry| *entry /= length);
            let component = dot(&residual, &here);
            subtract(&mut residual, &here, component);
            subtract(&mut found, &everywhere, -component);
            former.push([here, everywhere]);
        }
        let allowed = SIMILAR * largest(&found).max(largest(rates));
        if largest(&residual) > allowed {
            return None;
        }
        sample.iter().zip(rates).for_each(|(&i, &rate)| found[i] = rate);
        Some(found)
    }
}

/// Subtracts a multiple of other entries.
fn subtract(entries: &mut [f64], others: &[f64], factor: f64) {
    entries.iter_mut().zip(others).for_each(|(entry, other)| *entry -= factor * other);
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn place_of_largest(entries: &[f64]) -> Option<usize> {
    (0..entries.len()).max_by(|&i, &j| entries[i].abs().total_cmp(&entries[j].abs()))
}

fn largest(entries: &[f64]) -> f64 {
    entries.iter().fold(0.0, |most, entry| entry.abs().max(most))
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: usize = 400;

    fn rates(of: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..POINTS).map(|i| of(i as f64 / POINTS as f64)).collect()
    }

    fn some(of_all: &[f64], sample: &[usize]) -> Vec<f64> {
        sample.iter().map(|&i| of_all[i]).collect()
    }

    #[test]
    fn combinations_are_found_at_all_points() {
        let known = [rates(|x| (3.0 * x).sin()), rates(|x| x * x), rates(|x| 2.0 * x * x)];
        let span = Span::of(&known);
        // The third one is twice the second one.
        assert_eq!((span.directions.len(), span.pivots.len()), (2, 2));
        let sample = span.sample(POINTS, 16);
        assert!(sample.len() <= 18 && sample.windows(2).all(|pair| pair[0] < pair[1]));
        let other = rates(|x| 0.3 * (3.0 * x).sin() - 7.0 * x * x);
        let found = span.combined(&sample, &some(&other, &sample)).unwrap();
        for (found, exact) in found.iter().zip(&other) {
            assert!((found - exact).abs() < 1e-13, "{found} {exact}");
        }
    }

    #[test]
    fn other_rates_are_refused() {
        let span = Span::of(&[rates(|x| (3.0 * x).sin())]);
        let sample = span.sample(POINTS, 16);
        let other = rates(|x| (3.2 * x).sin());
        assert_eq!(span.combined(&sample, &some(&other, &sample)), None);
        assert!(Span::of(&[rates(|_| 0.0)]).combined(&[0], &[1.0]).is_none());
    }
}
