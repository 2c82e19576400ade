//! Method `vol` with an energy axis: exact cubes, costs against images bin by bin, and its limits.
#![expect(clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::los::{LosOptions, Steps};
use emitree::projection::Ellipsoid;
use emitree::vol::Seed;
use emitree::{
    Canonical, Cube, Emission, EnergyAxis, EnergyScale, FromFn, FromSpectralFn, Healpix, Image,
    Perspective, Projection, RenderOptions, Rendering, StopReason, Viewpoint, VolOptions, render,
    render_cube,
};
use emitree_problems::cubes::jumps::random_jump_cube;
use emitree_problems::cubes::parts::{self, Part};
use emitree_problems::cubes::skies::random_sky_cube;
use emitree_problems::cubes::spectrum::Spectrum;
use emitree_problems::cubes::{CubeProblem, problem, problems};
use std::convert::Infallible;

const SHAPE: [usize; 2] = [64, 64];
const BINS: usize = 32;

fn vol(tolerance: f64) -> RenderOptions<'static> {
    RenderOptions::new(VolOptions::new(tolerance))
}

fn emission(problem: &CubeProblem) -> impl Emission<Error = Infallible> {
    FromSpectralFn(|position, _, energy| problem.rate(position, energy))
}

/// A cube with its axis, and the exact one.
struct Checked {
    axis: EnergyAxis,
    rendering: Rendering<Cube>,
    exact: Cube,
    /// The largest error of a voxel over the largest voxel.
    error: f64,
}

fn checked(name: &str, shape: [usize; 2], bins: usize, options: &RenderOptions<'_>) -> Checked {
    let problem = problem(name).unwrap();
    let axis = problem.default_axis(bins).unwrap();
    let rendering = render_cube(&emission(&problem), &Canonical, shape, &axis, options).unwrap();
    let exact = problem.exact(shape, &axis);
    let error = rendering.values.max_difference(&exact) / exact.largest();
    Checked { axis, rendering, exact, error }
}

/// Voxels whose error is within its estimate, as a share.
fn share_within_estimate(Checked { rendering, exact, .. }: &Checked, exact_error: f64) -> f64 {
    let errors: Vec<f64> = rendering.error.as_ref().unwrap().voxels().collect();
    let slack = exact_error * exact.largest();
    let found = rendering.values.voxels().zip(exact.voxels()).zip(&errors);
    let within = found.filter(|((found, exact), error)| (found - exact).abs() <= *error + slack);
    within.count() as f64 / errors.len() as f64
}

/// An image for each bin, at the middle of its energies, to a tolerance of its own largest pixel.
fn evaluations_of_images(name: &str, tolerance: f64) -> u64 {
    let problem = problem(name).unwrap();
    let axis = problem.default_axis(BINS).unwrap();
    let image = |bin: usize| {
        let energy = axis.energy((bin as f64 + 0.5) / BINS as f64);
        let emission = FromFn(|position, _| problem.rate(position, energy));
        render(&emission, &Canonical, SHAPE, &vol(tolerance)).unwrap().stats.evaluations
    };
    (0..BINS).map(image).sum()
}

/// The exact test: one spectrum everywhere is one image, to each tolerance, at a pinned cost.
#[test]
fn one_spectrum_everywhere_costs_one_image_and_a_few_spectra() {
    for (tolerance, evaluations) in [(0.1, 3_470), (0.01, 3_470), (1e-3, 3_643)] {
        let found = checked("separable", SHAPE, BINS, &vol(tolerance));
        let rendering = &found.rendering;
        assert!(rendering.converged() && found.error <= tolerance, "{tolerance}: {}", found.error);
        let estimate = rendering.estimated_error().unwrap();
        assert!(found.error <= estimate && estimate <= tolerance, "{tolerance}: {estimate}");
        assert_eq!(rendering.stats.evaluations, evaluations, "{tolerance}");
        assert_eq!(rendering.stats.energies.len(), 1);
    }
}

fn check_tolerance(name: &str) {
    let exact_error = problem(name).unwrap().cube_error;
    for (tolerance, bins) in [(0.1, BINS), (0.01, 5), (0.01, BINS), (1e-3, BINS)] {
        let found = checked(name, SHAPE, bins, &vol(tolerance));
        let estimate = found.rendering.estimated_error().unwrap();
        assert!(found.rendering.converged(), "{name} {tolerance}");
        assert!(found.error <= tolerance && estimate <= tolerance, "{name} {tolerance} {bins}");
        assert!(found.error <= estimate, "{name} {tolerance} {bins}: {} {estimate}", found.error);
        let within = share_within_estimate(&found, exact_error);
        assert!(within >= 0.99, "{name} {tolerance} {bins}: {within}");
    }
}

#[test]
fn tolerances_are_met_for_lines_and_edges() {
    ["mixture", "narrow-line", "edge"].into_iter().for_each(check_tolerance);
}

#[test]
fn tolerances_are_met_for_smooth_spectra_that_change_with_place() {
    ["bremsstrahlung", "ena-ring"].into_iter().for_each(check_tolerance);
}

/// A line at another energy at each place is the most expensive.
#[test]
fn tolerances_are_met_for_a_line_that_is_shifted() {
    for (tolerance, evaluations) in [(0.1, 265_913), (0.01, 508_920)] {
        let found = checked("doppler", SHAPE, BINS, &vol(tolerance));
        assert!(found.rendering.converged() && found.error <= tolerance, "{}", found.error);
        assert_eq!(found.rendering.stats.evaluations, evaluations);
    }
}

/// Pinned, and against an image for each of 32 bins: smooth spectra cost less than a third, lines and
/// edges less.
#[test]
fn cubes_cost_what_they_cost() {
    for (name, evaluations, of_images) in [
        ("mixture", 7_096, 48_000),
        ("narrow-line", 8_515, 48_003),
        ("edge", 6_079, 47_332),
        ("bremsstrahlung", 6_950, 72_146),
        ("ena-ring", 16_331, 278_240),
    ] {
        let found = checked(name, SHAPE, BINS, &vol(0.01));
        assert_eq!(found.rendering.stats.evaluations, evaluations, "{name}");
        assert_eq!(evaluations_of_images(name, 0.01), of_images, "{name}");
        assert!(3 * evaluations < of_images, "{name}");
    }
}

/// More bins cost spectra of more samples, not images.
#[test]
fn bins_cost_little() {
    let cost =
        |bins| checked("bremsstrahlung", SHAPE, bins, &vol(0.01)).rendering.stats.evaluations;
    let [few, many] = [8, 256].map(cost);
    assert!(many < 2 * few, "{few} {many}");
}

#[test]
fn the_sum_over_energy_is_the_exact_band() {
    for name in ["separable", "edge"] {
        let found = checked(name, [40, 30], 12, &vol(0.01));
        let band = found.rendering.values.sum_over_energy(&found.axis);
        let exact = found.exact.sum_over_energy(&found.axis);
        let error = band.max_difference(&exact) / exact.min_max().1;
        assert!(error < 0.01, "{name}: {error}");
        let widths: Vec<f64> = found.axis.edges().windows(2).map(|e| e[1] - e[0]).collect();
        let bands = found.rendering.values.bands().iter().zip(&widths);
        let by_hand: f64 = bands.map(|(band, width)| band[(7, 9)] * width).sum();
        assert!((band[(7, 9)] - by_hand).abs() < 1e-12 * by_hand.abs());
    }
}

#[test]
fn threads_and_batches_change_no_bit() {
    let reference = checked("ena-ring", [24, 32], 10, &vol(0.01)).rendering;
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let options = vol(0.01).with_batch_size(1000 * threads as u64 + 1);
        let again = pool.install(|| checked("ena-ring", [24, 32], 10, &options).rendering);
        assert_eq!(again.stats.evaluations, reference.stats.evaluations);
        assert!(again.values == reference.values && again.error == reference.error, "{threads}");
        assert_eq!(again.stats.energies, reference.stats.energies);
    }
}

/// A limit ends the rendering with the image so far, which has not converged.
#[test]
fn a_limit_is_kept_and_reported() {
    for limit in [30, 400, 729, 1000, 5000, 12_000] {
        let options = vol(1e-3).with_max_evaluations(limit);
        let found = checked("ena-ring", SHAPE, BINS, &options);
        assert!(found.rendering.stats.evaluations <= limit, "{limit}");
        assert!(!found.rendering.converged(), "{limit}");
        assert_ne!(found.rendering.stats.ending, StopReason::Complete);
        // The estimate is infinite where it is not known.
        let within = share_within_estimate(&found, 1e-6);
        assert!(within >= 0.95 || limit < 729, "{limit}: {within}");
        assert!(found.rendering.estimated_error() > Some(1e-3), "{limit}");
        assert_eq!(found.rendering.values.shape(), [BINS, 64, 64]);
    }
}

#[test]
fn darkness_and_a_flat_spectrum_have_one_energy() {
    let axis = EnergyAxis::new(1.0, 2.0, 7, EnergyScale::Linear).unwrap();
    let dark = FromSpectralFn(|_: [f64; 3], _, _: f64| 0.0);
    let rendering = render_cube(&dark, &Canonical, [8, 8], &axis, &vol(0.01)).unwrap();
    assert!(rendering.converged() && rendering.values.largest() == 0.0);
    assert_eq!(rendering.estimated_error(), Some(0.0));
    let flat = FromSpectralFn(|[x, ..]: [f64; 3], _, _: f64| 1.0 + x);
    let rendering = render_cube(&flat, &Canonical, [8, 8], &axis, &vol(0.01)).unwrap();
    assert_eq!(rendering.stats.energies.len(), 1);
    for (column, expected) in (0..8).map(|column| (column, 1.0 + (column as f64 + 0.5) / 8.0)) {
        for band in rendering.values.bands() {
            assert!((band[(3, column)] - expected).abs() < 1e-12, "{column}");
        }
    }
}

/// A ball of Gaussian density, exactly, times the mean of a spectrum over each bin.
fn exact_ball(mean: impl Fn([f64; 2]) -> f64, axis: &EnergyAxis, size: usize) -> Cube {
    let along = |i: usize, n: usize| {
        emitree_problems::means::gaussian(20.0, 0.5, i as f64 / n as f64, (i + 1) as f64 / n as f64)
    };
    let ball = |at: usize| along(at % size, size) * along(at / size, size) * along(0, 1);
    let band = |edges: &[f64]| {
        let mean = mean([edges[0], edges[1]]);
        Image::from_pixels(size, size, (0..size * size).map(|at| mean * ball(at)).collect())
    };
    Cube::from_bands(axis.edges().windows(2).map(band).collect())
}

/// A band feature between the first selected energies, and no emission beside it.
#[test]
fn a_feature_in_darkness_is_found() {
    let axis = EnergyAxis::new(0.0, 1.0, 16, EnergyScale::Linear).unwrap();
    let (centre, width) = (0.37, 0.04);
    let rate = |[x, y, z]: [f64; 3], _, energy: f64| {
        let square = (x - 0.5).powi(2) + (y - 0.5).powi(2) + (z - 0.5).powi(2);
        let feature = (-((energy - centre) / width).powi(2)).exp();
        // Far from its middle there is nothing at all.
        if (energy - centre).abs() < 3.0 * width { feature * (-20.0 * square).exp() } else { 0.0 }
    };
    let mean = |[low, high]: [f64; 2]| {
        let [low, high] = [low, high].map(|e| e.clamp(centre - 3.0 * width, centre + 3.0 * width));
        if high <= low {
            return 0.0;
        }
        emitree_problems::means::gaussian(width.powi(-2), centre, low, high) * 16.0 * (high - low)
    };
    let exact = exact_ball(mean, &axis, 16);
    let found =
        render_cube(&FromSpectralFn(rate), &Canonical, [16, 16], &axis, &vol(0.01)).unwrap();
    let error = found.values.max_difference(&exact) / exact.largest();
    assert!(found.converged() && error < 0.01, "{error}");
    assert!(found.stats.evaluations < 10_000, "{}", found.stats.evaluations);
}

/// A narrow line and nothing else, where it is announced; and a spectrum that underflows elsewhere.
#[test]
fn a_line_in_darkness_is_found_where_it_is_announced() {
    let axis = EnergyAxis::new(0.0, 1.0, 16, EnergyScale::Linear).unwrap();
    for (line, width, lines, evaluations) in
        [(0.3123, 5e-4, &[0.3123][..], 6_464), (0.3, 1.87e-3, &[], 15_448)]
    {
        let rate = |[x, y, z]: [f64; 3], _, energy: f64| {
            let square = (x - 0.5).powi(2) + (y - 0.5).powi(2) + (z - 0.5).powi(2);
            1e3 * (-((energy - line) / width).powi(2)).exp() * (-20.0 * square).exp()
        };
        let mean = |[low, high]: [f64; 2]| {
            1e3 * emitree_problems::means::gaussian(width.powi(-2), line, low, high)
        };
        let exact = exact_ball(mean, &axis, 16);
        let line_energies = lines.to_vec();
        let options = RenderOptions::new(VolOptions::default().with_line_energies(line_energies));
        let found = render_cube(&FromSpectralFn(rate), &Canonical, [16, 16], &axis, &options);
        let found = found.unwrap();
        let error = found.values.max_difference(&exact) / exact.largest();
        assert!(found.converged() && error < 0.01, "{line}: {error}");
        assert_eq!(found.stats.evaluations, evaluations, "{line}");
    }
}

/// A compact source that only a seed finds is not counted twice, though it was missed at the first energy.
#[test]
fn a_seed_in_darkness_is_counted_once() {
    let axis = EnergyAxis::new(0.0, 1.0, 8, EnergyScale::Linear).unwrap();
    let (place, size): ([f64; 3], f64) = ([0.31, 0.43, 0.57], 3e-3);
    let rate = |at: [f64; 3], _, energy: f64| {
        let square: f64 = at.iter().zip(place).map(|(a, b)| (a - b).powi(2)).sum();
        1e6 * (-square / (size * size)).exp() * (-energy).exp()
    };
    let seeds = [Seed { position: place, radius: size }];
    let seeds = seeds.to_vec();
    let options = RenderOptions::new(VolOptions::default().with_seeds(seeds));
    let found = render_cube(&FromSpectralFn(rate), &Canonical, [16, 16], &axis, &options).unwrap();
    assert!(found.converged());
    let volume = 1e6 * (size * core::f64::consts::PI.sqrt()).powi(3);
    for (band, edges) in found.values.bands().iter().zip(axis.edges().windows(2)) {
        let mean = 8.0 * ((-edges[0]).exp() - (-edges[1]).exp());
        let sum: f64 = band.pixels().iter().sum::<f64>() / 256.0;
        assert!((sum / (volume * mean) - 1.0).abs() < 0.02, "{sum} {}", volume * mean);
    }
}

/// A line a thousandth of a bin wide is met by no sample; it is found if it is declared.
#[test]
fn a_very_narrow_line_is_found_where_it_is_announced() {
    let axis = EnergyAxis::new(0.0, 10.0, 10, EnergyScale::Linear).unwrap();
    let (line, width) = (6.4, 1e-3);
    let rate = |[x, y, z]: [f64; 3], _, energy: f64| {
        let square = (x - 0.3).powi(2) + (y - 0.5).powi(2) + (z - 0.5).powi(2);
        1.0 + 400.0 * (-((energy - line) / width).powi(2)).exp() * (-20.0 * square).exp()
    };
    let line_energies = vec![line];
    let options = RenderOptions::new(VolOptions::default().with_line_energies(line_energies));
    let declared =
        render_cube(&FromSpectralFn(rate), &Canonical, [16, 16], &axis, &options).unwrap();
    // Without the continuum the sixth bin has the column of the ball times the line's area.
    let column =
        |centre: f64, from: f64, to: f64| emitree_problems::means::gaussian(20.0, centre, from, to);
    let pixel = |at: usize| {
        let edges = |i: usize| [i as f64 / 16.0, (i + 1) as f64 / 16.0];
        let ([x0, x1], [y0, y1]) = (edges(at % 16), edges(at / 16));
        let ball = column(0.3, x0, x1) * column(0.5, y0, y1) * column(0.5, 0.0, 1.0);
        1.0 + 400.0 * width * core::f64::consts::PI.sqrt() * ball
    };
    let exact = Image::from_pixels(16, 16, (0..256).map(pixel).collect());
    let largest = exact.min_max().1;
    assert!(largest > 1.25, "{largest}");
    assert!(declared.values.bands()[6].max_difference(&exact) < 0.01 * largest);
    assert!(
        declared.values.bands()[5].max_difference(&Image::from_pixels(16, 16, vec![1.0; 256]))
            < 0.01
    );
}

/// A line far narrower than the distance of the energies at which the base lines are compared, in the middle
/// between two of them: it is found by the energies of the final verification.
#[test]
fn a_narrow_line_is_found_by_energies_that_took_no_part() {
    let axis = EnergyAxis::new(1.0, 3.0, 5, EnergyScale::Linear).unwrap();
    let continuum = Part {
        amplitude: 1.0,
        centre: [0.5; 3],
        widths: [0.35; 3],
        spectrum: Spectrum::PowerLaw { index: 2.0 },
    };
    for place in [20.5, 51.5, 77.5, 102.5] {
        // A standard deviation of 6e-4 of the band.
        let width = 2.0 * 6e-4 * core::f64::consts::SQRT_2;
        let spectrum = Spectrum::Line { energy: 1.0 + 2.0 * place / 128.0, width };
        let line = Part { amplitude: 20.0, centre: [0.4, 0.6, 0.5], widths: [0.35; 3], spectrum };
        let scene = [continuum, line];
        let emission = FromSpectralFn(|at, _, energy: f64| parts::rate(&scene, at, energy));
        let found = render_cube(&emission, &Canonical, [32, 32], &axis, &vol(0.01)).unwrap();
        let exact = parts::exact(&scene, [32, 32], &axis);
        let error = found.values.max_difference(&exact) / exact.largest();
        let without = parts::exact(&[continuum], [32, 32], &axis);
        assert!(without.max_difference(&exact) > 0.1 * exact.largest());
        assert!(found.converged() && error < 0.01, "{place}: {error}");
        assert!(found.stats.evaluations < 20_000, "{place}: {}", found.stats.evaluations);
    }
}

/// The mean over a bin of a spectrum with a scale height that grows with energy, by Gauss–Legendre.
fn mean_over_bin(edges: [f64; 2], rate: impl Fn(f64) -> f64) -> f64 {
    let nodes = [(-0.774_596_669_241_483_4, 5.0), (0.0, 8.0), (0.774_596_669_241_483_4, 5.0)];
    let [middle, half] = [0.5 * (edges[0] + edges[1]), 0.5 * (edges[1] - edges[0])];
    nodes.iter().map(|(node, weight)| weight / 18.0 * rate(middle + half * node)).sum()
}

/// Each band against an image of its own to a tenth of the tolerance.
fn check_bands(
    camera: &dyn Projection,
    shape: [usize; 2],
    rate: impl Fn([f64; 3], f64) -> f64 + Sync,
) {
    let axis = EnergyAxis::new(1.0, 3.0, 12, EnergyScale::Log).unwrap();
    let emission = FromSpectralFn(|position, _, energy: f64| rate(position, energy));
    let rendering = render_cube(&emission, camera, shape, &axis, &vol(0.01)).unwrap();
    assert!(rendering.converged() && rendering.stats.energies.len() > 1);
    let largest = rendering.values.largest();
    for (band, edges) in rendering.values.bands().iter().zip(axis.edges().windows(2)).step_by(5) {
        let mean = |position, _| mean_over_bin([edges[0], edges[1]], |e| rate(position, e));
        let image = render(&FromFn(mean), camera, shape, &vol(1e-3)).unwrap();
        let error = band.max_difference(&image.values) / largest;
        assert!(image.converged() && error < 0.01, "{error}");
    }
}

fn radius([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

#[test]
fn an_opaque_body_hides_its_share_at_all_energies() {
    let viewpoint = Viewpoint { position: [5.0, 1.0, 0.5], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
    let camera = Perspective::new(viewpoint, [0.6, 0.5], [0.0, 10.0]).unwrap();
    let body = Ellipsoid::sphere([0.0; 3], 1.0).unwrap();
    let camera = camera.with_occulters(vec![body]).unwrap();
    check_bands(&camera, [20, 24], |position, energy| {
        (-(radius(position) - 1.0) / (0.3 * energy)).exp() / energy
    });
}

#[test]
fn the_whole_sky_has_a_cube() {
    let sky = Healpix::new([0.2, 0.0, 0.1], [0.0, 4.0]).unwrap();
    check_bands(&sky, Healpix::shape(8), |[x, y, z], energy| {
        let at = radius([x - 1.0, y, z - 0.5]);
        (-at * at * energy).exp() + 0.3 * (-radius([x, y, z])).exp() / energy.powi(2)
    });
}

/// Line-of-sight integration of a cube is another way to it.
#[test]
fn lines_of_sight_see_the_same() {
    let problem = problem("separable").unwrap();
    let axis = problem.default_axis(6).unwrap();
    let los = LosOptions::new(4, Steps::Fixed(64));
    let options = RenderOptions::new(los);
    let lines = render_cube(&emission(&problem), &Canonical, [12, 10], &axis, &options).unwrap();
    let exact = problem.exact([12, 10], &axis);
    let error = lines.values.max_difference(&exact) / exact.largest();
    assert!(error < 0.02, "{error}");
    assert_eq!(lines.stats.energies.len(), 24);
    assert_eq!(lines.stats.evaluations, 12 * 10 * 16 * 64 * 24);
}

/// No bin costs: one of them is an image of the band's mean.
#[test]
fn one_bin_is_an_image() {
    for problem in problems().iter().filter(|problem| problem.name != "doppler") {
        let found = checked(problem.name, [20, 20], 1, &vol(0.01));
        assert!(found.rendering.converged() && found.error < 0.01, "{}", problem.name);
    }
}

/// The cube of a random scene with sharp surfaces in 10 bins, with the largest error of a voxel less that of the
/// reference, over the largest voxel.
fn jump_cube(seed: u64, tolerance: f64) -> (Rendering<Cube>, f64) {
    let scene = random_jump_cube(seed);
    let axis = scene.axis(10).unwrap();
    let emission = FromSpectralFn(|position, _, energy| scene.rate(position, energy));
    let found = render_cube(&emission, &Canonical, [32, 32], &axis, &vol(tolerance)).unwrap();
    let reference = scene.reference([32, 32], &axis);
    let error = found.values.max_difference(&reference.cube) / reference.cube.largest();
    (found, error - reference.error)
}

/// Surfaces are found at one energy, and what the other energies add costs little more; pinned, and beside what an image
/// at the middle of the band takes.
#[test]
fn jumps_at_all_energies_are_found_once() {
    const SEED: u64 = 0;
    let (found, error) = jump_cube(SEED, 0.01);
    assert!(found.converged() && found.surfaces.is_some() && error <= 0.01, "{error}");
    assert!(found.estimated_error().unwrap() <= 0.01);
    let scene = random_jump_cube(SEED);
    let emission = FromFn(|position, _| scene.rate(position, 1.25));
    let image = render(&emission, &Canonical, [32, 32], &vol(0.01)).unwrap();
    assert_eq!([found.stats.evaluations, image.stats.evaluations], [12_283, 6_527]);
}

/// Cameras of all kinds: 145,589 by image trees in a view of latitudes; a disc, in which few samples meet the shape, and
/// in which nothing and one of two shapes were seen, reported as converged.
#[test]
fn jumps_of_cubes_in_views_of_the_sky() {
    for (seed, evaluations) in [(6, 11_358), (17, 22_415), (18, 37_692)] {
        let scene = random_sky_cube(seed);
        let axis = scene.axis(12).unwrap();
        let emission = FromSpectralFn(|position, _, energy| scene.rate(position, energy));
        let found =
            render_cube(&emission, scene.camera(), scene.pixels(), &axis, &vol(0.01)).unwrap();
        let reference = scene.reference(&axis);
        let error = found.values.max_difference(&reference.cube) / reference.cube.largest();
        let name = scene.name();
        assert!(found.converged() && found.surfaces.is_some(), "{name}");
        assert!(error <= 0.01 + reference.error, "{name}: {error}");
        assert_eq!(found.stats.evaluations, evaluations, "{name}");
    }
}

/// A second shape with a line alone is dark at the energy of the largest image: its surfaces are found by no search, and
/// the image trees render the cube.
#[test]
fn a_surface_that_the_first_energy_does_not_have_is_left_to_the_trees() {
    let (found, error) = jump_cube(5, 0.05);
    assert!(found.converged() && found.surfaces.is_none() && error <= 0.05, "{error}");
}
