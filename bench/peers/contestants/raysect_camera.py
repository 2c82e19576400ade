"""A cube that emits before raysect's orthographic camera, and rays of another camera."""

import random

import numpy as np

from ..contestant import OTHERWISE, Contestant, Found


def _emitter(rate, step):
    from raysect.optical.material import InhomogeneousVolumeEmitter, NumericalIntegrator

    class Emitter(InhomogeneousVolumeEmitter):
        def emission_function(self, point, direction, spectrum, *scene):
            spectrum.samples[0] += float(rate(point.x, point.y, point.z))
            return spectrum

    return Emitter(NumericalIntegrator(step=step, min_samples=2))


def _observe(problem, steps, rays):
    from raysect.core import Point3D, translate
    from raysect.core.math import random as rays_random
    from raysect.core.workflow import SerialEngine
    from raysect.optical import World
    from raysect.optical.observer import OrthographicCamera, RadiancePipeline2D
    from raysect.primitive import Box

    # Where a ray goes through its pixel is random, and nothing else is on offer. Python's own
    # generator decides which pixel comes first.
    random.seed(1)
    rays_random.seed(1)
    height, width = problem.shape
    world = World()
    material = _emitter(problem.rate, 1 / steps)
    Box(Point3D(0, 0, 0), Point3D(1, 1, 1), parent=world, material=material)
    pipeline = RadiancePipeline2D(display_progress=False, accumulate=False)
    camera = OrthographicCamera(
        (width, height),
        width=1.0,
        parent=world,
        pipelines=[pipeline],
        transform=translate(0.5, 0.5, -1.0),
    )
    # One bin of unit width: its radiance is the integral of g.
    camera.spectral_bins, camera.min_wavelength, camera.max_wavelength = 1, 500, 501
    camera.pixel_samples, camera.quiet = rays, True
    camera.render_engine = SerialEngine()
    camera.observe()
    # Its pixels (column, row) start at the upper left, and it looks along +z with x to the left.
    return Found(np.asarray(pipeline.frame.mean)[::-1, ::-1].T)


def _trace(problem, steps, across):
    """The image of a camera, by across x across rays in each pixel.

    Raysect has no camera with equal angles, and its `VectorCamera` spreads the rays of a pixel
    over the neighbours of the pixel: rays are traced one by one.
    """
    from raysect.core import Point3D, Vector3D, translate
    from raysect.optical import Ray, World
    from raysect.primitive import Sphere

    camera, world = problem.camera, World()
    # A sphere about the observer, where all lines end. Its own centre is its origin.
    around = lambda x, y, z: problem.emission(*np.add(camera.position, (x, y, z)))  # noqa: E731
    material = _emitter(around, camera.far / steps)
    Sphere(camera.far, parent=world, transform=translate(*camera.position), material=material)
    observer, bin_ = Point3D(*camera.position), {"min_wavelength": 500, "max_wavelength": 501}
    lines = camera.lines(problem.shape, across)
    radiances = [
        Ray(observer, Vector3D(*line), bins=1, **bin_).trace(world).samples[0]
        for line in lines.reshape(-1, 3)
    ]
    return Found(np.reshape(radiances, lines.shape[:-1]).mean(axis=(2, 3)))


def _image(problem, **setting):
    return _observe(problem, **setting) if problem.camera is None else _trace(problem, **setting)


CONTESTANTS = [
    Contestant(
        name="raysect",
        distribution="raysect",
        about="`InhomogeneousVolumeEmitter` before the `OrthographicCamera`, random rays in each "
        "pixel; for a camera in space rays are traced one by one",
        run=_image,
        settings={
            OTHERWISE: [
                {"steps": steps, "rays": rays}
                for steps, rays in ((8, 1), (16, 1), (16, 4), (32, 4), (16, 16))
            ],
            "smile": [{"steps": steps, "across": 1} for steps in (40, 160)],
            # Its lines would end at a sphere about the observer.
            "zodi": [],
        },
        modules=("raysect.optical", "raysect.primitive"),
        limit_s=60.0,
        patience=1,
        has_cameras=True,
        for_users=True,
    )
]
