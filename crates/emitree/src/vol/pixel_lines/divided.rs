//! Pixels with lines of their own: those that a limb crosses, and those in which the image is not smooth enough.

use crate::exchange::MethodError;
use crate::parallel::prelude::*;
use crate::vol::pixel_lines::{PixelLines, place_in_cell};
use crate::vol::view::pixel_lattices::{gauss_nodes, lattice_nodes};
use crate::vol::view::pixel_rule::RuleNode;

/// The levels of few lines in a pixel: four of Gauss's rule, and those of Simpson's rule at its corners and in its middle.
const FEW: usize = 2;
/// The lines of later levels: Fibonacci lattices, with lines at as many distances from an edge as there are lines.
const LATTICES: [usize; 5] = [13, 34, 89, 233, 610];
/// Lines suffice if the mean changes by no more than this share of what is allowed, where g jumps or there are limbs: a few
/// lines may agree by chance where an edge crosses the pixel. In other images the change may be all that is allowed.
const CHANGE_AT_EDGES: f64 = 0.25;
/// The steps of these lines are finer so many times: structure of the image between pixels is often narrow in depth, too.
/// Where g jumps, all lines have so many.
const FINER: usize = 3;
/// The error of a mean over a pixel that an edge crosses, in units of the range of its lines over their number: what one
/// of them stands for is on one side of the edge or on the other.
const OF_RANGE: f64 = 0.5;
/// The share of a piece of a line between two steps in the error of a line at an edge.
const OF_PIECE: f64 = 0.5;

/// A pixel with lines of its own.
#[derive(Clone, Copy, Debug)]
pub(super) struct Divided {
    pub(super) pixel: usize,
    pub(super) mean: f64,
    pub(super) error: f64,
    is_settled: bool,
}

impl Divided {
    /// A pixel without lines.
    fn new(pixel: usize) -> Self {
        Self { pixel, mean: f64::INFINITY, error: f64::INFINITY, is_settled: false }
    }
}

impl PixelLines<'_> {
    /// The places of lines in a pixel, from 0 to 1, with their weights, at each level more of them.
    fn nodes(&self, pixel: usize, level: usize) -> Vec<RuleNode> {
        // More nodes would be an edge of the emission that no geometry knows: for that there are lattices.
        let of_limb = u8::try_from(level).ok().filter(|_| level < FEW);
        of_limb.and_then(|level| self.limbs.nodes(pixel, level)).unwrap_or_else(|| match level {
            0 => gauss_nodes().to_vec(),
            1 => {
                let corner = |k: usize| ([k % 2, k / 2].map(|at| at as f64), 0.25);
                (0..4).map(corner).chain([([0.5; 2], 2.0)]).collect()
            }
            _ => lattice_nodes(LATTICES[level - FEW]),
        })
    }

    /// The numbers of the pixels around one, and its own.
    fn around(&self, pixel: usize) -> impl Iterator<Item = usize> + use<> {
        let [height, width] = self.medium.tile.shape;
        let (row, column) = (pixel / width, pixel % width);
        let columns = column.saturating_sub(1)..(column + 2).min(width);
        let rows = row.saturating_sub(1)..(row + 2).min(height);
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
    }

    /// The means of some pixels from lines of their own, until more of them change it by no more than what is
    /// `allowed`, and of pixels beside those in which few lines do not suffice: an edge goes on there. `None` if that takes too
    /// long.
    pub(super) async fn divide(
        &self,
        pixels: &[usize],
        allowed: f64,
    ) -> Result<Option<Vec<Divided>>, MethodError> {
        let [height, width] = self.medium.tile.shape;
        let mut divided: Vec<Divided> = Vec::new();
        let mut is_divided = vec![false; height * width];
        let mut is_open = vec![false; height * width];
        let mut seconds_left = self.most_seconds;
        let mut next = pixels.to_vec();
        while !next.is_empty() {
            next.iter().for_each(|&pixel| is_divided[pixel] = true);
            let first = divided.len();
            divided.extend(next.drain(..).map(Divided::new));
            for level in 0..FEW {
                let of_level = &mut divided[first..];
                if !self.advance(of_level, level, allowed, &mut seconds_left).await? {
                    return Ok(None);
                }
            }
            for of in divided[first..].iter().filter(|of| !of.is_settled) {
                is_open[of.pixel] = true;
                for pixel in self.around(of.pixel) {
                    if !core::mem::replace(&mut is_divided[pixel], true) {
                        next.push(pixel);
                    }
                }
            }
        }
        for of in &mut divided {
            of.is_settled &= !self.around(of.pixel).any(|pixel| is_open[pixel]);
        }
        for level in FEW..FEW + LATTICES.len() {
            if !self.advance(&mut divided, level, allowed, &mut seconds_left).await? {
                return Ok(None);
            }
        }
        Ok(Some(divided))
    }

    /// The means of pixels that are not settled from the lines of a level; whether the time suffices.
    async fn advance(
        &self,
        divided: &mut [Divided],
        level: usize,
        allowed: f64,
        seconds_left: &mut f64,
    ) -> Result<bool, MethodError> {
        let has_jumps = self.steps.has_jumps;
        let finer = if has_jumps { 1 } else { FINER };
        let of_change = if has_jumps || self.limbs.cross_pixels() { CHANGE_AT_EDGES } else { 1.0 };
        let open: Vec<usize> = (0..divided.len()).filter(|&of| !divided[of].is_settled).collect();
        // Before there is a place for each of them.
        let least = open.len() * level.checked_sub(FEW).map_or(4, |of| LATTICES[of]);
        let evaluations = least * finer * self.steps.number;
        if self.seconds_of(least, finer) > *seconds_left || !self.medium.affords(evaluations) {
            return Ok(false);
        }
        let nodes_of = |&of: &usize| {
            let pixel = divided[of].pixel;
            let density = |at: [f64; 2]| self.medium.tile.projection.solid_angle_density(at);
            let place = |at| place_in_cell(self.medium.tile.shape, pixel, at);
            let nodes = self.nodes(pixel, level).into_iter();
            let nodes = nodes.map(|(at, weight)| (place(at), weight * density(place(at))));
            nodes.collect()
        };
        let nodes: Vec<Vec<RuleNode>> = open.par_iter().map(nodes_of).collect();
        let lines: Vec<RuleNode> = nodes.iter().flatten().copied().collect();
        *seconds_left -= self.seconds_of(lines.len(), finer);
        if *seconds_left < 0.0 {
            return Ok(false);
        }
        let place = |line: usize| lines[line].0;
        let found = self.steps.radiances(self.medium, &place, lines.len(), finer).await?;
        let Some(found) = found else { return Ok(false) };
        let mut of_lines = found.iter().zip(&lines);
        for (of, nodes) in open.into_iter().zip(&nodes) {
            let [mut mean, mut error, mut whole] = [0.0; 3];
            let mut range = [f64::INFINITY, f64::NEG_INFINITY];
            for (line, (_, weight)) in of_lines.by_ref().take(nodes.len()) {
                range = [range[0].min(line.radiance), range[1].max(line.radiance)];
                mean += weight * line.radiance;
                error += weight * line.error;
                whole += weight;
            }
            // Some projections have no image in parts of the square.
            if whole.is_nan() || whole <= 0.0 {
                return Ok(false);
            }
            let [mean, of_lines] = [mean, error].map(|sum| sum / whole);
            let change = (mean - divided[of].mean).abs();
            let pixel = divided[of].pixel;
            let number = nodes.len() as f64;
            let [mut of_edge, mut missed] = [0.0; 2];
            if level >= FEW {
                of_edge = OF_RANGE * (range[1] - range[0]) / number;
                // Lines at an edge may miss a piece that lies between two steps; not all of them do.
                missed = OF_PIECE * self.steps.missed / finer as f64 / number.sqrt();
            }
            let is_settled = change <= of_change * allowed && of_edge <= allowed;
            let error = change.max(of_edge) + of_lines + missed;
            divided[of] = Divided { pixel, mean, error, is_settled };
        }
        Ok(true)
    }
}
