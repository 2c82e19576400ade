"""Emissions that the tests render, in a module that worker processes can import."""

import functools
import math
import os
import signal
import time

import numpy as np

import emitree

ALPHA = 40.0


def peak(position, direction):
    """A Gaussian peak in the middle of the unit cube."""
    return np.exp(-ALPHA * ((position - 0.5) ** 2).sum(axis=1))


def counted(model, calls):
    """A model of parameters; `calls` gets the number of points of each call of its emissions."""

    def of_parameters(*values, **named):
        emission = model(*values, **named)

        def of_points(position, direction):
            calls.append(len(position))
            return emission(position, direction)

        return of_points

    return of_parameters


def spectral_peak(position, direction, energy):
    """The same with a spectrum that falls with energy."""
    return peak(position, direction) * np.exp(-energy)


def perspective_in_km():
    """A camera that sees the peak from outside of the unit cube."""
    return emitree.Perspective(
        position=(3, 0.5, 0.5),
        target=(0, 0.5, 0.5),
        field_of_view=(30, 30),
        near=1,
        far=5,
        length_unit="km",
    )


def slow_peak(position, direction):
    """The same, 1 microsecond a point and 2 ms a call."""
    time.sleep(0.002 + 1e-6 * len(position))
    return peak(position, direction)


def failing(position, direction):
    """A model with a mistake."""
    raise ZeroDivisionError("a mistake of the model")


def dying(position, direction):
    """A model that takes its process with it."""
    os._exit(1)


class Watched:
    """The peak, whose calls are written to a folder: the process, and the number of points.

    dies_at: after this many calls one process is killed, in the middle of its next call.
    stalls_at: after this many calls one process stays in its next call until `release`.
    seconds: how long a call takes.
    """

    def __init__(self, folder, dies_at=None, stalls_at=None, seconds=0.002):
        self.folder = str(folder)
        self.dies_at = dies_at
        self.stalls_at = stalls_at
        self.seconds = seconds

    def __call__(self, position, direction):
        self._write("calls", f"{os.getpid()} {len(position)}")
        if self.dies_at is not None and len(self.calls()) > self.dies_at:
            if not self._has("killed"):
                self._write("killed", str(len(position)))
                # Until what this process gave before has arrived.
                time.sleep(0.3)
                os.kill(os.getpid(), getattr(signal, "SIGKILL", signal.SIGTERM))
        if self.stalls_at is not None and len(self.calls()) > self.stalls_at:
            if not self._has("stalled"):
                self._write("stalled", str(len(position)))
                # At most a minute, so that a failed test ends.
                for _ in range(6000):
                    if self._has("released"):
                        break
                    time.sleep(0.01)
                self._write("resumed", str(len(position)))
        time.sleep(self.seconds)
        return peak(position, direction)

    def release(self):
        """The process that stalls goes on."""
        self._write("released", "")

    def is_stalled(self):
        """Whether a process is in the call in which it stalls."""
        return self._has("stalled") and not self._has("resumed")

    def calls(self):
        """Each call: its process, and its number of points."""
        with open(os.path.join(self.folder, "calls")) as file:
            return [tuple(map(int, line.split())) for line in file]

    def points(self):
        """How many points were evaluated, or at least begun."""
        return sum(points for _, points in self.calls())

    def processes(self):
        """The processes that were called."""
        return {process for process, _ in self.calls()}

    def lost(self):
        """How many points the killed process had been given."""
        with open(os.path.join(self.folder, "killed")) as file:
            return sum(map(int, file))

    def _has(self, name):
        return os.path.exists(os.path.join(self.folder, name))

    def _write(self, name, line):
        with open(os.path.join(self.folder, name), "a") as file:
            file.write(f"{line}\n")


def loaded(folder, width):
    """Makes a peak, as from a large file; each time it writes the process to a folder."""
    with open(os.path.join(folder, "loaded"), "a") as file:
        file.write(f"{os.getpid()}\n")
    time.sleep(0.1)
    return functools.partial(_of_width, width)


def _of_width(width, position, direction):
    time.sleep(0.002)
    return np.exp(-((position - 0.5) ** 2).sum(axis=1) / width)


def rendering(position, direction):
    """A model that renders another one, the same pixel for each point."""
    inner = emitree.render(peak, emitree.Canonical(), (2, 2))
    return np.full(len(position), inner.image[0, 0])


def spectral(position, direction, energy):
    """The peak with an exponential spectrum."""
    return peak(position, direction) * np.exp(-energy)


def exact_peak(height, width):
    """The means of the image of `peak` over pixels: products of error functions."""

    def means(count):
        root = math.sqrt(ALPHA)
        primitive = [math.erf(root * (i / count - 0.5)) for i in range(count + 1)]
        return 0.5 * math.sqrt(math.pi / ALPHA) * np.diff(primitive) * count

    return means(height)[:, None] * means(width) * means(1)


def rendered(shape):
    """A rendering, for workers that give back all of it."""
    return emitree.render(peak, emitree.Canonical(), shape)


def torus(radius, width, height, tilt):
    """A tilted torus with a Gaussian section."""
    c, s = np.cos(tilt), np.sin(tilt)

    def rate(position, direction):
        x, y, z = position.T
        y, z = c * y - s * z, s * y + c * z
        return height * np.exp(-((np.hypot(x, y) - radius) ** 2 + z**2) / (2 * width**2))

    return rate
