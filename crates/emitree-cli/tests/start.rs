//! The first five minutes: `emitree new`, `emitree check`, and what a rendering that did not converge ends with.
#![allow(clippy::unwrap_used, reason = "what fails here fails the test")]

use crate::support::{Folder, HOLMSTROM, pixels};

/// A ball in the unit cube.
const BALL: &str = r#"
[emission]
expression = "exp(-20*((x - 0.5)^2 + (y - 0.5)^2 + (z - 0.5)^2))"
unit = "ph m-3 s-1 sr-1"

[projection]
type = "canonical"
length_unit = "m"

[image]
width = 24
height = 16

[render]
tolerance = 0.01
"#;

const TEMPLATES: [&str; 5] = ["first", "planet", "jump", "spectrum", "sky"];

/// A new scene of a template, checked and rendered with few pixels.
fn starts(name: &str, options: &str) {
    let folder = Folder::with_scene(BALL);
    let new = folder.emitree(&format!("new {name} --template {name}"));
    new.succeeds();
    let next = format!("  next         emitree check {name}.toml, emitree render {name}.toml\n");
    assert!(new.stdout.starts_with(&format!("{name}.toml: ")) && new.stdout.ends_with(&next));
    let check = folder.emitree(&format!("check {name}.toml {options}"));
    check.succeeds();
    assert!(check.stdout.starts_with(&format!("{name}.toml: nothing odd\n")), "{}", check.stdout);
    let run = folder.emitree(&format!("render {name}.toml -o a.npy --report r.json {options}"));
    run.succeeds();
    assert_eq!(folder.json("r.json")["converged"], true);
    assert!(pixels(&folder.bytes("a.npy")).iter().any(|&pixel| pixel > 0.0));
}

const SMALL: &str = "--width 24 --height 24";

#[test]
fn the_first_template_is_rendered() {
    starts("first", "");
}

#[test]
fn the_planet_is_rendered() {
    starts("planet", SMALL);
}

#[test]
fn the_jump_is_rendered() {
    starts("jump", SMALL);
}

#[test]
fn the_spectrum_is_rendered() {
    starts("spectrum", SMALL);
}

#[test]
fn the_sky_is_rendered() {
    starts("sky", "--set image.nside=4");
}

#[test]
fn all_templates_are_listed() {
    let folder = Folder::with_scene(BALL);
    let list = folder.emitree("new --list");
    list.succeeds();
    let names: Vec<&str> =
        list.stdout.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(names, TEMPLATES);
    folder.holds(&["scene.toml"]);
}

#[test]
fn new_scenes_replace_nothing() {
    let folder = Folder::with_scene(BALL);
    let run = folder.emitree("new");
    run.fails_with(2);
    let why = "emitree: scene.toml exists, and is left as it is: expected a new name\n";
    assert_eq!(run.stderr, why);
    assert_eq!(folder.bytes("scene.toml"), BALL.as_bytes());
    let failures = [
        ("new a.json", "`a.json`: scenes are TOML files: expected a name such as scene.toml"),
        ("new ..", "`..`: names no file: expected a name such as scene.toml"),
        ("new a/", "`a/`: names no file: expected a name such as scene.toml"),
        ("new none/a", "can't write none/a.toml: "),
        (
            "new a -t cube",
            "--template: unknown template `cube`: expected one of first, planet, jump, spectrum, sky",
        ),
    ];
    for (arguments, expected) in failures {
        let run = folder.emitree(arguments);
        run.fails_with(2);
        assert!(run.stderr.starts_with(&format!("emitree: {expected}")), "{}", run.stderr);
    }
    folder.holds(&["scene.toml"]);
    folder.emitree("new b").succeeds();
    let text = String::from_utf8(folder.bytes("b.toml")).unwrap();
    assert!(text.contains("#   emitree render b.toml     renders it to b.fits, b.npy and b.png\n"));
}

/// A line of a summary.
fn line<'a>(stdout: &'a str, about: &str) -> &'a str {
    let found = stdout.lines().find(|line| line.trim_start().starts_with(about));
    assert!(found.is_some(), "no `{about}` in:\n{stdout}");
    found.unwrap()
}

#[test]
fn a_scene_is_told_with_its_cost() {
    let folder = Folder::with_scene(BALL);
    let run = folder.emitree("check scene.toml");
    run.succeeds();
    assert!(run.stdout.starts_with("scene.toml: nothing odd\n"), "{}", run.stdout);
    let expected = [
        "  emission     exp(-20*((x - 0.5)^2 + (y - 0.5)^2 + (z - 0.5)^2)) [ph m-3 s-1 sr-1]",
        "  camera       canonical, lengths in m",
        "  image        24 x 16 pixels (width x height), radiance [ph m-2 s-1 sr-1]",
        "  method       vol: to 1 % of the largest pixel, base 9 x 9 lines",
    ];
    for text in expected {
        assert!(run.stdout.lines().any(|line| line == text), "no `{text}` in:\n{}", run.stdout);
    }
    let rehearsal = line(&run.stdout, "rehearsal");
    assert!(rehearsal.starts_with("  rehearsal    to 5 % of the largest pixel: "), "{rehearsal}");
    assert!(rehearsal.ends_with(" evaluations with all tests"), "{rehearsal}");
    // The range has the true number.
    let forecast = line(&run.stdout, "forecast");
    let range = forecast.split(['(', ')']).nth(1).unwrap();
    let [low, high]: [u64; 2] = range
        .split(" to ")
        .map(|number| number.replace(',', "").parse().unwrap())
        .collect::<Vec<_>>()
        .try_into()
        .unwrap();
    folder.emitree("render scene.toml -o a.npy --report r.json").succeeds();
    let found = folder.json("r.json")["evaluations"].as_u64().unwrap();
    assert!(low <= found && found <= high, "{forecast}: {found}");
    let run = folder.emitree("check scene.toml --tolerance 0.05");
    assert!(!line(&run.stdout, "forecast").contains('('), "exact: {}", run.stdout);
    let run = folder.emitree("check scene.toml --rehearsal 0");
    run.succeeds();
    assert!(run.stdout.ends_with("  rehearsal    none: no forecast\n"), "{}", run.stdout);
    folder.holds(&["a.npy", "r.json", "scene.toml"]);
}

#[test]
fn what_looks_odd_is_told() {
    let folder = Folder::with_scene(&BALL.replace("canonical", "orthographic").replace(
        "length_unit",
        "position = [0, 0, 0]\ntarget = [0, 0, -1]\nup = [0, 1, 0]\nextent = [1, 1]\nfar = 5\nlength_unit",
    ));
    // The ball, at z = 0.5, is behind the camera.
    let run = folder.emitree("check scene.toml --set emission.expression=if(z<1,0,1)");
    run.succeeds();
    assert!(run.stdout.starts_with("scene.toml: 1 remark\n"), "{}", run.stdout);
    let remark = line(&run.stdout, "VIEW");
    assert!(remark.contains("nothing is in view: the emission rate is 0 at all "), "{remark}");
    let run =
        folder.emitree("check scene.toml --set emission.expression=exp(z) --max-evaluations 30");
    run.succeeds();
    assert!(line(&run.stdout, "LIMITS").contains("`max_evaluations`, 30, would end the rendering"));
    let run = folder.emitree("check scene.toml --set emission.expression=exp(-x^2-y^2)");
    assert!(line(&run.stdout, "FAR").contains("the emission goes on behind `far`"));
    let run = folder.emitree("check scene.toml --set emission.expression=1/(x-x)");
    run.fails_with(3);
    assert!(run.stderr.starts_with("emitree: the emission rate is "), "{}", run.stderr);
    let run = folder.emitree("check scene.toml --tolerance 7");
    run.fails_with(2);
    assert!(run.stderr.contains("option --tolerance:1:20"), "{}", run.stderr);
    let run = folder.emitree("check none.toml");
    run.fails_with(2);
    assert!(run.stderr.contains("none.toml"), "{}", run.stderr);
}

/// The hint names a budget with which the rendering converges.
#[test]
fn a_rendering_that_did_not_converge_ends_with_what_to_do() {
    let jump = HOLMSTROM
        .replace("method = \"paper\"\nthreshold = 0.01", "tolerance = 0.001\nbase_level = 4");
    let folder = Folder::with_scene(&jump);
    let run = folder.emitree("render scene.toml -o a.npy --report r.json --max-evaluations 9800");
    run.fails_with(4);
    let hint = folder.json("r.json")["hint"].as_str().unwrap().to_owned();
    assert!(
        run.stdout
            .contains(&format!("  hint         {hint}\n  NOT CONVERGED: stopped by its budget"))
    );
    assert!(hint.starts_with("the error is "), "{hint}");
    let value = |key: &str| {
        let rest = hint.split(&format!("`{key}` = ")).nth(1).unwrap_or_else(|| panic!("{hint}"));
        let number: String =
            rest.chars().take_while(|c| c.is_ascii_digit() || ",.e-".contains(*c)).collect();
        number.trim_end_matches(',').replace(',', "")
    };
    let [evaluations, tolerance] = ["max_evaluations", "tolerance"].map(value);
    folder
        .emitree(&format!("render scene.toml -o b.npy --max-evaluations {evaluations}"))
        .succeeds();
    // Twice the error of the image, with two digits.
    let error = folder.json("r.json")["estimated_error"].as_f64().unwrap();
    let tolerance: f64 = tolerance.parse().unwrap();
    assert!((tolerance / error - 2.0).abs() < 0.1, "{tolerance} {error}");
}

/// `max_seconds` ends with an image, however short.
#[test]
fn there_is_an_image_however_short_the_time() {
    let folder = Folder::with_scene(BALL);
    let run = folder.emitree("render scene.toml -o a.npy --report r.json --max-seconds 1e-9");
    run.fails_with(4);
    let image = pixels(&folder.bytes("a.npy"));
    assert!(image.len() == 24 * 16 && image.iter().any(|&pixel| pixel > 0.0));
    let report = folder.json("r.json");
    assert_eq!((&report["ending"], &report["evaluations"]), (&"time".into(), &27.into()));
    assert!(report["estimated_error"].as_f64().unwrap() >= 1.0);
    let hint = report["hint"].as_str().unwrap();
    assert!(
        hint.starts_with("there are too few samples for an image: try `max_seconds` = "),
        "{hint}"
    );
    // The lines of sight of `los` are made one after the other.
    let run =
        folder.emitree("render scene.toml -o b.npy --method los --steps 64 --max-seconds 1e-9");
    run.fails_with(2);
    assert!(
        run.stderr.starts_with("emitree: `max_seconds` is 0.000000001: the time ended before"),
        "{}",
        run.stderr
    );
    folder.holds(&["a.npy", "r.json", "scene.toml"]);
}

#[test]
fn man_pages_and_completions_are_made_of_the_options() {
    let folder = Folder::with_scene(BALL);
    let run = folder.emitree("manual out/manual");
    run.succeeds();
    let pages = folder.names_in("out/manual", ".1");
    let commands = [
        "build",
        "check",
        "compare",
        "models",
        "new",
        "plan",
        "render",
        "reproduce",
        "resume",
        "sweep",
    ];
    let expected: Vec<String> = commands
        .iter()
        .map(|name| format!("emitree-{name}.1"))
        .chain(["emitree.1".to_owned()])
        .collect();
    assert_eq!(pages, expected);
    let text = |name: &str| String::from_utf8(folder.bytes(&format!("out/manual/{name}"))).unwrap();
    assert!(text("emitree.1").contains("EXIT STATUS") && !text("emitree.1").contains("manual"));
    assert!(text("emitree-render.1").contains("max\\-evaluations"));
    for name in ["emitree.bash", "_emitree", "emitree.fish", "_emitree.ps1", "emitree.elv"] {
        assert!(text(name).contains("max-evaluations"), "{name}");
    }
}

/// The help of each command has its own first line, whatever options it shares.
#[test]
fn every_command_has_help_of_its_own() {
    let folder = Folder::with_scene(BALL);
    for (command, first) in [
        ("new", "Write a commented scene file to start from"),
        ("check", "Tell what a scene would render"),
        ("render", "Render a scene file to images"),
        ("sweep", "Render a scene at several values"),
        ("build", "Build the tree of a scene's emission"),
        ("compare", "Tell how two images, cubes or skies differ"),
    ] {
        let run = folder.emitree(&format!("{command} --help"));
        run.succeeds();
        assert!(run.stdout.starts_with(first), "{}", run.stdout);
    }
}
