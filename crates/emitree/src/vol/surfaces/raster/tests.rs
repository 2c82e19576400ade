//! Lattices of lines in a pixel.

use super::*;
use crate::vol::lattice;
use crate::vol::surfaces::octree::{Facet, Grid, Leaf, Octree};
use crate::vol::surfaces::patch::{FitPoint, Patch};
use crate::vol::surfaces::pieces::Pieces;

#[test]
fn each_line_of_a_lattice_has_its_own_row_and_column() {
    for count in LATTICES.into_iter().chain([CHECKS]) {
        let mut seen = vec![[false; 2]; count];
        for k in 0..count {
            for (axis, along) in fibonacci(k, count).into_iter().enumerate() {
                let place = along * count as f64 - 0.5;
                assert!((place - place.round()).abs() < 1e-9);
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "0 or more"
                )]
                let place = place.round() as usize;
                assert!(!core::mem::replace(&mut seen[place][axis], true));
            }
        }
    }
}

#[test]
fn a_limb_in_a_pixel_is_resolved() {
    // √x is the chord beside a limb.
    let mean = |count: usize| {
        (0..count).map(|k| fibonacci(k, count)[0].sqrt()).sum::<f64>() / count as f64
    };
    assert!((mean(89) - 2.0 / 3.0).abs() < 3e-4);
    assert!((mean(610) - 2.0 / 3.0).abs() < 2e-5);
}

#[test]
fn lattices_have_to_agree_one_after_another() {
    let line = |value: f64| LineIntegral { value, error: 0.1 };
    let mut settled = Settled { last: None, agreements: 0 };
    let values = [1.0, 1.01, 1.5, 1.49, 1.48];
    let agreements = values.map(|value| {
        settled.add(line(value), 0.02);
        settled.agreements
    });
    assert_eq!(agreements, [0, 1, 0, 1, 2]);
    let Some(last) = settled.last else { panic!("no mean") };
    assert!((last.value - 1.48).abs() < 1e-15 && (last.error - 0.105).abs() < 1e-12);
}

/// A flat surface in the unit cube, above which G is 1.
fn model(place: impl Fn([f64; 2]) -> [f64; 3], axis: usize, error: f64) -> Model {
    let grid = Grid { edges: [1.0; 3], base: [1; 3], finest: 2 };
    let point = |k: usize| {
        let [u, v, _] = lattice::point(k);
        FitPoint { at: place([u, v]), axis, is_upward: true, distance: 0.01 * k as f64 }
    };
    let points: Vec<FitPoint> = (0..16).map(point).collect();
    let normal = core::array::from_fn(|k| f64::from(u8::from(k == axis)));
    let fit = Patch::fit(&points, place([0.5; 2]), normal, 0.5, 0.0);
    let Some((patch, _)) = fit else { panic!("no patch") };
    let (below, above) = (0, 1);
    let facet = Facet { wall: patch.into(), below, above, error, allowed: error, jump: 1.0 };
    let tree = Octree::new(grid, vec![((0, [0; 3]), Leaf::Cut(vec![facet]))]);
    Model { tree, pieces: vec![None, Some(Pieces::constant(1.0))] }
}

fn aim(scale: &Image) -> Aim<'_> {
    Aim { target: 1e-2, scale, visible: None, sky: None, plane: None }
}

#[test]
fn rough_maps_have_the_errors_of_others() {
    let scale = Image::from_pixels(8, 8, vec![1.0; 64]);
    let aim = aim(&scale);
    // Below and above the share of the error allowed from which pixels have more lines.
    for error in [0.2, 0.8].map(|share| share * aim.target / TUNING.surfaces.crossing_margin) {
        let model = model(|[x, y]| [x, y, 0.3 + 0.2 * x], 2, error);
        let mut known = KnownLines::default();
        let rough = model.rough_maps(&aim, 1e-2, &mut known);
        let maps = model.maps(&aim, 1e-2, &mut known);
        for pixel in 0..64 {
            let [of_rough, all] = [&rough, &maps].map(|of| of.error.pixels()[pixel]);
            assert!((of_rough - all).abs() < 1e-9 && all > 0.9 * error, "{of_rough} {all}");
            let [of_rough, all] = [&rough, &maps].map(|of| of.image.pixels()[pixel]);
            assert!((of_rough - all).abs() < 1e-6, "{of_rough} {all}");
        }
    }
}

/// A plane that is parallel to the lines of sight, a twentieth of a pixel inside of the border of a pixel: none
/// of the first lines of the pixels is between them.
#[test]
fn an_edge_beside_the_border_of_a_pixel_is_seen() {
    let edge = 0.5 + 0.05 / 8.0;
    let model = model(|[y, z]| [edge, y, z], 0, 1e-6);
    let scale = Image::from_pixels(8, 8, vec![1.0; 64]);
    let aim = aim(&scale);
    let maps = model.maps(&aim, 1e-2, &mut KnownLines::default());
    for row in 0..8 {
        let found = maps.image[(row, 4)];
        assert!((found - 0.95).abs() < 5e-3, "{found}");
        assert!(maps.image[(row, 3)].abs() < 1e-12 && (maps.image[(row, 5)] - 1.0).abs() < 1e-12);
    }
}
