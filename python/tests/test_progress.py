"""Reports of the progress, and intermediate images."""

import threading
import time

import numpy as np
import pytest
from models import failing, peak

import emitree

CUBE = emitree.Canonical()


def slow(position, direction):
    time.sleep(0.03)
    return peak(position, direction)


def test_a_function_is_called_with_the_evaluations():
    reported = []
    rendering = emitree.render(slow, CUBE, (32, 32), tolerance=1e-3, progress=reported.append)
    assert reported == sorted(set(reported)) and len(reported) > 2
    assert reported[-1] == rendering.evaluations


def test_a_bar(capsys):
    pytest.importorskip("tqdm")
    emitree.render(peak, CUBE, (16, 16), progress=True)
    assert "evaluations" in capsys.readouterr().err


def test_exceptions_of_the_progress_end_the_rendering():
    def stop(evaluations):
        raise StopAsyncIteration

    with pytest.raises(StopAsyncIteration):
        emitree.render(slow, CUBE, (64, 64), tolerance=1e-4, progress=stop)


def test_intermediate_images():
    plain = emitree.render(peak, CUBE, (32, 32), tolerance=1e-3)
    *frames, last = emitree.progressive(peak, CUBE, (32, 32), tolerance=1e-3)
    assert np.array_equal(last.image, plain.image) and last.evaluations == plain.evaluations
    assert len(frames) > 1
    evaluations = [frame.evaluations for frame in frames]
    assert evaluations == sorted(evaluations) and evaluations[-1] <= last.evaluations
    for frame in frames:
        assert frame.image.shape == frame.error.shape == (32, 32)
        assert np.abs(frame.image - plain.image).max() < 0.5 * plain.image.max()
    assert np.abs(frames[-1].image - plain.image).max() < 1e-2 * plain.image.max()


def test_intermediate_images_have_the_unit_of_the_last():
    camera = emitree.Perspective(
        position=(3, 0, 0), target=(0, 0, 0), field_of_view=(40, 40), far=6, length_unit="km"
    )
    options = {"unit": "ph cm-3 s-1 sr-1", "quantity": "irradiance"}
    *frames, last = emitree.progressive("exp(-r^2)", camera, (8, 8), **options)
    assert frames[-1].image.max() == pytest.approx(last.image.max(), rel=0.05)


def test_a_loop_may_be_left_early():
    threads = threading.active_count()
    for frame in emitree.progressive(slow, CUBE, (256, 256), tolerance=1e-6):
        assert frame.evaluations > 0
        break
    del frame
    for _ in range(100):
        if threading.active_count() == threads:
            break
        time.sleep(0.02)
    assert threading.active_count() == threads


@pytest.mark.parametrize("kind", [SystemExit, GeneratorExit, KeyboardInterrupt, MemoryError])
def test_any_exception_comes_out_of_the_loop(kind):
    def raising(position, direction):
        raise kind(3)

    threads = threading.active_count()
    with pytest.raises(kind):
        list(emitree.progressive(raising, CUBE, (6, 8)))
    assert threading.active_count() == threads


def test_a_loop_that_is_closed_ends_the_rendering():
    calls = []

    def counted(position, direction):
        calls.append(len(position))
        return slow(position, direction)

    threads = threading.active_count()
    images = emitree.progressive(counted, CUBE, (256, 256), tolerance=1e-6)
    next(images)
    begun = len(calls)
    images.close()
    assert threading.active_count() == threads and len(calls) <= begun + 2


def test_exceptions_come_out_of_the_loop():
    with pytest.raises(ZeroDivisionError, match="a mistake"):
        list(emitree.progressive(failing, CUBE, (8, 8)))
    with pytest.raises(emitree.SceneError):
        list(emitree.progressive(peak, CUBE, (0, 8)))
