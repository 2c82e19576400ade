//! The loop: look, develop the image and its error, open what is worth it, until it is good enough.

use super::coverage::{Coverage, LayerSamples, fraction_of_view};
use super::cross::{self, Attempted};
use super::developed::Developed;
use super::dyadic::STEPS;
use super::energies::Energies;
use super::exam::Verdict;
use super::image_tree::Place;
use super::opening::{Choice, ChoiceLimits, worthwhile};
use super::round::Scan;
use super::seeds::{Seed, check_seeds};
use super::sheet::Sheet;
use super::sights::{Stop, Wanted};
use super::spectra::Spectra;
use super::visible::{Visible, visible_layers};
use super::{BASE_LEVELS, VolOptions, whole};
use crate::energy::EnergyAxis;
use crate::error::{OptionError, RenderError};
use crate::exchange::MethodError;
use crate::image::Image;
use crate::meter::Meter;
use crate::method::Made;
use crate::projection::Layer;
use crate::radiance::radiance_per_density;
use crate::tile::Tile;
use crate::tree::Ending;

/// Looser requests are met at this tolerance: a looser search does not find the structure.
pub(super) const LOOSEST_TOLERANCE: f64 = 0.05;
/// The largest estimate has to be within this share of the tolerance.
pub(super) const STOP: f64 = 0.85;
/// The share of the tolerance that a line or a depth rule may take.
const LINE_SHARE: f64 = 0.2;
/// Lines are integrated as for this tolerance if a looser one is asked for: looser lines step over peaks,
/// and what some lines have and others have not looks like structure of the image, which is expensive. Of 60
/// anisotropic peaks 3 cost more than 1.15 times a tighter tolerance at 2 to 10 %, 4 with lines for 2 %,
/// and 10 without this; images to 10 % cost 8 % more for it.
const LOOSEST_OF_LINES: f64 = 0.01;
/// If lines are all that is left to be improved, their share is halved this often.
const MOST_HALVINGS: u32 = 4;
/// Nodes are no closer to each other than 2^−this of a pixel…
const BELOW_PIXEL_LEVELS: u32 = 4;
/// …but on an image of few pixels may be as close as this level.
const FINE_ENOUGH_LEVEL: u8 = 10;
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
pub(super) const COST_EXPONENT: f64 = 0.4;

/// The image that a camera sees, or the cube in the bins of `axis`, to the tolerance of `vol`.
pub(crate) async fn render(
    meter: &Meter,
    tiles: &[Tile<'_>],
    axis: Option<&EnergyAxis>,
    vol: &VolOptions,
) -> Result<Made, MethodError> {
    check(vol)?;
    check_seeds(&vol.seeds)?;
    let Attempted { found: products, samples } = match axis {
        None => cross::attempt(meter, tiles, vol).await?,
        Some(_) => Attempted::default(),
    };
    let is_good = |found: &Made| found.ending == Ending::Complete;
    let products = match products {
        Some(products) if is_good(&products) => return Ok(products),
        products => products,
    };
    match (products, by_tree(meter, tiles, axis, vol, samples).await) {
        // The time has ended before the lines have given an image.
        (Some(products), Err(RenderError::Time { .. })) => Ok(products),
        (products, tree) => {
            let tree = tree?;
            // A limit may end both: then the better one counts.
            let is_better = |products: &Made| products.estimated_error() < tree.estimated_error();
            Ok(products.filter(|p| !is_good(&tree) && is_better(p)).unwrap_or(tree))
        }
    }
}

/// The same by image trees alone.
pub(crate) async fn by_tree(
    meter: &Meter,
    tiles: &[Tile<'_>],
    axis: Option<&EnergyAxis>,
    vol: &VolOptions,
    known: LayerSamples,
) -> Result<Made, MethodError> {
    let wanted = vol.smallest_feature.map(|size| fraction_of_view(size, tiles)).transpose()?;
    let layers: Vec<Vec<Box<dyn Layer + '_>>> =
        tiles.iter().map(|tile| tile.projection.layers()).collect();
    let mut scales: Vec<Image> =
        tiles.iter().map(|tile| radiance_per_density(tile.projection, tile.shape)).collect();
    let layers = visible_layers(tiles, &layers, &mut scales);
    meter.check_time()?;
    let sheets = layers.len() as u64;
    // Each of several tiles is a small part of the view, and finer in itself.
    let wanted_level = vol.base_level.saturating_sub(u8::from(tiles.len() > 1)).max(1);
    let base_level = affordable_base_level(wanted_level, sheets, meter.evaluations_left())?;
    let asked = vol.tolerance.min(LOOSEST_TOLERANCE);
    let short = meter.evaluations_left() < SHORT_BUDGET * sheets * first_look(base_level);
    let mut engine = Engine {
        meter,
        tiles,
        layers,
        seeds: &vol.seeds,
        sheets: Vec::new(),
        energies: Energies::none(),
        spectra: axis.map(|axis| Spectra::new(axis, &vol.line_energies)),
        scales,
        promised: vol.tolerance,
        asked,
        made_before: meter.evaluations(),
        lines_of_exam: 1,
        coverage: Coverage::new(wanted, known),
        tolerance: if short { LOOSEST_TOLERANCE } else { asked },
        line_share: LINE_SHARE * (LOOSEST_OF_LINES / asked).min(1.0),
        is_strict: false,
        base_level,
        always: base_level + 1,
        finest_level: finest_level(tiles[0].shape, base_level),
    };
    let (developed, ending) = engine.run().await?;
    // A base coarser than the one asked for has not looked where it was asked to.
    let ending = if base_level < wanted_level { Ending::Budget } else { ending };
    let [cube, error] = engine.finished(&developed);
    let mut made = Made::new(cube, Some(error), ending);
    made.base_level = Some(base_level);
    made.energies = engine.energies_used();
    made.smallest_feature = engine.coverage.smallest;
    Ok(made)
}

/// Refuses options out of range.
fn check(vol: &VolOptions) -> Result<(), MethodError> {
    if !(vol.tolerance > 0.0 && vol.tolerance < 1.0) {
        return Err(OptionError::Tolerance(vol.tolerance).into());
    }
    if !BASE_LEVELS.contains(&vol.base_level) {
        return Err(OptionError::BaseLevel(vol.base_level).into());
    }
    Ok(())
}

/// The base level wanted, or the finest one whose first look the budget allows.
fn affordable_base_level(wanted: u8, sheets: u64, allowed: u64) -> Result<u8, MethodError> {
    let needed = |level| sheets * first_look(level);
    (1..=wanted).rev().find(|&level| needed(level) <= allowed).ok_or_else(|| {
        let what = "a first look at 3 x 3 lines in 3 depths".to_owned();
        RenderError::Budget { what, needed: needed(1), allowed }
    })
}

/// Evaluations of the base lattice.
pub(super) fn first_look(base_level: u8) -> u64 {
    ((1_u64 << base_level) + 1).pow(3)
}

/// The deepest level of nodes that the pixels can be the better for.
pub(super) fn finest_level([height, width]: [usize; 2], base_level: u8) -> u8 {
    let of_pixels = height.max(width).next_power_of_two().trailing_zeros() + BELOW_PIXEL_LEVELS;
    let least = FINE_ENOUGH_LEVEL.max(base_level + 2);
    u8::try_from(of_pixels).unwrap_or(FINEST_LEVEL).clamp(least, FINEST_LEVEL)
}

pub(crate) struct Engine<'b> {
    pub(crate) meter: &'b Meter,
    pub(crate) tiles: &'b [Tile<'b>],
    /// The layers of all tiles, those of the first tile first.
    pub(crate) layers: Vec<Visible<'b>>,
    pub(crate) seeds: &'b [Seed],
    /// All layers at the first energy, then all at the second, and so on.
    pub(crate) sheets: Vec<Sheet<'b>>,
    /// The energies of the sheets, and their weights in the bins.
    pub(crate) energies: Energies,
    /// How energies are found, if there is an energy axis.
    pub(crate) spectra: Option<Spectra<'b>>,
    /// For each tile, its radiances over means of the irradiance density.
    pub(crate) scales: Vec<Image>,
    /// The error that was asked for, relative to the largest pixel…
    promised: f64,
    /// …and the one to be met in the end, which may be stricter.
    asked: f64,
    /// The error to be met first.
    pub(crate) tolerance: f64,
    pub(crate) line_share: f64,
    /// Whether an exam has made lines stricter.
    pub(crate) is_strict: bool,
    pub(crate) base_level: u8,
    /// The finest level that every rendering looks at.
    pub(crate) always: u8,
    pub(crate) finest_level: u8,
    /// Evaluations that were made before, for a search by products.
    pub(crate) made_before: u64,
    /// How many times the usual number of lines the next exam has.
    pub(crate) lines_of_exam: usize,
    /// Scattered samples, and the size of what they see.
    pub(crate) coverage: Coverage,
}

impl Engine<'_> {
    async fn run(&mut self) -> Result<(Developed, Ending), MethodError> {
        let before = self.made_before;
        let mut within_budget = self.look_first().await?;
        let mut developed = self.develop()?;
        // Lines that were refined by themselves: rules are cheaper.
        let nodes: usize = self.sheets.iter().map(|sheet| sheet.scan.tree.len()).sum();
        let mut cost_per_node = (self.meter.evaluations() - before) as f64 / nodes as f64;
        let mut halvings = 0;
        loop {
            let meter = self.meter;
            self.show(&developed);
            let largest = developed.largest_pixel().max(CANCELLED * self.brightest());
            let met = |tolerance: f64| {
                self.has_seen(&developed) && developed.largest_error() <= STOP * tolerance * largest
            };
            let [is_good, is_good_for_now] = [self.asked, self.tolerance].map(met);
            if is_good {
                match self.examine(&developed, self.promised * largest).await? {
                    Verdict::Passed => {
                        self.show(&developed);
                        return Ok((developed, Ending::Complete));
                    }
                    Verdict::TooFine => return Ok((developed, Ending::DeepestLevel)),
                    Verdict::Unaffordable => return Ok((developed, Ending::Budget)),
                    Verdict::Failed => developed = self.develop()?,
                }
            }
            if !within_budget {
                return self.conclude(developed, Ending::Budget).await;
            }
            if is_good_for_now && !is_good {
                self.tolerance = self.next_tolerance();
            }
            let target = self.tolerance * largest;
            let mut places = self.choose(&developed, target);
            let count = total(&places);
            if count == 0 {
                if halvings == MOST_HALVINGS {
                    return self.conclude(developed, Ending::DeepestLevel).await;
                }
                halvings += 1;
                self.line_share *= 0.5;
                self.spectra.iter_mut().for_each(Spectra::tighten);
            }
            let affordable = meter.evaluations_left() as f64 / (COST_MARGIN * cost_per_node);
            if count as f64 > affordable {
                // Each sheet keeps its most worthwhile ones.
                let kept = whole(affordable);
                places.iter_mut().for_each(|places| places.truncate(places.len() * kept / count));
                within_budget = total(&places) >= LEAST_ROUND;
            }
            for places in &mut places {
                places.sort_unstable();
                places.dedup();
            }
            let looked = total(&places);
            let before = meter.evaluations();
            if self.look(&places, &developed, target).await? {
                let spent = (meter.evaluations() - before) as f64;
                if looked > 0 {
                    cost_per_node = spent / looked as f64;
                }
            } else {
                // Fewer nodes may do, with what is left. Nodes where nothing is in view cost nothing, and
                // those before may all have been such.
                cost_per_node = cost_per_node.max(1.0) * TOO_DEAR;
                within_budget &= looked >= LEAST_ROUND;
            }
            let largest = developed.largest_pixel();
            developed = self.develop()?;
            if within_budget && self.spectra.is_some() {
                within_budget = self.look_at_spectra(largest).await?;
                developed = self.develop()?;
            }
        }
    }

    /// The end of a search that a limit has stopped: it has been stricter than what was promised, and may
    /// have met that all the same.
    async fn conclude(
        &mut self,
        developed: Developed,
        ending: Ending,
    ) -> Result<(Developed, Ending), MethodError> {
        let target = self.promised * developed.largest_pixel();
        let met = self.has_seen(&developed) && developed.largest_error() <= target;
        let passed = met && self.examine(&developed, target).await? == Verdict::Passed;
        Ok((developed, if passed { Ending::Complete } else { ending }))
    }

    /// The tolerance that the rest of the budget may reach.
    fn next_tolerance(&self) -> f64 {
        let (spent, left) = (self.meter.evaluations() as f64, self.meter.evaluations_left() as f64);
        let finer = ((spent + left) / spent).powf(-1.0 / COST_EXPONENT);
        // Half at the least: a smaller step would cost more than it brings.
        (self.tolerance * finer.min(0.5)).max(self.asked)
    }

    /// The largest ∫ |G| dz of a line.
    pub(crate) fn brightest(&self) -> f64 {
        self.sheets.iter().map(|sheet| sheet.scan.sights.brightest()).fold(0.0, f64::max)
    }

    /// The lines of the base lattice at the first energy, and at all others that their spectra need;
    /// whether the budget allowed it.
    async fn look_first(&mut self) -> Result<bool, MethodError> {
        let base = self.layers.len() as u64 * first_look(self.base_level);
        let energy = if base + self.cost_of_first_energy() > self.meter.evaluations_left() {
            self.spectra.as_ref().map(|_| STEPS / 2)
        } else {
            match self.brightest_energy().await {
                Err(Stop::Budget) => Some(STEPS / 2),
                Err(Stop::Failed(error)) => return Err(error),
                Ok(place) => place,
            }
        };
        self.add_sheets(energy);
        let looked = self.look_at_base(0, None).await?;
        match &self.spectra {
            Some(_) if looked => self.look_at_first_spectra(energy).await,
            _ => Ok(looked),
        }
    }

    /// The lines of the base lattice of the sheets from `first` on, each refined by itself, to
    /// the `tolerances` of all energies, or to that of the largest of them; whether the budget allowed it.
    pub(crate) async fn look_at_base(
        &mut self,
        first: usize,
        tolerances: Option<&[f64]>,
    ) -> Result<bool, MethodError> {
        let wanted = self.sheets[first..].iter_mut().map(Sheet::add_base).collect();
        let looked = self.refine_base(first, wanted, tolerances).await;
        self.sheets[first..].iter_mut().for_each(Sheet::settle);
        self.set_values(first);
        within_budget(looked)
    }

    /// Refines all lines of the base, step by step: the tolerance follows the largest of them unless
    /// there is one for each energy.
    async fn refine_base(
        &mut self,
        first: usize,
        mut wanted: Vec<Wanted>,
        fixed: Option<&[f64]>,
    ) -> Result<(), Stop> {
        let layers = self.layers.len();
        let mut tolerances = vec![f64::INFINITY; self.sheets.len()];
        let mut seeded: Vec<Wanted> = self.sheets[first..].iter().map(Sheet::seeded).collect();
        while wanted.iter().any(|wanted| !wanted.is_empty()) {
            let sheets = self.sheets.iter_mut().zip(&tolerances).skip(first);
            for ((sheet, tolerance), wanted) in sheets.zip(&wanted) {
                let Scan { view, tree, sights, depth_level, .. } = &mut sheet.scan;
                sights.sample(view, tree, wanted).await?;
                sights.assess(wanted.iter().map(|(i, _)| *i), *tolerance, *depth_level);
            }
            let largest = self.sheets.iter().map(Sheet::largest_line).fold(0.0, f64::max);
            let largest = largest.max(CANCELLED * self.brightest());
            let following = self.line_share * self.tolerance * largest;
            for (i, (sheet, tolerance)) in self.sheets.iter().zip(&mut tolerances).enumerate() {
                *tolerance =
                    fixed.map_or(following, |fixed| fixed[i / layers]) / sheet.layers as f64;
            }
            let assess = |(sheet, tolerance): (&mut Sheet<'_>, &f64)| {
                let Scan { tree, sights, depth_level, .. } = &mut sheet.scan;
                sights.assess(0..tree.len(), *tolerance, *depth_level)
            };
            wanted = self.sheets.iter_mut().zip(&tolerances).skip(first).map(assess).collect();
            if wanted.iter().all(Vec::is_empty) {
                wanted = core::mem::take(&mut seeded);
            }
        }
        for (sheet, tolerance) in self.sheets.iter_mut().zip(&tolerances).skip(first) {
            let found: Vec<usize> = (0..sheet.scan.tree.len()).collect();
            sheet.scan.follow(&found, *tolerance).await?;
        }
        Ok(())
    }

    /// The tolerance of a line at each energy, so that an error of `target` in a pixel leaves room for
    /// all else: as much for each where it has its largest weight.
    pub(crate) fn line_tolerances(&self, target: f64) -> Vec<f64> {
        let nodal = self.energies.nodal_weights();
        let largest = |k: usize| nodal.iter().map(|of_bin| of_bin[k].abs()).fold(0.0, f64::max);
        let scales: Vec<f64> = (0..self.energies.len())
            .map(largest)
            .map(|largest| if largest > 0.0 { 1.0 / largest } else { 1.0 })
            .collect();
        let together = |of_bin: &Vec<f64>| {
            of_bin.iter().zip(&scales).map(|(weight, scale)| weight.abs() * scale).sum()
        };
        let most = nodal.iter().map(together).fold(1.0, f64::max);
        scales.iter().map(|scale| self.line_share * target * scale / most).collect()
    }

    /// The values of the sheets from `first` on, those of the earliest energy first.
    pub(crate) fn set_values(&mut self, first: usize) {
        let layers = self.layers.len();
        for i in first..self.sheets.len() {
            let (earlier, rest) = self.sheets.split_at_mut(i);
            let of_layer: Vec<&Sheet<'_>> =
                earlier.iter().skip(i % layers).step_by(layers).collect();
            let amounts = self.energies.learned.get(i / layers).map(|one| &one.of_earlier[..]);
            rest[0].set_values(&of_layer, amounts.unwrap_or_default());
        }
    }

    /// The radiances of nodes at new `places` of each sheet; whether the budget allowed it.
    async fn look(
        &mut self,
        places: &[Vec<Place>],
        developed: &Developed,
        target: f64,
    ) -> Result<bool, MethodError> {
        let mut allowed = true;
        let tolerances = self.line_tolerances(target);
        let layers = self.layers.len();
        let sheets = self.sheets.iter_mut().zip(places).zip(&developed.seen);
        for (i, ((sheet, places), seen)) in sheets.enumerate() {
            let tolerance = tolerances[i / layers] / sheet.layers as f64;
            allowed &= within_budget(sheet.look(places, &seen.guarded, tolerance).await)?;
        }
        self.set_values(0);
        Ok(allowed)
    }

    /// Whether all that every rendering looks at has been looked at, and what seeds have named.
    fn has_seen(&self, developed: &Developed) -> bool {
        developed.seen.iter().all(|seen| seen.always_seen)
            && self.sheets.iter().all(|sheet| sheet.unseen_seeds().is_empty())
    }

    /// The places to be looked at next on each sheet, the most worthwhile first. The sheets of a tile
    /// compete for its error.
    fn choose(&self, developed: &Developed, target: f64) -> Vec<Vec<Place>> {
        let Self { finest_level, always, .. } = *self;
        let limits = ChoiceLimits { tolerance: target, finest_level, always };
        let mut places = vec![Vec::new(); self.sheets.len()];
        for (tile, maps) in developed.maps.iter().enumerate() {
            let of_tile = (0..self.sheets.len()).filter(|&i| self.sheets[i].tile == tile);
            let of_tile: Vec<usize> = of_tile.collect();
            let choice = |&i: &usize| {
                let weights = &self.energies.learned[i / self.layers.len()].weights;
                self.sheets[i].choice(&developed.seen[i], weights, &limits)
            };
            let choices: Vec<Choice<'_>> = of_tile.iter().map(choice).collect();
            let errors: Vec<&Image> = maps.iter().map(|[_, error]| error).collect();
            let nodes = worthwhile(&choices, &errors);
            for ((&i, choice), nodes) in of_tile.iter().zip(&choices).zip(nodes) {
                places[i] = self.sheets[i].places(&developed.seen[i], choice, nodes);
            }
        }
        places
    }
}

fn total(places: &[Vec<Place>]) -> usize {
    places.iter().map(Vec::len).sum()
}

/// Whether the budget allowed something that may have been stopped by it.
pub(crate) fn within_budget(result: Result<(), Stop>) -> Result<bool, MethodError> {
    match result {
        Ok(()) => Ok(true),
        Err(Stop::Budget) => Ok(false),
        Err(Stop::Failed(error)) => Err(error),
    }
}
