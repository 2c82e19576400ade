"""Emitree beside the packages that people use today, on the same scenes and counted alike.

`cargo xtask compare-peers` runs it; docs/peers.md is what it writes.
"""

import os

# Before NumPy is imported: its libraries read these once. Seconds are those of one thread.
for _library in ("OMP", "OPENBLAS", "MKL", "NUMEXPR"):
    os.environ[f"{_library}_NUM_THREADS"] = "1"
