//! Charts: coordinates in which a view with opaque bodies, edges of the emission and bounds is
//! smooth.
//!
//! The image of a view with a body is singular along its limb, and no tree or product represents it
//! well. In angles about the body that are adapted to the limb it is smooth: the *atlas* of a view
//! divides each line of sight into pieces, each with its place in one chart, and the image is
//! sampled from the charts. It depends on the observer, the bodies, edges and bounds alone: cameras
//! of all kinds, and the faces of a sky, have the same charts.
//!
//! * `shells`: concentric surfaces, and lines of sight relative to them;
//! * `aim`: a line of sight relative to a centre or an axis;
//! * `axis`: lines of sight relative to an axis at which the emission is singular;
//! * `singular`: coordinates of lines that pass a singularity;
//! * `singularities`: the coordinates about those of a view, and where they are in the image;
//! * `sectors`: parts of the azimuth between planes on which g jumps or has a kink;
//! * `faces`: lines of sight by the faces at which they enter and leave bounds that are a box;
//! * `layer`: the parts of lines on each side of planes on which g jumps or has a kink;
//! * `piece`: the pieces of lines between surfaces, their coordinates and depths;
//! * `chart`: a piece in view as a map from the unit cube;
//! * `stretch`: depths with more places where the emission is;
//! * `remapped`: a chart with the depths of a layer or of a stretch.

mod aim;
mod axis;
pub(crate) mod chart;
pub(crate) mod depth;
mod excluded;
mod faces;
pub(crate) mod layer;
mod piece;
pub(crate) mod remapped;
mod sectors;
mod shells;
mod singular;
mod singularities;
pub(crate) mod stretch;
pub(crate) mod unclipped;

use crate::projection::ViewGeometry;
use crate::projection::bounds::Bounds;
use crate::projection::edge::Edge;
use crate::projection::ellipsoid::Ellipsoid;
use crate::projection::region::Region;
use crate::projection::surroundings::{SightLine, Surroundings};
use chart::{Chart, PieceChart, Window};
use core::f64::consts::TAU;
use depth::Weights;
use faces::{Faces, Passage};
use layer::{Layer, layers};
use piece::{Piece, Side};
use remapped::{Remap, Remapped};
use shells::Shells;
pub(crate) use singularities::NearSingularity;

/// The charts of a view.
#[derive(Debug)]
pub(crate) struct Atlas<'a> {
    surroundings: &'a Surroundings,
    /// The image planes of all tiles.
    tiles: Vec<&'a dyn ViewGeometry>,
    /// Surfaces around each body, and around other centres.
    shells: Vec<Shells>,
    /// The faces of bounds that are a box, if there are no shells.
    faces: Option<Faces>,
    /// The regions between planes that divide all charts; none without such planes.
    layers: Vec<Layer>,
    /// What the charts are of, by their numbers.
    charts: Vec<LayerOf>,
    /// The weights of the coordinates of depth where they have been fitted.
    fitted: Vec<FittedDepth>,
}

/// A chart of lines, or its part in a layer.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LayerOf {
    lines: ChartOf,
    /// The number of the layer, if planes divide the charts.
    layer: Option<usize>,
}

/// What a chart is of.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ChartOf {
    /// A side of a piece of the lines in a sector around the centre of shells, given by their number.
    Piece { shells: usize, piece: Piece, side: Side, sector: usize },
    /// The lines of a passage through a box.
    Passage(Passage),
}

/// A piece of a line of sight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PieceOfLine {
    /// The number of its chart.
    pub(crate) chart: usize,
    /// The coordinates (c, φ) of the line in the chart.
    pub(crate) place: [f64; 2],
    /// The factor of the path in the chart, below 1 near a singularity.
    pub(crate) density: f64,
}

/// The weights of the coordinates of depth in a piece, fitted to samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FittedDepth {
    /// The number of the shells.
    pub(crate) shells: usize,
    piece: Piece,
    weights: Weights,
}

/// A surface of the shape of a body at which samples found the beginning of the emission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FoundEdge {
    /// The number of the body.
    pub(crate) body: usize,
    /// Its size in units of the body.
    pub(crate) radius: f64,
}

/// An azimuth about the axis of shells at which samples found a jump or a kink of g.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FoundCut {
    /// The number of the shells.
    pub(crate) shells: usize,
    pub(crate) azimuth_rad: f64,
}

impl<'a> Atlas<'a> {
    /// The atlas of a view on `tiles` with this height and width, with the declared edges and those `found`;
    /// `None` if no surface has a limb and the emission is nowhere singular.
    pub(crate) fn new(
        tiles: Vec<&'a dyn ViewGeometry>,
        tile_shape: [usize; 2],
        found: &[FoundEdge],
    ) -> Option<Self> {
        let surroundings = tiles.first()?.surroundings()?;
        let mut shells = shells_of(surroundings);
        for edge in found {
            if let Some(shells) = shells.iter_mut().find(|shells| shells.body == Some(edge.body)) {
                shells.insert(edge.radius);
                shells.has_found_edge = true;
            }
        }
        let mut centres: Vec<Ellipsoid> = Vec::new();
        centres
            .extend(shells.iter().filter(|shells| !shells.is_only_bounds()).map(|of| of.reference));
        centres.sort_by(|a, b| b.longest().total_cmp(&a.longest()));
        for shells in &mut shells {
            let size = shells.reference.longest();
            let others = centres.iter().filter(|centre| centre.longest() > size);
            shells.others = others.take(depth::MOST_CENTRES).copied().collect();
        }
        let centres = &centres[..centres.len().min(depth::MOST_CENTRES)];
        singularities::insert(&mut shells, surroundings, centres, (tiles[0], tile_shape));
        shells.retain(|shells| shells.limbs > 0 || shells.singular.is_some());
        if shells.is_empty() {
            return None;
        }
        for edge in &surroundings.edges {
            let Edge::Plane { position, normal } = *edge else { continue };
            shells.iter_mut().for_each(|shells| shells.cut_at_plane(position, normal));
        }
        let charts = in_layers(&[], charts_of(&shells));
        let (faces, layers, fitted) = (None, Vec::new(), Vec::new());
        let mut atlas = Self { surroundings, tiles, shells, faces, layers, charts, fitted };
        atlas.exclude_singularities();
        Some(atlas)
    }

    /// The atlas of a view on `tiles` without limbs and singularities whose bounds are a box; `None` if they are
    /// not.
    pub(crate) fn of_box(tiles: Vec<&'a dyn ViewGeometry>) -> Option<Self> {
        let surroundings = tiles.first()?.surroundings()?;
        let Some(Bounds::Cuboid(cuboid)) = surroundings.bounds else { return None };
        let faces = Faces::new(cuboid, surroundings.observer);
        let passages = faces.passages().iter().copied().map(ChartOf::Passage).collect();
        let charts = in_layers(&[], passages);
        let (shells, layers, fitted) = (Vec::new(), Vec::new(), Vec::new());
        Some(Self { surroundings, tiles, shells, faces: Some(faces), layers, charts, fitted })
    }

    /// The same atlas with charts that end at these azimuths, too.
    pub(crate) fn with_cuts(mut self, cuts: &[FoundCut]) -> Self {
        for cut in cuts {
            self.shells[cut.shells].sectors.cut(cut.azimuth_rad);
        }
        self.charts = in_layers(&self.layers, charts_of(&self.shells));
        self
    }

    /// The same atlas with charts divided into the [`layers`] that some tile has with the cosine `least_cosine`.
    pub(crate) fn with_layers(mut self, least_cosine: f64) -> Self {
        let mut of_tiles = self.tiles.iter().map(|tile| layers(*tile, least_cosine));
        self.layers = of_tiles.find(|layers| !layers.is_empty()).unwrap_or_default();
        let mut lines: Vec<ChartOf> = self.charts.iter().map(|of| of.lines).collect();
        lines.dedup();
        self.charts = in_layers(&self.layers, lines);
        self
    }

    /// Whether the only surface is that of the bounds, and all lines of sight pass well inside of its limb: nothing
    /// is singular in view.
    pub(crate) fn is_inside_bounds(&self) -> bool {
        /// How far inside, as a share of the radius.
        const INSIDE: f64 = 0.9;
        let [only] = &self.shells[..] else { return false };
        if !only.is_only_bounds() || only.singular.is_some() {
            return false;
        }
        let is_inside = |line: SightLine| {
            let aim = only.aim(&line);
            aim.is_ahead && aim.miss < INSIDE * only.radii[0]
        };
        self.lattice_of_lines().all(|line| line.is_some_and(is_inside))
    }

    /// Whether planes divide the charts.
    pub(crate) fn has_layers(&self) -> bool {
        !self.layers.is_empty()
    }

    /// The weights of the coordinates of depth in a chart; `None` if there is one coordinate only.
    pub(crate) fn weights(&self, chart: usize) -> Option<Weights> {
        let ChartOf::Piece { shells, piece, .. } = self.charts[chart].lines else { return None };
        Some(self.weights_of(shells, piece))
    }

    /// The weights of the coordinates of depth in a piece.
    fn weights_of(&self, shells: usize, piece: Piece) -> Weights {
        let is_own = |of: &&FittedDepth| (of.shells, of.piece) == (shells, piece);
        let usual = || self.shells[shells].usual_weights(piece);
        self.fitted.iter().find(is_own).map_or_else(usual, |fitted| fitted.weights)
    }

    /// Whether some charts have other weights than the usual ones.
    pub(crate) fn has_fitted_depths(&self) -> bool {
        !self.fitted.is_empty()
    }

    /// Other weights for the piece of a chart; `None` if there is one coordinate only.
    pub(crate) fn fitted(&self, chart: usize, weights: Weights) -> Option<FittedDepth> {
        let ChartOf::Piece { shells, piece, .. } = self.charts[chart].lines else { return None };
        Some(FittedDepth { shells, piece, weights })
    }

    /// The same atlas with other weights in some pieces.
    pub(crate) fn with_weights(mut self, fitted: &[FittedDepth]) -> Self {
        self.fitted.extend(fitted);
        self
    }

    /// The same atlas with the pieces that pass a centre around a surface divided at the points nearest to it, where
    /// that is possible.
    pub(crate) fn with_halves(mut self) -> Self {
        let possible: Vec<bool> =
            self.shells.iter().map(|shells| self.have_nearest(shells)).collect();
        let halved = self.shells.iter_mut().zip(possible);
        halved.for_each(|(shells, is_halved)| shells.is_halved = is_halved);
        self.charts = in_layers(&self.layers, charts_of(&self.shells));
        self
    }

    /// Whether all lines of sight in view that pass a centre are nearest to it between their ends.
    fn have_nearest(&self, shells: &Shells) -> bool {
        let has_nearest = |line: SightLine| {
            let nearest = shells.aim(&line).nearest;
            let ends_at_body = matches!(self.surroundings.end_of(&line).0, Region::Body(_));
            ends_at_body || (line.ends[0] < nearest && nearest < line.ends[1])
        };
        shells.singular.is_none() && self.lattice_of_lines().flatten().all(has_nearest)
    }

    /// Lines of sight at a lattice of places on the tiles, with those at their borders; `None` where there is none.
    fn lattice_of_lines(&self) -> impl Iterator<Item = Option<SightLine>> {
        /// Lines along each side of a tile.
        const LINES: usize = 17;
        let place = |k: usize| k as f64 / (LINES - 1) as f64;
        let of_tile = move |tile: &&'a dyn ViewGeometry| {
            let tile = *tile;
            (0..LINES * LINES).map(move |k| tile.line([place(k % LINES), place(k / LINES)]))
        };
        self.tiles.iter().flat_map(of_tile)
    }

    /// Whether some pieces are divided at the points nearest to a centre.
    pub(crate) fn has_halves(&self) -> bool {
        self.shells.iter().any(|shells| shells.is_halved)
    }

    /// Whether a chart is of a piece that passes a centre around a surface, and can be divided there.
    pub(crate) fn can_be_halved(&self, chart: usize) -> bool {
        let ChartOf::Piece { shells, piece, .. } = self.charts[chart].lines else { return false };
        let shells = &self.shells[shells];
        shells.passes(piece) && self.have_nearest(shells)
    }

    /// The cut through a chart at the coordinate v of a window; `None` if v is no azimuth.
    pub(crate) fn cut(&self, chart: usize, window: &Window, v: f64) -> Option<FoundCut> {
        let [begin, width] = window.azimuth_rad;
        match self.charts[chart].lines {
            ChartOf::Piece { shells, .. } => {
                Some(FoundCut { shells, azimuth_rad: begin + v * width })
            }
            ChartOf::Passage(_) => None,
        }
    }

    /// The beginning and the width of the second coordinate of a chart; `None` if it is the azimuth of the whole
    /// circle.
    pub(crate) fn sector_rad(&self, chart: usize) -> Option<[f64; 2]> {
        match self.charts[chart].lines {
            ChartOf::Piece { shells, sector, .. } => {
                self.shells[shells].sectors.azimuth_rad(sector)
            }
            ChartOf::Passage(_) => Some([0.0, 1.0]),
        }
    }

    /// Whether there are shells with this number.
    pub(crate) fn has_shells(&self, number: usize) -> bool {
        number < self.shells.len()
    }

    /// The number of tiles of the image.
    pub(crate) fn tiles(&self) -> usize {
        self.tiles.len()
    }

    /// The bodies in view around which no edge is known.
    pub(crate) fn bodies_without_edges(&self) -> Vec<usize> {
        let seen = self.bodies_in_view();
        let is_alone =
            |shells: &&Shells| shells.radii.len() == 1 + usize::from(shells.is_dark_beyond);
        let bodies = self.shells.iter().filter(is_alone).filter_map(|shells| shells.body);
        bodies.filter(|body| seen.contains(body)).collect()
    }

    /// The bodies at some of the places of a lattice on the tiles.
    fn bodies_in_view(&self) -> Vec<usize> {
        const PLACES: usize = 32;
        let place = |k: usize| (k as f64 + 0.5) / PLACES as f64;
        let lattice = || (0..PLACES * PLACES).map(|k| [place(k % PLACES), place(k / PLACES)]);
        let regions = self.tiles.iter().flat_map(|tile| lattice().map(|xy| tile.region(xy)));
        let mut bodies: Vec<usize> = regions
            .filter_map(|region| if let Region::Body(body) = region { Some(body) } else { None })
            .collect();
        bodies.sort_unstable();
        bodies.dedup();
        bodies
    }

    /// The shells around a body.
    fn around(&self, body: usize) -> usize {
        self.shells.iter().position(|shells| shells.body == Some(body)).unwrap_or(0)
    }

    /// The chart of all lines of sight to a body.
    pub(crate) fn near_chart(&'a self, body: usize) -> PieceChart<'a> {
        let shells = &self.shells[self.around(body)];
        let piece = Piece::Near(0);
        let window = Window { c: shells.natural_ends(piece), azimuth_rad: [0.0, TAU] };
        let (surroundings, tiles) = (self.surroundings, self.tiles.clone());
        let weights = shells.usual_weights(piece);
        PieceChart { surroundings, shells, piece, side: Side::Both, weights, window, tiles }
    }

    /// The size, in units of a body, of the surface of its shape through a position.
    pub(crate) fn radius(&self, body: usize, position: [f64; 3]) -> f64 {
        self.shells[self.around(body)].radius_at(position)
    }

    /// Whether samples found no emission where a chart is.
    pub(crate) fn looks_dark(&self, chart: usize) -> bool {
        let ChartOf::Piece { shells, piece, .. } = self.charts[chart].lines else { return false };
        self.shells[shells].has_found_edge && matches!(piece, Piece::Near(0) | Piece::Chord(1))
    }

    /// The number of charts.
    pub(crate) fn len(&self) -> usize {
        self.charts.len()
    }

    /// A number for the zones of a line of sight: where it changes, the image is singular.
    pub(crate) fn zones(&self, line: &SightLine) -> u64 {
        let add = |all: u64, zone: usize| all.wrapping_mul(31).wrapping_add(zone as u64);
        let zones = match &self.shells[..] {
            [only] if self.layers.is_empty() => {
                let aim = only.aim(line);
                let is_cut = only.sectors.len() > 1;
                add(if is_cut { only.sectors.of(aim.azimuth()) as u64 } else { 0 }, only.zone(&aim))
            }
            all => {
                let zones = all.iter().map(|shells| shells.zone(&shells.aim(line)));
                zones.fold(self.sectors(line), add)
            }
        };
        match self.surroundings.end_of(line).0 {
            Region::Body(number) => zones.wrapping_mul(31).wrapping_add(1 + number as u64),
            Region::Sky | Region::Outside => zones.wrapping_mul(31),
        }
    }

    /// A number for the sectors of a line of sight, or for its passage through a box, and for the pieces that
    /// planes divide.
    pub(crate) fn sectors(&self, line: &SightLine) -> u64 {
        let add = |all: u64, number: usize| all.wrapping_mul(31).wrapping_add(number as u64);
        let passage = self.faces.as_ref().and_then(|faces| faces.place(line));
        let cut = self.shells.iter().filter(|shells| shells.sectors.len() > 1);
        let sectors = cut.map(|shells| shells.sectors.of(shells.aim(line).azimuth()));
        let sectors = sectors.fold(passage.map_or(0, |(passage, _)| 1 + passage as u64), add);
        let Some(layer) = self.layers.first() else { return sectors };
        let divided = |distance: f64| {
            let [begin, end] = line.ends;
            if distance <= begin {
                return 0;
            }
            if distance >= end {
                return 1;
            }
            let around = |shells: &Shells| {
                let radius = shells.radius_at(line.at(distance));
                shells.radii.partition_point(|of| *of < radius)
            };
            2 + self.shells.iter().map(around).sum::<usize>()
        };
        layer.crossings(line).map(divided).fold(sectors, add)
    }

    /// For each shells the distance of a line from the centre, in units of the radius of each
    /// limb: the limb is at 1.
    pub(crate) fn misses(&self, line: &SightLine, misses: &mut Vec<f64>) {
        misses.clear();
        for shells in &self.shells {
            let aim = shells.aim(line);
            let miss = if aim.is_ahead { aim.miss } else { 2.0 * shells.distance - aim.miss };
            misses.extend(shells.radii[..shells.limbs].iter().map(|radius| miss / radius));
        }
    }

    /// The pieces of a line of sight that are not empty.
    pub(crate) fn pieces(&self, line: &SightLine, pieces: &mut Vec<PieceOfLine>) {
        pieces.clear();
        if let Some((passage, place)) = self.faces.as_ref().and_then(|faces| faces.place(line)) {
            let layers = self.layers.len().max(1);
            let charts = (passage * layers..).take(layers);
            let in_layer = charts.filter(|chart| self.has_part_of(*chart, line, line.ends));
            pieces.extend(in_layer.map(|chart| PieceOfLine { chart, place, density: 1.0 }));
        }
        let (end, _) = self.surroundings.end_of(line);
        let Some(number) = self.shells_of(line, end) else { return };
        let shells = &self.shells[number];
        let aim = shells.aim(line);
        let zone = shells.zone(&aim);
        let ends_at_body = matches!(end, Region::Body(body) if shells.body == Some(body));
        let azimuth = aim.azimuth();
        let sector = shells.sectors.of(azimuth);
        for (chart, of) in self.charts.iter().enumerate() {
            let ChartOf::Piece { shells: of_shells, piece, side, sector: of_sector } = of.lines
            else {
                continue;
            };
            if of_shells != number || of_sector != sector {
                continue;
            }
            let ends @ [from, to] = shells.range(piece, side, line, &aim);
            let has_piece = shells.has(zone, piece, ends_at_body) && to > from;
            if has_piece && self.has_part_of(chart, line, ends) {
                let c = shells.coordinate(piece, &aim);
                let density = shells.density(piece, c);
                pieces.push(PieceOfLine { chart, place: [c, azimuth], density });
            }
        }
    }

    /// Whether a piece of a line, given its ends, has a part in the layer of a chart.
    fn has_part_of(&self, chart: usize, line: &SightLine, ends: [f64; 2]) -> bool {
        let layer = self.charts[chart].layer;
        layer.is_none_or(|layer| self.layers[layer].has_part_of(line, ends))
    }

    /// The number of the shells in whose coordinates a line is: those of the body at which it ends,
    /// those with a surface that it crosses, or those with the nearest limb.
    fn shells_of(&self, line: &SightLine, end: Region) -> Option<usize> {
        if let Region::Body(body) = end {
            return self.shells.iter().position(|shells| shells.body == Some(body));
        }
        if self.shells.len() == 1 {
            return Some(0);
        }
        let order = |(number, shells): (usize, &Shells)| {
            let aim = shells.aim(line);
            let crosses_edge = !shells.is_only_bounds() && shells.zone(&aim) < shells.limbs;
            (!crosses_edge, shells.clearance(&aim), number)
        };
        let all = self.shells.iter().enumerate().map(order);
        all.min_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))).map(|(_, _, number)| number)
    }

    /// The coordinate c at limbs and on the axis, at which the window of a chart may end.
    pub(crate) fn natural_ends(&self, chart: usize) -> [f64; 2] {
        match self.charts[chart].lines {
            ChartOf::Piece { shells, piece, .. } => self.shells[shells].natural_ends(piece),
            ChartOf::Passage(_) => [0.0, 1.0],
        }
    }

    /// A chart with what is in view of it.
    pub(crate) fn chart(&'a self, chart: usize, window: Window) -> Box<dyn Chart + 'a> {
        let (surroundings, tiles) = (self.surroundings, self.tiles.clone());
        let LayerOf { lines, layer } = self.charts[chart];
        let chart: Box<dyn Chart + 'a> = match lines {
            ChartOf::Piece { shells, piece, side, .. } => {
                let weights = self.weights_of(shells, piece);
                let shells = &self.shells[shells];
                Box::new(PieceChart { surroundings, shells, piece, side, weights, window, tiles })
            }
            ChartOf::Passage(passage) => Box::new(passage.chart(surroundings, window, tiles)),
        };
        match layer {
            Some(layer) => {
                let remap = Remap::Layer(self.layers[layer].clone());
                Box::new(Remapped { chart, remap })
            }
            None => chart,
        }
    }
}

/// The sides of the pieces of all shells in all of their sectors.
fn charts_of(shells: &[Shells]) -> Vec<ChartOf> {
    let of_shells = |(number, shells): (usize, &Shells)| {
        let sectors = 0..shells.sectors.len();
        let pieces = shells.pieces().into_iter();
        let sides = pieces.flat_map(|piece| shells.sides(piece).iter().map(move |of| (piece, *of)));
        let of_side = |(piece, side)| {
            let of_sector = move |sector| ChartOf::Piece { shells: number, piece, side, sector };
            sectors.clone().map(of_sector)
        };
        sides.flat_map(of_side).collect::<Vec<_>>()
    };
    shells.iter().enumerate().flat_map(of_shells).collect()
}

/// All charts in all layers, those of one chart after each other.
fn in_layers(layers: &[Layer], charts: Vec<ChartOf>) -> Vec<LayerOf> {
    let numbers: Vec<Option<usize>> = match layers.len() {
        0 => vec![None],
        count => (0..count).map(Some).collect(),
    };
    let of_chart = |lines| numbers.iter().map(move |layer| LayerOf { lines, layer: *layer });
    charts.into_iter().flat_map(of_chart).collect()
}

/// The surfaces around each body, and around the centres of other edges and of bounds.
fn shells_of(surroundings: &Surroundings) -> Vec<Shells> {
    let observer = surroundings.observer;
    let bodies = surroundings.bodies.iter().enumerate();
    let mut all: Vec<Shells> =
        bodies.map(|(number, body)| Shells::new(*body, Some(number), observer)).collect();
    for edge in &surroundings.edges {
        let Edge::Ellipsoid(edge) = edge else { continue };
        let around = all.iter_mut().find_map(|shells| Some((shells.radius_of(edge)?, shells)));
        match around {
            Some((radius, shells)) => shells.insert_edge(radius),
            None => all.push(Shells::new(*edge, None, observer)),
        }
    }
    if let Some(Bounds::Ellipsoid(bounds)) = surroundings.bounds {
        let around = all.iter_mut().find_map(|shells| {
            let radius = shells.radius_of(&bounds)?;
            (radius > shells.radii[0]).then_some((radius, shells))
        });
        match around {
            Some((radius, shells)) => shells.bound(radius),
            None => {
                let mut bounds = Shells::new(bounds, None, observer);
                bounds.is_dark_beyond = true;
                all.push(bounds);
            }
        }
    }
    all
}

#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_of_faces;
#[cfg(test)]
mod tests_of_sectors;
#[cfg(test)]
mod tests_of_singularities;
