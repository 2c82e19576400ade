//! Zodiacal light at 25 µm: the DIRBE model of the interplanetary dust, seen from the Earth.
//!
//! The components of [Kelsall et al. 1998](https://doi.org/10.1086/306380) – a smooth cloud, three pairs of
//! bands, the ring along the Earth's orbit and the blob in it that trails the Earth – glow as black bodies
//! at T = 286 K R^−0.467, R the distance from the Sun in AU; at 25 µm all emissivities are 1 and the
//! albedo is 0. It is the scene of ZodiPy's model `dirbe`, whose densities the tests compare with.
//!
//! Positions are heliocentric ecliptic \[AU\], rates \[MJy sr⁻¹ AU⁻¹\], radiances \[MJy sr⁻¹\]. Lines of
//! sight end 5.2 AU from the Sun, where the model ends. The image is hard where the edges of the second
//! pair of bands, two degrees from the ecliptic and some tenths of a degree thin, are seen over the whole
//! width of the view.

mod dust;

use crate::family::Reference;
use crate::gauss::Gauss;
use crate::panels::{self, PanelAxis};
use dust::{Dust, SymmetryPlane};
use emitree::projection::{Bounds, Ellipsoid, GeometryError};
use emitree::{Equirectangular, Image, Viewpoint};

/// Where the Earth, and with it the observer, is \[AU\]: on 14 June 2022 at 0 h, after astropy's
/// built-in ephemeris.
pub const EARTH_AU: [f64; 3] = [-0.129_984_109, -1.007_229_16, 5.215_242e-5];
/// The distance from the Sun at which lines of sight end \[AU\]: that of Jupiter.
pub const END_AU: f64 = 5.2;
/// The full width and height of the view \[rad\]: 60 degrees.
pub const FIELD_OF_VIEW_RAD: f64 = core::f64::consts::FRAC_PI_3;

/// The temperature of dust at 1 AU \[K\] and its power of the distance, after Kelsall et al.
const TEMPERATURE_K: f64 = 286.0;
const COOLING: f64 = 0.466_862_598_614_865_73;
/// h ν/k at 25 µm \[K\], and 2 h ν³/c² there \[MJy sr⁻¹\], from the exact constants of the SI.
const QUANTUM_K: f64 = 575.510_751_001_573_5;
const PLANCK_MJY_PER_SR: f64 = 2.542_650_697_150_628_6e9;

/// Panels of the reference image. Along a line: this far from the observer all is, but for the smooth
/// parts, that needs short panels \[AU\], and how long panels are there and farther out \[AU\].
const NEAR_AU: f64 = 1.6;
const PANEL_AU: [f64; 2] = [0.08, 0.5];
/// Across: panels of latitude are as narrow as the edges of bands are seen within this latitude, and this
/// number of panels is enough elsewhere, and along the longitude.
const EDGES_WITHIN_RAD: f64 = 0.2;
const PANELS: usize = 10;
/// The width of panels of latitude near the ecliptic \[rad\].
const EDGE_RAD: f64 = 0.02;

/// What rounding can do to an image, relative to its largest pixel.
const ROUNDING: f64 = 1e-13;

/// The direction of the pointing along the ecliptic, 90 degrees from the Sun.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Towards {
    /// Where the Earth goes to.
    Apex,
    /// Where the Earth comes from, and with it the blob.
    Antapex,
}

/// The scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zodiacal {
    earth_au: [f64; 3],
    towards: Towards,
    dust: Dust,
}

impl Default for Zodiacal {
    fn default() -> Self {
        Self::new(EARTH_AU, Towards::Antapex)
    }
}

impl Zodiacal {
    /// The view from the Earth at a heliocentric ecliptic position \[AU\].
    pub fn new(earth_au: [f64; 3], towards: Towards) -> Self {
        Self { earth_au, towards, dust: Dust::new(earth_au) }
    }

    /// The view when the Earth is at a heliocentric ecliptic longitude \[rad\], at the distance of
    /// an ellipse of eccentricity 0.0167 whose perihelion is at 103 degrees.
    ///
    /// ```
    /// use emitree_problems::zodiacal::{Towards, Zodiacal};
    ///
    /// let in_summer = Zodiacal::in_season(-1.5, Towards::Apex);
    /// assert_ne!(in_summer, Zodiacal::default());
    /// ```
    pub fn in_season(longitude_rad: f64, towards: Towards) -> Self {
        let distance = 1.0 - 0.0167 * (longitude_rad - 103_f64.to_radians()).cos();
        let (sin, cos) = longitude_rad.sin_cos();
        Self::new([distance * cos, distance * sin, 0.0], towards)
    }

    /// The emission rate \[MJy sr⁻¹ AU⁻¹\] at a heliocentric ecliptic position \[AU\], which is not the
    /// Sun's.
    ///
    /// ```
    /// let zodiacal = emitree_problems::zodiacal::Zodiacal::default();
    /// assert!(zodiacal.rate([1.0, 0.0, 0.0]) > zodiacal.rate([1.0, 0.0, 0.5]));
    /// ```
    pub fn rate(&self, position_au: [f64; 3]) -> f64 {
        let distance = position_au.iter().map(|x| x * x).sum::<f64>().sqrt();
        self.dust.densities(position_au).iter().sum::<f64>() * black_body(distance)
    }

    /// The image of the [camera](Self::camera), in `shape` = \[height, width\] pixels
    /// \[MJy sr⁻¹\], by quadrature, and its error: the difference to a rule with fewer nodes along each
    /// line and across the image.
    ///
    /// ```
    /// let zodiacal = emitree_problems::zodiacal::Zodiacal::default();
    /// assert!(zodiacal.reference_image([2, 3]).error < 1e-5);
    /// ```
    pub fn reference_image(&self, shape: [usize; 2]) -> Reference {
        let (image, coarser) = (self.image(shape, 12, 14), self.image(shape, 9, 10));
        let error = image.max_difference(&coarser) / image.min_max().1 + ROUNDING;
        Reference { image, error }
    }

    /// The camera: an observer at the Earth, pointing 90 degrees from the Sun along the
    /// ecliptic; longitude to the right, latitude upwards.
    ///
    /// # Errors
    ///
    /// [`GeometryError`] never, for these numbers.
    ///
    /// ```
    /// let camera = emitree_problems::zodiacal::Zodiacal::default().camera()?;
    /// # Ok::<(), emitree::projection::GeometryError>(())
    /// ```
    pub fn camera(&self) -> Result<Equirectangular, GeometryError> {
        let [forward, _] = self.axes();
        let target = core::array::from_fn(|i| self.earth_au[i] + forward[i]);
        let viewpoint = Viewpoint { position: self.earth_au, target, up: [0.0, 0.0, 1.0] };
        let end = Ellipsoid::sphere([0.0; 3], END_AU)?;
        // No line is longer than the diameter of what there is.
        let camera = Equirectangular::new(viewpoint, [FIELD_OF_VIEW_RAD; 2], [0.0, 2.0 * END_AU])?;
        Ok(camera.with_bounds(Bounds::Ellipsoid(end)))
    }

    /// Means over pixels: panels of `across` nodes in the image, of `along` nodes on each line.
    fn image(&self, [height, width]: [usize; 2], across: usize, along: usize) -> Image {
        let rule = Gauss::new(along);
        let columns = PanelAxis::new(&equal(0.0, 1.0, PANELS), across, width);
        let rows = PanelAxis::new(&latitude_borders(), across, height);
        let mut image = panels::image(&columns, &rows, |x, y| {
            let latitude_rad = (y - 0.5) * FIELD_OF_VIEW_RAD;
            self.radiance([(x - 0.5) * FIELD_OF_VIEW_RAD, latitude_rad], &rule) * latitude_rad.cos()
        });
        // A pixel is the mean over its solid angle, which is as the cosine of the latitude.
        let sine = |row: usize| ((row as f64 / height as f64 - 0.5) * FIELD_OF_VIEW_RAD).sin();
        for (row, pixels) in image.pixels_mut().chunks_exact_mut(width).enumerate() {
            let mean_cosine = (sine(row + 1) - sine(row)) * height as f64 / FIELD_OF_VIEW_RAD;
            pixels.iter_mut().for_each(|pixel| *pixel /= mean_cosine);
        }
        image
    }

    /// The radiance \[MJy sr⁻¹\] at a longitude and a latitude about the pointing \[rad\].
    fn radiance(&self, [longitude_rad, latitude_rad]: [f64; 2], rule: &Gauss) -> f64 {
        let (sin_lon, cos_lon) = longitude_rad.sin_cos();
        let (sin_lat, cos_lat) = latitude_rad.sin_cos();
        let [forward, right] = self.axes();
        let direction: [f64; 3] = core::array::from_fn(|i| {
            cos_lat * (cos_lon * forward[i] + sin_lon * right[i])
                + if i == 2 { sin_lat } else { 0.0 }
        });
        let rate =
            |s: f64| self.rate(core::array::from_fn(|i| self.earth_au[i] + s * direction[i]));
        let borders = self.line_borders(direction);
        borders.windows(2).map(|ends| rule.integrate(ends[0], ends[1], rate)).sum()
    }

    /// The distances between which g is smooth on a line, and panels short enough for it \[AU\].
    fn line_borders(&self, direction: [f64; 3]) -> Vec<f64> {
        let Dust { cloud, bands, rings } = &self.dust;
        let end = self.sphere_crossings(direction, END_AU)[1];
        let near = end.min(NEAR_AU);
        let mut borders = equal(0.0, near, panels(near / PANEL_AU[0]));
        borders.extend(equal(near, end, panels((end - near) / PANEL_AU[1])));
        // g has kinks in the planes of the cloud, of the ring and of the blob, and the cloud's profile
        // changes its formula on a cone.
        borders.extend(self.cone_crossings(&cloud.plane, direction, 0.0));
        borders.extend(self.cone_crossings(&cloud.plane, direction, cloud.mu));
        borders.extend(self.cone_crossings(&rings[0].plane, direction, 0.0));
        // The ring and the inner edges of the bands are thin.
        for ring in rings {
            let radii = [-2.0, 0.0, 2.0].map(|widths| ring.radius + widths * ring.radial_width);
            borders.extend(radii.map(|radius| self.sphere_crossings(direction, radius)).concat());
        }
        for band in bands {
            borders.extend(self.sphere_crossings(direction, band.onset));
        }
        borders.retain(|&s| (0.0..=end).contains(&s));
        borders.sort_by(f64::total_cmp);
        borders
    }

    /// Forward and right of the camera; north is up.
    fn axes(&self) -> [[f64; 3]; 2] {
        let [x, y, _] = self.earth_au;
        // The Earth moves towards (−y, x).
        let scale = match self.towards {
            Towards::Apex => -1.0 / x.hypot(y),
            Towards::Antapex => 1.0 / x.hypot(y),
        };
        let forward = [scale * y, -scale * x, 0.0];
        [forward, [forward[1], -forward[0], 0.0]]
    }

    /// Where a line crosses a sphere about the Sun; what there is not is NaN \[AU\].
    fn sphere_crossings(&self, direction: [f64; 3], radius: f64) -> [f64; 2] {
        let earth = self.earth_au;
        let half = dot(earth, direction);
        let root = (half * half - dot(earth, earth) + radius * radius).sqrt();
        [-half - root, -half + root]
    }

    /// Where a line crosses the double cone of the points whose height above a plane is ± `zeta` times
    /// their distance from its centre; what there is not is NaN \[AU\].
    fn cone_crossings(&self, plane: &SymmetryPlane, direction: [f64; 3], zeta: f64) -> [f64; 2] {
        let from = core::array::from_fn(|i| self.earth_au[i] - plane.centre[i]);
        let (start, slope) = (dot(from, plane.normal), dot(direction, plane.normal));
        if zeta == 0.0 {
            return [-start / slope; 2];
        }
        // (start + s slope)² = ζ² |from + s direction|².
        let square = slope * slope - zeta * zeta;
        let half = start * slope - zeta * zeta * dot(from, direction);
        let constant = start * start - zeta * zeta * dot(from, from);
        let root = (half * half - square * constant).sqrt();
        [(-half - root) / square, (-half + root) / square]
    }
}

/// The radiance of a black body at 25 µm as warm as dust at this distance from the Sun \[MJy sr⁻¹\].
fn black_body(distance_au: f64) -> f64 {
    let temperature_k = TEMPERATURE_K * distance_au.powf(-COOLING);
    PLANCK_MJY_PER_SR / (QUANTUM_K / temperature_k).exp_m1()
}

/// The panels that so many lengths of one need.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "panels are few")]
fn panels(lengths: f64) -> usize {
    lengths.ceil() as usize
}

/// `count` equal parts, at least one.
fn equal(from: f64, to: f64, count: usize) -> Vec<f64> {
    let count = count.max(1);
    (0..=count).map(|i| from + (to - from) * i as f64 / count as f64).collect()
}

/// The borders of the panels of latitude, on \[0, 1\].
fn latitude_borders() -> Vec<f64> {
    let of_latitude = |latitude_rad: f64| 0.5 + latitude_rad / FIELD_OF_VIEW_RAD;
    let (low, high) = (of_latitude(-EDGES_WITHIN_RAD), of_latitude(EDGES_WITHIN_RAD));
    let mut borders = equal(0.0, low, PANELS / 2);
    borders.pop();
    borders.extend(equal(low, high, panels(2.0 * EDGES_WITHIN_RAD / EDGE_RAD)));
    borders.pop();
    borders.extend(equal(high, 1.0, PANELS / 2));
    borders
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use emitree::Projection;

    /// ZodiPy 1.1.5: `number_density.get_partial_number_density_func(component_params.DIRBE)` with the
    /// Earth at [`EARTH_AU`]; cloud, bands, ring, blob [AU⁻¹].
    #[test]
    fn densities_are_those_of_zodipy() {
        let rows: [([f64; 3], [f64; 6]); 5] = [
            (
                [-0.5, 0.9, 0.01],
                [
                    1.086_762_995_081e-7,
                    8.776_300_864_779e-13,
                    5.840_910_033_371e-9,
                    2.256_448_881_011e-13,
                    1.776_655_002_478e-8,
                    0.0,
                ],
            ),
            (
                [-1.3, 1.1, 0.05],
                [
                    5.539_522_803_402e-8,
                    9.875_231_249_169e-10,
                    3.521_303_335_285e-9,
                    2.531_340_340_535e-10,
                    0.0,
                    0.0,
                ],
            ),
            (
                [-0.35, -1.0, -0.02],
                [
                    1.030_321_483_337e-7,
                    1.520_679_391_833e-12,
                    5.630_696_681_048e-9,
                    3.900_746_966_249e-13,
                    2.927_538_402_463e-9,
                    1.693_824_454_765e-8,
                ],
            ),
            (
                [2.0, 3.0, 0.2],
                [
                    1.913_208_682_146e-8,
                    5.665_374_443_911e-10,
                    2.945_402_559_121e-11,
                    1.263_889_326_082e-10,
                    0.0,
                    0.0,
                ],
            ),
            (
                [0.1, -0.9, 0.3],
                [
                    4.236_969_591_053e-8,
                    0.0,
                    0.0,
                    9.410_391_747_268e-14,
                    9.146_030_693_424e-15,
                    5.475_458_441_373e-12,
                ],
            ),
        ];
        let zodiacal = Zodiacal::default();
        for (position, expected) in rows {
            let found = zodiacal.dust.densities(position);
            for (found, expected) in found.into_iter().zip(expected) {
                let far = (found - expected).abs();
                assert!(far <= 1e-11 * expected + 1e-30, "{position:?}: {found:e} {expected:e}");
            }
        }
    }

    /// Lines by the midpoint rule, with no borders known, at some places of the image.
    #[test]
    fn radiances_agree_with_many_samples_of_the_rate() {
        const STEPS: u32 = 200_000;
        let zodiacal = Zodiacal::default();
        let camera = zodiacal.camera().unwrap();
        let rule = Gauss::new(14);
        for [x, y] in [[0.5, 0.5], [0.1, 0.53], [0.9, 0.2], [0.3, 0.46]] {
            let of_camera = |i: u32| {
                let point =
                    camera.world_from_canonical([x, y, (f64::from(i) + 0.5) / f64::from(STEPS)]);
                point.path_per_depth * zodiacal.rate(point.position)
            };
            let brute = (0..STEPS).map(of_camera).sum::<f64>() / f64::from(STEPS);
            let angles = [x, y].map(|t| (t - 0.5) * FIELD_OF_VIEW_RAD);
            let found = zodiacal.radiance(angles, &rule);
            assert!((found / brute - 1.0).abs() < 1e-7, "{x} {y}: {found} {brute}");
        }
    }

    /// Pixels as means of many lines by the camera, whose code the reference does not share.
    #[test]
    fn the_reference_is_within_its_error() {
        const LINES: u32 = 16;
        let zodiacal = Zodiacal::default();
        let shape = [60, 60];
        let reference = zodiacal.reference_image(shape);
        assert!(reference.error < 3e-5, "{:e}", reference.error);
        let rule = Gauss::new(14);
        let (_, largest) = reference.image.min_max();
        for at in [[31, 3], [33, 40], [29, 58], [5, 20]] {
            let [row, column] = at.map(|k| f64::from(u32::try_from(k).unwrap()));
            let place = |k: u32, border: f64| {
                (((f64::from(k) + 0.5) / f64::from(LINES) + border) / 60.0 - 0.5)
                    * FIELD_OF_VIEW_RAD
            };
            let (mut sum, mut weights) = (0.0, 0.0);
            for k in 0..LINES * LINES {
                let latitude_rad = place(k / LINES, row);
                sum += latitude_rad.cos()
                    * zodiacal.radiance([place(k % LINES, column), latitude_rad], &rule);
                weights += latitude_rad.cos();
            }
            let far = (sum / weights - reference.image[at.into()]).abs() / largest;
            assert!(far < 1e-4, "{at:?}: {far:e}");
        }
    }
}
