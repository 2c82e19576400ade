"""TT-cross of the package pychebyshev on its Chebyshev nodes."""

from .. import interpolant, tensor_train
from ..contestant import OTHERWISE, Contestant, Found
from ..counter import PointMemo


def _cross(problem, across, depth, tolerance, seed):
    from pychebyshev import ChebyshevTT

    memo = PointMemo(problem.rate)
    train = ChebyshevTT(
        lambda point, _: memo(point),
        3,
        [(0, 1)] * 3,
        [across, across, depth],
        max_rank=90,
        tolerance=tolerance,
        max_sweeps=20,
    )
    train.build(verbose=False, seed=seed)
    ranks = list(train.tt_ranks[1:3])
    lines = train.integrate(dims=[2])
    height, width = problem.shape
    x, y = ChebyshevTT.nodes(2, [(0, 1)] * 2, [across, across])["nodes_per_dim"]
    to_columns = interpolant.from_chebyshev_nodes(x, width)
    to_rows = interpolant.from_chebyshev_nodes(y, height)
    return Found(to_rows @ lines.to_dense().T @ to_columns.T, note=f"ranks {ranks}")


SEEDS = (0, 1)
THIN = [
    *tensor_train.settings(tensor_train.THIN[:5], tolerance=(1e-3,), seed=SEEDS),
    *tensor_train.settings(tensor_train.THIN[5:], tolerance=(1e-3, 1e-8), seed=SEEDS),
]

CONTESTANTS = [
    Contestant(
        name="pychebyshev",
        distribution="pychebyshev",
        about="TT-cross on Chebyshev nodes, exact pixel means",
        run=_cross,
        settings={
            "eq8": tensor_train.settings(tensor_train.SMOOTH, tolerance=(1e-4,), seed=SEEDS),
            "shock": tensor_train.settings(
                tensor_train.JUMP + tensor_train.JUMP_MIDPOINTS, tolerance=(1e-3,), seed=SEEDS
            ),
            "smile": tensor_train.settings(tensor_train.SURFACES, tolerance=(1e-3,), seed=SEEDS),
            "zodi": [],
            OTHERWISE: THIN,
        },
        modules=("pychebyshev",),
    )
]
