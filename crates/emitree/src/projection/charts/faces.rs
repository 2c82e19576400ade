//! Charts of bounds that are a box: lines of sight by the faces at which they enter and leave it.
//!
//! The path of a line through a box is smooth as long as these two faces stay the same, and has a kink
//! in the image where one of them changes. All lines that enter by one face and leave by another one
//! are a chart.
//!
//! On the plane of the face by which lines enter, in units of the edges of the box, the image of the
//! opposite face, seen by the observer, is a rectangle, from l to h along b and c. Lines through it leave by the
//! opposite face. All others leave by a side: the planes through the observer and the edges between
//! sides are seen as straight lines from the corners of the face to those of the rectangle, so that the
//! region of each side is a trapezoid with two parallel edges. In it u is the distance from the outer
//! edge, and v the place between the two straight lines. If the observer is inside of the box, the
//! coordinates are those of the point on the face by which a line leaves.

use crate::projection::MappedPoint;
use crate::projection::ViewGeometry;
use crate::projection::bounds::Cuboid;
use crate::projection::charts::chart::{Chart, Window, image_place};
use crate::projection::span::Span;
use crate::projection::surroundings::{Observer, SightLine, Surroundings};
use crate::projection::vector::{difference, dot, unit};

/// The least extent of a region, and distance of the observer from a face, in units of the edges of the
/// box: rounding moves a place by far less.
const LEAST: f64 = 1e-12;
/// How far from the faces g is evaluated at least, in units of the edges.
const INSIDE: f64 = 1e-9;

/// A face of a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Face {
    axis: usize,
    is_max: bool,
}

/// The six faces of a box.
const FACES: [Face; 6] = {
    let mut faces = [Face { axis: 0, is_max: false }; 6];
    let mut number = 0;
    while number < 6 {
        faces[number] = Face { axis: number / 2, is_max: number % 2 == 1 };
        number += 1;
    }
    faces
};

/// The lines that enter a box by one face, if the observer is outside, and leave it by another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Passage {
    cuboid: Cuboid,
    enter: Option<Face>,
    leave: Face,
    region: Region,
}

/// The region of a passage on its face, in coordinates b and c from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Region {
    /// From the first corner to the second one.
    Rectangle([[f64; 2]; 2]),
    Trapezoid(Trapezoid),
}

/// Lines that leave by a side, with the coordinate b across it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Trapezoid {
    /// Whether c is the first coordinate of the face, and b the second one.
    is_turned: bool,
    /// The outer edge, 0 or 1, and the length of the region across it if it reaches to the rectangle.
    outer: f64,
    length: f64,
    /// The ends of c on the edge of the rectangle.
    ends: [f64; 2],
    /// The part of the length that is on the face.
    part: f64,
}

/// All passages through a box.
#[derive(Clone, Debug)]
pub(super) struct Faces {
    cuboid: Cuboid,
    observer: Observer,
    passages: Vec<Passage>,
}

impl Faces {
    pub(super) fn new(cuboid: Cuboid, observer: Observer) -> Self {
        let entered: Vec<Face> =
            FACES.into_iter().filter(|face| height(&cuboid, observer, *face) > LEAST).collect();
        let mut passages = Vec::new();
        if entered.is_empty() {
            let region = Region::Rectangle([[0.0; 2], [1.0; 2]]);
            passages.extend(FACES.map(|leave| Passage { cuboid, enter: None, leave, region }));
        }
        for &enter in &entered {
            let rectangle = seen_through(&cuboid, observer, enter);
            let left = FACES.into_iter().filter(|face| !entered.contains(face));
            let passage = |leave| {
                let region = region(rectangle, enter, leave)?;
                Some(Passage { cuboid, enter: Some(enter), leave, region })
            };
            passages.extend(left.filter_map(passage));
        }
        Self { cuboid, observer, passages }
    }

    pub(super) fn passages(&self) -> &[Passage] {
        &self.passages
    }

    /// The number of the passage of a line, with the coordinates (u, v) there; `None` if the line does not
    /// meet the box ahead of the observer.
    pub(super) fn place(&self, line: &SightLine) -> Option<(usize, [f64; 2])> {
        let [(enter, from), (leave, to)] = crossing(&self.cuboid, line)?;
        let is_ahead = matches!(self.observer, Observer::Parallel { .. }) || to > 0.0;
        let is_own = |passage: &Passage| {
            passage.leave == leave && passage.enter.is_none_or(|first| first == enter)
        };
        let number = self.passages.iter().position(is_own).filter(|_| is_ahead)?;
        Some((number, self.passages[number].place(line, [from, to])))
    }
}

/// The faces by which a line enters and leaves a box, with their distances.
fn crossing(cuboid: &Cuboid, line: &SightLine) -> Option<[(Face, f64); 2]> {
    let mut found: [Option<(Face, f64)>; 2] = [None; 2];
    for face in FACES {
        let along = line.direction[face.axis];
        let from_origin = cuboid.plane(face.axis, face.is_max) - line.origin[face.axis];
        let is_left = (along > 0.0) == face.is_max;
        if along == 0.0 {
            // The line is between the two faces, or misses the box.
            let is_outside = if face.is_max { from_origin < 0.0 } else { from_origin > 0.0 };
            if is_outside {
                return None;
            }
            continue;
        }
        let distance = from_origin / along;
        let is_nearer = |(_, other): (Face, f64)| {
            if is_left { distance < other } else { distance > other }
        };
        let end = &mut found[usize::from(is_left)];
        if end.is_none_or(is_nearer) {
            *end = Some((face, distance));
        }
    }
    let [enter, leave] = [found[0]?, found[1]?];
    (enter.1 < leave.1).then_some([enter, leave])
}

impl Passage {
    /// The face on which the coordinates are.
    fn face(&self) -> Face {
        self.enter.unwrap_or(self.leave)
    }

    /// The axes along which they are.
    fn axes(&self) -> [usize; 2] {
        others(self.face().axis)
    }

    /// (u, v) of a line of the passage that enters and leaves the box at two distances.
    fn place(&self, line: &SightLine, [from, to]: [f64; 2]) -> [f64; 2] {
        let at = line.at(if self.enter.is_some() { from } else { to });
        let place = self.cuboid.place_of(at);
        self.region.place(self.axes().map(|axis| place[axis]))
    }

    /// Its chart with what is in view of it.
    pub(super) fn chart<'a>(
        self,
        surroundings: &'a Surroundings,
        window: Window,
        tiles: Vec<&'a dyn ViewGeometry>,
    ) -> FaceChart<'a> {
        FaceChart { surroundings, passage: self, window, tiles }
    }
}

/// The two other axes, in ascending order.
fn others(axis: usize) -> [usize; 2] {
    [[1, 2], [0, 2], [0, 1]][axis]
}

/// The distance of the observer from the plane of a face, on its outer side, in units of the edge across
/// it. For parallel lines, the negative direction across it.
fn height(cuboid: &Cuboid, observer: Observer, face: Face) -> f64 {
    let sign = if face.is_max { 1.0 } else { -1.0 };
    match observer {
        Observer::Point(position) => {
            let plane = cuboid.plane(face.axis, face.is_max);
            sign * (position[face.axis] - plane) / cuboid.edge(face.axis)
        }
        Observer::Parallel { direction, .. } => -sign * direction[face.axis],
    }
}

/// The opposite face as it is seen through a face: the ends of its edges along the two other axes, from 0 to 1 on
/// the face.
fn seen_through(cuboid: &Cuboid, observer: Observer, face: Face) -> [[f64; 2]; 2] {
    others(face.axis).map(|axis| match observer {
        Observer::Point(position) => {
            let height = height(cuboid, observer, face);
            let scale = height / (1.0 + height);
            let foot = (position[axis] - cuboid.plane(axis, false)) / cuboid.edge(axis);
            [0.0, 1.0].map(|end| foot + (end - foot) * scale)
        }
        Observer::Parallel { direction, .. } => {
            let shift = direction[axis] / cuboid.edge(axis) * cuboid.edge(face.axis)
                / direction[face.axis].abs();
            [-shift, 1.0 - shift]
        }
    })
}

/// The region of the lines that enter by one face and leave by another; `None` if there are none.
fn region(rectangle: [[f64; 2]; 2], enter: Face, leave: Face) -> Option<Region> {
    if leave.axis == enter.axis {
        let cut = rectangle.map(|[low, high]| [low.max(0.0), high.min(1.0)]);
        let [[low_b, high_b], [low_c, high_c]] = cut;
        let is_seen = high_b - low_b > LEAST && high_c - low_c > LEAST;
        return is_seen.then_some(Region::Rectangle([[low_b, low_c], [high_b, high_c]]));
    }
    let is_turned = others(enter.axis)[1] == leave.axis;
    let [across, along] = if is_turned { [rectangle[1], rectangle[0]] } else { rectangle };
    let (outer, length) = if leave.is_max { (1.0, 1.0 - across[1]) } else { (0.0, across[0]) };
    // As far as the face, and the straight lines do not cross on it.
    let [low, high] = along;
    let of_low = if low > 1.0 { 1.0 / low } else { 1.0 };
    let of_high = if high < 0.0 { 1.0 / (1.0 - high) } else { 1.0 };
    let part = f64::min(1.0, 1.0 / length).min(of_low).min(of_high);
    let trapezoid = Trapezoid { is_turned, outer, length, ends: along, part };
    (length > LEAST).then_some(Region::Trapezoid(trapezoid))
}

impl Region {
    /// (u, v) of a place on the face.
    fn place(&self, place: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Rectangle([low, high]) => {
                core::array::from_fn(|k| (place[k] - low[k]) / (high[k] - low[k]))
            }
            Self::Trapezoid(trapezoid) => trapezoid.place(place),
        }
    }

    /// The place on the face at (u, v).
    fn at(&self, uv: [f64; 2]) -> [f64; 2] {
        match self {
            Self::Rectangle([low, high]) => {
                core::array::from_fn(|k| low[k] + uv[k] * (high[k] - low[k]))
            }
            Self::Trapezoid(trapezoid) => trapezoid.at(uv),
        }
    }
}

impl Trapezoid {
    /// The ends of c at a part of the length.
    fn between(&self, part: f64) -> [f64; 2] {
        let [low, high] = self.ends;
        [(low * part).max(0.0), (1.0 + (high - 1.0) * part).min(1.0)]
    }

    fn place(&self, place: [f64; 2]) -> [f64; 2] {
        let [b, c] = if self.is_turned { [place[1], place[0]] } else { place };
        let part = (b - self.outer).abs() / self.length;
        let [low, high] = self.between(part);
        // At the tip all v are the same place.
        let v = if high - low > LEAST { (c - low) / (high - low) } else { 0.5 };
        [part / self.part, v]
    }

    fn at(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let part = u * self.part;
        let [low, high] = self.between(part);
        let inwards = if self.outer > 0.5 { -1.0 } else { 1.0 };
        let (b, c) = (self.outer + inwards * part * self.length, low + v * (high - low));
        if self.is_turned { [c, b] } else { [b, c] }
    }
}

/// The chart of one passage.
#[derive(Debug)]
pub(super) struct FaceChart<'a> {
    surroundings: &'a Surroundings,
    passage: Passage,
    window: Window,
    /// The image planes of all tiles.
    tiles: Vec<&'a dyn ViewGeometry>,
}

impl FaceChart<'_> {
    /// The line of sight at (u, v), between the two faces: those by which rounding may have it pass do not
    /// matter.
    pub(super) fn line_at(&self, uv: [f64; 2]) -> SightLine {
        let Passage { cuboid, enter, leave, .. } = self.passage;
        let face = self.passage.face();
        let [b, c] = self.passage.axes();
        let [at_b, at_c] = self.passage.region.at(self.window.natural(uv));
        let mut place = [if face.is_max { 1.0 } else { 0.0 }; 3];
        (place[b], place[c]) = (at_b, at_c);
        let position = cuboid.at(place);
        let (origin, direction) = match self.surroundings.observer {
            Observer::Point(origin) => {
                // At the observer itself all directions are alike.
                (origin, unit(difference(position, origin)).unwrap_or([0.0, 0.0, 1.0]))
            }
            Observer::Parallel { plane_point, direction } => {
                let back = dot(difference(plane_point, position), direction);
                let origin = core::array::from_fn(|i| position[i] + back * direction[i]);
                (origin, direction)
            }
        };
        let distance = |face: Face| {
            let plane = cuboid.plane(face.axis, face.is_max);
            (plane - origin[face.axis]) / direction[face.axis]
        };
        let [near, far] = self.surroundings.depths();
        let from = enter.map_or(near, |enter| near.max(distance(enter)));
        let to = distance(leave);
        let to = if to.is_nan() { from } else { far.min(to).max(from) };
        SightLine { origin, direction, ends: [from, to] }
    }

    fn span(&self, line: &SightLine) -> Span {
        let [from, to] = line.ends;
        self.surroundings.span(from, to)
    }
}

impl Chart for FaceChart<'_> {
    fn world_from_chart(&self, [u, v, z]: [f64; 3]) -> MappedPoint {
        let line = self.line_at([u, v]);
        let mut point = line.point(&self.span(&line), z);
        // Rounding does not move points out of the box.
        let cuboid = self.passage.cuboid;
        let place = cuboid.place_of(point.position);
        let is_inside = |along: &f64| (INSIDE..=1.0 - INSIDE).contains(along);
        if !place.iter().all(is_inside) {
            point.position = cuboid.at(place.map(|along| along.clamp(INSIDE, 1.0 - INSIDE)));
        }
        point
    }

    fn chart_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        let line = self.surroundings.line_to(position)?;
        let Passage { cuboid, enter, leave, .. } = self.passage;
        let [(first, from), (last, to)] = crossing(&cuboid, &line)?;
        if leave != last || enter.is_some_and(|enter| enter != first) {
            return None;
        }
        let place = self.passage.place(&line, [from, to]);
        let distance = dot(difference(position, line.origin), line.direction);
        let [u, v] = self.window.unit(place);
        Some([u, v, self.span(&line).z_of(distance)])
    }

    fn density(&self, _uv: [f64; 2]) -> f64 {
        1.0
    }

    fn line(&self, uv: [f64; 2]) -> Option<SightLine> {
        Some(self.line_at(uv))
    }

    fn depth_of(&self, line: &SightLine, distance: f64) -> f64 {
        self.span(line).z_of(distance).clamp(0.0, 1.0)
    }

    fn image_place(&self, uv: [f64; 2]) -> (usize, [f64; 2]) {
        image_place(&self.tiles, &self.line_at(uv))
    }
}
