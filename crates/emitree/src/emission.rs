//! The directional volume emission rate g(r, d), which the user provides.
//!
//! g is expensive, so it is only ever called with a batch of many sample points, and only from
//! `meter`, where its calls are counted.

use core::convert::Infallible;

/// The sample points of one batch: positions at which g is needed, and directions of emission.
///
/// A batch is a view of arrays of equal length `n`, one row a sample:
///
/// * `positions`, `n` × 3, in the length unit of the scene, in world coordinates;
/// * `directions`, `n` × 3, unit vectors of *emission*: from the emitting point to the observer;
/// * `energies`, `n`, in the unit of the [energy axis](crate::EnergyAxis), where there is one: else
///   the array is empty.
///
/// ```
/// use emitree::Samples;
///
/// let samples = Samples::new(&[[0.0, 0.0, 1.0]], &[[0.0, 0.0, -1.0]]);
/// assert_eq!(samples.len(), 1);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    positions: &'a [[f64; 3]],
    directions: &'a [[f64; 3]],
    energies: &'a [f64],
}

impl<'a> Samples<'a> {
    /// A batch of sample points without energies.
    ///
    /// # Panics
    ///
    /// If the two arrays differ in length.
    pub fn new(positions: &'a [[f64; 3]], directions: &'a [[f64; 3]]) -> Self {
        assert_eq!(positions.len(), directions.len(), "one direction for each position");
        Self { positions, directions, energies: &[] }
    }

    /// The same batch at the given energies.
    ///
    /// # Panics
    ///
    /// If there is neither one energy for each position nor none at all.
    #[must_use]
    pub fn at_energies(self, energies: &'a [f64]) -> Self {
        assert!(
            energies.is_empty() || energies.len() == self.positions.len(),
            "one energy for each position, or none"
        );
        Self { energies, ..self }
    }

    /// The number of sample points.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether the batch has no sample points.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// World positions, in the length unit of the scene.
    pub fn positions(&self) -> &'a [[f64; 3]] {
        self.positions
    }

    /// Unit vectors of emission, from each point to the observer.
    pub fn directions(&self) -> &'a [[f64; 3]] {
        self.directions
    }

    /// Energies, in the unit of the energy axis; empty if there is none.
    pub fn energies(&self) -> &'a [f64] {
        self.energies
    }
}

/// A directional volume emission rate g(r, d), evaluated in batches.
///
/// In SI units g is in m⁻³ sr⁻¹ s⁻¹; a scene may name others, and the image then is in the unit of
/// g times the scene's length unit. With an [energy axis](crate::EnergyAxis) it is the rate per unit
/// of energy. Implement this for a model that is fastest on many points at
/// once; wrap a closure of one point with [`FromFn`].
///
/// Batches may be evaluated from several threads at a time, and the value at a point must not
/// depend on the other points of its batch.
///
/// ```
/// use emitree::{Emission, Samples};
///
/// /// A uniform glow, whatever the direction.
/// struct Uniform(f64);
///
/// impl Emission for Uniform {
///     type Error = std::convert::Infallible;
///
///     fn emission_rates(
///         &self,
///         _samples: &Samples<'_>,
///         rates: &mut [f64],
///     ) -> Result<(), Self::Error> {
///         rates.fill(self.0);
///         Ok(())
///     }
/// }
/// ```
pub trait Emission: Sync {
    /// The error of the model itself; [`Infallible`] if it has none.
    type Error: core::error::Error + Send + Sync + 'static;

    /// Writes g of sample `i` to `rates[i]`, for every sample; both have the same length.
    ///
    /// # Errors
    ///
    /// Whatever the model reports. Values that are not finite need not be reported here: the
    /// renderer finds them and names the point.
    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), Self::Error>;

    /// Whether the medium absorbs: then the image is the integral of g exp(−τ) along lines of sight, where the
    /// optical depth τ is the integral of the [absorption
    /// coefficient](Self::absorption_coefficients) between the observer and the point. [`Absorbing`] is an
    /// emission with a coefficient of its own.
    fn absorbs(&self) -> bool {
        false
    }

    /// Writes the absorption coefficient κ at sample `i` to `coefficients[i]`, for every sample, in one over the
    /// length unit of the scene; 0 by default. It is called only if the medium [absorbs](Self::absorbs). The direction is
    /// that of emission, as for the rates, and the light is absorbed on its way along it.
    ///
    /// # Errors
    ///
    /// As [`emission_rates`](Self::emission_rates).
    fn absorption_coefficients(
        &self,
        _samples: &Samples<'_>,
        coefficients: &mut [f64],
    ) -> Result<(), Self::Error> {
        coefficients.fill(0.0);
        Ok(())
    }

    /// Whether each batch has to come in one call: for a model that is parallel itself, or that only
    /// one thread may call at a time. Otherwise a batch comes in parts, from several threads.
    fn takes_whole_batches(&self) -> bool {
        false
    }
}

impl<E: Emission + ?Sized> Emission for &E {
    type Error = E::Error;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), Self::Error> {
        (**self).emission_rates(samples, rates)
    }

    fn absorbs(&self) -> bool {
        (**self).absorbs()
    }

    fn absorption_coefficients(
        &self,
        samples: &Samples<'_>,
        coefficients: &mut [f64],
    ) -> Result<(), Self::Error> {
        (**self).absorption_coefficients(samples, coefficients)
    }

    fn takes_whole_batches(&self) -> bool {
        (**self).takes_whole_batches()
    }
}

/// An emission in a medium that absorbs: g of `emission`, and the absorption coefficient κ in place of the rates
/// of `absorption`, in one over the length unit of the scene.
///
/// The image is the integral of g exp(−τ) along lines of sight, where the optical depth τ is the integral of κ between the
/// observer, or the near end of the line or the bounds of the view, and the point.
///
/// ```
/// use emitree::{Absorbing, Canonical, FromFn, RenderOptions, VolOptions, render};
///
/// // A uniform cube of optical depth 2, seen through one of its faces.
/// let fog = Absorbing {
///     emission: FromFn(|_: [f64; 3], _: [f64; 3]| 1.0),
///     absorption: FromFn(|_: [f64; 3], _: [f64; 3]| 2.0),
/// };
/// let options = RenderOptions::new(VolOptions::new(0.01));
/// let rendering = render(&fog, &Canonical, [4, 4], &options)?;
/// let exact = 0.5 * (1.0 - (-2.0_f64).exp()); // ∫ exp(−2 z) dz
/// assert!((rendering.values[(0, 0)] - exact).abs() < 0.01 * exact);
/// assert!(rendering.stats.absorption_evaluations > 0);
/// # Ok::<(), emitree::RenderError<std::convert::Infallible>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Absorbing<G, K> {
    /// g.
    pub emission: G,
    /// κ.
    pub absorption: K,
}

impl<G: Emission, K: Emission<Error = G::Error>> Emission for Absorbing<G, K> {
    type Error = G::Error;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), G::Error> {
        self.emission.emission_rates(samples, rates)
    }

    fn absorbs(&self) -> bool {
        true
    }

    fn absorption_coefficients(
        &self,
        samples: &Samples<'_>,
        coefficients: &mut [f64],
    ) -> Result<(), G::Error> {
        self.absorption.emission_rates(samples, coefficients)
    }

    fn takes_whole_batches(&self) -> bool {
        self.emission.takes_whole_batches() || self.absorption.takes_whole_batches()
    }
}

/// An [`Emission`] from a closure `g(position, direction) -> rate` of one point.
///
/// ```
/// use emitree::FromFn;
///
/// let ball = FromFn(|[x, y, z]: [f64; 3], _direction: [f64; 3]| (-(x * x + y * y + z * z)).exp());
/// ```
#[derive(Clone, Copy, Debug)]
pub struct FromFn<F>(pub F);

impl<F> Emission for FromFn<F>
where
    F: Fn([f64; 3], [f64; 3]) -> f64 + Sync,
{
    type Error = Infallible;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), Infallible> {
        let points = samples.positions.iter().zip(samples.directions);
        for (rate, (&position, &direction)) in rates.iter_mut().zip(points) {
            *rate = (self.0)(position, direction);
        }
        Ok(())
    }
}

/// An [`Emission`] from a closure `g(position, direction, energy) -> rate` of one point: the rate per
/// unit of energy.
///
/// Without an energy axis the energy is NaN.
///
/// ```
/// use emitree::FromSpectralFn;
///
/// let thermal = FromSpectralFn(|[x, y, z]: [f64; 3], _direction: [f64; 3], energy: f64| {
///     (-(x * x + y * y + z * z) - energy / 2.0).exp()
/// });
/// ```
#[derive(Clone, Copy, Debug)]
pub struct FromSpectralFn<F>(pub F);

impl<F> Emission for FromSpectralFn<F>
where
    F: Fn([f64; 3], [f64; 3], f64) -> f64 + Sync,
{
    type Error = Infallible;

    fn emission_rates(&self, samples: &Samples<'_>, rates: &mut [f64]) -> Result<(), Infallible> {
        let points = samples.positions.iter().zip(samples.directions);
        for (i, (rate, (&position, &direction))) in rates.iter_mut().zip(points).enumerate() {
            let energy = samples.energies.get(i).copied().unwrap_or(f64::NAN);
            *rate = (self.0)(position, direction, energy);
        }
        Ok(())
    }
}
