//! Absorption: rates become g exp(−τ), where τ is the integral of the absorption coefficient κ from the
//! observer to the point.
//!
//! This is done on the caller's side of a rendering, between g and the methods (`exchange.rs`), for which g exp(−τ)
//! is a function like any other. κ is integrated along each line of sight with a point at which g is not 0, up to the
//! end of the part of the line with that point, and once for all points of the line. Its values are those of a
//! low-rank approximation, if κ has one in the view (`model.rs`), and else are evaluated on each line.

mod jumps;
mod model;
mod panels;
mod traced;
mod tracing;

use crate::calls::Calls;
use crate::erased::AnyError;
use crate::error::RenderError;
use crate::exchange::Batch;
use crate::line_values::LineValues;
use crate::los::{LosOptions, Steps};
use crate::options::{Method, RenderOptions};
use crate::output::MethodOutput;
use crate::projection::Projection;
use crate::projection::path::{LineKey, Paths};
use model::KnownCoefficient;
use panels::Rule;
use rustc_hash::FxHashMap;
use traced::Traced;
use tracing::{PartOfLine, Tracing};

/// The share of the tolerance of the image that the method has, for g exp(−τ); the error of τ, a relative error of
/// the light from behind, has the rest.
const SHARE_OF_METHOD: f64 = 0.9;
/// The share of the optical depth along a line, given κ.
const SHARE_OF_LINES: f64 = 0.02;
/// The share of κ by products, whose cost depends on it.
const SHARE_OF_PRODUCTS: f64 = 0.08;
/// The least error allowed, also where the method has no tolerance, or others may follow: a fiftieth of the
/// tightest tolerance in use, 1e-5.
const FINEST: f64 = 2e-7;
/// Lines that are stored, at most: some 200 MB. If there are more, all are removed and integrated again when they
/// are needed.
const MOST_LINES: usize = 1 << 17;
/// Lines with evaluations of κ, with which products are compared.
const VERIFICATION_LINES: u32 = 8;
/// What a difference on these lines may be of a larger one on others.
const OF_VERIFICATION: f64 = 2.0;

/// The optical depths of the lines of sight of one rendering.
#[derive(Debug)]
pub(crate) struct Absorption {
    rule: Rule,
    /// The tolerance of the image; none if the method has none, or may be continued to another one.
    of_image: Option<f64>,
    /// The error allowed in the optical depth of a line, beside that of the model.
    tolerance: f64,
    numbers: FxHashMap<(LineKey, u64), usize>,
    lines: Vec<Traced>,
    /// The largest estimated error of an optical depth so far.
    error: f64,
    /// Whether a model was looked for.
    has_begun: bool,
    model: Option<KnownCoefficient>,
}

/// The options of a method whose rates are attenuated: its share of the tolerance.
pub(crate) fn of_method<'a>(options: &RenderOptions<'a>) -> RenderOptions<'a> {
    let mut options = options.clone();
    match &mut options.method {
        Method::Vol(vol) if vol.sums.is_empty() => {
            vol.tolerance *= SHARE_OF_METHOD;
            if let Some(by_pixel) = &mut vol.by_pixel {
                by_pixel.rtol *= SHARE_OF_METHOD;
            }
        }
        Method::Los(LosOptions { steps: Steps::Adaptive(tolerance), .. }) => {
            *tolerance *= SHARE_OF_METHOD;
        }
        _ => {}
    }
    options
}

impl Absorption {
    /// Of a rendering by a method with its [share](of_method) of the tolerance; `keeps_rates` if it may be continued to
    /// another one, and then it has all of it.
    pub(crate) fn new(method: &Method, keeps_rates: bool) -> Self {
        let of_method = match method {
            Method::Vol(vol) if !keeps_rates => vol.by_pixel.map_or(vol.tolerance, |by| by.rtol),
            Method::Los(LosOptions { steps: Steps::Adaptive(tolerance), .. }) if !keeps_rates => {
                *tolerance
            }
            _ => 0.0,
        };
        let of_image = of_method / SHARE_OF_METHOD;
        Self {
            rule: Rule::new(),
            of_image: Some(of_image).filter(|tolerance| *tolerance > 0.0),
            tolerance: (SHARE_OF_LINES * of_image).max(FINEST),
            numbers: FxHashMap::default(),
            lines: Vec::new(),
            error: 0.0,
            // Other methods evaluate g at so many points that κ costs less without.
            has_begun: !matches!(method, Method::Vol(_)),
            model: None,
        }
    }

    /// Adds the error of the optical depths to that of the image: a relative error of rates, and of a pixel
    /// where g has one sign.
    pub(crate) fn add_error(&self, made: &mut MethodOutput) {
        if let Some(error) = &mut made.error {
            for (error, band) in error.bands_mut().iter_mut().zip(made.cube.bands()) {
                for (error, value) in error.pixels_mut().iter_mut().zip(band.pixels()) {
                    *error += self.error * value.abs();
                }
            }
        }
        if let Some(LineValues { values, errors }) = &mut made.lines {
            for (error, value) in errors.iter_mut().zip(values) {
                *error += self.error * value.abs();
            }
        }
        if let (Some(share), Some(of_image)) = (&mut made.error_over_allowed, self.of_image) {
            *share = SHARE_OF_METHOD * *share + self.error / of_image;
        }
    }

    /// Multiplies the rates of a batch with exp(−τ).
    pub(crate) fn attenuate(
        &mut self,
        calls: &Calls<'_>,
        projection: &dyn Projection,
        batch: &mut Batch,
    ) -> Result<(), RenderError<AnyError>> {
        let is_dark = batch.rates.iter().all(|rate| *rate == 0.0);
        if is_dark {
            return Ok(());
        }
        if !core::mem::replace(&mut self.has_begun, true) && batch.energies.is_empty() {
            self.find_model(calls, projection)?;
        }
        if self.lines.len() > MOST_LINES {
            self.forget();
        }
        let depths = self.depths(calls, projection, batch)?;
        for (rate, depth) in batch.rates.iter_mut().zip(depths) {
            *rate *= (-depth).exp();
        }
        Ok(())
    }

    /// Removes all lines.
    fn forget(&mut self) {
        self.numbers.clear();
        self.lines.clear();
    }

    /// Looks for a model of κ, and compares it with evaluations on some lines.
    fn find_model(
        &mut self,
        calls: &Calls<'_>,
        projection: &dyn Projection,
    ) -> Result<(), RenderError<AnyError>> {
        let Some(of_image) = self.of_image else { return Ok(()) };
        let allowed = SHARE_OF_PRODUCTS * of_image;
        let Some(model) = model::find(calls, projection, allowed)? else { return Ok(()) };
        let mut ends = Batch::default();
        for k in 0..VERIFICATION_LINES {
            let at = |step: f64| (0.5 + f64::from(k) * step).fract();
            // The generalized golden ratio, and depths at which most of an infinite line is in front.
            let place = [at(0.754_877_666_246_692_8), at(0.569_840_290_998_053_3), 0.999];
            let point = projection.world_from_canonical(place);
            ends.positions.push(point.position);
            ends.directions.push(point.direction);
        }
        ends.rates.resize(ends.len(), 1.0);
        let evaluated = self.depths(calls, projection, &ends)?;
        self.model = Some(model);
        self.forget();
        let by_model = self.depths(calls, projection, &ends)?;
        let differences =
            evaluated.iter().zip(by_model).map(|(depth, other)| (depth - other).abs());
        let found = OF_VERIFICATION * differences.fold(0.0, f64::max);
        self.error = 0.0;
        self.model = self.model.take().filter(|_| found <= allowed).map(|mut model| {
            model.error = model.error.max(found);
            model
        });
        if self.model.is_none() {
            self.forget();
        }
        Ok(())
    }

    /// The optical depths of the points of a batch; 0 where g is 0.
    fn depths(
        &mut self,
        calls: &Calls<'_>,
        projection: &dyn Projection,
        batch: &Batch,
    ) -> Result<Vec<f64>, RenderError<AnyError>> {
        let paths = Paths::of(projection);
        let places: Vec<_> = (0..batch.len()).map(|i| self.place(&paths, batch, i)).collect();
        let needed = places.iter().flatten().map(|(of, _)| *of).collect();
        Tracing { absorption: self, calls, paths, projection }.trace(needed)?;
        let depth = |place: Option<(PartOfLine, f64)>| {
            place.map_or(0.0, |(PartOfLine { line, part }, z)| self.lines[line].up_to(part, z))
        };
        Ok(places.into_iter().map(depth).collect())
    }

    /// The line of point `i` of a batch, the part, and z there; `None` if nothing is in front of it, or g is 0.
    fn place(&mut self, paths: &Paths<'_>, batch: &Batch, i: usize) -> Option<(PartOfLine, f64)> {
        if batch.rates[i] == 0.0 {
            return None;
        }
        let energy = batch.energies.get(i).copied();
        let (key, at) = paths.locate(batch.positions[i], batch.directions[i])?;
        let lines = &mut self.lines;
        let number = self.numbers.entry((key, energy.map_or(0, f64::to_bits)));
        let line = *number.or_insert_with(|| {
            lines.push(Traced::new(paths.path(key), energy));
            lines.len() - 1
        });
        let (part, z) = lines[line].path.place(at)?;
        Some((PartOfLine { line, part }, z))
    }
}
