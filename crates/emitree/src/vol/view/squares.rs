//! Squares of a pixel that are no larger than their distance from a singularity.
//!
//! The radiance near a singularity has the same relative structure on all scales, so that one rule is equally
//! accurate on all such squares. Their number grows with the logarithm of the smallest size.

use crate::projection::charts::NearSingularity;

/// A square is divided while its middle is closer to a singularity than so many times its size,
/// and `FINER` times as many at each level of a finer quadrature, which has about twice as many squares.
const LEAST_DISTANCE: f64 = 1.5;
const FINER: f64 = 1.5;
/// A singularity whose distance from the middle is larger, in units of the size, is outside of a square; pixels
/// are not exactly square.
const OUTSIDE: f64 = 0.9;
/// How often the sides of squares at a point are halved: what is left of the pixel is 1e-12 of its area. And of
/// those at an axis, which rules for lines up to the axis integrate.
const LEVELS_AT_POINT: u8 = 20;
const LEVELS_AT_AXIS: u8 = 2;

/// A square of a pixel, whose sides are from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Square {
    pub(crate) corner: [f64; 2],
    pub(crate) size: f64,
    /// Whether an axis at which the emission is singular may cross it.
    pub(crate) touches_axis: bool,
}

impl Square {
    const WHOLE: Self = Self { corner: [0.0; 2], size: 1.0, touches_axis: false };

    pub(crate) fn is_whole_pixel(&self) -> bool {
        self.size >= 1.0
    }

    /// The place in the pixel of one in the square, from 0 to 1.
    pub(crate) fn place(&self, inner: [f64; 2]) -> [f64; 2] {
        [self.corner[0] + self.size * inner[0], self.corner[1] + self.size * inner[1]]
    }

    fn quarters(self) -> [Self; 4] {
        let size = 0.5 * self.size;
        let quarter = |x, y| Self { corner: self.place([x, y]), size, ..self };
        [quarter(0.0, 0.0), quarter(0.5, 0.0), quarter(0.0, 0.5), quarter(0.5, 0.5)]
    }
}

/// The squares of a pixel, for a quadrature of a `level` and given how near a place is to a singularity; the whole
/// pixel if none is near.
pub(crate) fn squares_about_singularities(
    level: u8,
    nearness: &dyn Fn([f64; 2]) -> Option<NearSingularity>,
) -> Vec<Square> {
    let is_near = |square: &Square, times: f64| {
        nearness(square.place([0.5; 2])).filter(|near| near.pixels < times * square.size)
    };
    if is_near(&Square::WHOLE, LEAST_DISTANCE).is_none() {
        return vec![Square::WHOLE];
    }
    let times = LEAST_DISTANCE * FINER.powi(i32::from(level));
    let mut squares = Vec::new();
    let mut open = vec![(Square::WHOLE, 0)];
    while let Some((square, depth)) = open.pop() {
        let levels = |near: NearSingularity| {
            if near.is_axis { LEVELS_AT_AXIS + level } else { LEVELS_AT_POINT }
        };
        match is_near(&square, times).filter(|near| depth < levels(*near)) {
            Some(_) => open.extend(square.quarters().map(|quarter| (quarter, depth + 1))),
            None => {
                let touches_axis = is_near(&square, OUTSIDE).is_some_and(|near| near.is_axis);
                squares.push(Square { touches_axis, ..square });
            }
        }
    }
    squares
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(distance: impl Fn([f64; 2]) -> f64, is_axis: bool) -> Vec<Square> {
        squares_about_singularities(0, &|place| {
            Some(NearSingularity { pixels: distance(place), is_axis })
        })
    }

    #[test]
    fn squares_cover_the_pixel_and_shrink_towards_the_point() {
        let point = [0.3, 0.81];
        let distance = |[x, y]: [f64; 2]| f64::hypot(x - point[0], y - point[1]);
        let squares = near(distance, false);
        let area: f64 = squares.iter().map(|square| square.size * square.size).sum();
        assert!((area - 1.0).abs() < 1e-12 && squares.len() < 1000, "{area} {}", squares.len());
        let smallest = squares.iter().map(|square| square.size).fold(1.0, f64::min);
        for square in &squares {
            let far = distance(square.place([0.5; 2])) >= LEAST_DISTANCE * square.size;
            assert!(far || square.size <= smallest);
        }
        assert_eq!(near(|_| 3.0, false), [Square::WHOLE]);
    }

    #[test]
    fn squares_at_an_axis_stay_few() {
        let squares = near(|[x, y]| (0.6 * x - 0.8 * y + 0.1).abs(), true);
        assert!(squares.len() < 64, "{}", squares.len());
        let at_axis = squares.iter().filter(|square| square.touches_axis);
        assert!(at_axis.clone().count() > 7);
        assert!(at_axis.into_iter().all(|square| square.size <= 0.25));
    }
}
