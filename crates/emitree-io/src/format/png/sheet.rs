//! The bands of a cube as one picture: tiles in reading order, the lowest energies first.

use crate::energies::{Energies, energy_range};
use crate::product::{Bands, ProductMap};
use emitree::Image;
use emitree_instrument::Channel;
use std::borrow::Cow;
use std::ops::Range;

/// The most tiles of a sheet; of more bins, neighbours share one.
const MOST_TILES: usize = 64;

/// A tile: the bands that it shows together, and what people call them; an image has no name.
pub(super) struct Tile<'a> {
    #[cfg_attr(
        not(feature = "figure"),
        expect(dead_code, reason = "bare pictures have no labels")
    )]
    pub(super) label: String,
    pub(super) image: Cow<'a, Image>,
}

/// What a picture shows beside each other: an image alone, the bins of a cube, or channels of counts.
/// Where bins share a tile it has the mean over their energies, which is the voxel of a wider bin;
/// where channels do, the sum of their counts.
pub(super) fn tiles<'a>(map: &ProductMap<'a>, energies: Option<&Energies>) -> Vec<Tile<'a>> {
    let bands = map.map.bands();
    match (map.bands, energies) {
        (Bands::Counts { channels }, _) => tiles_of(
            bands,
            |channels_of_tile| sum(bands, channels_of_tile.map(|channel| (channel, 1.0))),
            |channels_of_tile| range_of(&channels[channels_of_tile]),
        ),
        (Bands::Energies, Some(energies)) => {
            tiles_of(bands, |bins| mean(bands, bins, energies), |bins| energies.label(bins))
        }
        (Bands::Image, _) | (Bands::Energies, None) => {
            tiles_of(bands, |all| sum(bands, all.map(|band| (band, 1.0))), |_| String::new())
        }
    }
}

/// The tiles of bands, with what one has where several bands share it, and its name.
fn tiles_of<'a>(
    bands: &'a [Image],
    together: impl Fn(Range<usize>) -> Image,
    label: impl Fn(Range<usize>) -> String,
) -> Vec<Tile<'a>> {
    let of_tile = bands.len().div_ceil(MOST_TILES).max(1);
    let starts = (0..bands.len()).step_by(of_tile);
    let ranges = starts.map(|first| first..(first + of_tile).min(bands.len()));
    let tile = |range: Range<usize>| {
        let image = match &bands[range.clone()] {
            [band] => Cow::Borrowed(band),
            _ => Cow::Owned(together(range.clone())),
        };
        Tile { label: label(range), image }
    };
    ranges.map(tile).collect()
}

/// The nominal energies of channels side by side.
fn range_of(channels: &[Channel]) -> String {
    let ends = channels.iter().flat_map(|channel| channel.range_kev);
    let low = ends.clone().fold(f64::INFINITY, f64::min);
    energy_range([low, ends.fold(f64::NEG_INFINITY, f64::max)], "keV")
}

fn mean(bands: &[Image], bins: Range<usize>, energies: &Energies) -> Image {
    let axis = energies.axis();
    let whole: f64 = bins.clone().map(|bin| axis.width(bin)).sum();
    sum(bands, bins.map(|bin| (bin, axis.width(bin) / whole)))
}

/// The sum of some bands, each with its weight.
fn sum(bands: &[Image], weights: impl Iterator<Item = (usize, f64)>) -> Image {
    let [height, width] = bands.first().map_or([0; 2], |band| [band.height(), band.width()]);
    let mut sum = Image::zeros(height, width);
    for (band, weight) in weights {
        for (sum, pixel) in sum.pixels_mut().iter_mut().zip(bands[band].pixels()) {
            *sum += weight * pixel;
        }
    }
    sum
}

/// As many columns as make a sheet of so many tiles about square, each of them `proportion` times
/// as wide as high.
pub(super) fn columns(tiles: usize, proportion: f64) -> usize {
    let wanted = (tiles as f64 / proportion).sqrt().ceil();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a whole number above 0, at most that of the tiles after the clamp"
    )]
    let columns = wanted.clamp(1.0, tiles.max(1) as f64) as usize;
    // No column less would do with as many rows.
    tiles.div_ceil(tiles.div_ceil(columns).max(1)).max(1)
}

/// The tiles as one image, y up: what is between them, and what is left of the last row, is NaN.
pub(super) fn joined(tiles: &[Image]) -> Image {
    let [height, width] = tiles.first().map_or([0; 2], |tile| [tile.height(), tile.width()]);
    if tiles.len() < 2 {
        return tiles.first().cloned().unwrap_or_else(|| Image::zeros(0, 0));
    }
    let gap = (height.max(width) / 50).max(1);
    let columns = columns(tiles.len(), width as f64 / height as f64);
    let rows = tiles.len().div_ceil(columns);
    let along = |tiles: usize, edge: usize| tiles * (edge + gap) - gap;
    let (sheet_height, sheet_width) = (along(rows, height), along(columns, width));
    let mut pixels = vec![f64::NAN; sheet_height * sheet_width];
    for (number, tile) in tiles.iter().enumerate() {
        // The first row of tiles is the highest one.
        let [bottom, left] =
            [(rows - 1 - number / columns) * (height + gap), (number % columns) * (width + gap)];
        for (row, from) in tile.rows().enumerate() {
            let start = (bottom + row) * sheet_width + left;
            pixels[start..][..width].copy_from_slice(from);
        }
    }
    Image::from_pixels(sheet_height, sheet_width, pixels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use emitree::{Cube, EnergyAxis, EnergyScale};

    fn energies(bins: usize) -> Energies {
        let axis = EnergyAxis::new(1.0, 16.0, bins, EnergyScale::Log).unwrap();
        Energies::new(axis, "keV").unwrap()
    }

    fn bands(bins: usize) -> Vec<Image> {
        (0..bins).map(|bin| Image::from_pixels(1, 1, vec![bin as f64])).collect()
    }

    fn map<'a>(map: &'a Cube, bands: Bands<'a>) -> ProductMap<'a> {
        ProductMap { name: "", map, unit: "", bands }
    }

    #[test]
    fn neighbours_share_a_tile_where_there_are_many() {
        let cubes = [64, 130, 200].map(|bins| Cube::from_bands(bands(bins)));
        let of = |number: usize, bins: usize| {
            tiles(&map(&cubes[number], Bands::Energies), Some(&energies(bins)))
        };
        let few = of(0, 64);
        assert!(few.len() == 64 && few[63].label == energies(64).label(63..64));
        let many = of(1, 130);
        assert_eq!((many.len(), &*many[43].label), (44, &*energies(130).label(129..130)));
        let all = of(2, 200);
        let axis = *energies(200).axis();
        let sum: f64 = (0..200).map(|bin| bin as f64 * axis.width(bin)).sum();
        let width = |tile: usize| (4 * tile..4 * tile + 4).map(|bin| axis.width(bin)).sum::<f64>();
        let of_tiles = all.iter().enumerate().map(|(at, tile)| tile.image[(0, 0)] * width(at));
        assert!((of_tiles.sum::<f64>() / sum - 1.0).abs() < 1e-13);
    }

    #[test]
    fn channels_that_share_a_tile_are_added() {
        let edges = |number: i32| [f64::from(number) * 0.5, f64::from(number + 1) * 0.5];
        let channels = (0..130).map(|n| Channel { number: n.into(), range_kev: edges(n) });
        let (cube, channels): (_, Vec<Channel>) =
            (Cube::from_bands(bands(130)), channels.collect());
        let of_tiles = Bands::Counts { channels: &channels };
        let tiles = tiles(&map(&cube, of_tiles), Some(&energies(4)));
        assert_eq!((tiles.len(), &*tiles[1].label), (44, "1.5–3 keV"));
        assert_eq!(tiles[1].image[(0, 0)].to_bits(), 12_f64.to_bits());
        let total: f64 = tiles.iter().map(|tile| tile.image[(0, 0)]).sum();
        assert_eq!(total.to_bits(), 8385_f64.to_bits());
    }

    #[test]
    fn sheets_are_about_square() {
        assert_eq!([1, 2, 3, 12, 64].map(|tiles| columns(tiles, 1.0)), [1, 2, 2, 4, 8]);
        assert_eq!((columns(12, 4.0), columns(12, 0.01), columns(5, 100.0)), (2, 12, 1));
    }

    #[test]
    fn tiles_are_in_reading_order() {
        let sheet = joined(&bands(3));
        assert_eq!((sheet.height(), sheet.width()), (3, 3));
        let corners = [sheet[(2, 0)], sheet[(2, 2)], sheet[(0, 0)]];
        assert_eq!(corners.map(f64::to_bits), [0.0, 1.0, 2.0].map(f64::to_bits));
        for at in [(0, 2), (1, 0), (2, 1)] {
            assert!(sheet[at].is_nan(), "{at:?}");
        }
        assert_eq!(joined(&bands(1)), bands(1)[0]);
    }
}
