"""A session whose points are on disk: what is known is told to it without being asked for."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import NDArray

from emitree import _native
from emitree._cache import Cache
from emitree._function import Floats
from emitree._points import Points
from emitree._records import KEY

#: What fills the cache, for messages.
_NAME = "the rates that a session was told"


class Stored:
    """A session and its cache.

    The points of a batch depend on the rates before, and not on the process: a new session that is
    told the same rates asks for the same points.
    """

    def __init__(
        self,
        native: _native.Session,
        scene: _native.Scene,
        path: str | os.PathLike[str],
        unit: str | None,
    ) -> None:
        energies = scene.energies
        units = {
            "length_unit": scene.length_unit,
            "unit": unit,
            "energy_unit": energies[1] if energies else None,
        }
        self._native = native
        self._cache = Cache(path, units, _NAME)
        self._cache.__enter__()
        self._is_open = True
        # The batch that the session waits for: its points as they are stored, their keys, which of
        # them are not known.
        self._batch: tuple[Floats, list[bytes], NDArray[np.intp]] | None = None
        self.advance()

    def __del__(self) -> None:
        # An HDF5 file is not written now: its folder is found again.
        self._close(GeneratorExit)

    def close(self) -> None:
        """Closes the cache."""
        self._close(None)

    def _close(self, kind: type[BaseException] | None) -> None:
        if getattr(self, "_is_open", False):
            self._is_open = False
            self._cache.__exit__(kind, None, None)

    def advance(self) -> None:
        """Tells the session what is known, up to the next point that is not."""
        self._batch = None
        while (asked := self._native.ask()) is not None:
            points, wanted, new = self._cache.missing(*asked)
            if len(new):
                self._batch = points, wanted, new
                return
            known = self._cache.known
            self._native.tell(np.array([known[key] for key in wanted]))

    def waits_for(self) -> int | None:
        """How many rates are needed next."""
        return None if self._batch is None else len(self._batch[2])

    def ask(self) -> Points | None:
        """The points of the batch that are not known."""
        if self._batch is None:
            return None
        points, _, new = self._batch
        energy = points[new, 6].copy()
        is_cube = not np.isnan(energy).any()
        position, direction = points[new, :3].copy(), points[new, 3:6].copy()
        return Points(position, direction, energy if is_cube else None)

    def tell(self, rates: Floats) -> None:
        """Stores the rates of these points, and goes on."""
        if not self._is_open or self._batch is None:
            raise ValueError("rates were given: expected none, as the session is closed")
        points, wanted, new = self._batch
        told = points[new].copy()
        told[:, KEY] = rates
        # A rate that is no number is refused, and the others need not be evaluated again.
        self._cache.add(told[np.isfinite(rates)])
        fresh = dict(zip((wanted[i] for i in new), rates.tolist(), strict=True))
        known = self._cache.known
        both = [fresh[key] if key in fresh else known[key] for key in wanted]
        self._native.tell(np.array(both))
        self.advance()
