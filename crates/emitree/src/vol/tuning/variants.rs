//! Constants that can be replaced while a program runs, for measurements of their influence.

use super::Tuning;
use core::ops::Deref;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The standard values, then two variants for each constant, then those of each [`Forced`] choice.
static VARIANTS: LazyLock<Vec<Tuning>> = LazyLock::new(|| {
    let standard = [Tuning::STANDARD];
    let of_constants = standard.into_iter().chain(Tuning::variants());
    of_constants.chain(Forced::ALL.map(Forced::tuning)).collect()
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

/// A choice of method `vol` that is made whatever the samples show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Forced {
    /// Image trees on all parts: no search for products.
    Trees,
    /// Products wherever the search ends with them, whatever a forecast expects.
    Products,
    /// The usual weights of the coordinates of depth, and depths of an image plane that are not stretched.
    UsualDepths,
    /// Weights and stretches fitted to samples wherever they reduce the mean square at all.
    FittedDepths,
    /// The image plane, whatever limbs are in view.
    Plane,
}

impl Forced {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Trees, Self::Products, Self::UsualDepths, Self::FittedDepths, Self::Plane];

    fn tuning(self) -> Tuning {
        let mut tuning = Tuning::STANDARD;
        match self {
            Self::Trees => tuning.lowrank.least_budget = u64::MAX,
            Self::Products => tuning.lowrank.first_forecast = f64::INFINITY,
            Self::UsualDepths => {
                tuning.view.least_gain = f64::INFINITY;
                tuning.view.least_stretch_gain = f64::INFINITY;
            }
            Self::FittedDepths => {
                tuning.view.least_gain = 1.0;
                tuning.view.least_stretch_gain = 1.0;
            }
            Self::Plane => {}
        }
        tuning
    }
}

/// Makes a choice in all renderings from now on; `None` restores the usual ones.
pub fn force(choice: Option<Forced>) {
    let first = VARIANTS.len() - Forced::ALL.len();
    let number = choice.and_then(|choice| Forced::ALL.iter().position(|of| *of == choice));
    SELECTED.store(number.map_or(0, |number| first + number), Ordering::Relaxed);
}

/// Whether views have no charts.
pub(crate) fn is_plane_forced() -> bool {
    SELECTED.load(Ordering::Relaxed) + 1 == VARIANTS.len()
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
