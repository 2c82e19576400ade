//! One emission in one view: renderings of it that share all rates, and their cost together.

use crate::absorption;
use crate::calls::Calls;
use crate::checks::limits;
use crate::cube::Cube;
use crate::energy::EnergyAxis;
use crate::erased::{AnyEmission, AnyError};
use crate::error::RenderError;
use crate::exchange::Batch;
use crate::known::KnownRates;
use crate::mesh::Mesh;
use crate::meter::Meter;
use crate::options::{Method, RenderOptions};
use crate::progress::Progress;
use crate::projection::Projection;
use crate::rendering::{RenderStats, Rendering};
use crate::session::{Cost, Kept, Session};
use std::sync::{Arc, Mutex, PoisonError};

/// The most evaluations with which an image leaves a mesh.
const MESH_UP_TO: u64 = 1_000_000;

/// The rates of an emission, if they are stored, and the cost of all its renderings.
#[derive(Clone, Debug, Default)]
pub(super) struct Spent {
    rates: Arc<Mutex<KnownRates>>,
    cost: Cost,
}

impl Spent {
    pub(super) fn evaluations(&self) -> u64 {
        self.cost.evaluations
    }

    fn add(&mut self, cost: Cost) {
        self.cost.evaluations += cost.evaluations;
        self.cost.absorption_evaluations += cost.absorption_evaluations;
        self.cost.batches += cost.batches;
        self.cost.emission_time += cost.emission_time;
        self.cost.total_time += cost.total_time;
    }

    /// The cost of all renderings instead of that of the last one.
    pub(super) fn write(&self, stats: &mut RenderStats) {
        stats.evaluations = self.cost.evaluations;
        stats.absorption_evaluations = self.cost.absorption_evaluations;
        stats.batches = self.cost.batches;
        stats.emission_time = self.cost.emission_time;
        stats.total_time = self.cost.total_time;
    }
}

/// How images are rendered.
#[derive(Clone, Copy)]
pub(super) struct View<'a> {
    pub(super) projection: &'a dyn Projection,
    pub(super) shape: [usize; 2],
    pub(super) axis: Option<&'a EnergyAxis>,
    pub(super) options: &'a RenderOptions<'a>,
}

impl View<'_> {
    /// Whether images of other emissions may begin with the mesh of one.
    pub(super) fn has_meshes(&self) -> bool {
        self.axis.is_none() && matches!(self.options.method, Method::Vol(_))
    }

    /// The tolerance of a finer mesh, as options; none if the error is not relative to the largest pixel.
    pub(super) fn finer(&self, share: f64) -> Option<RenderOptions<'_>> {
        let Method::Vol(vol) = &self.options.method else { return None };
        if vol.by_pixel.is_some() || !vol.sums.is_empty() {
            return None;
        }
        let mut vol = vol.clone();
        vol.tolerance *= share;
        Some(RenderOptions { method: Method::Vol(vol), ..self.options.clone() })
    }
}

/// A rendering, and the number of rates that it requested, known or not.
pub(super) struct Found {
    pub(super) rendering: Rendering<Cube>,
    pub(super) requested: u64,
}

/// An emission in a view; `before` are the evaluations of the sweep before it, for progress.
pub(super) struct OfEmission<'a> {
    pub(super) emission: &'a AnyEmission<'a>,
    pub(super) view: View<'a>,
    pub(super) spent: &'a mut Spent,
    pub(super) before: u64,
}

impl OfEmission<'_> {
    /// The rendering with these options; `None` if it takes more than `most` evaluations, besides the stored rates.
    pub(super) fn rendered(
        &mut self,
        options: &RenderOptions<'_>,
        most: u64,
    ) -> Result<Option<Found>, RenderError<AnyError>> {
        let View { projection, shape, axis, .. } = self.view;
        let before = self.before + self.spent.evaluations();
        let given = options.progress;
        let progress = |evaluations| match given {
            Some(progress) => progress(before + evaluations),
            None => core::ops::ControlFlow::Continue(()),
        };
        // A mesh would be one of g exp(−τ), and τ that of each emission.
        let has_meshes = self.view.has_meshes() && !self.emission.absorbs();
        let rates = has_meshes.then(|| Arc::clone(&self.spent.rates));
        let options = match self.emission.absorbs() {
            true => absorption::of_method(options),
            false => options.clone(),
        };
        let options = RenderOptions {
            frame: None,
            progress: None,
            rounds: None,
            mesh_up_to: if has_meshes { MESH_UP_TO } else { 0 },
            ..options
        };
        let kept = Kept { rates, images: false, repeats: false, rows: None };
        let whole_batches = self.emission.takes_whole_batches();
        let mut session: Session<'_, Cube> =
            Session::start(projection, shape, axis.copied(), &options, kept, whole_batches)?;
        let mut failure = None;
        let is_within = |session: &Session<'_, Cube>| {
            let next = session.ask().map_or(0, |points| points.len() as u64);
            session.cost().evaluations + next <= most
        };
        while failure.is_none() && !session.is_done() && is_within(&session) {
            let progress: &Progress<'_> = &progress;
            failure = session.evaluate(self.emission, Some(progress)).err();
        }
        self.spent.add(session.cost());
        let requested = session.requested();
        match failure {
            Some(error) => Err(error),
            None if !session.is_done() => Ok(None),
            None => session.into_rendering().map(|rendering| Some(Found { rendering, requested })),
        }
    }

    /// The rendering at exactly the points of a mesh, which may not meet the tolerance; `None` if it takes more than
    /// `most` evaluations.
    pub(super) fn at_points_of(
        &mut self,
        mesh: &Mesh<Cube>,
        most: u64,
    ) -> Result<Option<Rendering<Cube>>, RenderError<AnyError>> {
        let options = self.view.options.clone().with_fixed_mesh(mesh);
        match self.rendered(&options, most) {
            Ok(found) => Ok(found.map(|found| found.rendering)),
            // Whatever else fails at these points need not in a rendering of its own.
            Err(RenderError::Interrupted) => Err(RenderError::Interrupted),
            Err(_) => Ok(None),
        }
    }

    /// The rates at some points; those that are not stored are evaluated.
    pub(super) fn rates_at(&mut self, points: &Batch) -> Result<Vec<f64>, RenderError<AnyError>> {
        let mut unknown = self.known(|rates| rates.unknown(points));
        let limits = limits(self.view.options, self.emission.takes_whole_batches(), true);
        let meter = Meter::new(self.view.shape, limits, None, false);
        if unknown.len() > 0 {
            Calls::new(self.emission, &meter, None).evaluate(&mut unknown)?;
            let (evaluations, emission_time) = (meter.new_evaluations(), meter.emission_time());
            self.spent.add(Cost {
                evaluations,
                absorption_evaluations: 0,
                batches: 1,
                emission_time,
                total_time: emission_time,
            });
            self.known(|rates| rates.insert(&unknown));
        }
        let mut all = Batch { rates: vec![0.0; points.len()], ..points.clone() };
        self.known(|rates| rates.fill(&mut all));
        Ok(all.rates)
    }

    /// Calls a function of the stored rates.
    pub(super) fn known<T>(&self, of: impl FnOnce(&mut KnownRates) -> T) -> T {
        of(&mut self.spent.rates.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
