"""What a contestant is: a way to make the image of a scene, and the settings that are tried."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from typing import Any, Self

import numpy as np

from .camera import Equirectangular
from .counter import Counter
from .scene import Scene

#: The key of the settings for scenes that have none of their own.
OTHERWISE = "*"


@dataclass(frozen=True)
class Problem:
    """The input of a contestant: the rate, the shape of the image, and its largest pixel.

    The largest pixel converts a relative tolerance into an absolute one.

    rate: in the unit cube. emission: in the coordinates of the scene, where `camera` is; the same
        as `rate` where there is no camera. Points of both are counted, by `emission`.
    """

    rate: Counter
    shape: tuple[int, int]
    scale: float
    emission: Counter
    camera: Equirectangular | None = None

    @classmethod
    def of(cls, scene: Scene, exact: np.ndarray) -> Self:
        """The problem of a scene with this exact image."""
        emission = Counter(scene.rate)
        rate = Counter(scene.camera.in_cube(emission)) if scene.camera else emission
        return cls(rate, scene.shape, float(np.abs(exact).max()), emission, scene.camera)


@dataclass(frozen=True)
class Found:
    """An image (height, width), row 0 at the lowest y, and its own error estimate.

    estimated_error: its own error estimate, relative to the largest pixel, or None.
    """

    image: np.ndarray
    estimated_error: float | None = None
    note: str = ""


@dataclass(frozen=True)
class Contestant:
    """A way to make images.

    distribution: the package on PyPI whose version is reported.
    about: what it does, a line of a table.
    run: called with a problem and one of the settings as keywords.
    settings: for each scene those that are tried, cheap ones first.
    modules: imported before the clock starts.
    limit_s: the wall time that one setting may take.
    patience: after so many failures in a scene the settings left are not tried.
    has_cameras: whether it deals with the camera of a scene. All others image the unit cube that
        the camera maps to, and what they find is divided by the solid angles of the pixels.
    for_users: whether it is the usual choice of a user with such a scene.
    """

    name: str
    distribution: str
    about: str
    run: Callable[..., Found]
    settings: Mapping[str, Sequence[dict[str, Any]]]
    modules: tuple[str, ...] = ()
    limit_s: float = 40.0
    patience: int = 2
    has_cameras: bool = False
    for_users: bool = False

    def settings_of(self, scene: str) -> Sequence[dict[str, Any]]:
        """The settings that are tried in a scene."""
        return self.settings.get(scene, self.settings.get(OTHERWISE, ()))

    @property
    def version(self) -> str:
        """The name and version of the package."""
        return f"{self.distribution} {metadata.version(self.distribution)}"


def spelled(setting: Mapping[str, Any]) -> str:
    """A setting as text: `nodes=24 tolerance=0.01`."""
    return " ".join(f"{key}={value}" for key, value in setting.items())
