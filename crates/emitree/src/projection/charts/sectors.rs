//! Sectors: parts of the azimuth about the axis of shells, divided by planes through the axis.
//!
//! The axis is the line through the observer and the centre, or through the centre along parallel
//! lines. A plane that contains it is seen edge-on. If g has a kink or a jump there, so has the
//! image at two azimuths, and charts that end there are smooth.

use core::f64::consts::TAU;

/// Azimuths closer to each other are one \[rad\].
const SAME_AZIMUTH_RAD: f64 = 1e-7;
/// Lines of sight in a chart are at least this far from the ends of its sector \[rad\]: a plane is
/// known to rounding, and a rate on its wrong side would be wrong by the whole jump.
const BESIDE_RAD: f64 = 1e-9;

/// The azimuths at which the charts of shells are divided.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Sectors {
    /// In ascending order, from 0 to 2π.
    cuts_rad: Vec<f64>,
}

impl Sectors {
    /// Divides the charts at an azimuth.
    pub(super) fn cut(&mut self, azimuth: f64) {
        let azimuth = azimuth.rem_euclid(TAU) % TAU;
        let apart = |cut: &f64| (azimuth - cut).rem_euclid(TAU);
        let is_there = |cut: &f64| apart(cut).min(TAU - apart(cut)) < SAME_AZIMUTH_RAD;
        if azimuth.is_finite() && !self.cuts_rad.iter().any(is_there) {
            let number = self.cuts_rad.partition_point(|cut| *cut < azimuth);
            self.cuts_rad.insert(number, azimuth);
        }
    }

    /// The number of sectors.
    pub(super) fn len(&self) -> usize {
        self.cuts_rad.len().max(1)
    }

    /// The number of the sector of an azimuth.
    pub(super) fn of(&self, azimuth: f64) -> usize {
        let azimuth = azimuth.rem_euclid(TAU);
        let before = self.cuts_rad.partition_point(|cut| *cut <= azimuth);
        (before + self.len() - 1) % self.len()
    }

    /// The beginning and the width of a sector; `None` if it is the whole circle without a cut.
    pub(super) fn azimuth_rad(&self, sector: usize) -> Option<[f64; 2]> {
        let begin = *self.cuts_rad.get(sector)?;
        let end = self.cuts_rad.get(sector + 1).copied();
        let end = end.unwrap_or(self.cuts_rad[0] + TAU);
        Some([begin + BESIDE_RAD, end - begin - 2.0 * BESIDE_RAD])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    #[test]
    fn sectors_are_between_successive_cuts() {
        let mut sectors = Sectors::default();
        assert_eq!((sectors.len(), sectors.of(3.0), sectors.azimuth_rad(0)), (1, 0, None));
        for azimuth in [-0.5 * PI, 0.5 * PI, 0.5 * PI + 1e-9, 1.5 * PI, f64::NAN, 0.0, TAU] {
            sectors.cut(azimuth);
        }
        assert_eq!(sectors.len(), 3);
        for sector in 0..3 {
            let [begin, width] = sectors.azimuth_rad(sector).unwrap();
            assert!([PI, 0.5 * PI].iter().any(|expected| (width / expected - 1.0).abs() < 1e-8));
            for part in [0.0, 0.3, 1.0] {
                assert_eq!(sectors.of(begin + part * width), sector);
                assert_eq!(sectors.of(begin + part * width - TAU), sector);
            }
        }
    }

    #[test]
    fn one_cut_is_both_ends_of_the_circle() {
        let mut sectors = Sectors::default();
        sectors.cut(2.0);
        let [begin, width] = sectors.azimuth_rad(0).unwrap();
        assert!((begin - 2.0).abs() < 1e-8 && width < TAU && TAU - width < 1e-8);
        assert_eq!([0.0, 2.0, 4.0].map(|azimuth| sectors.of(azimuth)), [0; 3]);
    }
}
