use crate::scene::{Quantity, Scene, SceneError};
use emitree::{Cube, Emission, Image, Samples};

/// A scene with these lines in `[emission]`, `[image]` and `[projection]`.
fn scene(emission: &str, image: &str, projection: &str) -> Result<Scene, SceneError> {
    let text = format!(
        "[image]\nwidth = 2\nheight = 2\n{image}\n[emission]\n{emission}\n[projection]\n\
         type = \"perspective\"\nposition = [1, 0, 0]\ntarget = [0, 0, 0]\n\
         field_of_view = [9, 9]\nfar = 2\n{projection}"
    );
    Scene::parse("scene.toml", &text, &[])
}

fn unit_and_factor(emission: &str, image: &str, projection: &str) -> (String, f64) {
    let scene = scene(emission, image, projection).unwrap();
    (scene.image_unit().to_owned(), scene.emission.rate_factor)
}

fn is(found: &(String, f64), unit: &str, factor: f64) {
    assert_eq!(found.0, unit);
    assert!((found.1 / factor - 1.0).abs() < 1e-13, "{found:?}, not {factor}");
}

#[test]
fn rates_and_lengths_make_the_image_unit() {
    let rate = "expression = \"1\"\nunit = \"cm-3 s-1 sr-1\"";
    let found = unit_and_factor(rate, "", "length_unit = \"R_E\"");
    is(&found, "cm-2 s-1 sr-1", 6.371e8);
    let found = unit_and_factor(rate, "unit = \"m-2 s-1 sr-1\"", "length_unit = \"km\"");
    is(&found, "m-2 s-1 sr-1", 1e9);
    let no_unit = unit_and_factor("expression = \"1\"", "", "length_unit = \"km\"");
    is(&no_unit, "", 1.0);
}

#[test]
fn isotropic_rates_become_rayleigh() {
    // 1 R is a column of 10^6 photons cm^-2 s^-1 of isotropic emission.
    let rate = "expression = \"1\"\nunit = \"ph cm-3 s-1\"";
    is(&unit_and_factor(rate, "unit = \"R\"", "length_unit = \"km\""), "R", 1e5 * 1e-6);
    let energy = "expression = \"1\"\nunit = \"ph m-3 s-1 sr-1\"\nphoton_energy = 10.0";
    let found = unit_and_factor(energy, "unit = \"J m-2 s-1 sr-1\"", "length_unit = \"m\"");
    is(&found, "J m-2 s-1 sr-1", 1.602_176_634e-18);
}

#[test]
fn models_are_rendered_in_any_length_unit() {
    let scene = scene("model = \"cmem\"", "", "length_unit = \"km\"").unwrap();
    assert_eq!(scene.image_unit(), "keV cm-2 s-1 sr-1");
    let in_km = [[12.0 * 6371.0, 0.0, 0.0]];
    let (mut ours, mut theirs) = ([0.0], [0.0]);
    let direction = [[0.0, 1.0, 0.0]];
    scene.emission.emission_rates(&Samples::new(&in_km, &direction), &mut ours).unwrap();
    let samples = Samples::new(&[[12.0, 0.0, 0.0]], &direction);
    scene.emission.source.emission_rates(&samples, &mut theirs).unwrap();
    assert!(theirs[0] > 0.0);
    assert!((ours[0] * 6371.0 / theirs[0] - 1.0).abs() < 1e-12, "{ours:?} {theirs:?}");
}

#[test]
fn an_irradiance_has_no_steradian() {
    let rate = "expression = \"1\"\nunit = \"cm-3 s-1 sr-1\"";
    let scene = scene(rate, "quantity = \"irradiance\"", "length_unit = \"cm\"").unwrap();
    assert_eq!((scene.quantity, scene.image_unit()), (Quantity::Irradiance, "cm-2 s-1"));
}

#[test]
fn an_isotropic_rate_has_its_share_in_each_direction() {
    let rate = "expression = \"1\"\nunit = \"ph cm-3 s-1\"";
    let found = unit_and_factor(rate, "quantity = \"irradiance\"", "length_unit = \"cm\"");
    is(&found, "ph cm-2 s-1", 0.25 * std::f64::consts::FRAC_1_PI);
}

#[test]
fn units_that_do_not_go_together_are_refused_where_they_stand() {
    let error = |emission: &str, image: &str, projection: &str| {
        let error = scene(emission, image, projection).unwrap_err();
        (error.line().unwrap().1, error.message().to_owned(), error.expected().to_owned())
    };
    let rate = "expression = \"1\"\nunit = \"cm-3 s-1 sr-1\"";
    let (line, message, _) = error(rate, "unit = \"erg\"", "length_unit = \"km\"");
    assert_eq!(line, 4);
    assert!(message.starts_with("`image.unit`: "), "{message}");
    let (line, message, expected) = error(rate, "", "");
    assert_eq!((line, &*message), (7, "`emission.unit` needs a length unit"));
    assert_eq!(expected, "expected `length_unit` in `[projection]` too, as in \"km\"");
    let (line, message, _) =
        error("expression = \"1\"\nunit = \"cm-3 sx\"", "", "length_unit = \"km\"");
    assert_eq!(line, 7);
    assert!(message.contains("`sx`"), "{message}");
    let (line, message, expected) = error("model = \"cmem\"\nunit = \"m-3\"", "", "");
    assert_eq!((line, &*message), (7, "`emission.unit` has no meaning here"));
    let of_model = "expected none: images of this emission are in \"keV cm-2 s-1 sr-1\"";
    assert_eq!(expected, of_model);
    let (line, message, expected) = error("expression = \"1\"", "unit = \"R\"", "");
    assert_eq!((line, &*message), (4, "`image.unit` can't be reached"));
    assert_eq!(expected, "expected `emission.unit` too, the unit that the rates have");
    let (_, message, expected) = error(rate, "quantity = \"flux\"", "length_unit = \"km\"");
    assert_eq!(message, "unknown quantity `flux`");
    assert_eq!(expected, "expected `radiance` or `irradiance`");
    let (_, message, expected) =
        error("expression = \"1\"\nphoton_energy = 0", "", "length_unit = \"km\"");
    assert_eq!(message, "`emission.photon_energy` is 0");
    assert_eq!(expected, "expected an energy in eV above 0");
}

/// The lines of an energy axis for the end of a scene, whose last table is the projection.
const ENERGY: &str =
    "length_unit = \"km\"\n[energy]\nmin = 100\nmax = 300\nbins = 2\nunit = \"eV\"";

/// The image of the whole energy band of a flat cube.
fn band_of_ones(scene: &Scene) -> f64 {
    let flat = Cube::from_bands(vec![Image::from_pixels(1, 1, vec![1.0]); 2]);
    let axis = scene.energy.as_ref().unwrap().axis();
    scene.in_band_unit(flat.sum_over_energy(axis))[(0, 0)]
}

fn cube_and_band(rate: &str, image: &str) -> (String, String, f64) {
    let scene = scene(&format!("expression = \"1\"\nunit = \"{rate}\""), image, ENERGY).unwrap();
    (scene.image_unit().to_owned(), scene.band_unit().to_owned(), band_of_ones(&scene))
}

#[test]
fn a_band_is_the_cube_times_an_energy() {
    let is = |found: (String, String, f64), cube: &str, band: &str, sum: f64| {
        assert_eq!((&*found.0, &*found.1), (cube, band));
        assert!((found.2 / sum - 1.0).abs() < 1e-13, "{found:?}");
    };
    let photons = "ph cm-3 s-1 sr-1 keV-1";
    is(cube_and_band(photons, ""), "ph cm-2 s-1 sr-1 keV-1", "ph cm-2 s-1 sr-1", 0.2);
    let wanted = "unit = \"ph m-2 s-1 sr-1 J-1\"";
    let sum = 200.0 * 1.602_176_634e-19;
    is(cube_and_band(photons, wanted), "ph m-2 s-1 sr-1 J-1", "ph m-2 s-1 sr-1", sum);
    is(cube_and_band("erg/(cm3 s eV)", ""), "erg cm-2 s-1 eV-1", "erg cm-2 s-1", 200.0);
    // keV of energy for each keV of the axis: what is written cancels, as it does in astropy.
    let cancelled = cube_and_band("keV cm-3 s-1 sr-1 keV-1", "");
    is(cancelled, "cm-2 s-1 sr-1", "cm-2 s-1 sr-1 eV", 200.0);
    let scene = scene("expression = \"1\"", "", ENERGY).unwrap();
    assert_eq!((scene.image_unit(), scene.band_unit()), ("", ""));
    assert!((band_of_ones(&scene) - 200.0).abs() < 1e-12);
}

#[test]
fn numbers_of_photons_are_per_energy_where_there_are_energies() {
    let error = |emission: &str, image: &str| {
        let error = scene(&format!("expression = \"1\"\n{emission}"), image, ENERGY).unwrap_err();
        (error.line().unwrap().1, error.message().to_owned(), error.expected().to_owned())
    };
    let (line, message, expected) = error("unit = \"ph cm-3 s-1\"", "");
    assert_eq!(
        (line, &*message, &*expected),
        (
            7,
            "`emission.unit` is \"ph cm-3 s-1\", and the scene has `[energy]`",
            "expected the rate per unit of energy, as in \"ph cm-3 s-1 keV-1\""
        )
    );
    let (line, message, expected) = error("photon_energy = 10", "");
    assert_eq!((line, &*message), (7, "`emission.photon_energy` is 10"));
    assert!(expected.starts_with("expected none: with `[energy]` photons have all"), "{expected}");
    let photons = "unit = \"ph cm-3 s-1 sr-1 keV-1\"";
    for wanted in ["ph cm-2 s-1 sr-1", "erg cm-2 s-1 sr-1 keV-1"] {
        let (line, message, _) = error(photons, &format!("unit = \"{wanted}\""));
        assert_eq!(line, 4);
        assert!(message.starts_with("`image.unit`: no conversion"), "{message}");
    }
}

#[test]
fn spectral_models_are_rendered_in_any_unit_of_energy() {
    let scene = scene("model = \"bremsstrahlung\"", "", ENERGY.replace("km", "pc").as_str());
    let scene = scene.unwrap();
    let source = &scene.emission.source;
    assert_eq!(source.energy_unit(), Some("keV"));
    let length = if source.length_unit().is_some() { scene.emission.length_factor } else { 1.0 };
    let at = [[3.0 / length, 0.0, 0.0]];
    let (mut ours, mut theirs) = ([0.0], [0.0]);
    let direction = [[0.0, 1.0, 0.0]];
    let samples = Samples::new(&at, &direction);
    scene.emission.emission_rates(&samples.at_energies(&[200.0]), &mut ours).unwrap();
    let samples = Samples::new(&[[3.0, 0.0, 0.0]], &direction);
    source.emission_rates(&samples.at_energies(&[0.2]), &mut theirs).unwrap();
    assert!(theirs[0] > 0.0);
    assert!((ours[0] / (theirs[0] * scene.emission.rate_factor) - 1.0).abs() < 1e-12, "{ours:?}");
}
