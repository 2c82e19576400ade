//! A rendering in the quantity of its scene, with its account: what every front end has and writes.

use crate::account::{Account, Bins};
use crate::advice::{advice, of_data};
use crate::energies::Energies;
use crate::fits::{Card, FitsEncodeError};
use crate::grouped::grouped;
use crate::product::{Bands, FitsProduct, Product, ProductMap};
use crate::report::{CountsReport, Report};
use crate::scene::Scene;
use crate::sky::Sky;
use emitree::result::{EvaluationCounts, FoundSurfaces};
use emitree::{Cube, Image, Rendering};
use std::error::Error;
use std::sync::{Arc, OnceLock};

/// A rendering in the quantity and the units of its scene. It needs neither the emission nor any file
/// afterwards.
///
/// ```
/// use emitree_io::{RenderedScene, Scene};
///
/// let text = r#"
///     emission.expression = "exp(-x)"
///     projection.type = "canonical"
///     image = { width = 8, height = 8 }
/// "#;
/// let scene = Scene::parse("example", text, &[])?;
/// let found = scene.render(&scene.emission, &scene.render_options())?;
/// let rendered = RenderedScene::new(&scene, &found);
/// assert!(rendered.account.converged());
/// let names: Vec<&str> = rendered.companions().iter().map(|map| map.name).collect();
/// assert_eq!(names, ["ERROR", "EVALUATIONS"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RenderedScene {
    /// What was rendered and what it cost.
    pub account: Account,
    /// The values: one band of an image, or those of a cube.
    pub values: Cube,
    /// The estimated |error| of each value, if the method has one.
    pub error: Option<Cube>,
    /// Evaluations on the lines of sight of each pixel.
    evaluations: EvaluationMap,
    /// The image of the whole energy band, one band, if there are energies.
    pub band: Option<Cube>,
    /// The energy bins, if there are some.
    pub energies: Option<Energies>,
    /// The surfaces at which the emission rate jumps, if the image is made of found surfaces. Jumps are in
    /// [`Account::rate_unit`], lengths in [`Account::length_unit`].
    pub surfaces: Option<Arc<FoundSurfaces>>,
}

/// Evaluations on the lines of sight of each pixel: few pixels of a large image have some, so that the map
/// of all pixels is made when it is asked for.
#[derive(Clone, Debug)]
struct EvaluationMap {
    counts: Option<EvaluationCounts>,
    map: OnceLock<Cube>,
}

impl EvaluationMap {
    fn map(&self) -> &Cube {
        let made =
            || of_one(self.counts.as_ref().map_or_else(no_pixels, EvaluationCounts::to_image));
        self.map.get_or_init(made)
    }
}

/// The unit of counts, in the grammar of FITS.
const COUNT: &str = "count";

impl RenderedScene {
    /// The rendering of a scene as [`Scene::render`] returns it.
    pub fn new(scene: &Scene, found: &Rendering<Cube>) -> Self {
        let values = scene.cube_in_quantity(&found.values);
        let error = found.error.as_ref().map(|error| scene.cube_in_quantity(error));
        let estimated = error.as_ref().map(|error| match error.largest() {
            largest if largest > 0.0 => largest / values.largest(),
            _ => 0.0,
        });
        let account = Account::new(scene, found, estimated);
        let counts = Some(found.stats.evaluations_per_pixel.clone());
        let evaluations = EvaluationMap { counts, map: OnceLock::new() };
        let surfaces = found.surfaces.as_deref().cloned().map(|mut surfaces| {
            surfaces.jumps.iter_mut().for_each(|jump| *jump /= scene.emission.rate_factor);
            Arc::new(surfaces)
        });
        let rendered = Self::of(account, values, error, evaluations, scene.energy.clone());
        Self { surfaces, ..rendered }
    }

    /// A rendering that was stored in its parts, without surfaces.
    ///
    /// # Errors
    ///
    /// If the bins in the account, which may have been read from anywhere, are not those of the values.
    pub fn from_parts(
        account: Account,
        values: Cube,
        error: Option<Cube>,
        evaluations_per_pixel: Cube,
    ) -> Result<Self, Box<dyn Error + Send + Sync>> {
        let energies = account.bins.as_ref().map(Bins::energies).transpose()?;
        let bins = energies.as_ref().map_or(1, |energies| energies.axis().bins());
        let bands = values.bands().len();
        if bands != bins {
            return Err(format!("a rendering of {bands} bands: expected {bins}").into());
        }
        let evaluations = EvaluationMap { counts: None, map: evaluations_per_pixel.into() };
        Ok(Self::of(account, values, error, evaluations, energies))
    }

    fn of(
        account: Account,
        values: Cube,
        error: Option<Cube>,
        evaluations: EvaluationMap,
        energies: Option<Energies>,
    ) -> Self {
        let band = energies.as_ref().map(|found| account.band_image(&values, found.axis()));
        let band = band.map(of_one);
        Self { account, values, error, evaluations, band, energies, surfaces: None }
    }

    /// Evaluations on the lines of sight of each pixel, one band; made when it is asked for first.
    pub fn evaluations_per_pixel(&self) -> &Cube {
        self.evaluations.map()
    }

    /// The image of the whole energy band, or the image itself.
    pub fn flat(&self) -> Option<&Image> {
        self.band.as_ref().unwrap_or(&self.values).bands().first()
    }

    /// The unit of [`flat`](Self::flat), or empty.
    pub fn flat_unit(&self) -> &str {
        let Account { band_unit, unit, .. } = &self.account;
        if self.band.is_some() { band_unit } else { unit }
    }

    /// What the bands of the values are.
    pub fn bands(&self) -> Bands<'static> {
        if self.account.bins.is_some() { Bands::Energies } else { Bands::Image }
    }

    /// The values as files have them.
    pub fn values_map(&self) -> ProductMap<'_> {
        let (unit, bands) = (self.account.unit.as_str(), self.bands());
        ProductMap { name: self.name(), map: &self.values, unit, bands }
    }

    /// The maps that go with the values in files: the error, the evaluations and, of a cube, the whole
    /// band.
    pub fn companions(&self) -> Vec<ProductMap<'_>> {
        let band = self.band.as_ref().map(|band| self.of_band("BAND", band));
        self.error_map().into_iter().chain([self.evaluations_map()]).chain(band).collect()
    }

    /// The image or the cube, with the maps that go with it, as a product of its scene.
    pub fn product<'a>(&'a self, scene: &'a Scene) -> Product<'a> {
        Product {
            meaning: self.account.meaning(),
            others: self.companions(),
            provenance: self.account.cards(),
            ..Product::new(scene, self.values_map())
        }
    }

    /// The estimated error as files have it, if there is one.
    pub fn error_map(&self) -> Option<ProductMap<'_>> {
        let (name, unit, bands) = ("ERROR", self.account.unit.as_str(), self.bands());
        Some(ProductMap { name, map: self.error.as_ref()?, unit, bands })
    }

    /// The image of the whole energy band as files have it; none without energies.
    pub fn band_map(&self) -> Option<ProductMap<'_>> {
        Some(self.of_band(self.name(), self.band.as_ref()?))
    }

    /// The maps that go with that image: `error`, which is [`band_error`](Self::band_error), and the
    /// evaluations.
    pub fn companions_of_band<'a>(&'a self, error: Option<&'a Cube>) -> Vec<ProductMap<'a>> {
        let error = error.map(|error| self.of_band("ERROR", error));
        error.into_iter().chain([self.evaluations_map()]).collect()
    }

    /// A bound for the error of the image of the whole energy band, one band.
    pub fn band_error(&self) -> Option<Cube> {
        let (error, energies) = self.error.as_ref().zip(self.energies.as_ref())?;
        Some(of_one(self.account.band_image(error, energies.axis())))
    }

    /// Counts as files have them, with their cards: expected ones, or with a seed those that were drawn.
    pub fn counts_map<'a>(
        &self,
        map: &'a Cube,
        bands: Bands<'a>,
        seed: Option<u64>,
    ) -> (ProductMap<'a>, Vec<Card>) {
        let name = if seed.is_some() { "COUNTS" } else { "EXPECTED" };
        (ProductMap { name, map, unit: COUNT, bands }, self.account.cards_of_counts(seed))
    }

    /// The report, with the counts of an instrument if they were made.
    pub fn report(&self, counts: Option<CountsReport>) -> Report<'_> {
        let ([_, height, width], (min, max)) = (self.values.shape(), self.values.min_max());
        Report::new(&self.account, [height, width], [min, max], counts, self.hint())
    }

    /// The bytes of a FITS file with a map, those that go with it, and cards.
    ///
    /// # Errors
    ///
    /// [`FitsEncodeError`]: what FITS can't hold.
    pub fn fits(
        &self,
        map: ProductMap<'_>,
        others: Vec<ProductMap<'_>>,
        provenance: Vec<Card>,
    ) -> Result<Vec<u8>, FitsEncodeError> {
        self.fits_on_sky(map, others, provenance, self.account.sky.as_ref())
    }

    /// The same with the coordinates of another sky than that of the scene, or with those about the pointing.
    ///
    /// # Errors
    ///
    /// As [`fits`](Self::fits).
    pub fn fits_on_sky(
        &self,
        map: ProductMap<'_>,
        others: Vec<ProductMap<'_>>,
        provenance: Vec<Card>,
        sky: Option<&Sky>,
    ) -> Result<Vec<u8>, FitsEncodeError> {
        let account = &self.account;
        let energies = self.energies.as_ref().filter(|_| map.has_energies());
        let wcs = account.wcs.clone().map(|wcs| match (sky, &account.pointing) {
            (Some(sky), Some(pointing)) => wcs.on_sky(sky, pointing),
            _ => wcs,
        });
        let file = FitsProduct {
            maps: [map].into_iter().chain(others).collect(),
            is_sky: account.is_sky,
            wcs,
            coordinates: sky.and_then(Sky::healpix_system),
            energies,
            provenance,
            history: account.history(),
        };
        file.encode()
    }

    /// The likely reason why every value is 0, or why the tolerance is not met, and what to do next; or that linear
    /// interpolation of data has an error above the tolerance; otherwise none.
    pub fn hint(&self) -> Option<String> {
        let is_dark = self.values.voxels().all(|value| value.is_nan() || value == 0.0);
        let position = self.account.largest_rate_position;
        if is_dark && position.is_none() {
            return Some(nothing_in_view(self.account.evaluations));
        }
        match position {
            Some(position) if self.account.ended_at_finest_level() => {
                Some(may_be_singular(position))
            }
            _ => advice(&self.account).or_else(|| of_data(&self.account)),
        }
    }

    /// The name of the values among the parts of a file.
    fn name(&self) -> &'static str {
        if self.account.quantity == "irradiance" { "IRRADIANCE" } else { "RADIANCE" }
    }

    fn evaluations_map(&self) -> ProductMap<'_> {
        let (map, bands) = (self.evaluations_per_pixel(), Bands::Image);
        ProductMap { name: "EVALUATIONS", map, unit: "", bands }
    }

    fn of_band<'a>(&'a self, name: &'a str, map: &'a Cube) -> ProductMap<'a> {
        ProductMap { name, map, unit: &self.account.band_unit, bands: Bands::Image }
    }
}

/// An image as a cube of one band.
fn of_one(image: Image) -> Cube {
    Cube::from_bands(vec![image])
}

fn no_pixels() -> Image {
    Image::zeros(0, 0)
}

fn may_be_singular([x, y, z]: [f64; 3]) -> String {
    format!(
        "the emission rate is largest at [{x:.6}, {y:.6}, {z:.6}]: if it is singular near there, or has a peak \
         far smaller than a pixel, add [[singularity]] with type = \"point\" (or \"axis\") and its exact \
         position; surfaces at which it jumps are [[edge]]"
    )
}

pub(crate) fn nothing_in_view(evaluations: u64) -> String {
    if evaluations == 0 {
        return "nothing is in view: no line of sight meets the bounds, or opaque bodies hide them \
                (check position, target, near, far and [bounds])"
            .to_owned();
    }
    let count = grouped(evaluations);
    format!(
        "nothing is in view: the emission rate is 0 at all {count} points evaluated (check position, \
         target, near, far and length_unit; a small source is found with [[seed]])"
    )
}

#[cfg(test)]
mod tests {
    use super::nothing_in_view;

    #[test]
    fn reasons_differ_for_bounds_and_rates() {
        assert!(nothing_in_view(0).contains("no line of sight meets the bounds"));
        assert!(nothing_in_view(1_530).contains("0 at all 1,530 points evaluated"));
    }
}
