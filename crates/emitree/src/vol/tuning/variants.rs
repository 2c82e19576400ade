//! Constants that can be replaced while a program runs, for measurements of their influence.

use super::Tuning;
use core::ops::Deref;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The standard values, then two variants for each constant.
static VARIANTS: LazyLock<Vec<Tuning>> = LazyLock::new(|| {
    let standard = [Tuning::STANDARD];
    standard.into_iter().chain(Tuning::variants()).collect()
});
/// The number of the variant in use.
static SELECTED: AtomicUsize = AtomicUsize::new(0);

/// The constants in use.
#[derive(Debug)]
pub(crate) struct Selected;

/// The constants of this run.
pub(crate) static TUNING: Selected = Selected;

impl Deref for Selected {
    type Target = Tuning;

    fn deref(&self) -> &Tuning {
        &VARIANTS[SELECTED.load(Ordering::Relaxed)]
    }
}

/// An end of the range of a constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The lower end.
    Low,
    /// The upper end.
    High,
}

/// Sets a constant, given by its number among [`constants`](super::constants), to an end of its
/// range in all renderings from now on; `None` restores the standard values.
pub fn select(variant: Option<(usize, End)>) {
    let number = variant.map_or(0, |(constant, end)| {
        let ends = 2 * constant;
        1 + match end {
            End::Low => ends,
            End::High => ends + 1,
        }
    });
    SELECTED.store(number.min(VARIANTS.len() - 1), Ordering::Relaxed);
}
