"""TT-cross of the package tntorch on a grid of Gauss nodes."""

import numpy as np

from .. import tensor_train
from ..contestant import OTHERWISE, Contestant, Found


def _cross(problem, across, depth, tolerance, growth, seed, midpoints=False):
    import tntorch
    import torch

    torch.set_num_threads(1)
    torch.set_default_dtype(torch.float64)
    torch.manual_seed(seed)
    np.random.seed(seed)
    grid = tensor_train.Grid(across, depth, midpoints)
    memo = grid.memo(problem)

    def rates(*indices):
        return torch.as_tensor(memo(np.rint(np.stack(indices, axis=1))))

    nodes = (across, across, depth)
    train = tntorch.cross(
        function=rates,
        # Indices in the place of coordinates: those are what nodes are known by.
        domain=[torch.arange(count, dtype=torch.float64) for count in nodes],
        eps=tolerance,
        rmax=120,
        kickrank=growth,
        max_iter=25,
        # Points for its own check count as evaluations: fewer on small grids.
        val_size=int(np.clip(across**2 * depth // 50, 50, 1000)),
        verbose=False,
        suppress_warnings=True,
    )
    image = grid.image([core.numpy() for core in train.cores], problem.shape)
    return Found(image, note=f"ranks {[int(rank) for rank in train.ranks_tt[1:3]]}")


#: The default of the package is a growth of 3.
CHOICES = {"growth": (1, 2, 4), "seed": (0, 1)}
THIN = [
    *tensor_train.settings(tensor_train.THIN[:5], tolerance=(1e-2, 1e-3), **CHOICES),
    *tensor_train.settings(tensor_train.THIN[5:], tolerance=(1e-3,), **CHOICES),
]
JUMP = (1e-2, 1e-3)

CONTESTANTS = [
    Contestant(
        name="tntorch",
        distribution="tntorch",
        about="TT-cross on Gauss nodes, ranks growing by 1, 2 or 4, exact pixel means",
        run=_cross,
        settings={
            "eq8": tensor_train.settings(tensor_train.SMOOTH, tolerance=(1e-4,), **CHOICES),
            "shock": [
                *tensor_train.settings(tensor_train.JUMP, tolerance=JUMP, **CHOICES),
                *tensor_train.settings(
                    tensor_train.JUMP_MIDPOINTS, True, tolerance=JUMP, **CHOICES
                ),
            ],
            "smile": tensor_train.settings(
                tensor_train.SURFACES, True, tolerance=(1e-2,), growth=(4,), seed=(0, 1)
            ),
            "zodi": [],
            OTHERWISE: THIN,
        },
        modules=("torch", "tntorch"),
    )
]
