//! Method `paper` with an energy axis: a sparse tree of four dimensions (x, y, z, energy), projected
//! along z, sampled to voxels.
//!
//! The tree's function is the canonical integrand g · ds/dz · dΩ/(dx dy) · dE/du, so that the tree
//! along x, y and u that the projection leaves has the irradiance density in each voxel. Refinement,
//! projection and sampling are those of images: an energy axis is one more axis.

use crate::cube::Cube;
use crate::emission::Emission;
use crate::energy::EnergyAxis;
use crate::error::RenderError;
use crate::image::Image;
use crate::meter::{CanonicalIntegrand, Meter, SpectralIntegrand};
use crate::radiance::{solid_angles, to_radiance};
use crate::refinement::Threshold;
use crate::render::Tile;
use crate::render_cube::CubeRendering;
use crate::tree::{BuildOptions, Ending, SparseTree, build};

/// The cube of each tile, stacked.
pub(crate) fn render<E: Emission>(
    meter: &Meter<'_, E>,
    tiles: &[Tile<'_>],
    axis: &EnergyAxis,
    options: &BuildOptions,
) -> Result<CubeRendering, RenderError<E::Error>> {
    let mut ending = Ending::Complete;
    let [mut cubes, mut errors] = [Vec::new(), Vec::new()];
    for tile in tiles {
        let of_tile = render_tile(meter, tile, axis, options)?;
        if ending == Ending::Complete {
            ending = of_tile.ending;
        }
        cubes.push(of_tile.cube);
        errors.push(of_tile.error);
    }
    let mut rendering = CubeRendering::new(stacked(cubes), Some(stacked(errors)), ending);
    rendering.base_level = Some(options.base_level);
    Ok(rendering)
}

/// The cube of one tile.
struct TileCube {
    cube: Cube,
    /// What the last generation of cells changed.
    error: Cube,
    ending: Ending,
}

fn render_tile<E: Emission>(
    meter: &Meter<'_, E>,
    tile: &Tile<'_>,
    axis: &EnergyAxis,
    options: &BuildOptions,
) -> Result<TileCube, RenderError<E::Error>> {
    let &Tile { projection, shape, place } = tile;
    let threshold = match options.threshold {
        Threshold::Absolute(size) => {
            // In the unit of g: the weight in the middle stands for all.
            let middle = projection.world_from_canonical([0.5; 3]);
            let of_view = middle.path_per_depth * projection.solid_angle([0.0; 2], [1.0; 2]);
            Threshold::Absolute(size * of_view * axis.energy_per_canonical(0.5))
        }
        relative @ Threshold::Relative(_) => relative,
    };
    let options = BuildOptions { threshold, ..*options };
    let canonical = CanonicalIntegrand { meter, projection, tile: place };
    let integrand = SpectralIntegrand { canonical, axis };
    let [x, y, z] = projection.periodic();
    let built = build(&integrand, [x, y, z, false], &options)?;

    let solid_angles = solid_angles(projection, shape);
    let cube = cube_of_tree(&built.tree.project(2), &solid_angles, axis);
    for band in cube.bands() {
        tile.check_finite(band)?;
    }
    let mut error = cube_of_tree(&built.previous.project(2), &solid_angles, axis);
    for (error, band) in error.bands_mut().iter_mut().zip(cube.bands()) {
        for (error, voxel) in error.pixels_mut().iter_mut().zip(band.pixels()) {
            *error = (*error - voxel).abs();
        }
    }
    Ok(TileCube { cube, error, ending: built.ending })
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

/// Cubes of equal width and bins one above the other, the lowest first.
fn stacked(mut cubes: Vec<Cube>) -> Cube {
    if cubes.len() == 1 {
        return cubes.remove(0);
    }
    let bins = cubes.first().map_or(0, |cube| cube.bands().len());
    let band = |bin: usize| Image::stacked(cubes.iter().map(|cube| &cube.bands()[bin]));
    Cube::from_bands((0..bins).map(band).collect())
}
