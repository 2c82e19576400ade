//! Pixels that the limb of an opaque body crosses, as geometry has them: they need no line to be found.

use crate::projection::ViewGeometry;
use crate::projection::charts::Atlas;
use crate::tile::Tile;
use crate::vol::view::division::atlas;
use crate::vol::view::pixel_rule::{Crossing, RuleNode};
use crate::vol::view::quadrature::Quadrature;

/// The edges of a view; none without bodies, limbs of bounds and declared edges.
pub(super) struct Limbs<'a> {
    tiles: &'a [Tile<'a>],
    atlas: Option<Atlas<'a>>,
    /// Of all pixels; empty without an atlas.
    crossings: Vec<Crossing>,
}

impl<'a> Limbs<'a> {
    /// Those of a view; `None` if lines of sight do not serve it: where the emission is singular, and where bodies
    /// have no charts.
    pub(super) fn of(tiles: &'a [Tile<'a>]) -> Option<Self> {
        let atlas = atlas(tiles, &[]);
        let has_regions = |tile: &Tile<'_>| {
            tile.projection.view_geometry().is_some_and(ViewGeometry::has_regions)
        };
        match &atlas {
            Some(atlas) if atlas.has_singularities() => return None,
            None if tiles.iter().any(has_regions) => return None,
            _ => {}
        }
        let crossings = match &atlas {
            Some(atlas) => Quadrature::new(Some(atlas), tiles).crossings(),
            None => Vec::new(),
        };
        Some(Self { tiles, atlas, crossings })
    }

    /// Whether there is any.
    pub(super) fn cross_pixels(&self) -> bool {
        self.crossings.iter().any(|crossing| matches!(crossing, Crossing::Crossed(_)))
    }

    /// For each square block of so many pixels along each side of an image, row by row, whether a limb crosses it.
    pub(super) fn blocks(&self, [height, width]: [usize; 2], block: usize) -> Vec<bool> {
        let columns = width / block;
        let mut are_crossed = vec![false; height / block * columns];
        for (pixel, crossing) in self.crossings.iter().enumerate() {
            if matches!(crossing, Crossing::Crossed(_)) {
                are_crossed[pixel / width / block * columns + pixel % width / block] = true;
            }
        }
        are_crossed
    }

    /// The places of lines in a pixel that a limb crosses, from 0 to 1, with their weights, more of them at each
    /// level; `None` for other pixels.
    pub(super) fn nodes(&self, pixel: usize, level: u8) -> Option<Vec<RuleNode>> {
        let crossing = *self.crossings.get(pixel)?;
        let atlas = self.atlas.as_ref().filter(|_| matches!(crossing, Crossing::Crossed(_)))?;
        Some(Quadrature::new(Some(atlas), self.tiles).places_in_pixel(pixel, crossing, level))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::{Ellipsoid, GeometryError};
    use crate::{Orthographic, Projection};

    /// The blocks of 4 × 4 pixels of an image of 16 × 16 that the limb of a ball crosses.
    fn crossed(centre: [f64; 3], radius: f64) -> Result<Vec<usize>, GeometryError> {
        let camera = Orthographic::of_unit_cube();
        let camera = camera.with_occulters(vec![Ellipsoid::sphere(centre, radius)?])?;
        let tiles =
            [Tile { projection: &camera as &dyn Projection, shape: [16; 2], place: (0, 1) }];
        let limbs = Limbs::of(&tiles).expect("a view with charts");
        assert!(limbs.cross_pixels());
        let blocks = limbs.blocks([16; 2], 4).into_iter().enumerate();
        Ok(blocks.filter(|(_, is_crossed)| *is_crossed).map(|(block, _)| block).collect())
    }

    #[test]
    fn limbs_of_large_and_of_tiny_bodies_are_known() -> Result<(), GeometryError> {
        // Its limb is in the four blocks in the middle, and far from those at the corners of the image.
        let large = crossed([0.5; 3], 0.2)?;
        assert!([5, 6, 9, 10].iter().all(|block| large.contains(block)), "{large:?}");
        assert!(![0, 3, 12, 15].iter().any(|block| large.contains(block)), "{large:?}");
        // A twentieth of a pixel, beside which no line through the middle of a pixel shows anything.
        let tiny = crossed([0.6, 0.6, 0.5], 0.003)?;
        assert_eq!(tiny, [10]);
        Ok(())
    }

    #[test]
    fn pixels_without_a_limb_have_no_nodes_of_one() -> Result<(), GeometryError> {
        let camera = Orthographic::of_unit_cube();
        let camera = camera.with_occulters(vec![Ellipsoid::sphere([0.5; 3], 0.24)?])?;
        let tiles =
            [Tile { projection: &camera as &dyn Projection, shape: [16; 2], place: (0, 1) }];
        let limbs = Limbs::of(&tiles).expect("a view with charts");
        assert_eq!(limbs.nodes(0, 0), None);
        // The limb is at x = 0.26 in the row above the middle.
        let nodes = limbs.nodes(8 * 16 + 4, 0).expect("a limb");
        let whole: f64 = nodes.iter().map(|(_, weight)| weight).sum();
        assert!((whole - 1.0).abs() < 1e-9, "{whole}");
        Ok(())
    }
}
