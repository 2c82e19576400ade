//! The memory that arrays may take, compared with their sizes before anything is allocated.

use super::error::GridReadError;
use super::request::GridRequest;
use crate::memory::available_memory_bytes;

/// Bytes of a value.
const VALUE: u64 = size_of::<f64>() as u64;

/// The memory that reading one array may take \[bytes\].
#[derive(Clone, Copy, Debug)]
pub(super) struct Budget(u64);

impl Budget {
    /// What the request allows, or else what the system has; no limit if neither is known.
    pub(super) fn of(request: &GridRequest) -> Self {
        Self(request.max_memory_bytes.or_else(available_memory_bytes).unwrap_or(u64::MAX))
    }

    /// The limit \[bytes\].
    #[cfg(feature = "hdf5")]
    pub(super) fn bytes(self) -> u64 {
        self.0
    }

    /// Refuses an array of this shape, a number of which takes `bytes_each` while it is read, beside
    /// `others` bytes.
    pub(super) fn check(
        self,
        shape: &[usize],
        bytes_each: u64,
        others: u64,
    ) -> Result<(), GridReadError> {
        let product = |product: u64, &length: &usize| product.saturating_mul(length as u64);
        let needed = shape.iter().fold(bytes_each, product).saturating_add(others);
        if needed > self.0 {
            let shape = shape.to_vec();
            return Err(GridReadError::TooLarge { shape, needed, allowed: self.0 });
        }
        Ok(())
    }

    /// Room for the values of an array of this shape, which takes `others` bytes besides.
    pub(super) fn reserve(self, shape: &[usize], others: u64) -> Result<Vec<f64>, GridReadError> {
        self.check(shape, VALUE, others)?;
        let mut values = Vec::new();
        // A product that has passed the check holds no more numbers than there are bytes.
        let count = shape.iter().fold(1, |product: usize, &length| product.saturating_mul(length));
        match values.try_reserve_exact(count) {
            Ok(()) => Ok(values),
            Err(_) => Err(GridReadError::TooLarge {
                shape: shape.to_vec(),
                needed: (count as u64).saturating_mul(VALUE).saturating_add(others),
                allowed: self.0,
            }),
        }
    }
}

/// What a value takes in the order of the file and in the order of a grid, if they differ.
pub(super) const TWO_ORDERS: u64 = 2 * VALUE;
