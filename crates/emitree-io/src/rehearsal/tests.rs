//! Rehearsals of scenes whose oddity is known.

use super::*;

const CAMERA: &str = r#"
[projection]
type = "perspective"
position = [0, -20, 0]
target = [0, 0, 0]
field_of_view = [30, 30]
near = 0
far = 40
"#;

fn scene(emission: &str, rest: &str) -> Scene {
    let image = "[image]\nwidth = 24\nheight = 24\n";
    Scene::parse("scene.toml", &format!("[emission]\n{emission}\n{CAMERA}{image}{rest}"), &[])
        .unwrap()
}

fn remarks(scene: &Scene) -> Vec<Remark> {
    Rehearsal::of(scene, 20_000, None).unwrap().remarks
}

fn only(scene: &Scene) -> Remark {
    let mut found = remarks(scene);
    assert_eq!(found.len(), 1, "{found:?}");
    found.remove(0)
}

const BALL: &str = r#"expression = "exp(-x^2 - y^2 - z^2)""#;

#[test]
fn a_ball_is_forecast_and_has_no_remark() {
    for (tolerance, is_exact) in [(0.05, true), (0.01, false), (0.001, false)] {
        let scene = scene(BALL, &format!("[render]\ntolerance = {tolerance}\n"));
        let rehearsal = Rehearsal::of(&scene, 20_000, None).unwrap();
        assert_eq!(rehearsal.remarks, []);
        let forecast = rehearsal.forecast.unwrap();
        let found = scene.render(&scene.emission, &scene.render_options()).unwrap();
        let [low, high] = forecast.range;
        let true_cost = found.stats.evaluations;
        assert!((low..=high).contains(&true_cost), "{forecast:?} {true_cost}");
        assert_eq!(forecast.is_exact, is_exact);
        if is_exact {
            assert_eq!(forecast.evaluations, true_cost);
        }
    }
}

#[test]
fn nothing_in_view_is_told() {
    let away = scene(r#"expression = "if(y > 30, 1, 0)""#, "");
    let remark = only(&away);
    assert!(
        remark.about == "view" && remark.text.contains("the emission rate is 0 at all"),
        "{remark:?}"
    );
    let body = "[[occulter]]\ntype = \"sphere\"\ncenter = [0, -10, 0]\nradius = 8\n";
    let hidden = scene(r#"expression = "if(x^2 + y^2 + z^2 < 3, 1, 0)""#, body);
    let remark = only(&hidden);
    assert!(
        remark.text.contains("opaque bodies hide them") || remark.text.contains("0 at all"),
        "{remark:?}"
    );
}

#[test]
fn emission_that_is_out_of_view_is_told_with_its_place() {
    // A ball 21 lengths behind the camera: at most exp(−441/4) in view.
    let behind = scene(r#"expression = "exp(-x^2/4 - (y + 41)^2/4 - z^2/4)""#, "");
    let remark = only(&behind);
    assert!(remark.about == "view" && remark.text.contains("which is not in view"), "{remark:?}");
    let place = remark.text.split(['[', ']']).nth(1).unwrap();
    let place: Vec<f64> = place.split(", ").map(|number| number.parse().unwrap()).collect();
    assert!(place[1] < -30.0, "{remark:?}");
    // In view, and with much more beside it.
    let beside = scene(
        r#"expression = "exp(-(x - 14)^2/4 - y^2/4 - z^2/4) + 1e-3 * exp(-x^2 - y^2 - z^2)""#,
        "",
    );
    assert_eq!(remarks(&beside), []);
}

#[test]
fn rates_that_are_out_of_range_or_negative_are_told() {
    let faint = scene(r#"expression = "1e-200 * exp(-x^2 - y^2 - z^2)""#, "");
    let remark = only(&faint);
    assert!(
        remark.about == "rates" && remark.text.starts_with("rates are up to 1.0e-200"),
        "{remark:?}"
    );
    let negative =
        scene(r#"expression = "exp(-x^2 - y^2 - z^2) - 0.5 * exp(-(x-4)^2 - y^2 - z^2)""#, "");
    let remark = only(&negative);
    assert!(remark.text.starts_with("pixels are negative, down to -0.5"), "{remark:?}");
    let infinite = scene(r#"expression = "1 / (x - x)""#, "");
    assert!(matches!(Rehearsal::of(&infinite, 20_000, None), Err(RenderError::NotFinite { .. })));
}

#[test]
fn emission_behind_far_is_told_with_its_amount() {
    // Of the 64 lines that are tried, those nearest to the middle have ∫ exp(−2 (0.0335 t)²/9) dt = 16.7 from t = 40
    // to 80, the brightest pixel some 39.4.
    let endless = scene(r#"expression = "exp(-(x^2 + z^2) / 9)""#, "");
    let remark = only(&endless);
    assert!(remark.about == "far" && remark.text.contains("up to 0.4"), "{remark:?}");
    let ended = scene(
        r#"expression = "exp(-(x^2 + z^2) / 9)""#,
        "[bounds]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 15\n",
    );
    assert_eq!(remarks(&ended), []);
}

#[test]
fn limits_and_keys_without_effect_are_told() {
    let render = "[render]\ntolerance = 0.01\nmax_evaluations = 300\nsteps = 7\n";
    let found = remarks(&scene(BALL, render));
    let abouts: Vec<&str> = found.iter().map(|remark| remark.about).collect();
    assert_eq!(abouts, ["keys", "limits"]);
    assert!(found[0].text.starts_with("`steps` has no effect"), "{found:?}");
    let loose = only(&scene(BALL, "[render]\ntolerance = 0.2\n"));
    assert!(loose.text.starts_with("the tolerance 0.2 is met at 0.05"), "{loose:?}");
    let tight = Rehearsal::of(&scene(BALL, "[render]\ntolerance = 1e-14\n"), 0, None).unwrap();
    assert!(tight.remarks[0].text.starts_with("the tolerance 1e-14 may never be met"), "{tight:?}");
}

#[test]
fn other_methods_are_forecast_from_fewer_pixels_and_larger_thresholds() {
    for (render, is_near) in [
        ("[render]\nmethod = \"los\"\nsteps = 16\n", 1.0),
        ("[render]\nmethod = \"los\"\ntolerance = 1e-4\n", 1.3),
        ("[render]\nmethod = \"paper\"\nthreshold = \"0.1%\"\n", 3.0),
    ] {
        let scene = scene(BALL, render);
        let forecast = Rehearsal::of(&scene, 1_000_000, None).unwrap().forecast.unwrap();
        let found = scene.render(&scene.emission, &scene.render_options()).unwrap();
        let ratio = forecast.evaluations as f64 / found.stats.evaluations as f64;
        assert!((1.0 / is_near - 1e-9..=is_near + 1e-9).contains(&ratio), "{render}: {ratio}");
        let [low, high] = forecast.range;
        assert!((low..=high).contains(&found.stats.evaluations), "{render}: {forecast:?}");
    }
}

/// A rehearsal ends in time, and an interruption is one.
#[test]
fn a_rehearsal_has_an_end() {
    let ridges = scene(r#"expression = "1 + sin(40 * x * y) * cos(31 * y * z)""#, "");
    let rehearsal = Rehearsal::of(&ridges, 3_000, None).unwrap();
    assert!(
        rehearsal.evaluations < 6_000 && rehearsal.how.contains("not to its end"),
        "{rehearsal:?}"
    );
    let stop = |_: u64| std::ops::ControlFlow::Break(());
    assert!(matches!(Rehearsal::of(&ridges, 3_000, Some(&stop)), Err(RenderError::Interrupted)));
    let none = Rehearsal::of(&ridges, 0, None).unwrap();
    assert_eq!((none.evaluations, none.forecast), (0, None));
}
