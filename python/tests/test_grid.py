"""Data on grids: dimensions, coordinates, units, files, and messages."""

import numpy as np
import pytest

import emitree

CUBE = emitree.Canonical()
X = np.linspace(0, 1, 5)
Y = np.linspace(0, 1, 4)
Z = np.linspace(0, 1, 3)
VALUES = X[:, None, None] + 10 * Y[:, None] + 100 * Z
CAMERA = emitree.Orthographic(
    position=(0.5, 0.5, 0),
    target=(0.5, 0.5, 1),
    up=(0, 1, 0),
    extent=(1, 1),
    near=0,
    far=1,
    length_unit="km",
)


def image(**options):
    return emitree.render(emitree.Grid(**options), CUBE, (2, 2)).image


@pytest.fixture
def data_array():
    xarray = pytest.importorskip("xarray")
    return xarray.DataArray(VALUES, dims=("x", "y", "z"), coords={"x": X, "y": Y, "z": Z})


PLAIN = image(values=VALUES, x=X, y=Y, z=Z)


@pytest.mark.parametrize("dims", ["xyz", "zyx", "yzx"])
def test_the_dimensions_of_a_data_array_are_honoured(data_array, dims):
    ordered = data_array.transpose(*dims)
    assert np.array_equal(image(values=ordered), PLAIN)
    assert np.array_equal(image(values=ordered, x=X, y=(0, 1), z=Z), PLAIN)
    upper = ordered.rename({"x": "X", "y": "Y", "z": "Z"})
    assert np.array_equal(image(values=upper), PLAIN)


def test_descending_coordinates_are_honoured(data_array):
    assert np.array_equal(image(values=data_array[::-1, :, ::-1]), PLAIN)


def test_keywords_come_before_coordinates(data_array):
    shifted = data_array.assign_coords(x=X + 7)
    assert np.array_equal(image(values=shifted, x=X), PLAIN)


def test_other_dimensions_are_refused(data_array):
    oblique = data_array.rename({"x": "u", "y": "v", "z": "w"})
    message = r"dimensions \('u', 'v', 'w'\): expected x, y and z, or rho, phi and z, or r,"
    with pytest.raises(emitree.SceneError, match=message):
        image(values=oblique)
    with pytest.raises(emitree.SceneError, match=r"dimensions \('y', 'z'\)"):
        image(values=data_array[0])
    with pytest.raises(emitree.SceneError, match=r"dimensions \('time', 'x', 'y', 'z'\).*`isel`"):
        image(values=data_array.expand_dims("time"))


def test_coordinates_that_are_missing_or_doubled_are_named(data_array):
    message = "no coordinate for its dimension y: expected one .*, or the keyword `y`"
    with pytest.raises(emitree.SceneError, match=message):
        image(values=data_array.drop_vars("y"))
    assert np.array_equal(image(values=data_array.drop_vars("y"), y=Y), PLAIN)
    twice = data_array.rename({"x": "lat", "y": "theta", "z": "phi"})
    with pytest.raises(emitree.SceneError, match="two dimensions for theta, lat and theta"):
        image(values=twice)
    repeated = data_array.assign_coords(y=[0, 0.5, 0.5, 1])
    with pytest.raises(emitree.SceneError, match=r"node 2 of the y axis is 0\.5 and follows 0\.5"):
        image(values=repeated)


def test_a_variable_of_a_dataset_is_chosen(data_array):
    dataset = data_array.to_dataset(name="g").assign(h=2 * data_array)
    assert np.array_equal(image(values=dataset, variable="g"), PLAIN)
    assert np.array_equal(image(values=dataset, variable="h"), 2 * PLAIN)
    with pytest.raises(emitree.SceneError, match="is a Dataset of g, h: expected `variable`"):
        image(values=dataset)
    with pytest.raises(emitree.SceneError, match="`variable` is 'k': expected one of g, h"):
        image(values=dataset, variable="k")


def test_units_of_coordinates_are_converted(data_array):
    pytest.importorskip("astropy")
    in_metres = data_array.assign_coords(
        {
            name: (name, 1000 * nodes, {"units": "m"})
            for name, nodes in zip("xyz", (X, Y, Z), strict=True)
        }
    )
    plain = emitree.render(emitree.Grid(values=VALUES, x=X, y=Y, z=Z), CAMERA, (2, 2)).image
    ours = emitree.render(emitree.Grid(values=in_metres), CAMERA, (2, 2)).image
    np.testing.assert_allclose(ours, plain, rtol=1e-12)
    seconds = data_array.assign_coords(x=("x", X, {"units": "s"}))
    with pytest.raises(emitree.SceneError, match="coordinate `x` of `values` is in 's'"):
        emitree.render(emitree.Grid(values=seconds), CAMERA, (2, 2))


def test_values_may_be_quantities():
    u = pytest.importorskip("astropy.units")
    nodes = {"x": X * u.km, "y": Y * 1000 * u.m, "z": Z * u.km}
    rates = VALUES * u.Unit("ph cm-3 s-1 sr-1")
    ours = emitree.render(emitree.Grid(values=rates, **nodes), CAMERA, (2, 2))
    unit = {"unit": "ph cm-3 s-1 sr-1"}
    plain = emitree.render(emitree.Grid(values=VALUES, x=X, y=Y, z=Z), CAMERA, (2, 2), **unit)
    assert u.Unit(ours.unit) == u.Unit(plain.unit)
    assert np.array_equal(ours.image, plain.image)
    in_metres = emitree.render(
        emitree.Grid(values=rates, **nodes), CAMERA, (2, 2), unit="ph m-3 s-1 sr-1"
    )
    np.testing.assert_allclose(in_metres.quantity.to_value(plain.unit), plain.image, rtol=1e-12)
    with pytest.raises(emitree.SceneError, match="`values` is "):
        emitree.render(emitree.Grid(values=VALUES * u.km, **nodes), CAMERA, (2, 2), **unit)


def test_files_and_their_variables(tmp_path):
    path = tmp_path / "data.npz"
    np.savez(path, g=VALUES, other=2 * VALUES, x=X, y=Y, z=Z)
    nodes = {"x": "x", "y": "y", "z": "z", "order": "xyz"}
    assert np.array_equal(image(file=path, variable="g", **nodes), PLAIN)
    np.testing.assert_allclose(image(file=path, variable="other", **nodes), 2 * PLAIN)
    np.testing.assert_allclose(image(file=path, variable="g", scale=3, **nodes), 3 * PLAIN)
    with pytest.raises(emitree.SceneError, match=r"data\.npz: it has no array `h`: expected one"):
        image(file=path, variable="h", **nodes)
    with pytest.raises(emitree.SceneError, match=r"no array `values`.*; `variable` chooses one"):
        image(file=path, **nodes)
    # As it was before there was `file`.
    assert np.array_equal(image(values=str(path), variable="g", **nodes), PLAIN)


@pytest.mark.parametrize(("options", "message"), [
    ({}, "expected one of `values`, an array, and `file`"),
    ({"values": VALUES, "file": "a.nc"}, "expected one of `values`, an array, and `file`"),
    ({"values": VALUES, "variable": "g"}, "`variable` is for files and Datasets: expected none"),
    ({"values": VALUES, "scale": 2}, "`scale` is for files: expected none"),
    ({"values": VALUES, "coordinates": "polar"}, "`coordinates` is 'polar': expected one of 'cart"),
    ({"values": VALUES, "x": X, "r": X}, "`r` is given: expected the axes of cartesian"),
    ({"values": VALUES[0]}, r"`values` has the shape \(4, 3\): expected \(nx, ny, nz\)"),
    ({"values": "a,b".split(",")}, "`values` is list: expected an array"),
    ({"values": VALUES, "x": "lon"}, "`x` is 'lon': expected nodes, names are for files"),
    ({"values": VALUES, "x": X[:3], "y": Y, "z": Z}, r"the grid array of shape \(5, 4, 3\): the x axis: it has 3"),
    ({"values": VALUES, "x": [0, 1, 2, 3, 3], "y": Y, "z": Z}, r"the grid array of shape \(5, 4, 3\): node 4 of the x"),
    ({"values": VALUES * np.nan, "x": X, "y": Y, "z": Z}, r"the grid array of shape \(5, 4, 3\): .*NaN"),
])  # fmt: skip
def test_what_is_wrong_is_named_and_no_temporary_file(options, message):
    with pytest.raises(emitree.SceneError, match=message) as raised:
        image(**options)
    assert ".npy" not in str(raised.value)


def test_the_scene_names_no_temporary_file():
    grid = emitree.Grid(values=VALUES, x=X, y=Y, z=Z)
    scene = emitree.render(grid, CUBE, (2, 2)).scene
    assert 'file = "array of shape (5, 4, 3)"' in scene and ".npy" not in scene


def lumps(position):
    """Two Gaussians in (0, 1)^3."""
    total = 0.0
    for height, centre in [(1.0, (0.45, 0.5, 0.55)), (0.5, (0.6, 0.35, 0.5))]:
        offset = position - np.array(centre)
        total = total + height * np.exp(-50 * (offset**2).sum(axis=-1))
    return total


def sampled(function, nodes, interpolation):
    places = np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), axis=-1)
    axes = {"x": nodes, "y": nodes, "z": nodes}
    return emitree.Grid(values=function(places), interpolation=interpolation, **axes)


def values(grid, position):
    return emitree.Fields({"g": grid}, "g").values(position)["g"]


def test_cubics_are_of_third_order_at_peaks_too():
    at = np.random.default_rng(1).uniform(0.1, 0.9, (4000, 3))
    errors = {}
    for interpolation in ("linear", "cubic"):
        for count in (33, 65):
            found = values(sampled(lumps, np.linspace(0, 1, count), interpolation), at)
            errors[interpolation, count] = np.abs(found - lumps(at)).max()
    assert 3.4 < errors["linear", 33] / errors["linear", 65] < 4.4
    assert errors["cubic", 33] / errors["cubic", 65] > 7
    assert errors["cubic", 33] < errors["linear", 33] / 5


def test_cubics_are_smooth_and_not_negative():
    nodes = np.cumsum([0.0, 1, 2, 1, 3, 1, 1])

    def step(position):
        return (position[..., 0] > 4).astype(float)

    x = np.stack([np.linspace(0, nodes[-1], 3001), np.full(3001, 4.5), np.full(3001, 4.5)], axis=1)
    along = values(sampled(step, nodes, "cubic"), x)
    assert along.min() == 0 and 1.01 < along.max() < 1.1
    np.testing.assert_array_equal(along[np.isclose(x[:, 0], 7)], 1)
    # Where none of them is cut off at 0 the slopes at both sides of a node are the same.
    bent = sampled(lambda position: step(position) + 1, nodes, "cubic")
    for node in nodes[1:-1]:
        three = values(bent, np.array([[node + shift, 4.5, 4.5] for shift in (-1e-6, 0, 1e-6)]))
        slopes = np.diff(three) / 1e-6
        assert abs(slopes[1] - slopes[0]) < 1e-4


def error_of_sums(count):
    """1/12 of the second differences of the sums along an axis, over their largest value."""
    nodes = np.linspace(0, 1, count)
    values = lumps(np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), axis=-1))
    # By the trapezoidal rule.
    weights = np.ones(count)
    weights[[0, -1]] = 0.5
    errors = []
    for axis in range(3):
        sums = np.tensordot(weights, values, axes=(0, axis))
        bends = [np.abs(np.diff(sums, 2, axis=along)) for along in (0, 1)]
        bend = bends[0][:, 1:-1] + bends[1][1:-1]
        errors.append(bend.max() / 12 / sums.max())
    return min(errors)


def test_images_of_cubics_cost_what_those_of_the_function_cost():
    camera = emitree.Orthographic(
        position=(3, 0.5, 0.5), target=(0.5, 0.5, 0.5), extent=(1, 1), near=0, far=9
    )
    box = emitree.Box(min=(0, 0, 0), max=(1, 1, 1))
    smooth = emitree.render(lambda r, d: lumps(r), camera, (24, 24), bounds=box, tolerance=0.01)
    evaluations = [smooth.evaluations]
    for interpolation in ("cubic", "linear"):
        grid = sampled(lumps, np.linspace(0, 1, 33), interpolation)
        found = emitree.render(grid, camera, (24, 24), tolerance=0.01)
        assert found.converged
        evaluations.append(found.evaluations)
        if interpolation == "cubic":
            assert np.abs(found.image - smooth.image).max() < 0.015 * smooth.image.max()
            assert found.report["data_error"] is None
        else:
            assert found.report["data_error"] == pytest.approx(error_of_sums(33), rel=1e-6)
            assert found.report["hint"] == (
                "linear interpolation between the data makes an error of some 1.3 % of the largest "
                "pixel, more than the tolerance, which no error estimate contains; where the data "
                'are smooth, that of `interpolation` = "cubic" is smaller'
            )
            looser = emitree.render(grid, camera, (24, 24), tolerance=0.03).report
            assert looser["data_error"] == found.report["data_error"] and looser["hint"] is None
    assert evaluations == [1482, 1508, 13647]
