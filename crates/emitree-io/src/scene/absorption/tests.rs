use crate::scene::{Scene, SceneError};
use emitree::{Emission, Samples};

fn scene(absorption: &str, other: &str) -> Result<Scene, SceneError> {
    let text = format!(
        "emission = {{ expression = \"1\" }}\nabsorption = {absorption}\n\
         projection = {{ type = \"canonical\", length_unit = \"km\" }}\n\
         image = {{ width = 2, height = 2 }}\n{other}"
    );
    Scene::parse("scene", &text, &[])
}

fn coefficients(scene: &Scene, positions: &[[f64; 3]], energies: &[f64]) -> Vec<f64> {
    let directions = vec![[0.0, 0.0, -1.0]; positions.len()];
    let samples = Samples::new(positions, &directions).at_energies(energies);
    let mut found = vec![0.0; positions.len()];
    scene.emission.absorption_coefficients(&samples, &mut found).unwrap();
    found
}

#[test]
fn a_coefficient_has_the_keys_of_an_emission_and_a_unit_of_its_own() {
    let plain = scene("{ expression = \"k * x\", constants = { k = 3 } }", "").unwrap();
    assert!(plain.emission.absorbs());
    assert_eq!(coefficients(&plain, &[[0.5, 0.0, 0.0]], &[]), [1.5]);
    let scaled = scene("{ expression = \"x\", unit = \"m-1\" }", "").unwrap();
    assert_eq!(coefficients(&scaled, &[[0.5, 0.0, 0.0]], &[]), [500.0]);
    assert_eq!(scaled.emission.absorption.unwrap().unit, "m-1");
    let none = Scene::parse(
        "scene",
        "emission.expression = \"1\"\nprojection.type = \"canonical\"\nimage = { width = 2, height = 2 }",
        &[],
    );
    assert!(!none.unwrap().emission.absorbs());
}

#[test]
fn a_coefficient_may_depend_on_the_energy_and_need_not() {
    let energy = "energy = { min = 1, max = 3, bins = 2 }";
    let of_energy = scene("{ expression = \"E^2\" }", energy).unwrap();
    let positions = [[0.5; 3]; 2];
    assert_eq!(coefficients(&of_energy, &positions, &[2.0, 3.0]), [4.0, 9.0]);
    let grey = scene("{ model = \"uniform\" }", energy).unwrap();
    let [first, second] = coefficients(&grey, &positions, &[2.0, 3.0])[..] else { panic!() };
    assert!((first - second).abs() <= 0.0);
}

#[test]
fn messages_name_the_table_and_its_keys() {
    let error = |absorption: &str| {
        let error = scene(absorption, "").unwrap_err();
        (error.message().to_owned(), error.expected().to_owned())
    };
    assert_eq!(
        error("{ expression = \"E\" }").0,
        "`absorption.expression` depends on the energy `E`, and the scene has no `[energy]`"
    );
    assert!(error("{ expression = \"q\" }").0.starts_with("`absorption.expression`: "));
    assert_eq!(error("{}").0, "`[absorption]` has no coefficient");
    assert_eq!(
        error("{ expression = \"1\", model = \"uniform\" }").0,
        "`[absorption]` has two coefficients"
    );
    assert_eq!(error("{ expression = \"1\", units = \"m\" }").1, "did you mean `unit`?");
    let (message, expected) = error("{ expression = \"1\", unit = \"kg\" }");
    assert!(message.starts_with("`absorption.unit`: "), "{message}");
    assert_eq!(expected, "expected one over a length, as in \"km-1\"");
}

#[test]
fn a_unit_needs_a_length_unit() {
    let text = "emission.expression = \"1\"\nabsorption = { expression = \"1\", unit = \"m-1\" }\n\
                projection.type = \"canonical\"\nimage = { width = 2, height = 2 }";
    let error = Scene::parse("scene", text, &[]).unwrap_err();
    assert_eq!(error.message(), "`absorption.unit` needs a length unit");
    assert_eq!(error.line(), Some(("scene", 2)));
}
