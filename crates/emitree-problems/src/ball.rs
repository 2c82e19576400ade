//! A uniform ball: g jumps, and the image has a kink of infinite slope at the limb.
//!
//! The image is 2 √(R² − b²) at distance b from the centre. Its integral over a rectangle with a
//! corner on the centre is elementary, and a pixel is four of those.

use core::f64::consts::PI;
use emitree::Image;

/// A bound on the largest error of a pixel of an image of up to 256 × 256 pixels, relative to the
/// largest pixel: rounding, in proportion to the number of pixels.
pub const IMAGE_ERROR: f64 = 1e-11;

/// A ball of emission rate 1 with nothing around it; the default has a radius of 0.3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// The centre.
    pub centre: [f64; 3],
    /// The radius R. The ball must not reach beyond 0 ≤ z ≤ 1.
    pub radius: f64,
}

impl Default for Ball {
    fn default() -> Self {
        Self { centre: [0.51, 0.48, 0.5], radius: 0.3 }
    }
}

impl Ball {
    /// The emission rate at a point: 1 inside and 0 outside.
    ///
    /// ```
    /// let ball = emitree_problems::ball::Ball::default();
    /// assert_eq!(ball.rate([0.51, 0.48, 0.79]), 1.0);
    /// assert_eq!(ball.rate([0.51, 0.48, 0.81]), 0.0);
    /// ```
    pub fn rate(&self, position: [f64; 3]) -> f64 {
        let square: f64 = (0..3).map(|i| (position[i] - self.centre[i]).powi(2)).sum();
        if square < self.radius.powi(2) { 1.0 } else { 0.0 }
    }

    /// The exact image of `shape` = \[height, width\] pixels in the canonical projection, to
    /// [`IMAGE_ERROR`].
    ///
    /// ```
    /// use emitree_problems::ball::Ball;
    ///
    /// let image = Ball::default().exact_image([1, 1]);
    /// assert!((image[(0, 0)] - 4.0 / 3.0 * std::f64::consts::PI * 0.3_f64.powi(3)).abs() < 1e-15);
    /// ```
    ///
    /// # Panics
    ///
    /// If the ball reaches beyond 0 ≤ z ≤ 1: the faces of the cube would cut chords short.
    pub fn exact_image(&self, [height, width]: [usize; 2]) -> Image {
        let [cx, cy, cz] = self.centre;
        let within = cz >= self.radius && cz + self.radius <= 1.0;
        assert!(within, "a ball of radius {} at depth {cz} lies within 0..1", self.radius);
        let (columns, rows) = (width as f64, height as f64);
        let corner = |row: usize, column: usize| {
            corner(column as f64 / columns - cx, row as f64 / rows - cy, self.radius)
        };
        let mean = |row: usize, column: usize| {
            let right = corner(row + 1, column + 1) - corner(row, column + 1);
            let left = corner(row + 1, column) - corner(row, column);
            2.0 * (right - left) * columns * rows
        };
        let pixels = (0..height).flat_map(|row| (0..width).map(move |column| mean(row, column)));
        Image::from_pixels(height, width, pixels.collect())
    }
}

/// ∫∫ √(R² − x'² − y'²) over the rectangle from the centre to (x, y), where the root is real; odd
/// in x and in y.
fn corner(x: f64, y: f64, radius: f64) -> f64 {
    let sign = x.signum() * y.signum();
    let (x, y, square) = (x.abs(), y.abs(), radius * radius);
    let height_square = square - x * x - y * y;
    if height_square > 0.0 {
        // Derived by parts; its mixed derivative in x and y is the root.
        let height = height_square.sqrt();
        let slices = y * (3.0 * square - y * y) * x.atan2(height)
            + x * (3.0 * square - x * x) * y.atan2(height);
        let twist = radius * square * (x * y).atan2(radius * height);
        sign * (x * y * height / 3.0 + slices / 6.0 - twist / 3.0)
    } else {
        // An eighth of the ball less half of each of the two caps, which do not meet: that beyond x
        // is ∫ (R² − x'²) π/4 dx' from x to R.
        let cap = |from: f64| {
            let from = from.min(radius);
            PI / 12.0 * (radius - from).powi(2) * (2.0 * radius + from)
        };
        sign * (PI / 6.0 * radius * square - cap(x) - cap(y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauss::Gauss;

    /// The mean over a pixel, another way: the area under the half circle along x, and
    /// Gauss–Legendre along y between all kinks, on pieces that halve in length towards each of
    /// them.
    fn pixel_by_slices(
        ball: &Ball,
        rule: &Gauss,
        [height, width]: [usize; 2],
        [row, column]: [usize; 2],
    ) -> f64 {
        let [cx, cy, _] = ball.centre;
        let x = |i: usize| i as f64 / width as f64 - cx;
        let y = |i: usize| i as f64 / height as f64 - cy;
        let (from, to) = (y(row), y(row + 1));
        let slice = |y: f64| {
            let square = ball.radius.powi(2) - y * y;
            if square <= 0.0 {
                return 0.0;
            }
            let reach = square.sqrt();
            let area = |x: f64| {
                if x.abs() >= reach {
                    return (0.5 * PI * square).copysign(x);
                }
                x * (square - x * x).max(0.0).sqrt() + square * (x / reach).asin()
            };
            area(x(column + 1)) - area(x(column))
        };
        let mut kinks = vec![from, to];
        for x in [0.0, x(column), x(column + 1)] {
            let y = (ball.radius.powi(2) - x * x).max(0.0).sqrt();
            kinks.extend([-y, y]);
        }
        kinks.retain(|&y| y >= from && y <= to);
        kinks.sort_by(f64::total_cmp);
        let mut integral = 0.0;
        for ends in kinks.windows(2) {
            let (start, end, length) = (ends[0], ends[1], ends[1] - ends[0]);
            for halvings in 1..24 {
                let far = length * 0.5_f64.powi(halvings);
                let near = if halvings == 23 { 0.0 } else { 0.5 * far };
                integral += rule.integrate(start + near, start + far, slice);
                integral += rule.integrate(end - far, end - near, slice);
            }
        }
        integral * height as f64 * width as f64
    }

    #[test]
    fn every_pixel_agrees_with_slices() {
        let (ball, rule) = (Ball::default(), Gauss::new(10));
        for shape in [[64, 64], [7, 3], [30, 41]] {
            let exact = ball.exact_image(shape);
            let pixels = (0..shape[0]).flat_map(|row| (0..shape[1]).map(move |c| [row, c]));
            let slices = |at| pixel_by_slices(&ball, &rule, shape, at);
            let far = pixels.map(|at| (exact[at.into()] - slices(at)).abs()).fold(0.0, f64::max);
            assert!(far < 2e-12, "{far:e} at {shape:?}");
        }
    }

    /// Chords at 1000 × 1000 points of pixels on the limb, and one in the middle.
    #[test]
    fn pixels_agree_with_counted_chords() {
        let ball = Ball::default();
        let exact = ball.exact_image([20, 16]);
        let [cx, cy, _] = ball.centre;
        for [row, column] in [[4, 6], [9, 12], [13, 11], [15, 8], [10, 8]] {
            let mut sum = 0.0;
            for i in 0..1_000_000 {
                let y = (f64::from(i / 1000) + 0.5) / 1000.0 + row as f64;
                let x = (f64::from(i % 1000) + 0.5) / 1000.0 + column as f64;
                let across = (x / 16.0 - cx).powi(2) + (y / 20.0 - cy).powi(2);
                sum += 2.0 * (ball.radius.powi(2) - across).max(0.0).sqrt();
            }
            assert!((exact[(row, column)] - sum * 1e-6).abs() < 1e-6);
        }
    }

    /// The image of a ball that reaches beyond the sides is cut there.
    #[test]
    fn a_ball_on_an_edge_shows_a_quarter() {
        let ball = Ball { centre: [0.0, 1.0, 0.5], radius: 0.2 };
        let mean = ball.exact_image([1, 1])[(0, 0)];
        assert!((mean - PI / 3.0 * 0.008).abs() < 1e-16);
    }

    #[test]
    #[should_panic(expected = "a ball of radius 0.3 at depth 0.2 lies within 0..1")]
    fn a_ball_beyond_the_near_face_is_refused() {
        let _ = Ball { centre: [0.5, 0.5, 0.2], radius: 0.3 }.exact_image([2, 2]);
    }
}
