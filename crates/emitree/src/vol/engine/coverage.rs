//! Coverage: scattered samples, and the size of the smallest structure that they detect.
//!
//! A compact structure may lie between all lines of a lattice. Each part of a view is therefore sampled at
//! scattered points too, and each sample is compared with a local fit to the lines around it.
//! Ascents from the largest differences find the lines of the final verification; the size of the
//! smallest Gaussian that would be detected follows from the differences that pass.

use crate::cell::whole;
use crate::vol::ascent::{self, Ascents};
use crate::vol::dyadic::Place;
use crate::vol::engine::Engine;
use crate::vol::engine::borders::border_samples;
use crate::vol::lattice;
use crate::vol::sampling::Stop;
use crate::vol::tuning::TUNING;
use crate::vol::view::scattered::{Deviation, PartSamples, ScatteredSheet, steps};
use crate::vol::view::verification::Lines;

/// The scattered samples of all parts of a view.
#[derive(Debug)]
pub(crate) struct Coverage {
    /// The size of the smallest feature that the options name, as a fraction of the view's cube.
    wanted: Option<f64>,
    /// The size of the smallest feature that is covered on parts without a tree.
    of_others: Option<f64>,
    parts: Vec<PartSamples>,
    /// The size of the smallest feature that is covered, once it has been determined.
    pub(crate) smallest: Option<f64>,
}

impl Coverage {
    /// Coverage of features of the size `wanted`, with the samples of parts that are `known`;
    /// features of the size `of_others` are covered on parts without a tree.
    pub(crate) fn new(
        wanted: Option<f64>,
        of_others: Option<f64>,
        known: Vec<PartSamples>,
    ) -> Self {
        Self { wanted, of_others, parts: known, smallest: None }
    }

    /// Whether the requested feature size is covered.
    pub(crate) fn is_sufficient(&self) -> bool {
        match (self.wanted, self.smallest) {
            (Some(wanted), Some(smallest)) => smallest <= wanted,
            _ => true,
        }
    }
}

impl Engine<'_> {
    /// Samples each part at scattered points. Returns for each sheet the lines, with depths, where
    /// the samples differ from the fits; `target` is the error allowed, in the unit of the image.
    pub(crate) async fn verify_samples(&mut self, target: f64) -> Result<Vec<Lines>, Stop> {
        let parts = self.parts.len();
        if parts == 0 {
            // No line of sight is in view.
            return Ok(Vec::new());
        }
        // Those of the first energy.
        let sheets = self.sheets.partition_point(|sheet| sheet.id.energy == 0);
        let of_evaluations =
            TUNING.verification.sample_share * self.meter.kept_evaluations() as f64;
        let in_parts = self.parts.iter().fold(1.0, |least, part| part.least_feature.min(least));
        let of_feature = self.coverage.wanted.map_or(0, |size| {
            lattice::points_to_detect(in_parts * size, TUNING.verification.detection_share)
        });
        let number = TUNING.verification.least_samples.max(whole(of_evaluations)).max(of_feature);
        let mut number = (number / parts).next_power_of_two();
        let at_borders = border_samples(&self.sheets[..sheets]);
        for _ in 0..=TUNING.verification.most_doublings {
            let mut lines = Vec::with_capacity(self.sheets.len());
            let mut smallest = self.coverage.of_others;
            for (sheet, at_border) in at_borders.iter().enumerate() {
                let (of_part, size) = self.verify_part(sheet, at_border, number, target).await?;
                lines.push(of_part);
                if let Some(size) = size {
                    smallest = Some(smallest.map_or(size, |of_others| of_others.max(size)));
                }
            }
            lines.resize_with(self.sheets.len(), Vec::new);
            self.coverage.smallest = smallest;
            if self.coverage.is_sufficient() || lines.iter().any(|of_part| !of_part.is_empty()) {
                return Ok(lines);
            }
            number *= 2;
        }
        Ok(vec![Vec::new(); self.sheets.len()])
    }

    /// The lines to be verified on one part after `number` scattered samples, and beside those of other parts
    /// at its border, and the feature size that the former cover; `None` if no sample is in view.
    async fn verify_part(
        &mut self,
        sheet: usize,
        at_border: &PartSamples,
        number: usize,
        target: f64,
    ) -> Result<(Lines, Option<f64>), Stop> {
        let sheet = &self.sheets[sheet];
        let samples = &mut self.coverage.parts[sheet.id.part];
        sheet.sample_scattered(samples, number).await?;
        if samples.points.is_empty() {
            return Ok((Vec::new(), None));
        }
        let lines = sheet.scan.node_lines.nearest_full(&sheet.scan.tree, sheet.scan.tree.len());
        let verified = ScatteredSheet { sheet, lines, target, number: samples.number };
        let deviations = verified.deviations(&samples.points, &samples.rates);
        let mut order: Vec<usize> = (0..deviations.len()).collect();
        let effect = |i: usize| verified.effect(&deviations[i]);
        order.sort_by(|&a, &b| effect(b).total_cmp(&effect(a)).then(a.cmp(&b)));
        let ascents = ascent::number(samples.points.len());
        let starts: Vec<usize> = order
            .iter()
            .copied()
            .take(ascents)
            .filter(|&i| effect(i) > TUNING.verification.sample_ascent_from)
            .collect();
        // No ascent begins at smaller effects than this one: they pass.
        let passed = order
            .get(ascents)
            .map_or(0.0, |&i| effect(i))
            .max(TUNING.verification.sample_ascent_from);
        let starts = starts.into_iter().map(|i| (samples.points[i], deviations[i])).collect();
        let size = |of: &Deviation| verified.effect(of);
        let mut ascents = Ascents::new(starts, samples.number);
        while let Some(points) = ascents.next() {
            let at: Vec<(Place, u32)> = points.iter().map(steps).collect();
            let rates = sheet.scan.view.rates(&at).await?;
            ascents.update(verified.deviations(&points, &rates), size);
        }
        let found = ascents.best();
        let lines = found
            .iter()
            .filter(|(_, of)| verified.effect(of) > TUNING.verification.sample_line_from);
        let mut lines: Lines = lines.map(|(point, _)| verified.line_through(*point)).collect();
        lines.extend(verified.lines_beside(at_border));
        let size = verified.size_covered(&samples.points, &deviations, passed);
        Ok((lines, Some(size / self.parts[sheet.id.part].least_feature)))
    }
}
