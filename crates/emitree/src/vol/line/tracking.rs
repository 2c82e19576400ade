//! Tracking of jumps: their expected depths on a new line, from those on the full lines around it.
//!
//! A surface on which g jumps cuts neighbouring lines at depths that vary smoothly over the image:
//! a [local fit](crate::vol::least_squares) to them gives the depth on a new line. Towards a limb
//! two jumps of opposite sign approach each other like z = m ± √v, where only the middle m and the
//! squared half width v vary smoothly; such pairs are fitted in this form.

use crate::vol::dyadic::{coarsest_between, spacing};
use crate::vol::least_squares::{DataPoint, Estimate, MOST_VALUES, estimate};
use crate::vol::line::Line;
use crate::vol::line::jumps::{Jump, matches, place_of};
use crate::vol::tuning::TUNING;

/// A full line near a new one.
#[derive(Clone, Debug)]
pub(crate) struct Neighbour {
    /// The place relative to the new line, in units of the distance of the nearest line.
    pub(crate) place: [f64; 2],
    pub(crate) jumps: Vec<Jump>,
}

/// Two depths between which a jump is expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bracket {
    pub(crate) low: u32,
    pub(crate) high: u32,
    /// G on either side of the jump on the reference line.
    below: f64,
    above: f64,
    misses: u8,
}

/// The depths at which a new line is to be sampled because of jumps.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Predicted {
    pub(crate) brackets: Vec<Bracket>,
    /// Single depths near jumps that have no bracket.
    pub(crate) probes: Vec<u32>,
}

impl Bracket {
    /// The next depth to be sampled once `line` has both ends; `None` if the jump is between them,
    /// or if the search is given up.
    pub(crate) fn next(&mut self, line: &Line) -> Option<u32> {
        let rate = |depth| line.find(depth).ok().map(|i| line.samples[i].rate);
        loop {
            let ends = [rate(self.low)?, rate(self.high)?];
            let is_below = |rate: f64| (rate - self.below).abs() <= (rate - self.above).abs();
            let [low, high] = ends.map(is_below);
            if low != high || self.misses == TUNING.jumps.most_misses {
                return None;
            }
            self.misses += 1;
            let stride = TUNING.jumps.search_stride.saturating_mul(self.high - self.low);
            if low {
                (self.low, self.high) =
                    (self.high, self.high.saturating_add(stride).min(spacing(0)));
            } else {
                (self.low, self.high) = (self.low.saturating_sub(stride), self.low);
            }
            let next = if low { self.high } else { self.low };
            if self.low == self.high {
                return None;
            }
            if !line.has(next) {
                return Some(next);
            }
        }
    }
}

/// The expected jumps of a line, given its `neighbours`, the nearest first. Brackets are not
/// narrower than the error of the integral needs for `tolerance`.
pub(crate) fn predict(neighbours: &[Neighbour], tolerance: f64) -> Predicted {
    let nearest = &neighbours[..neighbours.len().min(TUNING.jumps.reference_lines)];
    let reference = nearest.iter().rev().max_by_key(|neighbour| neighbour.jumps.len());
    let Some(reference) = reference.map(|neighbour| &neighbour.jumps).filter(|j| !j.is_empty())
    else {
        return Predicted::default();
    };
    let matched: Vec<Vec<Option<usize>>> =
        neighbours.iter().map(|neighbour| matches(reference, &neighbour.jumps)).collect();
    let surfaces = Surfaces { neighbours, matched };
    let mut predicted = Predicted::default();
    let mut depths: Vec<Option<Estimate>> =
        (0..reference.len()).map(|k| estimate(&surfaces.data_points(k))).collect();
    for k in 0..reference.len() - 1 {
        if !reference[k].is_like(&reference[k + 1]) {
            surfaces.fit_pair(k, &mut depths, &mut predicted.probes);
        }
    }
    for (k, depth) in depths.iter().enumerate() {
        let Some(Estimate { value: depth, error }) = *depth else { continue };
        // Each jump may have an equal share of the tolerance, with one share to spare.
        let shares = (reference.len() + 1) as f64;
        let step = reference[k].step().abs();
        let narrow = tolerance / (2.0 * TUNING.line.jump_error * step * shares);
        let half = (TUNING.jumps.bracket_scale
            * (error + TUNING.jumps.width_share * surfaces.width(k)))
        .max(narrow);
        if depth + half <= 0.0 || depth - half >= 1.0 || half > TUNING.jumps.widest_bracket {
            if depth > 0.0 && depth < 1.0 {
                predicted.probes.extend([
                    outside(depth, TUNING.jumps.probe_distance, false),
                    outside(depth, TUNING.jumps.probe_distance, true),
                ]);
            }
            continue;
        }
        predicted.brackets.push(Bracket {
            low: outside(depth - half, half, false),
            high: outside(depth + half, half, true),
            below: reference[k].below,
            above: reference[k].above,
            misses: 0,
        });
    }
    separate(&mut predicted.brackets);
    predicted
}

/// Separates overlapping brackets at a depth between their middles.
fn separate(brackets: &mut Vec<Bracket>) {
    for k in 1..brackets.len() {
        if brackets[k - 1].high >= brackets[k].low {
            let (low, high) = (brackets[k - 1].middle(), brackets[k].middle());
            let between = low.min(high) + low.abs_diff(high) / 2;
            let reach = low.abs_diff(high) / 4;
            let split = coarsest_between(between - reach, between + reach);
            brackets[k - 1].high = split;
            brackets[k].low = split;
        }
    }
    brackets.retain(|bracket| bracket.low < bracket.high);
}

impl Bracket {
    fn middle(&self) -> u32 {
        self.low.midpoint(self.high)
    }
}

/// A coarse place at or beyond `fraction` of the line, above it if `up`, by at most the slack times
/// `half`.
fn outside(fraction: f64, half: f64, up: bool) -> u32 {
    let slack = TUNING.jumps.slack * half;
    if up {
        coarsest_between(place_of(fraction), place_of(fraction + slack))
    } else {
        coarsest_between(place_of(fraction - slack), place_of(fraction))
    }
}

/// The jumps of the neighbours, by the jump of the reference line that they match.
struct Surfaces<'a> {
    neighbours: &'a [Neighbour],
    matched: Vec<Vec<Option<usize>>>,
}

impl Surfaces<'_> {
    /// The neighbours that have jump `k`, with this jump.
    fn of(&self, k: usize) -> impl Iterator<Item = (&Neighbour, &Jump)> {
        let with = self.neighbours.iter().zip(&self.matched);
        with.filter_map(move |(neighbour, matched)| {
            Some((neighbour, &neighbour.jumps[matched[k]?]))
        })
    }

    /// The depths of jump `k` on the nearest lines that have it.
    fn data_points(&self, k: usize) -> Vec<DataPoint> {
        let known = |(neighbour, jump): (&Neighbour, &Jump)| DataPoint {
            place: neighbour.place,
            value: jump.depth,
        };
        self.of(k).map(known).take(MOST_VALUES).collect()
    }

    /// The largest width of jump `k` on the nearest lines.
    fn width(&self, k: usize) -> f64 {
        self.of(k).take(TUNING.jumps.width_lines).map(|(_, jump)| jump.width).fold(0.0, f64::max)
    }

    /// Replaces jumps `k` and `k` + 1 by a fit to their middle and squared half width if its error
    /// is smaller. If the squared half width is negative, the line may pass by the pair, and a
    /// probe at the middle replaces them.
    fn fit_pair(&self, k: usize, depths: &mut [Option<Estimate>], probes: &mut Vec<u32>) {
        let (mut middles, mut squares) = (Vec::new(), Vec::new());
        for (neighbour, matched) in self.neighbours.iter().zip(&self.matched) {
            let (Some(low), Some(high)) = (matched[k], matched[k + 1]) else { continue };
            if high != low + 1 || middles.len() == MOST_VALUES {
                continue;
            }
            let (low, high) = (neighbour.jumps[low].depth, neighbour.jumps[high].depth);
            let known = |value| DataPoint { place: neighbour.place, value };
            middles.push(known(0.5 * (low + high)));
            squares.push(known(0.25 * (high - low) * (high - low)));
        }
        let (Some(middle), Some(square)) = (estimate(&middles), estimate(&squares)) else { return };
        let own = [k, k + 1].map(|k| depths[k].map_or(f64::INFINITY, |depth| depth.error));
        if square.value < -TUNING.jumps.bracket_scale * square.error {
            let inside = middle.value > 0.0 && middle.value < 1.0;
            if inside && own[0] > TUNING.jumps.own_fit_share * middle.error {
                probes.push(outside(
                    middle.value,
                    middle.error.max(TUNING.jumps.pair_probe_width),
                    false,
                ));
                (depths[k], depths[k + 1]) = (None, None);
            }
            return;
        }
        let value = square.value.max(0.0);
        let half = value.sqrt();
        let wider = (value + square.error).sqrt() - half;
        let narrower = half - (value - square.error).max(0.0).sqrt();
        let error = wider.max(narrower) + middle.error;
        for ((k, sign), own) in [(k, -1.0), (k + 1, 1.0)].into_iter().zip(own) {
            if own > error {
                depths[k] = Some(Estimate { value: middle.value + sign * half, error });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::dyadic::unit;

    const TOLERANCE: f64 = 1e-4;

    /// A line with samples at the given depths and at the ends.
    fn line(rate: impl Fn(f64) -> f64, depths: impl IntoIterator<Item = u32>) -> Line {
        let mut line = Line::default();
        let all = depths.into_iter().chain([0, spacing(0)]);
        line.add(all.map(|depth| (depth, rate(unit(depth)))));
        line
    }

    /// The lattice around the new line with the jumps given by `jumps`, the nearest lines first.
    fn neighbours(jumps: impl Fn(f64, f64) -> Vec<(f64, f64)>) -> Vec<Neighbour> {
        let mut places = Vec::new();
        for i in -2..3 {
            for j in -2..3 {
                let (x, y) = (f64::from(2 * i + 1), f64::from(2 * j + 1));
                places.push([x / 2.0_f64.sqrt(), y / 2.0_f64.sqrt()]);
            }
        }
        places.sort_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1])));
        let neighbour = |place: [f64; 2]| {
            let jump = |(depth, step): (f64, f64)| Jump {
                depth,
                width: 1e-5,
                below: if step > 0.0 { 0.0 } else { -step },
                above: step.max(0.0),
            };
            Neighbour { place, jumps: jumps(place[0], place[1]).into_iter().map(jump).collect() }
        };
        places.into_iter().take(TUNING.jumps.most_neighbours).map(neighbour).collect()
    }

    /// The number of samples until one bracket contains the jump or is given up, and the width of
    /// the bracket.
    fn search(mut bracket: Bracket, rate: impl Fn(f64) -> f64 + Copy) -> (usize, f64) {
        let mut line = line(rate, [bracket.low, bracket.high]);
        while let Some(depth) = bracket.next(&line) {
            line.add([(depth, rate(unit(depth)))]);
        }
        (line.samples.len() - 2, unit(bracket.high - bracket.low))
    }

    #[test]
    fn a_moving_jump_is_bracketed_with_2_to_4_samples() {
        let depth = |x: f64, y: f64| 0.4 + 0.02 * x - 0.01 * y + 0.002 * x * y + 1e-4 * x.powi(3);
        let predicted = predict(&neighbours(|x, y| vec![(depth(x, y), 1.0)]), TOLERANCE);
        assert_eq!((predicted.brackets.len(), predicted.probes.len()), (1, 0));
        let step = |z: f64| if z < 0.4 { 0.0 } else { 1.0 };
        let (samples, width) = search(predicted.brackets[0], step);
        assert!((2..=4).contains(&samples) && width < 0.01, "{samples} {width}");
    }

    #[test]
    fn near_a_limb_both_jumps_of_a_pair_are_bracketed() {
        let pair = |x: f64, y: f64| {
            let square: f64 = 0.01 - 0.0004 * (x * x + y * y) + 0.002 * x;
            if square <= 0.0 {
                return vec![];
            }
            vec![(0.5 - square.sqrt(), 1.0), (0.5 + square.sqrt(), -1.0)]
        };
        let predicted = predict(&neighbours(pair), TOLERANCE);
        assert_eq!(predicted.brackets.len(), 2);
        for (bracket, depth) in predicted.brackets.iter().zip([0.4, 0.6]) {
            assert!(unit(bracket.low) < depth && depth < unit(bracket.high), "{bracket:?}");
            assert!(unit(bracket.high - bracket.low) < 1e-3, "{bracket:?}");
        }
    }

    #[test]
    fn beyond_a_limb_there_is_one_probe_in_the_middle() {
        let pair = |x: f64, y: f64| {
            let square: f64 = -0.0004 + 0.002 * x + 1e-5 * y;
            if square <= 0.0 {
                return vec![];
            }
            vec![(0.5 - square.sqrt(), 1.0), (0.5 + square.sqrt(), -1.0)]
        };
        let predicted = predict(&neighbours(pair), TOLERANCE);
        assert_eq!((predicted.brackets.len(), predicted.probes.len()), (0, 1));
        assert!((unit(predicted.probes[0]) - 0.5).abs() < 0.05);
    }

    #[test]
    fn a_miss_is_recovered_and_one_too_far_is_given_up() {
        let (low, high) = (spacing(1), spacing(1) + spacing(8));
        let bracket = Bracket { low, high, below: 0.0, above: 1.0, misses: 0 };
        for depth in [0.49, 0.51, 0.53] {
            let step = move |z: f64| if z < depth { 0.0 } else { 1.0 };
            let (samples, width) = search(bracket, step);
            assert!(samples <= 4 && width < 0.1, "{depth}: {samples} {width}");
        }
        assert_eq!(search(bracket, |_| 0.0).0, 5);
    }

    #[test]
    fn no_jumps_are_expected_beside_lines_without_jumps() {
        assert_eq!(predict(&neighbours(|_, _| vec![]), TOLERANCE), Predicted::default());
        assert_eq!(predict(&[], TOLERANCE), Predicted::default());
    }
}
