//! The loop: look, develop the image and its error, open what is worth it, until it is good enough.

use super::dyadic::{spacing, unit};
use super::error_map::Footprint;
use super::image_tree::{ImageTree, Place};
use super::opening::Choice;
use super::pixels::pixel_means;
use super::remaining::{Children, Remaining, guarded_details, remaining};
use super::round::Scan;
use super::seeds::Looks;
use super::sights::{Sights, Stop, View, Wanted, Way, base_depths};
use super::{BASE_LEVELS, VolOptions, whole};
use crate::emission::Emission;
use crate::error::RenderError;
use crate::image::Image;
use crate::meter::Meter;
use crate::projection::Projection;
use crate::render::{Frame, RenderOptions, Rendering, check_finite};
use crate::tree::Ending;
use core::ops::ControlFlow;

/// Looser requests are met at this tolerance: a looser search does not find the structure.
const LOOSEST_TOLERANCE: f64 = 0.05;
/// The largest estimate has to be within this share of the tolerance.
const STOP: f64 = 0.85;
/// The share of the tolerance that a line or a depth rule may take.
const LINE_SHARE: f64 = 0.2;
/// If lines are all that is left to be improved, their share is halved this often.
const MOST_HALVINGS: u32 = 4;
/// A jump within an interval as short as the spacing of this level is one; a loose tolerance leaves
/// it no shorter.
const ROUGH_JUMP_LEVEL: u8 = 5;
/// If this share of the base lines has a jump, surfaces are tracked from line to line, and the image
/// has kinks where they turn away…
const ROUGH_SHARE: f64 = 0.03;
/// …and predictions of this order, which reach less far across them, are the better ones.
const ROUGH_ORDER: usize = 4;
/// Nodes are no closer to each other than 2^−this of a pixel.
const BELOW_PIXEL_LEVELS: u32 = 4;
/// Levels of nodes that the places have room for, with two for the children and their neighbours.
const FINEST_LEVEL: u8 = 22;
/// A round may cost this much more for each node than the one before.
const COST_MARGIN: f64 = 1.3;
/// A round that the budget did not allow has cost this much more than was expected, at the least.
const TOO_DEAR: f64 = 3.0;
/// An image whose pixels cancel below this share of ∫ |G| dz on a line is good enough if it is good to
/// the tolerance of that.
const CANCELLED: f64 = 1e-6;
/// A round of fewer nodes is not worth another one, when the budget is all but spent.
const LEAST_ROUND: usize = 8;

/// A budget below this many times the first look may be short: then the tolerance is approached in
/// steps, so that the evaluations go into the whole image and not into the digits of its first lines.
const SHORT_BUDGET: u64 = 300;
/// Evaluations grow like the tolerance to the power of −this, roughly: a tenfold precision costs two
/// to three times as many.
const COST_EXPONENT: f64 = 0.4;

/// The image that a camera sees, to the tolerance of `vol`.
pub(crate) fn render<E: Emission>(
    meter: &Meter<'_, E>,
    projection: &dyn Projection,
    shape: [usize; 2],
    vol: &VolOptions,
    options: &RenderOptions<'_>,
) -> Result<Rendering, RenderError<E::Error>> {
    let base_level = affordable_base_level(vol, meter.evaluations_left())?;
    let asked = vol.tolerance.min(LOOSEST_TOLERANCE);
    let short = meter.evaluations_left() < SHORT_BUDGET * first_look(base_level);
    let mut engine = Engine {
        scan: Scan {
            view: View { meter },
            base_level,
            tree: ImageTree::default(),
            sights: Sights::default(),
            seeds: Looks::default(),
        },
        projection,
        scale: radiance_per_density(projection, shape),
        shape,
        asked,
        tolerance: if short { LOOSEST_TOLERANCE } else { asked },
        line_share: LINE_SHARE,
        always: base_level + 1,
        finest_level: finest_level(shape, base_level),
    };
    engine.scan.seeds = Looks::at(options.seeds, projection, base_level, engine.finest_level);
    let (developed, ending) = engine.run(options)?;
    // The budget may end a search that has been stricter than what was asked for.
    let met = engine.has_seen(&developed)
        && developed.error.largest() <= vol.tolerance * developed.image.largest();
    // A base coarser than the one asked for has not looked where it was asked to.
    let ending = match ending {
        _ if base_level < vol.base_level => Ending::Budget,
        _ if met => Ending::Complete,
        ending => ending,
    };
    let mut rendering = Rendering::new(developed.image, Some(developed.error), ending);
    rendering.base_level = Some(base_level);
    Ok(rendering)
}

/// The base level asked for, or the finest one whose first look the budget allows.
fn affordable_base_level<E>(vol: &VolOptions, allowed: u64) -> Result<u8, RenderError<E>> {
    let option = |name, value: String, expected| Err(RenderError::Option { name, value, expected });
    if !(vol.tolerance > 0.0 && vol.tolerance < 1.0) {
        return option("tolerance", vol.tolerance.to_string(), "a fraction above 0 and below 1");
    }
    if !BASE_LEVELS.contains(&vol.base_level) {
        return option("base_level", vol.base_level.to_string(), "2 to 7");
    }
    (1..=vol.base_level).rev().find(|&level| first_look(level) <= allowed).ok_or_else(|| {
        let what = "a first look at 3 x 3 lines in 3 depths".to_owned();
        RenderError::Budget { what, needed: first_look(1), allowed }
    })
}

/// Evaluations of the base lattice.
fn first_look(base_level: u8) -> u64 {
    ((1_u64 << base_level) + 1).pow(3)
}

/// The deepest level of nodes that the pixels can be the better for.
fn finest_level([height, width]: [usize; 2], base_level: u8) -> u8 {
    let of_pixels = height.max(width).next_power_of_two().trailing_zeros() + BELOW_PIXEL_LEVELS;
    u8::try_from(of_pixels).unwrap_or(FINEST_LEVEL).clamp(base_level + 2, FINEST_LEVEL)
}

/// For each pixel, its radiance over the mean of the irradiance density on it.
fn radiance_per_density(projection: &dyn Projection, [height, width]: [usize; 2]) -> Image {
    let area = 1.0 / (height as f64 * width as f64);
    let mut scale = Image::zeros(height, width);
    for row in 0..height {
        // Borders as quotients, so that neighbours share them to the last bit.
        let y = [row, row + 1].map(|r| r as f64 / height as f64);
        for (column, scale) in scale.row_mut(row).iter_mut().enumerate() {
            let x = [column, column + 1].map(|c| c as f64 / width as f64);
            *scale = area / projection.solid_angle([x[0], y[0]], [x[1], y[1]]);
        }
    }
    scale
}

struct Engine<'a, E> {
    scan: Scan<'a, E>,
    projection: &'a dyn Projection,
    scale: Image,
    shape: [usize; 2],
    /// The error to be met in the end, relative to the largest pixel.
    asked: f64,
    /// The error to be met first.
    tolerance: f64,
    line_share: f64,
    /// The finest level that every rendering looks at.
    always: u8,
    finest_level: u8,
}

/// The image so far, and what is known of its error.
struct Developed {
    image: Image,
    error: Image,
    guarded: Vec<f64>,
    remaining: Vec<Remaining>,
    footprints: Vec<Option<Footprint>>,
    /// Whether all nodes of the levels that are always looked at are there.
    always_seen: bool,
}

impl<E: Emission> Engine<'_, E> {
    fn run(
        &mut self,
        options: &RenderOptions<'_>,
    ) -> Result<(Developed, Ending), RenderError<E::Error>> {
        let mut within_budget = self.look_at_base()?;
        let mut developed = self.develop()?;
        // Lines that were refined by themselves: rules are cheaper.
        let mut cost_per_node =
            self.scan.view.meter.evaluations() as f64 / self.scan.tree.len() as f64;
        let mut halvings = 0;
        loop {
            let meter = self.scan.view.meter;
            if let Some(callback) = options.frame {
                let frame = Frame {
                    image: &developed.image,
                    error: &developed.error,
                    evaluations: meter.evaluations(),
                    batches: meter.batches(),
                };
                if let ControlFlow::Break(()) = callback(&frame) {
                    return Err(RenderError::Interrupted);
                }
            }
            let largest = developed.image.largest().max(CANCELLED * self.scan.sights.brightest());
            let met = |tolerance: f64| {
                self.has_seen(&developed) && developed.error.largest() <= STOP * tolerance * largest
            };
            if met(self.asked) {
                return Ok((developed, Ending::Complete));
            }
            if !within_budget {
                return Ok((developed, Ending::Budget));
            }
            if met(self.tolerance) {
                self.tolerance = self.next_tolerance();
            }
            let target = self.tolerance * largest;
            let mut places = self.unseen_seeds();
            places.extend(self.choose(&developed, target));
            if places.is_empty() {
                if halvings == MOST_HALVINGS {
                    return Ok((developed, Ending::DeepestLevel));
                }
                halvings += 1;
                self.line_share *= 0.5;
            }
            let affordable = meter.evaluations_left() as f64 / (COST_MARGIN * cost_per_node);
            if places.len() as f64 > affordable {
                places.truncate(whole(affordable));
                within_budget = places.len() >= LEAST_ROUND;
            }
            places.sort_unstable();
            places.dedup();
            let before = meter.evaluations();
            if self.look(&places, &developed.guarded, target)? {
                let spent = (meter.evaluations() - before) as f64;
                if !places.is_empty() {
                    cost_per_node = spent / places.len() as f64;
                }
            } else {
                // Fewer nodes may do, with what is left.
                cost_per_node *= TOO_DEAR;
                within_budget &= places.len() >= LEAST_ROUND;
            }
            developed = self.develop()?;
        }
    }

    /// The tolerance that the rest of the budget may reach.
    fn next_tolerance(&self) -> f64 {
        let meter = self.scan.view.meter;
        let (spent, left) = (meter.evaluations() as f64, meter.evaluations_left() as f64);
        let finer = ((spent + left) / spent).powf(-1.0 / COST_EXPONENT);
        // Half at the least: a smaller step would cost more than it brings.
        (self.tolerance * finer.min(0.5)).max(self.asked)
    }

    /// The lines of the base lattice, each refined by itself; whether the budget allowed it.
    fn look_at_base(&mut self) -> Result<bool, RenderError<E::Error>> {
        let step = spacing(self.scan.base_level);
        let lattice = 0..=1_u32 << self.scan.base_level;
        let places: Vec<Place> = lattice
            .clone()
            .flat_map(|i| lattice.clone().map(move |j| [i * step, j * step]))
            .collect();
        self.scan.add(&places);
        self.scan.sights.ways.fill(Way::Full);
        let depths = base_depths(self.scan.base_level);
        let looked = self.refine_base((0..places.len()).map(|i| (i, depths.clone())).collect());
        if self.is_rough() {
            self.scan.sights.tracks_jumps = true;
            self.scan.tree.set_order(ROUGH_ORDER);
        }
        self.set_values();
        within_budget(looked)
    }

    /// Refines all lines of the base, step by step: the tolerance follows the largest of them.
    fn refine_base(&mut self, mut wanted: Wanted) -> Result<(), Stop<E::Error>> {
        let Scan { view, tree, sights, seeds, base_level } = &mut self.scan;
        let mut tolerance = f64::INFINITY;
        let mut seeded: Wanted = (0..tree.len())
            .map(|i| (i, seeds.depths(tree.nodes()[i].place)))
            .filter(|(_, depths)| !depths.is_empty())
            .collect();
        while !wanted.is_empty() {
            sights.sample(view, tree, &wanted)?;
            sights.assess(wanted.iter().map(|(i, _)| *i), tolerance, *base_level);
            let largest = sights.lines.iter().map(|line| line.integral.abs()).fold(0.0, f64::max);
            let largest = largest.max(CANCELLED * sights.brightest());
            tolerance = self.line_share * self.tolerance * largest;
            wanted = sights.assess(0..tree.len(), tolerance, *base_level);
            if wanted.is_empty() {
                wanted = core::mem::take(&mut seeded);
            }
        }
        let found: Vec<usize> = (0..self.scan.tree.len()).collect();
        self.scan.follow(&found, tolerance)
    }

    /// Whether g jumps on surfaces that many of the base lines cross.
    fn is_rough(&self) -> bool {
        let lines = &self.scan.sights.lines;
        let of_interest = spacing(ROUGH_JUMP_LEVEL);
        let jumping = lines.iter().filter(|line| line.has_jump_within(of_interest));
        jumping.count() as f64 >= ROUGH_SHARE * lines.len() as f64
    }

    /// The radiances of nodes at new `places`; whether the budget allowed it. If not, the nodes are
    /// left out again.
    fn look(
        &mut self,
        places: &[Place],
        guarded: &[f64],
        target: f64,
    ) -> Result<bool, RenderError<E::Error>> {
        let first = self.scan.tree.len();
        let standing = self.scan.sights.standing();
        self.scan.add(places);
        let allowed = within_budget(self.scan.scan(first, guarded, self.line_share * target))?;
        if !allowed {
            self.scan.truncate(first);
            self.scan.sights.restore(&standing);
        }
        self.set_values();
        Ok(allowed)
    }

    /// The irradiance density of all nodes, from their radiances.
    fn set_values(&mut self) {
        for i in 0..self.scan.tree.len() {
            let xy = self.scan.tree.nodes()[i].place.map(unit);
            let density = self.projection.solid_angle_density(xy);
            self.scan.tree.set(i, density * self.scan.sights.lines[i].integral);
        }
        self.scan.tree.update_details();
    }

    /// Whether all that every rendering looks at has been looked at, and what seeds have named.
    fn has_seen(&self, developed: &Developed) -> bool {
        developed.always_seen && self.unseen_seeds().is_empty()
    }

    /// The places of seeds that no node is at yet.
    fn unseen_seeds(&self) -> Vec<Place> {
        let unseen = |place: &&Place| self.scan.tree.find(**place).is_none();
        self.scan.seeds.places.iter().filter(unseen).copied().collect()
    }

    /// The image and its error, from what has been seen so far.
    fn develop(&self) -> Result<Developed, RenderError<E::Error>> {
        let Scan { tree, sights, .. } = &self.scan;
        let [height, width] = self.shape;
        let mut image = Image::from_pixels(height, width, pixel_means(tree, self.shape));
        for (pixel, scale) in image.pixels_mut().iter_mut().zip(self.scale.pixels()) {
            *pixel *= scale;
        }
        check_finite(&image)?;
        let guarded = guarded_details(tree);
        let remaining = remaining(tree, &guarded, self.always);
        let footprint = |(node, remaining): (_, &Remaining)| {
            (remaining.size > 0.0).then(|| Footprint::new(node, remaining, self.shape))
        };
        let footprints: Vec<Option<Footprint>> =
            tree.nodes().iter().zip(&remaining).map(footprint).collect();
        let of_lines = (0..tree.len()).map(|i| sights.error(i)).fold(0.0, f64::max);
        let mut error = Image::from_pixels(height, width, vec![of_lines; height * width]);
        for footprint in footprints.iter().flatten() {
            footprint.add_to(&mut error, &self.scale, 1.0);
        }
        let nodes = tree.nodes().iter().zip(&remaining);
        let always_seen = nodes
            .filter(|(node, _)| node.level < self.always)
            .all(|(_, remaining)| remaining.children == Children::All);
        Ok(Developed { image, error, guarded, remaining, footprints, always_seen })
    }

    /// The places to be looked at next, the most worthwhile first.
    fn choose(&self, developed: &Developed, target: f64) -> Vec<Place> {
        let choice = Choice {
            tree: &self.scan.tree,
            remaining: &developed.remaining,
            footprints: &developed.footprints,
            error: &developed.error,
            scale: &self.scale,
            tolerance: target,
            finest_level: self.finest_level,
            always: self.always,
        };
        let mut nodes = choice.nodes();
        if !developed.always_seen {
            let unseen = |&i: &usize| {
                self.scan.tree.nodes()[i].level < self.always
                    && developed.remaining[i].children != Children::All
            };
            nodes.extend((0..self.scan.tree.len()).filter(unseen));
        }
        choice.places(&nodes)
    }
}

/// Whether the budget allowed something that may have been stopped by it.
fn within_budget<E>(result: Result<(), Stop<E>>) -> Result<bool, RenderError<E>> {
    match result {
        Ok(()) => Ok(true),
        Err(Stop::Budget) => Ok(false),
        Err(Stop::Failed(error)) => Err(error),
    }
}
