//! Surfaces at which g jumps, as a result of a rendering.

/// The surfaces at which g jumps, as far as they were found: triangles, in world coordinates.
///
/// The arrays `positions`, `normals`, `jumps` and `uncertainties` have one element for each vertex. The
/// vertices are on the surfaces that the image is made of, about as far from each other as the cells of a
/// lattice in the view are wide; on a curved surface, triangles are beside it by as much as chords are beside
/// an arc. Two surfaces that are nearer to each other than a cell is wide may have one vertex in common.
/// Surfaces end at the borders of a view that is one image plane, and up to a cell before those of other views and
/// before lines on which three regions meet.
///
/// Where [`Bounds`](crate::projection::Bounds) end the emission there is no surface, as g itself need not jump
/// there; nor within a cell of the lines of sight that touch them.
///
/// ```
/// use emitree::{Canonical, FromFn, RenderOptions, VolOptions, render};
///
/// // A ball of radius 0.3 whose rate is 2, in a rate of 0.5.
/// let centre = [0.5, 0.52, 0.49];
/// let distance = |at: [f64; 3]| (0..3).map(|k| (at[k] - centre[k]).powi(2)).sum::<f64>().sqrt();
/// let ball = FromFn(|at: [f64; 3], _| if distance(at) < 0.3 { 2.0 } else { 0.5 });
/// let options = RenderOptions::new(VolOptions::new(0.01));
///
/// let found = render(&ball, &Canonical, [32, 32], &options)?.surfaces.ok_or("surfaces")?;
/// let vertices = found.positions.iter().zip(&found.uncertainties);
/// let near = vertices.filter(|(at, expected)| (distance(**at) - 0.3).abs() < 2.0 * **expected);
/// assert!(near.count() as f64 > 0.9 * found.len() as f64);
/// assert!(found.jumps.iter().all(|jump| (jump - 1.5).abs() < 1e-9));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FoundSurfaces {
    /// World coordinates of the vertices, in the length unit of the scene.
    pub positions: Vec<[f64; 3]>,
    /// Unit vectors perpendicular to the surface, to the side on which g is larger.
    pub normals: Vec<[f64; 3]>,
    /// The difference of g between the two sides, above 0, in the unit of g; of a cube at the energy at which the
    /// surfaces were found, that of its largest image.
    pub jumps: Vec<f64>,
    /// The expected displacement along the normal, in the length unit of the scene: an estimate, from points
    /// that take no part in the fit of a surface, and no bound.
    pub uncertainties: Vec<f64>,
    /// The numbers of the vertices of each triangle, anticlockwise seen from the side on which g is larger.
    pub triangles: Vec<[u32; 3]>,
}

impl FoundSurfaces {
    /// The number of vertices.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there is no vertex.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }
}
