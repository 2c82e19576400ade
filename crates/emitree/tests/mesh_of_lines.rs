//! Meshes of lines for other emissions: image trees, cubes and lines of sight by themselves.

use emitree::error::OptionError;
use emitree::los::{LosOptions, Steps};
use emitree::mesh::{Mesh, MeshError};
use emitree::result::Values;
use emitree::{
    Canonical, Cube, EnergyAxis, EnergyScale, FromFn, FromSpectralFn, Image, Method, RenderError,
    RenderOptions, Rendering, Session, StopReason, VolOptions, render, render_cube,
};
use emitree_problems::relative_error;
use emitree_problems::views::random_view;

const SHAPE: [usize; 2] = [48, 64];

fn vol(tolerance: f64) -> RenderOptions<'static> {
    RenderOptions::new(VolOptions::new(tolerance)).with_mesh_up_to(1_000_000)
}

fn los(steps: Steps) -> RenderOptions<'static> {
    RenderOptions::new(Method::Los(LosOptions::new(1, steps))).with_mesh_up_to(1_000_000)
}

/// Two spiral arms in a tilted plane, which no products represent; `turn` is an angle.
fn arms(turn: f64, [x, y, z]: [f64; 3]) -> f64 {
    let [x, y, z] = [x - 0.5, y - 0.5, z - 0.5 - 0.3 * (x - 0.5)];
    let radius = x.hypot(y);
    let arm = 1.0 + (2.0 * y.atan2(x) - 30.0 * radius + turn).cos();
    arm * radius * radius * (-16.0 * radius * radius - 60.0 * z * z).exp()
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn rendered(turn: f64, options: &RenderOptions<'_>) -> Rendering {
    render(&FromFn(|at, _| arms(turn, at)), &Canonical, SHAPE, options).unwrap()
}

/// 16 lines with 256 uniform steps for each pixel, whose error is 10⁻⁴ or less of the largest pixel.
#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn reference(turn: f64) -> Image {
    let options = RenderOptions::new(Method::Los(LosOptions::new(4, Steps::Fixed(256))));
    render(&FromFn(|at, _| arms(turn, at)), &Canonical, SHAPE, &options).unwrap().values
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn applied(mesh: &Mesh, turn: f64) -> Image {
    let rates: Vec<f64> = mesh.points().positions().iter().map(|&at| arms(turn, at)).collect();
    mesh.apply(&rates).unwrap()
}

/// The image of a fixed mesh of an image tree is that of its linear map. Its error is estimated from this
/// emission, and lines and points that took no part are evaluated in addition.
#[test]
fn a_fixed_tree_gives_the_image_of_its_map_and_an_error_of_its_own() {
    let mesh = rendered(0.0, &vol(0.0025)).mesh.unwrap();
    let points = mesh.points().len() as u64;
    for (turn, suffices) in [(0.0, true), (0.3, false)] {
        let found = rendered(turn, &vol(0.01).with_fixed_mesh(&mesh));
        let applied = applied(&mesh, turn);
        assert!(found.values.max_difference(&applied) < 1e-12 * applied.largest(), "{turn}");
        let error = relative_error(&found.values, &reference(turn));
        let estimated = found.estimated_error().unwrap();
        assert!(error < estimated + 1e-4, "{turn}: {error} {estimated}");
        let ending = if suffices { StopReason::Complete } else { StopReason::FixedMesh };
        assert_eq!(found.stats.ending, ending, "{turn}: {estimated}");
        assert!(found.stats.evaluations > points);
        // Its own mesh has the same points.
        assert_eq!(found.mesh.unwrap().points().positions(), mesh.points().positions());
    }
}

/// A rendering that begins with a tree goes on from it: it meets the tolerance where the fixed mesh does not.
#[test]
fn a_tree_is_refined_from_that_of_another_emission() {
    let mesh = rendered(0.0, &vol(0.01)).mesh.unwrap();
    let turn = 2.0;
    let found = rendered(turn, &vol(0.005).with_start(&mesh));
    let error = relative_error(&found.values, &reference(turn));
    assert!(found.converged() && error < 0.005, "{error}");
    let from_nothing = rendered(turn, &vol(0.005)).stats;
    let counts = [found.stats.evaluations, found.stats.batches];
    assert_eq!(
        [counts, [from_nothing.evaluations, from_nothing.batches]],
        [[23_091, 28], [19_446, 53]]
    );
    let own = found.mesh.unwrap();
    let rates = applied(&own, turn);
    assert!(rates.max_difference(&found.values) < 1e-12 * rates.largest());
}

/// A budget below that of the points is an error for a fixed mesh, and ends a rendering that may add points as
/// without a mesh.
#[test]
fn a_tree_with_a_small_budget() {
    let mesh = rendered(0.0, &vol(0.01)).mesh.unwrap();
    let emission = FromFn(|at, _| arms(0.1, at));
    let options = vol(0.01).with_max_evaluations(2000);
    let fixed = render(&emission, &Canonical, SHAPE, &options.clone().with_fixed_mesh(&mesh));
    let what = "the points of the fixed mesh and samples that show its error".to_owned();
    match fixed.err() {
        Some(RenderError::Budget { what: of, needed, allowed: 2000 }) => {
            assert_eq!(of, what);
            assert!(needed >= mesh.points().len() as u64);
        }
        other => panic!("{other:?}"),
    }
    let started = render(&emission, &Canonical, SHAPE, &options.clone().with_start(&mesh)).unwrap();
    let alone = render(&emission, &Canonical, SHAPE, &options).unwrap();
    assert_eq!(started.values, alone.values);
    // The points alone, and no lines that show the error.
    let budget = mesh.points().len() as u64 + 20;
    let few = vol(0.01).with_max_evaluations(budget).with_fixed_mesh(&mesh);
    let few = render(&emission, &Canonical, SHAPE, &few);
    assert!(few.is_ok_and(|found| found.stats.ending == StopReason::Budget));
}

fn spectral(temperature: f64, at: [f64; 3], energy: f64) -> f64 {
    let local = temperature * (1.0 + 0.5 * at[0] * at[1]);
    (-energy / local).exp() * arms(0.0, at) + 0.01 * (-at[2]).exp() / (1.0 + energy * energy)
}

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn cube(temperature: f64, options: &RenderOptions<'_>) -> Rendering<Cube> {
    let axis = EnergyAxis::new(0.5, 4.0, 6, EnergyScale::Linear).unwrap();
    let emission = FromSpectralFn(|at, _, energy| spectral(temperature, at, energy));
    render_cube(&emission, &Canonical, [24, 32], &axis, options).unwrap()
}

/// Energies and their functions are part of the mesh of a cube, and spectra of this emission show what they do
/// not explain.
#[test]
fn a_fixed_cube_has_an_error_of_its_own() {
    let mesh = cube(1.0, &vol(0.0025)).mesh.unwrap();
    let lines = RenderOptions::new(Method::Los(LosOptions::new(4, Steps::Fixed(128))));
    let mut found = Vec::new();
    for temperature in [1.0, 1.02, 2.0] {
        let fixed = cube(temperature, &vol(0.01).with_fixed_mesh(&mesh));
        let reference = cube(temperature, &lines).values;
        let largest = reference.largest();
        let difference = |(a, b): (&Image, &Image)| a.max_difference(b);
        let bands = fixed.values.bands().iter().zip(reference.bands());
        let error = bands.map(difference).fold(0.0, f64::max) / largest;
        let estimated = fixed.estimated_error().unwrap();
        assert!(error < estimated + 1e-3, "{temperature}: {error} {estimated}");
        found.push((fixed.converged(), fixed.stats.evaluations));
        let rates: Vec<f64> = {
            let points = mesh.points();
            let at = points.positions().iter().zip(points.energies());
            at.map(|(&at, &energy)| spectral(temperature, at, energy)).collect()
        };
        let applied = mesh.apply(&rates).unwrap();
        let bands = fixed.values.bands().iter().zip(applied.bands());
        assert!(bands.map(difference).fold(0.0, f64::max) < 1e-12 * largest);
    }
    assert_eq!(found, [(true, 71_025), (true, 71_027), (false, 71_160)]);
    let refined = cube(2.0, &vol(0.01).with_start(&mesh));
    assert!(refined.converged());
}

/// Lines have the errors of their own panels; those beyond the tolerance are halved if points may be added.
#[test]
fn lines_of_sight_serve_other_emissions() {
    let options = los(Steps::Adaptive(1e-3));
    let mesh = rendered(0.0, &options).mesh.unwrap();
    let same = rendered(0.0, &options.clone().with_fixed_mesh(&mesh));
    assert_eq!(same.stats.evaluations, mesh.points().len() as u64);
    let sharp = |at: [f64; 3]| (-3000.0 * (at[2] - 0.52).powi(2)).exp() * at[0];
    let emission = FromFn(|at, _| sharp(at));
    let of = |options: &RenderOptions<'_>| render(&emission, &Canonical, SHAPE, options).unwrap();
    let (fixed, started) =
        (of(&options.clone().with_fixed_mesh(&mesh)), of(&options.clone().with_start(&mesh)));
    assert_eq!(
        [fixed.stats.ending, started.stats.ending],
        [StopReason::FixedMesh, StopReason::Complete]
    );
    let alone = of(&options).values;
    assert!(relative_error(&started.values, &alone) < 1e-3);
    assert!(fixed.estimated_error().unwrap() > relative_error(&fixed.values, &alone));
    // Uniform steps are the same for all emissions, and have no error estimate.
    let options = los(Steps::Fixed(16));
    let mesh = rendered(0.0, &options).mesh.unwrap();
    let fixed = rendered(0.5, &options.clone().with_fixed_mesh(&mesh));
    assert_eq!(fixed.values, rendered(0.5, &options).values);
    assert_eq!(fixed.error, None);
    // Other lines than those of the mesh are refused.
    let other = los(Steps::Fixed(17)).with_fixed_mesh(&mesh);
    let refused = render(&emission, &Canonical, SHAPE, &other);
    assert_eq!(refused.err(), Some(RenderError::Option(OptionError::FixedMesh)));
}

/// In this view g is the same at all but a few points, beside which a jump is looked for: the same points are requested
/// again.
#[test]
fn a_mesh_is_restored_where_few_points_differ() {
    let view = random_view(167);
    let emission = FromFn(|position, _| view.rate(position));
    let found = render(&emission, view.camera(), view.shape(), &vol(0.01)).unwrap();
    assert_eq!(found.stats.evaluations, 5017);
    let mesh = found.mesh.unwrap();
    let (camera, shape): (&dyn emitree::Projection, _) = (view.camera(), view.shape());
    let rates = mesh.recorded_rates();
    let restored = Session::<Image>::restored_mesh(camera, shape, None, &vol(0.01), rates).unwrap();
    assert_eq!(restored.points().positions(), mesh.points().positions());
}

/// The recorded rates of a rendering make its mesh again, with all that it began with; other ones are refused.
#[test]
fn a_mesh_is_restored_from_its_rates() {
    let camera: &dyn emitree::Projection = &Canonical;
    let again = |options: &RenderOptions<'_>, rates: &[f64]| {
        Session::<Image>::restored_mesh(camera, SHAPE, None, options, rates)
    };
    let first = vol(0.01);
    let mesh = rendered(0.0, &first).mesh.unwrap();
    let restored = again(&first, mesh.recorded_rates()).unwrap();
    assert_eq!(restored.points().positions(), mesh.points().positions());
    assert_eq!(restored.weights(), mesh.weights());
    // A rendering that begins with the restored mesh is the same.
    let second = vol(0.005).with_start(&mesh);
    let found = rendered(0.5, &second);
    assert_eq!(rendered(0.5, &vol(0.005).with_start(&restored)).values, found.values);
    let mesh = found.mesh.unwrap();
    let restored = again(&second, mesh.recorded_rates()).unwrap();
    assert_eq!(restored.points().positions(), mesh.points().positions());
    // A session has the same record.
    let mut session = Session::<Image>::new(camera, SHAPE, &first).unwrap();
    while !session.is_done() {
        session.step(&FromFn(|at, _| arms(0.0, at))).unwrap();
    }
    let of_session = session.mesh().unwrap();
    assert!(again(&first, of_session.recorded_rates()).is_ok());
    let rates = of_session.recorded_rates();
    let number = rates.len() - 1;
    let refused = again(&first, &rates[..number]).err();
    assert_eq!(refused, Some(MeshError::Recorded { number }));
    let longer = [rates, &[0.0]].concat();
    assert_eq!(again(&first, &longer).err(), Some(MeshError::Recorded { number: number + 2 }));
}
