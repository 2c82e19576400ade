"""What a contestant is: a way to make the image of a scene, and the settings that are tried."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from typing import Any

import numpy as np

from .counter import Counter

#: The key of the settings for scenes that have none of their own.
OTHERWISE = "*"


@dataclass(frozen=True)
class Problem:
    """What a contestant is told: the rate, the shape of the image, and its largest pixel.

    The largest pixel makes an absolute tolerance of a relative one; nobody has to find the scale.
    """

    rate: Counter
    shape: tuple[int, int]
    scale: float


@dataclass(frozen=True)
class Found:
    """An image (height, width), row 0 at the lowest y, and what the contestant says of it.

    estimated_error: the error that it promises, relative to the largest pixel, or None.
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
    """

    name: str
    distribution: str
    about: str
    run: Callable[..., Found]
    settings: Mapping[str, Sequence[dict[str, Any]]]
    modules: tuple[str, ...] = ()
    limit_s: float = 40.0
    patience: int = 2

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
