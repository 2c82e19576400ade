//! The view of G in which products are searched for, and surfaces.

use crate::meter::Meter;
use crate::site::Site;
use crate::vol::lowrank::scaling::Scaling;
use crate::vol::sampling::{EnergySample, Stop, evaluate_across_gaps, terms};
use crate::vol::view::part::Part;

/// The view of G, weighted with the density of solid angle.
pub(crate) struct WeightedView<'a> {
    pub(crate) meter: &'a Meter,
    pub(crate) part: &'a Part<'a>,
    /// The number of tiles of the image.
    pub(crate) tiles: usize,
    /// The energies at which G is sampled, and the weights with which the samples are added; none without
    /// an energy axis.
    pub(crate) energies: &'a [(EnergySample, f64)],
    /// What G is multiplied with, if errors are allowed by pixel.
    pub(crate) scaling: Option<Scaling>,
}

impl<'a> WeightedView<'a> {
    /// Of G as it is, without an energy axis.
    pub(crate) fn new(meter: &'a Meter, part: &'a Part<'a>, tiles: usize) -> Self {
        Self { meter, part, tiles, energies: &[], scaling: None }
    }
}

impl WeightedView<'_> {
    /// The number of evaluations for one point.
    pub(crate) fn evaluations_of_point(&self) -> u64 {
        self.energies.len().max(1) as u64
    }

    /// G · dΩ/(dx dy) at the points, or its weighted sum over the energies, in one batch if the budget
    /// suffices.
    pub(crate) async fn rates(&self, points: &[[f64; 3]]) -> Result<Vec<f64>, Stop> {
        let (chart, energies) = (&*self.part.chart, self.energies);
        if energies.is_empty() {
            let site = |i: usize| self.site(points[i]);
            return evaluate_across_gaps(self.meter, chart, points.len(), &|i| points[i], &site)
                .await;
        }
        let point = |i: usize| points[i / energies.len()];
        let site = |i: usize| self.site_at(point(i), energies[i % energies.len()].0);
        let count = points.len() * energies.len();
        let rates = evaluate_across_gaps(self.meter, chart, count, &point, &site).await?;
        let sum = |of_point: &[f64]| {
            of_point.iter().zip(energies).map(|(rate, (_, weight))| rate * weight).sum()
        };
        Ok(rates.chunks(energies.len()).map(sum).collect())
    }

    /// One sample of G · dΩ/(dx dy).
    pub(super) fn site(&self, u: [f64; 3]) -> Site {
        let chart = &*self.part.chart;
        let mut point = chart.world_from_chart(u);
        point.path_per_depth *= chart.density([u[0], u[1]]);
        if let Some(scaling) = &self.scaling {
            point.path_per_depth *= scaling.at([u[0], u[1]]);
        }
        let (tile, xy) = chart.image_place([u[0], u[1]]);
        Site { xy, point, energy: None, tile: (tile, self.tiles) }
    }

    /// One sample at an energy.
    fn site_at(&self, u: [f64; 3], sample: EnergySample) -> Site {
        let mut site = self.site(u);
        site.point.path_per_depth *= sample.density;
        Site { energy: Some(sample.energy), ..site }
    }

    /// The sites whose weighted values make the value at a point.
    pub(super) fn terms(&self, u: [f64; 3]) -> Vec<(Site, f64)> {
        let chart = &*self.part.chart;
        if self.energies.is_empty() {
            return terms(chart, u, self.site(u));
        }
        let of_energy = |&(sample, weight): &(EnergySample, f64)| {
            let of_sample = terms(chart, u, self.site_at(u, sample)).into_iter();
            of_sample.map(move |(site, of_site)| (site, weight * of_site))
        };
        self.energies.iter().flat_map(of_energy).collect()
    }

    /// The values at several groups of points, in one batch.
    pub(super) async fn rates_of_groups(
        &self,
        groups: &[Vec<[f64; 3]>],
    ) -> Result<Vec<Vec<f64>>, Stop> {
        let mut rates = self.rates(&groups.concat()).await?.into_iter();
        Ok(groups.iter().map(|group| rates.by_ref().take(group.len()).collect()).collect())
    }
}
