//! The whole sky in pixels of equal area: twelve cameras, one for each `HEALPix` face.

use super::bounds::Bounds;
use super::camera::Camera;
use super::edge::Edge;
use super::ellipsoid::Ellipsoid;
use super::frame::GeometryError;
use super::healpix::{FACES, face_of_direction, face_pixel};
use super::plane::FacePlane;
use super::region::Region;
use super::singularity::Singularity;
use super::vector::difference;
use super::{MappedPoint, Projection, ViewGeometry};
use crate::image::Image;

/// The whole sky around an observer in `HEALPix` pixels.
///
/// Longitude and latitude are those of the world: longitude 0 along x, 90° along y, the north pole
/// along z. The image of `nside` is a stack of the twelve faces, \[12 · `nside`, `nside`\] pixels, face
/// 0 lowest, each with the [nested scheme's](super::healpix) x along the columns and y up the rows;
/// [`nested`](Self::nested) brings the pixels into the order of `HEALPix` maps.
///
/// ```
/// use emitree::{FromFn, Healpix, RenderOptions, VolOptions, render};
///
/// let sky = Healpix::new([0.0; 3], [0.0, 2.0])?;
/// let glow = FromFn(|_: [f64; 3], _: [f64; 3]| 0.5);
/// let options = RenderOptions::new(VolOptions::default());
/// let rendering = render(&glow, &sky, Healpix::shape(4), &options)?;
/// let map = Healpix::nested(&rendering.values);
/// assert_eq!(map.len(), 12 * 4 * 4);
/// assert!(map.iter().all(|radiance| (radiance - 1.0).abs() < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Healpix {
    faces: Vec<Camera<FacePlane>>,
    position: [f64; 3],
}

impl Healpix {
    /// An observer at `position` with depths \[near, far\] along each line of sight.
    ///
    /// # Errors
    ///
    /// [`GeometryError`] if not 0 ≤ near < far ≤ ∞.
    pub fn new(position: [f64; 3], depth: [f64; 2]) -> Result<Self, GeometryError> {
        let face = |plane| Camera::of_world(position, plane, depth);
        let faces = FacePlane::all().map(face).collect::<Result<_, _>>()?;
        Ok(Self { faces, position })
    }

    /// As [`Camera::with_bounds`].
    #[must_use]
    pub fn with_bounds(self, bounds: Bounds) -> Self {
        let faces = self.faces.into_iter().map(|face| face.with_bounds(bounds)).collect();
        Self { faces, ..self }
    }

    /// As [`Camera::with_occulters`].
    ///
    /// # Errors
    ///
    /// [`GeometryError::InsideOcculter`] if the observer is inside one of them.
    pub fn with_occulters(self, bodies: Vec<Ellipsoid>) -> Result<Self, GeometryError> {
        let faces = self.faces.into_iter().map(|face| face.with_occulters(bodies.clone()));
        Ok(Self { faces: faces.collect::<Result<_, _>>()?, ..self })
    }

    /// As [`Camera::with_edges`].
    #[must_use]
    pub fn with_edges(self, edges: Vec<Edge>) -> Self {
        let faces = self.faces.into_iter().map(|face| face.with_edges(edges.clone())).collect();
        Self { faces, ..self }
    }

    /// As [`Camera::with_singularities`].
    #[must_use]
    pub fn with_singularities(self, singularities: Vec<Singularity>) -> Self {
        let faces = self.faces.into_iter();
        let faces = faces.map(|face| face.with_singularities(singularities.clone())).collect();
        Self { faces, ..self }
    }

    /// Height and width of the image with `nside` pixels along the edge of a face.
    pub fn shape(nside: usize) -> [usize; 2] {
        [usize::from(FACES) * nside, nside]
    }

    /// The pixels of an image of this projection in the nested order.
    ///
    /// # Panics
    ///
    /// If the image is not twelve squares high.
    pub fn nested(image: &Image) -> Vec<f64> {
        let nside = image.width();
        assert_eq!([image.height(), nside], Self::shape(nside), "twelve squares");
        let side = u32::try_from(nside).unwrap_or(u32::MAX);
        let pixel = |index: usize| {
            let (face, x, y) = face_pixel(side, index as u64);
            image[(usize::from(face) * nside + y as usize, x as usize)]
        };
        (0..image.pixels().len()).map(pixel).collect()
    }

    /// The face at a place of the stack, and the place on it.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 11")]
    fn face_at(&self, [x, y]: [f64; 2]) -> (&Camera<FacePlane>, [f64; 2]) {
        let along = y * f64::from(FACES);
        let face = along.clamp(0.0, f64::from(FACES - 1)) as usize;
        (&self.faces[face], [x, along - face as f64])
    }

    /// A rectangle of the stack as such on its face.
    fn on_face(&self, min: [f64; 2], max: [f64; 2]) -> (&Camera<FacePlane>, [[f64; 2]; 2]) {
        let middle = core::array::from_fn(|i| 0.5 * (min[i] + max[i]));
        let (face, [_, y]) = self.face_at(middle);
        let half = 0.5 * (max[1] - min[1]) * f64::from(FACES);
        (face, [[min[0], y - half], [max[0], y + half]])
    }
}

impl Projection for Healpix {
    fn world_from_canonical(&self, [x, y, z]: [f64; 3]) -> MappedPoint {
        let (face, [x, y]) = self.face_at([x, y]);
        face.world_from_canonical([x, y, z])
    }

    fn canonical_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        let (face, _) = face_of_direction(difference(position, self.position));
        let [x, y, z] = self.faces[usize::from(face)].canonical_from_world(position)?;
        Some([x, (f64::from(face) + y) / f64::from(FACES), z])
    }

    fn solid_angle_density(&self, xy: [f64; 2]) -> f64 {
        let (face, xy) = self.face_at(xy);
        face.solid_angle_density(xy) * f64::from(FACES)
    }

    fn solid_angle(&self, min: [f64; 2], max: [f64; 2]) -> f64 {
        let (face, [min, max]) = self.on_face(min, max);
        face.solid_angle(min, max)
    }

    fn view_geometry(&self) -> Option<&dyn ViewGeometry> {
        Some(self)
    }
}

impl ViewGeometry for Healpix {
    fn region(&self, xy: [f64; 2]) -> Region {
        let (face, xy) = self.face_at(xy);
        face.region(xy)
    }

    fn has_regions(&self) -> bool {
        self.faces.iter().any(ViewGeometry::has_regions)
    }

    fn tiles(&self) -> Vec<&dyn Projection> {
        self.faces.iter().map(|face| face as &dyn Projection).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_face_has_the_edges() {
        let edges = vec![Edge::plane([0.0; 3], [0.0, 0.0, 1.0]).unwrap()];
        let sky = Healpix::new([0.0; 3], [0.0, 2.0]).unwrap().with_edges(edges.clone());
        assert_eq!(sky.faces.len(), 12);
        assert!(
            sky.faces
                .iter()
                .all(|face| face.surroundings().is_some_and(|around| around.edges == edges))
        );
    }
}
