"""Images against closed forms, for every kind of emission and camera, and what is refused."""

import tomllib

import numpy as np
import pytest
from models import exact_peak, peak, spectral

import emitree

FORMULA = "exp(-40 * ((x-0.5)^2 + (y-0.5)^2 + (z-0.5)^2))"
CUBE = emitree.Canonical()


def error_of(rendering, exact):
    return np.abs(rendering.image - exact).max() / exact.max()


@pytest.mark.parametrize("tolerance", [0.1, 0.01, 0.001])
def test_the_tolerance_is_kept_by_functions(tolerance):
    rendering = emitree.render(peak, CUBE, (24, 32), tolerance=tolerance)
    assert rendering.converged and rendering.estimated_error < tolerance
    assert error_of(rendering, exact_peak(24, 32)) < tolerance
    assert rendering.image.shape == rendering.error.shape == (24, 32)


def test_a_function_costs_what_a_formula_does():
    ours = emitree.render(peak, CUBE, (24, 32), tolerance=0.001)
    theirs = emitree.render(FORMULA, CUBE, (24, 32), tolerance=0.001)
    assert ours.evaluations == theirs.evaluations
    np.testing.assert_allclose(ours.image, theirs.image, rtol=0, atol=1e-15)
    assert ours.evaluations_per_pixel.sum() == ours.evaluations
    assert ours.evaluations_of_pixels is ours.evaluations_per_pixel


@pytest.mark.parametrize("options", [
    {"method": "vol", "base_level": 4},
    {"method": "paper", "threshold": "0.1%", "order": 5},
    {"method": "los", "steps": 64, "lines": 4},
    {"method": "los", "tolerance": 1e-4, "lines": 4},
])  # fmt: skip
def test_all_methods(options):
    rendering = emitree.render(peak, CUBE, (16, 16), **options)
    assert error_of(rendering, exact_peak(16, 16)) < 0.02
    assert rendering.report["method"] == options["method"]
    assert (rendering.tree is None) == (options["method"] != "paper")


def test_row_0_is_the_lowest_y():
    image = emitree.render(lambda r, d: r[:, 1], CUBE, (4, 2)).image
    np.testing.assert_allclose(image, [[0.125] * 2, [0.375] * 2, [0.625] * 2, [0.875] * 2])


def test_directions_point_to_the_observer():
    camera = emitree.Orthographic(
        position=(0, -5, 0), target=(0, 0, 0), extent=(2, 2), near=0, far=10
    )
    image = emitree.render(lambda r, d: d[:, 1], camera, (3, 3)).image
    np.testing.assert_allclose(image, -10.0)


SKY = {"position": (3.0, 0.0, 0.0), "far": float("inf")}
LOOKING = SKY | {"target": (0.0, 0.0, 0.0), "up": (0.0, 0.0, 1.0), "near": 0.0}


@pytest.mark.parametrize("camera", [
    emitree.Orthographic(extent=(4, 3), **LOOKING),
    emitree.Perspective(field_of_view=(60, 40), **LOOKING),
    emitree.Equirectangular(field_of_view=(60, 40), **LOOKING),
    emitree.Polar(field_of_view=60, **LOOKING),
    emitree.Fisheye(field_of_view=60, mapping="equal_area", **LOOKING),
], ids=lambda camera: type(camera).__name__)  # fmt: skip
def test_all_cameras(camera):
    ours = emitree.render(lambda r, d: np.exp(-((r**2).sum(axis=1))), camera, (12, 16))
    theirs = emitree.render("exp(-r^2)", camera, (12, 16))
    # The last bits of g may choose other places to look at: both keep the tolerance.
    largest = np.nanmax(theirs.image)
    np.testing.assert_allclose(ours.image, theirs.image, rtol=0, atol=0.01 * largest)
    # Through the middle of the ball the integral is that of a Gaussian.
    assert np.nanmax(ours.image) == pytest.approx(np.sqrt(np.pi), rel=0.1)
    assert ours.wcs is not None


@pytest.mark.parametrize("shape", [4, (48, 4)])
def test_a_sky(shape):
    sky = emitree.render("exp(-r^2)", emitree.Healpix(**SKY), shape)
    assert sky.image.shape == (48, 4) and sky.wcs is None


def test_bounds_bodies_and_seeds():
    camera = emitree.Perspective(position=(9, 0, 0), target=(0, 0, 0), field_of_view=(20, 20))
    ball = emitree.Sphere(center=(0, 0, 0), radius=1)
    box = emitree.Box(min=(-2, -2, -2), max=(2, 2, 2))
    body = emitree.Ellipsoid(center=(0, 0, 0), semi_axes=(0.5, 0.5, 0.5))
    middle = (slice(15, 17), slice(15, 17))
    lens = emitree.render("1", camera, (32, 32), bounds=ball, seeds=[((0, 0, 0), 0.3)])
    assert lens.image[middle] == pytest.approx(2.0, abs=0.02)
    hidden = emitree.render("1", camera, (32, 32), bounds=box, occulters=[body])
    assert hidden.image[middle] == pytest.approx(1.5, abs=0.03)


def test_a_singular_point_is_in_a_pixel():
    def rate(position, _):
        return 1 / (position**2).sum(axis=1)

    camera = emitree.Orthographic(position=(9, 0, 0), target=(0, 0, 0), extent=(2, 2), far=18)
    centre = emitree.SingularPoint(position=(0, 0, 0))
    image = emitree.render(rate, camera, (31, 31), singularities=[centre]).image
    # The radiance at the distance b is 2 atan(9/b) / b; its mean over a square of half side h.
    h, (nodes, weights) = 1 / 31, np.polynomial.legendre.leggauss(40)
    phi = np.pi / 8 * (1 + nodes)
    edge = h / np.cos(phi)
    u = 0.5 * (1 + nodes)[:, None] * edge
    inner = (2 * np.arctan(9 / u) * 0.5 * weights[:, None]).sum(axis=0) * edge
    exact = 8 * (inner * np.pi / 8 * weights).sum() / (2 * h) ** 2
    assert image[15, 15] == pytest.approx(exact, rel=0.01)


EDGES = [
    emitree.Sphere(center=(0, 0, 0), radius=1),
    emitree.Ellipsoid(center=(0, 0, 1), semi_axes=(1, 2, 3), pole=(0, 1, 0)),
    emitree.Plane(position=(0, 0, 1), normal=(0, 0, 2)),
]


@pytest.mark.parametrize(("camera", "shape"), [
    (CUBE, (4, 4)),
    (emitree.Perspective(position=(9, 0, 0), target=(0, 0, 0), field_of_view=(20, 20), far=9),
     (4, 4)),
    (emitree.Healpix(**SKY), 2),
])  # fmt: skip
def test_edges_are_tables_of_the_scene(camera, shape):
    edged = emitree.render("exp(-r^2)", camera, shape, edges=EDGES)
    assert tomllib.loads(edged.scene)["edge"] == [
        {"type": "sphere", "center": [0, 0, 0], "radius": 1},
        {"type": "ellipsoid", "center": [0, 0, 1], "semi_axes": [1, 2, 3], "pole": [0, 1, 0]},
        {"type": "plane", "position": [0, 0, 1], "normal": [0, 0, 2]},
    ]
    plain = emitree.render("exp(-r^2)", camera, shape)
    assert "edge" not in tomllib.loads(plain.scene)
    np.testing.assert_allclose(edged.image, plain.image, rtol=0, atol=0.02 * plain.image.max())


def test_energies_make_a_cube():
    energy = {"min": 0.5, "max": 2.5, "bins": 4, "unit": "keV"}
    ours = emitree.render(spectral, CUBE, (8, 8), energy=energy, tolerance=1e-3)
    assert ours.image.shape == ours.error.shape == (4, 8, 8)
    np.testing.assert_allclose(ours.energies, [0.5, 1.0, 1.5, 2.0, 2.5])
    assert ours.energy_unit == "keV"
    spectrum = -np.diff(np.exp(-ours.energies)) / 0.5
    exact = spectrum[:, None, None] * exact_peak(8, 8)
    assert np.abs(ours.image - exact).max() < 1e-3 * exact.max()
    np.testing.assert_allclose(ours.flat_image, 0.5 * ours.image.sum(axis=0), rtol=1e-12)


def test_models_and_formulas_with_constants():
    camera = emitree.Equirectangular(
        position=(10, -30, 0), target=(6, 0, 0), field_of_view=(16, 27), near=0, far=80,
        length_unit="R_E",
    )  # fmt: skip
    smile = emitree.render(emitree.Model("cmem", density=5.0), camera, (10, 5), tolerance=0.1)
    assert smile.image.max() > 0 and smile.unit
    ramp = emitree.render(emitree.Expression("a * x", {"a": 8.0}), CUBE, (1, 2))
    np.testing.assert_allclose(ramp.image, [[2.0, 6.0]])


def test_grids_of_arrays_and_files(tmp_path):
    nodes = np.linspace(0, 1, 5)
    values = nodes[:, None, None] + 10 * nodes[:, None] + 0 * nodes
    grid = emitree.Grid(values=values, x=nodes, y=(0, 1), z=(0, 1))
    image = emitree.render(grid, CUBE, (2, 2)).image
    np.testing.assert_allclose(image, [[2.75, 3.25], [7.75, 8.25]])
    np.save(tmp_path / "values.npy", values)
    file = emitree.Grid(values=tmp_path / "values.npy", x=(0, 1), y=(0, 1), z=(0, 1))
    # A file has z, y, x by default.
    image = emitree.render(file, CUBE, (2, 2)).image
    np.testing.assert_allclose(image, [[3.0, 3.0], [8.0, 8.0]])


def test_trees_are_built_once_and_rendered_again(tmp_path):
    calls = []

    def counted(position, direction):
        calls.append(len(position))
        return peak(position, direction)

    box = emitree.Box(min=(0, 0, 0), max=(1, 1, 1))
    tree = emitree.build_tree(counted, tmp_path / "peak.fits", box, tolerance=1e-4)
    assert tree.report["evaluations"] == sum(calls) and tree.report["converged"]
    seen = emitree.render(emitree.Tree(tmp_path / "peak.fits"), CUBE, (16, 16), tolerance=1e-3)
    assert sum(calls) == tree.report["evaluations"]
    assert error_of(seen, exact_peak(16, 16)) < 2e-3


def test_scene_files(tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(
        f'emission.expression = "{FORMULA}"\nprojection.type = "canonical"\n'
        "image = { width = 32, height = 24 }\nrender.tolerance = 0.001\n"
    )
    direct = emitree.render(FORMULA, CUBE, (24, 32), tolerance=0.001)
    for name in (scene, str(scene)):
        assert np.array_equal(emitree.render(name).image, direct.image)
    changed = emitree.render(scene, None, (6, 8), method="los", changes={"render.lines": 2})
    assert changed.image.shape == (6, 8) and changed.report["method"] == "los"
    scene.write_text("emission.expression = 'x'\nprojection.type = 'kanonical'\n")
    with pytest.raises(emitree.SceneError, match=r"scene\.toml, line 2: unknown projection"):
        emitree.render(scene)


def test_a_budget_is_no_error():
    rendering = emitree.render(peak, CUBE, (64, 64), tolerance=1e-6, max_evaluations=2000)
    assert not rendering.converged and rendering.evaluations <= 2000
    assert "NOT CONVERGED" in repr(rendering)


@pytest.mark.parametrize(("arguments", "message"), [
    (dict(tolerance=2.0), "tolerance` is 2"),
    (dict(method="ray"), "unknown method `ray`: expected `vol`, `paper` or `los`"),
    (dict(shape=(0, 4)), "`image.height` is 0: expected a number of pixels, 1 to 2.24"),
    (dict(shape=4), r"`shape` is 4: expected \(height, width\)"),
    (dict(emission="exp("), "`emission.expression`"),
    (dict(emission=emitree.Model("cmen")), "cmem"),
    (dict(camera=emitree.Healpix(**SKY), shape=(4, 4)), r"expected nside, or \(12 nside, nside\)"),
    (dict(unit="ph cm-3 s-1"), "needs a length unit"),
    (dict(batch_size=0), "`batch_size` is 0"),
    (dict(energy={"min": 1, "max": 2}), "`energy.bins` is missing"),
    (dict(edges=[emitree.Plane(position=(0, 0, 0), normal=(0, 0, 0))]),
     r"`normal` is \[0.0, 0.0, 0.0\]: expected a finite vector that is not zero"),
    (dict(edges=[emitree.Box(min=(0, 0, 0), max=(1, 1, 1))]),
     "unknown edge `box`: expected `sphere`, `ellipsoid` or `plane`"),
    (dict(singularities=[emitree.SingularPoint(position=(0, 0, 0), exponent=3)]),
     "`exponent` is 3: expected a number from 0 to below 3"),
    (dict(singularities=[emitree.SingularAxis(position=(0, 0, 0), direction=(0, 0, 0))]),
     r"`direction` is \[0.0, 0.0, 0.0\]: expected a finite vector that is not zero"),
    (dict(occulters=[emitree.Plane(position=(0, 0, 0), normal=(0, 0, 1))]),
     "unknown body `plane`: expected `sphere` or `ellipsoid`"),
])  # fmt: skip
def test_what_is_wrong_is_named(arguments, message):
    arguments = {"emission": peak, "camera": CUBE, "shape": (4, 4)} | arguments
    with pytest.raises(emitree.SceneError, match=message):
        emitree.render(**arguments)


def test_what_does_not_go_together_is_refused():
    with pytest.raises(TypeError, match="expected a function"):
        emitree.render(3.0, CUBE, (4, 4))
    with pytest.raises(TypeError, match="expected a camera"):
        emitree.render(peak)
    with pytest.raises(TypeError, match="expected `shape`"):
        emitree.render(peak, CUBE)
    with pytest.raises(TypeError, match="`cache` is for functions"):
        emitree.render("x", CUBE, (4, 4), cache="folder")
    with pytest.raises(TypeError, match="`unit` is for a camera: the scene file has its own"):
        emitree.render("scene.toml", unit="R")
    with pytest.raises(TypeError, match="`edges` is for a camera: the scene file has its own"):
        emitree.render("scene.toml", edges=EDGES)
    with pytest.raises(TypeError, match="`changes` are for scene files"):
        emitree.render("x", CUBE, (4, 4), changes={})
