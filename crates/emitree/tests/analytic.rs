//! Both methods against exact images.
#![expect(clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::los::{LosOptions, Steps};
use emitree::refinement::Threshold;
use emitree::tree::BuildOptions;
use emitree::{
    Canonical, Equirectangular, FromFn, Method, RenderOptions, Rendering, Viewpoint, render,
};
use emitree_problems::catalogue::{Problem, problem, problems};
use emitree_problems::relative_error;

fn error(problem: &Problem, shape: [usize; 2], method: Method) -> (Rendering, f64) {
    let emission = FromFn(|position: [f64; 3], _: [f64; 3]| problem.rate(position));
    let rendering = render(&emission, &Canonical, shape, &RenderOptions::new(method)).unwrap();
    let error = relative_error(&rendering.values, &problem.exact_image(shape));
    (rendering, error)
}

fn paper(order: usize, threshold: f64) -> Method {
    let threshold = Threshold::Relative(threshold);
    Method::Paper(
        BuildOptions::new(threshold).with_order(order).with_base_level(4).with_finest_level(8),
    )
}

/// Smooth problems, whole and odd pixels: the error falls with the threshold, to a few times it.
#[test]
fn trees_converge_on_smooth_problems() {
    for problem in problems().iter().filter(|problem| problem.smooth) {
        let errors: Vec<f64> = [0.1, 0.01, 1e-3]
            .map(|threshold| error(problem, [45, 64], paper(3, threshold)).1)
            .into();
        assert!(errors[2] < 5e-3, "{}: {errors:?}", problem.name);
        assert!(errors[2] < 0.7 * errors[0], "{}: {errors:?}", problem.name);
    }
}

/// Pinned: a change that costs more fails.
#[test]
fn trees_cost_what_they_cost() {
    let cost = |name| error(&problem(name).unwrap(), [64, 64], paper(3, 0.01)).0.stats.evaluations;
    assert_eq!(["eq8", "beta", "gaussians"].map(cost), [49_408, 45_632, 63_616]);
}

/// Where g jumps the image is right to the size of the finest cells.
#[test]
fn trees_and_lines_agree_where_g_jumps() {
    for name in ["shock", "ball", "nebula"] {
        let problem = problem(name).unwrap();
        let (_, tree) = error(&problem, [32, 32], paper(3, 0.01));
        let steps = LosOptions::new(4, Steps::Fixed(400));
        let (_, lines) = error(&problem, [32, 32], Method::Los(steps));
        assert!(tree < 0.03 && lines < 0.03, "{name}: tree {tree}, lines {lines}");
    }
}

/// The first point of the batch at which g is not finite is named, on any number of threads.
#[test]
fn the_same_point_is_named_on_any_number_of_threads() {
    let hole = FromFn(
        |[x, y, z]: [f64; 3], _: [f64; 3]| {
            if x > 0.3 && y > 0.4 && z > 0.2 { f64::NAN } else { 1.0 }
        },
    );
    let message = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let options = RenderOptions::new(paper(3, 0.01));
        pool.install(|| render(&hole, &Canonical, [4, 4], &options).unwrap_err().to_string())
    };
    let expected = message(1);
    assert!(expected.contains("NaN at position [0.34375, 0.40625, 0.21875]"), "{expected}");
    for _ in 0..20 {
        assert_eq!(message(4), expected);
    }
}

/// A uniform volume has the same radiance in every pixel of a wide camera inside it. The tree
/// has the density of solid angle at the centres of its cells, which matters near the poles.
#[test]
fn a_uniform_glow_is_uniform() {
    let viewpoint =
        Viewpoint { position: [0.1, 0.2, 0.3], target: [1.0, 0.0, 0.0], up: [0.0, 0.3, 1.0] };
    let fov_rad = [core::f64::consts::TAU, core::f64::consts::PI];
    let camera = Equirectangular::new(viewpoint, fov_rad, [0.0, 4.0]).unwrap();
    let uniform = FromFn(|_: [f64; 3], _: [f64; 3]| 1.5);
    let lines = LosOptions::new(2, Steps::Fixed(8));
    for (method, tolerance) in [(Method::Los(lines), 1e-14), (paper(3, 0.01), 5e-4)] {
        let rendering =
            render(&uniform, &camera, [17, 40], &RenderOptions::new(method.clone())).unwrap();
        for pixel in rendering.values.pixels() {
            assert!((pixel / 6.0 - 1.0).abs() < tolerance, "{method:?}: {pixel}");
        }
    }
}
