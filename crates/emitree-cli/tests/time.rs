//! Scenes with an exposure: `[time]`.

use crate::support::{Folder, pixels};

/// A Gaussian that passes a camera of parallel lines with the velocity 1.
const TRAIL: &str = r#"
[emission]
expression = "exp(-(x - t)^2 - y^2 - z^2)"

[projection]
type = "orthographic"
position = [0, 0, 5]
target = [0, 0, 0]
up = [0, 1, 0]
extent = [6, 6]
far = 10

[image]
width = 12
height = 12

[time]
start = 0
stop = 2
"#;

/// The integral of exp(−u²) from 0, by the rule of Simpson in steps of 0.005 or less: to 1e-11.
fn integral(u: f64) -> f64 {
    const PAIRS: usize = 800;
    let step = u / (2 * PAIRS) as f64;
    let value = |k: usize| (-(k as f64 * step).powi(2)).exp();
    let sum =
        (0..PAIRS).map(|k| value(2 * k) + 4.0 * value(2 * k + 1) + value(2 * k + 2)).sum::<f64>();
    sum * step / 3.0
}

/// exp(−u²) integrated twice.
fn twice(u: f64) -> f64 {
    u * integral(u) + 0.5 * (-u * u).exp()
}

/// The mean over times and pixels in closed form.
fn exact(start: f64, stop: f64) -> Vec<f64> {
    let edge = |i: usize| -3.0 + 0.5 * i as f64;
    let of_y = |i: usize| 2.0 * (integral(edge(i + 1)) - integral(edge(i)));
    let of_x = |i: usize| {
        let [now, then] = [start, stop].map(|t| twice(edge(i + 1) - t) - twice(edge(i) - t));
        2.0 * (now - then) / (stop - start)
    };
    let depth = 2.0 * integral(5.0);
    (0..144).map(|pixel| depth * of_y(pixel / 12) * of_x(pixel % 12)).collect()
}

fn assert_close(found: &[f64], exact: &[f64], tolerance: f64) {
    assert_eq!(found.len(), exact.len());
    let largest = exact.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    for (found, exact) in found.iter().zip(exact) {
        assert!((found - exact).abs() <= tolerance * largest, "{found} {exact}");
    }
}

#[test]
fn an_exposure_is_the_mean_over_its_times() {
    let folder = Folder::with_scene(TRAIL);
    let run = folder
        .emitree("render scene.toml -o a.npy -o a.fits --report report.json --tolerance 0.001");
    run.succeeds();
    assert_close(&pixels(&folder.bytes("a.npy")), &exact(0.0, 2.0), 0.001);
    assert!(run.stdout.contains("\n  exposure     0–2 s, "), "{}", run.stdout);
    assert!(run.stdout.contains(" times evaluated\n"), "{}", run.stdout);
    let time = &folder.json("report.json")["time"];
    assert_eq!((time["start"].as_f64(), time["stop"].as_f64()), (Some(0.0), Some(2.0)));
    assert_eq!((time["bins"].as_u64(), time["observer_moves"].as_bool()), (Some(1), Some(false)));
    let header = String::from_utf8_lossy(&folder.bytes("a.fits")).into_owned();
    for keyword in ["TSTART  =", "TSTOP   =", "TIMEUNIT=", "NTIME   ="] {
        assert!(header.contains(keyword), "{keyword}");
    }
    assert!(!header.contains("OBSMOVES"), "nobody moves");
}

#[test]
fn bins_are_a_cube_of_times() {
    let folder = Folder::with_scene(TRAIL);
    let run = folder.emitree(
        "render scene.toml --set time.bins=2 -o a.npy -o a.fits --band band.npy --tolerance 0.001",
    );
    run.succeeds();
    let both = [exact(0.0, 1.0), exact(1.0, 2.0)].concat();
    assert_close(&pixels(&folder.bytes("a.npy")), &both, 0.001);
    assert_close(&pixels(&folder.bytes("band.npy")), &exact(0.0, 2.0), 0.001);
    assert!(run.stdout.contains("\n  times        2 bins of 0–2 s (linear), "), "{}", run.stdout);
    assert!(run.stdout.contains("\n  all times    "), "{}", run.stdout);
    let header = String::from_utf8_lossy(&folder.bytes("a.fits")).into_owned();
    assert!(header.contains("CTYPE3  = 'TIME") && header.contains("'TIMES"), "no times");
}

#[test]
fn all_methods_have_exposures() {
    for method in ["paper", "los"] {
        let folder = Folder::with_scene(TRAIL);
        let options = if method == "los" { "--lines 4" } else { "" };
        folder
            .emitree(&format!("render scene.toml --method {method} {options} -o a.npy"))
            .succeeds();
        assert_close(&pixels(&folder.bytes("a.npy")), &exact(0.0, 2.0), 0.03);
    }
}

#[test]
fn an_observer_who_moves_sees_the_same_trail() {
    let folder = Folder::with_scene(&TRAIL.replace("(x - t)", "x"));
    let run = folder.emitree(
        "render scene.toml --set time.observer.velocity=[-1,0,0] -o a.npy -o a.fits --tolerance 0.001",
    );
    run.succeeds();
    assert_close(&pixels(&folder.bytes("a.npy")), &exact(0.0, 2.0), 0.001);
    let header = String::from_utf8_lossy(&folder.bytes("a.fits")).into_owned();
    assert!(header.contains("OBSMOVES="), "it moves");
}

#[test]
fn what_has_no_exposure_says_so() {
    let moving = "--set time.observer.velocity=[-1,0,0]";
    let folder = Folder::with_scene(TRAIL);
    let refused = |arguments: &str, message: &str| {
        let run = folder.emitree(arguments);
        assert_eq!(run.code, Some(2), "{}", run.stderr);
        let words = run.stderr.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains(message), "{words}");
    };
    refused(
        &format!("plan scene.toml {moving} -o points.npy"),
        "the scene has [time.observer] or light_travel_time",
    );
    refused(
        "render scene.toml --surfaces a.vtp -o a.npy",
        "surfaces are not searched for in a cube",
    );
    refused("render scene.toml --set time.stop=-1 -o a.npy", "`time.stop` is -1");
    let body = TRAIL.replace(
        "[time]",
        "[[occulter]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\n[time]",
    );
    let folder = Folder::with_scene(&body);
    let run = folder.emitree(&format!("render scene.toml {moving} -o a.npy"));
    assert_eq!(run.code, Some(2));
    assert!(
        run.stderr.contains("`[[occulter]]` 1 does not move with the observer"),
        "{}",
        run.stderr
    );
}
