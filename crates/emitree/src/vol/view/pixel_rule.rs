//! Quadrature over a pixel that edges may cross: limbs, and the rim of a disc.
//!
//! Edges are known from geometry, as changes of a label, and need no evaluation. A pixel is scanned
//! along lines that are across its edges. Each line is divided at the edges, and the sequence of
//! lines where an edge crosses the sides of the pixel, so that every part has a smooth integrand
//! and a Gauss–Legendre rule converges. The radiance beside a limb has the square root of the
//! distance from it, for which the nodes of a line are denser towards its edges.

use crate::vol::view::line_scan::{LineScan, Places};
use crate::vol::view::squares::Square;
use bilby::GaussLegendre;

/// Nodes on the unit interval with their weights.
type Rule = Vec<(f64, f64)>;
/// A node: its place in the pixel, from 0 to 1 along x and y, and its weight.
pub(crate) type RuleNode = ([f64; 2], f64);
/// How a pixel is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Crossing {
    /// No edge is near.
    None,
    /// It is outside of the image.
    Outside,
    /// An edge may be beside it.
    Beside,
    /// An edge may cross it; with so many parts along each side a body is not smaller than a part.
    Crossed(usize),
}

/// The number of intervals along each side of a part at whose ends labels are compared first.
const PROBES: usize = 4;
/// The number of bisections between two lines with different labels.
const CORNER_BISECTIONS: usize = 16;
/// The least number of lines for each part of the sequence, and of nodes for each part of a line.
const LINES: usize = 5;
const NODES_OF_LINE: usize = 6;
/// The least number of nodes along each axis of a pixel beside an edge.
const BESIDE: usize = 6;
/// The number of nodes that finer rules have more: along each axis beside an edge, and along lines across one; of these
/// lines; and along each axis elsewhere.
const MORE_BESIDE: usize = 2;
const MORE_LINES: usize = 2;
const MORE: usize = 1;

/// The number of nodes along each axis of a square that is no larger than its distance from a singularity, 0.8 of
/// it at the least: the rule is then exact to 6e-5.
const NODES_OF_SQUARE: usize = 3;
/// The number of nodes of a line on each side of an axis at which the radiance is singular.
const NODES_AT_AXIS: usize = 8;

/// The rules of one image.
#[derive(Clone, Debug)]
pub(crate) struct PixelRules {
    whole: Rule,
    finer: Rule,
    beside: Rule,
    finer_beside: Rule,
    /// Of the lines across edges, and of the nodes on each.
    crossed: [Rule; 2],
    finer_crossed: [Rule; 2],
    of_square: Rule,
    crossed_square: [Rule; 2],
    at_axis: [Rule; 2],
}

impl PixelRules {
    /// Rules with `whole` nodes along each axis of a pixel without edges.
    pub(crate) fn new(whole: usize) -> Self {
        let denser = |number: usize| gauss(number).into_iter().map(denser_at_ends).collect();
        Self {
            whole: gauss(whole),
            finer: gauss(whole + MORE),
            beside: denser(whole.max(BESIDE)),
            finer_beside: denser(whole.max(BESIDE) + MORE_BESIDE),
            crossed: [gauss(whole.max(LINES)), denser(whole.max(NODES_OF_LINE))],
            finer_crossed: [
                gauss(whole.max(LINES) + MORE_LINES),
                denser(whole.max(NODES_OF_LINE) + MORE_BESIDE),
            ],
            of_square: gauss(NODES_OF_SQUARE),
            crossed_square: [gauss(LINES), denser(whole.max(NODES_OF_LINE))],
            // Close to the end the nodes are at its fourth power.
            at_axis: [
                gauss(LINES),
                denser(NODES_AT_AXIS).into_iter().map(denser_at_ends).collect(),
            ],
        }
    }

    /// The nodes of a pixel, finer at each level; their weights add up to its part inside the image. At level 1 it has
    /// more nodes, and from level 2 on it is divided in halves along each axis at each level.
    pub(crate) fn nodes(&self, crossing: Crossing, level: u8, places: Places<'_>) -> Vec<RuleNode> {
        let is_finer = level > 0;
        let least = if let Crossing::Crossed(parts) = crossing { parts } else { 1 };
        let parts = least << level.saturating_sub(1);
        let size = 1.0 / parts as f64;
        let mut nodes = Vec::new();
        for part in 0..parts * parts {
            let corner = [part % parts, part / parts].map(|k| k as f64 * size);
            let inside = Square { corner, size, touches_axis: false };
            let of_part = match crossing {
                Crossing::None => product(if is_finer { &self.finer } else { &self.whole }),
                Crossing::Outside => Vec::new(),
                Crossing::Beside => {
                    product(if is_finer { &self.finer_beside } else { &self.beside })
                }
                Crossing::Crossed(_) => {
                    let rules = if is_finer { &self.finer_crossed } else { &self.crossed };
                    self.nodes_of_part(rules, &inside, places)
                }
            };
            let of_pixel = |(inner, weight)| (inside.place(inner), size * size * weight);
            nodes.extend(of_part.into_iter().map(of_pixel));
        }
        nodes
    }

    /// The nodes of a square of a pixel that is smaller than the pixel.
    pub(crate) fn nodes_of_square(
        &self,
        square: &Square,
        crossing: Crossing,
        places: Places<'_>,
    ) -> Vec<RuleNode> {
        let nodes = match (square.touches_axis, crossing) {
            (true, _) => self.nodes_of_part(&self.at_axis, square, places),
            (false, Crossing::Crossed(_)) => {
                self.nodes_of_part(&self.crossed_square, square, places)
            }
            (false, _) => product(&self.of_square),
        };
        let area = square.size * square.size;
        let of_pixel = |(at, weight)| (square.place(at), area * weight);
        nodes.into_iter().map(of_pixel).collect()
    }

    /// The nodes of a part that edges may cross, with a rule for the lines, and one for each line from one edge
    /// to the next.
    fn nodes_of_part(
        &self,
        [rule, of_line_rule]: &[Rule; 2],
        part: &Square,
        places: Places<'_>,
    ) -> Vec<RuleNode> {
        let label = |inner| (places.label)(part.place(inner));
        let Some(is_turned) = direction_of_lines(part, places) else {
            // An edge that none of the places shows is beside the part.
            return if label([0.0; 2]).is_some() { product(&self.beside) } else { Vec::new() };
        };
        let turn = |[s, t]: [f64; 2]| if is_turned { [t, s] } else { [s, t] };
        let scan = |t: f64| LineScan::new(places, &|s| part.place(turn([s, t])));
        // The places at which an edge enters or leaves through a side.
        let mut cuts = vec![0.0, 1.0];
        for side in [0.0, 1.0] {
            let along = |t: f64| part.place(turn([side, t]));
            cuts.extend(LineScan::new(places, &along).changes());
        }
        cuts.sort_by(f64::total_cmp);
        let sections = cuts.windows(2).filter(|pair| pair[1] > pair[0]);
        let mut nodes = Vec::new();
        for section in sections.flat_map(|pair| sections_between(rule, [pair[0], pair[1]], &scan)) {
            for (line, of_section) in section.lines.iter().zip(rule) {
                let parts = line.scan.ends.windows(2).zip(&line.scan.labels);
                for (ends, _) in parts.filter(|(ends, label)| ends[1] > ends[0] && label.is_some())
                {
                    let width = ends[1] - ends[0];
                    for &(along, weight) in of_line_rule {
                        let place = turn([ends[0] + along * width, line.t]);
                        nodes.push((place, weight * width * of_section.1 * section.length));
                    }
                }
            }
        }
        nodes
    }
}

/// Whether the lines across the edges of a part are along the second axis: the axis on which labels change more
/// often; `None` if no edge crosses the part.
fn direction_of_lines(part: &Square, places: Places<'_>) -> Option<bool> {
    let at = |k: usize| k as f64 / PROBES as f64;
    let label = |i: usize, j: usize| (places.label)(part.place([at(i), at(j)]));
    let rows: Vec<Vec<Option<u64>>> =
        (0..=PROBES).map(|j| (0..=PROBES).map(|i| label(i, j)).collect()).collect();
    let along_x = rows.iter().flat_map(|row| row.windows(2)).filter(|pair| pair[0] != pair[1]);
    let pairs = rows.windows(2).flat_map(|rows| rows[0].iter().zip(&rows[1]));
    let changes = [along_x.count(), pairs.filter(|(a, b)| a != b).count()];
    if changes != [0, 0] {
        return Some(changes[1] > changes[0]);
    }
    // An edge that enters and leaves through one side is crossed by lines from there.
    let crosses = |side: &dyn Fn(f64) -> [f64; 2]| {
        LineScan::new(places, &|s| part.place(side(s))).labels.len() > 1
    };
    let sides = |side: f64| (crosses(&|s| [s, side]), crosses(&|s| [side, s]));
    let [(bottom, left), (top, right)] = [0.0, 1.0].map(sides);
    (bottom || top || left || right).then_some(bottom || top)
}

/// A line across a section, at `t`.
struct LineAcross {
    t: f64,
    scan: LineScan,
}

/// A sequence of lines on which labels change in the same order.
struct Section {
    length: f64,
    /// One for each node of the rule.
    lines: Vec<LineAcross>,
}

impl Section {
    fn new(rule: &Rule, [from, to]: [f64; 2], scan: &dyn Fn(f64) -> LineScan) -> Self {
        let length = to - from;
        let line = |(along, _): &(f64, f64)| {
            let t = from + along * length;
            LineAcross { t, scan: scan(t) }
        };
        Self { length, lines: rule.iter().map(line).collect() }
    }

    /// The places at which the labels on its lines change: where edges meet, and where one touches a line.
    fn corners(&self, scan: &dyn Fn(f64) -> LineScan) -> Vec<f64> {
        let pairs = self.lines.windows(2);
        let changed = pairs.filter(|pair| pair[0].scan.labels != pair[1].scan.labels);
        let corner = |pair: &[LineAcross]| {
            let (mut low, mut high) = (pair[0].t, pair[1].t);
            for _ in 0..CORNER_BISECTIONS {
                let middle = 0.5 * (low + high);
                let is_before = scan(middle).labels == pair[0].scan.labels;
                if is_before { low = middle } else { high = middle }
            }
            0.5 * (low + high)
        };
        changed.map(corner).collect()
    }
}

/// The sections between two places at which edges cross a side, divided at corners.
fn sections_between(
    rule: &Rule,
    pair @ [from, to]: [f64; 2],
    scan: &dyn Fn(f64) -> LineScan,
) -> Vec<Section> {
    let whole = Section::new(rule, pair, scan);
    let corners = whole.corners(scan);
    if corners.is_empty() {
        return vec![whole];
    }
    let begins = core::iter::once(from).chain(corners.iter().copied());
    let ends = corners.iter().copied().chain([to]);
    begins.zip(ends).map(|(from, to)| Section::new(rule, [from, to], scan)).collect()
}

/// Gauss–Legendre nodes on the unit interval.
fn gauss(number: usize) -> Rule {
    let Ok(rule) = GaussLegendre::new(number) else { return Vec::new() };
    let nodes = rule.nodes().iter().zip(rule.weights());
    nodes.map(|(at, weight)| (0.5 * (1.0 + at), 0.5 * weight)).collect()
}

/// The substitution 3t² − 2t³, which makes square roots at both ends smooth.
fn denser_at_ends((t, weight): (f64, f64)) -> (f64, f64) {
    (t * t * (3.0 - 2.0 * t), weight * 6.0 * t * (1.0 - t))
}

fn product(rule: &Rule) -> Vec<RuleNode> {
    let pairs = rule.iter().flat_map(|&(y, of_row)| {
        rule.iter().map(move |&(x, of_column)| ([x, y], of_row * of_column))
    });
    pairs.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vol::view::line_scan::Label;
    use core::f64::consts::PI;

    fn integral(nodes: &[RuleNode], f: impl Fn([f64; 2]) -> f64) -> f64 {
        nodes.iter().map(|(place, weight)| weight * f(*place)).sum()
    }

    fn nodes_of(rules: &PixelRules, crossing: Crossing, label: &Label<'_>) -> Vec<RuleNode> {
        rules.nodes(crossing, 0, Places { label, misses: &|_, _| {} })
    }

    #[test]
    fn the_square_root_at_a_limb_is_integrated_on_both_sides() {
        let rules = PixelRules::new(3);
        for (x, y, radius) in
            [(0.3, -2.1, 2.5), (-1.7, -1.2, 2.4), (1.9, 0.5, 1.5), (-3.0, 0.4, 3.6)]
        {
            let within = |[a, b]: [f64; 2]| radius * radius - (a - x).powi(2) - (b - y).powi(2);
            let label = |place| Some(u64::from(within(place) > 0.0));
            let nodes = nodes_of(&rules, Crossing::Crossed(1), &label);
            let found = integral(&nodes, |place| within(place).abs().sqrt());
            // The same by so many parts that it is exact.
            let exact = integral(&nodes_of(&rules, Crossing::Crossed(40), &label), |place| {
                within(place).abs().sqrt()
            });
            assert!((found - exact).abs() < 1e-5, "{x} {y} {radius}: {found} {exact}");
            assert!((integral(&nodes, |_| 1.0) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_disc_in_a_pixel_has_its_area() {
        let rules = PixelRules::new(3);
        let label = |[x, y]: [f64; 2]| ((x - 0.47).hypot(y - 0.52) < 0.07).then_some(0);
        // A part is no larger than 1.4 times the disc.
        for (parts, allowed) in [(10, 1e-4), (16, 1e-5), (30, 1e-7)] {
            let area = integral(&nodes_of(&rules, Crossing::Crossed(parts), &label), |_| 1.0);
            assert!((area / (PI * 0.07 * 0.07) - 1.0).abs() < allowed, "{parts}: {area}");
        }
    }

    #[test]
    fn pixels_without_edges_have_products_of_gauss_rules() {
        let rules = PixelRules::new(3);
        let label = |_| Some(0);
        // Polynomials of degree 5 are exact.
        let found =
            integral(&nodes_of(&rules, Crossing::None, &label), |[x, y]| x.powi(5) * y.powi(4));
        assert!((found - 1.0 / 30.0).abs() < 1e-14, "{found}");
        // Square roots at the borders are integrated beside an edge.
        let beside = nodes_of(&rules, Crossing::Beside, &label);
        let found = integral(&beside, |[x, y]| (x * (1.0 - y)).sqrt());
        assert!((found - 4.0 / 9.0).abs() < 1e-4, "{found}");
        // An edge that is not in the pixel changes nothing.
        assert_eq!(nodes_of(&rules, Crossing::Crossed(1), &label).len(), beside.len());
    }

    #[test]
    fn a_straight_edge_divides_a_pixel_exactly() {
        let rules = PixelRules::new(3);
        for (a, b) in [(0.3, 0.2), (-0.1, 0.9), (0.5, 0.0), (1.2, -1.7)] {
            let is_inside = |[x, y]: [f64; 2]| x < a + b * y;
            let label = |place| is_inside(place).then_some(0);
            for parts in [1, 3] {
                let nodes = nodes_of(&rules, Crossing::Crossed(parts), &label);
                assert!(nodes.iter().all(|(place, _)| is_inside(*place)));
                let area = integral(&nodes, |_| 1.0);
                // The mean of the clipped width by many midpoints.
                let width = |k: u32| (a + b * (f64::from(k) + 0.5) / 20_000.0).clamp(0.0, 1.0);
                let expected = (0..20_000).map(width).sum::<f64>() / 20_000.0;
                assert!((area - expected).abs() < 1e-8, "{a} {b} {parts}: {area} {expected}");
            }
        }
    }

    #[test]
    fn a_pixel_outside_the_image_has_no_nodes() {
        let rules = PixelRules::new(2);
        assert!(nodes_of(&rules, Crossing::Crossed(2), &|_| None).is_empty());
    }
}
