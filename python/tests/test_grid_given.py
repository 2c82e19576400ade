"""Data as users have them: types, orders, units and ends of axes, each against a closed form of the image."""

import math

import numpy as np
import pytest

import emitree

#: The emission is exp(-r^2/2) (1 + b . r) up to r = 5, where the first factor is 4e-6.
SLOPE = np.array([0.12, 0.08, -0.1])
#: Coordinates of the image (right, up) and the direction of sight.
VIEWS = {
    "x": dict(position=(40, 0, 0), up=(0, 0, 1), right=1, above=2),
    "y": dict(position=(0, 40, 0), up=(1, 0, 0), right=2, above=0),
    "z": dict(position=(0, 0, 40), up=(0, 1, 0), right=0, above=1),
}
COUNT = 8
EXTENT = 6.0


def rate(position):
    return np.exp(-(position**2).sum(axis=-1) / 2) * (1 + position @ SLOPE)


def exact(view):
    """The mean over each pixel of the integral along the line of sight."""
    edges = np.linspace(-EXTENT / 2, EXTENT / 2, COUNT + 1)
    width = EXTENT / COUNT
    plain = np.array([math.sqrt(math.pi / 2) * math.erf(edge / math.sqrt(2)) for edge in edges])
    even, odd = np.diff(plain) / width, -np.diff(np.exp(-(edges**2) / 2)) / width
    right, above = SLOPE[VIEWS[view]["right"]], SLOPE[VIEWS[view]["above"]]
    first = np.outer(even, even) + right * np.outer(even, odd) + above * np.outer(odd, even)
    return math.sqrt(2 * math.pi) * first


def camera(view, **options):
    scale = options.pop("scale", 1.0)
    place = VIEWS[view]
    return emitree.Orthographic(
        position=tuple(scale * of for of in place["position"]),
        target=(0, 0, 0),
        up=place["up"],
        extent=(scale * EXTENT, scale * EXTENT),
        **options,
    )


def check(grid, views="xyz", **options):
    """Compares images of a grid with the closed form, which the data differ from by up to 0.5 %."""
    for view in views:
        found = emitree.render(grid, camera(view, **options), (COUNT, COUNT), tolerance=0.01)
        assert found.converged
        truth = exact(view) * options.get("scale", 1.0)
        assert np.abs(found.image - truth).max() < 0.015 * truth.max(), view


X, Y, Z = np.linspace(-5, 5, 71), np.linspace(-5, 5, 73), np.linspace(-5, 5, 75)
CUBE = rate(np.stack(np.meshgrid(X, Y, Z, indexing="ij"), axis=-1))
AXES = {"x": X, "y": Y, "z": Z}


def grid(values=CUBE, **options):
    return emitree.Grid(values=values, interpolation="cubic", **AXES | options)


# -- Types and orders of arrays.


def big_endian(values):
    return values.astype(">f8")


def strided(values):
    whole = np.zeros(tuple(2 * n for n in values.shape))
    whole[::2, 1::2, ::2] = values
    return whole[::2, 1::2, ::2]


def lazy(values):
    array = pytest.importorskip("dask.array")
    return array.from_array(values, chunks=20)


@pytest.mark.parametrize("change", [
    np.asfortranarray, np.float32, big_endian, strided, lazy, np.ma.masked_invalid, np.ndarray.tolist,
])  # fmt: skip
def test_arrays_of_any_kind_are_the_same(change):
    check(grid(change(CUBE)), "y")


@pytest.mark.parametrize("kind", [np.int16, np.uint8, np.int64])
def test_integers_are_numbers(kind):
    counts = np.rint(CUBE * 200 / CUBE.max()).astype(kind)
    nodes = {name: axis.astype(np.float32) for name, axis in AXES.items()}
    found = emitree.render(grid(counts, **nodes), camera("x"), (COUNT, COUNT), tolerance=0.01)
    truth = exact("x") * 200 / CUBE.max()
    # The sum of half steps along a line of 70 nodes is some 0.5 % of the largest integral.
    assert np.abs(found.image - truth).max() < 0.02 * truth.max()


def test_axes_of_any_kind_are_the_same():
    down = grid(
        CUBE[::-1, ::-1, ::-1], x=X[::-1], y=Y[::-1].tolist(), z=(Z[::-1]).astype(np.float32)
    )
    check(down)
    check(grid(CUBE[:, ::-1], y=Y[::-1]), "z")
    check(grid(x=(-5, 5), y=[-5, 5], z=np.array([-5, 5])), "z")
    whole = emitree.Grid(values=np.ones((11, 11, 11)), x=range(11), y=np.arange(11), z=(0, 10))
    found = emitree.render(whole, emitree.Canonical(), (2, 2)).image
    np.testing.assert_allclose(found, 1.0, rtol=1e-12)


def test_thin_grids_have_their_thickness():
    """One cell along z: the integral across it is its thickness."""
    thin = emitree.Grid(values=np.ones((21, 21, 2)), x=(-5, 5), y=(-5, 5), z=(-0.25, 0.25))
    # A third of the pixels beside the plane is in it.
    for view, expected in [("z", 0.5), ("x", 10 / 3)]:
        found = emitree.render(thin, camera(view), (COUNT, COUNT), tolerance=0.01).image
        np.testing.assert_allclose(found[COUNT // 2], expected, rtol=0.02)
    with pytest.raises(
        emitree.SceneError, match=r"the z axis has 1 node.*: expected at least 2, since a plane"
    ):
        emitree.render(grid(CUBE[..., :1], z=[0.0]), camera("z"), (2, 2))


# -- xarray, with coordinates and units as files have them.


@pytest.fixture
def cube():
    xarray = pytest.importorskip("xarray")
    return xarray.DataArray(CUBE, dims=tuple("xyz"), coords=AXES)


@pytest.mark.parametrize("unit", ["km", "kilometers", "Kilometres", "kilometer"])
def test_lengths_in_attributes_are_converted(cube, unit):
    pytest.importorskip("astropy")
    for name in "xyz":
        cube[name].attrs["units"] = unit
    given = emitree.Grid(values=cube, interpolation="cubic")
    check(given, "x", length_unit="m", scale=1000.0)


def test_mixed_lengths_are_converted_or_refused(cube):
    pytest.importorskip("astropy")
    mixed = cube.assign_coords(x=("x", 1000 * X, {"units": "m"}), y=("y", Y, {"units": "km"}))
    given = emitree.Grid(values=mixed, interpolation="cubic")
    check(given, "xy", length_unit="km")
    with pytest.raises(
        emitree.SceneError, match="`x` in 'm', `y` in 'km': expected one unit, or a camera"
    ):
        check(given, "x")
    cube.x.attrs["units"] = "pixels"
    with pytest.raises(
        emitree.SceneError, match="coordinate `x` of `values` is in 'pixels': expected 'km'"
    ):
        check(emitree.Grid(values=cube), "x", length_unit="km")


@pytest.mark.parametrize("change", ["float32", "dask", "dataset", "descending", "transposed"])
def test_data_arrays_of_any_kind_are_the_same(cube, change):
    if change == "dask":
        pytest.importorskip("dask.array")
    changed = {
        "float32": lambda: cube.astype(np.float32).assign_coords(x=X.astype(np.float32)),
        "dask": lambda: cube.chunk(30),
        "dataset": lambda: cube.to_dataset(name="g"),
        "descending": lambda: cube[::-1, ::-1, ::-1],
        "transposed": lambda: cube.transpose("z", "x", "y"),
    }[change]()
    options = {"variable": "g"} if change == "dataset" else {}
    check(emitree.Grid(values=changed, interpolation="cubic", **options), "z")


# -- Spherical and cylindrical grids.

R = np.linspace(0, 5, 60)
LATITUDE_DEG = np.linspace(-90, 90, 61)


def ball(latitude_deg, phi_deg, radii=R):
    """The emission on r, latitude and phi."""
    r, latitude, phi = np.meshgrid(
        radii, np.radians(latitude_deg), np.radians(phi_deg), indexing="ij"
    )
    place = [
        r * np.cos(latitude) * np.cos(phi),
        r * np.cos(latitude) * np.sin(phi),
        r * np.sin(latitude),
    ]
    return rate(np.stack(place, axis=-1))


PHIS = {
    "with its end": np.linspace(0, 360, 81),
    "without": np.arange(80) * 4.5,
    "centres": np.arange(80) * 4.5 + 2.25,
    "from -180": np.linspace(-180, 180, 81),
    "beyond a turn": np.arange(80) * 4.5 + 270,
    "descending": np.arange(80)[::-1] * 4.5,
    "descending with its end": np.linspace(180, -180, 81),
    "of 32 bits": np.linspace(0, 360, 81, dtype=np.float32),
    "rounded": np.round(np.arange(120) * 3.0 + 1 / 3, 2),
}


@pytest.mark.parametrize("name", PHIS)
def test_azimuths_close_however_they_are_given(name):
    phi = PHIS[name]
    values = ball(LATITUDE_DEG, phi)
    nodes = {"r": R, "latitude": LATITUDE_DEG, "phi": phi, "angle_unit": "deg"}
    check(emitree.Grid(values=values, interpolation="cubic", **nodes))


@pytest.mark.parametrize("latitude", [
    LATITUDE_DEG, LATITUDE_DEG[::-1], np.linspace(-88.5, 88.5, 60), np.linspace(89, -89, 90),
], ids=["to the poles", "from the north", "centres", "centres from the north"])  # fmt: skip
def test_latitudes_and_colatitudes_are_the_same(latitude):
    phi = PHIS["without"]
    values = ball(latitude, phi)
    options = {"values": values, "r": R, "phi": phi, "interpolation": "cubic", "angle_unit": "deg"}
    check(emitree.Grid(latitude=latitude, **options), "xz")
    check(emitree.Grid(theta=90 - latitude, **options), "xz")
    in_radians = options | {"phi": np.radians(phi), "angle_unit": "rad"}
    check(emitree.Grid(theta=np.radians(90 - latitude), **in_radians), "x")


def test_geographic_data_arrays_are_taken():
    xarray = pytest.importorskip("xarray")
    phi = PHIS["from -180"]
    data = xarray.DataArray(
        ball(LATITUDE_DEG, phi).transpose(2, 1, 0),
        dims=("longitude", "latitude", "radius"),
        coords={
            "longitude": ("longitude", phi, {"units": "degrees_east"}),
            "latitude": ("latitude", LATITUDE_DEG, {"units": "degrees_north"}),
            "radius": ("radius", R),
        },
    )
    check(emitree.Grid(values=data, interpolation="cubic"))
    check(emitree.Grid(values=data[:, ::-1, ::-1].astype(np.float32), interpolation="cubic"), "y")


def test_cylinders_close_too():
    rho, z = np.linspace(0, 5, 50), np.linspace(5, -5, 71)
    for phi in (PHIS["with its end"], PHIS["without"], PHIS["descending"]):
        at, angle, height = np.meshgrid(rho, np.radians(phi), z, indexing="ij")
        place = [at * np.cos(angle), at * np.sin(angle), height]
        values = rate(np.stack(place, axis=-1))
        options = {"rho": rho, "phi": phi, "z": z, "angle_unit": "deg"}
        check(emitree.Grid(values=values, interpolation="cubic", **options), "xz")


# -- Messages.


def masked():
    values = np.ma.masked_greater(CUBE, 0.99 * CUBE.max())
    assert np.ma.is_masked(values)
    return values


def with_nan(array, at):
    changed = np.array(array)
    changed[at] = np.nan
    return changed


@pytest.mark.parametrize(("options", "message"), [
    ({"values": masked()}, r"`values` is masked at \(3\d, 3\d, 3\d\).*: expected an array \(nx, ny, nz\) of numbers \(`filled`"),
    ({"values": CUBE + 1j}, r"`values` is an array of complex128: expected an array \(nx, ny, nz\) of numbers"),
    ({"values": CUBE.astype(str)}, "`values` is an array of <U32: expected an array"),
    ({"values": with_nan(CUBE, (1, 2, 3))}, r"at \(x, y, z\) node \(1, 2, 3\)|\(1, 2, 3\)"),
    ({"x": with_nan(X, 2)}, r"`emission.grid.x\[2\]` is NaN: expected a finite number"),
    ({"x": np.ma.masked_equal(np.arange(71), 4)}, r"`x` is masked at \(4,\): expected the coordinates of the nodes"),
    ({"x": np.linspace(-5, 5, 72)}, r"the x axis: it has 72 nodes: expected 71, .*, with axes in the order xyz \(.*centres of cells.*edges"),
    ({"x": np.meshgrid(X, Y, Z, indexing="ij")[0]}, r"`x` has the shape \(71, 73, 75\): expected one axis, the coordinates of the nodes along it"),
    ({"x": np.array(["2024-01-01", "2024-01-02"], dtype="datetime64[D]")}, r"`x` is an array of datetime64\[D\]: expected the coordinates"),
    ({"values": CUBE.transpose(2, 1, 0)}, "the x axis: it has 71 nodes: expected 75, since the values are an array of shape"),
    ({"values": CUBE[None]}, r"`values` has the shape \(1, 71, 73, 75\): expected \(nx, ny, nz\)"),
])  # fmt: skip
def test_what_is_wrong_is_named(options, message):
    with pytest.raises(emitree.SceneError, match=message):
        emitree.render(grid(**options), camera("x"), (2, 2))


@pytest.mark.parametrize(("options", "message"), [
    ({"theta": LATITUDE_DEG}, r"the theta axis: node 0 is -90 deg: expected a colatitude from 0 to 180 deg.*latitude"),
    ({"latitude": 90 - LATITUDE_DEG}, "the theta axis: node .* is .* deg: expected a latitude from -90 to 90 deg"),
    ({"latitude": LATITUDE_DEG, "phi": np.radians(PHIS["without"])}, "the phi axis: it goes from 0 to 6.*expected degrees, or `angle_unit` = .rad."),
    ({"latitude": LATITUDE_DEG, "phi": np.arange(81) * 4.6}, "the phi axis: it goes from 0 to 368 deg: expected at most a full turn, 360 deg"),
    ({"latitude": with_nan(LATITUDE_DEG, 5)}, "NaN"),
    ({"latitude": LATITUDE_DEG, "r": R - 1}, "node 0 of the r axis is -1: expected a distance, 0 or more"),
])  # fmt: skip
def test_what_is_wrong_with_angles_is_named(options, message):
    phi = options.get("phi", PHIS["without"])
    values = np.ones((60, 61, len(phi)))
    nodes = {"r": R, "phi": phi, "angle_unit": "deg"} | options
    with pytest.raises(emitree.SceneError, match=message):
        emitree.render(emitree.Grid(values=values, **nodes), camera("x"), (2, 2))
