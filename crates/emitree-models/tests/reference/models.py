"""Reference rates of the models other than the magnetosheath's, with 30 digits and more.

Written with mpmath, independently of the Rust code, and from another end where there is one:

* `chamberlain`: integrals over the velocities of the particles that come from the exobase;
* `k_corona`: an integral over the Sun's disk of Thomson scattering, with re = alpha^2 a0;
* `k_corona_polarised`: the same integral of the tangential minus the radial polarisation;
* `ena`: the integral over speed itself.

    python models.py > models.csv

Columns: model, parameters (name=value, separated by spaces; all others have their defaults), x, y,
z, direction x, y, z, rate in the unit of an image of the model per length unit.
"""

from mpmath import cos, e, erf, exp, log, mp, mpf, pi, quad, sin, sqrt

mp.dps = 40

BOLTZMANN = mpf("1.380649e-23")
CHARGE = mpf("1.602176634e-19")
PROTON_MASS = mpf("1.67262192595e-27")
EARTH_RADIUS_CM = mpf("6.371e8")
ANY = (0.0, 0.0, 1.0)


def norm(vector):
    return sqrt(sum(mpf(component) ** 2 for component in vector))


def dot(a, b):
    return sum(mpf(p) * mpf(q) for p, q in zip(a, b))


def power_exosphere(r, coefficient, offset, exponent, exobase):
    return mpf(0) if r < exobase else coefficient * (r - offset) ** -exponent


def mars_hydrogen(position, direction, coefficient="4e27", offset="2.7e6", exponent="2.7",
                  exobase_radius="3.595e6"):
    law = (mpf(p) for p in (coefficient, offset, exponent, exobase_radius))
    return power_exosphere(norm(position), *law)


def mars_oxygen(position, direction):
    return mars_hydrogen(position, direction, "5e22", "2.4e6", "2.1")


def chamberlain(position, direction, exobase_density="1e11", exobase_radius="6.871e6",
                temperature="1000", planet_mass="5.9722e24", particle_mass="1.67353e-27"):
    """Speeds in units of sqrt(2 k T/m), so that the energy is v^2 - lambda; by Liouville's theorem
    the phase space density is that of the exobase wherever a trajectory has come from there."""
    r, exobase = norm(position), mpf(exobase_radius)
    if r < exobase:
        return mpf(0)
    escape = (mpf("6.67430e-11") * mpf(planet_mass) * mpf(particle_mass)
              / (BOLTZMANN * mpf(temperature)))
    lam, lam_exobase = escape / r, escape / exobase

    def solid_angle(v):
        """Of one hemisphere, where the angular momentum lets the particle come from the exobase."""
        sin2 = (exobase / r) ** 2 * (v * v - lam + lam_exobase) / (v * v)
        return 2 * pi * (1 - sqrt(1 - sin2)) if sin2 < 1 else 2 * pi

    def part(v):
        return v * v * exp(-v * v) * solid_angle(v)

    # Where all of the sky is open: v^2 (1 - y^2) <= y^2 (lam_exobase - lam).
    y2 = (exobase / r) ** 2
    kink = sqrt(y2 * (lam_exobase - lam) / (1 - y2)) if y2 < 1 else mpf(0)
    stops = sorted({mpf(0), min(kink, sqrt(lam)), sqrt(lam)})
    bound = quad(part, stops)
    free_stops = sorted({sqrt(lam), max(kink, sqrt(lam)), sqrt(lam) + 1, sqrt(lam) + 3})
    free = quad(part, free_stops + [sqrt(lam) + 12])
    everywhere = pi ** mpf("-1.5") * (2 * bound + free)

    # At the exobase itself: all directions of bound particles, half of the others.
    root = sqrt(lam_exobase)
    below = erf(root) - 2 / sqrt(pi) * root * exp(-lam_exobase)
    at_exobase = (1 + below) / 2
    return mpf(exobase_density) * exp(lam - lam_exobase) * everywhere / at_exobase


def geocorona(position, direction, g_factor="2.09e-3", outer_radius="12"):
    r = norm(position)
    if not mpf("1.08") < r < mpf(outer_radius):
        return mpf(0)
    density = exp(mpf("10.692") - mpf("4.4431") * log(r / mpf("1.08")) ** mpf("0.715831"))
    return density * mpf(g_factor) * EARTH_RADIUS_CM / 10**6


def airglow(position, direction, planet_radius="6371", peak_altitude="97", scale_height="7",
            peak_rate="200"):
    altitude = norm(position) - mpf(planet_radius)
    if altitude < 0:
        return mpf(0)
    z = (altitude - mpf(peak_altitude)) / mpf(scale_height)
    return mpf(peak_rate) * e ** (1 - z - e ** (-z)) * 10**5 / mpf(10) ** 6


def cross_section(speed):
    energy = PROTON_MASS * speed**2 / 2 / CHARGE / 1000  # keV
    return ((mpf("4.15") - mpf("0.531") * log(energy)) ** 2
            * (1 - exp(mpf("-67.3") / energy)) ** mpf("4.5") / mpf(10) ** 20)


def ena(position, direction, ion_density="2.5e6", ion_temperature="1.2e5", velocity_x="-4e5",
        velocity_y="0", velocity_z="0", neutral_coefficient="4e27", neutral_offset="2.7e6",
        neutral_exponent="2.7"):
    drift = [mpf(v) for v in (velocity_x, velocity_y, velocity_z)]
    thermal2 = 2 * BOLTZMANN * mpf(ion_temperature) / PROTON_MASS
    d = [mpf(component) for component in direction]

    def distance2(v):
        return sum((v * p - q) ** 2 for p, q in zip(d, drift)) / thermal2

    # Of order 1 and in units of w, for mpmath stops at an absolute error.
    peak, w = max(dot(d, drift), mpf(0)), sqrt(thermal2)
    nearest = distance2(peak)

    def integrand(x):
        if x == 0:
            return mpf(0)
        return cross_section(x * w) * 10**20 * x**3 * exp(nearest - distance2(x * w))

    stops = {mpf(0), mpf(1) / 8, mpf(1) / 2}
    stops |= {max(peak / w + step, mpf(0)) for step in range(-12, 13)}
    flux = quad(integrand, sorted(stops)) * exp(-nearest) * w**4 / 10**20
    neutrals = power_exosphere(norm(position), mpf(neutral_coefficient), mpf(neutral_offset),
                               mpf(neutral_exponent), mpf("3.595e6"))
    return neutrals * mpf(ion_density) * (pi * thermal2) ** mpf("-1.5") * flux


def k_corona(position, direction, limb_darkening="0.58"):
    """Each electron scatters (1 + cos^2 of the angle of scattering) re^2/2."""
    cos2_chi = (dot(position, direction) / norm(position)) ** 2

    def scattered(sine, cosine2):
        return 1 + cosine2 * cos2_chi + sine**2 / 2 * (1 - cos2_chi)

    return corona_of(position, limb_darkening, scattered)


def k_corona_polarised(position, direction, limb_darkening="0.58"):
    """Of light along n' an electron scatters re^2/2 (1 - (n' e)^2) with the polarisation e; tangential is
    perpendicular to the radius and the line of sight, radial in their plane."""
    sin2_chi = 1 - (dot(position, direction) / norm(position)) ** 2

    def scattered(sine, cosine2):
        # Averages of (n' e)^2 about the radius.
        along_tangent = sine**2 / 2
        in_plane = cosine2 * sin2_chi + sine**2 / 2 * (1 - sin2_chi)
        return in_plane - along_tangent

    return corona_of(position, limb_darkening, scattered)


def corona_of(position, limb_darkening, scattered):
    r, u = norm(position), mpf(limb_darkening)
    if r < 1:
        return mpf(0)
    s = abs(mpf(position[2])) / r
    density = (mpf("3.09e8") * r**-16 * (1 - s / 2) + mpf("1.58e8") * r**-6 * (1 - mpf("0.95") * s)
               + mpf("0.0251e8") * r ** mpf("-2.5") * (1 - sqrt(s)))
    alpha, bohr_cm = mpf("7.2973525643e-3"), mpf("5.29177210544e-9")
    radius2 = (alpha**2 * bohr_cm) ** 2

    def ring(psi):
        """Light from the part of the disk where the surface is tilted by psi, averaged about the
        radius, per psi: sin(angle) r = sin(psi)."""
        sine = sin(psi) / r
        cosine2 = 1 - sine**2
        intensity = (1 - u + u * cos(psi)) / (1 - u / 3)
        return 2 * pi * intensity * scattered(sine, cosine2) * sine * cos(psi) / r / sqrt(cosine2)

    brightness = radius2 / 2 * quad(ring, [0, pi / 8, pi / 4, 3 * pi / 8, pi / 2])
    return density * brightness * mpf("6.957e10")


def from_centre(position, x, y, z):
    return norm([mpf(p) - mpf(q) for p, q in zip(position, (x, y, z))])


def beta_model(position, direction, amplitude="1", core_radius="1", beta="", centre_x="0",
               centre_y="0", centre_z="0"):
    b = mpf(beta) if beta else mpf(2) / 3
    r = from_centre(position, centre_x, centre_y, centre_z)
    return mpf(amplitude) * (1 + (r / mpf(core_radius)) ** 2) ** (-3 * b)


def shell_nebula(position, direction, amplitude="1", inner_radius="0.8", outer_radius="1",
                 centre_x="0", centre_y="0", centre_z="0"):
    r = from_centre(position, centre_x, centre_y, centre_z)
    return mpf(amplitude) if mpf(inner_radius) < r < mpf(outer_radius) else mpf(0)


def power_law(position, direction, amplitude="1", exponent="2", inner_radius="1", centre_x="0",
              centre_y="0", centre_z="0"):
    r = from_centre(position, centre_x, centre_y, centre_z)
    return mpf(amplitude) * r ** -mpf(exponent) if r >= mpf(inner_radius) else mpf(0)


def uniform(position, direction, amplitude="1"):
    return mpf(amplitude)


def halo(position, profile, power, local_density, local_radius, scale_radius, outer_radius,
         core_radius, centre):
    """The density to a power, times the centimetres of a kpc of 648000/pi AU."""
    r, scale = from_centre(position, *centre), mpf(scale_radius)
    if r > mpf(outer_radius):
        return mpf(0)
    softened = sqrt(r**2 + mpf(core_radius) ** 2)
    density = (mpf(local_density) * profile(softened / scale)
               / profile(mpf(local_radius) / scale))
    return density**power * 1000 * 648000 / pi * mpf("14959787070000")


def halo_of(name, power, profile, default_scale):
    def model(position, direction, local_density="0.3", local_radius="8.33",
              scale_radius=default_scale, alpha="0.17", outer_radius="250", core_radius="0",
              centre_x="0", centre_y="0", centre_z="0"):
        return halo(position, lambda x: profile(x, mpf(alpha)), power, local_density,
                    local_radius, scale_radius, outer_radius, core_radius,
                    (centre_x, centre_y, centre_z))
    model.__name__ = name
    return model


PROFILES = [
    ("nfw", lambda x, alpha: 1 / (x * (1 + x) ** 2), "24.42"),
    ("einasto", lambda x, alpha: exp(-2 / alpha * (x**alpha - 1)), "28.44"),
    ("burkert", lambda x, alpha: 1 / ((1 + x) * (1 + x**2)), "12.67"),
]
HALOS = [halo_of(name + ending, power, profile, scale)
         for name, profile, scale in PROFILES for ending, power in [("", 2), ("_decay", 1)]]


def unit(vector):
    length = norm(vector)
    return tuple(float(component / length) for component in vector)


def cases():
    for position in [(3.7e6, 0.0, 0.0), (-2e6, 3e6, 1e6), (1e7, -4e7, 2e6), (0.0, 3.4e6, 0.0)]:
        yield mars_hydrogen, "", position, ANY
        yield mars_oxygen, "", position, ANY
    yield mars_hydrogen, "coefficient=2e15 offset=0 exponent=1.5", (0.0, 3e6, -2.5e6), ANY

    heavy = "temperature=270 exobase_radius=3.595e6 planet_mass=6.4171e23 particle_mass=2.657e-26"
    warm = "temperature=9000 exobase_density=3e8"
    for scale in [1.00001, 1.01, 1.3, 2.0, 5.0, 40.0, 1e3, 1e5]:
        r = 6.871e6 * scale
        yield chamberlain, "", (r * 0.6, 0.0, -r * 0.8), ANY
        yield chamberlain, warm, (r * 0.6, -r * 0.8, 0.0), ANY
        yield chamberlain, heavy, (3.595e6 * scale, 0.0, 0.0), ANY
    yield chamberlain, "", (0.0, 0.0, 6.8e6), ANY

    for r in [1.0800001, 1.1, 1.5, 3.0, 8.0, 11.9, 12.1, 1.0]:
        yield geocorona, "", (0.36 * r, -0.48 * r, 0.8 * r), ANY
    yield geocorona, "g_factor=1.5e-3 outer_radius=20", (0.0, 15.0, 0.0), ANY

    for altitude in [-10.0, 40.0, 80.0, 90.0, 97.0, 110.0, 150.0, 400.0]:
        yield airglow, "", (0.0, 6371.0 + altitude, 0.0), ANY
    yield airglow, "planet_radius=3389.5 peak_altitude=120 scale_height=12 peak_rate=1000", (
        3500.0, 300.0, -100.0), ANY

    place = (-3e6, 2e6, 3e6)
    sheath = "ion_density=1e7 ion_temperature=1e6 velocity_x=-1.5e5 velocity_y=8e4 velocity_z=-3e4"
    ring = "ion_density=1e6 ion_temperature=2.5e8 velocity_x=0 velocity_y=3e5"
    hottest = "ion_temperature=1e9 velocity_x=-3e6 velocity_y=3e6 velocity_z=3e6"
    cold = "ion_temperature=1e3 velocity_x=-1e6"
    directions = [(-1, 0, 0), (-20, 1, 2), (-3, 2, 1), (1, 5, 1), (0, 0, 1), (1, 0, 0), (4, -3, 1)]
    for parameters in ["", sheath, ring, hottest]:
        for direction in directions:
            yield ena, parameters, place, unit(direction)
    yield ena, cold, place, (-1.0, 0.0, 0.0)
    yield ena, cold, place, unit((-300, 1, 2))
    yield ena, "velocity_x=0", place, unit((1, 2, 3))
    yield ena, "neutral_coefficient=1e27 neutral_exponent=2.5 neutral_offset=1e6", place, unit(
        (-4, 1, 0))
    yield ena, "", (3.5e6, 0.0, 0.0), (-1.0, 0.0, 0.0)

    for r in [1.0000001, 1.001, 1.1, 1.7, 3.0, 3.3, 10.0, 60.0, 215.0, 1e4]:
        for latitude, direction in [(0.0, (-1, 2, 0.5)), (0.7, (0, 0, 1)), (-1.3, (1, 1, -3))]:
            position = (r * float(cos(latitude)) * 0.6, r * float(cos(latitude)) * 0.8,
                        r * float(sin(latitude)))
            yield k_corona, "", position, unit(direction)
            yield k_corona_polarised, "", position, unit(direction)
    # Along the radius nothing is polarised.
    for corona, direction in [(k_corona, (3, -2, 0.4)), (k_corona_polarised, (3, 2, 0.4))]:
        yield corona, "limb_darkening=0", (1.5, -1.0, 0.2), unit(direction)
        yield corona, "limb_darkening=1", (1.5, -1.0, 0.2), unit((2, 3, 0))
        yield corona, "", (0.5, 0.5, 0.5), ANY

    cluster = "amplitude=3 core_radius=0.4 beta=0.8 centre_x=1 centre_y=-2 centre_z=0.5"
    shell = "amplitude=3 inner_radius=2 outer_radius=2.5 centre_x=1 centre_y=-2 centre_z=0.5"
    wind = "amplitude=3 exponent=2.5 inner_radius=0.3 centre_x=1 centre_y=-2 centre_z=0.5"
    for position in [(0.0, 0.0, 0.0), (0.5, -0.5, 0.55), (1.25, -2.0, 0.5), (30.0, 40.0, -9.0)]:
        for model, parameters in [(beta_model, cluster), (shell_nebula, shell), (power_law, wind)]:
            yield model, "", position, ANY
            yield model, parameters, position, ANY
        yield uniform, "amplitude=0.125", position, ANY

    far = "centre_x=1 centre_y=-2 centre_z=0.5 outer_radius=8.5 core_radius=0.03"
    here = "local_density=0.39 local_radius=8.5 scale_radius=20"
    for model in HALOS:
        for position in [(1e-6, 0.0, 0.0), (1.25, -2.0, 0.5), (3.0, 4.0, -3.0), (200.0, 9.0, 200.0)]:
            yield model, "", position, ANY
            yield model, f"{here} {far}", position, ANY
        if model.__name__.startswith("einasto"):
            yield model, "alpha=0.3", (0.0, 0.0, 2.0), ANY


def main():
    print("model,parameters,x,y,z,dx,dy,dz,rate")
    for model, parameters, position, direction in cases():
        given = dict(parameter.split("=") for parameter in parameters.split())
        rate = mp.nstr(model(position, direction, **given), 20)
        numbers = ",".join(repr(float(number)) for number in (*position, *direction))
        print(f"{model.__name__},{parameters},{numbers},{rate}")


if __name__ == "__main__":
    main()
