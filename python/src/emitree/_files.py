"""Files that are whole or absent."""

from __future__ import annotations

import errno
import os
from typing import Any

from emitree import _native


def written(encoded: bytes, path: str | os.PathLike[str] | None, overwrite: bool) -> Any:
    """The bytes of a FITS file in a file; or as an HDUList without a path."""
    if path is None:
        from astropy.io import fits

        return fits.HDUList.fromstring(encoded)
    if not overwrite and os.path.lexists(path):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), os.fspath(path))
    with _native.OutputFile(path) as output:
        output.commit(encoded)
    return None
