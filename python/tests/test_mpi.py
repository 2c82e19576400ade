"""Batches on the workers of `mpi4py.futures`: two processes, and one that has the loop."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from models import Watched

pytest.importorskip("mpi4py", reason="mpi4py is missing: optional")

HERE = Path(__file__).parent
#: A wheel of MPI has its command beside the interpreter.
MPIEXEC = shutil.which("mpiexec", path=Path(sys.executable).parent) or shutil.which("mpiexec")

pytestmark = pytest.mark.skipif(MPIEXEC is None, reason="mpiexec is missing: optional")


def run(folder, task):
    """One run of mpi_render.py; whether it came to its end."""
    command = [MPIEXEC, "-n", "3", sys.executable, "-m", "mpi4py.futures", "mpi_render.py"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [*command, folder, task],
        cwd=HERE,
        env=environment,
        capture_output=True,
        timeout=60,
        # MPI ends the processes of a group if one of them was killed: not those of the tests.
        start_new_session=True,
    )
    is_whole = (folder / f"{task}.done").exists()
    assert is_whole == (done.returncode == 0), done.stderr.decode()
    return is_whole, done.stderr.decode()


def test_workers_of_mpi(tmp_path):
    is_whole, messages = run(tmp_path, "bits")
    assert is_whole, messages


def test_a_killed_process_ends_all_and_the_next_run_goes_on(tmp_path):
    watched = Watched(tmp_path)
    is_whole, _ = run(tmp_path, "killed")
    assert not is_whole, "MPI ends all processes with one of them"
    before = watched.points()
    assert watched.lost() > 0
    is_whole, messages = run(tmp_path, "cached")
    assert is_whole, messages
    evaluations = int(np.load(tmp_path / "evaluations.npy"))
    # Again: what workers had when it ended, two parts at most and what was on its way, and 8 stored points.
    assert before < evaluations < watched.points()
    assert watched.points() <= evaluations + 4 * watched.lost() + 8
