//! Beams: the leaves that the lines of sight of a pixel pass, with what all of the lines have in common.
//!
//! Most leaves that a pixel sees are in one region as far as it sees them, even those with patches: the
//! lines need not ask again.

use crate::vol::surfaces::octree::{Facet, Grid, HIDDEN, Label, Leaf, Octree, one_region};
use crate::vol::surfaces::patch::Patch;

/// What is in a part of a beam.
#[derive(Debug)]
pub(super) enum Content<'a> {
    Region(Label),
    /// The region, the jump and the number of a leaf that remains unresolved.
    Unresolved(Label, f64, usize),
    /// The patches of a leaf, and those of them that some lines may cross.
    Cut(&'a [Facet], Vec<&'a Patch>),
}

/// A leaf, or several of one region after each other.
#[derive(Debug)]
pub(super) struct Part<'a> {
    /// The depth at which it ends.
    pub(super) top: f64,
    pub(super) content: Content<'a>,
    /// The x and y of its lines, in base cells; `None` for all lines of the beam.
    across: Option<[[f64; 2]; 2]>,
}

/// The lines of sight in a rectangle of the image.
#[derive(Debug)]
pub(super) struct Beam<'a> {
    grid: Grid,
    /// For each line its parts are in their order.
    parts: Vec<Part<'a>>,
}

impl<'a> Beam<'a> {
    /// The lines between two corners (x, y).
    pub(super) fn new(tree: &'a Octree, corners: [[f64; 2]; 2]) -> Self {
        let places = corners.map(|xy| tree.grid.places(xy));
        let mut beam = Self { grid: tree.grid, parts: Vec::new() };
        for leaf in tree.passed(places) {
            beam.add(tree, leaf, corners, places);
        }
        beam
    }

    fn add(
        &mut self,
        tree: &'a Octree,
        number: usize,
        [low, high]: [[f64; 2]; 2],
        places: [[f64; 2]; 2],
    ) {
        let (cell, leaf) = &tree.leaves[number];
        let across = tree.grid.places_of_lines(*cell);
        let across = (!places.iter().all(|at| is_in(&across, *at))).then_some(across);
        let [bottom, top] = tree.ends(number, 2);
        let content = match leaf {
            Leaf::Uncut(label) => Content::Region(*label),
            Leaf::Hidden => Content::Region(HIDDEN),
            Leaf::Unresolved(label, jump) => Content::Unresolved(*label, *jump, number),
            Leaf::Cut(facets) => {
                let [x, y] = [0, 1].map(|k| {
                    let [from, to] = tree.ends(number, k);
                    [low[k].max(from), high[k].min(to)]
                });
                let ends = [[x[0], y[0], bottom], [x[1], y[1], top]];
                let patches = facets.iter().flat_map(|of| of.wall.patches());
                let crossed: Vec<&Patch> =
                    patches.filter(|patch| !patch.is_on_one_side(ends)).collect();
                let middle = core::array::from_fn(|k| 0.5 * (ends[0][k] + ends[1][k]));
                match one_region(facets, middle).filter(|_| crossed.is_empty()) {
                    Some(label) => Content::Region(label),
                    None => Content::Cut(facets, crossed),
                }
            }
        };
        if let (Some(last), Content::Region(label), None) =
            (self.parts.last_mut(), &content, &across)
            && let (Content::Region(before), None) = (&last.content, &last.across)
            && before == label
        {
            last.top = top;
            return;
        }
        self.parts.push(Part { top, content, across });
    }

    /// The parts on a line of the beam.
    pub(super) fn parts(&self, xy: [f64; 2]) -> impl Iterator<Item = &Part<'a>> {
        let places = self.grid.places(xy);
        self.parts.iter().filter(move |of| of.across.is_none_or(|across| is_in(&across, places)))
    }
}

/// Whether a line is between ends along both axes.
fn is_in(across: &[[f64; 2]; 2], at: [f64; 2]) -> bool {
    across.iter().zip(at).all(|([low, high], at)| (*low..*high).contains(&at))
}

#[cfg(test)]
mod tests;
