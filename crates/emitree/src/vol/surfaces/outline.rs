//! What is to be done with a box of a region: the samples that its polynomial is to be fitted to.

use crate::projection::vector::{difference, norm};
use crate::vol::lattice;
use crate::vol::surfaces::boxes::{CANDIDATES, OpenBox, along_each, candidates};
use crate::vol::surfaces::octree::{Label, Leaf, Octree};
use crate::vol::surfaces::polynomial::{DEGREE, Polynomial, TERMS};
use crate::vol::surfaces::search::Search;
use crate::vol::tuning::TUNING;

/// The places of a box at which the error of its polynomial counts, those among which they are chosen, and
/// the points tried for these.
const PLACES: usize = 24;
const CHOICE: usize = 512;
const TRIES: usize = 4096;

/// What is to be done with a box.
#[derive(Debug)]
pub(super) enum Outline {
    /// Nothing of it is in the region.
    Empty,
    /// Little of it is in the region: its polynomial follows from samples around it.
    Continued(Box<Continued>),
    /// Its polynomial is fitted to samples in the box.
    Samples(Plan),
}

impl Outline {
    /// The points at which G is evaluated.
    pub(super) fn points(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        let [new, checks]: [&[[f64; 3]]; 2] = match self {
            Self::Empty => [&[], &[]],
            Self::Continued(continued) => [&[], &continued.checks],
            Self::Samples(plan) => [&plan.new, &plan.checks],
        };
        new.iter().chain(checks).copied()
    }
}

/// A polynomial that is continued into a box from samples around it.
#[derive(Debug)]
pub(super) struct Continued {
    pub(super) polynomial: Polynomial,
    /// Points at which it is checked.
    pub(super) checks: Vec<[f64; 3]>,
    /// The least error that is allowed. Where no place is in the region for certain, it may be the jump at the surface:
    /// the error of the surface covers it.
    pub(super) least_allowed: f64,
}

/// What the polynomial of a box is fitted to.
#[derive(Debug, Default)]
pub(super) struct Plan {
    pub(super) known: Vec<usize>,
    pub(super) new: Vec<[f64; 3]>,
    /// Points that take no part in the fit.
    pub(super) checks: Vec<[f64; 3]>,
    /// Places at which the polynomial is used.
    pub(super) places: Vec<[f64; 3]>,
}

/// At most so many of the samples of a box, evenly.
fn thinned(samples: &[usize]) -> impl Iterator<Item = usize> + '_ {
    samples.iter().step_by(samples.len() / CANDIDATES + 1).copied()
}

/// Those places that are furthest from all samples, in edges of a box: there a polynomial is extrapolated most.
fn furthest(places: Vec<[f64; 3]>, samples: &[[f64; 3]], edges: [f64; 3]) -> Vec<[f64; 3]> {
    let square =
        |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| ((a[k] - b[k]) / edges[k]).powi(2)).sum::<f64>();
    let nearest = |at: [f64; 3]| {
        samples.iter().map(|sample| square(at, *sample)).fold(f64::INFINITY, f64::min)
    };
    let mut far: Vec<(f64, [f64; 3])> = places.into_iter().map(|at| (nearest(at), at)).collect();
    far.sort_by(|a, b| b.0.total_cmp(&a.0));
    far.into_iter().take(PLACES).map(|(_, at)| at).collect()
}

/// The smallest jump at the surfaces in a box; 0 without surfaces.
fn least_jump(tree: &Octree, of: &OpenBox) -> f64 {
    let leaves = of.leaves.iter().map(|&leaf| &tree.leaves[leaf].1);
    let cut =
        leaves.filter_map(|leaf| if let Leaf::Cut(facets) = leaf { Some(facets) } else { None });
    let jumps = cut.flatten().map(|facet| facet.jump);
    let least = jumps.fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

impl Search<'_> {
    /// What is to be done with a box, which is tightened around the region.
    pub(super) fn outline(&self, tree: &Octree, label: Label, of: OpenBox) -> (OpenBox, Outline) {
        let of = of.tightened(tree);
        if of.leaves.is_empty() {
            return (of, Outline::Empty);
        }
        let candidates = candidates(&of, &|at| self.is_well_inside(tree, label, at));
        // With fewer of them none would be left for checks, and a polynomial of few samples would be extrapolated to
        // the rest of the box.
        if candidates.len() >= self.wanted_samples(&of) + TUNING.surfaces.piece_checks {
            let mut plan = self.plan(&of, &candidates);
            let known = plan.known.iter().map(|&i| self.samples.get(i).at);
            let samples: Vec<[f64; 3]> = known.chain(plan.new.iter().copied()).collect();
            let edges = difference(of.high, of.low);
            plan.places = furthest(self.places(tree, label, &of, CHOICE), &samples, edges);
            return (of, Outline::Samples(plan));
        }
        let places = self.places(tree, label, &of, PLACES);
        let polynomial = self.continued(&of, label, &places);
        // Those that are furthest inside, as far as they are in the region for certain.
        let clearance = |at: &[f64; 3]| tree.leaf(*at).clearance(*at);
        let mut inside: Vec<(f64, [f64; 3])> = places
            .into_iter()
            .filter(|at| tree.leaf(*at).region(*at) == label && !self.hides(*at))
            .map(|at| (clearance(&at), at))
            .filter(|(clearance, _)| *clearance > 1.0)
            .collect();
        let least_allowed = if inside.is_empty() { least_jump(tree, &of) } else { 0.0 };
        inside.sort_by(|a, b| b.0.total_cmp(&a.0));
        inside.truncate(TUNING.surfaces.piece_checks);
        let checks = inside.into_iter().map(|(_, at)| at).collect();
        (of, Outline::Continued(Box::new(Continued { polynomial, checks, least_allowed })))
    }

    /// Whether a point is in view, in a region and not near its surfaces.
    pub(super) fn is_well_inside(&self, tree: &Octree, label: Label, at: [f64; 3]) -> bool {
        let leaf = tree.leaf(at);
        leaf.region(at) == label
            && leaf.clearance(at) > TUNING.surfaces.piece_clearance
            && !self.hides(at)
    }

    /// The polynomial of a box of which little is in the region, from the samples around it, too: those
    /// of a small part of the box would be extrapolated to all of it.
    fn continued(&self, of: &OpenBox, label: Label, places: &[[f64; 3]]) -> Polynomial {
        let edges = difference(of.high, of.low);
        // As many as in a box with samples of its own: with fewer the degree would be lower.
        let wanted = self.wanted_samples(of);
        let mut reach = 1.0;
        loop {
            let low = core::array::from_fn(|k| of.low[k] - reach * edges[k]);
            let high = core::array::from_fn(|k| of.high[k] + reach * edges[k]);
            let is_near = |&i: &usize| {
                let at = self.samples.get(i).at;
                let is_in = (0..3).all(|k| low[k] <= at[k] && at[k] <= high[k]);
                is_in && self.samples.is_of(i, label)
            };
            let samples: Vec<usize> = (0..self.samples.len()).filter(is_near).collect();
            let is_whole = (0..3).all(|k| low[k] <= 0.0 && high[k] >= self.grid.edges[k]);
            if samples.len() >= wanted || is_whole {
                let samples: Vec<usize> = thinned(&samples).collect();
                return self.polynomial([low, high], &samples, places);
            }
            reach = 2.0 * reach + 1.0;
        }
    }

    /// At most `most` places of a box that are in the region, up to its surfaces; those of its leaves if it is
    /// thin.
    fn places(&self, tree: &Octree, label: Label, of: &OpenBox, most: usize) -> Vec<[f64; 3]> {
        let edges = difference(of.high, of.low);
        let scattered = (0..TRIES).map(lattice::point).map(|u| along_each(of.low, u, edges));
        let is_inside = |at: &[f64; 3]| tree.leaf(*at).region(*at) == label && !self.hides(*at);
        let found: Vec<[f64; 3]> = scattered.filter(is_inside).take(most).collect();
        if !found.is_empty() {
            return found;
        }
        let stride = of.leaves.len() / PLACES + 1;
        of.leaves
            .iter()
            .step_by(stride)
            .map(|&leaf| self.grid.centre(tree.leaves[leaf].0))
            .collect()
    }

    /// The error allowed in a box: the least on its lines, since a box may be all of a wide view. That of a box which
    /// is a small part of the lines of a pixel may be larger.
    pub(super) fn allowed(&self, of: &OpenBox) -> f64 {
        let of_line = (0..9).map(|place| {
            let u = [place % 3, place / 3, 1].map(|k| 0.5 * f64::from(k));
            let at = core::array::from_fn(|k| of.low[k] + u[k] * (of.high[k] - of.low[k]));
            let [x, y, _] = self.grid.canonical(at);
            self.aim.of_line([x, y])
        });
        let edges = difference(of.high, of.low);
        let [across, along] = self.aim.pixels_across();
        let share = (edges[0] / self.grid.edges[0] * across).min(1.0)
            * (edges[1] / self.grid.edges[1] * along).min(1.0)
            * (edges[2] / self.grid.edges[2]);
        let larger = (1.0 / (TUNING.surfaces.piece_boxes * share)).max(1.0);
        let of_line = of_line.fold(self.largest_allowed(), f64::min);
        TUNING.surfaces.piece_share * larger * of_line
    }

    /// A limit where there is no image.
    fn largest_allowed(&self) -> f64 {
        let least = self.aim.scale.pixels().iter().copied().filter(|scale| *scale > 0.0);
        let least = least.fold(f64::INFINITY, f64::min);
        if least.is_finite() { self.aim.target / least } else { self.aim.target }
    }

    /// The samples for the polynomial of a box: known ones where these are well placed.
    fn plan(&self, of: &OpenBox, candidates: &[[f64; 3]]) -> Plan {
        let wanted = self.wanted_samples(of);
        let edges = difference(of.high, of.low);
        let distance =
            |a: [f64; 3], b: [f64; 3]| norm(core::array::from_fn(|k| (a[k] - b[k]) / edges[k]));
        let known: Vec<(usize, [f64; 3])> =
            thinned(&of.samples).map(|i| (i, self.samples.get(i).at)).collect();
        let mut nearest = vec![f64::INFINITY; candidates.len()];
        let (mut plan, mut taken) = (Plan::default(), vec![false; known.len()]);
        let mut checks = 0;
        while plan.known.len() + plan.new.len() < wanted || checks < TUNING.surfaces.piece_checks {
            let furthest = (0..candidates.len()).fold(None, |best: Option<usize>, i| match best {
                Some(best) if nearest[best] >= nearest[i] => Some(best),
                _ => Some(i),
            });
            let Some(furthest) = furthest.filter(|&i| nearest[i] > 0.0) else { break };
            let at = candidates[furthest];
            let is_check = plan.known.len() + plan.new.len() >= wanted;
            let reach = 0.5 * nearest[furthest].min(0.5);
            let close = known.iter().enumerate().filter(|(k, _)| !taken[*k] && !is_check);
            let close = close.map(|(k, (_, place))| (distance(*place, at), k));
            let close = close.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let place = match close.filter(|(distance, _)| *distance < reach) {
                Some((_, k)) => {
                    taken[k] = true;
                    plan.known.push(known[k].0);
                    known[k].1
                }
                None if is_check => {
                    checks += 1;
                    plan.checks.push(at);
                    at
                }
                None => {
                    plan.new.push(at);
                    at
                }
            };
            nearest[furthest] = 0.0;
            for (nearest, candidate) in nearest.iter_mut().zip(candidates) {
                *nearest = nearest.min(distance(*candidate, place));
            }
        }
        // Samples that cost nothing more.
        let left = known.iter().zip(&taken).filter(|(_, taken)| !**taken).map(|((i, _), _)| *i);
        let stride = known.len() / 24 + 1;
        plan.known.extend(left.step_by(stride).take(24));
        plan
    }

    /// The number of samples for a box: few where all known ones are equal.
    fn wanted_samples(&self, of: &OpenBox) -> usize {
        let rates = thinned(&of.samples).map(|i| self.samples.get(i).rate);
        let [low, high] = rates.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], of| {
            [low.min(of), high.max(of)]
        });
        let is_constant = high - low <= self.samples.negligible;
        let terms = if is_constant { TERMS[1] } else { TERMS[DEGREE] };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
        let wanted = (TUNING.surfaces.piece_samples * terms as f64).ceil() as usize;
        wanted + 1
    }

    /// The polynomial in a box through samples.
    pub(super) fn polynomial(
        &self,
        [low, high]: [[f64; 3]; 2],
        samples: &[usize],
        places: &[[f64; 3]],
    ) -> Polynomial {
        let samples = samples.iter().map(|&i| self.samples.get(i));
        let samples: Vec<([f64; 3], f64)> = samples.map(|of| (of.at, of.rate)).collect();
        Polynomial::fit(low, high, &samples, places)
    }
}

#[cfg(test)]
mod tests;
