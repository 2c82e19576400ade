//! Scattered places in a region, and what the neighbours of a pixel say of the radiance within it.

use crate::cube::Cube;
use crate::tile::Tile;
use crate::vol::lattice;
use crate::vol::sums::functional::Functional;

/// The share of places that are distributed by the coefficients alone; the others also by the errors of the
/// pixels. No place counts for more than twice what it would without errors.
const PLAIN_SHARE: f64 = 0.5;

/// The fractional part of the golden ratio: its multiples fill an interval evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// How places are distributed in a region.
pub(super) struct Distribution {
    /// The voxels with a coefficient, in the order of a curve that fills each band.
    voxels: Vec<Voxel>,
    /// The probabilities of all voxels up to each one.
    cumulative: Vec<f64>,
}

/// A voxel: its band, and the number of its pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Voxel {
    pub(super) band: usize,
    pub(super) pixel: usize,
}

/// A place in a voxel, and the one opposite of the centre, which has the same weight.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacePair {
    pub(super) voxel: Voxel,
    /// The distances from the centre along x, y and the energy, −½ to ½; of a point, the last one is that from
    /// the middle of the depths.
    pub(super) offset: [f64; 3],
    /// The coefficient of the voxel over its probability.
    pub(super) weight: f64,
}

impl Distribution {
    pub(super) fn new(functional: &Functional<'_>, errors: Option<&Cube>) -> Self {
        let coefficients = functional.of_pixels.pixels();
        let width = functional.of_pixels.width();
        let mut pixels: Vec<usize> =
            (0..coefficients.len()).filter(|&pixel| coefficients[pixel] != 0.0).collect();
        pixels.sort_by_key(|&pixel| along_curve(pixel / width, pixel % width));
        let bands = 0..functional.of_bands.len();
        let voxels: Vec<Voxel> =
            bands.flat_map(|band| pixels.iter().map(move |&pixel| Voxel { band, pixel })).collect();
        let plain = |voxel: &Voxel| coefficient(functional, *voxel).abs();
        let error_of = |voxel: &Voxel| {
            let error =
                errors.map_or(0.0, |errors| errors.bands()[voxel.band].pixels()[voxel.pixel]);
            if error.is_finite() { plain(voxel) * error } else { 0.0 }
        };
        let sums: [f64; 2] = [voxels.iter().map(plain).sum(), voxels.iter().map(error_of).sum()];
        let plain_share = if sums[1] > 0.0 { PLAIN_SHARE } else { 1.0 };
        let mut cumulative = Vec::with_capacity(voxels.len());
        let mut so_far = 0.0;
        for voxel in &voxels {
            so_far += plain_share * plain(voxel) / sums[0];
            if plain_share < 1.0 {
                so_far += (1.0 - plain_share) * error_of(voxel) / sums[1];
            }
            cumulative.push(so_far);
        }
        Self { voxels, cumulative }
    }

    /// Pair `i` of an infinite sequence.
    pub(super) fn pair(&self, functional: &Functional<'_>, i: usize) -> PlacePair {
        let [along, x, y] = lattice::point(i);
        let last = self.cumulative.len() - 1;
        let along = along * self.cumulative[last];
        let k = self.cumulative.partition_point(|&to| to <= along).min(last);
        let from = if k == 0 { 0.0 } else { self.cumulative[k - 1] };
        let probability = (self.cumulative[k] - from) / self.cumulative[last];
        let voxel = self.voxels[k];
        let energy = ((i as f64 + 0.5) * GOLDEN).fract();
        let weight = coefficient(functional, voxel) / probability;
        PlacePair { voxel, offset: [x, y, energy].map(|at| at - 0.5), weight }
    }
}

fn coefficient(functional: &Functional<'_>, Voxel { band, pixel }: Voxel) -> f64 {
    functional.of_pixels.pixels()[pixel] * functional.of_bands[band]
}

/// The place of a pixel on Morton's curve: places that follow each other are close to each other.
fn along_curve(row: usize, column: usize) -> u64 {
    let spread = |along: usize| {
        (0..32).fold(0, |bits: u64, bit| bits | (along as u64 >> bit & 1) << (2 * bit))
    };
    spread(row) << 1 | spread(column)
}

impl PlacePair {
    /// The number of the tile that it is on.
    pub(super) fn tile(&self, tiles: &[Tile<'_>]) -> usize {
        let [rows, columns] = tiles[0].shape;
        self.voxel.pixel / columns / rows
    }

    /// The mean of the voxel and of what its neighbours let expect at both places: the image of a smooth
    /// emission within a voxel is nearly its mean plus a polynomial of degree 2, the odd terms of which
    /// cancel.
    pub(super) fn expected(&self, cube: &Cube, tile: &Tile<'_>) -> f64 {
        let Voxel { band, pixel } = self.voxel;
        let image = &cube.bands()[band];
        let width = image.width();
        let [row, column] = [pixel / width, pixel % width];
        let first_row = tile.place.0 * tile.shape[0];
        let at = |down: isize, right: isize| {
            let row = row.checked_add_signed(down)?;
            let column = column.checked_add_signed(right)?;
            let is_inside = (first_row..first_row + tile.shape[0]).contains(&row) && column < width;
            is_inside.then(|| image[(row, column)]).filter(|value| value.is_finite())
        };
        let centre = image.pixels()[pixel];
        let curvature =
            |a: Option<f64>, b: Option<f64>| a.zip(b).map_or(0.0, |(a, b)| a + b - 2.0 * centre);
        let [u, v, e] = self.offset;
        let even = |t: f64| 0.5 * (t * t - 1.0 / 12.0);
        let corners = [at(1, 1), at(-1, -1), at(1, -1), at(-1, 1)];
        let twist = match corners {
            [Some(a), Some(b), Some(c), Some(d)] => 0.25 * (a + b - c - d),
            _ => 0.0,
        };
        let beside =
            |band: Option<usize>| cube.bands().get(band?).map(|image| image.pixels()[pixel]);
        let along_energy = curvature(beside(band.checked_sub(1)), beside(band.checked_add(1)));
        centre
            + curvature(at(0, 1), at(0, -1)) * even(u)
            + curvature(at(1, 0), at(-1, 0)) * even(v)
            + along_energy * even(e)
            + twist * u * v
    }
}
