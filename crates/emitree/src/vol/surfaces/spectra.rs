//! The spectra of a cube beside its surfaces: points of all regions, and checks on new lines of sight.

use crate::cell::whole;
use crate::parallel::prelude::*;
use crate::vol::dyadic::{from_unit, unit};
use crate::vol::lattice;
use crate::vol::spectrum::probes::{ProbePoint, SpectralProbes, SpotCheck, energy_of_check};
use crate::vol::surfaces::attempt::Located;
use crate::vol::surfaces::channel::KnownSample;
use crate::vol::surfaces::octree::{HIDDEN, Label, Leaf};
use crate::vol::surfaces::rays::{Ray, Segment};
use crate::vol::tuning::TUNING;

/// The number of the first check in the sequence of scattered points, beyond those of verifications.
const FIRST_CHECK: usize = 1 << 27;
/// How far beyond the surfaces every second check may be, as a share of the extent of all surfaces.
const MARGIN_OF_CHECKS: f64 = 0.25;

/// A point beside the surfaces.
#[derive(Clone, Copy, Debug)]
pub(super) struct RegionPoint {
    pub(super) point: ProbePoint,
    pub(super) at: [f64; 3],
    pub(super) label: Label,
    /// The change of a pixel by a change of G over the whole path of the point.
    pub(super) path: f64,
}

impl Located<'_> {
    /// The points at which spectra are sampled: as many in each region, half of them where it is brightest.
    pub(super) fn spectral_points(&self) -> Vec<RegionPoint> {
        let regions = self.model.pieces.iter().filter(|of| of.is_some()).count().max(1);
        let of_region =
            (TUNING.surfaces.spectral_points / regions).max(TUNING.surfaces.least_spectral_points);
        let scattered: Vec<RegionPoint> = (0..TUNING.surfaces.spectral_candidates)
            .filter_map(|k| self.region_point(lattice::point(k)))
            .collect();
        let mut chosen = Vec::new();
        for label in
            (0..).zip(&self.model.pieces).filter_map(|(label, of)| of.as_ref().map(|_| label))
        {
            let mut own: Vec<RegionPoint> =
                scattered.iter().filter(|of| of.label == label).copied().collect();
            if own.len() < of_region {
                let samples =
                    (0..self.search.samples.len()).filter(|&i| self.search.samples.is_of(i, label));
                let places =
                    samples.map(|i| self.search.grid.canonical(self.search.samples.get(i).at));
                let more =
                    places.filter_map(|u| self.region_point(u)).filter(|of| of.label == label);
                own.extend(more.take(of_region));
            }
            let effect = |of: &RegionPoint| of.path * self.model.value(of.at).abs();
            let spread = own.len().div_ceil(of_region.div_ceil(2)).max(1);
            let mut taken: Vec<RegionPoint> = own.iter().step_by(spread).copied().collect();
            own.sort_by(|a, b| effect(b).total_cmp(&effect(a)));
            taken.extend(own.iter().take(of_region / 2));
            chosen.extend(taken);
        }
        chosen
    }

    /// A canonical point, if it is in view and not near a surface.
    fn region_point(&self, u: [f64; 3]) -> Option<RegionPoint> {
        let [x, y, depth] = u.map(from_unit);
        let point = ProbePoint { part: 0, place: [x, y], depth };
        let u = [x, y, depth].map(unit);
        let at = self.search.grid.at_canonical(u);
        let label = self.model.tree.leaf(at).region(at);
        let path = self.path(u);
        let is_good = label != HIDDEN
            && path > 0.0
            && self.search.is_well_inside(&self.model.tree, label, at);
        is_good.then_some(RegionPoint { point, at, label, path })
    }

    /// The change of a pixel by a change of G at a point over a path as long as that with its value at the first
    /// energy that would have the integral of the line, at most the whole line.
    fn path(&self, u: [f64; 3]) -> f64 {
        let grid = &self.search.grid;
        let aim = &self.search.aim;
        let at = grid.at_canonical(u);
        let xy = [at[0], at[1]];
        let ray = Ray::new(&self.model.tree, xy, aim.ends_of_line(grid, xy));
        let of_segment =
            |segment| self.model.integral(xy, core::iter::once(segment), 0.0).value.abs();
        let bright: f64 = ray.segments.iter().copied().map(of_segment).sum();
        let path = bright / self.model.value(at).abs();
        let path = if path > 0.0 { path.min(1.0) } else { 1.0 };
        path * aim.effect([u[0], u[1]])
    }

    /// The samples of a channel at the points with spectra: the sum of the rates at places of the energy axis,
    /// each with a weight.
    pub(super) fn known_samples(
        &self,
        points: &[RegionPoint],
        probes: &SpectralProbes<'_>,
        terms: &[(u32, f64)],
    ) -> Vec<KnownSample> {
        let mut known = Vec::new();
        for of in points {
            let Some(probe) = probes.probes.iter().find(|probe| probe.point == of.point) else {
                continue;
            };
            let rate =
                terms.iter().map(|(place, weight)| weight * probe.spectrum.rate(*place)).sum();
            known.push(KnownSample { label: of.label, at: of.at, rate });
        }
        known
    }

    /// New points, each with an energy of its own: every second one anywhere in view, the others on lines about the
    /// surfaces in any segment, as often in short ones as in long ones. `expected` is G at a point and an energy.
    pub(super) fn checks(
        &self,
        round: usize,
        expected: impl Fn(&RegionPoint, u32) -> f64 + Sync,
    ) -> Vec<(RegionPoint, SpotCheck)> {
        let count = TUNING.surfaces.spectral_checks;
        let first = FIRST_CHECK + round * count;
        let ends = self.ends_of_surfaces();
        let check = |number: usize| {
            let energy = energy_of_check(number);
            let of = self.region_point(self.place_of_check(number, ends))?;
            let expected = expected(&of, energy);
            let (point, path, weight) = (of.point, of.path, 1.0);
            Some((of, SpotCheck { point, energy, path, weight, expected }))
        };
        (first..first + count).into_par_iter().filter_map(check).collect()
    }

    /// The canonical ends, along the axes of the image, of what is around all surfaces: another body is often near them.
    fn ends_of_surfaces(&self) -> [[f64; 2]; 2] {
        let tree = &self.model.tree;
        let leaves = tree.leaves.iter().enumerate();
        let cut: Vec<usize> = leaves
            .filter(|(_, (_, leaf))| matches!(leaf, Leaf::Cut(_)))
            .map(|(number, _)| number)
            .collect();
        [0, 1].map(|axis| {
            let edge = self.search.grid.edges[axis];
            let ends = cut.iter().map(|leaf| tree.ends(*leaf, axis).map(|end| end / edge));
            let around = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [a, b]| {
                [low.min(a), high.max(b)]
            });
            let [low, high] = if around[0] < around[1] { around } else { [0.0, 1.0] };
            let margin = MARGIN_OF_CHECKS * (high - low);
            [(low - margin).max(0.0), (high + margin).min(1.0)]
        })
    }

    /// The canonical place of a check.
    fn place_of_check(&self, number: usize, ends: [[f64; 2]; 2]) -> [f64; 3] {
        let place @ [x, y, share] = lattice::point(number);
        if number.is_multiple_of(2) {
            return place;
        }
        let grid = &self.search.grid;
        let [x, y] = [(x, ends[0]), (y, ends[1])].map(|(at, [low, high])| low + at * (high - low));
        let xy = [x * grid.edges[0], y * grid.edges[1]];
        let ray = Ray::new(&self.model.tree, xy, self.search.aim.ends_of_line(grid, xy));
        let seen: Vec<&Segment> = ray.segments.iter().filter(|of| of.label != HIDDEN).collect();
        let at = share * seen.len() as f64;
        let Some(segment) = seen.get(whole(at)) else { return place };
        let [from, to] = segment.ends;
        [x, y, (from + (to - from) * at.fract()) / grid.edges[2]]
    }
}
