//! Surfaces of a view: whether they are searched for, and the output.

use crate::cube::Cube;
use crate::energy::EnergyAxis;
use crate::exchange::MethodError;
use crate::found_surfaces::FoundSurfaces;
use crate::image::Image;
use crate::meter::Meter;
use crate::output::MethodOutput;
use crate::tile::Tile;
use crate::tree::StopReason;
use crate::vol::VolOptions;
use crate::vol::dyadic::unit;
use crate::vol::engine::samples_wanted;
use crate::vol::lattice;
use crate::vol::lowrank::WeightedView;
use crate::vol::sampling::Stop;
use crate::vol::spectrum::bins::Bins;
use crate::vol::surfaces::attempt::attempt;
use crate::vol::surfaces::cube::attempt_cube;
use crate::vol::surfaces::hits::{hits, in_chart, known_in_chart};
use crate::vol::surfaces::lines_of_sight::LinesOfSight;
use crate::vol::surfaces::sky::known_rates;
use crate::vol::surfaces::start::Request;
use crate::vol::tuning::TUNING;
use crate::vol::view::part::{Part, Parts};
use crate::vol::view::scattered::{KnownParts, PartSamples, fraction_of_view, size_detected};
use std::sync::Arc;

/// The image of a view in which G jumps; `None` if surfaces do not give the image to the tolerance. The scattered
/// samples are added to those known.
pub(crate) async fn render(
    meter: &Meter,
    tiles: &[Tile<'_>],
    parts: &Parts<'_>,
    vol: &VolOptions,
    known: &mut KnownParts,
) -> Result<Option<MethodOutput>, MethodError> {
    if !is_possible(vol) {
        return Ok(None);
    }
    let Some(lines) = LinesOfSight::new(tiles, parts, &known_rates(parts, &known.samples)) else {
        return Ok(None);
    };
    let Some(part) = lines.part(tiles, parts) else { return Ok(None) };
    let part = &part;
    let hits = match lines.are_of_parts() && known.hits.is_empty() {
        true => Vec::new(),
        false => hits(&known_in_chart(part, parts, known)),
    };
    // Samples in charts are elsewhere.
    let samples = known.samples.first_mut().filter(|_| lines.are_of_parts());
    let view = WeightedView::new(meter, part, tiles.len());
    let known: Vec<f64> = samples.iter().flat_map(|of| of.rates.iter().copied()).collect();
    let request =
        Request { known: &known, hits: &hits, ..request(&view, &lines, tiles, parts, vol)? };
    let (found, rates) = match attempt(&request).await {
        Ok(found) => found,
        Err(Stop::Budget) => return Ok(None),
        Err(Stop::Failed(error)) => return Err(error),
    };
    if let Some(samples) = samples {
        let points = (0..rates.len()).map(lattice::point).collect::<Vec<_>>();
        *samples = PartSamples { number: points.len(), points, rates };
    }
    // G jumps somewhere, which samples of an image without surfaces have missed.
    let Some(found) = found.filter(|found| !found.surfaces.positions.is_empty()) else {
        return Ok(None);
    };
    let maps = vec![[found.image, found.error]];
    let mut made = output(meter, parts, part, vol, maps, found.samples, found.surfaces);
    made.lines = found.lines;
    Ok(Some(made))
}

/// What is known of a view at the first energy.
pub(crate) struct FirstImage {
    /// The place on the axis.
    pub(crate) energy: u32,
    /// Unit vectors along some lines, away from the observer, and their |integrals| times the density of solid angle.
    pub(crate) brightness: Vec<([f64; 3], f64)>,
    /// The few points of each part at which g differs from most of the view.
    pub(crate) hits: Vec<PartSamples>,
    /// Scattered samples of each part, if they are known.
    pub(crate) samples: Vec<PartSamples>,
}

/// The cube of a view in which G jumps at the first energy; `None` if surfaces do not give the cube to the tolerance.
pub(crate) async fn render_cube(
    meter: &Meter,
    tiles: &[Tile<'_>],
    parts: &Parts<'_>,
    axis: &EnergyAxis,
    first: &FirstImage,
    vol: &VolOptions,
) -> Result<Option<MethodOutput>, MethodError> {
    if !is_possible(vol) {
        return Ok(None);
    }
    let of_samples = [&first.hits, &first.samples].map(|of| known_rates(parts, of)).concat();
    let brightness = [&first.brightness[..], &of_samples].concat();
    let Some(lines) = LinesOfSight::new(tiles, parts, &brightness) else { return Ok(None) };
    let Some(part) = lines.part(tiles, parts) else { return Ok(None) };
    let part = &part;
    let bins = Bins::new(axis);
    let energies = [(bins.sample_at(first.energy), 1.0)];
    let view = WeightedView { energies: &energies, ..WeightedView::new(meter, part, tiles.len()) };
    let of_first = in_chart(part, parts, &first.hits);
    let mut all: Vec<_> = of_first.iter().map(|of| (of.at, of.of_path)).collect();
    if !lines.are_of_parts() {
        all.extend(hits(&in_chart(part, parts, &first.samples)));
    }
    let request = Request { hits: &all, ..request(&view, &lines, tiles, parts, vol)? };
    let found = match attempt_cube(&request, bins, first.energy, &vol.line_energies).await {
        Ok(found) => found,
        Err(Stop::Budget) => return Ok(None),
        Err(Stop::Failed(error)) => return Err(error),
    };
    let Some(found) = found else { return Ok(None) };
    let mut made = output(meter, parts, part, vol, found.maps, found.samples, found.surfaces);
    made.energies = found.energies.into_iter().map(|place| axis.energy(unit(place))).collect();
    made.energies.sort_by(f64::total_cmp);
    Ok(Some(made))
}

/// Whether surfaces are searched for with these options.
pub(super) fn is_possible(vol: &VolOptions) -> bool {
    vol.is_uniform() && vol.seeds.is_empty() && vol.tolerance >= TUNING.surfaces.least_tolerance
}

/// A request without known samples.
fn request<'a>(
    view: &'a WeightedView<'a>,
    seen: &'a LinesOfSight<'a>,
    tiles: &[Tile<'_>],
    parts: &'a Parts<'a>,
    vol: &'a VolOptions,
) -> Result<Request<'a>, MethodError> {
    let left = view.meter.evaluations_left() as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 2⁶⁴")]
    let most = (TUNING.surfaces.most_budget_share * left) as u64;
    let wanted = vol.smallest_feature.map(|size| fraction_of_view(size, tiles)).transpose()?;
    let of_options = samples_wanted(vol, wanted.map(|size| view.part.least_feature * size));
    // Image trees have a base lattice for each tile, which detects more than the samples of one chart.
    let of_tiles =
        if tiles.len() > 1 { tiles.len() * TUNING.surfaces.scattered_of_tile } else { 0 };
    let least_samples = of_options.max(of_tiles);
    Ok(Request {
        view,
        scale: &view.part.scale,
        tolerance: vol.tolerance.min(TUNING.engine.loosest_tolerance),
        most,
        known: &[],
        hits: &[],
        least_samples,
        limbs: seen.limbs(parts),
        lines: vol.lines.as_deref(),
        sky: seen.sky.as_ref(),
        plane: seen.plane(parts).map(|of| &*of.chart),
    })
}

/// The output of images with their errors, of so many scattered samples.
fn output(
    meter: &Meter,
    parts: &Parts<'_>,
    part: &Part<'_>,
    vol: &VolOptions,
    maps: Vec<[Image; 2]>,
    samples: usize,
    surfaces: FoundSurfaces,
) -> MethodOutput {
    let (mut images, mut errors) = (Vec::new(), Vec::new());
    for mut of_band in maps {
        for map in &mut of_band {
            parts.outside.iter().for_each(|&pixel| map.pixels_mut()[pixel] = f64::NAN);
        }
        let [image, error] = of_band;
        images.push(image);
        errors.push(error);
    }
    let [cube, error] = [images, errors].map(Cube::from_bands);
    if meter.keeps_images() {
        meter.show([cube.clone(), error.clone()]);
    }
    let mut made = MethodOutput::new(cube, Some(error), StopReason::Complete);
    made.base_level = Some(vol.base_level);
    let passes = TUNING.lowrank.least_detected_rate;
    made.smallest_feature = Some(size_detected(samples, passes) / part.least_feature);
    made.surfaces = Some(Arc::new(surfaces));
    made
}
