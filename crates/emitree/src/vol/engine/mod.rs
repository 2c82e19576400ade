//! The engine: image trees of all layers and energies, refined until the tolerance is met.

mod current_image;
mod base;
pub(crate) mod coverage;
mod verification;
pub(crate) mod run;
mod spectra;

use crate::energy::EnergyAxis;
use crate::error::RenderError;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::meter::Meter;
use crate::output::MethodOutput;
use crate::projection::Layer;
use crate::radiance::radiance_per_density;
use crate::tile::Tile;
use crate::tree::StopReason;
use crate::vol::VolOptions;
use crate::vol::engine::coverage::Coverage;
use crate::vol::engine::spectra::Spectra;
use crate::vol::sampling::Stop;
use crate::vol::seeds::Seed;
use crate::vol::spectrum::energies::Energies;
use crate::vol::tuning::TUNING;
use crate::vol::view::scattered::{LayerSamples, fraction_of_view};
use crate::vol::view::sheet::{Sheet, SheetId};
use crate::vol::view::visible::{Visible, visible_layers};

/// The finest level of nodes: two levels are left for children and their neighbours.
const FINEST_LEVEL: u8 = 22;

/// Renders an image or a cube by image trees alone; `known` are samples of the first layer.
pub(crate) async fn by_tree(
    meter: &Meter,
    tiles: &[Tile<'_>],
    axis: Option<&EnergyAxis>,
    vol: &VolOptions,
    known: LayerSamples,
) -> Result<MethodOutput, MethodError> {
    let wanted = vol.smallest_feature.map(|size| fraction_of_view(size, tiles)).transpose()?;
    let layers: Vec<Vec<Box<dyn Layer + '_>>> =
        tiles.iter().map(|tile| tile.projection.layers()).collect();
    let mut scales: Vec<Image> =
        tiles.iter().map(|tile| radiance_per_density(tile.projection, tile.shape)).collect();
    let layers = visible_layers(tiles, &layers, &mut scales);
    meter.check_time()?;
    let sheets = layers.len() as u64;
    // Each of several tiles is a small part of the view, so that its base lattice is finer in the
    // view.
    let wanted_level = vol.base_level.saturating_sub(u8::from(tiles.len() > 1)).max(1);
    let base_level = affordable_base_level(wanted_level, sheets, meter.evaluations_left())?;
    let goal = vol.tolerance.min(TUNING.engine.loosest_tolerance);
    let short = meter.evaluations_left()
        < TUNING.engine.short_budget * sheets * base_evaluations(base_level);
    let mut engine = Engine {
        meter,
        tiles,
        layers,
        seeds: &vol.seeds,
        sheets: Vec::new(),
        energies: Energies::none(),
        spectra: axis.map(|axis| Spectra::new(axis, &vol.line_energies)),
        scales,
        requested: vol.tolerance,
        goal,
        evaluations_before: meter.evaluations(),
        verification_lines: 1,
        coverage: Coverage::new(wanted, known),
        tolerance: if short { TUNING.engine.loosest_tolerance } else { goal },
        line_share: TUNING.engine.line_share
            * (TUNING.engine.loosest_line_tolerance / goal).min(1.0),
        is_strict: false,
        base_level,
        required_level: base_level + 1,
        finest_level: finest_level(tiles[0].shape, base_level),
    };
    let (current, ending) = engine.run().await?;
    // A base lattice that is coarser than requested does not meet the request.
    let ending = if base_level < wanted_level { StopReason::Budget } else { ending };
    let [cube, error] = engine.finished(&current);
    let mut made = MethodOutput::new(cube, Some(error), ending);
    made.base_level = Some(base_level);
    made.energies = engine.energies_used();
    made.smallest_feature = engine.coverage.smallest;
    Ok(made)
}

/// The requested base level, or the finest one whose initial sampling the budget allows.
fn affordable_base_level(wanted: u8, sheets: u64, allowed: u64) -> Result<u8, MethodError> {
    let needed = |level| sheets * base_evaluations(level);
    (1..=wanted).rev().find(|&level| needed(level) <= allowed).ok_or_else(|| {
        let what = "the initial sampling of 3 x 3 lines in 3 depths".to_owned();
        RenderError::Budget { what, needed: needed(1), allowed }
    })
}

/// The number of evaluations on the base lattice.
pub(crate) fn base_evaluations(base_level: u8) -> u64 {
    ((1_u64 << base_level) + 1).pow(3)
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
    /// The layers of all tiles, in the order of the tiles.
    pub(crate) layers: Vec<Visible<'b>>,
    pub(crate) seeds: &'b [Seed],
    /// The image trees: all layers at the first energy, then all at the second, and so on.
    pub(crate) sheets: Vec<Sheet<'b>>,
    /// The energies of the sheets, and their weights in the bins.
    pub(crate) energies: Energies,
    /// The spectra from which energies are selected, if there is an energy axis.
    pub(crate) spectra: Option<Spectra<'b>>,
    /// For each tile and pixel, the ratio of its radiance to the mean of the irradiance density.
    pub(crate) scales: Vec<Image>,
    /// The requested tolerance, relative to the largest pixel.
    requested: f64,
    /// The tolerance at which refinement ends, which may be smaller than the requested one.
    goal: f64,
    /// The tolerance of the current stage.
    pub(crate) tolerance: f64,
    pub(crate) line_share: f64,
    /// Whether a verification has reduced the tolerance of lines.
    pub(crate) is_strict: bool,
    pub(crate) base_level: u8,
    /// The finest level whose nodes every rendering samples.
    pub(crate) required_level: u8,
    pub(crate) finest_level: u8,
    /// The number of evaluations before, by the search for a low-rank approximation.
    pub(crate) evaluations_before: u64,
    /// The factor on the usual number of lines in the next verification.
    pub(crate) verification_lines: usize,
    /// The scattered samples, and the size of the structure that they detect.
    pub(crate) coverage: Coverage,
}

impl Engine<'_> {
    /// The largest ∫ |G| dz of a line.
    pub(crate) fn brightest(&self) -> f64 {
        self.sheets.iter().map(|sheet| sheet.scan.node_lines.brightest()).fold(0.0, f64::max)
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
            let SheetId { layer, energy } = sheet.id;
            let of_layer: Vec<&Sheet<'_>> =
                earlier.iter().filter(|earlier| earlier.id.layer == layer).collect();
            let amounts = self.energies.selected.get(energy).map(|one| &one.of_earlier[..]);
            sheet.set_values(&of_layer, amounts.unwrap_or_default());
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
