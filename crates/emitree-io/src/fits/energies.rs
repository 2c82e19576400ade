//! The energy axis of a cube: its coordinates, and a table of its bins.
//!
//! Greisen, Calabretta, Valdes & Allen 2006 (doi:10.1051/0004-6361:20053818): a linear axis is
//! `ENER`. One with bins of equal ratios is `ENER-LOG`, on which w = `CDELT` (p − `CRPIX`) stands for
//! the energy `CRVAL` · exp(w/`CRVAL`).
//!
//! Rots et al. 2015 (doi:10.1051/0004-6361/201424653): a linear axis of times in seconds is `TIME`.

use super::card::{Card, ascii, set};
use super::{FitsEncodeError, WcsAxis};
use crate::energies::Energies;
use emitree::EnergyScale;
use fits_well::FitsWriter;
use fits_well::header::Header;
use fits_well::table::{Builder, ColumnData, WriteColumn};
use std::io::Write;

impl Energies {
    /// The coordinates of the bins in joules, or of times in seconds: each pixel's centre is that of its bin, on a
    /// logarithmic axis the geometric mean of its ends.
    ///
    /// Energies in joules, and not in the unit of the scene, because that is what wcslib, and with it astropy,
    /// converts everything to: by an electronvolt of CODATA 2002, wrong by 8·10⁻⁸, and in a way that
    /// spectral-cube can't read.
    ///
    /// ```
    /// use emitree::{EnergyAxis, EnergyScale};
    /// use emitree_io::Energies;
    ///
    /// let axis = EnergyAxis::new(1.0, 3.0, 4, EnergyScale::Linear)?;
    /// let wcs = Energies::new(axis, "J")?.wcs();
    /// assert_eq!((wcs.ctype.as_str(), wcs.crval, wcs.cdelt), ("ENER", 1.25, 0.5));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn wcs(&self) -> WcsAxis {
        let axis = self.axis();
        let bins = super::wcs::count(axis.bins());
        let first = axis.energy(0.5 / bins) * self.in_si();
        let (cname, unit) = if self.is_time() { ("time", "s") } else { ("energy", "J") };
        let (ctype, cdelt) = match axis.scale() {
            EnergyScale::Linear if self.is_time() => ("TIME", (axis.max() - axis.min()) / bins),
            EnergyScale::Linear => ("ENER", (axis.max() - axis.min()) / bins * self.in_si()),
            EnergyScale::Log => ("ENER-LOG", first * (axis.max() / axis.min()).ln() / bins),
        };
        WcsAxis {
            ctype: ctype.to_owned(),
            cunit: Some(unit.to_owned()),
            cname: cname.to_owned(),
            crpix: 1.0,
            crval: first,
            cdelt,
        }
    }
}

/// Adds the table `ENERGIES`: a row for each bin, the lowest first, with its ends `E_MIN` and
/// `E_MAX` in the unit of the scene; of times the table `TIMES` with `T_START` and `T_STOP` in seconds.
pub(crate) fn write_table<W: Write>(
    writer: &mut FitsWriter<W>,
    energies: &Energies,
) -> Result<(), FitsEncodeError> {
    let (unit, factor) = energies.unit().fits();
    let unit = unit.unwrap_or_default();
    let edges: Vec<f64> = energies.axis().edges().iter().map(|edge| edge * factor).collect();
    let ends = |from: usize| ColumnData::F64(edges[from..][..energies.axis().bins()].to_vec());
    let mut header = Header::new();
    let (name, meaning, columns) = match energies.is_time() {
        false => ("ENERGIES", "ends of the energy bins", ["E_MIN", "E_MAX"]),
        true => ("TIMES", "ends of the bins of the time", ["T_START", "T_STOP"]),
    };
    set(&mut header, &Card::new("EXTNAME", name, meaning))?;
    let mut table = Builder::with_rows(energies.axis().bins());
    for (name, from) in columns.into_iter().zip([0, 1]) {
        table.push(WriteColumn::scalar(ascii(name), ends(from)).with_unit(ascii(&unit)))?;
    }
    Ok(writer.write_table(&table, Some(&header))?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use emitree::EnergyAxis;

    fn wcs(bins: usize, scale: EnergyScale) -> WcsAxis {
        let axis = EnergyAxis::new(0.3, 12.0, bins, scale).unwrap();
        Energies::new(axis, "J").unwrap().wcs()
    }

    #[test]
    fn centres_of_pixels_are_those_of_bins() {
        for bins in [1, 2, 7, 64] {
            let axis = EnergyAxis::new(0.3, 12.0, bins, EnergyScale::Linear).unwrap();
            let linear = wcs(bins, EnergyScale::Linear);
            let log = wcs(bins, EnergyScale::Log);
            assert_eq!((&*linear.ctype, &*log.ctype), ("ENER", "ENER-LOG"));
            for (bin, edges) in axis.edges().windows(2).enumerate() {
                let pixel = (bin + 1) as f64;
                let energy = linear.crval + linear.cdelt * (pixel - linear.crpix);
                assert!((energy - 0.5 * (edges[0] + edges[1])).abs() < 1e-13);
                let w = log.cdelt * (pixel - log.crpix);
                let energy = log.crval * (w / log.crval).exp();
                let mean = 0.3 * 40_f64.powf((pixel - 0.5) / bins as f64);
                assert!((energy / mean - 1.0).abs() < 1e-14, "{energy} {mean}");
            }
        }
    }

    #[test]
    fn coordinates_are_in_joules() {
        let axis = EnergyAxis::new(2.0, 4.0, 1, EnergyScale::Linear).unwrap();
        let wcs = Energies::new(axis, "keV").unwrap().wcs();
        assert_eq!(wcs.cunit.as_deref(), Some("J"));
        assert!((wcs.crval / 3.0 / 1.602_176_634e-16 - 1.0).abs() < 1e-15);
        assert!((wcs.cdelt / 2.0 / 1.602_176_634e-16 - 1.0).abs() < 1e-15);
    }
}
