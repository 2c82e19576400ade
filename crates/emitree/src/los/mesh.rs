//! The frozen quadrature of line-of-sight integration: its nodes are the lines, at each energy.

use super::adaptive::weighted_nodes;
use super::{Lines, StepsTaken};
use crate::cube::Cube;
use crate::image::Image;
use crate::mesh::frozen::{Collector, Frozen, NodesToCube};
use crate::site::Site;
use crate::tile::Tile;

/// The lines of a tile, while energies are added.
pub(super) struct FrozenLines {
    image: ImageOfLines,
    collector: Collector,
    /// The weights of the energies of the present bin.
    bin: Vec<f64>,
}

/// The map from lines to pixels.
#[derive(Debug)]
struct ImageOfLines {
    lines: Lines,
    /// The density of solid angle on each line, its weight in its pixel.
    densities: Vec<f64>,
    /// The weights of the energies of each bin.
    bins: Vec<Vec<f64>>,
}

impl FrozenLines {
    pub(super) fn new(tile: &Tile<'_>, per_side: usize) -> Self {
        let [height, width] = tile.shape;
        let lines = Lines { height, width, per_side };
        let density = |line: usize| tile.projection.solid_angle_density(lines.position(line));
        let densities = (0..lines.count()).map(density).collect();
        let image = ImageOfLines { lines, densities, bins: Vec::new() };
        Self { image, collector: Collector::new(), bin: Vec::new() }
    }

    /// Adds the lines at an energy with this weight in the present bin.
    pub(super) fn add(
        &mut self,
        tile: &Tile<'_>,
        steps: &StepsTaken,
        energy: Option<f64>,
        weight: f64,
    ) {
        let Self { image: ImageOfLines { lines, .. }, collector, bin } = self;
        bin.push(weight);
        let mut of_line = |line: usize, depths: &[(f64, f64)]| {
            let xy @ [x, y] = lines.position(line);
            collector.node(depths.iter().map(|&(z, weight)| {
                let point = tile.projection.world_from_canonical([x, y, z]);
                (Site { xy, point, energy, tile: tile.place }, weight)
            }));
        };
        match steps {
            StepsTaken::Fixed(steps) => {
                let middle = |step: usize| (step as f64 + 0.5) / *steps as f64;
                let depths: Vec<(f64, f64)> =
                    (0..*steps).map(|step| (middle(step), 1.0 / *steps as f64)).collect();
                (0..lines.count()).for_each(|line| of_line(line, &depths));
            }
            StepsTaken::Adaptive(panels) => {
                let mut depths: Vec<Vec<(f64, f64)>> = vec![Vec::new(); lines.count()];
                for (line, panel) in panels {
                    depths[*line].extend(weighted_nodes(*panel));
                }
                depths.iter().enumerate().for_each(|(line, depths)| of_line(line, depths));
            }
        }
    }

    pub(super) fn end_bin(&mut self) {
        self.image.bins.push(core::mem::take(&mut self.bin));
    }

    pub(super) fn finish(self) -> Frozen {
        self.collector.finish(self.image)
    }
}

impl NodesToCube for ImageOfLines {
    fn cube(&self, mut nodes: &[f64]) -> Cube {
        let Lines { height, width, .. } = self.lines;
        let mut bands = Vec::with_capacity(self.bins.len());
        for energies in &self.bins {
            let mut band = Image::zeros(height, width);
            for weight in energies {
                let (values, rest) = nodes.split_at(self.lines.count());
                band.add_scaled(&self.lines.weighted(values, |k| self.densities[k]), *weight);
                nodes = rest;
            }
            bands.push(band);
        }
        Cube::from_bands(bands)
    }
}
