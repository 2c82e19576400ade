//! Renderings that begin with the mesh of another emission.

use emitree::error::OptionError;
use emitree::los::{LosOptions, Steps};
use emitree::mesh::Mesh;
use emitree::result::Values;
use emitree::tree::BuildOptions;
use emitree::vol::PixelTolerance;
use emitree::{
    Canonical, EnergyAxis, EnergyScale, FromFn, FromSpectralFn, Image, Method, RenderError,
    RenderOptions, Rendering, Session, StopReason, VolOptions, render, render_cube,
};
use emitree_problems::family::random_scene;
use emitree_problems::relative_error;
use emitree_problems::views::{Outcome, random_view};

const SHAPE: [usize; 2] = [48, 64];
const WITH_MESH: u64 = 1_000_000;

fn vol(tolerance: f64) -> RenderOptions<'static> {
    RenderOptions::new(VolOptions::new(tolerance)).with_mesh_up_to(WITH_MESH)
}

/// Two Gaussians; `shift` moves both.
fn clouds(shift: f64) -> impl Fn([f64; 3]) -> f64 {
    move |[x, y, z]: [f64; 3]| {
        let [x, y] = [x - shift, y + 0.5 * shift];
        let near = (x - 0.4).powi(2) + (y - 0.6).powi(2) + 2.0 * (z - 0.3).powi(2) + x * y * z;
        let far = (x - 0.6).powi(2) + (x + y - 0.9).powi(2) + (z - 0.7).powi(2);
        (-12.0 * near).exp() + 0.5 * (-9.0 * far).exp()
    }
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn rendered(rate: impl Fn([f64; 3]) -> f64 + Sync, options: &RenderOptions<'_>) -> Rendering {
    render(&FromFn(|at, _| rate(at)), &Canonical, SHAPE, options).unwrap()
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn mesh_of(rate: impl Fn([f64; 3]) -> f64 + Sync, tolerance: f64) -> Mesh {
    rendered(rate, &vol(tolerance)).mesh.unwrap()
}

#[test]
fn a_rendering_has_its_mesh_up_to_a_number_of_evaluations() {
    let found = rendered(clouds(0.0), &vol(1e-3));
    let evaluations = found.stats.evaluations;
    let options = RenderOptions::new(VolOptions::new(1e-3));
    assert!(found.mesh.is_some());
    assert!(rendered(clouds(0.0), &options).mesh.is_none());
    assert!(rendered(clouds(0.0), &options.clone().with_mesh_up_to(evaluations)).mesh.is_some());
    assert!(rendered(clouds(0.0), &options.with_mesh_up_to(evaluations - 1)).mesh.is_none());
    for steps in [Steps::Fixed(8), Steps::Adaptive(1e-3)] {
        let lines = RenderOptions::new(Method::Los(LosOptions::new(1, steps)));
        let evaluations = rendered(clouds(0.0), &lines).stats.evaluations;
        let up_to = |number| rendered(clouds(0.0), &lines.clone().with_mesh_up_to(number)).mesh;
        assert!(up_to(evaluations).is_some() && up_to(evaluations / 2).is_none(), "{steps:?}");
    }
}

/// The image of a fixed mesh is that of its linear map, and its evaluations are those at the points and those
/// that show the error.
#[test]
fn a_fixed_mesh_gives_the_image_of_its_map() {
    let mesh = mesh_of(clouds(0.0), 1e-3);
    let other = clouds(0.01);
    let found = rendered(&other, &vol(0.01).with_fixed_mesh(&mesh));
    let rates: Vec<f64> = mesh.points().positions().iter().map(|&at| other(at)).collect();
    let applied = mesh.apply(&rates).unwrap();
    assert!(found.values.max_difference(&applied) < 1e-12 * applied.largest());
    assert!(found.converged());
    assert_eq!([mesh.points().len() as u64, found.stats.evaluations], [320, 576]);
    let from_nothing = rendered(&other, &vol(0.01)).stats.evaluations;
    assert_eq!(from_nothing, 2_033);
    // The same bits for any number of threads, and in a session.
    let options = vol(0.01).with_fixed_mesh(&mesh);
    let mut session =
        Session::<Image>::new(&Canonical as &dyn emitree::Projection, SHAPE, &options).unwrap();
    while !session.is_done() {
        session.step(&FromFn(|at, _| other(at))).unwrap();
    }
    let of_session = session.rendering().unwrap();
    assert_eq!(of_session.values, found.values);
    assert_eq!(session.mesh().unwrap().points().len(), mesh.points().len());
}

/// A budget below that of the points is an error with the number that is needed; one that suffices for them alone
/// gives their image, with an error from fewer samples.
#[test]
fn a_fixed_mesh_with_a_small_budget() {
    let mesh = mesh_of(clouds(0.0), 1e-3);
    let emission = FromFn(|at, _| clouds(0.01)(at));
    let fixed = |budget| {
        let options = vol(0.01).with_fixed_mesh(&mesh).with_max_evaluations(budget);
        render(&emission, &Canonical, SHAPE, &options)
    };
    let what = "the points of the fixed mesh and samples that show its error".to_owned();
    let needed = mesh.points().len() as u64 + 128;
    assert_eq!(fixed(400).err(), Some(RenderError::Budget { what, needed, allowed: 400 }));
    let [small, usual] = [needed, 1_000_000].map(|budget| fixed(budget).unwrap());
    assert_eq!(small.stats.evaluations, needed);
    assert_eq!(small.values, usual.values);
    let exact = rendered(clouds(0.01), &vol(1e-5)).values;
    let error = relative_error(&small.values, &exact);
    assert!(error > 0.0 && error < small.estimated_error().unwrap(), "{error}");
}

/// An emission of another structure does not converge with a fixed mesh; it does if functions may be added, to
/// the same error as without a mesh.
#[test]
fn a_mesh_that_does_not_suffice_is_not_called_converged() {
    let mesh = mesh_of(clouds(0.0), 0.01);
    let [x, y, z] = [0.2, 0.25, 0.6];
    let other = move |at: [f64; 3]| {
        let offset = (at[0] - x).powi(2) + (at[1] - y).powi(2) + (at[2] - z).powi(2);
        (-60.0 * offset).exp()
    };
    let exact = rendered(other, &vol(1e-5)).values;
    let fixed = rendered(other, &vol(0.01).with_fixed_mesh(&mesh));
    assert_eq!(fixed.stats.ending, StopReason::FixedMesh);
    let error = relative_error(&fixed.values, &exact);
    assert!(error > 0.01 && fixed.estimated_error().unwrap() > error, "{error}");
    let found = rendered(other, &vol(0.01).with_start(&mesh));
    assert!(found.converged() && relative_error(&found.values, &exact) < 0.01);
    assert_eq!(found.values, rendered(other, &vol(0.01)).values, "as without a mesh");
}

/// A mesh of another method, or of an image for a cube, has no effect; a rendering can't be fixed to it.
/// The mean of exp(-a (t - at)²) from `from` to `to`, by Simpson's rule: to rounding for the pixels here.
fn mean_of_gaussian(a: f64, at: f64, [from, to]: [f64; 2]) -> f64 {
    const PARTS: u32 = 256;
    let value = |k: u32| {
        let t = from + (to - from) * f64::from(k) / f64::from(PARTS);
        (-a * (t - at).powi(2)).exp()
    };
    let weight = |k: u32| match k {
        0 | PARTS => 1.0,
        _ => f64::from(2 + 2 * (k % 2)),
    };
    (0..=PARTS).map(|k| weight(k) * value(k)).sum::<f64>() / (3.0 * f64::from(PARTS))
}

/// The functions of an image with errors by pixel are those of a scaled rate: errors have to be those of the rate.
#[test]
fn a_mesh_with_errors_by_pixel_has_honest_errors_for_another_emission() {
    let peak = |at: f64| {
        move |[x, y, z]: [f64; 3]| {
            let across = (x - at).powi(2) + (y - 0.1).powi(2);
            (-24.0 * across - 12.0 * (z - 0.5).powi(2)).exp()
        }
    };
    let by_pixel =
        VolOptions::default().with_pixel_tolerance(PixelTolerance::relative(0.01).with_floor(1e-5));
    let by_pixel = RenderOptions::new(by_pixel).with_mesh_up_to(WITH_MESH);
    let mesh = rendered(peak(0.1), &by_pixel).mesh.unwrap();
    let [height, width] = SHAPE;
    let depth = mean_of_gaussian(12.0, 0.5, [0.0, 1.0]);
    for (at, tolerance) in [(0.1, 1e-3), (0.12, 1e-3), (0.2, 1e-2), (0.4, 1e-2)] {
        let mut exact = Image::zeros(height, width);
        for row in 0..height {
            let ends = |k: usize, count: usize| [k, k + 1].map(|k| k as f64 / count as f64);
            let of_row = depth * mean_of_gaussian(24.0, 0.1, ends(row, height));
            for column in 0..width {
                exact[(row, column)] = of_row * mean_of_gaussian(24.0, at, ends(column, width));
            }
        }
        let found = rendered(peak(at), &vol(tolerance).with_fixed_mesh(&mesh));
        let error = relative_error(&found.values, &exact);
        let estimate = found.estimated_error().unwrap();
        // Of an image that is wrong by more than its brightest pixel, the estimate says that alone.
        assert!(error.min(1.0) <= estimate, "{at}: {error} {estimate}");
        assert!(!found.converged() || error <= tolerance, "{at}: {error}");
    }
}

#[test]
fn a_mesh_of_another_method_has_no_effect_or_is_refused() {
    let lines = RenderOptions::new(Method::Los(LosOptions::default())).with_mesh_up_to(WITH_MESH);
    let mesh = rendered(clouds(0.0), &lines).mesh.unwrap();
    let found = rendered(clouds(0.0), &vol(0.01).with_start(&mesh));
    assert_eq!(found.values, rendered(clouds(0.0), &vol(0.01)).values);
    let emission = FromFn(|at, _| clouds(0.0)(at));
    let refused = render(&emission, &Canonical, SHAPE, &vol(0.01).with_fixed_mesh(&mesh)).err();
    assert_eq!(refused, Some(RenderError::Option(OptionError::FixedMesh)));
    // Nor do lines, cells and cubes use the functions of an image.
    let mesh = mesh_of(clouds(0.0), 0.01);
    let refused = render(&emission, &Canonical, SHAPE, &lines.with_fixed_mesh(&mesh)).err();
    assert_eq!(refused, Some(RenderError::Option(OptionError::FixedMesh)));
    let cells = RenderOptions::new(Method::Paper(BuildOptions::default())).with_fixed_mesh(&mesh);
    let refused = render(&emission, &Canonical, SHAPE, &cells).err();
    assert_eq!(refused, Some(RenderError::Option(OptionError::FixedMesh)));
    let axis = EnergyAxis::new(1.0, 2.0, 2, EnergyScale::Linear).unwrap();
    let spectral = FromSpectralFn(|at, _, _| clouds(0.0)(at));
    let cube = render_cube(&spectral, &Canonical, SHAPE, &axis, &vol(0.01).with_fixed_mesh(&mesh));
    assert_eq!(cube.err(), Some(RenderError::Option(OptionError::FixedMesh)));
    assert_eq!(
        OptionError::FixedMesh.to_string(),
        "the fixed mesh has neither products nor lines for some part of the view: expected the mesh of a \
         rendering of this view by method vol or los with the same options, or a rendering that may add points"
    );
}

/// Errors on random scenes and views with other parameters; the table in docs/results/engine.md has more
/// of them.
#[test]
fn a_fixed_mesh_that_converges_is_within_the_tolerance() {
    let (mut scenes, mut converged, mut evaluations, mut from_nothing) = (0, 0, 0, 0);
    let mut check = |found: Rendering, error: f64, cold: Rendering, name: &str| {
        scenes += 1;
        if found.converged() {
            converged += 1;
            evaluations += found.stats.evaluations;
            from_nothing += cold.stats.evaluations;
            assert!(error < 0.01, "{name}: {error}");
        }
    };
    for seed in (0..24).filter(|seed| seed % 6 < 4) {
        let (scene, other) = (random_scene(seed), random_scene(seed).changed(0.03));
        let [of_scene, of_other] = [&scene, &other].map(|scene| FromFn(|at, _| scene.rate(at)));
        let mesh = render(&of_scene, &Canonical, [64; 2], &vol(0.01)).unwrap().mesh.unwrap();
        let fixed = vol(0.01).with_fixed_mesh(&mesh);
        let Ok(found) = render(&of_other, &Canonical, [64; 2], &fixed) else { continue };
        let cold = render(&of_other, &Canonical, [64; 2], &vol(0.01)).unwrap();
        let error = relative_error(&found.values, &other.reference_image([64; 2]).image);
        check(found, error, cold, &scene.name());
    }
    for seed in [1, 2, 8, 13] {
        let (view, other) = (random_view(seed), random_view(seed).changed(0.03));
        let (camera, shape) = (view.camera(), view.shape());
        let [of_view, of_other] = [&view, &other].map(|view| FromFn(|at, _| view.rate(at)));
        let mesh = render(&of_view, camera, shape, &vol(0.01)).unwrap().mesh.unwrap();
        let fixed = vol(0.01).with_fixed_mesh(&mesh);
        let Ok(found) = render(&of_other, camera, shape, &fixed) else { continue };
        let cold = render(&of_other, camera, shape, &vol(0.01)).unwrap();
        let error = Outcome::of(&found, &other.reference()).error;
        check(found, error, cold, &view.name());
    }
    // The meshes of the ten others have lines: at their own tolerance they do not suffice.
    assert_eq!([scenes, converged], [20, 8]);
    assert_eq!([evaluations, from_nothing], [5_602, 19_760]);
}

/// Two clouds, each with a spectrum of its own; `second` is the amplitude of the second one, and `index` the power of 1/E in the
/// spectrum of the first one.
fn spectral_clouds(second: f64, index: f64) -> impl Fn([f64; 3], f64) -> f64 {
    move |at: [f64; 3], energy: f64| {
        let cloud = |middle: [f64; 3], width: f64| {
            let squares: f64 = at.iter().zip(middle).map(|(x, middle)| (x - middle).powi(2)).sum();
            (-squares / (width * width)).exp()
        };
        cloud([0.4, 0.5, 0.6], 0.3) * energy.powf(-index)
            + second * cloud([0.6, 0.4, 0.3], 0.25) * (-energy).exp()
    }
}

/// A cube of products has the functions of all its energies for another emission. Where these do not suffice, that is said.
#[test]
fn a_cube_begins_with_the_products_of_another_one() {
    let axis = EnergyAxis::new(0.5, 2.0, 8, EnergyScale::Log).unwrap();
    let cube = |rate: &(dyn Fn([f64; 3], f64) -> f64 + Sync), options: &RenderOptions<'_>| {
        let emission = FromSpectralFn(|at, _, energy| rate(at, energy));
        render_cube(&emission, &Canonical, SHAPE, &axis, options).unwrap()
    };
    let first = spectral_clouds(0.8, 1.0);
    let mesh = cube(&first, &vol(1e-3)).mesh.unwrap();
    let other = spectral_clouds(0.5, 1.0);
    let exact = cube(&other, &vol(1e-5)).values;
    let error = |found: &Rendering<_>| {
        let found: &Rendering<emitree::Cube> = found;
        found.values.max_difference(&exact) / exact.largest()
    };
    let fixed = cube(&other, &vol(0.01).with_fixed_mesh(&mesh));
    let both = mesh.points().positions().iter().zip(mesh.points().energies());
    let rates: Vec<f64> = both.map(|(&at, &energy)| other(at, energy)).collect();
    let applied = mesh.apply(&rates).unwrap();
    assert!(fixed.values.max_difference(&applied) < 1e-12 * applied.largest());
    assert!(fixed.converged() && error(&fixed) <= fixed.estimated_error().unwrap());
    let started = cube(&other, &vol(0.01).with_start(&mesh));
    let from_nothing = cube(&other, &vol(0.01));
    assert!(started.converged() && error(&started) < 0.01);
    let [started, from_nothing] = [started, from_nothing].map(|of| of.stats.evaluations);
    assert!(started < from_nothing, "{started} {from_nothing}");
    // The same in each band is made of trees.
    let by_band = RenderOptions::new(VolOptions::new(0.01).with_per_band(true));
    let by_band = cube(&other, &by_band.with_start(&mesh));
    assert!(by_band.converged() && error(&by_band) < 0.01);
    // The spectrum of the first cloud is no combination of those that the mesh has.
    let steep = spectral_clouds(0.5, 3.0);
    let fixed = cube(&steep, &vol(1e-3).with_fixed_mesh(&mesh));
    let exact = cube(&steep, &vol(1e-5)).values;
    let error = fixed.values.max_difference(&exact) / exact.largest();
    assert_eq!(fixed.stats.ending, StopReason::FixedMesh);
    assert!(error > 1e-3 && error <= fixed.estimated_error().unwrap(), "{error}");
    let started = cube(&steep, &vol(1e-3).with_start(&mesh));
    assert!(started.converged());
    assert!(started.values.max_difference(&exact) <= 1e-3 * exact.largest());
}
