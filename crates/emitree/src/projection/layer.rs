//! Layers: an image with edges as a sum of smooth images times known coverage fractions.
//!
//! An opaque body ends lines of sight, and the image jumps at its limb. Limbs are located analytically,
//! without evaluations. So a view is divided into *layers* whose radiances are smooth on their own side of
//! a limb, and the image is the sum over layers of radiance times coverage fraction (*share* in the
//! code), which follows at each (x, y) from the bodies on the line of sight.

use super::{MappedPoint, Projection};

/// The part of the view at a point of the image plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Region {
    /// Nothing: the point belongs to no image.
    Outside,
    /// A line of sight through all of the view's depth.
    Sky,
    /// A line of sight that ends at an opaque body, by its number in the order given.
    Body(usize),
}

/// One layer of a view: a map from the canonical cube to a part of the world, smooth where it
/// [is open](Self::is_open), and its coverage fraction in the image.
pub trait Layer: Send + Sync + core::fmt::Debug {
    /// As [`Projection::world_from_canonical`].
    fn world_from_canonical(&self, u: [f64; 3]) -> MappedPoint;

    /// As [`Projection::canonical_from_world`].
    fn canonical_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]>;

    /// As [`Projection::solid_angle_density`], continued smoothly where there is no image.
    fn solid_angle_density(&self, xy: [f64; 2]) -> f64;

    /// Whether the layer has to be sampled at (x, y): its coverage fraction is not 0 there, or it is smooth
    /// everywhere.
    fn is_open(&self, _xy: [f64; 2]) -> bool {
        true
    }

    /// The coverage fraction at (x, y), the part of the layer's radiance that is in the image, −1 to 1, if
    /// that point is in `region`.
    fn share(&self, xy: [f64; 2], region: Region) -> f64;
}

/// A whole projection as its only layer.
#[derive(Debug)]
pub(super) struct Whole<'a, P: ?Sized>(pub(super) &'a P);

impl<P: Projection + ?Sized> Layer for Whole<'_, P> {
    fn world_from_canonical(&self, u: [f64; 3]) -> MappedPoint {
        self.0.world_from_canonical(u)
    }

    fn canonical_from_world(&self, position: [f64; 3]) -> Option<[f64; 3]> {
        self.0.canonical_from_world(position)
    }

    fn solid_angle_density(&self, xy: [f64; 2]) -> f64 {
        self.0.solid_angle_density(xy)
    }

    fn share(&self, _xy: [f64; 2], region: Region) -> f64 {
        if region == Region::Outside { 0.0 } else { 1.0 }
    }
}
