"""Counts of an instrument."""

import numpy as np
import pytest

import emitree

UNIT = "ph cm-3 s-1 sr-1 keV-1"
CAMERA = emitree.Perspective(
    position=(-10, 0, 0),
    target=(0, 0, 0),
    field_of_view=(1, 1),
    near=9,
    far=11,
    length_unit="cm",
)
ENERGY = {"min": 0.5, "max": 1.5, "bins": 4, "unit": "keV"}
INSTRUMENT = {
    "effective_area": 50.0,
    "exposure": 1e9,
    "psf": {"fwhm_pixels": 1.5},
    "background": {"per_pixel": 1e-8},
    "seed": 3,
}


def flat(position, direction, energy):
    return np.ones(len(position))


@pytest.fixture(scope="module")
def rendering():
    return emitree.render(flat, CAMERA, (6, 8), energy=ENERGY, unit=UNIT, instrument=INSTRUMENT)


def test_the_expected_counts_are_those_of_the_closed_form(rendering):
    half = np.tan(np.radians(0.5))
    solid_angle = 4 * np.arcsin(half**2 / (1 + half**2))
    steps = rendering.count_steps()
    # 1 photon cm-3 s-1 sr-1 keV-1 over 2 cm, 1 keV, 1e9 s and 50 cm2; the paths of a pinhole are
    # longer off the axis by no more than 4e-5.
    assert list(steps) == ["photons", "area", "psf", "background"]
    assert steps["area"]["after"] == pytest.approx(2 * solid_angle * 1e9 * 50, rel=1e-4)
    for sums in steps.values():
        balance = sums["before"] + sums["added"] - sums["lost"] - sums["after"]
        assert abs(balance) <= 1e-11 * sums["after"]
    expected = rendering.expected_counts()
    assert expected.shape == (4, 6, 8)
    assert expected.sum() == pytest.approx(list(steps.values())[-1]["after"])


def test_counts_are_drawn_by_seed(rendering):
    counts = rendering.draw_counts()
    assert np.array_equal(counts, rendering.draw_counts(3))
    assert not np.array_equal(counts, rendering.draw_counts(4))
    assert np.array_equal(counts, np.round(counts))
    expected = rendering.expected_counts().sum()
    assert abs(counts.sum() - expected) < 5 * np.sqrt(expected)


def test_without_an_instrument_nothing_counts():
    rendering = emitree.render("1", emitree.Canonical(), (2, 2))
    with pytest.raises(ValueError, match="nothing counts photons: expected `instrument`"):
        rendering.expected_counts()


def test_wrong_instruments_are_refused():
    with pytest.raises(emitree.SceneError, match=r"instrument\.exposure"):
        emitree.render(
            flat, CAMERA, (2, 2), energy=ENERGY, unit=UNIT, instrument={"effective_area": 1.0}
        )
