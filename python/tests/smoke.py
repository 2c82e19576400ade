"""A package as it was installed: `python smoke.py`, with NumPy alone and in any folder.

Wheels are tried with it before they are published, on systems on which the tests are not run.
"""

import math
import tempfile
from importlib import metadata
from pathlib import Path

import numpy as np

import emitree

# The radiance of exp(-r^2) along a whole line at the distance b is sqrt(pi) exp(-b^2).
LARGEST = math.sqrt(math.pi)


def mean(low, high):
    """The mean of exp(-t^2) between two places."""
    return LARGEST / 2 * (math.erf(high) - math.erf(low)) / (high - low)


def ball(position, direction):
    return np.exp(-(position**2).sum(axis=1))


def main():
    camera = emitree.Orthographic(
        position=(8, 0, 0), target=(0, 0, 0), extent=(4, 4), near=0, far=16, length_unit="m"
    )
    rendering = emitree.render(ball, camera, (8, 8), tolerance=1e-3)
    means = [mean(-2 + 0.5 * i, -1.5 + 0.5 * i) for i in range(8)]
    exact = LARGEST * np.outer(means, means)
    error = np.abs(rendering.image - exact).max() / exact.max()
    assert rendering.converged and error < 1e-3, error

    # Formulas, models, energies, and data on a grid, without any function of Python.
    formula = emitree.render("exp(-x^2 - y^2 - z^2)", camera, (8, 8), tolerance=1e-3)
    assert np.abs(formula.image - exact).max() < 1e-3 * exact.max()
    model = emitree.render(emitree.Model("holmstrom"), emitree.Canonical(), (8, 8))
    assert model.converged and model.image.min() > 0
    nodes = np.linspace(-1, 1, 5)
    grid = emitree.Grid(values=np.full((5, 5, 5), 3.0), x=nodes, y=nodes, z=nodes)
    inside = emitree.Orthographic(
        position=(8, 0, 0), target=(0, 0, 0), extent=(1, 1), near=0, far=16, length_unit="m"
    )
    assert np.allclose(emitree.render(grid, inside, (2, 2)).image, 6.0, rtol=1e-2)
    cube = emitree.render(
        lambda r, d, energy: ball(r, d) * energy,
        camera,
        (4, 4),
        energy=emitree.Energies(1, 3, 2, unit="keV"),
        unit="ph cm-3 s-1 sr-1 keV-1",
    )
    assert np.allclose(cube.image[1] / cube.image[0], 2.5 / 1.5, rtol=2e-2)

    # Files: a plan, and a tree.
    with tempfile.TemporaryDirectory() as folder:
        rendering.plan.save(f"{folder}/plan.npz")
        plan = emitree.Plan.load(f"{folder}/plan.npz")
        assert np.allclose(plan.apply(plan.rates(ball)), rendering.image, rtol=1e-12)
        tree = Path(folder) / "tree.fits"
        box = emitree.Box(min=(-2, -2, -2), max=(2, 2, 2))
        emitree.build_tree(ball, tree, bounds=box, length_unit="m", tolerance=0.02)
        assert tree.read_bytes().startswith(b"SIMPLE  =")
        again = emitree.render(emitree.Tree(tree), camera, (8, 8), tolerance=0.05)
        assert np.abs(again.image - exact).max() < 0.1 * exact.max()

    print(f"emitree {metadata.version('emitree')}: error {error:.1e}")


if __name__ == "__main__":
    main()
