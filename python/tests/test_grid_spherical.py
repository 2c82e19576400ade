"""Spherical and cylindrical grids: a corona against its function and against SciPy's interpolation of the data."""

import numpy as np
import pytest

import emitree

CAMERA = emitree.Orthographic(
    position=(3, -40, 5), target=(0, 0, 0), up=(0, 0, 1), extent=(7, 7), near=30, far=50
)
# Above the north pole: the axis, the seam of phi and the outer end are in view, and no limb of the Sun, where
# lines of sight that are fixed converge slowly.
NORTH = emitree.Orthographic(
    position=(0, -40, 2.7), target=(0, 0, 2.7), up=(0, 0, 1), extent=(3, 3), near=30, far=50
)
SHAPE = (24, 24)
SUN = [emitree.Sphere(center=(0, 0, 0), radius=1)]
BOUNDS = emitree.Sphere(center=(0, 0, 0), radius=4)

# Radii at equal ratios, the middles of cells of theta, and phi without its end point.
R = np.geomspace(1, 4, 60)
THETA = (np.arange(40) + 0.5) * np.pi / 40
PHI = np.arange(80) * 2 * np.pi / 80


def corona(x, y, z):
    """Decreases as r^-3, with a streamer at one side, and smooth but for the origin."""
    r = np.sqrt(x**2 + y**2 + z**2)
    return r**-3.0 * (1 + 0.5 * x / r + 0.3 * (z / r) ** 2 + 0.2 * x * y / r**2)


def of_nodes(r, theta, phi):
    r, theta, phi = np.meshgrid(r, theta, phi, indexing="ij")
    in_plane = r * np.sin(theta)
    return corona(in_plane * np.cos(phi), in_plane * np.sin(phi), r * np.cos(theta))


VALUES = of_nodes(R, THETA, PHI)


def image(camera=CAMERA, shape=SHAPE, **options):
    grid = emitree.Grid(**options)
    return emitree.render(grid, camera, shape, tolerance=0.01, occulters=SUN)


def plain(camera=CAMERA):
    return image(camera, values=VALUES, r=R, theta=THETA, phi=PHI, angle_unit="rad")


def exact(camera=CAMERA, shape=SHAPE):
    found = emitree.render(
        lambda position, direction: corona(*position.T),
        camera,
        shape,
        tolerance=1e-3,
        occulters=SUN,
        bounds=BOUNDS,
    )
    assert found.converged
    return found.image


def scipy_corona():
    """SciPy's linear interpolation of the same data, with the seam and the poles closed."""
    interpolate = pytest.importorskip("scipy.interpolate")
    closed = np.concatenate([VALUES, VALUES[:, :, :1]], axis=2)
    poles = [np.repeat(VALUES[:, [i]].mean(axis=2, keepdims=True), 81, axis=2) for i in (0, -1)]
    closed = np.concatenate([poles[0], closed, poles[1]], axis=1)
    nodes = (R, np.concatenate([[0], THETA, [np.pi]]), np.append(PHI, 2 * np.pi))
    function = interpolate.RegularGridInterpolator(nodes, closed, bounds_error=False, fill_value=0)

    def rates(position, direction):
        x, y, z = position.T
        r = np.sqrt(x**2 + y**2 + z**2)
        theta = np.arctan2(np.hypot(x, y), z)
        return function(np.stack([r, theta, np.arctan2(y, x) % (2 * np.pi)], axis=1))

    return rates


def by_los(emission, lines, steps):
    options = dict(method="los", lines=lines, steps=steps, occulters=SUN, bounds=BOUNDS)
    return emitree.render(emission, NORTH, SHAPE, **options).image


def test_a_corona_is_as_scipy_and_los_have_it():
    """1 % of the brightest pixel, from the same data by another program."""
    ours = plain(NORTH)
    assert ours.converged
    rates = scipy_corona()
    coarse, fine = by_los(rates, 4, 60), by_los(rates, 8, 120)
    # The last change of the reference is far less than the tolerance.
    assert np.abs(fine - coarse).max() < 0.001 * fine.max()
    assert np.abs(ours.image - fine).max() < 0.01 * fine.max()


@pytest.mark.parametrize("camera", [CAMERA, NORTH], ids=["whole", "north"])
def test_a_corona_is_as_its_function_has_it(camera):
    ours, truth = plain(camera), exact(camera)
    assert ours.converged
    # The error of the data themselves, 60 x 40 x 80, is 0.15 %.
    assert np.abs(ours.image - truth).max() < 0.011 * truth.max()


def test_logarithmic_radii_are_closer_to_a_power():
    """Few radii, so that it shows: the error of r^-3 is 12/9 as large in r as in ln r, and cells are narrower."""
    r, shape = np.geomspace(1, 4, 8), (6, 6)
    options = dict(values=of_nodes(r, THETA, PHI), r=r, theta=THETA, phi=PHI, angle_unit="rad")
    truth = exact(NORTH, shape)
    linear, logarithmic = (
        np.abs(image(NORTH, shape, **options, **more).image - truth).max() / truth.max()
        for more in ({}, {"logarithmic": "r"})
    )
    assert logarithmic < 0.9 * linear


def test_order_and_units_of_a_data_array_are_honoured():
    xarray = pytest.importorskip("xarray")
    latitude = 90 - np.degrees(THETA)
    data = xarray.DataArray(
        VALUES[:, ::-1],
        dims=("radius", "lat", "lon"),
        coords={
            "radius": R,
            "lat": ("lat", latitude[::-1], {"units": "degrees_north"}),
            "lon": ("lon", np.degrees(PHI), {"units": "degrees_east"}),
        },
    )
    expected = plain().image
    for dims in (("radius", "lat", "lon"), ("lon", "radius", "lat")):
        ours = image(values=data.transpose(*dims)).image
        np.testing.assert_allclose(ours, expected, rtol=1e-9)
    rolled = data.roll(lon=30, roll_coords=True)
    with pytest.raises(emitree.SceneError, match=r"node 1 of the phi axis is 229.* follows 225"):
        image(values=rolled)
    data.lon.attrs["units"] = "km"
    with pytest.raises(emitree.SceneError, match="coordinate `lon` of `values` is in 'km'"):
        image(values=data)


def test_quantities_and_lists_are_angles_too():
    u = pytest.importorskip("astropy.units")
    expected = plain().image
    nodes = {"r": R, "theta": np.degrees(THETA) * u.deg, "phi": PHI * u.rad}
    np.testing.assert_allclose(image(values=VALUES, **nodes).image, expected, rtol=1e-9)
    nodes = {"r": R, "latitude": 90 - np.degrees(THETA), "phi": (0, 355.5), "angle_unit": "deg"}
    np.testing.assert_allclose(image(values=VALUES, **nodes).image, expected, rtol=1e-9)
    with pytest.raises(emitree.SceneError, match="`phi` has no unit, but others have"):
        image(values=VALUES, r=R, theta=THETA * u.rad, phi=PHI)


def test_a_cylinder_has_its_volume():
    """Uniform data to rho = 2 and |z| < 1, seen along the axis: twice the area of the disc."""
    camera = emitree.Orthographic(
        position=(0, 0, 9), target=(0, 0, 0), up=(0, 1, 0), extent=(5, 5), near=1, far=20
    )
    grid = emitree.Grid(
        values=np.full((3, 6, 2), 1.0), rho=(0, 2), phi=(0, 300), z=(-1, 1), angle_unit="deg"
    )
    found = emitree.render(grid, camera, (20, 20), tolerance=0.01).image
    np.testing.assert_allclose(found.sum() * (5 / 20) ** 2, 2 * np.pi * 4, rtol=2e-3)
    # From the side: chords of the disc.
    side = emitree.Orthographic(
        position=(9, 0, 0), target=(0, 0, 0), up=(0, 0, 1), extent=(5, 1), near=1, far=20
    )
    found = emitree.render(grid, side, (1, 20), tolerance=0.01).image[0]
    np.testing.assert_allclose(found.sum() * 5 / 20, np.pi * 4, rtol=2e-3)


@pytest.mark.parametrize(("options", "message"), [
    ({"angle_unit": "deg"}, "theta axis: it goes from 0.03.* deg.*|phi axis: it goes from 0 to 6.2"),
    ({}, "theta axis: the unit of its angles is not known: expected `angle_unit`"),
    ({"angle_unit": "rad", "theta": np.degrees(THETA)}, "node 1 is 6.75 rad: expected a colatitude from 0 to 3.14"),
    ({"angle_unit": "rad", "phi": np.degrees(PHI)}, r"goes from 0 to 355\.5 rad: expected at most a full turn"),
    ({"angle_unit": "rad", "latitude": THETA}, "expected one of `theta` and `latitude`"),
    ({"angle_unit": "rad", "theta": THETA[:3]}, "theta axis: it has 3 nodes: expected 40.*order r theta phi"),
    ({"angle_unit": "rad", "x": R}, "`x` is given: expected the axes of"),
])  # fmt: skip
def test_what_is_wrong_is_named(options, message):
    nodes = {"r": R, "theta": THETA, "phi": PHI} | options
    with pytest.raises(emitree.SceneError, match=message):
        image(values=VALUES, coordinates="spherical", **nodes)
