//! Lines whose depths are those of another emission: their integrals with given weights, and their errors.

use crate::parallel::prelude::*;
use crate::vol::line::node_lines::{LINES_ASSESSED, LineSource, NodeLines};

impl NodeLines {
    /// The integrals of all lines by the weights of a fixed mesh or of their rules; without a fixed mesh those
    /// of full lines follow from their samples.
    pub(crate) fn integrate_all(&mut self) {
        let weighted: Vec<Option<f64>> = (0..self.lines.len())
            .into_par_iter()
            .with_min_len(LINES_ASSESSED)
            .map(|i| self.weighted_integral(i))
            .collect();
        for (line, weighted) in self.lines.iter_mut().zip(weighted) {
            match weighted {
                Some(integral) => line.integral = integral,
                None => line.integrate(),
            }
        }
    }

    fn weighted_integral(&self, i: usize) -> Option<f64> {
        let is_given = !self.fixed.is_empty() || self.sources[i] != LineSource::Full;
        let line = &self.lines[i];
        let term = |(depth, weight): (u32, f64)| weight * line.rate(depth);
        is_given.then(|| self.weights(i).into_iter().map(term).sum())
    }

    /// Assesses all full lines. Those of a fixed mesh keep their integrals, whose differences from the new
    /// ones are errors too.
    pub(crate) fn assess_all(&mut self, tolerance: f64, base_level: u8) {
        let full: Vec<usize> = (0..self.lines.len()).filter(|&i| self.is_full(i)).collect();
        let before: Vec<f64> = full.iter().map(|&i| self.lines[i].integral).collect();
        self.assess(full.iter().copied(), tolerance, base_level);
        if self.fixed.is_empty() {
            return;
        }
        for (i, integral) in full.into_iter().zip(before) {
            let line = &mut self.lines[i];
            line.error += (line.integral - integral).abs();
            line.integral = integral;
        }
    }
}
