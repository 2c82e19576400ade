"""Sensitivity matrices: every entry against lines of sight by the thousand, made by hand."""

import dataclasses

import numpy as np
import pytest
from chords import along, in_ball, in_box, in_ring, means, of_gaussian

import emitree

scipy_sparse = pytest.importorskip("scipy.sparse")

#: A torus of major radius 3 and minor radius 1, seen by cameras beside it.
CAMERAS = [
    emitree.Perspective(
        position=(4.6 * np.cos(a), 4.6 * np.sin(a), 0.2 + 0.1 * a),
        target=(-np.sin(a), np.cos(a), 0),
        field_of_view=(60, 50),
        far=10,
    )
    for a in (0, 2, 4)
]
SHAPE = (9, 12)
#: Numbers of random scenes: those with which the constants of the method were chosen, and others.
SEEN, SET_ASIDE = [1, 2, 3, 4], [101, 102, 103, 104]


def random_camera(rng):
    position = rng.normal(size=3)
    return emitree.Perspective(
        position=position * rng.uniform(2.5, 6) / np.linalg.norm(position),
        target=rng.uniform(-0.5, 0.5, 3),
        field_of_view=tuple(rng.uniform(15, 80, 2)),
        far=np.inf,
    )


def random_boxes(rng):
    lower = rng.uniform(-2, 1.5, (5, 3)).round(1)
    upper = lower + rng.choice([0.25, 0.5, 1.0], (5, 3))
    return emitree.Voxels(lower, upper), [in_box(*box) for box in zip(lower, upper, strict=True)]


def random_rings(rng):
    lower = np.c_[rng.uniform(0, 2, 5), rng.uniform(-1, 1, 5)].round(1)
    upper = lower + rng.choice([0.125, 0.25, 0.5], (5, 2))
    return emitree.Voxels(lower, upper), [in_ring(*ring) for ring in zip(lower, upper, strict=True)]


def random_gaussians(rng):
    centers, widths = rng.uniform(-1.5, 1.5, (5, 3)), rng.choice([0.1, 0.3, 0.6], 5)
    basis = emitree.RadialFunctions(centers, widths)
    places = zip(centers, widths, strict=True)
    return basis, [of_gaussian(center, width, basis.cutoff) for center, width in places]


def entries(found):
    """The number of entries of each column."""
    return np.diff(found.matrix.tocsc().indptr)


def errors_over_scale(found, truth, uncertainty):
    """The largest error of each column beyond the uncertainty of the truth, over the largest entry."""
    error = np.maximum(abs(found.matrix.toarray().T - truth) - uncertainty, 0.0).max(axis=1)
    largest = truth.max(axis=1)
    floor = 1e-6 * largest.max()
    return error / np.maximum(largest, floor)


@pytest.mark.parametrize("seed", SEEN + SET_ASIDE)
@pytest.mark.parametrize("family", [random_boxes, random_rings, random_gaussians])
def test_each_column_is_within_the_tolerance(family, seed):
    rng = np.random.default_rng(seed)
    camera = random_camera(rng)
    basis, functions = family(rng)
    truth, uncertainty = means(camera, (8, 9), functions)
    assert truth.max() > 0.01
    seen = truth.max(axis=1) > 0.05 * truth.max()
    assert (uncertainty[seen, 0] < 0.02 * truth[seen].max(axis=1)).all()
    for tolerance in (0.05, 0.01):
        found = emitree.sensitivity(basis, camera, (8, 9), tolerance)
        assert found.converged
        assert (found.relative_error <= tolerance).all()
        assert (errors_over_scale(found, truth, uncertainty) <= tolerance).all()


@pytest.mark.parametrize(
    "basis",
    [
        emitree.RadialFunctions([[2.5, 0.3], [3.4, -0.4]], 0.2, cutoff=6.0),
        emitree.RadialFunctions([[2.5, 0.3], [3.4, -0.4]], [0.5, 0.7], "wendland"),
        emitree.BSplines([np.linspace(2, 3.6, 6), np.linspace(-0.8, 0.6, 5)], degree=3),
        emitree.BSplines([[2, 3, 3.5, 4], [-1, 0, 1], [-1, 0, 0.5]], degree=1),
    ],
    ids=repr,
)
def test_smooth_functions(basis):
    found = emitree.sensitivity(basis, CAMERAS[:2], SHAPE, tolerance=0.01)
    assert found.converged and found.evaluations > 0
    numbers = [0, len(basis) - 1]
    functions = [along(basis.emission(np.eye(len(basis))[n]), 0.0, 10.0, 60) for n in numbers]
    truths = [means(camera, SHAPE, functions, panels=3) for camera in CAMERAS[:2]]
    truth = np.concatenate([of for of, _ in truths], axis=1)
    uncertainty = np.maximum(*[of for _, of in truths])
    assert (uncertainty[:, 0] < 2e-3 * truth.max(axis=1)).all()
    error = abs(found.matrix.toarray().T[numbers] - truth) - uncertainty
    assert (error.max(axis=1) <= 0.01 * truth.max(axis=1)).all()


def test_functions_of_the_user_alone_and_together():
    def pair(position, direction):
        distance = ((position[:, None] - np.array([[2.5, 0, 0], [3.0, 1.0, 0.2]])) ** 2).sum(axis=2)
        return np.exp(-distance / (2 * 0.3**2))

    def ball(position, direction):
        return (((position - [3.0, 0.5, 0.0]) ** 2).sum(axis=1) < 0.4).astype(float)

    camera = CAMERAS[0]
    truth, uncertainty = means(
        camera,
        (6, 8),
        [
            of_gaussian(np.array([2.5, 0, 0]), 0.3, 30.0),
            of_gaussian(np.array([3.0, 1.0, 0.2]), 0.3, 30.0),
            in_ball(np.array([3.0, 0.5, 0.0]), 0.4**0.5),
            in_box(np.array([2.0, 0, 0]), np.array([3.0, 1, 1])),
        ],
    )
    basis = [pair, ball, emitree.Voxels([[2.0, 0, 0]], [[3.0, 1, 1]])]
    found = emitree.sensitivity(basis, camera, (6, 8))
    assert found.matrix.shape == (48, 4) and found.converged
    assert (errors_over_scale(found, truth, uncertainty) <= 0.01).all()
    alone = emitree.sensitivity(pair, camera, (6, 8))
    assert alone.matrix.shape == (48, 2)
    assert (errors_over_scale(alone, truth[:2], uncertainty[:2]) <= 0.01).all()
    one = emitree.sensitivity(ball, camera, (6, 8), 0.05)
    assert (errors_over_scale(one, truth[2:3], uncertainty[2:3]) <= 0.05).all()


def test_voxels_far_smaller_than_a_pixel_are_not_missed():
    # The sum of mean times solid angle is the integral of dV / r^2, V / r^2 of a small cube.
    centers = np.array([[2.51, 0.33, 0.12], [-0.3, 1.87, -0.41]])
    voxels = emitree.Voxels(centers - 5e-3, centers + 5e-3)
    found = emitree.sensitivity(voxels, CAMERAS[0], SHAPE, tolerance=0.01)
    one = emitree.render("1", CAMERAS[0], SHAPE, quantity="irradiance", tolerance=1e-4)
    solid_angles = one.image.ravel() / 10
    square = ((centers - np.array(CAMERAS[0].position)) ** 2).sum(axis=1)
    assert found.converged and (entries(found) <= 4).all()
    assert solid_angles @ found.matrix == pytest.approx(1e-6 / square, rel=0.01)


def test_rings_of_a_grid_add_up_to_the_whole():
    grid = emitree.Voxels.grid(np.linspace(2, 4, 5), np.linspace(-1, 1, 4))
    whole = emitree.Voxels([[2, -1]], [[4, 1]])
    parts = emitree.sensitivity(grid, CAMERAS, SHAPE, tolerance=0.005)
    of_whole = emitree.sensitivity(whole, CAMERAS, SHAPE, tolerance=0.001)
    difference = parts.matrix.sum(axis=1) - of_whole.matrix.toarray()[:, 0]
    assert abs(difference).max() <= parts.error.sum() + of_whole.error[0]
    truth, uncertainty = means(CAMERAS[1], SHAPE, [in_ring(np.array([2, -1]), np.array([4, 1]))])
    middle = of_whole.matrix.toarray()[108:216, 0]
    assert (abs(middle - truth[0]) <= 0.001 * truth.max() + uncertainty).all()


def test_faces_that_are_seen_edge_on():
    # A camera in the plane of a face: the length jumps within a row of pixels.
    camera = emitree.Perspective(
        position=(6, 0.1, 0.25), target=(0, 0.1, 0.3), field_of_view=(20, 20), far=np.inf
    )
    lower, upper = np.array([0, -0.5, 0.25]), np.array([1, 0.5, 0.75])
    found = emitree.sensitivity(emitree.Voxels([lower], [upper]), camera, (7, 7))
    truth, uncertainty = means(camera, (7, 7), [in_box(lower, upper)], panels=40)
    assert found.converged and uncertainty.max() < 0.01
    assert (errors_over_scale(found, truth, 0.5 * uncertainty) <= 0.01).all()


@pytest.mark.parametrize(
    ("camera", "shape"),
    [
        (emitree.Canonical(), (5, 6)),
        (emitree.Orthographic(position=(0, -4, 0.1), target=(0, 0, 0.5), extent=(3, 3), far=9), (5, 6)),
        (emitree.Equirectangular(position=(0, -2, 1), target=(0, 0, 1), field_of_view=(90, 70), far=9), (5, 6)),
        (emitree.Fisheye(position=(0, -2, 1), target=(0, 0, 1), field_of_view=100, far=9), (7, 7)),
        (emitree.Polar(position=(0, -2, 1), target=(0.4, 0.5, 1), field_of_view=90, far=9), (5, 8)),
        (emitree.Healpix(position=(0.1, -2, 1), far=9), 2),
    ],
    ids=lambda value: type(value).__name__,
)  # fmt: skip
def test_all_cameras(camera, shape):
    basis = emitree.RadialFunctions([[0.4, 0.5, 0.6], [0.1, 0.2, 0.9]], 0.2, cutoff=6.0)
    found = emitree.sensitivity(basis, camera, shape, tolerance=0.01)
    assert found.converged
    for number in range(2):
        unit = np.eye(2)[number]
        finer = emitree.render(basis.emission(unit), camera, shape, tolerance=5e-4)
        truth, image = finer.image, found.image(unit)
        largest = np.nanmax(truth)
        assert finer.converged and largest > 0.01
        assert (np.isnan(image) == np.isnan(truth)).all()
        assert np.nanmax(abs(image - truth)) < 0.0105 * largest


def test_bodies_hide_and_bounds_end():
    camera = emitree.Perspective(
        position=(0, -6, 0), target=(0, 0, 0), field_of_view=(40, 40), far=np.inf
    )
    body = emitree.Sphere(center=(0, 0, 0), radius=1)
    behind, before = [[-0.2, 1.5, -0.2]], [[-0.2, -1.9, -0.2]]
    voxels = emitree.Voxels(behind + before, [[0.2, 2, 0.2], [0.2, -1.4, 0.2]])
    hidden = emitree.sensitivity(voxels, camera, (9, 9), occulters=[body])
    assert hidden.converged and entries(hidden)[0] == 0
    free = emitree.sensitivity(voxels, camera, (9, 9))
    assert entries(free)[0] > 0
    assert abs(hidden.matrix - free.matrix)[:, [1]].max() <= 0.02 * free.scale[1]
    half = emitree.Box(min=(-1, -1.65, -1), max=(1, 3, 1))
    cut = emitree.sensitivity(voxels, camera, (9, 9), bounds=half)
    shorter = emitree.Voxels([[-0.2, -1.65, -0.2]], [[0.2, -1.4, 0.2]])
    of_shorter = emitree.sensitivity(shorter, camera, (9, 9))
    assert abs(cut.matrix[:, [1]] - of_shorter.matrix).max() <= 0.02 * of_shorter.scale[0]


def test_the_result():
    rings = emitree.Voxels.grid(np.linspace(2, 4, 4), np.linspace(-1, 1, 4))
    found = emitree.sensitivity(rings, CAMERAS, [(6, 8), (4, 5), (3, 3)], 0.05, threads=2)
    assert isinstance(found.matrix, scipy_sparse.csr_array)
    assert found.matrix.shape == (48 + 20 + 9, 9)
    assert found.shapes == ((6, 8), (4, 5), (3, 3)) and found.unit is None
    assert found.lines > 9 * found.matrix.nnz and found.evaluations == 0
    images = found.image(np.arange(9.0))
    assert [image.shape for image in images] == [(6, 8), (4, 5), (3, 3)]
    assert np.concatenate([image.ravel() for image in images]) == pytest.approx(
        found.matrix @ np.arange(9.0)
    )
    assert "3 cameras, converged" in repr(found)
    alone = emitree.sensitivity(rings, CAMERAS[1], (4, 5), 0.05)
    assert alone.image(np.ones(9)).shape == (4, 5)
    with pytest.raises(ValueError, match=r"`coefficients` has the shape \(3,\): expected \(9,\)"):
        found.image(np.ones(3))
    with pytest.raises(ValueError, match=r"`pixels` has the shape \(3,\): expected \(77,\)"):
        found.split(np.ones(3))


@pytest.fixture
def found():
    rings = emitree.Voxels.grid(np.linspace(2, 4, 4), np.linspace(-1, 1, 4))
    return emitree.sensitivity(rings, CAMERAS[:2], [(6, 8), (4, 5)], 0.05)


def test_a_file_has_all(found, tmp_path):
    path = tmp_path / "matrix.npz"
    found.save(path)
    loaded = emitree.Sensitivity.load(path)
    assert (loaded.matrix != found.matrix).nnz == 0 and loaded.matrix.shape == found.matrix.shape
    for name in ("error", "scale", "in_image"):
        np.testing.assert_array_equal(getattr(loaded, name), getattr(found, name))
    for name in ("shapes", "tolerance", "unit", "lines", "evaluations", "converged"):
        assert getattr(loaded, name) == getattr(found, name)
    assert [image.shape for image in loaded.image(np.ones(9))] == [(6, 8), (4, 5)]
    with pytest.raises(FileExistsError):
        found.save(path)
    fisheye = emitree.Fisheye(position=(6, 0, 0), target=(0, 0, 0), field_of_view=40, far=9)
    in_km = dataclasses.replace(fisheye, length_unit="km")
    alone = emitree.sensitivity(emitree.Voxels([[2, -1]], [[4, 1]]), in_km, (8, 8), 0.05)
    alone.save(path, overwrite=True)
    loaded = emitree.Sensitivity.load(path)
    assert loaded.unit == "km" and repr(loaded) == repr(alone)
    np.testing.assert_array_equal(loaded.image([2.0]), alone.image([2.0]))
    assert [file.name for file in tmp_path.iterdir()] == ["matrix.npz"]


def test_wrong_files_are_named(found, tmp_path):
    path = tmp_path / "matrix.npz"
    with pytest.raises(FileNotFoundError, match=r"matrix\.npz"):
        emitree.Sensitivity.load(path)
    path.write_bytes(b"PK\x03\x04 damaged")
    with pytest.raises(ValueError, match=r"matrix\.npz: not a file of NumPy.*expected a sensitiv"):
        emitree.Sensitivity.load(path)
    np.savez(path, format="emitree plan", version=1)
    with pytest.raises(ValueError, match="the `format` is 'emitree plan': expected a sensitivity"):
        emitree.Sensitivity.load(path)
    found.save(path, overwrite=True)
    with np.load(path) as file:
        arrays = dict(file)
    np.savez(path, **arrays | {"version": 2})
    with pytest.raises(ValueError, match="matrix of version 2: expected version 1 to 1"):
        emitree.Sensitivity.load(path)
    np.savez(path, **{name: array for name, array in arrays.items() if name != "scale"})
    with pytest.raises(ValueError, match="matrix without `scale`: expected a complete file"):
        emitree.Sensitivity.load(path)
    for name in ("scale", "in_image", "data", "indptr"):
        np.savez(path, **arrays | {name: arrays[name][:-1]})
        with pytest.raises(ValueError, match="do not agree: expected 68 pixels and 9 functions"):
            emitree.Sensitivity.load(path)


def test_the_bits_do_not_depend_on_threads():
    basis = [
        emitree.Voxels.grid(np.linspace(2, 4, 4), np.linspace(-1, 1, 4)),
        emitree.RadialFunctions([[3, 0], [2.5, 0.2]], 0.2),
    ]
    one, three = (emitree.sensitivity(basis, CAMERAS[:2], SHAPE, threads=n) for n in (1, 3))
    for name in ("data", "indices", "indptr"):
        assert (getattr(one.matrix, name) == getattr(three.matrix, name)).all()
    assert (one.error == three.error).all() and one.lines == three.lines


def test_a_function_is_called_in_the_calling_thread():
    import threading

    threads = set()

    def rate(position, direction):
        threads.add(threading.get_ident())
        assert np.linalg.norm(direction, axis=1) == pytest.approx(1)
        return np.exp(-(position**2).sum(axis=1))

    emitree.sensitivity(rate, CAMERAS, (4, 4), 0.05)
    assert threads == {threading.get_ident()}


def test_units():
    u = pytest.importorskip("astropy.units")
    in_km = emitree.Perspective(
        position=(6, 0, 0) * u.km, target=(0, 0, 0) * u.km, field_of_view=(20, 20), far=9 * u.km
    )
    voxel = emitree.Voxels([[-0.5, -0.5, -0.5]], [[0.5, 0.5, 0.5]])
    found = emitree.sensitivity(voxel, in_km, (3, 3))
    assert found.unit == "km" and found.scale[0] == pytest.approx(1, rel=0.02)
    in_m = emitree.Perspective(
        position=(6, 0, 0), target=(0, 0, 0), field_of_view=(20, 20), far=9, length_unit="m"
    )
    with pytest.raises(emitree.SceneError, match=r"length units .*: expected the same for all"):
        emitree.sensitivity(voxel, [in_km, in_m], (3, 3))


def test_functions_that_no_camera_sees():
    away = emitree.Voxels([[40, 40, 40], [2, -1, -1]], [[41, 41, 41], [3, 0, 0]])
    found = emitree.sensitivity(away, CAMERAS, SHAPE)
    assert found.converged and entries(found)[0] == 0
    assert found.error[0] == 0 and found.relative_error[0] == 0


def test_values_and_emissions():
    boxes = emitree.Voxels.grid(
        [0, 1, 3], [0, 2], [0, 1, 2], mask=np.array([[[True, False]], [[True, True]]])
    )
    assert boxes.lower.tolist() == [[0, 0, 0], [1, 0, 0], [1, 0, 1]]
    points = np.array([[0.5, 1, 0.5], [2, 1, 1.5], [0.5, 1, 1.5]])
    assert boxes(points).tolist() == [[1, 0, 0], [0, 0, 1], [0, 0, 0]]
    assert boxes.emission([1, 2, 3])(points, points).tolist() == [1, 3, 0]
    splines = emitree.BSplines([np.arange(9.0), np.arange(-4, 5.0)], degree=3)
    assert splines.shape == (5, 5) and len(splines) == 25
    inside = np.array([[3.3, 0, 0.2], [0, 4.7, -0.9]])
    assert splines(inside).sum(axis=1) == pytest.approx(1)


@pytest.mark.parametrize("degree", [1, 2, 3, 5])
def test_b_splines_are_those_of_scipy(degree):
    from scipy.interpolate import BSpline

    rng = np.random.default_rng(degree)
    ends = np.zeros(degree + 1), np.sort(rng.uniform(0, 1, 4)), np.ones(degree + 1)
    double = np.sort([*rng.uniform(-1, 1, degree + 3), 0.1, 0.1])
    knots = [np.concatenate(ends), double]
    basis = emitree.BSplines(knots, degree)
    radius, z = rng.uniform(0, 1, 500), rng.uniform(-1, 1, 500)
    along = [
        np.stack([BSpline.basis_element(of[n : n + degree + 2], False)(x) for n in range(count)])
        for of, count, x in zip(knots, basis.shape, (radius, z), strict=True)
    ]
    truth = np.nan_to_num(along[0])[:, np.newaxis] * np.nan_to_num(along[1])
    found = basis(np.stack([0.6 * radius, -0.8 * radius, z], axis=1))
    assert abs(found - truth.reshape(len(basis), -1).T).max() < 1e-14
    assert truth.max() > 0.3


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: emitree.Voxels([[0, 0]], [[0, 1]]), "number 0 are .*: expected lower < upper"),
        (lambda: emitree.Voxels([[0, 0]], [[1, 1, 1]]), "expected the same"),
        (lambda: emitree.Voxels([0, 0], [1, 1]), r"`lower` has the shape \(2,\): expected \(k, 3\)"),
        (lambda: emitree.Voxels.grid([0, 1]), "expected 2 .* or 3"),
        (lambda: emitree.Voxels.grid([0, 1], [1, 0]), r"`edges\[1\]` .* ascending"),
        (lambda: emitree.Voxels.grid([0, 1], [0, 1], mask=[[1]]), "expected .* and bool"),
        (lambda: emitree.RadialFunctions([[0, np.nan]], 1), "`centers` .* finite"),
        (lambda: emitree.RadialFunctions([[0, 0]], 0), "`width` is 0: expected lengths above 0"),
        (lambda: emitree.RadialFunctions([[0, 0]], [1, 2]), "`width` has the shape"),
        (lambda: emitree.RadialFunctions([[0, 0]], 1, "cubic"), "`kind` is 'cubic'"),
        (lambda: emitree.RadialFunctions([[0, 0]], 1, cutoff=-1), "`cutoff` is -1"),
        (lambda: emitree.BSplines([[0, 1, 2]]), "`knots` has 1 axes"),
        (lambda: emitree.BSplines([[0, 1], [0, 1, 2]], 1), r"`knots\[0\]` .* expected 3 or more"),
        (lambda: emitree.BSplines([[0, 1, 2], [0, 0, 0]], 1), r"`knots\[1\]` has a knot more than 2"),
        (lambda: emitree.BSplines([[0, 1, 2], [0, 1, 2]], 0), "`degree` is 0"),
    ],
)  # fmt: skip
def test_wrong_bases(make, message):
    with pytest.raises(emitree.SceneError, match=message):
        make()


def test_wrong_arguments():
    voxel, camera = emitree.Voxels([[2, -1]], [[3, 1]]), CAMERAS[0]

    def refused(message, *arguments, **keywords):
        with pytest.raises(emitree.SceneError, match=message):
            emitree.sensitivity(*arguments, **keywords)

    refused("`tolerance` is 0", voxel, camera, SHAPE, 0)
    refused("`basis` is 'x'", "x", camera, SHAPE)
    refused(r"`basis` is \[\]", [], camera, SHAPE)
    refused("`cameras` is", voxel, [camera, None], SHAPE)
    refused("`shape` has 2 shapes: expected one, or 3", voxel, CAMERAS, [SHAPE, SHAPE])
    refused("`shape` is", voxel, camera, 4)
    refused("`threads` is", voxel, camera, SHAPE, threads=0)
    endless = emitree.Perspective(
        position=(5, 0, 0), target=(0, 0, 0), field_of_view=(20, 20), far=np.inf
    )
    refused("lines of sight of camera 0 are infinite", lambda r, d: r[:, 0], endless, SHAPE)
    with pytest.raises(ValueError, match="the rates have the shape"):
        emitree.sensitivity(lambda r, d: np.ones((len(r), min(len(r), 2))), camera, SHAPE)
