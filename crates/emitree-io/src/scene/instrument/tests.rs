//! Instruments of scenes: what they take, and what is wrong with them.

use super::SceneInstrument;
use crate::scene::{Override, Scene, SceneError};
use emitree::{Cube, EnergyAxis, EnergyScale, Image};
use emitree_instrument::{Background, EffectiveArea, Psf, Redistribution};

const SCENE: &str = r#"[emission]
expression = "1"
unit = "ph cm-3 s-1 sr-1 keV-1"
[image]
width = 4
height = 2
[energy]
min = 0.5
max = 2.5
bins = 4
[projection]
type = "equirectangular"
position = [0, 0, 0]
target = [1, 0, 0]
field_of_view = [2, 1]
far = 1
length_unit = "cm"
[instrument]
"#;

/// The line of the table `[instrument]`, and what a scene needs there.
const TABLE: usize = 18;
const LEAST: &str = "exposure = 100\neffective_area = 50\n";

/// The scene with these lines in `[instrument]`, beside the response files of the instrument crate.
fn parse(scene: &str, lines: &str, overrides: &[Override]) -> Result<Scene, SceneError> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../emitree-instrument/tests/reference");
    Scene::parse(&format!("{folder}/scene.toml"), &format!("{scene}{lines}"), overrides)
}

fn read(lines: &str) -> SceneInstrument {
    parse(SCENE, lines, &[]).unwrap().instrument.unwrap()
}

fn reference(name: &str) -> String {
    format!("{}/../emitree-instrument/tests/reference/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// The error of a scene: its line after the head of the table, message and what was expected, with
/// names of files and not of folders.
fn error(scene: &str, lines: &str) -> (usize, String, String) {
    let error = parse(scene, lines, &[]).unwrap_err();
    let line = error.line().unwrap().1.saturating_sub(TABLE);
    (line, error.message().replace(&reference(""), ""), error.expected().to_owned())
}

fn expect(lines: &str, line: usize, message: &str, expected: &str) {
    assert_eq!(error(SCENE, lines), (line, message.to_owned(), expected.to_owned()), "{lines}");
}

#[test]
#[expect(clippy::float_cmp, reason = "numbers come back as they were written")]
fn the_least_is_an_area_and_an_exposure() {
    let found = read(LEAST);
    assert_eq!((found.instrument.exposure_s, found.seed), (100.0, 0));
    assert_eq!((found.radiance_factor, found.kev_per_unit), (1.0, 1.0));
    let area = found.instrument.area.clone().unwrap();
    assert_eq!([area.mean([0.5, 2.5]), area.mean([1.0, 1.5])], [50.0, 50.0]);
    let rest = &found.instrument;
    assert!(rest.redistribution.is_none() && rest.psf.is_none() && rest.background.is_none());
    assert_eq!((found.channels(4), parse(SCENE, LEAST, &[]).unwrap().height), (4, 2));
    let (head, _) = SCENE.split_once("[instrument]").unwrap();
    assert_eq!(parse(head, "", &[]).unwrap().instrument, None);
}

#[test]
fn all_keys_are_read() {
    let found = read(
        "exposure = 1e4\neffective_area = \"bins.arf\"\nredistribution = \"variable.rmf\"\n\
         psf = { fwhm_pixels = [2, 1.5] }\nbackground = { per_pixel = 2e-6 }\nseed = 7",
    );
    let instrument = found.instrument;
    assert_eq!(instrument.area, Some(EffectiveArea::read_arf(reference("bins.arf")).unwrap()));
    let matrix = Redistribution::read_rmf(reference("variable.rmf")).unwrap();
    assert_eq!(instrument.redistribution, Some(matrix));
    assert_eq!(instrument.psf, Some(Psf::gaussian([2.0, 1.5]).unwrap()));
    assert_eq!(instrument.background, Some(Background::per_pixel(2e-6).unwrap()));
    assert_eq!(found.seed, 7);
    let round = read(&format!("{LEAST}psf.fwhm_pixels = 2")).instrument.psf;
    assert_eq!(round, Some(Psf::gaussian([2.0; 2]).unwrap()));
    let sky = read(&format!("{LEAST}background.per_kev_sr = 50")).instrument.background;
    assert_eq!(sky, Some(Background::per_kev_sr(50.0).unwrap()));
}

#[test]
fn a_table_of_text_is_an_area_and_an_image_is_a_kernel() {
    let folder = tempfile::tempdir().unwrap();
    let [area, kernel] = ["area.txt", "psf.fits"].map(|name| folder.path().join(name));
    std::fs::write(&area, "energy area\n0.2 10\n4.2 30\n").unwrap();
    let pixels = Image::from_pixels(1, 3, vec![1.0, 2.0, 1.0]);
    let file = crate::FitsFile {
        primary: crate::FitsImage::new("PSF", &pixels, None),
        extensions: Vec::new(),
        wcs: None,
        energies: None,
        provenance: Vec::new(),
        history: String::new(),
        date: None,
    };
    std::fs::write(&kernel, file.encode().unwrap()).unwrap();
    let name = folder.path().join("scene.toml").display().to_string();
    let lines = "exposure = 1\neffective_area = \"area.txt\"\npsf.kernel = \"psf.fits\"";
    let scene = Scene::parse(&name, &format!("{SCENE}{lines}"), &[]).unwrap();
    let instrument = scene.instrument.unwrap().instrument;
    assert_eq!(instrument.area, Some(EffectiveArea::read_table(&area).unwrap()));
    assert_eq!(instrument.psf, Some(Psf::from_kernel(&pixels).unwrap()));
}

/// 3600 arcsec are 1°, and the image has 2° in 4 columns and 1° in 2 rows.
#[test]
fn widths_in_arcsec_are_those_of_the_middle_of_the_image() {
    let psf = read(&format!("{LEAST}psf.fwhm_arcsec = 3600")).instrument.psf.unwrap();
    let expected = Psf::gaussian([2.0, 2.0]).unwrap();
    let mut point = Image::zeros(9, 9);
    point[(4, 4)] = 1.0;
    let [found, expected] =
        [psf, expected].map(|psf| psf.blur(Cube::from_bands(vec![point.clone()])).unwrap());
    assert!(found.photons.max_difference(&expected.photons) < 1e-14);
    // A pinhole: 2 tan(fov/2) over the columns.
    let pinhole = SCENE.replace("equirectangular", "perspective").replace("[2, 1]", "[90, 53]");
    let scene = parse(&pinhole, &format!("{LEAST}psf.fwhm_arcsec = 206264.80624709636"), &[]);
    let psf = scene.unwrap().instrument.unwrap().instrument.psf.unwrap();
    let rows = 1.0 / (2.0 * 26.5_f64.to_radians().tan() / 2.0);
    let expected = Psf::gaussian([2.0, rows]).unwrap();
    let [found, expected] =
        [psf, expected].map(|psf| psf.blur(Cube::from_bands(vec![point.clone()])).unwrap());
    assert!(found.photons.max_difference(&expected.photons) < 1e-14);
}

#[test]
fn options_change_the_table() {
    let change = |key: &str, value: &str, option: &str| Override {
        key: key.into(),
        value: value.into(),
        option: option.into(),
    };
    let seed = change("instrument.seed", "5", "seed");
    let scene = parse(SCENE, LEAST, std::slice::from_ref(&seed)).unwrap();
    assert_eq!(scene.instrument.unwrap().seed, 5);
    let (head, _) = SCENE.split_once("[instrument]").unwrap();
    let error = parse(head, "", &[seed]).unwrap_err();
    assert_eq!(error.message(), "the scene has no `[instrument]`");
    assert_eq!(
        error.expected(),
        "expected a table `[instrument]` with `exposure` and `effective_area`"
    );
    assert_eq!(error.line(), Some(("option --seed", 1)));
    // A file of an option is where the command is given.
    let area = change("instrument.effective_area", "bins.arf", "set");
    let error = parse(SCENE, LEAST, &[area]).unwrap_err();
    let text = "`instrument.effective_area`: the response bins.arf: it can't be read: ";
    assert!(error.message().starts_with(text), "{error}");
    let whole = [("exposure", "1"), ("effective_area", "2")]
        .map(|(key, value)| change(&format!("instrument.{key}"), value, "set"));
    assert!(parse(head, "", &whole).unwrap().instrument.is_some());
}

/// The sum of the expected counts of radiance 1 in all voxels.
fn counts_of_one(scene: &str) -> f64 {
    let scene = parse(scene, LEAST, &[]).unwrap();
    let cube = Cube::from_bands(vec![Image::from_pixels(2, 4, vec![1.0; 8]); 4]);
    let observation = scene.expected_counts(&cube).unwrap().unwrap();
    observation.counts.voxels().sum()
}

/// 1 · 2 keV · 50 cm² · 100 s · the solid angle of 2° x 1°; in other units the factor by hand.
#[test]
fn units_are_converted() {
    let solid_angle_sr = 2_f64.to_radians() * 2.0 * 0.5_f64.to_radians().sin();
    let expected = 2.0 * 50.0 * 100.0 * solid_angle_sr;
    let unit = |unit: &str| SCENE.replace("ph cm-3 s-1 sr-1 keV-1", unit);
    let isotropic = 0.25 * core::f64::consts::FRAC_1_PI;
    let with = |key: &str| SCENE.replace("height = 2", &format!("height = 2\n{key}"));
    let of_arcsec2 = (180.0 * 3600.0 / core::f64::consts::PI).powi(2);
    for (scene, factor) in [
        (SCENE.to_owned(), 1.0),
        (unit("cm-3 s-1 sr-1 keV-1"), 1.0),
        (unit("ph m-3 s-1 sr-1 eV-1"), 1e-4 * 1e3),
        (unit("ph cm-3 s-1 keV-1"), isotropic),
        (with("unit = \"ph m-2 h-1 arcsec-2 MeV-1\""), 1e-4 / 3600.0 * of_arcsec2 * 1e-3),
        // The radiance is per steradian of the image's unit.
        (with("quantity = \"irradiance\""), 1.0),
        (with("quantity = \"irradiance\"\nunit = \"ph m-2 s-1 keV-1\""), 1e-4),
    ] {
        let found = counts_of_one(&scene);
        let ratio = found / (factor * expected);
        assert!((ratio - 1.0).abs() < 1e-12, "{ratio}\n{scene}");
    }
    // Energies of 500 to 2500 eV are those of 0.5 to 2.5 keV.
    let ev = SCENE.replace("min = 0.5\nmax = 2.5", "unit = \"eV\"\nmin = 500\nmax = 2500");
    let ratio = counts_of_one(&ev) / expected;
    assert!((ratio - 1.0).abs() < 1e-12, "{ratio}");
    let energies = EnergyAxis::new(500.0, 2500.0, 4, EnergyScale::Linear).unwrap();
    assert_eq!(parse(&ev, LEAST, &[]).unwrap().energy.unwrap().axis(), &energies);
}

#[test]
fn memory_counts_the_copy_of_a_cube_that_is_converted() {
    let shape = [4, 20, 30];
    let plain = read(LEAST);
    let solid_angles = 2 * 8 * 20 * 30;
    assert_eq!(plain.memory_bytes(shape), plain.instrument.memory_bytes(shape) + solid_angles);
    let other = SCENE.replace("ph cm-3 s-1 sr-1 keV-1", "ph m-3 s-1 sr-1 keV-1");
    let converted = parse(&other, LEAST, &[]).unwrap().instrument.unwrap();
    let copy = converted.memory_bytes(shape) - plain.memory_bytes(shape);
    assert_eq!(copy, 8 * 4 * 20 * 30);
}

#[test]
fn scenes_that_no_instrument_can_see_are_refused() {
    let refused = |scene: &str, message: &str, expected: &str| {
        assert_eq!(error(scene, LEAST), (0, message.to_owned(), expected.to_owned()));
    };
    let (before, after) = SCENE.split_once("[energy]").unwrap();
    let (_, after) = after.split_once("[projection]").unwrap();
    let flat = format!("{before}[projection]{after}").replace(" keV-1", "");
    refused(
        &flat,
        "`[instrument]` counts photons by their energy, and the scene has no `[energy]`",
        "expected a table `[energy]` too, with `min`, `max` and `bins`",
    );
    refused(
        &SCENE.replace("unit = \"ph cm-3 s-1 sr-1 keV-1\"\n", "\n"),
        "`[instrument]` needs a radiance with a unit, and the image has none",
        "expected `emission.unit` and `projection.length_unit` that make it ph cm-2 s-1 sr-1 keV-1",
    );
    refused(
        &SCENE.replace("ph cm-3", "keV cm-3"),
        "`[instrument]`: no conversion from `cm-2 s-1 sr-1` (length^-2 time^-1 angle^-2) to \
         `ph cm-2 s-1 sr-1 keV-1` (length^-4 mass^-1 time angle^-2 photon): expected units of the \
         same dimension; those of `to` may also be per solid angle, or of photons, where the others \
         are not",
        "expected an image in ph cm-2 s-1 sr-1 keV-1 or a unit that converts to it, and not \
         \"cm-2 s-1 sr-1\"",
    );
    refused(
        &SCENE.replace("min = 0.5", "min = -0.5"),
        "`[instrument]` counts photons, and `[energy]` starts at -0.5 keV",
        "expected energies of 0 or more",
    );
    let parallel = SCENE.replace("equirectangular", "orthographic");
    refused(
        &parallel.replace("field_of_view = [2, 1]", "extent = [2, 1]"),
        "`[instrument]` needs pixels with solid angles",
        "expected a camera with a point observer: parallel lines of sight have none",
    );
}

#[test]
fn wrong_values_are_marked() {
    let area = "expected an area in cm2, or the name of a file: an ARF (.arf, .fits) or a table of \
                energies and areas";
    let is = |key: &str, value: &str, said: &str, expected: &str| {
        let lines = match key {
            "exposure" => format!("effective_area = 50\n{key} = {value}"),
            "effective_area" => format!("exposure = 1\n{key} = {value}"),
            _ => format!("{LEAST}{key} = {value}"),
        };
        let line = lines.lines().count();
        expect(&lines, line, &format!("`instrument.{key}` is {said}"), expected);
    };
    let exposure = "expected the exposure in s, above 0";
    is("exposure", "0", "0", exposure);
    is("exposure", "-1.5", "-1.5", exposure);
    is("exposure", "inf", "inf", "expected a finite number");
    is("exposure", "\"1 ks\"", "a string", "expected a number");
    is("effective_area", "0", "0", area);
    is("effective_area", "[1, 2]", "an array", area);
    is("redistribution", "3", "an integer", "expected a string");
    let seed = "expected a whole number, 0 or more";
    is("seed", "-1", "-1", seed);
    is("seed", "1.5", "a number", seed);
    is("psf", "2", "an integer", "expected a table");
    is("background", "2", "an integer", "expected a table");
    let width = "expected a full width at half maximum in arcsec, 0 or more";
    is("psf.fwhm_arcsec", "-3", "-3", width);
    let pixels = "expected a full width at half maximum in pixels, or two [x, y]";
    is("psf.fwhm_pixels", "[1, 2, 3]", "an array of 3", pixels);
    is("psf.fwhm_pixels", "\"2\"", "a string", "expected a number");
    is("psf.kernel", "2", "an integer", "expected a string");
    is("background.per_pixel", "\"2\"", "a string", "expected a number");
}

#[test]
fn missing_and_unknown_keys_are_named() {
    expect(
        "effective_area = 50",
        0,
        "`instrument.exposure` is missing",
        "expected `exposure` here: the exposure in s, above 0",
    );
    expect(
        "exposure = 50",
        0,
        "`instrument.effective_area` is missing",
        "expected `effective_area` here: an area in cm2, or the name of a file: an ARF (.arf, .fits) \
         or a table of energies and areas",
    );
    let keys = "expected one of `exposure`, `effective_area`, `redistribution`, `psf`, `background`, \
                `seed`";
    expect(&format!("{LEAST}gain = 2"), 3, "unknown key `instrument.gain`", keys);
    let slip = "did you mean `effective_area`?";
    expect("exposure = 1\neffectve_area = 2", 2, "unknown key `instrument.effectve_area`", slip);
    let kinds = "expected one of `fwhm_pixels`, `fwhm_arcsec`, `kernel`";
    expect(&format!("{LEAST}psf = {{}}"), 3, "`instrument.psf` is empty", kinds);
    let both = "`instrument.psf` has both `fwhm_pixels` and `kernel`";
    expect(&format!("{LEAST}psf = {{ kernel = \"a\", fwhm_pixels = 1 }}"), 3, both, kinds);
    let unknown = "unknown key `instrument.psf.sigma`";
    expect(&format!("{LEAST}psf.sigma = 1"), 3, unknown, kinds);
    let rates = "expected one of `per_pixel`, `per_kev_sr`";
    expect(&format!("{LEAST}background = {{}}"), 3, "`instrument.background` is empty", rates);
}

#[test]
fn parts_that_can_not_be_say_why() {
    let reason = |lines: &str, message: &str| {
        let (line, found, _) = error(SCENE, lines);
        assert!(found.starts_with(message), "{found}");
        assert_eq!(line, lines.lines().count(), "{lines}");
    };
    let unread = "it can't be read: ";
    reason(
        "exposure = 1\neffective_area = \"no.arf\"",
        &format!("`instrument.effective_area`: the response no.arf: {unread}"),
    );
    reason(
        "exposure = 1\neffective_area = \"no.txt\"",
        &format!("`instrument.effective_area`: the effective area no.txt: {unread}"),
    );
    reason(
        "exposure = 1\neffective_area = \"observation.csv\"",
        "`instrument.effective_area`: the effective area observation.csv: line ",
    );
    reason(
        &format!("{LEAST}redistribution = \"bins.arf\""),
        "`instrument.redistribution`: the response bins.arf: it has no extension with ",
    );
    reason(
        &format!("{LEAST}psf.kernel = \"no.fits\""),
        &format!("`instrument.psf.kernel`: the point-spread function no.fits: {unread}"),
    );
    reason(
        &format!("{LEAST}psf.fwhm_pixels = -1"),
        "`instrument.psf.fwhm_pixels`: the full width at half maximum along x is -1 pixels: expected",
    );
    reason(
        &format!("{LEAST}background.per_kev_sr = -1"),
        "`instrument.background.per_kev_sr`: the background is -1 counts s-1 keV-1 sr-1: expected a \
         finite number, 0 or more",
    );
}

#[test]
fn an_area_is_there_once() {
    let full = read("exposure = 1\nredistribution = \"fixed.rsp\"").instrument;
    assert!(full.area.is_none() && full.redistribution.is_some());
    expect(
        "exposure = 1\nredistribution = \"fixed.rsp\"\neffective_area = 5",
        3,
        "`instrument.effective_area` is there twice",
        "expected none: `redistribution` includes it",
    );
    let (line, message, _) = error(SCENE, "exposure = 1\nredistribution = \"variable.rmf\"");
    assert_eq!((line, &*message), (0, "`instrument.effective_area` is missing"));
}

#[test]
fn views_that_are_no_plane_have_no_point_spread_function() {
    let lines = format!("{LEAST}psf.fwhm_pixels = 1");
    let expected = "expected none: the pixels of `healpix` and `polar` are on no plane";
    let polar = SCENE.replace("equirectangular", "polar").replace("[2, 1]", "20");
    let sky = SCENE
        .replace("equirectangular", "healpix")
        .replace("width = 4\nheight = 2", "nside = 4\n")
        .replace("target = [1, 0, 0]\nfield_of_view = [2, 1]\n", "\n\n");
    for scene in [polar, sky] {
        let message = "`instrument.psf` has no meaning for this camera";
        assert_eq!(error(&scene, &lines), (3, message.to_owned(), expected.to_owned()));
        assert!(parse(&scene, LEAST, &[]).is_ok());
    }
}
