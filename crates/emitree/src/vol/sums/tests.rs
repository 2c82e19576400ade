use super::functional::Functional;
use super::scattered::Distribution;
use crate::cube::Cube;
use crate::image::Image;
use crate::sums::{Region, Sum, SumKind};
use crate::tile::Tile;

const SHAPE: [usize; 2] = [12, 16];

fn solid_angles() -> Image {
    let [height, width] = SHAPE;
    Image::from_pixels(height, width, vec![0.25; height * width])
}

fn image(value: impl Fn(f64, f64) -> f64) -> Cube {
    let [height, width] = SHAPE;
    let pixel = |i: usize| value((i % width) as f64, (i / width) as f64);
    Cube::from_bands(vec![Image::from_pixels(
        height,
        width,
        (0..height * width).map(pixel).collect(),
    )])
}

#[test]
fn sums_means_and_fluxes_are_coefficients_of_pixels() {
    let weights = Region::rectangle([2.0, 3.0], [6.0, 5.0]).weights(SHAPE);
    let cube = image(|x, y| x + 100.0 * y);
    let value = |kind| {
        let sum = Sum::new("a", weights.clone()).with_kind(kind);
        let functional = Functional::new(0, &sum, &solid_angles(), None).unwrap();
        functional.value(&cube)
    };
    let sum = 8.0 * (3.5 + 350.0);
    assert!((value(SumKind::Sum) - sum).abs() < 1e-9);
    assert!((value(SumKind::Mean) - sum / 8.0).abs() < 1e-9);
    assert!((value(SumKind::Flux) - sum * 0.25).abs() < 1e-9);
}

#[test]
fn weighted_pairs_add_up_to_the_sum() {
    let weights = Region::circle([7.0, 6.0], 4.3).weights(SHAPE);
    let sum = Sum::new("a", weights);
    let functional = Functional::new(0, &sum, &solid_angles(), None).unwrap();
    let cube = image(|x, y| 1.0 + 0.1 * x + 0.05 * x * y);
    // Errors that draw places to one side.
    let errors = image(|x, _| x * x);
    for errors in [None, Some(&errors)] {
        let distribution = Distribution::new(&functional, errors);
        const PAIRS: usize = 4096;
        let of_pair = |i: usize| {
            let pair = distribution.pair(&functional, i);
            pair.weight * cube.bands()[0].pixels()[pair.voxel.pixel]
        };
        let mean = (0..PAIRS).map(of_pair).sum::<f64>() / PAIRS as f64;
        let value = functional.value(&cube);
        assert!((mean / value - 1.0).abs() < 2e-3, "{mean} {value}");
        let weight = |i: usize| distribution.pair(&functional, i).weight;
        let most = (0..PAIRS).map(weight).fold(0.0, f64::max);
        assert!(most <= 2.0 * functional.total() * (1.0 + 1e-12), "{most}");
    }
}

#[test]
fn quadratic_images_are_expected_exactly() {
    // The means of a quadratic function over pixels, with the curvature along x, y and both.
    let value = |x: f64, y: f64| 3.0 + x - 2.0 * y + 0.3 * x * x - 0.2 * y * y + 0.1 * x * y;
    let cube = image(|x, y| value(x + 0.5, y + 0.5) + (0.3 - 0.2) / 12.0);
    let projection = crate::projection::canonical::Canonical;
    let tile = Tile { projection: &projection, shape: SHAPE, place: (0, 1) };
    let sum = Sum::new("a", Region::circle([7.0, 6.0], 4.0).weights(SHAPE));
    let functional = Functional::new(0, &sum, &solid_angles(), None).unwrap();
    let distribution = Distribution::new(&functional, None);
    for i in 0..64 {
        let pair = distribution.pair(&functional, i);
        let [u, v, _] = pair.offset;
        let centre = [pair.voxel.pixel % SHAPE[1], pair.voxel.pixel / SHAPE[1]];
        let [x, y] = centre.map(|along| along as f64 + 0.5);
        let mean = 0.5 * (value(x + u, y + v) + value(x - u, y - v));
        assert!((pair.expected(&cube, &tile) - mean).abs() < 1e-12);
    }
}
