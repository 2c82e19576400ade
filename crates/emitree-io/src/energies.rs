//! The third axis of a cube with its unit: the energies of a scene's `[energy]`, or the times of its `[time]`.

use crate::units::{Dimension, Unit, UnitError};
use emitree::{EnergyAxis, EnergyScale};

/// The unit of times.
const SECOND: &str = "s";

/// An energy axis whose numbers have a unit; or one of times, made by [`times`](Self::times).
///
/// ```
/// use emitree::{EnergyAxis, EnergyScale};
/// use emitree_io::Energies;
///
/// let axis = EnergyAxis::new(0.5, 8.0, 4, EnergyScale::Log)?;
/// let energies = Energies::new(axis, "keV")?;
/// assert_eq!(energies.label(0..2), "0.5–2 keV");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Energies {
    axis: EnergyAxis,
    name: String,
    unit: Unit,
    in_si: f64,
    is_time: bool,
    lines: Vec<f64>,
}

impl Energies {
    /// The energies of `axis` in the `unit` of that name, in the grammar of [`units`](crate::units).
    ///
    /// # Errors
    ///
    /// [`UnitError`] if the unit is not one, is not one of energy, or is beyond all energies.
    pub fn new(axis: EnergyAxis, unit: &str) -> Result<Self, UnitError> {
        let (name, unit) = (unit.to_owned(), Unit::parse(unit)?);
        if unit.dimension() != Dimension::ENERGY {
            return Err(UnitError::NotAnEnergy { unit: name, dimension: unit.dimension() });
        }
        let in_si = unit.factor_to(&Unit::parse("J")?)?;
        Ok(Self { axis, name, unit, in_si, is_time: false, lines: Vec::new() })
    }

    /// The times of `axis` \[s\], of images that are means over their bins.
    ///
    /// ```
    /// use emitree::{EnergyAxis, EnergyScale};
    /// use emitree_io::Energies;
    ///
    /// let times = Energies::times(EnergyAxis::new(0.0, 60.0, 4, EnergyScale::Linear)?);
    /// assert_eq!((times.is_time(), times.label(0..1)), (true, "0–15 s".to_owned()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn times(axis: EnergyAxis) -> Self {
        // The grammar of units has the second: only a name could be missing.
        let unit = Unit::parse(SECOND).unwrap_or_else(|_| Unit::one());
        let name = SECOND.to_owned();
        Self { axis, name, unit, in_si: 1.0, is_time: true, lines: Vec::new() }
    }

    /// Whether they are times.
    pub fn is_time(&self) -> bool {
        self.is_time
    }

    /// What they are, for people: `energies` or `times`.
    pub fn noun(&self) -> &'static str {
        if self.is_time() { "times" } else { "energies" }
    }

    /// With the energies of spectral lines, in the unit of the axis; see
    /// [`VolOptions::line_energies`](emitree::VolOptions::line_energies).
    pub fn with_lines(self, lines: Vec<f64>) -> Self {
        Self { lines, ..self }
    }

    /// The energies of spectral lines that are known beforehand.
    pub fn lines(&self) -> &[f64] {
        &self.lines
    }

    /// The bins, their energies in [`unit`](Self::unit).
    pub fn axis(&self) -> &EnergyAxis {
        &self.axis
    }

    /// The unit of the energies.
    pub fn unit(&self) -> &Unit {
        &self.unit
    }

    /// The unit of the energies, as it was written.
    pub fn unit_name(&self) -> &str {
        &self.name
    }

    /// Joules, or seconds, in one [`unit`](Self::unit).
    pub fn in_si(&self) -> f64 {
        self.in_si
    }

    /// The name of the scale, as scenes and reports write it.
    pub fn scale_name(&self) -> &'static str {
        match self.axis.scale() {
            EnergyScale::Linear => "linear",
            EnergyScale::Log => "log",
        }
    }

    /// The range of energies that a range of bins has, for people: `0.5–2 keV`. It has as many
    /// digits as distinguish the bins.
    ///
    /// # Panics
    ///
    /// If there are no such bins.
    pub fn label(&self, bins: std::ops::Range<usize>) -> String {
        let edges = self.axis.edges();
        energy_range([bins.start, bins.end].map(|edge| self.shown(edges[edge])), &self.name)
    }

    /// An edge, or 0 for a border that is 0 but for the rounding of the ends.
    fn shown(&self, edge: f64) -> f64 {
        let (min, max) = (self.axis.min(), self.axis.max());
        let is_rounding = min < 0.0 && edge.abs() <= f64::EPSILON * max.abs().max(-min);
        if is_rounding && min < edge && edge < max { 0.0 } else { edge }
    }
}

/// A range of energies in a unit, for people: `0.5–2 keV`. It has as many digits as its length needs,
/// and an end near 0 as many as it needs itself.
///
/// ```
/// assert_eq!(emitree_io::energy_range([0.5, 0.625], "keV"), "0.5–0.625 keV");
/// ```
pub fn energy_range([low, high]: [f64; 2], unit: &str) -> String {
    let number = |energy| short(energy, high - low);
    format!("{}–{} {unit}", number(low), number(high))
}

/// A number with the digits that a difference of `step` needs, without zeros at the end.
fn short(number: f64, step: f64) -> String {
    // A smaller number has three digits of its own, lest it be shown as 0.
    let step = if number == 0.0 { step } else { step.min(number.abs()) };
    let largest = number.abs().max(step);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the digits of a 64-bit float"
    )]
    let digits = |below: f64| (2.0 - below.log10().floor()).clamp(0.0, 16.0) as usize;
    if (1e-3..1e6).contains(&largest) {
        let text = format!("{number:.*}", digits(step));
        let trimmed = text.trim_end_matches('0').trim_end_matches('.');
        return if text.contains('.') { trimmed.to_owned() } else { text };
    }
    let text = format!("{number:.*e}", digits(step / largest));
    match text.split_once('e') {
        Some((mantissa, power)) if mantissa.contains('.') => {
            format!("{}e{power}", mantissa.trim_end_matches('0').trim_end_matches('.'))
        }
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn energies(min: f64, max: f64, bins: usize, unit: &str) -> Energies {
        let axis = EnergyAxis::new(min, max, bins, EnergyScale::Linear).unwrap();
        Energies::new(axis, unit).unwrap()
    }

    #[test]
    fn labels_tell_bins_apart() {
        let axis = energies(0.5, 2.5, 16, "keV");
        assert_eq!([axis.label(0..1), axis.label(15..16)], ["0.5–0.625 keV", "2.375–2.5 keV"]);
        assert_eq!(energies(100.0, 3000.0, 1, "eV").label(0..1), "100–3000 eV");
        assert_eq!(energies(0.0, 20.0, 2, "eV").label(0..1), "0–10 eV");
        let lines = energies(6.3997, 6.4001, 4, "keV");
        assert_eq!(lines.label(1..2), "6.3998–6.3999 keV");
        assert_eq!(energies(0.0, 3.2e-16, 2, "J").label(1..2), "1.6e-16–3.2e-16 J");
        assert_eq!(energies(1e6, 2e7, 1, "eV").label(0..1), "1e6–2e7 eV");
    }

    #[test]
    fn labels_show_nothing_as_zero_that_is_not() {
        assert_eq!(energies(0.01, 50.0, 9, "keV").label(0..9), "0.01–50 keV");
        assert_eq!(energies(-0.01, 50.0, 9, "keV").label(0..9), "-0.01–50 keV");
        let log = |min, max| {
            let axis = EnergyAxis::new(min, max, 9, EnergyScale::Log).unwrap();
            Energies::new(axis, "keV").unwrap().label(0..9)
        };
        assert_eq!(log(0.01, 50.0), "0.01–50 keV");
        assert_eq!(log(0.06, 50.0), "0.06–50 keV");
        assert_eq!(log(0.012_345, 50.0), "0.0123–50 keV");
        assert_eq!(log(1e-5, 50.0), "1e-5–50 keV");
        assert_eq!(log(1e-200, 50.0), "1e-200–50 keV");
        assert_eq!(log(0.5, 2e7), "0.5–2e7 keV");
        // A border that is 0 but for the rounding of its own arithmetic, 1.4e-17.
        let axis = energies(-0.1, 0.6, 7, "keV");
        assert!(axis.axis().edges()[1] != 0.0);
        assert_eq!([axis.label(0..1), axis.label(1..7)], ["-0.1–0 keV", "0–0.6 keV"]);
    }

    #[test]
    fn units_of_other_quantities_are_refused() {
        let axis = EnergyAxis::new(1.0, 2.0, 1, EnergyScale::Log).unwrap();
        let message = |unit| Energies::new(axis, unit).unwrap_err().to_string();
        assert_eq!(message("Angstrom"), "unit `Angstrom` is of length: expected an energy");
        assert!(message("kev").contains("did you mean"), "{}", message("kev"));
    }
}
