"""Sessions whose points are on disk: each process goes on where the last one ended."""

import os
import subprocess
import sys

import numpy as np
import pytest
from models import peak, spectral

import emitree

CUBE = emitree.Canonical()


def same(one, other):
    return np.array_equal(one.image, other.image) and np.array_equal(one.error, other.error)


def test_a_new_session_for_each_round_gives_the_same_bits(tmp_path):
    plain = emitree.render(peak, CUBE, (16, 16), tolerance=1e-3)
    seen, rounds = set(), 0
    while True:
        with emitree.Session(CUBE, (16, 16), tolerance=1e-3, cache=tmp_path / "run") as session:
            points = session.ask()
            if points is None:
                break
            new = {tuple(position) for position in points.position}
            assert len(new) == len(points) and not new & seen
            seen |= new
            session.tell(peak(points.position, points.direction))
            rounds += 1
    assert same(session.rendering(), plain) and len(seen) == plain.evaluations
    assert rounds == plain.report["batches"]


def test_fewer_rounds_have_the_same_bits(tmp_path):
    plain = emitree.render(peak, CUBE, (16, 16), tolerance=1e-3)
    fewer = emitree.render(peak, CUBE, (16, 16), tolerance=1e-3, rounds=6)
    assert same(plain, fewer) and fewer.report["batches"] < plain.report["batches"]
    rounds = 0
    while True:
        options = {"tolerance": 1e-3, "rounds": 6, "cache": tmp_path}
        with emitree.Session(CUBE, (16, 16), **options) as session:
            if (points := session.ask()) is None:
                break
            session.tell(peak(points.position, points.direction))
            rounds += 1
    assert same(session.rendering(), plain) and rounds == fewer.report["batches"]


def test_another_tolerance_goes_on_with_the_points_that_are_there(tmp_path):
    numbers = []
    for tolerance in (0.01, 1e-4, 1e-3):
        with emitree.Session(CUBE, (16, 16), tolerance=tolerance, cache=tmp_path) as session:
            numbers.append(0)
            while points := session.ask():
                numbers[-1] += len(points)
                session.tell(peak(points.position, points.direction))
        assert same(session.rendering(), emitree.render(peak, CUBE, (16, 16), tolerance=tolerance))
    alone = emitree.render(peak, CUBE, (16, 16), tolerance=1e-4).evaluations
    assert numbers[2] == 0 < numbers[1] < alone


def test_a_session_that_is_resumed_stores_its_points(tmp_path):
    with emitree.Session(CUBE, (8, 8), tolerance=0.01, cache=tmp_path) as session:
        for tolerance in (0.01, 1e-4):
            session.resume(tolerance=tolerance)
            while points := session.ask():
                session.tell(peak(points.position, points.direction))
        fine = session.rendering()
    with emitree.Session(CUBE, (8, 8), tolerance=1e-4, cache=tmp_path) as session:
        assert session.ask() is None and same(session.rendering(), fine)


def test_a_cube_and_a_rendering_share_a_cache(tmp_path):
    options = {"energy": {"min": 1, "max": 2, "bins": 2}, "cache": tmp_path}
    with emitree.Session(CUBE, (4, 4), **options) as session:
        while points := session.ask():
            session.tell(spectral(points.position, points.direction, points.energy))
    found = emitree.render(spectral, CUBE, (4, 4), **options)
    assert found.report["cache"]["added"] == 0 and same(found, session.rendering())


def test_what_is_wrong_is_named_and_nothing_is_lost(tmp_path):
    with emitree.Session(CUBE, (8, 8), cache=tmp_path) as session:
        points = session.ask()
        with pytest.raises(ValueError, match=r"expected \(\d+,\)"):
            session.tell([1.0])
        rates = peak(points.position, points.direction)
        wrong = rates.copy()
        wrong[3] = np.nan
        with pytest.raises(emitree.EmissionError, match="NaN"):
            session.tell(wrong)
        assert len(session.ask()) == len(points), "it still waits for them"
    with pytest.raises(ValueError, match="the session is closed"):
        session.tell(rates)
    with emitree.Session(CUBE, (8, 8), cache=tmp_path) as session:
        assert len(session.ask()) == 1, "the rates that were numbers are there"
    with pytest.raises(ValueError, match="`length_unit` is None: expected 'km', or another cache"):
        emitree.Session(emitree.Canonical(length_unit="km"), (8, 8), cache=tmp_path)


def test_two_sessions_at_once_are_refused(tmp_path):
    pytest.importorskip("fcntl")
    with emitree.Session(CUBE, (8, 8), cache=tmp_path):
        with pytest.raises(ValueError, match="another rendering uses it"):
            emitree.Session(CUBE, (8, 8), cache=tmp_path)
    # One that is no longer there needs not be closed.
    emitree.Session(CUBE, (8, 8), cache=tmp_path)
    emitree.Session(CUBE, (8, 8), cache=tmp_path).close()


#: The programs of docs/guide.md, "Batch queues without a connection".
NEXT = """
import pathlib

import emitree
import numpy as np

JOBS = 2
files = [pathlib.Path(f"rates-{job}.npy") for job in range(JOBS)]
options = {"tolerance": 0.5, "max_evaluations": 200, "cache": "points"}
with emitree.Session(emitree.Canonical(), (8, 8), **options) as session:
    points = session.ask()
    asked = pathlib.Path("points.npy")
    if points and asked.exists() and np.array_equal(np.load(asked)[:, :3], points.position):
        rates = np.empty(len(points))
        for job, file in enumerate(files):
            rates[job::JOBS] = np.load(file)
        session.tell(rates)
        points = session.ask()
    for file in files:
        file.unlink(missing_ok=True)
    if points:
        np.save(asked, np.hstack([points.position, points.direction]))
    else:
        np.save("image.npy", session.rendering().image)
"""


def test_jobs_that_pass_files(tmp_path):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(map(os.path.abspath, sys.path))}
    command = [sys.executable, "-c", NEXT]
    evaluated = 0
    for _ in range(20):
        subprocess.run(command, check=True, env=environment, cwd=tmp_path)
        if (tmp_path / "image.npy").exists():
            break
        points = np.load(tmp_path / "points.npy")
        evaluated += len(points)
        for job in range(2):
            of_job = points[job::2]
            np.save(tmp_path / f"rates-{job}.npy", peak(of_job[:, :3], of_job[:, 3:]))
    plain = emitree.render(peak, CUBE, (8, 8), tolerance=0.5, max_evaluations=200)
    assert np.array_equal(np.load(tmp_path / "image.npy"), plain.image)
    assert evaluated == plain.evaluations
