//! The nodes and depths that seeds require, in the unit cube.

use super::*;
use crate::exchange::MethodError;
use crate::vol::dyadic::STEPS;
use crate::vol::testing::{PANE, at};

fn seed(position: [f64; 3], radius: f64) -> Seed {
    Seed { position, radius }
}

fn targets(seeds: &[Seed]) -> SeedTargets {
    SeedTargets::at(seeds, &PANE, 3, 10)
}

/// The places of a level that no coarser one has.
fn on_level(targets: &SeedTargets, level: u8) -> usize {
    use crate::vol::image::tree::level_of_place;
    targets.places.iter().filter(|place| level_of_place(**place) == level).count()
}

#[test]
fn a_seed_in_the_middle_of_a_cell_has_the_cell_and_its_neighbours_on_each_level() {
    // In the middle of a cell of level 5, a quarter into those of level 4.
    let targets = targets(&[seed([17.0 / 64.0, 17.0 / 64.0, 0.5], 1.0 / 32.0)]);
    assert!(targets.places.iter().all(|[x, y]| x.max(y) <= &(STEPS / 2)));
    for level in [4, 5] {
        let corner = (17 << level) / 64;
        for column in corner - 1..=corner + 2 {
            for row in corner - 1..=corner + 2 {
                assert!(targets.places.contains(&at(level, column, row)), "{level} {column} {row}");
            }
        }
    }
    // 4 × 4 places around each cell, of which 2 × 2 are on the coarser lattice.
    assert_eq!([4, 5, 6].map(|level| on_level(&targets, level)), [12, 12, 0]);
    assert!(!targets.are_none());
}

#[test]
fn the_radius_decides_how_fine_nodes_are_up_to_the_finest_level() {
    let middle = [0.3, 0.3, 0.3];
    let finest = |radius: f64| {
        let targets = targets(&[seed(middle, radius)]);
        (0..20).rev().find(|&level| on_level(&targets, level) > 0)
    };
    assert_eq!(finest(1.0 / 8.0), None);
    assert_eq!(finest(0.999 / 8.0), Some(4));
    assert_eq!(finest(1.0 / 128.0), Some(7));
    assert_eq!(finest(1e-6), Some(10));
    assert!(targets(&[seed(middle, 1.0 / 8.0)]).are_none());
}

#[test]
fn depths_around_a_seed_are_sampled_on_the_lines_near_it() {
    let targets = targets(&[seed([0.5, 0.5, 0.3], 1.0 / 32.0)]);
    let mut expected: Vec<u32> = (0..=5)
        .flat_map(|level| {
            let below = (3 << level) / 10;
            [below, below + 1].map(|k| k * spacing(level))
        })
        .collect();
    expected.sort_unstable();
    expected.dedup();
    assert_eq!(targets.depths(at(1, 1, 1)), expected);
    // Two radii along x and along y.
    assert_eq!(targets.depths(at(4, 9, 7)), expected);
    for far in [at(5, 19, 16), at(5, 16, 13), at(0, 0, 0)] {
        assert!(targets.depths(far).is_empty(), "{far:?}");
    }
}

#[test]
fn seeds_outside_the_view_require_nothing() {
    let outside = [[1.2, 0.5, 0.5], [0.5, -0.2, 0.5], [0.5, 0.5, 1.2]];
    for position in outside {
        assert!(targets(&[seed(position, 0.1)]).are_none(), "{position:?}");
        assert!(!targets(&[seed(position, 0.05), seed([0.5; 3], 0.05)]).are_none());
    }
    // Its rim is in view.
    assert!(!targets(&[seed([1.02, 0.5, 0.5], 0.05)]).are_none());
}

#[test]
fn a_failed_line_of_a_verification_adds_places_and_depths_around_it() {
    let mut targets = SeedTargets::default();
    let place = at(5, 9, 9);
    targets.add_depths_around(place, 5, &[3, 7]);
    assert_eq!(targets.places.len(), 16);
    assert!(targets.places.windows(2).all(|two| two[0] < two[1]));
    assert!(targets.places.contains(&place));
    // Within two spacings.
    assert_eq!(targets.depths(at(5, 11, 7)), [3, 7]);
    assert!(targets.depths(at(5, 12, 9)).is_empty());
    targets.add_depths_around(place, 5, &[5]);
    assert_eq!((targets.places.len(), targets.depths(place)), (16, vec![3, 5, 7]));
}

#[test]
fn a_seed_without_a_place_or_a_size_is_refused() {
    let name = |seed: Seed| match check_seeds(&[self::seed([0.0; 3], 1.0), seed]) {
        Ok(()) => None,
        Err(RenderError::Option(option)) => Some(option.name()),
        Err::<(), MethodError>(error) => panic!("{error}"),
    };
    assert_eq!(name(seed([0.0; 3], 1e-9)), None);
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(name(seed([0.0; 3], radius)), Some("seed.radius"));
    }
    assert_eq!(name(seed([0.0, f64::NAN, 0.0], 1.0)), Some("seed.position"));
}
