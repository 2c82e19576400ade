"""Media that absorb: functions, formulas and grids as absorption coefficients."""

import numpy as np
import pytest

import emitree

#: The image of a uniform cube with g = 3 and an optical depth of 2.
EXACT = 1.5 * (1 - np.exp(-2))


def uniform(position, direction):
    return np.full(len(position), 3.0)


def coefficient(position, direction):
    assert position.shape == direction.shape == (len(position), 3)
    return np.full(len(position), 2.0)


@pytest.mark.parametrize("method", ["vol", "paper", "los"])
@pytest.mark.parametrize("emission", [uniform, "3"])
@pytest.mark.parametrize("absorption", [coefficient, "2", emitree.Expression("k", {"k": 2.0})])
def test_functions_and_formulas_have_the_closed_form(method, emission, absorption):
    rendering = emitree.render(
        emission, emitree.Canonical(), (3, 4), absorption=absorption, method=method
    )
    assert np.allclose(rendering.image, EXACT, rtol=0.01)
    assert rendering.converged and rendering.absorption_evaluations > 0
    assert rendering.report["absorption_evaluations"] == rendering.absorption_evaluations


def test_evaluations_are_those_of_the_function():
    calls = []

    def counted(position, direction):
        calls.append(len(position))
        return position[:, 0] + 0.5

    rendering = emitree.render(uniform, emitree.Canonical(), (8, 8), absorption=counted)
    assert sum(calls) == rendering.absorption_evaluations
    free = emitree.render(uniform, emitree.Canonical(), (8, 8))
    assert free.absorption_evaluations is None and "absorption_evaluations" not in free.report


def test_a_coefficient_is_in_one_over_the_length_unit():
    camera = emitree.Orthographic(
        position=(0.5, 0.5, -1), target=(0.5, 0.5, 0), up=(0, 1, 0), extent=(1, 1), near=1, far=2,
        length_unit="km",
    )  # fmt: skip
    for absorption in (coefficient, "2"):
        rendering = emitree.render(uniform, camera, (3, 3), absorption=absorption)
        assert np.allclose(rendering.image, EXACT, rtol=0.01)


def test_a_grid_may_absorb():
    nodes = np.linspace(0, 1, 5)
    grid = emitree.Grid(values=np.full((5, 5, 5), 2.0), x=nodes, y=nodes, z=nodes)
    rendering = emitree.render(uniform, emitree.Canonical(), (4, 4), absorption=grid)
    assert np.allclose(rendering.image, EXACT, rtol=0.01)


def test_energies_reach_the_coefficient():
    def grey(position, direction, energy):
        return 2.0 * np.ones_like(energy)

    rendering = emitree.render(
        lambda position, direction, energy: 3.0 * np.ones_like(energy),
        emitree.Canonical(),
        (2, 2),
        energy={"min": 1, "max": 3, "bins": 2},
        absorption=grey,
    )
    assert np.allclose(rendering.image, EXACT, rtol=0.01)


def test_a_scene_file_has_a_table(tmp_path):
    path = tmp_path / "fog.toml"
    path.write_text(
        'emission.expression = "3"\nabsorption.expression = "2"\n'
        'projection.type = "canonical"\nimage = { width = 4, height = 4 }\n'
    )
    rendering = emitree.render(path)
    assert np.allclose(rendering.image, EXACT, rtol=0.01)


def test_exceptions_of_the_coefficient_are_raised():
    def fails(position, direction):
        raise KeyError("density")

    with pytest.raises(KeyError, match="density") as caught:
        emitree.render(uniform, emitree.Canonical(), (4, 4), absorption=fails)
    assert "the first at position" in caught.value.__notes__[0]


def test_a_coefficient_that_is_not_finite_is_refused():
    def nan(position, direction):
        return np.full(len(position), np.nan)

    with pytest.raises(emitree.EmissionError, match="the absorption coefficient is NaN"):
        emitree.render(uniform, emitree.Canonical(), (4, 4), absorption=nan)


def test_what_has_no_absorption_refuses_it():
    camera = emitree.Canonical()
    with pytest.raises(TypeError, match="several emissions: expected one"):
        emitree.render(["1", "2"], camera, (4, 4), absorption="2")
    with pytest.raises(TypeError, match="the absorption is int"):
        emitree.render(uniform, camera, (4, 4), absorption=2)
    with pytest.raises(TypeError, match="absorption"):
        emitree.Session(camera, (4, 4), absorption="2")
    rendering = emitree.render(uniform, camera, (4, 4), absorption="2")
    with pytest.raises(ValueError, match="no plan: the medium absorbs"):
        _ = rendering.plan
