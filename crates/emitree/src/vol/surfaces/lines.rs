//! Lines of sight of one's own, through the surfaces and the pieces beside them.

use crate::line_values::LineValues;
use crate::parallel::prelude::*;
use crate::projection::Chart;
use crate::vol::surfaces::aim::Aim;
use crate::vol::surfaces::beam::Beam;
use crate::vol::surfaces::model::Model;
use crate::vol::surfaces::rays::{LineIntegral, Ray};

/// Lines beside a line: the surfaces displaced by their errors are what it would meet. Directions of these
/// displacements.
const DIRECTIONS: usize = 8;

impl Model {
    /// The radiances along lines at places of the image plane, with errors; `chart` is that of the view.
    ///
    /// A line beside a limb may meet a surface that the model has just beside the line. So its error is the largest
    /// difference to lines that are displaced by the error of the surfaces, added to those of the pieces.
    pub(super) fn lines(
        &self,
        aim: &Aim<'_>,
        chart: &dyn Chart,
        places: &[[f64; 2]],
    ) -> LineValues {
        let of_line = |xy: &[f64; 2]| {
            let is_place = xy.iter().all(|along| (0.0..=1.0).contains(along));
            let place = match aim.sky {
                Some(sky) => sky.place_on_only(*xy),
                None => Some(*xy),
            };
            let place = place.filter(|_| is_place)?;
            let density = chart.density(place);
            (density > 0.0).then(|| {
                let LineIntegral { value, error } = self.line_alone(aim, place);
                [value / density, error / density]
            })
        };
        let of_lines: Vec<Option<[f64; 2]>> = places.par_iter().map(of_line).collect();
        let mut found = LineValues::unknown(places.len());
        for (line, of) in of_lines.into_iter().enumerate() {
            if let Some([value, error]) = of.filter(|of| of.iter().all(|of| of.is_finite())) {
                (found.values[line], found.errors[line]) = (value, error);
            }
        }
        found
    }

    /// The integral along the line at a place of the chart.
    fn line_alone(&self, aim: &Aim<'_>, place: [f64; 2]) -> LineIntegral {
        let grid = &self.tree.grid;
        let mut ray = Ray::default();
        let [x, y] = [place[0] * grid.edges[0], place[1] * grid.edges[1]];
        let end = aim.end_of_line(grid, [x, y]);
        let mut at = |xy: [f64; 2]| {
            ray.follow(&Beam::new(&self.tree, [xy; 2]), xy, end);
            let segments = ray.segments.iter().copied();
            (self.integral(xy, segments, ray.unresolved), ray.displacement)
        };
        let (line, displacement) = at([x, y]);
        let mut apart: f64 = 0.0;
        if displacement > 0.0 {
            for k in 0..DIRECTIONS {
                let (sin, cos) = (core::f64::consts::TAU * k as f64 / DIRECTIONS as f64).sin_cos();
                let beside = [(x, cos, 0), (y, sin, 1)].map(|(at, along, axis)| {
                    (at + displacement * along).clamp(0.0, grid.edges[axis])
                });
                let (of, _) = at(beside);
                apart = apart.max((of.value - line.value).abs());
            }
        }
        LineIntegral { value: line.value, error: line.error + apart }
    }
}
