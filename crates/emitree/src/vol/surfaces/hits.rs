//! Samples in other charts, and other points, at which g differs from most of the view: where few of many samples
//! meet a shape, the first samples of a search for surfaces would miss it.

use crate::meter::Meter;
use crate::parallel::prelude::*;
use crate::projection::vector::{difference, norm};
use crate::rendering::RateAt;
use crate::vol::sampling::unlike_most;
use crate::vol::view::part::{Part, Parts};
use crate::vol::view::scattered::{KnownParts, PartSamples};

/// The most samples that are taken: a shape that more of them meet is met by the first samples of a search, too.
const MOST: usize = 256;

/// A sample of a part of a view, in a chart of the whole view.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    pub(super) at: [f64; 3],
    /// g there.
    rate: f64,
    /// G there.
    pub(super) of_path: f64,
    /// Whether g is known there not to be that of most points.
    is_hit: bool,
}

/// The samples of the parts of a view in the chart of one part, those that are in view there. A sample in the gap of a body
/// is a sum over other points, and has no place.
pub(super) fn in_chart(part: &Part<'_>, parts: &Parts<'_>, samples: &[PartSamples]) -> Vec<Known> {
    let chart = &*part.chart;
    let of_parts = parts.parts.iter().zip(samples);
    let all = of_parts.flat_map(|(own, samples)| {
        samples.points.iter().zip(&samples.rates).filter_map(|(point, rate)| {
            let of_own = own.chart.world_from_chart(*point);
            let at = chart.chart_from_world(of_own.position)?;
            let is_in_view = at.iter().all(|along| (0.0..=1.0).contains(along));
            if !is_in_view || (own.chart.has_gaps() && own.chart.across_gap(*point).is_some()) {
                return None;
            }
            let [of_own, path] =
                [of_own, chart.world_from_chart(at)].map(|point| point.path_per_depth);
            let rate = rate / of_own;
            let of_path = rate * path;
            (of_own > 0.0).then_some(Known { at, rate, of_path, is_hit: false })
        })
    });
    all.collect()
}

/// The samples of a view, and all other points of it at which g is known not to be that of most, in the chart of one
/// part.
pub(super) fn known_in_chart(part: &Part<'_>, parts: &Parts<'_>, known: &KnownParts) -> Vec<Known> {
    let chart = &*part.chart;
    let known_at = |hit: &RateAt, is_hit: bool| {
        let at = chart.chart_from_world(hit.position)?;
        let path = chart.world_from_chart(at).path_per_depth;
        let is_in_view = at.iter().all(|along| (0.0..=1.0).contains(along)) && path > 0.0;
        let (rate, of_path) = (hit.rate, hit.rate * path);
        is_in_view.then_some(Known { at, rate, of_path, is_hit })
    };
    let mut all = in_chart(part, parts, &known.samples);
    let bits = |of: &Known| of.at.map(f64::to_bits);
    let is_new = |of: &Known, all: &[Known]| !all.iter().any(|other| bits(other) == bits(of));
    for (points, is_hit) in [(&known.hits, true), (&known.beside, false)] {
        for of in points.iter().filter_map(|point| known_at(point, is_hit)) {
            if is_new(&of, &all) {
                all.push(of);
            }
        }
    }
    all
}

/// Of all points at which g has been requested, those at which it is not that of most, if they are few, and the nearest
/// one of the others to each of them.
pub(crate) fn few_of_all(meter: &Meter) -> [Vec<RateAt>; 2] {
    let all = meter.first_requested();
    let unlike = unlike_most(&all.iter().map(|of| of.rate).collect::<Vec<_>>());
    if unlike.len() > most_of(all.len()) {
        return [const { Vec::new() }; 2];
    }
    let is_other = |number: &usize| unlike.binary_search(number).is_err();
    let others: Vec<&RateAt> = (0..all.len()).filter(is_other).map(|number| &all[number]).collect();
    let hits: Vec<RateAt> = unlike.into_iter().map(|number| all[number]).collect();
    let beside = |hit: &RateAt| {
        let distance = |of: &usize| norm(difference(others[*of].position, hit.position));
        (0..others.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))
    };
    let mut numbers: Vec<usize> = hits.par_iter().filter_map(beside).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let beside = numbers.into_iter().map(|number| *others[number]).collect();
    [hits, beside]
}

/// The numbers of those at which g is not that of most samples, in ascending order, with those of all hits; none if no
/// value is shared by most samples, or if more than [`MOST`] differ from it. Hits do not count for this: of the points
/// of all searches they are few, but there may be more of them than of these samples.
pub(super) fn few(samples: &[Known]) -> Vec<usize> {
    let (hits, others): (Vec<usize>, Vec<usize>) =
        (0..samples.len()).partition(|&number| samples[number].is_hit);
    let rates: Vec<f64> = others.iter().map(|&number| samples[number].rate).collect();
    let unlike = unlike_most(&rates);
    if unlike.len() > most_of(rates.len()) {
        return Vec::new();
    }
    let mut few: Vec<usize> = unlike.into_iter().map(|number| others[number]).collect();
    few.extend(hits);
    few.sort_unstable();
    few
}

/// The most of so many samples that are few.
fn most_of(samples: usize) -> usize {
    MOST.min(samples / 2)
}

/// The points of those samples with G there.
pub(super) fn hits(samples: &[Known]) -> Vec<([f64; 3], f64)> {
    few(samples).into_iter().map(|number| (samples[number].at, samples[number].of_path)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::MappedPoint;
    use crate::quadrature::Points;
    use crate::site::Mapping;
    use crate::vol::testing::{answered, meter};

    /// Requests g, which is 1 up to 100 and 0 beyond, at (0, 0, 0), (1, 0, 0) and so on.
    fn request(meter: &Meter, number: usize) {
        let point = |number: usize| [number as f64, 0.0, 0.0];
        let map =
            |position| MappedPoint { position, direction: [0.0, 0.0, -1.0], path_per_depth: 1.0 };
        let mapping = Mapping { map: &map, tile: (0, 1), energy: None };
        let rate = |[x, ..]: [f64; 3], _| f64::from(u8::from(x < 100.0));
        let mut rates = vec![1.0; number];
        let task = meter.evaluate(Points::new(number, &point), mapping, &mut rates);
        answered(meter, rate, task).unwrap();
    }

    fn samples(rate: impl Fn(usize) -> f64) -> Vec<Known> {
        let of = |number: usize| Known {
            at: [number as f64, 0.0, 0.0],
            rate: rate(number),
            of_path: 2.0 * rate(number),
            is_hit: false,
        };
        (0..400).map(of).collect()
    }

    #[test]
    fn samples_that_differ_from_most_are_hits() {
        // Equal but for rounding.
        let background = |number: usize| 3.0 * (1.0 + 1e-15 * (number % 5) as f64);
        let found = samples(|number| if number == 7 { 1.0 } else { background(number) });
        assert_eq!(few(&found), [7]);
        assert_eq!(hits(&found), [([7.0, 0.0, 0.0], 2.0)]);
        assert!(hits(&samples(|number| number as f64)).is_empty());
        assert!(hits(&samples(background)).is_empty());
    }

    #[test]
    fn hits_may_be_more_than_samples() {
        let hit = Known { at: [0.5; 3], rate: 2.0, of_path: 1.0, is_hit: true };
        let mut known = samples(|number| if number == 3 { 2.0 } else { 1.0 })[..20].to_vec();
        known.extend([hit; 200]);
        assert_eq!(few(&known), [&[3][..], &(20..220).collect::<Vec<_>>()].concat());
        known[..20].iter_mut().enumerate().for_each(|(number, of)| of.rate = number as f64);
        assert!(few(&known).is_empty());
    }

    #[test]
    fn few_of_all_are_those_requested_so_far() {
        let meter = meter(u64::MAX);
        request(&meter, 100);
        let places = || {
            few_of_all(&meter).map(|of| of.iter().map(|at| at.position[0]).collect::<Vec<f64>>())
        };
        assert_eq!(places(), [vec![], vec![]]);
        request(&meter, 102);
        assert_eq!(places(), [vec![100.0, 101.0], vec![99.0]]);
        let before = meter.keeps_none();
        request(&meter, 104);
        meter.keeps_again(before);
        assert_eq!(places()[0].len(), 2);
        request(&meter, 65_536 - 202 + 1);
        assert_eq!(places(), [vec![], vec![]]);
        request(&meter, 101);
        assert_eq!(places(), [vec![], vec![]]);
    }
}
