"""Uniform grids in yt: projected along an axis, or seen by its ray caster from a camera."""

import numpy as np

from .. import gauss
from ..contestant import OTHERWISE, Contestant, Found

FIELD = ("stream", "rate")


def _project(problem, cells):
    """The unit cube, in cells x cells x cells."""
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


def _cast(problem, cell, across):
    """The image of cubes with edges `cell`, by across x across rays in each pixel."""
    from yt.utilities.lib.image_samplers import ProjectionSampler
    from yt.utilities.lib.partitioned_grid import PartitionedGrid

    camera, (height, width) = problem.camera, problem.shape
    low, high = camera.box()
    counts = np.ceil((high - low) / cell).astype(np.int64)
    x, y, z = (start + cell * (np.arange(n) + 0.5) for start, n in zip(low, counts, strict=True))
    rates = np.empty(counts)
    for plane, at in zip(rates, x, strict=True):
        plane[:] = problem.emission(at, y[:, None], z)
    grid = PartitionedGrid(
        0, [rates], np.ones(counts, dtype=np.uint8), low, low + cell * counts, counts
    )
    # It has no lens for a part of the sky in equal angles, but takes the rays of any.
    rays = camera.lines(problem.shape, across).swapaxes(1, 2)
    rays = rays.reshape(height * across, width * across, 3)
    places = np.broadcast_to(camera.position, rays.shape).copy()
    image = np.zeros((*rays.shape[:2], 4))
    unused = np.ones(3)
    sampler = ProjectionSampler(
        *(places, camera.far * rays, unused, (0.0, 1.0, 0.0, 1.0), image),
        *(unused, unused, unused, "KDTree", 1),
        lens_type="perspective",
    )
    sampler(grid, num_threads=1)
    # Rays end after a length of one, in their own.
    lines = camera.far * image[..., 0]
    return Found(lines.reshape(height, across, width, across).mean(axis=(1, 3)))


def _image(problem, **setting):
    return _project(problem, **setting) if problem.camera is None else _cast(problem, **setting)


CONTESTANTS = [
    Contestant(
        name="yt grid",
        distribution="yt",
        about="`load_uniform_grid` of g at the centres of n x n x n cells, projected along z; "
        "for a camera its `ProjectionSampler`, which its lenses use, with the camera's rays",
        run=_image,
        settings={
            OTHERWISE: [{"cells": cells} for cells in (8, 16, 32, 64, 128, 192)],
            "smile": [{"cell": cell, "across": 4} for cell in (1.0, 0.5, 0.25, 0.125, 0.08)],
            # Its rays have one length.
            "zodi": [],
        },
        modules=("yt", "yt.utilities.lib.image_samplers"),
        patience=1,
        has_cameras=True,
        for_users=True,
    )
]
