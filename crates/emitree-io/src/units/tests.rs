use super::*;
use proptest::prelude::*;

fn unit(text: &str) -> Unit {
    Unit::parse(text).unwrap()
}

fn factor(from: &str, to: &str) -> f64 {
    unit(from).factor_to(&unit(to)).unwrap()
}

fn message(text: &str) -> String {
    Unit::parse(text).map_or_else(|error| error.to_string(), |unit| format!("parsed as {unit}"))
}

/// astropy 8.0.2: `(1 * Unit(from, format="fits")).to(Unit(to, format="fits"))`.
const ASTROPY: [(&str, &str, f64); 29] = [
    ("AU", "km", 149597870.7),
    ("pc", "AU", 206264.80624709636),
    ("kpc", "m", 3.085677581491367e+19),
    ("Mpc", "lyr", 3261563.7771674334),
    ("lyr", "m", 9460730472580800.0),
    ("solRad", "km", 695700.0),
    ("Angstrom", "nm", 0.1),
    ("um", "cm", 9.999999999999999e-05),
    ("d", "h", 24.0),
    ("yr", "s", 31557600.0),
    ("Gyr", "Myr", 1000.0),
    ("min-1", "Hz", 0.016666666666666666),
    ("keV", "J", 1.602176634e-16),
    ("eV", "erg", 1.6021766339999997e-12),
    ("MeV cm-2 s-1 sr-1", "erg m-2 h-1 deg-2", 0.017569832842498814),
    ("erg cm-2 s-1 arcsec-2", "W m-2 sr-1", 42545170.2961522),
    ("Jy/sr", "W m-2 Hz-1 arcmin-2", 8.461594994075238e-34),
    ("mas2", "sr", 2.350443053909789e-17),
    ("R", "ph cm-2 s-1 sr-1", 79577.47154594767),
    ("kR", "ph m-2 s-1 arcsec-2", 18.704231524287653),
    ("10**6 ph cm-2 s-1", "ph km-2 d-1", 8.64e+20),
    ("ct/cm2/s", "count m-2 min-1", 600000.0),
    ("kg m2 s-2", "keV", 6241509074460763.0),
    ("daJ", "hJ", 0.1),
    ("W h", "MeV", 2.2469432668058748e+16),
    ("deg", "rad", 0.017453292519943295),
    ("MJy sr-1", "mJy arcsec-2", 0.023504430539097884),
    ("m-3", "pc-3", 2.937998946096347e+49),
    ("aJ", "eV", 6.2415090744607635),
];

#[test]
fn factors_are_those_of_astropy() {
    for (from, to, expected) in ASTROPY {
        let found = factor(from, to);
        assert!((found / expected - 1.0).abs() < 2e-15, "{from} to {to}: {found}, {expected}");
    }
}

#[test]
#[expect(clippy::float_cmp, reason = "exact to the last bit")]
fn decimal_factors_are_exact() {
    for (from, to, expected) in [
        ("R_E", "cm", 6.371e8),
        ("R_E_eq", "km", 6378.1),
        ("R_earth", "m", 6.371e6),
        ("R_sun", "km", 695_700.0),
        ("R_jup", "R_E", 71_492.0 / 6371.0),
        ("R_mars", "km", 3389.5),
        ("cm-3 s-1", "m-3 s-1", 1e6),
        ("10**6 ph", "ph", 1e6),
        ("2.5 km", "m", 2500.0),
        ("1", "", 1.0),
        ("h", "min", 60.0),
        ("AU", "m", 149_597_870_700.0),
        ("ly", "m", 9_460_730_472_580_800.0),
        ("Yg", "yg", 1e48),
        ("GeV2 cm-5", "TeV2 m-5", 1e4),
        ("GeV cm-2 sr-1", "MeV m-2 sr-1", 1e7),
    ] {
        assert_eq!(factor(from, to), expected, "{from} to {to}");
    }
}

#[test]
fn all_ways_to_write_a_product_are_read() {
    let same = [
        "ph cm-2 s-1 sr-1",
        "ph/(cm2 s sr)",
        "ph/cm2/s/sr",
        " ph  cm**-2 * s^-1 . sr**(-1) ",
        "photon·cm(-2)·s^(-1)(sr)-1",
        "ph (cm2 s sr)**-1",
        "ph ((cm)(cm) s sr)^-1",
    ];
    for text in same {
        assert_eq!(unit(text), unit(same[0]), "{text}");
    }
    assert_eq!(unit("1/(cm2 s)"), unit("cm-2 s-1"));
    assert_eq!(unit("µm"), unit("um"));
    assert_eq!(unit("μm"), unit("um"));
    assert_eq!(unit("cm2(s sr)"), unit("cm2 s sr"));
    assert_eq!(unit("10+3 m"), unit("10**3 m"));
    assert_eq!(unit("1000 m"), unit("10^3 m"));
    assert_eq!(unit("m m-1"), Unit::one());
    assert_eq!(unit("m0"), Unit::one());
    assert_eq!(unit("  "), Unit::one());
}

#[test]
fn names_are_not_mistaken_for_prefixes() {
    // min, cd, Pa and the like: a whole name first, prefixes only where they are in use.
    for (text, expected) in [
        ("min", Dimension::TIME),
        ("mas", Dimension::ANGLE),
        ("pc", Dimension::LENGTH),
        ("ph", Dimension::PHOTON),
        ("ct", Dimension::COUNT),
        ("das", Dimension::TIME),
        ("mm", Dimension::LENGTH),
        ("as", Dimension::TIME),
    ] {
        assert_eq!(unit(text).dimension(), expected, "{text}");
    }
    for text in ["kAU", "cd", "Pa", "kR_E", "kerg", "mmin", "kkm", "k", "µ"] {
        assert!(message(text).contains("unknown name"), "{text}: {}", message(text));
    }
}

#[test]
fn errors_name_the_place_and_what_was_expected() {
    for (text, expected) in [
        ("kev cm-2", "unit `kev cm-2`: unknown name `kev` at character 1: did you mean `keV`?"),
        (
            "cm-3 photons",
            "unit `cm-3 photons`: unknown name `photons` at character 6: did you mean `ph`?",
        ),
        ("R_erth", "unit `R_erth`: unknown name `R_erth` at character 1: did you mean `R_earth`?"),
        (
            "m-2 furlong",
            "unit `m-2 furlong`: unknown name `furlong` at character 5: expected a unit such as \
             cm, R_E, s, sr, ph, keV or R",
        ),
        (
            "é",
            "unit `é`: unknown name `é` at character 1: expected a unit such as cm, R_E, s, sr, ph, keV or R",
        ),
        ("cm -2", "unit `cm -2`: `-` at character 4: expected a space, `*`, `/` or the end"),
        ("cm2s", "unit `cm2s`: `s` at character 4: expected a space, `*`, `/` or the end"),
        ("cm-", "unit `cm-`: the end at character 4: expected a whole power from -99 to 99"),
        (
            "cm-2.5 s",
            "unit `cm-2.5 s`: a power that is out of range or not whole at character 3: expected a \
             whole power from -99 to 99",
        ),
        ("m(1/2)", "unit `m(1/2)`: `/` at character 4: expected `)` after a whole power"),
        (
            "m100",
            "unit `m100`: a power that is out of range or not whole at character 2: expected a \
             whole power from -99 to 99",
        ),
        (
            "m-99999999999",
            "unit `m-99999999999`: the power -99999999999 at character 2: expected a whole power \
             from -99 to 99",
        ),
        ("ph/(cm2 s", "unit `ph/(cm2 s`: the end at character 10: expected `)`"),
        ("ph cm2)", "unit `ph cm2)`: `)` at character 7: expected a `(` before it"),
        ("ph/", "unit `ph/`: the end at character 4: expected a unit"),
        ("ph // s", "unit `ph // s`: `/` at character 5: expected a unit"),
        ("0 m", "unit `0 m`: the number 0 at character 1: expected a positive, finite number"),
        (
            "1e999 m",
            "unit `1e999 m`: the number 1e999 at character 1: expected a positive, finite number",
        ),
        ("m 10", "unit `m 10`: `1` at character 3: expected a space, `*`, `/` or the end"),
        (
            "m/s sr",
            "unit `m/s sr`: a product after a quotient at character 5: expected parentheses: \
             a/(b c), or powers: a b-1 c",
        ),
    ] {
        assert_eq!(message(text), expected);
    }
    let deep = "(".repeat(100_000);
    assert!(message(&deep).ends_with("`(` at character 17: expected at most 16 open parentheses"));
}

#[test]
fn units_of_different_kinds_are_not_converted() {
    for (from, to) in [("m", "s"), ("ph", "1"), ("ct", "ph"), ("sr", "rad"), ("cm-2", "cm-2 sr-1")]
    {
        let error = unit(from).factor_to(&unit(to)).unwrap_err();
        assert!(matches!(error, UnitError::Incompatible { .. }), "{from} to {to}: {error}");
    }
    let error = unit("Ym99").factor_to(&unit("ym99")).unwrap_err().to_string();
    assert_eq!(error, "the factor from `Ym99` to `ym99` is inf: expected one from 1e-300 to 1e300");
}

#[test]
fn an_image_has_the_unit_of_the_rate_times_a_length() {
    for (rate, length, expected, expected_factor) in [
        ("cm-3 s-1 sr-1", "R_E", "cm-2 s-1 sr-1", 6.371e8),
        ("eV cm-3 s-1", "R_E", "eV cm-2 s-1", 6.371e8),
        ("keV/(cm3 s sr)", "AU", "keV cm-2 s-1 sr-1", 1.495_978_707e13),
        ("ph m-3 s-1", "km", "ph m-2 s-1", 1000.0),
        ("cm-3", "R_sun", "cm-2", 6.957e10),
        ("R / km", "R_E", "R", 6371.0),
        ("m-1", "m", "1", 1.0),
        ("1", "pc", "pc", 1.0),
        ("1", "R_E", "km", 6371.0),
        ("erg s-1 Angstrom-1 cm-3", "cm", "erg s-1 Angstrom-1 cm-2", 1.0),
        ("R_E-3 s-1", "R_E", "km-2 s-1", 1.0 / (6371.0 * 6371.0)),
        ("2.5 cm-3", "m", "cm-2", 250.0),
    ] {
        let (image, factor) = image_unit(&unit(rate), &unit(length)).unwrap();
        assert_eq!(image.to_string(), expected, "{rate} over {length}");
        assert!((factor / expected_factor - 1.0).abs() < 1e-15, "{rate} over {length}: {factor}");
    }
    assert_eq!(
        image_unit(&unit("cm-3"), &unit("h")).unwrap_err().to_string(),
        "unit `h` is of time: expected a length"
    );
}

#[test]
fn isotropic_emission_and_numbers_of_photons() {
    const PER_SPHERE: f64 = 0.25 * core::f64::consts::FRAC_1_PI;
    let factor = |from: &str, to: &str| unit(from).factor_to_image(&unit(to));
    for (from, to, expected) in [
        ("ph cm-2 s-1", "R", 1e-6),
        ("cm-2 s-1", "kR", 1e-9),
        ("ph cm-2 s-1 sr-1", "R", 4e-6 * core::f64::consts::PI),
        ("cm-2 s-1 sr-1", "ph cm-2 s-1 sr-1", 1.0),
        ("eV cm-2 s-1", "keV cm-2 s-1 sr-1", PER_SPHERE * 1e-3),
        ("erg m-2 s-1", "W m-2 arcsec-2", PER_SPHERE * 1e-7 * factor_of_arcsec2()),
        ("R", "kR", 1e-3),
    ] {
        let found = factor(from, to).unwrap();
        assert!((found / expected - 1.0).abs() < 1e-15, "{from} to {to}: {found}");
    }
    for (from, to) in [
        ("cm-2 s-1 sr-1", "cm-2 s-1"),
        ("ph cm-2 s-1", "cm-2 s-1"),
        ("ct cm-2 s-1", "R"),
        ("cm-3 s-1", "R"),
        ("eV cm-2 s-1", "ph cm-2 s-1"),
    ] {
        let error = factor(from, to).unwrap_err();
        assert!(matches!(error, UnitError::Incompatible { .. }), "{from} to {to}: {error}");
    }
}

/// arcsec² in steradians.
fn factor_of_arcsec2() -> f64 {
    (core::f64::consts::PI / 648_000.0).powi(2)
}

#[test]
fn photons_and_energies() {
    // Lyman alpha, 10.2 eV, and an X-ray of 0.5 keV.
    let energy_j = |text: &str| factor(text, "J");
    let converted = |from: &str, to: &str, photon: &str| {
        unit(from).factor_with_photon_energy(&unit(to), energy_j(photon))
    };
    for (from, to, photon, expected) in [
        ("ph cm-2 s-1 sr-1", "keV cm-2 s-1 sr-1", "500 eV", 0.5),
        ("cm-2 s-1 sr-1", "keV cm-2 s-1 sr-1", "500 eV", 0.5),
        ("keV cm-2 s-1 sr-1", "ph cm-2 s-1 sr-1", "500 eV", 2.0),
        ("eV cm-2 s-1", "R", "10.2 eV", 1e-6 / 10.2),
        (
            "R",
            "erg cm-2 s-1 sr-1",
            "10.2 eV",
            10.2 * 1.602_176_634e-12 * 1e6 / (4.0 * core::f64::consts::PI),
        ),
        ("keV", "eV", "1 keV", 1000.0),
        ("cm-2", "ph cm-2 sr-1", "1 keV", 0.25 * core::f64::consts::FRAC_1_PI),
    ] {
        let found = converted(from, to, photon).unwrap();
        assert!((found / expected - 1.0).abs() < 4e-15, "{from} to {to}: {found}, {expected}");
    }
    let error = converted("ct", "keV", "1 keV").unwrap_err();
    assert!(matches!(error, UnitError::Incompatible { .. }), "{error}");
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = unit("ph").factor_with_photon_energy(&unit("J"), wrong).unwrap_err();
        assert!(matches!(error, UnitError::PhotonEnergy(_)), "{error}");
    }
}

#[test]
fn fits_gets_only_units_that_it_allows() {
    for (text, expected, expected_factor) in [
        ("cm-2 s-1 sr-1", Some("cm-2 s-1 sr-1"), 1.0),
        ("10**6 ph", Some("10**6 ph"), 1.0),
        ("0.001 m", Some("10**-3 m"), 1.0),
        ("2.5 ph R_E-2", Some("ph km-2"), 2.5 / (6371.0 * 6371.0)),
        ("ly", Some("lyr"), 1.0),
        ("R_sun", Some("solRad"), 1.0),
        ("photon count-1", Some("ph ct-1"), 1.0),
        ("1", None, 1.0),
        ("m/m", None, 1.0),
        ("10**-3", None, 1e-3),
        ("R_E/R_mars", None, 6371.0 / 3389.5),
    ] {
        let (found, factor) = unit(text).fits();
        assert_eq!(found.as_deref(), expected, "{text}");
        assert!((factor / expected_factor - 1.0).abs() < 1e-15, "{text}: {factor}");
    }
}

#[test]
fn names_are_unique_and_lead_to_their_units() {
    for known in table::KNOWN_UNITS {
        assert!(!known.source.is_empty() && known.factor_si() > 0.0);
        for name in known.names {
            assert_eq!(unit(name).dimension(), known.dimension, "{name}");
            let bearers = table::KNOWN_UNITS.iter().filter(|other| other.names.contains(name));
            assert_eq!(bearers.count(), 1, "{name}");
        }
    }
}

proptest! {
    #[test]
    fn what_is_written_is_read_again(
        scale in -20..20,
        factors in prop::collection::vec((0..table::KNOWN_UNITS.len(), -9..9), 0..6),
    ) {
        let text = factors.iter().fold(format!("10**{scale}"), |text, (index, power)| {
            format!("{text} {}{power}", table::KNOWN_UNITS[*index].names[0])
        });
        let first = unit(&text);
        prop_assert_eq!(unit(&first.to_string()), first);
    }

    #[test]
    fn no_text_makes_the_parser_panic(text in "[a-zR_0-9 ()*/^.+·-]{0,24}", any in "\\PC{0,12}") {
        for text in [text, any] {
            if let Ok(read) = Unit::parse(&text) {
                prop_assert!(Unit::parse(&read.to_string()).is_ok(), "{}", read);
            }
        }
    }
}

/// The squared density of dark matter over kiloparsecs: a J-factor for each steradian.
#[test]
fn j_factors_and_d_factors() {
    let kiloparsecs = unit("kpc");
    for (density, image) in
        [("GeV2 cm-6 sr-1", "GeV2 cm-5 sr-1"), ("GeV/(cm3 sr)", "GeV cm-2 sr-1")]
    {
        let (found, factor) = image_unit(&unit(density), &kiloparsecs).unwrap();
        assert_eq!(found.to_string(), image);
        assert!((factor / 3.085_677_581_491_367_3e21 - 1.0).abs() < 4e-16, "{factor:e}");
        let of_pixel = found.times(&unit("sr"));
        assert_eq!(of_pixel.to_string(), image.trim_end_matches(" sr-1"));
    }
}
