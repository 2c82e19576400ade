"""Tetrahedra of a mesh: location of points near a known cell, and linear interpolation."""

from __future__ import annotations

from typing import Any

import numpy as np

from emitree._function import Floats

#: How far beyond a face a point still belongs to a cell, in barycentric coordinates: rounding.
_ROUNDING = 1e-12
#: After so many steps from cell to cell a point is taken as outside: only overlapping cells need
#: more.
_STEPS = 64


class Tetrahedra:
    """Tetrahedra that share faces.

    points: (p, 3) [length]; cells: the corners (m, 4), numbers of points. No cell is flat.

    >>> points = np.vstack([np.zeros(3), np.eye(3), np.ones(3)])
    >>> tetrahedra = Tetrahedra(points, np.array([[0, 1, 2, 3], [1, 2, 3, 4]]))
    >>> position = np.array([[0.1, 0.2, 0.3], [0.6, 0.6, 0.6], [0.9, 0.9, 0.1]])
    >>> cell, coordinates = tetrahedra.located(position, [0, 0, 0])
    >>> cell
    array([ 0,  1, -1])
    >>> tetrahedra.interpolated(points @ [1.0, 10.0, 100.0], cell[:2], coordinates[:2])
    array([32.1, 66.6])
    """

    def __init__(self, points: Floats, cells: Any) -> None:
        corners = points[cells]
        self._cells = cells
        self._origin = corners[:, 0]
        self._inverse = np.linalg.inv(corners[:, 1:] - corners[:, :1])
        self._neighbours = _neighbours(points, cells)

    def located(self, position: Floats, guess: Any) -> tuple[Any, Floats]:
        """The cell (n,) of each point (n, 3), -1 outside, and its barycentric coordinates (n, 4).

        guess: the cell (n,) from which the search of each point starts, -1 for none. From there it
        goes through the face beyond which the point is farthest, and a point is outside where no
        cell has that face too.
        """
        cell = np.array(guess)
        coordinates = np.zeros((len(position), 4))
        moving = np.flatnonzero(cell >= 0)
        for _ in range(_STEPS):
            at = cell[moving]
            offset = position[moving] - self._origin[at]
            rest = np.einsum("ni,nij->nj", offset, self._inverse[at])
            found = np.column_stack([1.0 - rest.sum(axis=1), rest])
            coordinates[moving] = found
            face = found.argmin(axis=1)
            is_beyond = found[np.arange(len(found)), face] < -_ROUNDING
            moving = moving[is_beyond]
            if len(moving) == 0:
                return cell, coordinates
            cell[moving] = self._neighbours[at[is_beyond], face[is_beyond]]
            moving = moving[cell[moving] >= 0]
        cell[moving] = -1
        return cell, coordinates

    def interpolated(self, values: Floats, cell: Any, coordinates: Floats) -> Floats:
        """Values at points (p,), interpolated in cells (n,) with coordinates (n, 4)."""
        return np.asarray((values[self._cells[cell]] * coordinates).sum(axis=1))


def flat(points: Floats, cells: Any) -> Any:
    """Which tetrahedra (m,) have no volume but for rounding."""
    corners = points[cells]
    edges = corners[:, 1:] - corners[:, :1]
    size = np.linalg.norm(edges, axis=2).max(axis=1)
    return np.abs(np.linalg.det(edges)) <= 1e-13 * size**3


def _neighbours(points: Floats, cells: Any) -> Any:
    """The cell (m, 4) beyond the face opposite of each corner, -1 for none."""
    # Blocks of a mesh may have points of their own at the same positions.
    _, same = np.unique(points, axis=0, return_inverse=True)
    numbers = same.reshape(-1)[cells]
    faces = np.stack([np.delete(numbers, corner, axis=1) for corner in range(4)], axis=1)
    faces = np.sort(faces.reshape(-1, 3), axis=1)
    order = np.lexsort(faces.T)
    is_shared = (faces[order[1:]] == faces[order[:-1]]).all(axis=1)
    one, other = order[:-1][is_shared], order[1:][is_shared]
    neighbours = np.full(len(faces), -1, dtype=np.int64)
    neighbours[one], neighbours[other] = other // 4, one // 4
    return neighbours.reshape(-1, 4)
