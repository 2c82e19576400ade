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

    /// f at (u, v).
    fn height(&self, u: f64, v: f64) -> f64 {
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
        height
    }

    /// The gradient of f at (u, v).
    fn gradient(&self, u: f64, v: f64) -> [f64; 2] {
        let c = &self.coefficients;
        let (uu, vv) = (u * u, v * v);
        let [mut of_u, mut of_v] = [c[1], c[2]];
        if self.degree >= 2 {
            of_u = of_u + c[3] * 2.0 * u + c[4] * v;
            of_v = of_v + c[4] * u + c[5] * 2.0 * v;
        }
        if self.degree >= 3 {
            of_u = of_u + c[6] * 3.0 * uu + c[7] * 2.0 * u * v + c[8] * vv;
            of_v = of_v + c[7] * uu + c[8] * 2.0 * u * v + c[9] * 3.0 * vv;
        }
        if self.degree >= 4 {
            let (uuu, vvv) = (uu * u, vv * v);
            of_u = of_u + c[10] * 4.0 * uuu + c[11] * 3.0 * uu * v;
            of_u = of_u + c[12] * 2.0 * u * vv + c[13] * vvv;
            of_v = of_v + c[11] * uuu + c[12] * 2.0 * uu * v;
            of_v = of_v + c[13] * 3.0 * u * vv + c[14] * 4.0 * vvv;
        }
        [of_u, of_v]
    }

    /// The height of a point above the surface along w: above 0 on the upper side.
    pub(super) fn above(&self, at: [f64; 3]) -> f64 {
        let [u, v, w] = self.local(at);
        (w - self.height(u, v)) * self.scale
    }

    /// The height above the surface on the line along z through a point, as a polynomial: its coefficients
    /// of the powers of the distance from there.
    pub(super) fn above_along_z(&self, from: [f64; 3]) -> [f64; DEGREE + 1] {
        let [u, v, w] = self.local(from);
        let [du, dv, dw] = self.axes.map(|axis| axis[2] / self.scale);
        let c = &self.coefficients;
        let mut height = [c[0] + c[1] * u + c[2] * v, c[1] * du + c[2] * dv, 0.0, 0.0, 0.0];
        let mut add = |terms: &[f64]| height.iter_mut().zip(terms).for_each(|(to, of)| *to += of);
        let product = |[a, da]: [f64; 2], [b, db]: [f64; 2]| [a * b, a * db + da * b, da * db];
        let (u, v) = ([u, du], [v, dv]);
        let (uu, uv, vv) = (product(u, u), product(u, v), product(v, v));
        let sum = |a: f64, b: f64, c: f64| [0, 1, 2].map(|k| a * uu[k] + b * uv[k] + c * vv[k]);
        if self.degree >= 2 {
            add(&sum(c[3], c[4], c[5]));
        }
        if self.degree >= 3 {
            let times = |[a, da]: [f64; 2], [b, db, ddb]: [f64; 3]| {
                [a * b, a * db + da * b, a * ddb + da * db, da * ddb]
            };
            add(&times(u, sum(c[6], c[7], c[8])));
            add(&times(v, sum(0.0, 0.0, c[9])));
        }
        if self.degree >= 4 {
            let times = |a: [f64; 3], b: [f64; 3]| {
                let middle = a[0] * b[2] + a[1] * b[1] + a[2] * b[0];
                let [first, last] = [a[0] * b[1] + a[1] * b[0], a[1] * b[2] + a[2] * b[1]];
                [a[0] * b[0], first, middle, last, a[2] * b[2]]
            };
            add(&times(uu, sum(c[10], c[11], c[12])));
            add(&times(vv, sum(0.0, c[13], c[14])));
        }
        let [first, second, ..] = height;
        height = height.map(|of| -of * self.scale);
        height[0] = (w - first) * self.scale;
        height[1] = (dw - second) * self.scale;
        height
    }

    /// Whether all points of a box, of which two corners are given, are on one side, by a bound: most
    /// boxes beside the surface are found to be, not all.
    pub(super) fn is_on_one_side(&self, [low, high]: [[f64; 3]; 2]) -> bool {
        const ROUNDING: f64 = 1e-9;
        let middle = core::array::from_fn(|k| 0.5 * (low[k] + high[k]));
        let reach = |direction: [f64; 3]| -> f64 {
            (0..3).map(|k| 0.5 * (high[k] - low[k]) * direction[k].abs()).sum()
        };
        let [u, v, _] = self.local(middle);
        let [fu, fv] = self.gradient(u, v);
        let slope = along(along(self.axes[2], -fu, self.axes[0]), -fv, self.axes[1]);
        // Taylor's remainder of second order is at most that of the polynomial with |coefficients|.
        let most = Self { coefficients: self.coefficients.map(f64::abs), ..*self };
        let [du, dv] = [0, 1].map(|k| reach(self.axes[k]) / self.scale);
        let (u, v) = (u.abs(), v.abs());
        let [mu, mv] = most.gradient(u, v);
        let rest = most.height(u + du, v + dv) - most.height(u, v) - mu * du - mv * dv;
        self.above(middle).abs()
            > (1.0 + ROUNDING) * (reach(slope) + rest * self.scale) + ROUNDING * self.scale
    }

    /// The point of the surface below or above a point along w.
    pub(super) fn foot(&self, at: [f64; 3]) -> [f64; 3] {
        along(at, -self.above(at), self.axes[2])
    }

    /// The unit normal, towards the upper side, where a line along w through a point meets the surface.
    pub(super) fn normal(&self, at: [f64; 3]) -> [f64; 3] {
        let [u, v, _] = self.local(at);
        let [fu, fv] = self.gradient(u, v);
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
        let mut columns = Columns::new(weighted.collect(), TERMS);
        let powers: Vec<[[f64; DEGREE + 1]; 2]> =
            local.iter().map(|at| [powers(at[0]), powers(at[1])]).collect();
        let mut best: Option<(Self, f64)> = None;
        'degrees: for degree in 0..=DEGREE {
            let terms = (degree + 1) * (degree + 2) / 2;
            if (points.len() as f64) < 1.25 * terms as f64 + 1.0 {
                break;
            }
            for j in 0..=degree {
                let power = |[u, v]: &[[f64; DEGREE + 1]; 2]| u[degree - j] * v[j];
                let column = powers.iter().zip(&weights).map(|(at, weight)| power(at) * weight);
                if !columns.add(column) {
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

/// The powers of a number.
fn powers(x: f64) -> [f64; DEGREE + 1] {
    let square = x * x;
    [1.0, x, square, x * square, square * square]
}

#[cfg(test)]
mod tests;
