//! `[energy]`: the bins of a spectral cube.

use super::error::SceneError;
use super::source::Place;
use super::table::Table;
use crate::energies::Energies;
use crate::units::Unit;
use emitree::energy::EnergyError;
use emitree::{EnergyAxis, EnergyScale};

/// The unit of energies that a scene does not name.
const DEFAULT_UNIT: &str = "keV";

pub(super) fn read(mut table: Table) -> Result<Energies, SceneError> {
    const END: &str = "an energy, in `energy.unit`";
    const BINS: &str = "a number of energy bins, 1 to 65536";
    const APART: &str = "whose borders can be told apart";
    const LINES: &str = "an array of energies, as in [6.4, 6.7]";
    let whole = table.place().clone();
    let (min, max) = (table.require("min", END)?, table.require("max", END)?);
    let bins = table.require("bins", BINS)?;
    let lines = table.take("lines");
    let unit = table.text("unit")?;
    let scale = table.text("scale")?.map_or(Ok(EnergyScale::Linear), |text| scale(&text))?;
    table.finish()?;

    let (low, high) = (min.number()?, max.number()?);
    let axis =
        EnergyAxis::new(low, high, bins.count(BINS)?, scale).map_err(|error| match error {
            EnergyError::Range { min, .. } => {
                max.refuse(&high.to_string(), &format!("more than {min}, the `min`"))
            }
            EnergyError::NotPositive(low) => {
                min.refuse(&low.to_string(), "an energy above 0 for bins of `scale = \"log\"`")
            }
            EnergyError::Bins(count) => bins.refuse(&count.to_string(), BINS),
            EnergyError::Difference { min, max: high } => {
                let expected = format!("a difference to the `min`, {min:?}, below 1.8e308");
                max.refuse(&format!("{high:?}"), &expected)
            }
            EnergyError::Ratio { min, max: high } => {
                let expected = format!("a ratio to the `min`, {min:?}, below 1.8e308");
                max.refuse(&format!("{high:?}"), &(expected + " for bins of `scale = \"log\"`"))
            }
            EnergyError::Narrow { min, max: high, least, .. } if high - min < least => {
                let expected = format!("more than the `min`, {min:?}, by {least:.1e} or more");
                max.refuse(&format!("{high:?}"), &format!("{expected}: bins {APART}"))
            }
            EnergyError::Narrow { bins: count, least, .. } => {
                bins.refuse(&count.to_string(), &format!("bins of {least:.1e} or more, {APART}"))
            }
            other => SceneError::at(&whole, format!("`[energy]`: {other}")),
        })?;
    let lines = lines.as_ref().map_or(Ok(Vec::new()), |lines| lines.list(LINES))?;
    if let Some((line, node)) = lines.iter().find(|(line, _)| !(low..=high).contains(line)) {
        return Err(node.refuse(&line.to_string(), &format!("energies from {low} to {high}")));
    }
    let lines = lines.into_iter().map(|(line, _)| line).collect();
    let name = unit.as_ref().map_or(DEFAULT_UNIT, |(name, _)| name);
    Energies::new(axis, name).map(|energies| energies.with_lines(lines)).map_err(|error| {
        let place = unit.as_ref().map_or(&whole, |(_, place)| place);
        let refused = SceneError::at(place, format!("`energy.unit`: {error}"));
        // The error of a unit has what was expected.
        if Unit::parse(name).is_ok() {
            refused.label("expected a unit of energy, as in \"keV\"")
        } else {
            refused
        }
    })
}

fn scale((name, place): &(String, Place)) -> Result<EnergyScale, SceneError> {
    match name.as_str() {
        "linear" => Ok(EnergyScale::Linear),
        "log" => Ok(EnergyScale::Log),
        unknown => Err(SceneError::at(place, format!("unknown scale `{unknown}`"))
            .label("expected `linear` or `log`")),
    }
}

#[cfg(test)]
mod tests {
    use crate::{Energies, Override, Scene, SceneError};
    use emitree::{EnergyAxis, EnergyScale};

    const SCENE: &str = r#"
[emission]
expression = "1 + x"

[projection]
type = "canonical"

[image]
width = 5
height = 4

[energy]
min = 0.5
max = 8
unit = "eV"
bins = 12
scale = "log"
"#;

    fn scene(from: &str, to: &str) -> Result<Scene, SceneError> {
        assert!(SCENE.contains(from), "{from}");
        Scene::parse("scene.toml", &SCENE.replacen(from, to, 1), &[])
    }

    fn expect([from, to]: [&str; 2], line: usize, message: &str, expected: &str) {
        let error = scene(from, to).unwrap_err();
        assert_eq!((error.line().unwrap().1, error.message()), (line, message));
        assert_eq!(error.expected(), expected);
    }

    #[test]
    fn energies_are_read() {
        let axis = EnergyAxis::new(0.5, 8.0, 12, EnergyScale::Log).unwrap();
        let energies = Energies::new(axis, "eV").unwrap();
        assert_eq!(scene("", "").unwrap().energy, Some(energies));
        let (head, _) = SCENE.split_once("unit").unwrap();
        let change = |key: &str, value: &str| Override {
            key: key.into(),
            value: value.into(),
            option: "set".into(),
        };
        let few = Scene::parse("scene.toml", head, &[change("energy.bins", "3")]).unwrap();
        let axis = EnergyAxis::new(0.5, 8.0, 3, EnergyScale::Linear).unwrap();
        assert_eq!(few.energy, Some(Energies::new(axis, "keV").unwrap()));
        let with_lines = scene("bins = 12", "bins = 12\nlines = [6.4, 1]").unwrap();
        assert_eq!(with_lines.energy.unwrap().lines(), [6.4, 1.0]);
        let (head, _) = SCENE.split_once("[energy]").unwrap();
        assert_eq!(Scene::parse("scene.toml", head, &[]).unwrap().energy, None);
        let changes = ["energy.min", "energy.max", "energy.bins"].map(|key| change(key, "2"));
        let error = Scene::parse("scene.toml", head, &changes).unwrap_err();
        assert_eq!((error.message(), error.line().unwrap().1), ("`energy.max` is 2", 1));
    }

    #[test]
    fn wrong_values_are_marked() {
        let bins = "expected a number of energy bins, 1 to 65536";
        expect(["bins = 12", "bins = 0"], 16, "`energy.bins` is 0", bins);
        expect(["bins = 12", "bins = -1"], 16, "`energy.bins` is -1", bins);
        expect(["bins = 12", "bins = 65537"], 16, "`energy.bins` is 65537", bins);
        expect(["bins = 12", "bins = 1.5"], 16, "`energy.bins` is a number", bins);
        let missing = "expected `bins` here: a number of energy bins, 1 to 65536";
        expect(["bins = 12", ""], 12, "`energy.bins` is missing", missing);
        let missing = "expected `max` here: an energy, in `energy.unit`";
        expect(["max = 8", ""], 12, "`energy.max` is missing", missing);
        expect(
            ["max = 8", "max = 0.5"],
            14,
            "`energy.max` is 0.5",
            "expected more than 0.5, the `min`",
        );
        expect(["max = 8", "max = inf"], 14, "`energy.max` is inf", "expected a finite number");
        expect(["min = 0.5", "min = \"a\""], 13, "`energy.min` is a string", "expected a number");
        let ratio =
            "expected a ratio to the `min`, 0.5, below 1.8e308 for bins of `scale = \"log\"`";
        expect(["max = 8", "max = 1e308"], 14, "`energy.max` is 1e308", ratio);
        let linear = "min = -1e308\nmax = 1e308\nbins = 12";
        let (_, log) = SCENE.trim_end().split_once("[energy]\n").unwrap();
        let difference = "expected a difference to the `min`, -1e308, below 1.8e308";
        expect([log, linear], 14, "`energy.max` is 1e308", difference);
        let narrow = "expected bins of 5.0e-13 or more, whose borders can be told apart";
        expect(["max = 8", "max = 0.500000000001"], 16, "`energy.bins` is 12", narrow);
        let narrow = "expected more than the `min`, 0.5, by 5.0e-13 or more: bins whose borders can \
                      be told apart";
        let close = ["max = 8", "max = 0.5000000000000001"];
        expect(close, 14, "`energy.max` is 0.5000000000000001", narrow);
        let positive = "expected an energy above 0 for bins of `scale = \"log\"`";
        expect(["min = 0.5", "min = 0"], 13, "`energy.min` is 0", positive);
        let scales = "expected `linear` or `log`";
        expect(["\"log\"", "\"ln\""], 17, "unknown scale `ln`", scales);
        let message = "`energy.unit`: unit `km` is of length: expected an energy";
        let expected = "expected a unit of energy, as in \"keV\"";
        expect(["\"eV\"", "\"km\""], 15, message, expected);
        let error = scene("\"eV\"", "\"kev\"").unwrap_err();
        assert!(error.message().starts_with("`energy.unit`: unit `kev`: unknown name `kev`"));
        assert_eq!((error.line().unwrap().1, error.expected()), (15, ""));
        let within = "expected energies from 0.5 to 8";
        expect(["12\n", "12\nlines = [1, 9.5]\n"], 17, "`energy.lines[1]` is 9.5", within);
        let array = "expected an array of energies, as in [6.4, 6.7]";
        expect(["12\n", "12\nlines = 6.4\n"], 17, "`energy.lines` is a number", array);
        let (message, slip) = ("unknown key `energy.scael`", "did you mean `scale`?");
        expect(["scale", "scael"], 17, message, slip);
    }

    #[test]
    fn what_depends_on_the_energy_needs_some() {
        let (head, _) = SCENE.split_once("[energy]").unwrap();
        let refused = |emission: &str, line, column_text: &str| {
            let text = head.replace("expression = \"1 + x\"", emission);
            let error = Scene::parse("scene.toml", &text, &[]).unwrap_err();
            assert_eq!(error.line().unwrap().1, line);
            assert!(error.message().starts_with(column_text), "{error}");
            assert_eq!(
                error.expected(),
                "expected a table `[energy]` too, with `min`, `max` and `bins`"
            );
        };
        let expression = "`emission.expression` depends on the energy `E`, and the scene has no";
        refused("expression = \"1 + exp(-E)\"", 3, expression);
        refused("model = \"bremsstrahlung\"", 3, "`emission.model` depends on the energy");
        let spectral = SCENE.replace("1 + x", "x * exp(-E)");
        assert!(Scene::parse("scene.toml", &spectral, &[]).is_ok());
    }

    #[test]
    fn what_has_no_energies_is_refused_where_it_stands() {
        let expected = "expected an emission that depends on it, `expression = \"…\"` with `E`, or \
                        no `[energy]`";
        let cmem = ["expression = \"1 + x\"", "model = \"cmem\""];
        expect(cmem, 3, "`emission.model` has no spectrum, and the scene has `[energy]`", expected);
        let grid = ["expression = \"1 + x\"", "grid = { file = \"no.npy\" }"];
        expect(grid, 3, "`emission.grid` has no spectrum, and the scene has `[energy]`", expected);
        let tree = ["expression = \"1 + x\"", "tree = \"no.fits\""];
        expect(tree, 3, "`emission.tree` has no spectrum, and the scene has `[energy]`", expected);
    }
}
