//! Lines of sight anywhere in the image, integrated one by one.

use crate::parallel::prelude::*;
use crate::site::Site;
use crate::vol::dyadic::{STEPS, spacing, unit};
use crate::vol::line::Line;
use crate::vol::sampling::{Stop, evaluate};
use crate::vol::sums::View;
use crate::vol::tuning::TUNING;

/// A line of sight.
#[derive(Clone, Copy, Debug)]
pub(super) struct LineOfSight {
    /// The number of its tile.
    pub(super) tile: usize,
    /// Canonical x and y.
    pub(super) xy: [f64; 2],
    pub(super) energy: Option<f64>,
    /// The factor of its integral.
    pub(super) scale: f64,
}

impl LineOfSight {
    fn site(&self, view: View<'_>, depth: u32) -> Site {
        let [x, y] = self.xy;
        let mut point = view.tiles[self.tile].projection.world_from_canonical([x, y, unit(depth)]);
        point.path_per_depth *= self.scale;
        Site { xy: self.xy, point, energy: self.energy, tile: (self.tile, view.tiles.len()) }
    }
}

/// The integral of each line times its scale, with its |error|, each to `tolerance`.
pub(super) async fn integrals(
    view: View<'_>,
    of: &[LineOfSight],
    tolerance: f64,
) -> Result<Vec<[f64; 2]>, Stop> {
    let level = TUNING.sums.depth_level;
    let step = spacing(level);
    let mut lines = vec![Line::default(); of.len()];
    let depths = || (0..=STEPS / step).map(|k| k * step);
    let mut wanted: Vec<(usize, u32)> =
        (0..of.len()).flat_map(|line| depths().map(move |depth| (line, depth))).collect();
    while !wanted.is_empty() {
        let site = |k: usize| of[wanted[k].0].site(view, wanted[k].1);
        let rates = evaluate(view.meter, wanted.len(), &site).await?;
        for of_line in wanted.iter().zip(rates).collect::<Vec<_>>().chunk_by(|a, b| a.0.0 == b.0.0)
        {
            let samples = of_line.iter().map(|((_, depth), rate)| (*depth, *rate));
            lines[of_line[0].0.0].add(samples);
        }
        let mut sampled: Vec<usize> = wanted.iter().map(|(line, _)| *line).collect();
        sampled.dedup();
        let mut is_sampled = vec![false; lines.len()];
        sampled.iter().for_each(|&line| is_sampled[line] = true);
        let assess = |(number, line): (usize, &mut Line)| {
            let depths =
                if is_sampled[number] { line.assess(tolerance, level) } else { Vec::new() };
            depths.into_iter().map(|depth| (number, depth)).collect::<Vec<_>>()
        };
        let of_lines: Vec<Vec<(usize, u32)>> =
            lines.par_iter_mut().enumerate().map(assess).collect();
        wanted = of_lines.concat();
    }
    Ok(lines.iter().map(|line| [line.integral, line.error]).collect())
}
