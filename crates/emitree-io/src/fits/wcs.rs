//! World coordinates of the pixels, as FITS keywords. Those of each camera are beside its keys.
//!
//! Greisen & Calabretta 2002 (doi:10.1051/0004-6361:20021326) for the keywords, Calabretta &
//! Greisen 2002 (doi:10.1051/0004-6361:20021327) for spherical coordinates. Pixel (column, row)
//! has its centre at FITS pixel coordinates (column + 1, row + 1) and its edges half a pixel off.

use super::Card;
use super::celestial::Celestial;
use crate::energies::Energies;
use emitree_instrument::Channel;
use serde::{Deserialize, Serialize};

/// World coordinates of an image: data that become header records.
///
/// ```
/// use emitree_io::Wcs;
///
/// // 16 by 27 degrees on 50 x 100 pixels: 0.32 degrees a column, the pointing in the middle.
/// let wcs = Wcs::equirectangular(100, 50, [16.0, 27.0]);
/// assert_eq!((wcs.axes[0].cdelt, wcs.axes[0].crpix), (0.32, 25.5));
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wcs {
    /// What the coordinates are (`WCSNAME`).
    pub name: String,
    /// The axes: x, y, and the energy or the channel of a cube.
    pub axes: Vec<WcsAxis>,
    /// Where the native pole lies \[deg\] (`LONPOLE`, `LATPOLE`); only for spherical coordinates.
    pub pole_deg: Option<[f64; 2]>,
    /// What coordinates of the sky have beside their axes; `None` of others.
    #[serde(default)]
    pub celestial: Option<Celestial>,
}

/// One axis: world = `crval` + `cdelt` · (FITS pixel − `crpix`), before any projection.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WcsAxis {
    /// The type and, after its hyphens, the projection (`CTYPEi`).
    pub ctype: String,
    /// The unit (`CUNITi`), in the grammar of FITS; none for pure numbers.
    pub cunit: Option<String>,
    /// What the axis is, in words (`CNAMEi`); empty where the type says it.
    pub cname: String,
    /// The FITS pixel of the reference point (`CRPIXi`).
    pub crpix: f64,
    /// The coordinate of the reference point (`CRVALi`).
    pub crval: f64,
    /// The step of the coordinate from one pixel to the next (`CDELTi`).
    pub cdelt: f64,
}

impl Wcs {
    /// Longitude and latitude about the pointing by the projection `code`, for an image of
    /// `extent_deg` in the plane of projection.
    pub(crate) fn spherical(
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
            celestial: None,
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
            if !axis.cname.is_empty() {
                cards.push(Card::new(key("CNAME"), &*axis.cname, "name of the coordinate"));
            }
            cards.push(Card::new(key("CRPIX"), axis.crpix, "reference pixel, first centre 1"));
            cards.push(Card::new(key("CRVAL"), axis.crval, "coordinate at the reference pixel"));
            cards.push(Card::new(key("CDELT"), axis.cdelt, "step from pixel to pixel"));
        }
        if let Some(celestial) = &self.celestial {
            cards.extend(celestial.rotation_cards());
            cards.extend(celestial.cards());
        }
        if let Some([longitude, latitude]) = self.pole_deg {
            cards.push(Card::new("LONPOLE", longitude, "[deg] native longitude of the pole"));
            cards.push(Card::new("LATPOLE", latitude, "[deg] latitude of the native pole"));
        }
        cards
    }
}

impl WcsAxis {
    /// The code of the spherical projection whose plane the axis lies on, `TAN` for example; none
    /// where the coordinate itself has uniform steps. (`CAR` is the projection of uniform steps.)
    ///
    /// ```
    /// use emitree_io::Wcs;
    ///
    /// let [flat, angles] = [Wcs::perspective, Wcs::equirectangular];
    /// assert_eq!(flat(8, 8, [9.0, 9.0]).axes[0].plane(), Some("TAN"));
    /// assert_eq!(angles(8, 8, [9.0, 9.0]).axes[0].plane(), None);
    /// ```
    pub fn plane(&self) -> Option<&str> {
        let (_, code) = self.ctype.rsplit_once('-')?;
        let is_angle = self.cunit.as_deref() == Some("deg");
        (is_angle && code != "CAR").then_some(code)
    }

    /// An axis over `extent` with 0 in the middle of the image.
    pub(crate) fn about_the_middle(
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
pub(crate) const AT_THE_POLE: [f64; 2] = [180.0, 0.0];

/// A number of pixels as f64; images have far fewer than 2⁵³ along an edge.
#[expect(clippy::cast_precision_loss, reason = "exact below 2^53")]
pub(crate) fn count(pixels: usize) -> f64 {
    pixels as f64
}
