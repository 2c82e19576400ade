//! What a user gets to read when something is wrong, and what is left behind: nothing.

use crate::support::{self, Folder, HOLMSTROM};

/// Renders a scene in which one text is replaced; it must fail with a code and all these texts.
fn refused(from: &str, to: &str, options: &str, code: i32, texts: &[&str]) {
    assert!(HOLMSTROM.contains(from), "{from}");
    let folder = Folder::with_scene(&HOLMSTROM.replacen(from, to, 1));
    let run = folder.emitree(&format!("render scene.toml -o a.npy {options}"));
    run.fails_with(code);
    for text in texts {
        assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
    }
    assert_eq!(run.stdout, "");
    folder.holds(&["scene.toml"]);
}

#[test]
fn an_unknown_key() {
    let texts =
        ["unknown key `image.widht`", "scene.toml:11:1", "widht = 64", "did you mean `width`?"];
    refused("width = 64", "widht = 64", "", 2, &texts);
}

#[test]
fn a_wrong_type() {
    let texts =
        ["`image.width` is a string", "scene.toml:11", "width = \"64\"", "a number of pixels"];
    refused("width = 64", "width = \"64\"", "", 2, &texts);
}

#[test]
fn a_text_that_is_not_toml() {
    refused("[image]", "[image", "", 2, &["the scene is not valid TOML", "scene.toml:10"]);
}

#[test]
fn an_unknown_model_or_parameter() {
    let from = "expression = \"(sin(5*x) * sin(7*y) * sin(11*z) / 10)^2 + exp(-alpha*((x - sqrt(2)/3)^2/sqrt(2) + (y - sqrt(7)/5)^2*sqrt(2) + (z - sqrt(6)/5)^2*sqrt(3)))\"\nconstants = { alpha = 100.0 }";
    let texts = ["unknown model `cmemm`", "did you mean `cmem`?", "scene.toml:3"];
    refused(from, "model = \"cmemm\"", "", 2, &texts);
    let to = "model = \"cmem\"\nparameters = { densety = 5 }";
    let texts = ["no parameter `densety`", "did you mean `density`?", "scene.toml:4"];
    refused(from, to, "", 2, &texts);
}

#[test]
fn an_expression_that_does_not_parse() {
    refused("/ 10)^2", "/ 10^2", "", 2, &["`emission.expression`", "scene.toml:3"]);
    let texts = ["unknown name `q`", "scene.toml:3", "alpha"];
    refused("sin(5*x)", "sin(5*q)", "", 2, &texts);
}

#[test]
fn an_energy_without_a_table_of_energies() {
    refused("sin(5*x)", "sin(5*E)", "", 2, &["`E`", "energy"]);
}

#[test]
fn a_method_that_is_not_there() {
    let texts = ["unknown method `volume`", "scene.toml:15", "expected `vol`, `paper` or `los`"];
    refused("method = \"paper\"", "method = \"volume\"", "", 2, &texts);
    let texts = ["unknown method `tree`", "option --method:1", "expected `vol`, `paper` or `los`"];
    refused("width = 64", "width = 64", "--method tree", 2, &texts);
}

#[test]
fn options_of_vol_that_are_out_of_range() {
    let refused = |options: &str, texts: &[&str]| {
        refused("method = \"paper\"", "", options, 2, texts);
    };
    let levels = "expected a level from 2 to 7";
    refused("--base-level 9", &["`render.base_level` is 9", "option --base-level:1:", levels]);
    let fraction = "expected a fraction above 0 and below 1, as in 0.01";
    refused("--tolerance 0", &["`render.tolerance` is 0", "option --tolerance:1:", fraction]);
    refused("--tolerance 2", &["`render.tolerance` is 2", fraction]);
    refused("--tolerance x", &["`render.tolerance` is a string", "expected a number"]);
    let batch = "expected a number of evaluations in a batch, 1 or more";
    refused("--batch-size 0", &["`render.batch_size` is 0", "option --batch-size:1:", batch]);
    let minimized = "expected `evaluations` or `time`";
    let speed = ["`render.minimize` is \"speed\"", "option --minimize:1:", minimized];
    refused("--minimize speed", &speed);
    let rounds = "expected a number of rounds, 1 or more";
    refused("--rounds 0", &["`render.rounds` is 0", "option --rounds:1:", rounds]);
}

#[test]
fn a_budget_below_the_coarsest_image() {
    let texts =
        ["`max_evaluations` allows 100 evaluations, but the base grid of level 3 needs 512"];
    refused("method = \"paper\"", "method = \"paper\"", "--max-evaluations 100", 2, &texts);
    let texts =
        ["`max_evaluations` allows 26 evaluations, but the initial sampling of 3 x 3 lines"];
    refused("method = \"paper\"", "", "--max-evaluations 26", 2, &texts);
}

#[test]
fn seeds_that_are_wrong() {
    let refused = |seed: &str, texts: &[&str]| {
        refused("[image]", &format!("{seed}\n[image]"), "", 2, texts);
    };
    let texts = [
        "`seed[0].radius` is missing",
        "scene.toml:10:1",
        "expected `radius` here: a length above 0",
    ];
    refused("[[seed]]\nposition = [0.3, 0.62, 0.4]", &texts);
    let texts = ["`seed[0].radius` is 0", "scene.toml:12:10", "expected a length above 0"];
    refused("[[seed]]\nposition = [0.3, 0.62, 0.4]\nradius = 0", &texts);
    let texts = [
        "`seed` is a table",
        "scene.toml:10:1",
        "expected tables `[[seed]]`, each with `position` and `radius`",
    ];
    refused("[seed]\nposition = [0.3, 0.62, 0.4]\nradius = 0.01", &texts);
}

#[test]
fn an_image_of_no_or_absurd_size() {
    refused("width = 64", "width = 0", "", 2, &["`image.width` is 0", "1 to 2^24"]);
    let texts = ["`image.width` is 10000000000", "scene.toml:11", "1 to 2^24"];
    refused("width = 64", "width = 10_000_000_000", "", 2, &texts);
    let texts = ["an image of 16000000 x 16000000 pixels", "would take", "are allowed"];
    refused("width = 64", "width = 64", "--width 16000000 --height 16000000", 2, &texts);
    let texts = ["an image of 64 x 64 pixels", "would take", "are allowed"];
    refused("width = 64", "width = 64", "--method los --lines 1000000000", 2, &texts);
    let texts = ["base grid of level 10", "would take"];
    refused("width = 64", "width = 64", "--base-level 10 --threshold 1", 2, &texts);
    let texts = ["`render.base_level` is 0", "expected a level from 1 to 10"];
    refused("width = 64", "width = 64", "--base-level 0", 2, &texts);
}

#[test]
fn more_steps_than_there_are_numbers() {
    let options = "--method los --steps 4503599627370496 --max-evaluations 1000";
    let texts = ["`max_evaluations` allows 1000", "needs 18446744073709551615"];
    refused("width = 64", "width = 64", options, 2, &texts);
}

#[test]
fn an_emission_that_is_not_finite_names_the_point() {
    let texts = ["the emission rate is", "at position [0.", "expected a finite number"];
    refused("/ 10)^2", "/ 10)^2 + 1/floor(x)", "", 3, &texts);
    refused("/ 10)^2", "/ 10)^2 + sqrt(x - 0.5)", "--method los", 3, &["NaN", "position"]);
    // Finite everywhere, but not its sum.
    let texts = ["the image is", "in row 0, column 0", "smaller emission rates"];
    refused("/ 10)^2", "/ 10)^2 + 1.5e308 + 0*x", "--method los --steps 2", 3, &texts);
}

#[test]
fn outputs_that_can_not_be_written() {
    let folder = Folder::with_scene(HOLMSTROM);
    let failing = |options: &str, texts: &[&str]| {
        let run = folder.emitree(&format!("render scene.toml {options}"));
        run.fails_with(2);
        for text in texts {
            assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
        }
        folder.holds(&["scene.toml"]);
    };
    failing("-o nowhere/a.fits", &["nowhere"]);
    failing("-o a.fits -o b.jpeg", &["b.jpeg", ".png"]);
    failing("-o a.npy -o ./a.npy", &["`a.npy` and `./a.npy` are the same file"]);
    failing("-o a.npy --report a.npy", &["same file"]);
    failing("-o a.npy --report scene.toml", &["the output scene.toml is the scene itself"]);
    failing(
        "-o a.npy --method los --error-map e.npy",
        &["--error-map: uniform steps have no error estimate"],
    );
    failing(
        "-o a.npy --method los --progressive .",
        &["--progressive: lines of sight have no coefficients"],
    );
}

#[test]
fn a_scene_that_is_not_there() {
    let folder = Folder::with_scene(HOLMSTROM);
    let run = folder.emitree("render missing.toml");
    run.fails_with(2);
    assert!(run.stderr.contains("the scene missing.toml can't be read"), "{}", run.stderr);
}

#[test]
fn options_that_make_no_sense() {
    let folder = Folder::with_scene(HOLMSTROM);
    for (options, text) in [
        ("--threads 0", "--threads"),
        ("--set width", "expected KEY=VALUE"),
        ("--order 4", "expected an odd number from 1 to 9"),
        ("--tolerance -1", "`render.tolerance` is -1"),
        ("--threshold tiny", "a size above 0"),
        ("--frobnicate", "--frobnicate"),
        ("--max-evaluations 100", "needs 512"),
        ("--base-level 4 --finest-level 4", "expected a level from 5 to 19"),
    ] {
        let run = folder.emitree(&format!("render scene.toml {options}"));
        run.fails_with(2);
        assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
        folder.holds(&["scene.toml"]);
    }
}

/// A frame that can't be stored, for want of space for example, ends the rendering: with what is
/// wrong, not as if it had been interrupted.
#[cfg(unix)]
#[test]
fn a_frame_that_can_not_be_written_ends_the_rendering() {
    let folder = Folder::with_scene(&support::example("holmstrom.toml"));
    let run = folder.emitree_with_small_files("render scene.toml -o a.npy --progressive frames");
    run.fails_with(2);
    let message = &run.stderr;
    assert!(message.starts_with("emitree: `frames/frame-00-"), "{message}");
    assert!(message.contains("cannot write 32896 bytes"), "{message}");
    folder.holds(&["frames", "scene.toml"]);
    assert_eq!(folder.names_in("frames", ""), Vec::<String>::new());
}

/// Ctrl-C, or a batch system's SIGTERM, in the middle: exit code 130, and neither image nor
/// temporary file.
#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_nothing() {
    // Some 10^10 evaluations, or waves much finer than the finest lattice: minutes, if nothing
    // stopped them.
    let lines = "--method los --lines 16 --steps 10000";
    let waves = "--method vol --width 1024 --height 1024 --max-evaluations 4000000000 \
                 --set emission.expression=2+sin(1e7*alpha*x*(y+z))";
    for (signal, options) in [("-INT", lines), ("-TERM", lines), ("-INT", waves)] {
        let folder = Folder::with_scene(HOLMSTROM);
        let mut child = folder.start(&format!("render scene.toml -o a.fits {options}"));
        while folder.names().len() < 2 {
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        std::thread::sleep(std::time::Duration::from_millis(100));
        let kill =
            std::process::Command::new("kill").args([signal, &child.id().to_string()]).status();
        assert!(kill.unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(130), "{options}");
        folder.holds(&["scene.toml"]);
    }
}
