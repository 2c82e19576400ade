"""The time of a rendering whose emission takes 10 ms a point, by the number of workers.

    python benches/workers.py
    python benches/workers.py --engine dask --workers 16
    python benches/workers.py --engine ray --workers 16

The workers sleep: they are as many as are asked for, whatever the number of processors. Each row
compares the measured time with the model of docs/guide.md, "Clusters",

    time = overhead + batches x latency + evaluations x cost / workers.

The overhead is the time of the same rendering by a function that takes no time. The latency of the
model is half the cost of a point, and the time in which each worker is sent a part: the measured
time of a call of the engine, for each worker. The measured latency is that with which the model has
the measured time. The efficiency is evaluations x cost / (workers x time).
"""

import argparse
import contextlib
import functools
import time

import numpy as np

import emitree
from emitree._call_times import seconds_per_call
from emitree._engines import engine_of

#: The time of a point [s].
COST = 0.01

#: At 64 workers, for the larger rendering.
LEAST_EFFICIENCY = 0.8

VIEW = emitree.Perspective(
    position=(6, 0, 1), target=(0, 0, 0), field_of_view=(40, 40), near=0, far=12
)


def torus(position, direction):
    """A torus with a Gaussian section, tilted by half a radian."""
    x, y, z = position.T
    y, z = np.cos(0.5) * y - np.sin(0.5) * z, np.sin(0.5) * y + np.cos(0.5) * z
    return np.exp(-((np.hypot(x, y) - 1.2) ** 2 + z**2) / (2 * 0.3**2))


def planet(position, direction):
    """The airglow of a planet with a day and a night: it falls with the height."""
    radius = np.linalg.norm(position, axis=1)
    return np.exp(-(radius - 1) / 0.1) * (1 + 0.5 * position[:, 0] / radius)


def slow(cost, position, direction):
    """The torus, and the time that it takes [s a point]."""
    time.sleep(cost * len(position))
    return torus(position, direction)


@contextlib.contextmanager
def workers_of(name, workers):
    """What `executor` is, with so many workers."""
    if name == "threads":
        from concurrent.futures import ThreadPoolExecutor

        with ThreadPoolExecutor(workers) as executor:
            yield executor
    elif name == "dask":
        import distributed

        # Two processes, as most machines of this benchmark have few processors.
        options = {"host": "127.0.0.1", "dashboard_address": None}
        cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=workers // 2, **options)
        with cluster, distributed.Client(cluster) as client:
            yield client
    else:
        import ray

        ray.init(num_cpus=workers, include_dashboard=False, log_to_driver=False)
        yield ray
        ray.shutdown()


def batches() -> None:
    """Prints how many batches some renderings have."""
    print("64 x 64 pixels   tolerance   evaluations   batches   points a batch")
    ball = emitree.Sphere(center=(0, 0, 0), radius=1.0)
    near = emitree.Perspective(
        position=(4, 0, 0.5), target=(0, 0, 0), field_of_view=(40, 40), near=0, far=8
    )
    scenes = [("torus", torus, VIEW, {}), ("planet", planet, near, {"occulters": [ball]})]
    for name, emission, camera, options in scenes:
        for tolerance in (0.01, 1e-3, 1e-4):
            found = emitree.render(emission, camera, (64, 64), tolerance=tolerance, **options)
            number, batches = found.evaluations, found.report["batches"]
            print(f"{name:14}   {tolerance:9}   {number:11,}   {batches:7}", end="")
            print(f"   {number / batches:14,.0f}")


def measure(name: str, counts: list[int], tolerance: float) -> float:
    """Measures, prints and compares with the model; the efficiency with the most workers."""
    emission = functools.partial(slow, COST)
    start = time.perf_counter()
    alone = emitree.render(torus, VIEW, (64, 64), tolerance=tolerance)
    overhead = time.perf_counter() - start
    print(f"\n{name}, tolerance {tolerance}: {alone.evaluations:,} evaluations", end=" ")
    print(f"in {alone.report['batches']} batches, overhead {overhead:.2f} s")
    print("workers   call [ms]   latency [ms]   model [s]   time [s]   efficiency   parts")
    efficiency = 0.0
    for workers in counts:
        with workers_of(name, workers) as executor:
            # Workers import what they need, and the time of a point becomes known.
            emitree.render(emission, VIEW, (2, 2), tolerance=0.5, executor=executor)
            start = time.perf_counter()
            found = emitree.render(emission, VIEW, (64, 64), tolerance=tolerance, executor=executor)
            seconds = time.perf_counter() - start
            call = seconds_per_call(engine_of(executor))
        assert np.array_equal(found.image, alone.image), "the bits are those of one worker"
        work = found.evaluations * COST / workers
        batches, parts = found.report["batches"], found.report["executor"]["parts"]
        model = overhead + batches * (0.5 * COST + workers * call) + work
        latency = (seconds - overhead - work) / batches
        efficiency = work / seconds
        print(f"{workers:7}   {1e3 * call:9.2f}   {1e3 * latency:12.1f}   {model:9.2f}", end="")
        print(f"   {seconds:8.2f}   {efficiency:10.3f}   {parts:5}", flush=True)
    return efficiency


def main() -> None:
    """Measures, prints and checks."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--engine", choices=["threads", "dask", "ray"], default="threads")
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2, 4, 8, 16, 32, 64])
    given = parser.parse_args()
    batches()
    measure(given.engine, given.workers, 1e-3)
    efficiency = measure(given.engine, given.workers[-1:], 3e-5)
    if given.engine == "threads" and given.workers[-1] == 64:
        text = f"{efficiency:.3f} with 64 workers: expected at least {LEAST_EFFICIENCY}"
        assert efficiency > LEAST_EFFICIENCY, text


if __name__ == "__main__":
    main()
