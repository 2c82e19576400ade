//! Singular points and axes: images against references, with pinned evaluations.
#![expect(clippy::unwrap_used, reason = "what fails here fails the test")]

use emitree::projection::Singularity;
use emitree::{
    FromFn, Image, Orthographic, RenderOptions, Rendering, Viewpoint, VolOptions, render,
};
use emitree_problems::cusps::{CuspView, Place, comet, nfw_halo, power_law, random_cusps};

fn rendering(view: &CuspView, tolerance: f64) -> Rendering {
    let emission = FromFn(|position, _| view.rate(position));
    let options = RenderOptions::new(VolOptions::new(tolerance)).with_max_evaluations(1_000_000);
    render(&emission, view.camera(), view.shape(), &options).unwrap()
}

/// The largest error over the largest pixel, an error of the reference left out.
fn true_error(view: &CuspView, found: &Image) -> f64 {
    let reference = view.reference();
    let pairs = || found.pixels().iter().zip(reference.image.pixels());
    let largest = pairs().fold(0.0, |most: f64, (_, exact)| most.max(exact.abs()));
    let wrong = pairs().fold(0.0, |most: f64, (found, exact)| most.max((found - exact).abs()));
    wrong / largest - reference.error
}

/// J-factors of the halo of the documents, by an independent quadrature: the pixel that contains the centre, in
/// GeV² cm⁻⁵, for cores of these sizes in kpc.
const CENTRAL: [(f64, f64); 5] = [
    (0.0, 1.586_246e20),
    (1e-2, 3.174_186_4e19),
    (1e-3, 1.249_972_8e20),
    (1e-4, 1.548_510_1e20),
    (1e-5, 1.582_430_6e20),
];

#[test]
fn the_pixel_on_a_halo_is_within_its_tolerance() {
    let expected = [[1804, 3685], [4407, 5439], [2374, 5253], [2273, 4843], [2266, 4828]];
    for ((core, central), counts) in CENTRAL.into_iter().zip(expected) {
        let view = nfw_halo(core, Place::Centre);
        let solid_angles = view.solid_angles();
        for (tolerance, count) in [1e-2, 1e-3].into_iter().zip(counts) {
            let found = rendering(&view, tolerance);
            let pixel = 30 * 61 + 30;
            let flux = found.values.pixels()[pixel] * solid_angles[pixel];
            assert!(found.converged() && found.estimated_error().unwrap() <= tolerance);
            let wrong = (flux / central - 1.0).abs();
            assert!(wrong < tolerance, "core {core} kpc at {tolerance}: {wrong}");
            assert_eq!(found.stats.evaluations, count, "core {core} kpc at {tolerance}");
        }
    }
}

#[test]
fn all_pixels_about_cusps_are_within_their_estimates() {
    let views = [
        (nfw_halo(0.0, Place::Corner), 3689),
        (power_law(1.0, Place::Centre), 2117),
        (power_law(2.3, Place::Corner), 2491),
        (comet(Place::Corner), 5112),
    ];
    for (view, count) in views {
        let found = rendering(&view, 1e-3);
        let error = true_error(&view, &found.values);
        assert!(found.converged(), "{}", view.name());
        assert!(error <= found.estimated_error().unwrap(), "{}: {error}", view.name());
        assert_eq!(found.stats.evaluations, count, "{}", view.name());
    }
}

#[test]
fn random_cusps_are_within_one_per_cent() {
    // One point and two, in and out of view, exponents from 0.5 to 2.4.
    for (seed, count) in [(0, 1969), (3, 20_758), (5, 2098), (7, 4103), (9, 6231)] {
        let view = random_cusps(seed);
        let found = rendering(&view, 1e-2);
        let error = true_error(&view, &found.values);
        assert!(found.converged() && error <= 1e-2, "{}: {error}", view.name());
        assert_eq!(found.stats.evaluations, count, "{}", view.name());
    }
}

/// g = exp(−ρ²) / ρ about an axis across parallel lines of sight. A line at the distance b has
/// ∫ exp(−b² cosh² t) dt, by the trapezium rule, which converges exponentially here.
fn radiance_beside_axis(b: f64) -> f64 {
    let most = (30.0 / b.abs().max(1e-30)).ln().max(2.0);
    let steps = 400;
    let at = |k: i32| (-(b * (most * f64::from(k) / f64::from(steps)).cosh()).powi(2)).exp();
    2.0 * most / f64::from(steps) * (0.5 * at(0) + (1..=steps).map(at).sum::<f64>())
}

/// The mean of that radiance over a pixel, given the distance of its middle from the axis and by how much it
/// changes from the middle to the sides, along both axes of the image.
fn mean_beside_axis(middle: f64, [a, b]: [f64; 2]) -> f64 {
    let (long, short) = (a.abs().max(b.abs()), a.abs().min(b.abs()));
    // The density of distances in the pixel is a trapezium with these corners.
    let density = |d: f64| {
        let away = (d - middle).abs();
        ((long + short - away) / (2.0 * short)).clamp(0.0, 1.0) / (2.0 * long)
    };
    let mut ends: Vec<f64> =
        [-long - short, short - long, long - short, long + short].map(|x| middle + x).to_vec();
    if ends[0] < 0.0 && ends[3] > 0.0 {
        ends.push(0.0);
    }
    ends.sort_by(f64::total_cmp);
    let part = |pair: &[f64]| {
        // The third power makes the logarithm on the axis smooth enough for midpoints.
        let (from, to) = (pair[0], pair[1]);
        let (base, length) =
            if from.abs() < to.abs() { (from, to - from) } else { (to, from - to) };
        let n = 400;
        let at = |k: i32| {
            let u = (f64::from(k) + 0.5) / f64::from(n);
            let d = base + length * u.powi(3);
            3.0 * u * u * radiance_beside_axis(d) * density(d)
        };
        length.abs() / f64::from(n) * (0..n).map(at).sum::<f64>()
    };
    ends.windows(2).filter(|pair| pair[1] > pair[0]).map(part).sum()
}

#[test]
fn an_axis_through_pixels_is_within_its_tolerance() {
    let (size, half) = (24_u32, 1.2);
    let whole = |k: u32| usize::try_from(k).unwrap();
    // The axis is inclined in the image, and through no corner.
    let angle = 0.4_f64;
    let direction = [angle.sin(), 0.0, angle.cos()];
    let offset = 0.033;
    let rate = |[x, y, z]: [f64; 3]| {
        let beside = x * angle.cos() - z * angle.sin() - offset;
        let squared = beside * beside + y * y;
        (-squared).exp() / squared.sqrt()
    };
    let position = [offset * angle.cos(), 0.0, -offset * angle.sin()];
    let axis = Singularity::axis(position, direction).unwrap();
    let viewpoint = Viewpoint { position: [0.0, -8.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
    let camera = Orthographic::new(viewpoint, [2.0 * half; 2], [0.0, 16.0]).unwrap();
    let camera = camera.with_singularities(vec![axis]);
    let pixel = 2.0 * half / f64::from(size);
    for (tolerance, count) in [(1e-2, 4355), (1e-3, 7123)] {
        let options = RenderOptions::new(VolOptions::new(tolerance));
        let emission = FromFn(|position, _| rate(position));
        let shape = [whole(size); 2];
        let found = render(&emission, &camera, shape, &options).unwrap();
        let (mut largest, mut wrong) = (0.0_f64, 0.0_f64);
        for row in 0..size {
            for column in 0..size {
                let [x, z] = [column, row].map(|k| (f64::from(k) + 0.5) * pixel - half);
                let middle = x * angle.cos() - z * angle.sin() - offset;
                let across = [0.5 * pixel * angle.cos(), 0.5 * pixel * angle.sin()];
                let exact = mean_beside_axis(middle, across);
                largest = largest.max(exact);
                let value = found.values.row(whole(row))[whole(column)];
                wrong = wrong.max((value - exact).abs());
            }
        }
        assert!(found.converged() && wrong <= tolerance * largest, "{tolerance}: {wrong}");
        assert_eq!(found.stats.evaluations, count, "{tolerance}");
    }
}

#[test]
fn an_undeclared_cusp_ends_at_the_finest_level_and_has_a_place() {
    // In the middle of the image, at which lines of sight are.
    let rate = |r: [f64; 3]| r.map(|x| x * x).iter().sum::<f64>().recip().min(1e30);
    let viewpoint = Viewpoint { position: [0.0, -8.0, 0.0], target: [0.0; 3], up: [0.0, 0.0, 1.0] };
    let camera = Orthographic::new(viewpoint, [2.0; 2], [0.0, 16.0]).unwrap();
    let emission = FromFn(|position, _| rate(position));
    let options = RenderOptions::new(VolOptions::new(1e-2)).with_max_evaluations(300_000);
    let found = render(&emission, &camera, [21, 21], &options).unwrap();
    assert!(!found.converged());
    let largest = found.stats.largest_rate.unwrap();
    assert!(largest.position.iter().all(|along| along.abs() < 1e-6));
    assert!(largest.rate.to_bits() == rate(largest.position).to_bits());
}
