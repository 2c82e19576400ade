"""What every engine has to do, whatever it is: the tests of dask, Ray and MPI call these."""

import _thread
import functools
import signal
import threading
import time

import numpy as np
import pytest
from models import Watched, failing, loaded, peak, spectral

import emitree

render = functools.partial(
    emitree.render, camera=emitree.Canonical(), shape=(32, 32), tolerance=1e-3
)


def assert_same(one, other):
    """Bit by bit, and at the same cost."""
    assert np.array_equal(one.image, other.image) and np.array_equal(one.error, other.error)
    assert one.evaluations == other.evaluations


def check_bits(executor, folder):
    """The bits are those of one thread, and each point is evaluated once, by two workers."""
    watched = Watched(folder)
    found = render(watched, executor=executor)
    assert_same(render(peak), found)
    assert watched.points() == found.evaluations and len(watched.processes()) == 2
    assert found.report["executor"]["workers"] == 2


def check_energies(executor):
    """Cubes have energies."""
    options = {"shape": (8, 8), "energy": {"min": 1, "max": 2, "bins": 2}}
    assert_same(render(spectral, **options), render(spectral, executor=executor, **options))


def check_exceptions(executor):
    """Exceptions are those of the function; the executor is as good as before."""
    with pytest.raises(ZeroDivisionError, match="a mistake of the model") as raised:
        render(failing, executor=executor)
    assert any(note.startswith("emitree: in a batch of ") for note in raised.value.__notes__)
    assert_same(render(peak, shape=(8, 8)), render(peak, shape=(8, 8), executor=executor))


def check_lost_worker(executor, folder):
    """A worker is killed in the middle: what it had been given is evaluated again, nothing else."""
    # On a machine with other load there are few more calls than batches, 13.
    watched = Watched(folder, dies_at=8)
    found = render(watched, executor=executor)
    assert_same(render(peak), found)
    # Engines start a new worker: if that takes long, parts that wait for it are repeated, too.
    largest = max(points for _, points in watched.calls())
    more = watched.points() - found.evaluations - watched.lost()
    assert watched.lost() > 0 and 0 <= more <= found.report["executor"]["repeated"] * largest


def check_stalled_worker(executor, folder):
    """What a worker takes too long for is given to the other one; the result is the same."""
    watched = Watched(folder, stalls_at=4)
    options = {"shape": (8, 8), "tolerance": None, "method": "los", "steps": 16}
    try:
        found = render(watched, executor=executor, **options)
        assert watched.is_stalled(), "the rendering waited for the worker that stalls"
    finally:
        watched.release()
    alone = render(peak, **options)
    assert np.array_equal(found.image, alone.image) and found.evaluations == alone.evaluations
    assert found.report["executor"]["repeated"] >= 1
    assert watched.points() > found.evaluations


def check_emission_on_workers(executor, folder):
    """It is made once in each worker, for several renderings."""
    width = 0.05
    made = emitree.on_workers(loaded, str(folder), width=width)
    alone = render(lambda r, d: np.exp(-((r - 0.5) ** 2).sum(axis=1) / width))
    for _ in range(2):
        assert_same(alone, render(made, executor=executor))
    processes = (folder / "loaded").read_text().split()
    assert len(processes) == len(set(processes)) == 2


def _press_ctrl_c(folder, ended):
    """Ctrl-C a second after the first call, and again as users do: an engine may be freeing an object, which Python
    does not interrupt.
    """
    while not (folder / "calls").exists() and not ended.is_set():
        time.sleep(0.01)
    wait_s = 1.0
    while not ended.wait(wait_s):
        if hasattr(signal, "pthread_kill"):
            signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
        else:
            _thread.interrupt_main()
        wait_s = 3.0


def check_interruption(executor, folder):
    """Ctrl-C ends a rendering at once, and calls off the parts that no worker has begun."""
    watched = Watched(folder, seconds=0.2)
    ended = threading.Event()
    presses = threading.Thread(target=_press_ctrl_c, args=(folder, ended), daemon=True)
    presses.start()
    # About 1400 points in parts of a few: most of them have not begun after a second.
    with pytest.raises(KeyboardInterrupt):
        try:
            render(watched, executor=executor)
        finally:
            ended.set()
    presses.join()
    time.sleep(0.5)
    begun = len(watched.calls())
    assert watched.points() < 700
    time.sleep(0.5)
    assert len(watched.calls()) == begun
