//! Surfaces of a view: whether they are searched for, and the output.

use crate::cube::Cube;
use crate::energy::EnergyAxis;
use crate::exchange::MethodError;
use crate::meter::Meter;
use crate::output::MethodOutput;
use crate::tile::Tile;
use crate::tree::StopReason;
use crate::vol::VolOptions;
use crate::vol::engine::samples_wanted;
use crate::vol::lattice;
use crate::vol::lowrank::WeightedView;
use crate::vol::lowrank::attempted::Attempted;
use crate::vol::sampling::Stop;
use crate::vol::surfaces::attempt::attempt;
use crate::vol::surfaces::start::Request;
use crate::vol::tuning::TUNING;
use crate::vol::view::part::{Parts, parts as parts_of};
use crate::vol::view::scattered::{PartSamples, fraction_of_view, size_detected};
use std::sync::Arc;

/// The image of a view in which G jumps; `None` if it does not, or if surfaces do not give the image to
/// the tolerance. The scattered samples are added to those known.
pub(crate) async fn render(
    meter: &Meter,
    tiles: &[Tile<'_>],
    parts: &Parts<'_>,
    axis: Option<&EnergyAxis>,
    vol: &VolOptions,
    attempted: &mut Attempted,
) -> Result<Option<MethodOutput>, MethodError> {
    // Bodies hide a part of the lines of sight, but do not end the chart of the image plane.
    let has_charts = parts.parts.iter().any(|part| !part.footing.is_of_pixels());
    let is_divided = has_charts || parts.parts.len() > tiles.len();
    let plane = is_divided.then(|| parts_of(tiles, None, None));
    let [part] = &plane.as_ref().unwrap_or(parts).parts[..] else { return Ok(None) };
    let is_possible = attempted.has_jump
        && vol.is_uniform()
        && axis.is_none()
        && vol.seeds.is_empty()
        && vol.tolerance >= TUNING.surfaces.least_tolerance
        && part.footing.is_raster_of_pixels();
    if !is_possible {
        return Ok(None);
    }
    // Samples in charts are elsewhere.
    let samples = attempted.known.samples.first_mut().filter(|_| !is_divided);
    let chart = &*part.chart;
    let view = WeightedView { meter, part, tiles: tiles.len(), scaling: None };
    let density = |point: &[f64; 3]| chart.density([point[0], point[1]]);
    let weighted = samples.iter().flat_map(|of| of.points.iter().zip(&of.rates));
    let known: Vec<f64> = weighted.map(|(point, rate)| rate * density(point)).collect();
    let left = meter.evaluations_left() as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 2⁶⁴")]
    let most = (TUNING.surfaces.most_budget_share * left) as u64;
    let limbs = has_charts.then_some(parts);
    let tolerance = vol.tolerance.min(TUNING.engine.loosest_tolerance);
    let wanted = vol.smallest_feature.map(|size| fraction_of_view(size, tiles)).transpose()?;
    let least_samples = samples_wanted(vol, wanted.map(|size| part.least_feature * size));
    let scale = &part.scale;
    let request =
        Request { view: &view, scale, tolerance, most, known: &known, least_samples, limbs };
    let (found, rates) = match attempt(&request).await {
        Ok(found) => found,
        Err(Stop::Budget) => return Ok(None),
        Err(Stop::Failed(error)) => return Err(error),
    };
    if let Some(samples) = samples {
        let points = (0..rates.len()).map(lattice::point).collect::<Vec<_>>();
        *samples = PartSamples::of_probes(points.len(), &points, &rates, |xy| chart.density(xy));
    }
    let Some(found) = found else { return Ok(None) };
    let [cube, error] = [found.image, found.error].map(|mut map| {
        parts.outside.iter().for_each(|&pixel| map.pixels_mut()[pixel] = f64::NAN);
        Cube::from_bands(vec![map])
    });
    if meter.keeps_images() {
        meter.show([cube.clone(), error.clone()]);
    }
    let mut made = MethodOutput::new(cube, Some(error), StopReason::Complete);
    made.base_level = Some(vol.base_level);
    let passes = TUNING.lowrank.least_detected_rate;
    made.smallest_feature = Some(size_detected(found.samples, passes) / part.least_feature);
    made.surfaces = Some(Arc::new(found.surfaces));
    Ok(Some(made))
}
