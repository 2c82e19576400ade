"""Images of data: evaluations and errors, against the function that was sampled and against scipy.

    python benches/data.py [CASE ...]

Needs scipy, and pyvista for the tetrahedra. Prints the tables of docs/results/data.md. Each case is
a function, known everywhere, that is sampled at nodes, cells, points or particles. Errors are
relative to the largest pixel:

* against the function: of the rendering, to the image of the function itself;
* against scipy: of the rendering, to the image of scipy's interpolant of the same data;
* of the data: the difference of these two images, which no rendering can avoid.

Both images are made by the method `los`: n x n lines of sight in each pixel, with adaptive steps.
The kernels of particles have integrals along lines that are functions of one variable: the image of
particles is the sum of these, without steps. The convergence of images is the difference to that of
n/2 x n/2 lines.
"""

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline, LinearNDInterpolator, RegularGridInterpolator
from scipy.spatial import Delaunay, cKDTree

import emitree

SHAPE = (32, 32)
TOLERANCE = 0.01
SEED = 7
#: How many points are evaluated to measure the time of one.
POINTS = 500_000


@dataclass
class Case:
    """A function, the data that sample it, and the same by scipy.

    function, by_scipy: of positions (n, 3); emission: what `render` takes; bounds: of both; lines:
    of `los` along each axis of a pixel; image_of_data: instead of `by_scipy`, the image of the data
    itself from n x n lines in each pixel.
    """

    name: str
    function: Callable[..., Any]
    emission: Any
    by_scipy: Callable[..., Any] | None
    camera: Any
    bounds: Any
    lines: int
    edges: tuple[Any, ...] = ()
    image_of_data: Callable[[int], Any] | None = None


def perspective() -> emitree.Perspective:
    """A camera that sees a ball of radius 4."""
    return emitree.Perspective(
        position=(9, -6, 5), target=(0, 0, 0), up=(0, 0, 1), field_of_view=(36, 36), far=30
    )


def corona() -> list[Case]:
    """A corona with streamers on a spherical grid of 60 x 40 x 80 nodes, logarithmic in r."""

    def function(position: Any, direction: Any = None) -> Any:
        r = np.linalg.norm(position, axis=1)
        sine = np.hypot(position[:, 0], position[:, 1]) / r
        phi = np.arctan2(position[:, 1], position[:, 0])
        return r**-4 * (1 + sine**2 * (1 + 0.5 * np.cos(2 * phi)) * np.exp(-(r - 1)))

    r = np.geomspace(1, 4, 60)
    theta = np.linspace(0, np.pi, 40)
    phi = np.arange(80) * 2 * np.pi / 80
    rr, tt, pp = np.meshgrid(r, theta, phi, indexing="ij")
    nodes = np.stack(
        [rr * np.sin(tt) * np.cos(pp), rr * np.sin(tt) * np.sin(pp), rr * np.cos(tt)], axis=-1
    )
    values = function(nodes.reshape(-1, 3)).reshape(rr.shape)
    closed = np.concatenate([values, values[..., :1]], axis=2)
    axes = (np.log(r), theta, np.append(phi, 2 * np.pi))
    table = RegularGridInterpolator(axes, closed, bounds_error=False, fill_value=0.0)

    def by_scipy(position: Any, direction: Any = None) -> Any:
        r = np.linalg.norm(position, axis=1)
        theta = np.arccos(np.clip(position[:, 2] / r, -1, 1))
        phi = np.arctan2(position[:, 1], position[:, 0]) % (2 * np.pi)
        return table(np.stack([np.log(r), theta, phi], axis=1))

    def grid(interpolation: str) -> emitree.Grid:
        return emitree.Grid(
            values=values,
            r=r,
            theta=theta,
            phi=phi,
            angle_unit="rad",
            logarithmic=["r"],
            interpolation=interpolation,
        )

    bounds = emitree.Sphere(center=(0, 0, 0), radius=4)
    edges = (emitree.Sphere(center=(0, 0, 0), radius=1),)

    def outside(position: Any, direction: Any = None) -> Any:
        return np.where(np.linalg.norm(position, axis=1) >= 1, function(position), 0.0)

    return [
        Case(
            f"corona, r θ φ, 60 x 40 x 80, {interpolation}",
            outside,
            grid(interpolation),
            by_scipy if interpolation == "linear" else None,
            perspective(),
            bounds,
            16,
            edges,
        )
        for interpolation in ("linear", "cubic", "monotone")
    ]


def lumps(position: Any, direction: Any = None) -> Any:
    """Three Gaussians, the smallest in the middle."""
    total = 0.0
    for centre, sigma, height in [
        ((0.1, 0.0, -0.1), 0.45, 1.0),
        ((-0.3, 0.3, 0.2), 0.9, 0.4),
        ((0.5, -0.6, 0.3), 1.1, 0.2),
    ]:
        offset = position - np.array(centre)
        total = total + height * np.exp(-(offset**2).sum(axis=-1) / (2 * sigma**2))
    return total


def centres(low: float, high: float, count: int) -> Any:
    """The centres of cells."""
    return low + (np.arange(count) + 0.5) * (high - low) / count


def cube() -> list[Case]:
    """A cube of 80 nodes along each edge."""
    nodes = np.linspace(-4, 4, 80)
    values = lumps(np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), axis=-1))
    table = RegularGridInterpolator((nodes,) * 3, values, bounds_error=False, fill_value=0.0)

    def by_scipy(position: Any, direction: Any = None) -> Any:
        return table(position)

    return [
        Case(
            f"cube, 80³, {interpolation}",
            lumps,
            emitree.Grid(values=values, x=nodes, y=nodes, z=nodes, interpolation=interpolation),
            by_scipy if interpolation == "linear" else None,
            perspective(),
            emitree.Box(min=(-4, -4, -4), max=(4, 4, 4)),
            4,
        )
        for interpolation in ("linear", "cubic", "monotone", "nearest")
    ]


def amr() -> list[Case]:
    """A cube of 48 cells along each edge, and one of 48 finer cells in the middle."""
    tables, blocks = [], []
    for level, half in enumerate((4.0, 2.0)):
        axis = centres(-half, half, 48)
        values = lumps(np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1))
        blocks.append(emitree.Block(level, (-half,) * 3, (half,) * 3, values))
        tables.append(
            RegularGridInterpolator((axis,) * 3, values, bounds_error=False, fill_value=None)
        )

    def by_scipy(position: Any, direction: Any = None) -> Any:
        is_fine = (np.abs(position) < 2).all(axis=1)
        found = tables[0](np.clip(position, -4 + 1 / 12, 4 - 1 / 12))
        found[is_fine] = tables[1](position[is_fine])
        return found

    bounds = emitree.Box(min=(-4, -4, -4), max=(4, 4, 4))
    return [
        Case(
            f"AMR cube, two levels of 48³ cells, {interpolation}",
            lumps,
            emitree.AmrGrid(blocks, interpolation=interpolation),
            by_scipy if interpolation == "linear" else None,
            perspective(),
            bounds,
            4,
        )
        for interpolation in ("linear", "quadratic", "nearest")
    ]


def tetrahedra() -> list[Case]:
    """A ball of tetrahedra between 40,000 points, whose density falls as 1/r."""
    import pyvista

    count = 40_000
    random = np.random.default_rng(SEED)
    points = random.normal(size=(count, 3))
    points *= (3 * random.random(count) ** 0.5 / np.linalg.norm(points, axis=1))[:, None]
    mesh = Delaunay(points)
    cells = np.insert(mesh.simplices, 0, 4, axis=1)
    dataset = pyvista.UnstructuredGrid(cells, np.full(len(cells), 10, dtype=np.uint8), points)
    dataset["rate"] = lumps(points)
    table = LinearNDInterpolator(mesh, dataset["rate"], fill_value=0.0)
    emission = emitree.from_pyvista(dataset, "rate")

    def function(position: Any, direction: Any = None) -> Any:
        return np.where(np.linalg.norm(position, axis=1) < 3, lumps(position), 0.0)

    return [
        Case(
            f"tetrahedral ball, {len(cells):,} cells",
            function,
            emission,
            lambda position, direction=None: table(position),
            perspective(),
            emission.bounds,
            4,
        )
    ]


def particles() -> list[Case]:
    """10⁵ smoothed particles with some 50 neighbours."""
    count = 100_000
    position = np.random.default_rng(SEED).normal(size=(count, 3))
    density = count * np.exp(-0.5 * (position**2).sum(axis=1)) / (2 * np.pi) ** 1.5
    radius = np.minimum((50 / (4 / 3 * np.pi * density)) ** (1 / 3), 1.5)
    of_each = np.full(count, 1 / count)
    emission = emitree.Particles(position, emission=of_each, support_radius=radius)
    camera, bounds = perspective(), emission.bounds

    def function(position: Any, direction: Any = None) -> Any:
        return np.exp(-0.5 * (position**2).sum(axis=1)) / (2 * np.pi) ** 1.5

    def by_columns(lines: int) -> Any:
        return columns_of_splines(camera, bounds, position, radius, of_each, lines)

    return [Case("10⁵ particles", function, emission, None, camera, bounds, 16, (), by_columns)]


def column_of_spline() -> Any:
    """The integral of the cubic spline of support radius 1 along a line, of its distance."""
    distance = np.linspace(0, 1, 4001)
    node, weight = np.polynomial.legendre.leggauss(40)
    total = np.zeros_like(distance)
    for end, factor in ((1.0, 1.0), (0.5, -4.0)):
        half = np.sqrt(np.maximum(end**2 - distance**2, 0))[:, None]
        along = half * 0.5 * (node + 1)
        r = np.hypot(distance[:, None], along)
        total += factor * (half * weight * np.maximum(end - r, 0) ** 3).sum(axis=1)
    return CubicSpline(distance, 16 / np.pi * total)


def columns_of_splines(
    camera: Any, bounds: Any, position: Any, radius: Any, of_each: Any, lines: int
) -> Any:
    """The image of particles with cubic splines from n x n lines of sight in each pixel.

    The integral of a kernel along a line is a function of their distance. cKDTree finds the lines
    that pass each particle, by the angles between them as the observer sees them.
    """
    height, width = SHAPE[0] * lines, SHAPE[1] * lines
    sight = camera.lines((height, width), bounds=bounds).directions
    tree, column = cKDTree(sight), column_of_spline()
    offset = position - np.array(camera.position)
    away = np.linalg.norm(offset, axis=1)
    found = np.zeros(len(sight))
    # Groups of particles whose supports are of similar angles: few pairs are outside of them.
    order = np.argsort(radius / away)
    for part in np.array_split(order, 200):
        towards = cKDTree(offset[part] / away[part, None])
        largest = 2 * np.sin(0.5 * np.arcsin((radius / away)[part].max()))
        pairs = towards.sparse_distance_matrix(tree, largest * 1.000001, output_type="ndarray")
        which = part[pairs["i"]]
        # Of unit vectors the distance is 2 sin(angle / 2).
        sine = pairs["v"] * np.sqrt(1 - 0.25 * pairs["v"] ** 2)
        x = np.minimum(away[which] * sine / radius[which], 1)
        found += np.bincount(
            pairs["j"], of_each[which] / radius[which] ** 2 * column(x), len(found)
        )
    # Pixels are means weighted with the solid angle.
    forward = np.subtract(camera.target, camera.position)
    solid = (sight @ (forward / np.linalg.norm(forward))) ** 3
    parts = (SHAPE[0], lines, SHAPE[1], lines)
    weighted = (found * solid).reshape(parts).sum(axis=(1, 3))
    return weighted / solid.reshape(parts).sum(axis=(1, 3))


def by_lines(rate: Any, case: Case, lines: int) -> Any:
    """An image by lines of sight, each in adaptive steps."""
    options = {"method": "los", "lines": lines, "tolerance": 1e-3, "max_evaluations": 10**9}
    return emitree.render(rate, case.camera, SHAPE, bounds=case.bounds, **options).image


def nanoseconds(case: Case) -> float:
    """The time of one point of the emission, of one thread."""
    low, high = -2.5, 2.5
    position = np.random.default_rng(SEED).uniform(low, high, (POINTS, 3))
    emission = case.emission
    if isinstance(emission, emitree.Grid):
        fields = emitree.Fields({"g": emission}, "g")
        fields.values(position[:10])
        evaluate = fields.values
    else:
        emission(position[:10])
        evaluate = emission
    if isinstance(emission, emitree.Particles):
        position = position[: POINTS // 20]
    times = []
    for _ in range(3):
        start = time.process_time()
        evaluate(position)
        times.append(time.process_time() - start)
    return 1e9 * min(times) / len(position)


def measure(case: Case) -> None:
    """Prints the row of a case."""
    options = {"bounds": case.bounds, "edges": case.edges, "tolerance": TOLERANCE, "threads": 1}
    found = emitree.render(case.emission, case.camera, SHAPE, **options)
    smooth = emitree.render(case.function, case.camera, SHAPE, **options)
    exact = by_lines(case.function, case, case.lines)
    half = by_lines(case.function, case, case.lines // 2)
    top = exact.max()

    def error(a: Any, b: Any) -> str:
        return f"{100 * abs(a - b).max() / top:.2f} %"

    row = [
        case.name,
        f"{found.evaluations:,}",
        f"{smooth.evaluations:,}",
        f"{100 * found.estimated_error:.2f} %",
        error(found.image, exact),
        error(half, exact),
    ]
    if case.image_of_data is not None:
        theirs, coarse = (case.image_of_data(n) for n in (case.lines, case.lines // 2))
    elif case.by_scipy is not None:
        theirs, coarse = (by_lines(case.by_scipy, case, n) for n in (case.lines, case.lines // 2))
    else:
        theirs = coarse = None
    if theirs is None:
        row += ["", "", ""]
    else:
        row += [error(found.image, theirs), error(theirs, coarse), error(theirs, exact)]
    row.append(f"{nanoseconds(case):.0f}")
    print("| " + " | ".join(row) + " |", flush=True)


def main() -> None:
    """Prints the table of the cases that are named, or of all."""
    cases = {
        "cube": cube,
        "corona": corona,
        "amr": amr,
        "tetrahedra": tetrahedra,
        "particles": particles,
    }
    names = sys.argv[1:] or list(cases)
    print(
        "| data | evaluations | of the function itself | estimated | against the function | its "
        "convergence | against scipy | its convergence | error of the data | ns a point |"
    )
    print("| --- |" + " --: |" * 9)
    for name in names:
        for case in cases[name]():
            measure(case)


if __name__ == "__main__":
    main()
