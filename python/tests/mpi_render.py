"""A rendering on MPI workers: `mpiexec -n 3 python -m mpi4py.futures mpi_render.py FOLDER TASK`.

Called by test_mpi.py, in the folder of the tests.
"""

import pathlib
import sys

import engines
import numpy as np
from engines import render
from models import Watched, peak
from mpi4py.futures import MPIPoolExecutor


def cached(executor, folder, dies_at=None):
    """With a cache, from which the next call goes on."""
    watched = Watched(folder, dies_at=dies_at)
    found = render(watched, executor=executor, cache=folder / "cache")
    alone = render(peak)
    engines.assert_same(alone, found)
    np.save(folder / "evaluations.npy", found.evaluations)


def main():
    """Does one task with all workers."""
    folder, task = pathlib.Path(sys.argv[1]), sys.argv[2]
    with MPIPoolExecutor() as executor:
        if task == "killed":
            cached(executor, folder, dies_at=8)
        elif task == "cached":
            cached(executor, folder)
        else:
            engines.check_bits(executor, folder)
            engines.check_energies(executor)
            engines.check_exceptions(executor)
            engines.check_emission_on_workers(executor, folder)
    (folder / f"{task}.done").touch()


if __name__ == "__main__":
    main()
