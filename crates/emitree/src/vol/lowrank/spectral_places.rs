//! The places of a cube at which spectra are sampled and checked, on lines through products.

use crate::cell::whole;
use crate::parallel::prelude::*;
use crate::vol::dyadic::{from_unit, unit};
use crate::vol::lattice;
use crate::vol::lowrank::channel::Channel;
use crate::vol::spectrum::energies::Energies;
use crate::vol::spectrum::probes::{ProbePoint, SpotCheck, energies_of_line};
use crate::vol::tuning::TUNING;
use crate::vol::view::part::{Part, Parts};

/// The depths of a line among which the brightest one is chosen.
const DEPTHS: usize = 17;
/// The number of the first line of the checks in the sequence of scattered points, beyond those of verifications.
const FIRST_CHECK: usize = 1 << 27;
/// Lines among which those of spectra are chosen, for each of these.
const CANDIDATES: usize = 4;

/// The lines that are left for each channel.
const LINES_OF_CHANNEL: usize = 1 << 10;

/// A point on a line of sight.
#[derive(Clone, Copy, Debug)]
struct LinePoint {
    point: ProbePoint,
    /// The change of a pixel by a change of G over the effective path of the point.
    path: f64,
    /// The |pixel| of the line.
    brightness: f64,
}

/// Which depth of a line is taken.
#[derive(Clone, Copy, Debug)]
enum Depth {
    Brightest,
    /// That of the scattered point itself.
    Any,
}

/// At most so many points at which spectra are sampled, with their paths: in turn at the brightest depth of a line
/// and at any one. A third of them are on the brightest lines of a channel, the others on all and on any lines.
/// Each number of a channel has other lines.
pub(super) fn points(
    parts: &Parts<'_>,
    channel: &Channel,
    number: usize,
    most: usize,
) -> Vec<(ProbePoint, f64)> {
    let of_part = (CANDIDATES * most).div_ceil(parts.parts.len());
    let first = LINES_OF_CHANNEL * number;
    let of_parts = 0..parts.parts.len();
    let numbers: Vec<(usize, usize)> = of_parts
        .flat_map(|part| (first..first + of_part).map(move |number| (part, number)))
        .collect();
    let brightness = |&(part, number): &(usize, usize)| {
        let of = line_point(parts, channel, part, number, Depth::Brightest)?;
        Some((of.brightness, part, number))
    };
    let mut lines: Vec<(f64, usize, usize)> = numbers.par_iter().filter_map(brightness).collect();
    lines.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let of_brightest = TUNING.spectra.dim_share * lines.first().map_or(0.0, |line| line.0);
    let not_dim = lines.partition_point(|line| line.0 > of_brightest);
    let third = most.div_ceil(3);
    let spread = |to: usize| {
        let stride = (to / third).max(1);
        (stride / 2..to).step_by(stride).take(third)
    };
    let mut chosen: Vec<usize> =
        (0..third.min(lines.len())).chain(spread(not_dim)).chain(spread(lines.len())).collect();
    chosen.sort_unstable();
    chosen.dedup();
    let point = |(k, line): (usize, usize)| {
        let (_, part, number) = lines[line];
        let depth = if k.is_multiple_of(2) { Depth::Brightest } else { Depth::Any };
        let of = line_point(parts, channel, part, number, depth)?;
        Some((of.point, of.path))
    };
    chosen.into_iter().enumerate().filter_map(point).collect()
}

/// Comparisons on new lines of all parts: as many lines as a base lattice of this level has, each at energies of its own in
/// all parts of the band, in turn at the brightest depth of one of the channels and at any one.
pub(super) fn checks(
    parts: &Parts<'_>,
    channels: &[Channel],
    energies: &Energies,
    base_level: u8,
    round: usize,
) -> Vec<SpotCheck> {
    let of_part = |number: usize, part: &Part<'_>| {
        let lines = ((1_usize << part.base_level(base_level)) + 1).pow(2);
        let first = FIRST_CHECK + round * lines;
        (first..first + lines).map(move |line| (number, line))
    };
    let lines: Vec<(usize, usize)> =
        parts.parts.iter().enumerate().flat_map(|(number, part)| of_part(number, part)).collect();
    let of_line = |&(part, number): &(usize, usize)| {
        let half = number / 2;
        let channel = &channels[half % channels.len()];
        let depth = if number.is_multiple_of(2) { Depth::Brightest } else { Depth::Any };
        let of = line_point(parts, channel, part, number, depth)?;
        let rates: Vec<f64> =
            channels.iter().flat_map(|channel| channel.rates(parts, &[of.point])).collect();
        let check = move |energy: u32| SpotCheck {
            point: of.point,
            energy,
            path: of.path,
            weight: 1.0,
            expected: energies.explained(rates.iter().copied(), energy),
        };
        Some(energies_of_line(number - FIRST_CHECK).map(check))
    };
    lines.par_iter().flat_map_iter(|line| of_line(line).into_iter().flatten()).collect()
}

/// A point on the line of a scattered point of a part, if it is in view and not in an opaque body.
fn line_point(
    parts: &Parts<'_>,
    channel: &Channel,
    part: usize,
    number: usize,
    depth: Depth,
) -> Option<LinePoint> {
    let of = &parts.parts[part];
    let chart = &*of.chart;
    let [x, y, any] = lattice::point(number).map(from_unit);
    let xy = [x, y].map(unit);
    if !of.is_in_view(xy) {
        return None;
    }
    let is_good = |depth: u32| {
        let u = [xy[0], xy[1], unit(depth)];
        chart.world_from_chart(u).path_per_depth > 0.0
            && !(chart.has_gaps() && chart.across_gap(u).is_some())
    };
    let depths = (0..DEPTHS).map(|k| from_unit((k as f64 + 0.5) / DEPTHS as f64));
    let depths: Vec<u32> = depths.filter(|depth| is_good(*depth)).collect();
    let point = |depth: u32| ProbePoint { part, place: [x, y], depth };
    let points: Vec<ProbePoint> = depths.iter().map(|depth| point(*depth)).collect();
    let sizes: Vec<f64> = channel.rates(parts, &points).into_iter().map(f64::abs).collect();
    let mean = sizes.iter().sum::<f64>() / DEPTHS as f64;
    let brightest = (0..sizes.len()).max_by(|a, b| sizes[*a].total_cmp(&sizes[*b]).then(b.cmp(a)));
    let chosen = match depth {
        Depth::Brightest if mean > 0.0 => depths[brightest?],
        _ => any,
    };
    if !is_good(chosen) {
        return None;
    }
    let path = mean / channel.rates(parts, &[point(chosen)])[0].abs();
    let path = if path > 0.0 { path.min(1.0) } else { 1.0 };
    let effect = effect(of, xy);
    Some(LinePoint { point: point(chosen), path: path * effect, brightness: mean * effect })
}

/// The change of a pixel by a change of G along a whole line.
fn effect(part: &Part<'_>, [x, y]: [f64; 2]) -> f64 {
    let cell = |at: f64, cells: usize| whole(at * cells as f64).min(cells - 1);
    let scale = &part.scale;
    part.chart.density([x, y]) * scale[(cell(y, scale.height()), cell(x, scale.width()))]
}
