"""The overhead of a call from the renderer to a function in Python and back, for each point.

    python benches/overhead.py

The function does nothing, so that the time spent in the emission is that of the crossing: a copy of
positions and directions into arrays that the function may keep, the hand-over to the thread that
called, the call, and a copy of the rates.
"""

import numpy as np

import emitree

#: The limit for batches of 10^5 points [ns].
LIMIT_NS = 100.0
ROUNDS = 7


def overhead_ns(batch_size: int) -> float:
    """The least of several measurements [ns for each evaluation]."""
    ones = np.ones(batch_size)

    def nothing(position, direction):
        return ones[: len(position)]

    found = []
    for _ in range(ROUNDS):
        rendering = emitree.render(
            nothing,
            emitree.Canonical(),
            (128, 128),
            method="los",
            steps=64,
            batch_size=batch_size,
        )
        found.append(1e9 * rendering.report["seconds"]["emission"] / rendering.evaluations)
    return min(found)


def main() -> None:
    """Measures, prints and checks."""
    print("batch size   ns for each evaluation")
    for batch_size in (1_000, 10_000, 100_000, 1_000_000):
        print(f"{batch_size:10,}   {overhead_ns(batch_size):8.2f}")
    at_limit = overhead_ns(100_000)
    assert at_limit < LIMIT_NS, f"{at_limit} ns at batches of 100,000: expected below {LIMIT_NS}"


if __name__ == "__main__":
    main()
