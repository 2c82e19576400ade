//! `emitree models`: the built-in emission models.

use crate::failure::Failure;
use emitree_models::catalogue::ParameterDefault;
use emitree_models::{ModelDescription, catalogue};
use std::io::Write;
use std::process::ExitCode;

pub(crate) fn run(name: Option<&str>) -> Result<ExitCode, Failure> {
    let mut stdout = std::io::stdout().lock();
    match name {
        None => {
            for (i, model) in catalogue().iter().enumerate() {
                if i > 0 {
                    writeln!(stdout)?;
                }
                describe(&mut stdout, model)?;
            }
        }
        Some(name) => {
            let model = catalogue().iter().find(|model| model.name == name).ok_or_else(|| {
                let names: Vec<_> = catalogue().iter().map(|model| model.name).collect();
                Failure::Request(format!(
                    "unknown model `{name}`: expected one of {}",
                    names.join(", ")
                ))
            })?;
            describe(&mut stdout, model)?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn describe(to: &mut impl Write, model: &ModelDescription) -> Result<(), Failure> {
    writeln!(to, "{}: {}", model.name, model.title)?;
    writeln!(to, "    {}", model.summary)?;
    writeln!(to, "    source       {}", model.source)?;
    writeln!(to, "    length unit  {}", or_none(model.length_unit))?;
    if let Some(unit) = model.energy_unit {
        writeln!(to, "    energy unit  {unit}")?;
    }
    writeln!(to, "    image unit   {}", or_none(model.image_unit))?;
    let default = |parameter: &ParameterDefault| match parameter {
        ParameterDefault::Value(value) => value.to_string(),
        ParameterDefault::Derived(derivation) => format!("= {}", derivation.formula()),
    };
    let rows: Vec<[String; 4]> = model
        .parameters
        .iter()
        .map(|p| [p.name.to_owned(), unit(p.unit), default(&p.default), p.meaning.to_owned()])
        .collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let widths = [0, 1].map(|column| width(column).unwrap_or(0).max(4));
    writeln!(to, "    parameters   (name, unit, default, meaning)")?;
    for [name, unit, default, meaning] in &rows {
        let [wide, unit_wide] = widths;
        // A long formula gets its meaning on the next line.
        if default.chars().count() <= 24 {
            writeln!(to, "      {name:wide$}  {unit:unit_wide$}  {default:24}  {meaning}")?;
        } else {
            writeln!(to, "      {name:wide$}  {unit:unit_wide$}  {default}")?;
            writeln!(to, "      {:wide$}  {:unit_wide$}  {:24}  {meaning}", "", "", "")?;
        }
    }
    Ok(())
}

fn or_none(unit: &str) -> &str {
    if unit.is_empty() || unit == "1" { "none" } else { unit }
}

fn unit(unit: &str) -> String {
    if unit == "1" { "-".to_owned() } else { unit.to_owned() }
}
