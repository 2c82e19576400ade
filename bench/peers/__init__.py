"""Emitree beside other packages in use, on the same scenes and with the same counting.

`cargo xtask compare-peers` runs it; docs/peers.md is what it writes.
"""

import os

# Before NumPy is imported: its libraries read these once. Seconds are those of one thread.
for _library in ("OMP", "OPENBLAS", "MKL", "NUMEXPR"):
    os.environ[f"{_library}_NUM_THREADS"] = "1"
