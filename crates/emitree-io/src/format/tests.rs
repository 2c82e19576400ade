//! The table of formats: every row is complete.

use super::*;
use crate::product::{Bands, ProductMap};
use crate::scene::{Scene, cameras};
use emitree::Cube;

#[test]
fn endings_choose_formats_in_any_case() {
    for format in Format::ALL {
        for ending in format.description().endings {
            assert_eq!(Format::from_path(format!("a.b/c.{ending}")), Ok(format));
            assert_eq!(Format::from_path(format!("c.{}", ending.to_uppercase())), Ok(format));
        }
    }
}

#[test]
fn the_error_lists_every_ending() {
    for path in ["image", "image.", "fits", ".png", "image.png.bak", "a.fits/b"] {
        let message = Format::from_path(path).unwrap_err().to_string();
        assert!(message.starts_with(&format!("`{path}`")), "{message}");
        for ending in Format::ALL.iter().flat_map(|format| format.description().endings) {
            assert!(message.contains(&format!(".{ending}")), "{message}");
        }
    }
}

/// A new format does not compile here before it has a number, which is its place in the list.
#[test]
fn the_list_has_every_format_once() {
    for (number, format) in Format::ALL.into_iter().enumerate() {
        let expected = match format {
            Format::Fits => 0,
            Format::Npy => 1,
            Format::Png => 2,
        };
        assert_eq!(number, expected, "{format:?}");
    }
}

#[test]
fn every_row_is_complete() {
    let mut endings: Vec<&str> = Vec::new();
    for format in Format::ALL {
        let row = format.description();
        assert_eq!(row.name, format!("{format:?}").to_uppercase());
        assert!(!row.endings.is_empty(), "{format:?}");
        for text in [row.image, row.cube, row.sky] {
            assert!(!text.is_empty() && !text.ends_with('.'), "{format:?}: {text}");
        }
        endings.extend(row.endings);
    }
    assert!(endings.iter().all(|ending| !ending.is_empty() && *ending == ending.to_lowercase()));
    let mut unique = endings.clone();
    unique.sort_unstable();
    unique.dedup();
    assert_eq!(unique.len(), endings.len(), "an ending of two formats");
}

/// What the first bytes of a file are, so that no format is written as another.
fn starts(format: Format) -> &'static [u8] {
    match format {
        Format::Fits => b"SIMPLE  =",
        Format::Npy => b"\x93NUMPY",
        Format::Png => b"\x89PNG",
    }
}

fn styles() -> Vec<PictureStyle> {
    vec![
        PictureStyle::default(),
        #[cfg(feature = "figure")]
        PictureStyle::Annotated { logarithmic: false },
        #[cfg(feature = "figure")]
        PictureStyle::Annotated { logarithmic: true },
    ]
}

#[test]
fn every_format_holds_images_and_cubes_of_every_camera() {
    for camera in cameras() {
        for energies in ["", "[energy]\nmin = 1\nmax = 3\nbins = 2\n"] {
            let text = camera.example_scene(energies);
            let scene = Scene::parse("scene.toml", &text, &[]).unwrap();
            let found = scene.render(&scene.emission, &scene.render_options()).unwrap();
            let bands = if scene.energy.is_some() { Bands::Energies } else { Bands::Image };
            let map = |name, map| ProductMap { name, map, unit: scene.image_unit(), bands };
            let errors: Vec<Cube> = found.error.into_iter().collect();
            let others = errors.iter().map(|error| map("ERROR", error)).collect();
            let product =
                Product { others, ..Product::new(&scene, map("RADIANCE", &found.values)) };
            for format in Format::ALL {
                for style in styles() {
                    let bytes = format.encode(&product, style).unwrap();
                    let name = camera.name;
                    assert!(bytes.starts_with(starts(format)), "{name} {format:?} {style:?}");
                }
            }
        }
    }
}
