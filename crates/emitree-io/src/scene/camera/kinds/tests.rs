//! The table of cameras: every row is complete, and the guide has it.

use super::*;
use crate::fits::Wcs;
use crate::scene::camera::description::{
    CameraKey, FitsCoordinates, KeyDefault, PixelLayout, PlotAxis, PlotFrame, PlotScale,
};
use crate::scene::{Scene, SceneError};
use crate::units::Unit;
use std::collections::BTreeSet;

impl CameraDescription {
    /// A scene of few pixels with this camera and all of its keys, and with other tables.
    pub(crate) fn example_scene(&self, tables: &str) -> String {
        self.scene_with(self.keys, tables)
    }

    fn scene_with<'a>(
        &self,
        keys: impl IntoIterator<Item = &'a CameraKey>,
        tables: &str,
    ) -> String {
        let image = match self.pixels {
            PixelLayout::Rectangle => "width = 4\nheight = 3",
            PixelLayout::Healpix => "nside = 2",
        };
        let keys = keys.into_iter().map(|key| format!("{} = {}\n", key.name, key.example));
        let keys: String = keys.collect();
        format!(
            "emission.expression = \"exp(-x^2)\"\n[image]\n{image}\n[projection]\ntype = \"{}\"\n\
             {keys}\n{tables}",
            self.name
        )
    }
}

const BOUNDS: &str = "[bounds]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 2\n";

fn read(text: &str) -> Result<Scene, SceneError> {
    Scene::parse("scene.toml", text, &[])
}

/// Whether a key is needed in a scene with bounds, or in one without.
fn is_needed(key: &CameraKey, has_bounds: bool) -> bool {
    match key.default {
        KeyDefault::Required => true,
        KeyDefault::InBounds(_) => !has_bounds,
        KeyDefault::Value(_) => false,
    }
}

#[test]
fn names_are_words_and_differ() {
    let words: BTreeSet<&str> = cameras().iter().map(|camera| camera.name).collect();
    assert_eq!(words.len(), cameras().len());
    assert_eq!(
        cameras().iter().map(|c| c.python_class).collect::<BTreeSet<_>>().len(),
        words.len()
    );
    for camera in cameras() {
        assert!(camera.name.chars().all(|c| c.is_ascii_lowercase() || c == '_'), "{}", camera.name);
        assert!(camera.python_class.starts_with(char::is_uppercase), "{}", camera.name);
        assert!(camera.summary.ends_with('.'), "{}", camera.name);
        let keys: BTreeSet<&str> = camera.keys.iter().map(|key| key.name).collect();
        assert!(keys.len() == camera.keys.len() && keys.contains("length_unit"), "{}", camera.name);
        for key in camera.keys {
            let texts = [key.value, key.meaning, key.example, key.expected];
            assert!(texts.iter().all(|text| !text.is_empty()), "{}.{}", camera.name, key.name);
        }
    }
}

#[test]
fn every_camera_has_the_edges_of_its_scene() {
    let edge = "[[edge]]\ntype = \"plane\"\nposition = [0, 0, 0]\nnormal = [0, 0, 2]\n";
    let fields = "Plane { position: [0.0, 0.0, 0.0], normal: [0.0, 0.0, 1.0] }";
    for camera in cameras() {
        let count = |tables: &str| {
            let scene = read(&camera.example_scene(tables)).unwrap();
            format!("{:?}", scene.camera.projection()).matches(fields).count()
        };
        // Each face of a sky is a camera.
        let cameras = if camera.is_sky() { 12 } else { 1 };
        assert_eq!([count(""), count(edge)], [0, cameras], "{}", camera.name);
    }
}

#[test]
fn the_keys_of_a_row_are_those_that_are_read() {
    for camera in cameras() {
        let asked =
            read(&camera.scene_with(camera.keys, "").replace("type =", "qqqqqqqqq = 1\ntype ="));
        let expected = asked.unwrap_err().expected().to_owned();
        let read: BTreeSet<&str> = expected.split('`').skip(1).step_by(2).collect();
        let mut row: BTreeSet<&str> = camera.keys.iter().map(|key| key.name).collect();
        row.insert("type");
        assert_eq!(read, row, "{}", camera.name);
    }
}

#[test]
fn keys_are_needed_where_their_row_says_so() {
    for camera in cameras() {
        for (tables, has_bounds) in [("", false), (BOUNDS, true)] {
            for missing in camera.keys {
                let given = camera.keys.iter().filter(|key| key.name != missing.name);
                let found = read(&camera.scene_with(given, tables));
                let what = format!("{} without {}, {tables}", camera.name, missing.name);
                if is_needed(missing, has_bounds) {
                    let message = found.unwrap_err().message().to_owned();
                    assert_eq!(
                        message,
                        format!("`projection.{}` is missing", missing.name),
                        "{what}"
                    );
                } else {
                    found.expect(&what);
                }
            }
        }
    }
}

#[test]
fn every_camera_has_coordinates_in_fits_or_a_reason_for_none() {
    for camera in cameras() {
        let types = |keys: Vec<&CameraKey>| {
            let scene = read(&camera.scene_with(keys, "")).unwrap();
            let wcs = scene.camera.wcs(scene.height, scene.width, &Unit::one());
            wcs.map(|Wcs { axes, .. }| axes.into_iter().map(|axis| axis.ctype).collect::<Vec<_>>())
        };
        let needed = camera.keys.iter().filter(|key| is_needed(key, false)).collect();
        let found = [types(camera.keys.iter().collect()), types(needed)];
        match camera.fits {
            FitsCoordinates::None(reason) => {
                assert!(found == [None, None] && !reason.is_empty(), "{}", camera.name);
            }
            FitsCoordinates::Axes(rows) => {
                let found: BTreeSet<Vec<String>> = found.into_iter().flatten().collect();
                let row = rows.iter().map(|pair| pair.map(str::to_owned).to_vec());
                assert_eq!(found, row.collect(), "{}", camera.name);
            }
        }
    }
}

#[test]
fn every_picture_has_axes_or_an_ellipse() {
    for camera in cameras() {
        let axis = |PlotAxis { label, ends: [low, high], scale }| {
            assert!(!label.is_empty() && !label.contains('['), "{}: {label}", camera.name);
            assert!(low < high && low.is_finite() && high.is_finite(), "{}", camera.name);
            assert!(scale != PlotScale::Tangents || low > -90.0 && high < 90.0, "{}", camera.name);
        };
        match read(&camera.example_scene("")).unwrap().camera.frame() {
            PlotFrame::Axes { x, y } | PlotFrame::UnlikeAxes { x, y } => [x, y].map(axis),
            PlotFrame::Ellipse => [(); 2],
        };
    }
}

/// The tables of the guide: one of all cameras, one of their keys, one of coordinates in FITS.
#[test]
fn the_guide_has_every_row() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/guide.md");
    let guide = std::fs::read_to_string(path).unwrap();
    for camera in cameras() {
        let name = camera.name;
        for text in [format!("| [`{name}`](#{name}) | "), format!("\n#### `{name}`\n")] {
            assert!(guide.contains(&text), "no {text}");
        }
        for key in camera.keys {
            let default = match key.default {
                KeyDefault::Required => String::new(),
                KeyDefault::InBounds(value) => format!("none; `{value}` in bounds "),
                KeyDefault::Value(value) => format!("{value} "),
            };
            let row = format!("\n| `{}` | {} | {default}| ", key.name, key.value);
            assert!(guide.contains(&row), "{name}: no {row}");
        }
        if let FitsCoordinates::Axes(rows) = camera.fits {
            let row = guide.lines().find(|line| line.starts_with(&format!("| `{name}` | `")));
            let row = row.unwrap_or_default();
            let has_axes = rows[0].iter().all(|axis| row.contains(&format!("`{axis}`")));
            assert!(has_axes, "{name}: {row}");
        }
    }
}
