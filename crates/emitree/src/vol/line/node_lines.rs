//! The lines of sight of the nodes of an image tree: sampled in batches, refined together.

use crate::parallel::prelude::*;
use crate::vol::dyadic::spacing;
use crate::vol::image::block::Block;
use crate::vol::image::tree::ImageTree;
use crate::vol::line::Line;
use crate::vol::line::jumps::{Jump, jumps};
use crate::vol::line::profile::{Profile, has_jump};
use crate::vol::line::tracking::Bracket;
use crate::vol::sampling::{Stop, View};
use std::sync::OnceLock;

/// The smallest number of lines for a thread, which takes some ten microseconds to start, if most
/// results are cached.
pub(crate) const LINES_CACHED: usize = 1024;
/// The smallest number of lines for a thread that finds or adds samples.
const LINES_READ: usize = 128;
/// The smallest number of lines for a thread that assesses all samples.
pub(crate) const LINES_ASSESSED: usize = 8;

/// Depths to be sampled, with the number of the node of their line.
pub(crate) type Wanted = Vec<(usize, Vec<u32>)>;

/// The source of the integral of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LineSource {
    /// There is no integral yet.
    Unknown,
    /// The line was refined individually.
    Full,
    /// The depth rule of a block, by its number in [`NodeLines::rules`], with the largest |error| on the
    /// lines that it was fitted to.
    Rule { block: Block, error: f64, rule: usize },
}

/// The lines of all nodes, in the order of the nodes.
#[derive(Debug, Default)]
pub(crate) struct NodeLines {
    pub(crate) lines: Vec<Line>,
    pub(crate) sources: Vec<LineSource>,
    /// Depths and weights of each rule that has integrated a line.
    pub(crate) rules: Vec<Vec<(u32, f64)>>,
    /// Whether jumps are predicted from those of neighbouring lines.
    pub(crate) tracks_jumps: bool,
    /// The intervals in which jumps are expected on lines that have not been refined yet.
    pub(crate) brackets: Vec<Vec<Bracket>>,
    /// The weight of the error of each line: its tolerance is divided by it.
    pub(crate) error_weights: Vec<f64>,
    /// The depths of full lines with their weights in a fixed mesh; none without one.
    pub(crate) fixed: Vec<Vec<(u32, f64)>>,
    /// Cached results for each line.
    derived: Vec<Derived>,
}

/// Results that follow from the samples of a line, computed on first use and kept until there are
/// new samples.
#[derive(Debug, Default)]
struct Derived {
    profile: OnceLock<Profile>,
    jumps: OnceLock<Vec<Jump>>,
    /// Whether no depth rule can be fitted to the line.
    has_jump: OnceLock<bool>,
    /// ∫ |G| dz.
    brightness: OnceLock<f64>,
}

/// The lines with integrals from depth rules, with rule and integral.
#[derive(Debug)]
pub(crate) struct RuleSnapshot(Vec<(usize, LineSource, f64)>);

impl NodeLines {
    /// Adds lines without samples until there is one for each of `nodes` nodes.
    pub(crate) fn grow(&mut self, nodes: usize) {
        self.lines.resize_with(nodes, Line::default);
        self.sources.resize(nodes, LineSource::Unknown);
        self.brackets.resize(nodes, Vec::new());
        self.derived.resize_with(nodes, Derived::default);
        self.error_weights.resize(nodes, 1.0);
    }

    /// The tolerance of line `i`, from that of a line with the weight 1.
    pub(crate) fn tolerance_of(&self, i: usize, tolerance: f64) -> f64 {
        tolerance / self.error_weights[i]
    }

    pub(crate) fn truncate(&mut self, nodes: usize) {
        self.lines.truncate(nodes);
        self.sources.truncate(nodes);
        self.brackets.truncate(nodes);
        self.derived.truncate(nodes);
        self.error_weights.truncate(nodes);
    }

    /// The present rules and integrals of all lines that are not full, for
    /// [`restore`](Self::restore).
    pub(crate) fn snapshot(&self) -> RuleSnapshot {
        let ruled = (0..self.lines.len()).filter(|&i| !self.is_full(i));
        RuleSnapshot(ruled.map(|i| (i, self.sources[i], self.lines[i].integral)).collect())
    }

    /// Restores the rules and integrals of a snapshot.
    pub(crate) fn restore(&mut self, snapshot: &RuleSnapshot) {
        for &(i, source, integral) in &snapshot.0 {
            self.sources[i] = source;
            self.lines[i].integral = integral;
        }
    }

    pub(crate) fn is_full(&self, i: usize) -> bool {
        self.sources[i] == LineSource::Full
    }

    /// The profile of full line `i`, to which depth rules are fitted.
    pub(crate) fn profile(&self, i: usize) -> &Profile {
        self.derived[i].profile.get_or_init(|| Profile::new(&self.lines[i]))
    }

    /// Whether line `i` has a resolved jump: no depth rule is fitted to it.
    pub(crate) fn has_jump(&self, i: usize) -> bool {
        *self.derived[i].has_jump.get_or_init(|| has_jump(&self.lines[i]))
    }

    pub(crate) fn jumps(&self, i: usize) -> &[Jump] {
        self.derived[i].jumps.get_or_init(|| jumps(&self.lines[i]))
    }

    /// The largest ∫ |G| dz of a full line, times the weight of its error if that is below 1: lines that do
    /// not matter are not compared with.
    pub(crate) fn brightest(&self) -> f64 {
        let all = (0..self.lines.len()).into_par_iter().with_min_len(LINES_CACHED);
        let full = all.filter(|&i| self.is_full(i));
        let brightness = |i: usize| {
            let of_line = self.derived[i].brightness.get_or_init(|| self.lines[i].brightness());
            of_line * self.error_weights[i].min(1.0)
        };
        full.map(brightness).reduce(|| 0.0, f64::max)
    }

    /// Whether no sample is negative.
    pub(crate) fn are_nowhere_negative(&self) -> bool {
        let lines = self.lines.par_iter().with_min_len(LINES_CACHED);
        lines.all(|line| line.samples.iter().all(|sample| sample.rate >= 0.0))
    }

    /// The depths of line `i` with their weights in its integral.
    pub(crate) fn weights(&self, i: usize) -> Vec<(u32, f64)> {
        let line = &self.lines[i];
        match self.sources[i] {
            LineSource::Full if !self.fixed.is_empty() => self.fixed[i].clone(),
            LineSource::Full => {
                let depths = line.samples.iter().map(|sample| sample.depth);
                depths.zip(line.weights()).collect()
            }
            LineSource::Rule { rule, .. } => self.rules[rule].clone(),
            LineSource::Unknown => Vec::new(),
        }
    }

    /// The estimated |error| of the integral of line `i`.
    pub(crate) fn error(&self, i: usize) -> f64 {
        match self.sources[i] {
            LineSource::Full => self.lines[i].error,
            LineSource::Rule { error, .. } => error,
            LineSource::Unknown => f64::INFINITY,
        }
    }

    /// Samples all wanted depths in one batch. Depths that have been sampled cost nothing, and a
    /// depth may be wanted twice.
    pub(crate) async fn sample(
        &mut self,
        view: &View<'_>,
        tree: &ImageTree,
        wanted: &Wanted,
    ) -> Result<(), Stop> {
        let missing = |(i, depths): &(usize, Vec<u32>)| {
            let line = &self.lines[*i];
            let missing = depths.iter().filter(|&&depth| !line.has(depth));
            missing.map(|&depth| (*i, depth)).collect::<Vec<_>>()
        };
        let wanted = wanted.par_iter().with_min_len(LINES_READ);
        let mut missing: Vec<(usize, u32)> = wanted.flat_map_iter(missing).collect();
        missing.par_sort_unstable();
        missing.dedup();
        let points: Vec<_> = missing.iter().map(|&(i, d)| (tree.nodes()[i].place, d)).collect();
        let rates = view.rates(&points).await?;
        let samples: Vec<_> =
            missing.into_iter().zip(rates).map(|((i, depth), rate)| (i, (depth, rate))).collect();
        let of_lines: Vec<_> = samples.chunk_by(|a, b| a.0 == b.0).collect();
        let numbers = of_lines.iter().map(|of_line| of_line[0].0);
        let lines = chosen(&mut self.lines, numbers.clone());
        let derived = chosen(&mut self.derived, numbers);
        let lines = lines.into_par_iter().zip(derived).zip(of_lines).with_min_len(LINES_READ);
        lines.for_each(|((line, derived), new)| {
            line.add(new.iter().map(|(_, sample)| *sample));
            *derived = Derived::default();
        });
        Ok(())
    }

    /// Samples the wanted depths and refines each of these lines until its error is within
    /// `tolerance`, with one batch for each step of all lines.
    pub(crate) async fn refine(
        &mut self,
        view: &View<'_>,
        tree: &ImageTree,
        mut wanted: Wanted,
        tolerance: f64,
        base_level: u8,
    ) -> Result<(), Stop> {
        while !wanted.is_empty() {
            self.sample(view, tree, &wanted).await?;
            wanted = self.assess(wanted.iter().map(|(i, _)| *i), tolerance, base_level);
        }
        Ok(())
    }

    /// Assesses lines and returns the depths to be sampled, by line in ascending order. Expected
    /// jumps are searched for first, until all are bracketed or given up.
    pub(crate) fn assess(
        &mut self,
        numbers: impl Iterator<Item = usize>,
        tolerance: f64,
        base_level: u8,
    ) -> Wanted {
        let mut numbers: Vec<usize> = numbers.collect();
        numbers.sort_unstable();
        numbers.dedup();
        let lines = chosen(&mut self.lines, numbers.iter().copied());
        let brackets = chosen(&mut self.brackets, numbers.iter().copied());
        let derived = chosen(&mut self.derived, numbers.iter().copied());
        let weights = &self.error_weights;
        let lines = lines.into_par_iter().zip(brackets).zip(derived).zip(&numbers);
        let lines = lines.with_min_len(LINES_ASSESSED);
        let wanted = lines.map(|(((line, brackets), derived), &i)| {
            *derived = Derived::default();
            let searched: Vec<u32> = brackets.iter_mut().filter_map(|b| b.next(line)).collect();
            if searched.is_empty() {
                brackets.clear();
                (i, line.assess(tolerance / weights[i], base_level))
            } else {
                (i, searched)
            }
        });
        wanted.filter(|(_, depths)| !depths.is_empty()).collect()
    }
}

/// The entries with these numbers, which must be ascending.
fn chosen<T>(all: &mut [T], numbers: impl Iterator<Item = usize>) -> Vec<&mut T> {
    let (mut rest, mut passed) = (all.iter_mut(), 0);
    let entry = |i: usize| {
        let entry = rest.nth(i - passed);
        passed = i + 1;
        entry
    };
    numbers.filter_map(entry).collect()
}

/// All depths of the lattice of `level`.
pub(crate) fn base_depths(level: u8) -> Vec<u32> {
    (0..=1_u32 << level).map(|k| k * spacing(level)).collect()
}
