use super::*;
use emitree::projection::Region;

/// FNV-1a of all parameters of forty scenes: no seed may ever mean another scene.
#[test]
fn scenes_never_change() {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for seed in 0..40 {
        for byte in format!("{:?}", random_tail(seed)).bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    assert_eq!(hash, 0xb1b6_0bdf_014e_e9b5, "{hash:#x}");
}

/// The lines of the reference are those of the camera, whose code it does not share.
#[test]
fn lines_are_those_of_the_cameras() {
    for seed in 0..16 {
        let tail = random_tail(seed);
        let camera = tail.camera().unwrap();
        for xy in [[0.1, 0.7], [0.5, 0.5], [0.93, 0.2]] {
            assert_eq!(camera.view_geometry().unwrap().region(xy), Region::Sky);
            let (line, weight) = tail.view.line(xy);
            let (middle, _) = tail.view.line([0.5; 2]);
            let density = camera.solid_angle_density(xy) / camera.solid_angle_density([0.5; 2]);
            let weight_of_middle = tail.view.line([0.5; 2]).1;
            assert!((density - weight / weight_of_middle).abs() < 1e-12, "{}", tail.name());
            assert_eq!(middle.near.is_finite(), line.near.is_finite());
            for z in [0.2, 0.5, 0.8] {
                let point = camera.world_from_canonical([xy[0], xy[1], z]);
                let (_, square) = line.nearest(point.position);
                let scale = 1.0 + line::dot(point.position, point.position);
                assert!(square < 1e-12 * scale, "{} {square:e}", tail.name());
                let cosine = line::dot(point.direction, line.direction);
                // Samples have the direction of the light, towards the observer.
                assert!((cosine + 1.0).abs() < 1e-12, "{} {cosine}", tail.name());
            }
        }
    }
}

/// Line integrals against a million steps of the rate out to a distance beyond which all but the slowest
/// Line integrals against many steps of the rate out to s = sinh 12, and what a power has left beyond.
#[test]
fn line_integrals_agree_with_many_samples_of_the_rate() {
    const STEPS: u32 = 60_000;
    let rule = Gauss::new(11);
    for seed in 0..8 {
        let tail = random_tail(seed);
        let (line, _) = tail.view.line([0.3, 0.6]);
        let found = tail.glow.radiance(&line, &rule);
        // In u with s = sinh u about the origin of the line; far beyond, waves are under-sampled, but there
        // every step is as good as a random one, and little is left.
        let from = if line.near.is_finite() { 0.0 } else { -12.0 };
        let step = (12.0 - from) / f64::from(STEPS);
        let sum: f64 = (0..STEPS)
            .map(|i| {
                let u: f64 = from + (f64::from(i) + 0.5) * step;
                u.cosh() * tail.rate(line.at(u.sinh()))
            })
            .sum();
        let end = 12_f64.sinh();
        // What is beyond falls as a power between 1.5 and 3: its integral is s g/(p − 1).
        let last = |s: f64| {
            let power = -(tail.rate(line.at(2.0 * s)) / tail.rate(line.at(s))).log2();
            if (1.4..3.1).contains(&power) {
                s.abs() * tail.rate(line.at(s)) / (power - 1.0)
            } else {
                0.0
            }
        };
        let is_smooth = ["powers", "clumps"].contains(&tail.glow.name());
        let rest = if is_smooth {
            last(end) + if line.near.is_finite() { 0.0 } else { last(-end) }
        } else {
            0.0
        };
        let brute = sum * step + rest;
        // Waves beyond the cut are neglected by the sum: s^−1 of a few tenths.
        let slack = if is_smooth { 1e-6 } else { 2e-4 };
        assert!((found / brute - 1.0).abs() < slack, "{}: {found} {brute}", tail.name());
    }
}

/// One of each kind; the examples print the errors of all that they render.
#[test]
fn references_converge() {
    for seed in [0, 5, 10, 15] {
        let tail = random_tail(seed);
        let reference = tail.reference_image([8, 8]);
        assert!(reference.error < 1e-4, "{}: {:e}", tail.name(), reference.error);
        assert!(reference.image.min_max().0 > 0.0);
    }
}
