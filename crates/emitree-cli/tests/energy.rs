//! Scenes with an energy axis: cubes, the image of their whole band, and what can't be had.

use crate::support::{Folder, decode_png, pixels};
use serde_json::json;

/// A flat spectrum, linear along z, so that uniform steps are exact.
const CUBE: &str = r#"
[emission]
expression = "1 + x + 2*y + 3*z"
unit = "ph cm-3 s-1 sr-1 keV-1"

[projection]
type = "canonical"
length_unit = "cm"

[image]
width = 6
height = 5

[energy]
min = 500
max = 8000
unit = "eV"
bins = 4
scale = "log"

[render]
method = "los"
steps = 10
"#;

/// The widths of the bins of `CUBE` \[keV\].
const WIDTHS_KEV: [f64; 4] = [0.5, 1.0, 2.0, 4.0];

/// The shape that an NPY file says it has.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn shape(npy: &[u8]) -> String {
    let header = String::from_utf8_lossy(&npy[10..128]).into_owned();
    let (_, after) = header.split_once("'shape': ").unwrap();
    after.split_once(')').unwrap().0.to_owned() + ")"
}

/// Whether a FITS file has this record.
fn has(fits: &[u8], text: &str) -> bool {
    fits.windows(text.len()).any(|bytes| bytes == text.as_bytes())
}

fn close(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < 1e-12
}

/// The image that all bands of `CUBE` have, by the index of a voxel.
fn flat(index: usize) -> f64 {
    let [row, column] = [index / 6 % 5, index % 6].map(|at| at as f64 + 0.5);
    1.0 + column / 6.0 + 2.0 * row / 5.0 + 1.5
}

#[test]
fn a_scene_with_energies_becomes_a_cube() {
    let folder = Folder::with_scene(CUBE);
    let options = "-o a.fits -o a.npy -o a.png --band b.fits --band b.npy --band b.png";
    let run = folder.emitree(&format!("render scene.toml {options} --report r.json"));
    run.succeeds();
    for text in [
        "scene.toml: 6 x 5 pixels (width x height)\n",
        "  energies     4 bins of 500–8000 eV (log), 4 evaluated\n",
        "  evaluations  1,200 in ",
        ", 10.00 for each voxel\n",
        "  whole band   ",
        " ph cm-2 s-1 sr-1\n",
    ] {
        assert!(run.stdout.contains(text), "no `{text}` in:\n{}", run.stdout);
    }
    folder.holds(&["a.fits", "a.npy", "a.png", "b.fits", "b.npy", "b.png", "r.json", "scene.toml"]);

    let npy = folder.bytes("a.npy");
    assert_eq!(shape(&npy), "(4, 5, 6)");
    let cube = pixels(&npy);
    for (index, voxel) in cube.iter().enumerate() {
        assert!(close(*voxel, flat(index)), "{index}: {voxel}");
    }
    let band_file = folder.bytes("b.npy");
    assert_eq!(shape(&band_file), "(5, 6)");
    for (pixel, band) in pixels(&band_file).iter().enumerate() {
        let sum: f64 = (0..4).map(|bin| cube[bin * 30 + pixel] * WIDTHS_KEV[bin]).sum();
        assert!(close(*band, sum), "{pixel}: {band} {sum}");
    }

    let report = folder.json("r.json");
    let energy = json!({"min": 500.0, "max": 8000.0, "unit": "eV", "bins": 4, "scale": "log"});
    assert_eq!(report["energy"], energy);
    assert_eq!((&report["energies"], &report["evaluations"]), (&json!(4), &json!(1200)));
    assert_eq!(report["image"]["unit"], "ph cm-2 s-1 sr-1 keV-1");
    let largest = cube.iter().copied().fold(0.0, f64::max);
    assert!(close(report["image"]["max"].as_f64().unwrap(), largest));

    let fits = folder.bytes("a.fits");
    for text in [
        "NAXIS3  =                    4",
        "CTYPE3  = 'ENER-LOG'",
        "BUNIT   = 'ph cm-2 s-1 sr-1 keV-1'",
        "NENERGY =                    4",
        "EXTNAME = 'EVALUATIONS'",
        "EXTNAME = 'BAND    '",
        "BUNIT   = 'ph cm-2 s-1 sr-1'",
        "EXTNAME = 'ENERGIES'",
        "TTYPE2  = 'E_MAX   '",
        "TUNIT2  = 'eV      '",
    ] {
        assert!(has(&fits, text), "{text}");
    }
    let band = folder.bytes("b.fits");
    assert!(has(&band, "BUNIT   = 'ph cm-2 s-1 sr-1'") && !has(&band, "ENERGIES"));
    assert!(has(&band, "EXTNAME = 'RADIANCE'"), "as other images");
    // Two rows of two tiles with a gap of one pixel.
    let (width, height, _) = decode_png(&folder.bytes("a.png"));
    assert_eq!((width, height), (2 * 6 + 1, 2 * 5 + 1));
    let (width, height, _) = decode_png(&folder.bytes("b.png"));
    assert_eq!((width, height), (6, 5));
}

/// A Gaussian ball whose spectrum is steeper outside, by a method.
fn spectral(method: &str) -> Folder {
    let expression = "exp(-8*((x-0.5)^2 + (y-0.4)^2 + (z-0.5)^2)) * exp(-E*(1 + x)/2)";
    let scene = CUBE
        .replace("1 + x + 2*y + 3*z", expression)
        .replace("min = 500\nmax = 8000\nunit = \"eV\"\nbins = 4", "min = 0.5\nmax = 8\nbins = 6")
        .replace("method = \"los\"\nsteps = 10", method);
    Folder::with_scene(&scene)
}

/// The default method, the paper's and lines of sight agree, and the first costs least.
#[test]
fn all_methods_see_the_same_cube() {
    let methods = [
        ("tolerance = 0.005", "vol: to 0.5 % of the largest voxel"),
        ("method = \"paper\"\nthreshold = \"0.3%\"\nbase_level = 3", "paper: "),
        ("method = \"los\"\nsteps = 32\nlines = 8", "los: "),
    ];
    let found = methods.map(|(method, summary)| {
        let folder = spectral(method);
        let run = folder.emitree("render scene.toml -o a.npy --report r.json");
        run.succeeds();
        assert!(run.stdout.contains(summary), "no `{summary}` in:\n{}", run.stdout);
        let evaluations = folder.json("r.json")["evaluations"].as_u64().unwrap();
        (pixels(&folder.bytes("a.npy")), evaluations)
    });
    let [vol, paper, los] = found;
    let largest = los.0.iter().copied().fold(0.0, f64::max);
    let difference = |other: &[f64]| {
        other.iter().zip(&los.0).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
    };
    let [vol_error, paper_error] = [difference(&vol.0), difference(&paper.0)];
    assert!(vol_error < 0.006 && paper_error < 0.02, "{vol_error} {paper_error}");
    assert!(vol.1 < paper.1 && paper.1 < los.1, "{} {} {}", vol.1, paper.1, los.1);
}

/// A limit ends a cube as it ends an image: the best cube so far is written, and the exit code is 4.
#[test]
fn a_limit_ends_a_cube() {
    let folder = spectral("tolerance = 1e-5\nmax_evaluations = 2000");
    let run = folder.emitree("render scene.toml -o a.npy --error-map e.npy --report r.json");
    run.fails_with(4);
    folder.holds(&["a.npy", "e.npy", "r.json", "scene.toml"]);
    let report = folder.json("r.json");
    assert!(report["evaluations"].as_u64().unwrap() <= 2000);
    assert_eq!(report["converged"], false);
    assert_eq!(shape(&folder.bytes("e.npy")), "(6, 5, 6)");
}

#[test]
fn options_change_the_energies() {
    let folder = Folder::with_scene(CUBE);
    let options = "--set energy.bins=1 --set energy.scale=linear --tolerance 0.01";
    let run = folder.emitree(&format!(
        "render scene.toml -o a.npy -o a.fits --band b.npy --error-map e.npy --report r.json {options}"
    ));
    run.succeeds();
    assert!(run.stdout.contains("  energies     1 bin of 500–8000 eV (linear), 1 evaluated\n"));
    assert!(run.stdout.contains(" of the largest voxel ("), "{}", run.stdout);
    let files = ["a.npy", "e.npy", "b.npy"].map(|name| shape(&folder.bytes(name)));
    assert_eq!(files, ["(1, 5, 6)", "(1, 5, 6)", "(5, 6)"]);
    let [cube, band] = ["a.npy", "b.npy"].map(|name| pixels(&folder.bytes(name)));
    for (index, (band, voxel)) in band.iter().zip(&cube).enumerate() {
        assert!(close(*voxel, flat(index)) && close(*band, 7.5 * voxel), "{index}: {voxel} {band}");
    }
    assert!(has(&folder.bytes("a.fits"), "NAXIS3  =                    1"));
    assert_eq!(folder.json("r.json")["energy"]["scale"], "linear");
}

#[test]
fn scenes_without_energies_are_as_they_were() {
    let (before, after) = CUBE.split_once("[energy]").unwrap();
    let (_, render) = after.split_once("[render]").unwrap();
    let scene = format!("{before}[render]{render}").replace(" keV-1", "");
    let folder = Folder::with_scene(&scene);
    let run = folder.emitree("render scene.toml -o a.npy -o a.fits --report r.json");
    run.succeeds();
    assert!(!run.stdout.contains("energies") && !run.stdout.contains("voxel"), "{}", run.stdout);
    assert_eq!(shape(&folder.bytes("a.npy")), "(5, 6)");
    let fits = folder.bytes("a.fits");
    assert!(!has(&fits, "NAXIS3") && !has(&fits, "ENERG") && !has(&fits, "BAND"));
    let report = folder.json("r.json");
    assert!(report["energy"].is_null() && report["energies"].is_null());
    let run = folder.emitree("render scene.toml -o b.npy --band c.npy");
    run.fails_with(2);
    let expected = "emitree: --band: the scene has no `[energy]`, and its image no energy band: \
                    expected a scene with an energy axis\n";
    assert_eq!(run.stderr, expected);
    folder.holds(&["a.fits", "a.npy", "r.json", "scene.toml"]);
}

#[test]
fn pictures_of_cubes_are_annotated_sheets() {
    let folder = Folder::with_scene(CUBE);
    let sheet = |options: &str| {
        folder.emitree(&format!("render scene.toml -o a.png --annotate -q {options}")).succeeds();
        let (width, height, _) = decode_png(&folder.bytes("a.png"));
        (width, height, folder.bytes("a.png"))
    };
    let linear = sheet("");
    assert!(linear.0 > 1200 && linear.1 > 1200, "{} x {}", linear.0, linear.1);
    let logarithmic = sheet("--log");
    assert_ne!(linear.2, logarithmic.2);
    // Of 1000 bins 16 share a tile.
    let many = sheet("--set energy.bins=1000 --steps 1");
    assert!(many.0 < 2500 && many.1 < 2500, "{} x {}", many.0, many.1);
}

#[test]
fn skies_have_a_column_for_each_bin() {
    let camera = "type = \"healpix\"\nposition = [0, 0, 0]\nfar = 1";
    let scene = CUBE
        .replace("type = \"canonical\"", camera)
        .replace("width = 6\nheight = 5", "nside = 2\nquantity = \"irradiance\"");
    let folder = Folder::with_scene(&scene);
    let run = folder.emitree("render scene.toml -o a.fits -o a.npy -o a.png --band b.npy");
    run.succeeds();
    assert!(run.stdout.contains("irradiance") && run.stdout.contains(" ph cm-2 s-1 keV-1\n"));
    assert_eq!(shape(&folder.bytes("a.npy")), "(4, 48)");
    let band = folder.bytes("b.npy");
    assert_eq!(shape(&band), "(48,)");
    let cube = pixels(&folder.bytes("a.npy"));
    let sum: f64 = (0..4).map(|bin| cube[bin * 48 + 17] * WIDTHS_KEV[bin]).sum();
    assert!(close(pixels(&band)[17], sum));
    let fits = folder.bytes("a.fits");
    for text in [
        "TTYPE1  = 'IRRADIANCE_1'",
        "TTYPE4  = 'IRRADIANCE_4'",
        "TTYPE5  = 'EVALUATIONS'",
        "TTYPE6  = 'BAND    '",
        "EXTNAME = 'ENERGIES'",
    ] {
        assert!(has(&fits, text), "{text}");
    }
    let run = folder.emitree("render scene.toml -o c.fits --set energy.bins=998");
    run.fails_with(2);
    let expected = "output: a table of FITS has no columns for 998 energy bins of a sky: expected \
                    997 or less, or .npy";
    assert!(run.stderr.contains(expected), "{}", run.stderr);
    folder.holds(&["a.fits", "a.npy", "a.png", "b.npy", "scene.toml"]);
}

#[test]
fn what_a_cube_can_not_be_is_refused() {
    let folder =
        Folder::with_scene(&format!("{CUBE}\n[build]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n"));
    let refused = |command: &str, text: &str| {
        let run = folder.emitree(command);
        run.fails_with(2);
        assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
        folder.holds(&["scene.toml"]);
    };
    refused(
        "build scene.toml -o t.fits",
        "scene.toml: `[energy]`: a tree holds rates of one energy: expected a scene without",
    );
    refused("render scene.toml -o a.npy --band b.jpg", "`b.jpg`: no format for this ending");
    refused("render scene.toml -o a.npy --band a.npy", "`a.npy` and `a.npy` are the same file");
    refused("render scene.toml -o a.npy --band no/b.npy", "`no/b.npy`: cannot create a file");
    refused(
        "render scene.toml -o a.npy --method paper --progressive f",
        "--progressive: `paper` has no frames of a cube: expected the method `vol`",
    );
    refused("render scene.toml -o a.npy --set energy.max=1", "`energy.max` is 1");
    refused(
        "render scene.toml -o a.npy --set emission.photon_energy=10",
        "photons have all energies",
    );
    refused("render scene.toml -o a.npy --set emission.unit=ph/cm3/s", "as in \"ph/cm3/s keV-1\"");
    refused(
        "render scene.toml -o a.npy --set image.unit=R",
        "with `[energy]` images are per unit of",
    );
}

#[test]
fn a_cube_whose_emission_fails_leaves_nothing() {
    let folder = Folder::with_scene(&CUBE.replace("1 + x", "ln(x - 0.5)"));
    let run = folder.emitree("render scene.toml -o a.fits --band b.npy --report r.json");
    run.fails_with(3);
    folder.holds(&["scene.toml"]);
}
