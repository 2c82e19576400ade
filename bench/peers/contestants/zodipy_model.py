"""ZodiPy itself: Gauss points along the line of sight through the centre of each pixel."""

import numpy as np

from ..contestant import OTHERWISE, Contestant, Found


def _evaluate(problem, points, across):
    import zodipy
    from astropy import units
    from astropy.coordinates import BarycentricMeanEcliptic, CartesianRepresentation, SkyCoord
    from astropy.time import Time

    from .. import zodi

    lines = problem.camera.lines(problem.shape, across)
    directions = CartesianRepresentation(lines.reshape(-1, 3).T)
    sky = SkyCoord(directions, frame=BarycentricMeanEcliptic(), obstime=Time(zodi.TIME))
    # The ephemeris that astropy brings along: nothing is downloaded.
    model = zodipy.Model(25 * units.micron, gauss_quad_degree=points, ephemeris="builtin")
    found = model.evaluate(sky, obspos=np.array(zodi.EARTH) * units.AU)
    # It does not call the rate: its points are counted here, those of all components as one.
    problem.emission.evaluations += sky.size * points
    lines_of_pixels = found.to_value(units.MJy / units.sr).reshape(lines.shape[:-1])
    return Found(lines_of_pixels.mean(axis=(2, 3)))


CONTESTANTS = [
    Contestant(
        name="ZodiPy",
        distribution="zodipy",
        about="its own integration of its own model: Gauss points for each component on 1 x 1 or "
        "2 x 2 lines of sight through each pixel; its default is 50 on one line. A point of all "
        "six components counts once",
        run=_evaluate,
        settings={
            "zodi": [
                *({"points": points, "across": 1} for points in (10, 20, 50, 100, 200)),
                *({"points": points, "across": 2} for points in (50, 100)),
            ],
            OTHERWISE: [],
        },
        modules=("zodipy",),
        limit_s=60.0,
        has_cameras=True,
        for_users=True,
    )
]
