"""NumPy's .npz with a name and a version."""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Sequence
from typing import Any

import numpy as np


def encoded(file_format: str, version: int, arrays: dict[str, Any]) -> bytes:
    """The bytes of a file with some arrays."""
    buffer = io.BytesIO()
    np.savez_compressed(buffer, format=file_format, version=version, **arrays)
    return buffer.getvalue()


def arrays_of(
    path: str | os.PathLike[str], what: str, file_format: str, version: int, entries: Sequence[str]
) -> dict[str, Any]:
    """The arrays of a file.

    what: its content, for messages; version: the highest that is known; entries: the arrays that
        have to be there.

    Raises `ValueError` with the name of a file that is of another kind, or not complete.
    """
    name = os.fspath(path)
    expected = f'expected {what}, .npz with the `format` "{file_format}"'
    try:
        with open(path, "rb") as file:
            loaded = np.load(file, allow_pickle=False)
            is_array = isinstance(loaded, np.ndarray)
            arrays = {} if is_array else {key: loaded[key] for key in loaded}
    except (zipfile.BadZipFile, EOFError, ValueError) as error:
        raise ValueError(f"{name}: not a file of NumPy, or damaged: {expected}") from error
    if is_array:
        raise ValueError(f"{name}: an array: {expected}")
    found = str(arrays["format"]) if "format" in arrays else None
    if found != file_format:
        raise ValueError(f"{name}: the `format` is {found!r}: {expected}")
    of_file = int(arrays["version"])
    if not 1 <= of_file <= version:
        raise ValueError(f"{name}: {what} of version {of_file}: expected version 1 to {version}")
    missing = [key for key in entries if key not in arrays]
    if missing:
        raise ValueError(f"{name}: {what} without `{missing[0]}`: expected a complete file")
    return arrays
