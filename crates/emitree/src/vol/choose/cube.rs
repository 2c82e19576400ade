//! The products of a cube, from its first energy on.

use crate::energy::EnergyAxis;
use crate::exchange::MethodError;
use crate::tree::StopReason;
use crate::vol::engine::first_energy::FirstEnergy;
use crate::vol::lowrank::attempted::{Attempted, FoundCube};
use crate::vol::lowrank::channel::{ChannelTarget, CubeView};
use crate::vol::lowrank::start::Start;
use crate::vol::lowrank::{self, Probed};
use crate::vol::spectrum::bins::Bins;

/// The search for products at the first energy, with the cube in the place of its image if products give it to the
/// tolerance; nothing if they are not searched for. With a start the cube is made of its functions.
pub(super) async fn of_products(
    view: &CubeView<'_>,
    axis: &EnergyAxis,
    first: Option<&FirstEnergy>,
    probed: Vec<Probed>,
    start: Option<&Start>,
) -> Result<Attempted, MethodError> {
    let mut of_cube = Attempted::none(view.parts);
    if let Some(start) = start {
        let Some(start) = &start.cube else { return Ok(of_cube) };
        let is_fixed = view.meter.start().is_some_and(|start| start.is_fixed);
        if !is_fixed && !lowrank::cube::is_possible(view.vol) {
            of_cube.functions_suffice = false;
            return Ok(of_cube);
        }
        let found = lowrank::cube::cube_by_functions(view, axis, start).await?;
        let is_complete = |of: &FoundCube| of.output.ending == StopReason::Complete;
        of_cube.functions_suffice = is_fixed || found.as_ref().is_some_and(is_complete);
        of_cube.take_cube(found);
        return Ok(of_cube);
    }
    let Some(first) = first.filter(|_| lowrank::cube::is_possible(view.vol)) else {
        return Ok(of_cube);
    };
    let target = ChannelTarget {
        energy: first.place,
        tolerance: lowrank::cube::first_tolerance(view.vol),
        least_largest: 0.0,
        is_further: false,
    };
    let mut attempted = view.attempt(&Bins::new(axis), target, None, probed).await?;
    if attempted.divides() {
        return Ok(attempted.division_alone(view.parts));
    }
    of_cube.has_jump = attempted.has_jump;
    let samples = core::mem::take(&mut attempted.known.samples);
    of_cube.of_first = samples.iter().any(|of| of.number > 0).then_some(samples);
    if attempted.found.as_ref().is_some_and(|of| of.ending == StopReason::Complete) {
        of_cube.take_cube(lowrank::cube::attempt_cube(view, axis, first.place, attempted).await?);
    }
    Ok(of_cube)
}
