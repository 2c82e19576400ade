"""The projection of a uniform grid by yt."""

import numpy as np

from .. import gauss
from ..contestant import OTHERWISE, Contestant, Found

FIELD = ("stream", "rate")


def _project(problem, cells):
    import yt

    yt.set_log_level("critical")
    height, width = problem.shape
    centre, _ = gauss.panels(cells, 1)
    rates = problem.rate(centre[:, None, None], centre[:, None], centre)
    unit_cube = np.array([[0.0, 1.0]] * 3)
    data = yt.load_uniform_grid({FIELD: (rates, "")}, rates.shape, bbox=unit_cube, nprocs=1)
    frame = yt.FixedResolutionBuffer(
        data.proj(FIELD, "z"), (0.0, 1.0, 0.0, 1.0), (height, width), antialias=True
    )
    return Found(np.asarray(frame[FIELD]))


CONTESTANTS = [
    Contestant(
        name="yt grid",
        distribution="yt",
        about="`load_uniform_grid` of g at the centres of n x n x n cells, projected along z",
        run=_project,
        settings={OTHERWISE: [{"cells": cells} for cells in (8, 16, 32, 64, 128, 192)]},
        modules=("yt",),
        patience=1,
    )
]
