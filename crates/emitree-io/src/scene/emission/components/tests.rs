use super::super::{EmissionFailure, EmissionSource};
use crate::scene::Scene;
use emitree::{Emission, Samples};

const REST: &str = "[projection]\ntype = \"canonical\"\n[image]\nwidth = 4\nheight = 4\n";

fn parse(emission: &str) -> Result<Scene, crate::SceneError> {
    Scene::parse("scene.toml", &format!("[emission]\n{emission}\n{REST}"), &[])
}

/// The text that an error marks, its message, and what was expected.
fn refused(emission: &str, message: &str, expected: &str) {
    let error = parse(emission).unwrap_err();
    assert_eq!((error.message(), error.expected()), (message, expected), "{emission}");
}

#[test]
fn names_are_those_given_or_numbers() {
    let names = |emission: &str| parse(emission).unwrap().component_names().unwrap().to_vec();
    assert_eq!(names(r#"expressions = ["x", "y"]"#), ["component_1", "component_2"]);
    let given = "expressions = [\"x\", \"y\"]\ncomponents = [\"total\", \"p-B_2\"]";
    assert_eq!(names(given), ["total", "p-B_2"]);
    assert_eq!(names(r#"expressions = ["x"]"#).len(), 1);
    assert!(parse(r#"expression = "x""#).unwrap().component_names().is_none());
    assert!(parse(r#"expression = "x""#).unwrap().components().is_none());
}

#[test]
fn rates_are_known_where_another_component_was_evaluated() {
    let scene = parse("expressions = [\"a*x\", \"a*y\"]\nconstants = { a = 2 }").unwrap();
    let components = scene.components().unwrap();
    let positions = [[1.0, 5.0, 0.0], [2.0, 6.0, 0.0], [1.0, 5.0, 0.0]];
    let directions = [[0.0, 0.0, 1.0]; 3];
    let rates = |number: usize, of: std::ops::Range<usize>| {
        let mut rates = vec![f64::NAN; of.len()];
        let samples = Samples::new(&positions[of.clone()], &directions[of]);
        components.scenes()[number].emission.emission_rates(&samples, &mut rates).unwrap();
        rates
    };
    assert_eq!(rates(0, 0..2), [2.0, 4.0]);
    assert_eq!(components.evaluations(), 2);
    assert_eq!(rates(1, 0..3), [10.0, 12.0, 10.0]);
    assert_eq!(components.evaluations(), 2);
    // Nothing is known in the components of a scene that are asked for again, or in an empty batch.
    assert_eq!(rates(1, 0..0), Vec::<f64>::new());
    assert_eq!(scene.components().unwrap().evaluations(), 0);
    // A point that a batch has twice is one.
    let again = scene.components().unwrap();
    let mut both = [f64::NAN; 3];
    let samples = Samples::new(&positions, &directions);
    again.scenes()[0].emission.emission_rates(&samples, &mut both).unwrap();
    assert_eq!((both, again.evaluations()), ([2.0, 4.0, 2.0], 2));
}

#[test]
fn without_a_component_there_is_no_rate() {
    let scene = parse(r#"expressions = ["x", "y"]"#).unwrap();
    let found = scene.emission.emission_rates(&Samples::new(&[[0.0; 3]], &[[0.0; 3]]), &mut [0.0]);
    assert_eq!(found, Err(EmissionFailure::Components(2)));
    assert!(matches!(scene.emission.source, EmissionSource::Components(_)));
}

#[test]
fn wrong_lists_are_refused() {
    let list = "expected a list of 1 to 999 expressions, each a string";
    refused("expressions = []", "`emission.expressions` is a list of 0", list);
    refused(r#"expressions = "x""#, "`emission.expressions` is a string", list);
    refused("expressions = { a = \"x\" }", "`emission.expressions` is a table", list);
    let item = "`emission.expressions[1]` is an integer";
    refused(r#"expressions = ["x", 2]"#, item, "expected a string");
    let unknown = "`emission.expressions[1]`: unknown name `q`";
    assert_eq!(parse(r#"expressions = ["x", "q"]"#).unwrap_err().message(), unknown);
    let energy =
        "`emission.expressions[1]` depends on the energy `E`, and the scene has no `[energy]`";
    assert_eq!(parse(r#"expressions = ["x", "E"]"#).unwrap_err().message(), energy);
    refused(
        "expressions = [\"x\", \"b*y\"]\nconstants = { a = 1, b = 2 }",
        "the constant `a` is not used",
        "expected a name that stands in `emission.expressions`",
    );
}

#[test]
fn wrong_names_are_refused() {
    let two = "expressions = [\"x\", \"y\"]\ncomponents = ";
    let count = "expected 2, one for each of `emission.expressions`";
    refused(&format!("{two}[\"a\"]"), "`emission.components` has 1 name", count);
    refused(&format!("{two}[\"a\", \"b\", \"c\"]"), "`emission.components` has 3 names", count);
    let list = "expected a list of names, each a string";
    refused(&format!("{two}\"a\""), "`emission.components` is a string", list);
    refused(&format!("{two}[1, 2]"), "`emission.components[0]` is an integer", "expected a string");
    let letters = "expected 1 to 40 of A-Z, a-z, 0-9, _ and -";
    refused(&format!("{two}[\"a\", \"\"]"), "`emission.components[1]` is \"\"", letters);
    refused(&format!("{two}[\"a/b\", \"c\"]"), "`emission.components[0]` is \"a/b\"", letters);
    let once = "expected each name once, in upper or lower case";
    refused(&format!("{two}[\"a\", \"A\"]"), "`emission.components[1]` is \"A\"", once);
    let ending = "expected another ending: _ERROR, _EVALUATIONS and _BAND are those of its maps";
    refused(
        &format!("{two}[\"a\", \"a_error\"]"),
        "`emission.components[1]` is \"a_error\"",
        ending,
    );
    let number = "expected names that are not another one with a number";
    refused(
        &format!("{two}[\"a\", \"A_2\"]"),
        "`emission.components` has \"A_2\" and \"a\"",
        number,
    );
    refused(
        "expression = \"x\"\ncomponents = [\"a\"]",
        "`emission.components` is for `emission.expressions`",
        "expected `expressions = [\"…\", \"…\"]` too, which they name",
    );
}

#[test]
fn other_emissions_beside_a_list_are_refused() {
    let list = "expressions = [\"x\", \"y\"]\n";
    for (key, other) in [("expression", "\"x\""), ("model", "\"uniform\""), ("tree", "\"t.fits\"")]
    {
        let message = format!("the scene has `emission.{key}` and `emission.expressions`");
        refused(&format!("{list}{key} = {other}"), &message, "expected one of them");
    }
    for key in ["fields", "table"] {
        refused(
            &format!("{list}{key} = {{ n = \"rho\" }}"),
            &format!("`emission.{key}` is given with `emission.expressions`"),
            "expected none: data are for a single `emission.expression`",
        );
    }
    refused(
        &format!("{list}[energy]\nmin = 1\nmax = 2\nbins = 2\n[instrument]\nexposure = 1"),
        "the scene has `[instrument]` and `emission.expressions`",
        "expected none: counts are those of a single `emission.expression`",
    );
    refused(
        &format!("{list}[absorption]\nexpressions = [\"1\"]"),
        "`absorption.expressions`: a medium has one absorption coefficient",
        "expected `expression = \"…\"`",
    );
    let planned = Scene::parse_planned("s", &format!("[emission]\n{list}\n{REST}"), &[]);
    let message = "`emission.expressions` in a scene whose rates another program makes";
    assert_eq!(planned.unwrap_err().message(), message);
}

/// The one pixel of each component of a scene.
fn pixels(tables: &str) -> Vec<f64> {
    let scene =
        Scene::parse("scene.toml", &format!("{tables}\n{}", REST.replace(" = 4", " = 1")), &[]);
    let scene = scene.unwrap();
    let components = scene.components().unwrap();
    let rendered = components.scenes().iter().map(|scene| {
        let found = scene.render(&scene.emission, &scene.render_options()).unwrap();
        assert!(found.converged());
        found.values.bands()[0].pixels()[0]
    });
    rendered.collect()
}

#[test]
fn media_that_absorb_and_exposures_have_components_too() {
    let emission = "[emission]\nexpressions = [\"a\", \"a*z\"]\nconstants = { a = 3 }\n";
    let found = pixels(&format!("{emission}[absorption]\nexpression = \"2\""));
    // ∫ 3 exp(−2z) dz and ∫ 3 z exp(−2z) dz from 0 to 1.
    let e = (-2.0_f64).exp();
    for (found, exact) in found.iter().zip([1.5 * (1.0 - e), 0.75 * (1.0 - 3.0 * e)]) {
        assert!((found / exact - 1.0).abs() < 1e-3, "{found}, {exact}");
    }
    let emission = "[emission]\nexpressions = [\"t\", \"x*t^2\"]\n";
    let found = pixels(&format!("{emission}[time]\nstart = 1\nstop = 3"));
    // The means of t and of t² over 1 to 3 are 2 and 13/3.
    for (found, exact) in found.iter().zip([2.0, 13.0 / 6.0]) {
        assert!((found / exact - 1.0).abs() < 0.01, "{found}, {exact}");
    }
}
