//! The renderings of several components of one scene, as one result with one file of each format.

use crate::account::Account;
use crate::fits::{Card, FitsEncodeError};
use crate::format::EncodeError;
use crate::npy::encode_npy;
use crate::product::ProductMap;
use crate::rendered::RenderedScene;
use crate::report::{ComponentsReport, Report};
use emitree::{Cube, Healpix};

/// The renderings of the components of a scene, of one camera and one number of pixels.
///
/// ```
/// use emitree_io::{RenderedComponents, RenderedScene, Scene};
///
/// let text = r#"
///     emission.expressions = ["exp(-x)", "y*exp(-x)"]
///     emission.components = ["total", "polarised"]
///     projection.type = "canonical"
///     image = { width = 8, height = 8 }
/// "#;
/// let scene = Scene::parse("example", text, &[])?;
/// let components = scene.components().unwrap();
/// let mut rendered = Vec::new();
/// for (name, of) in components.names().iter().zip(components.scenes()) {
///     let found = of.render(&of.emission, &of.render_options())?;
///     rendered.push((name.clone(), RenderedScene::new(of, &found)));
/// }
/// let all = RenderedComponents::new(rendered, components.evaluations()).unwrap();
/// assert!(all.account().converged());
/// assert_eq!(all.account().evaluations, components.evaluations());
/// let fits = all.fits()?; // the HDUs TOTAL, POLARISED, TOTAL_ERROR, POLARISED_ERROR and so on
/// assert!(fits.starts_with(b"SIMPLE"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct RenderedComponents {
    components: Vec<(String, RenderedScene)>,
    account: Account,
    /// The bands of all components, one component after the other.
    values: Cube,
}

/// A map of one component, and the name of its HDU or column.
type NamedMap<'a> = (String, ProductMap<'a>);

impl RenderedComponents {
    /// Components by their names, for which the emission was evaluated at this number of points; none of no
    /// components, or of different numbers of pixels or bins.
    pub fn new(components: Vec<(String, RenderedScene)>, evaluations: u64) -> Option<Self> {
        let shape = components.first()?.1.values.shape();
        if components.iter().any(|(_, rendered)| rendered.values.shape() != shape) {
            return None;
        }
        let accounts: Vec<(&str, &Account)> =
            components.iter().map(|(name, of)| (name.as_str(), &of.account)).collect();
        let account = Account::of_components(&accounts, evaluations)?;
        let bands = components.iter().flat_map(|(_, of)| of.values.bands().iter().cloned());
        let values = Cube::from_bands(bands.collect());
        Some(Self { components, account, values })
    }

    /// The rendering of each component with its name. Its evaluations are those that it would take alone.
    pub fn components(&self) -> impl Iterator<Item = (&str, &RenderedScene)> {
        self.components.iter().map(|(name, rendered)| (name.as_str(), rendered))
    }

    /// The account of all components together: the largest errors, and the evaluations of all.
    pub fn account(&self) -> &Account {
        &self.account
    }

    /// The report of all components together, with that of each.
    pub fn report(&self) -> ComponentsReport<'_> {
        let of_each = self.components().map(|(name, of)| (name, of.report(None))).collect();
        let ([_, height, width], (min, max)) = (self.values.shape(), self.values.min_max());
        let all = Report::new(&self.account, [height, width], [min, max], None, None);
        ComponentsReport::new(all, of_each)
    }

    /// How the images came about, as FITS keywords: those of all components together, and for each its name, its
    /// error and its evaluations.
    pub fn cards(&self) -> Vec<Card> {
        let value = if self.account.bins.is_some() { "voxel" } else { "pixel" };
        let count = Card::new(NUMBER_OF_COMPONENTS, self.components.len() as u64, "components");
        let of_each = self.components().zip(1..).flat_map(|((name, rendered), number)| {
            let account = &rendered.account;
            let error = account.estimated_error.map(|error| {
                let meaning = format!("estimated error / its largest {value}");
                Card::new(format!("ESTER{number}"), error, meaning)
            });
            let evaluations = "evaluations that it would take alone";
            let converged = "its method ended by itself";
            [
                Some(Card::new(format!("COMP{number}"), name, "name of the component")),
                Some(Card::new(format!("NEVAL{number}"), account.evaluations, evaluations)),
                Some(Card::new(format!("CONVR{number}"), account.converged(), converged)),
                error,
            ]
        });
        let all = self.account.cards().into_iter().chain([count]);
        all.chain(of_each.flatten()).collect()
    }

    /// The bytes of a FITS file: an HDU for each component with its name, those of the errors with `_ERROR` after the
    /// name, of evaluations with `_EVALUATIONS`, and of cubes the whole band with `_BAND`. Of a sky they are columns.
    ///
    /// # Errors
    ///
    /// [`FitsEncodeError`]: what FITS can't hold.
    pub fn fits(&self) -> Result<Vec<u8>, FitsEncodeError> {
        let companions = ["ERROR", "EVALUATIONS", "BAND"].into_iter().flat_map(|kind| {
            self.components().filter_map(move |(name, of)| {
                let map = of.companions().into_iter().find(|map| map.name == kind)?;
                Some((format!("{}_{kind}", hdu_name(name)), map))
            })
        });
        self.fits_of(self.value_maps().chain(companions).collect())
    }

    /// The bytes of a FITS file with the estimated errors alone; none if the method has no estimate.
    ///
    /// # Errors
    ///
    /// As [`fits`](Self::fits).
    pub fn error_fits(&self) -> Option<Result<Vec<u8>, FitsEncodeError>> {
        let maps = self
            .components()
            .map(|(name, of)| Some((format!("{}_ERROR", hdu_name(name)), of.error_map()?)));
        Some(self.fits_of(maps.collect::<Option<Vec<NamedMap<'_>>>>()?))
    }

    fn value_maps(&self) -> impl Iterator<Item = NamedMap<'_>> {
        self.components().map(|(name, of)| (hdu_name(name), of.values_map()))
    }

    fn fits_of(&self, maps: Vec<NamedMap<'_>>) -> Result<Vec<u8>, FitsEncodeError> {
        let mut named = maps.iter().map(|(name, map)| ProductMap { name, ..*map });
        let (Some(first), Some((_, rendered))) = (named.next(), self.components.first()) else {
            return Ok(Vec::new());
        };
        rendered.fits(first, named.collect(), self.cards())
    }

    /// The bytes of an NPY file with the array (k, height, width) of k components, or (k, bins, height, width) of
    /// cubes; of a sky (k, pixels) or (k, bins, pixels) in nested order.
    ///
    /// # Errors
    ///
    /// [`EncodeError`]: what an array file can't hold.
    pub fn npy(&self) -> Result<Vec<u8>, EncodeError> {
        self.npy_of(self.components.iter().map(|(_, of)| &of.values))
    }

    /// The same of the estimated errors; none if the method has no estimate.
    ///
    /// # Errors
    ///
    /// As [`npy`](Self::npy).
    pub fn error_npy(&self) -> Option<Result<Vec<u8>, EncodeError>> {
        let errors = self.components.iter().map(|(_, of)| of.error.as_ref());
        let errors: Vec<&Cube> = errors.collect::<Option<_>>()?;
        Some(self.npy_of(errors.into_iter()))
    }

    fn npy_of<'a>(&self, maps: impl Iterator<Item = &'a Cube>) -> Result<Vec<u8>, EncodeError> {
        let [bins, height, width] =
            self.components.first().map_or([0; 3], |of| of.1.values.shape());
        let of_band = |band: &emitree::Image| match self.account.is_sky {
            true => Healpix::nested(band),
            false => band.pixels().to_vec(),
        };
        let pixels: Vec<f64> = maps.flat_map(|map| map.bands().iter().flat_map(of_band)).collect();
        let is_cube = self.account.bins.is_some();
        let bins = is_cube.then_some(bins);
        let sides = if self.account.is_sky { vec![height * width] } else { vec![height, width] };
        let shape: Vec<usize> =
            [self.components.len()].into_iter().chain(bins).chain(sides).collect();
        Ok(encode_npy(&shape, &pixels)?)
    }
}

/// The keyword with the number of components in a file.
pub(crate) const NUMBER_OF_COMPONENTS: &str = "NCOMP";

/// The name of the HDU of a component.
fn hdu_name(component: &str) -> String {
    component.to_uppercase()
}
