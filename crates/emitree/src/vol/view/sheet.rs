//! A sheet: the image tree of one part of the view at one energy, and its contribution to the image.

use crate::cell::whole;
use crate::image::Image;
use crate::parallel::prelude::*;
use crate::vol::dyadic::{Place, spacing, unit};
use crate::vol::error_weights::{WeightsOfSquares, errors_of_lines, product};
use crate::vol::image::error_map::Footprint;
use crate::vol::image::opening::{Choice, ChoiceLimits};
use crate::vol::image::pixels::pixel_means;
use crate::vol::image::remaining::{Children, Remaining, guarded_details, remaining};
use crate::vol::image::tree::NODES_PER_TASK;
use crate::vol::line::node_lines::{LineSource, Wanted, base_depths};
use crate::vol::rule::scan::Scan;
use crate::vol::sampling::Stop;
use crate::vol::tuning::TUNING;
use crate::vol::view::lines::FunctionOfPart;
use crate::vol::view::part::Footing;
use crate::vol::view::raster::cell_at;
use crate::vol::view::verification::Verification;
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// The cells of the raster for the errors of lines along each side of a pixel, and the most along a side of it unless
/// the pixels are more.
const ERRORS_PER_PIXEL: usize = 4;
const MOST_ERRORS: usize = 1024;
/// What the largest difference of a line of the verification is beyond the error there is added to the errors of all
/// lines so many times: these are more lines than those.
const BEYOND: f64 = 2.0;

/// The part of the view and the energy of a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SheetId {
    /// The number of its part of the view.
    pub(crate) part: usize,
    /// The number of its energy among those selected.
    pub(crate) energy: usize,
}

/// One part of the view at one energy, as a tree of lines.
pub(crate) struct Sheet<'a> {
    pub(crate) id: SheetId,
    pub(crate) scan: Scan<'a>,
    /// The largest number of parts in which a line of sight is: the errors of their lines add up.
    pub(crate) pieces_of_line: usize,
    /// Where its function is in the image.
    pub(crate) footing: Arc<Footing>,
    /// For each cell of its raster, the ratio of a pixel to the mean of the function there; 0 in
    /// cells that no pixel is in.
    pub(crate) scale: Arc<Image>,
    /// The scale times the weights of errors.
    pub(crate) weighted_scale: Arc<Image>,
    /// Lines that are not part of the image, for its verification.
    pub(crate) verification: Verification,
}

/// The image of a sheet on the rows of the image that it is in, with its estimated errors.
pub(crate) struct SheetImage {
    /// The first of the rows.
    pub(crate) first_row: usize,
    pub(crate) image: Image,
    /// The remaining errors around nodes.
    pub(crate) error: Image,
    /// The errors of the lines.
    pub(crate) of_lines: Image,
}

/// The state of a sheet, for the choice of the next nodes.
pub(crate) struct SheetState {
    pub(crate) guarded: Vec<f64>,
    remaining: Vec<Remaining>,
    footprints: Vec<Option<Footprint>>,
    /// Whether all nodes of the required levels exist.
    pub(crate) has_required: bool,
}

impl<'a> Sheet<'a> {
    /// The tolerance of a line of this sheet, from that of all lines through a pixel at each
    /// energy.
    pub(crate) fn line_tolerance(&self, of_energies: &[f64]) -> f64 {
        of_energies[self.id.energy] / self.pieces_of_line as f64
    }

    /// The finest level whose nodes every rendering samples.
    pub(crate) fn required_level(&self) -> u8 {
        self.scan.base_level + 1
    }

    /// Adds the nodes of the base lattice, and returns the depths that they start with.
    pub(crate) fn add_base(&mut self) -> Wanted {
        let level = self.scan.base_level;
        let lattice = 0..=1_u32 << level;
        let along = |k: u32| k * spacing(level);
        let places: Vec<Place> = lattice
            .clone()
            .flat_map(|i| lattice.clone().map(move |j| [along(i), along(j)]))
            .collect();
        self.scan.add(&places);
        let depths = base_depths(level);
        let nodes = 0..places.len();
        nodes.clone().for_each(|i| self.scan.node_lines.sources[i] = LineSource::Full);
        nodes.map(|i| (i, depths.clone())).collect()
    }

    /// The depths on the base lines that seeds require.
    pub(crate) fn seeded(&self) -> Wanted {
        let nodes = self.scan.tree.nodes().iter().enumerate();
        nodes
            .map(|(i, node)| (i, self.scan.seeds.depths(node.place)))
            .filter(|(_, depths)| !depths.is_empty())
            .collect()
    }

    /// Chooses the order of predictions and the tracking of jumps: they are those of jumps from this share of lines
    /// with one on, and remain so.
    pub(crate) fn choose_order(&mut self, share: f64) {
        if !self.scan.node_lines.tracks_jumps && self.jumps_on(share) {
            self.scan.node_lines.tracks_jumps = true;
            self.scan.tree.set_order(TUNING.view.rough_order);
        }
    }

    /// Whether at least this share of its lines crosses a surface on which g jumps.
    pub(crate) fn jumps_on(&self, share: f64) -> bool {
        let of_interest = spacing(TUNING.view.rough_jump_level);
        let lines = &self.scan.node_lines.lines;
        let all = lines.par_iter().with_min_len(NODES_PER_TASK);
        let jumping = all.filter(|line| line.has_jump_within(of_interest)).count();
        jumping as f64 >= share * lines.len() as f64
    }

    /// Unit vectors along its lines, away from the observer, and their |integrals| times the density of solid angle.
    pub(crate) fn brightness(&self) -> impl Iterator<Item = ([f64; 3], f64)> {
        let chart = self.scan.view.chart;
        let nodes = self.scan.tree.nodes().iter().zip(&self.scan.node_lines.lines);
        nodes.map(move |(node, line)| {
            let [x, y] = node.place.map(unit);
            let towards = chart.world_from_chart([x, y, 0.5]).direction.map(|along| -along);
            (towards, line.integral.abs() * chart.density([x, y]))
        })
    }

    /// Whether none of its lines has a sample.
    pub(crate) fn has_no_samples(&self) -> bool {
        self.scan.node_lines.lines.iter().all(|line| line.samples.is_empty())
    }

    /// The largest |radiance| of a line so far.
    pub(crate) fn largest_line(&self) -> f64 {
        self.scan.node_lines.lines.iter().map(|line| line.integral.abs()).fold(0.0, f64::max)
    }

    /// Samples nodes at new `places`, each to `tolerance`. If the budget does not suffice, the
    /// nodes are removed again. Their values have to be set afterwards.
    pub(crate) async fn sample_nodes(
        &mut self,
        places: &[Place],
        guarded: &[f64],
        tolerance: f64,
    ) -> Result<(), Stop> {
        let first = self.scan.tree.len();
        let snapshot = self.scan.node_lines.snapshot();
        self.scan.add(places);
        let sampled = self.scan.scan(first, guarded, tolerance).await;
        if let Err(Stop::Budget) = sampled {
            self.scan.truncate(first);
            self.scan.node_lines.restore(&snapshot);
        }
        sampled
    }

    /// Sets the values of all nodes: the irradiance density from the radiance, less `of_earlier`
    /// times the value of each of the `earlier` sheets of the layer there.
    pub(crate) fn set_values(&mut self, earlier: &[&Self], of_earlier: &[f64]) {
        let value = |ghosts: &mut Vec<FxHashMap<u64, f64>>, i: usize| {
            let place = self.scan.tree.nodes()[i].place;
            let integral = self.scan.node_lines.lines[i].integral;
            self.value_of(place, integral, earlier, of_earlier, ghosts)
        };
        let ghosts = || vec![FxHashMap::default(); earlier.len()];
        let nodes = (0..self.scan.tree.len()).into_par_iter().with_min_len(NODES_PER_TASK);
        let values: Vec<f64> = nodes.map_init(ghosts, value).collect();
        let tree = &mut self.scan.tree;
        for (i, value) in values.into_iter().enumerate() {
            tree.set(i, value);
        }
        tree.update_details();
    }

    /// The irradiance density at a place from the radiance there, less `of_earlier` times the value
    /// of each of the `earlier` sheets; `ghosts` are cached predictions of these.
    pub(crate) fn value_of(
        &self,
        place: Place,
        radiance: f64,
        earlier: &[&Self],
        of_earlier: &[f64],
        ghosts: &mut [FxHashMap<u64, f64>],
    ) -> f64 {
        let density = self.scan.view.chart.density(place.map(unit));
        let sheets = earlier.iter().zip(of_earlier).zip(ghosts);
        sheets.fold(density * radiance, |value, ((sheet, amount), ghosts)| {
            value - amount * sheet.scan.tree.value(place, ghosts)
        })
    }

    /// Row and column of the cell of the raster that contains a place.
    pub(crate) fn pixel(&self, place: Place) -> [usize; 2] {
        let at = |along: u32, pixels: usize| whole(unit(along) * pixels as f64).min(pixels - 1);
        [at(place[1], self.scale.height()), at(place[0], self.scale.width())]
    }

    /// The places of seeds without a node.
    pub(crate) fn missing_seed_places(&self) -> Vec<Place> {
        let missing = |place: &&Place| self.scan.tree.find(**place).is_none();
        self.scan.seeds.places.iter().filter(missing).copied().collect()
    }

    /// The image of the sheet with its errors, and the state for the choice of nodes.
    pub(crate) fn assemble(&self) -> (SheetImage, SheetState) {
        let required_level = self.required_level();
        let Scan { tree, node_lines, .. } = &self.scan;
        let shape @ [rows, columns] = [self.scale.height(), self.scale.width()];
        let (first_row, image) = self.footing.image(|shape| pixel_means(tree, shape), &self.scale);
        let of_lines = match &self.scan.weights {
            None => {
                let of_a_line = (0..tree.len()).map(|i| node_lines.error(i)).fold(0.0, f64::max);
                self.footing.same_errors(of_a_line, shape)
            }
            Some(_) => {
                let nodes = tree.nodes().iter().enumerate();
                let nodes = nodes.map(|(i, node)| {
                    (node.place, self.scan.level_of_next(node), node_lines.error(i))
                });
                self.footing.errors(errors_of_lines(nodes, shape))
            }
        };
        let mut error = Image::zeros(rows, columns);
        let guarded = guarded_details(tree);
        let remaining = remaining(tree, &guarded, required_level);
        let footprint = |(node, remaining): (_, &Remaining)| {
            (remaining.size > 0.0).then(|| Footprint::new(node, remaining, shape))
        };
        let footprints: Vec<Option<Footprint>> =
            tree.nodes().iter().zip(&remaining).map(footprint).collect();
        for footprint in footprints.iter().flatten() {
            footprint.add_to(&mut error, &self.scale, 1.0);
        }
        let nodes = tree.nodes().iter().zip(&remaining);
        let has_required = nodes
            .filter(|(node, _)| node.level < required_level)
            .all(|(_, remaining)| remaining.children == Children::All);
        let state = SheetState { guarded, remaining, footprints, has_required };
        let error = self.footing.errors(error);
        (SheetImage { first_row, image, error, of_lines }, state)
    }

    /// Its function, with errors on a raster with cells smaller than pixels: those of lines do not cancel in a pixel.
    pub(crate) fn function_of_lines(&self) -> FunctionOfPart<'_> {
        let Scan { tree, node_lines, .. } = &self.scan;
        let finer = |pixels: usize| (ERRORS_PER_PIXEL * pixels).min(MOST_ERRORS.max(pixels));
        let shape @ [rows, columns] = [self.scale.height(), self.scale.width()].map(finer);
        let of_a_line = (0..tree.len()).map(|i| node_lines.error(i)).fold(0.0, f64::max);
        let mut errors = Image::from_pixels(rows, columns, vec![of_a_line; rows * columns]);
        let ones = Image::from_pixels(rows, columns, vec![1.0; rows * columns]);
        let guarded = guarded_details(tree);
        let remaining = remaining(tree, &guarded, self.required_level());
        for (node, remaining) in tree.nodes().iter().zip(&remaining) {
            if remaining.size > 0.0 {
                Footprint::new(node, remaining, shape).add_to(&mut errors, &ones, 1.0);
            }
        }
        // Lines of the verification may have larger errors than single pixels do.
        let beyond = BEYOND * self.beyond_at_verification(&errors);
        errors.pixels_mut().iter_mut().for_each(|error| *error += beyond);
        FunctionOfPart { means: Box::new(move |shape| pixel_means(tree, shape)), errors }
    }

    /// By how much the largest difference of a line of the verification is beyond the error there.
    fn beyond_at_verification(&self, errors: &Image) -> f64 {
        let Verification { places, node_lines, .. } = &self.verification;
        let lines = places.nodes().iter().zip(&node_lines.lines);
        let beyond = lines.filter(|(_, line)| !line.samples.is_empty()).map(|(node, line)| {
            let value = self.value_of(node.place, line.integral, &[], &[], &mut []);
            let of_tree = self.scan.tree.value(node.place, &mut FxHashMap::default());
            let cell = cell_at(node.place.map(unit), [errors.height(), errors.width()]);
            (value - of_tree).abs() - errors.pixels()[cell]
        });
        beyond.fold(0.0, f64::max)
    }

    /// Sets the weights of errors on its raster: the largest of the bins that its image is in, and of those
    /// that its lines are in.
    pub(crate) fn set_weights(&mut self, of_image: &Image, of_lines: &Image) {
        self.weighted_scale = Arc::new(product(&self.scale, of_image));
        self.scan.set_weights(WeightsOfSquares::new(of_lines));
    }

    /// The input of the choice of nodes; `weights` are those of the sheet in each bin, and `scales` the
    /// factors from means of values to weighted pixels in each bin; none if all weights of errors are 1.
    pub(crate) fn choice<'s>(
        &'s self,
        state: &'s SheetState,
        weights: &'s [f64],
        scales: &'s [Image],
        limits: &ChoiceLimits,
    ) -> Choice<'s> {
        Choice {
            tree: &self.scan.tree,
            remaining: &state.remaining,
            footprints: &state.footprints,
            weights,
            scale: &self.weighted_scale,
            scales,
            limits: *limits,
        }
    }

    /// The places of the next nodes, those of seeds first, then by contribution, given the `nodes`
    /// to be opened.
    pub(crate) fn places(
        &self,
        state: &SheetState,
        choice: &Choice<'_>,
        mut nodes: Vec<usize>,
    ) -> Vec<Place> {
        if !state.has_required {
            let missing = |&i: &usize| {
                self.scan.tree.nodes()[i].level < choice.limits.required_level
                    && state.remaining[i].children != Children::All
            };
            nodes.extend((0..self.scan.tree.len()).filter(missing));
        }
        let mut places = self.missing_seed_places();
        places.extend(choice.places(&nodes));
        places
    }
}
