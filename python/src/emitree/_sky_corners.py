"""Corners of the pixels of a WCS on the image plane of a camera without distortions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from emitree._cameras import Camera, Equirectangular, Perspective
from emitree._cells import Integers
from emitree._function import Floats
from emitree._native import SceneError
from emitree._sky_fit import axes_at, directions_of
from emitree._sky_wcs import to_model

if TYPE_CHECKING:
    from emitree._wcs_camera import WcsCamera

#: The widest angle from the middle of a flat image to a corner [rad].
_FLAT = np.radians(50.0)
#: How far a border of a pixel may be from the straight parts that it is made of, by the side of the
#: pixel, if it is curved as much as the sides of great circles are in longitude and latitude.
_SAG = 1e-3
#: The fewest and the most straight parts of a border.
_BORDERS = (2, 8)
#: Cells of an image beside the pixels.
_MARGIN = 4
#: Pixels whose corners are in memory at once.
_TOGETHER = 1 << 18
#: A pixel that extends farther than this in longitude has a pole in or beside it [rad].
_WIDE = 0.5
#: Parts of such a pixel along each axis.
_PARTS = 16


@dataclass(frozen=True)
class Corners:
    """The pixels of a WCS as directions in the model.

    axes: rows are right, up and forward in the middle of the image; size: the side of a pixel, the
    root of the median of their areas [rad]; half: the largest |longitude| and |latitude| about the
    axes [rad], or tangents of an image that is flat.
    """

    wcs: Any
    matrix: Floats
    shape: tuple[int, int]
    axes: Floats
    size: float
    half: Floats
    is_flat: bool
    #: Straight parts of each border.
    borders: int

    @staticmethod
    def of(camera: WcsCamera) -> Corners:
        """Those of a camera."""
        sky = camera.sky
        assert sky is not None and sky.shape is not None
        height, width = sky.shape
        wcs, matrix = camera.wcs, to_model(sky)
        middle = 0.5 * np.array([width, height])
        axes = axes_at(lambda places: directions_of(wcs, matrix, places), middle)
        bare = Corners(wcs, matrix, sky.shape, axes, 0.0, np.zeros(2), False, _BORDERS[0])
        cosine, half, tangents, areas = 1.0, np.zeros(2), np.zeros(2), []
        for some, around in bare.blocks():
            number = np.flatnonzero(np.isfinite(around).all(axis=(1, 2)))
            seen = around[number]
            if len(seen) == 0:
                continue
            _refuse_folded(seen[:, :: bare.borders], number + some.start, width)
            right, up, ahead = np.moveaxis(seen @ axes.T, -1, 0)
            cosine = min(cosine, float(ahead.min()))
            angles = [np.arctan2(right, ahead), np.arcsin(np.clip(up, -1.0, 1.0))]
            half = np.maximum(half, [abs(angle).max() for angle in angles])
            if cosine > np.cos(_FLAT):
                tangents = np.maximum(tangents, [abs(of / ahead).max() for of in (right, up)])
            corner = seen[:, :: bare.borders]
            diagonals = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
            areas.append(0.5 * np.linalg.norm(np.cross(*diagonals), axis=1))
        if not areas:
            raise SceneError("`wcs` has no direction at the corners of any pixel: expected some")
        size = float(np.sqrt(np.median(np.concatenate(areas))))
        is_flat = bool(cosine > np.cos(_FLAT))
        borders = int(np.clip(np.ceil(np.sqrt(size / (8.0 * _SAG))), *_BORDERS))
        half = tangents if is_flat else half
        return Corners(wcs, matrix, sky.shape, axes, size, half, is_flat, borders)

    def directions(self, places: Floats) -> Floats:
        """Unit vectors (n, 3) of places (n, 2) in the image [pixels]; NaN where there are none."""
        return directions_of(self.wcs, self.matrix, places)

    def blocks(self) -> Iterator[tuple[slice, Floats]]:
        """Pixels, row by row, and the directions (n, 4 borders, 3) around each.

        They are counterclockwise, and every `borders`-th is a corner.
        """
        height, width = self.shape
        parts = self.borders
        each = np.arange(parts)
        ends = np.full(parts, parts)
        right = np.concatenate([each, ends, parts - each, 0 * each])
        up = np.concatenate([0 * each, each, ends, parts - each])
        rows = max(1, _TOGETHER // (width * parts))
        for low in range(0, height, rows):
            high = min(low + rows, height)
            y, x = np.mgrid[parts * low : parts * high + 1, 0 : parts * width + 1]
            places = np.stack([x, y], axis=-1).reshape(-1, 2) / parts
            lattice = self.directions(places).reshape(*x.shape, 3)
            around = [
                lattice[v : v + parts * (high - low) : parts, u : u + parts * width : parts]
                for u, v in zip(right, up, strict=True)
            ]
            found = np.stack(around, axis=2).reshape(-1, 4 * parts, 3)
            yield slice(low * width, high * width), found

    def parts(self, pixel: Integers) -> tuple[Floats, Floats]:
        """Directions (n, parts, 3) of the middles of small parts of pixels, and their areas."""
        row, column = np.divmod(pixel, self.shape[1])
        each = np.arange(_PARTS + 1) / _PARTS
        v, u = np.meshgrid(each, each, indexing="ij")
        places = np.stack([column, row], axis=-1)[:, None, None] + np.stack([u, v], axis=-1)
        at = self.directions(places.reshape(-1, 2)).reshape(len(pixel), *u.shape, 3)
        first, second = at[:, 1:, 1:] - at[:, :-1, :-1], at[:, 1:, :-1] - at[:, :-1, 1:]
        area = 0.5 * np.linalg.norm(np.cross(first, second), axis=-1)
        middle = at[:, 1:, 1:] + at[:, :-1, :-1] + at[:, 1:, :-1] + at[:, :-1, 1:]
        middle /= np.linalg.norm(middle, axis=-1, keepdims=True)
        return middle.reshape(len(pixel), -1, 3), area.reshape(len(pixel), -1)


def _refuse_folded(corners: Floats, number: Integers, width: int) -> None:
    """Refuses pixels (n, 4, 3) whose corners are not counterclockwise as the observer sees them."""
    after, before = np.roll(corners, -1, axis=1) - corners, corners - np.roll(corners, 1, axis=1)
    # Right times up is backward.
    turns = -np.einsum("ncx,ncx->nc", np.cross(before, after), corners)
    sizes = np.linalg.norm(before, axis=-1) * np.linalg.norm(after, axis=-1)
    is_wrong = (turns < -1e-6 * sizes.max(axis=1, keepdims=True)).any(axis=1)
    if is_wrong.any():
        row, column = divmod(int(number[np.argmax(is_wrong)]), width)
        raise SceneError(
            f"`wcs` is folded at the pixel in row {row} and column {column}, whose corners are not "
            "counterclockwise: expected one place in the image for each direction"
        )


@dataclass(frozen=True)
class Host:
    """An image without distortions, with the pixels of a WCS as polygons on it.

    camera: a `Perspective` or an `Equirectangular`; shape: (height, width); step: the sides of its
    cells, of tangents or angles [rad]; pad: columns that are repeated at both ends, where
    longitudes are closed.
    """

    corners: Corners
    camera: Camera
    shape: tuple[int, int]
    step: Floats
    pad: int

    @staticmethod
    def of(camera: WcsCamera, corners: Corners, finer: int) -> Host:
        """The image whose cells have sides of one `finer`-th of a pixel."""
        step = corners.size / finer
        half = corners.half + _MARGIN * step
        whole = np.array([np.pi, 0.5 * np.pi])
        is_closed = ~corners.is_flat & (half > 0.97 * whole)
        half = np.where(is_closed, whole, half)
        counts = 2 * np.ceil(half / step).astype(int)
        half = np.where(is_closed, half, 0.5 * counts * step)
        common: dict[str, Any] = {
            "position": camera.position,
            "target": (np.array(camera.position) + camera.distance * corners.axes[2]).tolist(),
            "up": corners.axes[1].tolist(),
            "near": camera.near,
            "far": camera.far,
            "length_unit": camera.length_unit,
        }
        made: Camera
        if corners.is_flat:
            angles = 2.0 * np.degrees(np.arctan(half))
            made = Perspective(field_of_view=angles.tolist(), **common)
        else:
            angles = np.where(is_closed, 2.0 * np.degrees(whole), 2.0 * np.degrees(half))
            made = Equirectangular(field_of_view=angles.tolist(), **common)
        object.__setattr__(made, "sky", camera.sky)
        width, height = (int(count) for count in counts)
        pad = int(np.ceil(_WIDE * width / (2.0 * np.pi))) + _MARGIN if is_closed[0] else 0
        return Host(corners, made, (height, width), 2.0 * half / counts, pad)

    def solid_angles(self) -> Floats:
        """The solid angles (height, 1) or (height, width) of cells, by the area of one [sr]."""
        height, width = self.shape
        y = (np.arange(height) + 0.5 - 0.5 * height)[:, np.newaxis] * self.step[1]
        if not self.corners.is_flat:
            # The mean of a cosine over a cell.
            mean = np.cos(y) * np.sinc(0.5 * self.step[1] / np.pi)
            return np.broadcast_to(mean, self.shape)
        x = (np.arange(width) + 0.5 - 0.5 * width) * self.step[0]
        nodes = 0.5 / np.sqrt(3.0) * np.array([-1.0, 1.0])
        of_nodes = [
            (1.0 + (x + right * self.step[0]) ** 2 + (y + up * self.step[1]) ** 2) ** -1.5
            for right in nodes
            for up in nodes
        ]
        return np.asarray(np.mean(of_nodes, axis=0))

    def padded(self, values: Floats) -> Floats:
        """An image with its ends repeated where longitudes are closed."""
        return np.pad(values, [(0, 0), (self.pad, self.pad)], "wrap") if self.pad else values

    def places(self, directions: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """Places (n, k, 2) in the padded image of directions (n, k, 3) around pixels.

        And which pixels (n,) have such: others have no direction somewhere on their border, or a
        pole in or beside them.
        """
        on_plane = self._on_plane(directions)
        is_seen = np.asarray(np.isfinite(directions).all(axis=(1, 2)))
        if not self.corners.is_flat:
            # Longitudes of a pixel are near those of its first corner.
            first = on_plane[:, :1, 0]
            apart = on_plane[..., 0] - first
            on_plane[..., 0] = first + apart - 2.0 * np.pi * np.round(apart / (2.0 * np.pi))
            is_seen = is_seen & (np.ptp(on_plane[..., 0], axis=1) <= _WIDE)
        found = on_plane / self.step + 0.5 * np.array(self.shape)[::-1] + np.array([self.pad, 0])
        return found, is_seen

    def cells(self, directions: Floats) -> tuple[Integers, Integers]:
        """Rows and columns of the cells (...) in which directions (..., 3) are."""
        found = self._on_plane(directions) / self.step + 0.5 * np.array(self.shape)[::-1]
        column, row = np.floor(np.moveaxis(found, -1, 0)).astype(np.int64)
        height, width = self.shape
        return np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)

    def _on_plane(self, directions: Floats) -> Floats:
        right, up, ahead = np.moveaxis(directions @ self.corners.axes.T, -1, 0)
        if self.corners.is_flat:
            return np.stack([right / ahead, up / ahead], axis=-1)
        return np.stack([np.arctan2(right, ahead), np.arcsin(np.clip(up, -1.0, 1.0))], axis=-1)
