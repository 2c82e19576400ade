//! The constants that decide accuracy and cost, in one table.
//!
//! Each has a reason and a range, the ends of which are the values at which its influence was
//! measured: half and twice the value where these make sense. `cargo xtask ablate` repeats the
//! measurement; its results are in `docs/results/tuning.md`. Lengths in steps, orders of stencils
//! and guards against rounding are constants of their modules.
//!
//! T is the tolerance, relative to the largest |pixel|. Depths and widths of lines are fractions of the
//! line, distances in the image plane fractions of its edge. Levels are those of dyadic lattices: one
//! level finer halves the spacing.

/// Declares a group of constants: its type, the standard values, and what measurements need.
macro_rules! group {
    (
        $(#[doc = $about:literal])*
        $group:ident {
            $(
                $(#[doc = $reason:literal])*
                $name:ident: $number:ty = $value:literal, $low:literal..=$high:literal;
            )*
        }
    ) => {
        $(#[doc = $about])*
        #[derive(Clone, Debug)]
        pub(crate) struct $group {
            $( $(#[doc = $reason])* pub(crate) $name: $number, )*
        }

        impl $group {
            /// The values of every rendering.
            pub(crate) const STANDARD: Self = Self { $( $name: $value, )* };

            /// For each constant the standard values with the lower and with the upper end of its range.
            #[cfg(feature = "ablate")]
            pub(crate) fn variants() -> Vec<Self> {
                let variants = [ $( [
                    Self { $name: $low, ..Self::STANDARD },
                    Self { $name: $high, ..Self::STANDARD },
                ], )* ];
                variants.into_iter().flatten().collect()
            }

            /// The constants, in the order of the variants.
            #[cfg(feature = "ablate")]
            pub(crate) fn constants(group: &str) -> Vec<super::Constant> {
                #[expect(trivial_numeric_casts, reason = "constants are of several types")]
                let constants = vec![ $( super::Constant {
                    name: format!("{group}.{}", stringify!($name)),
                    value: $value as f64,
                    low: $low as f64,
                    high: $high as f64,
                    reason: concat!($($reason),*).trim().to_owned(),
                }, )* ];
                constants
            }
        }
    };
}

/// Declares the table: its groups, each of which is a module.
macro_rules! tuning {
    ($($group:ident: $of_group:ident,)*) => {
        /// All constants that decide accuracy and cost.
        #[derive(Clone, Debug)]
        pub(crate) struct Tuning {
            $( pub(crate) $group: $group::$of_group, )*
        }

        impl Tuning {
            /// The values of every rendering.
            pub(crate) const STANDARD: Self = Self { $( $group: $group::$of_group::STANDARD, )* };

            /// Two variants for each constant, in the order of [`constants`].
            #[cfg(feature = "ablate")]
            fn variants() -> Vec<Self> {
                let mut variants = Vec::new();
                $( variants.extend(
                    $group::$of_group::variants().into_iter().map(|$group| Self { $group, ..Self::STANDARD }),
                ); )*
                variants
            }
        }

        /// All constants, group by group.
        #[cfg(feature = "ablate")]
        pub fn constants() -> Vec<Constant> {
            [ $( $group::$of_group::constants(stringify!($group)), )* ].concat()
        }
    };
}

mod engine;
mod verification;
mod spectra;
mod image;
mod line;
mod jumps;
mod rule;
mod view;
mod edges;
mod faces;
mod lowrank;
mod surfaces;
mod sums;
#[cfg(feature = "ablate")]
mod variants;

#[cfg(feature = "ablate")]
pub(crate) use variants::TUNING;
#[cfg(feature = "ablate")]
pub(crate) use variants::is_plane_forced;
#[cfg(feature = "ablate")]
pub use variants::{End, Forced, force, select};

tuning! {
    engine: Engine,
    verification: Verification,
    spectra: Spectra,
    image: Image,
    line: Line,
    jumps: Jumps,
    rule: Rule,
    view: View,
    edges: Edges,
    faces: Faces,
    lowrank: Lowrank,
    surfaces: Surfaces,
    sums: Sums,
}

/// The constants of this build.
#[cfg(not(feature = "ablate"))]
pub(crate) const TUNING: Tuning = Tuning::STANDARD;

/// Whether views have no charts: only measurements force that.
#[cfg(not(feature = "ablate"))]
pub(crate) const fn is_plane_forced() -> bool {
    false
}

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
