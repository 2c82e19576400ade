//! `emitree sweep`, as users call it.
#![allow(clippy::unwrap_used, reason = "what fails here fails the test")]

use crate::support::{self, Folder};
use serde_json::Value;

/// A Gaussian ball in the unit cube: its image is known.
const BALL: &str = r#"
[emission]
expression = "height*exp(-((x - 0.5)^2 + (y - 0.5)^2 + (z - 0.5)^2)/width^2)"
constants = { height = 2.0, width = 0.2 }

[projection]
type = "canonical"

[image]
width = 24
height = 16
"#;

/// A torus that takes thousands of evaluations.
const TORUS: &str = r#"
[emission]
expression = "exp(-((sqrt(x^2 + (cos(tilt)*y - sin(tilt)*z)^2) - 1.5)^2 + (sin(tilt)*y + cos(tilt)*z)^2)/0.18)"
constants = { tilt = 0.3 }

[projection]
type = "perspective"
position = [6, -4, 5]
target = [0, 0, 0]
field_of_view = [35, 35]
near = 2
far = 16

[image]
width = 48
height = 48
"#;

/// The pixels of an image.
fn pixels_of(folder: &Folder, name: &str) -> Vec<f64> {
    support::pixels(&folder.bytes(name))
}

/// ∫ exp(−(t − 1/2)²/w²) dt from a to b, by Simpson's rule on 512 intervals.
fn integral(a: f64, b: f64, width: f64) -> f64 {
    let at = |k: u32| (-((a + (b - a) * f64::from(k) / 512.0 - 0.5) / width).powi(2)).exp();
    let inner: f64 = (1..512).map(|k| if k % 2 == 1 { 4.0 * at(k) } else { 2.0 * at(k) }).sum();
    (at(0) + inner + at(512)) * (b - a) / (3.0 * 512.0)
}

/// The largest error of an image of the ball over its largest pixel.
fn error_of_ball(image: &[f64], height: f64, width: f64) -> f64 {
    let means = |count: u32| -> Vec<f64> {
        let edge = |i: u32| f64::from(i) / f64::from(count);
        (0..count).map(|i| integral(edge(i), edge(i + 1), width) * f64::from(count)).collect()
    };
    let (columns, rows, along) = (means(24), means(16), integral(0.0, 1.0, width));
    let exact = rows.iter().flat_map(|y| columns.iter().map(move |x| height * x * y * along));
    let exact: Vec<f64> = exact.collect();
    let largest = exact.iter().copied().fold(0.0, f64::max);
    let difference = |(a, b): (&f64, &f64)| (a - b).abs();
    assert_eq!(image.len(), exact.len());
    image.iter().zip(&exact).map(difference).fold(0.0, f64::max) / largest
}

#[test]
fn all_combinations_are_within_the_tolerance() {
    let folder = Folder::with_scene(BALL);
    let run = folder.emitree(
        "sweep scene.toml --over emission.constants.width=0.2:0.22:3 --over emission.constants.height=1,5 \
         -o w{width}_h{height}.npy -o {number}.fits --error-map error_{number}.npy --report report.json",
    );
    assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{}", run.stdout);
    let lines: Vec<&str> = run.stdout.lines().collect();
    assert!(lines[0].starts_with("scene.toml: 6 images, "), "{}", run.stdout);
    assert_eq!(lines.len(), 8, "{}", run.stdout);
    let report = folder.json("report.json");
    assert_eq!(report["keys"][0], "emission.constants.width");
    assert_eq!(report["converged"], true);
    let images = report["images"].as_array().unwrap();
    let mut evaluations = 0;
    for (number, image) in images.iter().enumerate() {
        let [width, height] = [0, 1].map(|key| image["values"][key].as_f64().unwrap());
        let name = format!("w{width}_h{height}.npy");
        assert_eq!(image["outputs"][0], name.as_str());
        assert!(error_of_ball(&pixels_of(&folder, &name), height, width) < 0.01, "{name}");
        assert!(folder.path(&format!("{number}.fits")).exists());
        let largest =
            pixels_of(&folder, &format!("error_{number}.npy")).into_iter().fold(0.0, f64::max);
        assert!(largest > 0.0 && image["estimated_error"].as_f64().unwrap() < 0.01);
        assert_eq!(image["exit_code"], 0);
        assert_eq!(image["report"]["evaluations"], image["evaluations"]);
        assert_eq!(image["report"]["overrides"].as_array().unwrap().len(), 2);
        evaluations += image["evaluations"].as_u64().unwrap();
    }
    assert_eq!(images.len(), 6);
    assert_eq!(report["evaluations"], evaluations);
}

/// The evaluations of a sweep and of the same images one by one; all are within the tolerance.
#[test]
fn eleven_tilts_take_a_third_of_the_evaluations() {
    let folder = Folder::with_scene(TORUS);
    let over = "--over emission.constants.tilt=0.25:0.35:11 -q --threads 2";
    let run = folder.emitree(&format!("sweep scene.toml {over} -o {{tilt}}.npy --report r.json"));
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let of_sweep = folder.json("r.json")["evaluations"].as_u64().unwrap();
    let mut alone = 0;
    for tilt in ["0.25", "0.3", "0.35"] {
        let set = format!("--set emission.constants.tilt={tilt} -q --threads 2");
        let run = folder.emitree(&format!("render scene.toml {set} -o x.npy --report x.json"));
        assert_eq!(run.code, Some(0));
        alone += folder.json("x.json")["evaluations"].as_u64().unwrap();
        let [found, other] =
            [format!("{tilt}.npy"), "x.npy".to_owned()].map(|n| pixels_of(&folder, &n));
        let largest = other.iter().copied().fold(0.0, f64::max);
        for (a, b) in found.iter().zip(&other) {
            // Each is within 1 % of the exact image.
            assert!((a - b).abs() < 0.02 * largest);
        }
    }
    // Three images are 3/11 of all.
    assert!(of_sweep < alone * 11 / 9, "{of_sweep} {alone}");
}

/// A budget that ends before the tolerance is met: the image is written, the code is 4.
#[test]
fn the_exit_code_is_the_worst_one() {
    let folder = Folder::with_scene(BALL);
    let run = folder.emitree(
        "sweep scene.toml --over render.max_evaluations=60,100000 -o {max_evaluations}.npy --report r.json",
    );
    assert_eq!(run.code, Some(4), "{}", run.stderr);
    let images = folder.json("r.json")["images"].clone();
    assert_eq!([&images[0]["exit_code"], &images[1]["exit_code"]], [4, 0]);
    assert!(folder.path("60.npy").exists() && folder.path("100000.npy").exists());
    assert!(run.stdout.contains("NO"), "{}", run.stdout);
}

/// An emission that is not finite at one value: the others are written, and the message names the value.
#[test]
fn an_image_that_fails_leaves_the_others() {
    let scene = BALL.replace("height*exp", "sqrt(height)*exp");
    let folder = Folder::with_scene(&scene);
    let run = folder.emitree(
        "sweep scene.toml --over emission.constants.height=-1,1,4 -o {height}.npy --report r.json",
    );
    assert_eq!(run.code, Some(3), "{}", run.stderr);
    assert!(run.stderr.contains("emission.constants.height = -1: "), "{}", run.stderr);
    assert!(!folder.path("-1.npy").exists());
    for (height, rate) in [("1", 1.0), ("4", 2.0)] {
        assert!(error_of_ball(&pixels_of(&folder, &format!("{height}.npy")), rate, 0.2) < 0.01);
    }
    let images = folder.json("r.json")["images"].clone();
    let codes: Vec<u64> =
        (0..3).map(|number: usize| images[number]["exit_code"].as_u64().unwrap()).collect();
    assert_eq!(codes, [3, 0, 0]);
    assert!(images[0]["error"].as_str().unwrap().starts_with("emission.constants.height = -1: "));
    assert_eq!(images[0]["report"], Value::Null);
}

/// Wrong requests are found before g is called: code 2, what was expected, and no file.
#[test]
fn wrong_requests_leave_no_file() {
    let folder = Folder::with_scene(BALL);
    let width = "--over emission.constants.width=0.2:0.22:3";
    let cases = [
        (
            "-o {width}.npy --over emission.constants.widht=1,2".to_owned(),
            "the constant `widht` is not used",
        ),
        (
            "-o {n}.npy --over emission.constants.width=0.2,x".to_owned(),
            "a value of `emission.constants.width` is `x`: expected a finite number",
        ),
        (
            "-o {width}.npy --over emission.constants.width=0.2:0.3:0".to_owned(),
            "the count of values of `emission.constants.width` is `0`: expected a whole",
        ),
        (
            format!("-o image.npy {width}"),
            "the output `image.npy` is that of emission.constants.width = 0.2 and of emission.constants.width = 0.21: expected a name with {width} or {number}",
        ),
        (format!("-o {{heigth}}.npy {width}"), "has `{heigth}`: expected {width} or {number}"),
        (format!("-o {{width}}.txt {width}"), "{width}.txt"),
        (
            format!("-o {{width}}.npy -o {{width}}.npy {width}"),
            "the outputs 0.2.npy and 0.2.npy are the same file",
        ),
        (format!("-o absent/{{width}}.npy {width}"), "absent"),
        (format!("-o {{width}}.npy {width} --over image.width=8,0"), "`image.width` is 0"),
        (
            format!("-o {{width}}.npy {width} --method los --error-map e{{width}}.npy"),
            "--error-map: uniform steps have no error estimate",
        ),
        (width.to_owned(), "--output"),
    ];
    for (arguments, expected) in cases {
        let run = folder.emitree(&format!("sweep scene.toml {arguments}"));
        let message = run.stderr.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(run.code, Some(2), "{arguments}: {message}");
        assert!(message.contains(expected), "{arguments}: {message}");
        assert!(run.stdout.is_empty(), "{arguments}: {}", run.stdout);
    }
    folder.holds(&["scene.toml"]);
}

/// Cameras and image sizes can be swept too; cubes are rendered one by one.
#[test]
fn any_number_of_a_scene_can_be_swept() {
    let scene =
        BALL.replace("z - 0.5)^2)", "z - 0.5)^2 + E)") + "\n[energy]\nmin = 1\nmax = 2\nbins = 2\n";
    let folder = Folder::with_scene(&scene);
    let run = folder.emitree(
        "sweep scene.toml --over energy.bins=1,3 --over image.width=8,12 -o {bins}_{width}.npy -q",
    );
    assert_eq!((run.code, run.stdout.as_str()), (Some(0), ""), "{}", run.stderr);
    assert_eq!(pixels_of(&folder, "3_8.npy").len(), 3 * 16 * 8);
    assert_eq!(pixels_of(&folder, "1_12.npy").len(), 16 * 12);
}
