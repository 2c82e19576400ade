//! A mesh for the images of several similar emissions, whose rates at its points are related.
//!
//! Where a sample of the points shows that the rates are combinations of those of other emissions, the others
//! are calculated and not evaluated. The rendering compares its image with samples of the emission itself:
//! rates that are no such combinations show in its error estimate.

use crate::cube::Cube;
use crate::erased::AnyError;
use crate::error::RenderError;
use crate::exchange::Batch;
use crate::mesh::Mesh;
use crate::rendering::Rendering;
use crate::sweep::span::Span;
use crate::sweep::view::OfEmission;

/// At how many points, spread over all, calculated rates are compared. Products have hundreds or thousands of
/// points.
const COMPARED: usize = 64;

/// A mesh of products, and the rates of several emissions at its points.
pub(super) struct SharedMesh {
    mesh: Mesh<Cube>,
    rates: Vec<Vec<f64>>,
    /// The least error of an image with all of its own rates, over the square of the distance of its parameters: as
    /// the error of a mesh grows.
    growth: Option<f64>,
}

impl SharedMesh {
    /// A mesh, and the rates at its points of the emission that it was made of.
    pub(super) fn new(
        mesh: Mesh<Cube>,
        of: &mut OfEmission<'_>,
    ) -> Result<Self, RenderError<AnyError>> {
        let rates = vec![of.rates_at(mesh.batch())?];
        Ok(Self { mesh, rates, growth: None })
    }

    /// The number of points.
    pub(super) fn points(&self) -> u64 {
        self.mesh.points().len() as u64
    }

    /// The rendering of another emission by this mesh, with parameters at a distance from those of the mesh; `None` if
    /// it does not meet the tolerance with `most` evaluations.
    pub(super) fn rendered(
        &mut self,
        of: &mut OfEmission<'_>,
        distance: f64,
        most: u64,
    ) -> Result<Option<Rendering<Cube>>, RenderError<AnyError>> {
        if let Some(rates) = unless_interrupted(self.calculated(of))?.flatten() {
            let points = Batch { rates, ..self.mesh.batch().clone() };
            let assumed = of.known(|known| known.insert_new(&points));
            let found = of.at_points_of(&self.mesh, most);
            of.known(|known| known.remove(&assumed));
            if let Some(found) = found? {
                // Where the mesh itself is expected to have such an error, its other rates do not help.
                let expected = self.growth.map(|growth| growth * distance.powi(2));
                if found.converged()
                    || found.estimated_error().is_some_and(|of| Some(of) <= expected)
                {
                    return Ok(Some(found).filter(Rendering::converged));
                }
            }
        }
        let rates = unless_interrupted(of.rates_at(self.mesh.batch()))?;
        let Some(rates) = rates else { return Ok(None) };
        self.rates.push(rates);
        let found = of.at_points_of(&self.mesh, most)?;
        if let Some(error) = found.as_ref().and_then(Rendering::estimated_error)
            && distance > 0.0
        {
            let growth = error / distance.powi(2);
            self.growth = Some(self.growth.map_or(growth, |least| least.min(growth)));
        }
        Ok(found.filter(Rendering::converged))
    }

    /// All rates from those of a sample of the points, if these are combinations of others.
    fn calculated(
        &self,
        of: &mut OfEmission<'_>,
    ) -> Result<Option<Vec<f64>>, RenderError<AnyError>> {
        let points = self.mesh.batch();
        if points.len() < 4 * (COMPARED + self.rates.len()) {
            return Ok(None);
        }
        let span = Span::of(&self.rates);
        let sample = span.sample(points.len(), COMPARED);
        let rates = of.rates_at(&points.some(&sample))?;
        Ok(span.combined(&sample, &rates))
    }
}

/// `None` for any failure but an interruption: a rendering without the mesh shows whether it has the same.
pub(super) fn unless_interrupted<T, E>(
    result: Result<T, RenderError<E>>,
) -> Result<Option<T>, RenderError<E>> {
    match result {
        Ok(found) => Ok(Some(found)),
        Err(RenderError::Interrupted) => Err(RenderError::Interrupted),
        Err(_) => Ok(None),
    }
}
