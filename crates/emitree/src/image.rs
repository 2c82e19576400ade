//! The image: pixels in the one orientation that everything here uses.

/// An image or any other map with one value a pixel.
///
/// # Axis order and orientation
///
/// An image is an array of shape (height, width), stored row by row. Row 0 is the lowest y and
/// column 0 the lowest x of the canonical cube, as in FITS; x grows with the column and y with the
/// row. Seen from the observer, x points to the right and y points up. Only pictures for people
/// (PNG) are flipped, so that y points up on the screen.
///
/// ```
/// use emitree::Image;
///
/// let mut image = Image::zeros(2, 3);
/// image[(1, 2)] = 4.0; // row 1 (the upper), column 2 (the rightmost)
/// assert_eq!(image.pixels(), [0.0, 0.0, 0.0, 0.0, 0.0, 4.0]);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    height: usize,
    width: usize,
    pixels: Vec<f64>,
}

impl Image {
    /// An image of zeros, `height` rows of `width` pixels.
    pub fn zeros(height: usize, width: usize) -> Self {
        Self { height, width, pixels: vec![0.0; height * width] }
    }

    /// An image from its pixels, row after row, the lowest first.
    ///
    /// # Panics
    ///
    /// If there are not `height · width` pixels.
    pub fn from_pixels(height: usize, width: usize, pixels: Vec<f64>) -> Self {
        assert_eq!(pixels.len(), height * width, "one value for each of {height} x {width} pixels");
        Self { height, width, pixels }
    }

    /// The number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// The number of columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// All pixels, row after row, the lowest row first.
    pub fn pixels(&self) -> &[f64] {
        &self.pixels
    }

    /// All pixels, to be changed.
    pub fn pixels_mut(&mut self) -> &mut [f64] {
        &mut self.pixels
    }

    /// The rows, from the lowest y up.
    pub fn rows(&self) -> impl DoubleEndedIterator<Item = &[f64]> + ExactSizeIterator {
        self.pixels.chunks_exact(self.width.max(1))
    }

    /// Row `row`, from the lowest.
    ///
    /// # Panics
    ///
    /// If there is no such row.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.pixels[row * self.width..][..self.width]
    }

    /// Row `row`, to be changed.
    pub(crate) fn row_mut(&mut self, row: usize) -> &mut [f64] {
        &mut self.pixels[row * self.width..][..self.width]
    }

    /// Adds `factor` times another image of the same shape.
    pub(crate) fn add_scaled(&mut self, other: &Self, factor: f64) {
        for (pixel, other) in self.pixels.iter_mut().zip(&other.pixels) {
            *pixel += factor * other;
        }
    }

    /// Images of equal width one above the other, the lowest first.
    pub(crate) fn stacked<'a>(images: impl Iterator<Item = &'a Self>) -> Self {
        let mut stack = Self::zeros(0, 0);
        for image in images {
            stack.width = image.width;
            stack.height += image.height;
            stack.pixels.extend_from_slice(&image.pixels);
        }
        stack
    }

    /// Adds `factor` times an image of the same width to the rows from `first` on.
    pub(crate) fn add_rows(&mut self, first: usize, other: &Self, factor: f64) {
        let pixels = self.pixels[first * self.width..].iter_mut();
        pixels.zip(&other.pixels).for_each(|(pixel, other)| *pixel += factor * other);
    }

    /// The largest |pixel|, pixels that are not numbers left out.
    pub(crate) fn largest(&self) -> f64 {
        self.pixels.iter().fold(0.0, |largest: f64, pixel| largest.max(pixel.abs()))
    }

    /// The smallest and the largest pixel, pixels that are not numbers left out; (∞, −∞) if there
    /// are none.
    pub fn min_max(&self) -> (f64, f64) {
        let start = (f64::INFINITY, f64::NEG_INFINITY);
        self.pixels.iter().fold(start, |(low, high), &p| (low.min(p), high.max(p)))
    }

    /// The largest |difference| to another image of the same shape, in the unit of the pixels.
    ///
    /// # Panics
    ///
    /// If the shapes differ.
    pub fn max_difference(&self, other: &Self) -> f64 {
        assert_eq!((self.height, self.width), (other.height, other.width), "same shape");
        let pairs = self.pixels.iter().zip(&other.pixels);
        pairs.fold(0.0, |largest, (a, b)| f64::max(largest, (a - b).abs()))
    }
}

impl core::ops::Index<(usize, usize)> for Image {
    type Output = f64;

    fn index(&self, (row, column): (usize, usize)) -> &f64 {
        debug_assert!(column < self.width, "column {column} of {}", self.width);
        &self.pixels[row * self.width + column]
    }
}

impl core::ops::IndexMut<(usize, usize)> for Image {
    fn index_mut(&mut self, (row, column): (usize, usize)) -> &mut f64 {
        debug_assert!(column < self.width, "column {column} of {}", self.width);
        &mut self.pixels[row * self.width + column]
    }
}
