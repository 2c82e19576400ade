//! Where a line of sight crosses the patches in a cell.

use crate::vol::surfaces::patch::Patch;

/// The parts of a line in a cell in which a patch is crossed at most twice.
const PARTS: usize = 4;
/// The most steps of the search for a crossing.
const STEPS: usize = 60;
/// The precision of a crossing, as a share of its part.
const PRECISION: f64 = 1e-10;

/// Finds the depths, ascending, at which the line at (x, y) crosses patches of a cell between two depths,
/// whether the region changes there or not.
pub(super) fn find_crossings(
    patches: &[&Patch],
    xy: [f64; 2],
    ends: [f64; 2],
    found: &mut Vec<f64>,
) {
    found.clear();
    patches.iter().for_each(|patch| add_crossings(patch, xy, ends, found));
    found.sort_by(f64::total_cmp);
}

/// Adds the crossings of one patch: between heights of different signs, and where three heights of one
/// sign have an extremum with the other.
fn add_crossings(patch: &Patch, [x, y]: [f64; 2], [from, to]: [f64; 2], found: &mut Vec<f64>) {
    let step = (to - from) / PARTS as f64;
    let above = patch.above_along_z([x, y, from]);
    let height = |z: f64| above.iter().rev().fold(0.0, |sum, c| sum * (z - from) + c);
    let places: [f64; PARTS + 1] = core::array::from_fn(|k| from + step * k as f64);
    let heights = places.map(height);
    for k in 0..PARTS {
        if heights[k] * heights[k + 1] <= 0.0 {
            found.push(root(&height, [places[k], places[k + 1]], [heights[k], heights[k + 1]]));
        }
    }
    for k in 1..PARTS {
        let [a, b, c] = [heights[k - 1], heights[k], heights[k + 1]];
        let is_extreme = a * b > 0.0 && b * c > 0.0 && b.abs() <= a.abs().min(c.abs());
        if !is_extreme {
            continue;
        }
        // The extremum of the parabola through the three.
        let bend = a - 2.0 * b + c;
        let z = places[k] + 0.5 * step * (a - c) / bend;
        let middle = height(z);
        if middle * b < 0.0 {
            found.push(root(&height, [places[k - 1], z], [a, middle]));
            found.push(root(&height, [z, places[k + 1]], [middle, c]));
        }
    }
}

/// A root between two places with values of different signs, by the Illinois method (Dowell and Jarratt
/// 1971, doi:10.1007/BF01934364).
fn root(height: &impl Fn(f64) -> f64, places: [f64; 2], values: [f64; 2]) -> f64 {
    let ([mut a, mut b], [mut fa, mut fb]) = (places, values);
    let width = PRECISION * (b - a).abs();
    for _ in 0..STEPS {
        if fb == 0.0 || (b - a).abs() <= width {
            return b;
        }
        let c = b - fb * (b - a) / (fb - fa);
        if (c - b).abs() <= width {
            return c;
        }
        let fc = height(c);
        if fc * fb < 0.0 {
            (a, fa) = (b, fb);
        } else {
            fa *= 0.5;
        }
        (b, fb) = (c, fc);
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::lattice;
    use crate::vol::surfaces::patch::FitPoint;

    /// A patch through places on a surface whose normal is about along an axis.
    fn patch(axis: usize, place: impl Fn(f64, f64) -> [f64; 3]) -> Patch {
        let point = |k: usize| {
            let [u, v, _] = lattice::point(k);
            let distance = (u - 0.5).hypot(v - 0.5);
            FitPoint { at: place(u, v), axis, is_upward: true, distance }
        };
        let mut points: Vec<FitPoint> = (0..60).map(point).collect();
        points.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        let normal = core::array::from_fn(|k| f64::from(u8::from(k == axis)));
        Patch::fit(&points, [0.5; 3], normal, 0.5, 0.0).unwrap().0
    }

    fn crossings(patches: &[Patch], xy: [f64; 2], ends: [f64; 2]) -> Vec<f64> {
        let mut found = vec![0.1];
        find_crossings(&patches.iter().collect::<Vec<_>>(), xy, ends, &mut found);
        found
    }

    #[test]
    fn patches_nearer_to_each_other_than_the_parts_are_both_crossed() {
        let patches = [
            patch(2, |x, y| [x, y, 0.41 + 0.1 * x - 0.2 * y]),
            patch(2, |x, y| [x, y, 0.42 + 0.1 * x * y]),
        ];
        let (x, y) = (0.3, 0.1);
        let found = crossings(&patches, [x, y], [0.0, 1.0]);
        let [first, second] = found[..] else { panic!("{found:?}") };
        assert!((first - (0.41 + 0.1 * x - 0.2 * y)).abs() < 1e-8, "{first}");
        assert!((second - (0.42 + 0.1 * x * y)).abs() < 1e-8, "{second}");
        assert!(crossings(&patches, [x, y], [0.5, 1.0]).is_empty());
    }

    #[test]
    fn a_patch_that_a_line_nearly_touches_is_crossed_twice() {
        for depth in [1e-1, 1e-3, 1e-5] {
            let bowl = |y: f64, z: f64| 0.5 - depth + (z - 0.55).powi(2) + 0.3 * (y - 0.5);
            let patch = patch(0, |y, z| [bowl(y, z), y, z]);
            let found = crossings(&[patch], [0.5, 0.5], [0.0, 1.0]);
            let [first, second] = found[..] else { panic!("{depth}: {found:?}") };
            let half = depth.sqrt();
            assert!((first - (0.55 - half)).abs() < 1e-4 * half + 1e-9, "{depth}: {first}");
            assert!((second - (0.55 + half)).abs() < 1e-4 * half + 1e-9, "{depth}: {second}");
        }
    }
}
