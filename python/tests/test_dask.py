"""Batches on the workers of a dask cluster: two processes here."""

import engines
import pytest
from engines import assert_same, render
from models import peak

distributed = pytest.importorskip("distributed", reason="dask[distributed] is missing: optional")

# What a cluster warns of is not ours.
pytestmark = pytest.mark.filterwarnings("default")


@pytest.fixture(scope="module")
def client():
    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None
    )
    with cluster, distributed.Client(cluster) as client:
        yield client


def test_bits(client, tmp_path):
    engines.check_bits(client, tmp_path)


def test_functions_of_the_caller_s_own(client):
    def local(position, direction):
        import numpy

        return numpy.exp(-40 * ((position - 0.5) ** 2).sum(axis=1))

    alone = render(local)
    assert_same(alone, render(local, executor=client))
    assert_same(alone, render(local, executor=client.get_executor(pure=False)))


def test_energies(client):
    engines.check_energies(client)


def test_exceptions(client):
    engines.check_exceptions(client)


def test_emissions_on_workers(client, tmp_path):
    engines.check_emission_on_workers(client, tmp_path)


def test_an_interruption(client, tmp_path):
    engines.check_interruption(client, tmp_path)
    assert_same(render(peak), render(peak, executor=client))


def test_parts_have_a_name_in_the_dashboard(client):
    render(peak, shape=(4, 4), executor=client)
    prefixes = client.run_on_scheduler(lambda dask_scheduler: list(dask_scheduler.task_prefixes))
    assert "emission_rates" in prefixes


def test_a_worker_that_stalls(client, tmp_path):
    engines.check_stalled_worker(client, tmp_path)
    # The next test needs both workers.
    calls = [client.submit(abs, 1, workers=[worker], pure=False) for worker in client.nthreads()]
    assert client.gather(calls) == [1, 1]


def test_a_worker_that_is_killed(client, tmp_path):
    engines.check_lost_worker(client, tmp_path)
