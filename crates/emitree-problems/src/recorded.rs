//! Eq. (8) recorded and replayed: for what a tree costs beside the emission.

use crate::equation8;
use core::cell::{Cell, RefCell};
use core::convert::Infallible;
use core::hint::black_box;
use emitree::quadrature::{Integrand, Points};

/// Eq. (8), with its values stored in the order of their evaluation.
///
/// ```
/// use emitree::tree::{BuildOptions, build};
/// use emitree_problems::recorded::{Record, Replay};
///
/// let record = Record::default();
/// let tree = build(&record, [false; 3], &BuildOptions::default()).unwrap().tree;
/// let values = record.into_values();
/// assert_eq!(values.len(), tree.cells());
/// let again = build(&Replay::new(&values), [false; 3], &BuildOptions::default()).unwrap().tree;
/// assert_eq!(again.integral(), tree.integral());
/// ```
#[derive(Debug, Default)]
pub struct Record(RefCell<Vec<f64>>);

impl Record {
    /// The values, in the order of their evaluation.
    pub fn into_values(self) -> Vec<f64> {
        self.0.into_inner()
    }
}

impl Integrand<3> for Record {
    type Error = Infallible;

    fn evaluate(&self, points: Points<'_, 3>, values: &mut [f64]) -> Result<(), Infallible> {
        for (i, value) in values.iter_mut().enumerate() {
            *value = equation8::rate(points.at(i), equation8::ALPHA);
        }
        self.0.borrow_mut().extend_from_slice(values);
        Ok(())
    }
}

/// The values of a record, in place of the function.
#[derive(Debug)]
pub struct Replay<'a> {
    values: &'a [f64],
    used: Cell<usize>,
}

impl<'a> Replay<'a> {
    /// From the first value on.
    pub fn new(values: &'a [f64]) -> Self {
        Self { values, used: Cell::new(0) }
    }
}

impl Integrand<3> for Replay<'_> {
    type Error = Infallible;

    /// # Panics
    ///
    /// If more values are requested than were recorded.
    fn evaluate(&self, points: Points<'_, 3>, values: &mut [f64]) -> Result<(), Infallible> {
        let used = self.used.replace(self.used.get() + values.len());
        values.copy_from_slice(&self.values[used..][..values.len()]);
        // To make the points is a part of what a tree costs.
        for i in 0..points.len() {
            black_box(points.at(i));
        }
        Ok(())
    }
}
