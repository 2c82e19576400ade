"""One contestant with one setting in one scene, in a process of its own."""

import contextlib
import importlib
import io
import multiprocessing
import resource
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from multiprocessing.connection import Connection

import numpy as np

from .contestant import Contestant, Found, Problem, spelled
from .row import Row
from .runs import SOME_RUN, Run
from .scene import Scene, relative_error

#: A child starts as a copy, with scenes and contestants in it: there is nothing to send.
PROCESSES = multiprocessing.get_context("fork")
#: Bytes in a unit of `ru_maxrss`.
RSS_UNIT = 1 if sys.platform == "darwin" else 1024


def sweep(
    contestant: Contestant, scene: Scene, exact: np.ndarray, run: Run = SOME_RUN
) -> Iterator[Row]:
    """Measures the settings of a contestant until its patience is at an end."""
    failures = 0
    for setting in contestant.settings_of(scene.name):
        row = replace(measure(contestant, scene, exact, setting), run=run)
        yield row
        failures += not row.found
        if failures >= contestant.patience:
            return


def measure(contestant: Contestant, scene: Scene, exact: np.ndarray, setting: dict) -> Row:
    """Runs one setting in a child; what goes wrong there becomes the note of the row."""
    receiver, sender = PROCESSES.Pipe(duplex=False)
    arguments = (sender, contestant, scene, exact, setting)
    child = PROCESSES.Process(target=_child, args=arguments)
    child.start()
    # The child has the only end left: if it dies, there is an end of file here.
    sender.close()
    try:
        if receiver.poll(contestant.limit_s):
            measured = receiver.recv()
        else:
            measured = {"note": f"failed: over {contestant.limit_s:.0f} s"}
    except EOFError:
        measured = {"note": "failed: its process ended"}
    child.kill()
    child.join()
    return Row(
        contestant=contestant.name,
        version=contestant.version,
        scene=scene.name,
        setting=spelled(setting),
        **measured,
    )


def _child(
    sender: Connection, contestant: Contestant, scene: Scene, exact: np.ndarray, setting: dict
) -> None:
    try:
        # Some packages greet.
        with contextlib.redirect_stdout(io.StringIO()):
            measured = solve(contestant, scene, exact, setting)
    # A contestant may raise anything: what it was goes into the table.
    except Exception as error:
        measured = {"note": f"failed: {type(error).__name__}: {error}"[:200]}
    sender.send(measured)
    sender.close()


def solve(contestant: Contestant, scene: Scene, exact: np.ndarray, setting: dict) -> dict:
    """Runs one setting here: the columns of its row."""
    for module in contestant.modules:
        importlib.import_module(module)
    problem = Problem.of(scene, exact)
    start = time.perf_counter()
    found: Found = contestant.run(problem, **setting)
    image = found.image
    if scene.camera and not contestant.has_cameras:
        image = image / scene.camera.pixel_angles(scene.shape)
    seconds = time.perf_counter() - start
    return {
        "evaluations": problem.emission.evaluations,
        "error": relative_error(image, exact),
        "estimated_error": found.estimated_error,
        "seconds": seconds,
        "peak_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * RSS_UNIT / 2**20,
        "note": found.note,
    }
