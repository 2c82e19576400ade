//! The places along a line across a pixel at which edges cross it.
//!
//! Edges are changes of a label. The limbs among them are also where a smooth function of the place is 1, so that
//! the method of Illinois finds them with some five places instead of the 27 of bisections.

/// The label of a place in a pixel, which changes at edges; `None` outside the image.
pub(crate) type Label<'a> = dyn Fn([f64; 2]) -> Option<u64> + 'a;
/// Writes the distances of a place from the centres of limbs, in units of their radii.
pub(crate) type Misses<'a> = dyn Fn([f64; 2], &mut Vec<f64>) + 'a;

/// What geometry tells of the places in a pixel.
#[derive(Clone, Copy)]
pub(crate) struct Places<'a> {
    pub(crate) label: &'a Label<'a>,
    pub(crate) misses: &'a Misses<'a>,
}

/// The number of intervals of a line at whose ends labels are compared.
pub(super) const PROBES: usize = 8;
/// The number of bisections between two places with different labels: places to 1e-9 of a pixel.
const BISECTIONS: usize = 26;
/// The most changes between two places.
const MOST_CHANGES: usize = 8;
/// How far beside a limb its two labels have to be found, in pixels, and the most steps of the method of Illinois.
const BESIDE_LIMB: f64 = 1e-9;
const MOST_STEPS: usize = 12;

/// A line divided at edges.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LineScan {
    /// The beginning of each part, and the end of the line, from 0 to 1.
    pub(super) ends: Vec<f64>,
    /// The label of each part.
    pub(super) labels: Vec<Option<u64>>,
}

impl LineScan {
    /// Of the places `at(s)` for s from 0 to 1.
    pub(super) fn new(places: Places<'_>, at: &dyn Fn(f64) -> [f64; 2]) -> Self {
        let label = |s: f64| (places.label)(at(s));
        let mut before = label(0.0);
        let mut scan = Self { ends: vec![0.0], labels: vec![before] };
        for k in 1..=PROBES {
            let [mut from, to] = [k - 1, k].map(|k| k as f64 / PROBES as f64);
            let next = label(to);
            // Several edges may be between two places.
            for _ in 0..MOST_CHANGES {
                if before == next {
                    break;
                }
                let change = Change::at_limb(places, at, [from, to], before);
                let change =
                    change.unwrap_or_else(|| Change::by_bisection(&label, [from, to], before));
                scan.ends.push(change.place);
                scan.labels.push(change.label);
                (from, before) = (change.beyond, change.label);
            }
            before = next;
        }
        scan.ends.push(1.0);
        scan
    }

    /// The places between 0 and 1 at which the label changes.
    pub(super) fn changes(&self) -> &[f64] {
        &self.ends[1..self.ends.len() - 1]
    }
}

/// The first change of a label along a line.
struct Change {
    place: f64,
    /// A place just beyond it, and the label there.
    beyond: f64,
    label: Option<u64>,
}

impl Change {
    /// Between a place with the label `before` and one with another label.
    fn by_bisection(
        label: &dyn Fn(f64) -> Option<u64>,
        [mut low, mut high]: [f64; 2],
        before: Option<u64>,
    ) -> Self {
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if label(middle) == before { low = middle } else { high = middle }
        }
        Self { place: 0.5 * (low + high), beyond: high, label: label(high) }
    }

    /// The same if one limb is between these places, and if the label changes there.
    fn at_limb(
        places: Places<'_>,
        at: &dyn Fn(f64) -> [f64; 2],
        [low, high]: [f64; 2],
        before: Option<u64>,
    ) -> Option<Self> {
        let mut misses = Vec::new();
        (places.misses)(at(low), &mut misses);
        let of_low = misses.clone();
        (places.misses)(at(high), &mut misses);
        let is_crossed = |limb: &usize| (of_low[*limb] < 1.0) != (misses[*limb] < 1.0);
        let mut crossed = (0..misses.len().min(of_low.len())).filter(is_crossed);
        let limb = crossed.next().filter(|_| crossed.next().is_none())?;
        let values = [of_low[limb] - 1.0, misses[limb] - 1.0];
        let mut miss = |s: f64| {
            (places.misses)(at(s), &mut misses);
            misses.get(limb).map_or(f64::NAN, |miss| miss - 1.0)
        };
        let place = root(&mut miss, [low, high], values)?;
        let [inside, beyond] = [place - BESIDE_LIMB, place + BESIDE_LIMB];
        let label = |s: f64| (places.label)(at(s));
        let found = label(beyond);
        let is_within = inside > low && beyond < high;
        (is_within && found != before && label(inside) == before).then_some(Self {
            place,
            beyond,
            label: found,
        })
    }
}

/// The root of a function between two places with values of different signs, by the method of Illinois (Dowell and
/// Jarratt 1971, doi:10.1007/BF01934364); `None` if it does not converge.
fn root(
    function: &mut dyn FnMut(f64) -> f64,
    [mut low, mut high]: [f64; 2],
    [mut of_low, mut of_high]: [f64; 2],
) -> Option<f64> {
    let mut before = f64::NAN;
    for _ in 0..MOST_STEPS {
        let place = low + (high - low) * of_low / (of_low - of_high);
        if (place - before).abs() < 0.1 * BESIDE_LIMB {
            return Some(place);
        }
        before = place;
        let value = function(place);
        if value.is_nan() {
            return None;
        }
        if (value < 0.0) == (of_high < 0.0) {
            of_low *= 0.5;
        } else {
            (low, of_low) = (high, of_high);
        }
        (high, of_high) = (place, value);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::cell::Cell;

    /// The scan of a line at `y` across discs, and the number of places asked for.
    fn scan(discs: &[[f64; 3]], y: f64, knows_limbs: bool) -> (LineScan, usize) {
        let count = Cell::new(0);
        let miss = |[x, y]: [f64; 2], [a, b, radius]: [f64; 3]| (x - a).hypot(y - b) / radius;
        let label = |place| {
            count.set(count.get() + 1);
            Some(discs.iter().fold(0, |all, disc| 2 * all + u64::from(miss(place, *disc) < 1.0)))
        };
        let misses = |place, misses: &mut Vec<f64>| {
            misses.clear();
            if knows_limbs {
                count.set(count.get() + 1);
                misses.extend(discs.iter().map(|disc| miss(place, *disc)));
            }
        };
        let places = Places { label: &label, misses: &misses };
        (LineScan::new(places, &|s| [s, y]), count.get())
    }

    #[test]
    fn limbs_are_found_as_by_bisections_with_fewer_places() {
        // Two changes, one close to a tangent, and several between two places.
        for discs in [
            vec![[0.5, 1.3, 1.31]],
            vec![[0.31, -2.0, 2.3]],
            vec![[-3.0, 0.1, 3.4], [1.9, 0.2, 1.1]],
            vec![[0.55, 0.3, 0.04], [0.56, 0.3, 0.02]],
        ] {
            for y in [0.0, 0.3, 0.9] {
                let (found, count) = scan(&discs, y, true);
                let (bisected, of_bisections) = scan(&discs, y, false);
                assert_eq!(found.labels, bisected.labels, "{discs:?} {y}");
                for (a, b) in found.ends.iter().zip(&bisected.ends) {
                    assert!((a - b).abs() < 3e-9, "{a} {b}");
                }
                if discs.len() == 1 && !found.changes().is_empty() {
                    let changes = found.changes().len();
                    assert!(count <= 9 + 12 * changes, "{count}");
                    assert_eq!(of_bisections, 9 + 27 * changes);
                }
            }
        }
    }

    #[test]
    fn a_line_without_edges_is_one_part() {
        let (found, count) = scan(&[[0.5, 0.5, 0.1]], 0.7, true);
        assert_eq!((found.ends, found.labels, count), (vec![0.0, 1.0], vec![Some(0)], 9));
    }
}
