//! Writes sample files for the tests under `tests/astropy`: `write_samples FOLDER`.
//!
//! The image is asymmetric, row · 1000 + column + ¼, so that no flip or transposition passes.

mod cubes;
mod views;

use emitree::Image;
use emitree::projection::healpix::{face_pixel, pixel_of_direction, sight_of_face};
use emitree_io::units::{Unit, image_unit};
use emitree_io::{
    Card, East, FitsFile, FitsImage, HealpixColumn, HealpixFile, OutputFile, PictureOptions, Wcs,
    encode_npy, encode_npy_image, encode_png, mollweide,
};
use std::error::Error;
use std::path::PathBuf;
use std::time::{Duration, UNIX_EPOCH};

const HEIGHT: usize = 7;
const WIDTH: usize = 5;

/// A scene with what is hard to keep: a line beyond one record, letters beyond ASCII, an empty
/// line, a tab.
const SCENE: &str = "# Röntgen image of the magnetosheath, 30 R⊕ away
[emission]
expression = \"exp(-a*((x-0.5)^2 + (y-0.5)^2 + (z-0.5)^2)) + exp(-a*((x-0.25)^2 + (y-0.5)^2 + (z-0.5)^2))\"

[projection]
type = \"equirectangular\"\t# equal angles
";

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).ok_or("expected a folder for the samples")?;
    let folder = PathBuf::from(folder);
    let write = |name: &str, bytes: Vec<u8>| OutputFile::create(folder.join(name))?.commit(&bytes);

    let pixels = (0_u16..7).flat_map(|row| {
        (0_u16..5).map(move |column| f64::from(row) * 1000.0 + f64::from(column) + 0.25)
    });
    let image = Image::from_pixels(HEIGHT, WIDTH, pixels.collect());
    let mut error = image.clone();
    error.pixels_mut().iter_mut().for_each(|pixel| *pixel *= -0.001);
    error[(1, 2)] = f64::NAN;
    error[(2, 2)] = f64::INFINITY;
    let counts = Image::from_pixels(1, 3, vec![1.0, 2.0, 3.0]);

    let file = |wcs| FitsFile {
        primary: FitsImage::new("RADIANCE", &image, Some("m-2 sr-1 s-1")),
        extensions: vec![
            FitsImage::new("ERROR", &error, Some("m-2 sr-1 s-1")),
            FitsImage::new("EVALUATIONS", &counts, None),
        ],
        wcs: Some(wcs),
        energies: None,
        provenance: vec![
            Card::new("METHOD", "vol", "how the image was computed"),
            Card::new("TOL", 0.1 + 0.2, "tolerance, relative to the largest pixel"),
            Card::new("ESTERR", f64::INFINITY, "estimated error, relative to the largest pixel"),
            Card::new("NEVAL", 4066, "evaluations of the emission rate"),
            Card::new("CONVERGD", true, "the tolerance was met"),
            Card::new("SCENE", format!("scenes/{}'s.toml", "long/".repeat(30)), "scene file"),
            Card::new("MODEL", "Jørgensen & Holmström", "emission model"),
        ],
        history: SCENE.to_owned(),
        date: Some(UNIX_EPOCH + Duration::from_secs(1_795_228_200)),
    };
    write("canonical.fits", file(Wcs::canonical(HEIGHT, WIDTH)).encode()?)?;
    for (name, wcs) in cameras()? {
        write(&format!("{name}.fits"), file(wcs).encode()?)?;
    }
    write("units.fits", units_file()?)?;
    write("healpix.fits", healpix_file()?)?;
    for (name, bytes) in views::files()?.into_iter().chain(views::sky()?).chain(cubes::files()?) {
        write(&name, bytes)?;
    }

    write("image.npy", encode_npy_image(&image))?;
    write("error.npy", encode_npy_image(&error))?;
    write("cube.npy", encode_npy(&[HEIGHT, 1, WIDTH], image.pixels())?)?;
    let options = PictureOptions { title: Some("sample".to_owned()), ..PictureOptions::default() };
    write("image.png", encode_png(&image, &options)?)?;
    let options = PictureOptions { blank_outside: true, ..PictureOptions::default() };
    write("mollweide.png", encode_png(&sky_picture(), &options)?)?;
    Ok(())
}

/// The coordinates of each camera; `conftest.py` has the same fields of view.
fn cameras() -> Result<Vec<(&'static str, Wcs)>, Box<dyn Error>> {
    let earth_radii = Unit::parse("R_E")?;
    let of_name = |(name, wcs): (&'static str, fn() -> Wcs)| (name, wcs());
    let mut cameras: Vec<_> = [
        ("narrow", (|| Wcs::equirectangular(HEIGHT, WIDTH, [16.0, 27.0])) as fn() -> Wcs),
        ("all_sky", || Wcs::equirectangular(HEIGHT, WIDTH, [360.0, 180.0])),
        ("perspective", || Wcs::perspective(HEIGHT, WIDTH, [100.0, 60.0])),
        ("fisheye_arc", || Wcs::fisheye(HEIGHT, WIDTH, 200.0, false)),
        ("fisheye_arc_360", || Wcs::fisheye(HEIGHT, WIDTH, 360.0, false)),
        ("fisheye_zea", || Wcs::fisheye(HEIGHT, WIDTH, 150.0, true)),
        ("fisheye_zea_360", || Wcs::fisheye(HEIGHT, WIDTH, 360.0, true)),
        ("polar", || Wcs::polar(HEIGHT, WIDTH, 140.0)),
    ]
    .map(of_name)
    .into();
    cameras.push(("orthographic", Wcs::orthographic(HEIGHT, WIDTH, [20.0, 35.0], &earth_radii)));
    Ok(cameras)
}

/// An image for each unit, its only pixel the factor from the rate's unit times the length's, its
/// name the two.
fn units_file() -> Result<Vec<u8>, Box<dyn Error>> {
    let mut images = Vec::new();
    for (rate, length) in UNITS {
        let (unit, factor) = image_unit(&Unit::parse(rate)?, &Unit::parse(length)?)?;
        images.push((format!("{rate} x {length}"), Image::from_pixels(1, 1, vec![factor]), unit));
    }
    let texts: Vec<_> = images.iter().map(|(_, _, unit)| unit.fits().0).collect();
    let pairs = images.iter().zip(&texts);
    let mut extensions =
        pairs.map(|((name, image, _), unit)| FitsImage::new(name, image, unit.as_deref()));
    let primary = extensions.next().ok_or("no units")?;
    let extensions = extensions.collect();
    let (provenance, history) = (Vec::new(), String::new());
    let (wcs, energies, date) = (None, None, None);
    Ok(FitsFile { primary, extensions, wcs, energies, provenance, history, date }.encode()?)
}

/// Rates and lengths that make units of all kinds.
const UNITS: [(&str, &str); 12] = [
    ("cm-3 s-1 sr-1", "AU"),
    ("keV cm-3 s-1 sr-1", "R_sun"),
    ("ph/(cm3 s sr)", "km"),
    ("erg cm-3 s-1 Angstrom-1", "Mpc"),
    ("R / km", "m"),
    ("kR km-1", "lyr"),
    ("10**6 ph m-3 h-1 arcsec-2", "pc"),
    ("W m-3 deg-2", "kpc"),
    ("2.5 count cm-3 d-1", "um"),
    ("MJy sr-1 kpc-1", "pc"),
    ("1", "AU"),
    ("m-1", "nm"),
];

/// A map whose first column has the components of the pixels' own centres, weighed 1, 10 and 100,
/// and whose second has the pixels' numbers.
fn healpix_file() -> Result<Vec<u8>, Box<dyn Error>> {
    let numbers: Vec<f64> = (0..12 * NSIDE * NSIDE).map(f64::from).collect();
    let centres: Vec<f64> =
        (0..12 * u64::from(NSIDE * NSIDE)).map(|index| weigh(centre(index))).collect();
    let file = HealpixFile {
        columns: vec![
            HealpixColumn { name: "RADIANCE", unit: Some("ph cm-2 s-1 sr-1"), values: &centres },
            HealpixColumn { name: "NUMBER", unit: None, values: &numbers },
        ],
        coordinates: None,
        energies: None,
        provenance: vec![Card::new("METHOD", "vol", "how the map was computed")],
        history: SCENE.to_owned(),
        date: Some(UNIX_EPOCH + Duration::from_secs(1_795_228_200)),
    };
    Ok(file.encode()?)
}

const NSIDE: u32 = 8;

/// The direction of the centre of a pixel.
fn centre(index: u64) -> [f64; 3] {
    let (face, x, y) = face_pixel(NSIDE, index);
    sight_of_face(face, [x, y].map(|pixel| (f64::from(pixel) + 0.5) / f64::from(NSIDE)))
}

fn weigh([x, y, z]: [f64; 3]) -> f64 {
    x + 10.0 * y + 100.0 * z
}

/// The same map as an ellipse.
fn sky_picture() -> Image {
    mollweide(64, East::Left, |direction| weigh(centre(pixel_of_direction(NSIDE, direction))))
}
