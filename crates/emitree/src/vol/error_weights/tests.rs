use super::*;
use crate::vol::PixelTolerance;
use crate::vol::dyadic::STEPS;
use crate::vol::testing::{assert_close, uniform};

const LARGEST: f64 = 8.0;

/// Four pixels, of which the last one belongs to no image.
fn image() -> Image {
    Image::from_pixels(1, 4, vec![LARGEST, -2.0, 0.0, 0.0])
}

/// The weights of these pixels for errors of 0.
fn weights(vol: &VolOptions) -> (f64, Option<Vec<f64>>) {
    let (image, none) = (image(), Image::zeros(1, 4));
    let found = ErrorWeights::new(vol, &[[&image, &none]], &[3]);
    (found.largest, found.maps.map(|maps| maps[0].pixels().to_vec()))
}

#[test]
fn without_options_all_weights_are_1_and_need_no_map() {
    assert_eq!(weights(&VolOptions::new(0.01)), (LARGEST, None));
}

#[test]
fn by_pixel_a_weight_is_the_error_of_the_brightest_over_that_allowed() {
    let by_pixel = PixelTolerance::relative(0.01).with_floor(1e-3);
    let vol = VolOptions::new(0.01).with_pixel_tolerance(by_pixel);
    let (largest, maps) = weights(&vol);
    assert_close(largest, LARGEST, 1e-15);
    for (weight, expected) in maps.unwrap().iter().zip([1.0, 4.0, 1e3, 0.0]) {
        assert_close(*weight, expected, 1e-9);
    }
    // No error may be larger than the loosest tolerance of the engine.
    let vol = VolOptions::new(0.01).with_pixel_tolerance(PixelTolerance::absolute(100.0));
    assert_close(weights(&vol).1.unwrap()[0], 0.01 / TUNING.engine.loosest_tolerance, 1e-12);
}

#[test]
fn a_pixel_with_an_error_larger_than_itself_is_taken_to_be_as_bright_as_that() {
    let by_pixel = PixelTolerance::relative(0.01).with_floor(1e-3);
    let vol = VolOptions::new(0.01).with_pixel_tolerance(by_pixel);
    let found = ErrorWeights::new(&vol, &[[&image(), &uniform([1, 4], 2.0)]], &[]);
    assert_close(found.maps.unwrap()[0].pixels()[2], 4.0, 1e-12);
    // In the end the values alone count: an error of 2 where 0.01 · 8 · 1e-3 is allowed.
    let [values, errors] = [image(), uniform([1, 4], 2.0)].map(|map| Cube::from_bands(vec![map]));
    assert_close(ErrorWeights::over_allowed(&vol, &values, &errors), 2.0 / 8e-5, 1e-6);
}

#[test]
fn pixels_of_weight_0_are_not_among_the_brightest() {
    let given = Image::from_pixels(1, 4, vec![0.0, 3.0, 1.0, 1.0]);
    let (largest, maps) = weights(&VolOptions::new(0.01).with_weights(given));
    assert_close(largest, 2.0, 1e-15);
    // Beside a pixel that matters, structure is resolved too.
    let beside = TUNING.engine.weight_beside * 3.0;
    assert_eq!(maps, Some(vec![beside, 3.0, 1.0, 0.0]));
}

#[test]
fn each_band_is_compared_with_its_own_largest_pixel() {
    let (bright, dark, none) = (image(), uniform([1, 4], 0.5), Image::zeros(1, 4));
    let vol = VolOptions::new(0.01).with_per_band(true);
    let found = ErrorWeights::new(&vol, &[[&bright, &none], [&dark, &none]], &[]);
    let maps = found.maps.as_ref().unwrap();
    assert_close(maps[0].pixels()[2], 1.0, 1e-12);
    assert_close(maps[1].pixels()[2], 16.0, 1e-12);
    // The error of a dark band counts for more.
    let error = uniform([1, 4], 0.01);
    assert_close(found.largest_error([&none, &error].into_iter()), 0.16, 1e-12);
    let over = |error: Image| {
        let values = Cube::from_bands(vec![bright.clone(), dark.clone()]);
        ErrorWeights::over_allowed(&vol, &values, &Cube::from_bands(vec![none.clone(), error]))
    };
    assert_close(over(error), 2.0, 1e-12);
    assert_close(over(none.clone()), 0.0, 1e-15);
}

#[test]
fn the_weight_around_a_place_is_the_largest_within_one_spacing() {
    let mut map = uniform([8, 8], 1.0);
    map.pixels_mut()[0] = 5.0; // row 0, column 0
    let squares = WeightsOfSquares::new(&map);
    let middle = [STEPS / 2; 2];
    // The spacing of level 1 reaches the corner, that of level 2 does not.
    assert_close(squares.around(middle, 1), 5.0, 1e-15);
    assert_close(squares.around(middle, 2), 1.0, 1e-15);
    assert_close(squares.around([0, 0], 20), 5.0, 1e-15);
    assert_close(squares.around([STEPS, STEPS], 20), 1.0, 1e-15);
    // Rows of another number than columns.
    let wide = WeightsOfSquares::new(&Image::from_pixels(1, 4, vec![1.0, 1.0, 1.0, 7.0]));
    assert_close(wide.around([STEPS, STEPS / 2], 2), 7.0, 1e-15);
    assert_close(wide.around([0, STEPS / 2], 2), 1.0, 1e-15);
}

#[test]
fn the_error_of_a_line_reaches_as_far_as_its_next_nodes() {
    let nodes = [([STEPS / 2; 2], 2, 3.0), ([0, 0], 2, 1.0)];
    let errors = errors_of_lines(nodes.into_iter(), [8, 8]);
    for (at, expected) in
        [((0, 0), 1.0), ((1, 1), 1.0), ((2, 2), 3.0), ((5, 5), 3.0), ((7, 7), 0.0), ((0, 2), 0.0)]
    {
        assert_close(errors[at], expected, 1e-15);
    }
}
