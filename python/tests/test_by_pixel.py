"""Errors by pixel: `rtol`, `atol`, `floor`, `weights`, `mask` and `per_band`."""

import numpy as np
import pytest

import emitree


def ball(position, direction):
    return np.exp(-60 * ((position - 0.5) ** 2).sum(axis=1))


def rendering(**options):
    return emitree.render(ball, emitree.Canonical(), (32, 32), **options)


def test_every_pixel_is_within_its_own_tolerance():
    found = rendering(rtol=0.01, floor=1e-3)
    fine = rendering(tolerance=1e-6)
    allowed = 0.01 * np.maximum(fine.image, 1e-3 * fine.image.max())
    # The reference has an error of 1e-6 of the largest pixel, a tenth of the smallest error allowed.
    assert (np.abs(found.image - fine.image) < 1.1 * allowed).all()
    assert found.converged and found.error_over_allowed <= 1
    report = found.report
    assert (report["rtol"], report["floor"], report["tolerance"]) == (0.01, 1e-3, None)


def test_weights_and_masks_are_arrays_or_files(tmp_path):
    weights = np.ones((32, 32))
    weights[:, :16] = 0
    np.save(tmp_path / "weights.npy", weights)
    array = rendering(weights=weights)
    file = rendering(mask=tmp_path / "weights.npy")
    assert array.report["weighted"] and file.report["weighted"]
    assert (array.image == file.image).all()


def test_an_absolute_tolerance_may_be_a_quantity():
    units = pytest.importorskip("astropy.units")
    camera = emitree.Canonical(length_unit="cm")
    found = emitree.render(
        ball, camera, (16, 16), unit="cm-3", image_unit="cm-2", atol=10 / units.m**2
    )
    assert found.report["atol"] == pytest.approx(1e-3)
    with pytest.raises(emitree.SceneError, match="`image_unit` too"):
        rendering(atol=10 / units.m**2)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"rtol": 2}, "`render.rtol` is 2"),
        ({"rtol": 0.1, "tolerance": 0.1}, "both `tolerance` and `rtol`"),
        ({"weights": np.ones((3, 4))}, "expected 32 rows of 32 pixels"),
        ({"weights": "many"}, "`render.weights`"),
        ({"per_band": True}, "energy axis"),
        ({"rtol": 0.1, "method": "paper"}, "`rtol` is given, and method `paper`"),
    ],
)
def test_what_can_not_be_is_refused(options, message):
    with pytest.raises(emitree.SceneError, match=message):
        rendering(**options)
