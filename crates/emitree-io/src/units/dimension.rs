//! What kind of quantity a unit measures: whole powers of base dimensions.

use core::fmt;

/// Powers of the base dimensions.
///
/// ```
/// use emitree_io::units::Unit;
///
/// let unit = Unit::parse("erg cm-2 sr-1")?;
/// assert_eq!(unit.dimension().to_string(), "mass time^-2 angle^-2");
/// # Ok::<(), emitree_io::units::UnitError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dimension {
    /// Of the metre.
    pub length: i32,
    /// Of the kilogram.
    pub mass: i32,
    /// Of the second.
    pub time: i32,
    /// Of the radian; −2 for "per solid angle".
    pub angle: i32,
    /// Of photons, a number of particles that is kept apart from pure numbers.
    pub photon: i32,
    /// Of counts, what a detector makes of photons.
    pub count: i32,
}

impl Dimension {
    /// The dimension of pure numbers.
    pub const NONE: Self = Self { length: 0, mass: 0, time: 0, angle: 0, photon: 0, count: 0 };
    /// A length.
    pub const LENGTH: Self = Self { length: 1, ..Self::NONE };
    /// A mass.
    pub const MASS: Self = Self { mass: 1, ..Self::NONE };
    /// A time.
    pub const TIME: Self = Self { time: 1, ..Self::NONE };
    /// An angle.
    pub const ANGLE: Self = Self { angle: 1, ..Self::NONE };
    /// A solid angle.
    pub const SOLID_ANGLE: Self = Self { angle: 2, ..Self::NONE };
    /// A number of photons.
    pub const PHOTON: Self = Self { photon: 1, ..Self::NONE };
    /// A number of counts.
    pub const COUNT: Self = Self { count: 1, ..Self::NONE };
    /// An energy.
    pub const ENERGY: Self = Self { length: 2, mass: 1, time: -2, ..Self::NONE };

    /// The dimension of a product of this to the power `own` and `other` to the power `power`.
    pub(super) fn combined(self, own: i32, other: Self, power: i32) -> Self {
        let sum = |a: i32, b: i32| a.saturating_mul(own).saturating_add(b.saturating_mul(power));
        Self {
            length: sum(self.length, other.length),
            mass: sum(self.mass, other.mass),
            time: sum(self.time, other.time),
            angle: sum(self.angle, other.angle),
            photon: sum(self.photon, other.photon),
            count: sum(self.count, other.count),
        }
    }

    /// The dimension of a quotient.
    pub(super) fn over(self, other: Self) -> Self {
        self.combined(1, other, -1)
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let powers = [
            ("length", self.length),
            ("mass", self.mass),
            ("time", self.time),
            ("angle", self.angle),
            ("photon", self.photon),
            ("count", self.count),
        ];
        let mut separator = "";
        for (name, power) in powers.into_iter().filter(|(_, power)| *power != 0) {
            write!(f, "{separator}{name}")?;
            if power != 1 {
                write!(f, "^{power}")?;
            }
            separator = " ";
        }
        if separator.is_empty() { f.write_str("a pure number") } else { Ok(()) }
    }
}
