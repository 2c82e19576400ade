//! A mesh: the frozen quadrature of a rendering, a linear map from rates to an image.
//!
//! A session that has ended has found where g has to be evaluated and with which weights. A [`Mesh`] is this
//! knowledge without the rates: points, the weights of their rates at nodes, and the map from nodes to
//! pixels. Rates of another emission at the same points give its image without a new search.
//!
//! * `frozen`: what a method leaves for a mesh;
//! * `sparse`: the weights;
//! * `matrix`: the whole map as one matrix;
//! * `start`: what renderings of other emissions begin with.

pub(crate) mod frozen;
mod matrix;
mod sparse;
pub(crate) mod start;

pub use sparse::SparseMatrix;

use crate::emission::Samples;
use crate::exchange::Batch;
use crate::image::Image;
use crate::mesh::frozen::Frozen;
use crate::mesh::start::Start;
use crate::values::Values;
use core::marker::PhantomData;
use std::sync::Arc;

/// The frozen quadrature of a rendering: points, and a linear map from the rates of g there to an image or a
/// cube.
///
/// With the rates of its own emission it returns the values of the rendering, to rounding. For another
/// emission it is as good as the same points and weights are for that one, and gives no error estimate;
/// [`RenderOptions::with_fixed_mesh`](crate::RenderOptions::with_fixed_mesh) does, but for `paper`:
///
/// * `los` and `paper`: lines and cells are those that the first emission needed;
/// * `vol` with image trees: so are lines, depths and depth rules; with energies so are the selected
///   energies and their functions;
/// * `vol` with products: g is taken to be in the span of the functions found, G(x, y, z) = Σ aᵢ(x) bⱼ(y)
///   cₖ(z) G(xᵢ, yⱼ, zₖ). The same model with other parameters often is, to the tolerance. The points are the
///   pivots (xᵢ, yⱼ, zₖ) alone, of a cube those at each selected energy.
///
/// Values at pixels without an image are NaN, as in the rendering. Made by
/// [`Session::mesh`](crate::Session::mesh), or with the [`Rendering`](crate::Rendering) itself.
///
/// ```
/// use emitree::{Canonical, FromFn, Image, Projection, RenderOptions, Session, VolOptions};
///
/// let glow = |[x, y, z]: [f64; 3]| (-9.0 * (x - 0.4).hypot(y - z)).exp();
/// let camera: &dyn Projection = &Canonical;
/// let options = RenderOptions::new(VolOptions::new(0.01));
/// let mut session = Session::<Image>::new(camera, [24, 32], &options)?;
/// while !session.is_done() {
///     session.step(&FromFn(|position, _| glow(position)))?;
/// }
/// let mesh = session.mesh()?;
/// // Another emission at the same points: twice as bright.
/// let rates: Vec<f64> = mesh.points().positions().iter().map(|&at| 2.0 * glow(at)).collect();
/// let twice = mesh.apply(&rates)?;
/// let once = session.rendering().ok_or("an image")?.values;
/// let expected = Image::from_pixels(24, 32, once.pixels().iter().map(|pixel| 2.0 * pixel).collect());
/// assert!(twice.max_difference(&expected) < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Mesh<V = Image> {
    frozen: Arc<Frozen>,
    values: PhantomData<fn() -> V>,
}

impl<V> Mesh<V> {
    pub(crate) fn new(frozen: Arc<Frozen>) -> Self {
        Self { frozen, values: PhantomData }
    }

    /// The same map to values of another type.
    pub(crate) fn retyped<W>(self) -> Mesh<W> {
        Mesh::new(self.frozen)
    }

    /// Whether renderings of other emissions can begin with the mesh, or be fixed to it: all meshes but those of
    /// method `paper`, with which [`RenderOptions::with_start`](crate::RenderOptions::with_start) has no effect.
    pub fn serves_as_start(&self) -> bool {
        self.frozen.structure.is_some()
    }

    /// Whether it has products for some part of the view: their points are far fewer than those of a rendering.
    pub(crate) fn has_products(&self) -> bool {
        self.frozen.structure.as_ref().is_some_and(|structure| structure.has_products)
    }

    /// All rates that its rendering has asked for, in the unit of g and in the order of the requests:
    /// [`Session::restored_mesh`](crate::Session::restored_mesh) makes the mesh from them again, without g.
    pub fn recorded_rates(&self) -> &[f64] {
        &self.frozen.recorded
    }

    /// The points, without rates.
    pub(crate) fn batch(&self) -> &Batch {
        &self.frozen.points
    }

    /// The start of a rendering with the structure of the mesh.
    pub(crate) fn start(&self, is_fixed: bool) -> Start {
        Start { structure: self.frozen.structure.clone(), is_fixed }
    }
}

impl<V: Values> Mesh<V> {
    /// The points at which rates are needed: positions in the scene's length unit, unit vectors of emission,
    /// and energies in the unit of the axis if there is one. No point is there twice.
    pub fn points(&self) -> Samples<'_> {
        self.frozen.points.samples()
    }

    /// The weights of the rates in the values at nodes: a row for each node, a column for each point. A node
    /// is a line of sight (`los`, and `vol` with image trees), a cell (`paper`) or a triple of pivots
    /// (`vol` with products), and its value the rate integrated along it or averaged over it, in the unit of
    /// g times a length where there is an integral.
    pub fn weights(&self) -> &SparseMatrix {
        &self.frozen.weights
    }

    /// The image, or the cube, for one rate at each of the [`points`](Self::points), in their order and in
    /// the unit of g: linear in the rates, to rounding.
    ///
    /// # Errors
    ///
    /// [`MeshError::Rates`]: a number of rates other than that of the points.
    pub fn apply(&self, rates: &[f64]) -> Result<V, MeshError> {
        let expected = self.frozen.points.len();
        if rates.len() != expected {
            return Err(MeshError::Rates { number: rates.len(), expected });
        }
        Ok(V::from_cube(self.frozen.cube(rates)))
    }

    /// The whole map as one matrix: a row for each pixel, row after row of the image (of a cube, band after
    /// band), a column for each point. Rows of pixels without an image are empty.
    ///
    /// [`apply`](Self::apply) takes the time and the memory of an image, this matrix those of an image for
    /// each node, and each pixel has weights for all points of the lines around it: it is for small images.
    ///
    /// ```
    /// use emitree::{Canonical, Image, Method, RenderOptions, Session, tree::BuildOptions};
    ///
    /// let options = RenderOptions::new(Method::Paper(BuildOptions::default()));
    /// let mut session = Session::<Image>::new(&Canonical as &dyn emitree::Projection, [4, 6], &options)?;
    /// while let Some(points) = session.ask() {
    ///     session.tell(&vec![2.0; points.len()])?;
    /// }
    /// let matrix = session.mesh()?.matrix();
    /// // Each pixel is a mean over 1 unit of length.
    /// assert!((matrix.row(5).map(|(_, weight)| weight).sum::<f64>() - 1.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn matrix(&self) -> SparseMatrix {
        matrix::matrix(&self.frozen)
    }
}

/// Why there is no mesh, or no image of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The session has not ended, or it has failed.
    #[error("the session has no mesh before its rendering has ended")]
    NotEnded,
    /// The rendering can't be repeated without new evaluations.
    #[error(
        "the session has no mesh: what it did depends on its time limit; expected no `max_seconds`"
    )]
    TimeLimit,
    /// The image is that of found surfaces.
    #[error(
        "the session has no mesh: its image is that of surfaces at which g jumps, and their places do \
         not depend on the rates linearly"
    )]
    FoundSurfaces,
    /// The medium absorbs.
    #[error(
        "the session has no mesh: the medium absorbs, and the image is not linear in the rates and the \
         absorption coefficients"
    )]
    Absorption,
    /// Recorded rates that are not those of this rendering.
    #[error(
        "{number} recorded rates are not those of a rendering with this camera and these options: expected \
         rates of the same version on a machine with the same rounding"
    )]
    Recorded {
        /// The number of rates given.
        number: usize,
    },
    /// The number of rates is not that of the points.
    #[error("{number} rates were given: expected {expected}, one for each point of the mesh")]
    Rates {
        /// The number of rates given.
        number: usize,
        /// The number of points.
        expected: usize,
    },
}
