//! Some rows of an image as a view of their own.

use super::region::Region;
use super::surroundings::{SightLine, Surroundings};
use super::{MappedPoint, Projection, ViewGeometry};

/// The part of a view between two places along the canonical y.
#[derive(Debug)]
pub(crate) struct RowsOfView<'a> {
    whole: &'a dyn ViewGeometry,
    y: [f64; 2],
}

impl<'a> RowsOfView<'a> {
    /// Between these places of y.
    pub(crate) fn new(whole: &'a dyn ViewGeometry, y: [f64; 2]) -> Self {
        Self { whole, y }
    }

    /// The y of the whole view.
    fn y_of_whole(&self, y: f64) -> f64 {
        self.y[0] + y * (self.y[1] - self.y[0])
    }

    fn of_whole(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [x, self.y_of_whole(y)]
    }

    fn y_of_rows(&self, y: f64) -> f64 {
        (y - self.y[0]) / (self.y[1] - self.y[0])
    }
}

impl Projection for RowsOfView<'_> {
    fn world_from_canonical(&self, [x, y, z]: [f64; 3]) -> MappedPoint {
        self.whole.world_from_canonical([x, self.y_of_whole(y), z])
    }

    fn canonical_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        let [x, y, z] = self.whole.canonical_from_world(position)?;
        Some([x, self.y_of_rows(y), z])
    }

    fn solid_angle_density(&self, xy: [f64; 2]) -> f64 {
        (self.y[1] - self.y[0]) * self.whole.solid_angle_density(self.of_whole(xy))
    }

    fn solid_angle(&self, min: [f64; 2], max: [f64; 2]) -> f64 {
        self.whole.solid_angle(self.of_whole(min), self.of_whole(max))
    }

    fn view_geometry(&self) -> Option<&dyn ViewGeometry> {
        Some(self)
    }
}

impl ViewGeometry for RowsOfView<'_> {
    fn region(&self, xy: [f64; 2]) -> Region {
        self.whole.region(self.of_whole(xy))
    }

    fn has_rim(&self) -> bool {
        self.whole.has_rim()
    }

    fn surroundings(&self) -> Option<&Surroundings> {
        self.whole.surroundings()
    }

    fn line(&self, xy: [f64; 2]) -> Option<SightLine> {
        self.whole.line(self.of_whole(xy))
    }

    fn place_of_line(&self, line: &SightLine) -> Option<[f64; 2]> {
        self.whole.place_of_line(line).map(|[x, y]| [x, self.y_of_rows(y)])
    }

    fn solid_angles_of_row(&self, y: [f64; 2], solid_angles: &mut [f64]) {
        self.whole.solid_angles_of_row(y.map(|y| self.y_of_whole(y)), solid_angles);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Orthographic;
    use crate::projection::Ellipsoid;

    #[test]
    fn rows_have_the_lines_of_sight_of_the_whole_view() {
        let ball = Ellipsoid::sphere([0.5; 3], 0.2).unwrap();
        let camera = Orthographic::of_unit_cube().with_occulters(vec![ball]).unwrap();
        let rows = RowsOfView::new(&camera, [0.5, 0.75]);
        for (at, of_whole) in [([0.4, 0.0], [0.4, 0.5]), ([0.9, 0.5], [0.9, 0.625])] {
            assert_eq!(rows.region(at), camera.region(of_whole));
            let [a, b] = [ViewGeometry::line(&rows, at), ViewGeometry::line(&camera, of_whole)];
            assert_eq!(a.map(|line| line.at(0.3)), b.map(|line| line.at(0.3)));
            let inside = [at[0], at[1], 0.2];
            let point = rows.world_from_canonical(inside);
            assert_eq!(point, camera.world_from_canonical([of_whole[0], of_whole[1], 0.2]));
            let back = rows.canonical_from_world(point.position).unwrap();
            assert!((0..3).all(|k| (back[k] - inside[k]).abs() < 1e-12), "{back:?}");
        }
        assert!((rows.solid_angle([0.0; 2], [1.0; 2]) - 0.25).abs() < 1e-12);
        assert!((rows.solid_angle_density([0.5; 2]) - 0.25).abs() < 1e-12);
    }
}
