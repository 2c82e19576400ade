//! The exact image of a view: means over lines whose ends are known from geometry.

use super::glow::Glow;
use super::shapes::{Ball, Room, Vector};
use crate::family::Reference;
use crate::gauss::Gauss;
use emitree::{Image, Projection};
use rayon::prelude::*;

/// Nodes of the rules, coarse to fine: along each side of a pixel, along each side of a part of a pixel
/// that an edge crosses, and between two breaks of a line.
const RULES: [[usize; 3]; 5] = [[3, 6, 6], [5, 9, 9], [8, 13, 12], [12, 19, 16], [18, 28, 20]];
/// Two rules agree if they differ by less than this times the largest pixel.
const AGREEMENT: f64 = 2e-5;
/// Pixels with edges are quartered so many times if no rules agree.
const QUARTERINGS: u32 = 6;
/// What rounding can do to a pixel, relative to the largest.
const ROUNDING: f64 = 1e-12;
/// Intervals of a pixel's side between which edges are searched for.
const PROBES: usize = 12;
/// Halvings of such an interval.
const BISECTIONS: usize = 44;
/// A kink that a line meets on a shorter part of its path than this is none.
const LEAST_OVERLAP: f64 = 1e-9;

/// The view without the camera.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Scenery {
    pub(super) bodies: Vec<Ball>,
    pub(super) room: Room,
    pub(super) glow: Glow,
    /// Distances from which to which lines reach.
    pub(super) depth: [f64; 2],
}

/// One line of sight: its ends, and what the map is smooth for.
struct Sight {
    ends: [f64; 2],
    kind: Kind,
}

/// What a line meets: radiances are smooth where this does not change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// It belongs to no image.
    Outside,
    /// The emission is 0 on it.
    Dark,
    Lit {
        /// The number of the body at which it ends.
        body: Option<usize>,
        /// Whether it begins where bounds do, and ends there, and by which faces.
        cut: [bool; 2],
        faces: u8,
        meets_kink: bool,
    },
}

impl Scenery {
    pub(super) fn rate(&self, position: Vector) -> f64 {
        if self.bodies.iter().any(|body| body.depth_of(position) < 1.0) {
            return f64::NAN;
        }
        self.glow.rate(position)
    }

    /// What a line meets.
    fn sight(&self, origin: Vector, direction: Vector) -> Sight {
        let dark = Sight { ends: [0.0; 2], kind: Kind::Dark };
        let [near, far] = self.depth;
        let Some(([enter, leave], faces)) = self.room.crossing(origin, direction) else {
            return dark;
        };
        let from = near.max(enter);
        let mut to = far.min(leave);
        let mut cut = [enter > near, leave < far];
        let mut body = None;
        for (number, ball) in self.bodies.iter().enumerate() {
            if let Some([hit, out]) = ball.crossing(origin, direction)
                && out > from
                && hit < to
            {
                (to, body) = (hit, Some(number));
                cut[1] = false;
            }
        }
        if to <= from {
            return dark;
        }
        // Faces that are not reached do not matter.
        let faces = if cut[0] { faces & 0b1100 } else { 0 } | if cut[1] { faces & 0b11 } else { 0 };
        let kink = self.glow.kink().and_then(|ball| ball.crossing(origin, direction));
        let meets_kink = kink.is_some_and(|[a, b]| b.min(to) - a.max(from) > LEAST_OVERLAP);
        Sight { ends: [from, to], kind: Kind::Lit { body, cut, faces, meets_kink } }
    }

    /// The length of the line at (x, y) with emission.
    pub(super) fn path(&self, bare: &dyn Projection, xy: [f64; 2]) -> f64 {
        if bare.solid_angle_density(xy) <= 0.0 {
            return 0.0;
        }
        let [origin, direction] = line(bare, xy);
        let [from, to] = self.sight(origin, direction).ends;
        to - from
    }
}

/// Where the line at (x, y) begins, and where it points to.
fn line(bare: &dyn Projection, [x, y]: [f64; 2]) -> [Vector; 2] {
    let begin = bare.world_from_canonical([x, y, 0.0]);
    [begin.position, begin.direction.map(|along| -along)]
}

/// A camera and its view.
#[derive(Clone, Copy)]
pub(super) struct Scene<'a> {
    pub(super) scenery: &'a Scenery,
    /// The camera without depths, bounds and bodies.
    pub(super) bare: &'a dyn Projection,
    /// Whether its image is the disc in the square.
    pub(super) is_disc: bool,
}

impl Scene<'_> {
    /// Where the rim of a disc crosses a row or a column.
    fn rim(&self, across: f64) -> Vec<f64> {
        let square = 0.25 - (across - 0.5) * (across - 0.5);
        if !self.is_disc || square < 0.0 {
            return Vec::new();
        }
        vec![0.5 - square.sqrt(), 0.5 + square.sqrt()]
    }

    fn kind(&self, xy: [f64; 2]) -> Kind {
        if self.bare.solid_angle_density(xy) <= 0.0 {
            return Kind::Outside;
        }
        let [origin, direction] = line(self.bare, xy);
        self.scenery.sight(origin, direction).kind
    }

    /// The irradiance and the solid angle densities at (x, y).
    fn densities(&self, xy: [f64; 2], rule: &Gauss) -> [f64; 2] {
        let density = self.bare.solid_angle_density(xy);
        if density <= 0.0 {
            return [0.0; 2];
        }
        let [origin, direction] = line(self.bare, xy);
        let ends = self.scenery.sight(origin, direction).ends;
        if ends[1] <= ends[0] {
            return [0.0, density];
        }
        [density * self.scenery.glow.integral(origin, direction, ends, rule), density]
    }
}

/// A pixel: its lower left corner and its size.
#[derive(Clone, Copy, Debug)]
struct Pixel {
    corner: [f64; 2],
    size: [f64; 2],
}

impl Pixel {
    fn at(&self, [s, t]: [f64; 2]) -> [f64; 2] {
        [self.corner[0] + s * self.size[0], self.corner[1] + t * self.size[1]]
    }

    /// Where the rim of a disc crosses a row, from 0 to 1.
    fn rim_in_row(&self, scene: &Scene<'_>, t: f64) -> Vec<f64> {
        let crossings = scene.rim(self.at([0.0, t])[1]).into_iter();
        crossings.map(|x| (x - self.corner[0]) / self.size[0]).collect()
    }

    /// The rows in which the rim of a disc leaves the pixel, from 0 to 1.
    fn rows_of_rim(&self, scene: &Scene<'_>) -> Vec<f64> {
        let [left, right] = [0.0, 1.0].map(|s| scene.rim(self.at([s, 0.0])[0]));
        let crossings = left.into_iter().chain(right);
        crossings.map(|y| (y - self.corner[1]) / self.size[1]).collect()
    }

    /// Whether all lines of a lattice in it and a little around it meet the same.
    fn is_smooth(&self, scene: &Scene<'_>) -> bool {
        let is_crossed = |breaks: Vec<f64>| breaks.iter().any(|at| (0.0..=1.0).contains(at));
        if is_crossed(self.rows_of_rim(scene))
            || [0.0, 1.0].map(|t| is_crossed(self.rim_in_row(scene, t))).contains(&true)
        {
            return false;
        }
        let along = |k: usize| (k as f64 - 0.5) / (PROBES - 1) as f64;
        let kind = |k: usize| {
            let st = [along(k % (PROBES + 1)), along(k / (PROBES + 1))];
            // The lattice ends at the borders of the image.
            scene.kind(self.at(st).map(|x| x.clamp(0.0, 1.0)))
        };
        let first = kind(0);
        (1..(PROBES + 1) * (PROBES + 1)).all(|k| kind(k) == first)
    }

    /// The means of both densities by rules of these numbers of nodes.
    fn means(
        &self,
        scene: &Scene<'_>,
        is_smooth: bool,
        [side, part, depth]: [usize; 3],
    ) -> [f64; 2] {
        let along_line = Gauss::new(depth);
        let mut sums = [0.0; 2];
        let mut add = |st: [f64; 2], weight: f64| {
            let [value, density] = scene.densities(self.at(st), &along_line);
            sums[0] += weight * value;
            sums[1] += weight * density;
        };
        if is_smooth {
            let rule = Gauss::new(side);
            rule.weigh(0.0, 1.0, |t, of_row| rule.weigh(0.0, 1.0, |s, w| add([s, t], w * of_row)));
        } else {
            let rule = Gauss::new(part);
            for rows in pieces(&|t| self.sequence(scene, t), self.rows_of_rim(scene)) {
                smoothed(&rule, rows, |t, of_row| {
                    for ends in pieces(&|s| scene.kind(self.at([s, t])), self.rim_in_row(scene, t))
                    {
                        smoothed(&rule, ends, |s, weight| add([s, t], weight * of_row));
                    }
                });
            }
        }
        sums
    }

    /// The means of both densities by finer and finer rules until two agree to `allowed`, in the four
    /// quarters if none do; and the change by the last one, in the first density over the second.
    fn refined(&self, scene: &Scene<'_>, allowed: f64, quarterings: u32) -> ([f64; 2], f64) {
        let is_smooth = self.is_smooth(scene);
        let mut means = self.means(scene, is_smooth, RULES[0]);
        let mut change = f64::INFINITY;
        for rules in &RULES[1..] {
            let finer = self.means(scene, is_smooth, *rules);
            change = (finer[0] - means[0]).abs().max((finer[1] - means[1]).abs() * ratio(finer));
            means = finer;
            if change <= allowed * means[1] {
                return (means, change);
            }
        }
        if is_smooth || quarterings == 0 {
            return (means, change);
        }
        let quarter = |k: usize| {
            let size = self.size.map(|side| 0.5 * side);
            let corner = self.at([0.5 * (k % 2) as f64, 0.5 * (k / 2) as f64]);
            Self { corner, size }.refined(scene, allowed, quarterings - 1)
        };
        (0..4).map(quarter).fold(([0.0; 2], 0.0), |(sums, changes), (of_quarter, change)| {
            (core::array::from_fn(|k| sums[k] + 0.25 * of_quarter[k]), changes + 0.25 * change)
        })
    }

    /// What lines along a row meet, one after the other.
    fn sequence(&self, scene: &Scene<'_>, t: f64) -> Vec<Kind> {
        let kinds = (0..=PROBES).map(|k| scene.kind(self.at([k as f64 / PROBES as f64, t])));
        let mut kinds: Vec<Kind> = kinds.collect();
        kinds.dedup();
        kinds
    }
}

/// A rule on a piece, its nodes drawn to both ends: roots of the distance from an end are smooth in the
/// variable in which the nodes are those of Gauss.
fn smoothed(rule: &Gauss, [from, to]: [f64; 2], mut f: impl FnMut(f64, f64)) {
    rule.weigh(0.0, 1.0, |u, weight| {
        let (place, slope) = (u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u));
        f(from + (to - from) * place, weight * slope * (to - from));
    });
}

/// The parts of the unit interval on which `seen` does not change; some of the breaks may be `known`.
fn pieces<T: PartialEq>(seen: &dyn Fn(f64) -> T, mut known: Vec<f64>) -> Vec<[f64; 2]> {
    known.retain(|at| (0.0..1.0).contains(at));
    known.extend([0.0, 1.0]);
    known.sort_by(f64::total_cmp);
    known.windows(2).flat_map(|ends| pieces_between([ends[0], ends[1]], seen)).collect()
}

/// The parts of an interval on which `seen` does not change.
fn pieces_between<T: PartialEq>([from, to]: [f64; 2], seen: &dyn Fn(f64) -> T) -> Vec<[f64; 2]> {
    // The ends may be breaks.
    let probe = |k: usize| from + (to - from) * (k as f64 + 0.01) / (PROBES as f64 + 0.02);
    let mut breaks = vec![from];
    let mut last = seen(probe(0));
    for k in 1..=PROBES {
        let next = seen(probe(k));
        if next != last {
            let (mut low, mut high) = (probe(k - 1), probe(k));
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                if seen(middle) == last { low = middle } else { high = middle }
            }
            breaks.push(0.5 * (low + high));
        }
        last = next;
    }
    breaks.push(to);
    breaks.windows(2).map(|ends| [ends[0], ends[1]]).collect()
}

/// The radiance; 0 where there is no image.
fn ratio([value, density]: [f64; 2]) -> f64 {
    if density == 0.0 { 0.0 } else { value / density }
}

/// The image, each pixel with finer rules until two agree.
pub(super) fn image(scene: Scene<'_>, [height, width]: [usize; 2]) -> Reference {
    let pixel = |number: usize| Pixel {
        corner: [(number % width) as f64 / width as f64, (number / width) as f64 / height as f64],
        size: [1.0 / width as f64, 1.0 / height as f64],
    };
    let numbers = (0..height * width).into_par_iter();
    let coarse = numbers.clone().map(|number| {
        let is_smooth = pixel(number).is_smooth(&scene);
        ratio(pixel(number).means(&scene, is_smooth, RULES[0])).abs()
    });
    let largest = coarse.reduce(|| 0.0, f64::max);
    let refined = |number: usize| {
        let (means, change) = pixel(number).refined(&scene, AGREEMENT * largest, QUARTERINGS);
        match means[1] {
            0.0 => (f64::NAN, 0.0),
            area => (means[0] / area, change / area),
        }
    };
    let found: Vec<(f64, f64)> = numbers.map(refined).collect();
    let change = found.iter().map(|(_, change)| *change).fold(0.0, f64::max);
    let pixels = found.into_iter().map(|(value, _)| value).collect();
    let image = Image::from_pixels(height, width, pixels);
    Reference { image, error: change / largest + ROUNDING }
}

/// The mean of `lines` × `lines` lines for each pixel, wherever edges are.
#[cfg(test)]
pub(super) fn plain(scene: Scene<'_>, [height, width]: [usize; 2], lines: usize) -> Image {
    let rule = Gauss::new(12);
    let mean = |number: usize| {
        let of_line = |k: usize| {
            let inside = |k: usize| (k as f64 + 0.5) / lines as f64;
            let x = ((number % width) as f64 + inside(k % lines)) / width as f64;
            let y = ((number / width) as f64 + inside(k / lines)) / height as f64;
            scene.densities([x, y], &rule)
        };
        let sums = (0..lines * lines).map(of_line);
        let [value, density] = sums.fold([0.0; 2], |sum, of| [sum[0] + of[0], sum[1] + of[1]]);
        value / density
    };
    let pixels = (0..height * width).into_par_iter().map(mean).collect();
    Image::from_pixels(height, width, pixels)
}
