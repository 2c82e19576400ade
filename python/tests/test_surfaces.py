"""Found surfaces: arrays, units, files, pickles."""

import copy
import pickle

import numpy as np
import pytest
from models import peak, spectral

import emitree

CENTER = np.array([0.1, -0.05, 0.03])
CAMERA = emitree.Perspective(
    position=(10, 2, 1), target=(0.1, 0, 0), field_of_view=(20, 20), near=7, far=13,
    length_unit="km",
)  # fmt: skip


def ball(position, direction):
    """2 in a ball of radius 1.2, 0.5 around it."""
    return np.where(np.linalg.norm(position - CENTER, axis=1) < 1.2, 2.0, 0.5)


@pytest.fixture(scope="module")
def rendering():
    return emitree.render(ball, CAMERA, (40, 40), unit="ph cm-3 s-1 sr-1")


@pytest.fixture(scope="module")
def surfaces(rendering):
    return rendering.surfaces


def test_arrays_and_units(rendering, surfaces):
    n, m = len(surfaces), len(surfaces.triangles)
    assert n > 1000 and m > n
    assert surfaces.position.shape == surfaces.normal.shape == (n, 3)
    assert surfaces.jump.shape == surfaces.uncertainty.shape == (n,)
    assert surfaces.triangles.shape == (m, 3) and surfaces.triangles.dtype == np.int64
    assert surfaces.triangles.min() == 0 and surfaces.triangles.max() < n
    assert (surfaces.length_unit, surfaces.jump_unit) == ("km", "ph cm-3 s-1 sr-1")
    assert repr(surfaces) == f"<emitree.Surfaces in km: {n} vertices, {m} triangles>"
    assert rendering.surfaces is surfaces


def test_the_surface_is_that_of_the_ball(surfaces):
    outward = surfaces.position - CENTER
    radius = np.linalg.norm(outward, axis=1)
    off = abs(radius - 1.2)
    assert off.max() < 0.02 and np.mean(off < 2 * surfaces.uncertainty) > 0.9
    np.testing.assert_allclose(surfaces.jump, 1.5, rtol=1e-4)
    # The larger rate is inside, and triangles turn that way.
    cosine = -(surfaces.normal * outward).sum(axis=1) / radius
    assert cosine.min() > 0.9
    corners = surfaces.position[surfaces.triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert ((across * surfaces.normal[surfaces.triangles[:, 0]]).sum(axis=1) > 0).all()
    area = 0.5 * np.linalg.norm(across, axis=1).sum()
    assert area == pytest.approx(4 * np.pi * 1.2**2, rel=0.01)


@pytest.mark.parametrize("options", [{}, {"method": "los", "steps": 8}, {"method": "paper"}])
def test_there_may_be_none(options):
    assert emitree.render(peak, emitree.Canonical(), (4, 4), **options).surfaces is None


def test_a_cube_has_none():
    bins = emitree.Energies(1, 2, 2)
    cube = emitree.render(spectral, emitree.Canonical(), (2, 2), energy=bins)
    assert cube.surfaces is None


def test_a_session_has_them_when_it_ends(surfaces):
    session = emitree.Session(CAMERA, (40, 40), unit="ph cm-3 s-1 sr-1")
    while (points := session.ask()) is not None:
        session.tell(ball(points.position, points.direction))
    assert np.array_equal(session.rendering().surfaces.position, surfaces.position)


@pytest.mark.parametrize("way", [lambda it: pickle.loads(pickle.dumps(it)), copy.deepcopy])
def test_pickles(rendering, surfaces, way, tmp_path):
    for other in (way(rendering).surfaces, way(surfaces)):
        for name in ("position", "normal", "jump", "uncertainty", "triangles"):
            assert np.array_equal(getattr(other, name), getattr(surfaces, name)), name
        assert repr(other) == repr(surfaces)
    way(rendering).surfaces.write(tmp_path / "other.npz")
    surfaces.write(tmp_path / "surfaces.npz")
    assert (tmp_path / "other.npz").read_bytes() == (tmp_path / "surfaces.npz").read_bytes()


def test_npz(surfaces, tmp_path):
    path = tmp_path / "ball.npz"
    surfaces.write(path)
    with np.load(path) as file:
        for name in ("position", "normal", "jump", "uncertainty", "triangles"):
            assert np.array_equal(file[name], getattr(surfaces, name)), name
        assert str(file["length_unit"]) == "km" and str(file["version"]) == emitree.__version__
        assert str(file["jump_unit"]) == "ph cm-3 s-1 sr-1" and file["scene"].shape == ()
    with pytest.raises(FileExistsError):
        surfaces.write(path)
    surfaces.write(path, overwrite=True)
    assert [file.name for file in tmp_path.iterdir()] == ["ball.npz"]


def test_vtp(surfaces, tmp_path):
    pyvista = pytest.importorskip("pyvista")
    surfaces.write(tmp_path / "ball.vtp")
    read = pyvista.read(tmp_path / "ball.vtp")
    assert np.array_equal(read.points, surfaces.position)
    assert np.array_equal(read.faces.reshape(-1, 4)[:, 1:], surfaces.triangles)
    for name in ("normal", "jump", "uncertainty"):
        assert np.array_equal(read.point_data[name], getattr(surfaces, name)), name
    assert list(read.field_data["length_unit"]) == ["km"] and read.n_open_edges == 0


def test_unknown_endings_are_errors(surfaces, tmp_path):
    path = tmp_path / "ball.stl"
    with pytest.raises(ValueError, match=r"ball.stl`: no format for this ending: expected .vtp or"):
        surfaces.write(path)
    assert not path.exists()
