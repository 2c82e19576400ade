"""What a view shows of an image: numbers in a few bytes, for a browser and for a saved notebook."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emitree._cameras import Healpix
from emitree._function import Floats
from emitree._progressive import Frame
from emitree._render import render
from emitree._result import Rendering

#: The most pixels of a picture: 8 bytes each, within what servers of notebooks pass on at once.
MOST_PIXELS = 200_000

#: How many rows the map of a whole sky has.
_SKY_ROWS = 200

#: What `sky_pixels` found.
_SKIES: dict[int, NDArray[np.int64]] = {}

State = dict[str, Any]


def picture_of(found: Rendering | Frame, is_sky: bool) -> State:
    """The state of a picture, with its arrays as bytes.

    width, height: of the picture in its own pixels, of which each is the mean of block x block
        pixels of the image. Of a whole sky it is a map in Mollweide's projection.
    image: 32-bit floats, in units of `image_scale`.
    error: the largest estimated error in each pixel, and evaluations: per pixel; both in the upper
        16 bits of 32-bit floats, with a scale. None if they are not known.
    axes: of x and of y the name, the unit, and the first and the last centre; None of skies.
    bins: how many a cube has; 0 of an image, or if that is not known yet.
    """
    image = band_of(found)
    arrays: dict[str, Floats | None] = {
        "image": image,
        "error": error_of(found),
        "evaluations": None,
    }
    axes, unit, quantity, bins = [], "", "value", 0
    if isinstance(found, Rendering):
        arrays["evaluations"] = found.evaluations_per_pixel
        unit, quantity = found._found.flat_unit, found.report["image"]["quantity"]
        bins = 0 if found.energies is None else len(found.energies) - 1
        for name, unit_of_axis, places in found._found.axes():
            ends = [float(places[0]), float(places[-1])]
            axes.append({"name": name, "unit": unit_of_axis or "", "ends": ends})
    if is_sky:
        numbers = sky_pixels(image.shape[1])
        image = _on_sky(image, numbers)
        for name, array in arrays.items():
            arrays[name] = None if array is None else _on_sky(array, numbers)
    block = math.ceil(math.sqrt(image.size / MOST_PIXELS))
    state: State = {"block": block, "axes": axes or None, "bins": bins}
    state |= {"unit": unit, "quantity": quantity}
    for name, array in arrays.items():
        if array is not None:
            array = _blocks(array, block, np.fmax if name == "error" else None)
            state["height"], state["width"] = array.shape
            state[f"{name}_scale"], array = _scaled(array)
        state[name] = None if array is None else _encoded(array, name == "image")
    return state


def size_of(state: State) -> int:
    """How many bytes the arrays of a picture take."""
    return sum(len(value) for value in state.values() if isinstance(value, bytes))


def band_of(found: Rendering | Frame) -> Floats:
    """The image (height, width); of a cube, the whole band."""
    return found.image if isinstance(found, Frame) else found.flat_image


def error_of(found: Rendering | Frame) -> Floats | None:
    """The estimated error of each pixel of `band_of`.

    Of a finished cube it is the sum over its bins, which is at least the error of the band.
    """
    if isinstance(found, Frame) or found.error is None or found.error.ndim == 2:
        return found.error
    assert found.energies is not None, "a cube has energies"
    steps = np.diff(found.energies)[:, np.newaxis, np.newaxis]
    # The image may be in another unit than that of the bins times the steps.
    sums = np.nansum(np.abs((found.image * steps).sum(axis=0))), np.nansum(np.abs(found.flat_image))
    factor = sums[1] / sums[0] if sums[0] > 0 else 1.0
    return (found.error * steps).sum(axis=0) * factor


def spectrum_at(found: Rendering, row: int, column: int, block: int, is_sky: bool) -> State | None:
    """The spectrum of a pixel of the picture: the means over its pixels of the image."""
    if found.energies is None:
        return None
    if is_sky:
        numbers = sky_pixels(found.image.shape[2])
        if numbers[row, column] < 0:
            return None
        row, column = divmod(int(numbers[row, column]), found.image.shape[2])
        block = 1
    part = np.s_[:, row * block : (row + 1) * block, column * block : (column + 1) * block]
    values = found.image[part]
    seen = ~np.isnan(values).any(axis=0)
    if not seen.any():
        return None
    errors = None if found.error is None else found.error[part][:, seen].mean(axis=1).tolist()
    return {
        "values": values[:, seen].mean(axis=1).tolist(),
        "errors": errors,
        "energies": found.energies.tolist(),
        "unit": found.unit,
        "energy_unit": found.energy_unit or "",
    }


def sky_pixels(nside: int) -> NDArray[np.int64]:
    """The number of the pixel (row * nside + column) at each place of the map of a sky; -1 outside.

    >>> sky_pixels(4).shape, int(sky_pixels(4).max())
    ((200, 400), 191)
    """
    if nside not in _SKIES:
        camera = Healpix(position=(0, 0, 0), near=0, far=1)
        found = render("1", camera, nside, method="los", steps=1)._found
        kind, (account, values, *others) = found.__reduce__()
        numbers = np.arange(values.size, dtype=np.float64).reshape(values.shape)
        places = kind(account, numbers, *others).picture(_SKY_ROWS)
        _SKIES[nside] = np.where(np.isnan(places), -1, places).astype(np.int64)
    return _SKIES[nside]


def _on_sky(array: Floats, numbers: NDArray[np.int64]) -> Floats:
    return np.where(numbers < 0, np.nan, array.ravel()[numbers])


def _blocks(array: Floats, block: int, largest: Any = None) -> Floats:
    """The means over block x block pixels, or their largest, without those that are no numbers."""
    if block == 1:
        return np.asarray(array, dtype=np.float64)
    height, width = (math.ceil(side / block) for side in array.shape)
    padded = np.full((height * block, width * block), np.nan)
    padded[: array.shape[0], : array.shape[1]] = array
    of_blocks = padded.reshape(height, block, width, block)
    if largest is not None:
        found: Floats = largest.reduce(of_blocks, axis=(1, 3))
        return found
    seen = ~np.isnan(of_blocks)
    count = seen.sum(axis=(1, 3))
    sums = np.where(seen, of_blocks, 0.0).sum(axis=(1, 3))
    return np.where(count > 0, sums / np.maximum(count, 1), np.nan)


def _scaled(array: Floats) -> tuple[float, Floats]:
    """The largest finite |value|, and the array in units of it."""
    finite = np.abs(array[np.isfinite(array)])
    scale = float(finite.max(initial=0.0)) or 1.0
    return scale, array / scale


def _encoded(array: Floats, is_precise: bool) -> bytes:
    single = np.ascontiguousarray(array, dtype="<f4")
    if is_precise:
        return single.tobytes()
    bits = single.view("<u4")
    # Rounded to the nearest; a number that is not finite stays so.
    rounded = np.where(np.isfinite(single), bits + np.uint32(0x8000), bits)
    return (rounded >> np.uint32(16)).astype("<u2").tobytes()
