//! Unusual inputs and outputs: full disks, links, devices, huge and empty scenes.

#![allow(clippy::unwrap_used, reason = "what fails here fails the test")]

use crate::support::{Folder, pixels};

/// A scene of the folder `scenes`.
fn known(name: &str) -> Folder {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/scenes");
    let scene = std::fs::read_to_string(std::path::Path::new(folder).join(name)).unwrap();
    Folder::with_scene(&scene)
}

/// A scene of some pixels with a view of its own.
fn scene(emission: &str, projection: &str) -> Folder {
    Folder::with_scene(&format!(
        "[emission]\nexpression = \"{emission}\"\n[projection]\n{projection}\n\
         [image]\nwidth = 6\nheight = 5\n"
    ))
}

/// One output that can't be stored keeps the others from being replaced.
#[cfg(unix)]
#[test]
fn outputs_are_replaced_together_or_not_at_all() {
    let folder = known("small_cube.toml");
    std::fs::write(folder.path("a.png"), "old").unwrap();
    std::fs::write(folder.path("report.json"), "old").unwrap();
    // The picture fits in what may be written, the cube does not.
    let options = "render scene.toml -o a.png -o b.npy --report report.json -q";
    let run = folder.emitree_with_small_files(options);
    run.fails_with(2);
    assert!(run.stderr.starts_with("emitree: `b.npy`: cannot write 32896 bytes"), "{}", run.stderr);
    assert_eq!(folder.bytes("a.png"), b"old");
    assert_eq!(folder.bytes("report.json"), b"old");
    folder.holds(&["a.png", "report.json", "scene.toml"]);
}

#[cfg(unix)]
#[test]
fn a_report_goes_to_the_terminal_without_taking_its_place() {
    let folder = known("wide_field.toml");
    let log = std::fs::File::create(folder.path("log")).unwrap();
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_emitree"));
    command.args(["render", "scene.toml", "-o", "a.npy", "--report", "/dev/stdout"]);
    let status = command.current_dir(folder.path("")).stdout(log).status().unwrap();
    assert_eq!(status.code(), Some(0));
    let text = String::from_utf8(folder.bytes("log")).unwrap();
    // The report, and the summary after it.
    let (report, summary) = text.split_once("\n}\n").unwrap();
    let report: serde_json::Value = serde_json::from_str(&format!("{report}\n}}")).unwrap();
    assert_eq!(report["converged"], true);
    assert!(summary.contains("a.npy, /dev/stdout"), "{text}");
    folder.emitree("render scene.toml -o a.npy --report /dev/null -q").succeeds();
    folder.holds(&["a.npy", "log", "scene.toml"]);
}

#[cfg(unix)]
#[test]
fn links_are_followed_wherever_they_lead() {
    let folder = known("wide_field.toml");
    std::os::unix::fs::symlink("there.npy", folder.path("link.npy")).unwrap();
    folder.emitree("render scene.toml -o link.npy -q").succeeds();
    assert!(folder.path("link.npy").is_symlink());
    assert_eq!(pixels(&folder.bytes("there.npy")).len(), 30);
}

#[test]
fn files_of_a_killed_run_are_removed_by_the_next() {
    let folder = known("wide_field.toml");
    std::fs::write(folder.path(".a.npy.Zz9Yy8.part"), "half").unwrap();
    folder.emitree("render scene.toml -o a.npy -q").succeeds();
    folder.holds(&["a.npy", "scene.toml"]);
}

#[test]
fn an_image_that_has_no_area_is_refused() {
    let view = "type = \"orthographic\"\nposition = [0, -10, 0]\ntarget = [0, 0, 0]\nfar = 20.0\n";
    for (key, value) in [("extent", "[1e-300, 1e-300]"), ("extent", "[1e200, 1e200]")] {
        let folder = scene("exp(-r^2)", &format!("{view}{key} = {value}"));
        let run = folder.emitree("render scene.toml -o a.npy");
        run.fails_with(2);
        for text in [&format!("`projection.{key}` is {value}"), "scene.toml:8:", "from 1e-290"] {
            assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
        }
        folder.holds(&["scene.toml"]);
    }
}

#[test]
fn an_image_without_anything_in_it_says_so() {
    let away = "type = \"perspective\"\nposition = [0, -10, 0]\ntarget = [0, -11, 0]\n\
                field_of_view = [20, 20]\nfar = 20.0";
    let run_of = |folder: &Folder| {
        let run = folder.emitree("render scene.toml -o a.npy --report r.json");
        run.succeeds();
        assert!(pixels(&folder.bytes("a.npy")).iter().all(|&pixel| pixel == 0.0));
        let hint = folder.json("r.json")["hint"].as_str().unwrap().to_owned();
        assert!(run.stdout.contains(&format!("  hint         {hint}")), "{}", run.stdout);
        hint
    };
    let hint = run_of(&scene("if(y > 0, 1, 0)", away));
    assert!(hint.starts_with("nothing is in view: the emission rate is 0 at all "), "{hint}");
    let hint = run_of(&known("bounds_behind_the_observer.toml"));
    assert!(hint.starts_with("nothing is in view: no line of sight meets the bounds"), "{hint}");
    let folder = known("wide_field.toml");
    let run = folder.emitree("render scene.toml -o a.npy --report r.json");
    run.succeeds();
    assert!(folder.json("r.json")["hint"].is_null() && !run.stdout.contains("hint"));
}

#[test]
fn the_number_of_threads_is_bounded() {
    let folder = known("wide_field.toml");
    for threads in ["0", "1025", "1000000000"] {
        let run = folder.emitree(&format!("render scene.toml -o a.npy --threads {threads}"));
        run.fails_with(2);
        assert!(run.stderr.contains("--threads"), "{}", run.stderr);
    }
}

/// What is quoted of a scene fits on a screen.
#[test]
fn messages_are_short_whatever_the_scene() {
    let long = "1+".repeat(1_000_000);
    let view = "type = \"canonical\"";
    for emission in [format!("{long}q"), format!("q{}", "u".repeat(1_000_000))] {
        let run = scene(&emission, view).emitree("render scene.toml -o a.npy");
        run.fails_with(2);
        assert!(run.stderr.contains("unknown name"), "{}", run.stderr);
        assert!(run.stderr.len() < 5_000, "{}", run.stderr.len());
    }
}
