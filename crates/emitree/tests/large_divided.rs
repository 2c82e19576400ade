//! Images row by row of views that bodies, bounds and planes divide.
#![expect(clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::large::{LargeImage, render_large, render_large_cube};
use emitree::projection::{Bounds, Edge, Ellipsoid, Singularity};
use emitree::{
    Canonical, EnergyAxis, EnergyScale, FromFn, FromSpectralFn, Orthographic, Perspective,
    Projection, RenderError, RenderOptions, Viewpoint, VolOptions, render,
};
use emitree_problems::divided::random_divided;
use emitree_problems::family::Reference;
use emitree_problems::relative_error;
use emitree_problems::views::random_view;
use std::f64::consts::PI;

/// The width of a Gaussian atmosphere about a planet of radius 1.
const WIDTH: f64 = 1.2;
const DEPTHS: [f64; 2] = [2.0, 12.0];

fn atmosphere(at: [f64; 3]) -> f64 {
    let square: f64 = at.iter().map(|x| x * x).sum();
    (-0.5 * square / (WIDTH * WIDTH)).exp()
}

fn planet() -> Vec<Ellipsoid> {
    vec![Ellipsoid::sphere([0.0; 3], 1.0).unwrap()]
}

fn camera() -> Perspective {
    let viewpoint =
        Viewpoint { position: [6.0, 0.3, 0.2], target: [0.0, 0.4, -0.2], up: [0.0, 0.1, 1.0] };
    Perspective::new(viewpoint, [0.6, 0.5], DEPTHS).unwrap()
}

fn options(tolerance: f64) -> RenderOptions<'static> {
    RenderOptions::new(VolOptions::new(tolerance))
}

/// The radiance of the line of sight at (x, y), before the planet where it meets that.
fn radiance(camera: &Perspective, [x, y]: [f64; 2]) -> f64 {
    let start = camera.world_from_canonical([x, y, 0.0]);
    let along: Vec<f64> = start.direction.iter().map(|d| -d).collect();
    // The line begins at the near end of the depths.
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let closest = -dot(&start.position, &along);
    let miss = dot(&start.position, &start.position) - closest * closest;
    let end = if miss < 1.0 { closest - (1.0 - miss).sqrt() } else { DEPTHS[1] - DEPTHS[0] };
    let erf = |t: f64| libm::erf((t - closest) / (WIDTH * 2.0_f64.sqrt()));
    let scale = (-0.5 * miss / (WIDTH * WIDTH)).exp() * WIDTH * (0.5 * PI).sqrt();
    scale * (erf(end) - erf(0.0))
}

/// Whether a line of sight ends at the planet.
fn meets_planet(camera: &Perspective, [x, y]: [f64; 2]) -> bool {
    let start = camera.world_from_canonical([x, y, 0.0]);
    let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let closest = dot(start.position, start.direction);
    dot(start.position, start.position) - closest * closest < 1.0
}

/// The mean over a pixel of the radiance of lines, each row of them divided at the limb, where it is found by bisection.
fn mean_of_lines(
    camera: &Perspective,
    [height, width]: [usize; 2],
    at: [usize; 2],
    lines: usize,
) -> f64 {
    let mean_of_row = |i: usize| {
        let y = (at[0] as f64 + (i as f64 + 0.5) / lines as f64) / height as f64;
        let place = |t: f64| [(at[1] as f64 + t) / width as f64, y];
        let mean = |from: f64, to: f64| {
            let of = |j: usize| place(from + (to - from) * (j as f64 + 0.5) / lines as f64);
            (0..lines).map(|j| radiance(camera, of(j))).sum::<f64>() / lines as f64 * (to - from)
        };
        let begins_at_planet = meets_planet(camera, place(0.0));
        if begins_at_planet == meets_planet(camera, place(1.0)) {
            return mean(0.0, 1.0);
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            let is_before = meets_planet(camera, place(middle)) == begins_at_planet;
            if is_before { low = middle } else { high = middle }
        }
        mean(0.0, low) + mean(low, 1.0)
    };
    (0..lines).map(mean_of_row).sum::<f64>() / lines as f64
}

/// Pixels of a large image of a planet against closed forms, on the disc, beyond it and at its limb.
#[test]
fn small_pixels_beside_a_planet_are_within_the_tolerance() {
    let (shape @ [height, width], tolerance) = ([1200, 1600], 1e-3);
    let camera = camera();
    let with_planet = camera.clone().with_occulters(planet()).unwrap();
    let glow = FromFn(|at: [f64; 3], _| atmosphere(at));
    let image = render_large(&glow, &with_planet, shape, &options(tolerance)).unwrap();
    assert!(image.converged() && image.estimated_error() <= tolerance);
    let [_, largest] = image.range();
    let mut at_limb = 0;
    for row in [3, 417, 600, 931] {
        let values = image.values(row..row + 1);
        for column in 0..width {
            let corner = |[i, j]: [usize; 2]| {
                [(column + j) as f64 / width as f64, (row + i) as f64 / height as f64]
            };
            let corners =
                [[0, 0], [0, 1], [1, 0], [1, 1]].map(|at| meets_planet(&camera, corner(at)));
            let is_at_limb = corners.contains(&true) && corners.contains(&false);
            if !is_at_limb && column % 97 > 0 {
                continue;
            }
            at_limb += usize::from(is_at_limb);
            let exact =
                mean_of_lines(&camera, shape, [row, column], if is_at_limb { 64 } else { 4 });
            let error = (values[(0, column)] - exact).abs();
            // Lines at the limb have an error themselves.
            let known = if is_at_limb { 1e-4 } else { 1e-9 };
            let allowed = (image.estimated_error() + known) * largest;
            assert!(error <= allowed, "{row} {column}: {error:e} of {exact}");
        }
    }
    assert!(at_limb > 3, "{at_limb} pixels at the limb");
}

/// Where the search has all pixels, the image is that of a rendering, up to the quadrature of blocks of rows.
#[test]
fn rows_of_a_divided_view_are_those_of_a_rendering() {
    let glow = FromFn(|at: [f64; 3], _| atmosphere(at));
    let shape = [170, 210];
    let cases: [Box<dyn Projection>; 3] = [
        Box::new(camera().with_occulters(planet()).unwrap()),
        Box::new(
            camera().with_bounds(Bounds::Ellipsoid(Ellipsoid::sphere([0.3; 3], 1.1).unwrap())),
        ),
        Box::new(
            Orthographic::of_unit_cube()
                .with_edges(vec![Edge::plane([0.5; 3], [0.2, 0.1, 1.0]).unwrap()]),
        ),
    ];
    for (number, view) in cases.iter().enumerate() {
        let whole = render(&glow, &**view, shape, &options(1e-3)).unwrap();
        let rows = render_large(&glow, &**view, shape, &options(1e-3)).unwrap();
        assert!(rows.converged(), "view {number}");
        assert!(rows.stats().evaluations <= whole.stats.evaluations, "view {number}");
        let (values, errors) = (rows.values(0..170), rows.errors(0..170));
        let of_whole = whole.error.as_ref().unwrap();
        let both = values.pixels().iter().zip(whole.values.pixels());
        let allowed = errors.pixels().iter().zip(of_whole.pixels());
        for ((a, b), (of_a, of_b)) in both.zip(allowed) {
            assert!(
                (a.is_nan() && b.is_nan()) || (a - b).abs() <= of_a + of_b,
                "{number}: {a} {b}"
            );
        }
        // The same bits, whatever the rows that are asked for.
        for (row, of_row) in rows.values(31..64).rows().enumerate() {
            let same = of_row.iter().zip(values.row(31 + row));
            assert!(
                same.into_iter().all(|(a, b)| a.to_bits() == b.to_bits()),
                "{number}: row {row}"
            );
        }
    }
}

/// Random views with bodies, bounds and edges, and with planes, of seeds that nothing was chosen on: each image that is
/// made is within the tolerance of its reference.
#[test]
fn random_divided_views_are_within_the_tolerance() {
    let (tolerance, mut made) = (1e-2, [0, 0]);
    for seed in 400..405 {
        let view = random_view(seed);
        let plane = random_divided(seed);
        let glow = FromFn(|at: [f64; 3], _| view.rate(at));
        let rows = render_large(&glow, view.camera(), view.shape(), &options(tolerance));
        made[0] += usize::from(is_within(rows, &view.reference(), tolerance, &view.name()));
        let glow = FromFn(|at: [f64; 3], _| plane.rate(at));
        let (camera, shape) = (plane.camera().unwrap(), [48, 48]);
        let rows = render_large(&glow, &*camera, shape, &options(tolerance));
        made[1] +=
            usize::from(is_within(rows, &plane.reference_image(shape), tolerance, &plane.name()));
    }
    assert!(made[0] >= 3 && made[1] >= 3, "{made:?} images were made");
}

/// Whether an image was made; one that has converged has to be within the tolerance, up to the error of the reference.
fn is_within<E: core::fmt::Debug>(
    rows: Result<LargeImage<'_>, RenderError<E>>,
    reference: &Reference,
    tolerance: f64,
    name: &str,
) -> bool {
    let rows = match rows {
        Ok(rows) => rows,
        Err(error) => {
            assert!(matches!(error, RenderError::NotByRows { .. }), "{name}: {error:?}");
            return false;
        }
    };
    let values = rows.values(0..rows.shape()[0]);
    let error = relative_error(&values, &reference.image);
    assert!(!rows.converged() || error <= tolerance + reference.error, "{name}: {error}");
    rows.converged()
}

/// A jump at a plane is seen by the layers on both sides, and a rendering row by row has both.
#[test]
fn layers_between_planes_add_up() {
    let glow = FromFn(|[_, _, z]: [f64; 3], _| if z < 0.4 { 1.0 } else { 3.0 });
    let view = Orthographic::of_unit_cube()
        .with_edges(vec![Edge::plane([0.5, 0.5, 0.4], [0.0, 0.0, 1.0]).unwrap()]);
    let image = render_large(&glow, &view, [900, 700], &options(1e-3)).unwrap();
    let exact = 0.4 * 1.0 + 0.6 * 3.0;
    for value in image.values(17..19).pixels() {
        assert!((value - exact).abs() <= 1e-3 * exact, "{value}");
    }
}

#[test]
fn a_singularity_is_refused_with_a_reason() {
    let glow = FromFn(|at: [f64; 3], _| 1.0 / at.iter().map(|x| x * x).sum::<f64>().sqrt());
    let point = Singularity::point([0.0; 3]).unwrap();
    let view = camera().with_singularities(vec![point]);
    let error = render_large(&glow, &view, [64, 64], &options(1e-2)).unwrap_err();
    assert!(error.to_string().contains("a singularity of the emission is in its view"), "{error}");
}

#[test]
fn a_cube_of_a_divided_view_is_refused_with_a_reason() {
    let glow = FromSpectralFn(|at, _, energy: f64| atmosphere(at) * (-energy).exp());
    let axis = EnergyAxis::new(0.5, 4.0, 6, EnergyScale::Linear).unwrap();
    let view = camera().with_occulters(planet()).unwrap();
    let refused = render_large_cube(&glow, &view, [64, 64], Some(&axis), &options(1e-2));
    let error = refused.unwrap_err();
    assert!(matches!(error, RenderError::NotByRows { .. }));
    assert!(error.to_string().contains("divides its view, and it is a cube"), "{error}");
    assert!(render_large_cube(&glow, &Canonical, [64, 64], Some(&axis), &options(1e-2)).is_ok());
}
