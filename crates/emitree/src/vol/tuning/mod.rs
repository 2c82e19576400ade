//! The constants that decide accuracy and cost, in one table.
//!
//! Each has a reason and a range, the ends of which are the values at which its influence was
//! measured: half and twice the value where these make sense. `cargo xtask ablate` repeats the
//! measurement; its results are in `docs/results/tuning.md`. Lengths in steps, orders of stencils
//! and guards against rounding are constants of their modules.

mod values;

/// The constants of this build.
#[cfg(not(feature = "ablate"))]
pub(crate) const TUNING: values::Tuning = values::Tuning::STANDARD;

#[cfg(feature = "ablate")]
mod variants;
#[cfg(feature = "ablate")]
pub(crate) use variants::TUNING;
#[cfg(feature = "ablate")]
pub use variants::{End, select};

/// One constant of the engine, for measurements of its influence.
#[cfg(feature = "ablate")]
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// The names of its group and of the constant, as in `line.negligible`.
    pub name: String,
    /// The value.
    pub value: f64,
    /// The lower end of the range in which its influence is measured.
    pub low: f64,
    /// The upper end of that range.
    pub high: f64,
    /// What the constant is, and why it has its value.
    pub reason: String,
}

/// Declares the groups of constants, their standard values, and the list of all of them.
macro_rules! tuning {
    ($(
        $(#[doc = $about:literal])*
        $group:ident: $of_group:ident {
            $(
                $(#[doc = $reason:literal])*
                $name:ident: $number:ty = $value:literal, $low:literal..=$high:literal;
            )*
        }
    )*) => {
        /// All constants that decide accuracy and cost.
        #[derive(Clone, Debug)]
        pub(crate) struct Tuning {
            $( $(#[doc = $about])* pub(crate) $group: $of_group, )*
        }

        $(
            $(#[doc = $about])*
            #[derive(Clone, Debug)]
            pub(crate) struct $of_group {
                $( $(#[doc = $reason])* pub(crate) $name: $number, )*
            }
        )*

        impl Tuning {
            /// The values of every rendering.
            pub(crate) const STANDARD: Self = Self {
                $( $group: $of_group { $( $name: $value, )* }, )*
            };

            /// For each constant two variants of the standard values, with the lower and the upper
            /// end of its range, in the order of [`constants`].
            #[cfg(feature = "ablate")]
            pub(crate) fn variants() -> Vec<Self> {
                let mut variants = Vec::new();
                $( $( for end in [$low, $high] {
                    let mut variant = Self::STANDARD;
                    variant.$group.$name = end;
                    variants.push(variant);
                } )* )*
                variants
            }
        }

        /// All constants, group by group.
        #[cfg(feature = "ablate")]
        pub fn constants() -> Vec<super::Constant> {
            #[expect(trivial_numeric_casts, reason = "constants are of several types")]
            let constants = vec![ $( $( super::Constant {
                name: concat!(stringify!($group), ".", stringify!($name)).to_owned(),
                value: $value as f64,
                low: $low as f64,
                high: $high as f64,
                reason: concat!($($reason),*).trim().to_owned(),
            }, )* )* ];
            constants
        }
    };
}

use tuning;
#[cfg(feature = "ablate")]
pub use values::constants;
