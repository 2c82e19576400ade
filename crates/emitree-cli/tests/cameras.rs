//! Every kind of camera, with bounds, bodies and units, from the scene to the files.

use crate::support::{Folder, decode_png, pixels};
use emitree::projection::healpix::{face_pixel, sight_of_face};
use serde_json::Value;
use std::f64::consts::{PI, TAU};

/// A cloud around the origin, seen from outside along no axis.
const CLOUD: &str = "exp(-(x*x + y*y + z*z)/2)";
const LOOKING: &str = "position = [4, 1, 2]\ntarget = [0, 0, 0.1]\nup = [0.3, 0.2, 1]\nfar = 9";

/// Names, the keys of the camera, and rows and columns.
const CAMERAS: [(&str, &str, [usize; 2]); 8] = [
    ("orthographic", "extent = [5, 4]", [10, 12]),
    ("perspective", "field_of_view = [70, 60]", [10, 12]),
    ("equirectangular", "field_of_view = [80, 60]", [10, 12]),
    ("polar", "field_of_view = 140", [10, 16]),
    ("fisheye", "field_of_view = 120", [15, 15]),
    ("fisheye", "field_of_view = 360\nmapping = 'ZEA'", [13, 17]),
    ("healpix", "position = [4, 1, 2]\nfar = 9", [192, 1]),
    ("canonical", "", [10, 12]),
];

/// A scene with these keys in `[emission]`, `[projection]` and `[image]`, and tables after them.
fn scene(emission: &str, projection: &str, image: &str, tables: &str) -> String {
    format!("[emission]\n{emission}\n[projection]\n{projection}\n[image]\n{image}\n{tables}\n")
}

/// The cloud in one of the [`CAMERAS`], with units.
fn view(kind: &str, keys: &str, [height, width]: [usize; 2]) -> String {
    let pointing = match kind {
        "healpix" | "canonical" => "",
        _ => LOOKING,
    };
    let image = match kind {
        "healpix" => "nside = 4".to_owned(),
        _ => format!("width = {width}\nheight = {height}"),
    };
    let emission = format!("expression = '{CLOUD}'\nunit = 'cm-3 s-1 sr-1'");
    let projection = format!("type = '{kind}'\nlength_unit = 'km'\n{keys}\n{pointing}");
    scene(&emission, &projection, &image, "")
}

/// One image of a FITS file, or one column of a table.
struct Map {
    name: String,
    unit: String,
    values: Vec<f64>,
}

/// All images and columns of a FITS file of 64-bit floats.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn maps(fits: &[u8]) -> Vec<Map> {
    let mut maps = Vec::new();
    let mut rest = fits;
    while !rest.is_empty() {
        let cards: Vec<String> =
            rest.chunks(80).map(|card| String::from_utf8_lossy(card).into_owned()).collect();
        let end = cards.iter().position(|card| card.trim_end() == "END").unwrap();
        let text = |key: &str| {
            let start = format!("{key:8}= ");
            let card = cards[..end].iter().find(|card| card.starts_with(&start))?;
            let value = card[10..].split('/').next().unwrap_or_default();
            Some(match card[10..].split('\'').nth(1) {
                Some(quoted) => quoted.trim_end().to_owned(),
                None => value.trim().to_owned(),
            })
        };
        let number = |key: &str| text(key).map_or(0, |value| value.parse::<usize>().unwrap());
        let axes: Vec<usize> =
            (1..=number("NAXIS")).map(|i| number(&format!("NAXIS{i}"))).collect();
        let is_table = text("XTENSION").is_some_and(|kind| kind == "BINTABLE");
        let count = if axes.is_empty() { 0 } else { axes.iter().product() };
        let bytes = if is_table { count } else { 8 * count };
        let (_, data) = rest.split_at((80 * (end + 1)).next_multiple_of(2880));
        let values: Vec<f64> = data[..bytes]
            .chunks_exact(8)
            .map(|value| f64::from_be_bytes(value.try_into().unwrap()))
            .collect();
        if is_table {
            let columns = number("TFIELDS");
            for column in 0..columns {
                let key = |root: &str| text(&format!("{root}{}", column + 1)).unwrap_or_default();
                let values = values.iter().copied().skip(column).step_by(columns).collect();
                maps.push(Map { name: key("TTYPE"), unit: key("TUNIT"), values });
            }
        } else if count > 0 {
            let unit = text("BUNIT").unwrap_or_default();
            maps.push(Map { name: text("EXTNAME").unwrap(), unit, values });
        }
        rest = &data[bytes.next_multiple_of(2880)..];
    }
    maps
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| largest.max(value.abs()))
}

/// The largest difference of two images over the largest pixel of the second.
fn difference(image: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(image.len(), expected.len());
    let differences = image.iter().zip(expected).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, f64::max) / largest(expected)
}

#[test]
fn every_camera_writes_the_requested_image() {
    for (kind, keys, [height, width]) in CAMERAS {
        let folder = Folder::with_scene(&view(kind, keys, [height, width]));
        let outputs = "-o a.fits -o a.npy -o a.png --report r.json --error-map e.npy";
        folder.emitree(&format!("render scene.toml {outputs} --threads 1")).succeeds();
        folder.holds(&["a.fits", "a.npy", "a.png", "e.npy", "r.json", "scene.toml"]);

        let npy = folder.bytes("a.npy");
        let shape = match kind {
            "healpix" => "'shape': (192,)".to_owned(),
            _ => format!("'shape': ({height}, {width})"),
        };
        assert!(String::from_utf8_lossy(&npy[..128]).contains(&shape), "{kind}: {shape}");
        let (image, error) = (pixels(&npy), pixels(&folder.bytes("e.npy")));
        assert_eq!(image.len(), height * width);
        let (columns, rows, _) = decode_png(&folder.bytes("a.png"));
        let picture = if kind == "healpix" { [256, 512] } else { [height, width] };
        assert_eq!([rows, columns], picture, "{kind}");

        let report = folder.json("r.json");
        assert_eq!(report["converged"], true, "{kind}");
        let unit = "cm-2 s-1 sr-1";
        assert_eq!(report["image"]["quantity"], "radiance");
        assert_eq!(report["image"]["unit"], unit);
        let maps = maps(&folder.bytes("a.fits"));
        let found: Vec<_> = maps.iter().map(|map| (&*map.name, &*map.unit)).collect();
        assert_eq!(found, [("RADIANCE", unit), ("ERROR", unit), ("EVALUATIONS", "")], "{kind}");
        assert_eq!(bits(&maps[0].values), bits(&image), "{kind}");
        assert_eq!(bits(&maps[1].values), bits(&error), "{kind}");
        let sum: f64 = maps[2].values.iter().sum();
        assert_eq!(Some(sum), report["evaluations"].as_f64(), "{kind}");

        folder.emitree("render scene.toml -o b.npy -o b.fits --threads 2").succeeds();
        assert!(folder.bytes("b.npy") == npy, "{kind}: other bits on two threads");
        assert_eq!(bits(&self::maps(&folder.bytes("b.fits"))[2].values), bits(&maps[2].values));
    }
}

/// A pixel has a value if any of it is in the disc.
#[test]
fn a_fisheye_has_no_value_outside_of_its_disc() {
    for (kind, keys, [height, width]) in CAMERAS.into_iter().filter(|(kind, ..)| *kind == "fisheye")
    {
        let folder = Folder::with_scene(&view(kind, keys, [height, width]));
        folder.emitree("render scene.toml -o a.npy --error-map e.npy").succeeds();
        let from_middle = |k: usize, count: usize| {
            let ends = [k, k + 1].map(|edge| edge as f64 / count as f64 - 0.5);
            0.0_f64.clamp(ends[0], ends[1])
        };
        for name in ["a.npy", "e.npy"] {
            for (k, value) in pixels(&folder.bytes(name)).into_iter().enumerate() {
                let (y, x) = (from_middle(k / width, height), from_middle(k % width, width));
                assert_eq!(value.is_nan(), x.hypot(y) >= 0.5, "{keys}: {name} {k} is {value}");
            }
        }
    }
}

#[test]
fn irradiance_is_radiance_times_solid_angle() {
    /// Of a pixel in this row.
    type SolidAngle = fn(usize) -> f64;
    let cases: [(&str, SolidAngle); 3] = [
        ("equirectangular", |row| {
            let latitude = |row: usize| (row as f64 / 10.0 - 0.5) * PI / 3.0;
            80.0_f64.to_radians() / 12.0 * (latitude(row + 1).sin() - latitude(row).sin())
        }),
        ("polar", |row| {
            let angle = |row: usize| row as f64 / 10.0 * 70.0_f64.to_radians();
            TAU / 16.0 * (angle(row).cos() - angle(row + 1).cos())
        }),
        ("healpix", |_| 4.0 * PI / 192.0),
    ];
    for (name, solid_angle) in cases {
        let (kind, keys, shape) = CAMERAS.into_iter().find(|(kind, ..)| *kind == name).unwrap();
        let folder = Folder::with_scene(&view(kind, keys, shape));
        folder.emitree("render scene.toml -o a.fits").succeeds();
        let options = "--set image.quantity=irradiance --report r.json";
        folder.emitree(&format!("render scene.toml -o b.fits {options}")).succeeds();
        let (radiance, irradiance) = (maps(&folder.bytes("a.fits")), maps(&folder.bytes("b.fits")));
        let found: Vec<_> = irradiance.iter().map(|map| (&*map.name, &*map.unit)).collect();
        assert_eq!(found[..2], [("IRRADIANCE", "cm-2 s-1"), ("ERROR", "cm-2 s-1")], "{kind}");
        let report = folder.json("r.json");
        assert_eq!(report["image"]["quantity"], "irradiance");
        assert_eq!(report["image"]["unit"], "cm-2 s-1");
        for map in 0..2 {
            for k in 0..shape[0] * shape[1] {
                let expected = radiance[map].values[k] * solid_angle(k / shape[1]);
                let error = irradiance[map].values[k] - expected;
                assert!(error.abs() <= 1e-12 * expected.abs(), "{kind} {map} {k}: {error}");
            }
        }
    }
}

#[test]
fn an_image_is_in_the_requested_unit() {
    let (kind, keys, shape) = CAMERAS[1];
    let folder = Folder::with_scene(&view(kind, keys, shape));
    folder.emitree("render scene.toml -o a.npy").succeeds();
    let options = "--set image.unit=m-2.s-1.sr-1 --report r.json";
    folder.emitree(&format!("render scene.toml -o b.fits {options}")).succeeds();
    let [found, asked] =
        [maps(&folder.bytes("b.fits")).remove(0).values, pixels(&folder.bytes("a.npy"))];
    let expected: Vec<f64> = asked.iter().map(|pixel| 1e4 * pixel).collect();
    assert!(difference(&found, &expected) < 1e-12);
    let unit = folder.json("r.json")["image"]["unit"].clone();
    assert_eq!(maps(&folder.bytes("b.fits"))[0].unit, unit.as_str().unwrap());
}

/// g is a component of its direction along lines of length 1, so a pixel is one of its line of sight.
#[test]
fn a_sky_is_in_the_nested_order() {
    let emission = "expression = '-(dx + 10*dy + 100*dz)'";
    let sky = "type = 'healpix'\nposition = [3, -2, 1]\nnear = 1\nfar = 2";
    let folder = Folder::with_scene(&scene(emission, sky, "nside = 8", ""));
    folder.emitree("render scene.toml -o a.npy -o a.fits --tolerance 1e-4").succeeds();
    let map = pixels(&folder.bytes("a.npy"));
    assert_eq!(map.len(), 12 * 8 * 8);
    assert_eq!(bits(&maps(&folder.bytes("a.fits"))[0].values), bits(&map));
    for (index, value) in map.into_iter().enumerate() {
        let (face, column, row) = face_pixel(8, index as u64);
        let [x, y, z] =
            sight_of_face(face, [column, row].map(|along| (f64::from(along) + 0.5) / 8.0));
        // The mean over a pixel is nearer to the origin than its middle, by less than 0.3 %.
        assert!((value - (x + 10.0 * y + 100.0 * z)).abs() < 0.3, "{index}: {value}");
    }
}

/// r⁻³ around an opaque sphere of radius 1, from 5 radii.
const EXOSPHERE: &str = "expression = '(x*x + y*y + z*z)^(-1.5)'";
const EXOSPHERE_CAMERA: &str = "type = 'perspective'\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\n\
                                up = [0, 1, 0]\nfield_of_view = [40, 40]\nfar = inf";
const PLANET: &str = "[[occulter]]\ntype = 'sphere'\ncenter = [0, 0, 0]\nradius = 1";

/// Its exact image: along lines in closed form, over pixels by many lines.
fn exact_exosphere(side: usize) -> Vec<f64> {
    const LINES: usize = 64;
    let at = |k: usize| (2.0 * (k as f64 + 0.5) / (side * LINES) as f64 - 1.0) * (PI / 9.0).tan();
    let (mut sums, mut weights) = (vec![0.0; side * side], vec![0.0; side * side]);
    for row in 0..side * LINES {
        for column in 0..side * LINES {
            let (x, y) = (at(column), at(row));
            let squared = 1.0 + x * x + y * y;
            let weight = squared.powf(-1.5);
            // Distances along the line from the point closest to the centre.
            let observer = -5.0 / squared.sqrt();
            let p2 = 25.0 - observer * observer;
            let primitive = |s: f64| s / (p2 * (s * s + p2).sqrt());
            let end = if p2 < 1.0 { primitive(-(1.0 - p2).sqrt()) } else { 1.0 / p2 };
            let pixel = row / LINES * side + column / LINES;
            sums[pixel] += weight * (end - primitive(observer));
            weights[pixel] += weight;
        }
    }
    sums.iter().zip(weights).map(|(sum, weight)| sum / weight).collect()
}

#[test]
fn all_methods_see_an_occulted_exosphere() {
    let image = "width = 12\nheight = 12";
    let folder = Folder::with_scene(&scene(EXOSPHERE, EXOSPHERE_CAMERA, image, PLANET));
    let exact = exact_exosphere(12);
    let methods = [
        ("--method vol --tolerance 0.01", 0.01),
        ("--method vol --tolerance 0.001", 0.001),
        ("--method los --lines 16 --tolerance 1e-3", 0.01),
        ("--method paper --finest-level 7 --threshold 0.1%", 0.01),
    ];
    for (options, within) in methods {
        folder.emitree(&format!("render scene.toml -o a.npy {options}")).succeeds();
        let error = difference(&pixels(&folder.bytes("a.npy")), &exact);
        // The exact image has errors of its own where the limb crosses a pixel.
        assert!(error <= within + 5e-4, "{options}: {error}");
    }
}

/// Two bodies that overlap: what hides what, and where, is taken from the geometry.
#[test]
fn bodies_that_overlap_are_as_by_lines_of_sight() {
    let camera = format!("type = 'perspective'\n{LOOKING}\nfield_of_view = [40, 40]");
    let bodies = format!(
        "{PLANET}\n[[occulter]]\ntype = 'sphere'\ncenter = [0.3, 0.8, 0.2]\nradius = 0.6\n"
    );
    let folder = Folder::with_scene(&scene(EXOSPHERE, &camera, "width = 16\nheight = 16", &bodies));
    folder.emitree("render scene.toml -o a.npy").succeeds();
    folder.emitree("render scene.toml -o b.npy --method los --lines 24 --steps 64").succeeds();
    let error = difference(&pixels(&folder.bytes("a.npy")), &pixels(&folder.bytes("b.npy")));
    assert!(error < 0.015, "{error}");
}

#[test]
fn what_is_outside_of_the_view_costs_nothing() {
    let camera = format!("type = 'perspective'\n{LOOKING}\nfield_of_view = [40, 40]");
    let cloud = format!("expression = '{CLOUD}'");
    let evaluations = |tables: &str| {
        let folder = Folder::with_scene(&scene(&cloud, &camera, "width = 12\nheight = 12", tables));
        folder.emitree("render scene.toml -o a.npy --report r.json").succeeds();
        let report = folder.json("r.json");
        (report, pixels(&folder.bytes("a.npy")))
    };
    let bounds = "[bounds]\ntype = 'sphere'\ncenter = [50, 0, 0]\nradius = 1";
    let (report, image) = evaluations(bounds);
    assert_eq!((&report["evaluations"], &report["estimated_error"]), (&0.into(), &0.0.into()));
    assert_eq!(bits(&image), vec![0; 144]);
    // A wall before the camera: only what is before it is sampled.
    let wall = "[[occulter]]\ntype = 'sphere'\ncenter = [2.4, 0.6, 1.24]\nradius = 1.6";
    let (report, image) = evaluations(wall);
    assert!(report["estimated_error"].as_f64().unwrap() <= 0.01, "{report}");
    assert!(image.iter().all(|pixel| *pixel > 0.0 && *pixel < 1e-3), "{image:?}");
    // A body behind the observer changes nothing.
    let (_, free) = evaluations("");
    let (_, image) = evaluations("[[occulter]]\ntype = 'sphere'\ncenter = [8, 2, 4]\nradius = 2");
    let error = difference(&image, &free);
    assert!(error < 0.015, "{error}");
}

/// The integral of r^-2 to infinity is finite, those of r^-1 and of a constant are not.
#[test]
fn a_glow_without_a_finite_image_is_not_called_converged() {
    let camera = format!("type = 'perspective'\n{LOOKING}\nfield_of_view = [20, 20]");
    let camera = camera.replace("far = 9", "far = inf");
    for (power, code) in [(-1.0, 0), (-0.5, 4), (0.0, 4)] {
        let glow = format!("expression = '(1 + x*x + y*y + z*z)^({power})'");
        let folder = Folder::with_scene(&scene(&glow, &camera, "width = 4\nheight = 4", ""));
        let run = folder.emitree("render scene.toml -o a.npy --report r.json");
        run.fails_with(code);
        let report = folder.json("r.json");
        assert_eq!(report["converged"], Value::Bool(code == 0), "{power}");
        let error = report["estimated_error"].as_f64().unwrap();
        assert_eq!(error <= 0.01, code == 0, "{power}: {error}");
    }
}

#[test]
fn frames_of_a_sky_and_of_a_disc_are_those_of_the_image() {
    for (kind, keys, shape) in [CAMERAS[4], CAMERAS[6]] {
        let folder = Folder::with_scene(&view(kind, keys, shape));
        let options = "--tolerance 0.001 --progressive frames";
        folder.emitree(&format!("render scene.toml -o a.npy {options}")).succeeds();
        let names = folder.names_in("frames", ".npy");
        let is_image = |name: &&String| !name.ends_with("-error.npy");
        assert!(names.iter().filter(is_image).count() >= 2, "{kind}: {names:?}");
        let last = names.iter().rfind(is_image).unwrap();
        let frame = folder.bytes(&format!("frames/{last}"));
        assert!(frame == folder.bytes("a.npy"), "{kind}: {last}");
        assert_eq!(folder.names_in("frames", ".png").len(), names.len() / 2);
    }
}

#[test]
fn errors_are_reported_and_nothing_is_written() {
    let refused = |kind: &str, keys: &str, options: &str, texts: &[&str]| {
        let folder = Folder::with_scene(&view(kind, keys, [8, 8]));
        let run = folder.emitree(&format!("render scene.toml -o a.npy {options}"));
        run.fails_with(2);
        for text in texts {
            assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
        }
        folder.holds(&["scene.toml"]);
    };
    let body = "--set occulter=[{type='sphere',center=[4,1,2.5],radius=1}]";
    let inside = ["the observer at [4.0, 1.0, 2.0] is inside occulter 1"];
    // Parallel lines of sight come from no point that could be inside.
    for (kind, keys, _) in CAMERAS {
        if !["orthographic", "canonical"].contains(&kind) {
            refused(kind, keys, body, &inside);
        }
    }
    let mapping = ["unknown mapping `gnomonic`", "`equidistant` (ARC) or `equal_area` (ZEA)"];
    refused("fisheye", "field_of_view = 90", "--set projection.mapping=gnomonic", &mapping);
    let sky = "position = [4, 1, 2]";
    refused("healpix", sky, "", &["`projection.far` is missing", "(or a table `[bounds]`)"]);
    let nside = ["`image.nside` is 12", "a power of two, 1 to 2^13"];
    refused("healpix", CAMERAS[6].1, "--set image.nside=12", &nside);
    let (kind, keys, _) = CAMERAS[1];
    refused(kind, keys, "--set image.unit=erg", &["`image.unit`: ", "option --set"]);
    let flat = ["`image.quantity` is \"irradiance\"", "parallel lines of sight"];
    refused("orthographic", "extent = [1, 1]", "--set image.quantity=irradiance", &flat);
    let angle = ["`field_of_view` is 361", "a full angle of the cone in (0, 360] degrees"];
    refused("polar", "field_of_view = 361", "", &angle);
}

#[test]
fn a_budget_for_bodies_names_what_is_needed() {
    let image = "width = 12\nheight = 12";
    let folder = Folder::with_scene(&scene(EXOSPHERE, EXOSPHERE_CAMERA, image, PLANET));
    // The planet and the sky: two charts of 27 evaluations each.
    let run = folder.emitree("render scene.toml -o a.npy --max-evaluations 53");
    run.fails_with(2);
    let text = "`max_evaluations` allows 53 evaluations, but the initial sampling of 3 x 3 lines in 3 \
                depths needs 54";
    assert!(run.stderr.contains(text), "{}", run.stderr);
    folder.holds(&["scene.toml"]);
    let run = folder.emitree("render scene.toml -o a.npy --report r.json --max-evaluations 54");
    run.fails_with(4);
    let report = folder.json("r.json");
    assert_eq!(report["converged"], Value::Bool(false));
    assert!(report["evaluations"].as_u64().unwrap() <= 54);
}
