"""A sensitivity matrix: how much each of many functions adds to each pixel of some cameras."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emitree import _npz
from emitree._files import written
from emitree._function import Floats

#: What the entry `format` of each file is, and the version of what is written.
_FORMAT, _VERSION = "emitree sensitivity", 1
#: The fields that are written as they are, and all entries of a file.
_PLAIN = ("error", "scale", "tolerance", "shapes", "in_image", "lines", "evaluations")
_ENTRIES = ("data", "indices", "indptr", *_PLAIN, "unit", "is_one_camera")


@dataclass(frozen=True, repr=False)
class Sensitivity:
    """A sensitivity matrix: the response of each pixel of some cameras to each of k functions.

    An entry is the mean over the solid angle of a pixel (of parallel lines, over its area) of the
    integral of a function along the line of sight. The response to a sum of functions with
    coefficients c, rates per steradian, is the radiance `matrix @ c`.
    """

    #: `scipy.sparse.csr_array`, (pixels, k) [length]. Pixels are in the order of the cameras, and
    #: those of each row by row, as `image.ravel()` has them: row 0 is the lowest y.
    matrix: Any
    #: The estimated largest error (k,) of an entry of each column [length].
    error: Floats
    #: The largest entry (k,) of each column, to which the tolerance is relative; at least a
    #: millionth of the largest of all [length].
    scale: Floats
    #: What the error of a column was to be, relative to `scale`.
    tolerance: float
    #: (height, width) of each camera.
    shapes: tuple[tuple[int, int], ...]
    #: Whether each pixel (pixels,) is in the image, at least in part. Those outside of the disc of
    #: a fisheye are not: their rows are 0.
    in_image: NDArray[np.bool_]
    #: The unit of the entries, that of the lengths of the cameras; None without one.
    unit: str | None
    #: How many integrals of a function along a line were made.
    lines: int
    #: How often functions were evaluated; voxels need none.
    evaluations: int
    _is_one_camera: bool = field(default=False)

    @property
    def relative_error(self) -> Floats:
        """The estimated error (k,) of each column relative to its largest entry; 0 if all are 0."""
        scale = np.where(self.scale > 0.0, self.scale, 1.0)
        return self.error / scale

    @property
    def converged(self) -> bool:
        """Whether all columns are within the tolerance."""
        return bool((self.error <= self.tolerance * self.scale).all())

    def image(self, coefficients: Any) -> Any:
        """The image (height, width) for coefficients (k,); of several cameras a list.

        As of `render`, pixels outside of the disc of a fisheye are NaN.
        """
        pixels = self.matrix @ self._checked(coefficients)
        return self.split(np.where(self.in_image, pixels, np.nan))

    def split(self, pixels: Any) -> Any:
        """The image (height, width) of numbers (pixels,); of several cameras a list."""
        values = np.asarray(pixels)
        sizes = [height * width for height, width in self.shapes]
        if values.shape != (sum(sizes),):
            raise ValueError(f"`pixels` has the shape {values.shape}: expected ({sum(sizes)},)")
        parts = np.split(values, np.cumsum(sizes)[:-1])
        images = [part.reshape(shape) for part, shape in zip(parts, self.shapes, strict=True)]
        return images[0] if self._is_one_camera else images

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Writes the matrix and all that is known of it to a file, NumPy's .npz.

        The file is whole or absent: one that is replaced stays until the other is complete.

        Raises `FileExistsError` if there is such a file and not `overwrite`.
        """
        arrays = {name: getattr(self.matrix, name) for name in ("data", "indices", "indptr")}
        arrays |= {name: np.asarray(getattr(self, name)) for name in _PLAIN}
        arrays |= {"unit": self.unit or "", "is_one_camera": self._is_one_camera}
        written(_npz.encoded(_FORMAT, _VERSION, arrays), path, overwrite)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Sensitivity:
        """A matrix from a file of `save`.

        Raises `FileNotFoundError` if there is no file, `ValueError` if it is not that of a matrix,
        `ImportError` without scipy.
        """
        sparse = scipy_sparse()
        found = _npz.arrays_of(path, "a sensitivity matrix", _FORMAT, _VERSION, _ENTRIES)
        shapes = tuple((int(height), int(width)) for height, width in found["shapes"])
        pixels, functions = sum(height * width for height, width in shapes), len(found["error"])
        indices, indptr = found["indices"], found["indptr"]
        agree = (
            found["scale"].shape == (functions,)
            and found["in_image"].shape == (pixels,)
            and indptr.shape == (pixels + 1,)
            and indices.shape == found["data"].shape == (indptr[-1],)
            and bool(np.all(np.diff(indptr) >= 0))
            and (indices.size == 0 or (indices.min() >= 0 and indices.max() < functions))
        )
        if not agree:
            raise ValueError(
                f"{os.fspath(path)}: the arrays of the sensitivity matrix do not agree: expected "
                f"{pixels} pixels and {functions} functions"
            )
        parts = found["data"], indices, indptr
        return cls(
            matrix=sparse.csr_array(parts, shape=(pixels, functions)),
            error=found["error"],
            scale=found["scale"],
            tolerance=float(found["tolerance"]),
            shapes=shapes,
            in_image=found["in_image"].astype(bool),
            unit=str(found["unit"]) or None,
            lines=int(found["lines"]),
            evaluations=int(found["evaluations"]),
            _is_one_camera=bool(found["is_one_camera"]),
        )

    def _checked(self, coefficients: Any) -> Floats:
        values = np.asarray(coefficients, dtype=float)
        count = self.matrix.shape[1]
        if values.shape != (count,):
            raise ValueError(f"`coefficients` has the shape {values.shape}: expected ({count},)")
        return values

    def __repr__(self) -> str:
        pixels, functions = self.matrix.shape
        worst = self.relative_error.max(initial=0.0)
        state = "converged" if self.converged else "NOT converged"
        return (
            f"<emitree sensitivity: {pixels} pixels x {functions} functions, {self.matrix.nnz} "
            f"entries, {len(self.shapes)} camera{'s' * (len(self.shapes) != 1)}, {state}: "
            f"error {worst:.2g} of the largest entry of a column>"
        )


def scipy_sparse() -> Any:
    """The module `scipy.sparse`; raises `ImportError` that says how to install it."""
    try:
        import scipy.sparse
    except ImportError:
        raise ImportError(
            "scipy is missing: expected it for `sensitivity`; `pip install emitree[fit]`"
        ) from None
    return scipy.sparse
