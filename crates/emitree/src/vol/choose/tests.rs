//! Options out of range, and the choice between the low-rank approximation and the image tree.

use super::*;
use crate::projection::Canonical;
use crate::vol::seeds::Seed;
use crate::vol::testing::{answered, meter};
use core::f64::consts::PI;

const WIDTH: f64 = 0.2;

fn blob([x, y, z]: [f64; 3]) -> f64 {
    let square = (x - 0.5).powi(2) + (y - 0.4).powi(2) + (z - 0.6).powi(2);
    (-square / (WIDTH * WIDTH)).exp()
}

fn made(
    allowed: u64,
    rate: impl Fn([f64; 3]) -> f64 + Sync,
    vol: &VolOptions,
) -> (Result<MethodOutput, MethodError>, u64) {
    let meter = meter(allowed);
    let tiles = [Tile { projection: &Canonical, shape: [16, 16], place: (0, 1) }];
    let made = answered(&meter, |at, _| rate(at), render(&meter, &tiles, None, vol));
    (made, meter.evaluations())
}

fn refused(vol: &VolOptions) -> Option<&'static str> {
    match checks::check(vol, [16, 16], None) {
        Ok(()) => None,
        Err(RenderError::Option(option)) => Some(option.name()),
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn a_tolerance_is_between_0_and_1() {
    for (tolerance, expected) in [
        (0.0, Some("tolerance")),
        (-0.1, Some("tolerance")),
        (1.0, Some("tolerance")),
        (f64::NAN, Some("tolerance")),
        (1e-300, None),
        (0.999, None),
    ] {
        assert_eq!(refused(&VolOptions { tolerance, ..VolOptions::default() }), expected);
    }
}

#[test]
fn a_base_level_is_between_2_and_7() {
    for (base_level, expected) in
        [(1, Some("base_level")), (2, None), (7, None), (8, Some("base_level"))]
    {
        assert_eq!(refused(&VolOptions { base_level, ..VolOptions::default() }), expected);
    }
}

#[test]
fn a_seed_without_a_size_ends_a_rendering_before_it_begins() {
    let seeds = vec![Seed { position: [0.5; 3], radius: 0.0 }];
    let (made, evaluations) = made(1_000_000, blob, &VolOptions { seeds, ..VolOptions::default() });
    assert!(matches!(made, Err(RenderError::Option(OptionError::SeedRadius { .. }))));
    assert_eq!(evaluations, 0);
}

#[test]
fn a_product_needs_no_image_tree() {
    let (made, evaluations) = made(1_000_000, blob, &VolOptions::default());
    let made = made.unwrap();
    assert_eq!(made.ending, StopReason::Complete);
    // One function along each axis, and the samples that confirm it: the initial sampling of a tree, and what
    // comes after it, would be at least 17³.
    assert!(evaluations < 17_u64.pow(3), "{evaluations}");
    let image = &made.cube.bands()[0];
    let sum: f64 = image.pixels().iter().sum::<f64>() / 256.0;
    let wanted = (WIDTH * PI.sqrt()).powi(3);
    assert!((sum / wanted - 1.0).abs() < 0.02, "{sum} {wanted}");
}

#[test]
fn emissions_with_jumps_are_left_to_the_image_tree() {
    let ball = |at: [f64; 3]| {
        let square: f64 = at.iter().map(|x| (x - 0.5).powi(2)).sum();
        if square < 0.09 { 1.0 } else { 0.0 }
    };
    let vol = VolOptions { tolerance: 0.1, ..VolOptions::default() };
    let (made, _) = made(1_000_000, ball, &vol);
    let made = made.unwrap();
    assert_eq!(made.ending, StopReason::Complete);
    let sum: f64 = made.cube.bands()[0].pixels().iter().sum::<f64>() / 256.0;
    let volume = 4.0 / 3.0 * PI * 0.027;
    assert!((sum / volume - 1.0).abs() < 0.05, "{sum} {volume}");
}

#[test]
fn a_budget_for_no_initial_sampling_is_an_error() {
    let (made, evaluations) = made(26, blob, &VolOptions::default());
    assert!(matches!(made, Err(RenderError::Budget { needed: 27, allowed: 26, .. })));
    assert_eq!(evaluations, 0);
}
