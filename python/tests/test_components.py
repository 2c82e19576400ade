"""Emissions with several rates at each point."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import emitree

CUBE = emitree.Canonical()
CALLS: list[int] = []


def gaussian(position, sharpness, centre=0.5):
    return np.exp(-sharpness * ((position - centre) ** 2).sum(axis=1))


def trio(position, direction):
    """Two Gaussians about one place, and one about another."""
    CALLS.append(len(position))
    rates = [gaussian(position, 40.0), 3 * gaussian(position, 25.0), gaussian(position, 60.0, 0.4)]
    return np.stack(rates, axis=1)


def test_each_component_is_what_it_would_be_alone():
    CALLS.clear()
    found = emitree.render(trio, CUBE, (24, 32))
    assert isinstance(found, emitree.Components)
    assert len(found) == 3 and found.image.shape == found.error.shape == (3, 24, 32)
    assert found.converged and found.estimated_error < 0.01
    alone = [emitree.render(lambda r, d, c=c: trio(r, d)[:, c], CUBE, (24, 32)) for c in range(3)]
    for component, rendering in zip(found, alone, strict=True):
        np.testing.assert_array_equal(component.image, rendering.image)
        assert component.evaluations == rendering.evaluations
    # Points that several components need are evaluated once.
    assert found.evaluations < sum(rendering.evaluations for rendering in alone)


def test_every_evaluation_is_counted_once():
    CALLS.clear()
    found = emitree.render(trio, CUBE, (24, 32))
    assert sum(CALLS) == found.evaluations
    seen = set()

    def watched(position, direction):
        keys = {row.tobytes() for row in position}
        assert not keys & seen and len(keys) == len(position)
        seen.update(keys)
        return trio(position, direction)

    assert emitree.render(watched, CUBE, (24, 32)).evaluations == len(seen)


def test_components_with_energies_and_workers():
    def pair(position, direction, energy):
        rate = gaussian(position, 40.0) * np.exp(-energy)
        return np.stack([rate, 2 * rate], axis=1)

    energy = emitree.Energies(min=1, max=3, bins=4, unit="keV")
    with ThreadPoolExecutor(2) as executor:
        found = emitree.render(pair, CUBE, (8, 8), energy=energy, executor=executor)
    assert found.image.shape == (2, 4, 8, 8)
    np.testing.assert_allclose(found.image[1], 2 * found.image[0], rtol=1e-9)
    # The second one needs the same points.
    assert found.evaluations <= found[0].evaluations


def test_a_single_column_is_a_component():
    found = emitree.render(lambda r, d: gaussian(r, 40.0)[:, np.newaxis], CUBE, (8, 8))
    assert found.image.shape == (1, 8, 8)


def test_shapes_that_change_and_what_takes_one_rate_are_refused():
    def changing(position, direction):
        CALLS.append(1)
        return np.ones((len(position), len(CALLS)))

    CALLS.clear()
    with pytest.raises(
        ValueError, match=r"the rates have the shape \(\d+, 2\): expected \(\d+, 1\)"
    ):
        emitree.render(changing, CUBE, (8, 8), method="los", batch_size=100)
    with pytest.raises(ValueError, match=r"the rates have the shape \(\d+, 3\): expected \(\d+,\)"):
        emitree.render(trio, CUBE, (8, 8), frame=print)
    with pytest.raises(ValueError, match=r"expected \(\d+,\)"):
        emitree.build_tree(trio, "tree.fits", emitree.Box(min=(0, 0, 0), max=(1, 1, 1)))


def test_models_with_components_are_refused():
    def model(width):
        return trio

    with pytest.raises(ValueError, match="the model has 3 rates at each point: expected one"):
        emitree.jacobian(model, [1.0], CUBE, (8, 8))
    with pytest.raises(ValueError, match="the model has 3 rates at each point: expected one"):
        emitree.Forward(model, CUBE, (8, 8))([1.0])
    with pytest.raises(ValueError, match=r"the rates have the shape .* expected"):
        emitree.sweep(model, {"width": [1.0]}, CUBE, (8, 8))


def test_formulas_by_name_are_components():
    total = emitree.Expression("h * exp(-40 * ((x - 0.5)^2 + (y - 0.5)^2 + (z - 0.5)^2))", {"h": 2})
    polarised = "0.5 * y * exp(-40 * ((x - 0.5)^2 + (y - 0.5)^2 + (z - 0.5)^2))"
    found = emitree.render({"total": total, "polarised": polarised}, CUBE, (24, 32))
    assert found.names == ("total", "polarised") and found.converged
    np.testing.assert_array_equal(found["polarised"].image, found[1].image)
    for name, alone in (("total", total), ("polarised", polarised)):
        np.testing.assert_allclose(
            found[name].image, emitree.render(alone, CUBE, (24, 32)).image, rtol=1e-9, atol=1e-12
        )
    assert found.evaluations < sum(component.evaluations for component in found)
    with pytest.raises(KeyError, match="no component 'pol': expected total, polarised"):
        found["pol"]
    plan = found["total"].plan
    assert plan.apply(np.ones((len(plan.points.position), 2))).shape == (2, 24, 32)


def test_formulas_and_functions_in_a_list_with_energies():
    energy = emitree.Energies(min=1, max=3, bins=4, unit="keV")
    formula = "exp(-E) * exp(-40 * ((x - 0.5)^2 + (y - 0.5)^2 + (z - 0.5)^2))"

    def function(position, direction, energy):
        return gaussian(position, 40.0) * np.exp(-energy)

    found = emitree.render([formula, function], CUBE, (8, 8), energy=energy)
    assert found.image.shape == (2, 4, 8, 8) and found.names is None
    np.testing.assert_allclose(found[0].image, found[1].image, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("emissions", "reason"),
    [
        ([], "the emission is empty: expected at least one"),
        (
            {"a": "x", "b": 3},
            "emission 'b' is int: expected a formula, an `Expression`, a `Model`, a `Grid` or a function",
        ),
        (["x", "x +"], "`expression`: "),
        (["x", "E"], "has the energy `E`, and there are no energies"),
    ],
)
def test_wrong_lists_of_emissions_are_named(emissions, reason):
    with pytest.raises(emitree.SceneError, match=reason):
        emitree.render(emissions, CUBE, (4, 4))
