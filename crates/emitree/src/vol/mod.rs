//! Method `vol`: the image to the error that was asked for, with as few evaluations as can be.
//!
//! There are two ways. If G is a sum of few products of functions of x, y and z, crosses of samples
//! know all of it: `cross`. Else it is integrated line by line, which needs no structure but the
//! image's own, and what there is of it along the lines and between them is learned on the way.
//!
//! The image is a function of two variables that may be smooth where g is not, and its error is what
//! has been promised: so the tree is one of the image plane, and each of its nodes is a line of
//! sight.
//!
//! * `dyadic`: places on the unit interval, predictions and polynomials;
//! * `line`, `line_error`: samples along one line, its integral, its error and where to look next;
//!   `memo`: what of that is known from before;
//! * `jumps`, `local_fit`, `tracking`: the jumps of lines, and where those of a new line are expected
//!   from its neighbours;
//! * `block`, `depth_rule`: a few depths that integrate all lines of a part of the image;
//! * `nearest`: the nearest of many lines;
//! * `sights`, `round`: the lines of all nodes, sampled in batches; the radiances of new nodes;
//! * `image_tree`, `remaining`: values and details in the image plane, and what remains unseen;
//! * `closed`: nodes that no pixel sees, and the values that stencils find there;
//! * `error_map`, `opening`: that spread over the pixels, and the nodes that are worth opening;
//! * `pixels`: the means over pixels;
//! * `shares`: what each pixel has of a layer, where the image has edges that geometry knows;
//! * `spectrum`: G along the energy axis at one point; `scouts`: the points where spectra are sampled;
//! * `energies`: the energies that explain all spectra, and bins as sums of their images; `spectra`: when
//!   to look at which;
//! * `visible`: the layers of all tiles, before there are energies;
//! * `lattice`: scattered samples, and how small a structure they see;
//! * `cross`: the other way, for a G that is a sum of few products, tried first;
//! * `sheet`: the image tree of one [layer](crate::projection::Layer), and its part in the image;
//! * `engine`: the loop over all this, for all layers of the view and all energies.
//!
//! What is promised, and what can't be, is told at [`VolOptions::tolerance`].

mod ascent;
mod block;
mod closed;
mod coverage;
mod cross;
mod depth_rule;
mod developed;
mod dyadic;
mod energies;
mod engine;
mod error_map;
mod exam;
mod image_tree;
mod jumps;
mod lattice;
mod line;
mod line_error;
mod local_fit;
mod memo;
mod nearest;
mod opening;
pub(crate) mod options;
mod pixels;
mod remaining;
mod round;
mod scouts;
mod seeds;
mod shares;
mod sheet;
mod sights;
mod spectra;
mod spectrum;
mod tracking;
mod visible;

#[cfg(test)]
mod tests;

pub(crate) use engine::render;
pub(crate) use options::VolOptions;
pub use seeds::Seed;

/// The size of a small feature: the standard deviation of a Gaussian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FeatureSize {
    /// As a fraction of the edge of the view's cube, above 0 and at most 1. Along each axis of the view
    /// it is that fraction of the image's width, of its height and of the depth.
    Fraction(f64),
    /// As a length in the scene's length unit, above 0: that fraction of the edge of a cube with the
    /// volume of the view, whose depth has to be finite.
    Length(f64),
}

/// The contrast of the smallest feature that is covered: the peak of the feature in the image, in units
/// of the error allowed.
pub const FEATURE_CONTRAST: f64 = 20.0;

/// The base levels that there are.
pub const BASE_LEVELS: core::ops::RangeInclusive<u8> = 2..=7;

/// Memory that one evaluation takes: its sample, and its share of the nodes and of what a round
/// makes of them.
pub(crate) const BYTES_PER_EVALUATION: u64 = 640;
/// Numbers for each pixel beside the image and its error: the copy that the choice is made on, the
/// scale, and the columns of one axis.
pub(crate) const MAPS: u64 = 4;

/// The whole part of a number of nodes or depths, which is 0 or more.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "saturates as it should"
)]
fn whole(number: f64) -> usize {
    number as usize
}
