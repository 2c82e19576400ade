//! Scenes with an instrument: expected counts, counts that are drawn, and what can't be had.

use crate::support::{Folder, Run, decode_png, pixels};
use fits_well::FitsWriter;
use fits_well::header::Header;
use fits_well::table::{Builder, ColumnData, WriteColumn};
use serde_json::Value;

/// A uniform emission, 3 cm deep: a radiance of 6 photons cm⁻² s⁻¹ sr⁻¹ keV⁻¹ in all voxels.
const SCENE: &str = r#"
[emission]
expression = "2"
unit = "ph cm-3 s-1 sr-1 keV-1"

[projection]
type = "equirectangular"
position = [0, 0, 0]
target = [1, 0, 0]
field_of_view = [4, 3]
far = 3
length_unit = "cm"

[image]
width = 20
height = 15

[energy]
min = 1
max = 3
bins = 4

[render]
method = "los"
steps = 2

[instrument]
effective_area = "camera.arf"
exposure = 5e4
seed = 3
"#;

const RADIANCE: f64 = 6.0;
const EXPOSURE_S: f64 = 5e4;
/// The mean area in each of the four bins \[cm²\]: 10 up to 2 keV, then 20 in one and 5 in the other.
const AREAS_CM2: [f64; 4] = [10.0, 10.0, 20.0, 5.0];
const WIDTH_KEV: f64 = 0.5;

/// The solid angle of the whole image: 4° of longitude, 3° of latitude about the equator.
fn solid_angle_sr() -> f64 {
    4_f64.to_radians() * 2.0 * 1.5_f64.to_radians().sin()
}

/// The counts that are expected in all pixels of a bin.
fn expected_in_bin(bin: usize) -> f64 {
    RADIANCE * solid_angle_sr() * WIDTH_KEV * AREAS_CM2[bin] * EXPOSURE_S
}

fn expected_total() -> f64 {
    (0..4).map(expected_in_bin).sum()
}

type Column<'a> = (&'a str, Vec<f64>, usize);

/// A FITS file of tables, each with its name and its columns.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn tables(tables: &[(&str, Vec<Column<'_>>)]) -> Vec<u8> {
    let mut writer = FitsWriter::new(Vec::new());
    for (name, columns) in tables {
        let mut table = Builder::new();
        for (name, values, repeat) in columns {
            let values = ColumnData::F64(values.clone());
            table.push(WriteColumn::fixed(*name, values, *repeat)).unwrap();
        }
        let mut header = Header::new();
        header.set("EXTNAME", *name).unwrap();
        if *name == "MATRIX" {
            // The number of the first channel, for the fourth column, F_CHAN.
            header.set("TLMIN4", 7).unwrap();
        }
        writer.write_table(&table, Some(&header)).unwrap();
    }
    writer.into_inner()
}

/// A folder with the scene, its area, and a matrix of two rows and three channels, numbered from 7.
/// Photons below 2 keV have equal probabilities in the first two channels, the others a probability of
/// 0.75 in the third, else not at all.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn folder(scene: &str) -> Folder {
    let folder = Folder::with_scene(scene);
    let area = vec![
        ("ENERG_LO", vec![0.5, 2.0, 2.5], 1),
        ("ENERG_HI", vec![2.0, 2.5, 3.5], 1),
        ("SPECRESP", vec![10.0, 20.0, 5.0], 1),
    ];
    let matrix = vec![
        ("ENERG_LO", vec![1.0, 2.0], 1),
        ("ENERG_HI", vec![2.0, 2.5], 1),
        ("N_GRP", vec![1.0, 1.0], 1),
        ("F_CHAN", vec![7.0, 9.0], 1),
        ("N_CHAN", vec![2.0, 1.0], 1),
        ("MATRIX", vec![0.5, 0.5, 0.75, 0.0], 2),
    ];
    let channels = vec![
        ("CHANNEL", vec![7.0, 8.0, 9.0], 1),
        ("E_MIN", vec![1.0, 1.5, 2.0], 1),
        ("E_MAX", vec![1.5, 2.0, 3.0], 1),
    ];
    std::fs::write(folder.path("camera.arf"), tables(&[("SPECRESP", area)])).unwrap();
    let matrix = tables(&[("MATRIX", matrix), ("EBOUNDS", channels)]);
    std::fs::write(folder.path("camera.rmf"), matrix).unwrap();
    folder
}

fn close(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < 1e-11
}

/// Whether a FITS file has this record.
fn has(fits: &[u8], text: &str) -> bool {
    fits.windows(text.len()).any(|bytes| bytes == text.as_bytes())
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// The names of the steps of a report, each of which has to be balanced.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn balanced_steps(report: &Value) -> Vec<&str> {
    let steps = report["instrument"]["steps"].as_array().unwrap();
    for step in steps {
        let of = |key: &str| number(&step[key]);
        let [given, made] = [of("before") + of("added"), of("after") + of("lost")];
        assert!((given - made).abs() <= 1e-12 * made.abs(), "{step}");
    }
    steps.iter().map(|step| step["step"].as_str().unwrap()).collect()
}

fn refused(folder: &Folder, command: &str, text: &str) {
    let names = folder.names();
    let run = folder.emitree(command);
    run.fails_with(2);
    assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
    assert_eq!(folder.names(), names);
}

#[test]
fn a_uniform_emission_has_the_counts_of_the_closed_form() {
    let folder = folder(SCENE);
    let run = folder.emitree(
        "render scene.toml -o a.npy --expected-counts e.npy --expected-counts e.fits \
         --expected-counts e.png --report r.json",
    );
    run.succeeds();
    let npy = folder.bytes("e.npy");
    assert!(String::from_utf8_lossy(&npy[..128]).contains("'shape': (4, 15, 20)"));
    let counts = pixels(&npy);
    for (bin, band) in counts.chunks(300).enumerate() {
        let [found, expected] = [band.iter().sum(), expected_in_bin(bin)];
        assert!(close(found, expected), "{bin}: {found} {expected}");
    }
    // The rows next to the equator have the largest solid angles.
    assert!(counts[7 * 20] > counts[0] && close(counts[0], counts[14 * 20 + 19]));

    let report = folder.json("r.json");
    assert_eq!(balanced_steps(&report), ["photons", "area"]);
    let instrument = &report["instrument"];
    let area = &instrument["steps"][1];
    assert!(close(number(&area["after"]), expected_total()), "{area}");
    let photons = number(&instrument["steps"][0]["after"]);
    assert!(close(photons, RADIANCE * solid_angle_sr() * 2.0 * EXPOSURE_S), "{photons}");
    assert!(close(number(&instrument["expected_counts"]), counts.iter().sum()));
    assert_eq!((&instrument["channels"], &instrument["seed"]), (&4.into(), &3.into()));
    assert!(instrument["counts"].is_null() && close(number(&instrument["exposure"]), EXPOSURE_S));
    let summary = format!(
        "  counts       {:.6e} expected in 4 channels over 50000 s\n",
        counts.iter().sum::<f64>()
    );
    assert!(run.stdout.contains(&summary), "no {summary} in:\n{}", run.stdout);

    let fits = folder.bytes("e.fits");
    for text in [
        "EXTNAME = 'EXPECTED'",
        "BUNIT   = 'count   '",
        "CTYPE1  = 'XLON-CAR'",
        "CTYPE3  = 'CHANNEL '",
        "EXPOSURE=",
        "EXTNAME = 'EBOUNDS '",
    ] {
        assert!(has(&fits, text), "{text}");
    }
    assert!(!has(&fits, "ENERGIES") && !has(&fits, "SEED    =") && !has(&fits, "'ERROR"));
    let (width, height, _) = decode_png(&folder.bytes("e.png"));
    assert_eq!((width, height), (2 * 20 + 1, 2 * 15 + 1));
}

#[test]
fn a_matrix_makes_channels_of_energies() {
    let folder = folder(&SCENE.replace("seed = 3", "redistribution = \"camera.rmf\""));
    let options = "--expected-counts e.npy --expected-counts e.fits --expected-counts e.png";
    let run = folder.emitree(&format!("render scene.toml -o a.fits {options} --report r.json"));
    run.succeeds();
    assert!(run.stdout.contains(" expected in 3 channels over 50000 s\n"), "{}", run.stdout);
    let counts = pixels(&folder.bytes("e.npy"));
    let below = expected_in_bin(0) + expected_in_bin(1);
    let expected = [0.5 * below, 0.5 * below, 0.75 * expected_in_bin(2)];
    for (band, expected) in counts.chunks(300).zip(expected) {
        let found: f64 = band.iter().sum();
        assert!(close(found, expected), "{found} {expected}");
    }
    let report = folder.json("r.json");
    assert_eq!(balanced_steps(&report), ["photons", "area", "energies", "redistribution"]);
    let lost = |step: usize| number(&report["instrument"]["steps"][step]["lost"]);
    assert!(close(lost(2), expected_in_bin(3)), "beyond 2.5 keV: {}", lost(2));
    assert!(close(lost(3), 0.25 * expected_in_bin(2)), "uncounted: {}", lost(3));

    let fits = folder.bytes("e.fits");
    for text in [
        "NAXIS3  =                    3",
        "CTYPE3  = 'CHANNEL '",
        "CRVAL3  =                  7.0",
        "EXTNAME = 'EBOUNDS '",
        "TTYPE1  = 'CHANNEL '",
        "TUNIT3  = 'keV     '",
    ] {
        assert!(has(&fits, text), "{text}");
    }
    assert!(!has(&fits, "ENERGIES") && has(&folder.bytes("a.fits"), "ENERGIES"));
    // Three channels are three tiles and an empty one.
    let (width, height, _) = decode_png(&folder.bytes("e.png"));
    assert_eq!((width, height), (2 * 20 + 1, 2 * 15 + 1));
}

#[test]
fn counts_are_those_of_their_seed() {
    let folder = folder(SCENE);
    let draw = |options: &str, name: &str| {
        let run = folder.emitree(&format!("render scene.toml -o a.npy --counts {name} {options}"));
        run.succeeds();
        (run, folder.bytes(name))
    };
    let (run, counts) = draw("--expected-counts e.npy --report r.json --threads 1", "c.npy");
    let drawn = pixels(&counts);
    let total: f64 = drawn.iter().sum();
    assert!(run.stdout.contains(&format!(", {total} drawn with seed 3\n")), "{}", run.stdout);
    assert!(drawn.iter().all(|count| count.fract() == 0.0 && *count >= 0.0));
    assert_eq!(folder.json("r.json")["instrument"]["counts"], total);

    let (_, again) = draw("--threads 4 -q", "again.npy");
    assert_eq!(counts, again);
    let (other_run, other) = draw("--seed 4 --report other.json", "other.npy");
    assert_ne!(counts, other);
    assert!(other_run.stdout.contains(" drawn with seed 4\n"), "{}", other_run.stdout);
    assert_eq!(folder.json("other.json")["instrument"]["seed"], 4);
    let (_, set) = draw("--set instrument.seed=4", "set.npy");
    assert_eq!(other, set);
    draw("--seed 5", "c.fits");
    let fits = folder.bytes("c.fits");
    for text in ["EXTNAME = 'COUNTS  '", "SEED    =                    5", "'count   '"] {
        assert!(has(&fits, text), "{text}");
    }

    // Five standard deviations of the sum, and of χ² with 1200 degrees of freedom.
    let expected = pixels(&folder.bytes("e.npy"));
    for counts in [&drawn, &pixels(&other)] {
        let total: f64 = counts.iter().sum();
        let sum = expected_total();
        assert!((total - sum).abs() < 5.0 * sum.sqrt(), "{total} {sum}");
        let chi2: f64 =
            counts.iter().zip(&expected).map(|(count, mean)| (count - mean).powi(2) / mean).sum();
        assert!((chi2 - 1200.0).abs() < 5.0 * 2400_f64.sqrt(), "{chi2}");
    }
}

#[test]
fn a_blur_and_a_background_are_in_the_report() {
    let parts = "psf = { fwhm_arcsec = 1440 }\nbackground = { per_kev_sr = 50 }";
    let folder = folder(&SCENE.replace("seed = 3", parts));
    folder.emitree("render scene.toml -o a.npy --expected-counts e.npy --report r.json").succeeds();
    let report = folder.json("r.json");
    assert_eq!(balanced_steps(&report), ["photons", "area", "psf", "background"]);
    let steps = &report["instrument"]["steps"];
    let added = 50.0 * 2.0 * solid_angle_sr() * EXPOSURE_S;
    assert!(close(number(&steps[3]["added"]), added), "{}", steps[3]);
    // Some of the light of the pixels along the borders leaves the image.
    let lost = number(&steps[2]["lost"]) / expected_total();
    assert!(lost > 0.05 && lost < 0.3, "{lost}");
    let counts = pixels(&folder.bytes("e.npy"));
    assert!(counts[7 * 20 + 10] > 1.3 * counts[0]);
    let total: f64 = counts.iter().sum();
    assert!(close(total, expected_total() * (1.0 - lost) + added), "{total}");
}

#[test]
fn counts_do_not_depend_on_the_quantity_or_the_unit_of_the_image() {
    let total = |image: &str| {
        let folder = folder(&SCENE.replace("height = 15", &format!("height = 15\n{image}")));
        folder.emitree("render scene.toml -o a.npy --report r.json").succeeds();
        let report = folder.json("r.json");
        balanced_steps(&report);
        number(&report["instrument"]["expected_counts"])
    };
    for image in [
        "",
        "quantity = \"irradiance\"",
        "unit = \"ph m-2 h-1 arcsec-2 eV-1\"",
        "quantity = \"irradiance\"\nunit = \"ph m-2 s-1 keV-1\"",
    ] {
        let found = total(image);
        assert!((found / expected_total() - 1.0).abs() < 1e-9, "{image}: {found}");
    }
}

#[test]
fn a_sky_has_a_column_for_each_channel() {
    let sky = "type = \"healpix\"\nposition = [0, 0, 0]";
    let camera = "type = \"equirectangular\"\nposition = [0, 0, 0]\ntarget = [1, 0, 0]\n\
                  field_of_view = [4, 3]";
    let scene = SCENE.replace(camera, sky).replace("width = 20\nheight = 15", "nside = 4");
    let folder = folder(&scene.replace("seed = 3", "redistribution = \"camera.rmf\""));
    let options = "-o a.npy --counts c.fits --expected-counts e.npy --counts c.png -q";
    folder.emitree(&format!("render scene.toml {options}")).succeeds();
    let counts = pixels(&folder.bytes("e.npy"));
    assert_eq!(counts.len(), 3 * 12 * 16);
    let sphere = 4.0 * std::f64::consts::PI / solid_angle_sr();
    let third: f64 = counts[2 * 192..].iter().sum();
    assert!(close(third, 0.75 * expected_in_bin(2) * sphere), "{third}");
    let fits = folder.bytes("c.fits");
    for text in
        ["TTYPE1  = 'COUNTS_1'", "TTYPE3  = 'COUNTS_3'", "TUNIT3  = 'count   '", "SEED    ="]
    {
        assert!(has(&fits, text), "{text}");
    }
    assert!(!has(&fits, "TTYPE4") && !has(&fits, "ENERGIES"));

    // The radiance of 1000 bins has no room in FITS, their counts in three channels have.
    let many = "-o many.npy --counts many.fits --set energy.bins=1000 -q";
    folder.emitree(&format!("render scene.toml {many}")).succeeds();
}

#[test]
fn a_table_of_the_sky_has_room_for_so_many_channels() {
    let scene = SCENE.replace("target = [1, 0, 0]\nfield_of_view = [4, 3]\n", "");
    let scene = scene.replace("equirectangular", "healpix");
    let folder = folder(&scene.replace("width = 20\nheight = 15", "nside = 1"));
    let counts = |bins: usize| {
        format!("render scene.toml -o a.npy --counts c.fits --set energy.bins={bins} -q")
    };
    let text = "emitree: counts: a table of FITS has no columns for 1000 channels of a sky: expected \
                999 or less, or .npy\n";
    refused(&folder, &counts(1000), text);
    folder.emitree(&counts(999)).succeeds();
    assert!(has(&folder.bytes("c.fits"), "'COUNTS_999'"));
}

#[test]
fn what_is_outside_of_a_disc_has_no_counts() {
    let scene = SCENE.replace("field_of_view = [4, 3]", "field_of_view = 4");
    let scene = scene.replace("equirectangular", "fisheye").replace("height = 15", "height = 20");
    let folder = folder(&scene.replace("seed = 3", "background.per_pixel = 1e-5"));
    let options = "--expected-counts e.npy --counts c.npy --report r.json -q";
    // `los` has no line in some of the pixels on the rim.
    folder.emitree(&format!("render scene.toml -o a.npy --method vol {options}")).succeeds();
    let [radiance, expected, drawn] =
        ["a.npy", "e.npy", "c.npy"].map(|name| pixels(&folder.bytes(name)));
    assert!(radiance[0].is_nan());
    for (radiance, count) in radiance.iter().zip(&expected).chain(radiance.iter().zip(&drawn)) {
        assert_eq!(radiance.is_nan(), count.is_nan());
    }
    let inside = radiance.iter().filter(|radiance| !radiance.is_nan()).count() as f64;
    // The solid angle of a cone of 2° about the pointing.
    let disc = 2.0 * std::f64::consts::PI * (1.0 - 2_f64.to_radians().cos()) / solid_angle_sr();
    let total = expected_total() * disc + inside * 1e-5 * EXPOSURE_S;
    let report = folder.json("r.json");
    balanced_steps(&report);
    let found = number(&report["instrument"]["expected_counts"]);
    assert!((found / total - 1.0).abs() < 1e-6, "{found} {total}");
}

#[test]
fn options_change_the_instrument() {
    let folder = folder(SCENE);
    let total = |options: &str| {
        folder.emitree(&format!("render scene.toml -o a.npy --report r.json {options}")).succeeds();
        number(&folder.json("r.json")["instrument"]["expected_counts"])
    };
    let twice = total("--set instrument.exposure=1e5");
    assert!(close(twice, 2.0 * expected_total()), "{twice}");
    let flat = total("--set instrument.effective_area=10");
    assert!(close(flat, 4.0 * expected_in_bin(0)), "{flat}");
    // A file of an option is where the command is given.
    let same = total("--set instrument.effective_area=camera.arf");
    assert!(close(same, expected_total()), "{same}");
}

#[test]
fn pictures_of_counts_are_annotated_sheets() {
    let folder = folder(SCENE);
    let sheet = |option: &str| {
        let command = format!("render scene.toml -o a.npy {option} c.png --annotate -q");
        folder.emitree(&command).succeeds();
        let (width, height, _) = decode_png(&folder.bytes("c.png"));
        assert!(width > 1000 && height > 800, "{width} x {height}");
        folder.bytes("c.png")
    };
    assert_ne!(sheet("--expected-counts"), sheet("--counts"));
}

#[test]
fn counts_without_an_instrument_are_refused() {
    let (scene, _) = SCENE.split_once("[instrument]").unwrap();
    let folder = folder(scene);
    for option in ["--counts", "--expected-counts"] {
        let expected = format!(
            "emitree: {option}: the scene has no `[instrument]`, and nothing counts its photons: \
             expected a scene with one\n"
        );
        refused(&folder, &format!("render scene.toml -o a.npy {option} c.npy"), &expected);
    }
    let command = "render scene.toml -o a.npy --seed 4";
    refused(&folder, command, "the scene has no `[instrument]`");
    refused(&folder, command, "expected a table `[instrument]` with `exposure` and");
    folder.emitree("render scene.toml -o a.npy --report r.json -q").succeeds();
    assert!(folder.json("r.json")["instrument"].is_null());
}

#[test]
fn files_of_counts_are_refused_before_the_rendering() {
    let folder = folder(SCENE);
    let with = |options: &str| format!("render scene.toml -o a.npy {options}");
    refused(&folder, &with("--counts c.jpg"), "`c.jpg`: no format for this ending");
    refused(&folder, &with("--counts a.npy"), "`a.npy` and `a.npy` are the same file");
    refused(&folder, &with("--counts c.npy --expected-counts c.npy"), "are the same file");
    refused(&folder, &with("--expected-counts no/c.npy"), "`no/c.npy`: cannot create a file");
    refused(&folder, &with("--counts scene.toml"), "scene.toml is the scene itself");
    refused(&folder, &with("--seed -1"), "`instrument.seed` is -1");
    refused(&folder, &with("--seed abc"), "`instrument.seed` is a string");
    let huge = "--width 1000000 --height 1000000 --counts c.npy";
    let text = "counting 1000000 x 1000000 pixels in 4 channels would take ";
    refused(&folder, &with(huge), text);
}

/// Counts that no distribution has are found at the end, and cost nothing but themselves.
#[test]
fn counts_that_can_not_be_drawn_leave_all_else() {
    let folder = folder(SCENE);
    let command = "render scene.toml -o a.npy -o a.fits --band b.npy --expected-counts e.npy \
                   --report r.json --set instrument.exposure=1e20 --counts c.npy --counts c.png";
    let run: Run = folder.emitree(command);
    run.fails_with(2);
    let text = "emitree: --counts: the expected counts in channel 0 at row 0, column 0 are ";
    assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
    assert!(run.stderr.ends_with("; all other outputs were written\n"), "{}", run.stderr);
    let files = "a.fits a.npy b.npy camera.arf camera.rmf e.npy r.json scene.toml";
    folder.holds(&files.split(' ').collect::<Vec<_>>());
    let written = "  written      a.npy, a.fits, b.npy, e.npy, r.json\n";
    assert!(run.stdout.contains(written), "{}", run.stdout);

    let radiance = pixels(&folder.bytes("a.npy"));
    assert!(radiance.len() == 1200 && radiance.iter().all(|&voxel| close(voxel, RADIANCE)));
    let expected: f64 = pixels(&folder.bytes("e.npy")).iter().sum();
    assert!(close(expected, expected_total() * 1e20 / EXPOSURE_S), "{expected}");
    let report = folder.json("r.json");
    assert!(report["instrument"]["counts"].is_null());
    assert!(close(number(&report["instrument"]["expected_counts"]), expected));
}

/// A radiance that is finite in the unit of its scene, and in that of an instrument is not.
#[test]
fn counts_that_can_not_be_expected_leave_the_cube() {
    let scene = SCENE.replace("\"2\"", "\"1e300\"").replace("ph cm-3", "ph nm-3");
    let folder = folder(&scene);
    let inputs = ["camera.arf", "camera.rmf", "scene.toml"];
    // No counts are requested.
    folder.emitree("render scene.toml -o a.npy -q").succeeds();
    folder.holds(&[&["a.npy"], &inputs[..]].concat());
    for options in ["--report r.json", "-q --report r.json --counts c.npy --expected-counts e.png"]
    {
        let run = folder.emitree(&format!("render scene.toml -o b.npy {options}"));
        run.fails_with(2);
        let text = "emitree: expected counts: ";
        assert!(run.stderr.contains(text), "no `{text}` in:\n{}", run.stderr);
        folder.holds(&[&["a.npy", "b.npy"], &inputs[..2], &["r.json"], &inputs[2..]].concat());
        assert_eq!(folder.bytes("a.npy"), folder.bytes("b.npy"));
        assert!(folder.json("r.json")["instrument"].is_null());
        for name in ["b.npy", "r.json"] {
            std::fs::remove_file(folder.path(name)).unwrap();
        }
    }
}
