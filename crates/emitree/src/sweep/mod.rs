//! Sweeps: the images of one model for many values of its parameters, with fewer evaluations than one by one.
//!
//! The image in the middle is rendered in full. If it is made of [products](crate::mesh::Mesh), its points,
//! chosen to a quarter of the tolerance, serve the images around it as far as samples of each show that they
//! do; then the next full rendering follows. Where the rates at these points are combinations of those of
//! former values, as a sample shows, most are calculated. Each image has its own error estimate, from samples
//! of its own emission.
//!
//! * `order`: which image comes next, with which mesh;
//! * `span`: rates as combinations of others;
//! * `view`: renderings of one emission, which share its rates;
//! * `shared`: a mesh for several emissions.

mod order;
mod shared;
mod span;
mod view;

use crate::cube::Cube;
use crate::emission::Emission;
use crate::energy::EnergyAxis;
use crate::erased::{AnyEmission, AnyError, Erased, typed};
use crate::error::RenderError;
use crate::mesh::Mesh;
use crate::options::RenderOptions;
use crate::projection::Projection;
use crate::rendering::Rendering;
use order::{Next, Order};
use shared::{SharedMesh, unless_interrupted};
use std::collections::BTreeMap;
use view::{Found, OfEmission, Spent, View};

/// The tolerance of meshes relative to that of the images: at a quarter the mesh of a torus serves three times
/// as many values, for a tenth to a third more evaluations.
const FINER: f64 = 0.25;
/// The most evaluations of such a mesh beyond those of its image, in these.
const MOST_OF_FINER: f64 = 0.5;

/// The images of one model for many values of its parameters, in progress.
///
/// The caller gives the emission of each image when its [`step`](Self::step) comes.
///
/// ```
/// use emitree::{Canonical, Emission, FromFn, RenderOptions, VolOptions, sweep::Sweep};
///
/// let ball = |width: f64| {
///     FromFn(move |at: [f64; 3], _| (-at.map(|x| (x - 0.5).powi(2)).iter().sum::<f64>() / width.powi(2)).exp())
/// };
/// let widths = [0.2, 0.21, 0.22];
/// let options = RenderOptions::new(VolOptions::new(0.01));
/// let mut sweep = Sweep::new(&widths.map(|width| vec![width]));
/// while let Some(number) = sweep.next_image() {
///     let found = sweep.step(&ball(widths[number]), &Canonical, [16, 16], None, &options)?;
///     // None: another image is rendered first.
///     assert!(found.is_none_or(|rendering| rendering.converged()));
/// }
/// println!("{} evaluations", sweep.evaluations());
/// # Ok::<(), emitree::RenderError<std::convert::Infallible>>(())
/// ```
pub struct Sweep {
    order: Order,
    meshes: Vec<SharedMesh>,
    /// The emissions that were evaluated and whose images remain.
    spent: BTreeMap<usize, Spent>,
    /// The share of the requests of an image in full that are not repeated, of the last one of which no rate was stored:
    /// a rendering alone evaluates so many.
    share_alone: f64,
}

impl Sweep {
    /// A sweep of images with these values of the parameters: for each image as many numbers, in any unit. The
    /// distance of two images is that of their values relative to the whole range of each parameter.
    ///
    /// # Panics
    ///
    /// If two images have different numbers of values.
    pub fn new(values: &[Vec<f64>]) -> Self {
        let is_like_first =
            |of: &Vec<f64>| values.first().is_some_and(|first| first.len() == of.len());
        assert!(values.iter().all(is_like_first), "as many values for each image");
        let (meshes, spent) = (Vec::new(), BTreeMap::new());
        Self { order: Order::new(values), meshes, spent, share_alone: 1.0 }
    }

    /// The number of the image whose emission the next [`step`](Self::step) takes; `None` at the end.
    pub fn next_image(&self) -> Option<usize> {
        self.order.next().map(Next::image)
    }

    /// How often g was evaluated for all images so far.
    pub fn evaluations(&self) -> u64 {
        self.order.evaluations()
    }

    /// Renders the image of [`next_image`](Self::next_image) from a camera, of `shape` = \[height, width\]
    /// pixels, with the bins of an energy axis if there is one; images without are cubes of one band. Cubes, and
    /// other methods than [`Method::Vol`](crate::Method::Vol), are rendered one by one.
    ///
    /// `None` if the points of another image do not suffice: then it comes again after others. The
    /// evaluations of a rendering are all those of its emission. Of the options the limits are those of one
    /// rendering, `progress` receives the evaluations of all images so far, and `frame` has no effect.
    ///
    /// # Errors
    ///
    /// As [`render`](crate::render()); this image is left out then, and the sweep can go on.
    pub fn step<E: Emission>(
        &mut self,
        emission: &E,
        projection: &dyn Projection,
        shape: [usize; 2],
        axis: Option<&EnergyAxis>,
        options: &RenderOptions<'_>,
    ) -> Result<Option<Rendering<Cube>>, RenderError<E::Error>> {
        self.step_of_any(&Erased(emission), View { projection, shape, axis, options })
            .map_err(typed)
    }

    /// The next image, of an emission of any type.
    fn step_of_any(
        &mut self,
        emission: &AnyEmission<'_>,
        view: View<'_>,
    ) -> Result<Option<Rendering<Cube>>, RenderError<AnyError>> {
        let Some(next) = self.order.next() else { return Ok(None) };
        let image = next.image();
        let mut spent = self.spent.remove(&image).unwrap_or_default();
        let before = spent.evaluations();
        let mut of = OfEmission {
            emission,
            view,
            before: self.order.evaluations() - before,
            spent: &mut spent,
        };
        let found = match next {
            Next::InFull(_) => self.in_full(image, &mut of).map(Some),
            Next::ByMesh { mesh, most, .. } => {
                let distance = self.order.distance_from(mesh, image);
                self.meshes[mesh].rendered(&mut of, distance, most)
            }
        };
        self.order.count(spent.evaluations() - before);
        match (found, next) {
            (Ok(None), Next::ByMesh { mesh, .. }) => {
                self.order.failed(image, mesh);
                self.spent.insert(image, spent);
                Ok(None)
            }
            (found, _) => {
                self.order.done(image);
                let mut found = found?;
                if let Some(rendering) = &mut found {
                    spent.write(&mut rendering.stats);
                }
                Ok(found)
            }
        }
    }

    /// The image without a mesh; its points become the mesh of those around it.
    fn in_full(
        &mut self,
        image: usize,
        of: &mut OfEmission<'_>,
    ) -> Result<Rendering<Cube>, RenderError<AnyError>> {
        let before = of.spent.evaluations();
        let found = of.rendered(of.view.options, u64::MAX)?;
        let Found { rendering: mut found, requested: of_image } =
            found.ok_or(RenderError::Interrupted)?;
        let new = of.spent.evaluations() - before;
        if before == 0 && of_image > 0 {
            self.share_alone = new as f64 / of_image as f64;
        }
        self.order.rendered_in_full(self.share_alone * of_image as f64);
        let mesh = found.mesh.take().filter(|mesh| found.converged() && mesh.has_products());
        let Some(mesh) = mesh.filter(|_| self.order.remaining() > 1) else { return Ok(found) };
        let mesh = self.finer(of, of_image, new)?.unwrap_or(mesh);
        if let Some(shared) = unless_interrupted(SharedMesh::new(mesh, of))? {
            self.order.add_mesh(image, shared.points());
            self.meshes.push(shared);
        }
        Ok(found)
    }

    /// The mesh of the same image to a finer tolerance, if that is affordable.
    fn finer(
        &self,
        of: &mut OfEmission<'_>,
        of_image: u64,
        new: u64,
    ) -> Result<Option<Mesh<Cube>>, RenderError<AnyError>> {
        let view = of.view;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a bound")]
        let more = (MOST_OF_FINER * of_image as f64) as u64;
        let is_affordable = self.order.allowance(1) >= new + more;
        let Some(options) = view.finer(FINER).filter(|_| is_affordable) else {
            return Ok(None);
        };
        let found = unless_interrupted(of.rendered(&options, more))?.flatten();
        let found = found.map(|found| found.rendering).filter(Rendering::converged);
        Ok(found.and_then(|found| found.mesh).filter(Mesh::has_products))
    }
}

impl core::fmt::Debug for Sweep {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Sweep")
            .field("remaining", &self.order.remaining())
            .field("evaluations", &self.order.evaluations())
            .finish_non_exhaustive()
    }
}
