"""Gauss-Legendre grids, one for the whole cube or one in each of equal elements."""

from functools import partial

import numpy as np

from .. import gauss, interpolant
from ..contestant import OTHERWISE, Contestant, Found

ACROSS = (
    *(3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 18, 20, 24, 28, 32, 36, 40, 48),
    *(56, 64, 80, 96, 112, 128, 160, 192),
)
#: Few nodes across and many along z: where the image is smooth and g is not.
DEEP = {(n, depth) for n in (8, 12, 16, 20) for depth in (64, 128, 256, 512, 1024, 4096)}
#: Where thin bands are seen over the whole width of the image, (nodes across, along lines).
OF_ZODI = ((12, 24), (16, 32), (24, 32), (32, 48), (48, 48), (64, 64), (96, 64), (128, 96))
#: The most nodes of all elements together.
LARGEST = 8_000_000


def _project(problem, across, depth, elements):
    height, width = problem.shape
    node, _ = gauss.panels(elements, across)
    z, weight = gauss.panels(elements, depth)
    lines = [problem.rate(node[:, None], y, z) @ weight for y in node]
    return Found(_to(height, across, elements) @ lines @ _to(width, across, elements).T)


def _to(pixels, across, elements):
    """The matrix from the nodes of all elements to pixels, some of them in each element."""
    return np.kron(np.eye(elements), interpolant.from_gauss_nodes(across, pixels // elements))


def _whole(extra=()):
    grids = {(n, max(2, depth)) for n in ACROSS for depth in (n // 2, 3 * n // 4, n)}
    ordered = sorted(grids | set(extra), key=lambda grid: grid[0] ** 2 * grid[1])
    return [{"across": across, "depth": depth} for across, depth in ordered]


def _grids(grids):
    return [{"across": across, "depth": depth} for across, depth in grids]


def _in_elements(counts):
    return [
        {"elements": elements, "across": across, "depth": depth}
        for elements in counts
        for across in (2, 3, 4, 5, 6, 8, 10, 12)
        for depth in (across // 2, across)
        if elements**3 * across**2 * depth <= LARGEST
    ]


CONTESTANTS = [
    Contestant(
        name="Gauss grid",
        distribution="numpy",
        about="one tensor grid of Gauss-Legendre nodes, exact pixel means of its interpolant",
        run=partial(_project, elements=1),
        settings={
            OTHERWISE: _whole(),
            "shock": _whole(DEEP),
            "smile": _whole(DEEP),
            "zodi": _grids(OF_ZODI),
        },
    ),
    Contestant(
        name="Gauss elements",
        distribution="numpy",
        about="the same in each of 2 to 16 elements along each axis",
        run=_project,
        settings={
            OTHERWISE: _in_elements((2, 4, 8, 16)),
            "smile": _in_elements((2, 5, 10)),
            "zodi": [],
        },
    ),
]
