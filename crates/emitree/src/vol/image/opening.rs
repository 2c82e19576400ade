//! Opening: the choice of the nodes that get children.
//!
//! Nodes are opened in the order of their contributions. Each contribution is subtracted from a
//! copy of the error map until no pixel is above the goal. A node beside a pixel with a large error
//! is therefore not opened if larger contributions are expected to reduce that error.

use crate::image::Image;
use crate::vol::dyadic::{Place, around, spacing, unit};
use crate::vol::image::error_map::Footprint;
use crate::vol::image::remaining::{Children, Remaining};
use crate::vol::image::tree::{ImageTree, key};
use crate::vol::tuning::TUNING;
use rustc_hash::FxHashSet;

/// The input of the choice for one tree.
pub(crate) struct Choice<'a> {
    pub(crate) tree: &'a ImageTree,
    pub(crate) remaining: &'a [Remaining],
    /// The footprint of the remaining error of each node, if there is one.
    pub(crate) footprints: &'a [Option<Footprint>],
    /// The factors of the tree's image in each energy bin.
    pub(crate) weights: &'a [f64],
    /// The factor from means of values to weighted pixels, the largest of all bins.
    pub(crate) scale: &'a Image,
    /// This factor in each bin; none if it is the same in all.
    pub(crate) scales: &'a [Image],
    pub(crate) limits: ChoiceLimits,
}

/// The limits of the choice.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChoiceLimits {
    /// The error allowed, in the unit of the image.
    pub(crate) tolerance: f64,
    /// The finest level of nodes.
    pub(crate) finest_level: u8,
    /// The finest level whose nodes every rendering samples.
    pub(crate) required_level: u8,
}

/// The nodes to be opened of each of several trees whose images are added, the largest
/// contributions first. The trees compete for the same maps of weighted errors, one for each energy bin.
pub(crate) fn worthwhile(choices: &[Choice<'_>], errors: &[&Image]) -> Vec<Vec<usize>> {
    let mut opened = vec![Vec::new(); choices.len()];
    let of_tree = |(tree, choice): (usize, &Choice<'_>)| {
        let found = choice.candidates().into_iter();
        found.map(|(contribution, i)| (contribution, tree, i)).collect::<Vec<_>>()
    };
    let mut candidates: Vec<_> = choices.iter().enumerate().flat_map(of_tree).collect();
    candidates.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    // Computed once for each tree: there may be thousands of bins.
    let least = |choice: &Choice<'_>| {
        TUNING.image.least_contribution * choice.limits.tolerance * choice.largest_weight()
    };
    let least: Vec<f64> = choices.iter().map(least).collect();
    let mut expected: Vec<Image> = errors.iter().map(|error| (*error).clone()).collect();
    for (contribution, tree, i) in candidates {
        let choice = &choices[tree];
        let Some(footprint) = &choice.footprints[i] else { continue };
        let ChoiceLimits { tolerance, .. } = choice.limits;
        let matters = |(bin, weight): &(usize, &f64)| {
            // The share of the largest contribution.
            let of_bin = match choice.scales {
                [] => contribution,
                scales => {
                    contribution * footprint.largest_scale(&scales[*bin])
                        / footprint.largest_scale(choice.scale)
                }
            };
            of_bin * weight.abs() >= least[tree]
        };
        let bins: Vec<(usize, &f64)> = choice.weights.iter().enumerate().filter(matters).collect();
        let is_bad = |(bin, _): (usize, &f64)| {
            footprint.touches_above(
                &expected[bin],
                choice.scale_in(bin),
                TUNING.image.pixel_goal * tolerance,
            )
        };
        if bins.iter().copied().any(is_bad) {
            for (bin, weight) in bins {
                let gain = -TUNING.image.expected_gain * weight.abs();
                footprint.add_to(&mut expected[bin], choice.scale_in(bin), gain);
            }
            opened[tree].push(i);
        }
    }
    opened
}

impl Choice<'_> {
    /// The factor from means of values to weighted pixels in a bin.
    fn scale_in(&self, bin: usize) -> &Image {
        self.scales.get(bin).unwrap_or(self.scale)
    }

    fn largest_weight(&self) -> f64 {
        self.weights.iter().fold(0.0, |largest: f64, weight| largest.max(weight.abs()))
    }

    /// The nodes that may be opened, each with its largest contribution to the error of a pixel in
    /// any bin.
    fn candidates(&self) -> Vec<(f64, usize)> {
        let ChoiceLimits { tolerance, finest_level, .. } = self.limits;
        let [height, width] = [self.scale.height(), self.scale.width()].map(|n| n as f64);
        let largest_weight = self.largest_weight();
        let largest_scale = self.scale.largest();
        let least = TUNING.image.least_contribution * tolerance;
        let mut candidates = Vec::new();
        for (i, node) in self.tree.nodes().iter().enumerate() {
            let Some(footprint) = &self.footprints[i] else { continue };
            if node.level >= finest_level {
                continue;
            }
            let half_width = unit(spacing(node.level));
            let share = (half_width * width).min(1.0) * (half_width * height).min(1.0);
            // Before the scale, which converts to the unit of the image.
            let unscaled = self.remaining[i].size * share * largest_weight;
            if unscaled * largest_scale < least {
                continue;
            }
            let contribution = unscaled * footprint.largest_scale(self.scale);
            if contribution >= least {
                candidates.push((contribution, i));
            }
        }
        candidates
    }

    /// The places of the missing children around `nodes`, in the order of the nodes and without
    /// repetition.
    pub(crate) fn places(&self, nodes: &[usize]) -> Vec<Place> {
        let mut added = FxHashSet::default();
        let mut places = Vec::new();
        for &i in nodes {
            let node = self.tree.nodes()[i];
            let diagonal_only = node.level >= self.limits.required_level
                && self.remaining[i].children == Children::None;
            for (dx, dy, child) in around(node.place, spacing(node.level + 1), 1) {
                let beside = dx == 0 || dy == 0;
                if (diagonal_only && beside) || self.tree.find(child).is_some() {
                    continue;
                }
                if added.insert(key(child)) {
                    places.push(child);
                }
            }
        }
        places
    }
}
