"""Batches on the workers of Ray: two processes here."""

import os
import sys
import time

import engines
import pytest
from engines import assert_same, render
from models import peak

import emitree

ray = pytest.importorskip("ray", reason="ray is missing: optional")

# What Ray warns of is not ours.
pytestmark = pytest.mark.filterwarnings("default")


@pytest.fixture(scope="module")
def connected():
    with pytest.raises(emitree.SceneError, match=r"not connected: expected `ray.init\(\)` before"):
        render(peak, executor=ray)
    with pytest.MonkeyPatch.context() as patch:
        # Workers find the modules of the tests.
        patch.setenv("PYTHONPATH", os.pathsep.join(sys.path))
        ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, logging_level="ERROR")
        yield ray
        ray.shutdown()


def test_bits(connected, tmp_path):
    engines.check_bits(connected, tmp_path)


def test_functions_of_the_caller_s_own(connected):
    def local(position, direction):
        import numpy

        return numpy.exp(-40 * ((position - 0.5) ** 2).sum(axis=1))

    assert_same(render(local), render(local, executor=connected))


def test_energies(connected):
    engines.check_energies(connected)


def test_exceptions(connected):
    engines.check_exceptions(connected)


def test_emissions_on_workers(connected, tmp_path):
    engines.check_emission_on_workers(connected, tmp_path)


def test_an_interruption(connected, tmp_path):
    engines.check_interruption(connected, tmp_path)


def process():
    """Takes so long that another worker gets the next call."""
    time.sleep(0.2)
    return os.getpid()


def test_a_worker_that_stalls(connected, tmp_path):
    remote = connected.remote(process)
    # Workers that were interrupted are replaced by new ones, which takes a while.
    while len(set(connected.get([remote.remote() for _ in range(2)]))) < 2:
        pass
    engines.check_stalled_worker(connected, tmp_path)


def test_a_worker_that_is_killed(connected, tmp_path):
    engines.check_lost_worker(connected, tmp_path)
