use super::state::State;
use super::*;
use crate::grid::{GridRequest, read_arrays};
use crate::scene::Scene;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

const CUBE: &str = "projection = { type = \"canonical\", length_unit = \"km\" }\n\
                    image = { width = 4, height = 4, unit = \"ph cm-2 s-1 sr-1 keV-1\" }\n\
                    emission.unit = \"ph cm-3 s-1 sr-1 keV-1\"\n\
                    energy = { min = 1, max = 2, bins = 2, unit = \"keV\" }\n";

fn scene(text: &str) -> Arc<Scene> {
    Arc::new(Scene::parse_planned("a scene", text, &[]).unwrap())
}

fn write(bytes: &[u8], name: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

#[test]
fn points_of_a_cube_have_energies_in_each_format() {
    let scene = scene(CUBE);
    let run = PlannedRun::new(&scene).unwrap();
    let points = run.points().unwrap();
    assert_eq!(points.energies.len(), points.len());
    let encode = |format: PointsFormat| format.encode(points, &scene).unwrap();

    let text = String::from_utf8(encode(PointsFormat::Csv)).unwrap();
    assert!(text.starts_with("x,y,z,dx,dy,dz,energy\n"));
    let last: Vec<f64> =
        text.lines().last().unwrap().split(',').map(|n| n.parse().unwrap()).collect();
    assert_eq!(last, points.row(points.len() - 1).collect::<Vec<_>>());

    let (_folder, path) = write(&encode(PointsFormat::Npz), "points.npz");
    let read = |name: &str| {
        read_arrays(&path, &GridRequest::default(), |arrays| arrays.array(name)).unwrap()
    };
    assert_eq!(read("position").into_last_fastest(), points.positions.as_flattened());
    assert_eq!(read("direction").shape, [points.len(), 3]);
    assert_eq!(read("energy").into_line().unwrap(), points.energies);

    let (_folder, path) = write(&encode(PointsFormat::Npy), "points.npy");
    let rows = read_arrays(&path, &GridRequest::default(), |arrays| arrays.values(None, &[]));
    assert_eq!(rows.unwrap().shape, [points.len(), 7]);
}

#[test]
fn a_medium_that_absorbs_is_refused() {
    let text = "projection.type = \"canonical\"\nimage = { width = 4, height = 4 }\n\
                absorption.expression = \"1\"\n";
    let refused = PlannedRun::new(&scene(text)).err().unwrap().to_string();
    assert!(refused.contains("the scene has [absorption]"), "{refused}");
}

#[test]
fn rates_are_in_the_unit_of_the_emission() {
    let scene = scene(CUBE);
    let mut run = PlannedRun::new(&scene).unwrap();
    while let Some(points) = run.points() {
        let rates = vec![1.0; points.len()];
        run.tell(&rates).unwrap();
    }
    // 1 ph cm-3 s-1 sr-1 keV-1 along 1 km.
    let found = run.rendering().unwrap();
    assert!(found.values.voxels().all(|voxel| (voxel / 1e5 - 1.0).abs() < 1e-9));
}

#[test]
fn a_state_is_read_as_it_was_written() {
    let mut state = State { rounds: 3, ..State::default() };
    state.scene = BTreeMap::from([("projection.far".to_owned(), "20".to_owned())]);
    state.asked.positions = vec![[1.0, -0.0, 1e-300]];
    state.asked.directions = vec![[0.0, 0.0, 1.0]];
    state.points = state.asked.clone();
    state.rates = vec![0.1];
    let (_folder, path) = write(&state.encode().unwrap(), "a.state");
    assert_eq!(State::read(&path).unwrap(), state);
    for points in [&mut state.asked, &mut state.points] {
        points.energies = vec![5.0];
    }
    let (_folder, path) = write(&state.encode().unwrap(), "a.state");
    assert_eq!(State::read(&path).unwrap(), state);
}

#[test]
fn files_that_are_no_states_are_refused() {
    let refused = |bytes: &[u8]| {
        let (_folder, path) = write(bytes, "a.state");
        State::read(&path).unwrap_err().to_string()
    };
    assert!(refused(b"text").contains("a.state: it is no whole archive"));
    let archive =
        |about: &str| points::archive(&[("about.json", about.as_bytes().to_vec())]).unwrap();
    for (about, expected) in [
        ("{", "its `about.json` is no JSON"),
        ("{}", "its `about.json` is not that of a state: expected a file of `emitree plan`"),
        (r#"{"format": "emitree state", "version": 2}"#, "has version 2: expected 1"),
        (r#"{"format": "emitree state"}"#, "its `about.json` has no `version`"),
        (r#"{"format": "emitree state", "version": 1}"#, "its `about.json` has no `scene`"),
        (r#"{"format": "emitree state", "version": 1, "scene": {}}"#, "it has no array `asked`"),
    ] {
        let found = refused(&archive(about));
        assert!(found.contains(expected), "{expected}: {found}");
    }
    // A byte that has changed.
    let mut bytes = State::default().encode().unwrap();
    let middle = bytes.len() / 3;
    bytes[middle] ^= 4;
    assert!(!refused(&bytes).is_empty());
}
