//! A spectral cube from products: G at a few energies, each by products of its own, and every bin as a weighted sum of
//! these.

use crate::cube::Cube;
use crate::energy::EnergyAxis;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::output::MethodOutput;
use crate::tree::StopReason;
use crate::vol::VolOptions;
use crate::vol::dyadic::unit;
use crate::vol::lowrank::attempted::{Attempted, FoundCube, frozen_of};
use crate::vol::lowrank::channel::{Channel, ChannelTarget, CubeView};
use crate::vol::lowrank::rows::PlaneProducts;
use crate::vol::lowrank::spectral_places::{checks, points};
use crate::vol::lowrank::start::{CubeStart, Start};
use crate::vol::sampling::{Stop, View};
use crate::vol::spectrum::bins::Bins;
use crate::vol::spectrum::cube_spectra::CubeSpectra;
use crate::vol::spectrum::energies::Energies;
use crate::vol::tuning::TUNING;
use crate::vol::view::part::Part;
use std::sync::Arc;

/// The evaluations that spectra and their checks may take.
const MOST_OF_SPECTRA: u64 = 8000;

/// Whether products are searched for with these options.
pub(crate) fn is_possible(vol: &VolOptions) -> bool {
    vol.is_uniform() && vol.seeds.is_empty() && vol.sums.is_empty()
}

/// The tolerance of the channel at the first energy.
pub(crate) fn first_tolerance(vol: &VolOptions) -> f64 {
    TUNING.spectra.channel_share * vol.tolerance.min(TUNING.engine.loosest_tolerance)
}

/// The cube of a view whose search for products at the energy `first`, a place of the axis, is complete, and what it
/// leaves for those of other emissions; `None` if products do not give the cube to the tolerance.
pub(crate) async fn attempt_cube(
    view: &CubeView<'_>,
    axis: &EnergyAxis,
    first: u32,
    of_first: Attempted,
) -> Result<Option<FoundCube>, MethodError> {
    let Some(channel) = Channel::of(of_first) else { return Ok(None) };
    let mut search = CubeSearch::new(view, axis, vec![channel]);
    match search.run(first).await {
        Ok(Some(maps)) => Ok(Some(search.found(maps, StopReason::Complete))),
        Ok(None) | Err(Stop::Budget) => Ok(None),
        Err(Stop::Failed(error)) => Err(error),
    }
}

/// The cube by the functions of another emission, with [`StopReason::FixedMesh`] if they do not suffice; `None` if the
/// budget does not.
pub(crate) async fn cube_by_functions(
    view: &CubeView<'_>,
    axis: &EnergyAxis,
    start: &CubeStart,
) -> Result<Option<FoundCube>, MethodError> {
    let mut search = CubeSearch::new(view, axis, Vec::new());
    match search.run_with(start).await {
        Ok(Some((maps, ending))) => Ok(Some(search.found(maps, ending))),
        Ok(None) | Err(Stop::Budget) => Ok(None),
        Err(Stop::Failed(error)) => Err(error),
    }
}

/// The energies of a cube with their products.
struct CubeSearch<'a> {
    view: &'a CubeView<'a>,
    axis: &'a EnergyAxis,
    bins: Bins<'a>,
    tolerance: f64,
    spectra: CubeSpectra<'a>,
    channels: Vec<Channel>,
    /// The error that each channel is allowed, in units of the first one.
    share: f64,
    /// The evaluations of the whole rendering after which the search ends.
    most: u64,
}

impl<'a> CubeSearch<'a> {
    fn new(view: &'a CubeView<'a>, axis: &'a EnergyAxis, channels: Vec<Channel>) -> Self {
        let CubeView { meter, tiles, parts, vol } = *view;
        let of_part = |part: &'a Part<'a>| View {
            meter,
            chart: &*part.chart,
            tiles: tiles.len(),
            energy: None,
        };
        let views = parts.parts.iter().map(of_part).collect();
        let tolerance = vol.tolerance.min(TUNING.engine.loosest_tolerance);
        let bins = Bins::new(axis);
        let mut spectra = CubeSpectra::new(views, bins.clone(), &vol.line_energies, tolerance);
        for first in &channels {
            let points = points(parts, first, 0, TUNING.spectra.first_probes);
            spectra.add_points(points.into_iter());
        }
        let left = meter.evaluations_left() as f64;
        let so_far = meter.evaluations();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 2⁶⁴")]
        let most = (TUNING.lowrank.most_budget_share * left) as u64;
        // Usually a few energies explain all spectra: where many more are needed, trees need fewer evaluations.
        let most = so_far + most.min(TUNING.spectra.most_channels * so_far + MOST_OF_SPECTRA);
        Self { view, axis, bins, tolerance, spectra, channels, share: 1.0, most }
    }

    /// Adds energies until new samples agree with them. Returns values and errors of each bin if they are within the
    /// tolerance.
    async fn run(&mut self, first: u32) -> Result<Option<Vec<[Image; 2]>>, Stop> {
        if !self.spectra.select_first(first).await? {
            return Ok(None);
        }
        for round in 0..TUNING.spectra.cube_rounds {
            let known = self.channels.len();
            if self.is_too_expensive() {
                return Ok(None);
            }
            while let Some(largest) = self.spectra.select_further(self.largest()).await? {
                for number in self.channels.len()..self.spectra.energies.len() {
                    if self.is_too_expensive() || !self.add_channel(number, largest, None).await? {
                        return Ok(None);
                    }
                }
            }
            if round > 0 && self.channels.len() == known {
                // The energies explain the spectra: the products are wrong.
                return Ok(None);
            }
            if self.is_too_expensive() {
                return Ok(None);
            }
            if self.check(round).await? {
                return self.within_tolerance().await;
            }
        }
        Ok(None)
    }

    /// Values and errors of each bin by the functions of another emission; `None` if they are not to be used.
    async fn run_with(
        &mut self,
        start: &CubeStart,
    ) -> Result<Option<(Vec<[Image; 2]>, StopReason)>, Stop> {
        self.spectra.take_energies(start.energies.clone());
        let mut largest = 0.0;
        for (number, functions) in start.functions.iter().enumerate() {
            let functions = Start { functions: functions.clone(), ..Start::default() };
            if !self.add_channel(number, largest, Some(&functions)).await? {
                return Ok(None);
            }
            largest = self.largest();
        }
        let agrees = match self.compare_spectra(largest).await {
            Err(Stop::Budget) => return Ok(Some((self.maps(), StopReason::Budget))),
            agrees => agrees?,
        };
        let maps = self.maps();
        let error = maps.iter().map(|[_, error]| error.largest()).fold(0.0, f64::max);
        let suffices = agrees && error <= self.tolerance * self.largest();
        Ok(Some((maps, if suffices { StopReason::Complete } else { StopReason::FixedMesh })))
    }

    /// Samples spectra of this emission, and compares others with the functions. Returns whether what differs is in the
    /// error that the energies of the start leave.
    async fn compare_spectra(&mut self, largest: f64) -> Result<bool, Stop> {
        self.spectra.residuals(largest).await?;
        if self.check(0).await? {
            return Ok(true);
        }
        self.spectra.residuals(largest).await?;
        // Where the energies explain the new spectra, too, the functions are wrong.
        let left = self.spectra.unexplained.iter().copied().fold(0.0, f64::max);
        Ok(left > TUNING.spectra.energy_share * self.tolerance * largest)
    }

    /// Whether what is left of the budget or of the time is for trees.
    fn is_too_expensive(&self) -> bool {
        let meter = self.view.meter;
        let share = TUNING.lowrank.most_budget_share;
        meter.evaluations() > self.most || meter.share_of_time_left() < 1.0 - share
    }

    /// Whether samples on new lines agree with the products.
    async fn check(&mut self, round: usize) -> Result<bool, Stop> {
        let (parts, base_level) = (self.view.parts, self.view.vol.base_level);
        let checks = checks(parts, &self.channels, &self.spectra.energies, base_level, round);
        let largest = self.largest();
        Ok(self.spectra.check(&checks, largest).await? == 0)
    }

    /// Adds the channel of energy `number`, in a cube with this largest voxel. Returns whether it is found.
    async fn add_channel(
        &mut self,
        number: usize,
        largest: f64,
        start: Option<&Start>,
    ) -> Result<bool, Stop> {
        let Some(channel) = self.channel(number, largest, start).await? else { return Ok(false) };
        let most = match number {
            0 => TUNING.spectra.first_probes,
            _ => TUNING.spectra.later_probes,
        };
        let more = points(self.view.parts, &channel, number, most);
        self.spectra.add_points(more.into_iter());
        self.channels.push(channel);
        Ok(true)
    }

    /// The channel of energy `number`, to its share of the error allowed in the bin that has most of it.
    async fn channel(
        &self,
        number: usize,
        largest: f64,
        start: Option<&Start>,
    ) -> Result<Option<Channel>, Stop> {
        let energies = &self.spectra.energies;
        let nodal = energies.nodal_weights();
        let in_bins = nodal.iter().map(|of_bin| of_bin[number].abs());
        let in_bins = in_bins.fold(f64::MIN_POSITIVE, f64::max);
        let target = ChannelTarget {
            energy: energies.selected[number].place,
            tolerance: self.share * TUNING.spectra.channel_share * self.tolerance,
            least_largest: largest / in_bins,
            is_further: true,
        };
        let found = self.view.attempt(&self.bins, target, start, Vec::new()).await;
        let found = Channel::of(found.map_err(Stop::Failed)?);
        Ok(found.filter(|channel| channel.is_complete || start.is_some()))
    }

    /// Values and errors of each bin, with channels that are searched for again where errors add up to more than the
    /// tolerance; `None` if they do to the end.
    async fn within_tolerance(&mut self) -> Result<Option<Vec<[Image; 2]>>, Stop> {
        for tighter in 0..=TUNING.spectra.tighter_channels {
            let maps = self.maps();
            let error = maps.iter().map(|[_, error]| error.largest()).fold(0.0, f64::max);
            let largest = self.largest();
            let allowed = self.tolerance * largest;
            if error <= allowed {
                return Ok(Some(maps));
            }
            // What the energies leave is the same for all channels.
            let left = self.spectra.unexplained.iter().copied().fold(0.0, f64::max);
            if tighter == TUNING.spectra.tighter_channels
                || left >= allowed
                || self.is_too_expensive()
            {
                break;
            }
            self.share *= TUNING.spectra.tighter_share * (allowed - left) / (error - left);
            for number in 0..self.channels.len() {
                let Some(channel) = self.channel(number, largest, None).await? else {
                    return Ok(None);
                };
                self.channels[number] = channel;
            }
        }
        Ok(None)
    }

    /// The weights of the channels that are known in each bin.
    fn weights(&self) -> Vec<Vec<f64>> {
        let selected = self.spectra.energies.selected.iter().take(self.channels.len());
        Energies { selected: selected.cloned().collect() }.nodal_weights()
    }

    /// The largest voxel.
    fn largest(&self) -> f64 {
        let [height, width] = [self.channels[0].image.height(), self.channels[0].image.width()];
        let of_bin = |weights: &Vec<f64>| {
            let mut image = Image::zeros(height, width);
            let both = self.channels.iter().zip(weights);
            both.for_each(|(channel, weight)| image.add_scaled(&channel.image, *weight));
            image.largest()
        };
        self.weights().iter().map(of_bin).fold(0.0, f64::max)
    }

    /// The values of each bin with their errors.
    fn maps(&self) -> Vec<[Image; 2]> {
        let [height, width] = [self.channels[0].image.height(), self.channels[0].image.width()];
        let nodal = self.weights();
        let of_bin = |(weights, unexplained): (&Vec<f64>, &f64)| {
            let mut image = Image::zeros(height, width);
            let mut error = Image::from_pixels(height, width, vec![*unexplained; height * width]);
            for (channel, weight) in self.channels.iter().zip(weights) {
                image.add_scaled(&channel.image, *weight);
                error.add_scaled(&channel.error, weight.abs());
            }
            [image, error]
        };
        nodal.iter().zip(&self.spectra.unexplained).map(of_bin).collect()
    }

    /// The output of these values and errors.
    fn found(&self, maps: Vec<[Image; 2]>, ending: StopReason) -> FoundCube {
        let CubeView { meter, parts, vol, .. } = *self.view;
        let bands = maps.into_iter().map(|mut maps| {
            for map in &mut maps {
                parts.outside.iter().for_each(|&pixel| map.pixels_mut()[pixel] = f64::NAN);
            }
            maps.into()
        });
        let (images, errors): (Vec<Image>, Vec<Image>) = bands.unzip();
        let [cube, error] = [images, errors].map(Cube::from_bands);
        if meter.keeps_images() {
            meter.show([cube.clone(), error.clone()]);
        }
        let mut output = MethodOutput::new(cube, Some(error), ending);
        output.base_level = Some(vol.base_level);
        output.smallest_feature = self.channels[0].smallest;
        let energies = &self.spectra.energies;
        output.energies =
            energies.selected.iter().map(|one| self.axis.energy(unit(one.place))).collect();
        output.energies.sort_by(f64::total_cmp);
        let products = self.channels.iter().flat_map(|of| &of.checked).cloned();
        let products: Vec<_> = products.collect();
        if !products.is_empty() {
            let unexplained = self.spectra.unexplained.clone();
            // All parts of a channel have its weight.
            let of_parts = |(weight, of): (f64, &Channel)| vec![weight; of.checked.len()];
            let of_band = |of: Vec<f64>| of.into_iter().zip(&self.channels).flat_map(of_parts);
            let weights = self.weights().into_iter().map(|of| of_band(of).collect()).collect();
            output.products = Some(Arc::new(PlaneProducts { products, weights, unexplained }));
        }
        let has_functions = |of: &Channel| of.functions.iter().all(Option::is_some);
        if !(meter.freezes() && self.channels.iter().all(has_functions)) {
            return FoundCube { output, start: None };
        }
        let nodal = energies.nodal_weights();
        let weights = |number: usize| nodal.iter().map(|of_bin| of_bin[number]).collect();
        let groups = self.channels.iter().enumerate();
        let groups: Vec<_> =
            groups.map(|(number, of)| (of.placed.clone(), weights(number))).collect();
        output.frozen = Some(Arc::new(frozen_of(parts, &groups, output.cube.shape())));
        let functions = self.channels.iter().map(|of| of.functions.clone()).collect();
        let start = CubeStart { axis: *self.axis, energies: energies.clone(), functions };
        FoundCube { output, start: Some(Arc::new(start)) }
    }
}
