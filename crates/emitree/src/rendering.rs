//! The result of a rendering: an image or a cube, its estimated error, and its cost.

use crate::cube::Cube;
use crate::found_surfaces::FoundSurfaces;
use crate::image::Image;
use crate::line_values::LineValues;
use crate::mesh::Mesh;
use crate::sums::RegionSum;
use crate::tally::EvaluationCounts;
use crate::tree::{SparseTree, StopReason};
use crate::values::Values;
use core::time::Duration;
use std::sync::Arc;

/// An image or a cube, its estimated error, and its cost.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Rendering<V = Image> {
    /// Radiance, F(Ω)/Ω in each pixel: the unit of g times the length unit of the scene. Of a cube the
    /// radiance per unit of energy, the mean over each pixel and energy bin.
    pub values: V,
    /// The estimated |error| of each value, in the same unit, if the method has one.
    ///
    /// `Vol`: the estimate that is compared with the tolerance. `Paper`: the change by the last
    /// generation of cells. Adaptive `Los`: the error along the lines, without that of too few lines for
    /// a pixel. Fixed steps have no estimate.
    pub error: Option<V>,
    /// The radiances of the lines that [`VolOptions::with_lines`](crate::VolOptions::with_lines) names; `None`
    /// without such lines, and of cubes and views of several tiles.
    pub lines: Option<LineValues>,
    /// The sums over regions that [`VolOptions::sums`](crate::VolOptions::sums) asks for, in that order.
    pub sums: Vec<RegionSum>,
    /// Its cost, and why it ended.
    pub stats: RenderStats,
    /// The tree that was built, if the method builds one, and one only.
    pub tree: Option<RenderedTree>,
    /// The surfaces at which g jumps, if the image is made of found surfaces: only of
    /// [`Method::Vol`](crate::Method::Vol), where it has found them and uses them. `None` does not mean that g
    /// has no jumps: an image tree may have followed them, or products may represent them.
    pub surfaces: Option<Arc<FoundSurfaces>>,
    /// The frozen quadrature, if [`RenderOptions::with_mesh_up_to`](crate::RenderOptions::with_mesh_up_to)
    /// asks for it and there is one: images of found surfaces, and of media that absorb, have none.
    pub mesh: Option<Mesh<V>>,
}

/// The cost of a rendering, and why it ended.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RenderStats {
    /// How often g was evaluated.
    pub evaluations: u64,
    /// How often the absorption coefficient was evaluated, which `evaluations` does not include; 0 for a medium
    /// that does not absorb.
    pub absorption_evaluations: u64,
    /// How many samples are on the lines of sight of each pixel, at all energies: those of the values
    /// that were returned.
    pub evaluations_per_pixel: EvaluationCounts,
    /// The number of batches of evaluations: one for each refinement step.
    pub batches: u64,
    /// Why the rendering ended.
    pub ending: StopReason,
    /// The energies at which g was integrated along lines of sight, ascending, in the unit of the
    /// energy axis; none without one, or if the method has a tree along the energy axis too.
    pub energies: Vec<f64>,
    /// The base level that was used, if the method has one: [`Method::Vol`](crate::Method::Vol) takes
    /// a coarser one than requested if the budget does not suffice, and has not converged then.
    pub base_level: Option<u8>,
    /// The standard deviation of the smallest Gaussian that would have been detected with a probability
    /// of 99 %, as a fraction of the edge of the view's cube, if its peak in the image is
    /// [`FEATURE_CONTRAST`](crate::vol::FEATURE_CONTRAST) times the tolerance; only of
    /// [`Method::Vol`](crate::Method::Vol).
    pub smallest_feature: Option<f64>,
    /// The uniform steps of lines of sight on a lattice of pixels, where
    /// [time is minimized](crate::vol::Minimize::Time) and the image is made of such lines; `None` otherwise.
    pub line_steps: Option<usize>,
    /// The largest estimated |error| of a value over the error that is allowed there: at most 1 if the
    /// tolerance is met; only of [`Method::Vol`](crate::Method::Vol).
    pub error_over_allowed: Option<f64>,
    /// The largest |rate| of all evaluations, the first one if there are several; `None` if all are 0. If the
    /// image does not converge, g may be [singular](crate::projection::Singularity) there.
    pub largest_rate: Option<RateAt>,
    /// Time spent in g, and in the absorption coefficient, of one thread.
    pub emission_time: Duration,
    /// The total time.
    pub total_time: Duration,
}

/// A rate and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateAt {
    /// The rate, in the unit of g.
    pub rate: f64,
    /// The position, in the length unit of the scene.
    pub position: [f64; 3],
}

/// The tree behind an image.
#[derive(Clone, Debug)]
pub struct RenderedTree {
    /// The canonical integrand g · ds/dz · dΩ/(dx dy) as a tree.
    pub tree: SparseTree<3>,
    /// The threshold of the last step, in the unit of g as in [`Method::Paper`](crate::Method::Paper).
    pub threshold: f64,
}

impl From<Rendering> for Rendering<Cube> {
    /// A cube of one band.
    fn from(of_image: Rendering) -> Self {
        let Rendering { values, error, lines, sums, stats, tree, surfaces, mesh } = of_image;
        let of_one = |image| Cube::from_bands(vec![image]);
        let (values, error) = (of_one(values), error.map(of_one));
        let mesh = mesh.map(Mesh::retyped);
        Self { values, error, lines, sums, stats, tree, surfaces, mesh }
    }
}

impl<V: Values> Rendering<V> {
    /// Whether the stopping criterion was met; `false` if a limit ended the rendering before.
    pub fn converged(&self) -> bool {
        self.stats.ending == StopReason::Complete
    }

    /// The largest estimated |error| of a value over the largest |value|.
    pub fn estimated_error(&self) -> Option<f64> {
        let error = self.error.as_ref()?.largest();
        Some(if error > 0.0 { error / self.values.largest() } else { 0.0 })
    }
}
