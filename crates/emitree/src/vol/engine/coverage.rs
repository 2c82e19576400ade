//! Coverage: scattered samples, and the size of the smallest structure that they detect.
//!
//! A compact structure may lie between all lines of a lattice. Each layer is therefore sampled at
//! scattered points too, and each sample is compared with a local fit to the lines around it.
//! Ascents from the largest differences find the lines of the final verification; the size of the
//! smallest Gaussian that would be detected follows from the differences that pass.

use crate::cell::whole;
use crate::vol::ascent::{self, Ascents};
use crate::vol::dyadic::Place;
use crate::vol::engine::Engine;
use crate::vol::lattice;
use crate::vol::sampling::Stop;
use crate::vol::tuning::TUNING;
use crate::vol::view::scattered::{Deviation, LayerSamples, ScatteredSheet, steps};
use crate::vol::view::verification::Lines;

/// The scattered samples of all layers of a view.
#[derive(Debug)]
pub(crate) struct Coverage {
    /// The size of the smallest feature that the options name, as a fraction of the view's cube.
    wanted: Option<f64>,
    layers: Vec<LayerSamples>,
    /// The size of the smallest feature that is covered, once it has been determined.
    pub(crate) smallest: Option<f64>,
}

impl Coverage {
    /// Coverage of features of the size `wanted`, with the samples of the first layer that are
    /// `known`.
    pub(crate) fn new(wanted: Option<f64>, known: LayerSamples) -> Self {
        Self { wanted, layers: vec![known], smallest: None }
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
    /// Samples each layer at scattered points. Returns for each sheet the lines, with depths, where
    /// the samples differ from the fits; `target` is the error allowed, in the unit of the image.
    pub(crate) async fn verify_samples(&mut self, target: f64) -> Result<Vec<Lines>, Stop> {
        let layers = self.layers.len();
        self.coverage.layers.resize_with(layers, LayerSamples::default);
        let of_evaluations = TUNING.verification.sample_share * self.meter.evaluations() as f64;
        let of_feature = self
            .coverage
            .wanted
            .map_or(0, |size| lattice::points_to_detect(size, TUNING.verification.detection_share));
        let number = TUNING.verification.least_samples.max(whole(of_evaluations)).max(of_feature);
        let mut number = (number / self.tiles.len()).next_power_of_two();
        for _ in 0..=TUNING.verification.most_doublings {
            let mut lines = Vec::with_capacity(self.sheets.len());
            let mut smallest: Option<f64> = None;
            for layer in 0..layers {
                let (of_layer, size) = self.verify_layer(layer, number, target).await?;
                lines.push(of_layer);
                if let Some(size) = size {
                    smallest = Some(smallest.map_or(size, |of_others| of_others.max(size)));
                }
            }
            lines.resize_with(self.sheets.len(), Vec::new);
            self.coverage.smallest = smallest;
            if self.coverage.is_sufficient() || lines.iter().any(|of_layer| !of_layer.is_empty()) {
                return Ok(lines);
            }
            number *= 2;
        }
        Ok(vec![Vec::new(); self.sheets.len()])
    }

    /// The lines to be verified on one layer after `number` scattered samples, and the feature size
    /// that these cover; `None` if no sample is in view.
    async fn verify_layer(
        &mut self,
        layer: usize,
        number: usize,
        target: f64,
    ) -> Result<(Lines, Option<f64>), Stop> {
        let sheet = &self.sheets[layer];
        let samples = &mut self.coverage.layers[layer];
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
        let is_open = |at: &[f64; 3]| sheet.is_open(at);
        let size = |of: &Deviation| verified.effect(of);
        let mut ascents = Ascents::new(starts, samples.number);
        while let Some(points) = ascents.next(is_open) {
            let at: Vec<(Place, u32)> = points.iter().map(steps).collect();
            let rates = sheet.scan.view.rates(&at).await?;
            ascents.update(verified.deviations(&points, &rates), size);
        }
        let found = ascents.best();
        let lines = found
            .iter()
            .filter(|(_, of)| verified.effect(of) > TUNING.verification.sample_line_from);
        let lines = lines.map(|(point, _)| verified.line_through(*point)).collect();
        let size = verified.size_covered(&samples.points, &deviations, passed);
        Ok((lines, Some(size)))
    }
}
