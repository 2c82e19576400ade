//! The image of a part by functions of another G.
//!
//! G is evaluated at the pivots alone. Probes show where the residual is large, but not that it changes its
//! sign along a line of sight, as it does where other functions than those of G are used: their root mean
//! square is some ten times the error. Some lines at the largest residuals, and some scattered ones, are
//! therefore integrated in full, and the errors of all pixels are scaled with what these show.

use crate::tree::StopReason;
use crate::vol::lattice;
use crate::vol::lowrank::Attempt;
use crate::vol::lowrank::chebyshev::{Analysis, all_places};
use crate::vol::lowrank::maps::Maps;
use crate::vol::lowrank::probes::CellResiduals;
use crate::vol::lowrank::search::{Assessment, Search, along};
use crate::vol::lowrank::start::Functions;
use crate::vol::sampling::Stop;
use crate::vol::tuning::TUNING;
use crate::vol::view::scattered::size_detected;

/// The axis along lines of sight.
const DEPTH: usize = 2;

impl Attempt<'_> {
    /// The image by these functions, with [`StopReason::FixedMesh`] if they do not suffice.
    pub(super) async fn by_functions(
        &mut self,
        Functions(functions): &Functions,
    ) -> Result<(Maps, StopReason), Stop> {
        self.search.restart(functions.for_another());
        self.search.fill().await?;
        let fewer = if self.wanted.is_some() { 1 } else { TUNING.lowrank.fewer_probes };
        let probes = self.probes_needed() / fewer;
        // With a small budget the error is that of fewer samples, and of no lines.
        while self.search.probes() < probes
            && affordable(self.search.probe(probes).await)?.is_some()
        {}
        self.weigh();
        let mut assessment = self.search.assess();
        let (mut maps, mut allowed) = self.maps_and_allowed(&assessment);
        let most = TUNING.lowrank.lines_most_excess * allowed;
        if maps.largest_error > allowed && maps.largest_error <= most {
            let share = affordable(self.search.share_along_lines(&assessment).await)?;
            assessment = assessment.scaled(share.unwrap_or(1.0));
            (maps, allowed) = self.maps_and_allowed(&assessment);
        }
        self.keep_error(&assessment);
        let of_rate = self.effect_of_rate(maps.largest.max(self.largest_of_others));
        let passes = of_rate * self.search.last_followed();
        let passes = passes.max(TUNING.lowrank.least_detected_rate);
        let size = size_detected(self.search.probes(), passes);
        self.smallest = Some(size / self.part.least_feature);
        self.show_maps(&maps);
        let suffices = maps.largest_error <= allowed;
        Ok((maps, if suffices { StopReason::Complete } else { StopReason::FixedMesh }))
    }

    /// The maps, and the largest error that is allowed in them.
    fn maps_and_allowed(&mut self, assessment: &Assessment) -> (Maps, f64) {
        let mut maps = self.maps(assessment);
        self.find_pixel_share(&mut maps);
        let of_image = maps.largest.max(self.largest_of_others);
        let of_image = self.largest_weighed.unwrap_or(of_image);
        (maps, self.accepted_share() * self.tolerance() * of_image)
    }
}

/// What the budget sufficed for.
fn affordable<T>(result: Result<T, Stop>) -> Result<Option<T>, Stop> {
    match result {
        Ok(found) => Ok(Some(found)),
        Err(Stop::Budget) => Ok(None),
        Err(failed) => Err(failed),
    }
}

impl Search<'_> {
    /// The error along lines of sight, as a share of the error that probes show there; at most 1.
    async fn share_along_lines(&self, assessment: &Assessment) -> Result<f64, Stop> {
        let places = self.places_of_lines();
        // The residual has no finer structure than the fibers, and what every second place leaves out is in
        // the tail.
        let level = self.interpolant.axes[DEPTH].level - 1;
        let depths = all_places(level);
        let lines = places.iter().map(|&place| along(DEPTH, place, &depths));
        let lines: Vec<Vec<[f64; 3]>> = lines.collect();
        let rates = self.view.rates_of_groups(&lines).await?;
        let analysis = Analysis::new(level);
        let share = |number: usize| {
            let (place, values) = (places[number], self.interpolant.values(&lines[number]));
            let residual = rates[number].iter().zip(values).map(|(rate, value)| rate - value);
            let [error, of_tail] = analysis.integral(&residual.collect::<Vec<_>>());
            let found = self.weight([place[0], place[1], 0.0]) * (error.abs() + of_tail);
            let expected = assessment.cell_residuals.error_at(place);
            if found > 0.0 { found / expected } else { 0.0 }
        };
        let shares = (0..places.len()).map(share);
        Ok((TUNING.lowrank.lines_margin * shares.fold(0.0, f64::max)).min(1.0))
    }

    /// The places of the image plane at which lines are integrated: those of the largest residuals of
    /// different cells, and as many scattered ones.
    fn places_of_lines(&self) -> Vec<[f64; 2]> {
        let half = TUNING.lowrank.lines_of_functions / 2;
        let mut places: Vec<[f64; 2]> = Vec::new();
        let mut cells: Vec<[usize; 2]> = Vec::new();
        for ([u, v, _], residual) in self.residuals() {
            let cell = CellResiduals::cell([u, v]);
            if places.len() < half && residual > 0.0 && !cells.contains(&cell) {
                places.push([u, v]);
                cells.push(cell);
            }
        }
        let scattered = (0..).map(lattice::point).filter(|point| self.is_in_view(*point));
        // A part in view has a probe, so that there are such points.
        if !places.is_empty() {
            places.extend(scattered.take(half).map(|[u, v, _]| [u, v]));
        }
        places
    }
}
