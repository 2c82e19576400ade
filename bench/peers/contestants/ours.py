"""Emitree with a tolerance and its defaults."""

from dataclasses import fields

from ..camera import Equirectangular, WithinSphere
from ..contestant import OTHERWISE, Contestant, Found

TOLERANCES = (
    *(0.5, 0.3, 0.2, 0.1, 0.06, 0.05, 0.03, 0.02, 0.01, 0.005, 0.002),
    *(1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6),
)


def _render(problem, tolerance):
    import emitree

    rendering = emitree.render(
        lambda position, direction: problem.emission.at(position),
        _camera(problem),
        problem.shape,
        tolerance=tolerance,
        threads=1,
        bounds=_bounds(problem.camera),
    )
    if rendering.evaluations != problem.emission.evaluations:
        raise AssertionError(
            f"emitree reports {rendering.evaluations} evaluations: expected the"
            f" {problem.emission.evaluations} that were counted"
        )
    note = "" if rendering.converged else "not converged"
    return Found(rendering.image, rendering.estimated_error, note)


def _camera(problem):
    import emitree

    if problem.camera is None:
        return emitree.Canonical()
    names = [field.name for field in fields(Equirectangular)]
    return emitree.Equirectangular(
        near=0.0, **{name: getattr(problem.camera, name) for name in names}
    )


def _bounds(camera):
    import emitree

    if not isinstance(camera, WithinSphere):
        return None
    return emitree.Sphere(center=(0.0, 0.0, 0.0), radius=camera.radius)


def _settings(tolerances):
    return [{"tolerance": tolerance} for tolerance in tolerances]


#: Tighter ones take minutes where the image has folds.
COARSE = (0.05, 0.02, 0.01, 0.005, 0.002, 0.001)
OF_ZODI = (0.1, 0.05, 0.02, 0.01, 0.005, 0.001)

CONTESTANTS = [
    Contestant(
        name="emitree",
        distribution="emitree",
        about="method `vol`, with a tolerance and defaults",
        run=_render,
        settings={
            OTHERWISE: _settings(TOLERANCES),
            "smile": _settings(COARSE),
            "zodi": _settings(OF_ZODI),
        },
        modules=("emitree",),
        limit_s=60.0,
        patience=1,
        has_cameras=True,
        for_users=True,
    )
]
