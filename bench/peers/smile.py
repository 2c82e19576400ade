"""The dayside magnetosheath in soft X-rays as SMILE's imager would see it: CMEM, view 1.

The model of Wharton et al. 2025 with the magnetopause of Lin et al. 2010
(doi:10.1029/2009JA014235), for 5 protons a cm^3 at 400 km/s and 5 nT northwards, no dipole tilt.
Lengths in R_E, rates in keV cm^-2 s^-1 sr^-1 per R_E. examples/smile.toml is the same scene.
"""

from pathlib import Path

import numpy as np

from .camera import Equirectangular
from .scene import Scene

DENSITY, VELOCITY, BZ = 5.0, 400.0, 5.0
#: Pressures of the wind, with the factor 1/2 of Wharton et al., and of its field [nPa].
WIND = 0.5 * 1.67e-27 * DENSITY * 1e6 * (VELOCITY * 1e3) ** 2 * 1e9
FIELD = (BZ * 1e-9) ** 2 / (2 * 4e-7 * np.pi) * 1e9
#: One eV cm^-3 s^-1 as a rate: 6.371e8 cm in an R_E, 4 pi sr, 1000 eV in a keV.
UNIT = 6.371e8 / (4 * np.pi) / 1000
#: Emissivity at 10 R_E of the sheath and of the wind.
SHEATH, SUNWARD = (2.7e-6 * DENSITY - 6.3e-6) * UNIT, (9e-7 * DENSITY - 1e-6) * UNIT

#: Lin's magnetopause: its nose, the powers of its shape, the depth of its cusps.
NOSE = (
    (0.0022 * DENSITY + 0.7753)
    * (12.544 * (WIND + FIELD) ** -0.194)
    * (1 + 0.305 * np.expm1(0.0573 * BZ) / (np.exp(2.178 * BZ) + 1))
)
FLARING = -0.999 + 16.473 * np.expm1(0.00152 * BZ) / (np.exp(0.382 * BZ) + 1)
DENT = 3 * -4.430 * (WIND + FIELD) ** -0.636
STEEPNESS, CUSP = 4 * -2.600, 1.103
#: The bow shock, of Shue's form.
SHOCK = 13.24 - 0.12 * DENSITY
SHOCK_FLARING = (0.58 - 0.010 * BZ) * (1 + 0.010 * WIND) + 0.2

CAMERA = Equirectangular(
    position=(10.0, -30.0, 0.0),
    target=(6.0, 0.0, 0.0),
    up=(0.0, 0.0, 1.0),
    field_of_view=(16.0, 27.0),
    far=80.0,
    length_unit="R_E",
)
#: The exact image and its check; `python -m peers.smile_exact` makes them.
IMAGES = Path(__file__).with_name("smile_exact.npz")


def _angles(x, y, z):
    """Distance, the angle from +x, and cosine and sine of the angle about it."""
    across = np.hypot(y, z)
    safe = np.where(across > 0, across, 1.0)
    return np.hypot(x, across), np.arctan2(across, x), np.where(across > 0, y / safe, 1.0), z / safe


def _magnetopause(theta, cos_phi, sin_phi):
    cos, sin = np.cos(theta), np.sin(theta)
    power = FLARING + 0.0431 * cos_phi + (0.0405 * sin_phi - 0.00763) * sin_phi
    base = np.cos(theta / 2) - 0.0571 * 2 * sin * cos * np.expm1(-theta)
    dents = 0.0
    for side in (1, -1):
        cosine = cos * np.cos(CUSP) + side * sin * sin_phi * np.sin(CUSP)
        dents = dents + np.exp(STEEPNESS * np.arccos(np.clip(cosine, -1, 1)) ** 1.450)
    return NOSE * base**power + DENT * dents


def _bow_shock(theta):
    return SHOCK * np.cos(theta / 2) ** (-2 * SHOCK_FLARING)


def heights(x, y, z):
    """Distances from the Earth less those of the magnetopause and of the bow shock."""
    r, theta, cos_phi, sin_phi = _angles(x, y, z)
    return r - _magnetopause(theta, cos_phi, sin_phi), r - _bow_shock(theta)


def sheath(x, y, z):
    """The rate between the magnetopause and the bow shock."""
    r, theta, _, _ = _angles(x, y, z)
    return _sheath(r, theta)


def wind(x, y, z):
    """The rate beyond the bow shock."""
    return _wind(np.hypot(x, np.hypot(y, z)))


def _sheath(r, theta):
    slope = 2.5 - 1.6 * np.sin(theta) ** 2
    return SHEATH * np.exp(-2 * (theta / 2) ** 4) * (r / 10) ** -slope


def _wind(r):
    return SUNWARD * (10 / r) ** 3


def rate(x, y, z):
    """The emission rate at positions that are not the centre of the Earth."""
    r, theta, cos_phi, sin_phi = _angles(x, y, z)
    outside = np.where(r < _bow_shock(theta), _sheath(r, theta), _wind(r))
    return np.where(r < _magnetopause(theta, cos_phi, sin_phi), 0.0, outside)


def exact(shape: tuple[int, int]) -> np.ndarray:
    """The image by quadrature, from its file."""
    return _from_file("exact", shape)


def check(shape: tuple[int, int]) -> np.ndarray:
    """The image by other nodes in other parts of the pixels, from its file."""
    return _from_file("check", shape)


def _from_file(name: str, shape: tuple[int, int]) -> np.ndarray:
    with np.load(IMAGES) as images:
        image = images[name]
    if image.shape != shape:
        raise ValueError(f"{IMAGES.name} has images of shape {image.shape}: expected {shape}")
    return image


SCENE = Scene(
    "smile",
    "the SMILE view of the magnetosheath",
    rate,
    exact,
    check,
    shape=(100, 50),
    agreement=1e-5,
    camera=CAMERA,
)
