//! Lines of sight that verify a sheet: they are no nodes of its tree.

use crate::vol::dyadic::Place;
use crate::vol::image::tree::ImageTree;
use crate::vol::line::node_lines::{NodeLines, Wanted};
use crate::vol::sampling::{Stop, View};
use crate::vol::tuning::TUNING;
/// Places of lines, with the depths that each starts with.
pub(crate) type Lines = Vec<(Place, Vec<u32>)>;

/// Lines of a sheet that are no nodes of its tree.
#[derive(Debug, Default)]
pub(crate) struct Verification {
    /// The places of the lines, without values.
    pub(crate) places: ImageTree,
    pub(crate) node_lines: NodeLines,
    /// The |change| of the integral of each line by the finer depths.
    pub(crate) changes: Vec<f64>,
    /// The number of scattered places that have been used.
    pub(crate) scattered: usize,
}

impl Verification {
    /// Integrates lines first from the depths that nodes would start with, then with the finer
    /// depths added.
    pub(crate) async fn integrate(
        &mut self,
        view: &View<'_>,
        [usual, finer]: [Wanted; 2],
        tolerance: f64,
        depth_level: u8,
    ) -> Result<(), Stop> {
        self.node_lines.refine(view, &self.places, usual, tolerance, depth_level).await?;
        let before: Vec<f64> =
            finer.iter().map(|(i, _)| self.node_lines.lines[*i].integral).collect();
        let numbers: Vec<usize> = finer.iter().map(|(i, _)| *i).collect();
        self.node_lines.refine(view, &self.places, finer, tolerance, depth_level).await?;
        let changes = numbers.into_iter().zip(before);
        self.changes
            .extend(changes.map(|(i, before)| (self.node_lines.lines[i].integral - before).abs()));
        Ok(())
    }

    /// The depths at which the samples of a line are significant.
    pub(crate) fn significant_depths(&self, line: usize, tolerance: f64) -> Vec<u32> {
        let tolerance = self.node_lines.tolerance_of(line, tolerance);
        let samples = self.node_lines.lines[line].samples.iter();
        let significant = samples.filter(|of| {
            of.opened || of.significance > TUNING.verification.shared_significance * tolerance
        });
        significant.map(|sample| sample.depth).collect()
    }
}
