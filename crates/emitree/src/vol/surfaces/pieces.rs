//! G within each region: a tree of boxes, each with a polynomial of total degree 4 or less.

use crate::parallel::prelude::*;
use crate::vol::surfaces::boxes::OpenBox;
use crate::vol::surfaces::missed::Schedule;
use crate::vol::surfaces::octree::{Cell, Label, Octree};
use crate::vol::surfaces::outline::Outline;
use crate::vol::surfaces::polynomial::Polynomial;
use crate::vol::surfaces::search::{Failure, Search};
use crate::vol::tuning::TUNING;

/// The most boxes of a region: a search without this limit made 78,000 and took minutes.
const MOST_NODES: usize = 1 << 15;

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

impl Search<'_> {
    /// The polynomials of a region; or the cells in which values of other regions were found, as far as they
    /// can be divided.
    pub(super) async fn pieces(
        &mut self,
        tree: &Octree,
        label: Label,
    ) -> Result<Result<Pieces, Vec<Cell>>, Failure> {
        let known = (0..self.samples.len()).filter(|&i| self.samples.is_of(i, label));
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
        let mut schedule = Schedule::new(self.tolerance);
        while !open.is_empty() {
            if nodes.len() > MOST_NODES {
                return Err(Failure::TooComplex);
            }
            let boxes = open.len();
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
                    // It is in the region by its place. A leaf of the finest level can't be divided: there a
                    // foreign value makes the error of the polynomial larger.
                    self.samples.add(*at, rate, label)
                });
            }
            if !wrong.is_empty() {
                wrong.sort_unstable();
                wrong.dedup();
                return Ok(Err(wrong));
            }
            let mut numbers = numbers.into_iter();
            let mut next: Vec<OpenBox> = Vec::new();
            let mut errors: Vec<f64> = Vec::new();
            for (mut of, outline) in outlines {
                let mut take = |count: usize| numbers.by_ref().take(count).collect::<Vec<usize>>();
                let mut allowed = self.allowed(&of);
                let (mut polynomial, checks) = match outline {
                    Outline::Empty => continue,
                    Outline::Continued(of_box) => {
                        allowed = allowed.max(of_box.least_allowed);
                        (of_box.polynomial, take(of_box.checks.len()))
                    }
                    Outline::Samples(plan) => {
                        let (new, checks) = (take(plan.new.len()), take(plan.checks.len()));
                        let used: Vec<usize> = plan.known.iter().chain(&new).copied().collect();
                        of.samples.extend(new);
                        (self.polynomial([of.low, of.high], &used, &plan.places), checks)
                    }
                };
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
                errors.extend([polynomial.error.max(worst); 2]);
            }
            // More and more boxes from level to level: G may not be smooth in them.
            let may_jump = self.can_be_finer && next.len() > boxes && schedule.is_due(nodes.len());
            if may_jump && self.jumps_within(tree, &next, &errors).await? {
                return Err(Failure::JumpInRegion);
            }
            open = next;
        }
        Ok(Ok(Pieces { nodes }))
    }
}

#[cfg(test)]
mod tests;
