//! Concentric surfaces of one shape: an opaque body, edges of the emission around it, and bounds.
//!
//! The ellipsoids are mapped affinely to spheres, and lines to lines. A line of sight is then given by
//! its angle ψ from the direction to the centre, or by its distance b from the centre if all lines
//! are parallel, and by an azimuth φ about that direction. The surfaces that it crosses, and in
//! which order, follow from b alone: it crosses those with a larger radius. So the lines between
//! the limbs of two successive surfaces are one *zone*, and all lines of a zone consist of the same
//! *pieces*, the parts between successive crossings.

use crate::projection::charts::aim::{Aim, Angle};
use crate::projection::charts::axis::{SIDES, SeenAxis};
use crate::projection::charts::excluded::Excluded;
use crate::projection::charts::sectors::Sectors;
use crate::projection::charts::singular::Logarithm;
use crate::projection::ellipsoid::Ellipsoid;
use crate::projection::region::Region;
use crate::projection::surroundings::{Observer, SightLine, Surroundings};
use crate::projection::vector::{along, cross, difference, dot, norm, unit, unit_across};
use core::f64::consts::PI;

/// Surfaces closer to each other than this share of their radii are one.
const SAME_RADIUS: f64 = 1e-8;
/// A plane contains the axis if its distance from the centre, in units of the radius, and the
/// cosine of the angle between its normal and the axis are smaller.
const ON_AXIS: f64 = 1e-9;

/// Surfaces around one centre, by their radii in units of the first one given.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shells {
    /// The surface of radius 1.
    pub(super) reference: Ellipsoid,
    /// The radii, in ascending order; none around a singularity without surfaces.
    pub(super) radii: Vec<f64>,
    /// The number of the opaque body whose surface has the smallest radius.
    pub(super) body: Option<usize>,
    /// Whether the second radius is that of an edge found by samples, below which the emission looks
    /// dark.
    pub(super) has_found_edge: bool,
    /// Whether there is no emission beyond the largest radius: it is that of the bounds.
    pub(super) is_dark_beyond: bool,
    /// Whether pieces that pass the centre around a surface are divided at the point nearest to it.
    pub(super) is_halved: bool,
    /// The sectors of azimuth, each of which has its own charts.
    pub(super) sectors: Sectors,
    /// The bodies and edges around other centres, the largest ones first.
    pub(super) others: Vec<Ellipsoid>,
    /// The coordinate of lines that pass a singularity at the centre, or on an axis instead of a centre.
    pub(super) singular: Option<Logarithm>,
    axis: Option<SeenAxis>,
    /// The singularities that other charts resolve.
    pub(super) excluded: Vec<Excluded>,
    observer: Observer,
    /// The distance of the observer from the centre, infinite for parallel lines.
    pub(super) distance: f64,
    /// The number of surfaces with the observer outside of them.
    pub(super) limbs: usize,
    /// Scaled unit vectors, the last from the observer to the centre.
    axes: [[f64; 3]; 3],
}

impl Shells {
    /// Shells around `reference`, the surface of radius 1 that may be that of the opaque `body`.
    pub(super) fn new(reference: Ellipsoid, body: Option<usize>, observer: Observer) -> Self {
        let mut shells = Self::without_surfaces(reference, body, observer);
        shells.insert(1.0);
        shells
    }

    /// Coordinates about the centre of `reference`.
    pub(super) fn without_surfaces(
        reference: Ellipsoid,
        body: Option<usize>,
        observer: Observer,
    ) -> Self {
        let (towards, distance) = match observer {
            Observer::Point(position) => {
                let from = reference.scaled_point(position);
                (from.map(|along| -along), norm(from))
            }
            Observer::Parallel { direction, .. } => (reference.scaled(direction), f64::INFINITY),
        };
        // At the centre all directions are alike.
        let forward = unit(towards).unwrap_or([0.0, 0.0, 1.0]);
        let across = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]].map(|axis| unit_across(axis, forward));
        let first = match across {
            // The pole is the usual axis of symmetry; along it the azimuth begins at x.
            [Some(first), _] if forward[2].abs() < 0.9 => first,
            [_, Some(first)] | [Some(first), None] => first,
            [None, None] => [0.0, 1.0, 0.0],
        };
        let axes = [first, cross(forward, first), forward];
        Self {
            reference,
            radii: Vec::new(),
            body,
            has_found_edge: false,
            is_dark_beyond: false,
            is_halved: false,
            sectors: Sectors::default(),
            others: Vec::new(),
            singular: None,
            axis: None,
            excluded: Vec::new(),
            observer,
            distance,
            limbs: 0,
            axes,
        }
    }

    /// Coordinates about an axis near the centre of `reference`.
    pub(super) fn about_axis(reference: Ellipsoid, axis: SeenAxis, observer: Observer) -> Self {
        let mut shells = Self::without_surfaces(reference, None, observer);
        SIDES.into_iter().for_each(|azimuth| shells.sectors.cut(azimuth));
        Self { distance: axis.distance, axis: Some(axis), ..shells }
    }

    /// The direction of the axis, if there is one.
    pub(super) fn axis_direction(&self) -> Option<[f64; 3]> {
        self.axis.as_ref().map(SeenAxis::direction)
    }

    /// The distance in the world at which a line passes the centre, at least, or the axis.
    pub(super) fn length_of_miss(&self, aim: &Aim) -> f64 {
        if self.axis.is_some() { aim.miss } else { aim.miss * self.reference.shortest() }
    }

    /// Whether the singularity is an axis.
    pub(super) fn has_axis(&self) -> bool {
        self.axis.is_some()
    }

    /// Adds a surface.
    pub(super) fn insert(&mut self, radius: f64) {
        let number = self.radii.partition_point(|other| *other < radius);
        self.radii.insert(number, radius);
        self.limbs = self.radii.partition_point(|radius| *radius < self.distance);
    }

    /// Adds an edge of the emission; one inside the body is not in view.
    pub(super) fn insert_edge(&mut self, radius: f64) {
        let is_hidden = self.body.is_some() && radius <= self.radii[0] * (1.0 + SAME_RADIUS);
        let is_there = self.radii.iter().any(|other| (other / radius - 1.0).abs() < SAME_RADIUS);
        if !is_hidden && !is_there {
            self.insert(radius);
        }
    }

    /// Divides the azimuth at a plane, given by a point and its unit normal, if it contains the axis.
    /// Its tolerance includes the rounding of positions far from the origin.
    pub(super) fn cut_at_plane(&mut self, position: [f64; 3], normal: [f64; 3]) {
        if self.axis.is_some() {
            return;
        }
        let centre = self.reference.centre();
        let [x, y, forward] = self.axes.map(|axis| self.reference.unscaled(axis));
        let rounding = ON_AXIS * 1e-3 * norm(centre).max(norm(position));
        let distance = dot(difference(centre, position), normal).abs();
        let is_on_axis = distance < ON_AXIS * norm(x).max(norm(y)) + rounding
            && dot(forward, normal).abs() < ON_AXIS * norm(forward);
        if is_on_axis {
            let azimuth = f64::atan2(-dot(x, normal), dot(y, normal));
            self.sectors.cut(azimuth);
            self.sectors.cut(azimuth + PI);
        }
    }

    /// Makes `radius` that of the bounds: surfaces beyond are not in view.
    pub(super) fn bound(&mut self, radius: f64) {
        self.radii.retain(|other| *other < radius * (1.0 - SAME_RADIUS));
        self.insert(radius);
        self.is_dark_beyond = true;
    }

    /// The radius of a surface if it has the centre and the shape of these shells.
    pub(super) fn radius_of(&self, surface: &Ellipsoid) -> Option<f64> {
        surface.size_relative_to(&self.reference)
    }

    pub(super) fn is_parallel(&self) -> bool {
        self.distance == f64::INFINITY
    }

    /// A line of sight relative to the centre.
    pub(super) fn aim(&self, line: &SightLine) -> Aim {
        if let Some(axis) = &self.axis {
            return axis.aim(line);
        }
        let (from, along_line) =
            (self.reference.scaled_point(line.origin), self.reference.scaled(line.direction));
        let [x, y, forward] = self.axes;
        let squared = dot(along_line, along_line);
        let nearest = -dot(from, along_line) / squared;
        let stretch = squared.sqrt();
        if self.is_parallel() {
            let at = along(from, nearest, along_line);
            let (a, b) = (dot(at, x), dot(at, y));
            let miss = norm([a, b, 0.0]);
            let (angle, azimuth) = (Angle::Known(miss), Angle::Of { across: b, along: a });
            return Aim { angle, azimuth, miss, is_ahead: true, nearest, stretch };
        }
        let (a, b, c) = (dot(along_line, x), dot(along_line, y), dot(along_line, forward));
        let across = norm([a, b, 0.0]);
        Aim {
            angle: Angle::Of { across, along: c },
            azimuth: Angle::Of { across: b, along: a },
            miss: self.distance * across / stretch,
            is_ahead: c > 0.0,
            nearest,
            stretch,
        }
    }

    /// The line of sight of an angle (a distance from the centre for parallel lines) and an azimuth.
    pub(super) fn line(&self, surroundings: &Surroundings, angle: f64, azimuth: f64) -> SightLine {
        if let Some(axis) = &self.axis {
            let (origin, direction) = axis.line(self.observer, angle, azimuth);
            return surroundings.line(origin, direction);
        }
        let [x, y, forward] = self.axes;
        let (sin, cos) = azimuth.sin_cos();
        let across: [f64; 3] = core::array::from_fn(|i| cos * x[i] + sin * y[i]);
        match self.observer {
            Observer::Point(position) => {
                let (sin, cos) = angle.sin_cos();
                let scaled = core::array::from_fn(|i| cos * forward[i] + sin * across[i]);
                let direction = self.reference.unscaled(scaled);
                surroundings.line(position, unit(direction).unwrap_or(direction))
            }
            Observer::Parallel { plane_point, direction } => {
                let offset = self.reference.unscaled(across.map(|along| angle * along));
                let point = along(self.reference.centre(), 1.0, offset);
                let back = dot(difference(plane_point, point), direction);
                surroundings.line(along(point, back, direction), direction)
            }
        }
    }

    /// The distance between the origin of scaled coordinates and a point.
    pub(super) fn radius_at(&self, position: [f64; 3]) -> f64 {
        norm(self.reference.scaled_point(position))
    }

    /// The point on the way from the centre to `position` with another radius.
    pub(super) fn at_radius(&self, position: [f64; 3], radius: f64) -> [f64; 3] {
        let factor = radius / self.radius_at(position).max(f64::MIN_POSITIVE);
        let centre = self.reference.centre();
        along(centre, factor, difference(position, centre))
    }

    /// Whether a line ends at the body. A line may enter the body before it begins: the bounds of the
    /// emission are behind it.
    pub(super) fn ends(&self, surroundings: &Surroundings, line: &SightLine) -> bool {
        match surroundings.end_of(line).0 {
            Region::Body(body) => self.body == Some(body),
            Region::Sky | Region::Outside => false,
        }
    }

    /// The number of the zone of a line: it crosses the surfaces of that number and above of which
    /// the observer is outside.
    pub(super) fn zone(&self, aim: &Aim) -> usize {
        if !aim.is_ahead {
            return self.limbs;
        }
        self.radii[..self.limbs].partition_point(|radius| *radius <= aim.miss)
    }

    /// How close a line is to a limb, in units of its radius, or to a singularity, in units of the
    /// reference; infinite for lines away from the centre.
    pub(super) fn clearance(&self, aim: &Aim) -> f64 {
        if !aim.is_ahead {
            return f64::INFINITY;
        }
        let unit = if self.axis.is_some() { self.reference.longest() } else { 1.0 };
        let of_singularity = self.singular.map_or(f64::INFINITY, |_| aim.miss / unit);
        let limbs = self.radii[..self.limbs].iter();
        limbs.map(|radius| (aim.miss / radius - 1.0).abs()).fold(of_singularity, f64::min)
    }

    /// Whether the only surface is that of the bounds.
    pub(super) fn is_only_bounds(&self) -> bool {
        self.is_dark_beyond && self.radii.len() == 1
    }
}
