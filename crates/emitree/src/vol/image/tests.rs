//! What remains around nodes, and which of them are opened, on trees with single details.

use crate::image::Image;
use crate::vol::dyadic::Place;
use crate::vol::image::error_map::Footprint;
use crate::vol::image::opening::{Choice, ChoiceLimits, worthwhile};
use crate::vol::image::remaining::{Children, Remaining, guarded_details, remaining};
use crate::vol::image::tree::ImageTree;
use crate::vol::testing::{assert_close, at, lattice, tree_of, uniform, with_detail};
use crate::vol::tuning::TUNING;

const SPIKE: (u32, u32) = (3, 3);

/// Zero on the lattice of level 3 but for a detail of 1 at (3, 3).
fn spike() -> (ImageTree, usize) {
    let mut tree = tree_of(&lattice(3), |_, _| 0.0);
    let i = with_detail(&mut tree, at(3, SPIKE.0, SPIKE.1), 1.0);
    (tree, i)
}

fn number(tree: &ImageTree, place: Place) -> usize {
    tree.find(place).unwrap_or(usize::MAX)
}

fn rests(tree: &ImageTree, required_level: u8) -> Vec<Remaining> {
    remaining(tree, &guarded_details(tree), required_level)
}

#[test]
fn a_spike_guards_the_nodes_of_its_level_up_to_two_spacings_away() {
    let (tree, _) = spike();
    let guarded = guarded_details(&tree);
    for (node, guarded) in tree.nodes().iter().zip(guarded) {
        let [x, y] = node.place.map(|along| along / at(3, 1, 0)[0]);
        let distance = x.abs_diff(SPIKE.0).max(y.abs_diff(SPIKE.1));
        let expected = match (node.level, distance) {
            (3, 0) => 1.0,
            (3, 1) => TUNING.image.first_neighbour_guard,
            (3, 2) => TUNING.image.second_neighbour_guard,
            _ => 0.0,
        };
        assert_close(guarded, expected, 1e-15);
    }
}

#[test]
fn a_detail_guards_no_finer_node() {
    let (mut tree, _) = spike();
    let finer = with_detail(&mut tree, at(4, 7, 7), 0.0);
    assert_close(guarded_details(&tree)[finer], 0.0, 1e-15);
}

#[test]
fn a_guarded_detail_remains_in_full_on_the_required_levels() {
    let (tree, spike) = spike();
    let rests = rests(&tree, 3);
    assert_eq!(rests[spike].children, Children::None);
    assert_close(rests[spike].size, 1.0, 1e-15);
    assert_close(rests[number(&tree, at(3, 4, 3))].size, TUNING.image.first_neighbour_guard, 1e-15);
    for (node, rest) in tree.nodes().iter().zip(&rests).filter(|(node, _)| node.level < 3) {
        assert_eq!(rest.children, Children::All, "{node:?}");
        assert_eq!(rest.size.to_bits(), 0, "{node:?}");
    }
}

#[test]
fn no_decay_is_assumed_on_the_last_required_level() {
    let mut tree = tree_of(&lattice(2), |_, _| 0.0);
    with_detail(&mut tree, at(2, 1, 1), 1.0);
    for place in lattice(3) {
        if tree.find(place).is_none() {
            with_detail(&mut tree, place, 0.0);
        }
    }
    let i = with_detail(&mut tree, at(3, 3, 3), 0.1);
    assert_close(rests(&tree, 3)[i].size, 0.1, 1e-14);
    let decay = (TUNING.image.decay_margin * 0.1).max(TUNING.image.first_least_decay);
    assert_close(rests(&tree, 2)[i].size, 0.1 * decay, 1e-14);
}

/// The places of the diagonal children of the spike, and of the four beside it.
const DIAGONAL: [(u32, u32); 4] = [(5, 5), (5, 7), (7, 5), (7, 7)];
const BESIDE: [(u32, u32); 4] = [(5, 6), (6, 5), (6, 7), (7, 6)];

#[test]
fn the_diagonal_children_determine_the_remaining_error() {
    let least = TUNING.image.after_diagonals;
    for (of_child, expected) in [(0.4, 0.4), (0.1 * least, least)] {
        let (mut tree, spike) = spike();
        for (x, y) in DIAGONAL {
            with_detail(&mut tree, at(4, x, y), 0.0);
        }
        with_detail(&mut tree, at(4, 7, 5), of_child);
        let rest = rests(&tree, 3)[spike];
        assert_eq!(rest.children, Children::Diagonal);
        assert_close(rest.size, expected, 1e-14);
        // The level before the last one required has no two steps.
        assert_close(rests(&tree, 4)[spike].size, 1.0, 1e-14);
        for (x, y) in BESIDE {
            with_detail(&mut tree, at(4, x, y), 0.0);
        }
        let rest = rests(&tree, 3)[spike];
        assert_eq!((rest.children, rest.size.to_bits()), (Children::All, 0));
    }
}

#[test]
fn the_detail_of_a_missing_child_is_estimated_from_its_siblings() {
    let of_order = [
        (6, TUNING.image.sibling_share),
        (4, TUNING.image.sibling_share_of_kinks * TUNING.image.kink_margin),
    ];
    for (order, expected) in of_order {
        let mut tree = tree_of(&lattice(3), |_, _| 0.0);
        tree.set_order(order);
        with_detail(&mut tree, at(4, 7, 7), 1.0);
        let rests = rests(&tree, 3);
        for (x, y) in [(3, 3), (3, 4), (4, 3)] {
            assert_close(rests[number(&tree, at(3, x, y))].size, expected, 1e-14);
        }
        for (x, y) in [(2, 3), (5, 3), (5, 5)] {
            assert_close(rests[number(&tree, at(3, x, y))].size, 0.0, 1e-14);
        }
    }
}

#[test]
fn below_the_required_levels_the_observed_decay_is_used() {
    let (margin, first) = (TUNING.image.decay_margin, TUNING.image.first_least_decay);
    for (detail, decay) in [(0.2, margin * 0.2), (0.05, first), (0.9, 1.0)] {
        let (mut tree, _) = spike();
        let child = with_detail(&mut tree, at(4, 7, 7), detail);
        assert_close(rests(&tree, 3)[child].size, decay * detail, 1e-14);
    }
    let (mut tree, _) = spike();
    with_detail(&mut tree, at(4, 7, 7), 0.2);
    for (detail, decay) in [(0.04, margin * 0.04 / 0.2), (1e-3, TUNING.image.least_decay)] {
        let grandchild = with_detail(&mut tree, at(5, 13, 13), detail);
        assert_close(rests(&tree, 3)[grandchild].size, decay * detail, 1e-14);
    }
}

/// A tree with values of 0 and remaining errors at a few nodes, on an image of `shape`.
struct Opening {
    tree: ImageTree,
    remaining: Vec<Remaining>,
    scale: Image,
    weights: Vec<f64>,
    limits: ChoiceLimits,
}

impl Opening {
    fn new(shape: [usize; 2], tolerance: f64, sizes: &[(Place, f64)]) -> Self {
        let tree = tree_of(&lattice(3), |_, _| 0.0);
        let mut remaining = vec![Remaining { children: Children::None, size: 0.0 }; tree.len()];
        for (place, size) in sizes {
            remaining[number(&tree, *place)].size = *size;
        }
        let limits = ChoiceLimits { tolerance, finest_level: 9, required_level: 3 };
        Self { tree, remaining, scale: uniform(shape, 1.0), weights: vec![1.0], limits }
    }

    fn footprints(&self) -> Vec<Option<Footprint>> {
        let shape = [self.scale.height(), self.scale.width()];
        let of_node = |(node, rest): (_, &Remaining)| {
            (rest.size > 0.0).then(|| Footprint::new(node, rest, shape))
        };
        self.tree.nodes().iter().zip(&self.remaining).map(of_node).collect()
    }

    fn choice<'a>(&'a self, footprints: &'a [Option<Footprint>]) -> Choice<'a> {
        Choice {
            tree: &self.tree,
            remaining: &self.remaining,
            footprints,
            weights: &self.weights,
            scale: &self.scale,
            scales: &[],
            limits: self.limits,
        }
    }

    /// The places that are opened, for the error that the footprints make or another one.
    fn opened(&self, errors: Option<&[&Image]>) -> Vec<Place> {
        let footprints = self.footprints();
        let mut own = Image::zeros(self.scale.height(), self.scale.width());
        for footprint in footprints.iter().flatten() {
            footprint.add_to(&mut own, &self.scale, 1.0);
        }
        let opened = worthwhile(&[self.choice(&footprints)], errors.unwrap_or(&[&own]));
        opened[0].iter().map(|&i| self.tree.nodes()[i].place).collect()
    }
}

const SHAPE: [usize; 2] = [16, 16];

/// The largest mean of a hat of a height of 1 and a half width of two pixels, from border to border.
const PEAK: f64 = 0.75 * 0.75;

#[test]
fn the_largest_are_opened_first_until_every_pixel_is_within_the_goal() {
    let (large, small) = (at(3, 3, 3), at(3, 7, 7));
    let goal = TUNING.image.pixel_goal;
    let opened =
        |tolerance: f64| Opening::new(SHAPE, tolerance, &[(small, 0.5), (large, 1.0)]).opened(None);
    assert_eq!(opened(1.001 * PEAK / goal), [] as [Place; 0]);
    assert_eq!(opened(0.999 * PEAK / goal), [large]);
    assert_eq!(opened(0.501 * PEAK / goal), [large]);
    assert_eq!(opened(0.499 * PEAK / goal), [large, small]);
}

#[test]
fn a_node_is_not_opened_if_a_larger_one_reduces_the_error_enough() {
    let (large, beside) = (at(3, 3, 3), at(3, 4, 3));
    let opening = Opening::new(SHAPE, 0.5, &[(large, 1.0), (beside, 0.3)]);
    assert_eq!(opening.opened(None), [large]);
    // The rest of the large one, and all of the other, on the pixels that both reach.
    let left = (1.0 - TUNING.image.expected_gain + 0.3) * PEAK;
    let opening =
        Opening::new(SHAPE, 0.4 * left / TUNING.image.pixel_goal, &[(large, 1.0), (beside, 0.3)]);
    assert_eq!(opening.opened(None), [large, beside]);
}

#[test]
fn nodes_with_small_contributions_or_of_the_finest_level_are_not_opened() {
    let bad = uniform(SHAPE, 10.0);
    let least = TUNING.image.least_contribution;
    let sizes = [(at(3, 3, 3), 0.99 * least), (at(3, 7, 7), 1.01 * least)];
    let mut opening = Opening::new(SHAPE, 1.0, &sizes);
    assert_eq!(opening.opened(Some(&[&bad])), [at(3, 7, 7)]);
    opening.limits.finest_level = 3;
    assert_eq!(opening.opened(Some(&[&bad])), [] as [Place; 0]);
}

#[test]
fn a_footprint_narrower_than_a_pixel_counts_by_its_share() {
    let (coarse, fine) = (at(3, 2, 2), at(3, 5, 5));
    let bad = |shape| uniform(shape, 10.0);
    // A spacing is half of a pixel along one axis of the first two images.
    for (shape, first) in [([16, 4], coarse), ([4, 16], coarse), (SHAPE, fine)] {
        let opening = Opening::new(shape, 1.0, &[(coarse, 0.6), (fine, 1.0)]);
        assert_eq!(opening.opened(Some(&[&bad(shape)]))[0], first, "{shape:?}");
    }
}

#[test]
fn only_bins_with_a_weight_require_nodes() {
    let place = at(3, 3, 3);
    let [good, bad] = [uniform(SHAPE, 0.0), uniform(SHAPE, 10.0)];
    let mut opening = Opening::new(SHAPE, 1.0, &[(place, 1.0)]);
    opening.weights = vec![1.0, 0.0];
    assert_eq!(opening.opened(Some(&[&good, &bad])), [] as [Place; 0]);
    opening.weights = vec![0.0, -2.0];
    assert_eq!(opening.opened(Some(&[&good, &bad])), [place]);
}

#[test]
fn nodes_without_effect_on_a_pixel_are_not_opened() {
    let (dark, bright) = (at(3, 1, 4), at(3, 7, 4));
    let mut opening = Opening::new(SHAPE, 1.0, &[(dark, 2.0), (bright, 1.0)]);
    for (i, pixel) in opening.scale.pixels_mut().iter_mut().enumerate() {
        *pixel = if i % SHAPE[1] < SHAPE[1] / 2 { 0.0 } else { 3.0 };
    }
    assert_eq!(opening.opened(Some(&[&uniform(SHAPE, 10.0)])), [bright]);
}

#[test]
fn two_trees_compete_for_one_error() {
    let place = at(3, 3, 3);
    let tolerance = 2.0 * PEAK / TUNING.image.pixel_goal;
    let openings = [1.0, 2.0].map(|size| Opening::new(SHAPE, tolerance, &[(place, size)]));
    let footprints = openings.each_ref().map(Opening::footprints);
    let choices = [openings[0].choice(&footprints[0]), openings[1].choice(&footprints[1])];
    let mut sum = uniform(SHAPE, 0.0);
    for footprint in footprints.iter().flatten().flatten() {
        footprint.add_to(&mut sum, &openings[0].scale, 1.0);
    }
    // Both together are beyond the goal, and either would be within it.
    let i = number(&openings[0].tree, place);
    assert_eq!(worthwhile(&choices, &[&sum]), [vec![], vec![i]]);
}

#[test]
fn the_first_step_has_diagonal_children_and_the_second_all_that_are_missing() {
    let (first, second) = (at(3, 3, 3), at(3, 0, 5));
    let mut opening = Opening::new(SHAPE, 1.0, &[(first, 1.0), (second, 1.0)]);
    let places = |opening: &Opening, nodes: &[Place]| {
        let nodes: Vec<usize> = nodes.iter().map(|at| number(&opening.tree, *at)).collect();
        let mut places = opening.choice(&opening.footprints()).places(&nodes);
        places.sort_unstable();
        places
    };
    let on_lattice = |of: &[(u32, u32)]| of.iter().map(|&(x, y)| at(4, x, y)).collect::<Vec<_>>();
    assert_eq!(places(&opening, &[first]), on_lattice(&DIAGONAL));
    // At the border of the image there are half as many.
    assert_eq!(places(&opening, &[second]), on_lattice(&[(1, 9), (1, 11)]));
    // Neighbours share two of them.
    assert_eq!(places(&opening, &[first, at(3, 4, 3)]).len(), 6);
    let i = number(&opening.tree, first);
    opening.remaining[i].children = Children::Diagonal;
    for (x, y) in DIAGONAL {
        opening.tree.add(at(4, x, y));
    }
    opening.remaining.resize(opening.tree.len(), opening.remaining[0]);
    assert_eq!(places(&opening, &[first]), on_lattice(&BESIDE));
    opening.limits.required_level = 4;
    assert_eq!(places(&opening, &[second]).len(), 5);
}
