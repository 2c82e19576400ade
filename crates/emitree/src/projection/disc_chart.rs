//! The lines of sight of a point observer about a direction as one chart, whatever the image planes are: without
//! tiles, and with no pole in view but the opposite direction.

use crate::projection::camera::{Camera, PlaneChart};
use crate::projection::charts::chart::{Chart, image_place};
use crate::projection::frame::{Frame, Viewpoint};
use crate::projection::plane::{DiscMapping, DiscPlane, ImagePlane};
use crate::projection::surroundings::{Observer, SightLine};
use crate::projection::vector::along;
use crate::projection::{MappedPoint, ViewGeometry};

/// Lines of sight on a disc on which equal distances from the middle are equal angles, with the surroundings of a
/// view. Its density is 1: a function on it is G = g · ds/dz. It continues beyond the rim.
#[derive(Clone, Debug)]
pub(crate) struct DiscChart<'a> {
    disc: Camera<DiscPlane>,
    /// The image planes of all tiles.
    tiles: Vec<&'a dyn ViewGeometry>,
}

impl<'a> DiscChart<'a> {
    /// The lines within an angle \[rad\], at most π, of a unit vector away from the observer; `None` for parallel
    /// lines.
    pub(crate) fn new(
        tiles: Vec<&'a dyn ViewGeometry>,
        towards: [f64; 3],
        reach_rad: f64,
    ) -> Option<Self> {
        let surroundings = tiles.first()?.surroundings()?;
        let Observer::Point(position) = surroundings.observer else { return None };
        // Any vector that is not along the direction.
        let least = (0..3).min_by(|&i, &j| towards[i].abs().total_cmp(&towards[j].abs()))?;
        let up = core::array::from_fn(|k| f64::from(u8::from(k == least)));
        let target = along(position, 1.0, towards);
        let frame = Frame::new(&Viewpoint { position, target, up }).ok()?;
        let plane = DiscPlane::new(2.0 * reach_rad, DiscMapping::Equidistant).ok()?;
        Some(Self { disc: Camera::within(frame, plane, surroundings.clone()), tiles })
    }

    fn plane(&self) -> PlaneChart<'_, DiscPlane> {
        PlaneChart { camera: &self.disc, tile: 0 }
    }

    /// The place of a line of sight.
    pub(crate) fn place(&self, line: &SightLine) -> Option<[f64; 2]> {
        self.disc.place_of_line(line)
    }

    /// The tile, and the place on it, at which the line at (u, v) is seen; `None` if it is not in view.
    pub(crate) fn seen(&self, uv: [f64; 2]) -> Option<(usize, [f64; 2])> {
        if !self.disc.plane().contains(uv) {
            return None;
        }
        let line = ViewGeometry::line(&self.disc, uv)?;
        let mut places = self.tiles.iter().map(|tile| tile.place_of_line(&line)).enumerate();
        places.find_map(|(tile, xy)| {
            let is_in = |xy: &[f64; 2]| xy.iter().all(|along| (0.0..=1.0).contains(along));
            let xy = xy.filter(is_in)?;
            (self.tiles[tile].solid_angle_density(xy) > 0.0 || !self.tiles[tile].has_rim())
                .then_some((tile, xy))
        })
    }
}

impl Chart for DiscChart<'_> {
    fn world_from_chart(&self, u: [f64; 3]) -> MappedPoint {
        self.plane().world_from_chart(u)
    }

    fn chart_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        self.plane().chart_from_world(position)
    }

    fn density(&self, _uv: [f64; 2]) -> f64 {
        1.0
    }

    fn line(&self, uv: [f64; 2]) -> Option<SightLine> {
        self.plane().line(uv)
    }

    fn depth_of(&self, line: &SightLine, distance: f64) -> f64 {
        self.plane().depth_of(line, distance)
    }

    fn visible_end(&self, uv: [f64; 2]) -> Option<(usize, f64)> {
        self.plane().visible_end(uv)
    }

    fn image_place(&self, uv: [f64; 2]) -> (usize, [f64; 2]) {
        ViewGeometry::line(&self.disc, uv)
            .map_or((0, [0.5; 2]), |line| image_place(&self.tiles, &line))
    }
}
