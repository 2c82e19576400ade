use super::super::{Override, Scene};
use super::*;
use emitree_models::{Interpolation, Outside};
use std::path::Path;

const REST: &str = r#"
[projection]
type = "canonical"

[image]
width = 4
height = 4
"#;

/// A scene that lies beside the reference grids.
fn parse(emission: &str) -> Result<EmissionSource, SceneError> {
    let name = format!("{}/tests/reference/grids/scene.toml", env!("CARGO_MANIFEST_DIR"));
    Scene::parse(&name, &format!("{emission}{REST}"), &[]).map(|scene| scene.emission.source)
}

fn grid(emission: &str) -> GridEmission {
    match parse(emission) {
        Ok(EmissionSource::Grid(grid)) => grid,
        other => panic!("{other:?}"),
    }
}

/// The error of an emission: its line, message and what was expected, with names of files and not
/// of folders.
fn error(emission: &str) -> (usize, String, String) {
    let error = parse(emission).unwrap_err();
    let folder = format!("{}/tests/reference/grids/", env!("CARGO_MANIFEST_DIR"));
    let message = error.message().replace(&folder, "");
    (error.line().unwrap().1, message, error.expected().to_owned())
}

fn expect(emission: &str, line: usize, message: &str, expected: &str) {
    assert_eq!(error(emission), (line, message.to_owned(), expected.to_owned()));
}

fn rate(emission: &EmissionSource, position: [f64; 3]) -> Result<f64, EmissionFailure> {
    let mut rate = [f64::NAN];
    let samples = [position];
    emission.emission_rates(&Samples::new(&samples, &[[0.0, 0.0, 1.0]]), &mut rate)?;
    Ok(rate[0])
}

#[test]
fn a_file_alone_is_a_grid() {
    let emission = parse("emission.grid = { file = \"smile.fits\" }\n").unwrap();
    // g = 100 z + 10 y + x of the indices.
    let middle = rate(&emission, [1.0, 0.25, 15.0]).unwrap();
    assert!((middle - 56.5).abs() < 1e-13, "{middle}");
    assert_eq!(rate(&emission, [1.0, 0.25, 20.5]).map(f64::to_bits), Ok(0));
    assert_eq!((emission.length_unit(), emission.image_unit()), (None, ""));
    let EmissionSource::Grid(grid) = emission else { panic!("{emission:?}") };
    assert_eq!(grid.unit.as_deref(), Some("cm-3 s-1"));
    assert!(grid.file.ends_with("grids/smile.fits"));
    assert_eq!(grid.grid.interpolation(), Interpolation::Linear);
    assert_eq!(grid.grid.outside(), Outside::Zero);
}

#[test]
fn every_key_does_what_it_says() {
    let scene = r#"
[emission.grid]
file = "compressed.npz"
format = "npz"
values = "rate"
x = "lon"
y = { min = -2, max = 2.0 }
z = [0, 1.5]
order = "zyx"
interpolation = "monotone"
outside = "error"
scale = 2
"#;
    let grid = grid(scene);
    assert_eq!(grid.grid.nodes(), [&[-1.0, 0.0, 2.0, 6.0][..], &[-2.0, 0.0, 2.0], &[0.0, 1.5]]);
    assert_eq!(grid.grid.values()[..5], [0.0, 2.0, 4.0, 6.0, 20.0]);
    assert_eq!(grid.grid.interpolation(), Interpolation::MonotoneCubic);
    assert_eq!(grid.grid.outside(), Outside::Error);
    let failure = rate(&EmissionSource::Grid(grid), [0.0, 3.0, 0.0]).unwrap_err();
    assert_eq!(
        failure.to_string(),
        "the position [0.0, 3.0, 0.0] is outside the grid: its y is 3, expected -2 to 2 \
         (or `emission.grid.outside = \"zero\"`)"
    );
}

#[test]
fn keys_are_checked_where_they_stand() {
    let with = |line: &str| format!("[emission.grid]\nfile = \"smile.fits\"\n{line}\n");
    let cases = [
        (
            "interpolation = \"quartic\"",
            "unknown interpolation `quartic`",
            "expected one of `linear`, `cubic`, `monotone`, `nearest`",
        ),
        (
            "outside = \"nan\"",
            "unknown answer outside the grid `nan`",
            "expected one of `zero`, `error`",
        ),
        (
            "format = \"vti\"",
            "unknown format `vti`",
            "expected one of `fits`, `npy`, `npz`, `hdf5`, `netcdf`, `vtk`",
        ),
        (
            "order = \"zzy\"",
            "`emission.grid.order` is \"zzy\"",
            "expected the names of the three axes in the order of the array's, as in \"zyx\" or \
             \"phi theta r\"",
        ),
        (
            "y = 3",
            "`emission.grid.y` is an integer",
            "expected the name of an array, a list of nodes, or { min = …, max = … }",
        ),
        ("y = [1, \"2\"]", "`emission.grid.y[1]` is a string", "expected a number"),
        (
            "y = { min = 2, max = 1 }",
            "`emission.grid.y.max` is 1",
            "expected more than 2, the `min`",
        ),
        (
            "y = { min = 2, most = 4 }",
            "`emission.grid.y.max` is missing",
            "expected `max` here: the coordinate of a node, in the length unit of the scene or \
             `angle_unit`",
        ),
        (
            "coordinates = \"polar\"",
            "unknown coordinates `polar`",
            "expected one of `cartesian`, `cylindrical`, `spherical`",
        ),
        ("angle_unit = \"°\"", "unknown unit of angles `°`", "expected one of `deg`, `rad`"),
        (
            "logarithmic = [\"r\"]",
            "`emission.grid.logarithmic[0]` is \"r\"",
            "expected \"x\", \"y\" or \"z\"",
        ),
        (
            "logarithmic = true",
            "`emission.grid.logarithmic` is a boolean",
            "expected a list of axes, each \"x\", \"y\" or \"z\"",
        ),
        ("r = [1, 2]", "unknown key `emission.grid.r`", "did you mean `x`?"),
        ("scale = nan", "`emission.grid.scale` is NaN", "expected a finite number"),
        ("scales = 3", "unknown key `emission.grid.scales`", "did you mean `scale`?"),
    ];
    for (line, message, expected) in cases {
        expect(&with(line), 3, message, expected);
    }
    let file = "`emission.grid.file` is missing";
    let expected = "expected `file` here: the name of a file of data, as in \"cube.fits\"";
    expect("[emission.grid]\n", 1, file, expected);
}

#[test]
fn what_a_file_contradicts_is_marked_at_its_key() {
    let with = |lines: &str| format!("[emission.grid]\nfile = \"smile.fits\"\n\n{lines}\n");
    let axis = "the values are an array of shape [2, 3, 4], with axes in the order zyx";
    let cases = [
        (
            with("values = \"flux\""),
            4,
            "it has no array `flux`: expected one of `PRIMARY`, `x`, `y`, `z`".to_owned(),
        ),
        (with("z = [0, 1, 2]"), 4, format!("the z axis: it has 3 nodes: expected 2, since {axis}")),
        (
            with("z = [1, 1]"),
            4,
            "node 1 of the z axis is 1 and follows 1: expected nodes that all increase or all decrease"
                .to_owned(),
        ),
        (
            with("x = \"lon\""),
            4,
            "the x axis: it has no array `lon`: expected one of `PRIMARY`, `x`, `y`, `z`"
                .to_owned(),
        ),
        // What the scene leaves out is the file's affair.
        (
            with("order = \"xyz\""),
            2,
            "the x axis: it has 4 nodes: expected 2, since the values are an array of shape \
             [2, 3, 4], with axes in the order xyz"
                .to_owned(),
        ),
        (
            with("format = \"npz\"").replace("smile.fits", "f8.npy"),
            2,
            "it can't be read as NPZ: ".to_owned(),
        ),
    ];
    for (scene, line, text) in cases {
        let name = if scene.contains("f8.npy") { "f8.npy" } else { "smile.fits" };
        let (found_line, message, expected) = error(&scene);
        let text = format!("`emission.grid`: the grid {name}: {text}");
        assert!(message.starts_with(&text), "{message}\n{text}");
        assert_eq!((found_line, expected.as_str()), (line, ""), "{message}");
    }
}

#[test]
fn a_scene_has_one_emission() {
    let expected = "expected only one of `expression = \"…\"`, `model = \"…\"`, \
                    `grid = { file = \"…\" }` or `tree = \"…\"`";
    for (emission, line) in [
        ("[emission]\nexpression = \"x\"\nmodel = \"cmem\"\n", 3),
        ("[emission]\ngrid = {}\nmodel = \"cmem\"\n", 2),
        ("[emission]\nexpression = \"x\"\ngrid = 3\n", 3),
    ] {
        expect(emission, line, "the scene has two emissions", expected);
    }
    expect("[emission]\ngrid = 3\n", 2, "`emission.grid` is an integer", "expected a table");
    let constants = "[emission]\ngrid = { file = \"smile.fits\" }\nconstants = { a = 1 }\n";
    assert_eq!(error(constants).1, "unknown key `emission.constants`");
}

#[test]
fn a_file_of_an_option_is_where_the_command_was_given() {
    let scene = format!("emission.grid.file = \"no.fits\"\n{REST}");
    let file = |value: &str| Override {
        key: "emission.grid.file".into(),
        value: value.into(),
        option: "--set".into(),
    };
    let open = |value: &str| Scene::parse("elsewhere/scene.toml", &scene, &[file(value)]);
    let error = Scene::parse("elsewhere/scene.toml", &scene, &[]).unwrap_err();
    let name = Path::new("elsewhere").join("no.fits");
    assert!(error.message().contains(&format!("the grid {}: ", name.display())), "{error}");
    let error = open("other.fits").unwrap_err();
    assert!(error.message().contains("the grid other.fits: "), "{error}");
    assert_eq!(error.line(), Some(("option --set", 1)));
    // Tests run in the folder of their package.
    assert!(open("tests/reference/grids/smile.fits").is_ok());
}

#[test]
fn a_function_has_a_name_and_no_rates() {
    let scene = Scene::parse(
        "scene.toml",
        "emission.function = \"models.peak\"\nprojection.type = \"canonical\"\nimage = { width = 1, \
         height = 1 }\n",
        &[],
    );
    let source = scene.unwrap().emission.source;
    assert!(matches!(&source, EmissionSource::Function(name) if name == "models.peak"));
    let failure = rate(&source, [0.0; 3]).unwrap_err().to_string();
    assert!(failure.starts_with("`emission.function` is `models.peak`, a function in Python"));
    let two =
        "emission = { function = \"f\", expression = \"x\" }\nprojection.type = \"canonical\"\n";
    let error = Scene::parse("scene.toml", two, &[]).unwrap_err();
    assert_eq!(error.message(), "the scene has two emissions");
}

/// A grid of spherical coordinates in `f8.npy`, an array of 2 x 3 x 4, with more lines.
fn spherical(lines: &str) -> String {
    format!("[emission.grid]\nfile = \"f8.npy\"\ncoordinates = \"spherical\"\n{lines}\n")
}

#[test]
fn spherical_grids_are_read() {
    let scene = spherical(
        "angle_unit = \"deg\"\nr = { min = 1, max = 27 }\nlatitude = [45, 0, -45]\n\
         phi = [0, 20]\nlogarithmic = [\"r\"]\ninterpolation = \"nearest\"",
    );
    let EmissionSource::Grid(emission) = parse(&scene).unwrap() else { panic!("{scene}") };
    let axes = emission.grid.axes();
    let [r, theta, phi] = axes.nodes();
    let close = |found: &[f64], expected: &[f64]| {
        found.len() == expected.len()
            && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-14 * b.abs().max(1.0))
    };
    assert!(close(r, &[1.0, 3.0, 9.0, 27.0]), "{r:?}");
    assert!(close(theta, &[45_f64, 90.0, 135.0].map(f64::to_radians)), "{theta:?}");
    assert!(close(phi, &[0.0, 20_f64.to_radians()]), "{phi:?}");
    assert_eq!(axes.are_logarithmic(), [true, false, false]);
    // g = 100 phi + 10 theta + r of the indices; 5 is nearer to 3 than to 9, by ratio.
    let source = EmissionSource::Grid(emission);
    assert_eq!(rate(&source, [5.0, 0.0, 0.0]).unwrap().to_bits(), 11.0_f64.to_bits());
    assert_eq!(rate(&source, [5.3, 0.0, 0.0]).unwrap().to_bits(), 12.0_f64.to_bits());
}

#[test]
fn angles_are_checked_in_their_unit() {
    let axes = |theta: &str, phi: &str, unit: &str| {
        spherical(&format!("r = [1, 2, 3, 4]\ntheta = {theta}\nphi = {phi}\n{unit}"))
    };
    let (rad, deg) = ("angle_unit = \"rad\"", "angle_unit = \"deg\"");
    let all = "(`angle_unit` is the unit of all angles)";
    let pi = std::f64::consts::PI;
    let cases = [
        (
            axes("[0, 90, 180]", "[0, 1]", rad),
            5,
            format!(
                "the theta axis: node 1 is 90 rad: expected a colatitude from 0 to {pi} rad {all}"
            ),
        ),
        (
            axes("[0, 90, 181]", "[0, 1]", deg),
            5,
            format!(
                "the theta axis: node 2 is 181 deg: expected a colatitude from 0 to 180 deg {all}"
            ),
        ),
        (
            axes("[0, 1, 3]", "[0, 350]", rad),
            6,
            format!(
                "the phi axis: it goes from 0 to 350 rad: expected at most a full turn, {} rad {all}",
                2.0 * pi
            ),
        ),
        (
            axes("[0, 1.6, 3.1416]", "[0, 180]", deg),
            5,
            "the theta axis: it goes from 0 to 3.1416 deg, which are pi in radians: expected \
             degrees, or `angle_unit` = \"rad\""
                .to_owned(),
        ),
        (
            axes("[0, 90, 180]", "[0, 3.1416]", deg),
            6,
            "the phi axis: it goes from 0 to 3.1416 deg, which are 2 pi in radians: expected \
             degrees, or `angle_unit` = \"rad\""
                .to_owned(),
        ),
        (
            axes("[0, 90, 80]", "[0, 180]", deg),
            5,
            "node 2 of the theta axis is 80 and follows 90: expected nodes that all increase or \
             all decrease"
                .to_owned(),
        ),
        (
            axes("[0, 90, 180]", "[0, 180]", ""),
            5,
            "the theta axis: the unit of its angles is not known: expected `angle_unit`, \"deg\" or \
             \"rad\""
                .to_owned(),
        ),
        (
            axes("[0, 90, 180]", "[0, 180]", &format!("{deg}\norder = \"zyx\"")),
            8,
            "the order of axes is given as zyx: expected the axes r, theta, phi".to_owned(),
        ),
    ];
    for (scene, line, text) in cases {
        let (found_line, message, _) = error(&scene);
        let expected = format!("`emission.grid`: the grid f8.npy: {text}");
        assert_eq!((found_line, message), (line, expected), "{scene}");
    }
    let both = spherical("theta = [0, 90]\nlatitude = [0, 90]");
    expect(&both, 5, "`emission.grid` has `theta` and `latitude`", "expected one of them");
}

/// The bounds and edges of a scene with a spherical grid of radii 1 to 4, by the evaluations of a line.
#[test]
fn data_declare_where_they_end() {
    let rest = "[projection]\ntype = \"orthographic\"\nposition = [-50, 0, 0]\n\
                target = [0, 0, 0]\nextent = [10, 10]\n[image]\nwidth = 4\nheight = 4\n";
    let emission =
        spherical("r = [1, 2, 3, 4]\ntheta = [0, 90, 180]\nphi = [0, 180]\nangle_unit = \"deg\"");
    let name = format!("{}/tests/reference/grids/scene.toml", env!("CARGO_MANIFEST_DIR"));
    let depths = |lines: &str| {
        let scene = Scene::parse(&name, &format!("{emission}{lines}{rest}"), &[]).unwrap();
        let ends =
            |z: f64| scene.camera.projection().world_from_canonical([0.5, 0.5, z]).position[0];
        [ends(1e-6), ends(1.0 - 1e-6)]
    };
    // No depths are needed: the sphere of the largest radius has them.
    let found = depths("");
    assert!((found[0] + 4.0).abs() < 1e-4 && (found[1] - 4.0).abs() < 1e-4, "{found:?}");
    let bounds = "[bounds]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 2.0\n";
    let found = depths(bounds);
    assert!((found[0] + 2.0).abs() < 1e-4 && (found[1] - 2.0).abs() < 1e-4, "{found:?}");
}
