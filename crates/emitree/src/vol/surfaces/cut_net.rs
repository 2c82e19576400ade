//! The part of a net that lines of sight reach: triangles that cross its border are cut there.
//!
//! Patches go on in the cells at bounds and behind the limbs of bodies, as far as the cells do.

use crate::vol::surfaces::net::{Net, Vertex};
use rustc_hash::FxHashMap;

/// The halvings of an edge that leaves the part in view.
const HALVINGS: usize = 20;

/// A net that is cut, with the vertices on its border by the edges that they are on: a vertex in view, and one that is not.
struct CutNet<'a> {
    vertices: Vec<Vertex>,
    border: FxHashMap<[u32; 2], u32>,
    is_hidden: &'a dyn Fn([f64; 3]) -> bool,
}

impl Net {
    /// The part of the net outside of the points that no line of sight reaches.
    pub(super) fn cut(self, is_hidden: &dyn Fn([f64; 3]) -> bool) -> Self {
        let hidden: Vec<bool> = self.vertices.iter().map(|vertex| is_hidden(vertex.at)).collect();
        if !hidden.contains(&true) {
            return self;
        }
        let mut cut = CutNet { vertices: self.vertices, border: FxHashMap::default(), is_hidden };
        let mut triangles = Vec::with_capacity(self.triangles.len());
        for [a, b, c] in self.triangles {
            let is_in_view = |vertex: u32| !hidden[vertex as usize];
            // In an order in which those in view are the first ones, turned as before.
            let turns = [[a, b, c], [b, c, a], [c, a, b]];
            match [a, b, c].into_iter().filter(|vertex| is_in_view(*vertex)).count() {
                3 => triangles.push([a, b, c]),
                2 => {
                    let turned = turns.into_iter().find(|[_, _, last]| !is_in_view(*last));
                    let [a, b, c] = turned.unwrap_or([a, b, c]);
                    let [to_b, to_a] = [cut.between(b, c), cut.between(a, c)];
                    triangles.extend([[a, b, to_b], [a, to_b, to_a]]);
                }
                1 => {
                    let turned = turns.into_iter().find(|[first, ..]| is_in_view(*first));
                    let [a, b, c] = turned.unwrap_or([a, b, c]);
                    triangles.push([a, cut.between(a, b), cut.between(a, c)]);
                }
                _ => {}
            }
        }
        Self { vertices: cut.vertices, triangles, ..self }.compact()
    }

    /// The same triangles without vertices that none of them has.
    fn compact(self) -> Self {
        let mut numbers = vec![None; self.vertices.len()];
        let mut vertices = Vec::new();
        let mut number = |vertex: u32| {
            let known = &mut numbers[vertex as usize];
            *known.get_or_insert_with(|| {
                vertices.push(self.vertices[vertex as usize]);
                u32::try_from(vertices.len() - 1).unwrap_or(u32::MAX)
            })
        };
        let triangles = self.triangles.iter().map(|of| of.map(&mut number)).collect();
        Self { vertices, triangles, ..self }
    }
}

impl CutNet<'_> {
    /// The vertex at which an edge leaves the part in view.
    fn between(&mut self, seen: u32, hidden: u32) -> u32 {
        if let Some(known) = self.border.get(&[seen, hidden]) {
            return *known;
        }
        let [from, to] = [seen, hidden].map(|vertex| self.vertices[vertex as usize]);
        let at = |share: f64| [0, 1, 2].map(|k| from.at[k] + share * (to.at[k] - from.at[k]));
        let [mut low, mut high] = [0.0, 1.0];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            *(if (self.is_hidden)(at(middle)) { &mut high } else { &mut low }) = middle;
        }
        let number = u32::try_from(self.vertices.len()).unwrap_or(u32::MAX);
        self.vertices.push(Vertex { at: at(low), ..from });
        self.border.insert([seen, hidden], number);
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 4 × 4 smaller ones at z = 0.5.
    fn square() -> Net {
        let at = |k: u32| [f64::from(k % 5) / 4.0, f64::from(k / 5) / 4.0, 0.5];
        let vertex =
            |k: u32| Vertex { at: at(k), sides: [0, 1], normal: [0.0, 0.0, 1.0], error: 0.0 };
        let first = (0..16_u32).map(|k| 5 * (k / 4) + k % 4);
        let triangles = first.flat_map(|k| [[k, k + 1, k + 6], [k, k + 6, k + 5]]).collect();
        Net { vertices: (0..25).map(vertex).collect(), cell_size: 0.25, triangles }
    }

    /// The area of each triangle, below 0 if it is turned the other way round.
    fn areas(net: &Net) -> Vec<f64> {
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| net.vertices[vertex as usize].at);
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]))
        };
        net.triangles.iter().map(area).collect()
    }

    #[test]
    fn a_net_that_is_seen_stays_as_it_is() {
        let net = square();
        assert_eq!(net.clone().cut(&|_| false), net);
        let none = net.cut(&|_| true);
        assert!(none.vertices.is_empty() && none.triangles.is_empty());
    }

    #[test]
    fn triangles_end_at_the_border_of_what_is_seen() {
        for [slope, most] in [[0.0, 0.6], [0.3, 0.55], [-1.0, 1.1], [2.0, 1.3]] {
            let beyond = |[x, y, _]: [f64; 3]| x + slope * y - most;
            let net = square().cut(&|at| beyond(at) > 0.0);
            assert!(net.vertices.iter().all(|vertex| beyond(vertex.at) <= 0.0));
            let areas = areas(&net);
            assert!(areas.iter().all(|area| *area >= 0.0));
            // The part of the square by a fine sum.
            let lines = 2000;
            let width =
                |k: u32| (most - slope * (f64::from(k) + 0.5) / f64::from(lines)).clamp(0.0, 1.0);
            let expected: f64 = (0..lines).map(width).sum::<f64>() / f64::from(lines);
            let area: f64 = areas.iter().sum();
            assert!((area - expected).abs() < 1e-4, "{slope} {most}: {area} instead of {expected}");
        }
    }
}
