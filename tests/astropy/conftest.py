"""The sample files, and the image that they hold."""

import os
from pathlib import Path

import numpy as np
import pytest

HEIGHT, WIDTH = 7, 5


@pytest.fixture(scope="session")
def samples() -> Path:
    """The folder that the example `write_samples` has filled."""
    folder = os.environ.get("EMITREE_SAMPLES")
    if folder is None:
        pytest.fail("set EMITREE_SAMPLES to the folder that `write_samples` has filled")
    return Path(folder)


@pytest.fixture(scope="session")
def image() -> np.ndarray:
    """row * 1000 + column + 1/4, row 0 the lowest y."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    return rows * 1000.0 + columns + 0.25


@pytest.fixture(scope="session")
def error(image: np.ndarray) -> np.ndarray:
    """The error map: values below zero, one that is no number, one infinite."""
    error = image * -0.001
    error[1, 2] = np.nan
    error[2, 2] = np.inf
    return error
