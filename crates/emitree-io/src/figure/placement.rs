//! Where a label may stand without covering anything.

use super::svg::Rect;

/// What labels must not cover: points along the data, and labels placed before.
#[derive(Debug, Default)]
pub(super) struct Obstacles {
    points: Vec<[f64; 2]>,
    taken: Vec<Rect>,
}

/// Distance between the points that stand for a line; smaller than any label.
const SPACING: f64 = 3.0;

impl Obstacles {
    pub(super) fn add_point(&mut self, point: [f64; 2]) {
        self.points.push(point);
    }

    pub(super) fn add_line(&mut self, from: [f64; 2], to: [f64; 2]) {
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        // A line far beyond the figure needs no more points than fit into it.
        let steps = (length / SPACING).ceil().clamp(1.0, 1000.0);
        let mut step = 0.0;
        while step <= steps {
            let t = step / steps;
            self.points.push([from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])]);
            step += 1.0;
        }
    }

    /// The first of the `candidates` within `area` that covers least, and how many obstacles it
    /// covers.
    pub(super) fn best(
        &self,
        area: Rect,
        candidates: impl IntoIterator<Item = Rect>,
    ) -> Option<(Rect, usize)> {
        candidates
            .into_iter()
            .filter(|candidate| within(candidate, &area))
            .map(|candidate| (candidate, self.covered(&candidate)))
            .min_by_key(|(_, covered)| *covered)
    }

    /// Reserves the place of a label.
    pub(super) fn take(&mut self, rect: Rect) {
        self.taken.push(rect);
    }

    fn covered(&self, rect: &Rect) -> usize {
        let grown = rect.grown(2.0);
        let points = self.points.iter().filter(|[x, y]| {
            (grown.left..=grown.right()).contains(x) && (grown.top..=grown.bottom()).contains(y)
        });
        let labels = self.taken.iter().filter(|taken| overlap(&grown, taken));
        // Text upon text is worse than text upon a line.
        points.count() + 1000 * labels.count()
    }
}

fn within(inner: &Rect, outer: &Rect) -> bool {
    inner.left >= outer.left
        && inner.top >= outer.top
        && inner.right() <= outer.right()
        && inner.bottom() <= outer.bottom()
}

fn overlap(a: &Rect, b: &Rect) -> bool {
    a.left < b.right() && b.left < a.right() && a.top < b.bottom() && b.top < a.bottom()
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn rect(left: f64, top: f64) -> Rect {
        Rect { left, top, width: 20.0, height: 10.0 }
    }

    #[test]
    fn the_free_place_wins() {
        let area = Rect { left: 0.0, top: 0.0, width: 100.0, height: 100.0 };
        let mut obstacles = Obstacles::default();
        obstacles.add_line([0.0, 5.0], [100.0, 5.0]);
        obstacles.take(rect(0.0, 40.0));
        let candidates = [rect(0.0, 0.0), rect(10.0, 45.0), rect(90.0, 60.0), rect(0.0, 80.0)];
        assert_eq!(obstacles.best(area, candidates), Some((rect(0.0, 80.0), 0)));
        assert!(obstacles.best(area, [rect(0.0, 0.0)]).unwrap().1 > 0);
        assert_eq!(obstacles.best(area, [rect(95.0, 0.0)]), None);
    }
}
