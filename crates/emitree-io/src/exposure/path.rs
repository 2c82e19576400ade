//! A path through points at given times.

/// The most nodes of a derivative: those of the polynomial of degree 4 beside each node.
const NODES_OF_DERIVATIVES: usize = 5;

/// Points in space at ascending times, and cubic polynomials between them. The derivatives at the nodes are those of
/// the polynomial through the five nearest nodes, or through all if there are fewer: the path and its velocity are
/// continuous, polynomials up to degree 3 are exact, and others have errors that fall as the fourth power of the step.
///
/// ```
/// use emitree_io::Path;
///
/// let times = [0.0, 1.0, 2.0, 4.0];
/// let path = Path::new(&times, &times.map(|t| [t, t * t, 0.0]))?;
/// assert_eq!(path.at(3.0), [3.0, 9.0, 0.0]);
/// # Ok::<(), emitree_io::PathError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    times: Vec<f64>,
    points: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
}

/// A path that can't be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PathError {
    /// Fewer than two nodes.
    #[error("there are {0} times: expected two or more")]
    Few(usize),
    /// Another number of points than of times.
    #[error("there are {points} points at {times} times: expected one for each time")]
    Points {
        /// The number of points.
        points: usize,
        /// The number of times.
        times: usize,
    },
    /// Times that do not ascend.
    #[error("time {number} is {time}: expected more than the one before it, {before}")]
    Order {
        /// Which, from 0.
        number: usize,
        /// The time.
        time: f64,
        /// The one before it.
        before: f64,
    },
}

impl Path {
    /// Through `points` at `times`.
    ///
    /// # Errors
    ///
    /// [`PathError`]: fewer than two times, times that do not ascend, another number of points.
    pub fn new(times: &[f64], points: &[[f64; 3]]) -> Result<Self, PathError> {
        if times.len() < 2 {
            return Err(PathError::Few(times.len()));
        }
        if points.len() != times.len() {
            return Err(PathError::Points { points: points.len(), times: times.len() });
        }
        for (number, pair) in times.windows(2).enumerate() {
            let [before, time] = [pair[0], pair[1]];
            if time.is_nan() || before.is_nan() || time <= before {
                return Err(PathError::Order { number: number + 1, time, before });
            }
        }
        let velocities = (0..times.len()).map(|node| velocity(times, points, node)).collect();
        Ok(Self { times: times.to_vec(), points: points.to_vec(), velocities })
    }

    /// The first time and the last.
    pub fn range(&self) -> [f64; 2] {
        [self.times[0], self.times[self.times.len() - 1]]
    }

    /// The times of its nodes.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The point at a time; beyond the nodes that of the outermost polynomial.
    pub fn at(&self, time: f64) -> [f64; 3] {
        let last = self.times.len() - 2;
        let piece = self.times.partition_point(|node| *node <= time).saturating_sub(1).min(last);
        let (from, step) = (self.times[piece], self.times[piece + 1] - self.times[piece]);
        let s = (time - from) / step;
        let (p, q) = (self.points[piece], self.points[piece + 1]);
        let (v, w) = (self.velocities[piece], self.velocities[piece + 1]);
        // Cubic Hermite polynomials on 0..1.
        let (of_q, of_v, of_w) =
            (s * s * (3.0 - 2.0 * s), s * (1.0 - s) * (1.0 - s), s * s * (s - 1.0));
        core::array::from_fn(|i| p[i] + of_q * (q[i] - p[i]) + step * (of_v * v[i] + of_w * w[i]))
    }
}

/// The derivative at a node of the polynomial through the nodes about it.
fn velocity(times: &[f64], points: &[[f64; 3]], node: usize) -> [f64; 3] {
    let count = times.len().min(NODES_OF_DERIVATIVES);
    let first = node.saturating_sub(count / 2).min(times.len() - count);
    let (times, points, node) = (&times[first..][..count], &points[first..], node - first);
    let here = times[node];
    // Differences from the node itself, so that the weight of the node is not needed.
    let mut velocity = [0.0; 3];
    for other in (0..count).filter(|other| *other != node) {
        let mut weight = 1.0 / (times[other] - here);
        for third in (0..count).filter(|third| *third != node && *third != other) {
            weight *= (here - times[third]) / (times[other] - times[third]);
        }
        for i in 0..3 {
            velocity[i] += weight * (points[other][i] - points[node][i]);
        }
    }
    velocity
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubic_polynomials_are_exact() {
        let cubic = |t: f64| [1.0 - 2.0 * t, t * t * t - t, 3.0 * t * t];
        for times in [vec![-1.0, 0.5, 2.0, 2.5], vec![0.0, 0.1, 1.0, 1.5, 4.0, 5.0, 9.0]] {
            let points: Vec<[f64; 3]> = times.iter().map(|&t| cubic(t)).collect();
            let path = Path::new(&times, &points).unwrap();
            let [first, last] = path.range();
            for k in 0..=40 {
                let t = first + (last - first) * f64::from(k) / 40.0;
                for (found, exact) in path.at(t).into_iter().zip(cubic(t)) {
                    assert!(
                        (found - exact).abs() < 1e-11 * (1.0 + exact.abs()),
                        "{t}: {found} {exact}"
                    );
                }
            }
        }
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "the positions are whole numbers")]
    fn two_nodes_are_a_straight_line() {
        let path = Path::new(&[1.0, 3.0], &[[0.0, 2.0, 5.0], [4.0, 2.0, 1.0]]).unwrap();
        assert_eq!(path.at(2.0), [2.0, 2.0, 3.0]);
        assert_eq!(path.at(1.0), [0.0, 2.0, 5.0]);
    }

    /// A step of h has an error of h⁴/384 times the fourth derivative inside, and a few times more at the ends.
    #[test]
    fn errors_on_a_circle_fall_as_the_fourth_power() {
        let error = |nodes: i32| {
            let times: Vec<f64> = (0..=nodes).map(|k| f64::from(k) / f64::from(nodes)).collect();
            let circle = |t: f64| [t.cos(), t.sin(), 0.0];
            let points: Vec<[f64; 3]> = times.iter().map(|&t| circle(t)).collect();
            let path = Path::new(&times, &points).unwrap();
            let one = |k: i32| {
                let t = f64::from(k) / 999.0;
                let (found, exact) = (path.at(t), circle(t));
                (0..3).map(|i| (found[i] - exact[i]).abs()).fold(0.0, f64::max)
            };
            (0..1000).map(one).fold(0.0, f64::max)
        };
        assert!(error(8) < 3e-6, "{}", error(8));
        assert!(error(64) < 3e-10, "{}", error(64));
    }

    #[test]
    fn what_is_no_path_is_refused_by_name() {
        let message =
            |times: &[f64], points: &[[f64; 3]]| Path::new(times, points).unwrap_err().to_string();
        assert_eq!(message(&[1.0], &[[0.0; 3]]), "there are 1 times: expected two or more");
        let order = message(&[0.0, 2.0, 2.0], &[[0.0; 3]; 3]);
        assert_eq!(order, "time 2 is 2: expected more than the one before it, 2");
        let points = message(&[0.0, 2.0], &[[0.0; 3]; 3]);
        assert_eq!(points, "there are 3 points at 2 times: expected one for each time");
    }
}
