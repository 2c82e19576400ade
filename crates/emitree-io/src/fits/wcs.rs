//! World coordinates of the pixels, as FITS keywords.
//!
//! Greisen & Calabretta 2002 (doi:10.1051/0004-6361:20021326) for the keywords, Calabretta &
//! Greisen 2002 (doi:10.1051/0004-6361:20021327) for spherical coordinates. Pixel (column, row)
//! has its centre at FITS pixel coordinates (column + 1, row + 1) and its edges half a pixel off.

use super::Card;
use crate::energies::Energies;
use crate::units::Unit;
use emitree_instrument::Channel;

/// World coordinates of an image: data that become header records.
///
/// ```
/// use emitree_io::Wcs;
///
/// // 16 by 27 degrees on 50 x 100 pixels: 0.32 degrees a column, the pointing in the middle.
/// let wcs = Wcs::equirectangular(100, 50, [16.0, 27.0]);
/// assert_eq!((wcs.axes[0].cdelt, wcs.axes[0].crpix), (0.32, 25.5));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Wcs {
    /// What the coordinates are (`WCSNAME`).
    pub name: String,
    /// The axes: x, y, and the energy or the channel of a cube.
    pub axes: Vec<WcsAxis>,
    /// Where the native pole lies \[deg\] (`LONPOLE`, `LATPOLE`); only for spherical coordinates.
    pub pole_deg: Option<[f64; 2]>,
}

/// One axis: world = `crval` + `cdelt` · (FITS pixel − `crpix`), before any projection.
#[derive(Clone, Debug, PartialEq)]
pub struct WcsAxis {
    /// The type and, after its hyphens, the projection (`CTYPEi`).
    pub ctype: String,
    /// The unit (`CUNITi`), in the grammar of FITS; none for pure numbers.
    pub cunit: Option<String>,
    /// What the axis is, in words (`CNAMEi`).
    pub cname: String,
    /// The FITS pixel of the reference point (`CRPIXi`).
    pub crpix: f64,
    /// The coordinate of the reference point (`CRVALi`).
    pub crval: f64,
    /// The step of the coordinate from one pixel to the next (`CDELTi`).
    pub cdelt: f64,
}

impl Wcs {
    /// Canonical coordinates: x and y go linearly from 0 to 1 across the image.
    ///
    /// The lower left corner of pixel (row 0, column 0), FITS pixel (½, ½), is (0, 0).
    pub fn canonical(height: usize, width: usize) -> Self {
        let axis = |name: &str, pixels| WcsAxis {
            ctype: name.to_uppercase(),
            cunit: None,
            cname: format!("canonical {name}"),
            crpix: 0.5,
            crval: 0.0,
            cdelt: 1.0 / count(pixels),
        };
        Self {
            name: "canonical".to_owned(),
            axes: vec![axis("x", width), axis("y", height)],
            pole_deg: None,
        }
    }

    /// Lengths on the image plane of parallel rays, linear and about the middle, for an image of
    /// `extent` = \[width, height\] in `unit`.
    ///
    /// At the canonical point (x, y) they are ((x − ½) · width, (y − ½) · height): x to the right, y
    /// up. A unit that FITS lacks, the radius of a planet, becomes kilometres; pure numbers have
    /// none.
    ///
    /// ```
    /// use emitree_io::{Wcs, units::Unit};
    ///
    /// let wcs = Wcs::orthographic(100, 50, [50.0, 100.0], &Unit::parse("R_E")?);
    /// assert_eq!((wcs.axes[0].cunit.as_deref(), wcs.axes[0].cdelt), (Some("km"), 6371.0));
    /// # Ok::<(), emitree_io::units::UnitError>(())
    /// ```
    pub fn orthographic(height: usize, width: usize, extent: [f64; 2], unit: &Unit) -> Self {
        let (cunit, factor) = unit.fits();
        let axis = |ctype: &str, name: &str, pixels, extent: f64| {
            WcsAxis::about_the_middle(ctype, name, pixels, extent * factor, cunit.as_deref())
        };
        Self {
            name: "orthographic".to_owned(),
            axes: vec![
                axis("X", "x on the image plane", width, extent[0]),
                axis("Y", "y on the image plane", height, extent[1]),
            ],
            pole_deg: None,
        }
    }

    /// Longitude and latitude about the pointing in uniform steps, the projection CAR, for a field
    /// of view of `fov_deg` = \[width, height\] \[deg\].
    ///
    /// At the canonical point (x, y) they are ((x − ½) · width, (y − ½) · height), longitudes
    /// modulo 360°. The axes are called `XLON` and `XLAT`: FITS reserves the first letter for
    /// systems such as `G` (galactic), and `RA`/`DEC` would claim a place on the sky that an image
    /// about a pointing does not have. The native coordinates are the world coordinates, which
    /// `LONPOLE` = 0 and `LATPOLE` = 90 with a reference point on the equator say. `CDELT1` is
    /// positive because longitude grows to the right here, unlike right ascension.
    pub fn equirectangular(height: usize, width: usize, fov_deg: [f64; 2]) -> Self {
        Self::spherical("equirectangular", "CAR", [height, width], fov_deg, [0.0, 90.0])
    }

    /// Longitude and latitude about the pointing on a plane behind a pinhole, the projection TAN,
    /// for a field of view of `fov_deg` = \[width, height\] \[deg\], both below 180.
    ///
    /// The canonical point (x, y) is at ((2x − 1) tan(width/2), (2y − 1) tan(height/2)) on the
    /// plane at distance 1. As for all cameras with a pointing, the world coordinates of a sight
    /// with components (right, up, forward) are the longitude atan2(right, forward) and the
    /// latitude asin(up), \(0, 0\) in the middle. The middle is the native pole here (Calabretta &
    /// Greisen, section 5.1), and `LONPOLE` = 180 has latitude grow upwards and, with a positive
    /// `CDELT1`, longitude to the right (their eqs. 2, 12 and 13).
    ///
    /// ```
    /// use emitree_io::Wcs;
    ///
    /// let wcs = Wcs::perspective(100, 200, [90.0, 60.0]);
    /// assert_eq!(wcs.axes[0].ctype, "XLON-TAN");
    /// assert!((wcs.axes[0].cdelt - 1_f64.to_degrees() / 100.0).abs() < 1e-15); // tan 45° = 1
    /// ```
    pub fn perspective(height: usize, width: usize, fov_deg: [f64; 2]) -> Self {
        let on_plane = |fov_deg: f64| 2.0 * (0.5 * fov_deg).to_radians().tan().to_degrees();
        let extent_deg = fov_deg.map(on_plane);
        Self::spherical("perspective", "TAN", [height, width], extent_deg, AT_THE_POLE)
    }

    /// Longitude and latitude about the pointing in a disc, for a field of view of `fov_deg` across
    /// \[deg\], up to 360.
    ///
    /// The disc's radius on the canonical image is ½. At the distance ϱ from its middle the sight is
    /// at the angle ϑ from the pointing: ϑ = ϱ · fov, the projection ARC, or with `equal_area`
    /// sin(ϑ/2) = 2ϱ sin(fov/4), the projection ZEA. World coordinates and signs are those of
    /// [`perspective`](Self::perspective).
    ///
    /// ```
    /// use emitree_io::Wcs;
    ///
    /// let wcs = Wcs::fisheye(100, 100, 180.0, false);
    /// assert_eq!((wcs.axes[0].ctype.as_str(), wcs.axes[0].cdelt), ("XLON-ARC", 1.8));
    /// ```
    pub fn fisheye(height: usize, width: usize, fov_deg: f64, equal_area: bool) -> Self {
        let (code, across_deg) = if equal_area {
            ("ZEA", 4.0 * (0.25 * fov_deg).to_radians().sin().to_degrees())
        } else {
            ("ARC", fov_deg)
        };
        Self::spherical("fisheye", code, [height, width], [across_deg; 2], AT_THE_POLE)
    }

    /// Azimuth about the pointing and angle from it, linear, for a field of view of `fov_deg` across
    /// \[deg\], up to 360.
    ///
    /// At the canonical point (x, y) the azimuth is x · 360° and the angle y · fov/2. Linear axes and
    /// no spherical ones: FITS has no latitude that falls from 90° at the lower edge, and a reader
    /// would take it for one of the sky.
    pub fn polar(height: usize, width: usize, fov_deg: f64) -> Self {
        let axis = |ctype: &str, name: &str, pixels, extent_deg: f64| WcsAxis {
            crpix: 0.5,
            ..WcsAxis::about_the_middle(ctype, name, pixels, extent_deg, Some("deg"))
        };
        Self {
            name: "polar".to_owned(),
            axes: vec![
                axis("AZIMUTH", "azimuth about the pointing", width, 360.0),
                axis("ANGLE", "angle from the pointing", height, 0.5 * fov_deg),
            ],
            pole_deg: None,
        }
    }

    /// Longitude and latitude about the pointing by the projection `code`, for an image of
    /// `extent_deg` in the plane of projection.
    fn spherical(
        name: &str,
        code: &str,
        [height, width]: [usize; 2],
        extent_deg: [f64; 2],
        pole_deg: [f64; 2],
    ) -> Self {
        let axis = |letters: &str, name: &str, pixels, extent_deg| {
            let (ctype, name) = (format!("{letters}-{code}"), format!("{name} about the pointing"));
            WcsAxis::about_the_middle(&ctype, &name, pixels, extent_deg, Some("deg"))
        };
        Self {
            name: name.to_owned(),
            axes: vec![
                axis("XLON", "longitude", width, extent_deg[0]),
                axis("XLAT", "latitude", height, extent_deg[1]),
            ],
            pole_deg: Some(pole_deg),
        }
    }

    /// The coordinates of a cube of such images, one for each energy bin.
    ///
    /// ```
    /// use emitree::{EnergyAxis, EnergyScale};
    /// use emitree_io::{Energies, Wcs};
    ///
    /// let axis = EnergyAxis::new(0.5, 8.0, 4, EnergyScale::Log)?;
    /// let wcs = Wcs::canonical(32, 64).with_energies(&Energies::new(axis, "keV")?);
    /// assert_eq!(wcs.axes[2].ctype, "ENER-LOG");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn with_energies(mut self, energies: &Energies) -> Self {
        self.axes.push(energies.wcs());
        self
    }

    /// The coordinates of a cube of such images, one for each channel: its number, where numbers are
    /// uniform, else the rows of the table `EBOUNDS`, from 1.
    ///
    /// ```
    /// use emitree_instrument::Channel;
    /// use emitree_io::Wcs;
    ///
    /// let channels = [20, 21, 22].map(|number| Channel { number, range_kev: [0.5, 1.0] });
    /// let axis = &Wcs::canonical(32, 64).with_channels(&channels).axes[2];
    /// assert_eq!((axis.ctype.as_str(), axis.crval, axis.cdelt), ("CHANNEL", 20.0, 1.0));
    /// ```
    #[must_use]
    pub fn with_channels(mut self, channels: &[Channel]) -> Self {
        self.axes.push(super::channels::axis(channels));
        self
    }

    /// The header records, in the order of the standard.
    pub(super) fn cards(&self) -> Vec<Card> {
        let mut cards = vec![
            Card::new("WCSAXES", self.axes.len(), "number of coordinate axes"),
            Card::new("WCSNAME", &*self.name, "projection"),
        ];
        for (axis, number) in self.axes.iter().zip(1..) {
            let key = |root: &str| format!("{root}{number}");
            cards.push(Card::new(key("CTYPE"), &*axis.ctype, "type of the coordinate"));
            if let Some(unit) = &axis.cunit {
                cards.push(Card::new(key("CUNIT"), &**unit, "unit of the coordinate"));
            }
            cards.push(Card::new(key("CNAME"), &*axis.cname, "name of the coordinate"));
            cards.push(Card::new(key("CRPIX"), axis.crpix, "reference pixel, first centre 1"));
            cards.push(Card::new(key("CRVAL"), axis.crval, "coordinate at the reference pixel"));
            cards.push(Card::new(key("CDELT"), axis.cdelt, "step from pixel to pixel"));
        }
        if let Some([longitude, latitude]) = self.pole_deg {
            cards.push(Card::new("LONPOLE", longitude, "[deg] native longitude of the pole"));
            cards.push(Card::new("LATPOLE", latitude, "[deg] latitude of the native pole"));
        }
        cards
    }
}

impl WcsAxis {
    /// An axis over `extent` with 0 in the middle of the image.
    fn about_the_middle(
        ctype: &str,
        cname: &str,
        pixels: usize,
        extent: f64,
        cunit: Option<&str>,
    ) -> Self {
        Self {
            ctype: ctype.to_owned(),
            cunit: cunit.map(ToOwned::to_owned),
            cname: cname.to_owned(),
            crpix: 0.5 * (count(pixels) + 1.0),
            crval: 0.0,
            cdelt: extent / count(pixels),
        }
    }
}

/// `LONPOLE` and `LATPOLE` where the reference point on the equator is the native pole.
const AT_THE_POLE: [f64; 2] = [180.0, 0.0];

/// A number of pixels as f64; images have far fewer than 2⁵³ along an edge.
#[expect(clippy::cast_precision_loss, reason = "exact below 2^53")]
pub(super) fn count(pixels: usize) -> f64 {
    pixels as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn world(axis: &WcsAxis, pixel: f64) -> f64 {
        axis.crval + axis.cdelt * (pixel - axis.crpix)
    }

    #[test]
    fn corners_of_the_canonical_image_are_zero_and_one() {
        let wcs = Wcs::canonical(3, 7);
        for (axis, pixels) in wcs.axes.iter().zip([7.0, 3.0]) {
            assert!(world(axis, 0.5).abs() < 1e-15);
            assert!((world(axis, pixels + 0.5) - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn edges_of_the_equirectangular_image_are_half_the_field_of_view() {
        let wcs = Wcs::equirectangular(100, 50, [16.0, 27.0]);
        for (axis, (pixels, extent)) in wcs.axes.iter().zip([(50.0, 16.0), (100.0, 27.0)]) {
            assert!((world(axis, 0.5) + extent / 2.0).abs() < 1e-14);
            assert!((world(axis, pixels + 0.5) - extent / 2.0).abs() < 1e-14);
        }
    }

    #[test]
    fn edges_of_a_perspective_image_are_tangents() {
        let wcs = Wcs::perspective(60, 100, [100.0, 60.0]);
        for (axis, (pixels, half_fov_deg)) in wcs.axes.iter().zip([(100.0, 50.0_f64), (60.0, 30.0)])
        {
            let tangent = world(axis, pixels + 0.5).to_radians();
            assert!((tangent - half_fov_deg.to_radians().tan()).abs() < 1e-15);
            assert!((world(axis, 0.5).to_radians() + tangent).abs() < 1e-15);
        }
    }

    #[test]
    fn the_rim_of_a_fisheye_is_at_half_the_field_of_view() {
        for (fov_deg, radius_deg) in
            [(180.0, 2_f64.sqrt().to_degrees()), (360.0, 2_f64.to_degrees())]
        {
            let wcs = Wcs::fisheye(40, 30, fov_deg, true);
            for (axis, pixels) in wcs.axes.iter().zip([30.0, 40.0]) {
                assert!((world(axis, pixels + 0.5) - radius_deg).abs() < 1e-13);
            }
        }
        let wcs = Wcs::fisheye(40, 30, 220.0, false);
        assert!((world(&wcs.axes[1], 40.5) - 110.0).abs() < 1e-13);
    }

    #[test]
    fn polar_axes_start_at_zero() {
        let wcs = Wcs::polar(40, 30, 220.0);
        for (axis, (pixels, end)) in wcs.axes.iter().zip([(30.0, 360.0), (40.0, 110.0)]) {
            assert!(world(axis, 0.5).abs() < 1e-13);
            assert!((world(axis, pixels + 0.5) - end).abs() < 1e-13);
        }
    }

    #[test]
    fn pure_numbers_have_no_unit() {
        let wcs = Wcs::orthographic(10, 10, [2.0, 2.0], &Unit::one());
        assert_eq!(wcs.axes[1].cunit, None);
        assert!((world(&wcs.axes[1], 10.5) - 1.0).abs() < 1e-15);
    }
}
