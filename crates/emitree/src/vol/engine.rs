//! The loop: look, develop the image and its error, open what is worth it, until it is good enough.

use super::image_tree::{ImageTree, Place};
use super::opening::{Choice, worthwhile};
use super::round::Scan;
use super::seeds::Looks;
use super::shares::{Regions, Shares};
use super::sheet::{Seen, Sheet};
use super::sights::{Sights, Stop, View, Wanted};
use super::{BASE_LEVELS, VolOptions, whole};
use crate::emission::Emission;
use crate::error::RenderError;
use crate::image::Image;
use crate::meter::Meter;
use crate::projection::{Layer, Projection};
use crate::render::{Frame, RenderOptions, Rendering, Tile};
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
const COST_EXPONENT: f64 = 0.4;

/// The image that a camera sees, to the tolerance of `vol`.
pub(crate) fn render<E: Emission>(
    meter: &Meter<'_, E>,
    tiles: &[Tile<'_>],
    vol: &VolOptions,
    options: &RenderOptions<'_>,
) -> Result<Rendering, RenderError<E::Error>> {
    let layers: Vec<Vec<Box<dyn Layer + '_>>> =
        tiles.iter().map(|tile| tile.projection.layers()).collect();
    let visible = visible_layers(tiles, &layers);
    let sheets = visible.len() as u64;
    // Each of several tiles is a small part of the view, and finer in itself.
    let wanted_level = vol.base_level.saturating_sub(u8::from(tiles.len() > 1)).max(1);
    let base_level = affordable_base_level(vol, wanted_level, sheets, meter.evaluations_left())?;
    let asked = vol.tolerance.min(LOOSEST_TOLERANCE);
    let short = meter.evaluations_left() < SHORT_BUDGET * sheets * first_look(base_level);
    let finest_level = finest_level(tiles[0].shape, base_level);
    let mut engine = Engine {
        meter,
        tiles,
        sheets: Vec::new(),
        scales: tiles.iter().map(|p| radiance_per_density(p.projection, p.shape)).collect(),
        asked,
        tolerance: if short { LOOSEST_TOLERANCE } else { asked },
        line_share: LINE_SHARE,
        always: base_level + 1,
        finest_level,
    };
    let mut layers_of_tile = vec![0; tiles.len()];
    visible.iter().for_each(|layer| layers_of_tile[layer.tile] += 1);
    for Visible { tile, layer, shares } in visible {
        let scan = Scan {
            view: View { meter, layer, tile: tiles[tile].place },
            base_level,
            tree: ImageTree::default(),
            sights: Sights::default(),
            seeds: Looks::at(options.seeds, layer, base_level, finest_level),
            closes: false,
        };
        let (layers, scale) = (layers_of_tile[tile], &engine.scales[tile]);
        engine.sheets.push(Sheet::new(scan, tile, layers, shares, scale));
    }
    let (developed, ending) = engine.run(options)?;
    // The budget may end a search that has been stricter than what was asked for.
    let met = engine.has_seen(&developed)
        && developed.largest_error() <= vol.tolerance * developed.largest_pixel();
    // A base coarser than the one asked for has not looked where it was asked to.
    let ending = match ending {
        _ if base_level < wanted_level => Ending::Budget,
        _ if met => Ending::Complete,
        ending => ending,
    };
    let [image, error] = engine.finished(&developed);
    let mut rendering = Rendering::new(image, Some(error), ending);
    rendering.base_level = Some(base_level);
    Ok(rendering)
}

/// A layer that some pixels have a share of.
struct Visible<'a> {
    tile: usize,
    layer: &'a dyn Layer,
    shares: Option<Shares>,
}

/// The layers of all tiles, those of the first tile first, without what no pixel sees: the far side
/// of a body that fills the view, or the shadow of one that is on another tile.
fn visible_layers<'a>(
    tiles: &[Tile<'_>],
    layers: &'a [Vec<Box<dyn Layer + 'a>>],
) -> Vec<Visible<'a>> {
    let mut visible = Vec::new();
    for (number, (tile, layers)) in tiles.iter().zip(layers).enumerate() {
        let regions = Regions::of(tile.projection, tile.shape);
        for layer in layers {
            let layer: &dyn Layer = &**layer;
            let shares = regions.as_ref().map(|regions| Shares::new(layer, regions));
            if shares.as_ref().is_none_or(|shares| shares.reach.largest() > 0.0) {
                visible.push(Visible { tile: number, layer, shares });
            }
        }
    }
    visible
}

/// The base level wanted, or the finest one whose first look the budget allows.
fn affordable_base_level<E>(
    vol: &VolOptions,
    wanted: u8,
    sheets: u64,
    allowed: u64,
) -> Result<u8, RenderError<E>> {
    let option = |name, value: String, expected| Err(RenderError::Option { name, value, expected });
    if !(vol.tolerance > 0.0 && vol.tolerance < 1.0) {
        return option("tolerance", vol.tolerance.to_string(), "a fraction above 0 and below 1");
    }
    if !BASE_LEVELS.contains(&vol.base_level) {
        return option("base_level", vol.base_level.to_string(), "2 to 7");
    }
    let needed = |level| sheets * first_look(level);
    (1..=wanted).rev().find(|&level| needed(level) <= allowed).ok_or_else(|| {
        let what = "a first look at 3 x 3 lines in 3 depths".to_owned();
        RenderError::Budget { what, needed: needed(1), allowed }
    })
}

/// Evaluations of the base lattice.
fn first_look(base_level: u8) -> u64 {
    ((1_u64 << base_level) + 1).pow(3)
}

/// The deepest level of nodes that the pixels can be the better for.
fn finest_level([height, width]: [usize; 2], base_level: u8) -> u8 {
    let of_pixels = height.max(width).next_power_of_two().trailing_zeros() + BELOW_PIXEL_LEVELS;
    let least = FINE_ENOUGH_LEVEL.max(base_level + 2);
    u8::try_from(of_pixels).unwrap_or(FINEST_LEVEL).clamp(least, FINEST_LEVEL)
}

/// For each pixel, its radiance over the mean of the irradiance density on it; 0 where the projection
/// has no image.
fn radiance_per_density(projection: &dyn Projection, [height, width]: [usize; 2]) -> Image {
    let area = 1.0 / (height as f64 * width as f64);
    let mut scale = Image::zeros(height, width);
    for row in 0..height {
        // Borders as quotients, so that neighbours share them to the last bit.
        let y = [row, row + 1].map(|r| r as f64 / height as f64);
        for (column, scale) in scale.row_mut(row).iter_mut().enumerate() {
            let x = [column, column + 1].map(|c| c as f64 / width as f64);
            let solid_angle = projection.solid_angle([x[0], y[0]], [x[1], y[1]]);
            *scale = if solid_angle > 0.0 { area / solid_angle } else { 0.0 };
        }
    }
    scale
}

struct Engine<'a, 'b, E> {
    meter: &'b Meter<'a, E>,
    tiles: &'b [Tile<'b>],
    /// The layers of all tiles, those of the first tile first.
    sheets: Vec<Sheet<'b, E>>,
    /// For each tile, its radiances over means of the irradiance density.
    scales: Vec<Image>,
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
    /// Image and error of each tile.
    maps: Vec<[Image; 2]>,
    /// What each sheet has seen.
    seen: Vec<Seen>,
}

impl Developed {
    fn largest_pixel(&self) -> f64 {
        self.maps.iter().map(|[image, _]| image.largest()).fold(0.0, f64::max)
    }

    fn largest_error(&self) -> f64 {
        self.maps.iter().map(|[_, error]| error.largest()).fold(0.0, f64::max)
    }
}

impl<E: Emission> Engine<'_, '_, E> {
    fn run(
        &mut self,
        options: &RenderOptions<'_>,
    ) -> Result<(Developed, Ending), RenderError<E::Error>> {
        let mut within_budget = self.look_at_base()?;
        let mut developed = self.develop()?;
        // Lines that were refined by themselves: rules are cheaper.
        let nodes: usize = self.sheets.iter().map(|sheet| sheet.scan.tree.len()).sum();
        let mut cost_per_node = self.meter.evaluations() as f64 / nodes as f64;
        let mut halvings = 0;
        loop {
            let meter = self.meter;
            if let Some(callback) = options.frame {
                let [image, error] = &self.finished(&developed);
                let (evaluations, batches) = (meter.evaluations(), meter.batches());
                let frame = Frame { image, error, evaluations, batches };
                if let ControlFlow::Break(()) = callback(&frame) {
                    return Err(RenderError::Interrupted);
                }
            }
            let largest = developed.largest_pixel().max(CANCELLED * self.brightest());
            let met = |tolerance: f64| {
                self.has_seen(&developed) && developed.largest_error() <= STOP * tolerance * largest
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
            let mut places = self.choose(&developed, target);
            let count = total(&places);
            if count == 0 {
                if halvings == MOST_HALVINGS {
                    return Ok((developed, Ending::DeepestLevel));
                }
                halvings += 1;
                self.line_share *= 0.5;
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
            if self.look(&places, &developed, target)? {
                let spent = (meter.evaluations() - before) as f64;
                if looked > 0 {
                    cost_per_node = spent / looked as f64;
                }
            } else {
                // Fewer nodes may do, with what is left.
                cost_per_node *= TOO_DEAR;
                within_budget &= looked >= LEAST_ROUND;
            }
            developed = self.develop()?;
        }
    }

    /// The tolerance that the rest of the budget may reach.
    fn next_tolerance(&self) -> f64 {
        let (spent, left) = (self.meter.evaluations() as f64, self.meter.evaluations_left() as f64);
        let finer = ((spent + left) / spent).powf(-1.0 / COST_EXPONENT);
        // Half at the least: a smaller step would cost more than it brings.
        (self.tolerance * finer.min(0.5)).max(self.asked)
    }

    /// The largest ∫ |G| dz of a line.
    fn brightest(&self) -> f64 {
        self.sheets.iter().map(|sheet| sheet.scan.sights.brightest()).fold(0.0, f64::max)
    }

    /// The lines of the base lattice, each refined by itself; whether the budget allowed it.
    fn look_at_base(&mut self) -> Result<bool, RenderError<E::Error>> {
        let wanted = self.sheets.iter_mut().map(Sheet::add_base).collect();
        let looked = self.refine_base(wanted);
        for sheet in &mut self.sheets {
            sheet.settle();
            sheet.set_values();
        }
        within_budget(looked)
    }

    /// Refines all lines of the base, step by step: the tolerance follows the largest of them.
    fn refine_base(&mut self, mut wanted: Vec<Wanted>) -> Result<(), Stop<E::Error>> {
        let mut tolerance = f64::INFINITY;
        let mut seeded: Vec<Wanted> = self.sheets.iter().map(Sheet::seeded).collect();
        while wanted.iter().any(|wanted| !wanted.is_empty()) {
            for (sheet, wanted) in self.sheets.iter_mut().zip(&wanted) {
                let Scan { view, tree, sights, base_level, .. } = &mut sheet.scan;
                sights.sample(view, tree, wanted)?;
                sights.assess(wanted.iter().map(|(i, _)| *i), tolerance, *base_level);
            }
            let largest = self.sheets.iter().map(Sheet::largest_line).fold(0.0, f64::max);
            let largest = largest.max(CANCELLED * self.brightest());
            tolerance = self.line_share * self.tolerance * largest;
            let assess = |sheet: &mut Sheet<'_, E>| {
                let of_layer = tolerance / sheet.layers as f64;
                let Scan { tree, sights, base_level, .. } = &mut sheet.scan;
                sights.assess(0..tree.len(), of_layer, *base_level)
            };
            wanted = self.sheets.iter_mut().map(assess).collect();
            if wanted.iter().all(Vec::is_empty) {
                wanted = core::mem::take(&mut seeded);
            }
        }
        for sheet in &mut self.sheets {
            let found: Vec<usize> = (0..sheet.scan.tree.len()).collect();
            sheet.scan.follow(&found, tolerance / sheet.layers as f64)?;
        }
        Ok(())
    }

    /// The radiances of nodes at new `places` of each sheet; whether the budget allowed it.
    fn look(
        &mut self,
        places: &[Vec<Place>],
        developed: &Developed,
        target: f64,
    ) -> Result<bool, RenderError<E::Error>> {
        let mut allowed = true;
        for ((sheet, places), seen) in self.sheets.iter_mut().zip(places).zip(&developed.seen) {
            let tolerance = self.line_share * target / sheet.layers as f64;
            allowed &= within_budget(sheet.look(places, &seen.guarded, tolerance))?;
        }
        Ok(allowed)
    }

    /// Whether all that every rendering looks at has been looked at, and what seeds have named.
    fn has_seen(&self, developed: &Developed) -> bool {
        developed.seen.iter().all(|seen| seen.always_seen)
            && self.sheets.iter().all(|sheet| sheet.unseen_seeds().is_empty())
    }

    /// The image and its error, from what has been seen so far.
    fn develop(&self) -> Result<Developed, RenderError<E::Error>> {
        let empty = |tile: &Tile<'_>| {
            let [height, width] = tile.shape;
            [Image::zeros(height, width), Image::zeros(height, width)]
        };
        let mut maps: Vec<[Image; 2]> = self.tiles.iter().map(empty).collect();
        let mut seen = Vec::with_capacity(self.sheets.len());
        for sheet in &self.sheets {
            let [image, error] = &mut maps[sheet.tile];
            seen.push(sheet.develop(image, error, &self.scales[sheet.tile], self.always));
        }
        for (tile, [image, _]) in self.tiles.iter().zip(&maps) {
            tile.check_finite(image)?;
        }
        Ok(Developed { maps, seen })
    }

    /// The image and its error in one piece, and NaN where the projection has none.
    fn finished(&self, developed: &Developed) -> [Image; 2] {
        let of_kind = |kind: usize| {
            let mut map = Image::stacked(developed.maps.iter().map(|maps| &maps[kind]));
            let scales = self.scales.iter().flat_map(Image::pixels);
            for (pixel, scale) in map.pixels_mut().iter_mut().zip(scales) {
                if *scale == 0.0 {
                    *pixel = f64::NAN;
                }
            }
            map
        };
        [of_kind(0), of_kind(1)]
    }

    /// The places to be looked at next on each sheet, the most worthwhile first. The sheets of a tile
    /// compete for its error.
    fn choose(&self, developed: &Developed, target: f64) -> Vec<Vec<Place>> {
        let mut places = Vec::with_capacity(self.sheets.len());
        let sheets: Vec<_> = self.sheets.iter().zip(&developed.seen).collect();
        for of_tile in sheets.chunk_by(|a, b| a.0.tile == b.0.tile) {
            let choices: Vec<Choice<'_>> = of_tile
                .iter()
                .map(|&(sheet, seen)| {
                    let [_, error] = &developed.maps[sheet.tile];
                    sheet.choice(seen, error, target, self.finest_level, self.always)
                })
                .collect();
            let nodes = worthwhile(&choices);
            for ((&(sheet, seen), choice), nodes) in of_tile.iter().zip(&choices).zip(nodes) {
                places.push(sheet.places(seen, choice, nodes));
            }
        }
        places
    }
}

fn total(places: &[Vec<Place>]) -> usize {
    places.iter().map(Vec::len).sum()
}

/// Whether the budget allowed something that may have been stopped by it.
fn within_budget<E>(result: Result<(), Stop<E>>) -> Result<bool, RenderError<E>> {
    match result {
        Ok(()) => Ok(true),
        Err(Stop::Budget) => Ok(false),
        Err(Stop::Failed(error)) => Err(error),
    }
}
