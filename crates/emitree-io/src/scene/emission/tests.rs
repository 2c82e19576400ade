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
            "interpolation = \"cubic\"",
            "unknown interpolation `cubic`",
            "expected one of `linear`, `monotone`",
        ),
        (
            "outside = \"nan\"",
            "unknown answer outside the grid `nan`",
            "expected one of `zero`, `error`",
        ),
        (
            "format = \"vtk\"",
            "unknown format `vtk`",
            "expected one of `fits`, `npy`, `npz`, `hdf5`, `netcdf`",
        ),
        (
            "order = \"zzy\"",
            "`emission.grid.order` is \"zzy\"",
            "expected the letters x, y and z in the order of the array's axes, as in \"zyx\"",
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
            "expected `max` here: the coordinate of a node, in the length unit of the scene",
        ),
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
            with("z = [1, 0]"),
            4,
            "node 1 of the z axis is 0 and follows 1: expected an axis that increases strictly"
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
