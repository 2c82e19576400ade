"""TT-cross of the package teneva on a grid of Gauss nodes."""

import numpy as np

from .. import tensor_train
from ..contestant import OTHERWISE, Contestant, Found


def _cross(problem, across, depth, tolerance, growth, seed, midpoints=False):
    import teneva

    grid = tensor_train.Grid(across, depth, midpoints)
    # It draws from NumPy's generator as well as from its own.
    np.random.seed(seed)
    start = teneva.rand([across, across, depth], r=1, seed=seed)
    how = {}
    cores = teneva.cross(
        grid.memo(problem),
        start,
        e=tolerance,
        nswp=40,
        dr_min=1,
        dr_max=growth,
        info=how,
    )
    ranks = [core.shape[2] for core in cores[:2]]
    return Found(grid.image(cores, problem.shape), note=f"ranks {ranks}, ended by {how['stop']}")


CHOICES = {"growth": (1, 2), "seed": (0, 1)}
THIN = [
    *tensor_train.settings(tensor_train.THIN[:5], tolerance=(0.1, 1e-2, 1e-3), **CHOICES),
    *tensor_train.settings(tensor_train.THIN[5:7], tolerance=(1e-3,), **CHOICES),
]

CONTESTANTS = [
    Contestant(
        name="teneva",
        distribution="teneva",
        about="TT-cross on Gauss nodes, ranks growing by 1 or up to 2, exact pixel means",
        run=_cross,
        settings={
            "eq8": tensor_train.settings(tensor_train.SMOOTH, tolerance=(1e-2, 1e-4), **CHOICES),
            "shock": [
                *tensor_train.settings(tensor_train.JUMP, tolerance=(0.1, 1e-3), **CHOICES),
                *tensor_train.settings(
                    tensor_train.JUMP_MIDPOINTS[:4], True, tolerance=(0.1, 1e-3), **CHOICES
                ),
            ],
            "smile": tensor_train.settings(
                tensor_train.SURFACES, True, tolerance=(1e-2,), growth=(2,), seed=(0, 1)
            ),
            "zodi": [],
            OTHERWISE: THIN,
        },
        modules=("teneva",),
    )
]
