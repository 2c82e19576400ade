"""How functions are called: threads, signals, exceptions, and what they may return."""

import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
from models import failing, peak

import emitree

CUBE = emitree.Canonical()


def test_a_function_is_called_in_the_thread_that_renders():
    threads = set()

    def noting(position, direction):
        threads.add(threading.get_ident())
        assert position.shape == direction.shape == (len(position), 3)
        assert position.dtype == np.float64 and position.flags.c_contiguous
        return peak(position, direction)

    emitree.render(noting, CUBE, (32, 32), batch_size=500)
    assert threads == {threading.get_ident()}


def test_the_state_of_the_caller_holds_in_a_function():
    with np.errstate(divide="raise"), pytest.raises(FloatingPointError):
        emitree.render(lambda r, d: 1.0 / np.zeros(len(r)), CUBE, (4, 4))


def test_arrays_may_be_kept_and_changed():
    kept = []

    def keeping(position, direction):
        rates = peak(position, direction)
        kept.append((position, position.copy()))
        direction[:] = np.nan
        return rates

    rendering = emitree.render(keeping, CUBE, (16, 16))
    assert np.array_equal(rendering.image, emitree.render(peak, CUBE, (16, 16)).image)
    assert all(np.array_equal(position, copy) for position, copy in kept)


def test_neither_batches_nor_threads_change_a_bit():
    one = emitree.render(peak, CUBE, (32, 32), tolerance=1e-3, threads=1)
    for options in ({"threads": 2}, {"threads": 3, "batch_size": 37}, {"batch_size": 1000}):
        other = emitree.render(peak, CUBE, (32, 32), tolerance=1e-3, **options)
        assert np.array_equal(one.image, other.image) and one.evaluations == other.evaluations


def test_the_interpreter_is_free_while_rust_works():
    count, done = 0, threading.Event()

    def counting():
        nonlocal count
        while not done.is_set():
            count += 1
            time.sleep(0.001)

    counter = threading.Thread(target=counting)
    counter.start()
    try:
        start = time.perf_counter()
        emitree.render("exp(-r)", CUBE, (128, 128), method="los", steps=4000)
        took, counted = time.perf_counter() - start, count
    finally:
        done.set()
        counter.join()
    assert took > 0.05 and counted > 0.1 * took / 0.001


def test_a_function_may_render():
    def nested(position, direction):
        inner = emitree.render(peak, CUBE, (2, 2), tolerance=0.1, threads=1)
        return np.full(len(position), inner.image[0, 0])

    rendering = emitree.render(nested, CUBE, (2, 2), threads=1)
    inner = emitree.render(peak, CUBE, (2, 2), tolerance=0.1).image[0, 0]
    np.testing.assert_allclose(rendering.image, inner)


def test_threads_may_render_at_once():
    images = {}

    def work(number):
        images[number] = emitree.render(peak, CUBE, (16, 16)).image

    threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(images) == 4 and all(np.array_equal(images[0], image) for image in images.values())


def test_exceptions_come_back_as_themselves_with_a_note():
    firsts = []

    def watched(position, direction):
        firsts.append(position[0].tolist())
        return failing(position, direction)

    with pytest.raises(ZeroDivisionError, match="a mistake of the model") as raised:
        emitree.render(watched, CUBE, (8, 8))
    (note,) = raised.value.__notes__
    assert note.startswith("emitree: in a batch of ")
    assert f"the first at position {firsts[-1]}" in note
    assert raised.traceback[-1].name == "failing"


def test_rates_that_are_not_finite_are_located():
    def hole(position, direction):
        return np.where(position[:, 0] > 0.6, np.inf, 1.0)

    with pytest.raises(
        emitree.EmissionError, match="the emission rate is inf at position"
    ) as found:
        emitree.render(hole, CUBE, (8, 8))
    assert found.value.position[0] > 0.6 and found.value.rate == np.inf
    assert len(found.value.direction) == 3 and found.value.energy is None


@pytest.mark.parametrize(("result", "kind", "message"), [
    (lambda n: np.zeros((n, 1, 1)), ValueError, r"shape \(\d+, 1, 1\): expected \(\d+,\)"),
    (lambda n: 0.0, ValueError, r"shape \(\): expected"),
    (lambda n: np.zeros(n, complex), TypeError, "complex128: expected real numbers"),
    (lambda n: np.array(["a"] * n), TypeError, "expected real numbers"),
    (lambda n: None, TypeError, "expected real numbers"),
    (lambda n: np.ma.masked_array(np.zeros(n), [True] * n), ValueError, "masked"),
])  # fmt: skip
def test_other_results_are_refused(result, kind, message):
    with pytest.raises(kind, match=message):
        emitree.render(lambda position, direction: result(len(position)), CUBE, (4, 4))


class Foreign:
    """An array of another library: DLPack is all that it has."""

    def __init__(self, values):
        self.values = values

    def __dlpack__(self, **options):
        return self.values.__dlpack__(**options)

    def __dlpack_device__(self):
        return self.values.__dlpack_device__()


class Elsewhere(Foreign):
    """An array on another device, with a way of its own to this one."""

    def __dlpack__(self, **options):
        raise BufferError("on another device")

    def __array__(self, dtype=None, copy=None):
        return self.values


class OnDevice(Foreign):
    """An array on another device, which DLPack copies on request, as those of CuPy and PyTorch."""

    def __dlpack__(self, *, dl_device=None, copy=None, **options):
        if dl_device is None or not copy:
            raise BufferError("on another device")
        return self.values.__dlpack__(dl_device=dl_device, copy=copy, **options)

    def __dlpack_device__(self):
        return (2, 0)


@pytest.mark.parametrize("made", [
    Foreign,
    Elsewhere,
    OnDevice,
    list,
    lambda rates: np.repeat(rates, 2)[::2],
    lambda rates: np.ma.masked_array(rates),
])  # fmt: skip
def test_results_of_other_kinds_are_taken(made):
    found = emitree.render(lambda r, d: made(peak(r, d)), CUBE, (8, 8))
    assert np.array_equal(found.image, emitree.render(peak, CUBE, (8, 8)).image)


def test_smaller_numbers_are_taken():
    found = emitree.render(lambda r, d: peak(r, d).astype(np.float32), CUBE, (8, 8))
    np.testing.assert_allclose(found.image, emitree.render(peak, CUBE, (8, 8)).image, atol=1e-6)
    ones = emitree.render(lambda r, d: np.ones(len(r), dtype=int), CUBE, (8, 8))
    np.testing.assert_allclose(ones.image, 1.0)


def test_jax_functions():
    jax = pytest.importorskip("jax")

    @jax.jit
    def glow(position, direction):
        return jax.numpy.exp(-40 * ((position - 0.5) ** 2).sum(axis=1))

    found = emitree.render(glow, CUBE, (8, 8))
    np.testing.assert_allclose(found.image, emitree.render(peak, CUBE, (8, 8)).image, atol=1e-5)


def test_torch_functions():
    torch = pytest.importorskip("torch")
    device = "cuda" if torch.cuda.is_available() else "cpu"

    def glow(position, direction):
        at = torch.from_numpy(position).to(device)
        return torch.exp(-40 * ((at - 0.5) ** 2).sum(dim=1))

    found = emitree.render(glow, CUBE, (8, 8))
    np.testing.assert_allclose(found.image, emitree.render(peak, CUBE, (8, 8)).image, atol=1e-12)


def test_cupy_functions():
    # Its arrays are on a GPU.
    cupy = pytest.importorskip("cupy")

    def glow(position, direction):
        return cupy.exp(-40 * ((cupy.asarray(position) - 0.5) ** 2).sum(axis=1))

    found = emitree.render(glow, CUBE, (8, 8))
    np.testing.assert_allclose(found.image, emitree.render(peak, CUBE, (8, 8)).image, atol=1e-12)


STALLED = """
        from concurrent.futures import Executor, Future

        class Stalled(Executor):
            def submit(self, function, *arguments):
                print("working", flush=True)
                return Future()

        def peak(position, direction):
            raise AssertionError
"""

INTERRUPTED = {
    "function": """
        def work(position, direction):
            print("working", flush=True)
            for _ in range(12000):
                time.sleep(0.01)
            return position[:, 0]
        emitree.render(work, emitree.Canonical(), (64, 64))
    """,
    "model": """
        print("working", flush=True)
        emitree.render("sin(50*x) * exp(-r)", emitree.Canonical(), (4096, 4096), method="los",
                       steps=4000)
    """,
    "intermediate images": """
        def work(position, direction):
            print("working", flush=True)
            time.sleep(0.1)
            return np.sin(50 * position[:, 0]) * np.cos(30 * position[:, 1])
        for frame in emitree.progressive(work, emitree.Canonical(), (512, 512), tolerance=1e-5,
                                         batch_size=100):
            pass
    """,
    "a stalled worker": STALLED
    + """
        emitree.render(peak, emitree.Canonical(), (8, 8), executor=Stalled())
    """,
    "a stalled worker and intermediate images": STALLED
    + """
        list(emitree.progressive(peak, emitree.Canonical(), (8, 8), executor=Stalled()))
    """,
}


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent otherwise there")
@pytest.mark.parametrize("what", INTERRUPTED)
def test_ctrl_c_ends_a_rendering(what):
    code = "import emitree, time\nimport numpy as np\n" + textwrap.dedent(INTERRUPTED[what])
    with subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout.readline() == "working\n"
        time.sleep(0.4)
        process.send_signal(signal.SIGINT)
        try:
            # Each of them would take minutes.
            _, errors = process.communicate(timeout=30)
        finally:
            process.kill()
    assert "KeyboardInterrupt" in errors
    assert process.returncode == -signal.SIGINT


LEFT = """
import emitree
images = emitree.progressive("1 + sin(50*x) * sin(70*y)", emitree.Canonical(), (512, 512), tolerance=1e-6)
print(next(images).evaluations)
"""


def test_a_program_ends_though_a_loop_was_left_half_way():
    subprocess.run([sys.executable, "-c", LEFT], check=True, timeout=20, capture_output=True)
