//! The jumps of a line, and their matches with the jumps of another line.

use crate::vol::dyadic::{STEPS, coarsest_between, unit};
use crate::vol::line::Line;
use crate::vol::tuning::TUNING;

/// A jump of G: one or more successive intervals that are steeper than a smooth function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jump {
    /// The middle of these intervals, as a fraction of the line.
    pub(crate) depth: f64,
    /// The length of these intervals together.
    pub(crate) width: f64,
    /// G at the lower end, and at the upper.
    pub(crate) below: f64,
    pub(crate) above: f64,
}

impl Jump {
    pub(crate) fn step(&self) -> f64 {
        self.above - self.below
    }

    /// Whether both have the same sign.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.step() * other.step() > 0.0
    }

    fn distance(&self, other: &Self) -> f64 {
        (self.depth - other.depth).abs()
    }
}

/// The jumps of a line that has been assessed, in the order of their depths.
pub(crate) fn jumps(line: &Line) -> Vec<Jump> {
    let mut jumps = Vec::new();
    let mut start = None;
    for i in 0..line.samples.len() {
        let goes_on = line.jumps.get(i).copied().unwrap_or(false);
        if goes_on {
            start = start.or(Some(i));
        } else if let Some(first) = start.take() {
            jumps.push(Jump {
                depth: 0.5 * (line.z(first) + line.z(i)),
                width: line.z(i) - line.z(first),
                below: line.samples[first].rate,
                above: line.samples[i].rate,
            });
        }
    }
    jumps
}

/// For each jump of `reference`, the number of its match among `others`. If both have the same
/// number of jumps with the same signs, they match in order; otherwise jumps match that are each
/// other's nearest of their sign.
pub(crate) fn matches(reference: &[Jump], others: &[Jump]) -> Vec<Option<usize>> {
    let in_order = reference.len() == others.len()
        && reference.iter().zip(others).all(|(own, other)| own.is_like(other));
    if in_order {
        return (0..reference.len()).map(Some).collect();
    }
    let nearest = |to: &Jump, among: &[Jump]| {
        let like = (0..among.len()).filter(|&k| among[k].is_like(to));
        like.min_by(|&a, &b| among[a].distance(to).total_cmp(&among[b].distance(to)))
    };
    let of_jump = |(k, own): (usize, &Jump)| {
        let other = nearest(own, others)?;
        let back = nearest(&others[other], reference)?;
        (back == k && own.distance(&others[other]) < TUNING.jumps.farthest_match).then_some(other)
    };
    reference.iter().enumerate().map(of_jump).collect()
}

/// Whether jump `k` of one line has no partner on a neighbouring line.
fn is_unmatched(own: &[Jump], k: usize, other: &[Jump]) -> bool {
    let near = |jumps: &[Jump], distance: f64| {
        let is_near = |jump: &&Jump| jump.is_like(&own[k]) && jump.distance(&own[k]) < distance;
        jumps.iter().filter(is_near).count()
    };
    near(own, TUNING.jumps.own_distance) > near(other, TUNING.jumps.partner_distance)
}

/// Whether all jumps of a line that may have caused its sample at `depth` have partners on a
/// neighbouring line.
pub(crate) fn are_matched(own: &[Jump], other: &[Jump], depth: u32) -> bool {
    let caused = |k: &usize| (own[*k].depth - unit(depth)).abs() < TUNING.jumps.cause_distance;
    !own.is_empty() && !(0..own.len()).filter(caused).any(|k| is_unmatched(own, k, other))
}

/// Depths at which a line has to be sampled for the pairs of jumps of a neighbouring line that it
/// lacks: in the middle of each pair, unless it has a sample there.
pub(crate) fn probes(pairs_of: &[Jump], of_line: &[Jump], line: &Line) -> Vec<u32> {
    let is_lacking = |&k: &usize| {
        !pairs_of[k].is_like(&pairs_of[k + 1])
            && is_unmatched(pairs_of, k, of_line)
            && is_unmatched(pairs_of, k + 1, of_line)
    };
    let probe = |k: usize| {
        let (from, to) = (pairs_of[k].depth, pairs_of[k + 1].depth);
        let (middle, reach) = (0.5 * (from + to), 0.5 * TUNING.jumps.probed_gap * (to - from));
        let (low, high) = (place_of(middle - reach), place_of(middle + reach));
        let after = line.samples.partition_point(|sample| sample.depth < low);
        let is_sampled = line.samples.get(after).is_some_and(|sample| sample.depth <= high);
        (!is_sampled).then(|| coarsest_between(low, high))
    };
    (0..pairs_of.len().saturating_sub(1)).filter(is_lacking).filter_map(probe).collect()
}

/// The place nearest to a fraction of the line.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the line")]
pub(crate) fn place_of(fraction: f64) -> u32 {
    (fraction.clamp(0.0, 1.0) * f64::from(STEPS)).round() as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::dyadic::spacing;

    fn line(rates: &[f64]) -> Line {
        let mut line = Line::default();
        line.add((0..).map(|k| k * spacing(4)).zip(rates.iter().copied()));
        line.assess(1.0, 3);
        line
    }

    fn jump(depth: f64, step: f64) -> Jump {
        Jump { depth, width: 1e-3, below: 0.0, above: step }
    }

    #[test]
    fn a_box_has_two_jumps_with_its_rates_on_either_side() {
        let found =
            jumps(&line(&[0.0, 0.0, 0.0, 0.0, 2.0, 2.0, 2.0, 2.0, 2.0, 1.0, 1.0, 1.0, 1.0]));
        assert_eq!(
            found
                .iter()
                .map(|jump| (jump.depth * 32.0, jump.below, jump.above))
                .collect::<Vec<_>>(),
            [(7.0, 0.0, 2.0), (17.0, 2.0, 1.0)]
        );
        assert!(jumps(&line(&[0.0; 9])).is_empty());
    }

    #[test]
    fn jumps_match_in_order_or_with_their_nearest() {
        let reference = [jump(0.2, 1.0), jump(0.4, -1.0), jump(0.6, 2.0)];
        let moved = reference.map(|j| Jump { depth: j.depth + 0.3, ..j });
        assert_eq!(matches(&reference, &moved), [Some(0), Some(1), Some(2)]);
        let fewer = [jump(0.41, -1.0), jump(0.63, 1.0)];
        assert_eq!(matches(&reference, &fewer), [None, Some(0), Some(1)]);
        assert_eq!(matches(&reference, &[jump(0.9, 1.0)]), [None, None, None]);
    }

    #[test]
    fn a_pair_that_a_neighbour_lacks_is_probed_once_in_its_middle() {
        let own = [jump(0.2, 1.0), jump(0.3, -1.0), jump(0.8, 1.0)];
        let other = [jump(0.75, 1.0)];
        let mut neighbour = line(&[0.0; 3]);
        let found = probes(&own, &other, &neighbour);
        assert_eq!(found, [spacing(2)]);
        neighbour.add([(spacing(2) + 1, 0.0)]);
        assert!(probes(&own, &other, &neighbour).is_empty());
        assert!(probes(&own, &own, &line(&[0.0; 3])).is_empty());
        assert!(
            are_matched(&own, &other, spacing(2) * 3) && !are_matched(&own, &other, spacing(2))
        );
    }
}
