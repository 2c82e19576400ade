//! World coordinates of the pixels, as FITS keywords.
//!
//! Greisen & Calabretta 2002 (doi:10.1051/0004-6361:20021326) for the keywords, Calabretta &
//! Greisen 2002 (doi:10.1051/0004-6361:20021327) for spherical coordinates. Pixel (column, row)
//! has its centre at FITS pixel coordinates (column + 1, row + 1) and its edges half a pixel off.

use super::Card;

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
    /// The axes, x then y.
    pub axes: [WcsAxis; 2],
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
            axes: [axis("x", width), axis("y", height)],
            pole_deg: None,
        }
    }

    /// Longitude and latitude about the pointing in equal steps, the projection CAR, for a field
    /// of view of `fov_deg` = \[width, height\] \[deg\].
    ///
    /// At the canonical point (x, y) they are ((x − ½) · width, (y − ½) · height), longitudes
    /// modulo 360°. The axes are called `XLON` and `XLAT`: FITS reserves the first letter for
    /// systems such as `G` (galactic), and `RA`/`DEC` would claim a place on the sky that an image
    /// about a pointing does not have. The native coordinates are the world coordinates, which
    /// `LONPOLE` = 0 and `LATPOLE` = 90 with a reference point on the equator say. `CDELT1` is
    /// positive because longitude grows to the right here, unlike right ascension.
    pub fn equirectangular(height: usize, width: usize, fov_deg: [f64; 2]) -> Self {
        let axis = |ctype: &str, name: &str, pixels, extent_deg: f64| WcsAxis {
            ctype: ctype.to_owned(),
            cunit: Some("deg".to_owned()),
            cname: format!("{name} about the pointing"),
            crpix: 0.5 * (count(pixels) + 1.0),
            crval: 0.0,
            cdelt: extent_deg / count(pixels),
        };
        Self {
            name: "equirectangular".to_owned(),
            axes: [
                axis("XLON-CAR", "longitude", width, fov_deg[0]),
                axis("XLAT-CAR", "latitude", height, fov_deg[1]),
            ],
            pole_deg: Some([0.0, 90.0]),
        }
    }

    /// The header records, in the order of the standard.
    pub(super) fn cards(&self) -> Vec<Card> {
        let mut cards = vec![
            Card::new("WCSAXES", 2, "number of coordinate axes"),
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

/// A number of pixels as f64; images have far fewer than 2⁵³ along an edge.
#[expect(clippy::cast_precision_loss, reason = "exact below 2^53")]
fn count(pixels: usize) -> f64 {
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
}
