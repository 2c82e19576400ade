"""Sums over regions of an image, with their errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from emitree._function import Floats


@dataclass(frozen=True)
class RegionSum:
    """The sum, mean or flux of a region.

    >>> import emitree
    >>> half = {"box": {"min": (0, 0), "max": (4, 4)}, "of": "mean", "tolerance": 1e-3}
    >>> rendering = emitree.render("1 + x", emitree.Canonical(), (4, 8), sums={"half": half})
    >>> found = rendering.sums["half"]
    >>> round(found.value, 6), found.error <= found.allowed
    (1.25, True)
    """

    #: What was asked: "sum", "mean" or "flux".
    of: str
    #: The sum; of a cube over all bands, with their widths.
    value: float
    #: Its estimated |error|: that of the sum, and not the sum of those of the pixels.
    error: float
    #: The error that was allowed.
    allowed: float
    #: The unit of value and errors, or an empty text.
    unit: str
    #: How many points or lines of sight it is estimated from; 0 if it is the sum of those of the
    #: pixels.
    samples: int
    #: Of a cube: value and |error| of each band (bins, 2), in `band_unit`; otherwise (0, 2).
    bands: Floats
    #: The unit of `bands`, or an empty text.
    band_unit: str


def region_sums(report: dict[str, Any]) -> dict[str, RegionSum]:
    """The sums of a report, by name."""

    def one(found: dict[str, Any]) -> RegionSum:
        values = {key: value for key, value in found.items() if key not in ("name", "tolerance")}
        values["bands"] = np.array(found["bands"], dtype=np.float64).reshape(-1, 2)
        return RegionSum(**values)

    return {name: one(found) for name, found in report.get("sums", {}).items()}
