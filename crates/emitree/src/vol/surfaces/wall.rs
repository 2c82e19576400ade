//! Walls: the surface between two regions in a cell, of one smooth patch or of several that meet.
//!
//! At the edge of a box two patches meet, at its corner three; a thin sheet has one on each of its two
//! sides. In each of these cases one region is where all patches have it, and the other is where one of
//! them has it.

use crate::projection::vector::{along, dot, unit};
use crate::vol::surfaces::nearest::keep_nearest;
use crate::vol::surfaces::patch::{FitPoint, Patch, is_oriented};
use crate::vol::tuning::TUNING;

/// The most patches: at the corner of a box.
const MOST_PATCHES: usize = 3;
/// The points of a first plane.
const POINTS_OF_PLANE: usize = 6;
/// The times that points are assigned to the nearest patch and the patches fitted again.
const ASSIGNMENTS: usize = 4;

/// One patch, or several patches between two regions.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Wall {
    patches: Vec<Patch>,
    /// Whether the region above is where all patches have it, not where one of them does.
    is_above_all: bool,
}

impl From<Patch> for Wall {
    fn from(patch: Patch) -> Self {
        Self { patches: vec![patch], is_above_all: true }
    }
}

impl Wall {
    /// The patches.
    pub(super) fn patches(&self) -> &[Patch] {
        &self.patches
    }

    /// The patch that decides the side of a point, and the height of the point above it.
    fn deciding(&self, at: [f64; 3]) -> (usize, f64) {
        let sign = if self.is_above_all { 1.0 } else { -1.0 };
        let heights = self.patches.iter().map(|patch| patch.above(at)).enumerate();
        heights
            .reduce(|best, of| if sign * of.1 < sign * best.1 { of } else { best })
            .unwrap_or((0, 0.0))
    }

    /// The height of a point above the wall, along the normal of the frame of the patch that decides:
    /// above 0 on the upper side.
    pub(super) fn above(&self, at: [f64; 3]) -> f64 {
        match &self.patches[..] {
            [only] => only.above(at),
            _ => self.deciding(at).1,
        }
    }

    /// The patch that decides the side of a point.
    pub(super) fn patch_at(&self, at: [f64; 3]) -> &Patch {
        &self.patches[self.deciding(at).0]
    }

    /// The unit normal, towards the upper side, of the patch that decides the side of a point.
    pub(super) fn normal(&self, at: [f64; 3]) -> [f64; 3] {
        self.patch_at(at).normal(at)
    }

    /// The edge between two patches beside a point: a point of it, and a step upwards in which the heights above both
    /// rise by 1. `None` where they are nearly parallel.
    pub(super) fn edge(
        &self,
        (i, j): (usize, usize),
        from: [f64; 3],
    ) -> Option<([f64; 3], [f64; 3])> {
        const STEPS: usize = 4;
        const LEAST_SINE: f64 = 1e-2;
        // The planes that touch the patches at a point: the height above each along its normal, their normals, and the
        // cosine and the squared sine between these.
        let tangent = |at: [f64; 3]| {
            let patches = [i, j].map(|k| &self.patches[k]);
            let normals = patches.map(|patch| patch.normal(at));
            let height = |k: usize| patches[k].above(at) * dot(patches[k].axis(), normals[k]);
            let cosine = dot(normals[0], normals[1]);
            let square = 1.0 - cosine * cosine;
            let heights = [height(0), height(1)];
            (square > LEAST_SINE * LEAST_SINE).then_some((heights, normals, cosine, square))
        };
        let mut at = from;
        for _ in 0..STEPS {
            let ([a, b], normals, cosine, square) = tangent(at)?;
            at = along(at, (cosine * b - a) / square, normals[0]);
            at = along(at, (cosine * a - b) / square, normals[1]);
        }
        let (_, normals, cosine, _) = tangent(at)?;
        let sum = along(normals[0], 1.0, normals[1]);
        Some((at, sum.map(|x| x / (1.0 + cosine))))
    }

    /// Several patches through points that no single one fits, with their error: as few as reach
    /// `wanted`. `size` is that of the cell, `cell` its centre, and the points are within so many
    /// reaches of it.
    pub(super) fn fit(
        points: &[FitPoint],
        cell: [f64; 3],
        (size, reaches): (f64, i32),
        wanted: f64,
    ) -> Option<(Self, f64)> {
        let planes = planes(points, cell, size);
        let wide = f64::from(reaches) * size;
        let mut chosen = Vec::new();
        let mut best: Option<(Self, f64)> = None;
        for count in 2..=MOST_PATCHES {
            chosen = with_one_more(&planes, points, &chosen, count, size)?;
            for belongs in [TUNING.surfaces.wall_belongs, TUNING.surfaces.wall_belongs_loosely] {
                let first = chosen.iter().map(|&k| planes[k]).collect();
                let found = Self::refined(
                    first,
                    points,
                    cell,
                    (size, wide),
                    (belongs * wide, TUNING.surfaces.wall_enough * wanted),
                );
                best = best.into_iter().chain(found).min_by(|a, b| a.1.total_cmp(&b.1));
            }
            if best.as_ref().is_some_and(|(_, error)| *error <= wanted) {
                break;
            }
        }
        best
    }

    /// Patches fitted to the points nearest to each of them, repeatedly.
    fn refined(
        mut patches: Vec<Patch>,
        points: &[FitPoint],
        cell: [f64; 3],
        (size, wide): (f64, f64),
        (belongs, enough): (f64, f64),
    ) -> Option<(Self, f64)> {
        let near = TUNING.surfaces.wall_near * size;
        let mut errors = vec![f64::INFINITY; patches.len()];
        let mut assigned: Vec<usize> = Vec::new();
        for _ in 0..ASSIGNMENTS {
            let next: Vec<usize> =
                points.iter().map(|point| nearest(&patches, point, near, belongs)).collect();
            if next == assigned {
                break;
            }
            assigned = next;
            for (k, (patch, error)) in patches.iter_mut().zip(&mut errors).enumerate() {
                let own = points.iter().zip(&assigned).filter(|(_, to)| **to == k);
                let own: Vec<FitPoint> = own.map(|(point, _)| *point).collect();
                (*patch, *error) = Patch::fit(&own, cell, patch.axis(), wide, enough)?;
            }
            if least_turn(&patches, cell) < TUNING.surfaces.wall_least_first_turn {
                return None;
            }
        }
        // Two parts of one smooth surface, continued to the same place, are no edge.
        if least_turn(&patches, cell) < TUNING.surfaces.wall_least_turn {
            return None;
        }
        let error = errors.into_iter().fold(0.0, f64::max);
        let both = [true, false].map(|is_above_all| {
            let wall = Self { patches: patches.clone(), is_above_all };
            // Points beside the edge that belong to another patch are as far from their own one.
            let displaced = |(point, own): (&FitPoint, &usize)| {
                let own = patches[*own].above(point.at).abs();
                (wall.above(point.at).abs() - own).max(0.0)
            };
            let all = points.iter().zip(&assigned).filter(|of| of.0.distance <= near);
            let worst = all.map(displaced).fold(0.0, f64::max);
            (wall, error.max(worst))
        });
        both.into_iter().min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// The least angle between the normals of two patches at a point, in radians.
fn least_turn(patches: &[Patch], at: [f64; 3]) -> f64 {
    let normals: Vec<[f64; 3]> = patches.iter().map(|patch| patch.normal(at)).collect();
    let pairs = (0..normals.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let cosines = pairs.map(|(i, j)| dot(normals[i], normals[j]));
    cosines.fold(-1.0_f64, f64::max).min(1.0).acos()
}

/// The patch that is nearest to a point, of those with its orientation; their number for a point
/// beside the cell that belongs to none.
fn nearest(patches: &[Patch], point: &FitPoint, near: f64, belongs: f64) -> usize {
    let distance = |patch: &Patch| {
        let is_oriented = is_oriented(point, patch.normal(point.at), TUNING.surfaces.second_tilt);
        if is_oriented { patch.above(point.at).abs() } else { f64::INFINITY }
    };
    let all = patches.iter().map(distance).enumerate();
    let (best, distance) =
        all.reduce(|best, of| if of.1 < best.1 { of } else { best }).unwrap_or((0, 0.0));
    let is_of_it = point.distance <= near || distance <= belongs;
    if is_of_it { best } else { patches.len() }
}

/// Planes through neighbouring points.
fn planes(points: &[FitPoint], cell: [f64; 3], size: f64) -> Vec<Patch> {
    let step = points.len().div_ceil(TUNING.surfaces.wall_planes).max(1);
    let plane = |middle: &FitPoint| {
        let square =
            |point: &FitPoint| (0..3).map(|k| (point.at[k] - middle.at[k]).powi(2)).sum::<f64>();
        let mut near: Vec<(f64, usize)> = points.iter().map(square).zip(0..).collect();
        keep_nearest(&mut near, POINTS_OF_PLANE);
        let near: Vec<FitPoint> = near.into_iter().map(|(_, i)| points[i]).collect();
        Patch::fit(&near, cell, mean_orientation(&near)?, size, 0.0).map(|(patch, _)| patch)
    };
    points.iter().step_by(step).filter_map(plane).collect()
}

/// Those planes to which the points are nearest: all pairs are compared, and each further one is added
/// to those chosen.
fn with_one_more(
    planes: &[Patch],
    points: &[FitPoint],
    chosen: &[usize],
    count: usize,
    size: f64,
) -> Option<Vec<usize>> {
    // Outliers do not decide.
    let most = 0.5 * size;
    let distances = |plane: &Patch| -> Vec<f64> {
        let normal = plane.normal(plane.middle());
        let distance = |point: &FitPoint| {
            let is_oriented = is_oriented(point, normal, TUNING.surfaces.second_tilt);
            if is_oriented { plane.above(point.at).abs().min(most) } else { most }
        };
        points.iter().map(distance).collect()
    };
    let distances: Vec<Vec<f64>> = planes.iter().map(distances).collect();
    let weight = |point: &FitPoint| {
        let is_near = point.distance <= TUNING.surfaces.wall_near * size;
        if is_near { 1.0 } else { TUNING.surfaces.wall_far_weight }
    };
    let weights: Vec<f64> = points.iter().map(weight).collect();
    let least =
        |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a.min(*b)).collect() };
    let cost = |a: &[f64], b: &[f64]| -> f64 {
        weights.iter().zip(a).zip(b).map(|((weight, a), b)| weight * a.min(*b)).sum()
    };
    let best =
        |costs: &mut dyn Iterator<Item = (f64, usize)>| costs.min_by(|a, b| a.0.total_cmp(&b.0));
    if chosen.len() + 1 == count {
        let own = chosen.iter().fold(vec![most; points.len()], |a, &k| least(&a, &distances[k]));
        let mut costs = distances.iter().map(|of| cost(&own, of)).zip(0..);
        return best(&mut costs).map(|(_, k)| [chosen, &[k][..]].concat());
    }
    let pair = |i: usize| {
        let costs = distances[..i].iter().map(|of| cost(&distances[i], of));
        best(&mut costs.zip(0..)).map(|(cost, j)| (cost, vec![j, i]))
    };
    let pairs = (0..planes.len()).filter_map(pair);
    pairs.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, set)| set)
}

/// A direction for the first normal of a wall, from the orientations of points.
pub(super) fn mean_orientation(points: &[FitPoint]) -> Option<[f64; 3]> {
    let sum = points.iter().fold([0.0; 3], |sum, point| {
        let mut upward = [0.0; 3];
        upward[point.axis] = if point.is_upward { 1.0 } else { -1.0 };
        along(sum, 1.0, upward)
    });
    unit(sum)
}

#[cfg(test)]
mod tests;
