"""Zodiacal light at 25 um: ZodiPy's model of DIRBE's dust, seen from the Earth.

The densities of Kelsall et al. 1998 (doi:10.1086/306380) as ZodiPy has them, times the Planck
function at 286 K R^-0.467; at 25 um all emissivities are 1 and the albedo is 0. Lengths in AU,
rates in MJy/sr per AU. The crate `emitree-problems` has the same scene.
"""

from functools import cache
from pathlib import Path

import numpy as np

from .camera import WithinSphere
from .scene import Scene

#: The Earth on 14 June 2022 at 0 h, after astropy's built-in ephemeris, in heliocentric ecliptic
#: coordinates: what ZodiPy takes for it, without a network.
EARTH = (-0.129984109, -1.00722916, 5.215242e-5)
TIME = "2022-06-14"
#: T(R) = WARMTH R^-COOLING [K], after Kelsall et al.
WARMTH, COOLING = 286.0, 0.46686259861486573
#: h nu/k at 25 um [K], and 2 h nu^3/c^2 there [MJy/sr], from the exact constants of the SI.
QUANTUM, PLANCK = 575.5107510015735, 2542650697.1506286
#: Where lines of sight end.
JUPITER = 5.2

#: 90 degrees from the Sun along the ecliptic, where the Earth comes from.
CAMERA = WithinSphere(
    position=EARTH,
    target=(EARTH[0] + EARTH[1], EARTH[1] - EARTH[0], EARTH[2]),
    up=(0.0, 0.0, 1.0),
    field_of_view=(60.0, 60.0),
    far=2 * JUPITER,
    length_unit="AU",
    radius=JUPITER,
)
#: The exact image and its check; `python -m peers.zodi_exact` makes them.
IMAGES = Path(__file__).with_name("zodi_exact.npz")


@cache
def densities():
    """ZodiPy's density functions, of positions (3, n)."""
    from zodipy.component_params import DIRBE
    from zodipy.number_density import get_partial_number_density_func, update_partial_earth_pos

    earth = np.array(EARTH)[:, None]
    return tuple(update_partial_earth_pos(get_partial_number_density_func(DIRBE), earth).values())


def rate(x, y, z):
    """The emission rate at positions that are not the Sun's."""
    shape = np.broadcast_shapes(*(np.shape(t) for t in (x, y, z)))
    position = np.stack([np.broadcast_to(t, shape).ravel() for t in (x, y, z)])
    temperature = WARMTH * np.linalg.norm(position, axis=0) ** -COOLING
    dust = sum(density(position) for density in densities())
    return (dust * PLANCK / np.expm1(QUANTUM / temperature)).reshape(shape)


def exact(shape: tuple[int, int]) -> np.ndarray:
    """The image by quadrature, from its file."""
    return _from_file("exact", shape)


def check(shape: tuple[int, int]) -> np.ndarray:
    """The image by fewer nodes in other places, from its file."""
    return _from_file("check", shape)


def _from_file(name: str, shape: tuple[int, int]) -> np.ndarray:
    with np.load(IMAGES) as images:
        image = images[name].astype(float)
    if image.shape != shape:
        raise ValueError(f"{IMAGES.name} has images of shape {image.shape}: expected {shape}")
    return image


SCENE = Scene(
    "zodi",
    "zodiacal light at 25 um",
    rate,
    exact,
    check,
    shape=(120, 120),
    agreement=2e-5,
    camera=CAMERA,
)
