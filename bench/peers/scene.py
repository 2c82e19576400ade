"""What a scene is: an emission rate, a camera, and the exact image."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .camera import Equirectangular


@dataclass(frozen=True)
class Scene:
    """A scene: the unit cube along z, or the view of a camera.

    rate: g(x, y, z) of arrays that broadcast.
    exact, check: two images (height, width) that share no nodes; row 0 has the lowest y. Each
        pixel is the mean over its square of the integral of g over z or, of a camera, the mean
        over its solid angle of the integral along the line of sight.
    agreement: what the two may differ by at most, relative to the largest pixel.
    camera: its camera; None: the unit cube, x to the right, y up, z away.
    """

    name: str
    title: str
    rate: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
    exact: Callable[[tuple[int, int]], np.ndarray]
    check: Callable[[tuple[int, int]], np.ndarray]
    shape: tuple[int, int] = (64, 64)
    agreement: float = 1e-12
    camera: Equirectangular | None = None

    def verified_image(self) -> tuple[np.ndarray, float]:
        """The exact image and by how much the other one differs from it."""
        image = self.exact(self.shape)
        disagreement = relative_error(self.check(self.shape), image)
        if not disagreement < self.agreement:
            raise ArithmeticError(
                f"scene {self.name}: its two exact images differ by {disagreement:.1e} of the"
                f" largest pixel: expected less than {self.agreement:.0e}"
            )
        return image, disagreement


def relative_error(image: np.ndarray, exact: np.ndarray) -> float:
    """The largest |error| of a pixel over the largest |pixel| of the exact image."""
    if image.shape != exact.shape:
        raise ValueError(f"an image of shape {image.shape}: expected {exact.shape}")
    return float(np.abs(image - exact).max() / np.abs(exact).max())
