//! Memory: what a rendering would take, refused before anything is allocated.

use crate::error::RenderError;
use crate::los::{LosOptions, Steps, adaptive};
use crate::quadrature::CellRule;
use crate::render::{Method, RenderOptions};
use crate::tree::BuildOptions;
use crate::vol;

/// Memory that one cell of a tree takes while the tree is built, at the most, with its share of the
/// ghosts, of the tree without the last generation and of the evaluations that are kept.
///
/// Measured on trees of 10⁴ to 10⁶ cells (`tests/alloc.rs`), 33 to 47 bytes and 360 to 520, and
/// rounded up: a hash table that has just grown is larger.
fn bytes_per_cell(rule: CellRule) -> u64 {
    match rule {
        CellRule::Midpoint => 64,
        CellRule::Simpson => 640,
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
        Method::Paper(BuildOptions { rule, .. }) => options.max_memory_bytes / bytes_per_cell(rule),
        Method::Vol(_) => options.max_memory_bytes / vol::BYTES_PER_EVALUATION,
        Method::Los(_) => u64::MAX,
    }
}

/// Refuses what can't fit in memory, before anything is allocated.
pub(crate) fn check_size<E>(
    [height, width]: [usize; 2],
    bins: usize,
    options: &RenderOptions<'_>,
) -> Result<(), RenderError<E>> {
    if height == 0 || width == 0 {
        return Err(RenderError::EmptyImage { height, width });
    }
    let refuse = |what: String, needed: u64| {
        let allowed = options.max_memory_bytes;
        if needed > allowed { Err(RenderError::TooLarge { what, needed, allowed }) } else { Ok(()) }
    };
    let longest = height.max(width);
    if longest > MAX_PIXELS_ALONG {
        let name = if longest == width { "width" } else { "height" };
        let expected = "at most 2^24 pixels along an axis";
        return Err(RenderError::Option { name, value: longest.to_string(), expected });
    }
    let (height, width) = (height as u64, width as u64);
    let number = size_of::<f64>() as u64;
    let voxels = height.saturating_mul(width).saturating_mul(bins as u64);
    let maps = |count: u64| voxels.saturating_mul(count);
    let needed = match options.method {
        Method::Paper(BuildOptions { base_level, .. }) => {
            // The grid that the image is sampled from, its cells no larger than pixels along the
            // narrower axis, and half of it again while it is made; then that grid with the pixels
            // of one axis; then the weights of an axis; then maps.
            let level = u64::from(base_level.min(16));
            let cells = height.min(width).next_power_of_two().max(1 << level);
            let grid = cells.saturating_mul(cells.saturating_mul(3) / 2 + width);
            let weights = (height + width).saturating_mul(WEIGHTS_PER_PIXEL);
            grid.saturating_add(weights).saturating_add(maps(MAPS))
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
    let image = format!("an image of {height} x {width} pixels (height x width)");
    refuse(image, needed.saturating_mul(number))?;
    if let Method::Paper(build_options) = options.method {
        let level = build_options.base_level;
        // Each base cell is split at once.
        let cells = build_options.base_cells::<3>().saturating_mul(8);
        refuse(
            format!("a base grid of level {level} (2^{level} cells along each axis, split once)"),
            cells.saturating_mul(bytes_per_cell(build_options.rule)),
        )?;
    }
    Ok(())
}
