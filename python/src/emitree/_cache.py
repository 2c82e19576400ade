"""Evaluated points on disk, written as they come, for a rendering that may be killed.

A cache is a folder:

* `about.json` says what the columns are, and in which units;
* `points.f64` has 8 numbers for each point, little-endian 64-bit floats: position, emission
  direction, energy (NaN if there is none), rate.

Points are only ever appended. A process that is killed leaves whole points and at most a piece of
one, which is dropped when the cache is opened again. Points are known by the bits of position,
direction and energy: the same call asks for the same ones, so it goes on where it was.

A cache `NAME.h5` is the folder `NAME.h5.points` while it is in use, and the HDF5 file after.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from emitree._function import Floats

_COLUMNS = ["x", "y", "z", "dx", "dy", "dz", "energy", "rate"]
_KEY = len(_COLUMNS) - 1
_RECORD = np.dtype("<f8").itemsize * len(_COLUMNS)


class Cache:
    """The points of a cache; about 0.3 kB of memory for each.

    path: the folder, or an HDF5 file; units: those that the points are in, which may not change.
    """

    def __init__(self, path: str | os.PathLike[str], units: dict[str, str | None]) -> None:
        path = Path(path)
        self.file = path if path.suffix.lower() in (".h5", ".hdf5") else None
        self.folder = path.with_name(path.name + ".points") if self.file else path
        self.about = {"format": "emitree points", "version": 1, "columns": _COLUMNS, **units}
        self.known: dict[bytes, float] = {}
        self.found = 0
        self.added = 0

    def __enter__(self) -> Cache:
        if self.file is not None and self.file.exists():
            import h5py

            with h5py.File(self.file, "r") as file:
                self._check(json.loads(file.attrs["about"]), self.file)
                self._learn(file["points"][:])
        self._open_folder()
        return self

    def _open_folder(self) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        about = self.folder / "about.json"
        if about.exists():
            self._check(json.loads(about.read_text()), self.folder)
        else:
            if any(self.folder.iterdir()):
                raise ValueError(f"cache {self.folder}: expected a new or empty folder, or a cache")
            # Under its name it is whole, also if we are killed here.
            part = self.folder.with_name(self.folder.name + ".part")
            part.write_text(json.dumps(self.about, indent=1))
            part.replace(about)
        flags = os.O_RDWR | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0)
        self.points = os.open(self.folder / "points.f64", flags, 0o666)
        self._lock()
        size = os.fstat(self.points).st_size
        os.ftruncate(self.points, size - size % _RECORD)
        self._learn(np.fromfile(self.folder / "points.f64", "<f8").reshape(-1, len(_COLUMNS)))

    def _lock(self) -> None:
        """Keeps other renderings out; the system lets go of it when we are killed."""
        try:
            import fcntl
        except ImportError:
            return
        try:
            fcntl.flock(self.points, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(self.points)
            raise ValueError(f"cache {self.folder}: another rendering uses it") from None

    def _check(self, about: dict[str, Any], where: Path) -> None:
        for name, value in self.about.items():
            if about.get(name) != value:
                raise ValueError(
                    f"cache {where}: `{name}` is {about.get(name)!r}: expected {value!r}, or "
                    "another cache"
                )

    def _learn(self, points: Floats) -> None:
        self.known.update(zip(keys(points), points[:, _KEY].tolist(), strict=True))

    def rates(self, evaluator: Any, position: Floats, direction: Floats, energy: Any) -> Floats:
        """The rates of a batch; the evaluator gives those of points that are not known."""
        points = np.empty((len(position), len(_COLUMNS)), "<f8")
        points[:, :3], points[:, 3:6] = position, direction
        points[:, 6] = np.nan if energy is None else energy
        wanted = keys(points)
        first = {key: i for i, key in reversed(list(enumerate(wanted))) if key not in self.known}
        self.found += len(wanted) - len(first)
        fresh: dict[bytes, float] = {}
        if first:
            new = np.array(sorted(first.values()))
            fresh.update(self._evaluated(evaluator, points[new], energy is not None))
        rates = (fresh[key] if key in fresh else self.known[key] for key in wanted)
        return np.fromiter(rates, np.float64, len(wanted))

    def _evaluated(
        self, evaluator: Any, points: Floats, has_energy: bool
    ) -> Iterator[tuple[bytes, float]]:
        columns = np.ascontiguousarray(points[:, :3]), np.ascontiguousarray(points[:, 3:6])
        energy = points[:, 6].copy() if has_energy else None
        for part, rates in evaluator.parts(*columns, energy):
            points[part, _KEY] = rates
            # A rate that is no number ends the rendering; mended, the function is asked again.
            finite = points[part][np.isfinite(rates)]
            self._append(finite.tobytes())
            self._learn(finite)
            self.added += len(finite)
            yield from zip(keys(points[part]), rates.tolist(), strict=True)

    def _append(self, records: bytes) -> None:
        while records:
            records = records[os.write(self.points, records) :]

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        os.close(self.points)
        if self.file is not None and kind is None:
            self._to_hdf5()

    def _to_hdf5(self) -> None:
        import h5py

        assert self.file is not None
        columns = np.frombuffer(b"".join(self.known), "<f8").reshape(-1, _KEY)
        rates = np.fromiter(self.known.values(), np.float64, len(self.known))
        part = self.file.with_name(self.file.name + ".part")
        with h5py.File(part, "w") as file:
            file.attrs["about"] = json.dumps(self.about)
            file["points"] = np.column_stack((columns, rates))
        part.replace(self.file)
        shutil.rmtree(self.folder)


def keys(points: Floats) -> list[bytes]:
    """What points are known by: the bits of all columns but the last."""
    return np.ascontiguousarray(points[:, :_KEY]).view(f"V{8 * _KEY}").ravel().tolist()
