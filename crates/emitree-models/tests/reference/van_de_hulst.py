"""The coefficients A to D of van de Hulst 1950 in their published form, with 50 digits.

    python van_de_hulst.py > van_de_hulst.csv

Columns: r [R_sun] (as a double), A, B, C, D.
"""

from mpmath import asin, cos, log, mp, mpf, sin

mp.dps = 50

RADII = [1 + 1e-12, 1 + 1e-6, 1.0001, 1.01, 1.1, 1.3, 1.5, 2.0, 2.5, 3.0, 3.16, 3.17, 3.5, 4.0, 5.0,
         7.0, 10.0, 15.0, 21.5, 30.0, 50.0, 100.0, 215.0, 500.0, 1e3, 3e3, 1e4]


def coefficients(r):
    w = asin(1 / mpf(r))
    s, c = sin(w), cos(w)
    logarithm = log((1 + s) / c)
    return (
        c * s**2,
        -(1 - 3 * s**2 - c**2 / s * (1 + 3 * s**2) * logarithm) / 8,
        mpf(4) / 3 - c - c**3 / 3,
        (5 + s**2 - c**2 / s * (5 - s**2) * logarithm) / 8,
    )


def main():
    print("r,A,B,C,D")
    for r in RADII:
        print(",".join([repr(r)] + [mp.nstr(value, 20) for value in coefficients(r)]))


if __name__ == "__main__":
    main()
