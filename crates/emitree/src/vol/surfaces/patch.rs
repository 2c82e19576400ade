//! Patches: surfaces as heights over a tangent plane, polynomials of degree 4 or less.

use crate::projection::vector::{along, cross, difference, dot, norm, unit};
use crate::vol::surfaces::columns::Columns;
use crate::vol::tuning::TUNING;

/// The highest degree of a height.
const DEGREE: usize = 4;
/// The number of its coefficients.
const TERMS: usize = (DEGREE + 1) * (DEGREE + 2) / 2;

/// A surface near a point: w = f(u, v) in a frame of unit vectors u, v and w, scaled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Patch {
    centre: [f64; 3],
    axes: [[f64; 3]; 3],
    scale: f64,
    degree: usize,
    coefficients: [f64; TERMS],
}

/// A point of a surface for a fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct FitPoint {
    pub(super) at: [f64; 3],
    /// The axis along which it was found, and whether the upper side is at its higher end.
    pub(super) axis: usize,
    pub(super) is_upward: bool,
    /// The distance from the centre of the cell.
    pub(super) distance: f64,
}

impl Patch {
    /// Coordinates in the frame.
    fn local(&self, at: [f64; 3]) -> [f64; 3] {
        let from = difference(at, self.centre);
        self.axes.map(|axis| dot(axis, from) / self.scale)
    }

    /// f and its gradient at (u, v).
    fn height(&self, u: f64, v: f64) -> (f64, [f64; 2]) {
        let (mut sum, mut gradient, mut k) = (0.0, [0.0; 2], 0);
        let powers = |x: f64| {
            let mut powers = [1.0; DEGREE + 1];
            (1..=DEGREE).for_each(|n| powers[n] = powers[n - 1] * x);
            powers
        };
        let (us, vs) = (powers(u), powers(v));
        for n in 0..=self.degree {
            for j in 0..=n {
                let (c, i) = (self.coefficients[k], n - j);
                sum += c * us[i] * vs[j];
                if i > 0 {
                    gradient[0] += c * i as f64 * us[i - 1] * vs[j];
                }
                if j > 0 {
                    gradient[1] += c * j as f64 * us[i] * vs[j - 1];
                }
                k += 1;
            }
        }
        (sum, gradient)
    }

    /// The height of a point above the surface along w: above 0 on the upper side.
    pub(super) fn above(&self, at: [f64; 3]) -> f64 {
        let [u, v, w] = self.local(at);
        let c = &self.coefficients;
        let (uu, vv, uv) = (u * u, v * v, u * v);
        let mut height = c[0] + c[1] * u + c[2] * v;
        if self.degree >= 2 {
            height += c[3] * uu + c[4] * uv + c[5] * vv;
        }
        if self.degree >= 3 {
            height += u * (c[6] * uu + c[7] * uv + c[8] * vv) + c[9] * v * vv;
        }
        if self.degree >= 4 {
            height += uu * (c[10] * uu + c[11] * uv + c[12] * vv) + vv * (c[13] * uv + c[14] * vv);
        }
        (w - height) * self.scale
    }

    /// The point of the surface below or above a point along w.
    pub(super) fn foot(&self, at: [f64; 3]) -> [f64; 3] {
        along(at, -self.above(at), self.axes[2])
    }

    /// The unit normal, towards the upper side, where a line along w through a point meets the surface.
    pub(super) fn normal(&self, at: [f64; 3]) -> [f64; 3] {
        let [u, v, _] = self.local(at);
        let (_, [fu, fv]) = self.height(u, v);
        let normal = along(along(self.axes[2], -fu, self.axes[0]), -fv, self.axes[1]);
        unit(normal).unwrap_or(self.axes[2])
    }

    /// The normal of the tangent plane.
    pub(super) fn axis(&self) -> [f64; 3] {
        self.axes[2]
    }

    /// The directions of u and v.
    pub(super) fn tangents(&self) -> [[f64; 3]; 2] {
        [self.axes[0], self.axes[1]]
    }

    /// The largest |curvature| at the centre, about. One above the inverse of the size is that of a fit
    /// to an edge, not of a smooth surface.
    pub(super) fn curvature(&self) -> f64 {
        if self.degree < 2 {
            return 0.0;
        }
        let [a, b, c] = [3, 4, 5].map(|k| self.coefficients[k]);
        let (mean, half) = (a + c, ((a - c).powi(2) + b * b).sqrt());
        (mean.abs() + half).min(1.0) / self.scale
    }

    /// The point of the surface at its centre.
    pub(super) fn middle(&self) -> [f64; 3] {
        self.foot(self.centre)
    }

    /// The patch that fits points, with its error: that with the least leave-one-out error of all
    /// degrees up to the first with an error below `enough`. `normal` points to the upper side, `size`
    /// is that of the cell.
    pub(super) fn fit(
        points: &[FitPoint],
        cell: [f64; 3],
        normal: [f64; 3],
        size: f64,
        enough: f64,
    ) -> Option<(Self, f64)> {
        let kept: Vec<FitPoint> = oriented(points, normal, TUNING.surfaces.first_tilt);
        let near = kept.iter().take(TUNING.surfaces.centre_points);
        let count = near.len().max(1) as f64;
        let centre = near.fold([0.0; 3], |sum, point| along(sum, 1.0 / count, point.at));
        let first = Self::fit_in(&kept, centre, normal, size, enough)?;
        // Again in the frame of the surface itself, where the cell is nearest to it.
        let foot = first.0.foot(cell);
        let is_far = norm(difference(foot, cell)) > 2.0 * size;
        let centre = if is_far { centre } else { foot };
        let normal = first.0.normal(centre);
        let kept: Vec<FitPoint> = oriented(points, normal, TUNING.surfaces.second_tilt);
        match Self::fit_in(&kept, centre, normal, size, enough) {
            Some(second) if second.1 <= first.1 => Some(second),
            _ => Some(first),
        }
    }

    /// The same in a given frame.
    fn fit_in(
        points: &[FitPoint],
        centre: [f64; 3],
        normal: [f64; 3],
        size: f64,
        enough: f64,
    ) -> Option<(Self, f64)> {
        let across = if normal[0].abs() < 0.8 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let u = unit(cross(normal, across))?;
        let axes = [u, cross(normal, u), normal];
        let empty = Self { centre, axes, scale: size, degree: 0, coefficients: [0.0; TERMS] };
        let local: Vec<[f64; 3]> = points.iter().map(|point| empty.local(point.at)).collect();
        let reach = TUNING.surfaces.reach * size;
        let weight = |point: &FitPoint| (-1.5 * (point.distance / reach).powi(2)).exp();
        let weights: Vec<f64> = points.iter().map(weight).collect();
        let is_near = |i: usize| i < 3 || points[i].distance < 0.5 * reach;
        let near: Vec<usize> = (0..points.len()).filter(|&i| is_near(i)).collect();
        let weighted = local.iter().zip(&weights).map(|(at, weight)| at[2] * weight);
        let mut columns = Columns::new(weighted.collect());
        let mut best: Option<(Self, f64)> = None;
        'degrees: for degree in 0..=DEGREE {
            let terms = (degree + 1) * (degree + 2) / 2;
            if (points.len() as f64) < 1.25 * terms as f64 + 1.0 {
                break;
            }
            for j in 0..=degree {
                let power =
                    |at: &[f64; 3]| at[0].powi(exponent(degree - j)) * at[1].powi(exponent(j));
                let column = local.iter().zip(&weights).map(|(at, weight)| power(at) * weight);
                if !columns.add(column.collect()) {
                    break 'degrees;
                }
            }
            if degree == 0 {
                continue;
            }
            let square = |&i: &usize| (columns.left_out(i) / weights[i]).powi(2);
            let mean = near.iter().map(square).sum::<f64>() / near.len().max(1) as f64;
            let error = TUNING.surfaces.patch_margin * mean.sqrt() * size;
            if best.as_ref().is_none_or(|best| error < best.1) {
                let mut coefficients = [0.0; TERMS];
                let found = columns.coefficients();
                coefficients.iter_mut().zip(&found).for_each(|(to, from)| *to = *from);
                best = Some((Self { degree, coefficients, ..empty }, error));
            }
            if error <= enough {
                break;
            }
        }
        best
    }
}

/// The points whose orientation agrees with a normal, within a tilt.
fn oriented(points: &[FitPoint], normal: [f64; 3], tilt: f64) -> Vec<FitPoint> {
    points.iter().filter(|point| is_oriented(point, normal, tilt)).copied().collect()
}

/// Whether the orientation of a point agrees with a normal, within a tilt.
pub(super) fn is_oriented(point: &FitPoint, normal: [f64; 3], tilt: f64) -> bool {
    let upward = if point.is_upward { normal[point.axis] } else { -normal[point.axis] };
    upward > -tilt
}

fn exponent(power: usize) -> i32 {
    i32::try_from(power).unwrap_or(0)
}

#[cfg(test)]
mod tests;
