//! `render.smallest_feature`: the size of the smallest Gaussian that must not be missed.

use super::document::{Node, Value};
use super::error::SceneError;
use super::table::Table;
use crate::units::Unit;
use emitree::vol::FeatureSize;

const EXPECTED: &str = "a fraction of the view's cube, above 0 and at most 1, or a length as in \
                        \"0.1 R_E\" or { length = 0.1 }, in `length_unit`";

/// The size in a node; `length_unit` is that of the scene.
pub(super) fn read(node: Node, length_unit: Option<&str>) -> Result<FeatureSize, SceneError> {
    match &node.value {
        Value::Text(text) => length_with_unit(&node, text, length_unit),
        Value::Table(_) => {
            let mut table = Table::new(node)?;
            let length = table.require("length", "a length in `length_unit`, above 0")?;
            table.finish()?;
            let value = length.number()?;
            if value > 0.0 {
                return Ok(FeatureSize::Length(value));
            }
            Err(length.refuse(&value.to_string(), "a length above 0"))
        }
        _ => {
            let fraction = node.number()?;
            if fraction > 0.0 && fraction <= 1.0 {
                return Ok(FeatureSize::Fraction(fraction));
            }
            Err(node.refuse(&fraction.to_string(), EXPECTED))
        }
    }
}

/// "0.1 R_E", in the length unit of the scene.
fn length_with_unit(
    node: &Node,
    text: &str,
    length_unit: Option<&str>,
) -> Result<FeatureSize, SceneError> {
    let refuse = |why: &str| node.refuse(&format!("\"{text}\"{why}"), EXPECTED);
    let (number, unit) = text.trim().split_once(char::is_whitespace).ok_or_else(|| refuse(""))?;
    let number: f64 = number.parse().map_err(|_| refuse(""))?;
    let Some(of_scene) = length_unit else {
        return Err(refuse(", and the scene has no `length_unit`"));
    };
    let factor = Unit::parse(unit.trim())
        .and_then(|unit| unit.factor_to(&Unit::parse(of_scene)?))
        .map_err(|error| refuse(&format!(": {error}")))?;
    let length = number * factor;
    if length > 0.0 && length.is_finite() {
        Ok(FeatureSize::Length(length))
    } else {
        Err(refuse(""))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Override, Scene};
    use emitree::Method;
    use emitree::vol::FeatureSize;

    const VIEW: &str = r#"
        emission.expression = "exp(-r)"
        image = { width = 4, height = 4 }
        [projection]
        type = "orthographic"
        position = [0, 0, 9]
        target = [0, 0, 0]
        up = [0, 1, 0]
        extent = [2, 2]
        far = 18
    "#;

    /// The size that is read, or the message and what was expected.
    fn read(value: &str, unit: &str) -> Result<Option<FeatureSize>, String> {
        let text = format!("{VIEW}{unit}\n[render]\nsmallest_feature = {value}");
        match Scene::parse("scene.toml", &text, &[]) {
            Ok(scene) => match scene.render.method {
                Method::Vol(options) => Ok(options.smallest_feature),
                other => Err(format!("{other:?}")),
            },
            Err(error) => Err(format!("{}: {}", error.message(), error.expected())),
        }
    }

    #[test]
    fn fractions_and_lengths_are_read() {
        let km = "length_unit = \"km\"";
        assert_eq!(read("0.01", ""), Ok(Some(FeatureSize::Fraction(0.01))));
        assert_eq!(read("1", ""), Ok(Some(FeatureSize::Fraction(1.0))));
        assert_eq!(read("\"250 m\"", km), Ok(Some(FeatureSize::Length(0.25))));
        assert_eq!(read("\" 2  km \"", km), Ok(Some(FeatureSize::Length(2.0))));
        assert_eq!(read("{ length = 0.5 }", ""), Ok(Some(FeatureSize::Length(0.5))));
        // On the command line it needs no quotes.
        let change = Override {
            key: "render.smallest_feature".into(),
            value: "0.5 km".into(),
            option: "smallest-feature".into(),
        };
        let scene = Scene::parse("scene.toml", &format!("{VIEW}{km}"), &[change]).unwrap();
        let Method::Vol(options) = scene.render.method else { panic!("{:?}", scene.render) };
        assert_eq!(options.smallest_feature, Some(FeatureSize::Length(0.5)));
    }

    #[test]
    fn what_is_no_size_is_refused() {
        for (value, unit, message) in [
            ("0", "", "`render.smallest_feature` is 0: expected a fraction"),
            ("1.5", "", "`render.smallest_feature` is 1.5: expected a fraction"),
            ("\"tiny\"", "", "`render.smallest_feature` is \"tiny\": expected a fraction"),
            ("\"1 km\"", "", "is \"1 km\", and the scene has no `length_unit`: expected"),
            ("\"1 s\"", "length_unit = \"km\"", "is \"1 s\": "),
            ("\"-1 km\"", "length_unit = \"km\"", "is \"-1 km\": expected a fraction"),
            ("{ length = -1 }", "", "`render.smallest_feature.length` is -1: expected a length"),
            ("true", "", "`render.smallest_feature` is a boolean: expected a number"),
        ] {
            let error = read(value, unit).unwrap_err();
            assert!(error.contains(message), "{value}: {error}");
        }
    }

    #[test]
    fn other_methods_have_no_such_option() {
        let text = format!("{VIEW}\n[render]\nmethod = \"los\"\nsmallest_feature = 0.1");
        let scene = Scene::parse("scene.toml", &text, &[]).unwrap();
        assert_eq!(scene.render.ignored, ["smallest_feature"]);
    }
}
