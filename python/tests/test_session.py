"""Sessions: the caller has the loop."""

import numpy as np
import pytest
from models import peak, perspective_in_km, spectral_peak

import emitree

CUBE = emitree.Canonical()


def told(session, rate=peak):
    """Answers all questions; the number of rates."""
    number = 0
    while points := session.ask():
        number += len(points)
        session.tell(rate(points.position, points.direction))
    return number


@pytest.mark.parametrize("method", ["vol", "paper", "los"])
def test_ask_and_tell_give_what_render_gives(method):
    at_once = emitree.render(peak, CUBE, (8, 12), method=method)
    session = emitree.Session(CUBE, (8, 12), method=method)
    number = told(session)
    rendering = session.rendering()
    assert np.array_equal(rendering.image, at_once.image)
    assert number == rendering.evaluations == at_once.evaluations
    assert rendering.converged and session.ask() is None


def test_a_session_goes_on_without_evaluating_a_point_again():
    session = emitree.Session(CUBE, (16, 16), tolerance=0.01)
    seen = set()
    for tolerance in (0.01, 1e-3, 1e-5):
        session.resume(tolerance=tolerance)
        while points := session.ask():
            new = {tuple(position) for position in points.position}
            assert len(new) == len(points) and not new & seen
            seen |= new
            session.tell(peak(points.position, points.direction))
        at_once = emitree.render(peak, CUBE, (16, 16), tolerance=tolerance)
        assert np.array_equal(session.rendering().image, at_once.image)
    assert session.rendering().evaluations == len(seen)
    session.resume((64, 64))
    assert session.ask() is None, "pixels are integrals of what is known"
    assert session.rendering().image.shape == (64, 64)


def test_a_cube_with_units():
    camera = perspective_in_km()
    options = {
        "energy": {"min": 1, "max": 3, "bins": 4, "unit": "keV"},
        "unit": "cm-3 s-1 sr-1 keV-1",
    }
    at_once = emitree.render(spectral_peak, camera, (6, 8), **options)
    session = emitree.Session(camera, (6, 8), **options)
    while points := session.ask():
        session.tell(spectral_peak(points.position, points.direction, points.energy))
    rendering = session.rendering()
    assert np.array_equal(rendering.image, at_once.image) and rendering.unit == at_once.unit


def test_intermediate_images():
    session = emitree.Session(CUBE, (16, 16), tolerance=1e-4)
    assert session.rendering() is None
    early = None
    while points := session.ask():
        early = early or session.rendering()
        session.tell(peak(points.position, points.direction))
    assert not early.converged and early.report["ending"] == "unfinished"
    assert early.estimated_error > session.rendering().estimated_error


def test_what_is_wrong_is_named():
    with pytest.raises(
        TypeError, match="unknown option `executor`: expected one of atol, base_level"
    ):
        emitree.Session(CUBE, (4, 4), executor=None)
    with pytest.raises(emitree.SceneError, match="`steps`"):
        emitree.Session(CUBE, (4, 4), steps=4)
    session = emitree.Session(CUBE, (4, 4))
    with pytest.raises(ValueError, match=r"the rates have the shape \(1,\): expected \(\d+,\)"):
        session.tell([1.0])
    with pytest.raises(TypeError, match="unknown option `energy`"):
        session.resume(energy=None)
    with pytest.raises(emitree.EmissionError, match="NaN"):
        session.tell(np.full(len(session.ask()), np.nan))
    told(session)
    assert session.rendering().converged, "what was refused left no trace"
    with pytest.raises(ValueError, match="expected none, as the session waits for no rates"):
        session.tell([])
    with pytest.raises(emitree.RenderError, match="max_evaluations"):
        session.resume(max_evaluations=10)
    assert session.rendering().converged, "a session that is not continued is as it was"
