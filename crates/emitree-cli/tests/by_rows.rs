//! `emitree render --by-rows`: the image of an ordinary rendering, refusals by name, and no file that is half written.
#![allow(clippy::unwrap_used, reason = "what fails here fails the test")]

use crate::support::{Folder, HOLMSTROM, example};

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
fn a_cube_has_the_values_and_the_bins_of_an_ordinary_rendering() {
    let scene = r#"
        emission.expression = "exp(-r^2) * exp(-E) + exp(-(x-0.5)^2 - y^2 - z^2) / (1 + E^2)"
        projection = { type = "perspective", position = [0, -9, 0], target = [0, 0, 0], field_of_view = [30, 30], near = 4, far = 14 }
        energy = { min = 0.5, max = 4.0, bins = 6 }
        image = { width = 40, height = 30 }
    "#;
    let folder = Folder::with_scene(scene);
    folder.emitree("render scene.toml -o whole.fits").succeeds();
    let run = folder.emitree("render scene.toml -o rows.fits --by-rows");
    run.succeeds();
    assert!(run.stdout.contains("energies     6 bins of 0.5"), "{}", run.stdout);
    assert!(run.stdout.contains("of the largest voxel (estimated)"), "{}", run.stdout);
    folder.emitree("compare rows.fits whole.fits -t 1e-12").succeeds();
    let text = |name: &str| {
        String::from_utf8_lossy(&std::fs::read(folder.path(name)).unwrap()).into_owned()
    };
    let [rows, whole] = [text("rows.fits"), text("whole.fits")];
    let card = |text: &str, name: &str| {
        let at = text.find(name).unwrap_or_else(|| panic!("no {name}"));
        text[at..].chars().take(40).collect::<String>()
    };
    for name in
        ["NAXIS3  =", "CTYPE3  =", "CRVAL3  =", "CDELT3  =", "EXTNAME = 'ENERGIES", "NEVAL   ="]
    {
        assert_eq!(card(&rows, name), card(&whole, name));
    }
    assert_eq!(rows.matches("XTENSION=").count(), 2);
}

/// Irradiances, and means over one time and over several, with the errors of ordinary renderings.
#[test]
fn irradiances_and_exposures_are_those_of_an_ordinary_rendering() {
    let view =
        r#"type = "perspective", position = [0, -5, 0], target = [0, 0, 0], near = 1, far = 14"#;
    let scene = |factor: &str, image: &str, table: &str| {
        format!(
            "emission.expression = \"exp(-r^2) * {factor} + exp(-(x-0.5)^2 - y^2 - z^2)\"\n\
             projection = {{ {view}, field_of_view = [110, 110] }}\n\
             image = {{ width = 40, height = 30{image} }}\n{table}"
        )
    };
    let time = |bins: usize| format!("[time]\nstart = 0.0\nstop = 2.0\nbins = {bins}\n");
    let energy = "[energy]\nmin = 0.5\nmax = 4.0\nbins = 3\n";
    let scenes = [
        scene("2", ", quantity = \"irradiance\"", ""),
        scene("exp(-E)", ", quantity = \"irradiance\"", energy),
        scene("exp(-t)", "", &time(1)),
        scene("exp(-t)", "", &time(3)),
    ];
    for scene in scenes {
        let folder = Folder::with_scene(&scene);
        let whole = folder.emitree("render scene.toml -o whole.fits");
        whole.succeeds();
        let rows = folder.emitree("render scene.toml -o rows.fits --by-rows");
        rows.succeeds();
        folder.emitree("compare rows.fits whole.fits -t 1e-12").succeeds();
        for label in ["  error ", "  radiance ", "  irradiance "] {
            let line = |stdout: &str| {
                let of_label = stdout.lines().find(|line| line.starts_with(label));
                of_label.map(|line| line.split(" ph ").next().unwrap_or(line).to_owned())
            };
            assert_eq!(line(&rows.stdout), line(&whole.stdout), "{scene}");
        }
    }
}

/// Charts, the rim of a disc and pixels without an image, with fewer pixels than the search may have.
#[test]
fn a_view_with_a_planet_has_the_pixels_of_an_ordinary_rendering() {
    let folder = Folder::with_scene(&example("mars_hydrogen.toml"));
    folder.emitree("render scene.toml -o whole.fits").succeeds();
    folder.emitree("render scene.toml -o rows.fits --by-rows").succeeds();
    // Both are within 1 %; they differ by the blocks of rows alone, in which rasters are refined.
    folder.emitree("compare rows.fits whole.fits -t 1e-3").succeeds();
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
    let cube = r#"
        emission.expression = "exp(-r^2) * exp(-E)"
        projection = { type = "perspective", position = [0, -9, 0], target = [0, 0, 0], field_of_view = [30, 30], near = 4, far = 14 }
        occulter = [{ type = "sphere", center = [0, 0, 0], radius = 0.5 }]
        energy = { min = 0.5, max = 4.0, bins = 6 }
        image = { width = 40, height = 30 }
    "#;
    let cases = [
        (cube, "", 2, "divides its view, and it is a cube"),
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
