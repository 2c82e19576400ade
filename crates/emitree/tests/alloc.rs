//! Memory: no allocation per cell, and the bytes of a cell that `max_memory_bytes` counts with.
//!
//! A binary of its own with one test: the counters are those of the whole process.

use dhat::{HeapStats, Profiler};
use emitree::quadrature::{CellRule, Pointwise};
use emitree::refinement::Threshold;
use emitree::tree::{BuildOptions, build};
use emitree_problems::equation8;

#[global_allocator]
static ALLOCATOR: dhat::Alloc = dhat::Alloc;

/// What a tree of eq. (8) took.
#[derive(Debug)]
struct Taken {
    cells: usize,
    /// Allocations of the build, reallocations included, and of the projection.
    blocks: [u64; 2],
    /// The largest memory at any time, over the number of cells.
    bytes_per_cell: f64,
}

#[expect(clippy::unwrap_used, reason = "a helper of the test")]
fn taken(rule: CellRule, order: usize, base_level: u8, threshold: f64) -> Taken {
    let options = BuildOptions::new(Threshold::Absolute(threshold))
        .with_order(order)
        .with_base_level(base_level)
        .with_rule(rule);
    let emission = Pointwise(|u| equation8::rate(u, equation8::ALPHA));
    let _profiler = Profiler::builder().testing().build();
    let start = HeapStats::get();
    let tree = build(&emission, [false; 3], &options).unwrap().tree;
    let built = HeapStats::get();
    tree.project::<2>(2);
    let projected = HeapStats::get();
    Taken {
        cells: tree.cells(),
        blocks: [
            built.total_blocks - start.total_blocks,
            projected.total_blocks - built.total_blocks,
        ],
        bytes_per_cell: projected.max_bytes as f64 / tree.cells() as f64,
    }
}

#[test]
fn memory_is_taken_in_few_blocks_and_few_bytes_a_cell() {
    use CellRule::{Midpoint, Simpson};
    // Rule, order, base level, threshold; the cells that they make, and the most bytes a cell.
    let trees = [
        // More and more cells.
        (Midpoint, 3, 3, 0.02, 11_328, 36.0),
        (Midpoint, 3, 3, 0.002_4, 97_856, 36.0),
        (Midpoint, 3, 3, 0.000_35, 982_144, 36.0),
        (Midpoint, 3, 3, 0.000_066, 10_364_928, 36.0),
        // The most ghosts.
        (Midpoint, 9, 3, 0.02, 21_696, 36.0),
        // A base grid, split once.
        (Midpoint, 3, 5, 1e3, 294_912, 36.0),
        // Evaluations that are kept to be used again.
        (Simpson, 3, 3, 0.02, 8_768, 540.0),
        (Simpson, 3, 4, 1e3, 36_864, 540.0),
    ];
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    for (rule, order, base_level, threshold, cells, most_bytes) in trees {
        let taken = pool.install(|| taken(rule, order, base_level, threshold));
        assert_eq!(taken.cells, cells);
        // Some for each level and each of its ghosts' levels.
        assert!(taken.blocks.iter().all(|&blocks| blocks < 1_500), "{taken:?}");
        assert!(taken.bytes_per_cell < most_bytes, "{taken:?}");
    }
}
