//! Views of every kind of camera, and the lines of sight of their pixels.

use emitree::projection::healpix::face_pixel;
use emitree::projection::{MappedPoint, Region};
use emitree::{Healpix, Image, render};
use emitree_io::units::Unit;
use emitree_io::{FitsFile, FitsImage, HealpixColumn, HealpixFile, Scene, encode_npy};
use std::error::Error;

/// A file's name and its bytes.
type File = (String, Vec<u8>);

/// A pointing along no axis, and a roll.
const POINTING: &str = "position = [10.0, -30.0, 4.0]
target = [6.0, 1.0, -2.0]
up = [0.3, 0.2, 1.0]
near = 5.0
far = 40.0";

/// Names, cameras and pixels \[width, height\]: even numbers have corners on the axes and on the
/// rims of discs, odd ones do not.
const VIEWS: [(&str, &str, [usize; 2]); 13] = [
    ("radii", "type = 'orthographic'\nextent = [20, 35]\nlength_unit = 'R_E'", [5, 7]),
    ("units", "type = 'orthographic'\nextent = [0.1, 0.2]\nlength_unit = 'AU'", [6, 4]),
    ("numbers", "type = 'orthographic'\nextent = [3, 0.2]", [5, 8]),
    ("tangent", "type = 'perspective'\nfield_of_view = [100, 60]", [5, 7]),
    ("tangent_high", "type = 'perspective'\nfield_of_view = [2.5, 170]", [6, 8]),
    ("angles", "type = 'equirectangular'\nfield_of_view = [16, 27]", [5, 7]),
    ("angles_all", "type = 'equirectangular'\nfield_of_view = [360, 180]", [6, 8]),
    ("arc", "type = 'fisheye'\nfield_of_view = 200", [5, 7]),
    ("arc_all", "type = 'fisheye'\nfield_of_view = 360\nmapping = 'ARC'", [6, 8]),
    ("zea", "type = 'fisheye'\nfield_of_view = 150\nmapping = 'ZEA'", [5, 7]),
    ("zea_all", "type = 'fisheye'\nfield_of_view = 360\nmapping = 'equal_area'", [6, 8]),
    ("polar", "type = 'polar'\nfield_of_view = 140", [5, 7]),
    ("polar_all", "type = 'polar'\nfield_of_view = 360", [6, 8]),
];

/// For each view the scene, an image with the header that `emitree render` writes, and the lines of
/// sight through the corners of its pixels.
pub(crate) fn files() -> Result<Vec<File>, Box<dyn Error>> {
    let mut files = Vec::new();
    for (name, camera, [width, height]) in VIEWS {
        let text = format!(
            "emission.expression = '1'\nimage = {{ width = {width}, height = {height} }}\n\
             [projection]\n{camera}\n{POINTING}\n"
        );
        let scene = Scene::parse(name, &text, &[])?;
        files.push((format!("view_{name}.fits"), fits(&scene)?));
        files.push((format!("view_{name}.npy"), corners(&scene)?));
        files.push((format!("view_{name}.toml"), text.into_bytes()));
    }
    Ok(files)
}

fn fits(scene: &Scene) -> Result<Vec<u8>, Box<dyn Error>> {
    let image = Image::zeros(scene.height, scene.width);
    let length = scene.length_unit.as_deref().map_or_else(|| Ok(Unit::one()), Unit::parse)?;
    Ok(FitsFile {
        primary: FitsImage::new("RADIANCE", &image, None),
        extensions: Vec::new(),
        wcs: scene.camera.wcs(scene.height, scene.width, &length),
        energies: None,
        provenance: Vec::new(),
        history: scene.text.clone(),
        date: None,
    }
    .encode()?)
}

/// \[height + 1, width + 1, 2, 3\]: the point in the middle of each line, and the unit vector along
/// the line; NaN at corners that are not in the image.
fn corners(scene: &Scene) -> Result<Vec<u8>, Box<dyn Error>> {
    let camera = scene.camera.projection();
    let at = |step: usize, pixels: usize| step as f64 / pixels as f64;
    let mut lines = Vec::new();
    for row in 0..=scene.height {
        for column in 0..=scene.width {
            let [x, y] = [at(column, scene.width), at(row, scene.height)];
            match camera.view_geometry().map(|geometry| geometry.region([x, y])) {
                Some(Region::Outside) => lines.extend([f64::NAN; 6]),
                _ => lines.extend(line(camera.world_from_canonical([x, y, 0.5]))),
            }
        }
    }
    Ok(encode_npy(&[scene.height + 1, scene.width + 1, 2, 3], &lines)?)
}

fn line(point: MappedPoint) -> impl Iterator<Item = f64> {
    point.position.into_iter().chain(point.direction.map(|component| -component))
}

/// An emission equal to a component of the direction (from the point to the observer), along lines of length 1.
const SKY: &str = "emission.expression = '-(dx + 10*dy + 100*dz)'
image = { nside = 4 }
render = { tolerance = 1e-5 }
[projection]
type = 'healpix'
position = [3.0, -2.0, 1.0]
near = 1.0
far = 2.0
";

/// The sky of directions, and the lines of sight through the middle and the corners of its pixels.
pub(crate) fn sky() -> Result<Vec<File>, Box<dyn Error>> {
    let scene = Scene::parse("sky", SKY, &[])?;
    let options = scene.render_options();
    let shape = [scene.height, scene.width];
    let rendering = render(&scene.emission, scene.camera.projection(), shape, &options)?;
    let map = Healpix::nested(&rendering.values);
    let file = HealpixFile {
        columns: vec![HealpixColumn { name: "RADIANCE", unit: None, values: &map }],
        coordinates: None,
        energies: None,
        provenance: Vec::new(),
        history: scene.text.clone(),
        date: None,
    };
    Ok(vec![
        ("sky.fits".to_owned(), file.encode()?),
        ("sky.npy".to_owned(), encode_npy(&[map.len()], &map)?),
        ("sky_lines.npy".to_owned(), sky_lines(&scene)?),
    ])
}

/// The middle of a pixel, then its corners in the order of healpy: north, west, south, east.
const IN_PIXEL: [[f64; 2]; 5] = [[0.5, 0.5], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0], [1.0, 0.0]];

/// \[12 nside², 5, 2, 3\]: the lines of [`IN_PIXEL`] of each pixel, as in [`corners`].
fn sky_lines(scene: &Scene) -> Result<Vec<u8>, Box<dyn Error>> {
    let faces = scene.camera.projection().view_geometry().ok_or("no faces")?.tiles();
    let (nside, pixels) = (u32::try_from(scene.width)?, scene.height * scene.width);
    let mut lines = Vec::new();
    for index in 0..pixels {
        let (face, column, row) = face_pixel(nside, index as u64);
        for [right, up] in IN_PIXEL {
            let [x, y] = [f64::from(column) + right, f64::from(row) + up];
            let [x, y] = [x, y].map(|along| along / f64::from(nside));
            lines.extend(line(faces[usize::from(face)].world_from_canonical([x, y, 0.5])));
        }
    }
    Ok(encode_npy(&[pixels, IN_PIXEL.len(), 2, 3], &lines)?)
}
