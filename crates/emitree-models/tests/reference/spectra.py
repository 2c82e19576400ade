"""Reference rates of the models with spectra, with 20 digits and more.

Written with mpmath, independently of the Rust code, and from another end:

* `bremsstrahlung`: the power per frequency in erg and Hz, counted in photons between two energies
  that are close together;
* `ena_ring`: protons by their velocity in m/s, in a distribution whose constant is an integral, and
  the flux through an area between two energies.

    python spectra.py > spectra.csv

Columns: model, parameters (name=value, separated by spaces; all others have their defaults), x, y,
z, energy in keV, rate in the unit of an image of the model per length unit.
"""

from mpmath import asin, exp, inf, log, mp, mpf, pi, quad, sqrt

mp.dps = 40

BOLTZMANN = mpf("1.380649e-23")
KEV = mpf("1.602176634e-16")
PLANCK = mpf("6.62607015e-34")
PROTON_MASS = mpf("1.67262192595e-27")
EARTH_RADIUS_CM = mpf("6.371e8")
KPC_CM = 1000 * 648000 / pi * mpf("14959787070000")


def norm(vector):
    return sqrt(sum(mpf(component) ** 2 for component in vector))


def per_kev(rate_between, energy):
    """The rate per keV at an energy, from that between two energies: by Richardson's rule on the
    exact integral, so narrow that the rest is below 30 digits."""
    width = mpf(energy) / 10**4
    wide, narrow = (rate_between(energy - w / 2, energy + w / 2) / w for w in (width, width / 2))
    narrower = rate_between(energy - width / 8, energy + width / 8) / (width / 4)
    first, second = (4 * narrow - wide) / 3, (4 * narrower - narrow) / 3
    return (16 * second - first) / 15


def bremsstrahlung(position, energy, density="0.01", core_radius="100", beta="", temperature="6",
                   core_fraction="0.45", cooling_radius="45", cooling_exponent="1.9",
                   decline_radius="600", decline_exponent="0.9", ion_charge="1.14",
                   gaunt_factor="1.2", centre_x="0", centre_y="0", centre_z="0"):
    centre = (centre_x, centre_y, centre_z)
    r = norm([mpf(p) - mpf(q) for p, q in zip(position, centre)])
    b = mpf(beta) if beta else mpf(2) / 3
    electrons = mpf(density) * (1 + (r / mpf(core_radius)) ** 2) ** (-3 * b / 2)
    x = (r / mpf(cooling_radius)) ** mpf(cooling_exponent)
    kev = (mpf(temperature) * (x + mpf(core_fraction)) / (x + 1)
           / (1 + (r / mpf(decline_radius)) ** 2) ** (mpf(decline_exponent) / 2))
    kelvin = kev * KEV / BOLTZMANN

    def power(frequency):
        """In erg s^-1 cm^-3 Hz^-1, into all directions."""
        return (mpf("6.8e-38") * mpf(ion_charge) * electrons**2 / sqrt(kelvin) * mpf(gaunt_factor)
                * exp(-PLANCK * frequency / (BOLTZMANN * kelvin)))

    def photons(low, high):
        """Per second, cm^3 and sr."""
        return quad(lambda f: power(f) / (PLANCK * 10**7 * f),
                    [low * KEV / PLANCK, high * KEV / PLANCK]) / (4 * pi)

    return per_kev(photons, mpf(energy)) * KPC_CM


def ena_ring(position, energy, ion_density="3", ion_temperature="8", temperature_exponent="",
             kappa="5", shell="4", shell_width="0.8", latitude_width="30"):
    r = norm(position)
    if r < mpf("1.08"):
        return mpf(0)
    latitude = asin(mpf(position[2]) / r)
    ell = r / (1 - (mpf(position[2]) / r) ** 2)
    p = mpf(temperature_exponent) if temperature_exponent else mpf(8) / 3
    joule = mpf(ion_temperature) * (mpf(shell) / ell) ** p * KEV
    protons = (mpf(ion_density) * 10**6
               * exp(-((ell - mpf(shell)) / mpf(shell_width)) ** 2 / 2)
               * exp(-((latitude * 180 / pi) / mpf(latitude_width)) ** 2 / 2))
    k = mpf(kappa)
    # The most probable speed of Vasyliunas: w^2 = (2 kappa - 3)/kappa kT/m.
    w2 = (2 * k - 3) / k * joule / PROTON_MASS

    def shape(v):
        return (1 + v * v / (k * w2)) ** (-k - 1)

    w = sqrt(w2)
    stops = [mpf(0), 1, 3, 10, 100, inf]
    norm_of_shape = 4 * pi * w**3 * quad(lambda s: s * s * shape(s * w), stops)

    def flux(low, high):
        """Per second, m^2 and sr."""
        speeds = [sqrt(2 * e * KEV / PROTON_MASS) for e in (low, high)]
        return protons / norm_of_shape * quad(lambda v: v**3 * shape(v), speeds)

    e = mpf(energy)
    cross_section_m2 = ((mpf("4.15") - mpf("0.531") * log(e)) ** 2
                        * (1 - exp(mpf("-67.3") / e)) ** mpf("4.5") / mpf(10) ** 20)
    hydrogen_m3 = 10**6 * exp(
        mpf("10.692") - mpf("4.4431") * log(r / mpf("1.08")) ** mpf("0.715831"))
    per_m3 = hydrogen_m3 * cross_section_m2 * per_kev(flux, e)
    return per_m3 / 10**6 * EARTH_RADIUS_CM


def cases():
    offset = "density=0.03 core_radius=60 beta=0.8 centre_x=40 centre_y=-25 centre_z=10"
    isothermal = "core_fraction=1 decline_exponent=0 temperature=3.5 ion_charge=1 gaunt_factor=1.1"
    graded = ("core_fraction=0.2 cooling_radius=80 cooling_exponent=3 decline_radius=300 "
              "decline_exponent=2.5 temperature=12")
    for position in [(0.0, 0.0, 0.0), (30.0, -20.0, 10.0), (0.0, 150.0, 90.0), (900.0, 0.0, -900.0)]:
        for energy in [0.1, 1.0, 7.5, 40.0]:
            for parameters in ["", offset, isothermal, graded]:
                yield bremsstrahlung, parameters, position, energy

    cold = "ion_temperature=1.5 temperature_exponent=2 kappa=2.2 ion_density=0.5"
    outer = "shell=5.5 shell_width=1.5 latitude_width=15 kappa=60 temperature_exponent=3"
    for position in [(4.0, 0.0, 0.0), (-2.0, 2.5, 0.7), (0.0, -5.5, -1.5), (0.8, 0.3, 1.4),
                     (12.5, 1.0, 0.5)]:
        for energy in [0.05, 2.0, 20.0, 180.0]:
            for parameters in ["", cold, outer]:
                yield ena_ring, parameters, position, energy
    yield ena_ring, "", (0.5, 0.5, 0.5), 20.0


def main():
    print("model,parameters,x,y,z,energy,rate")
    for model, parameters, position, energy in cases():
        given = dict(parameter.split("=") for parameter in parameters.split())
        rate = mp.nstr(model(position, energy, **given), 20)
        numbers = ",".join(repr(float(number)) for number in (*position, energy))
        print(f"{model.__name__},{parameters},{numbers},{rate}")


if __name__ == "__main__":
    main()
