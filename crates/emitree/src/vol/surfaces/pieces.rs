//! G within each region: a tree of boxes, each with a polynomial of total degree 4 or less.

use crate::projection::vector::{difference, norm};
use crate::vol::lattice;
use crate::vol::surfaces::columns::Columns;
use crate::vol::surfaces::octree::{Label, Octree};
use crate::vol::surfaces::search::{Failure, Search};
use crate::vol::tuning::TUNING;

/// The highest total degree.
const DEGREE: usize = 4;
/// The number of coefficients for each degree.
const TERMS: [usize; DEGREE + 1] = [1, 4, 10, 20, 35];
/// The candidates for samples of a box.
const CANDIDATES: usize = 512;
/// The fewest candidates in a region for a polynomial that is not constant.
const FEW: usize = 8;
/// The most |local coordinate| at which a polynomial is evaluated.
const BEYOND: f64 = 1.15;

/// A box with a polynomial, or two halves.
#[derive(Clone, Debug)]
enum Node {
    Polynomial(Polynomial),
    Halves { axis: usize, at: f64, below: usize, above: usize },
}

/// A polynomial in Legendre polynomials of coordinates from −1 to 1.
#[derive(Clone, Debug)]
pub(super) struct Polynomial {
    low: [f64; 3],
    high: [f64; 3],
    coefficients: Vec<f64>,
    /// The expected error.
    pub(super) error: f64,
}

/// The tree of one region.
#[derive(Clone, Debug)]
pub(super) struct Pieces {
    nodes: Vec<Node>,
}

/// Powers of the terms, by total degree.
fn powers() -> impl Iterator<Item = [usize; 3]> {
    (0..=DEGREE).flat_map(|degree| {
        (0..=degree)
            .rev()
            .flat_map(move |i| (0..=degree - i).rev().map(move |j| [i, j, degree - i - j]))
    })
}

fn legendre(t: f64) -> [f64; DEGREE + 1] {
    let s = t * t;
    let three = (2.5 * s - 1.5) * t;
    [1.0, t, 1.5 * s - 0.5, three, (4.375 * s - 3.75) * s + 0.375]
}

impl Polynomial {
    fn terms(&self, at: [f64; 3]) -> impl Iterator<Item = f64> + use<> {
        let local = core::array::from_fn::<_, 3, _>(|k| {
            let t = (2.0 * at[k] - self.low[k] - self.high[k]) / (self.high[k] - self.low[k]);
            legendre(t.clamp(-BEYOND, BEYOND))
        });
        powers().map(move |[i, j, k]| local[0][i] * local[1][j] * local[2][k])
    }

    fn value(&self, at: [f64; 3]) -> f64 {
        if let [constant] = self.coefficients[..] {
            return constant;
        }
        let local: [[f64; DEGREE + 1]; 3] = core::array::from_fn(|k| {
            let t = (2.0 * at[k] - self.low[k] - self.high[k]) / (self.high[k] - self.low[k]);
            legendre(t.clamp(-BEYOND, BEYOND))
        });
        // In the order of the powers.
        let (mut sum, mut number) = (0.0, 0);
        for degree in 0..=DEGREE {
            if number == self.coefficients.len() {
                break;
            }
            for i in (0..=degree).rev() {
                for j in (0..=degree - i).rev() {
                    let term = local[0][i] * local[1][j] * local[2][degree - i - j];
                    sum += self.coefficients[number] * term;
                    number += 1;
                }
            }
        }
        sum
    }

    /// The axis along which the higher terms are largest.
    fn roughest_axis(&self) -> usize {
        let mut sums = [0.0; 3];
        for (powers, coefficient) in powers().zip(&self.coefficients) {
            for k in 0..3 {
                if powers[k] >= 2 {
                    sums[k] += coefficient.abs() * powers[k] as f64;
                }
            }
        }
        if sums.iter().all(|sum| *sum <= 0.0) {
            let edges = difference(self.high, self.low);
            return (0..3).fold(0, |best, k| if edges[k] > edges[best] { k } else { best });
        }
        (0..3).fold(0, |best, k| if sums[k] > sums[best] { k } else { best })
    }
}

impl Pieces {
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
            Some(Node::Polynomial(of)) => {
                let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
                if let [constant] = of.coefficients[..] {
                    return [2.0 * half * constant, 2.0 * half * of.error];
                }
                // Three Gauss nodes integrate a polynomial of degree 5.
                let beside = half * 0.6_f64.sqrt();
                let value = |z: f64| of.value([x, y, z]);
                let sum = 5.0 * (value(middle - beside) + value(middle + beside));
                [half * (sum + 8.0 * value(middle)) / 9.0, 2.0 * half * of.error]
            }
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
    /// Samples of the region in it.
    samples: Vec<usize>,
}

impl Search<'_> {
    /// The polynomials of a region, to an error `allowed` in G.
    pub(super) async fn pieces(&mut self, tree: &Octree, label: Label) -> Result<Pieces, Failure> {
        let clearance = |at: [f64; 3]| {
            let leaf = tree.leaf(at);
            leaf.region(at) == label && leaf.clearance(at) > TUNING.surfaces.piece_clearance
        };
        let known = (0..self.samples.len()).filter(|&i| self.samples.label(i) == label);
        let first = OpenBox {
            node: 0,
            low: [0.0; 3],
            high: self.grid.edges,
            level: 0,
            samples: known.collect(),
        };
        let mut nodes = vec![Node::Polynomial(empty(&first))];
        let mut open = vec![first];
        while !open.is_empty() {
            // One batch for all boxes of a level.
            let (mut wanted, mut numbers) = (Vec::new(), Vec::new());
            let mut plans = Vec::new();
            for of in &open {
                let candidates = candidates(of, &clearance);
                let plan = self.plan(of, &candidates);
                wanted.extend(plan.new.iter().chain(&plan.checks).copied());
                plans.push((plan, candidates.len()));
            }
            let rates = self.rates(&wanted).await?;
            for (at, rate) in wanted.iter().zip(rates) {
                // They are in the region by their places, whatever their values.
                numbers.push(self.samples.add(*at, rate, label));
            }
            let mut numbers = numbers.into_iter();
            let mut next = Vec::new();
            for (of, (plan, candidates)) in open.into_iter().zip(plans) {
                let new: Vec<usize> = numbers.by_ref().take(plan.new.len()).collect();
                let checks: Vec<usize> = numbers.by_ref().take(plan.checks.len()).collect();
                let mut used = plan.known;
                used.extend(&new);
                let polynomial = self.polynomial(&of, &used);
                let allowed = self.allowed(&of);
                let differs = |&i: &usize| {
                    let sample = self.samples.get(i);
                    (sample.rate - polynomial.value(sample.at)).abs()
                };
                let worst = checks.iter().map(differs).fold(0.0, f64::max);
                let is_good = polynomial.error <= allowed && worst <= 2.0 * allowed;
                if is_good || of.level >= TUNING.surfaces.piece_levels || candidates < FEW {
                    let error = polynomial.error.max(0.5 * worst);
                    nodes[of.node] = Node::Polynomial(Polynomial { error, ..polynomial });
                    continue;
                }
                let all: Vec<usize> =
                    of.samples.iter().chain(&new).chain(&checks).copied().collect();
                let axis = polynomial.roughest_axis();
                let at = 0.5 * (of.low[axis] + of.high[axis]);
                let halves = [0, 1].map(|half| {
                    let (mut low, mut high) = (of.low, of.high);
                    if half == 0 {
                        high[axis] = at;
                    } else {
                        low[axis] = at;
                    }
                    let is_in = |&&i: &&usize| (self.samples.get(i).at[axis] < at) == (half == 0);
                    let samples = all.iter().filter(is_in).copied().collect();
                    let node = nodes.len() + half;
                    OpenBox { node, low, high, level: of.level + 1, samples }
                });
                let [below, above] = [0, 1].map(|half| nodes.len() + half);
                nodes.extend(halves.each_ref().map(|half| Node::Polynomial(empty(half))));
                nodes[of.node] = Node::Halves { axis, at, below, above };
                next.extend(halves);
            }
            open = next;
        }
        Ok(Pieces { nodes })
    }

    /// The error allowed in a box.
    fn allowed(&self, of: &OpenBox) -> f64 {
        let middle = core::array::from_fn(|k| 0.5 * (of.low[k] + of.high[k]));
        let [x, y, _] = self.grid.canonical(middle);
        TUNING.surfaces.piece_share * self.aim.of_line([x, y]).min(self.largest_allowed())
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

    /// The polynomial of the degree with the least leave-one-out error.
    fn polynomial(&self, of: &OpenBox, samples: &[usize]) -> Polynomial {
        let mut best = empty(of);
        let rates: Vec<f64> = samples.iter().map(|&i| self.samples.get(i).rate).collect();
        if rates.is_empty() {
            return best;
        }
        let mut columns = Columns::new(rates);
        let rows: Vec<Vec<f64>> =
            samples.iter().map(|&i| best.terms(self.samples.get(i).at).collect()).collect();
        let mut term = 0;
        best.error = f64::INFINITY;
        for terms in TERMS {
            if terms > 1 && (samples.len() as f64) < 1.25 * terms as f64 + 1.0 {
                break;
            }
            while term < terms {
                if !columns.add(rows.iter().map(|row| row[term]).collect()) {
                    return best;
                }
                term += 1;
            }
            let square = |i: usize| columns.left_out(i).powi(2);
            let mean = (0..samples.len()).map(square).sum::<f64>() / samples.len() as f64;
            let error = TUNING.surfaces.piece_margin * mean.sqrt();
            if error < best.error {
                best = Polynomial { coefficients: columns.coefficients(), error, ..best };
            }
        }
        best
    }
}

/// What the polynomial of a box is fitted to.
#[derive(Debug, Default)]
struct Plan {
    known: Vec<usize>,
    new: Vec<[f64; 3]>,
    /// Points that take no part in the fit.
    checks: Vec<[f64; 3]>,
}

/// At most so many of the samples of a box, evenly.
fn thinned(samples: &[usize]) -> impl Iterator<Item = usize> + '_ {
    samples.iter().step_by(samples.len() / CANDIDATES + 1).copied()
}

fn empty(of: &OpenBox) -> Polynomial {
    Polynomial { low: of.low, high: of.high, coefficients: vec![0.0], error: 0.0 }
}

/// Scattered points of a box that are in the region.
fn candidates(of: &OpenBox, is_in_region: &dyn Fn([f64; 3]) -> bool) -> Vec<[f64; 3]> {
    let edges = difference(of.high, of.low);
    let mut found = Vec::new();
    for k in 0..16 * CANDIDATES {
        let u = lattice::point(k);
        let at = core::array::from_fn(|k| of.low[k] + u[k] * edges[k]);
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
