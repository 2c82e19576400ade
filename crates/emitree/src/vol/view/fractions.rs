//! Coverage fractions: the part of a layer's radiance in each pixel of an image with edges.
//!
//! An edge (a limb, the rim of a disc) divides a pixel into regions, on each of which the coverage
//! fraction of a [layer](crate::projection::Layer) is smooth. In a pixel that an edge crosses, the
//! layer is approximated by the quadratic polynomial with the means of the pixels around it, and
//! its product with the coverage fraction is integrated. Edges need no evaluation.

use crate::image::Image;
use crate::parallel::prelude::*;
use crate::projection::{Layer, Projection, Region};
use bilby::GaussLegendre;

/// The fewest parts along the longer side of an image with edges.
const LEAST_PIXELS: usize = 512;
/// The most parts along each side of a pixel.
const MOST_PARTS: usize = 16;
/// The numbers of panels of rows, and of rows in each panel, of the quadrature over a part that an
/// edge crosses.
const ROW_PANELS: usize = 4;
const ROW_NODES: usize = 4;
/// The number of places along a row at which regions are compared.
const PROBES: usize = 9;
/// The number of bisections between two places with different regions.
const BISECTIONS: usize = 20;

/// A node of the quadrature over a part: its place relative to the centre in parts, its weight,
/// where the weights add up to 1, and the region there.
#[derive(Clone, Copy, Debug)]
struct Node {
    place: [f64; 2],
    weight: f64,
    region: Region,
}

/// The regions in all parts of the pixels of an image.
#[derive(Debug)]
pub(crate) struct Regions {
    /// Height and width of the image in parts of pixels.
    shape: [usize; 2],
    parts_per_side: usize,
    /// The region of each part that has only one.
    whole: Vec<Option<Region>>,
    /// The parts with several regions, in order, with their quadrature.
    crossed: Vec<(usize, Vec<Node>)>,
}

impl Regions {
    /// The regions of the image of a projection; `None` if it has no edges.
    pub(crate) fn of(projection: &dyn Projection, [height, width]: [usize; 2]) -> Option<Self> {
        if !projection.has_regions() {
            return None;
        }
        let parts_per_side = LEAST_PIXELS.div_ceil(height.max(width)).clamp(1, MOST_PARTS);
        let shape @ [rows, columns] = [height * parts_per_side, width * parts_per_side];
        let whole = whole_parts(projection, shape);
        let crossed: Vec<(usize, Vec<Node>)> = (0..rows * columns)
            .into_par_iter()
            .filter(|&part| whole[part].is_none())
            .map(|part| (part, nodes(projection, shape, part)))
            .collect();
        Some(Self { shape, parts_per_side, whole, crossed })
    }
}

impl Regions {
    /// The number of the pixel that contains a part.
    fn pixel(&self, part: usize) -> usize {
        let ([_, columns], parts) = (self.shape, self.parts_per_side);
        part / columns / parts * (columns / parts) + part % columns / parts
    }

    /// For each pixel, the ratio of the radiance to the mean of the irradiance density, from
    /// `scale`, which contains closed forms. For pixels that are partly outside the image it is
    /// computed anew: mean and solid angle must be sums over the same nodes, since a small relative
    /// error of their area would be a large one of their quotient.
    pub(crate) fn scale(&self, projection: &dyn Projection, scale: &Image) -> Image {
        let [rows, columns] = self.shape;
        let parts = self.parts_per_side;
        let mut is_cut = vec![false; scale.pixels().len()];
        for (part, nodes) in &self.crossed {
            is_cut[self.pixel(*part)] |= nodes.iter().any(|node| node.region == Region::Outside);
        }
        let mut densities = vec![0.0; scale.pixels().len()];
        let mut add = |part: usize, nodes: &[Node]| {
            let (row, column) = (part / columns, part % columns);
            for Node { place: [x, y], weight, region } in nodes {
                let at =
                    |k: usize, place: f64, parts: usize| (k as f64 + 0.5 + place) / parts as f64;
                if *region != Region::Outside {
                    let xy = [at(column, *x, columns), at(row, *y, rows)];
                    densities[self.pixel(part)] += weight * projection.solid_angle_density(xy);
                }
            }
        };
        let in_cut = |part: &usize| is_cut[self.pixel(*part)];
        for (part, region) in self.whole.iter().enumerate().filter(|(part, _)| in_cut(part)) {
            if let Some(region) = region {
                add(part, &square(*region));
            }
        }
        for (part, nodes) in self.crossed.iter().filter(|(part, _)| in_cut(part)) {
            add(*part, nodes);
        }
        let share = 1.0 / (parts * parts) as f64;
        let mut scale = scale.clone();
        let cut =
            scale.pixels_mut().iter_mut().zip(densities).zip(is_cut).filter(|(_, is_cut)| *is_cut);
        for ((scale, density), _) in cut {
            *scale = if density > 0.0 { 1.0 / (share * density) } else { 0.0 };
        }
        scale
    }
}

/// The region of each part without an edge: corners and centre have the same region, and so have
/// all parts around.
fn whole_parts(projection: &dyn Projection, [rows, columns]: [usize; 2]) -> Vec<Option<Region>> {
    let at = |twice: usize, parts: usize| twice as f64 / (2 * parts) as f64;
    let corners: Vec<Region> = (0..(rows + 1) * (columns + 1))
        .into_par_iter()
        .map(|k| {
            let (row, column) = (k / (columns + 1), k % (columns + 1));
            projection.region([at(2 * column, columns), at(2 * row, rows)])
        })
        .collect();
    let alone = |part: usize| {
        let (row, column) = (part / columns, part % columns);
        let first = row * (columns + 1) + column;
        let middle = projection.region([at(2 * column + 1, columns), at(2 * row + 1, rows)]);
        let same = [first, first + 1, first + columns + 1, first + columns + 2]
            .into_iter()
            .all(|corner| corners[corner] == middle);
        same.then_some(middle)
    };
    let mut whole: Vec<Option<Region>> = (0..rows * columns).into_par_iter().map(alone).collect();
    for xy in projection.landmarks() {
        if xy.iter().all(|along| (0.0..=1.0).contains(along)) {
            whole[part_at(xy, [rows, columns])] = None;
        }
    }
    // An edge may extend into a part between its corners.
    let beside = |part: usize| {
        let (row, column) = (part / columns, part % columns);
        let around = |k: usize, parts: usize| k.saturating_sub(1)..(k + 2).min(parts);
        around(row, rows).all(|r| around(column, columns).all(|c| whole[r * columns + c].is_some()))
    };
    let kept: Vec<bool> = (0..rows * columns).into_par_iter().map(beside).collect();
    whole.into_iter().zip(kept).map(|(region, kept)| region.filter(|_| kept)).collect()
}

/// The part that contains (x, y).
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the parts")]
fn part_at(xy: [f64; 2], [rows, columns]: [usize; 2]) -> usize {
    let index = |along: f64, parts: usize| ((along * parts as f64) as usize).min(parts - 1);
    index(xy[1], rows) * columns + index(xy[0], columns)
}

/// Quadrature nodes of a part with edges: Gauss–Legendre rules between the edges along each row. The
/// rows are distributed between the edges in the middle column, since an edge may be parallel to
/// them.
fn nodes(projection: &dyn Projection, [rows, columns]: [usize; 2], part: usize) -> Vec<Node> {
    let (row, column) = (part / columns, part % columns);
    let Ok(rule) = GaussLegendre::new(ROW_NODES) else { return Vec::new() };
    let pairs = || rule.nodes().iter().zip(rule.weights()).map(|(t, w)| (0.5 * t, 0.5 * w));
    let region = |x: f64, y: f64| {
        let at = |place: f64, k: usize, parts: usize| (k as f64 + 0.5 + place) / parts as f64;
        projection.region([at(x, column, columns), at(y, row, rows)])
    };
    let mut nodes = Vec::new();
    for (low, high, _) in pieces(|y| region(0.0, y)) {
        let height = (high - low) / ROW_PANELS as f64;
        for (panel, (t, of_row)) in
            (0..ROW_PANELS).flat_map(|panel| pairs().map(move |p| (panel, p)))
        {
            let y = low + (panel as f64 + 0.5 + t) * height;
            for (from, to, region) in pieces(|x| region(x, y)) {
                for (s, weight) in pairs() {
                    let x = 0.5 * (from + to) + s * (to - from);
                    let weight = weight * (to - from) * of_row * height;
                    nodes.push(Node { place: [x, y], weight, region });
                }
            }
        }
    }
    nodes
}

/// The intervals of a row or a column, from −½ to ½, with one region each.
fn pieces(region: impl Fn(f64) -> Region) -> Vec<(f64, f64, Region)> {
    let probe = |k: usize| k as f64 / (PROBES - 1) as f64 - 0.5;
    let mut pieces = Vec::new();
    let (mut from, mut current) = (-0.5, region(-0.5));
    for k in 1..PROBES {
        let next = region(probe(k));
        if next != current {
            let (mut low, mut high) = (probe(k - 1), probe(k));
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                if region(middle) == current { low = middle } else { high = middle }
            }
            pieces.push((from, high, current));
            (from, current) = (high, next);
        }
    }
    pieces.push((from, 0.5, current));
    pieces
}

/// ∫ fraction · {1, x, y, x², xy, y²} over a part, with x and y relative to its centre in parts.
type Moments = [f64; 6];

/// The coverage fractions of one layer.
#[derive(Debug)]
pub(crate) struct CoverageFractions {
    shape: [usize; 2],
    parts_per_side: usize,
    /// The coverage fraction of each part on which it is constant; 0 where it varies.
    constant: Vec<f64>,
    /// The moments of the parts on which it varies, with their numbers.
    varying: Vec<(usize, Moments)>,
    /// The mean of |coverage fraction| over each pixel.
    pub(crate) reach: Image,
    /// Whether an edge of the layer crosses each pixel.
    pub(crate) is_crossed: Vec<bool>,
}

impl CoverageFractions {
    pub(crate) fn new(layer: &dyn Layer, regions: &Regions) -> Self {
        let &Regions { shape: [rows, columns], parts_per_side, .. } = regions;
        let place = |part: usize, [x, y]: [f64; 2]| {
            let (row, column) = (part / columns, part % columns);
            [(column as f64 + 0.5 + x) / columns as f64, (row as f64 + 0.5 + y) / rows as f64]
        };
        let moments = |part: usize, nodes: &[Node]| {
            let mut moments = [0.0; 6];
            for &Node { place: [x, y], weight, region } in nodes {
                let share = weight * layer.share(place(part, [x, y]), region);
                let terms = [1.0, x, y, x * x, x * y, y * y];
                moments.iter_mut().zip(terms).for_each(|(moment, term)| *moment += share * term);
            }
            moments
        };
        let of_whole = |part: usize| {
            let region = regions.whole[part]?;
            let share = layer.share(place(part, [0.0; 2]), region);
            #[expect(clippy::float_cmp, reason = "shares that are constant are exactly 0 or 1")]
            let is_constant = share == 0.0 || share == 1.0;
            Some(if is_constant {
                (share, None)
            } else {
                (0.0, Some((part, moments(part, &square(region)))))
            })
        };
        let of_whole: Vec<_> = (0..rows * columns).into_par_iter().map(of_whole).collect();
        let constant = of_whole.iter().map(|found| found.map_or(0.0, |(share, _)| share)).collect();
        let mut varying: Vec<(usize, Moments)> =
            of_whole.into_iter().flatten().filter_map(|(_, moments)| moments).collect();
        let crossed =
            regions.crossed.par_iter().map(|(part, nodes)| (*part, moments(*part, nodes)));
        varying.extend(crossed.collect::<Vec<_>>());
        varying.sort_unstable_by_key(|(part, _)| *part);
        let reach = Image::zeros(rows / parts_per_side, columns / parts_per_side);
        let mut is_crossed = vec![false; reach.pixels().len()];
        for (part, nodes) in &regions.crossed {
            let is_visible =
                |node: &Node| layer.share(place(*part, node.place), node.region) != 0.0;
            is_crossed[regions.pixel(*part)] |= nodes.iter().any(is_visible);
        }
        let shape = [rows, columns];
        let mut fractions = Self { shape, parts_per_side, constant, varying, reach, is_crossed };
        fractions.reach =
            fractions.sum(|part| fractions.constant[part], |(_, moments)| moments[0].abs());
        fractions
    }

    /// The shape in parts, whose means are needed.
    pub(crate) fn shape(&self) -> [usize; 2] {
        self.shape
    }

    /// For each pixel the mean of `constant` and `varying` over its parts.
    fn sum(
        &self,
        constant: impl Fn(usize) -> f64 + Sync,
        varying: impl Fn(&(usize, Moments)) -> f64 + Sync,
    ) -> Image {
        let [rows, columns] = self.shape;
        let parts = self.parts_per_side;
        let mut image = Image::zeros(rows / parts, columns / parts);
        let share = 1.0 / (parts * parts) as f64;
        let of_row = |(row, pixels): (usize, &mut [f64])| {
            for row in row * parts..(row + 1) * parts {
                let row = row * columns..(row + 1) * columns;
                for (pixel, first) in pixels.iter_mut().zip(row.step_by(parts)) {
                    for part in first..first + parts {
                        *pixel += share * constant(part);
                    }
                }
            }
            let [from, to] = [row, row + 1]
                .map(|row| self.varying.partition_point(|(part, _)| *part < row * parts * columns));
            for found in &self.varying[from..to] {
                pixels[found.0 % columns / parts] += share * varying(found);
            }
        };
        image.pixels_mut().par_chunks_mut(columns / parts).enumerate().for_each(of_row);
        image
    }

    /// The mean of the layer's function times its coverage fraction over each pixel, from the means
    /// of the function over all parts, and an estimate of its error due to the polynomials.
    pub(crate) fn apply(&self, means: &[f64]) -> [Image; 2] {
        let [rows, columns] = self.shape;
        let polynomial = |part: usize| self.polynomial(means, part / columns, part % columns);
        let product = |coefficients: &[f64], moments: &[f64]| -> f64 {
            coefficients.iter().zip(moments).map(|(c, m)| c * m).sum()
        };
        let image = self.sum(
            |part| self.constant[part] * means[part],
            |(part, moments)| product(&polynomial(*part), moments),
        );
        // The contribution of the next order: the change of the curvature from part to part.
        let change = |part: usize| {
            let own = polynomial(part);
            let (row, column) = (part / columns, part % columns);
            let beside = [
                row.checked_sub(1).map(|r| (r, column)),
                Some((row + 1, column)).filter(|(r, _)| *r < rows),
                column.checked_sub(1).map(|c| (row, c)),
                Some((row, column + 1)).filter(|(_, c)| *c < columns),
            ];
            let others = beside.into_iter().flatten().map(|(r, c)| self.polynomial(means, r, c));
            others.fold([0.0_f64; 3], |largest, other| {
                core::array::from_fn(|k| largest[k].max((other[k + 3] - own[k + 3]).abs()))
            })
        };
        let means_error = self.sum(
            |_| 0.0,
            |(part, moments)| {
                let [xx, xy, yy] = change(*part);
                let around_mean = |square: f64| (square - moments[0] / 12.0).abs();
                xx * around_mean(moments[3]) + xy * moments[4].abs() + yy * around_mean(moments[5])
            },
        );
        [image, means_error]
    }

    /// The quadratic polynomial around the centre of a part with the means of the parts around it,
    /// as coefficients of {1, x, y, x², xy, y²}; linear or constant at the border of the image.
    fn polynomial(&self, means: &[f64], row: usize, column: usize) -> [f64; 6] {
        let [rows, columns] = self.shape;
        let at = |r: usize, c: usize| means[r * columns + c];
        let middle = at(row, column);
        let along = |low: Option<f64>, high: Option<f64>| match (low, high) {
            (Some(low), Some(high)) => (0.5 * (high - low), 0.5 * (high + low) - middle),
            (Some(low), None) => (middle - low, 0.0),
            (None, Some(high)) => (high - middle, 0.0),
            (None, None) => (0.0, 0.0),
        };
        let (left, right) = (column.checked_sub(1), Some(column + 1).filter(|c| *c < columns));
        let (below, above) = (row.checked_sub(1), Some(row + 1).filter(|r| *r < rows));
        let (x, xx) = along(left.map(|c| at(row, c)), right.map(|c| at(row, c)));
        let (y, yy) = along(below.map(|r| at(r, column)), above.map(|r| at(r, column)));
        let xy = match (left, right, below, above) {
            (Some(left), Some(right), Some(below), Some(above)) => {
                0.25 * (at(above, right) + at(below, left) - at(above, left) - at(below, right))
            }
            _ => 0.0,
        };
        // x² and y² have means of 1/12 over the part.
        [middle - (xx + yy) / 12.0, x, y, xx, xy, yy]
    }
}

/// Quadrature nodes of a part with one region.
fn square(region: Region) -> Vec<Node> {
    let Ok(rule) = GaussLegendre::new(3) else { return Vec::new() };
    let pairs = || rule.nodes().iter().zip(rule.weights()).map(|(t, w)| (0.5 * t, 0.5 * w));
    pairs()
        .flat_map(|(x, a)| pairs().map(move |(y, b)| Node { place: [x, y], weight: a * b, region }))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::projection::{DiscMapping, ViewGeometry};
    use crate::{Fisheye, Viewpoint};

    fn disc() -> Fisheye {
        let viewpoint =
            Viewpoint { position: [0.0; 3], target: [0.0, 0.0, 1.0], up: [0.0, 1.0, 0.0] };
        Fisheye::new(viewpoint, 1.0, DiscMapping::EqualArea, [0.0, 1.0]).unwrap()
    }

    #[test]
    fn the_share_of_a_disc_is_its_area() {
        let disc = disc();
        for shape in [[5, 7], [64, 64], [300, 200]] {
            let regions = Regions::of(&disc, shape).unwrap();
            let layers = disc.layers();
            let fractions = CoverageFractions::new(&*layers[0], &regions);
            let pixels = (shape[0] * shape[1]) as f64;
            let area = fractions.reach.pixels().iter().sum::<f64>() / pixels;
            assert!((area - core::f64::consts::FRAC_PI_4).abs() < 3e-6, "{shape:?}: {area}");
            // The middle is in the disc, the corner is not, except for a seventh of the pixel of
            // the small image.
            assert!((fractions.reach[(shape[0] / 2, shape[1] / 2)] - 1.0).abs() < 1e-14);
            assert!(fractions.reach[(0, 0)] < 0.2, "{shape:?}");
        }
    }

    #[test]
    fn quadratics_are_integrated_over_a_disc_as_by_its_moments() {
        // ∫ x² over the disc of radius ½ is π/64, and so is that of (x − ½)²; ∫ x is π/8.
        let disc = disc();
        let regions = Regions::of(&disc, [40, 40]).unwrap();
        let layers = disc.layers();
        let fractions = CoverageFractions::new(&*layers[0], &regions);
        let [rows, columns] = fractions.shape();
        let mean = |k: usize, n: usize| {
            let at = |k: usize| (k as f64 / n as f64 - 0.5).powi(3) / 3.0;
            (at(k + 1) - at(k)) * n as f64
        };
        let means: Vec<f64> = (0..rows * columns)
            .map(|part| mean(part % columns, columns) + 1.0 + (part / columns) as f64 / rows as f64)
            .collect();
        let [image, means_error] = fractions.apply(&means);
        let sum = image.pixels().iter().sum::<f64>() / 1600.0;
        let row_mean = 0.5 - 0.5 / rows as f64;
        let exact = core::f64::consts::PI * (1.0 / 64.0 + (1.0 + row_mean) / 4.0);
        assert!((sum - exact).abs() < 1e-6, "{sum} {exact}");
        // Quadratic functions follow from their means, except at the border of the image.
        let largest = means_error.largest();
        assert!(largest < 1e-8, "{largest}");
    }
}
