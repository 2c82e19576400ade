"""Evaluated points on disk, written at once, for a rendering that may be killed.

A cache is a folder:

* `about.json` says what the columns are, in which units, and which function filled it first;
* `points.f64` has 9 numbers for each point, little-endian 64-bit floats: position, emission
  direction, energy (NaN if there is none), rate, checksum.

Points are only ever appended. A process that is killed leaves whole points and at most a piece of
one, which is dropped when the cache is opened again. Points are known by the bits of position,
direction and energy: the same call needs the same ones, so it continues where it was.

Points whose checksum is wrong are never used, but evaluated again. Before anything else a few
stored points are evaluated again and compared: another function is refused.

A cache `NAME.h5` is the folder `NAME.h5.points` while it is in use, and the HDF5 file after.
"""

from __future__ import annotations

import io
import json
import os
import shutil
import warnings
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emitree import _native
from emitree._function import Floats
from emitree._records import COLUMNS, KEY, RECORD, checksums, encode, intact, keys

#: How many stored points are evaluated again: spread over all, and as many with the largest rates.
_COMPARED = 4
#: How far the rates of a function may differ from call to call: relative to the rate (32-bit
#: floats, sums in another order), and to the largest stored one (where terms cancel).
_SAME, _SAME_OF_LARGEST = 1e-5, 1e-9


class Cache:
    """The points of a cache; about 0.3 kB of memory for each.

    path: the folder, or an HDF5 file; units: those that the points are in, which may not change;
    function: the name of the function, for messages.
    """

    def __init__(
        self, path: str | os.PathLike[str], units: dict[str, str | None], function: str
    ) -> None:
        if (
            not isinstance(path, str | os.PathLike)
            or "\0" in os.fspath(path)
            or not os.fspath(path)
        ):
            raise TypeError(
                f"`cache` is {path!r}: expected the name of a folder, or of an HDF5 file"
            )
        path = Path(path)
        self.file = path if path.suffix.lower() in (".h5", ".hdf5") else None
        self.folder = path.with_name(path.name + ".points") if self.file else path
        self.about = {"format": "emitree points", "version": 2, "columns": COLUMNS, **units}
        self.function = function
        self.filled_by = function
        self.known: dict[bytes, float] = {}
        #: Stored points that are still to be compared.
        self.stored = np.empty((0, KEY + 1))
        self.found = 0
        self.added = 0
        self.compared = 0
        self.damaged = 0

    @property
    def report(self) -> dict[str, int]:
        """How many points were found, added and compared, and how many were damaged."""
        names = ("found", "added", "compared", "damaged")
        return {name: getattr(self, name) for name in names}

    def __enter__(self) -> Cache:
        if self.file is not None and self.file.exists():
            self._take(self._read_hdf5(self.file), self.file)
        self._open_folder()
        if self.damaged:
            try:
                warnings.warn(
                    f"cache {self.file or self.folder}: damaged points: {self.damaged}; they are "
                    "evaluated again where they are needed",
                    stacklevel=2,
                )
            except Warning:
                os.close(self.points)
                raise
        return self

    def _read_hdf5(self, path: Path) -> Floats:
        import h5py

        try:
            with h5py.File(path, "r") as file:
                about, points = file.attrs["about"], file["points"][:]
        except (OSError, KeyError, RuntimeError, ValueError) as error:
            raise self._unreadable(path, error) from error
        self._check(about, path)
        if points.ndim != 2 or points.shape[1] != len(COLUMNS) or points.dtype.kind != "f":
            raise self._unreadable(path, f"`points` has the shape {points.shape}")
        return points.astype("<f8")

    def _open_folder(self) -> None:
        self.folder.mkdir(parents=True, exist_ok=True)
        about, points = self.folder / "about.json", self.folder / "points.f64"
        if about.exists():
            self._check(about.read_bytes(), about)
        else:
            if any(self.folder.iterdir()):
                raise ValueError(
                    f"cache {self.folder}: it has files and no about.json: expected a new or empty "
                    "folder, or a cache"
                )
            text = json.dumps(self.about | {"function": self.function}, indent=1)
            with _native.OutputFile(about) as file:
                file.commit(text.encode())
        flags = os.O_RDWR | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0)
        self.points = os.open(points, flags, 0o666)
        self._lock()
        size = os.fstat(self.points).st_size
        records = np.fromfile(points, "<f8", size // RECORD * len(COLUMNS))
        try:
            whole = self._take(records.reshape(-1, len(COLUMNS)), points)
        except ValueError:
            os.close(self.points)
            raise
        # A piece of a point, and what the system had no time to write.
        os.ftruncate(self.points, whole * RECORD)

    def _lock(self) -> None:
        """Locks the cache; the system releases the lock if the process is killed."""
        try:
            import fcntl
        except ImportError:
            return
        try:
            fcntl.flock(self.points, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(self.points)
            raise ValueError(f"cache {self.folder}: another rendering uses it") from None

    def _check(self, text: str | bytes, where: Path) -> None:
        """Whether a cache is one, and of these units."""
        try:
            about = json.loads(text)
        except (TypeError, ValueError) as error:
            raise self._unreadable(where, error) from error
        if not isinstance(about, dict):
            raise self._unreadable(where, f"it has {text!r}")
        for name, value in self.about.items():
            if about.get(name) != value:
                raise ValueError(
                    f"cache {where}: `{name}` is {about.get(name)!r}: expected {value!r}, or "
                    "another cache"
                )
        self.filled_by = str(about.get("function", self.filled_by))

    @staticmethod
    def _unreadable(path: Path, why: object) -> ValueError:
        return ValueError(
            f"cache {path}: it can't be read ({why}): expected a cache, or a name where none is; "
            "delete it to start anew"
        )

    def _take(self, records: Floats, where: Path) -> int:
        """Keeps the points of records that are intact; how many records end with the last one."""
        good = intact(records)
        if len(records) and not good.any():
            raise self._unreadable(where, "no point of it is intact")
        whole = int(np.flatnonzero(good)[-1]) + 1 if len(records) else 0
        self.damaged += len(records) - int(good.sum())
        points = records[good, : KEY + 1]
        self.known.update(zip(keys(points), points[:, KEY].tolist(), strict=True))
        if len(points):
            self.stored = np.concatenate((self.stored, _some(points)))
        return whole

    def rates(self, evaluator: Any, position: Floats, direction: Floats, energy: Any) -> Floats:
        """The rates of a batch; the evaluator gives those of points that are not stored."""
        if len(self.stored):
            self._compare(evaluator, energy is not None)
        points, wanted, new = self.missing(position, direction, energy)
        fresh: dict[bytes, float] = {}
        if len(new):
            for part, rates in _evaluated(evaluator, points[new], energy is not None):
                fresh.update(zip(keys(part), rates.tolist(), strict=True))
                part[:, KEY] = rates
                # A rate that is no number ends the rendering; a corrected function is called again.
                self.add(part[np.isfinite(rates)])
        found = (fresh[key] if key in fresh else self.known[key] for key in wanted)
        return np.fromiter(found, np.float64, len(wanted))

    def missing(
        self, position: Floats, direction: Floats, energy: Floats | None
    ) -> tuple[Floats, list[bytes], NDArray[np.intp]]:
        """Points as they are stored, without rates; their keys; which of them are not known."""
        points = np.empty((len(position), KEY + 1), "<f8")
        points[:, :3], points[:, 3:6] = position, direction
        points[:, 6] = np.nan if energy is None else energy
        wanted = keys(points)
        first = {key: i for i, key in reversed(list(enumerate(wanted))) if key not in self.known}
        self.found += len(wanted) - len(first)
        return points, wanted, np.array(sorted(first.values()), np.intp)

    def _compare(self, evaluator: Any, has_energy: bool) -> None:
        """Refuses a function that gives other rates than those that are stored."""
        stored, self.stored = self.stored, self.stored[:0]
        largest = np.abs(stored[:, KEY]).max()
        for part, rates in _evaluated(evaluator, stored, has_energy):
            kept = part[:, KEY]
            limit = _SAME * np.maximum(np.abs(kept), np.abs(rates)) + _SAME_OF_LARGEST * largest
            wrong = np.flatnonzero(~(np.abs(rates - kept) <= limit))
            if len(wrong):
                at = int(wrong[0])
                energy = f", energy {part[at, 6]}" if has_energy else ""
                raise ValueError(
                    f"cache {self.file or self.folder}: it was filled by another function, "
                    f"{self.filled_by}: at position {part[at, :3].tolist()}, emission direction "
                    f"{part[at, 3:6].tolist()}{energy} it has the rate {kept[at]}, and "
                    f"{self.function} gives {rates[at]}: expected the same function, or another "
                    "cache"
                )
            self.compared += len(part)

    def add(self, points: Floats) -> None:
        """Stores points with their rates."""
        records = encode(points)
        try:
            while records:
                records = records[os.write(self.points, records) :]
        except OSError as error:
            path = str(self.folder / "points.f64")
            raise OSError(error.errno, os.strerror(error.errno or 0), path) from None
        self.known.update(zip(keys(points), points[:, KEY].tolist(), strict=True))
        self.added += len(points)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        os.close(self.points)
        if self.file is not None and kind is None:
            self._to_hdf5(self.file)

    def _to_hdf5(self, path: Path) -> None:
        import h5py

        points = np.empty((len(self.known), KEY + 1), "<f8")
        points[:, :KEY] = np.frombuffer(b"".join(self.known), "<f8").reshape(-1, KEY)
        points[:, KEY] = np.fromiter(self.known.values(), np.float64, len(self.known))
        buffer = io.BytesIO()
        with h5py.File(buffer, "w") as file:
            file.attrs["about"] = json.dumps(self.about | {"function": self.filled_by})
            file["points"] = np.column_stack((points, checksums(points)))
        with _native.OutputFile(path) as output:
            output.commit(buffer.getvalue())
        shutil.rmtree(self.folder)


def _some(points: Floats) -> Floats:
    """A few of some points: the same number spread over all, and with the largest rates."""
    count = min(_COMPARED, len(points))
    spread = np.linspace(0, len(points) - 1, count).astype(int)
    largest = np.argpartition(np.abs(points[:, KEY]), len(points) - count)[-count:]
    return points[np.unique(np.concatenate((spread, largest)))]


def _evaluated(evaluator: Any, points: Floats, has_energy: bool) -> Iterator[tuple[Floats, Floats]]:
    """Parts of points with the rates that the evaluator gives for them."""
    columns = np.ascontiguousarray(points[:, :3]), np.ascontiguousarray(points[:, 3:6])
    energy = points[:, 6].copy() if has_energy else None
    for part, rates in evaluator.parts(*columns, energy):
        yield points[part].copy(), rates
