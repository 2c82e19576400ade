//! `emitree render --by-rows`: the image of an ordinary rendering, refusals by name, and no file that is half written.
#![allow(clippy::unwrap_used, reason = "what fails here fails the test")]

mod support;

use support::{Folder, HOLMSTROM, example};

/// The scene of the paper with the method `vol`.
fn smooth() -> Folder {
    let scene = HOLMSTROM.replace("\"paper\"\nthreshold = 0.01", "\"vol\"\ntolerance = 0.001");
    Folder::with_scene(&scene)
}

#[test]
fn the_file_has_the_pixels_and_the_errors_of_an_ordinary_rendering() {
    let folder = smooth();
    folder.emitree("render scene.toml -o whole.fits").succeeds();
    let run = folder.emitree("render scene.toml -o rows.fits --by-rows");
    run.succeeds();
    assert!(run.stdout.contains("64 x 64 pixels (width x height), row by row"), "{}", run.stdout);
    let run = folder.emitree("compare rows.fits whole.fits -t 0");
    run.succeeds();
    assert!(run.stdout.contains("all numbers are the same"), "{}", run.stdout);
    let bytes = |name: &str| std::fs::read(folder.path(name)).unwrap();
    // Values and errors, each in blocks of 2880 bytes, with headers.
    assert!(bytes("rows.fits").len() >= 2 * (64 * 64 * 8 + 2880));
}

#[test]
fn a_name_that_ends_in_gz_has_a_compressed_file() {
    let folder = smooth();
    folder.emitree("render scene.toml -o rows.fits.gz --by-rows").succeeds();
    let bytes = std::fs::read(folder.path("rows.fits.gz")).unwrap();
    assert_eq!(&bytes[..2], &[0x1f, 0x8b]);
}

#[test]
fn what_has_no_rows_is_refused_and_leaves_no_file() {
    let planet = example("mars_hydrogen.toml");
    let cases = [
        (planet.as_str(), "", 2, "its view is divided into"),
        (HOLMSTROM, "", 2, "the method `paper` has no products"),
        (HOLMSTROM, "--method vol --report report.json", 2, "there is no --report of an image"),
    ];
    for (scene, options, code, text) in cases {
        let folder = Folder::with_scene(scene);
        let run = folder.emitree(&format!("render scene.toml -o rows.fits --by-rows {options}"));
        assert!(run.stderr.contains(text), "no `{text}` in {:?}:\n{}", run.code, run.stderr);
        run.fails_with(code);
        folder.holds(&["scene.toml"]);
    }
    let folder = smooth();
    let run = folder.emitree("render scene.toml -o rows.png --by-rows");
    assert!(run.stderr.contains("expected .fits or .fits.gz"), "{}", run.stderr);
    folder.holds(&["scene.toml"]);
}
