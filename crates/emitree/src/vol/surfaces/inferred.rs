//! Points at which a region follows from the patches of the parent, without an evaluation.
//!
//! A cell is divided where its patches are not accurate enough, and most corners of its children are far
//! from all of its surfaces. G is evaluated at those corners only when a bracket of a surface ends there.

use crate::parallel::prelude::*;
use crate::vol::surfaces::octree::{Label, region};
use crate::vol::surfaces::search::{Failure, Guess, Search};
use crate::vol::tuning::TUNING;
use rustc_hash::FxHashMap;
use std::hash::Hash;

/// Points that are not known yet, in the order of the cells, each with its region if all cells infer the same one.
pub(super) struct NewPoints<K> {
    points: Vec<(K, [f64; 3], Option<Label>)>,
    numbers: FxHashMap<K, usize>,
}

impl<K> Default for NewPoints<K> {
    fn default() -> Self {
        Self { points: Vec::new(), numbers: FxHashMap::default() }
    }
}

impl<K: Eq + Hash + Copy> NewPoints<K> {
    /// Adds what a cell infers at a point.
    pub(super) fn add(&mut self, key: K, at: [f64; 3], inferred: Option<Label>) {
        let next = self.points.len();
        let number = *self.numbers.entry(key).or_insert(next);
        match self.points.get_mut(number) {
            Some((.., label)) => *label = label.filter(|_| *label == inferred),
            None => self.points.push((key, at, inferred)),
        }
    }

    /// The points, in their order.
    pub(super) fn keys(&self) -> impl Iterator<Item = &K> {
        self.points.iter().map(|(key, ..)| key)
    }
}

impl Search<'_> {
    /// Samples at new points: inferred where all cells agree, otherwise measured.
    pub(super) async fn sample_or_infer<K: Eq + Hash + Copy + Sync>(
        &mut self,
        new: NewPoints<K>,
    ) -> Result<Vec<usize>, Failure> {
        let inferred = new.points.par_iter().map(|(_, at, label)| {
            label.map(|label| (*at, self.samples.rate_near(*at, label), label))
        });
        let inferred: Vec<Option<([f64; 3], f64, Label)>> = inferred.collect();
        let add = |of: Option<([f64; 3], f64, Label)>| {
            of.map(|(at, rate, label)| self.samples.add_inferred(at, rate, label))
        };
        let mut known: Vec<Option<usize>> = inferred.into_iter().map(add).collect();
        let missing = new.points.iter().filter(|(.., label)| label.is_none());
        let missing: Vec<[f64; 3]> = missing.map(|(_, at, _)| *at).collect();
        let mut measured = self.sample(&missing).await?.into_iter();
        known.iter_mut().filter(|of| of.is_none()).for_each(|of| *of = measured.next());
        Ok(known.into_iter().flatten().collect())
    }

    /// The region of a point that is far from the patches of the parent of a cell of this size.
    pub(super) fn inferred(&self, guess: &Guess, at: [f64; 3], size: f64) -> Option<Label> {
        let facets = guess.facets.as_deref()?;
        if guess.is_refuted || self.hides(at) {
            return None;
        }
        let error = facets.iter().map(|of| of.error).fold(0.0, f64::max);
        let least = TUNING.surfaces.inferred_errors * error;
        let (label, distance) = region(facets, at);
        let is_far = distance > least.max(TUNING.surfaces.inferred_share * size);
        is_far.then(|| self.samples.current(label))
    }

    /// Evaluates G at those of some points at which a region was inferred.
    pub(super) async fn measure(
        &mut self,
        points: impl Iterator<Item = usize>,
    ) -> Result<(), Failure> {
        let is_inferred = |i: &usize| !self.samples.is_measured(*i) && !self.samples.is_hidden(*i);
        let mut inferred: Vec<usize> = points.filter(is_inferred).collect();
        inferred.sort_unstable();
        inferred.dedup();
        let places: Vec<[f64; 3]> = inferred.iter().map(|&i| self.samples.get(i).at).collect();
        let rates = self.rates(&places).await?;
        for ((number, at), rate) in inferred.into_iter().zip(places).zip(rates) {
            let label = self.label_of(at, rate)?;
            self.samples.measure(number, rate, label);
        }
        Ok(())
    }
}
