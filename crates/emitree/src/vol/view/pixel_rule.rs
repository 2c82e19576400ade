//! Quadrature over a pixel that edges may cross: limbs, and the rim of a disc.
//!
//! Edges are known from geometry, as changes of a label, and need no evaluation. A pixel is scanned
//! along lines that are across its edges. Each line is divided at the edges, and the sequence of
//! lines where an edge crosses the sides of the pixel, so that every part has a smooth integrand
//! and a Gauss–Legendre rule converges. The radiance beside a limb has the square root of the
//! distance from it, for which the nodes of a line are denser towards its edges.

use crate::vol::view::squares::Square;
use bilby::GaussLegendre;

/// Nodes on the unit interval with their weights.
type Rule = Vec<(f64, f64)>;
/// A node: its place in the pixel, from 0 to 1 along x and y, and its weight.
pub(crate) type RuleNode = ([f64; 2], f64);
/// The label of a place in a pixel, which changes at edges; `None` outside the image.
pub(crate) type Label<'a> = dyn Fn([f64; 2]) -> Option<u64> + 'a;

/// How a pixel is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Crossing {
    /// No edge is near.
    None,
    /// An edge may be beside it.
    Beside,
    /// An edge may cross it; with so many parts along each side a body is not smaller than a part.
    Crossed(usize),
}

/// The number of intervals of a line, and of the sides of a pixel, at whose ends labels are compared.
const PROBES: usize = 8;
/// The number of bisections between two places with different labels: places to 1e-9 of a pixel.
const BISECTIONS: usize = 26;
/// The number of bisections between two lines with different labels, and the most changes between
/// two places.
const CORNER_BISECTIONS: usize = 16;
const MOST_CHANGES: usize = 8;
/// The least number of lines for each part of the sequence, and of nodes for each part of a line.
const LINES: usize = 5;
const NODES_OF_LINE: usize = 6;
/// The least number of nodes along each axis of a pixel beside an edge.
const BESIDE: usize = 6;

/// The number of nodes along each axis of a square that is no larger than its distance from a singularity, 0.8 of
/// it at the least: the rule is then exact to 6e-5.
const NODES_OF_SQUARE: usize = 3;
/// The number of nodes of a line on each side of an axis at which the radiance is singular.
const NODES_AT_AXIS: usize = 8;

/// The rules of one image.
#[derive(Clone, Debug)]
pub(crate) struct PixelRules {
    whole: Rule,
    beside: Rule,
    lines: Rule,
    of_line: Rule,
    of_square: Rule,
    lines_of_square: Rule,
    at_axis: Rule,
}

impl PixelRules {
    /// Rules with `whole` nodes along each axis of a pixel without edges.
    pub(crate) fn new(whole: usize) -> Self {
        let denser = |number: usize| gauss(number).into_iter().map(denser_at_ends).collect();
        Self {
            whole: gauss(whole),
            beside: denser(whole.max(BESIDE)),
            lines: gauss(whole.max(LINES)),
            of_line: denser(whole.max(NODES_OF_LINE)),
            of_square: gauss(NODES_OF_SQUARE),
            lines_of_square: gauss(LINES),
            // Close to the end the nodes are at its fourth power.
            at_axis: denser(NODES_AT_AXIS).into_iter().map(denser_at_ends).collect(),
        }
    }

    /// The nodes of a pixel, divided `level` times in halves along each axis; their weights add up
    /// to its part inside the image.
    pub(crate) fn nodes(&self, crossing: Crossing, level: u8, label: &Label<'_>) -> Vec<RuleNode> {
        let parts = if let Crossing::Crossed(parts) = crossing { parts } else { 1 } << level;
        let size = 1.0 / parts as f64;
        let mut nodes = Vec::new();
        for part in 0..parts * parts {
            let corner = [part % parts, part / parts].map(|k| k as f64 * size);
            let place = |[x, y]: [f64; 2]| [corner[0] + size * x, corner[1] + size * y];
            let of_part = match crossing {
                Crossing::None => product(&self.whole),
                Crossing::Beside => product(&self.beside),
                Crossing::Crossed(_) => {
                    self.nodes_of_part([&self.lines, &self.of_line], &|inner| label(place(inner)))
                }
            };
            let of_pixel = |(inner, weight)| (place(inner), size * size * weight);
            nodes.extend(of_part.into_iter().map(of_pixel));
        }
        nodes
    }

    /// The nodes of a square of a pixel that is smaller than the pixel.
    pub(crate) fn nodes_of_square(
        &self,
        square: &Square,
        crossing: Crossing,
        label: &Label<'_>,
    ) -> Vec<RuleNode> {
        let label = |inner| label(square.place(inner));
        let nodes = match (square.touches_axis, crossing) {
            (true, _) => self.nodes_of_part([&self.lines_of_square, &self.at_axis], &label),
            (false, Crossing::Crossed(_)) => {
                self.nodes_of_part([&self.lines_of_square, &self.of_line], &label)
            }
            (false, _) => product(&self.of_square),
        };
        let area = square.size * square.size;
        let of_pixel = |(at, weight)| (square.place(at), area * weight);
        nodes.into_iter().map(of_pixel).collect()
    }

    /// The nodes of a part that edges may cross, with a rule for the lines, and one for each line from one edge
    /// to the next.
    fn nodes_of_part(&self, [lines, of_line_rule]: [&Rule; 2], label: &Label<'_>) -> Vec<RuleNode> {
        let at = |k: usize| k as f64 / PROBES as f64;
        let found: Vec<Vec<Option<u64>>> =
            (0..=PROBES).map(|j| (0..=PROBES).map(|i| label([at(i), at(j)])).collect()).collect();
        let changes_along_x: usize =
            found.iter().map(|row| row.windows(2).filter(|pair| pair[0] != pair[1]).count()).sum();
        let changes_along_y: usize = found
            .windows(2)
            .map(|rows| rows[0].iter().zip(&rows[1]).filter(|(a, b)| a != b).count())
            .sum();
        if changes_along_x + changes_along_y == 0 {
            // An edge that none of the places shows is beside the part.
            return if found[0][0].is_some() { product(&self.beside) } else { Vec::new() };
        }
        // Lines across the edges: along the axis on which labels change more often.
        let is_turned = changes_along_y > changes_along_x;
        let turn = |[s, t]: [f64; 2]| if is_turned { [t, s] } else { [s, t] };
        let of_line = |s: f64, t: f64| label(turn([s, t]));
        // The places at which an edge enters or leaves through a side.
        let mut cuts = vec![0.0, 1.0];
        for side in [0.0, 1.0] {
            cuts.extend(changes(&|t| of_line(side, t)));
        }
        cuts.sort_by(f64::total_cmp);
        cuts = cuts.windows(2).flat_map(|pair| with_corners(lines, pair, &of_line)).collect();
        cuts.push(1.0);
        let mut nodes = Vec::new();
        for pair in cuts.windows(2).filter(|pair| pair[1] > pair[0]) {
            let length = pair[1] - pair[0];
            for &(along, of_part) in lines {
                let t = pair[0] + along * length;
                let mut ends = vec![0.0];
                ends.extend(changes(&|s| of_line(s, t)));
                ends.push(1.0);
                for ends in ends.windows(2).filter(|ends| ends[1] > ends[0]) {
                    let width = ends[1] - ends[0];
                    if of_line(0.5 * (ends[0] + ends[1]), t).is_none() {
                        continue;
                    }
                    for &(along, weight) in of_line_rule {
                        let place = turn([ends[0] + along * width, t]);
                        nodes.push((place, weight * width * of_part * length));
                    }
                }
            }
        }
        nodes
    }
}

/// The beginning of a part of the sequence of `lines`, and the places in it at which the labels on
/// them change: where edges meet, and where one touches a line.
fn with_corners(lines: &Rule, pair: &[f64], of_line: &dyn Fn(f64, f64) -> Option<u64>) -> Vec<f64> {
    let length = pair[1] - pair[0];
    let labels = |t: f64| labels_along(&|s| of_line(s, t));
    let lines = lines.iter().map(|(along, _)| pair[0] + along * length);
    let all: Vec<(f64, Vec<Option<u64>>)> = lines.map(|t| (t, labels(t))).collect();
    let mut cuts = vec![pair[0]];
    for two in all.windows(2).filter(|two| two[0].1 != two[1].1) {
        let (mut low, mut high) = (two[0].0, two[1].0);
        for _ in 0..CORNER_BISECTIONS {
            let middle = 0.5 * (low + high);
            if labels(middle) == two[0].1 { low = middle } else { high = middle }
        }
        cuts.push(0.5 * (low + high));
    }
    cuts
}

/// The labels along a line, from one change to the next.
fn labels_along(label: &dyn Fn(f64) -> Option<u64>) -> Vec<Option<u64>> {
    let mut ends = vec![0.0];
    ends.extend(changes(label));
    ends.push(1.0);
    ends.windows(2).map(|ends| label(0.5 * (ends[0] + ends[1]))).collect()
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

/// The places between 0 and 1 at which a label changes.
fn changes(label: &dyn Fn(f64) -> Option<u64>) -> Vec<f64> {
    let at = |k: usize| k as f64 / PROBES as f64;
    let mut changes = Vec::new();
    let mut before = label(0.0);
    for k in 1..=PROBES {
        let next = label(at(k));
        // Several edges may be between two places.
        let mut from = at(k - 1);
        for _ in 0..MOST_CHANGES {
            if before == next {
                break;
            }
            let (mut low, mut high) = (from, at(k));
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                if label(middle) == before { low = middle } else { high = middle }
            }
            changes.push(0.5 * (low + high));
            (from, before) = (high, label(high));
        }
        before = next;
    }
    changes
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    fn integral(nodes: &[RuleNode], f: impl Fn([f64; 2]) -> f64) -> f64 {
        nodes.iter().map(|(place, weight)| weight * f(*place)).sum()
    }

    fn nodes_of(rules: &PixelRules, crossing: Crossing, label: &Label<'_>) -> Vec<RuleNode> {
        rules.nodes(crossing, 0, label)
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
