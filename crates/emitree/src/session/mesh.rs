//! The frozen quadrature of a session: its method is repeated on known rates.

use super::course::{Course, State};
use super::{Kept, Session};
use crate::energy::EnergyAxis;
use crate::error::RenderError;
use crate::mesh::{Mesh, MeshError};
use crate::meter::{Limits, Meter};
use crate::options::RenderOptions;
use crate::projection::Projection;
use crate::values::Values;
use core::borrow::Borrow;
use core::convert::Infallible;
use std::sync::Arc;

impl<'a, V: Values> Session<'a, V> {
    /// The frozen quadrature of a session that has ended: a linear map from rates at its points to the
    /// values. The method is repeated on the stored rates, without a new evaluation, which takes as
    /// long as it took without g.
    ///
    /// # Errors
    ///
    /// [`MeshError`]: a session that has not ended; one that its time limit has ended, or may have changed; an
    /// image of found surfaces, which is not linear in the rates; one of a medium that absorbs.
    pub fn mesh(&self) -> Result<Mesh<V>, MeshError> {
        let State::Ended(ended) = &self.course.state else { return Err(MeshError::NotEnded) };
        if self.absorption.is_some() {
            return Err(MeshError::Absorption);
        }
        if let Some(frozen) = &ended.frozen {
            return Ok(Mesh::new(Arc::clone(frozen)));
        }
        if ended.surfaces.is_some() {
            return Err(MeshError::FoundSurfaces);
        }
        let Course { shape, limits, options, begins_with, .. } = &self.course;
        let limits = Limits { deadline: None, ..*limits };
        let meter = Meter::new(*shape, limits, self.known.clone(), false)
            .with_frozen_quadrature(u64::MAX)
            .with_start(begins_with.clone());
        let again = Course::begin(meter, &*self.start, *shape, options);
        // Without a time limit all points are known, and the values have the same bits.
        let again = again.map_err(|_| MeshError::TimeLimit)?;
        let State::Ended(again) = again.state else { return Err(MeshError::TimeLimit) };
        if !ended.cube.has_bits_of(&again.cube) {
            return Err(MeshError::TimeLimit);
        }
        again.frozen.map(Mesh::new).ok_or(MeshError::FoundSurfaces)
    }

    /// The mesh of a rendering from its [recorded rates](Mesh::recorded_rates), without g: it takes as long as that
    /// rendering took without g. `options` are those of the rendering, with its start; its time limit is ignored.
    ///
    /// ```
    /// use emitree::{Canonical, FromFn, Image, Projection, RenderOptions, Session, VolOptions, render};
    ///
    /// let glow = FromFn(|[x, y, z]: [f64; 3], _| (-9.0 * (x - 0.4).hypot(y - z)).exp());
    /// let options = RenderOptions::new(VolOptions::new(0.01)).with_mesh_up_to(1_000_000);
    /// let camera: &dyn Projection = &Canonical;
    /// let mesh = render(&glow, camera, [24, 32], &options)?.mesh.ok_or("a mesh")?;
    /// let rates = mesh.recorded_rates();
    /// let again = Session::<Image>::restored_mesh(camera, [24, 32], None, &options, rates)?;
    /// assert_eq!(again.points().positions(), mesh.points().positions());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`MeshError::Recorded`]: rates of another rendering; [`MeshError::FoundSurfaces`].
    pub fn restored_mesh<P: Borrow<dyn Projection + 'a> + Send + Sync + 'a>(
        projection: P,
        shape: [usize; 2],
        axis: Option<EnergyAxis>,
        options: &RenderOptions<'_>,
        recorded: &[f64],
    ) -> Result<Mesh<V>, MeshError> {
        let differs = MeshError::Recorded { number: recorded.len() };
        let mut options = options.clone();
        (options.max_seconds, options.mesh_up_to) = (f64::INFINITY, u64::MAX);
        let kept = Kept { rates: None, images: false, repeats: true, rows: None };
        let session: Result<Self, RenderError<Infallible>> =
            Self::start(projection, shape, axis, &options, kept, true);
        let mut session = session.map_err(|_| differs)?;
        let mut left = recorded;
        while let Some(number) = session.ask().map(|points| points.len()) {
            let (next, rest) = left.split_at_checked(number).ok_or(differs)?;
            session.tell(next).map_err(|_| differs)?;
            left = rest;
        }
        let rendering: Result<_, RenderError<Infallible>> = session.into_rendering();
        let rendering = rendering.map_err(|_| differs)?;
        if !left.is_empty() {
            return Err(differs);
        }
        rendering.mesh.ok_or(MeshError::FoundSurfaces)
    }
}
