"""Libraries that are used where they are there: JAX, PyTorch, scipy."""

from __future__ import annotations

import importlib
import sys
from typing import Any


def library_of(rates: Any) -> Any:
    """The module for arrays of a library that is in use, which is imported for them alone."""
    for name, kind in (("jax", "Array"), ("torch", "Tensor")):
        if name in sys.modules and isinstance(rates, getattr(sys.modules[name], kind, ())):
            return importlib.import_module(f"emitree._{name}")
    return None


def scipy(module: str) -> Any:
    """A module of scipy."""
    try:
        return importlib.import_module(f"scipy.{module}")
    except ImportError as error:
        raise ImportError(
            "scipy is missing: expected it for `matrix`, `operator` and `Particles`; "
            '`pip install "emitree[fit]"` installs it'
        ) from error
