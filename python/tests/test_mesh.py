"""Meshes: the frozen quadrature of a session."""

import numpy as np
import pytest
from models import peak, perspective_in_km, spectral_peak

import emitree

CUBE = emitree.Canonical()


def ended(camera, shape, rate=peak, **options):
    """A session run to its end."""
    session = emitree.Session(camera, shape, **options)
    while points := session.ask():
        arrays = (points.position, points.direction, points.energy)
        session.tell(rate(*(values for values in arrays if values is not None)))
    return session


@pytest.mark.parametrize("method", ["vol", "paper", "los"])
def test_a_mesh_gives_the_image_of_its_session(method):
    session = ended(CUBE, (8, 12), method=method)
    image = session.rendering().image
    mesh = session.mesh()
    rates = peak(mesh.points.position, mesh.points.direction)
    assert len(mesh) == len(rates) and mesh.points.energy is None
    np.testing.assert_allclose(mesh.apply(rates), image, rtol=1e-12)
    np.testing.assert_allclose(mesh.apply(2 * rates), 2 * image, rtol=1e-12)


def test_the_matrix_is_the_whole_map():
    mesh = ended(CUBE, (4, 6), method="los", steps=8).mesh()
    rates = peak(mesh.points.position, mesh.points.direction)
    matrix = mesh.matrix()
    assert matrix.shape == (24, len(mesh)) and mesh.weights.shape == (24, len(mesh))
    rows = np.repeat(np.arange(24), np.diff(matrix.indptr))
    image = np.bincount(rows, matrix.data * rates[matrix.indices], minlength=24)
    np.testing.assert_allclose(image.reshape(4, 6), mesh.apply(rates), rtol=1e-12)


def test_a_cube_with_units():
    camera = perspective_in_km()
    options = {
        "energy": {"min": 1, "max": 3, "bins": 4, "unit": "keV"},
        "unit": "cm-3 s-1 sr-1 keV-1",
        "quantity": "irradiance",
        "method": "los",
        "steps": 4,
    }
    session = ended(camera, (6, 8), spectral_peak, **options)
    mesh, cube = session.mesh(), session.rendering().image
    rates = spectral_peak(mesh.points.position, mesh.points.direction, mesh.points.energy)
    np.testing.assert_allclose(mesh.apply(rates), cube, rtol=1e-12)
    matrix = mesh.matrix()
    rows = np.repeat(np.arange(4 * 6 * 8), np.diff(matrix.indptr))
    found = np.bincount(rows, matrix.data * rates[matrix.indices])
    np.testing.assert_allclose(found.reshape(cube.shape), cube, rtol=1e-12)


def test_what_is_wrong_is_named():
    session = emitree.Session(CUBE, (4, 4))
    with pytest.raises(ValueError, match="no mesh before its rendering has ended"):
        session.mesh()
    mesh = ended(CUBE, (4, 4), method="los").mesh()
    with pytest.raises(ValueError, match=r"the rates have the shape \(1,\): expected \(\d+,\)"):
        mesh.apply([1.0])
