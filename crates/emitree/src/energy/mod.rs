//! The energy axis of a spectral cube: [`EnergyAxis`] with a
//! [`EnergyScale`](crate::EnergyScale), and the error of an axis that is none.

pub(crate) mod axis;

pub(crate) use axis::EnergyAxis;
pub use axis::EnergyError;
