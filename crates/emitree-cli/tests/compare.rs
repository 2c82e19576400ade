//! `emitree compare`, as users call it.
#![allow(clippy::unwrap_used, reason = "what fails here fails the test")]

use crate::support::{Folder, decode_png};
use emitree_io::encode_npy;

/// 16 times the integral of a ball along z, at two tolerances.
const BALL: &str = r#"
[emission]
expression = "16*exp(-20*((x - 0.5)^2 + (y - 0.5)^2 + (z - 0.5)^2))"
unit = "ph m-3 s-1 sr-1"

[projection]
type = "canonical"
length_unit = "m"

[image]
width = 12
height = 8
"#;

/// A folder with arrays of 2 x 3 numbers.
fn with_arrays(arrays: &[(&str, [f64; 6])]) -> Folder {
    let folder = Folder::with_scene(BALL);
    for (name, values) in arrays {
        std::fs::write(folder.path(name), encode_npy(&[2, 3], values).unwrap()).unwrap();
    }
    folder
}

#[test]
fn differences_are_told_with_their_place() {
    let a = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
    let folder = with_arrays(&[("a.npy", a), ("b.npy", [0.0, 1.0, 2.0, 3.5, 4.0, 5.0])]);
    let run = folder.emitree("compare a.npy b.npy");
    run.succeeds();
    let expected = "\
a.npy and b.npy: 3 x 2 pixels (width x height)
  largest      1.00e-1 of the largest pixel (5.000e-1), in row 1, column 0: 3e0 and 3.5e0
  rms          4.08e-2 of the largest pixel (2.041e-1); mean +1.67e-2 (+8.333e-2)
  scale        5.0000e0, the largest pixel of a.npy
";
    assert_eq!(run.stdout, expected);
    let run = folder.emitree("compare a.npy b.npy --tolerance 0.1");
    run.succeeds();
    assert!(run.stdout.ends_with("  within 10 % of the largest pixel\n"), "{}", run.stdout);
    let run = folder.emitree("compare a.npy b.npy --tolerance 0.09");
    run.fails_with(1);
    assert!(run.stdout.ends_with("  DIFFERENT: more than 9 % of the largest pixel\n"));
    let run = folder.emitree("compare a.npy a.npy -t 0");
    run.succeeds();
    assert!(run.stdout.contains("  largest      0: all numbers are the same\n"), "{}", run.stdout);
    let quiet = folder.emitree("compare a.npy b.npy -t 0 -q");
    quiet.fails_with(1);
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
}

#[test]
fn pixels_that_are_no_numbers_in_one_image_differ() {
    let a = [0.0, 1.0, 2.0, 3.0, 4.0, f64::NAN];
    let folder = with_arrays(&[("a.npy", a), ("b.npy", [f64::NAN, 1.0, 2.0, 3.0, 4.0, f64::NAN])]);
    let run = folder.emitree("compare a.npy b.npy --tolerance 0.5");
    run.fails_with(1);
    let text = "  no numbers   1 pixels are a number in one image only, the first one in row 0, column 0\n";
    assert!(run.stdout.contains(text), "{}", run.stdout);
    assert!(run.stdout.ends_with("  DIFFERENT: not all numbers are numbers in both\n"));
}

/// Renderings to two tolerances differ by less than both errors, and FITS has the error maps.
#[test]
fn renderings_are_compared_with_their_error_maps() {
    let folder = Folder::with_scene(BALL);
    folder.emitree("render scene.toml -o a.fits -o a.npy --tolerance 0.05").succeeds();
    folder.emitree("render scene.toml -o b.fits --tolerance 1e-6").succeeds();
    let run = folder.emitree("compare a.fits b.fits --tolerance 0.05 -o difference.png");
    run.succeeds();
    let errors = run.stdout.lines().find(|line| line.starts_with("  errors       at most "));
    let errors = errors.unwrap_or_else(|| panic!("{}", run.stdout));
    assert!(errors.contains(" times the sum of both errors, in row "), "{errors}");
    assert!(errors.ends_with("; 0 of 96 pixels (0 %) are above it"), "{errors}");
    assert!(run.stdout.contains(" ph m-2 s-1 sr-1), in row "), "{}", run.stdout);
    assert!(run.stdout.contains("  written      difference.png\n"));
    let (width, height, colours) = decode_png(&folder.bytes("difference.png"));
    assert!(width > 600 && height > 200 && colours.iter().any(|&part| part < 100));
    // Of two files one has an error map; units are those of the one that has some.
    let run = folder.emitree("compare a.npy b.fits");
    assert!(run.stdout.contains(" times the error, which one of them has, "), "{}", run.stdout);
    // 100 ph cm-2 are a ph m-2 times 1e6: the same radiance in another unit.
    folder
        .emitree(
            "render scene.toml -o c.fits --tolerance 1e-6 --set image.unit=\"ph cm-2 s-1 sr-1\"",
        )
        .fails_with(2);
    folder.emitree("render scene.toml -o c.fits --tolerance 1e-6 --set image={width=12,height=8,unit=\"ph/cm2/s/sr\"}").succeeds();
    let run = folder.emitree("compare b.fits c.fits --tolerance 1e-12");
    run.succeeds();
    assert!(run.stdout.contains("  unit         ph m-2 s-1 sr-1; "), "{}", run.stdout);
}

#[test]
fn cubes_have_bands() {
    let folder = Folder::with_scene(BALL);
    let values: Vec<f64> = (0..24).map(f64::from).collect();
    let mut other = values.clone();
    other[17] += 2.3;
    for (name, values) in [("a.npy", &values), ("b.npy", &other)] {
        std::fs::write(folder.path(name), encode_npy(&[2, 3, 4], values).unwrap()).unwrap();
    }
    let run = folder.emitree("compare a.npy b.npy -o d.png");
    run.succeeds();
    assert!(run.stdout.starts_with("a.npy and b.npy: 4 x 3 pixels (width x height), 2 bands\n"));
    let text =
        "1.00e-1 of the largest voxel (2.300e0), in band 1, row 1, column 1: 1.7e1 and 1.93e1\n";
    assert!(run.stdout.contains(text), "{}", run.stdout);
}

/// `HEALPix` maps of 48 pixels, in a table of FITS and in NPY.
#[test]
fn skies_are_compared_in_nested_order() {
    let folder = Folder::with_scene(
        "[emission]\nexpression = \"2 + z + if(z > 0.9, 0.1 * x, 0)\"\n[projection]\ntype = \"healpix\"\n\
         position = [0, 0, 0]\nfar = 1\n[image]\nnside = 2\n",
    );
    folder.emitree("render scene.toml -o a.fits -o a.npy --tolerance 0.05").succeeds();
    folder.emitree("render scene.toml -o b.fits --tolerance 1e-6").succeeds();
    let run = folder.emitree("compare a.fits b.fits --tolerance 0.05 -o d.png");
    run.succeeds();
    assert!(run.stdout.starts_with("a.fits and b.fits: 48 pixels of the sky (HEALPix)\n"));
    assert!(run.stdout.contains("; 0 of 48 pixels (0 %) are above it\n"), "{}", run.stdout);
    assert!(run.stdout.contains(", in pixel "), "{}", run.stdout);
    let (width, height, _) = decode_png(&folder.bytes("d.png"));
    assert!(width > height, "two ellipses side by side");
    let run = folder.emitree("compare a.fits a.npy --tolerance 0");
    run.succeeds();
    assert!(run.stdout.contains("  largest      0: all numbers are the same\n"), "{}", run.stdout);
    assert!(!run.stdout.contains("  errors  "), "{}", run.stdout);
    // Another order of the pixels is refused, and not compared pixel by pixel.
    let rings = String::from_utf8_lossy(&folder.bytes("a.fits")).find("'NESTED").unwrap() + 1;
    let mut bytes = folder.bytes("a.fits");
    bytes[rings..rings + 6].copy_from_slice(b"RING  ");
    std::fs::write(folder.path("rings.fits"), bytes).unwrap();
    let run = folder.emitree("compare a.fits rings.fits");
    run.fails_with(2);
    assert!(run.stderr.contains("ORDERING = 'RING': expected 'NESTED'"), "{}", run.stderr);
}

#[test]
fn failures_name_the_file_and_what_was_expected() {
    let folder = with_arrays(&[("a.npy", [1.0; 6])]);
    std::fs::write(folder.path("b.npy"), encode_npy(&[3, 2], &[1.0; 6]).unwrap()).unwrap();
    std::fs::write(folder.path("c.npy"), b"not an array").unwrap();
    let failures = [
        (
            "compare a.npy b.npy",
            "a.npy has 3 x 2 pixels (width x height) and b.npy 2 x 3 pixels (width x height): expected as many in both",
        ),
        ("compare a.npy c.npy", "c.npy: it can't be read as NPY: "),
        ("compare a.npy none.npy", "none.npy: it can't be read: "),
        ("compare a.png b.npy", "a.png: expected an image with numbers, .fits, .fit or .npy"),
        ("compare a.npy a.npy -t -1", "--tolerance: -1: expected a fraction of the largest pixel"),
        (
            "compare a.npy a.npy -o d.fits",
            "output: `d.fits`: the difference is a picture: expected a name that ends in .png",
        ),
    ];
    for (arguments, expected) in failures {
        let run = folder.emitree(arguments);
        run.fails_with(2);
        assert!(run.stderr.starts_with(&format!("emitree: {expected}")), "{}", run.stderr);
    }
    folder.holds(&["a.npy", "b.npy", "c.npy", "scene.toml"]);
}
