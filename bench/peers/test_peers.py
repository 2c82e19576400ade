"""Evaluations are counted correctly, images have their orientation, and exact images are exact."""

import itertools
import shutil
import subprocess
import time

import numpy as np
import pytest

from . import __main__ as command
from . import gauss, harness, interpolant, row, runs, tables
from .contestant import Contestant, Found, Problem
from .contestants import CONTESTANTS
from .counter import Counter, GridMemo, PointMemo
from .scene import Scene, relative_error
from .scenes import SCENES

#: Those that have settings for it.
OF_EQ8 = [one for one in CONTESTANTS.values() if one.settings_of("eq8")]


def ramp(x, y, z):
    """Brighter towards large x, more so towards large y: no two of the symmetries leave it."""
    return 1 + 2 * x + 5 * y + 0 * z


def ramp_image(shape):
    height, width = shape
    x, y = gauss.panels(width, 1)[0], gauss.panels(height, 1)[0]
    return 1 + 2 * x + 5 * y[:, None]


RAMP = Scene("eq8", "a ramp", ramp, ramp_image, ramp_image, shape=(8, 8))


@pytest.mark.parametrize("contestant", OF_EQ8, ids=lambda one: one.name)
def test_every_contestant_has_x_to_the_right_and_y_up(contestant):
    exact = ramp_image(RAMP.shape)
    found = harness.measure(contestant, RAMP, exact, contestant.settings_of("eq8")[0])
    assert found.found, found.note
    # Flipped or transposed, the image is wrong by a fifth or more.
    assert found.error < 0.1
    flips = (exact[::-1], exact[:, ::-1], exact[::-1, ::-1], exact.T)
    assert min(relative_error(flip, exact) for flip in flips) > 0.2


@pytest.mark.parametrize("contestant", OF_EQ8, ids=lambda one: one.name)
def test_every_evaluation_is_counted(contestant):
    # Counted apart from the counter, in the rate itself.
    points = itertools.count()

    def rate(x, y, z):
        values = ramp(x, y, z)
        for _ in range(values.size):
            next(points)
        return values

    scene = Scene("eq8", "a ramp", rate, ramp_image, ramp_image, shape=(8, 8))
    setting = contestant.settings_of("eq8")[0]
    measured = harness.solve(contestant, scene, ramp_image(scene.shape), setting)
    assert measured["evaluations"] == next(points) > 0


def test_counts_that_are_known():
    exact = ramp_image(RAMP.shape)
    for name, setting, evaluations in (
        ("fixed step 4", {"steps": 6}, 4 * 64 * 6),
        ("Gauss grid", {"across": 5, "depth": 3}, 5 * 5 * 3),
        ("quad on Gauss lines", {"lines": 3, "tolerance": 0.1}, 3 * 3 * 21),
        ("yt grid", {"cells": 8}, 8**3),
    ):
        assert harness.solve(CONTESTANTS[name], RAMP, exact, setting)["evaluations"] == evaluations


def test_the_counter_counts_points_of_arrays_that_broadcast():
    counter = Counter(lambda x, y, z: x + y + z)
    counter(np.zeros((4, 1)), np.zeros(3), 0.5)
    counter(0.1, 0.2, 0.3)
    counter.at(np.zeros((7, 3)))
    assert counter.evaluations == 4 * 3 + 1 + 7


def test_memos_evaluate_each_point_once():
    counter = Counter(lambda x, y, z: x + 10 * y + 100 * z)
    memo = GridMemo(counter, (np.arange(3.0), np.arange(4.0), np.arange(5.0)))
    asked = np.array([[2, 3, 4], [0, 1, 2], [2, 3, 4]])
    assert memo(asked).tolist() == [432.0, 210.0, 432.0]
    assert memo(asked[::-1]).tolist() == [432.0, 210.0, 432.0]
    assert counter.evaluations == 2
    point = PointMemo(counter)
    assert [point((1, 2, 3)), point((1, 2, 3))] == [321.0, 321.0]
    assert counter.evaluations == 3


#: Lowest pixel, highest pixel and sum, as the tests of the crate `emitree-problems` have them.
OF_THE_CRATE = {
    "eq8": (5.322024676125433e-9, 0.13382470742571245, 22.34880358896829),
    "shell": (4.411362728452924e-65, 0.4412596815810711, 420.634169654585),
    "shock": (0.17943140071909636, 5.598769619255256, 9531.881315511473),
}


@pytest.mark.parametrize("name", OF_THE_CRATE)
def test_exact_images_agree_with_other_nodes_and_with_the_crate(name):
    image, disagreement = SCENES[name].verified_image()
    assert disagreement < 1e-12
    low, high, total = OF_THE_CRATE[name]
    assert abs(image.min() - low) < 1e-12 * high
    assert abs(image.max() - high) < 1e-12 * high
    assert abs(image.sum() - total) < 1e-12 * total


def test_rates_are_those_of_the_scenes():
    assert SCENES["eq8"].rate(*np.sqrt([2 / 9, 7 / 25, 6 / 25])) == pytest.approx(1, abs=0.01)
    assert SCENES["shell"].rate(0.85, 0.47, 0.52) == pytest.approx(1.425, abs=1e-12)
    assert SCENES["shock"].rate(0.5, 0.5, 0.3) == 10


def test_exact_images_that_differ_are_not_used():
    scene = Scene("off", "", ramp, ramp_image, lambda shape: 1.001 * ramp_image(shape))
    with pytest.raises(ArithmeticError, match=r"scene off: .* differ by 1\.0e-03"):
        scene.verified_image()


def test_interpolants_average_polynomials_exactly():
    border = np.linspace(0, 1, 8)
    means = 7 * np.diff(border**6 / 6)
    node, _ = gauss.nodes(6)
    assert interpolant.from_gauss_nodes(6, 7) @ node**5 == pytest.approx(means, abs=1e-14)
    node = 0.5 + 0.5 * np.cos(np.pi * (np.arange(6) + 0.5) / 6)
    assert interpolant.from_chebyshev_nodes(node, 7) @ node**5 == pytest.approx(means, abs=1e-14)


def contestant(run, **more):
    return Contestant("one", "numpy", "", run, {"*": [{}, {}, {}]}, **more)


def test_failures_become_notes_and_end_a_sweep():
    def fail(problem: Problem):
        raise ValueError("no image")

    rows = list(harness.sweep(contestant(fail), RAMP, ramp_image((8, 8))))
    assert [row.note for row in rows] == ["failed: ValueError: no image"] * 2
    assert not any(row.found for row in rows)


def test_a_contestant_that_takes_too_long_is_ended():
    slow = contestant(lambda problem: time.sleep(60), limit_s=0.2)
    found = harness.measure(slow, RAMP, ramp_image((8, 8)), {})
    assert found.note == "failed: over 0 s"


def test_memory_and_time_are_those_of_the_run():
    def run(problem):
        block = np.ones(2**23)
        time.sleep(0.1)
        return Found(ramp_image((8, 8)) * block[0])

    small = harness.measure(
        contestant(lambda problem: Found(ramp_image((8, 8)))), RAMP, ramp_image((8, 8)), {}
    )
    large = harness.measure(contestant(run), RAMP, ramp_image((8, 8)), {})
    assert 60 < large.peak_mib - small.peak_mib < 80
    assert 0.1 <= large.seconds < 10
    assert small.error == 0


EARLIER = runs.Run("a machine: old", "abc-dirty", "cargo xtask compare-peers", "2026-01-02")
LATER = runs.Run("a machine", "def", 'cargo xtask compare-peers "fixed step 1"', "2026-02-01")


def test_runs_say_where_they_were(tmp_path):
    run = runs.now(["cargo", "xtask", "compare-peers", "fixed step 1"], tmp_path)
    assert run.command == 'cargo xtask compare-peers "fixed step 1"'
    assert "cores" in run.machine and "GiB" in run.machine and run.date.endswith("Z")
    # There is no repository.
    assert run.commit == runs.UNKNOWN


@pytest.mark.skipif(shutil.which("git") is None, reason="there is no git")
def test_commits_with_changes_are_dirty(tmp_path):
    def git(*arguments):
        author = ["-c", "user.name=a", "-c", "user.email=a@b"]
        subprocess.run(["git", *author, *arguments], cwd=tmp_path, check=True)

    git("init", "-q")
    git("commit", "-q", "--allow-empty", "-m", "one")
    commit = runs.commit(tmp_path)
    assert len(commit) == 40
    (tmp_path / "new").write_text("changed")
    assert runs.commit(tmp_path) == f"{commit}-dirty"


def test_names_are_those_of_contestants_and_scenes():
    contestants, scenes = command.selected([])
    assert [one.name for one in contestants] == list(CONTESTANTS)
    assert [one.name for one in scenes] == list(SCENES)
    contestants, scenes = command.selected(["smile", "yt grid", "emitree"])
    assert [one.name for one in contestants] == ["emitree", "yt grid"]
    assert [one.name for one in scenes] == ["smile"]
    contestants, scenes = command.selected(["users"])
    assert [one.name for one in scenes] == ["eq8", "smile", "zodi"]
    assert {"emitree", "raysect"} < {one.name for one in contestants} < set(CONTESTANTS)
    with pytest.raises(ValueError, match=r"unknown contestants or scenes \['nothing'\]"):
        command.selected(["eq8", "nothing"])


def test_rows_survive_their_file(tmp_path):
    rows = [
        row.Row("one", "numpy 2", "eq8", "nodes=3", 27, 0.25, None, 0.5, 80.0, "a, b", LATER),
        row.Row("two", "scipy 1", "eq8", "", note="failed: over 40 s", run=EARLIER),
        row.Row("two", "scipy 1", "smile", "", note="failed: over 40 s", run=LATER),
    ]
    row.write(tmp_path / "rows.csv", rows)
    assert row.read(tmp_path / "rows.csv") == rows
    text = (tmp_path / "rows.csv").read_text().splitlines()
    assert text[:3] == ["# run: 1", "# machine: a machine: old", "# commit: abc-dirty"]
    assert text[5] == "# run: 2" and text[10].startswith("contestant,")
    assert row.read(tmp_path / "none.csv") == []


def test_the_cheapest_setting_is_taken():
    rows = [
        row.Row("one", "", "eq8", "a", 100, 0.02),
        row.Row("one", "", "eq8", "b", 300, 0.005),
        row.Row("one", "", "eq8", "c", 200, 0.009),
        row.Row("one", "", "eq8", "d"),
    ]
    assert tables.cheapest(rows, 0.01).evaluations == 200
    assert tables.cheapest(rows, 0.06).evaluations == 100
    assert tables.cheapest(rows, 0.001) is None


def test_luck_is_marked():
    rows = [
        row.Row("one", "", "eq8", "nodes=3 seed=0", 1000, 0.005, None, 0.1, 70),
        row.Row("one", "", "eq8", "nodes=3 seed=1", 1100, 0.02),
        row.Row("one", "", "eq8", "nodes=4 seed=0", 2000, 0.005),
        row.Row("two", "", "eq8", "nodes=3 seed=1", 3000, 0.02),
    ]
    one, two = tables.levels(rows, ["one", "two"]).splitlines()[2:]
    assert one.startswith("| one | **1,000** | **1,000\\*** | - |")
    assert two.startswith("| two | 3,000 | - |")
    rows[1] = row.Row("one", "", "eq8", "nodes=3 seed=1", note="failed: over 40 s")
    assert "1,000\\*" in tables.against(rows[:2] + rows[3:], ["eq8"])


def test_ours_is_set_against_the_best_of_the_others():
    rows = [
        row.Row("emitree", "", "eq8", "tolerance=0.01", 500, 0.002, 0.007, 0.1),
        row.Row("emitree", "", "eq8", "tolerance=0.02", 400, 0.009, 0.013, 0.1),
        row.Row("emitree", "", "eq8", "tolerance=0.05", 400, 0.009, 0.013, 0.1),
        row.Row("one", "", "eq8", "", 800, 0.01),
    ]
    assert "| eq8 | 1 % | 500 | 400 | 800 (one) | wins, 2 x fewer |" in tables.against(
        rows, ["eq8"]
    )
    asked = [line.split(" | ")[0] for line in tables.tolerances_met(rows).splitlines()[2:]]
    assert asked == ["| 0.01", "| 0.05"]


def test_what_users_would_pick_shows_where_ours_loses():
    rows = [
        row.Row("emitree", "", "eq8", "tolerance=0.02", 400, 0.009, 0.013, 0.1, 60),
        row.Row("emitree", "", "eq8", "tolerance=0.01", 500, 0.002, 0.007, 0.1, 60),
        row.Row("one", "", "eq8", "n=2", 2000, 0.01, None, 0.05, 60),
        row.Row("two", "", "eq8", "n=2", 900, 0.3, None, 0.05, 60),
        row.Row("two", "", "eq8", "n=3", note="failed: over 40 s"),
    ]
    names = ["emitree", "one", "two", "three"]
    ours, one, two, three, *rest = tables.users(rows, names, ["eq8"]).splitlines()[2:]
    assert ours == "| eq8 | 1 % | emitree | tolerance=0.01 | 500 | 2.0e-03 | 0.1 | 60 | - |"
    assert one.endswith("| 0.05 | 60 | 0.25 x evaluations, **2 x s**, 1 x MiB |")
    assert two.startswith(
        "| eq8 | 1 % | two | n=2 | 900 | 3.0e-01 | 0.05 | 60 | missed; n=3 failed"
    )
    assert three.endswith("three | - | - | - | - | - | not measured |") and len(rest) == 4
