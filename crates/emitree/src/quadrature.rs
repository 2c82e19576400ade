//! Cell rules: how the average of g over a cell is made from evaluations.

use crate::cell::{self, CellIndex, power, to_u32};
use rustc_hash::{FxHashMap, FxHashSet};

/// How the average of a cell is made from evaluations of g.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CellRule {
    /// g at the cell's centre: one evaluation a cell, none used twice. The paper's choice.
    #[default]
    Midpoint,
    /// The D-dimensional Simpson rule on the 3^D corners, edge and face centres and the centre of
    /// the cell (Stroud 1971; the paper's Fig. 8): neighbours and finer levels use them again.
    Simpson,
}

/// Sample points of one batch, computed when they are used: point `i` of `len`.
#[derive(Clone, Copy)]
pub struct Points<'a, const D: usize> {
    len: usize,
    at: &'a (dyn Fn(usize) -> [f64; D] + Sync),
}

impl<'a, const D: usize> Points<'a, D> {
    /// A batch of `len` points in canonical coordinates, point `i` at `at(i)`.
    pub fn new(len: usize, at: &'a (dyn Fn(usize) -> [f64; D] + Sync)) -> Self {
        Self { len, at }
    }

    /// The number of points.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether the batch has no points.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Point `i`, in canonical coordinates.
    pub fn at(&self, i: usize) -> [f64; D] {
        (self.at)(i)
    }
}

impl<const D: usize> core::fmt::Debug for Points<'_, D> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Points").field("len", &self.len).finish_non_exhaustive()
    }
}

/// A function on the unit cube that is evaluated in batches: what a tree is built from.
///
/// ```
/// use emitree::quadrature::{Integrand, Pointwise, Points};
///
/// let square = Pointwise(|[x, y]: [f64; 2]| x * y);
/// let mut values = [0.0; 2];
/// square.evaluate(Points::new(2, &|i| [0.5, i as f64]), &mut values)?;
/// assert_eq!(values, [0.0, 0.5]);
/// # Ok::<(), std::convert::Infallible>(())
/// ```
pub trait Integrand<const D: usize> {
    /// The error of an evaluation.
    type Error;

    /// Writes the value at each point of the batch to `values`, which has the same length.
    ///
    /// # Errors
    ///
    /// The error of the function.
    fn evaluate(&self, points: Points<'_, D>, values: &mut [f64]) -> Result<(), Self::Error>;

    /// How many evaluations may still be made; no limit unless overridden.
    fn evaluations_left(&self) -> u64 {
        u64::MAX
    }

    /// Whether an evaluation failed because the time that was allowed has ended: then a tree is
    /// what it was before; `false` unless overridden.
    fn is_out_of_time(_error: &Self::Error) -> bool {
        false
    }
}

/// An [`Integrand`] whose values may have to be waited for.
pub(crate) trait AsyncIntegrand<const D: usize> {
    type Error;

    fn evaluate(
        &self,
        points: Points<'_, D>,
        values: &mut [f64],
    ) -> impl Future<Output = Result<(), Self::Error>>;

    fn evaluations_left(&self) -> u64;

    fn is_out_of_time(error: &Self::Error) -> bool;
}

/// An [`Integrand`] whose values are available at once.
pub(crate) struct Immediate<'a, I>(pub(crate) &'a I);

impl<const D: usize, I: Integrand<D>> AsyncIntegrand<D> for Immediate<'_, I> {
    type Error = I::Error;

    async fn evaluate(&self, points: Points<'_, D>, values: &mut [f64]) -> Result<(), I::Error> {
        self.0.evaluate(points, values)
    }

    fn evaluations_left(&self) -> u64 {
        self.0.evaluations_left()
    }

    fn is_out_of_time(error: &I::Error) -> bool {
        I::is_out_of_time(error)
    }
}

/// An [`Integrand`] from a closure of one point.
#[derive(Clone, Copy, Debug)]
pub struct Pointwise<F>(pub F);

impl<const D: usize, F: Fn([f64; D]) -> f64> Integrand<D> for Pointwise<F> {
    type Error = core::convert::Infallible;

    fn evaluate(&self, points: Points<'_, D>, values: &mut [f64]) -> Result<(), Self::Error> {
        for (i, value) in values.iter_mut().enumerate() {
            *value = (self.0)(points.at(i));
        }
        Ok(())
    }
}

/// Computes the averages of whole families, and stores the evaluations that can be reused.
#[derive(Debug)]
pub(crate) struct Averager<const D: usize> {
    periodic: [bool; D],
    nodes: Option<NodeStore<D>>,
}

impl<const D: usize> Averager<D> {
    pub(crate) fn new(rule: CellRule, periodic: [bool; D]) -> Self {
        let nodes = (rule == CellRule::Simpson).then(NodeStore::default);
        Self { periodic, nodes }
    }

    /// How many evaluations the children of one family need at the most.
    pub(crate) fn family_cost(&self) -> u64 {
        // A family of Simpson cells has 5^D nodes, all of them new at the worst.
        if self.nodes.is_some() { power(5, D) as u64 } else { 1 << D }
    }

    /// How many evaluations [`average`](Self::average) will make for these families of `level`.
    pub(crate) fn cost(&self, level: u8, families: &[[u32; D]]) -> u64 {
        let Some(nodes) = &self.nodes else { return families.len() as u64 * self.family_cost() };
        let mut new = FxHashSet::default();
        for &family in families {
            for child in 0..1 << D {
                let cell = cell::child_position(family, child);
                let of_cell = |n| cell::key(NodeStore::<D>::node(level, cell, n, self.periodic));
                new.extend(
                    (0..power(3, D)).map(of_cell).filter(|key| !nodes.index.contains_key(key)),
                );
            }
        }
        new.len() as u64
    }

    /// Writes the averages of the children of `families` to `averages`, family after family, and
    /// evaluates in one batch what is needed for it.
    pub(crate) async fn average<E>(
        &mut self,
        level: u8,
        families: &[[u32; D]],
        averages: &mut [f64],
        integrand: &impl AsyncIntegrand<D, Error = E>,
    ) -> Result<(), E> {
        let siblings = 1_usize << D;
        let Some(nodes) = &mut self.nodes else {
            let edge = cell::edge(level);
            let centre = |i: usize| {
                let child = cell::child_position(families[i / siblings], i % siblings);
                child.map(|p| (f64::from(p) + 0.5) * edge)
            };
            return integrand.evaluate(Points::new(averages.len(), &centre), averages).await;
        };
        let node = |family: usize, child: usize, n: usize| {
            let cell = cell::child_position(families[family], child);
            NodeStore::<D>::node(level, cell, n, self.periodic)
        };
        let per_cell = power(3, D);
        let cells = || (0..families.len()).flat_map(|f| (0..siblings).map(move |c| (f, c)));
        for (family, child) in cells() {
            for n in 0..per_cell {
                nodes.want(node(family, child, n));
            }
        }
        nodes.evaluate_wanted(integrand).await?;
        for ((family, child), average) in cells().zip(averages) {
            let values =
                (0..per_cell).map(|n| simpson_weight::<D>(n) * nodes.value(node(family, child, n)));
            *average = values.sum();
        }
        Ok(())
    }
}

impl CellRule {
    /// The points of the average of a cell with their weights, on axes some of which are periodic.
    pub(crate) fn terms<const D: usize>(
        self,
        cell: CellIndex<D>,
        periodic: [bool; D],
    ) -> Vec<([f64; D], f64)> {
        if self == Self::Midpoint {
            return vec![(cell.centre(), 1.0)];
        }
        let term = |n: usize| {
            let node = NodeStore::<D>::node(cell.level(), cell.position(), n, periodic);
            (NodeStore::<D>::point(node), simpson_weight::<D>(n))
        };
        (0..power(3, D)).map(term).collect()
    }
}

/// Weight of node `n` of 3^D: a product of 1/6, 4/6, 1/6 along each axis.
fn simpson_weight<const D: usize>(n: usize) -> f64 {
    let digit = |axis: usize| n / power(3, axis) % 3;
    (0..D).map(|axis| if digit(axis) == 1 { 4.0 / 6.0 } else { 1.0 / 6.0 }).product()
}

/// Evaluations at dyadic nodes, found again from any level.
///
/// A node's coordinates count steps of the finest level that a tree can have, so that the same
/// point has the same key from every level.
#[derive(Debug, Default)]
struct NodeStore<const D: usize> {
    index: FxHashMap<u64, u32>,
    values: Vec<f64>,
    wanted: Vec<[u32; D]>,
}

impl<const D: usize> NodeStore<D> {
    /// Steps of one unit: nodes of the deepest level lie half an edge apart.
    const STEPS: u32 = 1 << (CellIndex::<D>::MAX_LEVEL + 1);

    /// Node `n` of 3^D of the cell at `position` of `level`, in steps.
    fn node(level: u8, position: [u32; D], n: usize, periodic: [bool; D]) -> [u32; D] {
        let half_edge = Self::STEPS >> (level + 1);
        core::array::from_fn(|axis| {
            let digit = to_u32(n / power(3, axis) % 3);
            let steps = (2 * position[axis] + digit) * half_edge;
            if periodic[axis] { steps % Self::STEPS } else { steps }
        })
    }

    /// The coordinates of a node.
    fn point(node: [u32; D]) -> [f64; D] {
        let step = 1.0 / f64::from(Self::STEPS);
        node.map(|steps| f64::from(steps) * step)
    }

    fn want(&mut self, node: [u32; D]) {
        let next = to_u32(self.values.len() + self.wanted.len());
        if let std::collections::hash_map::Entry::Vacant(entry) = self.index.entry(cell::key(node))
        {
            entry.insert(next);
            self.wanted.push(node);
        }
    }

    async fn evaluate_wanted<E>(
        &mut self,
        integrand: &impl AsyncIntegrand<D, Error = E>,
    ) -> Result<(), E> {
        let first = self.values.len();
        self.values.resize(first + self.wanted.len(), 0.0);
        let point = |i: usize| Self::point(self.wanted[i]);
        let points = Points::new(self.wanted.len(), &point);
        integrand.evaluate(points, &mut self.values[first..]).await?;
        self.wanted.clear();
        Ok(())
    }

    fn value(&self, node: [u32; D]) -> f64 {
        self.values[self.index[&cell::key(node)] as usize]
    }
}
