use crate::{RenderedScene, Scene, SceneError};

const SCENE: &str = r#"
[emission]
expression = "exp(-(x - t)^2 - y^2 - z^2)"

[projection]
type = "orthographic"
position = [0, 0, -5]
target = [0, 0, 0]
up = [0, 1, 0]
extent = [6, 6]
far = 10

[image]
width = 8
height = 8

[time]
start = 0
stop = 2
"#;

fn parse(changes: &[[&str; 2]]) -> Result<Scene, SceneError> {
    let mut text = SCENE.to_owned();
    for [from, to] in changes {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    Scene::parse("scene.toml", &text, &[])
}

fn expect(changes: &[[&str; 2]], message: &str, expected: &str) {
    let error = parse(changes).unwrap_err();
    assert_eq!((error.message(), error.expected()), (message, expected));
}

/// The image of a scene, band by band.
fn image(scene: &Scene) -> Vec<f64> {
    let found = scene.render(&scene.emission, &scene.render_options()).unwrap();
    RenderedScene::new(scene, &found).values.voxels().collect()
}

fn assert_close(found: &[f64], exact: &[f64]) {
    assert_eq!(found.len(), exact.len());
    let largest = exact.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    for (found, exact) in found.iter().zip(exact) {
        assert!((found - exact).abs() <= 0.01 * largest, "{found} {exact}");
    }
}

#[test]
fn bins_of_the_time_are_a_third_axis_if_there_are_several() {
    let one = parse(&[]).unwrap();
    assert!(one.energy.is_none());
    assert_eq!(one.axis().map(emitree::EnergyAxis::bins), Some(1));
    let several = parse(&[["stop = 2", "stop = 2\nbins = 4"]]).unwrap();
    let times = several.energy.as_ref().unwrap();
    assert!(times.is_time());
    assert_eq!((times.label(0..1), times.noun()), ("0–0.5 s".to_owned(), "times"));
    let bands = image(&several);
    let mean: Vec<f64> =
        (0..64).map(|pixel| (0..4).map(|bin| bands[64 * bin + pixel]).sum::<f64>() / 4.0).collect();
    assert_close(&image(&one), &mean);
}

/// The image of all times is the mean of the bins, in their unit.
#[test]
fn all_times_together_are_the_mean() {
    let units = [
        ["[emission]\n", "[emission]\nunit = \"W m-3 sr-1\"\n"],
        ["extent =", "length_unit = \"m\"\nextent ="],
        ["stop = 2", "stop = 2\nbins = 4"],
    ];
    let scene = parse(&units).unwrap();
    assert_eq!([scene.image_unit(), scene.band_unit()], ["W m-2 sr-1"; 2]);
    let found = scene.render(&scene.emission, &scene.render_options()).unwrap();
    let rendered = RenderedScene::new(&scene, &found);
    let (bands, all) = (rendered.values.bands(), rendered.flat().unwrap());
    let mean = bands.iter().map(|band| band[(4, 4)]).sum::<f64>() / 4.0;
    assert!((all[(4, 4)] / mean - 1.0).abs() < 1e-12);
}

#[test]
fn an_observer_who_moves_sees_what_a_blob_that_moves_shows() {
    let moving =
        [["(x - t)", "x"], ["stop = 2\n", "stop = 2\nobserver = { velocity = [-1, 0, 0] }\n"]];
    assert_close(&image(&parse(&moving).unwrap()), &image(&parse(&[]).unwrap()));
    let path = "stop = 2\n[time.observer]\ntimes = [0, 1, 2]\n\
                positions = [[0, 0, -5], [-1, 0, -5], [-2, 0, -5]]\n";
    assert_close(
        &image(&parse(&[["(x - t)", "x"], ["stop = 2\n", path]]).unwrap()),
        &image(&parse(&[]).unwrap()),
    );
}

/// Light from the depth s took s/c to the plane of the image.
#[test]
fn light_takes_time() {
    let scene = parse(&[
        ["exp(-(x - t)^2 - y^2 - z^2)", "t"],
        ["extent =", "length_unit = \"m\"\nextent ="],
        ["far = 10", "far = 299792458"],
        ["stop = 2", "stop = 2\nlight_travel_time = true"],
    ]);
    // The mean of t − s/c over 0..2 s and 0..1 light seconds.
    let exact = 299_792_458.0 * (1.0 - 0.5);
    assert_close(&image(&scene.unwrap()), &[exact; 64]);
}

#[test]
fn what_is_wrong_is_refused_where_it_stands() {
    let more = "expected more than 0, the `start`";
    expect(&[["stop = 2", "stop = 0"]], "`time.stop` is 0", more);
    let bins = "expected a number of bins of the time, 1 to 65536";
    expect(&[["stop = 2", "stop = 2\nbins = 0"]], "`time.bins` is 0", bins);
    expect(
        &[["start = 0\n", ""]],
        "`time.start` is missing",
        "expected `start` here: a time in seconds",
    );
    let slip = "did you mean `bins`?";
    expect(&[["stop = 2", "stop = 2\nbinz = 3"]], "unknown key `time.binz`", slip);
    expect(
        &[["[time]", "[energy]\nmin = 1\nmax = 2\nbins = 1\n[time]"]],
        "the scene has `[time]` and `[energy]`",
        "expected one of them: the third axis of a cube is the energy or the time",
    );
    expect(
        &[["stop = 2", "stop = 2\nlight_travel_time = 1"]],
        "`time.light_travel_time` is an integer",
        "expected true or false",
    );
    expect(
        &[["stop = 2", "stop = 2\nlight_travel_time = true"]],
        "`time.light_travel_time` needs a length unit",
        "expected `length_unit` in `[projection]` too, as in \"km\"",
    );
    expect(
        &[["stop = 2", "stop = 2\nobserver = { times = [0, 2] }"]],
        "`[time.observer]` is neither a velocity nor a path",
        "expected `velocity = [x, y, z]`, or `times` and `positions` (and `targets`)",
    );
    expect(
        &[[
            "stop = 2",
            "stop = 2\nobserver = { times = [0, 1], positions = [[0, 0, 0], [1, 0, 0]] }",
        ]],
        "`time.observer.times` is from 0 to 1",
        "expected times from 0 to 2 or beyond, those of the exposure",
    );
    expect(
        &[["stop = 2", "stop = 2\nobserver = { times = [0, 0, 2], positions = [[0, 0, 0]] }"]],
        "`time.observer`: there are 1 points at 3 times: expected one for each time",
        "",
    );
    let orbit = "observer = { times = [0, 2], positions = [[0, 0, -5], [1, 0, -5]], \
                 targets = [[0, 0, 0], [1, 5, -5]] }";
    expect(
        &[["stop = 2", &format!("stop = 2\n{orbit}")]],
        "the camera has no orientation at 2 s",
        "expected a target that is not at the position, nor straight along `up` from there",
    );
}

#[test]
fn the_time_is_known_where_there_is_one() {
    let error = parse(&[["[time]\nstart = 0\nstop = 2\n", ""]]).unwrap_err();
    let message = "`emission.expression`: unknown name `t`: it is the time where there is a time axis, `[time]` in a \
                   scene";
    assert_eq!(error.message(), message);
    let error = parse(&[["- z^2", "- E"]]).unwrap_err();
    assert_eq!(error.message(), "`emission.expression`: unknown name `E`");
    // Without a time a constant may have its name.
    let text = SCENE.replace("[projection]", "constants = { t = 1 }\n[projection]");
    let error = Scene::parse("scene.toml", &text, &[]).unwrap_err();
    assert!(error.message().contains("has a reserved name: `t` is the time"), "{error}");
    let (head, _) = text.split_once("[time]").unwrap();
    assert!(Scene::parse("scene.toml", head, &[]).is_ok());
}

#[test]
fn shapes_that_the_observer_leaves_behind_are_refused_by_name() {
    let with = |shape: &str, observer: &str| {
        let changed = format!("stop = 2\n{observer}\n{shape}");
        parse(&[["stop = 2\n", &changed]])
    };
    let sphere = "center = [0, 0, 0]\nradius = 0.5";
    let velocity = "observer = { velocity = [1, 0, 0] }";
    let body = format!("[[occulter]]\ntype = \"sphere\"\n{sphere}");
    let error = with(&body, velocity).unwrap_err();
    assert_eq!(error.message(), "`[[occulter]]` 1 does not move with the observer");
    let place = "at 0.062500 s this one is 6.250e-2 away";
    assert!(error.expected().ends_with(place), "{}", error.expected());
    let bounds = "[bounds]\ntype = \"box\"\nmin = [-1, -1, -1]\nmax = [1, 1, 1]";
    let error = with(bounds, velocity).unwrap_err();
    assert_eq!(error.message(), "`[bounds]` does not move with the observer");
    let plane = |normal: &str| {
        format!("[[edge]]\ntype = \"plane\"\nposition = [0, 0, 1]\nnormal = {normal}")
    };
    let error = with(&plane("[1, 0, 1]"), velocity).unwrap_err();
    assert_eq!(error.message(), "`[[edge]]` 1 does not move with the observer");
    let seed = "[[seed]]\nposition = [0, 0, 1]\nradius = 0.1";
    let error = with(seed, velocity).unwrap_err();
    assert_eq!(error.message(), "`[[seed]]` 1 does not move with the observer");

    // Along a plane, and about a sphere, they are where they were.
    assert!(with(&plane("[0, 0, 1]"), velocity).is_ok());
    let axis = "[[singularity]]\ntype = \"axis\"\nposition = [0, 0, 0]\ndirection = [1, 0, 0]";
    assert!(with(axis, velocity).is_ok());
    let times: Vec<f64> = (0..=40).map(|k| f64::from(k) / 20.0).collect();
    let positions: Vec<[f64; 3]> =
        times.iter().map(|t| [-5.0 * t.sin(), 0.0, -5.0 * t.cos()]).collect();
    let targets = vec![[0.0; 3]; times.len()];
    let orbit = format!(
        "[time.observer]\ntimes = {times:?}\npositions = {positions:?}\ntargets = {targets:?}"
    );
    let found = with(&body, &orbit);
    assert!(found.is_ok(), "{}", found.unwrap_err());
    let off = body.replace("[0, 0, 0]", "[0, 0.2, 0.1]");
    assert!(with(&off, &orbit).is_err());
}

#[test]
fn projections_without_an_observer_are_refused() {
    let text = "emission.expression = \"t\"\nprojection.type = \"canonical\"\n\
                image = { width = 2, height = 2 }\n\
                time = { start = 0, stop = 1, observer = { velocity = [1, 0, 0] } }\n";
    let error = Scene::parse("scene.toml", text, &[]).unwrap_err();
    assert_eq!(error.message(), "the projection `canonical` has no observer");
}
