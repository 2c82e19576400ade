//! `[bounds]`, `[[occulter]]`, `[[edge]]` and `[[singularity]]`: what lines of sight are clipped to, what they
//! end at, where the emission jumps or has a kink, and where it is singular.

use super::super::document::Node;
use super::super::error::SceneError;
use super::super::source::Place;
use super::super::table::Table;
use emitree::projection::{Bounds, Edge, Ellipsoid, GeometryError, Singularity};
use emitree_models::catalogue::{SingularPoint, SphericalEdge};
use emitree_models::grid::GridAxes;

/// The tables of shapes of a scene.
pub(in crate::scene) struct ShapeTables {
    pub(in crate::scene) bounds: Option<Table>,
    pub(in crate::scene) occulters: Vec<Table>,
    pub(in crate::scene) edges: Vec<Table>,
    pub(in crate::scene) singularities: Vec<Table>,
}

/// The form of a shape, as far as it matters where it is relative to a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::scene) enum Shape {
    /// A point.
    Point([f64; 3]),
    /// An ellipsoid: its centre, and the vectors from there to the ends of its semi-axes.
    Ellipsoid { centre: [f64; 3], semi_axes: [[f64; 3]; 3] },
    /// A box along the axes of the world.
    Box,
    /// A plane: a point of it, and its normal of length 1.
    Plane { position: [f64; 3], normal: [f64; 3] },
    /// A line: a point of it, and its direction of length 1.
    Axis { position: [f64; 3], direction: [f64; 3] },
}

/// A shape that a scene has, by what messages call it.
pub(in crate::scene) struct ShapeOfScene {
    pub(in crate::scene) name: String,
    pub(in crate::scene) place: Place,
    pub(in crate::scene) shape: Shape,
}

impl From<&Ellipsoid> for Shape {
    fn from(ellipsoid: &Ellipsoid) -> Self {
        let (centre, semi_axes) = (ellipsoid.centre(), ellipsoid.semi_axis_vectors());
        Self::Ellipsoid { centre, semi_axes }
    }
}

/// The shapes of a scene.
pub(super) struct Shapes {
    pub(super) bounds: Option<Bounds>,
    pub(super) bodies: Vec<Ellipsoid>,
    /// Where each body was written.
    pub(super) places: Vec<Place>,
    pub(super) edges: Vec<Edge>,
    pub(super) singularities: Vec<Singularity>,
    /// Where the bounds, each edge and each singularity were written.
    others: Vec<Place>,
}

impl Shapes {
    /// Those that the scene has itself, without those of its emission.
    pub(super) fn listed(&self) -> Vec<ShapeOfScene> {
        let bounds = self.bounds.iter().map(|bounds| match bounds {
            Bounds::Ellipsoid(ellipsoid) => ("`[bounds]`".to_owned(), ellipsoid.into()),
            _ => ("`[bounds]`".to_owned(), Shape::Box),
        });
        let numbered = |key: &str, number: usize| format!("`[[{key}]]` {}", number + 1);
        let edges = self.edges.iter().enumerate().filter_map(|(number, edge)| {
            let shape = match edge {
                Edge::Ellipsoid(ellipsoid) => ellipsoid.into(),
                &Edge::Plane { position, normal, .. } => Shape::Plane { position, normal },
                _ => return None,
            };
            Some((numbered("edge", number), shape))
        });
        let singularities = self.singularities.iter().enumerate().map(|(number, of)| {
            let position = of.position();
            let shape = match of.direction() {
                Some(direction) => Shape::Axis { position, direction },
                None => Shape::Point(position),
            };
            (numbered("singularity", number), shape)
        });
        let bodies = self.bodies.iter().enumerate();
        let bodies = bodies.map(|(number, body)| (numbered("occulter", number), body.into()));
        let others = bounds.chain(edges).chain(singularities).zip(&self.others);
        bodies
            .zip(&self.places)
            .chain(others)
            .map(|((name, shape), place)| ShapeOfScene { name, place: place.clone(), shape })
            .collect()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.bounds.is_none()
            && self.bodies.is_empty()
            && self.edges.is_empty()
            && self.singularities.is_empty()
    }

    /// Adds the singular points of the emission, given `factor` of its length units in one of the scene. A
    /// singularity of the scene at the same place replaces that of the emission.
    pub(super) fn add_singular_points(&mut self, points: Vec<SingularPoint>, factor: f64) {
        for point in points {
            let position = point.position.map(|along| along / factor);
            let size = position.iter().fold(0.0, |most: f64, along| most.max(along.abs()));
            let is_there = |of: &Singularity| {
                let pairs = of.position().into_iter().zip(position);
                pairs.into_iter().all(|(a, b)| (a - b).abs() <= 1e-9 * size)
            };
            if self.singularities.iter().any(is_there) {
                continue;
            }
            let found = Singularity::point(position).and_then(|found| match point.exponent {
                Some(exponent) => found.with_exponent(exponent),
                None => Ok(found),
            });
            self.singularities.extend(found.ok());
        }
    }

    /// Adds what surrounds data on a grid: their bounds, if the scene has none, and the edges at which they end, if no
    /// other shape has the same surface.
    pub(super) fn add_ends_of(&mut self, axes: &GridAxes) {
        self.bounds = self.bounds.or(axes.bounds());
        axes.edges().into_iter().for_each(|edge| self.add_edge(edge));
    }

    /// Adds the edges that the emission has, given `factor` of its length units in one of the scene, if no other shape
    /// has the same surface.
    pub(super) fn add_edges(&mut self, edges: Vec<SphericalEdge>, factor: f64) {
        for SphericalEdge { centre, radius, .. } in edges {
            let sphere = Ellipsoid::sphere(centre.map(|along| along / factor), radius / factor);
            sphere.into_iter().for_each(|sphere| self.add_edge(Edge::Ellipsoid(sphere)));
        }
    }

    fn add_edge(&mut self, edge: Edge) {
        let Edge::Ellipsoid(surface) = edge else { return };
        let of_bounds = self.bounds.iter().filter_map(|bounds| match bounds {
            Bounds::Ellipsoid(ellipsoid) => Some(ellipsoid),
            _ => None,
        });
        let of_edges = self.edges.iter().filter_map(|edge| match edge {
            Edge::Ellipsoid(ellipsoid) => Some(ellipsoid),
            _ => None,
        });
        let mut others = of_bounds.chain(&self.bodies).chain(of_edges);
        if !others.any(|other| are_one(other, &surface)) {
            self.edges.push(edge);
        }
    }
}

/// Whether two ellipsoids are the same surface, but for the rounding of units.
fn are_one(first: &Ellipsoid, second: &Ellipsoid) -> bool {
    let vectors = |of: &Ellipsoid| {
        let [a, b, c] = of.semi_axis_vectors();
        [of.centre(), a, b, c].into_iter().flatten().collect::<Vec<f64>>()
    };
    let (first, second) = (vectors(first), vectors(second));
    let size = first.iter().fold(0.0, |most: f64, along| most.max(along.abs()));
    first.iter().zip(&second).all(|(a, b)| (a - b).abs() <= 1e-9 * size)
}

const POINT: &str = "three numbers [x, y, z] in `length_unit`";
const DIRECTION: &str = "three numbers [x, y, z]";
const LENGTH: &str = "a length in `length_unit`";

pub(super) fn read(tables: ShapeTables) -> Result<Shapes, SceneError> {
    let ShapeTables { bounds, occulters, edges, singularities } = tables;
    let places = occulters.iter().map(|table| table.place().clone()).collect();
    let tables = bounds.iter().chain(&edges).chain(&singularities);
    let others = tables.map(|table| table.place().clone()).collect();
    let bodies = occulters.into_iter().map(read_body).collect::<Result<_, _>>()?;
    let bounds = bounds.map(read_bounds).transpose()?;
    let edges = edges.into_iter().map(read_edge).collect::<Result<_, _>>()?;
    let singularities =
        singularities.into_iter().map(read_singularity).collect::<Result<_, _>>()?;
    Ok(Shapes { bounds, bodies, places, edges, singularities, others })
}

fn read_body(mut table: Table) -> Result<Ellipsoid, SceneError> {
    const KINDS: &str = "`sphere` or `ellipsoid`";
    let (kind, place) = table.require("type", KINDS)?.text()?;
    let body = match kind.as_str() {
        "sphere" => sphere(&mut table)?,
        "ellipsoid" => ellipsoid(&mut table)?,
        _ => return Err(unknown("body", &kind, &place, KINDS)),
    };
    table.finish()?;
    Ok(body)
}

fn read_bounds(mut table: Table) -> Result<Bounds, SceneError> {
    const KINDS: &str = "`sphere`, `ellipsoid` or `box`";
    let (kind, place) = table.require("type", KINDS)?.text()?;
    let bounds = match kind.as_str() {
        "sphere" => Bounds::Ellipsoid(sphere(&mut table)?),
        "ellipsoid" => Bounds::Ellipsoid(ellipsoid(&mut table)?),
        "box" => cuboid(&mut table)?,
        _ => return Err(unknown("shape", &kind, &place, KINDS)),
    };
    table.finish()?;
    Ok(bounds)
}

fn read_edge(mut table: Table) -> Result<Edge, SceneError> {
    const KINDS: &str = "`sphere`, `ellipsoid` or `plane`";
    let (kind, place) = table.require("type", KINDS)?.text()?;
    let edge = match kind.as_str() {
        "sphere" => Edge::Ellipsoid(sphere(&mut table)?),
        "ellipsoid" => Edge::Ellipsoid(ellipsoid(&mut table)?),
        "plane" => plane(&mut table)?,
        _ => return Err(unknown("edge", &kind, &place, KINDS)),
    };
    table.finish()?;
    Ok(edge)
}

fn read_singularity(mut table: Table) -> Result<Singularity, SceneError> {
    const KINDS: &str = "`point` or `axis`";
    let (kind, place) = table.require("type", KINDS)?.text()?;
    let position = table.require("position", POINT)?;
    let (direction, found) = match kind.as_str() {
        "point" => (None, Singularity::point(position.vector(POINT)?)),
        "axis" => {
            let direction = table.require("direction", DIRECTION)?;
            let (at, along) = (position.vector(POINT)?, direction.vector(DIRECTION)?);
            (Some(direction), Singularity::axis(at, along))
        }
        _ => return Err(unknown("singularity", &kind, &place, KINDS)),
    };
    let exponent = table.take("exponent");
    let of_exponent = exponent.as_ref().map(Node::number).transpose()?;
    let found = found.and_then(|found| match of_exponent {
        Some(exponent) => found.with_exponent(exponent),
        None => Ok(found),
    });
    let found = found.map_err(|error| {
        let direction = direction.as_ref().unwrap_or(&position);
        let exponent = exponent.as_ref().unwrap_or(&position);
        refuse(&error, &position, &[("direction", direction), ("exponent", exponent)])
    })?;
    table.finish()?;
    Ok(found)
}

fn unknown(what: &str, kind: &str, place: &Place, kinds: &str) -> SceneError {
    SceneError::at(place, format!("unknown {what} `{kind}`")).label(format!("expected {kinds}"))
}

fn sphere(table: &mut Table) -> Result<Ellipsoid, SceneError> {
    let (center, radius) = (table.require("center", POINT)?, table.require("radius", LENGTH)?);
    let sphere = Ellipsoid::sphere(center.vector(POINT)?, radius.number()?);
    sphere.map_err(|error| refuse(&error, &center, &[("radius", &radius)]))
}

fn ellipsoid(table: &mut Table) -> Result<Ellipsoid, SceneError> {
    const LENGTHS: &str = "three lengths [a, b, c] in `length_unit`";
    let center = table.require("center", POINT)?;
    let semi_axes = table.require("semi_axes", LENGTHS)?;
    let (pole, meridian) = (table.take("pole"), table.take("meridian"));
    let direction = |node: &Option<Node>, default: [f64; 3]| {
        node.as_ref().map_or(Ok(default), |node| node.vector(DIRECTION))
    };
    let toward_pole = direction(&pole, [0.0, 0.0, 1.0])?;
    let toward_meridian = direction(&meridian, [1.0, 0.0, 0.0])?;
    let body = Ellipsoid::new(center.vector(POINT)?, semi_axes.vector(LENGTHS)?);
    body.and_then(|body| body.oriented(toward_pole, toward_meridian)).map_err(|error| {
        let pole = pole.as_ref().unwrap_or(&semi_axes);
        let meridian = meridian.as_ref().unwrap_or(pole);
        let others = [("semi_axes", &semi_axes), ("pole", pole), ("meridian", meridian)];
        refuse(&error, &center, &others)
    })
}

fn cuboid(table: &mut Table) -> Result<Bounds, SceneError> {
    let (min, max) = (table.require("min", POINT)?, table.require("max", POINT)?);
    let cuboid = Bounds::cuboid(min.vector(POINT)?, max.vector(POINT)?);
    cuboid.map_err(|error| refuse(&error, &min, &[("max", &max)]))
}

fn plane(table: &mut Table) -> Result<Edge, SceneError> {
    let position = table.require("position", POINT)?;
    let normal = table.require("normal", DIRECTION)?;
    let plane = Edge::plane(position.vector(POINT)?, normal.vector(DIRECTION)?);
    plane.map_err(|error| refuse(&error, &position, &[("normal", &normal)]))
}

/// The error of a shape, at the key among `others` that it names, or else at `first`.
fn refuse(error: &GeometryError, first: &Node, others: &[(&str, &Node)]) -> SceneError {
    let named = match error {
        GeometryError::OutOfRange { name, .. } | GeometryError::Vector { name, .. } => *name,
        _ => "",
    };
    let found = others.iter().find(|(name, _)| *name == named);
    SceneError::at(&found.map_or(first, |(_, node)| node).place, error.to_string())
}
