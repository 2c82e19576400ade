//! A sheet: the image tree of one layer of one tile at one energy, and its part in the image.

use super::closed::continue_values;
use super::dyadic::{spacing, unit};
use super::error_map::Footprint;
use super::exam::Exam;
use super::image_tree::{NODES_PER_TASK, Place};
use super::opening::{Choice, ChoiceLimits};
use super::pixels::pixel_means;
use super::remaining::{Children, Remaining, guarded_details, remaining};
use super::round::Scan;
use super::shares::Shares;
use super::sights::{Stop, Wanted, Way, base_depths};
use super::whole;
use crate::image::Image;
use crate::parallel::prelude::*;
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// If this share of the base lines has a jump, surfaces are tracked from line to line, and the image
/// has kinks where they turn away…
const ROUGH_SHARE: f64 = 0.03;
/// …and predictions of this order, which reach less far across them, are the better ones.
const ROUGH_ORDER: usize = 4;
/// A jump within an interval as short as the spacing of this level is one; a loose tolerance leaves
/// it no shorter.
const ROUGH_JUMP_LEVEL: u8 = 5;

/// With fewer open nodes on the base lattice than this, there is nothing to continue from: all are
/// looked at.
const LEAST_OPEN: usize = 6;

/// One layer of one tile at one energy, as a tree of lines.
pub(crate) struct Sheet<'a> {
    pub(crate) scan: Scan<'a>,
    /// The number of its tile.
    pub(crate) tile: usize,
    /// The layers of its tile: the errors of their lines add up.
    pub(crate) layers: usize,
    /// What of the layer each pixel has; all of it if there is none.
    pub(crate) shares: Option<Arc<Shares>>,
    /// For each pixel, its radiance over the mean of the irradiance density on it, times the part
    /// of it that the layer reaches.
    pub(crate) scale: Arc<Image>,
    /// Lines that take no part in the image, to examine it.
    pub(crate) exam: Exam,
}

/// The image of a sheet, and what is not known of it.
pub(crate) struct Part {
    pub(crate) image: Image,
    /// What remains unseen between the lines.
    pub(crate) error: Image,
    /// The error of the lines.
    pub(crate) of_lines: Image,
}

/// What a sheet has seen, for the choice of what is to be looked at next.
pub(crate) struct Seen {
    pub(crate) guarded: Vec<f64>,
    remaining: Vec<Remaining>,
    footprints: Vec<Option<Footprint>>,
    /// Whether all nodes of the levels that are always looked at are there.
    pub(crate) always_seen: bool,
}

impl<'a> Sheet<'a> {
    /// Adds the nodes of the base lattice, and returns the depths that they start with.
    pub(crate) fn add_base(&mut self) -> Wanted {
        let level = self.scan.base_level;
        let lattice = 0..=1_u32 << level;
        let along = |k: u32| k * spacing(level);
        let places: Vec<Place> = lattice
            .clone()
            .flat_map(|i| lattice.clone().map(move |j| [along(i), along(j)]))
            .collect();
        let layer = self.scan.view.layer;
        let open = places.iter().filter(|place| layer.is_open(place.map(unit))).count();
        self.scan.closes = (LEAST_OPEN..places.len()).contains(&open);
        self.scan.add(&places);
        let depths = base_depths(level);
        let open: Vec<usize> =
            (0..places.len()).filter(|&i| !self.scan.sights.is_closed(i)).collect();
        open.iter().for_each(|&i| self.scan.sights.ways[i] = Way::Full);
        open.into_iter().map(|i| (i, depths.clone())).collect()
    }

    /// The depths that seeds want on the lines of the base.
    pub(crate) fn seeded(&self) -> Wanted {
        let nodes = self.scan.tree.nodes().iter().enumerate();
        nodes
            .filter(|(i, _)| !self.scan.sights.is_closed(*i))
            .map(|(i, node)| (i, self.scan.seeds.depths(node.place)))
            .filter(|(_, depths)| !depths.is_empty())
            .collect()
    }

    /// Chooses how jumps are treated, once the base has been looked at.
    pub(crate) fn settle(&mut self) {
        if self.is_rough() {
            self.scan.sights.tracks_jumps = true;
            self.scan.tree.set_order(ROUGH_ORDER);
        }
    }

    /// Whether g jumps on surfaces that many of the base lines cross.
    fn is_rough(&self) -> bool {
        let lines = &self.scan.sights.lines;
        let of_interest = spacing(ROUGH_JUMP_LEVEL);
        let jumping = lines.iter().filter(|line| line.has_jump_within(of_interest));
        let open = (0..lines.len()).filter(|&i| !self.scan.sights.is_closed(i));
        jumping.count() as f64 >= ROUGH_SHARE * open.count() as f64
    }

    /// The largest |radiance| of a line so far.
    pub(crate) fn largest_line(&self) -> f64 {
        self.scan.sights.lines.iter().map(|line| line.integral.abs()).fold(0.0, f64::max)
    }

    /// The radiances of nodes at new `places`, each to `tolerance`; whether the budget allowed it. If
    /// not, the nodes are left out again. Their values are to be set.
    pub(crate) async fn look(
        &mut self,
        places: &[Place],
        guarded: &[f64],
        tolerance: f64,
    ) -> Result<(), Stop> {
        let first = self.scan.tree.len();
        let standing = self.scan.sights.standing();
        self.scan.add(places);
        let looked = self.scan.scan(first, guarded, tolerance).await;
        if let Err(Stop::Budget) = looked {
            self.scan.truncate(first);
            self.scan.sights.restore(&standing);
        }
        looked
    }

    /// The irradiance density of all nodes, from their radiances, less `of_earlier` times what each
    /// of the `earlier` sheets of the layer has there.
    pub(crate) fn set_values(&mut self, earlier: &[&Self], of_earlier: &[f64]) {
        let value = |ghosts: &mut Vec<FxHashMap<u64, f64>>, i: usize| {
            let place = self.scan.tree.nodes()[i].place;
            let integral = self.scan.sights.lines[i].integral;
            self.value_of(place, integral, earlier, of_earlier, ghosts)
        };
        let ghosts = || vec![FxHashMap::default(); earlier.len()];
        let nodes = (0..self.scan.tree.len()).into_par_iter().with_min_len(NODES_PER_TASK);
        let values: Vec<f64> = nodes.map_init(ghosts, value).collect();
        let Scan { tree, sights, base_level, .. } = &mut self.scan;
        for (i, value) in values.into_iter().enumerate() {
            tree.set(i, value);
        }
        let closed: Vec<bool> = (0..tree.len()).map(|i| sights.is_closed(i)).collect();
        continue_values(tree, &closed, *base_level + 1);
        tree.update_details();
    }

    /// The irradiance density at a place from the radiance there, less `of_earlier` times what each of the
    /// `earlier` sheets has, of which `ghosts` are predictions made before.
    pub(crate) fn value_of(
        &self,
        place: Place,
        radiance: f64,
        earlier: &[&Self],
        of_earlier: &[f64],
        ghosts: &mut [FxHashMap<u64, f64>],
    ) -> f64 {
        let density = self.scan.view.layer.solid_angle_density(place.map(unit));
        let sheets = earlier.iter().zip(of_earlier).zip(ghosts);
        sheets.fold(density * radiance, |value, ((sheet, amount), ghosts)| {
            value - amount * sheet.scan.tree.value(place, ghosts)
        })
    }

    /// Row and column of the pixel that a place is in.
    pub(crate) fn pixel(&self, place: Place) -> [usize; 2] {
        let at = |along: u32, pixels: usize| whole(unit(along) * pixels as f64).min(pixels - 1);
        [at(place[1], self.scale.height()), at(place[0], self.scale.width())]
    }

    /// The places of seeds that no node is at yet.
    pub(crate) fn unseen_seeds(&self) -> Vec<Place> {
        let unseen = |place: &&Place| self.scan.tree.find(**place).is_none();
        self.scan.seeds.places.iter().filter(unseen).copied().collect()
    }

    /// The sheet's image and what is not known of it; `scale` is that of the tile.
    pub(crate) fn develop(&self, scale: &Image, always: u8) -> (Part, Seen) {
        let Scan { tree, sights, .. } = &self.scan;
        let shape = [scale.height(), scale.width()];
        let empty = || Image::zeros(scale.height(), scale.width());
        let [mut image, mut error, mut of_lines] = [empty(), empty(), empty()];
        let of_a_line = (0..tree.len()).map(|i| sights.error(i)).fold(0.0, f64::max);
        match &self.shares {
            None => {
                add(&mut image, &pixel_means(tree, shape), scale);
                of_lines.pixels_mut().fill(of_a_line);
            }
            Some(shares) => {
                let [seen, unknown] = shares.apply(&pixel_means(tree, shares.shape()));
                add(&mut image, seen.pixels(), scale);
                add(&mut error, unknown.pixels(), scale);
                of_lines.add_scaled(&shares.reach, of_a_line);
            }
        }
        let guarded = guarded_details(tree);
        let remaining = remaining(tree, &guarded, always);
        let footprint = |(node, remaining): (_, &Remaining)| {
            (remaining.size > 0.0).then(|| Footprint::new(node, remaining, shape))
        };
        let footprints: Vec<Option<Footprint>> =
            tree.nodes().iter().zip(&remaining).map(footprint).collect();
        for footprint in footprints.iter().flatten() {
            footprint.add_to(&mut error, &self.scale, 1.0);
        }
        let nodes = tree.nodes().iter().zip(&remaining);
        let always_seen = nodes
            .filter(|(node, _)| node.level < always)
            .all(|(_, remaining)| remaining.children == Children::All);
        let seen = Seen { guarded, remaining, footprints, always_seen };
        (Part { image, error, of_lines }, seen)
    }

    /// What the choice of nodes is made from; `weights` are those of the sheet in each bin.
    pub(crate) fn choice<'s>(
        &'s self,
        seen: &'s Seen,
        weights: &'s [f64],
        limits: &ChoiceLimits,
    ) -> Choice<'s> {
        Choice {
            tree: &self.scan.tree,
            remaining: &seen.remaining,
            footprints: &seen.footprints,
            weights,
            scale: &self.scale,
            limits: *limits,
        }
    }

    /// The places to be looked at next, the most worthwhile first, given the worthwhile nodes.
    pub(crate) fn places(
        &self,
        seen: &Seen,
        choice: &Choice<'_>,
        mut nodes: Vec<usize>,
    ) -> Vec<Place> {
        if !seen.always_seen {
            let unseen = |&i: &usize| {
                self.scan.tree.nodes()[i].level < choice.limits.always
                    && seen.remaining[i].children != Children::All
            };
            nodes.extend((0..self.scan.tree.len()).filter(unseen));
        }
        let mut places = self.unseen_seeds();
        places.extend(choice.places(&nodes));
        places
    }
}

/// Adds `values` times `scale` to a map.
fn add(map: &mut Image, values: &[f64], scale: &Image) {
    for ((pixel, value), scale) in map.pixels_mut().iter_mut().zip(values).zip(scale.pixels()) {
        *pixel += value * scale;
    }
}
