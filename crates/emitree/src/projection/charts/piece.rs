//! Pieces: the parts of lines of sight between successive crossings of concentric surfaces, in
//! coordinates in which their radiance is smooth.
//!
//! A limb is where a line touches a surface of radius R. Along it the radiance of each piece has
//! the square root of the distance from the limb. The coordinate c of a piece absorbs it:
//!
//! * from a surface outwards: c is the central angle of the point of the surface, tan ψ =
//!   R sin c / (D − R cos c), on the near side up to acos(R/D) and on the far side beyond;
//! * across the inside of a surface and around the next smaller one: b² = r² + (R² − r²) sin²(πc/2);
//! * past all surfaces: c = √(ψ − ψ of the limb), or √(b² − R²) for parallel lines.
//!
//! The depth from a surface outwards over a length T is t = L v / (1 − v (1 − L/T)), v = z² and L =
//! min(R/3, T): an atmosphere above the surface and the square root that its rate may have there
//! are resolved, and so is a power law towards infinity. Past a surface the depth is the angle at
//! the centre, which is smooth for lines that look away from the body, too.
//!
//! Where a piece contains a singularity at the centre, its coordinate is the logarithm of this one.
//!
//! A rate that has the square root of the height above the surface, as light scattered from the whole disk has, is
//! √(c² + s²) near a limb, with the distance s from the point nearest to the centre: no polynomial of s
//! approximates it well, but on each [side](Side) of that point one does, since the places of the polynomials are
//! denser at the ends.

use crate::projection::MappedPoint;
use crate::projection::charts::aim::Aim;
use crate::projection::charts::depth::{Depth, Own, Weights, usual_weights};
use crate::projection::charts::shells::Shells;
use crate::projection::charts::singular::Logarithm;
use crate::projection::surroundings::{SightLine, Surroundings};
use core::f64::consts::{FRAC_PI_2, PI};

/// Which part of the lines of sight a piece is; numbers are those of surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Piece {
    /// From where a line enters a surface back to the next larger one, or to its beginning.
    Near(usize),
    /// Inside a surface, for lines that do not enter the next smaller one.
    Chord(usize),
    /// From where a line leaves a surface to the next larger one, or to its end.
    Far(usize),
    /// All of a line that enters no surface, up to the first one around the observer.
    Sky,
}

/// Which part of a piece, if it is divided at the point that is nearest to the centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// The whole piece.
    Both,
    /// From the observer to the nearest point.
    Before,
    /// From the nearest point on.
    Beyond,
}

/// The scale of depth from a surface outwards, in units of its radius.
const DEPTH_SCALE: f64 = 1.0 / 3.0;
/// How far from an edge g is evaluated at least, relative to its radius: an edge is known to
/// rounding, and a rate on its wrong side would be wrong by the whole jump.
const BESIDE_EDGE: f64 = 1e-9;

impl Shells {
    /// All pieces that lines of sight may have.
    pub(super) fn pieces(&self) -> Vec<Piece> {
        let surfaces = self.radii.len();
        let is_dark = |number: usize| self.is_dark_beyond && number + 1 == surfaces;
        let first_inside = usize::from(self.body.is_some());
        let near = (0..self.limbs).filter(|&j| !is_dark(j)).map(Piece::Near);
        let chords = (first_inside..self.limbs).map(Piece::Chord);
        let far = (0..surfaces).filter(|&j| !is_dark(j)).map(Piece::Far);
        let has_sky = !(self.is_dark_beyond && self.limbs == surfaces);
        near.chain(chords).chain(far).chain(has_sky.then_some(Piece::Sky)).collect()
    }

    /// The parts into which a piece is divided.
    pub(super) fn sides(&self, piece: Piece) -> &'static [Side] {
        if self.is_halved && self.passes(piece) {
            &[Side::Before, Side::Beyond]
        } else {
            &[Side::Both]
        }
    }

    /// Whether a piece passes the centre around a surface.
    pub(super) fn passes(&self, piece: Piece) -> bool {
        match piece {
            Piece::Chord(number) => self.inner_radius(number) > 0.0,
            Piece::Sky => self.limbs > 0,
            Piece::Near(_) | Piece::Far(_) => false,
        }
    }

    /// Whether the lines of a zone have a piece. Those of zone 0 enter the body, if there is one, and
    /// end at it, or begin behind it.
    pub(super) fn has(&self, zone: usize, piece: Piece, ends_at_body: bool) -> bool {
        let enters_body = zone == 0 && self.body.is_some();
        match piece {
            Piece::Near(number) => number >= zone,
            Piece::Chord(number) => number == zone && !enters_body,
            Piece::Far(number) => number >= zone && !ends_at_body,
            Piece::Sky => zone == self.limbs && !enters_body,
        }
    }

    /// The largest central angle of points on the near side of a surface.
    fn limb_angle(&self, number: usize) -> f64 {
        (self.radii[number] / self.distance).min(1.0).acos()
    }

    /// The radius of the next smaller surface; 0 if there is none.
    fn inner_radius(&self, number: usize) -> f64 {
        number.checked_sub(1).map_or(0.0, |inner| self.radii[inner])
    }

    /// The angle ψ, or the distance b of parallel lines, of the largest limb.
    fn outer_limb(&self) -> f64 {
        let radius = self.radii[self.limbs - 1];
        if self.is_parallel() { radius } else { (radius / self.distance).asin() }
    }

    /// The logarithm that replaces the coordinate c of a piece that contains a singularity.
    fn logarithm(&self, piece: Piece) -> Option<Logarithm> {
        let logarithm = self.singular?;
        match piece {
            Piece::Sky if self.limbs == 0 => Some(logarithm),
            Piece::Chord(number) if self.inner_radius(number) == 0.0 => {
                // The angle, or the distance of parallel lines, per central angle on the axis.
                let radius = self.radii[number];
                let parallel = self.is_parallel();
                let slope = if parallel { radius } else { radius / (self.distance - radius) };
                Some(logarithm.in_units(slope))
            }
            _ => None,
        }
    }

    /// The density of a piece at its coordinate c, which multiplies the radiance; 1 without a singularity.
    pub(super) fn density(&self, piece: Piece, c: f64) -> f64 {
        self.logarithm(piece).map_or(1.0, |logarithm| logarithm.density(c))
    }

    /// The coordinate c of a line in a piece.
    pub(super) fn coordinate(&self, piece: Piece, aim: &Aim) -> f64 {
        let c = self.smooth_coordinate(piece, aim);
        self.logarithm(piece).map_or(c, |logarithm| logarithm.of(c))
    }

    /// The angle, or the distance of parallel lines, at the coordinate c of a piece.
    pub(super) fn angle(&self, piece: Piece, c: f64) -> f64 {
        let c = self.logarithm(piece).map_or(c, |logarithm| logarithm.distance(c));
        self.smooth_angle(piece, c)
    }

    /// The ends of the coordinate c at limbs and on the axis.
    pub(super) fn natural_ends(&self, piece: Piece) -> [f64; 2] {
        let ends = self.smooth_ends(piece);
        self.logarithm(piece).map_or(ends, |logarithm| ends.map(|end| logarithm.of(end)))
    }

    /// The coordinate c where no singularity is in the piece.
    fn smooth_coordinate(&self, piece: Piece, aim: &Aim) -> f64 {
        let incidence = |number: usize| (aim.miss / self.radii[number]).min(1.0).acos();
        let central = |number: usize, side: f64| match self.is_parallel() {
            // The angle of the point from the axis, on the side of the observer or beyond.
            true => FRAC_PI_2 + side * incidence(number),
            false => FRAC_PI_2 - aim.angle() + side * incidence(number),
        };
        match piece {
            Piece::Near(number) => central(number, -1.0).max(0.0),
            Piece::Chord(number) if self.inner_radius(number) == 0.0 => {
                central(number, -1.0).max(0.0)
            }
            Piece::Chord(number) => {
                let [inner, outer] = [self.inner_radius(number), self.radii[number]];
                let share = (aim.miss.powi(2) - inner * inner) / (outer * outer - inner * inner);
                share.clamp(0.0, 1.0).sqrt().asin() / FRAC_PI_2
            }
            Piece::Far(number) => central(number, 1.0),
            Piece::Sky if self.limbs == 0 => aim.angle(),
            Piece::Sky if self.is_parallel() => {
                (aim.miss.powi(2) - self.outer_limb().powi(2)).max(0.0).sqrt()
            }
            Piece::Sky => (aim.angle() - self.outer_limb()).max(0.0).sqrt(),
        }
    }

    fn smooth_angle(&self, piece: Piece, c: f64) -> f64 {
        let of_point = |number: usize| {
            let radius = self.radii[number];
            let (sin, cos) = c.sin_cos();
            if self.is_parallel() {
                radius * sin
            } else {
                (radius * sin).atan2(self.distance - radius * cos)
            }
        };
        match piece {
            Piece::Near(number) | Piece::Far(number) => of_point(number),
            Piece::Chord(number) if self.inner_radius(number) == 0.0 => of_point(number),
            Piece::Chord(number) => {
                let [inner, outer] = [self.inner_radius(number), self.radii[number]];
                let share = (FRAC_PI_2 * c).sin().powi(2);
                let miss = (inner * inner + (outer * outer - inner * inner) * share).sqrt();
                if self.is_parallel() { miss } else { (miss / self.distance).min(1.0).asin() }
            }
            Piece::Sky if self.limbs == 0 => c,
            Piece::Sky if self.is_parallel() => self.outer_limb().hypot(c),
            Piece::Sky => (self.outer_limb() + c * c).min(PI),
        }
    }

    fn smooth_ends(&self, piece: Piece) -> [f64; 2] {
        match piece {
            Piece::Near(number) => [0.0, self.limb_angle(number)],
            Piece::Chord(number) if self.inner_radius(number) == 0.0 => {
                [0.0, self.limb_angle(number)]
            }
            Piece::Chord(_) => [0.0, 1.0],
            Piece::Far(number) => [self.limb_angle(number), PI],
            Piece::Sky if self.limbs == 0 => {
                [0.0, if self.is_parallel() { f64::INFINITY } else { PI }]
            }
            Piece::Sky if self.is_parallel() => [0.0, f64::INFINITY],
            Piece::Sky => [0.0, (PI - self.outer_limb()).sqrt()],
        }
    }

    /// The distances along a line between which a side of a piece is; empty if the second is not larger.
    pub(super) fn range(&self, piece: Piece, side: Side, line: &SightLine, aim: &Aim) -> [f64; 2] {
        let half = |number: usize| {
            let within = self.radii[number].powi(2) - aim.miss.powi(2);
            within.max(0.0).sqrt() / aim.stretch
        };
        let [begin, end] = line.ends;
        let [from, to] = match piece {
            Piece::Near(number) => {
                let outer = Some(number + 1).filter(|&outer| outer < self.limbs);
                [outer.map_or(begin, |outer| aim.nearest - half(outer)), aim.nearest - half(number)]
            }
            Piece::Chord(number) => [aim.nearest - half(number), aim.nearest + half(number)],
            Piece::Far(number) => {
                let outer = Some(number + 1).filter(|&outer| outer < self.radii.len());
                [aim.nearest + half(number), outer.map_or(end, |outer| aim.nearest + half(outer))]
            }
            Piece::Sky => {
                let outer = Some(self.limbs).filter(|&outer| outer < self.radii.len());
                [begin, outer.map_or(end, |outer| aim.nearest + half(outer))]
            }
        };
        let [from, to] = match side {
            Side::Both => [from, to],
            Side::Before => [from, to.min(aim.nearest)],
            Side::Beyond => [from.max(aim.nearest), to],
        };
        [from.clamp(begin, end), to.clamp(begin, end)]
    }

    /// The coordinate of depth that resolves what is close to the surfaces of a piece.
    fn own_depth(&self, piece: Piece, aim: &Aim) -> Own {
        if self.logarithm(piece).is_some() {
            return Own::Singular { nearest: aim.nearest, miss: aim.miss / aim.stretch };
        }
        let scale = |number: usize| DEPTH_SCALE * self.radii[number] / aim.stretch;
        match piece {
            Piece::Near(number) => Own::Inwards(scale(number)),
            Piece::Far(number) => Own::Outwards(scale(number)),
            Piece::Chord(number) if self.inner_radius(number) == 0.0 => Own::Even,
            Piece::Sky if self.limbs == 0 => Own::Plain,
            Piece::Chord(_) | Piece::Sky => {
                Own::Angle { nearest: aim.nearest, miss: aim.miss / aim.stretch }
            }
        }
    }

    /// The weights of the coordinates of depth in a piece before anything is known of the emission.
    pub(super) fn usual_weights(&self, piece: Piece) -> Weights {
        let is_plain = match piece {
            Piece::Chord(number) => self.inner_radius(number) == 0.0,
            Piece::Sky => self.limbs == 0,
            Piece::Near(_) | Piece::Far(_) => false,
        } && self.logarithm(piece).is_none();
        let smallest = self.radii.first().copied().unwrap_or(1.0);
        usual_weights(is_plain, self.reference.longest() * smallest, &self.others)
    }

    /// The depth along a side of a piece of a line.
    pub(super) fn depth(
        &self,
        surroundings: &Surroundings,
        (piece, side): (Piece, Side),
        weights: Weights,
        line: &SightLine,
    ) -> Depth {
        let aim = self.aim(line);
        let [from, to] = self.range(piece, side, line, &aim);
        let own = self.own_depth(piece, &aim);
        Depth::new(own, surroundings.span(from, to), weights).beside(line, &self.others)
    }

    /// The point at `z` of a side of a piece of a line.
    pub(super) fn point(
        &self,
        surroundings: &Surroundings,
        (piece, side): (Piece, Side),
        weights: Weights,
        line: &SightLine,
        z: f64,
    ) -> MappedPoint {
        let depth = self.depth(surroundings, (piece, side), weights, line);
        let Some((distance, path)) = depth.at(z) else {
            let nearest = self.aim(line).nearest;
            return line.sample(line.ends[0].max(nearest.min(line.ends[1])), 0.0);
        };
        let mut point = line.sample(distance, path);
        point.position = self.beside_surfaces(piece, point.position);
        point.position = surroundings.outside(point.position);
        for excluded in &self.excluded {
            point.position = excluded.outside(point.position);
        }
        point
    }

    /// A position of a piece that rounding may have moved across one of its surfaces, moved back.
    fn beside_surfaces(&self, piece: Piece, position: [f64; 3]) -> [f64; 3] {
        let (inner, outer) = match piece {
            Piece::Near(number) | Piece::Far(number) => (Some(number), Some(number + 1)),
            Piece::Chord(number) => (number.checked_sub(1), Some(number)),
            Piece::Sky => (self.limbs.checked_sub(1), Some(self.limbs)),
        };
        let is_body = |number: usize| number == 0 && self.body.is_some();
        let least = inner.filter(|&number| !is_body(number));
        let most = outer.filter(|&number| number < self.radii.len());
        if least.is_none() && most.is_none() {
            return position;
        }
        let radius = self.radius_at(position);
        let least = least.map_or(0.0, |number| self.radii[number] * (1.0 + BESIDE_EDGE));
        let most = most.map_or(f64::INFINITY, |number| self.radii[number] * (1.0 - BESIDE_EDGE));
        if radius < least {
            self.at_radius(position, least)
        } else if radius > most {
            self.at_radius(position, most)
        } else {
            position
        }
    }
}
