//! A channel of a cube: what one energy adds to those before, beside the surfaces that were found at the first one.

use crate::vol::lowrank::WeightedView;
use crate::vol::surfaces::aim::Aim;
use crate::vol::surfaces::model::Model;
use crate::vol::surfaces::octree::{Cell, Grid, Label, Leaf, Octree};
use crate::vol::surfaces::pieces::Pieces;
use crate::vol::surfaces::pixel::KnownLines;
use crate::vol::surfaces::raster::Maps;
use crate::vol::surfaces::samples::Samples;
use crate::vol::surfaces::search::{Failure, Search};
use crate::vol::tuning::TUNING;

/// What an energy adds, with its image.
pub(super) struct Channel {
    pub(super) model: Model,
    pub(super) maps: Maps,
}

/// A sample of a channel in a region.
#[derive(Clone, Copy, Debug)]
pub(super) struct KnownSample {
    pub(super) label: Label,
    pub(super) at: [f64; 3],
    pub(super) rate: f64,
}

/// What a channel is made of.
pub(super) struct ChannelRequest<'a> {
    /// The weighted sum of energies that the channel is.
    pub(super) view: &'a WeightedView<'a>,
    /// The error allowed in a pixel of it.
    pub(super) target: f64,
    pub(super) tolerance: f64,
    pub(super) known: &'a [KnownSample],
}

impl Search<'_> {
    /// The channel beside the surfaces of `model`. Each region has polynomials of its own, and no sample decides
    /// about regions: a surface that the first energy does not have makes the polynomials fail.
    pub(super) async fn channel(
        &self,
        model: &Model,
        request: &ChannelRequest<'_>,
        left: &mut u64,
    ) -> Result<Channel, Failure> {
        let &ChannelRequest { view, target, tolerance, known } = request;
        let aim = || Aim { target, ..self.aim };
        let negligible = TUNING.surfaces.negligible * target / self.aim.scale.largest();
        let mut pieces = Vec::with_capacity(model.pieces.len());
        for (label, of_first) in (0..).zip(&model.pieces) {
            if of_first.is_none() {
                pieces.push(None);
                continue;
            }
            let mut samples = Samples::new(0.25 * self.grid.cell_size(0), negligible);
            (0..=label).for_each(|_| _ = samples.new_label());
            let of_region = known.iter().filter(|of| of.label == label);
            of_region.for_each(|of| _ = samples.add(of.at, of.rate, label));
            let mut search = Search::new(view, self.grid, aim(), tolerance, samples, *left);
            let of_region =
                search.pieces(&model.tree, label).await?.map_err(|_| Failure::TooComplex)?;
            *left = search.left;
            pieces.push(Some(of_region));
        }
        let model = Model { tree: with_jumps(&model.tree, &pieces), pieces };
        let maps = model.maps(&aim(), tolerance, &mut KnownLines::default());
        Ok(Channel { model, maps })
    }
}

/// The same leaves with the jumps of other pieces: the largest ones at the corners and the centres of the leaves.
fn with_jumps(tree: &Octree, pieces: &[Option<Pieces>]) -> Octree {
    let value = |label: Label, at: [f64; 3]| {
        pieces.get(usize::from(label)).and_then(Option::as_ref).map_or(0.0, |of| of.value(at))
    };
    let jump = |cell: Cell, sides: &[Label]| {
        let of_place = |at: [f64; 3]| {
            let values = sides.iter().map(|side| value(*side, at));
            let ends = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
                [low.min(value), high.max(value)]
            });
            (ends[1] - ends[0]).max(0.0)
        };
        places(&tree.grid, cell).map(of_place).fold(0.0, f64::max)
    };
    let all: Vec<Label> =
        (0..).zip(pieces).filter(|(_, of)| of.is_some()).map(|(label, _)| label).collect();
    let mut tree = tree.clone();
    for (cell, leaf) in &mut tree.leaves {
        match leaf {
            Leaf::Uncut(_) | Leaf::Hidden => {}
            // Nobody knows which regions are there.
            Leaf::Unresolved(_, of_leaf) => *of_leaf = jump(*cell, &all),
            Leaf::Cut(facets) => {
                facets.iter_mut().for_each(|of| of.jump = jump(*cell, &[of.below, of.above]));
            }
        }
    }
    tree
}

/// The corners and the centre of a cell.
fn places(grid: &Grid, (level, at): Cell) -> impl Iterator<Item = [f64; 3]> + '_ {
    let corner = move |corner: u32| {
        grid.point(level, core::array::from_fn(|k| f64::from(at[k] + ((corner >> k) & 1))))
    };
    (0..8).map(corner).chain([grid.centre((level, at))])
}
