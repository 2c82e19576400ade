//! Memory: the estimate for a rendering; too much is an error before anything is allocated.

use crate::error::{OptionError, RenderError};
use crate::los::{LosOptions, Steps, adaptive};
use crate::options::{Method, RenderOptions};
use crate::quadrature::CellRule;
use crate::tree::{BuildOptions, sampled_level};
use crate::vol;

/// Memory that one cell of a tree takes while the tree is built, at the most, with its share of the
/// ghosts, of the tree without the last generation and of the evaluations that are kept.
///
/// Measured on trees of 10⁴ to 10⁷ cells (`tests/alloc.rs`), 24 to 34 bytes and 360 to 520, and
/// rounded up: a hash table that has just grown is larger. With an energy axis they are at most 39, and
/// 1010 to 1160: a cell of four dimensions has three times as many nodes, and what is measured for
/// each evaluation is at most 70.
fn bytes_per_cell(rule: CellRule, axes: usize) -> u64 {
    match (rule, axes) {
        (CellRule::Midpoint, _) => 64,
        (CellRule::Simpson, ..=3) => 640,
        (CellRule::Simpson, _) => 1536,
    }
}

/// Sampling counts the pixels of an axis in 24 bits.
const MAX_PIXELS_ALONG: usize = 1 << 24;
/// Numbers that the weights of a pixel's row or column take, with their bookkeeping.
const WEIGHTS_PER_PIXEL: u64 = 24;
/// Numbers for each pixel: the image, its error and what the latter is the difference of, and the
/// bytes of a file made of each.
const MAPS: u64 = 6;

/// How many evaluations a tree may make before it fills the memory allowed.
pub(crate) fn evaluations_in_memory(options: &RenderOptions<'_>) -> u64 {
    match options.method {
        // The most that an evaluation can take, whatever the dimensions.
        Method::Paper(BuildOptions { rule, .. }) => {
            options.max_memory_bytes / bytes_per_cell(rule, 3)
        }
        Method::Vol(_) => options.max_memory_bytes / vol::BYTES_PER_EVALUATION,
        Method::Los(_) => u64::MAX,
    }
}

/// An error if the rendering can't fit in memory, before anything is allocated.
///
/// With `bins` it is a cube, and a tree has an axis more.
pub(crate) fn check_size<E>(
    shape: [usize; 2],
    bins: Option<usize>,
    options: &RenderOptions<'_>,
) -> Result<(), RenderError<E>> {
    let [height, width] = shape;
    if height == 0 || width == 0 {
        return Err(RenderError::EmptyImage { height, width });
    }
    let refuse = |what: String, needed: u64| {
        let allowed = options.max_memory_bytes;
        if needed > allowed { Err(RenderError::TooLarge { what, needed, allowed }) } else { Ok(()) }
    };
    let longest = height.max(width);
    if longest > MAX_PIXELS_ALONG {
        let too_long = if longest == width { OptionError::Width } else { OptionError::Height };
        return Err(too_long(longest).into());
    }
    let (height, width) = (height as u64, width as u64);
    let number = size_of::<f64>() as u64;
    let voxels = height.saturating_mul(width).saturating_mul(bins.unwrap_or(1) as u64);
    let maps = |count: u64| voxels.saturating_mul(count);
    let needed = match options.method {
        Method::Paper(BuildOptions { base_level, .. }) => {
            let weights =
                (height + width + bins.unwrap_or(0) as u64).saturating_mul(WEIGHTS_PER_PIXEL);
            grid(base_level, shape, bins).saturating_add(weights).saturating_add(maps(MAPS))
        }
        Method::Vol(_) => {
            // Borders of pixels are weighted one axis at a time; all else is maps.
            let weights = (height + width).saturating_mul(WEIGHTS_PER_PIXEL);
            weights.saturating_add(maps(MAPS + vol::MAPS))
        }
        Method::Los(LosOptions { lines, steps }) => {
            let per_line = match steps {
                Steps::Fixed(_) => 1,
                Steps::Adaptive(_) => adaptive::BYTES_PER_LINE / number,
            };
            let of_lines = (lines as u64).saturating_mul(lines as u64).saturating_mul(per_line);
            height.saturating_mul(width).saturating_mul(of_lines).saturating_add(maps(MAPS))
        }
    };
    let what = match bins {
        None => format!("an image of {height} x {width} pixels (height x width)"),
        Some(bins) => {
            format!("a cube of {bins} x {height} x {width} voxels (bins x height x width)")
        }
    };
    refuse(what, needed.saturating_mul(number))?;
    if let Method::Paper(build_options) = options.method {
        let level = build_options.base_level;
        // Each base cell is split at once.
        let (cells, axes) = match bins {
            None => (build_options.base_cells::<3>().saturating_mul(8), 3),
            Some(_) => (build_options.base_cells::<4>().saturating_mul(16), 4),
        };
        refuse(
            format!("a base grid of level {level} (2^{level} cells along each axis, split once)"),
            cells.saturating_mul(bytes_per_cell(build_options.rule, axes)),
        )?;
    }
    Ok(())
}

/// The height and width of the largest image of the proportions of `shape` that fits in the memory allowed; of a cube
/// with so many bins.
pub(crate) fn largest_that_fits(
    shape: [usize; 2],
    bins: Option<usize>,
    options: &RenderOptions<'_>,
) -> [usize; 2] {
    let of_size =
        |share: f64| shape.map(|pixels| crate::cell::whole((pixels as f64 * share).floor()).max(1));
    let fits =
        |share: f64| check_size::<core::convert::Infallible>(of_size(share), bins, options).is_ok();
    if fits(1.0) {
        return shape;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if fits(middle) { low = middle } else { high = middle }
    }
    of_size(low)
}

/// The numbers that sampling takes besides what it makes: the grid of the tree, its cells no larger
/// than pixels along the axis that has the fewest, and half of it again while it is made; then the
/// same with the pixels of one axis after the other in place of its cells.
fn grid(base_level: u8, [height, width]: [usize; 2], bins: Option<usize>) -> u64 {
    let product =
        |factors: &[u64]| factors.iter().fold(1_u64, |product, &f| product.saturating_mul(f));
    let pixels = [width, height, bins.unwrap_or(usize::MAX)];
    let cells = 1_u64 << sampled_level(base_level.min(16), &pixels).min(24);
    let [width, height] = [width, height].map(|along| along as u64);
    // The grid itself, and the grid with the pixels of the axes before the last.
    let terms = match bins {
        None => [product(&[cells, cells]), product(&[cells, width]), 0],
        Some(_) => [
            product(&[cells, cells, cells]),
            product(&[cells, cells, width]),
            product(&[cells, width, height]),
        ],
    };
    terms.iter().fold(terms[0] / 2, |sum, &term| sum.saturating_add(term))
}
