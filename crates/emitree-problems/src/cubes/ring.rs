//! The tilted ring of the problems [`ena_ring`](super::ena_ring) and [`doppler`](super::doppler).

/// A ring whose profile is smooth on its axis too:
/// (q exp(1 − q))^`sharpness` exp(−h²/`thickness`²), q = ρ²/`radius`², with the distances ρ from the
/// axis and h from the plane. It is 1 on the ring and falls to 1/e `radius`/√(2 `sharpness`) beside it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ring {
    pub(super) centre: [f64; 3],
    /// The cosine and sine of the angle from the x axis to the line of nodes, in which the planes of
    /// the ring and the image meet.
    pub(super) nodes: [f64; 2],
    /// The cosine and sine of the angle between the axis and the line of sight.
    pub(super) tilt: [f64; 2],
    pub(super) radius: f64,
    pub(super) sharpness: i32,
    pub(super) thickness: f64,
}

/// A point as the ring has it.
#[derive(Clone, Copy, Debug)]
pub(super) struct RingPlace {
    /// The profile of the ring there.
    pub(super) density: f64,
    /// ρ², the square of the distance from the axis.
    pub(super) axis_distance_squared: f64,
    /// r², the square of the distance from the centre.
    pub(super) centre_distance_squared: f64,
    /// The coordinate along the line of nodes.
    pub(super) along_nodes: f64,
}

impl Ring {
    pub(super) fn place(&self, position: [f64; 3]) -> RingPlace {
        let [x, y, z] = core::array::from_fn(|i| position[i] - self.centre[i]);
        let ([node_cos, node_sin], [tilt_cos, tilt_sin]) = (self.nodes, self.tilt);
        let (u, across) = (node_cos * x + node_sin * y, node_cos * y - node_sin * x);
        let (v, h) = (tilt_cos * across + tilt_sin * z, tilt_cos * z - tilt_sin * across);
        let axis_distance_squared = u * u + v * v;
        let q = axis_distance_squared / self.radius.powi(2);
        let fall = (1.0 - q) * f64::from(self.sharpness) - (h / self.thickness).powi(2);
        RingPlace {
            density: q.powi(self.sharpness) * fall.exp(),
            axis_distance_squared,
            centre_distance_squared: axis_distance_squared + h * h,
            along_nodes: u,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ring_is_where_it_should_be() {
        let [nodes, tilt] = [[0.8, 0.6], [0.6, 0.8]];
        let centre = [0.5, 0.4, 0.6];
        let ring = Ring { centre, nodes, tilt, radius: 0.2, sharpness: 2, thickness: 0.1 };
        // On the line of nodes, on the ring a quarter further on, and on the axis.
        let node = ring.place([0.5 + 0.2 * 0.8, 0.4 + 0.2 * 0.6, 0.6]);
        assert!((node.density - 1.0).abs() < 1e-14 && (node.along_nodes - 0.2).abs() < 1e-15);
        let quarter = ring.place([0.5 - 0.072, 0.4 + 0.096, 0.6 + 0.16]);
        assert!((quarter.density - 1.0).abs() < 1e-14 && quarter.along_nodes.abs() < 1e-15);
        let axis = ring.place([0.5 + 0.048, 0.4 - 0.064, 0.6 + 0.06]);
        assert!(axis.density < 1e-14 && axis.axis_distance_squared < 1e-15);
        assert!((axis.centre_distance_squared - 0.01).abs() < 1e-15);
    }
}
