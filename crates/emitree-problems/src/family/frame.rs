//! A place and an orientation: the coordinates in which a component is simple.

use super::generator::Generator;

/// A centre and three orthonormal axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) centre: [f64; 3],
    pub(super) axes: [[f64; 3]; 3],
}

impl Frame {
    /// Any orientation, somewhere in the middle of the cube.
    pub(super) fn draw(generator: &mut Generator) -> Self {
        Self { centre: centre(generator), axes: generator.axes() }
    }

    /// The same orientation about a centre that is moved.
    pub(super) fn moved(mut self, by: [f64; 3]) -> Self {
        self.centre = core::array::from_fn(|i| self.centre[i] + by[i]);
        self
    }

    /// The coordinates of a point of the unit cube along the axes, from the centre.
    pub(super) fn local_from_canonical(&self, position: [f64; 3]) -> [f64; 3] {
        let offset: [f64; 3] = core::array::from_fn(|i| position[i] - self.centre[i]);
        self.axes.map(|[x, y, z]| x * offset[0] + y * offset[1] + z * offset[2])
    }
}

/// A centre somewhere in the middle of the cube.
pub(super) fn centre(generator: &mut Generator) -> [f64; 3] {
    core::array::from_fn(|_| generator.between(0.2, 0.8))
}
