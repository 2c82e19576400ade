//! Scenes with fields and tables: what they evaluate to, and every message with its line.

use super::super::super::Scene;
use super::super::{EmissionFailure, EmissionSource};
use emitree::{Emission, Samples};

const REST: &str = "[projection]\ntype = \"canonical\"\n[image]\nwidth = 4\nheight = 4\n";

fn parse_with(emission: &str, rest: &str) -> Result<Scene, super::SceneError> {
    let name = format!("{}/tests/reference/grids/scene.toml", env!("CARGO_MANIFEST_DIR"));
    Scene::parse(&name, &format!("{emission}{rest}"), &[])
}

fn parse(emission: &str) -> EmissionSource {
    parse_with(emission, REST).unwrap().emission.source
}

/// The line, the message and what was expected, with names of files and not of folders.
fn error(emission: &str) -> (usize, String, String) {
    let error = parse_with(emission, REST).unwrap_err();
    let folder = format!("{}/tests/reference/grids/", env!("CARGO_MANIFEST_DIR"));
    let message = error.message().replace(&folder, "");
    (error.line().unwrap().1, message, error.expected().to_owned())
}

fn rate(emission: &EmissionSource, position: [f64; 3]) -> Result<f64, EmissionFailure> {
    let mut rate = [f64::NAN];
    let (positions, directions, energies) = ([position], [[0.0, 0.0, 1.0]], [2.0]);
    let samples = Samples::new(&positions, &directions).at_energies(&energies);
    emission.emission_rates(&samples, &mut rate)?;
    Ok(rate[0])
}

/// G = 100 z + 10 y + x of the indices as `emissivity`, and 2 G as `other`.
const DATA: &str = "[emission]\ngrid = { file = \"extension.fits\" }\n";

#[test]
fn arrays_of_one_file_are_fields() {
    let scene = format!(
        "{DATA}fields = {{ n = \"emissivity\", T = \"other\" }}\nexpression = \"a*n*sqrt(T) + x\"\n\
         constants = {{ a = 3 }}\n"
    );
    let source = parse(&scene);
    // At a node, and half-way to the next along x.
    for (at, g) in [([2.0, 0.5, 20.0], 112.0), ([4.0, 0.5, 20.0], 112.5)] {
        let expected = 3.0 * g * f64::sqrt(2.0 * g) + at[0];
        assert!((rate(&source, at).unwrap() / expected - 1.0).abs() < 1e-14);
    }
    assert_eq!(rate(&source, [7.0, 0.5, 20.0]).map(f64::to_bits), Ok(0));
    assert_eq!(source.data_axes().len(), 1);
    assert_eq!((source.length_unit(), source.image_unit()), (None, ""));
}

#[test]
fn a_field_has_keys_of_its_own_and_those_of_the_grid() {
    let scene = "[emission]\nexpression = \"n + 1000*T + 1e6*v\"\n\
                 [emission.grid]\nfile = \"extension.fits\"\nscale = 2\noutside = \"error\"\n\
                 [emission.fields]\nn = \"emissivity\"\n\
                 T = { values = \"other\", interpolation = \"nearest\", scale = 1 }\n\
                 v = { file = \"plain.npz\", outside = \"zero\" }\n";
    let source = parse(scene);
    // x = 4.5 is nearer to 6 than to 2: n is 112.625 twice, T is 113 twice, v is 112.625 twice.
    let expected = 225.25 + 1000.0 * 226.0 + 1e6 * 225.25;
    assert!((rate(&source, [4.5, 0.5, 20.0]).unwrap() - expected).abs() < 1e-6);
    assert_eq!(
        rate(&source, [7.0, 0.5, 20.0]).unwrap_err().to_string(),
        "the field `T`: the position [7.0, 0.5, 20.0] is outside the grid: its x is 7, expected -1 \
         to 6 (or `emission.fields.T.outside = \"zero\"`, or that of `emission.grid`)"
    );
}

#[test]
fn tables_are_functions() {
    let scene = "[emission]\nexpression = \"n*Lambda(n, E) + f(2)\"\n\
                 grid = { file = \"extension.fits\" }\nfields = { n = \"emissivity\" }\n\
                 [emission.table.Lambda]\nfile = \"../tables/two.npz\"\naxes = [\"T\", \"n\"]\n\
                 logarithmic = [\"T\", \"n\", \"values\"]\noutside = \"edge\"\n\
                 [emission.table.f]\nfile = \"../tables/tables.fits\"\nextension = \"cooling\"\n\
                 scale = 2\n";
    let energy = "[energy]\nmin = 1\nmax = 3\nbins = 2\nunit = \"keV\"\n";
    let source = parse_with(scene, &format!("{energy}{REST}"));
    let source = source.unwrap().emission.source;
    // n²/T with T = n = 12 and n = E = 2; the other is 8/T at T = 1, 10, linear.
    let expected = 12.0 * 4.0 / 12.0 + 2.0 * (4.0 + (0.4 - 4.0) / 9.0);
    let found = rate(&source, [2.0, 0.5, 10.0]).unwrap();
    assert!((found - expected).abs() < 1e-13, "{found} {expected}");
    let beyond = "[emission]\nexpression = \"f(r)\"\ntable.f.file = \"../tables/tables.fits\"\n";
    assert_eq!(
        rate(&parse(beyond), [0.5, 0.0, 0.0]).unwrap_err().to_string(),
        "at the position [0.5, 0.0, 0.0]: the argument `T` of `f` is 0.5: expected 1 to 100, the \
         range of the table (or `emission.table.f.outside`, \"zero\" or \"edge\")"
    );
}

#[test]
fn what_is_wrong_is_marked_where_it_stands() {
    let with = |lines: &str| format!("{DATA}{lines}\n");
    let n = "expression = \"n\"\n";
    let cases = [
        (
            with(&format!("{n}fields = {{ n = \"rho\" }}")),
            4,
            "`emission.fields.n`: the grid extension.fits: it has no array `rho`: expected one of \
             `other`, `emissivity`, `x`, `y`, `z`",
            "",
        ),
        (
            with(&format!("{n}fields = {{ n = 3 }}")),
            4,
            "`emission.fields.n` is an integer",
            "expected the name of an array of `emission.grid`, or a table with the keys of a grid",
        ),
        (
            with(&format!("{n}fields = {{ n = {{ values = \"other\", interpolate = \"nearest\" }} }}")),
            4,
            "unknown key `emission.fields.n.interpolate`",
            "did you mean `interpolation`?",
        ),
        (
            with("expression = \"n\"\nfields = { n = \"other\", T = \"emissivity\" }"),
            4,
            "the field `T` is not used",
            "expected a name that stands in `emission.expression`",
        ),
        (
            with("expression = \"n*t\"\nfields = { n = \"other\", T = \"emissivity\" }"),
            3,
            "`emission.expression`: unknown name `t`: did you mean `T`?",
            "",
        ),
        (
            with("fields = { n = \"other\" }"),
            3,
            "`emission.fields` is for `emission.expression`",
            "expected `expression = \"…\"` too, which names them",
        ),
        (
            with("expression = \"x\""),
            2,
            "the scene has two emissions",
            "expected only one of `expression = \"…\"`, `model = \"…\"`, `grid = { file = \"…\" }` or \
             `tree = \"…\"`",
        ),
        (
            "[emission]\nexpression = \"n\"\nfields = { n = \"other\" }\n".to_owned(),
            3,
            "`emission.fields.n` is \"other\", and the scene has no `emission.grid`",
            "expected `grid = { file = \"…\" }` in `[emission]` too, the file that has this array, or a \
             table `{ file = \"…\" }` here",
        ),
        (
            "[emission]\nexpression = \"n\"\ngrid = { file = \"extension.fits\", values = \"other\" }\n\
             fields = { n = \"other\" }\n"
                .to_owned(),
            3,
            "`emission.grid.values` is given with `emission.fields`",
            "expected none: the fields name the arrays",
        ),
        (
            with("expression = \"f(2)\"\ntable.f.file = \"../tables/tables.fits\""),
            2,
            "`emission.grid` is not used",
            "expected `fields = { n = \"…\" }` too, which name its arrays",
        ),
        (
            with("expression = \"n*E\"\nfields = { n = \"other\" }"),
            3,
            "`emission.expression` depends on the energy `E`, and the scene has no `[energy]`",
            "expected a table `[energy]` too, with `min`, `max` and `bins`",
        ),
    ];
    for (scene, line, message, expected) in cases {
        let found = error(&scene);
        assert_eq!(
            (found.0, found.1.as_str(), found.2.as_str()),
            (line, message, expected),
            "{scene}"
        );
    }
}

#[test]
fn tables_are_checked_where_they_stand() {
    let with = |line: &str| {
        format!(
            "[emission]\nexpression = \"f(r)\"\n[emission.table.f]\nfile = \"../tables/two.npz\"\n{line}\n"
        )
    };
    let in_file = "`emission.table.f`: the table ../tables/two.npz: ";
    let cases = [
        (
            with("axes = [\"T\", \"m\"]"),
            5,
            format!("{in_file}it has no array `m`: expected one of `T`, `n`, `values`"),
            "",
        ),
        (
            with("axes = [\"T\", \"n\"]"),
            2,
            "`emission.expression`: the table `f` takes 2 arguments, not 1".to_owned(),
            "",
        ),
        (
            with("axes = []"),
            5,
            "`emission.table.f.axes` is a list of 0".to_owned(),
            "expected 1 to 3 names",
        ),
        (
            with("outside = \"clamp\""),
            5,
            "unknown answer outside the table `clamp`".to_owned(),
            "expected one of `error`, `zero`, `edge`",
        ),
        (
            with("logarithmic = true"),
            5,
            "`emission.table.f.logarithmic` is a boolean".to_owned(),
            "expected a list of names, of axes or of the values",
        ),
        (
            with("axes = [\"T\", \"n\"]\nlogarithmic = [\"t\"]"),
            6,
            format!(
                "{in_file}`t` is neither an axis nor the values: expected one of `T`, `n`, `values`"
            ),
            "",
        ),
        (
            "[emission]\nexpression = \"f(r)\"\ntable.f = \"two.csv\"\n".to_owned(),
            3,
            "`emission.table.f` is a string".to_owned(),
            "expected a table",
        ),
        (
            "[emission]\nexpression = \"f(r)\"\n[emission.table.f]\naxes = [\"T\"]\n".to_owned(),
            3,
            "`emission.table.f.file` is missing".to_owned(),
            "expected `file` here: the name of a file of a table, as in \"cooling.csv\"",
        ),
        (
            with("interpolation = \"nearest\""),
            5,
            "unknown key `emission.table.f.interpolation`".to_owned(),
            "expected one of `file`, `format`, `extension`, `axes`, `values`, `logarithmic`, \
             `outside`, `scale`",
        ),
    ];
    for (scene, line, message, expected) in cases {
        let found = error(&scene);
        assert_eq!((found.0, found.1, found.2.as_str()), (line, message, expected), "{scene}");
    }
}

#[test]
fn fields_have_steps() {
    let scene = |step: &str| {
        format!(
            "[emission]\nexpression = \"n\"\nfields = {{ n = \"values\" }}\n[emission.grid]\n\
             file = \"../steps/steps.npz\"\nstep = {step}\n"
        )
    };
    let at = [2.0, 0.5, 20.0];
    let cases = [
        ("0", 112.0),
        ("-1", 2112.0),
        ("{ value = 3.0, axis = \"t\" }", 1112.0),
        ("{ index = 1 }", 1112.0),
    ];
    for (step, expected) in cases {
        let found = rate(&parse(&scene(step)), at).unwrap();
        assert_eq!(found.to_bits(), f64::to_bits(expected), "{step}");
    }
    let number = "expected the number of a step, or { index = … } or { value = … } of one";
    let in_file = "`emission.fields.n`: the grid ../steps/steps.npz: ";
    let cases = [
        ("\"last\"", "`emission.grid.step` is a string".to_owned(), number),
        (
            "{ axis = \"t\" }",
            "`emission.grid.step` has not one of `index` and `value`".to_owned(),
            number,
        ),
        (
            "{ value = 11, axis = \"t\" }",
            format!(
                "{in_file}the step is that at 11: expected 0 to 10, the range of their coordinates"
            ),
            "",
        ),
    ];
    for (step, message, expected) in cases {
        let found = error(&scene(step));
        assert_eq!((found.0, found.1, found.2.as_str()), (6, message, expected), "{step}");
    }
}

/// A scene that knows no depths takes those of the data.
#[test]
fn fields_declare_where_they_end() {
    let rest = "[projection]\ntype = \"orthographic\"\nposition = [2, 0.5, 99]\n\
                target = [2, 0.5, 0]\nup = [0, 1, 0]\nextent = [1, 1]\n[image]\nwidth = 4\nheight = 4\n";
    let scene = format!("{DATA}expression = \"n\"\nfields = {{ n = \"other\" }}\n");
    let scene = parse_with(&scene, rest).unwrap();
    let depth = |z: f64| scene.camera.projection().world_from_canonical([0.5, 0.5, z]).position[2];
    assert!((depth(1e-9) - 20.0).abs() < 1e-6 && (depth(1.0 - 1e-9) - 10.0).abs() < 1e-6);
}
