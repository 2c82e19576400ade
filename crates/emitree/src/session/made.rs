//! What a session has made: its rendering, intermediate images, and what they cost.

use super::course::State;
use super::{Session, of_method};
use crate::error::RenderError;
use crate::mesh::Mesh;
use crate::meter::Shown;
use crate::output::{MethodOutput, Products};
use crate::progress::{Frame, FrameCallback};
use crate::rendering::{RenderStats, Rendering};
use crate::tree::StopReason;
use crate::values::Values;
use core::time::Duration;
use std::sync::Arc;

/// The cost of renderings.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Cost {
    pub(crate) evaluations: u64,
    pub(crate) absorption_evaluations: u64,
    pub(crate) batches: u64,
    pub(crate) emission_time: Duration,
    pub(crate) total_time: Duration,
}

impl<V: Values> Session<'_, V> {
    /// The rendering once it has ended; before that the latest image, with [`StopReason::Unfinished`], if
    /// the method has intermediate images (only [`Method::Vol`](crate::Method::Vol) has).
    pub fn rendering(&self) -> Option<Rendering<V>> {
        match &self.course.state {
            State::Ended(made) => Some(self.finished((**made).clone())),
            State::Waiting(_) | State::Failed(_) => {
                let [cube, error] = self.course.shown.last()?.maps.clone();
                Some(self.finished(MethodOutput::new(cube, Some(error), StopReason::Unfinished)))
            }
        }
    }

    /// The rendering of a session that has ended.
    pub(crate) fn into_rendering<E>(mut self) -> Result<Rendering<V>, RenderError<E>> {
        match core::mem::replace(&mut self.course.state, State::Failed(RenderError::Interrupted)) {
            State::Ended(made) => Ok(self.finished(*made)),
            State::Failed(error) => Err(of_method(error)),
            State::Waiting(_) => Err(RenderError::Interrupted),
        }
    }

    /// The products of a session that has ended, if it had to leave them.
    pub(crate) fn products(&self) -> Option<Arc<dyn Products>> {
        match &self.course.state {
            State::Ended(made) => made.products.clone(),
            State::Waiting(_) | State::Failed(_) => None,
        }
    }

    /// Passes on the intermediate images that have not been passed on yet.
    pub(crate) fn show_new_images<E>(
        &mut self,
        callback: Option<&FrameCallback<'_>>,
    ) -> Result<(), RenderError<E>> {
        let Some(callback) = callback else { return Ok(()) };
        for Shown { maps, evaluations, batches } in self.course.shown.drain(..) {
            let [image, error] = &maps.map(|cube| match &self.axis {
                Some(axis) => cube.sum_over_energy(axis),
                None => cube.into_first(),
            });
            if callback(&Frame { image, error, evaluations, batches }).is_break() {
                return Err(RenderError::Interrupted);
            }
        }
        Ok(())
    }

    /// Evaluations, batches and times so far, of all renderings of the session.
    pub(crate) fn cost(&self) -> Cost {
        Cost {
            evaluations: self.before.evaluations + self.course.meter.made_evaluations(),
            absorption_evaluations: self.before.absorption_evaluations
                + self.course.meter.absorption_evaluations(),
            batches: self.before.batches + self.course.meter.batches(),
            emission_time: self.before.emission_time + self.course.meter.emission_time(),
            total_time: self.before.total_time
                + self.course.took.unwrap_or_else(|| self.course.started.elapsed()),
        }
    }

    fn finished(&self, mut made: MethodOutput) -> Rendering<V> {
        if let Some(absorption) = &self.absorption {
            absorption.add_error(&mut made);
        }
        let cost = self.cost();
        let Cost { evaluations, absorption_evaluations, .. } = cost;
        let Cost { batches, emission_time, total_time, .. } = cost;
        let stats = RenderStats {
            evaluations,
            absorption_evaluations,
            evaluations_per_pixel: self.course.meter.evaluations_per_pixel(),
            batches,
            ending: made.ending,
            energies: made.energies,
            base_level: made.base_level,
            smallest_feature: made.smallest_feature,
            line_steps: made.line_steps,
            error_over_allowed: made.error_over_allowed,
            largest_rate: self.course.meter.largest_rate(),
            emission_time,
            total_time,
        };
        let (values, error) = (V::from_cube(made.cube), made.error.map(V::from_cube));
        let (lines, sums) = (made.lines, made.sums);
        let (tree, surfaces) = (made.tree, made.surfaces);
        // It would be one of g exp(−τ).
        let mesh = made.frozen.filter(|_| self.absorption.is_none()).map(Mesh::new);
        Rendering { values, error, lines, sums, stats, tree, surfaces, mesh }
    }
}
