use super::*;
use crate::field::total;
use core::f64::consts::LN_2;
use proptest::prelude::*;

fn blurred(psf: &Psf, band: &Image) -> (Image, f64) {
    let blurred = psf.blur(Cube::from_bands(vec![band.clone()])).unwrap();
    (blurred.photons.bands()[0].clone(), blurred.lost[0])
}

/// A band without symmetry.
fn bumpy(height: usize, width: usize) -> Image {
    let pixel = |n: usize| (n as f64 * 0.618).fract() * 10.0;
    Image::from_pixels(height, width, (0..height * width).map(pixel).collect())
}

/// Convolution as it is defined, and what leaves the field.
fn direct(kernel: &Image, band: &Image) -> (Image, f64) {
    let mut sum = Image::zeros(band.height(), band.width());
    let mut lost = 0.0;
    let kernel_sum: f64 = kernel.pixels().iter().sum();
    for (index, photons) in band.pixels().iter().enumerate().filter(|(_, p)| !p.is_nan()) {
        for (at, value) in kernel.pixels().iter().enumerate() {
            let place = |index: usize, at: usize, half: usize| (index + at).checked_sub(half);
            let row = place(index / band.width(), at / kernel.width(), kernel.height() / 2);
            let column = place(index % band.width(), at % kernel.width(), kernel.width() / 2);
            let moved = photons * value / kernel_sum;
            match (row, column) {
                (Some(row), Some(column))
                    if row < band.height()
                        && column < band.width()
                        && !band[(row, column)].is_nan() =>
                {
                    sum[(row, column)] += moved;
                }
                _ => lost += moved,
            }
        }
    }
    (sum, lost)
}

#[test]
fn a_kernel_of_one_pixel_changes_nothing() {
    for (height, width) in [(1, 1), (1, 7), (16, 9), (31, 32)] {
        let band = bumpy(height, width);
        for psf in [
            Psf::gaussian([0.0, 0.0]).unwrap(),
            Psf::from_kernel(&Image::from_pixels(1, 1, vec![3.0])).unwrap(),
        ] {
            let (image, lost) = blurred(&psf, &band);
            assert!(image.max_difference(&band) < 1e-14, "{height} x {width}");
            assert!(lost.abs() < 1e-13, "{lost}");
        }
    }
}

/// The pixels are means of the Gaussian over pixels, by the error function, but for the 4·10⁻⁹ of it
/// that is cut off.
#[test]
fn a_point_becomes_the_means_of_a_gaussian() {
    let mut point = Image::zeros(41, 61);
    point[(20, 30)] = 1.0;
    let fwhm = [5.0, 3.0_f64];
    let (image, lost) = blurred(&Psf::gaussian(fwhm).unwrap(), &point);
    let mean = |distance: f64, fwhm: f64| {
        let border = |at: f64| libm::erf(at * 2.0 * LN_2.sqrt() / fwhm);
        0.5 * (border(distance + 0.5) - border(distance - 0.5))
    };
    for row in 0..41 {
        for column in 0..61 {
            let (x, y) = (column as f64 - 30.0, row as f64 - 20.0);
            let expected = mean(x, fwhm[0]) * mean(y, fwhm[1]);
            assert!((image[(row, column)] - expected).abs() < 5e-9 * mean(0.0, 5.0), "{x} {y}");
        }
    }
    assert!(lost.abs() < 1e-15, "{lost}");
    // Half of the height at half of the width, by the definition.
    let round = Psf::gaussian_angular(0.02, [0.001, 0.002]).unwrap();
    assert_eq!(round, Psf::gaussian([20.0, 10.0]).unwrap());
}

#[test]
#[expect(clippy::float_cmp, reason = "the sum in the same order")]
fn kernels_of_any_shape_are_convolved_as_defined() {
    for (rows, columns) in [(1, 2), (3, 3), (4, 5), (2, 8), (30, 3), (25, 25)] {
        let kernel = bumpy(rows, columns);
        let psf = Psf::from_kernel(&kernel).unwrap();
        assert_eq!(psf.kernel_sum(), kernel.pixels().iter().sum::<f64>());
        for (height, width) in [(1, 1), (6, 11), (12, 5)] {
            let mut band = bumpy(height, width);
            band[(0, width - 1)] = f64::NAN;
            let (image, lost) = blurred(&psf, &band);
            let (expected, expected_lost) = direct(&kernel, &band);
            assert!(image[(0, width - 1)].is_nan());
            let difference = image
                .pixels()
                .iter()
                .zip(expected.pixels())
                .filter(|(pixel, _)| !pixel.is_nan())
                .fold(0.0, |largest: f64, (a, b)| largest.max((a - b).abs()));
            let case = format!("{rows} x {columns} on {height} x {width}");
            assert!(difference < 1e-13, "{case}: {difference}");
            assert!((lost - expected_lost).abs() < 1e-11, "{case}: {lost} {expected_lost}");
        }
    }
}

/// A wide Gaussian on a narrow field: most of it is cut off, and all is accounted for.
#[test]
fn nothing_wraps_around() {
    let mut corner = Image::zeros(8, 8);
    corner[(0, 0)] = 1.0;
    let (image, lost) = blurred(&Psf::gaussian([1.0, 1.0]).unwrap(), &corner);
    assert!(image[(7, 7)] < 1e-16 && image[(0, 7)] < 1e-16, "{}", image[(7, 7)]);
    // The quarter plane and the strips of half a pixel beside it: ((1 + erf(√ln 2)) / 2)².
    let along = 0.5 * (1.0 + libm::erf(LN_2.sqrt()));
    assert!((total(&image) - along * along).abs() < 1e-8, "{}", total(&image));
    assert!((lost - (1.0 - along * along)).abs() < 1e-8);
    let (image, lost) = blurred(&Psf::gaussian([1e4, 1e4]).unwrap(), &corner);
    assert!(total(&image) < 1e-5 && (lost + total(&image) - 1.0).abs() < 1e-12);
}

#[test]
#[expect(clippy::float_cmp, reason = "the sum in the same order")]
fn rounding_makes_no_negative_photons() {
    let mut band = Image::zeros(64, 64);
    band[(10, 50)] = 1e9;
    let (image, _) = blurred(&Psf::gaussian([4.0, 4.0]).unwrap(), &band);
    assert_eq!(image.min_max().0, 0.0);
    // Where there were some before, they are blurred as all is.
    band[(40, 20)] = -1e6;
    let (image, lost) = blurred(&Psf::gaussian([4.0, 4.0]).unwrap(), &band);
    assert!(image[(40, 20)] < -1e4);
    assert!((total(&image) + lost - (1e9 - 1e6)).abs() < 1e-4);
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    let cube = Cube::from_bands((0..6).map(|n| bumpy(20 + n / 9, 31)).collect());
    let psf = Psf::gaussian([3.0, 2.0]).unwrap();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let blurred = pool.install(|| psf.blur(cube.clone()).unwrap());
        blurred.photons.voxels().chain(blurred.lost).map(f64::to_bits).collect::<Vec<_>>()
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn kernels_that_can_not_be_are_refused_by_name() {
    let text = |result: Result<Psf, PsfError>| result.unwrap_err().to_string();
    assert_eq!(
        text(Psf::gaussian([1.0, -2.0])),
        "the full width at half maximum along y is -2 pixels: expected 0 to 100000"
    );
    assert!(text(Psf::gaussian([f64::NAN, 1.0])).contains("along x is NaN"));
    assert_eq!(
        text(Psf::gaussian_angular(0.1, [0.01, 0.0])),
        "a pixel is 0 rad along y: expected a finite number above 0"
    );
    assert_eq!(
        text(Psf::from_kernel(&Image::from_pixels(1, 3, vec![1.0, 2.0, -1.0]))),
        "the kernel is -1 at row 0, column 2: expected a finite number, 0 or more"
    );
    assert_eq!(
        text(Psf::from_kernel(&Image::zeros(2, 3))),
        "the 2 x 3 pixels (height x width) of the kernel have the sum 0: expected a finite number \
         above 0"
    );
    let infinite = Cube::from_bands(vec![Image::from_pixels(1, 2, vec![0.0, f64::INFINITY])]);
    assert_eq!(
        Psf::gaussian([1.0, 1.0]).unwrap().blur(infinite).unwrap_err().to_string(),
        "the photons in bin 0 at row 0, column 1 are inf: expected a finite number, or NaN outside \
         of the field"
    );
}

#[test]
fn a_kernel_is_read_from_fits() {
    use fits_well::FitsWriter;
    use fits_well::image::{Image as FitsImage, Scaling};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("kernel.fits");
    let write = |shape: Vec<usize>, pixels: Vec<f32>| {
        let image = FitsImage::new(shape, pixels, Scaling::IDENTITY).unwrap();
        let mut writer = FitsWriter::new(Vec::new());
        writer.write_image(image.view(), None).unwrap();
        std::fs::write(&path, writer.into_inner()).unwrap();
    };
    write(vec![3, 2], vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    let kernel = Image::from_pixels(2, 3, vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    assert_eq!(Psf::read_kernel(&path).unwrap(), Psf::from_kernel(&kernel).unwrap());

    let text = || Psf::read_kernel(&path).unwrap_err().to_string();
    let named = format!("the point-spread function {}: ", path.display());
    write(vec![3, 2, 1], vec![1.0; 6]);
    let axes = "its first image has the axes [3, 2, 1] (NAXIS1 first): expected two";
    assert_eq!(text(), format!("{named}{axes}"));
    std::fs::write(&path, "plain text").unwrap();
    assert!(text().starts_with(&format!("{named}it can't be read as FITS: ")), "{}", text());
    std::fs::remove_file(&path).unwrap();
    assert!(text().starts_with(&format!("{named}it can't be read: ")), "{}", text());
}

proptest! {
    #[test]
    fn photons_are_conserved(
        height in 1..24_usize,
        width in 1..24_usize,
        fwhm in [0.0..12.0_f64, 0.0..12.0_f64],
        none in 0..600_usize,
    ) {
        let mut band = bumpy(height, width);
        if let Some(pixel) = band.pixels_mut().get_mut(none) {
            *pixel = f64::NAN;
        }
        let (image, lost) = blurred(&Psf::gaussian(fwhm).unwrap(), &band);
        let before = total(&band);
        prop_assert!((total(&image) + lost - before).abs() < 1e-11 * (1.0 + before));
        prop_assert!(image.pixels().iter().all(|&pixel| pixel.is_nan() || pixel >= 0.0));
    }
}
