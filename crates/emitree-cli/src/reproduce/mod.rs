//! `emitree reproduce`: the paper's Figures 9, 10 and 11, measured anew.

mod figures;
mod measure;

use crate::failure::Failure;
use crate::interrupt;
use emitree_io::{OutputSet, commit_all, grouped};
use measure::{Measurements, Run};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The files, in the order in which they are made.
const NAMES: [&str; 7] = [
    "figure9.csv",
    "figure9.png",
    "figure10.csv",
    "figure10.png",
    "figure11.csv",
    "figure11.png",
    "summary.txt",
];

pub(crate) fn run(folder: &PathBuf) -> Result<ExitCode, Failure> {
    interrupt::catch();
    std::fs::create_dir_all(folder).map_err(|error| {
        Failure::Request(format!("can't make the folder {}: {error}", folder.display()))
    })?;
    let names = NAMES.map(|name| folder.join(name));
    let files = OutputSet::create(&names)?;
    let measured = Measurements::make()?;
    let contents: [Vec<u8>; 7] = [
        figures::csv_of_images(&measured),
        figures::images(&measured)?,
        figures::csv_of_runs(measured.all()),
        figures::error_against_evaluations(&measured)?,
        figures::csv_of_runs(measured.paper()),
        figures::error_against_threshold(&measured)?,
        summary(&measured).into_bytes(),
    ];
    commit_all(files.into_iter().zip(contents))?;
    print(&measured, folder)?;
    Ok(ExitCode::SUCCESS)
}

fn print(measured: &Measurements, folder: &Path) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    write!(out, "{}", summary(measured))?;
    writeln!(out, "figures 9 to 11 as CSV and PNG, and this table, are in {}", folder.display())?;
    Ok(())
}

/// "1 line", "4 lines".
pub(crate) fn counted_lines(lines: usize) -> String {
    format!("{lines} line{}", if lines == 1 { "" } else { "s" })
}

/// Our numbers beside those that the paper states.
fn summary(measured: &Measurements) -> String {
    let percent = |error: f64| format!("{:.2} %", 100.0 * error);
    let cost = |run: Option<&Run>| match run {
        Some(run) => format!("{} for {}", grouped(run.evaluations), percent(run.error)),
        None => "not reached".to_owned(),
    };
    let cheapest = |runs: &[Run]| runs.iter().min_by_key(|run| run.evaluations).cloned();
    let for_one_percent = |runs: &[Run]| -> Option<Run> {
        let good: Vec<Run> = runs.iter().filter(|run| run.error <= 0.01).cloned().collect();
        cheapest(&good)
    };
    let paper = for_one_percent(&measured.paper_8);
    let ratio = |run: Option<&Run>| match (run, &paper) {
        (Some(run), Some(paper)) => {
            format!("{:.1} times as many", run.evaluations as f64 / paper.evaluations as f64)
        }
        _ => String::new(),
    };
    let mut rows = vec![
        ["".into(), "the paper".into(), "here".into()],
        [
            "Fig. 9: hierarchical image, base grid 4^3".into(),
            "4,032 for 6 %".into(),
            cost(Some(&measured.figure_9)),
        ],
        [
            "Fig. 10: hierarchical method, 1 %, base grid 8^3".into(),
            "20,000 for 1 %".into(),
            cost(paper.as_ref()),
        ],
    ];
    for (lines, runs) in &measured.los {
        let run = for_one_percent(runs);
        rows.push([
            format!("Fig. 10: uniform steps, 1 %, {} for each pixel", counted_lines(*lines)),
            if *lines == 1 { "about 10 times as many".into() } else { String::new() },
            format!("{}  {}", cost(run.as_ref()), ratio(run.as_ref())),
        ]);
    }
    let errors = measured.paper().map(|run| run.error);
    let (low, high) = errors.fold((f64::INFINITY, 0.0_f64), |(l, h), e| (l.min(e), h.max(e)));
    rows.push([
        "Fig. 10: span of errors of the hierarchical method".into(),
        "0.35 to 0.0004".into(),
        format!("{high:.2} to {low:.4}"),
    ]);
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let [first, second] = [0, 1].map(|column| width(column).unwrap_or(0));
    let line =
        |[a, b, c]: &[String; 3]| format!("{a:first$}  {b:second$}  {c}").trim_end().to_owned();
    rows.iter().map(|row| line(row) + "\n").collect()
}
