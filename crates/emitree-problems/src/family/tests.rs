use super::*;
use crate::{brute, relative_error};

/// FNV-1a of all parameters of a hundred scenes: no seed may ever mean another scene.
#[test]
fn scenes_never_change() {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for seed in 0..100 {
        for byte in format!("{:?}", random_scene(seed)).bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    assert_eq!(hash, 0x5e25_73e6_6b55_80bd, "{hash:#x}");
}

/// The mean of g over 5 × 5 × 5 points, for a scene of each kind.
#[test]
fn rates_never_change() {
    let expected = [
        0.002_562_670_250_639_547_3,
        0.099_190_410_175_126_34,
        0.018_667_020_326_837_94,
        0.004_651_855_973_612_378,
        0.027_387_795_599_794_13,
        0.073_510_326_530_066_06,
    ];
    for (seed, rate) in (0..).zip(expected) {
        let scene = random_scene(seed);
        let at = |i: u32| f64::from(i % 5) / 4.0;
        let rates = (0..125).map(|i| scene.rate([at(i), at(i / 5), at(i / 25)]));
        let found = rates.sum::<f64>() / 125.0;
        assert!((found - rate).abs() < 1e-13 * rate, "{seed}: {found:?}");
    }
}

#[test]
fn scenes_are_of_order_one_and_not_negative() {
    for seed in 0..60 {
        let scene = random_scene(seed);
        assert_eq!(scene, random_scene(seed));
        assert!((0.02..=0.5).contains(&scene.shortest_length()));
        let brightest = (0..20_000_u32).map(|i| {
            // A Kronecker sequence fills the cube evenly.
            let at = |step: f64| (f64::from(i) * step).fract();
            let rate = scene.rate([at(0.819_172_513), at(0.671_043_606), at(0.549_700_478)]);
            assert!(rate >= 0.0);
            rate
        });
        let brightest = brightest.fold(0.0, f64::max);
        assert!((0.005..6.0).contains(&brightest), "{}: {brightest}", scene.name());
    }
}

/// Two hundred of them: the estimate bounds the error and is below 1e-6.
#[test]
fn references_converge() {
    for seed in 0..200 {
        let scene = random_scene(seed);
        let reference = scene.reference_image([64, 64]);
        assert!(reference.error < 1e-6, "{}: {:e}", scene.name(), reference.error);
        let (low, high) = reference.image.min_max();
        assert!(low >= -reference.error * high, "{}: {low:e}", scene.name());
    }
}

/// Two of each kind against the finest rule, and a pixel of each against brute force.
#[test]
fn references_are_within_their_errors() {
    let shape = [48, 64];
    for seed in 0..12 {
        let scene = random_scene(seed);
        let Reference { image, error } = scene.reference_image(shape);
        let mut finest = Image::zeros(48, 64);
        for (amplitude, part) in &scene.parts {
            let part = part.image(shape, RESOLUTIONS[4]);
            for (sum, pixel) in finest.pixels_mut().iter_mut().zip(part.pixels()) {
                *sum += amplitude * pixel;
            }
        }
        assert!(relative_error(&image, &finest) < error, "{}", scene.name());
        let (_, largest) = image.min_max();
        let is_brightest = |&at: &usize| image.pixels()[at] >= largest;
        let brightest = (0..48 * 64).find(is_brightest).unwrap();
        for at in [[brightest / 64, brightest % 64], [14, 40], [30, 20]] {
            let brute = brute::pixel(|position| scene.rate(position), shape, at, 6);
            let far = (image[at.into()] - brute).abs() / largest;
            assert!(far < error + 1e-8, "{} {at:?}: {far:e} {error:e}", scene.name());
        }
    }
}

/// Few pixels are means of many.
#[test]
fn references_of_other_shapes_agree() {
    for seed in 6..12 {
        let scene = random_scene(seed);
        let many = scene.reference_image([30, 20]);
        let few = scene.reference_image([3, 2]);
        for row in 0..3 {
            for column in 0..2 {
                let inside =
                    (0..100).map(|i| many.image[(10 * row + i / 10, 10 * column + i % 10)]);
                let far = (inside.sum::<f64>() / 100.0 - few.image[(row, column)]).abs();
                assert!(far < 1e-6 * few.image.min_max().1, "{}: {far:e}", scene.name());
            }
        }
    }
}

/// The same for peaks, whose orientation and ridge are unlike those of most scenes.
#[test]
fn peaks_have_exact_images() {
    let shape = [48, 64];
    for seed in 0..6 {
        let scene = random_peak(seed);
        let Reference { image, error } = scene.reference_image(shape);
        assert!(error < 1e-6, "{}: {error:e}", scene.name());
        let (low, largest) = image.min_max();
        assert!(low > 0.0);
        let brightest = (0..48 * 64).find(|&at| image.pixels()[at] >= largest).unwrap();
        for at in [[brightest / 64, brightest % 64], [14, 40], [30, 20]] {
            let brute = brute::pixel(|position| scene.rate(position), shape, at, 6);
            let far = (image[at.into()] - brute).abs() / largest;
            assert!(far < error + 1e-8, "{} {at:?}: {far:e} {error:e}", scene.name());
        }
    }
}
