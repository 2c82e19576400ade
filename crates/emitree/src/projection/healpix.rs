//! The `HEALPix` pixelisation of the sphere, nested scheme: twelve faces of equal area, and their
//! pixels.
//!
//! Górski et al. 2005 (doi:10.1086/427976) for faces and numbers, Calabretta & Roukema 2007
//! (doi:10.1111/j.1365-2966.2007.12297.x) for the projection behind them. Each face is a square in
//! coordinates (x, y) from its southern corner: x to the north-east, y to the north-west, whose
//! bits are the even and the odd bits of a nested index. The map to the sphere keeps areas: π/3 sr
//! for each unit of dx dy, on every face.
//!
//! ```
//! use emitree::projection::healpix::{face_of_direction, nested_index, sight_of_face};
//!
//! let [x, y, z] = sight_of_face(4, [0.5, 0.5]); // face 4 has longitude 0, latitude 0 in its middle
//! assert!((x - 1.0).abs() < 1e-15 && y == 0.0 && z == 0.0);
//! let (face, [x, y]) = face_of_direction([0.0, 0.0, 1.0]); // the northern corner
//! assert!(face < 4 && x == 1.0 && y == 1.0);
//! assert_eq!(nested_index(4, 5, 2, 1), 5 * 16 + 6);
//! ```

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// The number of faces.
pub const FACES: u8 = 12;

/// The most pixels along an edge of a face: 2²⁹, whose indices fit in 64 bits.
pub const MAX_NSIDE: u32 = 1 << 29;

/// The unit vector, x towards longitude 0 and z north, of the point `xy` of a face.
///
/// Faces 0–3 touch the north pole, 4–7 are on the equator, 8–11 touch the south pole; `face` is
/// below [`FACES`] and `xy` in \[0, 1\]². Continuous on the closed face, and smooth but for a kink
/// where |z| = 2/3 (Górski et al., eqs. 2–9, for real numbers in place of pixels).
///
/// ```
/// use emitree::projection::healpix::sight_of_face;
///
/// // The upper corner of the faces in the north is the pole, the lower one is on the equator.
/// assert_eq!(sight_of_face(2, [1.0, 1.0]), [0.0, 0.0, 1.0]);
/// assert_eq!(sight_of_face(2, [0.0, 0.0])[2], 0.0);
/// ```
pub fn sight_of_face(face: u8, [x, y]: [f64; 2]) -> [f64; 3] {
    let (row, column) = (face / 4, face % 4);
    // Longitude of the face's middle, in units of π/4.
    let middle = f64::from(2 * column + u8::from(row != 1));
    // How far a polar cap's point is from the pole in the projection, 1 at the cap's rim.
    let (pole, cap) = match row {
        0 => (1.0, (1.0 - x) + (1.0 - y)),
        1 => (1.0, 1.0),
        _ => (-1.0, x + y),
    };
    let (z, radius, offset) = if cap < 1.0 {
        let below_pole = cap * cap / 3.0;
        let offset = if cap > 0.0 { (x - y) / cap } else { 0.0 };
        (pole * (1.0 - below_pole), cap * ((2.0 - below_pole) / 3.0).sqrt(), offset)
    } else {
        let z = (x + y - f64::from(row)) * 2.0 / 3.0;
        (z, ((1.0 - z) * (1.0 + z)).sqrt(), x - y)
    };
    let (sin, cos) = (FRAC_PI_4 * (middle + offset)).sin_cos();
    [radius * cos, radius * sin, z]
}

/// The face that a direction lies on, and where: the inverse of [`sight_of_face`].
///
/// `direction` has any length but zero. What lies on an edge belongs to either face.
///
/// ```
/// use emitree::projection::healpix::face_of_direction;
///
/// assert_eq!(face_of_direction([3.0, 0.0, 0.0]), (4, [0.5, 0.5]));
/// ```
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "whole numbers from 0 to 4"
)]
pub fn face_of_direction(direction: [f64; 3]) -> (u8, [f64; 2]) {
    let [along, across, north] = direction;
    let radius = along.hypot(across);
    let length = radius.hypot(north);
    let z = north / length;
    // Longitude in quarters of the circle; one of −0 plus 4 rounds to 4, the end of the circle.
    let quarters = across.atan2(along) / FRAC_PI_2;
    let quarters = if quarters < 0.0 { quarters + 4.0 } else { quarters };
    if z.abs() <= 2.0 / 3.0 {
        let (falling, rising) = (0.5 + quarters - 0.75 * z, 0.5 + quarters + 0.75 * z);
        let (fall, rise) = (falling.floor(), rising.floor());
        let xy = [rising - rise, 1.0 - (falling - fall)];
        let (fall, rise) = (fall as u8, rise as u8);
        return match fall.cmp(&rise) {
            core::cmp::Ordering::Equal => (4 + fall % 4, xy),
            core::cmp::Ordering::Less => (fall % 4, xy),
            core::cmp::Ordering::Greater => (8 + rise % 4, xy),
        };
    }
    let quarter = quarters.floor().min(3.0);
    // 1 − |z| without cancellation.
    let sine = radius / length;
    let cap = (3.0 * sine * sine / (1.0 + z.abs())).sqrt();
    let (east, west) = ((quarters - quarter) * cap, (1.0 - (quarters - quarter)) * cap);
    if z > 0.0 {
        (quarter as u8, [1.0 - west, 1.0 - east])
    } else {
        (8 + quarter as u8, [east, west])
    }
}

/// The nested index of the pixel in column `x` and row `y` of a face with `nside`² pixels.
///
/// `nside` is a power of two up to [`MAX_NSIDE`] (of another number the largest power of two in it
/// counts), `x` and `y` are below it, and `face` is below [`FACES`].
///
/// ```
/// use emitree::projection::healpix::nested_index;
///
/// assert_eq!(nested_index(1, 7, 0, 0), 7);
/// assert_eq!(nested_index(2, 0, 1, 0), 1); // x counts in the even bits
/// assert_eq!(nested_index(2, 0, 0, 1), 2);
/// ```
pub fn nested_index(nside: u32, face: u8, x: u32, y: u32) -> u64 {
    let depth = depth(nside);
    (u64::from(face) << (2 * depth)) | spread(x) | spread(y) << 1
}

/// The face, column and row of the pixel with a nested index: the inverse of [`nested_index`].
///
/// `index` is below 12 `nside`².
///
/// ```
/// use emitree::projection::healpix::face_pixel;
///
/// assert_eq!(face_pixel(4, 86), (5, 2, 1));
/// ```
#[expect(clippy::cast_possible_truncation, reason = "an index below 12 nside² has a face below 12")]
pub fn face_pixel(nside: u32, index: u64) -> (u8, u32, u32) {
    let depth = depth(nside);
    let within = index & ((1 << (2 * depth)) - 1);
    ((index >> (2 * depth)) as u8, gathered(within), gathered(within >> 1))
}

/// The nested index of the pixel that a direction of any length but zero lies in, for `nside` as in
/// [`nested_index`].
///
/// ```
/// use emitree::projection::healpix::pixel_of_direction;
///
/// assert_eq!(pixel_of_direction(1, [1.0, 0.0, 0.0]), 4);
/// assert_eq!(pixel_of_direction(2, [0.1, 0.1, 5.0]), 3); // the northern pixel of face 0
/// ```
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to [0, nside)"
)]
pub fn pixel_of_direction(nside: u32, direction: [f64; 3]) -> u64 {
    let nside = 1 << depth(nside);
    let (face, place) = face_of_direction(direction);
    let [x, y] = place.map(|along| ((along * f64::from(nside)) as u32).min(nside - 1));
    nested_index(nside, face, x, y)
}

/// How far bits move apart, in five steps, and which bits there are after each step: halves of a word, of
/// its halves, and so on.
const STEPS: [(u32, u64); 5] = [
    (16, 0x0000_ffff_0000_ffff),
    (8, 0x00ff_00ff_00ff_00ff),
    (4, 0x0f0f_0f0f_0f0f_0f0f),
    (2, 0x3333_3333_3333_3333),
    (1, 0x5555_5555_5555_5555),
];

/// The bits of a number at the even places.
fn spread(number: u32) -> u64 {
    STEPS.iter().fold(u64::from(number), |bits, &(by, mask)| (bits | bits << by) & mask)
}

/// The bits at the even places, as a number: the inverse of [`spread`].
#[expect(clippy::cast_possible_truncation, reason = "the upper half is masked")]
fn gathered(bits: u64) -> u32 {
    let apart = STEPS.iter().rev();
    apart.fold(bits, |bits, &(by, mask)| (bits & mask) | (bits & mask) >> by) as u32
}

/// log₂ of `nside`.
#[expect(clippy::cast_possible_truncation, reason = "at most 29")]
fn depth(nside: u32) -> u8 {
    nside.clamp(1, MAX_NSIDE).ilog2() as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use cdshealpix::nested;
    use core::f64::consts::PI;
    use proptest::prelude::*;

    fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
        (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
    }

    fn unit_vector((longitude, latitude): (f64, f64)) -> [f64; 3] {
        let (sin, cos) = longitude.sin_cos();
        [latitude.cos() * cos, latitude.cos() * sin, latitude.sin()]
    }

    /// The direction of a pixel's centre.
    fn centre(nside: u32, index: u64) -> [f64; 3] {
        let (face, x, y) = face_pixel(nside, index);
        let place = |pixel: u32| (f64::from(pixel) + 0.5) / f64::from(nside);
        sight_of_face(face, [place(x), place(y)])
    }

    #[test]
    fn pixel_centres_are_those_of_the_crate() {
        for depth in [0, 1, 2, 5, 13, 29] {
            let nside = 1 << depth;
            let pixels = 12 << (2 * depth);
            // All pixels of small maps, some thousand of the others; 7919 is prime.
            let step = if pixels < 20_000 { 1 } else { pixels / 7919 };
            for index in (0..pixels).step_by(usize::try_from(step).unwrap()) {
                let expected = nested::center(depth, index);
                let found = centre(nside, index);
                assert!(distance(found, unit_vector(expected)) < 1e-15, "{nside} {index}");
                let (face, x, y) = face_pixel(nside, index);
                assert!(face < 12 && x < nside && y < nside);
                assert_eq!(nested_index(nside, face, x, y), index);
                assert_eq!(nested::hash(depth, expected.0, expected.1), index);
                assert_eq!(pixel_of_direction(nside, found), index);
            }
        }
    }

    /// healpy 1.20.1: `healpy.pix2vec(nside, index, nest=True)`.
    #[test]
    fn pixel_centres_are_those_of_healpy() {
        for (nside, index, expected) in HEALPY {
            assert!(distance(centre(nside, index), expected) < 1e-15, "{nside} {index}");
        }
    }

    const HEALPY: [(u32, u64, [f64; 3]); 9] = [
        (1, 0, [0.5270462766947299, 0.5270462766947298, 0.6666666666666666]),
        (1, 11, [0.5270462766947298, -0.52704627669473, -0.6666666666666666]),
        (4, 86, [-0.19509032201612797, 0.9807852804032305, 0.0]),
        (4, 191, [0.6972166887783962, -0.6972166887783965, -0.16666666666666666]),
        (64, 17, [0.661120730843006, 0.7476718058410451, 0.0625]),
        (64, 12345, [0.69289870405881, -0.7101171635115021, 0.125]),
        (64, 49151, [0.7070684171477167, -0.7070684171477171, -0.010416666666666666]),
        (1024, 4194303, [0.0005638185774472137, -0.000563818577447214, 0.9999996821085612]),
        (1024, 9999999, [-0.13169168812566026, 0.5727728793937044, -0.8090664545694988]),
    ];

    #[test]
    fn bits_of_x_are_even_and_bits_of_y_are_odd() {
        for (x, y) in [(0, 0), (1, 0), (0, 1), (5, 3), (1000, 7), ((1 << 29) - 1, 1 << 28)] {
            let interleaved = (0..29)
                .map(|bit| {
                    let [x, y] = [x, y].map(|value: u32| u64::from(value >> bit & 1));
                    (x | y << 1) << (2 * bit)
                })
                .sum::<u64>();
            assert_eq!(nested_index(MAX_NSIDE, 11, x, y), (11 << 58) + interleaved);
        }
    }

    #[test]
    fn neighbouring_faces_meet_at_their_edges() {
        for step in 0..=16 {
            let along = f64::from(step) / 16.0;
            for column in 0..4 {
                let (east, west) = ((column + 1) % 4, (column + 3) % 4);
                let pairs = [
                    ((column, [1.0, along]), (east, [along, 1.0])),
                    ((column, [along, 0.0]), (4 + east, [along, 1.0])),
                    ((column, [0.0, along]), (4 + column, [1.0, along])),
                    ((4 + column, [along, 0.0]), (8 + column, [along, 1.0])),
                    ((4 + column, [0.0, along]), (8 + west, [1.0, along])),
                    ((8 + column, [along, 0.0]), (8 + east, [0.0, along])),
                ];
                for ((face, xy), (other, there)) in pairs {
                    let apart = distance(sight_of_face(face, xy), sight_of_face(other, there));
                    assert!(apart < 2e-15, "{face} {xy:?}, {other} {there:?}: {apart}");
                }
            }
        }
    }

    #[test]
    fn corners_and_edges_are_found_again() {
        let ends = [0.0, 1e-14, 0.25, 0.5, 1.0 - 1e-14, 1.0];
        for face in 0..FACES {
            for xy in ends.into_iter().flat_map(|x| ends.map(|y| [x, y])) {
                let sight = sight_of_face(face, xy);
                let (found, place) = face_of_direction(sight);
                assert!(found < FACES && place.iter().all(|p| (-1e-13..=1.0 + 1e-13).contains(p)));
                // An edge may be found on the other face, but it is the same direction.
                let clamped = place.map(|p| p.clamp(0.0, 1.0));
                assert!(distance(sight_of_face(found, clamped), sight) < 1e-13, "{face} {xy:?}");
            }
        }
    }

    proptest! {
        #[test]
        fn the_inverse_finds_each_point_again(
            face in 0..FACES,
            x in 1e-9..1.0 - 1e-9,
            y in 1e-9..1.0 - 1e-9,
            length in 1e-3..1e3,
        ) {
            let sight = sight_of_face(face, [x, y]);
            prop_assert!((sight.iter().map(|s| s * s).sum::<f64>() - 1.0).abs() < 1e-15);
            let (found, place) = face_of_direction(sight.map(|component| length * component));
            prop_assert_eq!(found, face);
            // Near a pole a step of 1e-16 in the direction is as small a step on the face.
            prop_assert!((place[0] - x).abs() < 1e-12 && (place[1] - y).abs() < 1e-12);
        }

        #[test]
        fn areas_are_equal(face in 0..FACES, x in 0.001..0.999_f64, y in 0.001..0.999_f64) {
            const STEP: f64 = 1e-5;
            // No central difference across the kink where the caps begin.
            prop_assume!((x + y - 1.0).abs() > 4.0 * STEP);
            let derivative = |dx: f64, dy: f64| {
                let high = sight_of_face(face, [x + dx, y + dy]);
                let low = sight_of_face(face, [x - dx, y - dy]);
                [0, 1, 2].map(|i| (high[i] - low[i]) / (2.0 * STEP))
            };
            let (a, b) = (derivative(STEP, 0.0), derivative(0.0, STEP));
            let sight = sight_of_face(face, [x, y]);
            let cross =
                [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            let area: f64 = (0..3).map(|i| cross[i] * sight[i]).sum();
            // Positive: seen from outside, x to y is counterclockwise.
            let poleward = match face / 4 { 0 => 2.0 - x - y, 2 => x + y, _ => 1.0 };
            let tolerance = 1e-8 + STEP * STEP / poleward.powi(2);
            prop_assert!((area - 4.0 * PI / 12.0).abs() < 10.0 * tolerance, "{area}");
        }
    }
}
