"""Constants of `src/elementary`, and reference values of its functions.

Written with mpmath. A polynomial interpolates its function at the nodes of Chebyshev on the range
that the reduction of the argument leaves, which is within a factor of about 2 of the smallest
possible error; its coefficients are rounded to doubles. Printed with it is its largest error
relative to the whole function, before it is evaluated in doubles.

    python elementary.py constants
    python elementary.py values > elementary.csv

Columns of the values: function; the bits of the argument, of the exponent of a power (else of 0), and
of the double nearest to the value; the distance of the value from that double in units of its last
place. Arguments are drawn with a fixed seed; each function has its hard places too.
"""

import random
import struct
import sys

from mpmath import (
    atan, atan2, cos, exp, factorial, frexp, ldexp, log, log10, lu_solve, matrix, mp, mpf, nint, pi,
    power, sin, sqrt, tan,
)

mp.dps = 60


def chebyshev_nodes(start, end, count):
    return [
        (start + end) / 2 + (end - start) / 2 * cos(pi * (2 * k + 1) / (2 * count))
        for k in range(count)
    ]


def interpolate(function, start, end, count):
    """The `count` coefficients, from the lowest, as doubles."""
    nodes = chebyshev_nodes(start, end, count)
    powers = matrix(count, count)
    for row, node in enumerate(nodes):
        for column in range(count):
            powers[row, column] = node**column
    values = matrix([function(node) for node in nodes])
    return [float(coefficient) for coefficient in lu_solve(powers, values)]


def largest_error(whole, approximation, start, end):
    """Relative, on 2001 points that do not meet 0."""
    points = [start + (end - start) * (k + mpf("0.37")) / 2002 for k in range(2001)]
    return max(abs(approximation(x) / whole(x) - 1) for x in points)


def polynomial(coefficients, x):
    return sum(mpf(coefficient) * x**k for k, coefficient in enumerate(coefficients))


def parts(value, bits):
    """A sum of doubles, all but the last with so many bits."""
    found = []
    for count in bits:
        mantissa, exponent = frexp(value)
        part = ldexp(nint(ldexp(mantissa, count)), exponent - count)
        found.append(float(part))
        value -= part
    return found


def show(name, numbers):
    print(name)
    for number in numbers:
        print(f"    {number!r}")


def constants():
    reach = log(2) / 2 * mpf("1.000001")
    # As a series: a node is at 0.
    tail = lambda r: sum(r**k / factorial(k + 2) for k in range(40))
    c = interpolate(tail, -reach, reach, 11)
    error = largest_error(exp, lambda r: 1 + r + r**2 * polynomial(c, r), -reach, reach)
    show(f"exp: (e^r - 1 - r)/r^2 in powers of r, error {float(error):.2g}", c)
    show("ln 2 in 42 bits and 53", parts(log(2), [42, 53]))
    show("1/ln 2", [float(1 / log(2))])

    reach = pi / 2 * mpf("1.000001")
    # The first coefficient is rounded before the others are found, which make up for it where it
    # matters, at large angles.
    first = float(mpf(-1) / 6)
    rest = lambda z: ((sin(sqrt(z)) / sqrt(z) - 1) / z - first) / z
    c = [first, *interpolate(rest, reach**2 / 4, reach**2, 7)]
    error = largest_error(sin, lambda r: r + r**3 * polynomial(c, r**2), -reach, reach)
    show(f"sin: (sin r - r)/r^3 in powers of r^2, error {float(error):.2g}", c)
    show("pi in 37 bits, 37 and 53", parts(pi, [37, 37, 53]))
    show("1/pi", [float(1 / pi)])

    reach = (sqrt(2) - 1) / (sqrt(2) + 1) * mpf("1.000001")
    logarithm = lambda s: log((1 + s) / (1 - s))
    c = interpolate(lambda z: (logarithm(sqrt(z)) / sqrt(z) - 2) / z, mpf(0), reach**2, 7)
    error = largest_error(logarithm, lambda s: 2 * s + s**3 * polynomial(c, s**2), -reach, reach)
    show(f"ln: (ln((1 + s)/(1 - s)) - 2s)/s^3 in powers of s^2, error {float(error):.2g}", c)
    # As a series: a node may be near 0.
    tail = lambda z: 3 * sum(z**k / (2 * k + 5) for k in range(60))
    c = interpolate(tail, mpf(0), reach**2, 8)
    whole = lambda s: s * 2 / 3 * (3 + s**2 + s**4 * polynomial(c, s**2))
    error = largest_error(logarithm, whole, -reach, reach)
    show(f"pow: (3/2s ln((1 + s)/(1 - s)) - 3 - s^2)/s^4 in s^2, error {float(error):.2g}", c)
    show("2/3 in 21 bits and 53", parts(mpf(2) / 3, [21, 53]))
    show("1/ln 10 in 32 bits and 53", parts(1 / log(10), [32, 53]))
    show("log10 2 in 42 bits and 53", parts(log10(2), [42, 53]))

    reach = tan(pi / 8) * mpf("1.000001")
    # As a series: a node may be near 0.
    tail = lambda z: sum((-1) ** (k + 1) * z**k / (2 * k + 3) for k in range(90))
    c = interpolate(tail, mpf(0), reach**2, 11)
    error = largest_error(atan, lambda t: t + t**3 * polynomial(c, t**2), -reach, reach)
    show(f"atan: (atan t - t)/t^3 in powers of t^2, error {float(error):.2g}", c)
    show("pi/4 in 51 bits and 53", parts(pi / 4, [51, 53]))


def bits(x):
    return struct.unpack("<Q", struct.pack("<d", x))[0]


def double(pattern):
    return struct.unpack("<d", struct.pack("<Q", pattern))[0]


def row(name, function, x, *, second=None):
    arguments = [x] if second is None else [x, second]
    value = function(*map(mpf, arguments))
    nearest = float(value)
    if nearest in (0.0, float("inf")):
        return
    _, exponent = frexp(value)
    last_place = ldexp(mpf(1), max(int(exponent) - 53, -1074))
    offset = float((value - mpf(nearest)) / last_place)
    patterns = ",".join(f"{bits(argument):016x}" for argument in [x, second or 0.0])
    print(f"{name},{patterns},{bits(nearest):016x},{offset:.4f}")


def values():
    draw = random.Random(20)
    print("function,argument,second,nearest,offset")

    exponents = [draw.uniform(-745, 709.7) for _ in range(150)]
    exponents += [draw.uniform(-1, 1) for _ in range(100)]
    exponents += [draw.choice([-1, 1]) * 2 ** draw.uniform(-60, 0) for _ in range(50)]
    exponents += [float(log(2) * (k + mpf("0.5"))) for k in range(-1000, 1000, 40)]
    exponents += [709.782712893384, -708.3964185322641, -745.1332191019411, -740.5]
    for x in exponents:
        row("exp", exp, x)

    angles = [draw.uniform(-10, 10) for _ in range(150)]
    angles += [draw.uniform(-1e5, 1e5) for _ in range(100)]
    angles += [draw.choice([-1, 1]) * 2 ** draw.uniform(-60, 0) for _ in range(50)]
    # As near to their zeros as doubles come, and at the borders of the reduced range.
    multiples = [1, 2, 3, 4, 5, 6, 7, 8, 11, 100, 355, 1001, 20001, 50000, 63661]
    angles += [float(pi * k / 2) for k in multiples]
    angles += [double(bits(float(pi * k / 2)) + 1) for k in multiples]
    angles += [1e5, 99999.99999999999, 1e6, 3e15, 1.7e308]
    for x in angles:
        row("sin", sin, x)
        row("cos", cos, x)

    arguments = [double(draw.randrange(1 << 52, 0x7FF0 << 48)) for _ in range(150)]
    arguments += [draw.uniform(0.5, 2) for _ in range(150)]
    arguments += [1 + draw.choice([-1, 1]) * 2 ** draw.uniform(-52, -2) for _ in range(80)]
    arguments += [double(draw.randrange(1, 1 << 52)) for _ in range(20)]
    arguments += [5e-324, double((1 << 52) - 1), double(1 << 52), double((0x7FF0 << 48) - 1)]
    arguments += [double(bits(1.0) - 1), double(bits(1.0) + 1)]
    half = bits(float(sqrt(mpf(1) / 2)))
    arguments += [double(half + offset) for offset in range(-3, 4)]
    arguments += [2 * double(half + offset) for offset in range(-3, 4)]
    for x in arguments:
        row("ln", log, x)
        row("log10", log10, x)

    for x in arguments:
        # Values of all sizes, subnormal ones too.
        limits = [-743, 709] if x >= 1 else [-709, 743]
        second = float(draw.uniform(*limits) / log(x)) if abs(x - 1) > 1e-12 else 1e9
        row("pow", power, x, second=second)
        row("pow", power, x, second=draw.choice([-2.5, -1.5, 0.5, 1 / 3, -0.05, 1.0, 2.0, -3.0]))

    # Points in all directions, near the axes and the diagonals too.
    sides = [-1.0, 1.0]
    for _ in range(200):
        row("atan2", atan2, draw.uniform(-1, 1), second=draw.uniform(-1, 1))
    for _ in range(100):
        near, other = draw.choice(sides) * 2 ** draw.uniform(-60, 0), draw.choice(sides)
        row("atan2", atan2, near, second=other)
        row("atan2", atan2, other, second=near)
    for _ in range(100):
        first = draw.choice(sides) * draw.uniform(0.5, 1)
        second = draw.choice(sides) * abs(first) * (1 + draw.uniform(-1, 1) * 2 ** draw.uniform(-52, -2))
        row("atan2", atan2, first, second=second)
        # The border of the reduced range.
        edge = draw.choice(sides) * abs(first) * float(tan(pi / 8)) * (1 + draw.uniform(-4e-16, 4e-16))
        row("atan2", atan2, edge, second=first)


if __name__ == "__main__":
    {"constants": constants, "values": values}[sys.argv[1]]()
