"""Emitree: it is told a tolerance and decides the rest."""

from ..contestant import OTHERWISE, Contestant, Found

TOLERANCES = (
    *(0.5, 0.3, 0.2, 0.1, 0.06, 0.05, 0.03, 0.02, 0.01, 0.005, 0.002),
    *(1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6),
)


def _render(problem, tolerance):
    import emitree

    rendering = emitree.render(
        lambda position, direction: problem.rate.at(position),
        emitree.Canonical(),
        problem.shape,
        tolerance=tolerance,
        threads=1,
    )
    if rendering.evaluations != problem.rate.evaluations:
        raise AssertionError(
            f"emitree reports {rendering.evaluations} evaluations: expected the"
            f" {problem.rate.evaluations} that were counted"
        )
    note = "" if rendering.converged else "not converged"
    return Found(rendering.image, rendering.estimated_error, note)


CONTESTANTS = [
    Contestant(
        name="emitree",
        distribution="emitree",
        about="method `vol`, told a tolerance and nothing else",
        run=_render,
        settings={OTHERWISE: [{"tolerance": tolerance} for tolerance in TOLERANCES]},
        modules=("emitree",),
        patience=1,
    )
]
