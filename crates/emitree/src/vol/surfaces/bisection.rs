//! Whether G jumps between two points.

use crate::vol::surfaces::search::{Failure, Search};
use crate::vol::tuning::TUNING;

/// Two points with their values.
pub(super) type Bracket = [([f64; 3], f64); 2];

impl Search<'_> {
    /// Whether G jumps between the points of each pair: the steepest half is divided repeatedly. Adds the points in
    /// between to `found`.
    pub(super) async fn are_jumps(
        &mut self,
        mut brackets: Vec<Bracket>,
        found: &mut Vec<([f64; 3], f64)>,
    ) -> Result<Vec<bool>, Failure> {
        let changes = |brackets: &[Bracket]| -> Vec<f64> {
            brackets.iter().map(|[a, b]| (b.1 - a.1).abs()).collect()
        };
        let first = changes(&brackets);
        // The differences before the last two halvings: a pair may be on two sides of several surfaces, and a slope
        // leaves little of a difference behind.
        let mut before = vec![f64::INFINITY; brackets.len()];
        for halving in 0..TUNING.surfaces.halvings {
            if halving + 2 == TUNING.surfaces.halvings {
                before = changes(&brackets);
            }
            let middle = |[a, b]: &Bracket| core::array::from_fn(|k| 0.5 * (a.0[k] + b.0[k]));
            let points: Vec<[f64; 3]> = brackets.iter().map(middle).collect();
            let rates = self.rates(&points).await?;
            for ((bracket, at), rate) in brackets.iter_mut().zip(points).zip(rates) {
                found.push((at, rate));
                let [a, b] = bracket.map(|(_, end)| (end - rate).abs());
                bracket[usize::from(a > b)] = (at, rate);
            }
        }
        let is_jump = |((left, before), first): ((f64, f64), f64)| {
            left > TUNING.surfaces.jump_share * before && left > TUNING.surfaces.slope_left * first
        };
        Ok(changes(&brackets).into_iter().zip(before).zip(first).map(is_jump).collect())
    }
}
