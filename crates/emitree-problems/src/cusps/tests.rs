//! Reference images against closed forms and published numbers.

use super::cusp::Line;
use super::pixel::{Rules, Singularity};
use super::*;
use crate::gauss::Gauss;
use core::f64::consts::PI;
use emitree_models::build_model;

fn fine() -> Rules {
    Rules::new([13, 32, 12, 9], [13, 9, 6])
}

/// A line at a distance of a cusp at the origin.
fn line(b: f64) -> Line {
    Line { offset: [b, 0.0, 0.0], direction: [0.0, 1.0, 0.0], ends: [-4.0, f64::INFINITY] }
}

#[test]
fn lines_of_powers_are_those_of_closed_forms() {
    let rule = Gauss::new(13);
    for b in [1e-30_f64, 1e-12, 1e-5, 0.01, 0.3, 1.4] {
        let t = (9.0 - b * b).sqrt();
        for (gamma, exact) in [(1.0, 2.0 * (t / b).asinh()), (2.0, 2.0 / b * (t / b).atan())] {
            let found = power_law(gamma, Place::Centre).cusps[0].integral(&line(b), &rule);
            assert!((found / exact - 1.0).abs() < 1e-12, "{gamma}, {b}: {found:e}, {exact:e}");
        }
        // Without an end it is √π Γ((γ − 1)/2)/Γ(γ/2) b^(1 − γ); beyond it 2 ∫ t^−γ to lowest orders.
        if b < 1e-4 {
            for gamma in [1.5_f64, 2.3] {
                let gammas = libm::tgamma(0.5 * (gamma - 1.0)) / libm::tgamma(0.5 * gamma);
                let endless = PI.sqrt() * gammas * b.powf(1.0 - gamma);
                let exact = endless - 2.0 * 3.0_f64.powf(1.0 - gamma) / (gamma - 1.0);
                let found = power_law(gamma, Place::Centre).cusps[0].integral(&line(b), &rule);
                assert!((found / exact - 1.0).abs() < 1e-9, "{gamma}, {b}: {found:e}, {exact:e}");
            }
        }
    }
}

/// ∫∫ q^(1 − γ) over the square \[−h, h\]² is 8 ∫ h^(3 − γ)/(3 − γ) cos^(γ − 3) φ dφ from 0 to π/4, and
/// 8 h ln(1 + √2) for γ = 2.
#[test]
fn pixels_about_the_point_are_those_of_closed_forms() {
    let rules = fine();
    let angles = Gauss::new(20);
    for gamma in [0.5_f64, 1.0, 1.5, 2.0, 2.3, 2.4] {
        let singularity = Singularity { exponent: gamma, core: 0.0 };
        let power = |[x, y]: [f64; 2]| x.hypot(y).powf(1.0 - gamma);
        let integral = |low, high| Pixel { low, high }.integral(singularity, &rules, power);
        let octant = angles.integrate(0.0, PI / 4.0, |phi| phi.cos().powf(gamma - 3.0));
        let quarter = 2.0 * octant / (3.0 - gamma);
        let whole = integral([-1.0; 2], [1.0; 2]);
        assert!((whole / (4.0 * quarter) - 1.0).abs() < 1e-9, "{gamma}: {whole}");
        let corner = integral([0.0; 2], [1.0; 2]);
        assert!((corner / quarter - 1.0).abs() < 1e-9, "{gamma}: {corner}");
        // Parts of a square add up to it, wherever they meet.
        for [x, y] in [[0.3, -0.2], [1e-6, 0.5], [-1e-12, 0.0], [0.9, 0.95], [1e-3, 1e-3]] {
            let parts = integral([-1.0; 2], [x, y])
                + integral([x, -1.0], [1.0, y])
                + integral([-1.0, y], [x, 1.0])
                + integral([x, y], [1.0; 2]);
            assert!((parts / whole - 1.0).abs() < 1e-8, "{gamma}, {x}, {y}: {parts}, {whole}");
        }
    }
}

/// The numbers of the issue, GeV² cm⁻⁵ in the central pixel of 61 × 61: with s = √(r² + core²), and offsets
/// on the image plane as tangents, dΩ = dx dy.
#[test]
fn central_pixels_of_the_halo_are_the_known_ones() {
    for (core, expected) in [
        (0.0, "1.586246e20"),
        (1e-2, "3.1741864e19"),
        (1e-3, "1.2499728e20"),
        (1e-4, "1.5485101e20"),
        (1e-5, "1.5824306e20"),
    ] {
        let view = nfw_halo(core, Place::Centre);
        let central = view.pixel(30 * 61 + 30);
        let flat = Lens { kind: Kind::Tangent, ..view.lens };
        let seen = flat.seen([0.0; 3]);
        let singularity = Singularity { exponent: 2.0, core: core / seen.distance };
        let rules = fine();
        let found = central.integral(singularity, &rules, |offset| {
            view.cusps[0].integral(&flat.line(&seen, offset), &rules.line)
        });
        let digits = if core > 0.0 { 7 } else { 6 };
        assert_eq!(format!("{found:.digits$e}"), expected);
        // What the camera has differs by the curvature of its pixel.
        let reference = view.reference();
        let of_camera = reference.image[(30, 30)] * view.solid_angles()[30 * 61 + 30];
        assert!((of_camera / found - 1.0).abs() < 1e-7, "{core}: {of_camera:e}");
        assert!(reference.error < 1e-7, "{core}: {:e}", reference.error);
    }
}

/// The place in the corner of four pixels: they are the same, and hold what the point's surroundings do.
#[test]
fn four_pixels_about_a_corner_are_the_same() {
    let reference = nfw_halo(0.0, Place::Corner).reference();
    let image = &reference.image;
    let four = [image[(29, 29)], image[(29, 30)], image[(30, 29)], image[(30, 30)]];
    assert!(four.iter().all(|pixel| (pixel / four[0] - 1.0).abs() < 1e-10), "{four:?}");
    assert!((four[0] / image.min_max().1 - 1.0).abs() < 1e-12 && reference.error < 1e-7);
    // ∫∫ 1/q over [0, h]² is half of that over [−h/2, h/2]²·… to the curvature of the profile.
    let central = nfw_halo(0.0, Place::Centre).reference().image[(30, 30)];
    assert!((four[0] / central - 0.5).abs() < 0.01, "{}", four[0] / central);
}

#[test]
fn the_rate_of_the_halo_is_that_of_the_model() {
    for core in [0.0, 1e-3] {
        let view = nfw_halo(core, Place::Centre);
        let parameters = [
            ("local_density", 0.39),
            ("local_radius", 8.5),
            ("scale_radius", 20.0),
            ("outer_radius", 8.5),
            ("core_radius", core),
        ];
        let parameters = parameters.map(|(name, value)| (name.to_owned(), value)).into();
        let model = build_model("nfw", &parameters).unwrap();
        let points = [[1e-9, 0.0, 0.0], [0.0, 1e-3, 2e-3], [1.0, -2.0, 3.0], [6.0, 6.0, 6.0]];
        let mut rates = [0.0; 4];
        let samples = emitree::Samples::new(&points, &[[0.0, 1.0, 0.0]; 4]);
        emitree::Emission::emission_rates(&model, &samples, &mut rates).unwrap();
        for (point, rate) in points.iter().zip(rates) {
            let ours = view.rate(*point);
            assert!((ours - rate).abs() <= 1e-13 * rate, "{point:?}: {ours:e}, {rate:e}");
        }
    }
}

/// Pixels by many lines that are g at many places, in a perspective camera: away from the point, where
/// that is exact enough.
#[test]
fn lines_and_pixels_are_those_of_the_library() {
    for view in [comet(Place::Centre), random_cusps(1), random_cusps(2), random_cusps(5)] {
        let reference = view.reference();
        let [height, width] = view.shape();
        for (row, column) in [(1, 2), (height - 2, 3), (height / 2, 1), (5, width - 3)] {
            let (x, y) = ((column as f64) / width as f64, (row as f64) / height as f64);
            let rule = Gauss::new(5);
            let mut sums = [0.0; 2];
            rule.weigh(y, y + 1.0 / height as f64, |y, along| {
                rule.weigh(x, x + 1.0 / width as f64, |x, across| {
                    let line = Gauss::new(12).integrate_panels([0.0, 1.0], 120, |z| {
                        let at = view.camera().world_from_canonical([x, y, z]);
                        if at.path_per_depth > 0.0 {
                            at.path_per_depth * view.rate(at.position)
                        } else {
                            0.0
                        }
                    });
                    let density = view.camera().solid_angle_density([x, y]);
                    sums[0] += along * across * line * density;
                    sums[1] += along * across * density;
                });
            });
            let (found, expected) = (sums[0] / sums[1], reference.image[(row, column)]);
            let error = (found / expected - 1.0).abs();
            assert!(error < 1e-6, "{} {row} {column}: {found} {expected}", view.name());
        }
    }
}

#[test]
fn references_of_the_family_are_exact_enough() {
    for seed in [0, 3, 6, 14] {
        let view = random_cusps(seed);
        let reference = view.reference();
        assert!(reference.error < 1e-7, "{}: {:e}", view.name(), reference.error);
        assert!(reference.image.min_max().0 > 0.0);
    }
}

/// Points are in view and out of it, at centres and at corners, and anywhere.
#[test]
fn the_family_has_all_kinds_of_places() {
    let [mut centres, mut corners, mut elsewhere, mut outside] = [0; 4];
    for view in (0..100).map(random_cusps) {
        for seen in &view.seen {
            let in_pixels = [0, 1].map(|i| 16.0 * (seen.place[i] / view.lens.half[i] + 1.0));
            let off = |by: f64| {
                let far = |x: &f64| (x - by - (x - by).round()).abs() < 1e-9;
                in_pixels.iter().all(far)
            };
            let is_out = in_pixels.iter().any(|x| !(0.0..=32.0).contains(x));
            match (is_out, off(0.5), off(0.0)) {
                (true, ..) => outside += 1,
                (_, true, _) => centres += 1,
                (.., true) => corners += 1,
                _ => elsewhere += 1,
            }
        }
    }
    let counts = [centres, corners, elsewhere, outside];
    assert!(counts.iter().all(|&count| count > 20), "{counts:?}");
}
