//! A unit: a number times named units to whole powers.

use super::magnitude::Magnitude;
use super::parser;
use super::table::KnownUnit;
use super::{Dimension, UnitError};
use core::fmt;

/// A unit of a quantity: a number times named units to whole powers, in the order they came.
///
/// Two are equal if their texts are the same; [`factor_to`](Self::factor_to) is 1 for units of the
/// same size.
///
/// ```
/// use emitree_io::units::Unit;
///
/// let radiance = Unit::parse("ph/(cm2 s sr)")?;
/// assert_eq!(radiance.to_string(), "ph cm-2 s-1 sr-1");
/// assert_eq!(Unit::parse("Mpc")?.factor_to(&Unit::parse("kpc")?)?, 1000.0);
/// # Ok::<(), emitree_io::units::UnitError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    scale: Magnitude,
    factors: Vec<Factor>,
}

/// A named unit with its prefix, to a power that is not zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Factor {
    /// Symbol and power of ten.
    pub(super) prefix: (&'static str, i32),
    pub(super) known: &'static KnownUnit,
    pub(super) exponent: i32,
}

impl Factor {
    fn same_name(&self, other: &Self) -> bool {
        self.prefix == other.prefix && core::ptr::eq(self.known, other.known)
    }

    fn magnitude(&self) -> Magnitude {
        self.known.size.times(Magnitude::new(1.0, self.prefix.1)).power(self.exponent)
    }
}

impl Unit {
    /// The unit of pure numbers.
    pub fn one() -> Self {
        Self { scale: Magnitude::ONE, factors: Vec::new() }
    }

    /// The unit that `text` names, in the grammar of the [module](super).
    ///
    /// An empty text and `1` are pure numbers. A product after a quotient, `a/b c`, is refused:
    /// some read it as a c/b, others as a/(b c).
    ///
    /// # Errors
    ///
    /// [`UnitError`] with the place in `text` if a name is unknown or the grammar is not kept.
    ///
    /// ```
    /// use emitree_io::units::Unit;
    ///
    /// for text in ["ph/(cm2 s sr)", "ph cm**-2 s^-1 sr-1", "ph/cm2/s/sr", "10**-4 km m-1 R"] {
    ///     assert!(Unit::parse(text).is_ok());
    /// }
    /// assert_eq!(
    ///     Unit::parse("ph/cm2 s").unwrap_err().to_string(),
    ///     "unit `ph/cm2 s`: a product after a quotient at character 8: expected parentheses: \
    ///      a/(b c), or powers: a b-1 c"
    /// );
    /// # Ok::<(), emitree_io::units::UnitError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, UnitError> {
        parser::parse(text)
    }

    pub(super) fn number(scale: Magnitude) -> Self {
        Self { scale, factors: Vec::new() }
    }

    pub(super) fn named(factor: Factor) -> Self {
        Self::number(Magnitude::ONE).times_factor(factor)
    }

    pub(super) fn factors(&self) -> &[Factor] {
        &self.factors
    }

    /// The product with `other`; equal names are joined.
    ///
    /// ```
    /// use emitree_io::units::Unit;
    ///
    /// let product = Unit::parse("cm-3 s-1")?.times(&Unit::parse("cm")?);
    /// assert_eq!(product.to_string(), "cm-2 s-1");
    /// # Ok::<(), emitree_io::units::UnitError>(())
    /// ```
    #[must_use]
    pub fn times(&self, other: &Self) -> Self {
        let product = Self { scale: self.scale.times(other.scale), ..self.clone() };
        other.factors.iter().fold(product, |product, factor| product.times_factor(*factor))
    }

    /// The unit to a whole power.
    ///
    /// ```
    /// use emitree_io::units::Unit;
    ///
    /// assert_eq!(Unit::parse("m s-1")?.power(-2).to_string(), "m-2 s2");
    /// # Ok::<(), emitree_io::units::UnitError>(())
    /// ```
    #[must_use]
    pub fn power(&self, exponent: i32) -> Self {
        let raised = |factor: &Factor| Factor {
            exponent: factor.exponent.saturating_mul(exponent),
            ..*factor
        };
        let factors = self.factors.iter().map(raised).filter(|factor| factor.exponent != 0);
        Self { scale: self.scale.power(exponent), factors: factors.collect() }
    }

    fn times_factor(mut self, factor: Factor) -> Self {
        match self.factors.iter_mut().find(|own| own.same_name(&factor)) {
            Some(own) => own.exponent = own.exponent.saturating_add(factor.exponent),
            None => self.factors.push(factor),
        }
        self.factors.retain(|factor| factor.exponent != 0);
        self
    }

    /// What the unit measures.
    ///
    /// ```
    /// use emitree_io::units::{Dimension, Unit};
    ///
    /// assert_eq!(Unit::parse("keV")?.dimension(), Dimension::ENERGY);
    /// # Ok::<(), emitree_io::units::UnitError>(())
    /// ```
    pub fn dimension(&self) -> Dimension {
        self.factors.iter().fold(Dimension::NONE, |product, factor| {
            product.combined(1, factor.known.dimension, factor.exponent)
        })
    }

    /// The size of the unit in SI.
    pub(super) fn magnitude(&self) -> Magnitude {
        self.factors.iter().fold(self.scale, |product, factor| product.times(factor.magnitude()))
    }

    /// How many `other` this is: values in this unit times the factor are values in `other`.
    ///
    /// # Errors
    ///
    /// [`UnitError`] if the two measure different quantities, or the factor is beyond what a 64-bit
    /// float holds.
    ///
    /// ```
    /// use emitree_io::units::Unit;
    ///
    /// let factor = Unit::parse("R_E")?.factor_to(&Unit::parse("cm")?)?;
    /// assert_eq!(factor, 6.371e8);
    /// # Ok::<(), emitree_io::units::UnitError>(())
    /// ```
    pub fn factor_to(&self, other: &Self) -> Result<f64, UnitError> {
        if self.dimension() != other.dimension() {
            return Err(self.incompatible(other, "units of the same dimension"));
        }
        self.finite_factor(other, self.magnitude().over(other.magnitude()))
    }

    pub(super) fn incompatible(&self, other: &Self, expected: &'static str) -> UnitError {
        UnitError::Incompatible {
            from: self.to_string(),
            from_dimension: self.dimension(),
            to: other.to_string(),
            to_dimension: other.dimension(),
            expected,
        }
    }

    pub(super) fn finite_factor(&self, to: &Self, factor: Magnitude) -> Result<f64, UnitError> {
        let factor = factor.value();
        if (1e-300..=1e300).contains(&factor) {
            Ok(factor)
        } else {
            Err(UnitError::OutOfRange { from: self.to_string(), to: to.to_string(), factor })
        }
    }

    /// The unit as `BUNIT` and `CUNIT` have it, and the factor to values in it: none for pure
    /// numbers.
    ///
    /// FITS allows neither the radii of planets, which become kilometres, nor numbers that are not
    /// powers of ten, which go into the factor.
    ///
    /// ```
    /// use emitree_io::units::Unit;
    ///
    /// assert_eq!(Unit::parse("kR")?.fits(), (Some("kR".to_owned()), 1.0));
    /// assert_eq!(Unit::parse("10**6 ph")?.fits(), (Some("10**6 ph".to_owned()), 1.0));
    /// assert_eq!(Unit::parse("R_mars")?.fits(), (Some("km".to_owned()), 3389.5));
    /// assert_eq!(Unit::parse("2.5")?.fits(), (None, 2.5));
    /// # Ok::<(), emitree_io::units::UnitError>(())
    /// ```
    pub fn fits(&self) -> (Option<String>, f64) {
        let (unit, factor) = self.in_fits();
        ((!unit.is_one()).then(|| unit.to_string()), factor)
    }

    /// An equal unit of names and numbers that FITS allows, and the factor to values in it.
    pub(super) fn in_fits(&self) -> (Self, f64) {
        let mut known = Self::number(Magnitude::new(1.0, self.scale.decade));
        let mut rest = Magnitude::new(self.scale.mantissa, 0);
        if self.factors.is_empty() {
            // A power of ten alone is a number, and no unit.
            return (Self::one(), self.scale.value());
        }
        for factor in &self.factors {
            if factor.known.in_fits {
                known = known.times_factor(*factor);
                continue;
            }
            if let Some((prefix, metre)) = super::table::find("km") {
                let kilometres = Factor { prefix, known: metre, exponent: factor.exponent };
                rest = rest.times(factor.magnitude().over(kilometres.magnitude()));
                known = known.times_factor(kilometres);
            }
        }
        (known, rest.value())
    }

    /// Whether this is the unit of pure numbers.
    pub fn is_one(&self) -> bool {
        *self == Self::one()
    }
}

/// As FITS has it, but for numbers and names that FITS lacks (see [`Unit::fits`]): `cm-2 s-1`; a
/// pure number is `1`.
impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Magnitude { mantissa, decade } = self.scale;
        #[expect(clippy::float_cmp, reason = "only the exact power of ten is written as one")]
        let power_of_ten = mantissa == 1.0;
        let mut separator = " ";
        match (power_of_ten, decade) {
            (true, 0) if self.factors.is_empty() => f.write_str("1")?,
            (true, 0) => separator = "",
            (true, _) => write!(f, "10**{decade}")?,
            (false, 0) => write!(f, "{mantissa}")?,
            (false, _) => write!(f, "{mantissa}e{decade}")?,
        }
        for Factor { prefix, known, exponent } in &self.factors {
            write!(f, "{separator}{}{}", prefix.0, known.names[0])?;
            if *exponent != 1 {
                write!(f, "{exponent}")?;
            }
            separator = " ";
        }
        Ok(())
    }
}
