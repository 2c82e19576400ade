//! G within each region: a tree of boxes, each with a polynomial of total degree 4 or less.

use crate::parallel::prelude::*;
use crate::projection::vector::{difference, norm};
use crate::vol::lattice;
use crate::vol::surfaces::octree::{Cell, Label, Octree};
use crate::vol::surfaces::polynomial::{DEGREE, Polynomial, TERMS};
use crate::vol::surfaces::search::{Failure, Search};
use crate::vol::tuning::TUNING;

/// The candidates for samples of a box.
const CANDIDATES: usize = 512;
/// The fewest candidates in a region for a polynomial of samples in its box alone.
const FEW: usize = 8;
/// The places of a box at which the error of its polynomial counts, and the points tried for them.
const PLACES: usize = 24;
const TRIES: usize = 512;
/// A box with a polynomial, or two halves.
#[derive(Clone, Debug)]
enum Node {
    Polynomial(Box<Polynomial>),
    Halves { axis: usize, at: f64, below: usize, above: usize },
}

impl From<Polynomial> for Node {
    fn from(polynomial: Polynomial) -> Self {
        Self::Polynomial(Box::new(polynomial))
    }
}

/// The tree of one region.
#[derive(Clone, Debug)]
pub(super) struct Pieces {
    nodes: Vec<Node>,
}

impl Pieces {
    /// One value everywhere.
    #[cfg(test)]
    pub(super) fn constant(value: f64) -> Self {
        let samples = [([0.25; 3], value), ([0.75; 3], value)];
        let polynomial = Polynomial::fit([0.0; 3], [1.0; 3], &samples, &[]);
        Self { nodes: vec![polynomial.into()] }
    }

    /// The polynomial at a point.
    fn at(&self, at: [f64; 3]) -> Option<&Polynomial> {
        let mut node = self.nodes.first()?;
        loop {
            match node {
                Node::Polynomial(polynomial) => return Some(polynomial),
                Node::Halves { axis, at: middle, below, above } => {
                    let next = if at[*axis] < *middle { below } else { above };
                    node = self.nodes.get(*next)?;
                }
            }
        }
    }

    /// The value at a point.
    pub(super) fn value(&self, at: [f64; 3]) -> f64 {
        self.at(at).map_or(0.0, |polynomial| polynomial.value(at))
    }

    /// The integrals along z of the value and of its error, from one depth to another.
    pub(super) fn integral(&self, [x, y]: [f64; 2], ends: [f64; 2]) -> [f64; 2] {
        self.integral_below(0, [x, y], ends)
    }

    fn integral_below(&self, node: usize, [x, y]: [f64; 2], [from, to]: [f64; 2]) -> [f64; 2] {
        match self.nodes.get(node) {
            None => [0.0; 2],
            Some(Node::Polynomial(of)) => [of.integral([x, y], [from, to]), (to - from) * of.error],
            Some(&Node::Halves { axis, at, below, above }) => {
                if axis < 2 {
                    let next = if [x, y][axis] < at { below } else { above };
                    return self.integral_below(next, [x, y], [from, to]);
                }
                let mut sum = [0.0; 2];
                for (next, ends) in [(below, [from, to.min(at)]), (above, [from.max(at), to])] {
                    if ends[0] < ends[1] {
                        let [value, error] = self.integral_below(next, [x, y], ends);
                        sum = [sum[0] + value, sum[1] + error];
                    }
                }
                sum
            }
        }
    }
}

/// A box that has no polynomial yet.
struct OpenBox {
    node: usize,
    low: [f64; 3],
    high: [f64; 3],
    level: u8,
    /// Samples of the region in it, and leaves that may contain some of the region.
    samples: Vec<usize>,
    leaves: Vec<usize>,
}

impl OpenBox {
    /// What is there before there are samples.
    fn zero(&self) -> Polynomial {
        Polynomial::zero(self.low, self.high)
    }

    /// Leaves out the leaves that are not in the box, and then the part of the box without leaves.
    fn tightened(mut self, tree: &Octree) -> Self {
        let overlap = |leaf: usize, axis: usize| {
            let [from, to] = tree.ends(leaf, axis);
            [from.max(self.low[axis]), to.min(self.high[axis])]
        };
        self.leaves.retain(|&leaf| {
            (0..3).all(|axis| {
                let [from, to] = overlap(leaf, axis);
                from < to
            })
        });
        let bounds = |axis: usize| {
            let ends = self.leaves.iter().map(|&leaf| overlap(leaf, axis));
            let join = |[a, b]: [f64; 2], [from, to]: [f64; 2]| [a.min(from), b.max(to)];
            ends.fold([f64::INFINITY, f64::NEG_INFINITY], join)
        };
        if !self.leaves.is_empty() {
            let bounds = [0, 1, 2].map(bounds);
            (self.low, self.high) = (bounds.map(|of| of[0]), bounds.map(|of| of[1]));
        }
        self
    }

    /// The two halves along an axis, whose nodes follow.
    fn halves(&self, axis: usize, node: usize, is_below: impl Fn(usize) -> bool) -> [Self; 2] {
        let at = 0.5 * (self.low[axis] + self.high[axis]);
        [0, 1].map(|half| {
            let (mut low, mut high) = (self.low, self.high);
            if half == 0 {
                high[axis] = at;
            } else {
                low[axis] = at;
            }
            let is_in = |i: &&usize| is_below(**i) == (half == 0);
            let samples = self.samples.iter().filter(is_in).copied().collect();
            let (node, leaves) = (node + half, self.leaves.clone());
            Self { node, low, high, level: self.level + 1, samples, leaves }
        })
    }
}

impl Search<'_> {
    /// The polynomials of a region; or the cells in which values of other regions were found, as far as they
    /// can be divided.
    pub(super) async fn pieces(
        &mut self,
        tree: &Octree,
        label: Label,
    ) -> Result<Result<Pieces, Vec<Cell>>, Failure> {
        let known = (0..self.samples.len()).filter(|&i| self.samples.label(i) == label);
        let leaves = (0..tree.leaves.len()).filter(|&leaf| tree.leaves[leaf].1.has(label));
        let first = OpenBox {
            node: 0,
            low: [0.0; 3],
            high: self.grid.edges,
            level: 0,
            samples: known.collect(),
            leaves: leaves.collect(),
        };
        let mut nodes: Vec<Node> = vec![first.zero().into()];
        let mut open = vec![first];
        while !open.is_empty() {
            // One batch for all boxes of a level.
            let (mut wanted, mut numbers) = (Vec::new(), Vec::new());
            let outlines: Vec<(OpenBox, Outline)> =
                open.into_par_iter().map(|of| self.outline(tree, label, of)).collect();
            let mut allowed: Vec<f64> = Vec::new();
            for (of, outline) in &outlines {
                wanted.extend(outline.points());
                allowed.resize(wanted.len(), self.allowed(of));
            }
            let rates = self.rates(&wanted).await?;
            let all = wanted.par_iter().zip(&rates).zip(&allowed);
            let is_foreign: Vec<bool> = all
                .map(|((at, rate), allowed)| {
                    let least = TUNING.surfaces.piece_foreign * allowed;
                    self.samples.is_foreign(*at, *rate, label, least)
                })
                .collect();
            let mut wrong = Vec::new();
            for ((at, rate), is_foreign) in wanted.iter().zip(rates).zip(is_foreign) {
                let cell = tree.leaves[tree.find(*at)].0;
                numbers.push(if is_foreign && cell.0 < self.grid.finest {
                    wrong.push(cell);
                    self.add(*at, rate)?
                } else {
                    // It is in the region by its place.
                    self.samples.add(*at, rate, label)
                });
            }
            if !wrong.is_empty() {
                wrong.sort_unstable();
                wrong.dedup();
                return Ok(Err(wrong));
            }
            let mut numbers = numbers.into_iter();
            let mut next = Vec::new();
            for (mut of, outline) in outlines {
                let mut take = |count: usize| numbers.by_ref().take(count).collect::<Vec<usize>>();
                let (mut polynomial, checks) = match outline {
                    Outline::Empty(zero) => {
                        nodes[of.node] = zero.into();
                        continue;
                    }
                    Outline::Continued(polynomial, checks) => (polynomial, take(checks.len())),
                    Outline::Samples(plan) => {
                        let (new, checks) = (take(plan.new.len()), take(plan.checks.len()));
                        let used: Vec<usize> = plan.known.iter().chain(&new).copied().collect();
                        of.samples.extend(new);
                        (self.polynomial([of.low, of.high], &used, &plan.places), checks)
                    }
                };
                let allowed = self.allowed(&of);
                let differs = |&i: &usize| {
                    let sample = self.samples.get(i);
                    (sample.rate - polynomial.value(sample.at)).abs()
                };
                let worst = checks.iter().map(differs).fold(0.0, f64::max);
                let is_good = polynomial.error <= allowed && worst <= 2.0 * allowed;
                if is_good || of.level >= TUNING.surfaces.piece_levels {
                    polynomial.error = polynomial.error.max(0.5 * worst);
                    nodes[of.node] = polynomial.into();
                    continue;
                }
                of.samples.extend(checks);
                let axis = polynomial.roughest_axis();
                let at = 0.5 * (of.low[axis] + of.high[axis]);
                let [below, above] = [0, 1].map(|half| nodes.len() + half);
                let halves = of.halves(axis, below, |i| self.samples.get(i).at[axis] < at);
                nodes.extend(halves.each_ref().map(|half| Node::from(half.zero())));
                nodes[of.node] = Node::Halves { axis, at, below, above };
                next.extend(halves);
            }
            open = next;
        }
        Ok(Ok(Pieces { nodes }))
    }

    /// What is to be done with a box, which is tightened around the region.
    fn outline(&self, tree: &Octree, label: Label, of: OpenBox) -> (OpenBox, Outline) {
        let of = of.tightened(tree);
        if of.leaves.is_empty() {
            let zero = of.zero();
            return (of, Outline::Empty(zero));
        }
        let places = self.places(tree, label, &of);
        let candidates = candidates(&of, &|at| self.is_well_inside(tree, label, at));
        if candidates.len() >= FEW {
            let mut plan = self.plan(&of, &candidates);
            plan.places = places;
            return (of, Outline::Samples(plan));
        }
        let continued = self.continued(&of, label, &places);
        // Those that are furthest inside, as far as they are in the region for certain.
        let clearance = |at: &[f64; 3]| tree.leaf(*at).clearance(*at);
        let mut inside: Vec<(f64, [f64; 3])> = places
            .into_iter()
            .filter(|at| tree.leaf(*at).region(*at) == label && !self.hides(*at))
            .map(|at| (clearance(&at), at))
            .filter(|(clearance, _)| *clearance > 1.0)
            .collect();
        inside.sort_by(|a, b| b.0.total_cmp(&a.0));
        inside.truncate(TUNING.surfaces.piece_checks);
        let checks = inside.into_iter().map(|(_, at)| at).collect();
        (of, Outline::Continued(continued, checks))
    }

    /// Whether a point is in view, in a region and not near its surfaces.
    fn is_well_inside(&self, tree: &Octree, label: Label, at: [f64; 3]) -> bool {
        let leaf = tree.leaf(at);
        leaf.region(at) == label
            && leaf.clearance(at) > TUNING.surfaces.piece_clearance
            && !self.hides(at)
    }

    /// The polynomial of a box of which little is in the region, from the samples around it, too: those
    /// of a small part of the box would be extrapolated to all of it.
    fn continued(&self, of: &OpenBox, label: Label, places: &[[f64; 3]]) -> Polynomial {
        let edges = difference(of.high, of.low);
        let mut reach = 1.0;
        loop {
            let low = core::array::from_fn(|k| of.low[k] - reach * edges[k]);
            let high = core::array::from_fn(|k| of.high[k] + reach * edges[k]);
            let is_near = |&i: &usize| {
                let at = self.samples.get(i).at;
                let is_in = (0..3).all(|k| low[k] <= at[k] && at[k] <= high[k]);
                is_in && self.samples.label(i) == label
            };
            let samples: Vec<usize> = (0..self.samples.len()).filter(is_near).collect();
            let is_whole = (0..3).all(|k| low[k] <= 0.0 && high[k] >= self.grid.edges[k]);
            if samples.len() >= FEW || is_whole {
                let samples: Vec<usize> = thinned(&samples).collect();
                return self.polynomial([low, high], &samples, places);
            }
            reach = 2.0 * reach + 1.0;
        }
    }

    /// Places of a box that are in the region, up to its surfaces; those of its leaves if it is thin.
    fn places(&self, tree: &Octree, label: Label, of: &OpenBox) -> Vec<[f64; 3]> {
        let edges = difference(of.high, of.low);
        let scattered = (0..TRIES).map(lattice::point).map(|u| along_each(of.low, u, edges));
        let is_inside = |at: &[f64; 3]| tree.leaf(*at).region(*at) == label;
        let found: Vec<[f64; 3]> = scattered.filter(is_inside).take(PLACES).collect();
        if !found.is_empty() {
            return found;
        }
        let stride = of.leaves.len() / PLACES + 1;
        of.leaves.iter().step_by(stride).map(|&leaf| self.grid.centre(tree.leaves[leaf].0)).collect()
    }

    /// The error allowed in a box. That of a box which is a small part of the lines of a pixel may be larger.
    fn allowed(&self, of: &OpenBox) -> f64 {
        let middle = core::array::from_fn(|k| 0.5 * (of.low[k] + of.high[k]));
        let [x, y, _] = self.grid.canonical(middle);
        let edges = difference(of.high, of.low);
        let [height, width] = [self.aim.scale.height(), self.aim.scale.width()];
        let share = (edges[0] / self.grid.edges[0] * width as f64).min(1.0)
            * (edges[1] / self.grid.edges[1] * height as f64).min(1.0)
            * (edges[2] / self.grid.edges[2]);
        let larger = (1.0 / (TUNING.surfaces.piece_boxes * share)).max(1.0);
        let of_line = self.aim.of_line([x, y]).min(self.largest_allowed());
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
    fn polynomial(
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

/// What is to be done with a box.
enum Outline {
    /// Nothing of it is in the region.
    Empty(Polynomial),
    /// Little of it is in the region: its polynomial follows from samples around it, and is checked at points.
    Continued(Polynomial, Vec<[f64; 3]>),
    /// Its polynomial is fitted to samples in the box.
    Samples(Plan),
}

impl Outline {
    /// The points at which G is evaluated.
    fn points(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        let [new, checks]: [&[[f64; 3]]; 2] = match self {
            Self::Empty(_) => [&[], &[]],
            Self::Continued(_, checks) => [&[], checks],
            Self::Samples(plan) => [&plan.new, &plan.checks],
        };
        new.iter().chain(checks).copied()
    }
}

/// What the polynomial of a box is fitted to.
#[derive(Debug, Default)]
struct Plan {
    known: Vec<usize>,
    new: Vec<[f64; 3]>,
    /// Points that take no part in the fit.
    checks: Vec<[f64; 3]>,
    /// Places at which the polynomial is used.
    places: Vec<[f64; 3]>,
}

/// At most so many of the samples of a box, evenly.
fn thinned(samples: &[usize]) -> impl Iterator<Item = usize> + '_ {
    samples.iter().step_by(samples.len() / CANDIDATES + 1).copied()
}

/// The point at shares `u` of the edges of a box from its corner.
fn along_each(low: [f64; 3], u: [f64; 3], edges: [f64; 3]) -> [f64; 3] {
    core::array::from_fn(|k| low[k] + u[k] * edges[k])
}

/// Scattered points of a box that are in the region.
fn candidates(of: &OpenBox, is_in_region: &dyn Fn([f64; 3]) -> bool) -> Vec<[f64; 3]> {
    let edges = difference(of.high, of.low);
    let mut found = Vec::new();
    for k in 0..16 * CANDIDATES {
        let u = lattice::point(k);
        let at = along_each(of.low, u, edges);
        if is_in_region(at) {
            found.push(at);
        }
        if found.len() == CANDIDATES / 2 || (k >= 4 * CANDIDATES && found.is_empty()) {
            break;
        }
    }
    found
}

#[cfg(test)]
mod tests;
