//! Scenes with several expressions: an image for each, as users have them.
#![allow(clippy::expect_used, clippy::unwrap_used, reason = "what fails here fails the test")]

use crate::support::{Folder, decode_png, pixels};
use emitree_models::means::gaussian;
use fits_well::FitsReader;
use std::io::Cursor;

/// Two Gaussians of different widths and sizes, and one that is 0.
const THREE: &str = r#"
[emission]
expressions = [
    "h*exp(-a*((x - 0.5)^2 + (y - 0.5)^2 + (z - 0.5)^2))",
    "h/100*exp(-9*a*((x - 0.4)^2 + (y - 0.5)^2 + (z - 0.6)^2))",
    "0*x",
]
components = ["wide", "narrow", "dark"]
constants = { a = 20.0, h = 3.0 }
unit = "ph m-3 s-1 sr-1"

[projection]
type = "canonical"
length_unit = "m"

[image]
width = 24
height = 20

[render]
tolerance = 0.001
"#;

const HEIGHT: usize = 20;
const WIDTH: usize = 24;

/// The exact image of h exp(−a |r − centre|²), means over pixels.
fn exact(h: f64, a: f64, [x, y, z]: [f64; 3]) -> Vec<f64> {
    let mean = |centre: f64, at: usize, count: usize| {
        let count = count as f64;
        gaussian(a, centre, at as f64 / count, (at + 1) as f64 / count)
    };
    let along = h * gaussian(a, z, 0.0, 1.0);
    let pixel = |at: usize| along * mean(x, at % WIDTH, WIDTH) * mean(y, at / WIDTH, HEIGHT);
    (0..HEIGHT * WIDTH).map(pixel).collect()
}

fn exact_components() -> [Vec<f64>; 3] {
    let wide = exact(3.0, 20.0, [0.5; 3]);
    [wide, exact(0.03, 180.0, [0.4, 0.5, 0.6]), vec![0.0; HEIGHT * WIDTH]]
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| value.abs().max(largest))
}

/// The pixels of an image of a FITS file, by its name.
fn hdu(fits: &[u8], name: &str) -> Vec<f64> {
    let mut reader = FitsReader::open(Cursor::new(fits)).unwrap();
    let is_named = |hdu: &fits_well::io::Hdu| {
        hdu.header.get_text("EXTNAME").unwrap().is_some_and(|found| found.trim() == name)
    };
    let at = reader.hdus().iter().position(is_named).expect(name);
    let mut values = Vec::new();
    reader.image(at).unwrap().physical_into(.., &mut values).unwrap();
    values
}

#[test]
fn every_component_has_its_exact_image_to_its_own_tolerance() {
    let folder = Folder::with_scene(THREE);
    let files = "-o a.fits -o a.npy -o a.png --error-map e.npy --report r.json";
    let run = folder.emitree(&format!("render scene.toml {files}"));
    run.succeeds();
    for text in [
        "scene.toml: 24 x 20 pixels (width x height), 3 components\n",
        " of all components together\n",
        "  wide         ",
        "  dark         0.0000e0 to 0.0000e0 ph m-2 s-1 sr-1, error 0.00e0 of its largest pixel",
        "  hint         dark: nothing is in view",
    ] {
        assert!(run.stdout.contains(text), "no `{text}` in:\n{}", run.stdout);
    }
    folder.holds(&[
        "a-dark.png",
        "a-narrow.png",
        "a-wide.png",
        "a.fits",
        "a.npy",
        "e.npy",
        "r.json",
        "scene.toml",
    ]);
    let (npy, fits, report) =
        (folder.bytes("a.npy"), folder.bytes("a.fits"), folder.json("r.json"));
    assert!(String::from_utf8_lossy(&npy[..128]).contains("'shape': (3, 20, 24)"));
    let (images, errors) = (pixels(&npy), pixels(&folder.bytes("e.npy")));
    let (mut alone, count) = (0, HEIGHT * WIDTH);
    for (number, (name, exact)) in
        ["wide", "narrow", "dark"].iter().zip(exact_components()).enumerate()
    {
        let [image, error] = [&images, &errors].map(|all| &all[number * count..][..count]);
        // The tolerance is relative to the component itself, though the second is a hundredth of the first.
        for (pixel, (found, exact)) in image.iter().zip(&exact).enumerate() {
            let difference = (found - exact).abs();
            assert!(difference <= 0.001 * largest(&exact_components()[number]), "{name}, {pixel}");
            assert!(difference <= error[pixel] + 1e-14, "{name}, {pixel}: {difference:e}");
        }
        assert!(largest(error) <= 0.001 * largest(&exact));
        assert_eq!(hdu(&fits, &name.to_uppercase()), image);
        assert_eq!(hdu(&fits, &format!("{}_ERROR", name.to_uppercase())), error);
        let evaluations = hdu(&fits, &format!("{}_EVALUATIONS", name.to_uppercase()));
        let of_this = &report["components"][name];
        let own = of_this["evaluations"].as_u64().unwrap();
        assert!((evaluations.iter().sum::<f64>() - own as f64).abs() < 0.5);
        assert_eq!(of_this["converged"], true);
        let in_report = of_this["image"]["max"].as_f64().unwrap();
        assert!((in_report - image.iter().copied().fold(0.0, f64::max)).abs() < 1e-15);
        alone += own;
    }
    let together = report["evaluations"].as_u64().unwrap();
    assert!(together < alone, "{together}, {alone}");
    assert_eq!(
        (&report["converged"], &report["image"]["unit"]),
        (&true.into(), &"ph m-2 s-1 sr-1".into())
    );
    for card in [
        "NCOMP   =                    3",
        "COMP1   = 'wide    '",
        "COMP3   = 'dark    '",
        "ESTER2  = ",
    ] {
        assert!(fits.windows(card.len()).any(|bytes| bytes == card.as_bytes()), "{card}");
    }
    let (width, height, _) = decode_png(&folder.bytes("a-narrow.png"));
    assert_eq!([width, height], [WIDTH, HEIGHT]);
}

/// Each component has the bits and the evaluations of its expression alone.
#[test]
fn a_component_is_what_its_expression_alone_is() {
    let folder = Folder::with_scene(THREE);
    folder.emitree("render scene.toml -o all.npy --report all.json --threads 2 --quiet").succeeds();
    let all = pixels(&folder.bytes("all.npy"));
    let alone = THREE.replace("components = [\"wide\", \"narrow\", \"dark\"]", "").replace(
        "expressions = [",
        "expression = \"h/100*exp(-9*a*((x - 0.4)^2 + (y - 0.5)^2 + (z - 0.6)^2))\"\n#",
    );
    let lines = alone.lines().filter(|line| !line.starts_with("    \"") && *line != "]");
    let alone = lines.collect::<Vec<_>>().join("\n");
    std::fs::write(folder.path("alone.toml"), alone).unwrap();
    folder.emitree("render alone.toml -o one.npy --report one.json --threads 1 --quiet").succeeds();
    assert_eq!(pixels(&folder.bytes("one.npy")), &all[HEIGHT * WIDTH..2 * HEIGHT * WIDTH]);
    let evaluations = &folder.json("all.json")["components"]["narrow"]["evaluations"];
    assert_eq!(evaluations, &folder.json("one.json")["evaluations"]);
    folder
        .emitree("render scene.toml -o again.npy --report again.json --threads 1 --quiet")
        .succeeds();
    assert_eq!(folder.bytes("again.npy"), folder.bytes("all.npy"));
    assert_eq!(folder.json("again.json")["evaluations"], folder.json("all.json")["evaluations"]);
}

#[test]
fn components_without_names_are_numbered_and_skies_and_cubes_have_them() {
    let scene = "emission = { expressions = [\"exp(-r^2)*E\", \"2*exp(-r^2)\"] }\n\
                 projection = { type = \"healpix\", position = [0, 0, 0], far = 4 }\n\
                 image = { nside = 4 }\nenergy = { min = 1, max = 3, bins = 2 }\n";
    let folder = Folder::with_scene(scene);
    folder.emitree("render scene.toml -o a.fits -o a.npy").succeeds();
    folder.emitree("render scene.toml -o b.fits --tolerance 1e-3").succeeds();
    let npy = folder.bytes("a.npy");
    assert!(String::from_utf8_lossy(&npy[..128]).contains("'shape': (2, 2, 192)"));
    let fits = folder.bytes("a.fits");
    for column in ["COMPONENT_1_1", "COMPONENT_2_2", "COMPONENT_1_ERROR_2", "COMPONENT_2_BAND"] {
        let value = format!("= '{column}'");
        assert!(fits.windows(value.len()).any(|bytes| bytes == value.as_bytes()), "{column}");
    }
    let run = folder.emitree("compare a.fits b.fits --tolerance 0.01");
    run.succeeds();
    assert!(run.stdout.contains("192 pixels of the sky (HEALPix), 4 bands"), "{}", run.stdout);
    assert!(run.stdout.contains("sum of both errors"), "{}", run.stdout);
    // ∫ exp(−s²) ds over 0 to 4 is √π/2 to 2e-8, and the mean energies of the bins are 1.5 and 2.5.
    let root = core::f64::consts::PI.sqrt() / 2.0;
    for (band, expected) in pixels(&npy).chunks(192).zip([1.5, 2.5, 2.0, 2.0]) {
        assert!(band.iter().all(|pixel| (pixel / (expected * root) - 1.0).abs() < 0.01));
    }
}

#[test]
fn comparisons_see_all_components() {
    let folder = Folder::with_scene(THREE);
    folder.emitree("render scene.toml -o a.fits -o a.npy --quiet").succeeds();
    let run = folder.emitree("compare a.fits a.npy --tolerance 0");
    run.succeeds();
    assert!(run.stdout.contains("24 x 20 pixels (width x height), 3 bands"), "{}", run.stdout);
    folder.emitree("render scene.toml -o b.fits --set emission.constants.a=19 --quiet").succeeds();
    folder.emitree("compare a.fits b.fits --tolerance 0.01").fails_with(1);
}

#[test]
fn checks_forecast_each_component() {
    let folder = Folder::with_scene(THREE);
    let run = folder.emitree("check scene.toml");
    run.succeeds();
    for text in [
        "  emission     expressions of wide, narrow, dark [ph m-3 s-1 sr-1]\n",
        "  component    narrow, by itself:\n  forecast     some ",
        "scene.toml: 1 remark\n",
    ] {
        assert!(run.stdout.contains(text), "no `{text}` in:\n{}", run.stdout);
    }
}

#[test]
fn what_there_is_of_one_emission_is_refused() {
    let folder =
        Folder::with_scene(&format!("{THREE}\n[build]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n"));
    let one =
        "the scene has several `emission.expressions`: expected a single `emission.expression`";
    for option in [
        "--surfaces s.vtp",
        "--progressive frames",
        "--by-rows",
        "--counts c.fits",
        "--band b.fits",
    ] {
        let run = folder.emitree(&format!("render scene.toml -o a.fits {option}"));
        run.fails_with(2);
        let name = option.split_whitespace().next().unwrap();
        assert_eq!(run.stderr, format!("emitree: {name}: {one}\n"));
    }
    let run = folder.emitree("build scene.toml -o tree.fits");
    run.fails_with(2);
    assert!(run.stderr.contains("`emission.expressions`: a tree holds one rate at each point"));
    let over = "--over emission.constants.a=10:20:3";
    let run = folder.emitree(&format!("sweep scene.toml {over} -o a-{{a}}.fits"));
    run.fails_with(2);
    assert!(run.stderr.contains("`emission.expressions`: a sweep has one image for each value"));
    let run = folder.emitree("plan scene.toml -o points.npz");
    run.fails_with(2);
    assert!(run.stderr.contains("`emission.expressions` in a scene whose rates another program"));
    folder.holds(&["scene.toml"]);
}

#[test]
fn failures_name_their_component() {
    let folder = Folder::with_scene(&THREE.replace("\"0*x\"", "\"1/(x - x)\""));
    let run = folder.emitree("render scene.toml -o a.fits");
    run.fails_with(3);
    assert!(run.stderr.contains("component dark: the emission rate is inf at"), "{}", run.stderr);
    folder.holds(&["scene.toml"]);
    let folder = Folder::with_scene(THREE);
    let run = folder.emitree("render scene.toml -o a.npy --max-evaluations 2000");
    run.fails_with(4);
    assert!(run.stdout.contains("  NOT CONVERGED: narrow, ended by budget"), "{}", run.stdout);
}
