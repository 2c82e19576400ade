//! The heap memory that a piece of work takes.

use peakmem_alloc::{PeakMemAlloc, PeakMemAllocTrait};
use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};
use std::alloc::System;
use std::time::{Duration, Instant};

/// The allocator of the system with two counters: of allocations, and of the most bytes. It costs some
/// nanoseconds for each allocation.
#[global_allocator]
static HEAP: PeakMemAlloc<&'static StatsAlloc<System>> = PeakMemAlloc::new(&INSTRUMENTED_SYSTEM);

/// The memory that a piece of work took.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Taken {
    pub(crate) time: Duration,
    /// The most bytes that were taken at once, beside those taken before.
    pub(crate) peak_bytes: usize,
    /// Allocations, reallocations included.
    pub(crate) allocations: usize,
}

/// Does `work` and measures it.
pub(crate) fn measured<T>(work: impl FnOnce() -> T) -> (T, Taken) {
    let count = || {
        let stats = INSTRUMENTED_SYSTEM.stats();
        stats.allocations + stats.reallocations
    };
    HEAP.reset_peak_memory();
    let (before, start) = (count(), Instant::now());
    let result = work();
    let time = start.elapsed();
    let taken = Taken { time, peak_bytes: HEAP.get_peak_memory(), allocations: count() - before };
    (result, taken)
}

/// Memory that the machine has to give \[bytes\]: `None` where it is not known.
pub(crate) fn available_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes << 10)
}
