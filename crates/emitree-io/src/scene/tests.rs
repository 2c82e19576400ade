use super::*;
use emitree::los::{LosOptions, Steps};
use emitree::quadrature::CellRule;
use emitree::refinement::Threshold;
use emitree::tree::BuildOptions;
use emitree::vol::Seed;
use emitree::{Method, VolOptions};

const SCENE: &str = r#"
[emission]
expression = "exp(-a*x^2)"
constants = { a = 100.0 }

[projection]
type = "canonical"

[image]
width = 50
height = 100

[render]
method = "paper"
threshold = 0.038
base_level = 2
"#;

const SMILE: &str = r#"
[emission]
model = "cmem"
parameters = { density = 5.0 }

[projection]
type = "equirectangular"
position = [10, -30.0, 0.0]
target = [6.0, 0.0, 0.0]
field_of_view = [16.0, 27.0]
far = 80.0
length_unit = "R_E"

[image]
width = 50
height = 100

[render]
method = "los"
steps = 160
"#;

/// All of method `vol`, and two seeds.
const KNOTS: &str = r#"
[emission]
expression = "exp(-x^2)"

[projection]
type = "canonical"

[image]
width = 50
height = 100

[[seed]]
position = [0.3, 0.62, 0.4]
radius = 0.01

[[seed]]
position = [1, 0, 0]
radius = 2

[render]
method = "vol"
tolerance = 0.02
base_level = 4
max_evaluations = 20_000
batch_size = 500
"#;

/// The error of a scene with one text replaced: its line, message, and what was expected.
fn error(scene: &str, from: &str, to: &str) -> (usize, String, String) {
    assert!(scene.contains(from), "{from}");
    let error = Scene::parse("scene.toml", &scene.replacen(from, to, 1), &[]).unwrap_err();
    let (name, line) = error.line().unwrap();
    assert_eq!(name, "scene.toml");
    (line, error.message().to_owned(), error.expected().to_owned())
}

fn expect(scene: &str, [from, to]: [&str; 2], line: usize, message: &str, expected: &str) {
    assert_eq!(error(scene, from, to), (line, message.to_owned(), expected.to_owned()));
}

fn option(key: &str, value: &str) -> Override {
    Override { key: key.into(), value: value.into(), option: format!("--{key}") }
}

fn render_of(overrides: &[Override]) -> Result<RenderSettings, SceneError> {
    Scene::parse("scene.toml", SMILE, overrides).map(|scene| scene.render)
}

#[test]
fn a_scene_is_read() {
    let scene = Scene::parse("scene.toml", SCENE, &[]).unwrap();
    assert_eq!((scene.height, scene.width), (100, 50));
    assert_eq!(scene.render.method.name(), "paper");
    let expected = BuildOptions::new(Threshold::Absolute(0.038)).with_base_level(2);
    assert_eq!(scene.render.method, Method::Paper(expected));
    assert_eq!((scene.image_unit(), &scene.length_unit), ("", &None));

    let scene = Scene::parse("scene.toml", SMILE, &[]).unwrap();
    assert_eq!(scene.length_unit.as_deref(), Some("R_E"));
    assert_eq!(scene.image_unit(), "keV cm-2 s-1 sr-1");
    let expected = LosOptions::new(1, Steps::Fixed(160));
    assert_eq!(scene.render.method, Method::Los(expected));
}

#[test]
fn options_replace_values() {
    let overrides = [
        option("image.width", "7"),
        option("emission.constants.a", "2"),
        option("image.width", "9"),
    ];
    let scene = Scene::parse("scene.toml", SCENE, &overrides).unwrap();
    assert_eq!((scene.height, scene.width), (100, 9));
    assert_eq!(scene.overrides[1], "emission.constants.a = 2");
    // Words need no quotes, as on any command line.
    let changes = [
        option("render.method", "paper"),
        option("render.threshold", "2%"),
        option("render.rule", "simpson"),
    ];
    let settings = render_of(&changes).unwrap();
    let Method::Paper(options) = settings.method else { panic!("{settings:?}") };
    assert_eq!((options.threshold, options.rule), (Threshold::Relative(0.02), CellRule::Simpson));
}

#[test]
fn an_error_in_an_option_names_the_option() {
    let error = render_of(&[option("render.order", "three")]).unwrap_err();
    assert_eq!(error.line(), Some(("option --render.order", 1)));
    assert_eq!(error.message(), "`render.order` is a string");
    assert_eq!(error.expected(), "expected an odd number from 1 to 9");
    let error = render_of(&[option("render.ordre", "3")]).unwrap_err();
    assert_eq!(error.message(), "unknown key `render.ordre`");
    assert_eq!(error.expected(), "did you mean `order`?");
    let error = render_of(&[option("image.width", "9999999999999999999")]).unwrap_err();
    assert_eq!(error.message(), "`image.width` is an integer beyond 64 bits");
    let error = render_of(&[option("emission.model", "it's \u{e9}")]).unwrap_err();
    assert!(error.message().starts_with("unknown model `it's \u{e9}`"), "{error}");
    let error = render_of(&[option("image.width", "10\nimage.height=3")]).unwrap_err();
    assert_eq!(error.message(), "`image.width` is a string");
    let error = render_of(&[option("bad key", "3")]).unwrap_err();
    assert_eq!(error.message(), "the scene is not valid TOML");
}

#[test]
fn adaptive_or_uniform_steps_the_later_option_counts() {
    let steps = |overrides: &[Override]| match render_of(overrides).unwrap().method {
        Method::Los(options) => options.steps,
        method => panic!("{method:?}"),
    };
    assert_eq!(steps(&[]), Steps::Fixed(160));
    assert_eq!(steps(&[option("render.tolerance", "0.01")]), Steps::Adaptive(0.01));
    let both = [option("render.tolerance", "0.01"), option("render.steps", "20")];
    let error = render_of(&both).unwrap_err();
    assert_eq!(error.message(), "both `tolerance` and `steps` are given");
    // A tolerance for `vol` in the scene does not keep anyone from asking for steps.
    let scene = SMILE.replace("steps = 160", "tolerance = 0.01");
    let settings = |change| Scene::parse("scene.toml", &scene, change).unwrap().render;
    assert_eq!(settings(&[]).tolerance, Some(0.01));
    let fixed = settings(&[option("render.steps", "20")]);
    assert_eq!(fixed.tolerance, None);
    assert_eq!(fixed.method, Method::Los(LosOptions::new(1, Steps::Fixed(20))));
}

#[test]
fn unknown_keys_are_refused_where_they_stand() {
    let message = "unknown key `image.widht`";
    expect(SCENE, ["width = 50", "widht = 50\nwidth = 50"], 10, message, "did you mean `width`?");
    let message = "unknown key `colour`";
    let keys = "expected one of `emission`, `energy`, `projection`, `time`, `instrument`, `absorption`, `occulter`, \
                `bounds`, `edge`, `singularity`, `image`, `seed`, `render`, `build`, `sky`";
    expect(SCENE, ["\n[emission]", "colour = 3\n[emission]"], 1, message, keys);
    let message = "unknown key `projection.far`";
    expect(
        SCENE,
        ["\"canonical\"", "\"canonical\"\nfar = 3"],
        8,
        message,
        "expected one of `type`, `length_unit`",
    );
}

#[test]
fn wrong_types_are_named() {
    let pixels = "expected a number of pixels, 1 to 2^24";
    expect(SCENE, ["50", "\"50\""], 10, "`image.width` is a string", pixels);
    expect(SCENE, ["50", "50.5"], 10, "`image.width` is a number", pixels);
    expect(SCENE, ["50", "-50"], 10, "`image.width` is -50", pixels);
    expect(SCENE, ["50", "0"], 10, "`image.width` is 0", pixels);
    let table = "expected a table";
    let message = "the scene is not valid TOML";
    expect(SCENE, ["\n[emission]", "image = 3\n[emission]"], 9, message, "duplicate key");
    expect(SCENE, ["{ a = 100.0 }", "3"], 4, "`emission.constants` is an integer", table);
    let message = "`emission.constants.a` is a boolean";
    expect(SCENE, ["100.0", "true"], 4, message, "expected a number");
    let message = "`emission.constants.a` is inf";
    expect(SCENE, ["100.0", "inf"], 4, message, "expected a finite number");
    let message = "`projection.target` is an array of 2";
    expect(SMILE, ["6.0, 0.0, 0.0", "6.0, 0.0"], 9, message, "expected three numbers [x, y, z]");
    let message = "`projection.position[1]` is a string";
    expect(SMILE, ["-30.0", "\"a\""], 8, message, "expected a number");
}

#[test]
fn missing_parts_say_what_is_missing() {
    expect(
        SCENE,
        ["[projection]\ntype = \"canonical\"", ""],
        1,
        "the scene has no `[projection]`",
        "expected a table `[projection]` with `type` = `canonical`, `orthographic`, \
         `perspective`, `equirectangular`, `polar`, `fisheye` or `healpix`",
    );
    let message = "`image.height` is missing";
    let expected = "expected `height` here: a number of pixels, 1 to 2^24";
    expect(SCENE, ["height = 100", ""], 9, message, expected);
    let message = "`projection.far` is missing";
    let expected = "expected `far` here: a depth in `length_unit`, or inf (or a table `[bounds]`)";
    expect(SMILE, ["far = 80.0", ""], 6, message, expected);
    let message = "the scene has no emission";
    let expected = "expected `expression = \"…\"`, `model = \"…\"`, `grid = { file = \"…\" }` or \
                    `tree = \"…\"` here";
    expect(SMILE, ["model = \"cmem\"\nparameters = { density = 5.0 }", ""], 2, message, expected);
}

#[test]
fn models_and_their_parameters_are_checked_where_they_stand() {
    let (line, message, _) = error(SMILE, "\"cmem\"", "\"cmen\"");
    assert_eq!(line, 3);
    assert!(message.starts_with("unknown model `cmen`: did you mean `cmem`?"), "{message}");
    let (line, message, _) = error(SMILE, "{ density = 5.0 }", "{ densty = 5.0 }");
    assert_eq!(line, 4);
    assert!(message.contains("no parameter `densty`: did you mean `density`?"), "{message}");
    let (line, message, _) = error(SMILE, "density = 5.0", "density = -5.0");
    assert_eq!(line, 4);
    assert!(message.contains("`density` of model `cmem` is -5.0: expected"), "{message}");
    let message = "`length_unit` is \"s\": ";
    let (line, found, expected) = error(SMILE, "\"R_E\"", "\"s\"");
    assert!(line == 12 && found.starts_with(message), "{line}: {found}");
    let of_model = "expected \"R_E\", the length unit of the emission, or another";
    assert_eq!(expected, of_model);
}

#[test]
fn expressions_are_marked_where_they_are_wrong() {
    let text = SCENE.replace("exp(-a*x^2)", "exp(-a*q^2)");
    let error = Scene::parse("scene.toml", &text, &[]).unwrap_err();
    assert!(error.message().contains("unknown name `q`"), "{}", error.message());
    let span = miette::Diagnostic::labels(&error).unwrap().next().unwrap();
    assert_eq!(&text[span.offset()..span.offset() + span.len()], "q");
    // In a string of several lines too, whose first line break TOML drops.
    let text = SCENE.replace("\"exp(-a*x^2)\"", "\"\"\"\n  1 +\n  exp(-a*q^2)\"\"\"");
    let error = Scene::parse("scene.toml", &text, &[]).unwrap_err();
    let span = miette::Diagnostic::labels(&error).unwrap().next().unwrap();
    assert_eq!(
        (&text[span.offset()..span.offset() + span.len()], error.line().unwrap().1),
        ("q", 5)
    );
    let (line, message, _) = self::error(SCENE, "exp(-a*x^2)", "exp(-a*x^2");
    assert_eq!(line, 3);
    assert!(message.starts_with("`emission.expression`: "), "{message}");
    let message = "the constant `b` is not used";
    let expected = "expected a name that stands in `emission.expression`";
    expect(SCENE, ["a = 100.0", "a = 100.0, b = 1"], 4, message, expected);
}

#[test]
fn cameras_that_make_no_sense_are_refused() {
    let message = "`[projection]`: `field_of_view` is 400: expected a width in (0, 360] degrees";
    expect(SMILE, ["16.0, 27.0", "400, 27.0"], 10, message, "");
    let (line, message, _) = error(SMILE, "[6.0, 0.0, 0.0]", "[10.0, -30.0, 0.0]");
    assert_eq!(line, 9);
    assert!(message.contains("expected two different points"), "{message}");
    let (line, message, _) = error(SMILE, "far = 80.0", "far = 80.0\nup = [-4.0, 30.0, 0.0]");
    assert_eq!(line, 12);
    assert!(message.contains("is along the pointing"), "{message}");
    let kinds = "expected `canonical`, `orthographic`, `perspective`, `equirectangular`, `polar`, \
                 `fisheye` or `healpix`";
    expect(SMILE, ["equirectangular", "round"], 7, "unknown projection `round`", kinds);
}

#[test]
fn options_that_the_method_has_not_are_noted() {
    assert_eq!(render_of(&[]).unwrap().ignored, Vec::<&str>::new());
    let paper = render_of(&[option("render.method", "paper"), option("render.tolerance", "0.1")]);
    assert_eq!(paper.unwrap().ignored, ["steps", "tolerance"]);
    let los = render_of(&[option("render.order", "5"), option("render.threshold", "1%")]);
    assert_eq!(los.unwrap().ignored, ["order", "threshold"]);
}

#[test]
fn render_settings_out_of_range_are_refused() {
    let message = "`render.base_level` is 11";
    expect(
        SCENE,
        ["base_level = 2", "base_level = 11"],
        16,
        message,
        "expected a level from 1 to 10",
    );
    let levels = "base_level = 2\nfinest_level = 2";
    let message = "`render.finest_level` is 2";
    expect(SCENE, ["base_level = 2", levels], 17, message, "expected a level from 3 to 19");
    let odd = "expected an odd number from 1 to 9";
    expect(SCENE, ["base_level = 2", "order = 4"], 16, "`render.order` is 4", odd);
    let sizes = "expected a size above 0 in the units of g, or a string such as \"1%\"";
    expect(SCENE, ["0.038", "-1"], 15, "`render.threshold` is -1", sizes);
    expect(SCENE, ["0.038", "\"1 percent\""], 15, "`render.threshold` is \"1 percent\"", sizes);
    let message = "unknown method `volume`";
    expect(SCENE, ["\"paper\"", "\"volume\""], 14, message, "expected `vol`, `paper` or `los`");
    let budget = "expected a number of evaluations, 1 or more";
    let add = ["base_level = 2", "max_evaluations = 0"];
    expect(SCENE, add, 16, "`render.max_evaluations` is 0", budget);
    let add = ["base_level = 2", "tolerance = 0"];
    expect(SCENE, add, 16, "`render.tolerance` is 0", "expected a fraction above 0, as in 0.01");
    let batch = "expected a number of evaluations in a batch, 1 or more";
    let add = ["base_level = 2", "batch_size = 0"];
    expect(SCENE, add, 16, "`render.batch_size` is 0", batch);
    let add = ["base_level = 2", "batch_size = 1.5"];
    expect(SCENE, add, 16, "`render.batch_size` is a number", batch);
    let rounds = "expected a number of rounds, 1 or more";
    let add = ["base_level = 2", "rounds = 0"];
    expect(SCENE, add, 16, "`render.rounds` is 0", rounds);
}

#[test]
fn rounds_are_an_option_of_every_method() {
    for method in ["vol", "paper", "los"] {
        let to = format!("\"{method}\"\nrounds = 6");
        let scene = SCENE.replace("threshold = 0.038\nbase_level = 2\n", "");
        let scene = Scene::parse("scene.toml", &scene.replace("\"paper\"", &to), &[]).unwrap();
        assert_eq!((scene.render.rounds, scene.render_options().rounds), (Some(6), Some(6)));
        assert_eq!(scene.render.ignored, Vec::<&str>::new());
    }
}

#[test]
fn an_emission_may_be_missing_where_another_program_has_it() {
    let (_, without) = SCENE.split_once("[projection]").unwrap();
    let without = format!("[projection]{without}");
    for text in [without.clone(), format!("emission.unit = \"ph cm-3 s-1 sr-1\"\n{without}")] {
        let text = text.replace("\"canonical\"", "\"canonical\"\nlength_unit = \"cm\"");
        let scene = Scene::parse_planned("scene.toml", &text, &[]).unwrap();
        assert!(matches!(&scene.emission.source, EmissionSource::Function(_)));
    }
    let error = Scene::parse("scene.toml", &without, &[]).unwrap_err().to_string();
    assert_eq!(error, "the scene has no `[emission]`");
    for (name, slip) in [("emission", "emision"), ("projection", "projecton")] {
        let text = SCENE.replace(&format!("[{name}]"), &format!("[{slip}]"));
        let error = Scene::parse("scene.toml", &text, &[]).unwrap_err().to_string();
        assert_eq!(error, format!("unknown key `{slip}`"));
    }
}

#[test]
fn the_method_is_vol_unless_another_is_named() {
    let settings = |scene: &str| Scene::parse("scene.toml", scene, &[]).unwrap().render;
    let (before, after) = SCENE.split_once("[render]").unwrap();
    for scene in [before, &format!("{before}[render]")] {
        let settings = settings(scene);
        assert_eq!(settings.method, Method::Vol(VolOptions::new(0.01)));
        assert_eq!(settings.tolerance, Some(0.01));
        assert_eq!((settings.max_evaluations, settings.batch_size), (None, None));
        assert_eq!(settings.ignored, Vec::<&str>::new());
    }
    let settings = settings(&format!("{before}[render]{}", after.replace("method", "# method")));
    assert_eq!(settings.method, Method::Vol(VolOptions::new(0.01).with_base_level(2)));
    assert_eq!(settings.ignored, ["threshold"]);
    let changes = [option("render.tolerance", "1e-4"), option("render.base_level", "7")];
    let settings = Scene::parse("scene.toml", before, &changes).unwrap().render;
    assert_eq!(settings.method, Method::Vol(VolOptions::new(1e-4).with_base_level(7)));
    assert_eq!(settings.tolerance, Some(1e-4));
}

/// The seeds of method `vol`.
fn seeds(settings: &RenderSettings) -> &[Seed] {
    match &settings.method {
        Method::Vol(vol) => &vol.seeds,
        other => panic!("{other:?} has no seeds"),
    }
}

#[test]
fn all_options_of_vol_are_read() {
    let settings = Scene::parse("scene.toml", KNOTS, &[]).unwrap().render;
    let seeds = [([0.3, 0.62, 0.4], 0.01), ([1.0, 0.0, 0.0], 2.0)];
    let seeds = seeds.map(|(position, radius)| Seed { position, radius }).to_vec();
    assert_eq!(
        settings.method,
        Method::Vol(VolOptions::new(0.02).with_base_level(4).with_seeds(seeds))
    );
    assert_eq!((settings.max_evaluations, settings.batch_size), (Some(20_000), Some(500)));
    assert_eq!(settings.ignored, Vec::<&str>::new());
    // A tolerance of the image and steps of other methods are no contradiction.
    let scene = KNOTS.replace("tolerance", "rule = \"simpson\"\nsteps = 9\ntolerance");
    let settings = Scene::parse("scene.toml", &scene, &[option("render.order", "5")]).unwrap();
    assert_eq!(settings.render.ignored, ["order", "rule", "steps"]);
    for method in ["paper", "los"] {
        let settings = Scene::parse("scene.toml", KNOTS, &[option("render.method", method)]);
        assert_eq!(settings.unwrap().render.ignored.last(), Some(&"seed"));
    }
}

#[test]
fn settings_of_vol_out_of_range_are_refused() {
    let fraction = "expected a fraction above 0 and below 1, as in 0.01";
    let tolerance = |to: &str, message: &str, expected: &str| {
        expect(KNOTS, ["tolerance = 0.02", &format!("tolerance = {to}")], 22, message, expected);
    };
    tolerance("0", "`render.tolerance` is 0", fraction);
    tolerance("-0.1", "`render.tolerance` is -0.1", fraction);
    tolerance("1", "`render.tolerance` is 1", fraction);
    tolerance("2", "`render.tolerance` is 2", fraction);
    tolerance("inf", "`render.tolerance` is inf", "expected a finite number");
    tolerance("nan", "`render.tolerance` is NaN", "expected a finite number");
    tolerance("\"x\"", "`render.tolerance` is a string", "expected a number");
    let levels = "expected a level from 2 to 7";
    for level in ["1", "9", "300"] {
        let message = format!("`render.base_level` is {level}");
        expect(KNOTS, ["base_level = 4", &format!("base_level = {level}")], 23, &message, levels);
    }
    // Method `los` accepts very large tolerances.
    let los = [option("render.method", "los"), option("render.tolerance", "2")];
    assert_eq!(Scene::parse("scene.toml", KNOTS, &los).unwrap().render.tolerance, Some(2.0));
}

#[test]
fn seeds_that_are_wrong_are_refused_where_they_stand() {
    let [point, radius] = ["expected three numbers [x, y, z]", "expected a length above 0"];
    let missing = "expected `radius` here: a length above 0";
    expect(KNOTS, ["radius = 0.01", ""], 12, "`seed[0].radius` is missing", missing);
    let missing = "expected `position` here: three numbers [x, y, z]";
    expect(KNOTS, ["position = [1, 0, 0]", ""], 16, "`seed[1].position` is missing", missing);
    expect(KNOTS, ["radius = 0.01", "radius = 0"], 14, "`seed[0].radius` is 0", radius);
    expect(KNOTS, ["radius = 2", "radius = -2"], 18, "`seed[1].radius` is -2", radius);
    let message = "`seed[1].radius` is a string";
    expect(KNOTS, ["radius = 2", "radius = \"2\""], 18, message, "expected a number");
    let message = "`seed[1].position` is an array of 2";
    expect(KNOTS, ["[1, 0, 0]", "[1, 0]"], 17, message, point);
    let message = "unknown key `seed[1].width`";
    let keys = "expected one of `position`, `radius`";
    expect(KNOTS, ["radius = 2", "radius = 2\nwidth = 3"], 19, message, keys);
    let message = "unknown key `seed[0].raduis`";
    expect(KNOTS, ["radius", "raduis"], 14, message, "did you mean `radius`?");

    let scene = KNOTS.replace("[[seed]]\nposition = [1, 0, 0]\nradius = 2", "");
    let tables = "expected tables `[[seed]]`, each with `position` and `radius`";
    expect(&scene, ["[[seed]]", "[seed]"], 12, "`seed` is a table", tables);
    let error = |value| Scene::parse("scene.toml", KNOTS, &[option("seed", value)]).unwrap_err();
    assert_eq!((error("3").message(), error("3").expected()), ("`seed` is an integer", tables));
    let mixed = error("[3]");
    assert_eq!(
        (mixed.message(), mixed.expected()),
        ("`seed[0]` is an integer", "expected a table")
    );
    // As options: all of them at once.
    let one = option("seed", "[{ position = [0, 1, 2], radius = 3 }]");
    let scene = Scene::parse("scene.toml", KNOTS, &[one]).unwrap();
    assert_eq!(seeds(&scene.render), [Seed { position: [0.0, 1.0, 2.0], radius: 3.0 }]);
}

#[test]
fn the_example_scenes_are_read() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples");
    let example = |name: &str| Scene::open(&Path::new(folder).join(name), &[]).unwrap().render;
    let knot = example("knot.toml");
    assert_eq!(seeds(&knot), [Seed { position: [0.3, 0.62, 0.4], radius: 0.01 }]);
    for (name, method) in [
        ("holmstrom.toml", "vol"),
        ("knot.toml", "vol"),
        ("smile.toml", "vol"),
        ("smile_jorgensen.toml", "vol"),
    ] {
        let settings = example(name);
        assert_eq!((settings.method.name(), settings.ignored), (method, Vec::new()), "{name}");
    }
}
