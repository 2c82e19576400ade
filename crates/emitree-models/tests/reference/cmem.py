"""Reference emissivities of the magnetosheath models `cmem` and `jorgensen`, in 50 digits.

Written from the published formulas with mpmath, independently of the Rust code:

    python cmem.py > emissivity.csv

Columns: model, solar wind (see WINDS), place, x, y, z [R_E], emissivity [eV cm^-3 s^-1].
"""

from mpmath import acos, atan2, cos, e, exp, mp, mpf, pi, sin, sqrt

mp.dps = 50

# Lin et al. 2010, doi:10.1029/2009JA014235: a0 to a21.
A = [mpf(a) for a in """12.544 -0.194 0.305 0.0573 2.178 0.0571 -0.999 16.473 0.00152 0.382 0.0431
-0.00763 -0.210 0.0405 -4.430 -0.636 -2.600 0.832 -5.328 1.103 -0.907 1.450""".split()]

PROTON_MASS_KG = mpf("1.67e-27")  # as in the model
MU0 = 4 * pi * mpf("1e-7")

# name: density [cm^-3], velocity [km/s], bx, by, bz [nT], dipole tilt [rad]
WINDS = {
    "view1": "5 400 0 0 5 0",
    "southward": "12 550 2 -3 -6.5 0.3",
    "northward": "3.5 320 -1 4 9 -0.25",
}


def wind(name):
    n, v, bx, by, bz, tilt = (mpf(w) for w in WINDS[name].split())
    pd = PROTON_MASS_KG * n * mpf("1e6") * (v * 1000) ** 2 / 2 * mpf("1e9")  # nPa
    pm = (bx**2 + by**2 + bz**2) * mpf("1e-18") / (2 * MU0) * mpf("1e9")  # nPa
    return n, pd, pm, bz, tilt


def angles(x, y, z):
    return sqrt(x**2 + y**2 + z**2), atan2(sqrt(y**2 + z**2), x), atan2(z, y)


def shue(r0, ay, az, theta, phi):
    """Radius of the surface s(r0, ay, az) [R_E]."""
    ry = r0 * (2 / (1 + cos(theta))) ** ay
    rz = r0 * (2 / (1 + cos(theta))) ** az
    return ry * rz / sqrt((rz * cos(phi)) ** 2 + (ry * sin(phi)) ** 2)


def lin(name, theta, phi):
    """Radius of the magnetopause of Lin et al. as CMEM scales it [R_E]."""
    n, pd, pm, bz, tilt = wind(name)
    p0, p1, p2, p3 = mpf("0.0022") * n + mpf("0.7753"), 1, 3, 4
    a = A
    r0 = a[0] * (pd + pm) ** a[1] * (1 + a[2] * (exp(a[3] * bz) - 1) / (exp(a[4] * bz) + 1))
    b0 = a[6] + a[7] * (exp(a[8] * bz) - 1) / (exp(a[9] * bz) + 1)
    b1, b2, b3 = a[10], a[11] + a[12] * tilt, a[13]
    c = a[14] * (pd + pm) ** a[15]
    dn = a[16] + a[17] * tilt + a[18] * tilt**2
    ds = a[16] - a[17] * tilt + a[18] * tilt**2
    tn, ts = a[19] + a[20] * tilt, a[19] - a[20] * tilt
    psin = acos(cos(theta) * cos(tn) + sin(theta) * sin(tn) * cos(phi - pi / 2))
    psis = acos(cos(theta) * cos(ts) + sin(theta) * sin(ts) * cos(phi - 3 * pi / 2))
    power = p1 * (b0 + b1 * cos(phi) + b2 * sin(phi) + b3 * sin(phi) ** 2)
    f = (cos(theta / 2) + a[5] * sin(2 * theta) * (1 - e ** (-theta))) ** power
    q = p2 * c * (exp(p3 * dn * psin ** a[21]) + exp(p3 * ds * psis ** a[21]))
    return p0 * r0 * f + q


def cmem_surfaces(name, theta, phi):
    n, pd, pm, bz, tilt = wind(name)
    a = (mpf("0.58") - mpf("0.010") * bz) * (1 + mpf("0.010") * pd) + mpf("0.2")
    return lin(name, theta, phi), shue(mpf("13.24") - mpf("0.12") * n, a, a, theta, phi)


def jorgensen_surfaces(name, theta, phi):
    n, pd, pm, bz, tilt = wind(name)
    r0 = (mpf("11.4") + (mpf("0.013") if bz >= 0 else mpf("0.14")) * bz) * pd ** (-1 / mpf("6.6"))
    a = (mpf("0.58") - mpf("0.010") * bz) * (1 + mpf("0.010") * pd)
    return shue(r0, a, a, theta, phi), shue(r0 + 3, a + mpf("0.2"), a + mpf("0.2"), theta, phi)


def emissivity(model, name, x, y, z):
    r, theta, phi = angles(mpf(x), mpf(y), mpf(z))
    n = wind(name)[0]
    magnetopause, bow_shock = SURFACES[model](name, theta, phi)
    if r < magnetopause:
        return mpf(0)
    if r >= bow_shock:
        a2 = mpf("9e-7") * n - mpf("1e-6") if model == "cmem" else mpf("1.3e-5")
        return a2 * (r / 10) ** -3
    slope = (r / 10) ** -(mpf("2.5") + mpf("-1.6") * sin(theta) ** 2)
    if model == "cmem":
        return (mpf("2.7e-6") * n - mpf("6.3e-6")) * exp(-2 * (theta / 2) ** 4) * slope
    return (mpf("3.2e-5") + mpf("-1.8e-5") * sin(theta) ** 8) * slope


SURFACES = {"cmem": cmem_surfaces, "jorgensen": jorgensen_surfaces}

# Directions as degrees from +x and about it; the last number goes from one surface to the other:
# 0 at the magnetopause, 1 at the bow shock.
PLACES = [
    ("subsolar sheath", 2, 10, "0.5"),
    ("dayside sheath", 35, -70, "0.3"),
    ("flank sheath", 88, 0, "0.6"),
    ("tail sheath", 125, 190, "0.8"),
    ("north cusp", 58, 90, "0.1"),
    ("south cusp", 66, -86, "0.2"),
    ("beyond the nose", 10, 45, "1.4"),
    ("beyond the flank", 95, 135, "1.7"),
    ("inside", 40, 20, "-0.5"),
    ("inside of the magnetopause", 50, 60, "-1e-7"),
    ("outside of the magnetopause", 50, 60, "1e-7"),
    ("inside of the bow shock", 70, -30, "0.9999999"),
    ("outside of the bow shock", 70, -30, "1.0000001"),
]


def main():
    print("model,wind,place,x,y,z,emissivity")
    for model in SURFACES:
        for name in WINDS:
            for place, polar, azimuth, share in PLACES:
                theta, phi = polar * pi / 180, azimuth * pi / 180
                near, far = SURFACES[model](name, theta, phi)
                r = near + mpf(share) * (far - near)
                # Rounded to doubles, so that both programs see the same point.
                x = float(r * cos(theta))
                y = float(r * sin(theta) * cos(phi))
                z = float(r * sin(theta) * sin(phi))
                value = mp.nstr(emissivity(model, name, x, y, z), 20)
                print(f"{model},{name},{place},{x!r},{y!r},{z!r},{value}")


if __name__ == "__main__":
    main()
