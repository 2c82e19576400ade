"""Batches shared out over executors: the same bits as in one thread."""

import functools
import multiprocessing
import threading
import time
from concurrent.futures import (
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
)
from concurrent.futures.process import BrokenProcessPool
from types import SimpleNamespace

import numpy as np
import pytest
from models import dying, failing, peak, rendering, slow_peak, spectral

import emitree
from emitree import _executor
from emitree._call_times import seconds_per_call
from emitree._engines import engine_of
from emitree._late import Lateness
from emitree._part_sizes import Cost, parts_of

CUBE = emitree.Canonical()

render = functools.partial(
    emitree.render, camera=emitree.Canonical(), shape=(32, 32), tolerance=1e-3
)


@pytest.fixture(scope="module")
def processes():
    # Not forked: the tests have threads.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=context) as executor:
        yield executor


def assert_same(one, other):
    assert np.array_equal(one.image, other.image) and np.array_equal(one.error, other.error)
    assert one.evaluations == other.evaluations


def test_threads():
    threads = set()

    def noting(position, direction):
        threads.add(threading.get_ident())
        return slow_peak(position, direction)

    with ThreadPoolExecutor(3) as executor:
        assert_same(render(peak), render(noting, executor=executor))
    assert len(threads) > 1 and threading.get_ident() not in threads


def test_processes(processes):
    assert_same(render(peak), render(peak, executor=processes))


def test_energies_go_along(processes):
    energy = {"min": 1, "max": 2, "bins": 2}
    alone = render(spectral, shape=(8, 8), energy=energy)
    assert_same(alone, render(spectral, shape=(8, 8), energy=energy, executor=processes))


def test_exceptions_of_workers_come_back_as_themselves(processes):
    with pytest.raises(ZeroDivisionError, match="a mistake of the model") as raised:
        render(failing, executor=processes)
    assert raised.value.__notes__[0].startswith("emitree: in a batch of ")
    # The executor is as good as before.
    assert_same(render(peak), render(peak, executor=processes))


def test_workers_may_render(processes):
    inner = emitree.render(peak, emitree.Canonical(), (2, 2)).image[0, 0]
    outer = render(rendering, shape=(2, 2), executor=processes)
    np.testing.assert_allclose(outer.image, inner)


def test_other_parts_are_called_off_after_an_exception():
    calls = []

    def fails_once(position, direction):
        calls.append(len(position))
        raise ArithmeticError

    with ThreadPoolExecutor(1) as executor:
        with pytest.raises(ArithmeticError):
            render(fails_once, executor=executor)
    assert len(calls) <= 2


def test_an_executor_that_is_shut_down_is_an_error():
    with ThreadPoolExecutor(1) as executor:

        def shuts_down(position, direction):
            # When all parts of the batch have been submitted.
            time.sleep(0.3)
            executor.shutdown(wait=False, cancel_futures=True)
            return peak(position, direction)

        with pytest.raises(CancelledError) as raised:
            render(shuts_down, executor=executor)
    assert any("were called off, but not by this" in note for note in raised.value.__notes__)


class Late(Executor):
    """An executor whose futures give up waiting."""

    def submit(self, function, *arguments):
        future = Future()
        future.set_exception(TimeoutError("there is no answer"))
        return future


@pytest.mark.parametrize("way", [
    render, lambda *given, **options: list(emitree.progressive(*given, CUBE, (8, 8), **options)),
], ids=["render", "progressive"])  # fmt: skip
def test_a_timeout_of_an_executor_is_passed_on(way):
    with pytest.raises(TimeoutError, match="there is no answer"):
        way(peak, executor=Late())


def test_a_worker_that_takes_its_time_is_waited_for(monkeypatch):
    monkeypatch.setattr(_executor, "_LOOK_SECONDS", 0.01)

    def slow(position, direction):
        time.sleep(0.05)
        return peak(position, direction)

    with ThreadPoolExecutor(2) as executor:
        found = render(slow, shape=(4, 4), tolerance=0.1, executor=executor)
    assert_same(found, render(peak, shape=(4, 4), tolerance=0.1))


def sizes(count, workers, seconds_per_point, seconds_per_part=0.0):
    """The sizes of parts, which are one after the other."""
    parts = list(parts_of(count, workers, seconds_per_point, seconds_per_part))
    ends = [part.stop for part in parts]
    assert [part.start for part in parts] == [0, *ends[:-1]] and ends[-1] == count
    return [part.stop - part.start for part in parts]


def test_parts_follow_the_time_that_points_take():
    assert sizes(800, 2, None) == [100] * 8
    assert sizes(3, 64, None) == [1, 1, 1]
    # A part of half a second at most.
    assert max(sizes(800, 2, 0.1)) == 5
    # 2 milliseconds at least.
    assert sizes(800, 2, 1e-8) == [800]
    assert sizes(800, 2, 1e-4)[:3] == [200, 150, 113] and min(sizes(800, 2, 1e-4)[:-1]) == 20
    # A scheduler that sends a part in 1 ms keeps 64 workers busy with parts of 64 ms.
    assert min(sizes(10_000, 64, 0.01, 1e-3)[:-1]) == 6
    # Parts of 1 s, sent within 1 s, if sending takes 0.1 s: 1 s of work for 10 parts.
    assert sizes(1000, 64, 0.01, 0.1) == [100] * 10


def test_workers_end_at_about_the_same_time():
    # Greedy workers, and points that take 10 ms, but 5 times as long in a fifth of the batch.
    seconds = np.full(10_000, 0.01)
    seconds[3000:5000] = 0.05
    free = np.zeros(64)
    start = 0
    for size in sizes(10_000, 64, seconds.mean()):
        free[free.argmin()] += seconds[start : start + size].sum()
        start += size
    assert free.max() < 1.1 * seconds.sum() / 64


def test_the_cost_of_a_point_is_the_mean_of_what_came_last():
    cost = Cost()
    assert cost.seconds_per_point is None
    cost.add(0.0, 100)
    assert cost.seconds_per_point > 0
    for _ in range(200):
        cost.add(2.0, 100)
    assert cost.seconds_per_point == pytest.approx(0.02, rel=1e-4)


def test_a_large_batch_begins_with_a_few_points():
    sizes = []

    def noting(position, direction):
        sizes.append(len(position))
        time.sleep(1e-3 * len(position))
        return peak(position, direction)

    options = {"shape": (16, 16), "tolerance": None, "method": "los", "steps": 8}
    with ThreadPoolExecutor(4) as executor:
        found = render(noting, executor=executor, **options)
    assert np.array_equal(found.image, render(peak, **options).image)
    assert found.evaluations == sum(sizes) > 1024 and found.report["executor"]["batches"] == 1
    # 16 points for each worker; then half a second, instead of a quarter of all for a worker.
    assert max(sizes[:16]) == 4 and 4 < max(sizes) <= 500


def test_the_time_of_a_call_is_measured_once():
    with ThreadPoolExecutor(2) as executor:
        engine = engine_of(executor)
        guess = seconds_per_call(engine)
        render(peak, executor=executor)
        measured = seconds_per_call(engine)
        assert 0 < measured < 0.1 and measured != guess
        render(peak, executor=executor)
        assert seconds_per_call(engine_of(executor)) == measured


def test_executors_that_tell_nothing():
    assert engine_of(Late()).workers() >= 1


@pytest.mark.parametrize("wrong", [5, Late, "ray", object()])
def test_what_is_no_executor_is_refused(wrong):
    with pytest.raises(emitree.SceneError, match=r"`executor` is .*: expected a concurrent"):
        render(peak, executor=wrong)


def test_an_asynchronous_client_is_refused():
    client = SimpleNamespace(get_executor=None, asynchronous=True)
    with pytest.raises(emitree.SceneError, match="`executor` is an asynchronous dask client"):
        render(peak, executor=client)


def test_the_work_of_the_workers_is_reported():
    with ThreadPoolExecutor(3) as executor:
        found = render(slow_peak, executor=executor)
    of_workers = found.report["executor"]
    assert of_workers["workers"] == 3 and of_workers["batches"] == found.report["batches"]
    assert of_workers["parts"] >= of_workers["batches"] and of_workers["repeated"] == 0
    assert 0 < of_workers["seconds"] < 3 * of_workers["waited"]


def test_the_progress_is_told_in_the_middle_of_a_batch():
    told = []
    with ThreadPoolExecutor(3) as executor:
        found = render(slow_peak, executor=executor, progress=told.append)
    assert told == sorted(set(told)) and told[-1] == found.evaluations
    assert len(told) > found.report["batches"]


class Stuck:
    """The peak, of which one call in the middle does not return until it is told to."""

    def __init__(self):
        self.calls = 0
        self.points = 0
        self.held = threading.Event()
        self.lock = threading.Lock()

    def __call__(self, position, direction):
        with self.lock:
            self.calls += 1
            self.points += len(position)
            is_stuck = self.calls == 25
        if is_stuck:
            self.held.wait(60)
        return slow_peak(position, direction)


def test_a_worker_that_does_not_respond_is_not_waited_for():
    stuck = Stuck()
    with ThreadPoolExecutor(3) as executor:
        try:
            found = render(stuck, executor=executor)
        finally:
            stuck.held.set()
    assert_same(found, render(peak))
    of_workers = found.report["executor"]
    assert of_workers["repeated"] >= 1
    # What was repeated is that one part, and it is not counted.
    assert found.evaluations < stuck.points <= found.evaluations + 200
    assert of_workers["waited"] < 10


def test_a_part_is_repeated_some_times_only():
    cost = Cost()
    lateness = Lateness(cost)
    parts = [slice(0, 10), slice(10, 20)]
    lateness._last -= 1e6
    assert lateness.late(parts, 2) == [], "nothing is known of the time of a point"
    cost.add(1.0, 10)
    assert lateness.late(parts, 0) == parts[:1], "one at a time if no worker is idle"
    assert lateness.late(parts[:1], 1) == lateness.late(parts[:1], 1) == parts[:1]
    assert lateness.late(parts[:1], 1) == []
    lateness.came(0.0)
    assert lateness.late(parts, 2) == []


def test_a_worker_that_dies_is_an_error_and_no_wait():
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=context) as executor:
        with pytest.raises(BrokenProcessPool) as raised:
            render(dying, executor=executor)
    assert any("with `cache` the same call goes on" in note for note in raised.value.__notes__)
