"""The contestants. A further one is a file with a list `CONTESTANTS`, and its name here."""

from . import (
    adaptive_cubature,
    fixed_step,
    gauss_grid,
    ours,
    quad_lines,
    raysect_camera,
    tt_pychebyshev,
    tt_teneva,
    tt_tntorch,
    yt_grid,
    zodipy_model,
)

#: In the order of the tables: ours first, then from the strongest to the most common.
CONTESTANTS = {
    contestant.name: contestant
    for module in (
        ours,
        tt_teneva,
        tt_tntorch,
        tt_pychebyshev,
        gauss_grid,
        quad_lines,
        adaptive_cubature,
        fixed_step,
        yt_grid,
        raysect_camera,
        zodipy_model,
    )
    for contestant in module.CONTESTANTS
}
