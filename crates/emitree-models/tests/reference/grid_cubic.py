"""Monotone cubic interpolation on a rectilinear grid, in 50 digits with mpmath.

Written from M. Steffen, Astronomy and Astrophysics 239, 443 (1990), with slopes in units of y/x at
every node of a row and the cubic in powers of x - x_i, independently of the Rust code:

    python grid_cubic.py            # writes grid_cubic.csv beside this file

Rows of the table: `x`, `y`, `z` and the nodes of that axis; `v` and the values, x varying fastest;
`p` and a position with the interpolant there, along x, then y, then z.
"""

import csv
import random
from pathlib import Path

from mpmath import mp, mpf

mp.dps = 50


def sign(value):
    return (value > 0) - (value < 0)


def slopes(x, y):
    """y' at every node."""
    n = len(x)
    h = [x[i + 1] - x[i] for i in range(n - 1)]
    s = [(y[i + 1] - y[i]) / h[i] for i in range(n - 1)]
    if n == 2:
        return [s[0], s[0]]

    def at_the_end(s1, s2, h1, h2):
        p = s1 * (1 + h1 / (h1 + h2)) - s2 * h1 / (h1 + h2)
        if p * s1 <= 0:
            return mpf(0)
        return 2 * s1 if abs(p) > 2 * abs(s1) else p

    inner = []
    for i in range(1, n - 1):
        p = (s[i - 1] * h[i] + s[i] * h[i - 1]) / (h[i - 1] + h[i])
        inner.append((sign(s[i - 1]) + sign(s[i])) * min(abs(s[i - 1]), abs(s[i]), abs(p) / 2))
    return [at_the_end(s[0], s[1], h[0], h[1]), *inner, at_the_end(s[-1], s[-2], h[-1], h[-2])]


def interpolate(x, y, at):
    i = max(i for i in range(len(x) - 1) if x[i] <= at)
    d = slopes(x, y)
    h = x[i + 1] - x[i]
    s = (y[i + 1] - y[i]) / h
    a = (d[i] + d[i + 1] - 2 * s) / h**2
    b = (3 * s - 2 * d[i] - d[i + 1]) / h
    t = at - x[i]
    return a * t**3 + b * t**2 + d[i] * t + y[i]


def interpolate_3d(axes, values, at):
    x, y, z = axes
    planes = []
    for plane in values:
        planes.append(interpolate(y, [interpolate(x, row, at[0]) for row in plane], at[1]))
    return interpolate(z, planes, at[2])


def main():
    rng = random.Random(1990)
    axes = []
    for count in (6, 3, 5):
        nodes = [rng.uniform(-3, 0)]
        while len(nodes) < count:
            nodes.append(nodes[-1] + rng.uniform(0.2, 2))
        axes.append(nodes)
    nx, ny, nz = map(len, axes)
    # A third of zeros: plateaus, and extrema beside them.
    value = lambda: max(0.0, rng.uniform(-1, 2))
    values = [[[value() for _ in range(nx)] for _ in range(ny)] for _ in range(nz)]

    exact = lambda numbers: [mpf(number) for number in numbers]
    exact_values = [[exact(row) for row in plane] for plane in values]
    exact_axes = [exact(axis) for axis in axes]
    with open(Path(__file__).with_suffix(".csv"), "w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        for name, axis in zip("xyz", axes):
            table.writerow([name, *map(repr, axis)])
        table.writerow(["v", *(repr(v) for plane in values for row in plane for v in row)])
        for _ in range(60):
            at = [rng.uniform(axis[0], axis[-1]) for axis in axes]
            answer = interpolate_3d(exact_axes, exact_values, exact(at))
            table.writerow(["p", *map(repr, at), repr(float(answer))])


main()
