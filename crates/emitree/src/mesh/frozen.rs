//! What a method leaves for a mesh: points, their weights at nodes, and the map from nodes to values.

use crate::cube::Cube;
use crate::exchange::Batch;
use crate::known::{Point, key};
use crate::mesh::sparse::SparseMatrix;
use crate::mesh::start::Structure;
use crate::site::Site;
use core::fmt::Debug;
use rustc_hash::FxHashMap;

/// The linear map from values at nodes to a cube.
pub(crate) trait NodesToCube: Send + Sync + Debug {
    /// The cube for one value at each node.
    fn cube(&self, nodes: &[f64]) -> Cube;
}

/// The frozen quadrature of a rendering.
#[derive(Debug)]
pub(crate) struct Frozen {
    /// The points, without rates.
    pub(crate) points: Batch,
    /// A row for each node, a column for each point.
    pub(crate) weights: SparseMatrix,
    image: Box<dyn NodesToCube>,
    /// What renderings of other emissions can begin with.
    pub(crate) structure: Option<Structure>,
    /// All rates of the rendering in the order of its requests.
    pub(crate) recorded: Vec<f64>,
}

impl Frozen {
    /// The cube for one rate at each point.
    pub(crate) fn cube(&self, rates: &[f64]) -> Cube {
        self.cube_of_nodes(&self.weights.times(rates))
    }

    /// The cube for one value at each node.
    pub(crate) fn cube_of_nodes(&self, nodes: &[f64]) -> Cube {
        self.image.cube(nodes)
    }

    /// The quadratures of tiles, the lowest first, as one.
    pub(crate) fn stacked(of_tiles: Vec<Self>) -> Self {
        let (mut points, mut weights) = (Batch::default(), SparseMatrix::new());
        let mut images = Vec::with_capacity(of_tiles.len());
        for tile in of_tiles {
            points.positions.extend(tile.points.positions);
            points.directions.extend(tile.points.directions);
            points.energies.extend(tile.points.energies);
            weights.append(&tile.weights);
            images.push((tile.weights.rows(), tile.image));
        }
        let image = Box::new(Stacked(images));
        Self { points, weights, image, structure: None, recorded: Vec::new() }
    }
}

/// The maps of tiles, the lowest first, each with its number of nodes.
#[derive(Debug)]
struct Stacked(Vec<(usize, Box<dyn NodesToCube>)>);

impl NodesToCube for Stacked {
    fn cube(&self, nodes: &[f64]) -> Cube {
        let mut first = 0;
        let cube = |(count, image): &(usize, Box<dyn NodesToCube>)| {
            first += count;
            image.cube(&nodes[first - count..first])
        };
        let cubes: Vec<Cube> = self.0.iter().map(cube).collect();
        Cube::stacked(&cubes.iter().collect::<Vec<_>>())
    }
}

/// Collects points and weights, node by node. A point that several nodes use is one point.
#[derive(Debug)]
pub(crate) struct Collector {
    points: Batch,
    numbers: FxHashMap<Point, usize>,
    weights: SparseMatrix,
}

impl Collector {
    pub(crate) fn new() -> Self {
        let numbers = FxHashMap::default();
        Self { points: Batch::default(), numbers, weights: SparseMatrix::new() }
    }

    /// Adds a node, whose value is the sum of weight times G at the sites.
    pub(crate) fn node(&mut self, terms: impl IntoIterator<Item = (Site, f64)>) {
        let mut row = Vec::new();
        for (Site { point, energy, .. }, weight) in terms {
            // g is not evaluated where its weight is 0, as by the meter.
            if point.path_per_depth == 0.0 {
                continue;
            }
            let next = self.points.len();
            let number = key(point.position, point.direction, energy);
            let number = *self.numbers.entry(number).or_insert(next);
            if number == next {
                self.points.positions.push(point.position);
                self.points.directions.push(point.direction);
                self.points.energies.extend(energy);
            }
            row.push((number, weight * point.path_per_depth));
        }
        self.weights.push(row);
    }

    pub(crate) fn finish(self, image: impl NodesToCube + 'static) -> Frozen {
        let Self { points, weights, .. } = self;
        let (image, recorded) = (Box::new(image), Vec::new());
        Frozen { points, weights, image, structure: None, recorded }
    }
}
