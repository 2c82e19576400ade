"""Surfaces at which the emission rate jumps, as a result of a rendering."""

from __future__ import annotations

import errno
import html
import os
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from emitree import _native
from emitree._display_places import extent_html, places_html, span_html
from emitree._function import Floats


@dataclass(frozen=True, eq=False)
class Surfaces:
    """Surfaces at which the emission rate jumps, as far as they were found: triangles.

    position: (n, 3), world coordinates of the vertices, in `length_unit`.
    normal: (n, 3), unit vectors perpendicular to the surface, to the side with the larger rate.
    jump: (n,), the difference of the rate between the two sides, above 0, in `jump_unit`.
    uncertainty: (n,), the expected displacement along the normal, in `length_unit`: an estimate,
        and no bound.
    triangles: (m, 3), the numbers of their vertices, anticlockwise seen from the side with the
        larger rate.
    length_unit, jump_unit: that of the camera and that of the rate; "" if they are not known.

    Vertices are on the surfaces that the image is made of, about as far from each other as the
    cells of a lattice in the view are wide. Surfaces end at the borders of a view that is
    one image plane, and up to a cell before those of other views (discs, skies) and of the bounds,
    and before lines on which three regions meet.
    """

    position: Floats
    normal: Floats
    jump: Floats
    uncertainty: Floats
    triangles: NDArray[np.int64]
    length_unit: str
    jump_unit: str
    _found: _native.Rendered = field(repr=False)

    def __len__(self) -> int:
        return len(self.position)

    def __repr__(self) -> str:
        unit = f" in {self.length_unit}" if self.length_unit else ""
        return f"<emitree.Surfaces{unit}: {len(self)} vertices, {len(self.triangles)} triangles>"

    def _repr_html_(self) -> str:
        rows = {"vertices": f"{len(self):,}", "triangles": f"{len(self.triangles):,}"}
        rows |= extent_html(self.position, self.length_unit)
        if len(self):
            rows["jump"] = span_html(self.jump.min(), self.jump.max(), self.jump_unit)
            uncertainty = float(np.median(self.uncertainty))
            rows["uncertainty"] = f"{uncertainty:.2g} {html.escape(self.length_unit)} (median)"
        return places_html(self.position, rows)

    def write(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Writes them to a file: .vtp, polygons of VTK for ParaView and PyVista, or .npz.

        A file is whole or absent: one that is replaced stays until the other is complete.
        """
        encoded = self._found.surfaces_file(path) or b""
        if not overwrite and os.path.lexists(path):
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), os.fspath(path))
        with _native.OutputFile(path) as output:
            output.commit(encoded)
