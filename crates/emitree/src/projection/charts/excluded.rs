//! Singularities that the charts of other lines of sight resolve.

use crate::projection::vector::{along, difference, dot, norm};

/// A singularity near which the lines of sight of a chart are not in view: they belong to other charts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Excluded {
    pub(super) position: [f64; 3],
    pub(super) axis: Option<[f64; 3]>,
    pub(super) radius: f64,
}

impl Excluded {
    /// The nearest position at least `radius` away from the singularity: a chart has bounded values there, which no
    /// pixel sees.
    pub(super) fn outside(&self, position: [f64; 3]) -> [f64; 3] {
        let from = difference(position, self.position);
        let along_axis = self.axis.map_or([0.0; 3], |axis| axis.map(|x| x * dot(from, axis)));
        let away = difference(from, along_axis);
        let distance = norm(away);
        if distance >= self.radius {
            return position;
        }
        let away = if distance > 0.0 { away } else { [self.radius, 0.0, 0.0] };
        let factor = self.radius / distance.max(f64::MIN_POSITIVE);
        let factor = if distance > 0.0 { factor } else { 1.0 };
        let foot = along(self.position, 1.0, along_axis);
        along(foot, factor, away)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_near_a_singularity_are_moved_to_its_border() {
        let point = Excluded { position: [1.0, 2.0, 3.0], axis: None, radius: 0.5 };
        let moved = point.outside([1.0, 2.1, 3.0]);
        assert!(norm(difference(moved, [1.0, 2.5, 3.0])) < 1e-12, "{moved:?}");
        let far = [2.0, 2.0, 3.0];
        assert!(norm(difference(point.outside(far), far)) <= 0.0);
        let at_it = point.outside([1.0, 2.0, 3.0]);
        assert!((norm(difference(at_it, [1.0, 2.0, 3.0])) - 0.5).abs() < 1e-12, "{at_it:?}");
        let axis = Excluded { axis: Some([0.0, 0.0, 1.0]), ..point };
        let moved = axis.outside([1.0, 1.8, 9.0]);
        assert!(norm(difference(moved, [1.0, 1.5, 9.0])) < 1e-12, "{moved:?}");
    }
}
