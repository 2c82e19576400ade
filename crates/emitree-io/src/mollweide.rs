//! The picture of a map of the whole sphere: an ellipse of equal areas.

use emitree::projection::healpix::pixel_of_direction;
use emitree::{Healpix, Image};
use std::f64::consts::{FRAC_1_PI, PI};

/// Which way longitude grows in a picture of the sphere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum East {
    /// To the left, as the sky is seen from inside.
    #[default]
    Left,
    /// To the right, as a globe is seen from outside.
    Right,
}

/// The sphere in Mollweide's projection, `height` × 2 `height` pixels, north up and longitude 0 in
/// the middle.
///
/// Each pixel is the `value` in the direction of its centre, a unit vector with x towards longitude
/// 0, y towards longitude 90° and z north; pixels outside of the ellipse are NaN. The ellipse fills
/// the image (Calabretta & Greisen 2002, doi:10.1051/0004-6361:20021327, section 5.3.3).
///
/// ```
/// use emitree::projection::healpix::pixel_of_direction;
/// use emitree_io::{East, mollweide};
///
/// // A `HEALPix` map whose twelve pixels are their own numbers.
/// let map: Vec<f64> = (0..12).map(f64::from).collect();
/// let image = mollweide(100, East::Left, |direction| map[pixel_of_direction(1, direction) as usize]);
/// assert_eq!((image.height(), image.width()), (100, 200));
/// assert_eq!(image[(50, 100)], 4.0); // the face on the equator in the middle
/// assert_eq!(image[(50, 50)], 5.0); // the next one, at 90 degrees, is on its left
/// assert!(image[(0, 0)].is_nan());
/// ```
pub fn mollweide<F: Fn([f64; 3]) -> f64>(height: usize, east: East, value: F) -> Image {
    let width = 2 * height;
    let mut image = Image::zeros(height, width);
    for (index, pixel) in image.pixels_mut().iter_mut().enumerate() {
        let across = centre(index % width, width);
        let right = if east == East::Right { across } else { -across };
        let direction = direction_at([right, centre(index / width, height)]);
        *pixel = direction.map_or(f64::NAN, &value);
    }
    image
}

/// The picture of an image of [`Healpix`]: the sky as it is seen from inside, in Mollweide's projection
/// of `height` rows; pixels outside of the ellipse are NaN.
///
/// ```
/// use emitree::Image;
/// use emitree_io::picture_of_sky;
///
/// // Twelve faces of a pixel each, one above the other.
/// let picture = picture_of_sky(&Image::from_pixels(12, 1, vec![3.0; 12]), 50);
/// assert_eq!((picture.height(), picture.width(), picture[(25, 50)]), (50, 100, 3.0));
/// ```
pub fn picture_of_sky(image: &Image, height: usize) -> Image {
    picture_of_map(image.width(), &Healpix::nested(image), height)
}

/// The same picture of the pixels of a map in nested order.
pub(crate) fn picture_of_map(nside: usize, map: &[f64], height: usize) -> Image {
    let nside = u32::try_from(nside).unwrap_or(u32::MAX);
    let value = |direction| {
        let pixel = usize::try_from(pixel_of_direction(nside, direction)).unwrap_or(usize::MAX);
        map.get(pixel).copied().unwrap_or(f64::NAN)
    };
    mollweide(height, East::Left, value)
}

/// The direction at a point of the picture, both coordinates in \[−1, 1\] and longitude growing to
/// the right; none outside of the ellipse.
fn direction_at([x, y]: [f64; 2]) -> Option<[f64; 3]> {
    // The cosine of the parametric latitude, half the length of this parallel in the picture.
    let half_parallel = (1.0 - y * y).max(0.0).sqrt();
    if x.abs() > half_parallel {
        return None;
    }
    let longitude = if half_parallel > 0.0 { PI * x / half_parallel } else { 0.0 };
    let sin_latitude = (2.0 * FRAC_1_PI * (y.asin() + y * half_parallel)).clamp(-1.0, 1.0);
    let cos_latitude = ((1.0 - sin_latitude) * (1.0 + sin_latitude)).sqrt();
    let (sin, cos) = longitude.sin_cos();
    Some([cos_latitude * cos, cos_latitude * sin, sin_latitude])
}

/// The middle of a pixel on \[−1, 1\].
#[expect(clippy::cast_precision_loss, reason = "exact below 2^53")]
fn centre(pixel: usize, pixels: usize) -> f64 {
    (2 * pixel + 1) as f64 / pixels as f64 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_4;

    #[test]
    fn the_picture_fills_its_ellipse_with_equal_areas() {
        let all = mollweide(400, East::Left, |_| 1.0);
        let inside = all.pixels().iter().filter(|pixel| !pixel.is_nan()).count();
        let area = inside as f64 / all.pixels().len() as f64;
        assert!((area - FRAC_PI_4).abs() < 1e-3, "{area}");
        // Half of the sphere lies within 30 degrees of the equator.
        let belt = all_within(&mollweide(400, East::Left, |[_, _, z]| f64::from(z.abs() < 0.5)));
        assert!((belt / inside as f64 - 0.5).abs() < 2e-3, "{belt}");
        let octant = |[x, y, z]: [f64; 3]| f64::from(x > 0.0 && y > 0.0 && z > 0.0);
        let octant = all_within(&mollweide(400, East::Left, octant));
        assert!((octant / inside as f64 - 0.125).abs() < 1e-3, "{octant}");
    }

    fn all_within(image: &Image) -> f64 {
        image.pixels().iter().filter(|pixel| !pixel.is_nan()).sum()
    }

    #[test]
    fn north_is_up_and_east_is_as_requested() {
        let (middle, top) = (50, 99);
        let z = mollweide(100, East::Right, |[_, _, z]| z);
        assert!(z[(top, 99)] > 0.99 && z[(0, 100)] < -0.99);
        let right = mollweide(100, East::Right, |[_, y, _]| y);
        let left = mollweide(100, East::Left, |[_, y, _]| y);
        for column in 10..90 {
            assert!(right[(middle, 100 + column)] > 0.0);
            assert!((right[(middle, 100 + column)] + left[(middle, 100 + column)]).abs() < 1e-15);
        }
        let x = mollweide(100, East::Left, |[x, _, _]| x);
        assert!(x[(middle, 100)] > 0.999 && x[(middle, 1)] < -0.99);
    }

    /// mpmath: 2θ + sin 2θ = π sin φ solved for φ = 30°, 60°; λ = 60°, −120°.
    #[test]
    fn places_are_those_of_the_defining_equation() {
        for (x, y, longitude_deg, latitude_deg) in MPMATH {
            let [a, b, c] = direction_at([x, y]).unwrap();
            assert!((b.atan2(a).to_degrees() - longitude_deg).abs() < 1e-12);
            assert!((c.asin().to_degrees() - latitude_deg).abs() < 1e-12);
        }
    }

    const MPMATH: [(f64, f64, f64, f64); 3] = [
        (0.30492367252434527, 0.4039727532995172, 60.0, 30.0),
        (-0.4314149601682314, 0.7623860880956889, -120.0, 60.0),
        (0.05082061208739088, -0.4039727532995172, 10.0, -30.0),
    ];
}
