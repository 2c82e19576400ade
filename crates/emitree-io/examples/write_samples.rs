//! Writes sample files for the tests under `tests/astropy`: `write_samples FOLDER`.
//!
//! The image is asymmetric, row · 1000 + column + ¼, so that no flip or transposition passes.

use emitree::Image;
use emitree_io::{
    Card, FitsFile, FitsImage, OutputFile, PictureOptions, Wcs, encode_npy, encode_npy_image,
    encode_png,
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
        primary: FitsImage { name: "RADIANCE", image: &image, unit: Some("m-2 sr-1 s-1") },
        extensions: vec![
            FitsImage { name: "ERROR", image: &error, unit: Some("m-2 sr-1 s-1") },
            FitsImage { name: "EVALUATIONS", image: &counts, unit: None },
        ],
        wcs: Some(wcs),
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
    for (name, fov_deg) in [("narrow", [16.0, 27.0]), ("all_sky", [360.0, 180.0])] {
        let wcs = Wcs::equirectangular(HEIGHT, WIDTH, fov_deg);
        write(&format!("{name}.fits"), file(wcs).encode()?)?;
    }

    write("image.npy", encode_npy_image(&image))?;
    write("error.npy", encode_npy_image(&error))?;
    write("cube.npy", encode_npy(&[HEIGHT, 1, WIDTH], image.pixels())?)?;
    let options = PictureOptions { title: Some("sample".to_owned()), ..PictureOptions::default() };
    write("image.png", encode_png(&image, &options)?)?;
    Ok(())
}
