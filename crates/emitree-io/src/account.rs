//! What was rendered and what it cost, as plain data: for reports, for the headers of files, and for
//! results that are kept without their scene.

use crate::data_error;
use crate::energies::Energies;
use crate::exposure::Exposure;
use crate::fits::{Card, Wcs};
use crate::memory::peak_memory_bytes;
use crate::product::scene_history;
use crate::scene::{CameraDescription, Scene, SceneError, SceneSum, SkyView, cameras, read_sky};
use crate::sky::{Pointing, Sky};
use crate::units::Unit;
use emitree::result::{RenderStats, RenderedTree};
use emitree::sums::RegionSum;
use emitree::{Cube, EnergyAxis, EnergyScale, Image, Method, Rendering, StopReason};
use serde::{Deserialize, Serialize};
use std::error::Error;

/// What was rendered and what it cost. It needs neither the emission nor any file afterwards, and can be
/// serialised.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Account {
    /// The name of the scene.
    pub scene: String,
    /// The text of the scene, without what was changed.
    pub text: String,
    /// What was changed, as `key = value`.
    pub overrides: Vec<String>,
    /// The version of this program.
    pub version: String,
    /// The name of the method.
    pub method: String,
    /// The tolerance, relative to the largest |value|, if the method has one.
    pub tolerance: Option<f64>,
    /// The error allowed in each pixel from the pixel itself, if it is given so.
    #[serde(default)]
    pub by_pixel: Option<ByPixel>,
    /// Whether the errors of pixels have weights.
    #[serde(default)]
    pub is_weighted: bool,
    /// Whether each band has a tolerance of its own.
    #[serde(default)]
    pub per_band: bool,
    /// Sums over regions, with their errors.
    #[serde(default)]
    pub sums: Vec<SumAccount>,
    /// Options that were given and that the method does not have.
    pub ignored: Vec<String>,
    /// The name of the quantity: `radiance` or `irradiance`.
    pub quantity: String,
    /// The unit of the values, in the grammar of FITS, or empty.
    pub unit: String,
    /// The unit of the image of the whole energy band.
    pub band_unit: String,
    /// What a sum of voxels times the widths of their bins is multiplied with for that unit.
    band_factor: f64,
    /// The unit of the emission rate, or empty.
    #[serde(default)]
    pub rate_unit: String,
    /// The unit of length of the scene.
    pub length_unit: Option<String>,
    /// Whether the pixels are those of `HEALPix`.
    pub is_sky: bool,
    /// The coordinates of the pixels about the pointing of the camera, if they have some.
    pub wcs: Option<Wcs>,
    /// The name of the camera.
    #[serde(default)]
    pub camera: String,
    /// Where the camera is and how it looks.
    #[serde(default)]
    pub pointing: Option<Pointing>,
    /// Where on the sky the image is, if the scene says so.
    #[serde(default)]
    pub sky: Option<Sky>,
    /// The energy bins, if there are some.
    pub bins: Option<Bins>,
    /// When the image was exposed, if the scene says so.
    #[serde(default)]
    pub exposed: Option<Exposed>,
    /// The exposure of the instrument \[s\], if there is one.
    pub exposure_s: Option<f64>,
    /// The seed of its counts.
    pub seed: Option<u64>,
    /// Where the largest rate was evaluated, in the scene's unit of length.
    #[serde(default)]
    pub largest_rate_position: Option<[f64; 3]>,
    /// Evaluations of the emission rate.
    pub evaluations: u64,
    /// Evaluations of the absorption coefficient; none if the medium does not absorb.
    #[serde(default)]
    pub absorption_evaluations: Option<u64>,
    /// In how many batches.
    pub batches: u64,
    /// Of linear data on a Cartesian grid: the error of their interpolation over the largest |value|.
    #[serde(default)]
    pub data_error: Option<f64>,
    /// Why the rendering ended: `complete`, `deepest level`, `budget`, `time` or `unfinished`.
    pub ending: String,
    /// The largest estimated error over the largest |value|, if there is an estimate.
    pub estimated_error: Option<f64>,
    /// The largest estimated error of a value over the error allowed there, if the method has such.
    #[serde(default)]
    pub error_over_allowed: Option<f64>,
    /// How many energies were evaluated, if the method selects some.
    pub energies: Option<usize>,
    /// The threshold of a tree, in the unit of g.
    pub threshold: Option<f64>,
    /// The order of its prediction.
    pub order: Option<usize>,
    /// How many leaves it has on each level.
    pub leaves_per_level: Vec<usize>,
    /// The base level that was used.
    pub base_level: Option<u8>,
    /// The standard deviation of the smallest Gaussian that would have been detected, as a fraction of
    /// the view's cube.
    pub smallest_feature: Option<f64>,
    /// The uniform steps of lines of sight on a lattice of pixels, if the image is made of such lines.
    #[serde(default)]
    pub line_steps: Option<usize>,
    /// The time that it took \[s\].
    pub total_seconds: f64,
    /// The part of it that was spent in the emission \[s\].
    pub emission_seconds: f64,
    /// The most memory that the process had taken, if the system tells.
    pub peak_memory_bytes: Option<u64>,
}

/// The error allowed in each pixel: `atol` + `rtol` · max(|pixel|, `floor` · largest |pixel|).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ByPixel {
    /// The error relative to the pixel.
    pub rtol: f64,
    /// The error in the unit of the image.
    pub atol: f64,
    /// The brightness below which `rtol` is relative to it, as a fraction of the largest pixel.
    pub floor: f64,
}

/// A sum over a region, with its error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SumAccount {
    /// The name.
    pub name: String,
    /// What was asked: `sum`, `mean` or `flux`.
    pub of: String,
    /// The sum; of a cube over all bands, with their widths.
    pub value: f64,
    /// The estimated |error| of the value.
    pub error: f64,
    /// The error that was allowed.
    pub allowed: f64,
    /// The error that was allowed relative to the value.
    pub tolerance: f64,
    /// The unit of value and errors, in the grammar of FITS, or empty.
    pub unit: String,
    /// How many points or lines of sight the error is estimated from; 0 if it is the sum of those of the pixels.
    pub samples: usize,
    /// Of a cube: the value and the |error| of each band, in `band_unit`.
    pub bands: Vec<[f64; 2]>,
    /// The unit of these, or empty.
    pub band_unit: String,
}

/// The sums of a rendering in the units of its scene.
fn sums(scene: &Scene, found: &Rendering<Cube>) -> Vec<SumAccount> {
    let factor = if scene.axis().is_some() { scene.band_factor() } else { 1.0 };
    let sum = |(asked, found): (&SceneSum, &RegionSum)| SumAccount {
        name: asked.name.clone(),
        of: asked.of.to_owned(),
        value: factor * found.value,
        error: factor * found.error,
        allowed: factor * found.allowed,
        tolerance: asked.tolerance,
        unit: asked.unit.clone(),
        samples: found.samples,
        bands: found.bands.clone(),
        band_unit: asked.band_unit.clone(),
    };
    scene.render.sums.iter().zip(&found.sums).map(sum).collect()
}

/// Bins of the energy, or of the time if their unit is the second, as scenes and reports have them: [`Energies`]
/// as plain data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Bins {
    /// The lowest energy, or the first time.
    pub min: f64,
    /// The highest energy, or the last time.
    pub max: f64,
    /// The unit of both.
    pub unit: String,
    /// The number of bins.
    pub bins: usize,
    /// `linear` or `log`.
    pub scale: String,
}

/// When an image was exposed: an [`Exposure`] as plain data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Exposed {
    /// The start \[s\].
    pub start: f64,
    /// The end \[s\].
    pub stop: f64,
    /// The number of bins, each the mean over its times.
    pub bins: usize,
    /// Whether the observer moves.
    pub observer_moves: bool,
    /// Whether the time that light travels counts.
    pub light_travel_time: bool,
}

impl From<&Exposure> for Exposed {
    fn from(exposure: &Exposure) -> Self {
        let [start, stop] = exposure.range_s();
        Self {
            start,
            stop,
            bins: exposure.times().axis().bins(),
            observer_moves: exposure.motion().is_some(),
            light_travel_time: exposure.light_travels(),
        }
    }
}

impl Exposed {
    /// The keywords of FITS (standard 4.0, section 9.6).
    fn cards(&self) -> Vec<Card> {
        let always = [
            Card::new("TSTART", self.start, "start of the exposure"),
            Card::new("TSTOP", self.stop, "end of the exposure"),
            Card::new("TIMEUNIT", "s", "unit of TSTART and TSTOP"),
        ];
        let moves = Card::new("OBSMOVES", true, "the camera moves; coordinates are in its frame");
        let light = Card::new("LIGHTTIM", true, "light takes time to the observer");
        let others = [(self.observer_moves, moves), (self.light_travel_time, light)];
        let others = others.into_iter().filter_map(|(is_so, card)| is_so.then_some(card));
        always.into_iter().chain(others).collect()
    }
}

impl From<&Energies> for Bins {
    fn from(energies: &Energies) -> Self {
        let axis = energies.axis();
        Self {
            min: axis.min(),
            max: axis.max(),
            unit: energies.unit_name().to_owned(),
            bins: axis.bins(),
            scale: energies.scale_name().to_owned(),
        }
    }
}

impl Bins {
    /// The energies, or the times.
    ///
    /// # Errors
    ///
    /// If the data, which may have been read from anywhere, are not those of an energy axis.
    pub fn energies(&self) -> Result<Energies, Box<dyn Error + Send + Sync>> {
        if self.unit == "s" {
            let axis = EnergyAxis::new(self.min, self.max, self.bins, EnergyScale::Linear)?;
            return Ok(Energies::times(axis));
        }
        let scale = if self.scale == "log" { EnergyScale::Log } else { EnergyScale::Linear };
        let axis = EnergyAxis::new(self.min, self.max, self.bins, scale)?;
        Ok(Energies::new(axis, &self.unit)?)
    }
}

impl Account {
    /// The account of a rendering whose estimated error, in the quantity of the scene, is
    /// `estimated_error`.
    pub(crate) fn new(
        scene: &Scene,
        found: &Rendering<Cube>,
        estimated_error: Option<f64>,
    ) -> Self {
        let (tree, sums) = (found.tree.as_ref(), sums(scene, found));
        Self { sums, ..Self::of(scene, &found.stats, tree, estimated_error) }
    }

    /// The account of a rendering with this cost and this tree, and without sums.
    pub(crate) fn of(
        scene: &Scene,
        stats: &RenderStats,
        tree: Option<&RenderedTree>,
        estimated_error: Option<f64>,
    ) -> Self {
        let settings = &scene.render;
        let instrument = scene.instrument.as_ref();
        let vol = match &settings.method {
            Method::Vol(vol) => Some(vol),
            _ => None,
        };
        Self {
            scene: scene.name.clone(),
            text: scene.text.clone(),
            overrides: scene.overrides.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            method: settings.method.name().to_owned(),
            tolerance: settings.tolerance,
            by_pixel: vol.and_then(|vol| vol.by_pixel).map(|of| ByPixel {
                rtol: of.rtol,
                atol: of.atol,
                floor: of.floor,
            }),
            is_weighted: vol.is_some_and(|vol| vol.weights.is_some()),
            per_band: vol.is_some_and(|vol| vol.per_band),
            sums: Vec::new(),
            ignored: settings.ignored.iter().map(|&key| key.to_owned()).collect(),
            quantity: scene.quantity.name().to_owned(),
            unit: scene.image_unit().to_owned(),
            band_unit: scene.band_unit().to_owned(),
            band_factor: scene.band_factor(),
            rate_unit: scene.emission.rate_unit.clone(),
            length_unit: scene.length_unit.clone(),
            is_sky: scene.camera.description().is_sky(),
            wcs: scene.wcs(),
            camera: scene.camera.description().name.to_owned(),
            pointing: scene.camera.pointing().copied(),
            sky: scene.sky.clone(),
            bins: scene.energy.as_ref().map(Bins::from),
            exposed: scene.exposure.as_ref().map(Exposed::from),
            exposure_s: instrument.map(|found| found.instrument.exposure_s),
            seed: instrument.map(|found| found.seed),
            largest_rate_position: stats
                .largest_rate
                .map(|of| of.position)
                .filter(|_| scene.emission.events.is_none()),
            evaluations: stats.evaluations,
            absorption_evaluations: scene
                .emission
                .absorption
                .as_ref()
                .map(|_| stats.absorption_evaluations),
            batches: stats.batches,
            data_error: data_error::for_account(scene),
            ending: ending(stats.ending).to_owned(),
            estimated_error,
            error_over_allowed: stats.error_over_allowed,
            energies: Some(stats.energies.len()).filter(|&energies| energies > 0),
            threshold: tree.map(|built| built.threshold),
            order: match &settings.method {
                Method::Paper(options) => Some(options.order),
                _ => None,
            },
            leaves_per_level: tree.map_or_else(Vec::new, |built| built.tree.leaves_per_level()),
            base_level: stats.base_level,
            smallest_feature: stats.smallest_feature,
            line_steps: stats.line_steps,
            total_seconds: stats.total_time.as_secs_f64(),
            emission_seconds: stats.emission_time.as_secs_f64(),
            peak_memory_bytes: peak_memory_bytes(),
        }
    }

    /// The account of several components together, which took some `evaluations`: of errors the largest, of
    /// endings the first that is not complete, of costs the sum; the sums over regions have the names of their
    /// components before their own.
    pub(crate) fn of_components(components: &[(&str, &Self)], evaluations: u64) -> Option<Self> {
        let (_, first) = components.first()?;
        let each = || components.iter().map(|(_, account)| *account);
        let largest = |of: &dyn Fn(&Self) -> Option<f64>| {
            each().map(of).collect::<Option<Vec<f64>>>()?.into_iter().reduce(f64::max)
        };
        let sums = components.iter().flat_map(|(name, account)| {
            let named = move |sum: &SumAccount| SumAccount {
                name: format!("{name}.{}", sum.name),
                ..sum.clone()
            };
            account.sums.iter().map(named)
        });
        let unfinished = each().find(|account| !account.converged());
        Some(Self {
            sums: sums.collect(),
            evaluations,
            absorption_evaluations: each().map(|of| of.absorption_evaluations).sum(),
            batches: each().map(|of| of.batches).sum(),
            ending: unfinished.unwrap_or(first).ending.clone(),
            estimated_error: largest(&|of| of.estimated_error),
            error_over_allowed: largest(&|of| of.error_over_allowed),
            energies: each().map(|of| of.energies).max()?,
            smallest_feature: largest(&|of| of.smallest_feature),
            total_seconds: each().map(|of| of.total_seconds).sum(),
            emission_seconds: each().map(|of| of.emission_seconds).sum(),
            peak_memory_bytes: each().map(|of| of.peak_memory_bytes).max()?,
            largest_rate_position: None,
            threshold: None,
            leaves_per_level: Vec::new(),
            ..(*first).clone()
        })
    }

    /// Whether the stopping criterion was met.
    pub fn converged(&self) -> bool {
        self.ending == ending(StopReason::Complete)
    }

    /// The scene with what was changed in it, a line for each change.
    pub fn history(&self) -> String {
        scene_history(&self.text, &self.overrides)
    }

    /// The sky of the text of a table `[sky]`, for an image that was rendered without one.
    ///
    /// # Errors
    ///
    /// As [`Scene::parse`].
    pub fn read_sky(&self, text: &str) -> Result<Sky, SceneError> {
        let kind = cameras().iter().find(|kind| kind.name == self.camera);
        let view = SkyView {
            camera: &self.camera,
            is_celestial: kind.is_some_and(CameraDescription::is_celestial),
            is_healpix: self.is_sky,
            pointing: self.pointing,
            length_unit: self.length_unit.as_deref(),
        };
        read_sky(text, &view)
    }

    /// The image of the whole energy band of a cube, in [`band_unit`](Self::band_unit).
    pub(crate) fn band_image(&self, bands: &Cube, axis: &EnergyAxis) -> Image {
        let mut band = bands.sum_over_energy(axis);
        band.pixels_mut().iter_mut().for_each(|pixel| *pixel *= self.band_factor);
        band
    }

    /// What the values are, for people: the quantity, or the column density that the integral of a
    /// density is.
    pub fn meaning(&self) -> &str {
        let unit = Unit::parse(&self.unit);
        let is_column = unit.and_then(|unit| unit.factor_to(&Unit::parse("m-2")?)).is_ok();
        if is_column { "column density" } else { &self.quantity }
    }

    /// How the image came about, as FITS keywords.
    pub fn cards(&self) -> Vec<Card> {
        let value = if self.bins.is_some() { "voxel" } else { "pixel" };
        let always = [
            Card::new("SCENE", self.scene.as_str(), "the scene, in full under HISTORY"),
            Card::new("METHOD", self.method.as_str(), "from the emission to the image"),
            Card::new("NEVAL", self.evaluations, "evaluations of the emission rate"),
            Card::new("CONVERGD", self.converged(), "the method ended by itself"),
        ];
        let absorption = self
            .absorption_evaluations
            .map(|n| Card::new("NABSORB", n, "evaluations of the absorption coefficient"));
        let energies = self.energies.map(|n| match &self.exposed {
            None => Card::new("NENERGY", n, "energies that were evaluated"),
            Some(_) => Card::new("NTIME", n, "times that were evaluated"),
        });
        let exposed = self.exposed.iter().flat_map(Exposed::cards);
        let tolerance = self.tolerance.map(|tolerance| {
            Card::new("TOLERANC", tolerance, format!("tolerance / largest {value}"))
        });
        let error = self.estimated_error.map(|error| {
            Card::new("ESTERROR", error, format!("estimated error / largest {value}"))
        });
        let threshold = self
            .threshold
            .map(|threshold| Card::new("THRESHLD", threshold, "details below it were dropped"));
        let order = self.order.map(|order| Card::new("ORDER", order, "order of the prediction"));
        let base_level = self.base_level.map(|level| {
            Card::new("BASELEVL", i32::from(level), "2^this base intervals along each axis")
        });
        let length_unit = self.length_unit.as_deref();
        let length_unit =
            length_unit.map(|unit| Card::new("LENUNIT", unit, "unit of length of the scene"));
        let by_pixel = self.by_pixel.map(|of| {
            let floor = (of.rtol > 0.0)
                .then(|| Card::new("FLOOR", of.floor, format!("of RTOL / largest {value}")));
            let rtol = (of.rtol > 0.0)
                .then(|| Card::new("RTOL", of.rtol, format!("error allowed / {value}")));
            let atol = (of.atol > 0.0)
                .then(|| Card::new("ATOL", of.atol, format!("error allowed in every {value}")));
            [rtol, floor, atol]
        });
        let weighted = self.is_weighted.then(|| {
            Card::new("WEIGHTED", true, format!("the error allowed depends on the {value}"))
        });
        let per_band = self.per_band.then(|| Card::new("PERBAND", true, "each band to its own"));
        let share = self.error_over_allowed.filter(|_| by_pixel.is_some() || self.is_weighted);
        let share =
            share.map(|share| Card::new("ERRSHARE", share, "largest error / error allowed"));
        let by_pixel = by_pixel.into_iter().flatten().flatten();
        let sums = self.sums.iter().zip(1..).flat_map(|(sum, number)| {
            let of = format!("{} of a region", sum.of);
            [
                Card::new(format!("SUM{number}"), sum.name.as_str(), of),
                Card::new(
                    format!("SUMVAL{number}"),
                    sum.value,
                    format!("its value [{}]", sum.unit),
                ),
                Card::new(format!("SUMERR{number}"), sum.error, "its estimated error"),
            ]
        });
        let known =
            [absorption, energies, tolerance, error, threshold, order, base_level, length_unit];
        let known = known.into_iter().flatten().chain(by_pixel);
        let known = known.chain([weighted, per_band, share].into_iter().flatten());
        always.into_iter().chain(exposed).chain(known).chain(sums).collect()
    }

    /// The same of counts, with their exposure and, if they were drawn, their seed.
    pub fn cards_of_counts(&self, seed: Option<u64>) -> Vec<Card> {
        let exposure = self.exposure_s;
        let exposure = exposure.map(|time| Card::new("EXPOSURE", time, "[s] of the counts"));
        let seed = seed.map(|seed| Card::new("SEED", seed, "of the counts that were drawn"));
        self.cards().into_iter().chain(exposure).chain(seed).collect()
    }
}

impl Account {
    /// Whether the rendering ended at the finest level of method `vol`, where the emission may be singular.
    pub(crate) fn ended_at_finest_level(&self) -> bool {
        self.method == VOL && self.ending == ending(StopReason::MaxLevel)
    }
}

/// The method that has coordinates about singularities.
const VOL: &str = "vol";

/// The names of endings in reports.
fn ending(ending: StopReason) -> &'static str {
    match ending {
        StopReason::Complete => "complete",
        StopReason::MaxLevel => "deepest level",
        StopReason::Time => "time",
        StopReason::FixedMesh => "fixed mesh",
        StopReason::Unfinished => "unfinished",
        _ => "budget",
    }
}

#[cfg(test)]
mod tests {
    use crate::{RenderedScene, Scene};

    #[test]
    fn integrals_of_densities_are_column_densities() {
        let meaning = |unit: &str| {
            let text = format!(
                "emission = {{ expression = \"1\", unit = \"{unit}\" }}\nimage = {{ width = 1, \
                 height = 1 }}\nprojection = {{ type = \"perspective\", position = [0, 0, 0], \
                 target = [1, 0, 0], field_of_view = [1, 1], far = 1, length_unit = \"km\" }}"
            );
            let scene = Scene::parse("scene.toml", &text, &[]).unwrap();
            let found = scene.render(&scene.emission, &scene.render_options()).unwrap();
            RenderedScene::new(&scene, &found).account.meaning().to_owned()
        };
        assert_eq!(meaning("cm-3"), "column density");
        assert_eq!(meaning("W m-3 sr-1"), "radiance");
        assert_eq!(meaning("m-1"), "radiance");
    }
}
