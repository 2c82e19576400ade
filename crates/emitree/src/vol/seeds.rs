//! Seeds: the nodes and depths that are sampled at structures which the options name.

use crate::error::{OptionError, RenderError};
use crate::projection::Chart;
use crate::vol::dyadic::{Place, around, spacing, unit};

/// A known place of small structure that a coarse lattice would miss. Method
/// [`Vol`](crate::Method::Vol) samples there down to the size of the structure.
///
/// ```
/// use emitree::vol::Seed;
///
/// let knot = Seed { position: [0.2, 0.4, 0.9], radius: 0.01 };
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seed {
    /// The centre of the structure, in world coordinates and the scene's length unit.
    pub position: [f64; 3],
    /// Its radius, in the scene's length unit, above 0.
    pub radius: f64,
}

/// Returns an error for a seed with a position that is not finite or without a size.
pub(crate) fn check_seeds<E>(seeds: &[Seed]) -> Result<(), RenderError<E>> {
    for &Seed { position, radius } in seeds {
        let refused = if !position.iter().all(|x| x.is_finite()) {
            OptionError::SeedPosition { position, radius }
        } else if !(radius > 0.0 && radius.is_finite()) {
            OptionError::SeedRadius { position, radius }
        } else {
            continue;
        };
        return Err(refused.into());
    }
    Ok(())
}

/// The nodes and depths that seeds and failed verifications require.
#[derive(Clone, Debug, Default)]
pub(crate) struct SeedTargets {
    /// Nodes around the seeds, of all levels down to their size.
    pub(crate) places: Vec<Place>,
    boxes: Vec<SeedBox>,
    found: Vec<FoundDepths>,
}

/// The depths of a failed line of a verification, and the distance from it within which new lines
/// are sampled there.
#[derive(Clone, Debug)]
struct FoundDepths {
    centre: [f64; 2],
    reach: f64,
    depths: Vec<u32>,
}

/// A seed in canonical coordinates.
#[derive(Clone, Copy, Debug)]
struct SeedBox {
    centre: [f64; 3],
    /// The distance along x and y within which lines are sampled around the depth of the seed.
    reach: f64,
    finest_level: u8,
}

/// The finest level of depths, and of nodes, for the smallest seeds.
const FINEST_LEVEL: u8 = 20;

impl SeedTargets {
    /// The nodes and depths for the seeds that are in view.
    pub(crate) fn at(seeds: &[Seed], chart: &dyn Chart, base_level: u8, finest_level: u8) -> Self {
        let mut targets = Self::default();
        for seed in seeds {
            let Some(centre) = chart.chart_from_world(seed.position) else { continue };
            let mut half = [0.0; 3];
            for axis in 0..3 {
                for sign in [-1.0, 1.0] {
                    let mut position = seed.position;
                    position[axis] += sign * seed.radius;
                    if let Some(u) = chart.chart_from_world(position) {
                        half =
                            core::array::from_fn(|i| f64::max(half[i], (u[i] - centre[i]).abs()));
                    }
                }
            }
            let inside = (0..3).all(|i| (-half[i]..=1.0 + half[i]).contains(&centre[i]));
            if !inside {
                continue;
            }
            let of_image = level_of_size(half[0].min(half[1])).min(finest_level);
            for level in base_level + 1..=of_image {
                targets.places.extend(places(centre, level));
            }
            let of_depth = level_of_size(half[2]);
            if of_image <= base_level && of_depth <= base_level {
                continue; // The base lattice resolves it.
            }
            // Nodes are no closer to the seed than the finest level of the image allows.
            let reach = f64::max(2.0 * half[0].max(half[1]), unit(spacing(finest_level)));
            targets.boxes.push(SeedBox { centre, reach, finest_level: of_depth.max(base_level) });
        }
        targets.places.sort_unstable();
        targets.places.dedup();
        targets
    }

    /// Requires the nodes of `level` around a place, and the given depths on all lines that are
    /// added near it.
    pub(crate) fn add_depths_around(&mut self, place: Place, level: u8, depths: &[u32]) {
        let [x, y] = place.map(unit);
        self.places.extend(places([x, y, 0.0], level));
        self.places.sort_unstable();
        self.places.dedup();
        if !depths.is_empty() {
            let reach = unit(spacing(level - 1));
            self.found.push(FoundDepths { centre: [x, y], reach, depths: depths.to_vec() });
        }
    }

    /// Whether no seed needs nodes or depths beyond those of every rendering.
    pub(crate) fn are_none(&self) -> bool {
        self.places.is_empty() && self.boxes.is_empty()
    }

    /// The additional depths at which a line at `place` is sampled; none if no seed is near.
    pub(crate) fn depths(&self, place: Place) -> Vec<u32> {
        let mut depths = Vec::new();
        for seed in &self.boxes {
            let near =
                (0..2).all(|axis| (unit(place[axis]) - seed.centre[axis]).abs() <= seed.reach);
            if !near {
                continue;
            }
            for level in 0..=seed.finest_level {
                let [below, above] = bracket(seed.centre[2], level);
                depths.extend([below, above]);
            }
        }
        for found in &self.found {
            let near = (0..2).all(|k| (unit(place[k]) - found.centre[k]).abs() <= found.reach);
            if near {
                depths.extend(&found.depths);
            }
        }
        depths.sort_unstable();
        depths.dedup();
        depths
    }
}

/// The coarsest level whose spacing is no larger than a size.
fn level_of_size(size: f64) -> u8 {
    (0..FINEST_LEVEL).find(|&level| unit(spacing(level)) <= size).unwrap_or(FINEST_LEVEL)
}

/// The two places of the lattice of `level` around a coordinate.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the axis")]
fn bracket(coordinate: f64, level: u8) -> [u32; 2] {
    let intervals = f64::from(1_u32 << level);
    let below =
        (coordinate * intervals).floor().clamp(0.0, intervals - 1.0) as u32 * spacing(level);
    [below, below + spacing(level)]
}

/// The nodes of the lattice of `level` around the interval that contains (x, y).
fn places([x, y, _]: [f64; 3], level: u8) -> impl Iterator<Item = Place> {
    let corners = bracket(x, level).map(|x| bracket(y, level).map(|y| [x, y]));
    corners.into_iter().flatten().flat_map(move |corner| {
        let beside = around(corner, spacing(level), 1).map(|(_, _, place)| place);
        core::iter::once(corner).chain(beside)
    })
}

#[cfg(test)]
mod tests;
