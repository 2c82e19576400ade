//! Method `paper`: a sparse tree of the canonical integrand, projected along the line of sight and sampled.
//!
//! With an energy axis u there is one axis more: the tree is one of g · ds/dz · dΩ/(dx dy) · dE/du, so that
//! the tree along x, y and u that the projection leaves has the irradiance density in each voxel. Refinement,
//! projection and sampling are those of images.

use crate::cube::Cube;
use crate::energy::EnergyAxis;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::mesh::frozen::{Collector, Frozen, NodesToCube};
use crate::meter::{CanonicalIntegrand, Meter, SpectralIntegrand};
use crate::output::MethodOutput;
use crate::radiance::{image_of_tree, solid_angles, to_radiance};
use crate::refinement::Threshold;
use crate::rendering::RenderedTree;
use crate::site::Site;
use crate::tile::Tile;
use crate::tree::{BuildOptions, SparseTree, build_async};
use std::sync::Arc;

/// The image, or the cube in the bins of `axis`; the error is what the last generation of cells changed.
pub(crate) async fn render(
    meter: &Meter,
    tiles: &[Tile<'_>],
    axis: Option<&EnergyAxis>,
    options: &BuildOptions,
) -> Result<MethodOutput, MethodError> {
    let mut of_tiles = Vec::with_capacity(tiles.len());
    for tile in tiles {
        let mut made = match axis {
            None => image(meter, tile, options).await?,
            Some(axis) => cube(meter, tile, axis, options).await?,
        };
        made.base_level = Some(options.base_level);
        made.cube.bands().iter().try_for_each(|band| tile.check_finite(band, 0))?;
        of_tiles.push(made);
    }
    Ok(MethodOutput::stacked(of_tiles))
}

/// The weight of g in the middle of the view, which stands for all of it: an absolute threshold is in the
/// unit of g.
fn weight_in_the_middle(tile: &Tile<'_>) -> f64 {
    let middle = tile.projection.world_from_canonical([0.5; 3]);
    middle.path_per_depth * tile.projection.solid_angle([0.0; 2], [1.0; 2])
}

/// The options in the unit of an integrand of which g is weighted with `weight`.
fn weighted(options: &BuildOptions, weight: f64) -> BuildOptions {
    let threshold = match options.threshold {
        Threshold::Absolute(size) => Threshold::Absolute(size * weight),
        relative @ Threshold::Relative(_) => relative,
    };
    BuildOptions { threshold, ..*options }
}

/// The image of one tile.
async fn image(
    meter: &Meter,
    tile: &Tile<'_>,
    options: &BuildOptions,
) -> Result<MethodOutput, MethodError> {
    let &Tile { projection, shape, place } = tile;
    let weight = weight_in_the_middle(tile);
    let integrand = CanonicalIntegrand { meter, projection, tile: place };
    let options = weighted(options, weight);
    let built = build_async(&integrand, projection.periodic(), &options).await?;
    let image = image_of_tree(&built.tree.project(2), projection, shape);
    let before = image_of_tree(&built.previous.project(2), projection, shape);
    let [cube, before] = [image, before].map(|image| Cube::from_bands(vec![image]));
    let error = changes(before, &cube);
    let mut made = MethodOutput::new(cube, Some(error), built.ending);
    if meter.freezes() {
        let solid_angles = solid_angles(projection, shape);
        let image = TreeImage { tree: built.tree.clone(), solid_angles };
        made.frozen = Some(Arc::new(frozen(&built.tree, &options, |u| integrand.site(u), image)));
    }
    made.tree = Some(RenderedTree { tree: built.tree, threshold: built.threshold / weight });
    Ok(made)
}

/// The cube of one tile.
async fn cube(
    meter: &Meter,
    tile: &Tile<'_>,
    axis: &EnergyAxis,
    options: &BuildOptions,
) -> Result<MethodOutput, MethodError> {
    let &Tile { projection, shape, place } = tile;
    let options = weighted(options, weight_in_the_middle(tile) * axis.energy_per_canonical(0.5));
    let canonical = CanonicalIntegrand { meter, projection, tile: place };
    let integrand = SpectralIntegrand { canonical, axis };
    let [x, y, z] = projection.periodic();
    let built = build_async(&integrand, [x, y, z, false], &options).await?;
    let solid_angles = solid_angles(projection, shape);
    let cube = cube_of_tree(&built.tree.project(2), &solid_angles, axis);
    let error = changes(cube_of_tree(&built.previous.project(2), &solid_angles, axis), &cube);
    let mut made = MethodOutput::new(cube, Some(error), built.ending);
    if meter.freezes() {
        let image = TreeCube { tree: built.tree.clone(), solid_angles, axis: *axis };
        made.frozen = Some(Arc::new(frozen(&built.tree, &options, |u| integrand.site(u), image)));
    }
    Ok(made)
}

/// The frozen quadrature of a tree: its nodes are the leaves.
fn frozen<const D: usize>(
    tree: &SparseTree<D>,
    options: &BuildOptions,
    site: impl Fn([f64; D]) -> Site,
    image: impl NodesToCube + 'static,
) -> Frozen {
    let mut collector = Collector::new();
    tree.for_each_leaf(|cell, _| {
        let points = options.rule.terms(cell, tree.periodic()).into_iter();
        collector.node(points.map(|(u, weight)| (site(u), weight)));
    });
    collector.finish(image)
}

/// The image of a tree from the averages of its leaves.
#[derive(Debug)]
struct TreeImage {
    tree: SparseTree<3>,
    solid_angles: Image,
}

impl NodesToCube for TreeImage {
    fn cube(&self, leaves: &[f64]) -> Cube {
        let [height, width] = [self.solid_angles.height(), self.solid_angles.width()];
        let mut image = self.tree.with_leaves(leaves).project::<2>(2).sample(height, width);
        to_radiance(&mut image, &self.solid_angles);
        Cube::from_bands(vec![image])
    }
}

/// The cube of a tree from the averages of its leaves.
#[derive(Debug)]
struct TreeCube {
    tree: SparseTree<4>,
    solid_angles: Image,
    axis: EnergyAxis,
}

impl NodesToCube for TreeCube {
    fn cube(&self, leaves: &[f64]) -> Cube {
        let projected = self.tree.with_leaves(leaves).project(2);
        cube_of_tree(&projected, &self.solid_angles, &self.axis)
    }
}

/// What each voxel has changed by.
fn changes(mut before: Cube, after: &Cube) -> Cube {
    for (before, after) in before.bands_mut().iter_mut().zip(after.bands()) {
        for (before, after) in before.pixels_mut().iter_mut().zip(after.pixels()) {
            *before = (*before - after).abs();
        }
    }
    before
}

/// The radiance per unit of energy of each voxel from the tree of the irradiance density along x, y
/// and u; NaN where the projection has no image.
fn cube_of_tree(tree: &SparseTree<3>, solid_angles: &Image, axis: &EnergyAxis) -> Cube {
    let mut cube = tree.sample_cube(axis.bins(), solid_angles.height(), solid_angles.width());
    let du = 1.0 / axis.bins() as f64;
    for (bin, band) in cube.bands_mut().iter_mut().enumerate() {
        to_radiance(band, solid_angles);
        let per_energy = du / axis.width(bin);
        band.pixels_mut().iter_mut().for_each(|voxel| *voxel *= per_energy);
    }
    cube
}
