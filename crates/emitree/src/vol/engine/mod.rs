//! The engine: image trees of all parts and energies, refined until the tolerance is met.

mod current_image;
mod base;
mod borders;
pub(crate) mod first_energy;
pub(crate) mod coverage;
mod verification;
pub(crate) mod run;
mod spectra;
mod start;

use crate::energy::EnergyAxis;
use crate::error::{OptionError, RenderError};
use crate::exchange::MethodError;
use crate::image::Image;
use crate::line_values::LineValues;
use crate::mesh::frozen::Frozen;
use crate::mesh::start::Structure;
use crate::meter::Meter;
use crate::output::MethodOutput;
use crate::tile::Tile;
use crate::tree::StopReason;
use crate::vol::VolOptions;
use crate::vol::dyadic::unit;
use crate::vol::engine::coverage::Coverage;
use crate::vol::engine::current_image::CurrentImage;
use crate::vol::engine::first_energy::{EnergySearch, FirstEnergy, Hit};
use crate::vol::engine::run::Beginning;
use crate::vol::engine::spectra::Spectra;
use crate::vol::image::pixels::pixel_means;
use crate::vol::lattice::points_to_detect;
use crate::vol::sampling::Stop;
use crate::vol::spectrum::energies::Energies;
use crate::vol::tuning::TUNING;
use crate::vol::view::frozen::FrozenView;
use crate::vol::view::lines::{FunctionOfPart, LinesInView};
use crate::vol::view::part::{Footing, Part, Parts, ProductImage, add};
use crate::vol::view::scattered::{KnownParts, PartSamples, fraction_of_view};
use crate::vol::view::sheet::{Sheet, SheetId};
use crate::vol::view::tree_start::{SheetStart, TreeStart};
use std::sync::Arc;

/// The finest level of nodes: two levels are left for children and their neighbours.
const FINEST_LEVEL: u8 = 22;

/// The base level of the smallest possible sampling: 3 x 3 lines in 3 depths.
pub(crate) const COARSEST_LEVEL: u8 = 1;

/// What is known before trees begin.
#[derive(Default)]
pub(crate) struct BeforeTrees<'a> {
    /// Those of another emission.
    pub(crate) start: Option<&'a TreeStart>,
    /// The first energy of a cube.
    pub(crate) first: Option<FirstEnergy>,
    /// Whether products were searched for there, which has shown whether G jumps.
    pub(crate) is_searched: bool,
}

/// Image trees that have begun, of a view without other images than those of products.
pub(crate) struct Trees<'a> {
    engine: Engine<'a>,
    beginning: Beginning<'a>,
}

impl<'a> Trees<'a> {
    /// The base lattice sampled at the first energy, unless the trees begin with those of another emission; `known` is what
    /// products have found.
    pub(crate) async fn begin(
        meter: &'a Meter,
        tiles: &'a [Tile<'a>],
        view: &'a Parts<'a>,
        axis: Option<&'a EnergyAxis>,
        vol: &'a VolOptions,
        known: KnownParts,
        before: BeforeTrees<'a>,
    ) -> Result<Self, MethodError> {
        let BeforeTrees { start, first, .. } = before;
        let parts = &view.parts[..];
        let is_fixed = meter.start().is_some_and(|start| start.is_fixed);
        let start = start.filter(|start| start.is_of(&known.products));
        if is_fixed && start.is_none() {
            return Err(OptionError::FixedMesh.into());
        }
        let wanted = vol.smallest_feature.map(|size| fraction_of_view(size, tiles)).transpose()?;
        meter.check_time()?;
        let base_level = affordable_base_level(parts, vol.base_level, meter.evaluations_left())?;
        let goal = vol.tolerance.min(TUNING.engine.loosest_tolerance);
        let short = meter.evaluations_left()
            < TUNING.engine.short_budget * base_evaluations_of(parts, base_level);
        let of_first = first.as_ref().map_or(0, |first| first.evaluations);
        let mut engine = Engine {
            meter,
            tiles,
            view,
            parts,
            footings: parts.iter().map(|part| part.footing.clone()).collect(),
            quadrature_error: None,
            of_exam: 0.0,
            vol,
            sheets: Vec::new(),
            energies: Energies::none(),
            spectra: axis.map(|axis| Spectra::new(axis, &vol.line_energies)),
            first_hits: Vec::new(),
            requested: vol.tolerance,
            goal,
            evaluations_before: meter.evaluations() - of_first,
            verification_lines: 1,
            coverage: Coverage::new(wanted, known.smallest, known.samples),
            products: known.products,
            done: None,
            largest_done: known.largest,
            tolerance: if short { TUNING.engine.loosest_tolerance } else { goal },
            line_share: TUNING.engine.line_share
                * (TUNING.engine.loosest_line_tolerance / goal).min(1.0),
            is_strict: false,
            is_fixed: false,
            base_level,
            finest_level: finest_level(tiles[0].shape, base_level),
        };
        engine.add_products();
        let beginning = match start {
            Some(start) if is_fixed => Beginning::FixedTrees(start),
            Some(start) => Beginning::Trees(start),
            None => {
                let first = match (first, axis) {
                    (None, Some(axis)) => {
                        let search = EnergySearch::new(meter, tiles, parts, axis, vol);
                        Some(search.run(base_level).await?)
                    }
                    (first, _) => first,
                };
                Beginning::Samples(engine.sample_initially(first).await?)
            }
        };
        Ok(Self { engine, beginning })
    }

    /// The first energy, a place of the axis, if G jumps there on many of the base lines of a part, or if g differs at
    /// few points from the rest of the view.
    pub(crate) fn energy_of_jumps(&self) -> Option<u32> {
        let Beginning::Samples(first) = &self.beginning else { return None };
        let is_sampled =
            first.within_budget && self.engine.base_level == self.engine.vol.base_level;
        let may_jump = || self.have_jumps() || !self.engine.first_hits.is_empty();
        first.energy.filter(|_| is_sampled && may_jump())
    }

    /// Unit vectors along the lines that have been sampled, away from the observer, and their |integrals| times the density
    /// of solid angle.
    pub(crate) fn brightness(&self) -> Vec<([f64; 3], f64)> {
        self.engine.sheets.iter().flat_map(Sheet::brightness).collect()
    }

    /// The points of each part at which g differs from most of the view, at the first energy.
    pub(crate) fn first_hits(&self) -> Vec<PartSamples> {
        let of_part = |part: usize| {
            let own = self.engine.first_hits.iter().filter(|hit| hit.point.part == part);
            let both = own.map(|Hit { point, rate }| {
                let [x, y] = point.place.map(unit);
                ([x, y, unit(point.depth)], *rate)
            });
            let (points, rates) = both.unzip();
            PartSamples { number: 0, points, rates }
        };
        (0..self.engine.parts.len()).map(of_part).collect()
    }

    /// Whether G jumps on many of the base lines of a part.
    pub(crate) fn have_jumps(&self) -> bool {
        let Beginning::Samples(first) = &self.beginning else { return false };
        first.within_budget
            && self.engine.sheets.iter().any(|sheet| sheet.jumps_on(TUNING.view.rough_share))
    }

    /// Leaves evaluations out of those of the trees.
    pub(crate) fn leave_out(&mut self, evaluations: u64) {
        self.engine.evaluations_before += evaluations;
    }

    /// Refines the trees until the tolerance is met.
    pub(crate) async fn finish(self) -> Result<MethodOutput, MethodError> {
        let Self { mut engine, beginning } = self;
        let (current, ending) = engine.run(beginning).await?;
        // A base lattice that is coarser than requested does not meet the request.
        let is_coarse = engine.base_level < engine.vol.base_level;
        let ending = if is_coarse { StopReason::Budget } else { ending };
        let [cube, error] = engine.finished(&current);
        let mut made = MethodOutput::new(cube, Some(error), ending);
        made.base_level = Some(engine.base_level);
        made.energies = engine.energies_used();
        made.lines = engine.lines();
        made.smallest_feature = engine.coverage.smallest;
        made.frozen = engine.meter.freezes().then(|| {
            let mut frozen = engine.frozen();
            frozen.structure = Some(Structure::new(Arc::new(engine.start()), false));
            Arc::new(frozen)
        });
        Ok(made)
    }
}

/// The requested base level, or the finest one whose initial sampling the budget allows.
pub(crate) fn affordable_base_level(
    parts: &[Part<'_>],
    wanted: u8,
    allowed: u64,
) -> Result<u8, MethodError> {
    let needed = |level| base_evaluations_of(parts, level);
    (COARSEST_LEVEL..=wanted).rev().find(|&level| needed(level) <= allowed).ok_or_else(|| {
        let what = "the initial sampling of 3 x 3 lines in 3 depths".to_owned();
        RenderError::Budget { what, needed: needed(COARSEST_LEVEL), allowed }
    })
}

/// The number of evaluations on the base lattices of all parts.
pub(crate) fn base_evaluations_of(parts: &[Part<'_>], base_level: u8) -> u64 {
    parts.iter().map(|part| base_evaluations(part.base_level(base_level))).sum()
}

/// The number of evaluations on the base lattice.
pub(crate) fn base_evaluations(base_level: u8) -> u64 {
    ((1_u64 << base_level) + 1).pow(3)
}

/// The number of scattered samples that the options require, for features of this size as a fraction of the part's cube: a
/// base lattice that is finer than the default is requested for small structure, too.
pub(crate) fn samples_wanted(vol: &VolOptions, feature: Option<f64>) -> usize {
    let is_fine = vol.base_level > VolOptions::default().base_level;
    let of_base = if is_fine { base_evaluations(vol.base_level) } else { 0 };
    let of_base = usize::try_from(of_base).unwrap_or(usize::MAX);
    let detected = TUNING.verification.detection_share;
    feature.map_or(0, |size| points_to_detect(size, detected)).max(of_base)
}

/// The finest level of nodes that can improve the pixels.
pub(crate) fn finest_level([height, width]: [usize; 2], base_level: u8) -> u8 {
    let of_pixels =
        height.max(width).next_power_of_two().trailing_zeros() + TUNING.engine.below_pixel_levels;
    let least = TUNING.engine.fine_enough_level.max(base_level + 2);
    u8::try_from(of_pixels).unwrap_or(FINEST_LEVEL).clamp(least, FINEST_LEVEL)
}

pub(crate) struct Engine<'b> {
    pub(crate) meter: &'b Meter,
    pub(crate) tiles: &'b [Tile<'b>],
    view: &'b Parts<'b>,
    /// The parts of the view.
    pub(crate) parts: &'b [Part<'b>],
    /// Where the parts are in the image, with the present quadrature of pixels.
    footings: Vec<Arc<Footing>>,
    /// The error of that quadrature, once it has been compared with a finer one.
    pub(crate) quadrature_error: Option<Image>,
    /// The weighted error of all pixels that lines of the verification of a fixed mesh have shown.
    of_exam: f64,
    pub(crate) vol: &'b VolOptions,
    /// The image trees: all parts at the first energy, then all at the second, and so on.
    pub(crate) sheets: Vec<Sheet<'b>>,
    /// The energies of the sheets, and their weights in the bins.
    pub(crate) energies: Energies,
    /// The spectra from which energies are selected, if there is an energy axis.
    pub(crate) spectra: Option<Spectra<'b>>,
    /// The few points at which g differs from most of the view at the first energy.
    first_hits: Vec<Hit>,
    /// The requested tolerance, relative to the largest pixel.
    requested: f64,
    /// The tolerance at which refinement ends, which may be smaller than the requested one.
    goal: f64,
    /// The tolerance of the current stage.
    pub(crate) tolerance: f64,
    pub(crate) line_share: f64,
    /// Whether a verification has reduced the tolerance of lines.
    pub(crate) is_strict: bool,
    /// Whether nodes and energies are those of another emission, and none is added.
    is_fixed: bool,
    pub(crate) base_level: u8,
    pub(crate) finest_level: u8,
    /// The number of evaluations before, by the search for a low-rank approximation.
    pub(crate) evaluations_before: u64,
    /// The factor on the usual number of lines in the next verification.
    pub(crate) verification_lines: usize,
    /// The image of each part by products: it has no tree.
    pub(crate) products: Vec<Option<ProductImage>>,
    /// The sum of the images of these parts, and of their errors.
    done: Option<[Image; 2]>,
    /// The largest |pixel| of one of them.
    pub(crate) largest_done: f64,
    /// The scattered samples, and the size of the structure that they detect.
    pub(crate) coverage: Coverage,
}

impl Engine<'_> {
    /// Height and width of the image.
    pub(crate) fn shape(&self) -> [usize; 2] {
        self.tiles[0].shape_of_image()
    }

    /// The radiances of the lines that the options name, if there is one tile and no energy.
    fn lines(&self) -> Option<LineValues> {
        let places = self.vol.lines.as_ref().filter(|_| self.spectra.is_none())?;
        let largest =
            self.largest_done.max(self.sheets.iter().map(Sheet::largest_line).fold(0.0, f64::max));
        let of_part = |(number, part): (usize, &Part<'_>)| match &self.products[number] {
            Some(product) => Some(FunctionOfPart::of_products(product, &part.scale)),
            None => {
                self.sheets.iter().find(|of| of.id.part == number).map(Sheet::function_of_lines)
            }
        };
        let functions: Option<Vec<_>> = self.parts.iter().enumerate().map(of_part).collect();
        let lines = LinesInView::new(self.view, places);
        Some(match functions {
            Some(functions) => lines.values(&functions, self.requested * largest),
            None => LineValues::unknown(places.len()),
        })
    }

    /// Makes the image of the parts that have products.
    fn add_products(&mut self) {
        let mut done = None;
        for ((footing, product), part) in self.footings.iter().zip(&self.products).zip(self.parts) {
            if let Some(product) = product {
                add(&mut done, footing.maps_of_product(product, &part.scale));
            }
        }
        self.done = done;
    }

    /// Compares the quadrature of pixels with a finer one, and replaces it where they differ by more
    /// than a small share of `target`. Returns whether that has changed anything.
    pub(crate) fn settle_quadrature(&mut self, current: &CurrentImage, target: f64) -> bool {
        if self.quadrature_error.is_some() {
            return false;
        }
        let brightness = |bin: &usize| current.maps[*bin][0].largest();
        let bins = 0..current.maps.len();
        let brightest = bins.max_by(|a, b| brightness(a).total_cmp(&brightness(b))).unwrap_or(0);
        let means = |number: usize, shape @ [rows, columns]: [usize; 2]| {
            if let Some(product) = &self.products[number] {
                return product.function.means(shape);
            }
            let mut sum = vec![0.0; rows * columns];
            for sheet in self.sheets.iter().filter(|sheet| sheet.id.part == number) {
                let weight = self.energies.selected[sheet.id.energy].weights[brightest];
                let means = pixel_means(&sheet.scan.tree, shape);
                sum.iter_mut().zip(means).for_each(|(sum, mean)| *sum += weight * mean);
            }
            sum
        };
        let allowed = TUNING.view.quadrature_share * target;
        let weights = current.largest_weights();
        let Some((footings, error)) = self.view.settle(&means, allowed, weights.as_ref()) else {
            return false;
        };
        for sheet in &mut self.sheets {
            sheet.footing = footings[sheet.id.part].clone();
        }
        self.footings = footings;
        self.quadrature_error = Some(error);
        self.add_products();
        true
    }

    /// The frozen quadrature of the current image.
    fn frozen(&self) -> Frozen {
        let mut frozen = FrozenView::new(&self.view.outside);
        let products = self.products.iter().zip(self.parts).zip(&self.footings);
        for ((product, part), footing) in products {
            let product = product.as_ref().and_then(|product| product.frozen.as_ref());
            product.iter().for_each(|of| frozen.add_products(of, part, footing, &[1.0]));
        }
        for sheet in &self.sheets {
            let energy = &self.energies.selected[sheet.id.energy];
            frozen.add_sheet(sheet, &energy.of_earlier, &energy.weights);
        }
        let bins = self.energies.selected[0].weights.len();
        let [height, width] = self.shape();
        frozen.finish([bins, height, width])
    }

    /// What the trees leave for renderings of other emissions.
    fn start(&self) -> TreeStart {
        TreeStart {
            axis: self.spectra.as_ref().map(|spectra| *spectra.axis()),
            energies: self.energies.clone(),
            sheets: self.sheets.iter().map(SheetStart::of).collect(),
        }
    }

    /// The largest ∫ |G| dz of a line.
    pub(crate) fn brightest(&self) -> f64 {
        let of_sheets = self.sheets.iter().map(|sheet| sheet.scan.node_lines.brightest());
        of_sheets.fold(self.largest_done, f64::max)
    }

    /// The tolerance of a line at each energy for an error of `target` in a pixel. All energies
    /// have equal shares in the bins where their weights are largest.
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

    /// Sets the values of the sheets from number `first` on, in the order of the energies.
    pub(crate) fn set_values(&mut self, first: usize) {
        for i in first..self.sheets.len() {
            let (earlier, rest) = self.sheets.split_at_mut(i);
            let sheet = &mut rest[0];
            let SheetId { part, energy } = sheet.id;
            let of_part: Vec<&Sheet<'_>> =
                earlier.iter().filter(|earlier| earlier.id.part == part).collect();
            let amounts = self.energies.selected.get(energy).map(|one| &one.of_earlier[..]);
            sheet.set_values(&of_part, amounts.unwrap_or_default());
        }
    }
}

/// Whether the budget sufficed for an operation.
pub(crate) fn within_budget(result: Result<(), Stop>) -> Result<bool, MethodError> {
    match result {
        Ok(()) => Ok(true),
        Err(Stop::Budget) => Ok(false),
        Err(Stop::Failed(error)) => Err(error),
    }
}

#[cfg(test)]
mod tests;
