//! `emitree plan` and `emitree resume`: a rendering by files of points and rates, here with this test as the
//! program that makes the rates.
#![allow(clippy::unwrap_used, reason = "what fails here fails the test")]

use crate::support::{Folder, pixels};
use emitree::{Emission, Samples};
use emitree_io::{Scene, encode_npy};

const SCENE: &str = r#"
[emission]
expression = "exp(-20*((x-0.4)^2+(y-0.6)^2+(z-0.5)^2)) + 0.3/(1+40*((x-0.7)^2+(y-0.3)^2+(z-0.4)^2))"

[projection]
type = "canonical"

[image]
width = 24
height = 16
"#;

/// Bad points, beside the scene, or damaged files: what the scene or the options are wrong for.
const BAD_REQUEST: i32 = 2;
const BAD_EMISSION: i32 = 3;
const NEEDS_RATES: i32 = 5;

/// The scene without its emission.
fn without_emission() -> String {
    SCENE
        .lines()
        .filter(|line| !line.starts_with("[emission") && !line.starts_with("expr"))
        .fold(String::new(), |text, line| text + line + "\n")
}

/// The rates of the scene at rows of x, y, z and a direction.
fn rates(rows: &[Vec<f64>]) -> Vec<f64> {
    let scene = Scene::parse("scene", SCENE, &[]).unwrap();
    let part = |row: &Vec<f64>, from: usize| [row[from], row[from + 1], row[from + 2]];
    let positions: Vec<[f64; 3]> = rows.iter().map(|row| part(row, 0)).collect();
    let directions: Vec<[f64; 3]> = rows.iter().map(|row| part(row, 3)).collect();
    let mut rates = vec![0.0; rows.len()];
    scene.emission.emission_rates(&Samples::new(&positions, &directions), &mut rates).unwrap();
    rates
}

/// The rows of a CSV file of points.
fn csv(folder: &Folder) -> Vec<Vec<f64>> {
    let text = String::from_utf8(folder.bytes("points.csv")).unwrap();
    let (names, rows) = text.split_once('\n').unwrap();
    assert_eq!(names, "x,y,z,dx,dy,dz");
    rows.lines().map(|row| row.split(',').map(|n| n.parse().unwrap()).collect()).collect()
}

/// Writes the file of points again with a column of rates.
fn answer_csv(folder: &Folder) {
    let rates = rates(&csv(folder));
    let text = String::from_utf8(folder.bytes("points.csv")).unwrap();
    let lines = text.lines().skip(1).zip(rates).map(|(line, rate)| format!("{line},{rate:?}\n"));
    let all = format!("x,y,z,dx,dy,dz,rate\n{}", lines.collect::<String>());
    std::fs::write(folder.path("rates.csv"), all).unwrap();
}

/// Writes the rates of a NPY file of points.
fn answer_npy(folder: &Folder) {
    let rows: Vec<Vec<f64>> =
        pixels(&folder.bytes("points.npy")).chunks_exact(6).map(<[f64]>::to_vec).collect();
    let bytes = encode_npy(&[rows.len()], &rates(&rows)).unwrap();
    std::fs::write(folder.path("rates.npy"), bytes).unwrap();
}

/// Goes on until the image is there; returns the number of times that rates were needed.
#[expect(clippy::panic, reason = "what fails here fails the test")]
fn finish(folder: &Folder, options: &str, answer: impl Fn(&Folder)) -> usize {
    for round in 1..200 {
        answer(folder);
        let run =
            folder.emitree(&format!("resume scene.toml {options} -o image.npy --report r.json"));
        if run.code != Some(NEEDS_RATES) {
            run.succeeds();
            return round;
        }
        assert!(!folder.path("image.npy").exists() && !folder.path("r.json").exists());
    }
    panic!("no end");
}

#[test]
fn rates_by_files_make_the_image_of_a_rendering_bit_by_bit() {
    let folder = Folder::with_scene(SCENE);
    folder.emitree("render scene.toml -o whole.npy --report whole.json").succeeds();
    let planned = folder.emitree("plan scene.toml -o points.csv");
    planned.succeeds();
    assert_eq!(planned.stdout, "points.csv: 128 points, after 0 evaluations in 0 rounds\n");
    let rounds = finish(&folder, "--points points.csv --rates rates.csv", answer_csv);
    assert_eq!(folder.bytes("image.npy"), folder.bytes("whole.npy"));
    let (found, whole) = (folder.json("r.json"), folder.json("whole.json"));
    for key in ["batches", "converged", "estimated_error"] {
        assert_eq!(found[key], whole[key], "{key}");
    }
    assert_eq!(whole["batches"], rounds);
    // Neither a rendering nor a run by files evaluates a point twice.
    assert_eq!((&whole["evaluations"], &found["evaluations"]), (&1904.into(), &1904.into()));

    // The same without the emission in the scene, by other files, and in fewer rounds.
    std::fs::write(folder.path("scene.toml"), without_emission()).unwrap();
    std::fs::remove_file(folder.path("image.npy")).unwrap();
    std::fs::remove_file(folder.path("r.json")).unwrap();
    let state = "--state other.state --rounds 6";
    folder.emitree(&format!("plan scene.toml -o points.npy {state}")).succeeds();
    let options = format!("--points points.npy --rates rates.npy {state}");
    let fewer = finish(&folder, &options, answer_npy);
    assert_eq!(folder.bytes("image.npy"), folder.bytes("whole.npy"));
    assert_eq!((rounds, fewer), (22, 8));
}

#[test]
fn a_run_that_has_ended_goes_on_to_a_tighter_tolerance_and_needs_nothing_again() {
    let folder = Folder::with_scene(&without_emission());
    folder.emitree("plan scene.toml -o points.csv --tolerance 0.1").succeeds();
    finish(&folder, "--points points.csv --rates rates.csv --tolerance 0.1", answer_csv);
    // The image of a run that has ended can be written again.
    let again = "resume scene.toml --points points.csv --tolerance 0.1 -o again.npy -q";
    folder.emitree(again).succeeds();
    assert_eq!(folder.bytes("again.npy"), folder.bytes("image.npy"));
    let tighter =
        folder.emitree("resume scene.toml --points points.csv --tolerance 1e-3 -o fine.npy");
    tighter.fails_with(NEEDS_RATES);
    // Without rates the points are written again.
    let points = folder.bytes("points.csv");
    folder
        .emitree("resume scene.toml --points points.csv --tolerance 1e-3")
        .fails_with(NEEDS_RATES);
    assert_eq!(folder.bytes("points.csv"), points);
    let told: Vec<Vec<f64>> = csv(&folder);
    answer_csv(&folder);
    folder.emitree("resume scene.toml --points points.csv --rates rates.csv --tolerance 1e-3");
    assert!(csv(&folder).iter().all(|row| !told.contains(row)));
}

#[test]
fn rates_in_parts_follow_each_other() {
    let folder = Folder::with_scene(&without_emission());
    folder.emitree("plan scene.toml -o points.csv -q").succeeds();
    let rates = rates(&csv(&folder));
    for (name, part) in [("a.npy", &rates[..100]), ("b.npy", &rates[100..])] {
        std::fs::write(folder.path(name), encode_npy(&[part.len()], part).unwrap()).unwrap();
    }
    let run = folder.emitree("resume scene.toml --points points.csv --rates a.npy --rates b.npy");
    run.fails_with(NEEDS_RATES);
    assert!(run.stdout.contains("after 128 evaluations in 1 rounds"), "{}", run.stdout);
}

#[test]
fn rates_that_are_not_those_of_the_points_are_refused_and_nothing_changes() {
    let folder = Folder::with_scene(&without_emission());
    folder.emitree("plan scene.toml -o points.csv -q").succeeds();
    answer_csv(&folder);
    let whole = String::from_utf8(folder.bytes("rates.csv")).unwrap();
    let state = folder.bytes("scene.state");
    let line = |number: usize, text: &str| {
        let mut lines: Vec<String> = whole.lines().map(str::to_owned).collect();
        lines[number] = text.to_owned();
        lines.join("\n")
    };
    let last = whole.lines().last().unwrap();
    let point = last.rsplit_once(',').unwrap().0;
    let moved = format!("0.5{},1", &point[point.find(',').unwrap()..]);
    let cases = [
        (
            whole.replace(last, ""),
            "127 rates in rates.csv: expected 128, one for each point",
            BAD_REQUEST,
        ),
        (
            line(3, &format!("{point},")),
            "line 4: the column `rate` is ``: expected a finite number",
            BAD_REQUEST,
        ),
        (
            line(3, &format!("{point},nan")),
            "line 4: the column `rate` is `nan`: expected a finite",
            BAD_REQUEST,
        ),
        (line(3, "1,2,3"), "line 4 has 3 fields: expected 7, as in line 1", BAD_REQUEST),
        (line(128, &moved), "row 128 is of the point [0.5, ", BAD_REQUEST),
        ("x,y\n1,2\n".into(), "it has no column `rate`: expected one of `x`, `y`", BAD_REQUEST),
    ];
    let files = folder.names();
    for (text, expected, code) in cases {
        std::fs::write(folder.path("rates.csv"), text).unwrap();
        let run = folder.emitree("resume scene.toml --points points.csv --rates rates.csv");
        run.fails_with(code);
        assert!(run.stderr.contains(expected), "{expected}: {}", run.stderr);
        assert_eq!((folder.bytes("scene.state"), folder.names()), (state.clone(), files.clone()));
    }
    let mut numbers = vec![1.0; 128];
    numbers[16] = f64::INFINITY;
    std::fs::write(folder.path("r.npy"), encode_npy(&[128], &numbers).unwrap()).unwrap();
    let run = folder.emitree("resume scene.toml --points points.csv --rates r.npy");
    run.fails_with(BAD_EMISSION);
    assert!(
        run.stderr.contains("the rates r.npy: row 17 is inf: expected a finite"),
        "{}",
        run.stderr
    );
    let run = folder.emitree("resume scene.toml --points points.csv --rates none.npy");
    run.fails_with(BAD_REQUEST);
    assert!(run.stderr.contains("the rates none.npy: "), "{}", run.stderr);
}

#[test]
fn a_scene_or_a_state_that_has_changed_is_refused_by_name() {
    let folder = Folder::with_scene(SCENE);
    folder.emitree("plan scene.toml -o points.csv -q").succeeds();
    let state = folder.bytes("scene.state");
    let resume = "resume scene.toml --points points.csv";
    let refused = |arguments: &str, expected: &str| {
        let run = folder.emitree(arguments);
        run.fails_with(BAD_REQUEST);
        assert!(run.stderr.contains(expected), "{expected}: {}", run.stderr);
    };
    refused(
        "plan scene.toml -o points.csv",
        "the state scene.state exists, with the rates of another run: expected `emitree resume`",
    );
    refused(
        &format!("{resume} --set projection.length_unit=km"),
        "the scene is not that of the state scene.state: `projection.length_unit` is \"km\" and was missing",
    );
    // Neither other pixels nor another tolerance make other rates.
    folder.emitree(&format!("{resume} --width 30 --tolerance 0.05")).fails_with(NEEDS_RATES);
    refused(&format!("{resume} --state none"), "the state none can't be read: ");
    std::fs::write(folder.path("scene.state"), &state[..state.len() / 2]).unwrap();
    refused(resume, "the state scene.state: it is no whole archive");
    std::fs::write(folder.path("scene.state"), &state).unwrap();
    refused(
        "resume scene.toml --points points.txt",
        "expected a name that ends in .npz, .npy or .csv",
    );
    refused("resume scene.toml --points scene.toml", "the points scene.toml: expected a name");
    refused(
        &format!("{resume} --progressive frames"),
        "--progressive: a run that is resumed has no frames",
    );
    folder.holds(&["points.csv", "scene.state", "scene.toml"]);
}

#[test]
fn points_that_cant_be_written_leave_the_state_as_it_was() {
    let folder = Folder::with_scene(&without_emission());
    folder.emitree("plan scene.toml -o points.csv -q --tolerance 0.1").succeeds();
    // Until the state is longer than files may be.
    for _ in 0..4 {
        answer_csv(&folder);
        let resume = "resume scene.toml --points points.csv --rates rates.csv --tolerance 0.1";
        folder.emitree(resume).fails_with(NEEDS_RATES);
    }
    answer_csv(&folder);
    let before = (folder.bytes("points.csv"), folder.bytes("scene.state"), folder.names());
    let resume = "resume scene.toml --points points.csv --rates rates.csv --tolerance 0.1";
    let run = folder.emitree_with_small_files(resume);
    run.fails_with(BAD_REQUEST);
    assert!(run.stderr.contains("cannot write"), "{}", run.stderr);
    assert_eq!((folder.bytes("points.csv"), folder.bytes("scene.state"), folder.names()), before);
}
