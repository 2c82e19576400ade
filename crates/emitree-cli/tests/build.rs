//! `emitree build`, the real binary: a tree is built once, and rendered from anywhere.

use crate::support::{Folder, HOLMSTROM, pixels};
use emitree::Image;
use emitree_io::TreeFile;
use emitree_problems::{equation8, relative_error};

/// Eq. (8) as a tree of the unit cube, to 0.1 %.
fn scene() -> String {
    format!("{}\n[build]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n", with_vol(HOLMSTROM))
}

fn with_vol(scene: &str) -> String {
    scene.replace("method = \"paper\"\nthreshold = 0.01", "tolerance = 0.001")
}

/// The same scene with the tree for an emission.
fn of_tree() -> String {
    let text = scene();
    let (head, rest) = text.split_once("expression").unwrap_or_default();
    let (_, rest) = rest.split_once("\n\n").unwrap_or_default();
    format!("{head}tree = \"model.fits\"\n\n{rest}")
}

#[test]
fn a_tree_is_built_once_and_rendered_from_anywhere() {
    let folder = Folder::with_scene(&scene());
    let run = folder.emitree("build scene.toml -o model.fits");
    run.succeeds();
    assert!(run.stderr.is_empty(), "no progress in a pipe: {}", run.stderr);
    for text in [
        "scene.toml: a tree of the box [0.0, 0.0, 0.0] to [1.0, 1.0, 1.0]\n",
        "  tree         order 5, base grid 16^3, to 0.1 % of the largest rate\n",
        "  evaluations  62,912 in 6 batches\n",
        "  cells        61,888, the finest 1/128 of the box\n",
        "  written      model.fits\n",
    ] {
        assert!(run.stdout.contains(text), "no `{text}` in:\n{}", run.stdout);
    }
    assert!(!run.stdout.contains("NOT CONVERGED") && !run.stdout.contains("unresolved"));
    folder.holds(&["model.fits", "scene.toml"]);
    let file = TreeFile::open(folder.path("model.fits")).unwrap();
    assert_eq!(file.evaluations, 62_912);
    assert!(file.converged);
    assert!(file.scene.starts_with(scene().trim_end()), "{}", file.scene);

    // The emission is the tree from here on: the expression is not in the scene any more.
    std::fs::create_dir(folder.path("views")).unwrap();
    std::fs::write(
        folder.path("views/scene.toml"),
        of_tree().replace("model.fits", "../model.fits"),
    )
    .unwrap();
    folder.emitree("render views/scene.toml -o a.npy --report r.json").succeeds();
    assert_eq!(folder.json("r.json")["converged"], true);
    let image = Image::from_pixels(64, 64, pixels(&folder.bytes("a.npy")));
    let error = relative_error(&image, &equation8::exact_image(equation8::ALPHA, [64, 64]));
    assert!(error < 1.2e-3, "{error:e}");
    // A camera elsewhere, against the expression itself.
    let camera = "type = \"equirectangular\"\nposition = [-3, 0.4, 1.5]\ntarget = [0.5, 0.5, 0.5]\n\
                  field_of_view = [15, 15]\nfar = 6";
    let aside = |scene: String| {
        let small = scene.replace("width = 64\nheight = 64", "width = 24\nheight = 24");
        small.replace("type = \"canonical\"", camera)
    };
    std::fs::write(folder.path("tree.toml"), aside(of_tree())).unwrap();
    // The expression has an end where the box has one.
    let boxed = with_vol(HOLMSTROM)
        .replace("\"(sin", "\"if(max(abs(x - 0.5), max(abs(y - 0.5), abs(z - 0.5))) < 0.5, (sin")
        .replace("*sqrt(3)))\"", "*sqrt(3))), 0)\"");
    std::fs::write(folder.path("boxed.toml"), aside(boxed)).unwrap();
    let [tree, boxed] = ["tree", "boxed"].map(|name| {
        folder.emitree(&format!("render {name}.toml -o {name}.npy --quiet")).succeeds();
        Image::from_pixels(24, 24, pixels(&folder.bytes(&format!("{name}.npy"))))
    });
    let error = relative_error(&tree, &boxed);
    assert!(error < 3e-3 && boxed.min_max().1 > 0.05, "{error:e}");
}

#[test]
fn the_scene_renders_with_its_table_build() {
    let folder = Folder::with_scene(&scene());
    folder.emitree("render scene.toml -o a.npy --quiet").succeeds();
}

#[test]
fn options_win_and_quiet_is_quiet() {
    let folder = Folder::with_scene(&scene());
    let run = folder.emitree("build scene.toml -o model.fits --tolerance 0.01 --quiet");
    run.succeeds();
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
    let file = TreeFile::open(folder.path("model.fits")).unwrap();
    assert_eq!(file.evaluations, 41_600);
    assert!(file.scene.ends_with("# changed: build.tolerance = 0.01\n"));
}

#[test]
fn any_number_of_threads_makes_the_same_tree() {
    let folder = Folder::with_scene(&scene());
    let families = |threads: u8| {
        let run =
            folder.emitree(&format!("build scene.toml -o m{threads}.fits --threads {threads}"));
        run.succeeds();
        TreeFile::open(folder.path(&format!("m{threads}.fits"))).unwrap().tree.families().collect()
    };
    let [one, three]: [Vec<_>; 2] = [1, 3].map(families);
    assert!(one == three);
}

#[test]
fn a_budget_that_ends_is_exit_code_4_with_a_tree() {
    let folder = Folder::with_scene(&scene());
    let run = folder.emitree("build scene.toml -o model.fits --max-evaluations 50000");
    run.fails_with(4);
    let text = "  NOT CONVERGED: stopped by its budget after 50,000 evaluations with ";
    assert!(run.stdout.contains(text), "{}", run.stdout);
    let file = TreeFile::open(folder.path("model.fits")).unwrap();
    assert!(!file.converged && file.largest_dropped > file.threshold);
    // It can be used all the same.
    std::fs::write(folder.path("tree.toml"), of_tree()).unwrap();
    folder.emitree("render tree.toml -o a.npy --tolerance 0.02").succeeds();
}

#[test]
fn a_finest_level_ends_at_a_jump() {
    let ball = r#"
        emission.expression = "if((x - 0.5)^2 + (y - 0.5)^2 + (z - 0.5)^2 < 0.09, 1, 0)"
        projection.type = "canonical"
        image = { width = 16, height = 16 }
        build = { min = [0, 0, 0], max = [1, 1, 1], finest_level = 6 }
    "#;
    let folder = Folder::with_scene(ball);
    let run = folder.emitree("build scene.toml -o model.fits");
    run.succeeds();
    assert!(run.stdout.contains("  unresolved   "), "{}", run.stdout);
    assert!(!TreeFile::open(folder.path("model.fits")).unwrap().converged);
}

/// Building must fail with a code and these texts, and leave nothing behind.
fn refused(scene: &str, options: &str, code: i32, texts: &[&str]) {
    let folder = Folder::with_scene(scene);
    let run = folder.emitree(&format!("build scene.toml {options}"));
    run.fails_with(code);
    for text in texts {
        assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
    }
    assert_eq!(run.stdout, "");
    folder.holds(&["scene.toml"]);
}

#[test]
fn wrong_scenes_and_options_are_exit_code_2() {
    let none = "the scene has no `[build]`: expected a table `[build]` with `min` and `max`";
    refused(HOLMSTROM, "-o model.fits", 2, &["scene.toml: ", none]);
    let fraction = "expected a fraction above 0 and below 1, as in 0.001";
    refused(&scene(), "-o model.fits --tolerance 2", 2, &["option --tolerance:1:", fraction]);
    refused(&scene(), "-o model.npy", 2, &["`model.npy`", "expected .fits or .fit"]);
    refused(&scene(), "-o no/model.fits", 2, &["no/model.fits", "a folder that can be written"]);
    let budget =
        "allows 100 evaluations, but the base grid of level 4 with the check of directions";
    refused(&scene(), "-o model.fits --max-evaluations 100", 2, &[budget]);
    let folder = Folder::with_scene(&scene());
    std::fs::copy(folder.path("scene.toml"), folder.path("scene.fits")).unwrap();
    let run = folder.emitree("build scene.fits -o ./scene.fits");
    run.fails_with(2);
    assert!(run.stderr.contains("./scene.fits is the scene itself"), "{}", run.stderr);
}

#[test]
fn an_emission_that_fails_is_exit_code_3() {
    let pole = scene().replace("exp(-alpha*", "1/(x - 0.53125) + exp(-alpha*");
    refused(&pole, "-o model.fits", 3, &["the emission rate is inf at position [0.53125, "]);
}

#[test]
fn a_broken_tree_is_refused_with_its_place() {
    let folder = Folder::with_scene(&of_tree());
    std::fs::write(folder.path("model.fits"), b"not a tree").unwrap();
    let run = folder.emitree("render scene.toml -o a.npy");
    run.fails_with(2);
    for text in ["the tree model.fits ", "scene.toml:3", "expected a file of `emitree build`"] {
        assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
    }
}
