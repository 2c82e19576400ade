//! A channel of a cube: G at one energy by products.

use crate::cube::Cube;
use crate::exchange::MethodError;
use crate::image::Image;
use crate::meter::Meter;
use crate::tile::Tile;
use crate::tree::StopReason;
use crate::vol::VolOptions;
use crate::vol::dyadic::unit;
use crate::vol::lowrank::attempted::{Attempted, Placed};
use crate::vol::lowrank::interpolant::Interpolant;
use crate::vol::lowrank::rows::Checked;
use crate::vol::lowrank::start::{Functions, Start};
use crate::vol::lowrank::{ImageOf, Probed, attempt};
use crate::vol::spectrum::bins::Bins;
use crate::vol::spectrum::probes::ProbePoint;
use crate::vol::view::part::Parts;
use std::sync::Arc;

/// The view of a cube whose channels are searched for.
#[derive(Clone, Copy)]
pub(crate) struct CubeView<'a> {
    pub(crate) meter: &'a Meter,
    pub(crate) tiles: &'a [Tile<'a>],
    pub(crate) parts: &'a Parts<'a>,
    pub(crate) vol: &'a VolOptions,
}

/// What the search for a channel aims at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChannelTarget {
    /// The place of its energy on the axis.
    pub(crate) energy: u32,
    /// The tolerance, relative to the largest |pixel| or to `least_largest`.
    pub(crate) tolerance: f64,
    pub(crate) least_largest: f64,
    /// Whether it is not the first one: the view is divided as it has to be.
    pub(crate) is_further: bool,
}

impl CubeView<'_> {
    /// The searches for products of G at one energy.
    pub(crate) async fn attempt(
        &self,
        bins: &Bins<'_>,
        target: ChannelTarget,
        start: Option<&Start>,
        probed: Vec<Probed>,
    ) -> Result<Attempted, MethodError> {
        let ChannelTarget { energy, tolerance, least_largest, is_further } = target;
        let Self { meter, tiles, parts, .. } = *self;
        let vol = VolOptions { tolerance, lines: None, ..self.vol.clone() };
        let energies = [(bins.sample_at(energy), 1.0)];
        let of = ImageOf { energies: &energies, least_largest, is_further };
        attempt(meter, tiles, parts, &vol, start, probed, of).await
    }
}

/// G at one energy, with its image.
pub(super) struct Channel {
    pub(super) image: Image,
    pub(super) error: Image,
    /// The smallest feature that was detected.
    pub(super) smallest: Option<f64>,
    /// Whether the error is as small as it has to be.
    pub(super) is_complete: bool,
    /// The functions of the parts, if a frozen quadrature is made.
    pub(super) functions: Vec<Option<Functions>>,
    pub(super) placed: Vec<Placed>,
    /// What its image is made of row by row, if it is to be; else nothing.
    pub(super) checked: Vec<Arc<Checked>>,
    /// The products of each part.
    products: Vec<Arc<Interpolant>>,
}

impl Channel {
    /// That of a search, if all parts have products.
    pub(super) fn of(attempted: Attempted) -> Option<Self> {
        let products: Option<Vec<_>> = attempted.interpolants.into_iter().collect();
        let made = attempted.found?;
        let first = |cube: &Cube| cube.bands()[0].clone();
        Some(Self {
            image: first(&made.cube),
            error: first(made.error.as_ref()?),
            smallest: made.smallest_feature,
            is_complete: made.ending == StopReason::Complete,
            functions: attempted.functions,
            placed: attempted.placed,
            checked: attempted.checked.into_iter().flatten().collect(),
            products: products?,
        })
    }

    /// G = g · ds/dz · dE/du at points of one part.
    pub(super) fn rates(&self, parts: &Parts<'_>, points: &[ProbePoint]) -> Vec<f64> {
        let Some(ProbePoint { part, .. }) = points.first() else { return Vec::new() };
        let place = |of: &ProbePoint| [unit(of.place[0]), unit(of.place[1]), unit(of.depth)];
        let places: Vec<[f64; 3]> = points.iter().map(place).collect();
        let chart = &*parts.parts[*part].chart;
        let values = self.products[*part].unscaled_values(&places).into_iter().zip(&places);
        let rate = |(value, [x, y, _]): (f64, &[f64; 3])| match chart.density([*x, *y]) {
            0.0 => 0.0,
            density => value / density,
        };
        values.map(rate).collect()
    }
}
