use crate::{Override, Scene, encode_npy};
use emitree::vol::PixelTolerance;
use emitree::{Method, VolOptions};

const VIEW: &str = "emission = { expression = \"1\" }\nprojection = { type = \"canonical\" }\n\
                    image = { width = 3, height = 2 }\n";

fn options(text: &str, overrides: &[Override]) -> Result<VolOptions, String> {
    let scene = Scene::parse("example", &format!("{VIEW}[render]\n{text}"), overrides);
    match scene.map_err(|error| error.to_string())?.render.method {
        Method::Vol(options) => Ok(options),
        other => Err(other.name().to_owned()),
    }
}

#[test]
fn tolerances_by_pixel_are_read_with_their_defaults() {
    let by_pixel = |text: &str| options(text, &[]).map(|options| options.by_pixel);
    let relative = PixelTolerance::relative(0.02);
    assert_eq!(by_pixel("rtol = 0.02"), Ok(Some(relative)));
    assert_eq!(by_pixel("rtol = 0.02\nfloor = 1e-3"), Ok(Some(relative.with_floor(1e-3))));
    let both = relative.with_floor(0.0).with_atol(5.0);
    assert_eq!(by_pixel("rtol = 0.02\natol = 5"), Ok(Some(both)));
    assert_eq!(by_pixel("atol = 5"), Ok(Some(PixelTolerance::absolute(5.0))));
    assert_eq!(by_pixel("tolerance = 0.02"), Ok(None));
}

#[test]
fn an_option_of_the_command_line_replaces_the_other_kind_of_tolerance() {
    let option = |key: &str| Override {
        key: format!("render.{key}"),
        value: "0.03".into(),
        option: format!("--{key}"),
    };
    let found = options("tolerance = 0.1", &[option("rtol")]).unwrap();
    assert_eq!(found.by_pixel, Some(PixelTolerance::relative(0.03)));
    let found = options("rtol = 0.1", &[option("tolerance")]).unwrap();
    assert_eq!((found.by_pixel, found.tolerance), (None, 0.03));
}

#[test]
fn what_can_not_be_is_refused_with_the_key() {
    for (text, message) in [
        ("rtol = 2", "`render.rtol` is 2"),
        ("atol = -1", "`render.atol` is -1"),
        ("rtol = 0.1\nfloor = 1", "`render.floor` is 1"),
        ("floor = 0.1", "`render.floor` is 0.1"),
        ("rtol = 0.1\ntolerance = 0.1", "both `tolerance` and `rtol` are given"),
        ("per_band = true", "`render.per_band` is true"),
        ("per_band = 1", "`render.per_band` is an integer"),
        ("weights = \"nowhere.npy\"", "`render.weights`: "),
    ] {
        let error = options(text, &[]).unwrap_err();
        assert!(error.contains(message), "{text}: {error}");
    }
}

#[test]
fn maps_are_read_and_multiplied() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, shape: [usize; 2], values: &[f64]| {
        let path = folder.path().join(name);
        std::fs::write(&path, encode_npy(&shape, values).unwrap()).unwrap();
        format!("{:?}", path.to_str().unwrap())
    };
    let weights = write("weights.npy", [2, 3], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let mask = write("mask.npy", [2, 3], &[0.0, 1.0, -7.0, 0.0, 1.0, 1.0]);
    let found = options(&format!("weights = {weights}\nmask = {mask}"), &[]).unwrap();
    assert_eq!(found.weights.unwrap().pixels(), [0.0, 2.0, 3.0, 0.0, 5.0, 6.0]);
    let turned = write("turned.npy", [3, 2], &[1.0; 6]);
    let dark = write("dark.npy", [2, 3], &[0.0; 6]);
    let negative = write("negative.npy", [2, 3], &[1.0, 1.0, 1.0, 1.0, -1.0, 1.0]);
    for (text, message) in [
        (format!("weights = {turned}"), "the map has 3 rows of 2 pixels"),
        (format!("mask = {dark}"), "`render.mask` is 0 in all pixels"),
        (format!("weights = {negative}"), "the map has -1 in row 1, column 1"),
    ] {
        let error = options(&text, &[]).unwrap_err();
        assert!(error.contains(message), "{text}: {error}");
    }
}
