"""The SMILE SXI image of `cmem` from view 1, in double precision with numpy.

Written from the published formulas, independently of the Rust code:

    python smile_view1.py           # writes smile_view1.csv beside this file, prints the statistics

View 1: n = 5 cm^-3, v = 400 km/s, B = (0, 0, 5) nT, no dipole tilt; observer at (10, -30, 0),
target (6, 0, 0), up +z, equirectangular, 16 degrees (50 columns) by 27 degrees (100 rows), depth 0
to 80 R_E. One line of sight through each pixel's centre. Row 0 is the lowest z, column 0 the
leftmost. Columns of the table: row, column, the converged line-of-sight integral, and the midpoint
rule with steps of 0.5 R_E, both in keV cm^-2 s^-1 sr^-1.
"""

import csv
from pathlib import Path

import numpy as np

A = [12.544, -0.194, 0.305, 0.0573, 2.178, 0.0571, -0.999, 16.473, 0.00152, 0.382, 0.0431,
     -0.00763, -0.210, 0.0405, -4.430, -0.636, -2.600, 0.832, -5.328, 1.103, -0.907, 1.450]
N, V, BZ, TILT = 5.0, 400.0, 5.0, 0.0
PD = 0.5 * 1.67e-27 * N * 1e6 * (V * 1e3) ** 2 * 1e9
PM = (BZ * 1e-9) ** 2 / (2 * 4e-7 * np.pi) * 1e9
SCALE = 6.371e8 / (4 * np.pi) / 1000  # eV cm^-3 s^-1 over R_E to keV cm^-2 s^-1 sr^-1
HEIGHT, WIDTH, FAR = 100, 50, 80.0


def magnetopause(theta, phi):
    r0 = A[0] * (PD + PM) ** A[1]
    r0 *= 1 + A[2] * (np.exp(A[3] * BZ) - 1) / (np.exp(A[4] * BZ) + 1)
    b0 = A[6] + A[7] * (np.exp(A[8] * BZ) - 1) / (np.exp(A[9] * BZ) + 1)
    b = b0 + A[10] * np.cos(phi) + (A[11] + A[12] * TILT) * np.sin(phi) + A[13] * np.sin(phi) ** 2
    f = (np.cos(theta / 2) + A[5] * np.sin(2 * theta) * (1 - np.exp(-theta))) ** b
    q = 0.0
    for sign in (1, -1):  # the north and the south cusp
        d = A[16] + sign * A[17] * TILT + A[18] * TILT**2
        t = A[19] + sign * A[20] * TILT
        cosine = np.cos(theta) * np.cos(t) + sign * np.sin(theta) * np.sin(t) * np.sin(phi)
        q = q + np.exp(4 * d * np.arccos(np.clip(cosine, -1, 1)) ** A[21])
    return (0.0022 * N + 0.7753) * r0 * f + 3 * A[14] * (PD + PM) ** A[15] * q


def bow_shock(theta):
    a = (0.58 - 0.010 * BZ) * (1 + 0.010 * PD) + 0.2
    return (13.24 - 0.12 * N) * (2 / (1 + np.cos(theta))) ** a


def spherical(p):
    r = np.sqrt((p**2).sum(-1))
    return r, np.arctan2(np.hypot(p[..., 1], p[..., 2]), p[..., 0]), np.arctan2(p[..., 2], p[..., 1])


def heights(p):
    """Distances above the magnetopause and above the bow shock [R_E]."""
    r, theta, phi = spherical(p)
    return r - magnetopause(theta, phi), r - bow_shock(theta)


def emission_rate(p):
    r, theta, phi = spherical(p)
    slope = (r / 10) ** -(2.5 - 1.6 * np.sin(theta) ** 2)
    sheath = (2.7e-6 * N - 6.3e-6) * np.exp(-2 * (theta / 2) ** 4) * slope
    wind = (9e-7 * N - 1e-6) * (r / 10) ** -3.0
    g = np.where(r < bow_shock(theta), sheath, wind)
    return SCALE * np.where(r < magnetopause(theta, phi), 0.0, g)


POSITION = np.array([10.0, -30.0, 0.0])


def sight(row, column):
    """Unit vector of the line of sight through the centre of a pixel."""
    forward = np.array([6.0, 0.0, 0.0]) - POSITION
    forward /= np.linalg.norm(forward)
    up = np.array([0.0, 0.0, 1.0])
    right = np.cross(forward, up)
    lon = np.radians(16.0) * ((column + 0.5) / WIDTH - 0.5)
    lat = np.radians(27.0) * ((row + 0.5) / HEIGHT - 0.5)
    return np.cos(lat) * np.sin(lon) * right + np.sin(lat) * up + np.cos(lat) * np.cos(lon) * forward


def points(direction, s):
    return POSITION + np.asarray(s)[..., None] * direction


NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)


def converged(direction):
    """The integral to rounding: Gauss panels of at most 1 R_E that end at the surfaces."""
    s = np.linspace(0, FAR, 8001)
    breaks = []
    for which in (0, 1):
        above = heights(points(direction, s))[which] >= 0
        for i in np.flatnonzero(above[1:] != above[:-1]):
            low, high = s[i], s[i + 1]
            for _ in range(60):
                middle = 0.5 * (low + high)
                if (heights(points(direction, middle))[which] >= 0) == above[i]:
                    low = middle
                else:
                    high = middle
            breaks.append(low)
    edges = np.unique(np.concatenate([np.arange(FAR + 1), breaks]))
    half, centre = 0.5 * np.diff(edges), 0.5 * (edges[1:] + edges[:-1])
    nodes = centre[:, None] + half[:, None] * NODES
    values = emission_rate(points(direction, nodes))
    return (values * WEIGHTS * half[:, None]).sum(), sorted(breaks)


def main():
    h = 0.5
    mid = (np.arange(int(FAR / h)) + 0.5) * h
    trap = np.arange(int(FAR / h) + 1) * h
    trap_weights = np.full(trap.shape, h)
    trap_weights[[0, -1]] *= 0.5
    exact, midpoint, trapezium = (np.zeros((HEIGHT, WIDTH)) for _ in range(3))
    crossings = np.zeros((HEIGHT, WIDTH), int)
    clearance = np.full((HEIGHT, WIDTH), np.inf)
    for row in range(HEIGHT):
        for column in range(WIDTH):
            d = sight(row, column)
            exact[row, column], breaks = converged(d)
            crossings[row, column] = len(breaks)
            p = points(d, mid)
            midpoint[row, column] = h * emission_rate(p).sum()
            clearance[row, column] = min(np.abs(above).min() for above in heights(p))
            trapezium[row, column] = (trap_weights * emission_rate(points(d, trap))).sum()

    top = exact.max()
    for name, image in (("converged", exact), ("midpoint 0.5", midpoint), ("trapezium 0.5", trapezium)):
        row, column = np.unravel_index(image.argmax(), image.shape)
        error = (image - exact) / top
        print(f"{name}: max {image.max():.9f} at row {row}, column {column}; min {image.min():.9f}; "
              f"mean {image.mean():.9f}; against converged: max {np.abs(error).max():.4%}, "
              f"rms {np.sqrt((error**2).mean()):.4%}")

    # Away from kinks: the same number of crossings five pixels around, and no midpoint node so
    # close to a surface that rounding could put it on the other side.
    rows, columns = [4, 17, 30, 42, 55, 68, 81, 94], [3, 12, 21, 33, 45]
    with (Path(__file__).parent / "smile_view1.csv").open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["row", "column", "converged", "midpoint_0.5"])
        for row in rows:
            for column in columns:
                around = crossings[max(row - 5, 0):row + 6, max(column - 5, 0):column + 6]
                if np.all(around == crossings[row, column]) and clearance[row, column] > 1e-6:
                    values = repr(float(exact[row, column])), repr(float(midpoint[row, column]))
                    table.writerow([row, column, *values])


if __name__ == "__main__":
    main()
