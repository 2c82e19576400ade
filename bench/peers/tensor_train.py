"""The image of a rate that is given as a tensor train on a grid, and the grids."""

from dataclasses import dataclass
from itertools import product

import numpy as np

from . import gauss, interpolant
from .contestant import Problem
from .counter import GridMemo

#: Grids as (nodes across, nodes along z). Where g jumps, many nodes along z: midpoints.
SMOOTH = ((12, 12), (16, 16), (20, 20), (24, 24), (28, 28), (32, 32), (40, 36), (48, 40), (64, 56))
THIN = ((16, 16), (24, 24), (32, 32), (40, 40), (48, 40), (64, 48), (80, 64), (96, 72), (112, 84))
JUMP = ((6, 16), (8, 24))
JUMP_MIDPOINTS = ((8, 64), (12, 64), (12, 256), (16, 256), (20, 256), (20, 1024))
#: Two surfaces, and folds in the image.
SURFACES = ((16, 128), (32, 128), (48, 256), (80, 256))


def settings(grids, midpoints=False, **choices):
    """One setting for each grid and each combination of the choices.

    The combinations of all are tried, so that none is judged by a number that does not suit it.
    """
    rule = {"midpoints": True} if midpoints else {}
    return [
        {"across": across, "depth": depth, **rule, **dict(zip(choices, chosen, strict=True))}
        for across, depth in grids
        for chosen in product(*choices.values())
    ]


@dataclass(frozen=True)
class Grid:
    """Gauss nodes in x and y, and Gauss nodes or midpoints in z."""

    across: int
    depth: int
    midpoints: bool = False

    def axes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The nodes along x, y and z."""
        node, _ = gauss.nodes(self.across)
        return node, node, self._depths()[0]

    def memo(self, problem: Problem) -> GridMemo:
        """The rate on the nodes, each evaluated once: cross requests many of them again."""
        return GridMemo(problem.rate, self.axes())

    def image(self, cores, shape: tuple[int, int]) -> np.ndarray:
        """The pixel means of a train of three cores (rank, nodes, rank)."""
        in_x, in_y, in_z = (np.asarray(core) for core in cores)
        height, width = shape
        along_z = in_z[:, :, 0] @ self._depths()[1]
        to_columns = interpolant.from_gauss_nodes(self.across, width)
        to_rows = interpolant.from_gauss_nodes(self.across, height)
        return to_rows @ (in_y @ along_z).T @ (to_columns @ in_x[0]).T

    def _depths(self) -> tuple[np.ndarray, np.ndarray]:
        return gauss.panels(self.depth, 1) if self.midpoints else gauss.nodes(self.depth)
