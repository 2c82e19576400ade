//! Files of two triangles, as their readers read them.

use super::*;
use crate::RenderedScene;
use crate::scene::Scene;

const SCENE: &str = r#"
    emission = { expression = "x", unit = "ph cm-3 s-1 sr-1" }
    projection = { type = "canonical", length_unit = "R_E" }
    image = { width = 2, height = 2 }
"#;

fn account() -> Account {
    let scene = Scene::parse("scene.toml", SCENE, &[]).unwrap();
    let found = scene.render(&scene.emission, &scene.render_options()).unwrap();
    RenderedScene::new(&scene, &found).account
}

/// A square of side 1 in two triangles.
fn square() -> FoundSurfaces {
    let mut surfaces = FoundSurfaces::default();
    surfaces.positions = vec![[0.0, 0.0, 2.0], [1.0, 0.0, 2.0], [1.0, 1.0, 2.0], [0.0, 1.0, 2.0]];
    surfaces.normals = vec![[0.0, 0.0, 1.0]; 4];
    surfaces.jumps = vec![0.5; 4];
    surfaces.uncertainties = vec![1e-3; 4];
    surfaces.triangles = vec![[0, 1, 2], [0, 2, 3]];
    surfaces
}

/// The bytes of an array in base64 of a .vtp file, by its name.
fn array(text: &str, name: &str) -> Vec<u8> {
    use base64::Engine;
    let (_, rest) = text.split_once(&format!("Name=\"{name}\"")).unwrap();
    let (_, rest) = rest.split_once('>').unwrap();
    let (data, _) = rest.split_once('<').unwrap();
    let bytes = base64::engine::general_purpose::STANDARD.decode(data).unwrap();
    let length = u64::from_le_bytes(bytes[..8].try_into().unwrap());
    assert_eq!(length, bytes.len() as u64 - 8, "{name}");
    bytes[8..].to_vec()
}

fn numbers(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).map(|of| f64::from_le_bytes(of.try_into().unwrap())).collect()
}

fn integers(bytes: &[u8]) -> Vec<i64> {
    bytes.chunks_exact(8).map(|of| i64::from_le_bytes(of.try_into().unwrap())).collect()
}

#[test]
fn polygons_of_vtk_have_all_arrays_and_units() {
    let bytes = SurfaceFormat::Vtp.encode(&square(), &account()).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    assert!(text.contains("NumberOfPoints=\"4\"") && text.contains("NumberOfPolys=\"2\""));
    assert_eq!(numbers(&array(&text, "position"))[3..6], [1.0, 0.0, 2.0]);
    assert_eq!(numbers(&array(&text, "normal"))[..3], [0.0, 0.0, 1.0]);
    assert_eq!(numbers(&array(&text, "jump")), [0.5; 4]);
    assert_eq!(numbers(&array(&text, "uncertainty")), [1e-3; 4]);
    assert_eq!(integers(&array(&text, "connectivity")), [0, 1, 2, 0, 2, 3]);
    assert_eq!(integers(&array(&text, "offsets")), [3, 6]);
    // R_E and a 0.
    assert!(
        text.contains("Name=\"length_unit\" NumberOfTuples=\"1\" format=\"ascii\">82 95 69 0<")
    );
}

#[test]
fn all_elements_are_closed() {
    let bytes = SurfaceFormat::Vtp.encode(&FoundSurfaces::default(), &account()).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let mut open = Vec::new();
    for tag in text.split('<').skip(2) {
        let (tag, _) = tag.split_once('>').unwrap();
        let name = tag.split_whitespace().next().unwrap();
        match name.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name)),
            None => open.push(name),
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

#[test]
fn arrays_of_numpy_have_the_same_names() {
    let bytes = SurfaceFormat::Npz.encode(&square(), &account()).unwrap();
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(bytes)).unwrap();
    let mut read = |name: &str| {
        let mut bytes = Vec::new();
        let mut file = archive.by_name(name).unwrap();
        std::io::Read::read_to_end(&mut file, &mut bytes).unwrap();
        bytes
    };
    assert_eq!(numbers(&read("position.npy")[128..])[3..6], [1.0, 0.0, 2.0]);
    assert_eq!(numbers(&read("jump.npy")[128..]), [0.5; 4]);
    assert_eq!(integers(&read("triangles.npy")[128..]), [0, 1, 2, 0, 2, 3]);
    let unit: Vec<u8> = read("jump_unit.npy")[128..].iter().copied().step_by(4).collect();
    assert_eq!(unit, b"ph cm-3 s-1 sr-1");
    for name in ["normal", "uncertainty", "length_unit", "scene", "version"] {
        assert!(read(&format!("{name}.npy")).starts_with(b"\x93NUMPY"), "{name}");
    }
}

#[test]
fn a_model_has_the_unit_of_its_image_over_its_length() {
    let text = r#"
        emission.model = "cmem"
        image = { width = 2, height = 2 }
        projection = { type = "equirectangular", position = [10, -30, 0], target = [6, 0, 0], up = [0, 0, 1], field_of_view = [16, 27], far = 80, length_unit = "R_E" }
    "#;
    let scene = Scene::parse("scene.toml", text, &[]).unwrap();
    assert_eq!(scene.emission.rate_unit, format!("{} R_E-1", scene.emission.source.image_unit()));
    let plain = Scene::parse(
        "scene.toml",
        "emission.expression = \"x\"\nprojection.type = \"canonical\"\nimage = { width = 2, height = 2 }",
        &[],
    );
    assert_eq!(plain.unwrap().emission.rate_unit, "");
}
