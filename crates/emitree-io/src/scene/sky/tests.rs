//! Tables `[sky]`: the numbers of files, and what does not fit together.

use crate::fits::{FitsFile, FitsImage, HealpixColumn, HealpixFile};
use crate::scene::{Scene, SceneError};
use crate::sky::SkyCoordinates;
use emitree::Image;
use fits_well::FitsReader;
use fits_well::header::{Header, Value};

const PERSPECTIVE: &str = "type = \"perspective\"\nposition = [-10, 0, 0]\ntarget = [0, 0, 0]\n\
                           field_of_view = [20, 10]\nfar = 20\nlength_unit = \"R_sun\"";
const HEALPIX: &str = "type = \"healpix\"\nposition = [-10, 0, 0]\nfar = 20";
/// At 60 degrees of longitude and 30 of latitude, 2 solar radii away.
const ABOVE_THE_SUN: &str = "type = \"perspective\"\n\
    position = [0.8660254037844388, 1.5, 1.0]\ntarget = [0, 0, 0]\n\
    field_of_view = [60, 60]\nfar = 20\nlength_unit = \"R_sun\"";

fn scene(projection: &str, sky: &str) -> Result<Scene, SceneError> {
    let image = if projection.contains("healpix") { "nside = 4" } else { "width = 4, height = 2" };
    let text = format!(
        "emission.expression = \"x\"\nimage = {{ {image} }}\n[sky]\n{sky}\n[projection]\n{projection}"
    );
    Scene::parse("scene.toml", &text, &[])
}

/// Line of the table, message and expectation of an error.
fn error(projection: &str, sky: &str) -> (usize, String, String) {
    let error = scene(projection, sky).unwrap_err();
    let (_, line) = error.line().unwrap();
    (line - 3, error.message().to_owned(), error.expected().to_owned())
}

fn header(projection: &str, sky: &str) -> Header {
    let scene = scene(projection, sky).unwrap();
    let image = Image::zeros(scene.height, scene.width);
    let file = FitsFile {
        primary: FitsImage::new("RADIANCE", &image, None),
        extensions: Vec::new(),
        wcs: scene.celestial_wcs(),
        energies: None,
        provenance: Vec::new(),
        history: String::new(),
        date: None,
    };
    let reader = FitsReader::open(std::io::Cursor::new(file.encode().unwrap())).unwrap();
    reader.hdus()[0].header.clone()
}

fn real(header: &Header, key: &str) -> f64 {
    match header.get(key).unwrap() {
        Some(Value::Real(real)) => *real,
        other => panic!("{key}: {other:?}"),
    }
}

fn text<'a>(header: &'a Header, key: &str) -> Option<&'a str> {
    header.get_text(key).unwrap()
}

#[test]
fn axes_of_the_model_that_are_those_of_the_sky_need_no_numbers() {
    let header = header(PERSPECTIVE, "frame = \"ICRS\"\ndate = 2024-04-08T18:00:00Z");
    assert_eq!(text(&header, "CTYPE1"), Some("RA---TAN"));
    assert_eq!(text(&header, "CTYPE2"), Some("DEC--TAN"));
    assert_eq!(text(&header, "WCSNAME"), Some("ICRS"));
    assert_eq!(text(&header, "RADESYS"), Some("ICRS"));
    assert_eq!(text(&header, "DATE-OBS"), Some("2024-04-08T18:00:00"));
    assert_eq!(text(&header, "CNAME1"), None);
    // Along x: right ascension and declination 0, north up, east to the left.
    let wcs = scene(PERSPECTIVE, "frame = \"ICRS\"").unwrap().wcs().unwrap();
    for (key, expected) in [
        ("CRVAL1", 0.0),
        ("CRVAL2", 0.0),
        ("CDELT1", -wcs.axes[0].cdelt),
        ("CDELT2", wcs.axes[1].cdelt),
        ("PC1_1", 1.0),
        ("PC1_2", 0.0),
        ("PC2_1", 0.0),
        ("PC2_2", 1.0),
        ("LONPOLE", 180.0),
        ("MJD-OBS", 60_408.75),
    ] {
        assert_eq!(real(&header, key).to_bits(), f64::to_bits(expected), "{key}");
    }
    assert!(!header.contains("LATPOLE").unwrap() && !header.contains("HGLN_OBS").unwrap());
}

#[test]
fn helioprojective_coordinates_follow_from_a_position_in_the_frame_of_stonyhurst() {
    let sky = "frame = \"HeliographicStonyhurst\"\ndate = \"2024-04-08\"";
    let found = header(ABOVE_THE_SUN, sky);
    assert_eq!(text(&found, "CTYPE1"), Some("HPLN-TAN"));
    assert_eq!(text(&found, "DATE-OBS"), Some("2024-04-08"));
    for (key, expected, allowed) in [
        ("CRVAL1", 0.0, 1e-13),
        ("CRVAL2", 0.0, 1e-13),
        ("PC1_1", 1.0, 1e-14),
        ("PC1_2", 0.0, 1e-14),
        ("HGLN_OBS", 60.0, 1e-12),
        ("HGLT_OBS", 30.0, 1e-12),
        ("DSUN_OBS", 2.0 * 6.957e8, 1e-5),
        ("RSUN_REF", 6.957e8, 0.0),
    ] {
        assert!((real(&found, key) - expected).abs() <= allowed, "{key}: {}", real(&found, key));
    }
    // West is to the right.
    assert!(real(&found, "CDELT1") > 0.0);
    // An observer at that place, and another radius of the Sun, are copied.
    let given = "observer = { longitude = 60, latitude = 30, distance = 2 }\nsun_radius = 1.01";
    let found = header(ABOVE_THE_SUN, &format!("{sky}\n{given}"));
    assert_eq!(real(&found, "HGLN_OBS").to_bits(), 60_f64.to_bits());
    assert_eq!(real(&found, "RSUN_REF").to_bits(), (1.01 * 6.957e8_f64).to_bits());
}

#[test]
fn axes_are_numbers_that_are_copied_and_made_orthonormal() {
    // The galactic axes of J2000, with six digits: columns of Murray's matrix.
    let sky = "frame = \"Galactic\"\ncoordinates = \"ICRS\"\n\
               axes = [[-0.054876, -0.873437, -0.483835], [0.494109, -0.444830, 0.746982], \
               [-0.867666, -0.198076, 0.455984]]";
    let found = header(PERSPECTIVE, sky);
    // The galactic centre is at the right ascension 266.405 and the declination -28.936.
    assert!((real(&found, "CRVAL1") - 266.405).abs() < 1e-3, "{}", real(&found, "CRVAL1"));
    assert!((real(&found, "CRVAL2") + 28.936).abs() < 1e-3);
    let axes = scene(PERSPECTIVE, sky).unwrap().sky.unwrap().axes;
    for (i, a) in axes.iter().enumerate() {
        for (j, b) in axes.iter().enumerate() {
            let product: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
            assert!((product - if i == j { 1.0 } else { 0.0 }).abs() < 1e-15);
        }
    }
}

#[test]
fn equinoxes_and_coordinates_have_defaults() {
    let of = |sky: &str| scene(PERSPECTIVE, sky).unwrap().sky.unwrap();
    assert_eq!(of("frame = \"FK5\"").equinox, Some(2000.0));
    assert_eq!(of("frame = \"FK5\"\nequinox = 1975").equinox, Some(1975.0));
    assert_eq!(of("frame = \"Galactic\"").equinox, None);
    let identity = "axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]";
    let found = of(&format!("frame = \"my own\"\n{identity}"));
    assert_eq!((found.frame.as_str(), found.coordinates), ("my own", SkyCoordinates::Icrs));
    let found = header(PERSPECTIVE, "frame = \"BarycentricMeanEcliptic\"");
    assert_eq!(text(&found, "CTYPE1"), Some("ELON-TAN"));
    assert_eq!(real(&found, "EQUINOX").to_bits(), 2000_f64.to_bits());
}

#[test]
fn a_healpix_map_names_its_system() {
    for (frame, letter) in [("ICRS", "C"), ("Galactic", "G"), ("BarycentricMeanEcliptic", "E")] {
        let scene = scene(HEALPIX, &format!("frame = \"{frame}\"")).unwrap();
        assert_eq!(scene.sky.as_ref().unwrap().healpix_system(), Some(letter));
        let values = [0.0; 12];
        let column = HealpixColumn { name: "RADIANCE", unit: None, values: &values };
        let file = HealpixFile {
            columns: vec![column],
            coordinates: scene.sky.unwrap().healpix_system(),
            energies: None,
            provenance: Vec::new(),
            history: String::new(),
            date: None,
        };
        let reader = FitsReader::open(std::io::Cursor::new(file.encode().unwrap())).unwrap();
        let header = &reader.hdus()[1].header;
        assert_eq!(text(header, "COORDSYS"), Some(letter));
        assert_eq!(text(header, "RADESYS"), (letter == "C").then_some("ICRS"));
    }
    let message = "a HEALPix map has the axes of the model, for which there is no COORDSYS";
    let expected = "expected the frame ICRS, Galactic or BarycentricMeanEcliptic, without `axes`";
    let is = |sky: &str, line| {
        assert_eq!(error(HEALPIX, sky), (line, message.to_owned(), expected.to_owned()), "{sky}");
    };
    is("frame = \"FK5\"", 1);
    is("frame = \"ICRS\"\naxes = [[0, 1, 0], [0, 0, 1], [1, 0, 0]]", 1);
}

#[test]
fn what_does_not_fit_is_refused_where_it_stands() {
    let icrs = "frame = \"ICRS\"";
    let sun = "frame = \"HeliographicStonyhurst\"\ndate = \"2024-04-08\"";
    let is = |projection: &str, sky: &str, line: usize, message: &str, expected: &str| {
        let found = error(projection, sky);
        assert_eq!(found, (line, message.to_owned(), expected.to_owned()), "{sky}");
    };
    let here = |sky: &str, line, message: &str, expected: &str| {
        is(PERSPECTIVE, sky, line, message, expected);
    };
    here(
        "",
        0,
        "`sky.frame` is missing",
        "expected `frame` here: the name of the frame whose axes are those of the model, such as \"ICRS\"",
    );
    here(
        &format!("{icrs}\nepoch = 2000"),
        2,
        "unknown key `sky.epoch`",
        "expected one of `frame`, `coordinates`, `axes`, `equinox`, `date`, `observer`, `sun_radius`",
    );
    here(
        &format!("{icrs}\ncoordinates = \"Galactik\""),
        2,
        "unknown coordinates `Galactik`",
        "expected `ICRS`, `FK5`, `Galactic`, `BarycentricMeanEcliptic` or `Helioprojective`",
    );
    let date = "expected a date and time in UTC, such as \"2024-04-08T18:00:00\"";
    here(&format!("{icrs}\ndate = \"8 April\""), 2, "`sky.date` is `8 April`", date);
    here(&format!("{icrs}\ndate = 2024"), 2, "`sky.date` is an integer", date);
    here(
        &format!("{icrs}\ndate = 2024-04-08T18:00:00+02:00"),
        2,
        "`sky.date` is `2024-04-08T18:00:00+02:00`",
        date,
    );
    here(
        &format!("{icrs}\nequinox = 2000"),
        2,
        "ICRS have no equinox",
        "expected none, or `coordinates` FK5 or BarycentricMeanEcliptic",
    );
    here(
        &format!("{icrs}\nobserver = {{ longitude = 0, latitude = 0, distance = 1 }}"),
        2,
        "ICRS have no observer",
        "expected none, or `coordinates` Helioprojective",
    );
    let axes = "expected three directions [x, y, z] in `coordinates`, those of the model's x, y and z, \
                at right angles to each other";
    here(
        &format!("{icrs}\naxes = [[1, 0, 0], [0, 1, 0], [0, 0, 1.1]]"),
        2,
        "`sky.axes` are off by 2.10e-1 from unit vectors at right angles",
        axes,
    );
    here(&format!("{icrs}\naxes = [1, 0, 0]"), 2, "`sky.axes[0]` is an integer", axes);
    here(
        &format!("{icrs}\naxes = [[-1, 0, 0], [0, 1, 0], [0, 0, 1]]"),
        2,
        "`sky.axes` are left-handed in ICRS coordinates",
        "expected right-handed ones, so that the axes of the model are right-handed in space",
    );
    here(
        "frame = \"HeliographicCarrington\"",
        1,
        "`sky.axes` is missing",
        &axes.replacen("expected", "expected `axes`:", 1),
    );
    here(
        "frame = \"Helioprojective\"",
        1,
        "`sky.axes` is missing",
        &axes.replacen("expected", "expected `axes`:", 1),
    );
    let observer = "expected `observer` here: a table { longitude, latitude, distance }: \
                    Stonyhurst's, in degrees, and a length in `length_unit`";
    here(
        "frame = \"HeliographicCarrington\"\naxes = [[-1, 0, 0], [0, 1, 0], [0, 0, 1]]",
        0,
        "`sky.observer` is missing",
        observer,
    );
    here(
        "frame = \"HeliographicStonyhurst\"",
        0,
        "`sky.date` is missing",
        &date.replacen("expected", "expected `date` here:", 1),
    );
    here(
        &format!("{sun}\nobserver = {{ longitude = 0, latitude = 0, distance = 10 }}"),
        3,
        "the observer is 1.391e10 m from `position` of the camera, [-10.0, 0.0, 0.0]",
        "expected one place, or no `observer`",
    );
    here(
        &format!("{sun}\nobserver = {{ longitude = 0, latitude = 91, distance = 10 }}"),
        3,
        "`sky.observer.latitude` is 91",
        "expected a latitude in degrees, -90 to 90",
    );
    here(
        &format!("{sun}\nsun_radius = 11"),
        3,
        "the observer is 6.957000e9 m from the centre of the Sun, whose radius is 7.652700e9 m",
        "expected an observer outside of the Sun",
    );
    is(
        "type = \"perspective\"\nposition = [0, 0, 5]\ntarget = [0, 1, 0]\nfield_of_view = [9, 9]\n\
         far = 20\nlength_unit = \"R_sun\"",
        sun,
        0,
        "`position` is [0.0, 0.0, 5.0]: helioprojective coordinates have no north there",
        "expected an observer outside of the Sun and not above a pole, or `axes`",
    );
    is(
        &PERSPECTIVE.replace("\nlength_unit = \"R_sun\"", ""),
        sun,
        0,
        "the scene has no `length_unit`",
        "expected `length_unit` in `[projection]`, such as \"R_sun\"",
    );
    for (camera, keys) in [("polar", "field_of_view = 20"), ("orthographic", "extent = [2, 2]")] {
        is(
            &format!(
                "type = \"{camera}\"\nposition = [9, 0, 0]\ntarget = [0, 0, 0]\n{keys}\nfar = 9"
            ),
            icrs,
            0,
            &format!("the camera `{camera}` has no celestial projection"),
            "expected `perspective`, `equirectangular`, `fisheye` or `healpix`",
        );
    }
}
