"""Datasets of PyVista and VTK: grids, tetrahedra and other cells."""

import pickle
import sys

import numpy as np
import pytest

import emitree

pyvista = pytest.importorskip("pyvista")
spatial = pytest.importorskip("scipy.spatial")


def hexahedra(count=7):
    """A ball of hexahedra: cubes within each other become spheres within each other."""
    axis = np.linspace(-1, 1, count)
    mesh = pyvista.StructuredGrid(*np.meshgrid(axis, axis, axis, indexing="ij"))
    points = np.array(mesh.points, dtype=np.float64)
    length = np.linalg.norm(points, axis=1)
    points *= (np.abs(points).max(axis=1) / np.where(length > 0, length, 1))[:, None]
    mesh.points = points
    return mesh


def tetrahedra(inner=150, outer=150):
    """A ball of tetrahedra, from one triangulation of points in a ball and on its surface."""
    rng = np.random.default_rng(7)
    direction = rng.normal(size=(inner + outer, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    radius = np.concatenate([0.95 * rng.random(inner) ** (1 / 3), np.ones(outer)])
    points = radius[:, None] * direction
    corners = spatial.Delaunay(points).simplices
    cells = np.column_stack([np.full(len(corners), 4), corners])
    mesh = pyvista.UnstructuredGrid(cells, np.full(len(corners), pyvista.CellType.TETRA), points)
    mesh["rate"] = linear(mesh.points)
    return mesh


def linear(position):
    return 4 + np.asarray(position, dtype=np.float64) @ [1.0, 2.0, -0.5]


def corners(mesh):
    return np.asarray(mesh.points, dtype=np.float64)[mesh.cells.reshape(-1, 5)[:, 1:]]


def exact_image(mesh, edge, count, order):
    """Means over pixels of integrals along x, of order^2 lines in each.

    The integral of a linear field through a tetrahedron is the chord times the value at its middle.
    """
    axis = (np.arange(count * order) + 0.5) * edge / (count * order) - edge / 2
    sums = np.zeros((len(axis), len(axis)))
    for corner in corners(mesh):
        low, high = corner.min(axis=0), corner.max(axis=0)
        columns = np.flatnonzero((low[1] <= axis) & (axis <= high[1]))
        rows = np.flatnonzero((low[2] <= axis) & (axis <= high[2]))
        z, y = np.meshgrid(axis[rows], axis[columns], indexing="ij")
        start, end = np.full(z.shape, -np.inf), np.full(z.shape, np.inf)
        for opposite in range(4):
            a, b, c = np.delete(corner, opposite, axis=0)
            normal = np.cross(b - a, c - a)
            normal *= np.sign(normal @ (corner[opposite] - a))
            # Inside, normal . (r - a) >= 0; no face is along x.
            root = a[0] - (normal[1] * (y - a[1]) + normal[2] * (z - a[2])) / normal[0]
            if normal[0] > 0:
                start = np.maximum(start, root)
            else:
                end = np.minimum(end, root)
        chord = np.maximum(end - start, 0)
        middle = np.stack([np.where(chord > 0, 0.5 * (start + end), 0), y, z], axis=-1)
        sums[np.ix_(rows, columns)] += chord * linear(middle)
    return sums.reshape(count, order, count, order).mean(axis=(1, 3))


CAMERA = emitree.Orthographic(position=(9, 0, 0), target=(0, 0, 0), extent=(2.2, 2.2))


def test_an_image_of_tetrahedra_is_the_exact_integral_through_them():
    mesh = tetrahedra(40, 60)
    emission = emitree.from_pyvista(mesh, "rate")
    rendering = emitree.render(emission, CAMERA, (8, 8), tolerance=0.01)
    exact = exact_image(mesh, 2.2, 8, 60)
    largest = exact.max()
    assert np.abs(exact - exact_image(mesh, 2.2, 8, 47)).max() < 1e-3 * largest
    assert rendering.converged
    assert np.abs(rendering.image - exact).max() < 0.01 * largest


def test_the_surface_of_tetrahedra_is_exact():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    mesh = pyvista.UnstructuredGrid([4, 0, 1, 2, 3], [pyvista.CellType.TETRA], points)
    mesh["rate"] = linear(points)
    at = np.random.default_rng(0).uniform(-0.1, 1.1, (20000, 3))
    is_inside = (at > 0).all(axis=1) & (at.sum(axis=1) < 1)
    expected = np.where(is_inside, linear(at), 0)
    np.testing.assert_allclose(emitree.from_pyvista(mesh)(at), expected, rtol=1e-12)


@pytest.mark.parametrize("kind", ["tetrahedra", "hexahedra"])
def test_point_data_are_interpolated_within_cells(kind):
    mesh = tetrahedra() if kind == "tetrahedra" else hexahedra()
    mesh["rate"] = linear(mesh.points)
    emission = emitree.from_pyvista(mesh, "rate")
    points = np.random.default_rng(1).uniform(-0.5, 0.5, (4000, 3))
    np.testing.assert_allclose(emission(points), linear(points), rtol=1e-6)
    outside = points / np.linalg.norm(points, axis=1)[:, None] * 1.01
    assert not emission(outside).any()
    assert emission(np.empty((0, 3))).shape == (0,)
    again = pickle.loads(pickle.dumps(emission))
    assert np.array_equal(again(points), emission(points))


def test_cells_of_a_ball_of_hexahedra_are_an_image():
    """Data of cells and of points in the same mesh: the same image, up to the size of the cells."""
    mesh = hexahedra(17)
    mesh["rate"] = linear(mesh.points)
    mesh.cell_data["of cells"] = linear(mesh.cell_centers().points)
    mesh.cell_data["one"] = np.ones(mesh.n_cells)
    ball = emitree.Sphere(center=(0, 0, 0), radius=1)
    images = {
        name: emitree.render(
            emitree.from_pyvista(mesh, name), CAMERA, (8, 8), tolerance=0.01, edges=[ball]
        )
        for name in ("rate", "of cells", "one")
    }
    assert all(found.converged for found in images.values())
    # Chords of the unit sphere, and of the linear rate, whose mean along a chord is at its middle.
    axis = (np.arange(8 * 40) + 0.5) * 2.2 / (8 * 40) - 1.1
    z, y = np.meshgrid(axis, axis, indexing="ij")
    chord = 2 * np.sqrt(np.maximum(1 - y**2 - z**2, 0))
    middle = linear(np.stack([np.zeros_like(y), y, z], axis=-1))
    exact = {"rate": chord * middle, "of cells": chord * middle, "one": chord}
    for name, found in images.items():
        truth = exact[name].reshape(8, 40, 8, 40).mean(axis=(1, 3))
        # Flat faces cut off 0.6 % of the ball, and constant cells are a third order of theirs.
        assert np.abs(found.image - truth).max() < 0.025 * truth.max(), name


@pytest.mark.parametrize("ending", [".vtu", ".vtk"])
def test_files_are_read(tmp_path, ending):
    path = tmp_path / f"mesh{ending}"
    mesh = tetrahedra()
    mesh.cell_data["number"] = np.arange(mesh.n_cells)
    mesh.save(path)
    at = np.random.default_rng(1).uniform(-0.5, 0.5, (500, 3))
    for given in (path, str(path)):
        np.testing.assert_allclose(emitree.from_pyvista(given, "rate")(at), linear(at), rtol=1e-9)
    expected = emitree.from_pyvista(mesh, "number")(at)
    assert np.array_equal(emitree.from_pyvista(path, "number")(at), expected)


@pytest.mark.parametrize("ending", [".vti", ".vtr"])
def test_grids_in_xml_are_read_by_both(tmp_path, ending):
    path = tmp_path / f"grid{ending}"
    data = pyvista.ImageData(dimensions=(5, 4, 3), spacing=(0.25, 1 / 3, 0.5))
    data["rate"] = np.random.default_rng(0).uniform(1, 2, data.n_points)
    data.cell_data["of cells"] = np.arange(data.n_cells)
    data = data if ending == ".vti" else data.cast_to_rectilinear_grid()
    data.save(path)
    ours = emitree.Grid(file=path, variable="rate")
    theirs = emitree.from_pyvista(path, "rate")
    images = [emitree.render(grid, emitree.Canonical(), (4, 4)).image for grid in (ours, theirs)]
    np.testing.assert_allclose(*images, rtol=1e-12)
    cells = emitree.Grid(file=path, variable="of cells", interpolation="nearest")
    values = emitree.Fields({"g": cells}, "g").values(np.array([[0.375, 0.5, 0.75]]))
    assert values["g"] == [1 + 4 * 1 + 12 * 1]


def test_files_that_are_none_are_named(tmp_path):
    with pytest.raises(emitree.SceneError, match="which is no file: expected one of VTK"):
        emitree.from_pyvista(tmp_path / "none.vtu")
    path = tmp_path / "cut.vtu"
    tetrahedra().save(path)
    path.write_bytes(path.read_bytes()[:500])
    with pytest.raises(
        emitree.SceneError, match=r"cut\.vtu': expected one that PyVista reads, such"
    ):
        emitree.from_pyvista(path)
    with pytest.raises(
        emitree.SceneError,
        match=r"its dataset is UnstructuredGrid: expected .*`emitree.from_pyvista`",
    ):
        path = tmp_path / "mesh.vtu"
        tetrahedra().save(path)
        emitree.render(emitree.Grid(file=path), emitree.Canonical(), (2, 2))


def test_the_mesh_may_change_afterwards():
    mesh = tetrahedra()
    emission = emitree.from_pyvista(mesh)
    before = emission(np.zeros((1, 3)))
    mesh["rate"] *= 2
    mesh.points *= 10
    assert np.array_equal(emission(np.zeros((1, 3))), before)


@pytest.mark.parametrize("name", ["WEDGE", "PYRAMID"])
def test_other_cells_are_split_into_tetrahedra(name):
    corner = {
        "WEDGE": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]],
        "PYRAMID": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1]],
    }[name]
    mesh = pyvista.UnstructuredGrid(
        [len(corner), *range(len(corner))],
        [getattr(pyvista.CellType, name)],
        np.array(corner, dtype=float),
    )
    mesh["rate"] = linear(mesh.points)
    at = np.random.default_rng(0).uniform(-0.1, 1.1, (5000, 3))
    x, y, z = at.T
    is_inside = (at > 0).all(axis=1) & (z < 1)
    is_inside &= (x + y < 1) if name == "WEDGE" else (x < 1 - z) & (y < 1 - z)
    expected = np.where(is_inside, linear(at), 0)
    np.testing.assert_allclose(emitree.from_pyvista(mesh)(at), expected, rtol=1e-12)
    mesh.cell_data["constant"] = [2.0]
    assert np.array_equal(emitree.from_pyvista(mesh, "constant")(at), 2.0 * is_inside)


def test_cell_data_are_constant_in_each_cell():
    image = pyvista.ImageData(dimensions=(3, 2, 2))
    image.cell_data["rate"] = [1.0, 3.0]
    emission = emitree.from_pyvista(image, "rate")
    points = [[0.01, 0.5, 0.5], [0.99, 0.9, 0.1], [1.01, 0.5, 0.5], [2.1, 0.5, 0.5]]
    assert emission(points).tolist() == [1, 1, 3, 0]
    # Of tetrahedra: the field at the centre of the cell that VTK finds for a point.
    mesh = tetrahedra()
    mesh.cell_data["number"] = np.arange(mesh.n_cells)
    points = corners(mesh).mean(axis=1)
    found = emitree.from_pyvista(mesh, "number")(points)
    assert np.array_equal(found, np.arange(mesh.n_cells))


@pytest.mark.parametrize("is_uniform", [True, False])
def test_grids_become_grids(is_uniform):
    x, y, z = np.array([0, 0.5, 1.0]), np.array([0, 1.0]), np.array([0, 0.25, 0.5, 0.75, 1.0])
    if is_uniform:
        data = pyvista.ImageData(dimensions=(3, 2, 5), spacing=(0.5, 1, 0.25))
    else:
        x[1] = 0.3
        data = pyvista.RectilinearGrid(x, y, z)
    data["rate"] = np.random.default_rng(0).uniform(1, 2, data.n_points)
    emission = emitree.from_pyvista(data, "rate")
    assert isinstance(emission, emitree.Grid)
    cube = np.array(data["rate"]).reshape(5, 2, 3).transpose(2, 1, 0)
    expected = emitree.Grid(values=cube, x=x, y=y, z=z)
    images = [
        emitree.render(grid, emitree.Canonical(), (4, 4)).image for grid in (emission, expected)
    ]
    assert np.array_equal(*images)


def test_turned_images_are_located():
    data = pyvista.ImageData(dimensions=(3, 3, 3))
    data["rate"] = np.arange(27.0)
    at = np.array([[0.5, 1.5, 1.0]])
    straight = data.sample(pyvista.ImageData(dimensions=(3, 3, 3)))["rate"]
    assert len(straight) == 27
    data.direction_matrix = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    emission = emitree.from_pyvista(data)
    # (x, y) of the data is at (-y, x); the rate is x + 3 y + 9 z.
    turned = np.column_stack([-at[:, 1], at[:, 0], at[:, 2]])
    np.testing.assert_allclose(emission(turned), at @ [1, 3, 9], rtol=1e-9)


def test_cells_without_a_volume_are_left_out():
    mesh = tetrahedra()
    surface = mesh.extract_surface(algorithm="dataset_surface")
    both = mesh.merge(surface, merge_points=False)
    emission = emitree.from_pyvista(both, "rate")
    points = np.random.default_rng(1).uniform(-0.5, 0.5, (100, 3))
    np.testing.assert_allclose(emission(points), linear(points), rtol=1e-6)
    with pytest.raises(emitree.SceneError, match=r"PolyData of \d+ cells without a volume"):
        emitree.from_pyvista(surface, "rate")


def test_the_box_around_a_mesh_is_the_bounds():
    emission = emitree.from_pyvista(tetrahedra())
    position = tetrahedra().points
    np.testing.assert_allclose(emission.bounds.min, position.min(axis=0), atol=1e-6)
    np.testing.assert_allclose(emission.bounds.max, position.max(axis=0), atol=1e-6)


def test_wrong_fields_are_named():
    mesh = tetrahedra()
    mesh["vector"] = np.zeros((mesh.n_points, 3))
    for field, message in [
        (
            "speed",
            "`field` is 'speed': expected one of the arrays .of points rate, vector; of cells none.",
        ),
        ("vector", r"`field` 'vector' has the shape \(\d+, 3\)"),
        (None, "`field` is not given: expected one of the arrays"),
    ]:
        with pytest.raises(emitree.SceneError, match=message):
            emitree.from_pyvista(mesh, field)
    mesh.cell_data["rate"] = np.ones(mesh.n_cells)
    with pytest.raises(emitree.SceneError, match="an array of points and one of cells"):
        emitree.from_pyvista(mesh, "rate")
    assert emitree.from_pyvista(mesh, "rate", association="cell")([[0, 0, 0.1]]).tolist() == [1]
    with pytest.raises(emitree.SceneError, match="`association` is 'face'"):
        emitree.from_pyvista(mesh, "rate", association="face")
    mesh.point_data["rate"][3] = np.nan
    with pytest.raises(emitree.SceneError, match="`field` 'rate' is nan at point 3"):
        emitree.from_pyvista(mesh, "rate", association="point")


@pytest.mark.parametrize("dataset", [3, np.zeros((4, 3)), None])
def test_other_things_are_refused(dataset):
    with pytest.raises(emitree.SceneError, match="expected a dataset of PyVista or VTK"):
        emitree.from_pyvista(dataset, "rate")


def test_blocks_are_refused():
    with pytest.raises(emitree.SceneError, match="MultiBlock of 1 blocks"):
        emitree.from_pyvista(pyvista.MultiBlock([tetrahedra()]), "rate")


def test_datasets_of_vtk_itself_are_taken():
    core = pytest.importorskip("vtkmodules.vtkCommonDataModel")
    data = core.vtkUnstructuredGrid()
    data.ShallowCopy(tetrahedra())
    at = np.array([[0.1, 0.2, 0.3]])
    np.testing.assert_allclose(emitree.from_pyvista(data, "rate")(at), linear(at), rtol=1e-12)


def test_a_missing_pyvista_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(ImportError, match="expected it for `from_pyvista`"):
        emitree.from_pyvista(None, "rate")


def test_duplicated_points_do_not_separate_cells():
    mesh = tetrahedra()
    apart = corners(mesh).reshape(-1, 3)
    cells = np.column_stack([np.full(mesh.n_cells, 4), np.arange(len(apart)).reshape(-1, 4)])
    separate = pyvista.UnstructuredGrid(cells, mesh.celltypes, apart)
    separate["rate"] = linear(apart)
    at = np.random.default_rng(2).uniform(-0.5, 0.5, (20000, 3))
    np.testing.assert_allclose(emitree.from_pyvista(separate)(at), linear(at), rtol=1e-9)
