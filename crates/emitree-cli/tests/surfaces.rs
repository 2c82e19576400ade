//! Found surfaces as files, and why there are none.

use crate::support::{self, Folder};
use emitree::{Emission, Samples};
use emitree_io::{Override, RenderedScene, Scene};

/// A ball of radius 0.3 in a dimmer cube, whose rate is that of its own unit.
const BALL: &str = r#"
[emission]
expression = "if((x - 50)^2 + (y - 52)^2 + (z - 49)^2 < 900, 2, 0.5)"
unit = "ph m-3 s-1 sr-1"

[projection]
type = "orthographic"
position = [50, 50, 200]
target = [50, 50, 50]
up = [0, 1, 0]
extent = [100, 100]
near = 100
far = 200
length_unit = "km"

[image]
width = 32
height = 32
unit = "ph cm-2 s-1 sr-1"
"#;

/// The numbers of an array in base64 of a .vtp file.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn array(text: &str, name: &str) -> Vec<f64> {
    let (_, rest) = text.split_once(&format!("Name=\"{name}\"")).unwrap();
    let (_, rest) = rest.split_once('>').unwrap();
    let (data, _) = rest.split_once('<').unwrap();
    decoded(data)[8..].chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
}

fn decoded(base64: &str) -> Vec<u8> {
    let value = |letter: u8| match letter {
        b'A'..=b'Z' => letter - b'A',
        b'a'..=b'z' => letter - b'a' + 26,
        b'0'..=b'9' => letter - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let letters: Vec<u8> = base64.bytes().filter(|letter| *letter != b'=').map(value).collect();
    let of_four = |four: &[u8]| {
        let bits = four.iter().fold(0_u32, |bits, six| (bits << 6) | u32::from(*six));
        let bits = bits << (6 * (4 - four.len()));
        bits.to_be_bytes()[1..four.len()].to_vec()
    };
    letters.chunks(4).flat_map(of_four).collect()
}

#[test]
fn surfaces_are_files_in_the_units_of_the_scene() {
    let folder = Folder::with_scene(BALL);
    let run = folder.emitree("render scene.toml -o a.npy --surfaces s.vtp --surfaces s.NPZ");
    run.succeeds();
    assert!(run.stdout.contains("  surfaces     ") && run.stdout.contains(" triangles\n"));
    assert!(run.stdout.contains("written      a.npy, s.vtp, s.NPZ"), "{}", run.stdout);
    folder.holds(&["a.npy", "s.NPZ", "s.vtp", "scene.toml"]);
    let text = String::from_utf8(folder.bytes("s.vtp")).unwrap();
    let (positions, expected) = (array(&text, "position"), array(&text, "uncertainty"));
    assert!(expected.len() > 1_000 && positions.len() == 3 * expected.len());
    for position in positions.as_chunks::<3>().0 {
        let [x, y, z] = position;
        let off = ((x - 50.0).powi(2) + (y - 52.0).powi(2) + (z - 49.0).powi(2)).sqrt() - 30.0;
        assert!(off.abs() < 0.5, "{position:?}: {off} km");
    }
    // In the unit of the expression, not in that of the image over its length.
    assert!(array(&text, "jump").iter().all(|jump| (jump - 1.5).abs() < 1e-9));
}

#[test]
fn without_found_surfaces_there_is_no_file_and_all_others_are_written() {
    let scene =
        BALL.replace("if((x - 50)^2", "exp(-1e-4 * ((x - 50)^2").replace(" < 900, 2, 0.5)", "))");
    let folder = Folder::with_scene(&scene);
    let run = folder.emitree("render scene.toml -o a.npy --surfaces s.vtp");
    run.fails_with(2);
    assert_eq!(
        run.stderr,
        "emitree: --surfaces: the image is not made of found surfaces: expected an emission rate that \
         jumps, and no `base_level` above 3, no `smallest_feature`, no seeds and no tolerance below \
         0.0005; all other outputs were written\n"
    );
    folder.holds(&["a.npy", "scene.toml"]);
}

#[test]
fn what_has_no_surfaces_is_refused_before_g_is_evaluated() {
    let folder = Folder::with_scene(BALL);
    let fails = |options: &str, message: &str| {
        let run = folder.emitree(&format!("render scene.toml -o a.npy {options}"));
        run.fails_with(2);
        assert_eq!(run.stderr, format!("emitree: {message}\n"));
        folder.holds(&["scene.toml"]);
    };
    fails(
        "--surfaces s.stl",
        "--surfaces: `s.stl`: no format for this ending: expected .vtp or .npz",
    );
    fails(
        "--surfaces s.vtp --method los --steps 8",
        "--surfaces: the method `los` finds no surfaces: expected the method `vol`",
    );
    fails(
        "--surfaces s.vtp --set energy.min=1 --set energy.max=2 --set energy.bins=2 --set energy.unit=\"keV\" \
         --set emission.unit=\"ph/m3/s/sr/keV\" --set image.unit=\"ph/cm2/s/sr/keV\"",
        "--surfaces: surfaces are not searched for in a cube: expected a scene without `[energy]`",
    );
    fails(
        "--surfaces s.vtp --surfaces ./s.vtp",
        "`s.vtp` and `./s.vtp` are the same file: expected another name for each output",
    );
    fails(
        "--surfaces no/s.vtp",
        "`no/s.vtp`: cannot create a file in the folder `no` (No such file or directory (os error 2)): \
         expected a folder that can be written",
    );
}

#[test]
fn a_surface_file_that_can_not_be_stored_leaves_the_old_one() {
    let folder = Folder::with_scene(BALL);
    std::fs::write(folder.path("s.vtp"), "old").unwrap();
    let run = folder.emitree_with_small_files("render scene.toml -o a.npy --surfaces s.vtp -q");
    run.fails_with(2);
    assert!(run.stderr.contains("cannot write"), "{}", run.stderr);
    assert_eq!(folder.bytes("s.vtp"), b"old");
    folder.holds(&["s.vtp", "scene.toml"]);
}

#[test]
fn the_magnetopause_and_the_bow_shock_are_where_the_model_jumps() {
    let text = support::example("smile.toml");
    let target = Override {
        key: "projection.target".to_owned(),
        value: "[8, 0, 0]".to_owned(),
        option: "set".to_owned(),
    };
    let scene = Scene::parse("smile.toml", &text, &[target]).unwrap();
    let found = scene.render(&scene.emission, &scene.render_options()).unwrap();
    let surfaces = RenderedScene::new(&scene, &found).surfaces.expect("surfaces are found");
    let mut sides = [3.0, -3.0].map(|side| {
        let vertices =
            surfaces.positions.iter().zip(&surfaces.normals).zip(&surfaces.uncertainties);
        let beside = |((at, normal), expected): ((&[f64; 3], &[f64; 3]), &f64)| {
            core::array::from_fn(|k| at[k] + side * expected * normal[k])
        };
        let positions: Vec<[f64; 3]> = vertices.map(beside).collect();
        let directions = vec![[0.0, 0.0, 1.0]; positions.len()];
        let mut rates = vec![0.0; positions.len()];
        let samples = Samples::new(&positions, &directions);
        scene.emission.source.emission_rates(&samples, &mut rates).unwrap();
        rates.into_iter()
    });
    let mut agreeing = 0;
    for jump in &surfaces.jumps {
        let [bright, dark] = sides.each_mut().map(|side| side.next().unwrap());
        agreeing += usize::from(((bright - dark) / jump - 1.0).abs() < 0.2);
    }
    assert!(agreeing as f64 > 0.9 * surfaces.len() as f64, "{agreeing} of {}", surfaces.len());
}
