//! The evaluations and errors of the named scenes and cubes in the documents are those of `vol`: a change
//! that costs more or less fails here.

// Shared with the messages of the command.
#[expect(unreachable_pub, reason = "it is public there")]
#[path = "../../emitree-io/src/grouped.rs"]
mod grouped;

use emitree::{Canonical, FromFn, FromSpectralFn, RenderOptions, VolOptions, render, render_cube};
use emitree_problems::catalogue::problem;
use emitree_problems::cubes;
use emitree_problems::relative_error;
use grouped::grouped;
use std::fs;
use std::path::Path;

const RESULTS: &str = "../../docs/results/engine.md";
const README: &str = "../../README.md";
/// The scenes of the first table of the results, with their names there and in the README, if they are.
const SCENES: [(&str, &str, Option<&str>); 7] = [
    ("eq8", "eq. (8)", Some("eq. (8) of the paper")),
    ("shell", "shell", Some("a shell")),
    ("shock", "shock", Some("a shock (g jumps)")),
    ("beta", "β model, core 0.04", Some("a β model with a small core")),
    ("gaussians", "gaussians", None),
    ("ball", "uniform ball", None),
    ("nebula", "nebula (shells with jumps)", None),
];
const TOLERANCES: [f64; 4] = [0.1, 0.01, 1e-3, 1e-4];
/// The cubes of the results that take less than some seconds, and the number of their bins.
const CUBES: [&str; 6] =
    ["separable", "mixture", "narrow-line", "edge", "bremsstrahlung", "ena-ring"];
const BINS: usize = 32;

/// The cells of the first row of a document that begins with a name, without the name.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn row(document: &str, name: &str) -> Vec<String> {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(document)).unwrap();
    let begin = format!("| {name} |");
    let line = text.lines().find(|line| line.starts_with(&begin)).unwrap();
    line.split('|').skip(2).map(|cell| cell.trim().to_owned()).collect()
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn check((name, in_results, in_readme): (&str, &str, Option<&str>)) {
    let problem = problem(name).unwrap();
    let exact = problem.exact_image([64, 64]);
    let cells = row(RESULTS, in_results);
    let filled: Vec<_> = TOLERANCES.iter().zip(&cells).filter(|(_, c)| !c.is_empty()).collect();
    assert!(filled.len() >= 3, "{in_results}: {cells:?}");
    for (&tolerance, cell) in filled {
        let emission = FromFn(|position, _| problem.rate(position));
        let options = RenderOptions::new(VolOptions::new(tolerance));
        let rendering = render(&emission, &Canonical, [64, 64], &options).unwrap();
        let error = relative_error(&rendering.values, &exact);
        assert!(rendering.converged() && error <= tolerance, "{name} {tolerance}: {error}");
        let found = format!("{} ({error:.1e})", grouped(rendering.stats.evaluations));
        assert_eq!(&found, cell, "{name} at {tolerance} in {RESULTS}");
    }
    if let Some(in_readme) = in_readme {
        let at_one_percent = cells[1].split(' ').next();
        assert_eq!(row(README, in_readme).first().map(String::as_str), at_one_percent);
    }
}

macro_rules! as_documented {
    ($($test:ident: $scene:literal;)*) => {$(
        #[test]
        fn $test() {
            check(SCENES[$scene]);
        }
    )*};
}

as_documented! {
    equation_8: 0;
    shell: 1;
    shock: 2;
    beta_model: 3;
    gaussians: 4;
    uniform_ball: 5;
    nebula: 6;
}

/// The second cell of a row describes the cube; the last one is the number of selected energies at 1 %.
#[test]
fn cubes_of_the_results() {
    for name in CUBES {
        let problem = cubes::problem(name).unwrap();
        let axis = problem.default_axis(BINS).unwrap();
        let exact = problem.exact([64, 64], &axis);
        let cells = row(RESULTS, name);
        assert_eq!(cells.len(), 7, "{name}: {cells:?}");
        for (&tolerance, cell) in TOLERANCES[..3].iter().zip(&cells[1..]) {
            let emission = FromSpectralFn(|position, _, energy| problem.rate(position, energy));
            let options = RenderOptions::new(VolOptions::new(tolerance));
            let found = render_cube(&emission, &Canonical, [64, 64], &axis, &options).unwrap();
            let error = found.values.max_difference(&exact) / exact.largest();
            assert!(found.converged() && error <= tolerance, "{name} {tolerance}: {error}");
            let of_cube = format!("{} ({error:.1e})", grouped(found.stats.evaluations));
            assert_eq!(&of_cube, cell, "{name} at {tolerance} in {RESULTS}");
            if (tolerance - 0.01).abs() < 1e-9 {
                assert_eq!(found.stats.energies.len().to_string(), cells[5], "{name}");
            }
        }
    }
}

/// The numbers with groups of digits, as 1,464, of a text.
fn grouped_numbers(text: &str) -> Vec<&str> {
    let words = text.split(|c: char| !(c.is_ascii_digit() || c == ','));
    let is_grouped = |word: &&str| {
        let mut groups = word.split(',');
        let first = groups.next().map_or(0, str::len);
        word.contains(',') && (1..=3).contains(&first) && groups.all(|group| group.len() == 3)
    };
    words.map(|word| word.trim_end_matches(',')).filter(is_grouped).collect()
}

#[test]
fn the_numbers_of_the_paper_are_those_of_the_results() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = |file: &str| fs::read_to_string(root.join(file)).unwrap();
    let results = [text("docs/results/engine.md"), text("docs/peers.md")].concat();
    let (known, paper) = (grouped_numbers(&results), text("paper/paper.md"));
    let numbers = grouped_numbers(&paper);
    assert!(numbers.len() >= 10, "{numbers:?}");
    for number in numbers {
        assert!(known.contains(&number), "{number} is in no table of the results");
    }
}
