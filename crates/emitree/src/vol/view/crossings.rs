//! Which pixels the limbs, the borders of sectors and the rim of a view cross.

use crate::projection::ViewGeometry;
use crate::projection::charts::Atlas;
use crate::vol::view::pixel_rule::Crossing;

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

/// What is known of a place on the image plane.
#[derive(Clone, Debug)]
struct Corner {
    /// The distances from the centres of limbs, in units of their radii.
    misses: Vec<f64>,
    /// The number of the sectors.
    sectors: u64,
    is_inside: bool,
}

impl Corner {
    fn new(atlas: Option<&Atlas<'_>>, geometry: &dyn ViewGeometry, xy: [f64; 2]) -> Self {
        let is_inside = !geometry.has_rim() || geometry.solid_angle_density(xy) > 0.0;
        let mut corner = Self { misses: Vec::new(), sectors: 0, is_inside };
        if let Some((atlas, line)) = atlas.zip(geometry.line(xy)) {
            atlas.misses(&line, &mut corner.misses);
            corner.sectors = atlas.sectors(&line);
        }
        corner
    }
}

/// Whether edges cross the pixels of a row of an image of `geometry` with this height and width, in
/// the charts of an atlas.
pub(crate) fn crossings_of_row(
    atlas: Option<&Atlas<'_>>,
    geometry: &dyn ViewGeometry,
    [height, width]: [usize; 2],
    row: usize,
) -> Vec<Crossing> {
    // Places are counted in halves of pixels.
    let corner = |twice_row: usize, twice_column: usize| {
        let along = |twice: usize, count: usize| twice as f64 / (2 * count) as f64;
        Corner::new(atlas, geometry, [along(twice_column, width), along(twice_row, height)])
    };
    let border = |row: usize| (0..=width).map(|k| corner(2 * row, 2 * k)).collect::<Vec<_>>();
    let [below, above] = [row, row + 1].map(border);
    // A rim may pass between the corners of a pixel, but not between those of its neighbours.
    let beyond = [row.checked_sub(1), Some(row + 2).filter(|row| *row <= height)];
    let beyond = beyond.map(|row| row.filter(|_| geometry.has_rim()).map(border));
    let rim_crosses = |column: usize| {
        let rows = [Some(&below), Some(&above), beyond[0].as_ref(), beyond[1].as_ref()];
        let columns = column.saturating_sub(1)..(column + 3).min(width + 1);
        let mut corners = rows.into_iter().flatten().flat_map(|row| &row[columns.clone()]);
        let is_inside = below[column].is_inside;
        geometry.has_rim() && corners.any(|corner| corner.is_inside != is_inside)
    };
    let of_pixel = |column: usize| {
        let middle = corner(2 * row + 1, 2 * column + 1);
        let around =
            [&below[column], &below[column + 1], &above[column], &above[column + 1], &middle];
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
    (0..width).map(of_pixel).collect()
}

/// Whether limbs cross a pixel, given its corners and its middle and whether other edges do.
fn of_limbs(others: Crossing, around: &[&Corner]) -> Crossing {
    let limbs = around.first().map_or(0, |corner| corner.misses.len());
    (0..limbs).fold(others, |crossing, limb| {
        let misses = || around.iter().map(|corner| corner.misses[limb]);
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
