//! Edges of the emission around opaque bodies: the radius at which it begins.
//!
//! Emission often begins at a height above a body: at an exobase, or with a layer of airglow. If it
//! begins with a jump, the surface there has a limb of its own beside that of the body. It is
//! searched for on a few lines of sight towards the body: the lowest bright sample of each is
//! bisected. Where rates just above the body are not negligible there is nothing to search for.

use crate::meter::Meter;
use crate::projection::Chart;
use crate::projection::charts::{Atlas, FoundEdge};
use crate::site::Site;
use crate::vol::sampling::{Stop, evaluate};
use crate::vol::tuning::TUNING;

/// The depths of each line that show whether there may be an edge.
const FIRST_DEPTHS: usize = 3;

/// The lines of sight towards one body.
struct Rays<'a> {
    meter: &'a Meter,
    atlas: &'a Atlas<'a>,
    body: usize,
    /// Places (u, v) on the near side of the body.
    places: Vec<[f64; 2]>,
    /// The energies at which g is evaluated.
    energies: &'a [Option<f64>],
}

/// A height above a body between a dark and a bright sample of one line, as depths z of the chart.
#[derive(Clone, Copy, Debug)]
struct Bracket {
    ray: usize,
    dark: f64,
    bright: f64,
    /// The rate of the bright sample.
    rate: f64,
    /// The rate below which a sample of the line is dark.
    limit: f64,
}

/// The edges around the bodies in view; `tolerance` is that of the image, `energies` are some of
/// the energy axis if there is one.
pub(crate) async fn find_edges(
    meter: &Meter,
    atlas: &Atlas<'_>,
    tolerance: f64,
    energies: &[Option<f64>],
) -> Result<Vec<FoundEdge>, Stop> {
    let mut found = Vec::new();
    for body in atlas.bodies_without_edges() {
        let place = |k: usize| {
            let along = |ratio: f64| (0.5 + k as f64 * ratio) % 1.0;
            // Two coordinates of the golden ratio's generalization, a lattice without gaps.
            [TUNING.edges.reach * along(0.754_877_666_246_693), along(0.569_840_290_998_053)]
        };
        // Where the surface is outside of the bounds nothing begins at it.
        let chart = atlas.near_chart(body);
        let is_in_bounds = |&[u, v]: &[f64; 2]| {
            let lowest = 1.0 - TUNING.edges.lowest_depth;
            chart.world_from_chart([u, v, lowest]).path_per_depth != 0.0
        };
        let places: Vec<[f64; 2]> =
            (0..TUNING.edges.lines).map(place).filter(is_in_bounds).collect();
        if places.len() < TUNING.edges.least_lines {
            continue;
        }
        let rays = Rays { meter, atlas, body, places, energies };
        found.extend(rays.edge(tolerance).await?);
    }
    Ok(found)
}

/// The largest number of evaluations for a body, at one energy.
pub(crate) fn cost_of_edges() -> u64 {
    let bisections = TUNING.edges.first_bisections + TUNING.edges.last_bisections;
    let of_line = TUNING.edges.depths + bisections;
    (TUNING.edges.lines * of_line) as u64
}

impl Rays<'_> {
    /// The largest |g| over the energies at depths of rays, times the distance from the centre of
    /// the body less two thirds of its radius: the share of a path in the radiance.
    async fn rates(&self, at: &[(usize, f64)]) -> Result<Vec<f64>, Stop> {
        let chart = self.atlas.near_chart(self.body);
        let site = |i: usize| {
            let (ray, z) = at[i / self.energies.len()];
            let [u, v] = self.places[ray];
            let mut point = chart.world_from_chart([u, v, z]);
            if point.path_per_depth != 0.0 {
                point.path_per_depth = self.atlas.radius(self.body, point.position) - 2.0 / 3.0;
            }
            let energy = self.energies[i % self.energies.len()];
            let (tile, xy) = chart.image_place([u, v]);
            Site { xy, point, energy, tile: (tile, self.atlas.tiles()) }
        };
        let rates = evaluate(self.meter, at.len() * self.energies.len(), &site).await?;
        let largest = |of_point: &[f64]| of_point.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        Ok(rates.chunks(self.energies.len()).map(largest).collect())
    }

    async fn edge(&self, tolerance: f64) -> Result<Option<FoundEdge>, Stop> {
        // The depths of a parabola from the surface, where z is 1.
        let depths = TUNING.edges.depths;
        let z = |k: usize| 1.0 - (k as f64 / (depths - 1) as f64).max(TUNING.edges.lowest_depth);
        let rays = self.places.len();
        let few: [usize; FIRST_DEPTHS] = [0, depths / 8, depths / 3];
        let first: Vec<(usize, f64)> = (0..rays).flat_map(|ray| few.map(|k| (ray, z(k)))).collect();
        let rates = self.rates(&first).await?;
        let largest = rates.iter().copied().fold(0.0, f64::max);
        let limit = |of_ray: f64, of_all: f64| {
            let negligible = TUNING.edges.negligible_share * tolerance * of_all;
            negligible.min(TUNING.edges.dark_share * of_ray)
        };
        let is_dark = |of_ray: &[f64]| {
            let of_all = of_ray.iter().copied().fold(0.0, f64::max);
            of_ray[0] <= limit(of_all, largest)
        };
        if !rates.chunks(few.len()).any(is_dark) {
            return Ok(None);
        }
        let of_ray = |ray: usize| (0..depths).map(move |k| (ray, k));
        let is_new = |(_, k): &(usize, usize)| !few.contains(k);
        let new = (0..rays).flat_map(of_ray).filter(is_new).map(|(ray, k)| (ray, z(k)));
        let mut new = self.rates(&new.collect::<Vec<_>>()).await?.into_iter();
        let mut known = rates.into_iter();
        let next = |at| if is_new(&at) { new.next() } else { known.next() };
        let rates: Vec<f64> = (0..rays).flat_map(of_ray).filter_map(next).collect();
        let largest = rates.iter().copied().fold(0.0, f64::max);
        let mut brackets = Vec::new();
        for (ray, of_ray) in rates.chunks(depths).enumerate() {
            let of_all = of_ray.iter().copied().fold(0.0, f64::max);
            let limit = limit(of_all, largest);
            let Some(bright) = of_ray.iter().position(|rate| *rate > limit) else { continue };
            if bright == 0 {
                return Ok(None);
            }
            let rate = of_ray[bright];
            brackets.push(Bracket { ray, dark: z(bright - 1), bright: z(bright), rate, limit });
        }
        if brackets.len() < TUNING.edges.least_lines {
            return Ok(None);
        }
        self.bisect(&mut brackets, TUNING.edges.first_bisections).await?;
        let jumps = |b: &&Bracket| b.rate > TUNING.edges.jump_ratio * b.limit;
        let jumping = brackets.iter().filter(jumps).count();
        let is_jump = 2 * jumping > brackets.len();
        if is_jump {
            self.bisect(&mut brackets, TUNING.edges.last_bisections).await?;
        }
        let radius = |b: &Bracket, z: f64| {
            let [u, v] = self.places[b.ray];
            let position = self.atlas.near_chart(self.body).world_from_chart([u, v, z]).position;
            self.atlas.radius(self.body, position)
        };
        let dark = brackets.iter().map(|b| radius(b, b.dark));
        let bright = brackets.iter().map(|b| radius(b, b.bright)).fold(0.0, f64::max);
        let (lowest, highest) = dark.fold((f64::INFINITY, 0.0_f64), |(low, high), radius| {
            (low.min(radius), high.max(radius))
        });
        let is_sphere = highest - lowest <= TUNING.edges.same_radius * lowest;
        let radius = if is_jump { bright } else { lowest };
        let is_edge = (is_sphere || !is_jump) && lowest > 1.0;
        Ok(is_edge.then_some(FoundEdge { body: self.body, radius }))
    }

    /// Halves all brackets so many times.
    async fn bisect(&self, brackets: &mut [Bracket], times: usize) -> Result<(), Stop> {
        for _ in 0..times {
            let middle = |b: &Bracket| 0.5 * (b.dark + b.bright);
            let at: Vec<(usize, f64)> = brackets.iter().map(|b| (b.ray, middle(b))).collect();
            for (bracket, rate) in brackets.iter_mut().zip(self.rates(&at).await?) {
                let middle = middle(bracket);
                if rate > bracket.limit {
                    (bracket.bright, bracket.rate) = (middle, rate);
                } else {
                    bracket.dark = middle;
                }
            }
        }
        Ok(())
    }
}
