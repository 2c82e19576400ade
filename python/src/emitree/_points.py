"""Points at which rates are needed."""

from __future__ import annotations

from dataclasses import dataclass

from emitree._function import Floats


@dataclass(frozen=True)
class Points:
    """Points at which rates are needed.

    position: (n, 3), in the camera's length unit.
    direction: (n, 3), unit vectors of emission, from the point to the observer.
    energy: (n,), in the unit of the bins; None without bins.
    """

    position: Floats
    direction: Floats
    energy: Floats | None

    def __len__(self) -> int:
        return len(self.position)
