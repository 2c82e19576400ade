//! The coordinates about the singularities of a view, and where these are in the image.

use crate::projection::ViewGeometry;
use crate::projection::charts::axis::SeenAxis;
use crate::projection::charts::excluded::Excluded;
use crate::projection::charts::shells::Shells;
use crate::projection::charts::singular::Logarithm;
use crate::projection::charts::{Atlas, depth};
use crate::projection::ellipsoid::Ellipsoid;
use crate::projection::singularity::Singularity;
use crate::projection::surroundings::{Observer, SightLine, Surroundings};
use crate::projection::vector::{difference, norm};

/// The place on the image plane at which the size of a pixel is measured, beside the middle, at which a
/// singularity is likely to be.
const PLACE: [f64; 2] = [0.513, 0.479];
/// A step on the image plane, in pixels, over which the change of an angle is its gradient.
const STEP: f64 = 1e-3;
/// The part of the way to other centres that lines belong to the coordinates about a singularity.
const SHARE_OF_WAY: f64 = 0.5;
/// The length over which the image of parallel lines extends along an axis, in pixels.
const LENGTH_PIXELS: f64 = 100.0;

/// The part of the distance at which lines of sight of a chart pass a singularity of another one that is excluded.
const SHARE_EXCLUDED: f64 = 0.7;
/// The number of places along each side of a tile at which that distance is measured.
const LATTICE: usize = 48;

/// How near a line of sight is to a singularity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NearSingularity {
    /// The distance in pixels.
    pub(crate) pixels: f64,
    pub(crate) is_axis: bool,
}

/// Adds the coordinates about all singularities of a view to `shells`; `centres` are those of bodies and edges,
/// and `tile` is one tile of the image with its height and width.
pub(super) fn insert(
    shells: &mut Vec<Shells>,
    surroundings: &Surroundings,
    centres: &[Ellipsoid],
    (tile, shape): (&dyn ViewGeometry, [usize; 2]),
) {
    let all = &surroundings.singularities;
    let is_hidden = |of: &&Singularity| {
        of.axis.is_none() && surroundings.bodies.iter().any(|body| body.contains(of.position))
    };
    for (number, singularity) in all.iter().enumerate().filter(|(_, of)| !is_hidden(of)) {
        let own = shells.iter().position(|shells| {
            let apart = norm(difference(shells.reference.centre(), singularity.position));
            shells.body.is_none() && apart <= 1e-9 * shells.reference.longest()
        });
        let other = all.iter().enumerate().filter(|(other, _)| *other != number);
        let other = other.map(|(_, other)| norm(difference(other.position, singularity.position)));
        let apart = |centre: &Ellipsoid| {
            let apart = norm(difference(centre.centre(), singularity.position));
            (apart - centre.longest()).abs()
        };
        let nearest = centres.iter().map(apart).chain(other).fold(f64::INFINITY, f64::min);
        let radius = SHARE_OF_WAY * if nearest.is_finite() { nearest.max(1e-300) } else { 2.0 };
        let mut about = match own.filter(|_| singularity.axis.is_none()) {
            Some(own) => shells.remove(own),
            None => match about(singularity, radius, surroundings, (tile, shape)) {
                Some(about) => about,
                None => continue,
            },
        };
        if let Some(pixel) = size_of_pixel(&about, tile, shape) {
            about.singular = Some(Logarithm::new(singularity, 0.5 * pixel));
            about.others = centres.iter().take(depth::MOST_CENTRES).copied().collect();
        }
        shells.push(about);
    }
}

/// Coordinates about one singularity, of lines within `radius`; `None` if it is at the observer, or an axis that is seen
/// as a point.
fn about(
    singularity: &Singularity,
    radius: f64,
    surroundings: &Surroundings,
    (tile, shape): (&dyn ViewGeometry, [usize; 2]),
) -> Option<Shells> {
    let reference = Ellipsoid::sphere(singularity.position, radius).ok()?;
    let observer = surroundings.observer;
    let Some(direction) = singularity.axis else {
        let about = Shells::without_surfaces(reference, None, observer);
        return (about.distance > 0.0).then_some(about);
    };
    // For parallel lines, the size of a pixel as a length.
    let length = match observer {
        Observer::Point(_) => 1.0,
        Observer::Parallel { .. } => {
            let centred = Ellipsoid::sphere(singularity.position, 1.0).ok()?;
            let centred = Shells::without_surfaces(centred, None, observer);
            LENGTH_PIXELS * size_of_pixel(&centred, tile, shape)?
        }
    };
    let axis = SeenAxis::new(singularity.position, direction, observer, length)?;
    Some(Shells::about_axis(reference, axis, observer))
}

/// The size of a pixel as an angle, or as a length for parallel lines, in the units of `shells`.
fn size_of_pixel(
    shells: &Shells,
    tile: &dyn ViewGeometry,
    [height, width]: [usize; 2],
) -> Option<f64> {
    let angle = |x: f64, y: f64| {
        let place = [PLACE[0] + x * STEP / width as f64, PLACE[1] + y * STEP / height as f64];
        Some(shells.aim(&tile.line(place)?).angle())
    };
    let here = angle(0.0, 0.0)?;
    let size = f64::hypot(angle(1.0, 0.0)? - here, angle(0.0, 1.0)? - here) / STEP;
    (size > 0.0 && size.is_finite()).then_some(size)
}

impl Atlas<'_> {
    /// Excludes from the coordinates of all shells the singularities that are resolved by others.
    pub(super) fn exclude_singularities(&mut self) {
        let singular = |number: &usize| self.shells[*number].singular.is_some();
        let singular: Vec<usize> = (0..self.shells.len()).filter(singular).collect();
        let lines = self.lines_of_lattice();
        for number in 0..self.shells.len() {
            let others = singular.iter().filter(|other| **other != number);
            let excluded = others.map(|&other| {
                let about = &self.shells[other];
                let (position, axis) = (about.reference.centre(), about.axis_direction());
                let nearest = self.nearest_miss(number, other, &lines);
                Excluded { position, axis, radius: SHARE_EXCLUDED * nearest }
            });
            let excluded = excluded.filter(|of| of.radius > 0.0 && of.radius.is_finite()).collect();
            self.shells[number].excluded = excluded;
        }
    }

    /// How near the lines of sight in the coordinates of some shells are at least to the singularity of others.
    fn nearest_miss(&self, own: usize, other: usize, lines: &[(usize, SightLine)]) -> f64 {
        let (own_shells, other_shells) = (&self.shells[own], &self.shells[other]);
        let miss = |line: &SightLine| {
            let aim = other_shells.aim(line);
            if aim.is_ahead { other_shells.length_of_miss(&aim) } else { f64::INFINITY }
        };
        let of_lattice = || {
            let lines = lines.iter().filter(|(number, _)| *number == own);
            lines.map(|(_, line)| miss(line)).fold(f64::INFINITY, f64::min)
        };
        let has_point = |shells: &Shells| shells.singular.is_some() && !shells.has_axis();
        if !(has_point(own_shells) && has_point(other_shells)) {
            return of_lattice();
        }
        // On the way from one point to the other the clearances are equal where the way is divided in this ratio.
        let line_to = |shells: &Shells| self.surroundings.line_to(shells.reference.centre());
        let Some((to_own, to_other)) = line_to(own_shells).zip(line_to(other_shells)) else {
            return 0.0;
        };
        let apart = [
            own_shells.clearance(&own_shells.aim(&to_other)),
            other_shells.clearance(&other_shells.aim(&to_own)),
        ];
        if apart.iter().all(|apart| apart.is_finite()) {
            miss(&to_own) * apart[0] / (apart[0] + apart[1])
        } else {
            of_lattice()
        }
    }

    /// Lines of sight in view, with the numbers of their shells.
    fn lines_of_lattice(&self) -> Vec<(usize, SightLine)> {
        let place = |k: usize| (k as f64 + 0.5) / LATTICE as f64;
        let places = || (0..LATTICE * LATTICE).map(|k| [place(k % LATTICE), place(k / LATTICE)]);
        let lines = self.tiles.iter().flat_map(|tile| places().filter_map(|xy| tile.line(xy)));
        lines
            .filter_map(|line| {
                Some((self.shells_of(&line, self.surroundings.end_of(&line).0)?, line))
            })
            .collect()
    }

    /// Whether the emission is singular somewhere.
    pub(crate) fn has_singularities(&self) -> bool {
        self.shells.iter().any(|shells| shells.singular.is_some())
    }

    /// How near a line of sight is to the nearest singularity that is ahead of the observer.
    pub(crate) fn near_singularity(&self, line: &SightLine) -> Option<NearSingularity> {
        let near = self.shells.iter().filter_map(|shells| {
            let singular = shells.singular?;
            let aim = shells.aim(line);
            let pixels = aim.angle() / (2.0 * singular.pixel);
            Some(NearSingularity { pixels, is_axis: shells.has_axis() })
        });
        near.min_by(|a, b| a.pixels.total_cmp(&b.pixels))
    }
}
