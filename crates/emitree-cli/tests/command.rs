//! The real binary, in a temporary folder.

use crate::support::{self, Folder, HOLMSTROM, pixels};
use emitree::Image;
use emitree_problems::{equation8, relative_error};
use serde_json::Value;

#[test]
fn a_scene_becomes_images_a_report_and_a_summary() {
    let folder = Folder::with_scene(HOLMSTROM);
    let run = folder.emitree("render scene.toml -o a.fits -o a.npy -o a.png --report r.json");
    run.succeeds();
    assert!(run.stdout.contains("19,136 in 5 batches, 4.67 for each pixel"), "{}", run.stdout);
    assert!(run.stdout.contains("written      a.fits, a.npy, a.png, r.json"), "{}", run.stdout);
    assert!(run.stderr.is_empty(), "no progress in a pipe: {}", run.stderr);
    folder.holds(&["a.fits", "a.npy", "a.png", "r.json", "scene.toml"]);

    let report = folder.json("r.json");
    assert_eq!(report["evaluations"], 19_136);
    assert_eq!(report["batches"], 5);
    assert_eq!(report["tolerance"], Value::Null);
    assert_eq!(report["converged"], true);
    assert_eq!(report["threshold"], 0.01);
    assert_eq!(report["order"], 3);
    assert_eq!(report["base_level"], 3);
    assert_eq!(report["leaves_per_level"], serde_json::json!([0, 0, 0, 0, 3792, 1600, 5976, 5440]));
    assert_eq!(report["image"]["quantity"], "radiance");
    assert_eq!(report["image"]["unit"], "");
    assert_eq!(report["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(report["scene"], "scene.toml");
    for key in ["total", "emission"] {
        assert!(report["seconds"][key].as_f64().unwrap() > 0.0);
    }
    let image = pixels(&folder.bytes("a.npy"));
    assert_eq!(image.len(), 64 * 64);
    let largest = image.iter().copied().fold(0.0, f64::max);
    assert!((report["image"]["max"].as_f64().unwrap() / largest - 1.0).abs() < 1e-15);
    assert!(report["estimated_error"].as_f64().unwrap() > 0.006, "the true error is 0.0061");
}

#[test]
fn the_default_method_takes_a_tolerance() {
    let folder = Folder::with_scene(&support::example("holmstrom.toml"));
    let run =
        folder.emitree("render scene.toml -o a.fits -o a.npy --error-map e.npy --report r.json");
    run.succeeds();
    let method = "method       vol: to 1 % of the largest pixel, base 9 x 9 lines\n";
    assert!(run.stdout.contains(method), "{}", run.stdout);
    assert!(run.stdout.contains(" of the largest pixel (estimated)\n"), "{}", run.stdout);
    assert!(!run.stdout.contains("ignored") && !run.stdout.contains("NOT CONVERGED"));
    folder.holds(&["a.fits", "a.npy", "e.npy", "r.json", "scene.toml"]);
    assert_eq!(pixels(&folder.bytes("e.npy")).len(), 64 * 64);

    let report = folder.json("r.json");
    assert_eq!((&report["method"], &report["converged"]), (&"vol".into(), &true.into()));
    assert_eq!((&report["tolerance"], &report["base_level"]), (&0.01.into(), &3.into()));
    assert!(report["estimated_error"].as_f64().unwrap() <= 0.01);
    assert_eq!((&report["threshold"], &report["order"]), (&Value::Null, &Value::Null));
    assert_eq!(report["leaves_per_level"], serde_json::json!([]));
    let fits = folder.bytes("a.fits");
    let card = |text: &str| fits.windows(text.len()).any(|bytes| bytes == text.as_bytes());
    for text in [
        "METHOD  = 'vol     '",
        "NEVAL   = ",
        "CONVERGD=                    T",
        "TOLERANC=                 0.01",
        "ESTERROR= ",
        "BASELEVL=                    3 / 2^this base intervals along each axis",
        "EXTNAME = 'ERROR   '",
    ] {
        assert!(card(text), "{text}");
    }
    assert!(!card("THRESHLD") && !card("ORDER   "));

    let options = "-o b.npy --report r.json --tolerance 0.005 --base-level 4";
    let run = folder.emitree(&format!("render scene.toml {options}"));
    run.succeeds();
    assert!(run.stdout.contains("vol: to 0.5 % of the largest pixel, base 17 x 17 lines"));
    let report = folder.json("r.json");
    assert_eq!((&report["tolerance"], &report["base_level"]), (&0.005.into(), &4.into()));
}

#[test]
fn the_default_method_meets_its_tolerance() {
    let folder = Folder::with_scene(&support::example("holmstrom.toml"));
    for tolerance in [0.1, 0.01, 0.001] {
        let options = format!("-o a.npy --report r.json --tolerance {tolerance}");
        folder.emitree(&format!("render scene.toml {options}")).succeeds();
        let image = Image::from_pixels(64, 64, pixels(&folder.bytes("a.npy")));
        let error = relative_error(&image, &equation8::exact_image(100.0, [64, 64]));
        assert!(error <= tolerance, "{error} for {tolerance}");
    }
}

/// The knot is a hundredth of the cube wide, the base lattice an eighth.
#[test]
fn a_seed_shows_what_the_base_lattice_would_miss() {
    let folder = Folder::with_scene(&support::example("knot.toml"));
    let run = folder.emitree("render scene.toml -o a.npy");
    run.succeeds();
    assert!(!run.stdout.contains("ignored"), "{}", run.stdout);
    // Along z in closed form; over each pixel as the mean of 16 x 16 points.
    let radiance = |x: f64, y: f64| {
        let knot = (-((x - 0.3).powi(2) + (y - 0.62).powi(2)) / 1e-4).exp();
        let through_its_middle = 100.0 * 0.01 * core::f64::consts::PI.sqrt();
        1.0 + 0.25 * (3.0 * x).sin() * (2.0 * y).cos() + through_its_middle * knot
    };
    let at = |pixel: usize, point: usize| (pixel as f64 + (point as f64 + 0.5) / 16.0) / 64.0;
    let mean = |pixel: usize| {
        let points = (0..256).map(|p| radiance(at(pixel % 64, p % 16), at(pixel / 64, p / 16)));
        points.sum::<f64>() / 256.0
    };
    let exact = Image::from_pixels(64, 64, (0..64 * 64).map(mean).collect());
    assert!(exact.min_max().1 > 2.0, "the knot is there");
    let image = Image::from_pixels(64, 64, pixels(&folder.bytes("a.npy")));
    let error = relative_error(&image, &exact);
    assert!(error <= 0.01, "{error}");
}

/// Expressions take nanoseconds: lines of sight on a lattice of pixels take less time than few evaluations.
#[test]
fn time_is_minimized_on_request() {
    let folder = Folder::with_scene(&support::example("holmstrom.toml"));
    let size = "--width 64 --height 64";
    let render = |more: &str| {
        let run =
            folder.emitree(&format!("render scene.toml -o a.npy --report r.json {size} {more}"));
        run.succeeds();
        (run.stdout, folder.json("r.json"), pixels(&folder.bytes("a.npy")))
    };
    let (summary, report, in_time) = render("--minimize time");
    let steps = report["line_steps"].as_u64().unwrap();
    let lines =
        format!("  lines        on a lattice of pixels, {steps} steps each, to minimize time\n");
    assert!(summary.contains(&lines), "{summary}");
    assert!(report["evaluations"].as_u64().unwrap() > 60_000);
    assert_eq!((&report["method"], &report["converged"]), (&"vol".into(), &true.into()));
    let (summary, report, fewest) = render("--minimize evaluations");
    assert!(!summary.contains("lattice of pixels"), "{summary}");
    assert_eq!(report["line_steps"], Value::Null);
    let largest = fewest.iter().copied().fold(0.0, f64::max);
    let differences = in_time.iter().zip(&fewest).map(|(a, b)| (a - b).abs());
    let difference = differences.fold(0.0, f64::max);
    assert!(difference > 0.0 && difference <= 0.02 * largest, "{difference} {largest}");
}

#[test]
fn options_without_effect_are_reported() {
    let folder = Folder::with_scene(&support::example("knot.toml"));
    let ignored = |options: &str, expected: &str| {
        let run = folder.emitree(&format!("render scene.toml -o a.npy {options}"));
        run.succeeds();
        assert!(run.stdout.contains(&format!("  ignored      {expected}\n")), "{}", run.stdout);
    };
    ignored("--threshold 1% --order 5", "order, threshold: the method vol has no such option");
    ignored("--lines 2", "lines: the method vol has no such option");
    ignored(
        "--method los --set seed=[] --minimize time",
        "minimize: the method los has no such option",
    );
    let paper = "--method paper --threshold 0.5";
    ignored(paper, "tolerance, seed: the method paper has no such option");
    ignored("--method los --set seed=[] --order 3", "order: the method los has no such option");
}

#[test]
fn without_outputs_the_files_are_named_like_the_scene() {
    let folder = Folder::with_scene(HOLMSTROM);
    folder.emitree("render scene.toml --width 8 --height 4").succeeds();
    folder.holds(&["scene.fits", "scene.npy", "scene.png", "scene.toml"]);
    assert_eq!(pixels(&folder.bytes("scene.npy")).len(), 32);
}

#[test]
fn quiet_is_quiet() {
    let folder = Folder::with_scene(HOLMSTROM);
    let run = folder.emitree("render scene.toml -o a.npy --quiet");
    run.succeeds();
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
}

#[test]
fn the_peak_is_where_the_scene_says_in_every_output() {
    // A narrow peak at x = 0.8, y = 0.3: column 12 of 16, row 2 of 8 from below.
    let folder = Folder::with_scene(
        r#"
        emission.expression = "exp(-200*((x - 0.8)^2 + (y - 0.3)^2))"
        projection.type = "canonical"
        image = { width = 16, height = 8 }
        render.method = "paper"
        "#,
    );
    folder.emitree("render scene.toml -o a.npy -o a.png").succeeds();
    let image = pixels(&folder.bytes("a.npy"));
    let brightest = (0..image.len()).max_by(|&a, &b| image[a].total_cmp(&image[b])).unwrap();
    assert_eq!((brightest / 16, brightest % 16), (2, 12));
    let (width, height, rgb) = support::decode_png(&folder.bytes("a.png"));
    assert_eq!((width, height), (16, 8));
    // Viridis is brightest, in green, at the top of its scale; the picture has y up.
    let green = |i: usize| rgb[3 * i + 1];
    let brightest = (0..width * height).max_by_key(|&i| green(i)).unwrap();
    assert_eq!((height - 1 - brightest / width, brightest % width), (2, 12));
}

#[test]
fn options_of_the_command_line_win() {
    let folder = Folder::with_scene(HOLMSTROM);
    folder
        .emitree("render scene.toml -o a.npy --report r.json --base-level 2 --threshold 0.038")
        .succeeds();
    assert_eq!(folder.json("r.json")["evaluations"], 4_032);
    folder.emitree("render scene.toml -o b.npy --report r.json --method los --steps 9").succeeds();
    assert_eq!(folder.json("r.json")["evaluations"], 64 * 64 * 9);
    assert_eq!(folder.json("r.json")["estimated_error"], Value::Null);
    folder
        .emitree("render scene.toml -o b.npy --report r.json --method los --tolerance 1e-3")
        .succeeds();
    let report = folder.json("r.json");
    assert_eq!(report["tolerance"], 1e-3);
    assert!(report["estimated_error"].as_f64().unwrap() <= 1e-3);
    folder
        .emitree("render scene.toml -o b.npy --report r.json --set emission.constants.alpha=10")
        .succeeds();
    assert_eq!(folder.json("r.json")["overrides"][0], "emission.constants.alpha = 10");
}

#[test]
fn any_number_of_threads_makes_the_same_bits() {
    let folder = Folder::with_scene(HOLMSTROM);
    for method in ["vol", "paper", "los"] {
        for threads in [1, 3] {
            let options = format!("--method {method} --threads {threads} -o {method}{threads}.npy");
            folder.emitree(&format!("render scene.toml {options}")).succeeds();
        }
        let bytes = |threads| folder.bytes(&format!("{method}{threads}.npy"));
        assert!(bytes(1) == bytes(3), "{method}");
    }
}

#[test]
fn a_budget_that_ends_is_exit_code_4_with_an_image() {
    let folder = Folder::with_scene(HOLMSTROM);
    let run = folder.emitree("render scene.toml -o a.npy --report r.json --max-evaluations 9000");
    run.fails_with(4);
    assert!(run.stdout.contains("NOT CONVERGED: stopped by its budget after 9,000 evaluations"));
    let report = folder.json("r.json");
    assert_eq!(report["converged"], false);
    assert!(report["evaluations"].as_u64().unwrap() <= 9_000);
    assert_eq!(pixels(&folder.bytes("a.npy")).len(), 64 * 64);
}

#[test]
fn a_budget_that_ends_vol_is_exit_code_4_with_an_image() {
    let folder = Folder::with_scene(&support::example("holmstrom.toml"));
    let options = "-o a.npy --report r.json --max-evaluations 1000 --tolerance 1e-6";
    let run = folder.emitree(&format!("render scene.toml {options}"));
    run.fails_with(4);
    assert!(run.stdout.contains("  NOT CONVERGED: stopped by its budget after "), "{}", run.stdout);
    let report = folder.json("r.json");
    assert_eq!(report["converged"], false);
    assert_eq!(report["tolerance"], 1e-6);
    assert!(report["estimated_error"].as_f64().unwrap() > 1e-6);
    assert!(report["evaluations"].as_u64().unwrap() <= 1_000);
    let image = Image::from_pixels(64, 64, pixels(&folder.bytes("a.npy")));
    assert!(image.min_max().1 > 0.0);
}

#[test]
fn batches_are_no_larger_than_allowed_and_make_the_same_bits() {
    let folder = Folder::with_scene(HOLMSTROM);
    for (i, method) in ["vol", "paper", "los"].iter().enumerate() {
        let options = format!("--method {method} --report r.json");
        folder.emitree(&format!("render scene.toml -o a{i}.npy {options}")).succeeds();
        let evaluations = folder.json("r.json")["evaluations"].as_u64().unwrap();
        let options = format!("{options} --batch-size 300");
        folder.emitree(&format!("render scene.toml -o b{i}.npy {options}")).succeeds();
        let report = folder.json("r.json");
        assert_eq!(report["evaluations"], evaluations, "{method}");
        assert!(report["batches"].as_u64().unwrap() >= evaluations.div_ceil(300), "{method}");
        let [a, b] = ["a", "b"].map(|name| folder.bytes(&format!("{name}{i}.npy")));
        assert!(a == b, "{method}");
    }
}

#[test]
fn frames_of_vol_come_with_their_errors() {
    let folder = Folder::with_scene(&support::example("holmstrom.toml"));
    let options = "-o a.npy --report r.json --tolerance 0.001 --progressive frames";
    let run = folder.emitree(&format!("render scene.toml {options}"));
    run.succeeds();
    let names = folder.names_in("frames", ".png");
    assert!(names.len() > 1, "{names:?}");
    assert_eq!(folder.names_in("frames", "").len(), 3 * names.len(), "nothing else");
    let written = format!("  written      {} files: a.npy … ", 3 * names.len() + 2);
    assert!(run.stdout.contains(&written), "{}", run.stdout);
    let mut evaluations = 0;
    for (i, name) in names.iter().enumerate() {
        let stem = name.strip_suffix(".png").unwrap();
        let so_far: u64 = stem.strip_prefix(&format!("frame-{i:02}-")).unwrap().parse().unwrap();
        assert!(so_far >= evaluations.max(1), "{names:?}");
        evaluations = so_far;
        let (width, height, _) = support::decode_png(&folder.bytes(&format!("frames/{name}")));
        assert_eq!((width, height), (64, 64));
        for ending in [".npy", "-error.npy"] {
            let numbers = pixels(&folder.bytes(&format!("frames/{stem}{ending}")));
            assert_eq!(numbers.len(), 64 * 64);
        }
    }
    assert!(evaluations <= folder.json("r.json")["evaluations"].as_u64().unwrap());
    let image = |name: &str| Image::from_pixels(64, 64, pixels(&folder.bytes(name)));
    let frame = |name: &str| image(&format!("frames/{}", name.replace(".png", ".npy")));
    let [first, last] = [&names[0], &names[names.len() - 1]].map(|name| frame(name));
    assert!(last == image("a.npy"), "the last frame is the image");
    assert!(first.max_difference(&last) > 0.0);
}

#[test]
fn progressive_frames_end_with_the_image() {
    let folder = Folder::with_scene(HOLMSTROM);
    folder.emitree("render scene.toml -o a.npy --progressive frames").succeeds();
    let frames = folder.names_in("frames", ".npy");
    assert_eq!(frames.first().unwrap(), "frame-00-00000512.npy");
    assert_eq!(frames.last().unwrap(), "frame-07-00019136.npy");
    let image = pixels(&folder.bytes("a.npy"));
    let error = |name: &String| {
        let frame = pixels(&folder.bytes(&format!("frames/{name}")));
        frame.iter().zip(&image).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
    };
    let errors: Vec<f64> = frames.iter().map(error).collect();
    assert!(errors.windows(2).all(|pair| pair[1] < pair[0]), "{errors:?}");
    assert!(errors.last().unwrap() < &1e-15);
}

#[test]
fn frames_of_two_runs_do_not_mix() {
    let folder = Folder::with_scene(HOLMSTROM);
    folder.emitree("render scene.toml -o a.npy --progressive frames").succeeds();
    let again = folder.emitree("render scene.toml -o b.npy --progressive frames");
    again.fails_with(2);
    assert!(again.stderr.contains("has frames already"), "{}", again.stderr);
    folder.holds(&["a.npy", "frames", "scene.toml"]);
    let same = folder.emitree("render scene.toml -o frame-00.png --progressive .");
    same.fails_with(2);
    assert!(same.stderr.contains("frame-00.png would be replaced by a frame"), "{}", same.stderr);
    folder.holds(&["a.npy", "frames", "scene.toml"]);
}

/// Without emission nothing is refined: 8^3 cells, split once.
#[test]
fn a_dark_scene_is_done_at_once() {
    let folder = Folder::with_scene(HOLMSTROM);
    let dark = ["--set", "emission.expression=\"0*x*alpha\"", "--set", "render.threshold=\"1%\""];
    let options = format!("render scene.toml -o a.npy --report r.json {}", dark.join(" "));
    folder.emitree(&options).succeeds();
    assert_eq!(folder.json("r.json")["evaluations"], 512 + 4_096);
    assert_eq!(folder.json("r.json")["estimated_error"], 0.0);
}

#[test]
fn a_scene_keeps_its_last_line_in_the_history() {
    let folder = Folder::with_scene(HOLMSTROM.trim_end());
    folder.emitree("render scene.toml -o a.fits --width 5").succeeds();
    let fits = folder.bytes("a.fits");
    let card = |text: &str| fits.windows(text.len()).any(|bytes| bytes == text.as_bytes());
    assert!(card("HISTORY threshold = 0.01  "));
    assert!(card("HISTORY # changed: image.width = 5  "));
}

#[test]
fn models_are_listed_with_units_defaults_and_sources() {
    let folder = Folder::with_scene(HOLMSTROM);
    let run = folder.emitree("models");
    run.succeeds();
    for text in ["cmem:", "jorgensen:", "holmstrom:", "density", "cm-3", "10.1029/2018JA026153"] {
        assert!(run.stdout.contains(text), "{text} in {}", run.stdout);
    }
    let one = folder.emitree("models jorgensen");
    one.succeeds();
    assert!(one.stdout.starts_with("jorgensen:") && !one.stdout.contains("cmem:"));
    assert!(!one.stdout.contains("energy unit"));
    let spectral = folder.emitree("models ena_ring");
    assert!(spectral.stdout.contains("    energy unit  keV\n"), "{}", spectral.stdout);
    let unknown = folder.emitree("models cmen");
    unknown.fails_with(2);
    assert_eq!(
        unknown.stderr,
        "emitree: unknown model `cmen`: expected one of cmem, jorgensen, geocorona, \
         chamberlain, airglow, mars_hydrogen, mars_oxygen, ena, ena_ring, k_corona, k_corona_polarised, \
         beta_model, bremsstrahlung, nfw, nfw_decay, einasto, einasto_decay, burkert, burkert_decay, \
         shell_nebula, power_law, uniform, holmstrom\n"
    );
}

#[test]
fn the_figures_of_the_paper_are_reproduced() {
    let folder = Folder::with_scene(HOLMSTROM);
    let run = folder.emitree("reproduce --output here");
    run.succeeds();
    assert!(run.stdout.contains("4,032 for 3.97 %"), "{}", run.stdout);
    let runs = String::from_utf8(folder.bytes("here/figure10.csv")).unwrap();
    assert!(runs.starts_with("method,threshold_or_steps,evaluations,max_relative_error\n"));
    let images = String::from_utf8(folder.bytes("here/figure9.csv")).unwrap();
    assert_eq!(images.lines().count(), 1 + 64 * 64);
    for figure in 9..=11 {
        let (width, height, _) =
            support::decode_png(&folder.bytes(&format!("here/figure{figure}.png")));
        assert!(width > 800 && height > 500);
    }
}
