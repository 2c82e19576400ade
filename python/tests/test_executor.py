"""Batches shared out over executors: the same bits as in one thread."""

import functools
import multiprocessing
import threading
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool

import numpy as np
import pytest
from models import dying, failing, peak, rendering, slow_peak, spectral

import emitree
from emitree import _executor
from emitree._executor import Shared, worker_count
from emitree._function import Function

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


def test_a_worker_that_dies_is_an_error_and_no_wait():
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=context) as executor:
        with pytest.raises(BrokenProcessPool):
            render(dying, executor=executor)


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


def test_parts_follow_the_time_that_points_take():
    with ThreadPoolExecutor(2) as executor:
        shared = Shared(Function(peak), executor)
        assert shared.workers == 2
        assert shared.part_size(800) == 100
        shared.seconds_per_point = 0.1
        assert shared.part_size(800) == 5
        shared.seconds_per_point = 1e-8
        assert shared.part_size(800) == 200_000
        shared.seconds_per_point = 0.0
        assert shared.part_size(800) >= 800


def test_executors_that_tell_nothing():
    assert worker_count(object()) >= 1


@pytest.mark.filterwarnings("default")  # What a cluster warns of is not ours.
def test_a_cluster():
    distributed = pytest.importorskip("distributed")

    def local(position, direction):
        import numpy

        return numpy.exp(-40 * ((position - 0.5) ** 2).sum(axis=1))

    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
    )
    with cluster, distributed.Client(cluster) as client:
        executor = client.get_executor(pure=False)
        assert worker_count(executor) == 2
        alone = render(local)
        assert_same(alone, render(local, executor=executor))
        assert_same(alone, render(local, executor=client))
