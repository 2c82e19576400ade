"""A camera in space, and the unit cube that it maps to for contestants without cameras."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Equirectangular:
    """Uniform steps of longitude to the right and latitude upwards, about a pointing.

    position, target, up: the observer, a point in the middle of the image, and what is up in it.
    field_of_view: full width and height [deg]. far: where lines of sight end, a length.
    """

    position: tuple[float, float, float]
    target: tuple[float, float, float]
    up: tuple[float, float, float]
    field_of_view: tuple[float, float]
    far: float
    length_unit: str

    def directions(self, x, y) -> np.ndarray:
        """Unit vectors (..., 3) away from the observer, at places (x, y) of an image [0, 1]^2."""
        width, height = np.radians(self.field_of_view)
        longitude, latitude = np.broadcast_arrays((x - 0.5) * width, (y - 0.5) * height)
        right, up, forward = self._axes
        ahead = np.cos(longitude)[..., None] * forward + np.sin(longitude)[..., None] * right
        return np.cos(latitude)[..., None] * ahead + np.sin(latitude)[..., None] * up

    def lengths(self, directions: np.ndarray) -> np.ndarray | float:
        """The lengths of lines of sight with these directions (..., 3)."""
        return self.far

    def lines(self, shape: tuple[int, int], across: int) -> np.ndarray:
        """Directions (height, width, across, across, 3) of the centres of parts of the pixels."""
        height, width = shape
        y, x = (
            ((np.arange(n * across) + 0.5) / (n * across)).reshape(n, across)
            for n in (height, width)
        )
        return self.directions(x[None, :, None, :], y[:, None, :, None])

    def in_cube(self, rate):
        """The rate as one in the unit cube, z along the lines of sight.

        Its integral over z is the radiance times the solid angle of an area of one.
        """

        def seen(x, y, z):
            direction = self.directions(x, y)
            length = self.lengths(direction)
            places = (
                start + length * z * direction[..., axis]
                for axis, start in enumerate(self.position)
            )
            return length * self.solid_angle(y) * rate(*places)

        return seen

    def solid_angle(self, y) -> np.ndarray:
        """The solid angle of a unit of area, relative to that in the middle of the image."""
        return np.cos((y - 0.5) * np.radians(self.field_of_view[1]))

    def pixel_angles(self, shape: tuple[int, int]) -> np.ndarray:
        """The means (height, 1) of `solid_angle` over pixels: what divides images of `in_cube`."""
        height = np.radians(self.field_of_view[1])
        border = np.sin((np.linspace(0, 1, shape[0] + 1) - 0.5) * height)
        return (np.diff(border) * shape[0] / height)[:, None]

    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """The lowest and the highest corner of a box around the volume of the view."""
        share = np.linspace(0, 1, 101)
        ends = self.far * self.directions(share, share[:, None]).reshape(-1, 3)
        seen = np.array(self.position) + np.vstack([ends, np.zeros(3)])
        return seen.min(axis=0), seen.max(axis=0)

    @property
    def _axes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        forward = np.subtract(self.target, self.position)
        forward = forward / np.linalg.norm(forward)
        right = np.cross(forward, self.up)
        right = right / np.linalg.norm(right)
        return right, np.cross(right, forward), forward


@dataclass(frozen=True)
class WithinSphere(Equirectangular):
    """Such a camera within a sphere about the origin, of `radius`, where lines of sight end.

    far: longer than any of them.
    """

    radius: float

    def lengths(self, directions: np.ndarray) -> np.ndarray:
        """The lengths (...) of lines of sight with these directions (..., 3)."""
        position = np.array(self.position)
        half = directions @ position
        return np.sqrt(half**2 + self.radius**2 - position @ position) - half
