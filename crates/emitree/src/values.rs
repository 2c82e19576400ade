//! What is rendered: images and cubes.

use crate::cube::Cube;
use crate::image::Image;
use core::fmt::Debug;

/// What is rendered: an [`Image`], or with an energy axis a [`Cube`].
pub trait Values: Clone + Debug + Send + sealed::FromCube {
    /// The largest |value|.
    fn largest(&self) -> f64;
}

mod sealed {
    /// Values from the bands of a method, of which an image has one.
    pub trait FromCube {
        #[doc(hidden)]
        fn from_cube(cube: crate::Cube) -> Self;
    }
}

impl sealed::FromCube for Image {
    fn from_cube(cube: Cube) -> Self {
        cube.into_first()
    }
}

impl sealed::FromCube for Cube {
    fn from_cube(cube: Cube) -> Self {
        cube
    }
}

impl Values for Image {
    fn largest(&self) -> f64 {
        Self::largest(self)
    }
}

impl Values for Cube {
    fn largest(&self) -> f64 {
        Self::largest(self)
    }
}
