//! Which pixels the limbs, the borders of sectors and the rim of a view cross: from lines of sight at the corners of
//! the pixels, which neighbours share, and in their middles.

use crate::projection::charts::{Atlas, PieceOfLine};
use crate::projection::{SightLine, ViewGeometry};
use crate::vol::view::pixel_rule::Crossing;
use core::ops::Range;

/// How far from a limb, in units of the variation of the distance from it over a pixel, the square
/// root of the radiance matters.
const BESIDE: f64 = 1.0;
/// How far between the corners of a pixel a limb may be from where it is at them, in the same units, where the body
/// is larger than the pixel; the variation above which a body is not: with it a limb is straight to 0.04.
const CURVATURE: f64 = 0.25;
const SMALL_BODY: f64 = 0.5;
/// A body has at least so many times the size of a part of a pixel.
const PARTS: f64 = 2.0;
/// The most parts along each side of a pixel.
const MOST_PARTS: usize = 16;

/// The image plane of a tile, and what lines of sight meet.
#[derive(Clone, Copy)]
pub(crate) struct Plane<'a> {
    pub(crate) atlas: Option<&'a Atlas<'a>>,
    pub(crate) geometry: &'a dyn ViewGeometry,
    /// Height and width of the tile.
    pub(crate) shape: [usize; 2],
}

/// What is known of a place on the image plane.
#[derive(Clone, Debug)]
pub(crate) struct Corner {
    /// The density of solid angle.
    pub(crate) density: f64,
    line: Option<SightLine>,
    /// The distances from the centres of limbs, in units of their radii.
    misses: Vec<f64>,
    /// The number of the sectors.
    sectors: u64,
    is_inside: bool,
}

impl Plane<'_> {
    /// At a place that is counted in halves of pixels.
    fn corner(&self, twice_row: usize, twice_column: usize) -> Corner {
        let along = |twice: usize, count: usize| twice as f64 / (2 * count) as f64;
        let [height, width] = self.shape;
        let xy = [along(twice_column, width), along(twice_row, height)];
        let density = self.geometry.solid_angle_density(xy);
        let is_inside = !self.geometry.has_rim() || density > 0.0;
        let line = self.geometry.line(xy);
        let mut corner = Corner { density, line, misses: Vec::new(), sectors: 0, is_inside };
        if let Some((atlas, line)) = self.atlas.zip(line) {
            atlas.misses(&line, &mut corner.misses);
            corner.sectors = atlas.sectors(&line);
        }
        corner
    }

    fn border(&self, row: usize) -> Vec<Corner> {
        (0..=self.shape[1]).map(|column| self.corner(2 * row, 2 * column)).collect()
    }

    fn middles(&self, row: usize) -> Vec<Corner> {
        (0..self.shape[1]).map(|column| self.corner(2 * row + 1, 2 * column + 1)).collect()
    }
}

impl Corner {
    /// The pieces of its line of sight in the charts of an atlas.
    pub(crate) fn pieces(&self, atlas: &Atlas<'_>) -> Vec<PieceOfLine> {
        let mut pieces = Vec::new();
        self.line.iter().for_each(|line| atlas.pieces(line, &mut pieces));
        pieces
    }
}

/// The corners and middles of the pixels of successive rows of a tile.
pub(crate) struct CornersOfRows {
    pub(crate) rows: Range<usize>,
    /// The corners below each row, and above the last one.
    pub(crate) borders: Vec<Vec<Corner>>,
    /// By row.
    pub(crate) middles: Vec<Vec<Corner>>,
    /// The corners below the first border and above the last one, if there is a rim.
    beyond: [Option<Vec<Corner>>; 2],
    has_rim: bool,
}

impl CornersOfRows {
    pub(crate) fn new(plane: Plane<'_>, rows: Range<usize>) -> Self {
        let has_rim = plane.geometry.has_rim();
        let borders = (rows.start..=rows.end).map(|row| plane.border(row)).collect();
        let middles = rows.clone().map(|row| plane.middles(row)).collect();
        let beyond = [rows.start.checked_sub(1), Some(rows.end + 1)];
        let is_there = |row: &usize| has_rim && *row <= plane.shape[0];
        let beyond = beyond.map(|row| row.filter(is_there).map(|row| plane.border(row)));
        Self { rows, borders, middles, beyond, has_rim }
    }

    /// The border `offset` above the one below a row.
    fn border(&self, row: usize, offset: isize) -> Option<&Vec<Corner>> {
        let number = (row - self.rows.start).checked_add_signed(offset);
        match number {
            None => self.beyond[0].as_ref(),
            Some(number) => self.borders.get(number).or(self.beyond[1].as_ref()),
        }
    }

    /// Whether edges cross the pixels of a row.
    pub(crate) fn crossings(&self, row: usize) -> Vec<Crossing> {
        let k = row - self.rows.start;
        let (below, above) = (&self.borders[k], &self.borders[k + 1]);
        // A rim may pass between the corners of a pixel, but not between those of its neighbours.
        let rows = [-1, 0, 1, 2].map(|offset| self.border(row, offset));
        let rim_crosses = |column: usize| {
            let columns = column.saturating_sub(1)..(column + 3).min(below.len());
            let mut corners = rows.iter().flatten().flat_map(|row| &row[columns.clone()]);
            let is_inside = below[column].is_inside;
            self.has_rim && corners.any(|corner| corner.is_inside != is_inside)
        };
        let of_pixel = |(column, middle): (usize, &Corner)| {
            let around =
                [&below[column], &below[column + 1], &above[column], &above[column + 1], middle];
            if rim_crosses(column) || around.iter().any(|corner| corner.sectors != middle.sectors) {
                return of_limbs(Crossing::Crossed(1), &around);
            }
            match (middle.is_inside, below[column].is_inside) {
                (true, true) => {}
                (false, false) => return Crossing::Outside,
                (true, false) | (false, true) => return Crossing::Crossed(1),
            }
            of_limbs(Crossing::None, &around)
        };
        self.middles[k].iter().enumerate().map(of_pixel).collect()
    }
}

/// Whether limbs cross a pixel, given its corners and its middle and whether other edges do.
fn of_limbs(others: Crossing, around: &[&Corner]) -> Crossing {
    let limbs = around.first().map_or(0, |corner| corner.misses.len());
    (0..limbs).fold(others, |crossing, limb| {
        let misses = || around.iter().filter_map(|corner| corner.misses.get(limb).copied());
        let (low, high) = (misses().fold(f64::INFINITY, f64::min), misses().fold(0.0, f64::max));
        let spread = high - low;
        let is_within = |times: f64| low - times * spread < 1.0 && high + times * spread > 1.0;
        // Between corners a limb is curved: a body of the size of a pixel may be anywhere in it.
        let between = if spread > SMALL_BODY { 1.0 } else { CURVATURE };
        if is_within(between) {
            let parts = crate::cell::whole((PARTS * spread).ceil()).clamp(1, MOST_PARTS);
            let before = if let Crossing::Crossed(before) = crossing { before } else { 1 };
            Crossing::Crossed(before.max(parts))
        } else if crossing == Crossing::None && is_within(1.0 + BESIDE) {
            Crossing::Beside
        } else {
            crossing
        }
    })
}
