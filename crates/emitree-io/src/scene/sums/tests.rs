use crate::{Override, RenderedScene, Scene, encode_npy};
use emitree::sums::SumKind;
use emitree::{Method, VolOptions};

const VIEW: &str = "emission = { expression = \"1 + x\" }\nprojection = { type = \"canonical\" }\n\
                    image = { width = 8, height = 4 }\n";

fn options(text: &str, overrides: &[Override]) -> Result<VolOptions, String> {
    let scene = Scene::parse("example", &format!("{VIEW}[render]\n{text}"), overrides);
    match scene.map_err(|error| error.to_string())?.render.method {
        Method::Vol(options) => Ok(options),
        other => Err(other.name().to_owned()),
    }
}

#[test]
fn regions_are_read_in_pixels_and_on_axes() {
    let found = options("sums = { a = { box = { min = [1, 1], max = [3, 2] } } }", &[]).unwrap();
    let [sum] = &found.sums[..] else { panic!("{:?}", found.sums) };
    assert_eq!((sum.name.as_str(), sum.kind, sum.rtol), ("a", SumKind::Sum, 0.01));
    let mut expected = vec![0.0; 32];
    (expected[9], expected[10]) = (1.0, 1.0);
    assert_eq!(sum.weights.pixels(), expected);
    let text = "sums.b = { circle = { center = [0.5, 0.5], radius = 0.25 }, coordinates = \"axes\", \
                of = \"mean\", tolerance = 1e-3, atol = 2 }";
    let found = options(text, &[]).unwrap();
    let sum = &found.sums[0];
    assert_eq!((sum.kind, sum.rtol, sum.atol), (SumKind::Mean, 1e-3, 2.0));
    let area: f64 = sum.weights.pixels().iter().sum();
    assert!((area - std::f64::consts::PI * 2.0).abs() < 1e-12, "{area}");
}

#[test]
fn tangents_of_angles_are_sampled() {
    let text = "emission = { expression = \"1\" }\nimage = { width = 64, height = 64 }\n\
                projection = { type = \"perspective\", position = [0, 0, 0], target = [1, 0, 0], \
                field_of_view = [60, 60], far = 1 }\n\
                render.sums.c = { box = { min = [-30, 0], max = [30, 15] }, coordinates = \"axes\" }";
    let scene = Scene::parse("scene", text, &[]).unwrap();
    let Method::Vol(vol) = &scene.render.method else { panic!("vol") };
    let area: f64 = vol.sums[0].weights.pixels().iter().sum();
    let rows = 32.0 * 15_f64.to_radians().tan() / 30_f64.to_radians().tan();
    assert!((area / 64.0 - rows).abs() < 0.1, "{area} {rows}");
}

#[test]
fn an_option_adds_a_sum_and_a_file_alone_is_a_mask() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mask.npy");
    std::fs::write(&path, encode_npy(&[4, 8], &[0.5; 32]).unwrap()).unwrap();
    let option = Override {
        key: "render.sums.\"m\"".into(),
        value: path.to_str().unwrap().into(),
        option: "sum".into(),
    };
    let text = "sums = { a = { box = { min = [1, 1], max = [3, 2] } } }";
    let found = options(text, &[option]).unwrap();
    let names: Vec<&str> = found.sums.iter().map(|sum| sum.name.as_str()).collect();
    assert_eq!(names, ["a", "m"]);
    assert_eq!(found.sums[1].weights.pixels(), [0.5; 32]);
}

#[test]
fn what_can_not_be_is_refused_with_the_key() {
    for (text, message) in [
        ("sums = 1", "`render.sums` is an integer"),
        ("sums = {}", "`render.sums` is empty"),
        ("sums.a = {}", "`render.sums.a` has no region of its own"),
        (
            "sums.a = { circle = { center = [1, 1], radius = 0 } }",
            "`render.sums.a.circle.radius` is 0",
        ),
        ("sums.a = { circle = { center = [90, 1], radius = 1 } }", "`render.sums.a` is empty"),
        (
            "sums.a = { box = { min = [1, 1], max = [1, 2] } }",
            "`render.sums.a.box.max` is [1.0, 2.0]",
        ),
        ("sums.a = { mask = \"nowhere.npy\" }", "`render.sums.a.mask`: "),
        (
            "sums.a = { box = { min = [0, 0], max = [1, 1] }, of = \"flux\" }",
            "`render.sums.a.of` is `flux`",
        ),
        (
            "sums.a = { box = { min = [0, 0], max = [1, 1] }, tolerance = 1 }",
            "`render.sums.a.tolerance` is 1",
        ),
        (
            "sums.a = { box = { min = [0, 0], max = [1, 1] }, sum = 1 }",
            "unknown key `render.sums.a.sum`",
        ),
        (
            "method = \"los\"\nsums.a = { box = { min = [0, 0], max = [1, 1] } }",
            "`render.sums` is given",
        ),
        ("tolerance = 1", "`render.tolerance` is 1"),
    ] {
        let error = options(text, &[]).unwrap_err();
        assert!(error.contains(message), "{text}: {error}");
    }
}

#[test]
fn a_mean_and_a_flux_have_their_units_in_either_quantity() {
    let view = |quantity: &str| {
        let text = format!(
            "emission = {{ expression = \"2\", unit = \"ph cm-3 s-1 sr-1\" }}\n\
             image = {{ width = 8, height = 8, quantity = \"{quantity}\" }}\n\
             render = {{ tolerance = 1, sums = {{ f = {{ box = {{ min = [0, 0], max = [4, 8] }}, of = \"flux\" }}, \
             m = {{ box = {{ min = [0, 0], max = [8, 8] }}, of = \"mean\" }} }} }}\n\
             [projection]\ntype = \"equirectangular\"\nposition = [0, 0, 0]\ntarget = [1, 0, 0]\n\
             field_of_view = [20, 20]\nfar = 3\nlength_unit = \"cm\""
        );
        let scene = Scene::parse("scene", &text, &[]).unwrap();
        let found = scene.render(&scene.emission, &scene.render_options()).unwrap();
        RenderedScene::new(&scene, &found)
    };
    let solid_angle = 20_f64.to_radians() * 2.0 * 10_f64.to_radians().sin();
    let [of_radiance, of_irradiance] = ["radiance", "irradiance"].map(|quantity| {
        let rendered = view(quantity);
        let sums = &rendered.account.sums;
        assert_eq!([sums[0].of.as_str(), sums[1].of.as_str()], ["flux", "mean"]);
        assert_eq!(sums[0].unit, "ph cm-2 s-1");
        assert!((sums[0].value - 6.0 * 0.5 * solid_angle).abs() < 1e-9, "{sums:?}");
        let report = rendered.report(None).to_json();
        assert!(report.contains("\"sums\": {\n    \"f\": {"), "{report}");
        let cards = rendered.account.cards();
        let keys: Vec<&str> = cards.iter().map(|card| card.keyword.as_str()).collect();
        assert!(keys.ends_with(&["SUM1", "SUMVAL1", "SUMERR1", "SUM2", "SUMVAL2", "SUMERR2"]));
        sums[1].clone()
    });
    assert!((of_radiance.value - 6.0).abs() < 1e-9 && of_radiance.unit == "ph cm-2 s-1 sr-1");
    assert!((of_irradiance.value - 6.0 * solid_angle / 64.0).abs() < 1e-9);
    assert_eq!(of_irradiance.unit, "ph cm-2 s-1");
}
