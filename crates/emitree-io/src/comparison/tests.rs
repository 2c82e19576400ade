//! Comparisons whose answers are counted by hand.

use super::*;
use std::path::Path;

fn image(values: &[f64]) -> StoredImage {
    StoredImage::new("a.npy", [1, 2, values.len() / 2], values.to_vec()).unwrap()
}

#[test]
fn the_largest_difference_has_a_place_and_two_values() {
    let mut cube = StoredImage::new("a.fits", [2, 1, 2], vec![1.0, -4.0, 2.0, 3.0]).unwrap();
    let other = StoredImage::new("b.fits", [2, 1, 2], vec![1.0, -4.0, 2.5, 2.0]).unwrap();
    let found = Comparison::of(&cube, &other).unwrap();
    assert_eq!(found.largest, Some(Difference { place: [1, 0, 1], first: 3.0, second: 2.0 }));
    assert_eq!((found.scale, found.compared, found.in_one_only), (4.0, 4, 0));
    assert_eq!((found.mean, found.rms), (-0.125, (1.25_f64 / 4.0).sqrt()));
    assert!(found.is_within(0.25) && !found.is_within(0.249));
    assert_eq!(found.beside_errors, None);
    cube.error = Some(vec![0.1, 0.1, 1.0, 0.5]);
    let beside = Comparison::of(&cube, &other).unwrap().beside_errors.unwrap();
    let expected = BesideErrors { maps: 1, largest: 2.0, place: [1, 0, 1], above: 1 };
    assert_eq!(beside, expected);
    let mut other = other;
    other.error = Some(vec![0.0, 0.0, 0.0, 0.5]);
    let beside = Comparison::of(&cube, &other).unwrap().beside_errors.unwrap();
    assert_eq!((beside.maps, beside.largest, beside.above), (2, 1.0, 0));
}

#[test]
fn pixels_that_are_no_numbers_are_counted_where_one_image_has_them() {
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    let a = image(&[nan, nan, inf, inf, 1.0, 2.0]);
    let b = image(&[nan, 1.0, inf, -inf, 1.0, 2.0]);
    let found = Comparison::of(&a, &b).unwrap();
    assert_eq!((found.compared, found.in_one_only), (2, 2));
    assert_eq!(found.first_in_one_only, Some([0, 0, 1]));
    assert!(!found.is_within(1.0) && found.rms == 0.0);
    let nothing = Comparison::of(&image(&[nan, nan]), &image(&[nan, nan])).unwrap();
    assert_eq!((nothing.largest, nothing.rms, nothing.scale), (None, 0.0, 0.0));
    assert!(nothing.is_within(0.0));
    // Relative to the second image where the first is 0.
    let found = Comparison::of(&image(&[0.0, 0.0]), &image(&[0.0, 2.0])).unwrap();
    assert_eq!((found.relative(found.largest.unwrap().amount()), found.compared), (1.0, 2));
}

#[test]
fn units_are_converted_and_others_refused() {
    let mut a = image(&[1.0, 2.0]);
    let mut b = image(&[100.0, 201.0]);
    (a.unit, b.unit) = (Some("W m-2".to_owned()), Some("W m-2".to_owned()));
    let same = Comparison::of(&a, &b).unwrap();
    assert_eq!((same.factor, same.unit.as_str()), (1.0, "W m-2"));
    (a.unit, b.unit) = (Some("m".to_owned()), Some("cm".to_owned()));
    a.error = Some(vec![0.0, 0.005]);
    b.error = Some(vec![0.0, 0.5]);
    let found = Comparison::of(&a, &b).unwrap();
    assert!((found.largest.unwrap().amount() - 0.01).abs() < 1e-12 && found.unit == "m");
    assert!((found.beside_errors.unwrap().largest - 1.0).abs() < 1e-9);
    b.unit = Some("s".to_owned());
    let error = Comparison::of(&a, &b).unwrap_err().to_string();
    let expected = "a.npy is in `m` and a.npy in `s`: expected units of one dimension";
    assert_eq!(error, expected);
    b.unit = None;
    assert_eq!(Comparison::of(&a, &b).unwrap().unit, "m");
}

#[test]
fn arrays_of_other_shapes_and_files_without_numbers_are_refused() {
    let error = Comparison::of(&image(&[1.0, 2.0]), &image(&[1.0; 4])).unwrap_err().to_string();
    let expected = "a.npy has 1 x 2 pixels (width x height) and a.npy 2 x 2 pixels (width x height): \
                    expected as many in both";
    assert_eq!(error, expected);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npy");
    let array = |shape: &[usize]| {
        let count = shape.iter().product();
        std::fs::write(&path, crate::encode_npy(shape, &vec![1.0; count]).unwrap()).unwrap();
        StoredImage::open(&path)
    };
    assert_eq!(array(&[5]).unwrap().shape, [1, 1, 5]);
    assert_eq!(array(&[2, 3]).unwrap().shape, [1, 2, 3]);
    assert_eq!(array(&[4, 2, 3]).unwrap().shape, [4, 2, 3]);
    let error = array(&[1, 1, 1, 2]).unwrap_err().to_string();
    assert!(error.ends_with("an array of shape [1, 1, 1, 2]: expected 1 to 3 axes with numbers"));
    let error = StoredImage::open(Path::new("a.png")).unwrap_err().to_string();
    assert_eq!(error, "a.png: expected an image with numbers, .fits, .fit or .npy");
    let error = StoredImage::open(&folder.path().join("none.npy")).unwrap_err().to_string();
    assert!(error.contains("none.npy: it can't be read: "), "{error}");
}

/// An array of `numpy` with `order="F"`: 2 rows of 3, stored column by column.
#[test]
fn arrays_in_the_order_of_columns_are_read_as_rows() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.npy");
    let mut bytes = crate::encode_npy(&[2, 3], &[0.0, 3.0, 1.0, 4.0, 2.0, 5.0]).unwrap();
    let at = bytes.windows(5).position(|word| word == b"False").unwrap();
    bytes.splice(at..at + 5, *b"True ");
    std::fs::write(&path, bytes).unwrap();
    let read = StoredImage::open(&path).unwrap();
    assert_eq!(read.values, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
}
