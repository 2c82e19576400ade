//! The bands of a cube as one picture: tiles in reading order, the lowest energies first.

use emitree::Image;
use emitree_io::{Energies, Scene};
use std::borrow::Cow;
use std::ops::Range;

/// The most tiles of a sheet; of more bins, neighbours share one.
const MOST_TILES: usize = 64;

/// A tile: the bins that it shows, and their mean; an image without energies has none.
pub(super) struct Tile<'a> {
    bins: Option<Range<usize>>,
    pub(super) image: Cow<'a, Image>,
}

impl<'a> Tile<'a> {
    pub(super) fn of_image(image: &'a Image) -> Self {
        Self { bins: None, image: Cow::Borrowed(image) }
    }

    /// The energies that it shows.
    pub(super) fn label(&self, scene: &Scene) -> String {
        let label = |energies: &Energies| Some(energies.label(self.bins.clone()?));
        scene.energy.as_ref().and_then(label).unwrap_or_default()
    }
}

/// The tiles of a cube's bands; where bins share one, it has the mean over their energies, which is
/// the voxel of a wider bin.
pub(super) fn tiles<'a>(bands: &'a [Image], energies: &Energies) -> Vec<Tile<'a>> {
    let together = bands.len().div_ceil(MOST_TILES).max(1);
    let starts = (0..bands.len()).step_by(together);
    let ranges = starts.map(|first| first..(first + together).min(bands.len()));
    let tile = |bins: Range<usize>| {
        let image = match &bands[bins.clone()] {
            [band] => Cow::Borrowed(band),
            _ => Cow::Owned(mean(bands, bins.clone(), energies)),
        };
        Tile { bins: Some(bins), image }
    };
    ranges.map(tile).collect()
}

fn mean(bands: &[Image], bins: Range<usize>, energies: &Energies) -> Image {
    let axis = energies.axis();
    let whole: f64 = bins.clone().map(|bin| axis.width(bin)).sum();
    let [height, width] = bands.first().map_or([0; 2], |band| [band.height(), band.width()]);
    let mut mean = Image::zeros(height, width);
    for bin in bins {
        let weight = axis.width(bin) / whole;
        for (mean, pixel) in mean.pixels_mut().iter_mut().zip(bands[bin].pixels()) {
            *mean += weight * pixel;
        }
    }
    mean
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
    use emitree::{EnergyAxis, EnergyScale};

    fn energies(bins: usize) -> Energies {
        let axis = EnergyAxis::new(1.0, 16.0, bins, EnergyScale::Log).unwrap();
        Energies::new(axis, "keV").unwrap()
    }

    fn bands(bins: usize) -> Vec<Image> {
        (0..bins).map(|bin| Image::from_pixels(1, 1, vec![bin as f64])).collect()
    }

    #[test]
    fn neighbours_share_a_tile_where_there_are_many() {
        let bands_of = [64, 130, 200].map(bands);
        let few = tiles(&bands_of[0], &energies(64));
        assert!(few.len() == 64 && few[63].bins == Some(63..64));
        let many = tiles(&bands_of[1], &energies(130));
        assert_eq!((many.len(), many[43].bins.clone()), (44, Some(129..130)));
        let all = tiles(&bands_of[2], &energies(200));
        let axis = *energies(200).axis();
        let sum: f64 = (0..200).map(|bin| bin as f64 * axis.width(bin)).sum();
        let width =
            |tile: &Tile<'_>| tile.bins.clone().unwrap().map(|bin| axis.width(bin)).sum::<f64>();
        let of_tiles: f64 = all.iter().map(|tile| tile.image[(0, 0)] * width(tile)).sum();
        assert!((of_tiles / sum - 1.0).abs() < 1e-13);
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
