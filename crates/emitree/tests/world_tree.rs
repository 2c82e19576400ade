//! Trees in the world against the emissions that they were built from: errors, costs and images.

use core::sync::atomic::{AtomicU64, Ordering};
use emitree::world_tree::{
    BuiltWorldTree, WorldBox, WorldTree, WorldTreeOptions, build_world_tree,
};
use emitree::{
    Canonical, Emission, Equirectangular, FromFn, Image, Projection, RenderOptions, Samples,
    StopReason, Viewpoint, VolOptions, render,
};
use emitree_problems::catalogue::{Problem, problem};
use emitree_problems::relative_error;

#[expect(clippy::unwrap_used, reason = "what fails here fails the test")]
fn built(problem: &Problem, order: usize, tolerance: f64) -> BuiltWorldTree {
    let g = FromFn(|position, _| problem.rate(position));
    let options = WorldTreeOptions::new(tolerance).with_order(order);
    build_world_tree(&g, WorldBox::new([0.0; 3], [1.0; 3]).unwrap(), &options).unwrap()
}

/// The largest and the rms error at many points, relative to the largest rate.
fn errors(problem: &Problem, built: &BuiltWorldTree) -> [f64; 2] {
    let step = [0.819_172_513_396_164_5, 0.671_043_606_703_789_2, 0.549_700_477_901_936_6];
    let positions: Vec<[f64; 3]> =
        (0..60_000).map(|n| step.map(|s| (f64::from(n) * s).fract())).collect();
    let mut rates = vec![0.0; positions.len()];
    let directions = vec![[0.0, 0.0, 1.0]; positions.len()];
    let Ok(()) = built.tree.emission_rates(&Samples::new(&positions, &directions), &mut rates);
    let errors = positions.iter().zip(&rates).map(|(&p, rate)| (rate - problem.rate(p)).abs());
    let (largest, squares) = errors.fold((0.0_f64, 0.0), |(m, s), e| (m.max(e), s + e * e));
    [largest, (squares / positions.len() as f64).sqrt()].map(|error| error / built.largest_rate)
}

/// Tolerance, order, evaluations, and bounds on the largest and the rms error.
type Row = (f64, usize, u64, f64, f64);

fn converges(name: &str, rows: &[Row]) {
    let problem = problem(name).unwrap_or_else(|| unreachable!("{name} is in the catalogue"));
    for &(tolerance, order, evaluations, largest, rms) in rows {
        let built = built(&problem, order, tolerance);
        let found = errors(&problem, &built);
        assert_eq!(built.evaluations, evaluations, "{name} {order} {tolerance}");
        assert_eq!(built.ending, StopReason::Complete);
        assert!(built.largest_dropped < tolerance * built.largest_rate);
        assert!(found[0] < largest && found[1] < rms, "{name} {order} {tolerance}: {found:?}");
        // Bounds that are far from what is found would hide a loss.
        assert!(found[0] > largest / 3.0 && found[1] > rms / 3.0, "{name}: {found:?}");
    }
}

#[test]
fn errors_and_evaluations_of_eq8() {
    converges(
        "eq8",
        &[
            (1e-2, 3, 46_912, 4e-3, 8e-5),
            (1e-2, 5, 41_600, 1.2e-3, 2.5e-5),
            (1e-2, 7, 41_216, 8e-4, 1.3e-5),
            (1e-3, 5, 62_912, 4e-4, 5e-6),
            (1e-4, 5, 179_712, 6e-5, 8e-7),
            (1e-4, 7, 156_416, 4e-5, 2.2e-7),
        ],
    );
}

#[test]
fn errors_and_evaluations_of_a_cluster_of_galaxies() {
    converges(
        "beta",
        &[
            (1e-2, 5, 43_200, 3e-3, 2e-5),
            (1e-3, 5, 61_376, 1e-4, 1.5e-6),
            (1e-4, 5, 137_536, 1e-5, 1.2e-7),
        ],
    );
}

fn image<E: Emission>(emission: &E, camera: &dyn Projection, tolerance: f64) -> Image {
    let options = RenderOptions::new(VolOptions::new(tolerance));
    let rendering = render(emission, camera, [24, 32], &options);
    let Ok(rendering) = rendering else { unreachable!("the scene can be rendered") };
    assert!(rendering.converged());
    rendering.values
}

/// Views from outside, along an edge, and from within.
fn views() -> Vec<Equirectangular> {
    let view = |position, target, fov_deg: f64, far| {
        let viewpoint = Viewpoint { position, target, up: [0.0, 0.1, 1.0] };
        let fov = [fov_deg.to_radians(), (0.75 * fov_deg).to_radians()];
        Equirectangular::new(viewpoint, fov, [0.0, far])
    };
    [
        view([-2.0, 0.3, 0.6], [0.5; 3], 24.0, 4.0),
        view([0.2, 3.0, 1.9], [0.5, 0.5, 0.4], 20.0, 5.0),
        view([0.5, 0.5, 0.9], [0.4, 0.5, 0.1], 60.0, 1.5),
    ]
    .into_iter()
    .filter_map(Result::ok)
    .collect()
}

/// g has an end at the box, as the tree has.
fn inside(position: [f64; 3]) -> bool {
    position.iter().all(|x| (0.0..=1.0).contains(x))
}

#[test]
fn one_tree_makes_the_images_of_every_view_without_g() {
    let problem = problem("beta").unwrap();
    let calls = AtomicU64::new(0);
    let g = FromFn(|position, _| {
        calls.fetch_add(1, Ordering::Relaxed);
        if inside(position) { problem.rate(position) } else { 0.0 }
    });
    let bounds = WorldBox::new([0.0; 3], [1.0; 3]).unwrap();
    let built = build_world_tree(&g, bounds, &WorldTreeOptions::default()).unwrap();
    assert_eq!(calls.load(Ordering::Relaxed), built.evaluations);
    // The tree as it would come from a file.
    let families: Vec<_> = built.tree.families().collect();
    let tree = WorldTree::from_families(bounds, 5, 4, &families).unwrap();

    let views = views();
    assert_eq!(views.len(), 3);
    let before = calls.load(Ordering::Relaxed);
    let of_tree: Vec<Image> = views.iter().map(|view| image(&tree, view, 1e-3)).collect();
    assert_eq!(calls.load(Ordering::Relaxed), before, "g is not called again");
    for (view, of_tree) in views.iter().zip(&of_tree) {
        let error = relative_error(of_tree, &image(&g, view, 1e-3));
        // The tolerance of both renderings, and what is the tree's own.
        assert!(error < 2e-3, "{error:e}");
    }
    let exact = problem.exact_image([24, 32]);
    let error = relative_error(&image(&tree, &Canonical, 1e-4), &exact);
    assert!(error < 3e-4, "{error:e}");
}

/// Where g jumps only the finest level bounds the error: it halves with the cells.
#[test]
fn a_jump_is_as_sharp_as_the_finest_cells() {
    let ball = problem("ball").unwrap();
    let g = FromFn(|position, _| ball.rate(position));
    let bounds = WorldBox::new([0.0; 3], [1.0; 3]).unwrap();
    let rms = [5, 6, 7].map(|level| {
        let options = WorldTreeOptions::default().with_finest_level(level);
        let built = build_world_tree(&g, bounds, &options).unwrap();
        assert!(built.unresolved_cells > 0 && built.largest_dropped > 0.1 * built.largest_rate);
        errors(&ball, &built)[1]
    });
    // The volume in which the error is of the size of g is that of a layer of cells.
    for pair in rms.windows(2) {
        assert!(pair[1] < 0.8 * pair[0] && pair[1] > 0.6 * pair[0], "{rms:?}");
    }
}
