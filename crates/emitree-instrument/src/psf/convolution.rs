//! Convolution by the fast Fourier transform.
//!
//! The field is padded with zeros to the size of the field and the kernel together, so that the
//! transform's periodic copies never meet, and everything that leaves the field can be summed. Rows
//! are transformed as real numbers, then the columns of what comes out; between the two the spectrum
//! is kept column by column.

use super::PsfError;
use super::kernel::Kernel;
use core::fmt::{self, Debug, Formatter};
use emitree::Image;
use realfft::{ComplexToReal, FftError, RealFftPlanner, RealToComplex};
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;

/// The transforms of one size, and the spectrum of a kernel.
pub(super) struct Convolver {
    field: [usize; 2],
    padded: [usize; 2],
    origin: [usize; 2],
    beyond: f64,
    to_spectrum: Arc<dyn RealToComplex<f64>>,
    from_spectrum: Arc<dyn ComplexToReal<f64>>,
    columns_forward: Arc<dyn Fft<f64>>,
    columns_inverse: Arc<dyn Fft<f64>>,
    /// Divided by the number of pixels, as neither transform is.
    kernel: Vec<Complex<f64>>,
}

impl Debug for Convolver {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.debug_struct("Convolver")
            .field("field", &self.field)
            .field("padded", &self.padded)
            .finish_non_exhaustive()
    }
}

impl Convolver {
    pub(super) fn new(kernel: &Kernel, field: [usize; 2]) -> Result<Self, PsfError> {
        let [height, width] =
            [field[0] + kernel.image.height() - 1, field[1] + kernel.image.width() - 1]
                .map(transform_length);
        let mut rows = RealFftPlanner::new();
        let mut columns = FftPlanner::new();
        let mut convolver = Self {
            field,
            padded: [height, width],
            origin: kernel.origin,
            beyond: kernel.beyond,
            to_spectrum: rows.plan_fft_forward(width),
            from_spectrum: rows.plan_fft_inverse(width),
            columns_forward: columns.plan_fft_forward(height),
            columns_inverse: columns.plan_fft_inverse(height),
            kernel: Vec::new(),
        };
        let mut spectrum = convolver.spectrum(&kernel.image)?;
        let pixels = (height * width) as f64;
        spectrum.iter_mut().for_each(|mode| *mode /= pixels);
        convolver.kernel = spectrum;
        Ok(convolver)
    }

    /// Blurs a band, and returns the sum of what has left the field.
    pub(super) fn blur(&self, band: &mut Image) -> Result<f64, PsfError> {
        let mut spectrum = self.spectrum(band)?;
        for (mode, kernel) in spectrum.iter_mut().zip(&self.kernel) {
            *mode *= kernel;
        }
        self.columns_inverse.process(&mut spectrum);
        let before: f64 = crate::field::total(band);
        let clip = !band.pixels().iter().any(|&pixel| pixel < 0.0);

        let [height, _] = self.padded;
        let mut modes = self.from_spectrum.make_input_vec();
        let mut row = self.from_spectrum.make_output_vec();
        let mut scratch = self.from_spectrum.make_scratch_vec();
        let mut lost = before * self.beyond;
        for y in 0..height {
            for (x, mode) in modes.iter_mut().enumerate() {
                *mode = spectrum[x * height + y];
            }
            self.make_real(&mut modes);
            let inverse = &self.from_spectrum;
            inverse.process_with_scratch(&mut modes, &mut row, &mut scratch).map_err(failed)?;
            lost += self.take_row(band, y, &row, clip);
        }
        Ok(lost)
    }

    /// The transform of an image that is padded with zeros, column by column; NaN counts as 0.
    fn spectrum(&self, image: &Image) -> Result<Vec<Complex<f64>>, PsfError> {
        let [height, width] = self.padded;
        let mut spectrum = vec![Complex::default(); (width / 2 + 1) * height];
        let mut row = self.to_spectrum.make_input_vec();
        let mut modes = self.to_spectrum.make_output_vec();
        let mut scratch = self.to_spectrum.make_scratch_vec();
        for (y, pixels) in image.rows().enumerate() {
            row.fill(0.0);
            for (value, &pixel) in row.iter_mut().zip(pixels) {
                *value = if pixel.is_nan() { 0.0 } else { pixel };
            }
            let forward = &self.to_spectrum;
            forward.process_with_scratch(&mut row, &mut modes, &mut scratch).map_err(failed)?;
            for (x, mode) in modes.iter().enumerate() {
                spectrum[x * height + y] = *mode;
            }
        }
        self.columns_forward.process(&mut spectrum);
        Ok(spectrum)
    }

    /// The first mode of a real row has no imaginary part, nor has the last of an even number of
    /// pixels; rounding leaves one, which the transform would refuse.
    fn make_real(&self, modes: &mut [Complex<f64>]) {
        if let Some(first) = modes.first_mut() {
            first.im = 0.0;
        }
        if self.padded[1].is_multiple_of(2)
            && let Some(last) = modes.last_mut()
        {
            last.im = 0.0;
        }
    }

    /// Puts what is in the field of row `y` of the padded plane into the band; the rest is its sum.
    fn take_row(&self, band: &mut Image, y: usize, row: &[f64], clip: bool) -> f64 {
        let ([height, width], [top, left]) = (self.field, self.origin);
        let inside = y.checked_sub(top).filter(|&at| at < height);
        let Some(at) = inside else { return row.iter().sum() };
        let (before, rest) = row.split_at(left);
        let (within, after) = rest.split_at(width);
        let mut lost: f64 = before.iter().chain(after).sum();
        for (column, &value) in within.iter().enumerate() {
            let pixel = &mut band[(at, column)];
            if pixel.is_nan() {
                lost += value;
            } else {
                *pixel = if clip { value.max(0.0) } else { value };
            }
        }
        lost
    }
}

/// The shortest length from `least` on that has no prime factors but 2, 3 and 5, which transforms are
/// fast for.
fn transform_length(least: usize) -> usize {
    let smooth = |&length: &usize| {
        let mut rest = length;
        for factor in [2, 3, 5] {
            while rest.is_multiple_of(factor) {
                rest /= factor;
            }
        }
        rest == 1
    };
    // There is one at the next power of 2 at the latest.
    (least.max(1)..).find(smooth).unwrap_or(least)
}

fn failed(error: FftError) -> PsfError {
    PsfError::Transform(error.to_string())
}
