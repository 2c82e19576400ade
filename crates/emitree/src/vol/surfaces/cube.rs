//! A spectral cube beside surfaces: they are found at one energy, and what few further energies add is represented
//! by polynomials in the same regions.

use crate::found_surfaces::FoundSurfaces;
use crate::image::Image;
use crate::vol::dyadic::unit;
use crate::vol::lowrank::WeightedView;
use crate::vol::sampling::{Stop, View};
use crate::vol::spectrum::bins::Bins;
use crate::vol::spectrum::cube_spectra::CubeSpectra;
use crate::vol::spectrum::probes::SpotCheck;
use crate::vol::surfaces::attempt::{Located, locate};
use crate::vol::surfaces::channel::{Channel, ChannelRequest};
use crate::vol::surfaces::found::found_surfaces;
use crate::vol::surfaces::search::Failure;
use crate::vol::surfaces::spectra::RegionPoint;
use crate::vol::surfaces::start::Request;
use crate::vol::tuning::TUNING;

/// A cube of surfaces.
pub(crate) struct FoundCube {
    /// Values and errors of each bin.
    pub(crate) maps: Vec<[Image; 2]>,
    /// The places of the selected energies.
    pub(crate) energies: Vec<u32>,
    /// The number of scattered samples at the first of them.
    pub(crate) samples: usize,
    pub(crate) surfaces: FoundSurfaces,
}

/// Searches for surfaces at the energy `first`, at which the request has its view, and for the spectra beside them.
/// Returns the cube if it is within the tolerance. `lines` are energies at which every spectrum is sampled.
pub(crate) async fn attempt_cube(
    request: &Request<'_>,
    bins: Bins<'_>,
    first: u32,
    lines: &[f64],
) -> Result<Option<FoundCube>, Stop> {
    match find(request, bins, first, lines).await {
        Ok(found) => Ok(found),
        Err(failure) => failure.given_up().map(|()| None),
    }
}

async fn find(
    request: &Request<'_>,
    bins: Bins<'_>,
    first: u32,
    lines: &[f64],
) -> Result<Option<FoundCube>, Failure> {
    let meter = request.view.meter;
    let before = meter.evaluations();
    let tolerance = TUNING.surfaces.cube_share * request.tolerance;
    let mut rates = Vec::new();
    let of_first = Request { tolerance, ..Request { ..*request } };
    let Some(located) = locate(&of_first, &mut rates).await? else { return Ok(None) };
    let spent = (meter.evaluations() - before) as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 2⁶⁴")]
    let left = (TUNING.surfaces.channel_evaluations * spent) as u64;
    let mut surfaces =
        found_surfaces(&*request.view.part.chart, &located.model, &located.search.aim);
    let density = bins.density(unit(first));
    surfaces.jumps.iter_mut().for_each(|jump| *jump /= density);
    let mut cube = CubeSearch::new(request, &located, bins, lines, left);
    let Some(maps) = cube.run(first).await? else { return Ok(None) };
    let energies = cube.spectra.energies.selected.iter().map(|one| one.place).collect();
    Ok(Some(FoundCube { energies, samples: rates.len(), surfaces, maps }))
}

/// The energies of a cube with what each adds beside the surfaces.
struct CubeSearch<'a> {
    request: &'a Request<'a>,
    located: &'a Located<'a>,
    spectra: CubeSpectra<'a>,
    /// Where spectra are sampled.
    points: Vec<RegionPoint>,
    /// What each energy adds.
    channels: Vec<Channel>,
    /// The evaluations that may be made for those from the second one on.
    left: u64,
}

impl<'a> CubeSearch<'a> {
    fn new(
        request: &'a Request<'a>,
        located: &'a Located<'a>,
        bins: Bins<'a>,
        lines: &[f64],
        left: u64,
    ) -> Self {
        let WeightedView { meter, part, tiles, .. } = *request.view;
        let views = vec![View { meter, chart: &*part.chart, tiles, energy: None }];
        let points = located.spectral_points();
        let mut spectra = CubeSpectra::new(views, bins, lines, request.tolerance);
        spectra.add_points(points.iter().map(|of| (of.point, of.path)));
        // The pieces of the search are those of the first energy.
        let (model, maps) = (located.model.clone(), located.maps.clone());
        let channels = vec![Channel { model, maps }];
        Self { request, located, spectra, points, channels, left }
    }

    /// Adds energies from that of the surfaces on, until new samples agree with them. Returns values and errors of each
    /// bin if they are within the tolerance.
    async fn run(&mut self, first: u32) -> Result<Option<Vec<[Image; 2]>>, Failure> {
        if !self.spectra.select_first(first).await? {
            return Ok(None);
        }
        for round in 0..TUNING.spectra.cube_rounds {
            let known = self.channels.len();
            while let Some(largest) = self.spectra.select_further(self.largest()).await? {
                for number in self.channels.len()..self.spectra.energies.len() {
                    self.add_channel(number, largest).await?;
                }
            }
            if round > 0 && self.channels.len() == known {
                // The energies explain the spectra: the pieces are wrong.
                return Ok(None);
            }
            if self.check(round).await? {
                let maps = self.maps();
                let error = maps.iter().map(|[_, error]| error.largest()).fold(0.0, f64::max);
                let allowed = TUNING.surfaces.cube_accepted_share * self.request.tolerance;
                return Ok((error <= allowed * self.largest()).then_some(maps));
            }
        }
        Ok(None)
    }

    /// Adds the channel of energy `number`, not the first one, in a cube with this largest voxel.
    async fn add_channel(&mut self, number: usize, largest: f64) -> Result<(), Failure> {
        let CubeSpectra { energies, probes, .. } = &self.spectra;
        let selected = &energies.selected;
        let places = selected.iter().map(|one| one.place);
        let terms: Vec<(u32, f64)> = places.zip(energies.weights_of_part(number)).collect();
        let sample = |&(place, weight): &(u32, f64)| (probes.bins.sample_at(place), weight);
        let samples: Vec<_> = terms.iter().map(sample).collect();
        let view = WeightedView { energies: &samples, ..*self.request.view };
        let known = self.located.known_samples(&self.points, probes, &terms);
        let in_bins = selected[number].weights.iter().map(|weight| weight.abs());
        let in_bins = in_bins.fold(f64::MIN_POSITIVE, f64::max);
        // Each further energy adds less than those before: its share of the error halves, three times.
        let share = [1.0, 0.5, 0.25, 0.125][number.min(3)] * TUNING.surfaces.channel_share;
        let tolerance = self.request.tolerance;
        let target = share * tolerance * largest / in_bins;
        let request = ChannelRequest { view: &view, target, tolerance, known: &known };
        let (search, model) = (&self.located.search, &self.located.model);
        self.channels.push(search.channel(model, &request, &mut self.left).await?);
        Ok(())
    }

    /// Compares new samples, at energies in all parts of the band, with the channels. Those that differ become
    /// spectral probes. Returns whether there are none.
    async fn check(&mut self, round: usize) -> Result<bool, Failure> {
        let expected = |of: &RegionPoint, energy: u32| {
            let parts = self.channels.iter().map(|channel| channel.model.value(of.at));
            self.spectra.energies.sum_of_parts(parts, energy)
        };
        let both = self.located.checks(round, expected);
        let checks: Vec<SpotCheck> = both.iter().map(|(_, check)| *check).collect();
        let (known, largest) = (self.spectra.probes.probes.len(), self.largest());
        let found = self.spectra.check(&checks, largest).await?;
        for probe in &self.spectra.probes.probes[known..] {
            self.points.extend(both.iter().map(|(of, _)| of).find(|of| of.point == probe.point));
        }
        Ok(found == 0)
    }

    /// The largest voxel.
    fn largest(&self) -> f64 {
        self.maps().iter().map(|[image, _]| image.largest()).fold(0.0, f64::max)
    }

    /// The values of each bin with their errors.
    fn maps(&self) -> Vec<[Image; 2]> {
        let [height, width] = [self.located.maps.image.height(), self.located.maps.image.width()];
        let of_bin = |(bin, unexplained): (usize, &f64)| {
            let mut image = Image::zeros(height, width);
            let mut error = Image::from_pixels(height, width, vec![*unexplained; height * width]);
            for (channel, one) in self.channels.iter().zip(&self.spectra.energies.selected) {
                image.add_scaled(&channel.maps.image, one.weights[bin]);
                error.add_scaled(&channel.maps.error, one.weights[bin].abs());
            }
            [image, error]
        };
        self.spectra.unexplained.iter().enumerate().map(of_bin).collect()
    }
}
