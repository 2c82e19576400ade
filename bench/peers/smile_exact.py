"""The exact image of the scene `smile`, twice: `python -m peers.smile_exact`.

A line of sight is cut where it crosses the magnetopause or the bow shock, and integrated by Gauss
panels between: to rounding. Over pixels its radiance has folds, where lines touch a surface.
Parts of pixels are therefore halved both ways, until they agree with their quarters.
"""

import time

import numpy as np
from scipy.optimize.elementwise import find_root

from . import gauss, smile
from .scene import relative_error

#: Lines that are integrated together: their arrays stay small.
TOGETHER = 2048
#: How often parts of pixels may be halved.
DEEPEST = 12
#: What quarters may change of a pixel, in the unit of the image, where the largest pixel is 6.5.
CHANGE = 1e-6


class Sights:
    """Lines of sight with a coordinate t along them, close-meshed near the Earth.

    The distance from the observer is s = middle + scale sinh t, the middle where the line comes
    closest to the Earth, the scale how close that is.
    """

    def __init__(self, directions: np.ndarray):
        self.directions = directions
        self.middle = -directions @ np.array(smile.CAMERA.position)
        closest = np.square(smile.CAMERA.position).sum() - self.middle**2
        self.scale = np.sqrt(np.maximum(closest, 1.0))
        self.start = np.arcsinh(-self.middle / self.scale)
        self.end = np.arcsinh((smile.CAMERA.far - self.middle) / self.scale)

    def positions(self, t: np.ndarray, at=slice(None)):
        """Coordinates x, y and z at t (n, ...) of the lines `at`."""
        more = (slice(None),) + (None,) * (t.ndim - 1)
        s = self.middle[at][more] + self.scale[at][more] * np.sinh(t)
        for axis, start in enumerate(smile.CAMERA.position):
            yield start + s * self.directions[at][:, axis][more]

    def heights(self, t: np.ndarray, at=slice(None)):
        """Heights above both surfaces at t (n, ...) of the lines `at`."""
        return smile.heights(*self.positions(t, at))


def radiances(directions: np.ndarray, samples: int, panels: int, nodes: int) -> np.ndarray:
    """The integrals (n,) of the rate along lines of sight (n, 3).

    samples: places on a line between which surfaces are searched. panels, nodes: how many panels
        the quadrature has at least, and nodes in each.
    """
    sights = Sights(directions)
    share = np.linspace(0, 1, samples)
    t = sights.start[:, None] + (sights.end - sights.start)[:, None] * share
    crossings = [
        _crossings(sights, which, t, height) for which, height in enumerate(sights.heights(t))
    ]
    even = sights.start[:, None] + (sights.end - sights.start)[:, None] * np.linspace(
        0, 1, panels + 1
    )
    edges = np.sort(np.concatenate([even, *crossings], axis=1), axis=1)
    node, weight = gauss.nodes(nodes)
    width = np.diff(edges)
    t = edges[:, :-1, None] + width[..., None] * node
    # The middle of a panel decides in which of the three regions it is.
    above = sights.heights(edges[:, :-1] + 0.5 * width)
    in_sheath = smile.sheath(*sights.positions(t))
    in_wind = smile.wind(*sights.positions(t))
    rates = np.where(above[1][..., None] < 0, in_sheath, in_wind)
    rates = np.where(above[0][..., None] < 0, 0.0, rates) * np.cosh(t)
    return sights.scale * ((rates @ weight) * width).sum(axis=1)


def _crossings(sights: Sights, which: int, t: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Where lines cross a surface (n, most of one line), the ends of the lines where they don't."""
    line, low, high = _brackets(sights, which, t, height)
    at = np.full((len(t), 1), 0.0) + sights.end[:, None]
    if not len(line):
        return at
    height_at = lambda t, line: sights.heights(t, line.astype(int))[which]  # noqa: E731
    root = find_root(height_at, (low, high), args=(line,))
    if not root.success.all():
        raise ArithmeticError("a crossing of a surface was not found")
    order = np.argsort(line, kind="stable")
    line, found = line[order], root.x[order]
    number = np.arange(len(line)) - np.searchsorted(line, line)
    at = np.repeat(at, number.max() + 1, axis=1)
    at[line, number] = found
    return at


def _brackets(sights: Sights, which: int, t: np.ndarray, height: np.ndarray):
    """Lines, and pairs of t between which they cross a surface once.

    Between samples on one side a line may touch the other: the vertex of the parabola through
    three of them shows it.
    """
    side = height > 0
    line, left = np.nonzero(side[:, 1:] != side[:, :-1])
    pairs = [(line, t[line, left], t[line, left + 1])]
    a, b, c = (np.abs(height[:, i : i + t.shape[1] - 2]) for i in range(3))
    same = (side[:, :-2] == side[:, 1:-1]) & (side[:, 1:-1] == side[:, 2:])
    line, left = np.nonzero(same & (b <= a) & (b < c))
    a, b, c = (height[line, left + i] for i in range(3))
    step = t[line, 1] - t[line, 0]
    vertex = t[line, left + 1] + 0.5 * step * (a - c) / (a - 2 * b + c)
    through = (sights.heights(vertex, line)[which] > 0) != side[line, left]
    line, left, vertex = line[through], left[through], vertex[through]
    pairs += [(line, t[line, left], vertex), (line, vertex, t[line, left + 2])]
    return tuple(np.concatenate(parts) for parts in zip(*pairs, strict=True))


def image(chosen: np.ndarray, parts: int, order: int, **lines: int) -> tuple[np.ndarray, int]:
    """The means over the pixels that are chosen, 0 elsewhere, and how many lines were integrated.

    Pixels consist of parts x parts, which are halved as often as they need, with order x order
    lines in each. lines: keywords of `radiances`.
    """
    shape = chosen.shape
    total, count = np.zeros(shape), 0
    size = 1.0 / (np.array(shape[::-1]) * parts)
    row, column = np.nonzero(np.repeat(np.repeat(chosen, parts, axis=0), parts, axis=1))
    corner = np.stack([column, row], axis=1) * size
    share = np.full(len(corner), parts**-2.0)
    value = _means(corner, size, order, lines)
    count += len(corner) * order**2
    for _ in range(DEEPEST):
        size = size / 2
        quarters = corner[:, None] + size * np.array([[0, 0], [0, 1], [1, 0], [1, 1]])
        values = _means(quarters.reshape(-1, 2), size, order, lines).reshape(-1, 4)
        count += values.size * order**2
        open_ = share * np.abs(values.mean(axis=1) - value) > CHANGE
        closed = ~open_
        column, row = ((corner[closed] + size) * shape[::-1]).astype(int).T
        np.add.at(total, (row, column), share[closed] * values[closed].mean(axis=1))
        corner, value = quarters[open_].reshape(-1, 2), values[open_].ravel()
        share = np.repeat(share[open_], 4) / 4
        if not len(corner):
            return total / smile.CAMERA.pixel_angles(shape), count
    raise ArithmeticError(f"{len(corner)} parts of pixels do not agree with their quarters")


def _means(corner: np.ndarray, size: np.ndarray, order: int, lines: dict) -> np.ndarray:
    """The means (n,) of radiance times solid angle over parts of the image with corners (n, 2)."""
    node, weight = gauss.nodes(order)
    x, y = (corner[:, axis, None] + size[axis] * node for axis in range(2))
    x, y = np.broadcast_arrays(x[:, None, :], y[:, :, None])
    directions = smile.CAMERA.directions(x, y).reshape(-1, 3)
    values = [
        radiances(directions[start : start + TOGETHER], **lines)
        for start in range(0, len(directions), TOGETHER)
    ]
    values = np.concatenate(values).reshape(x.shape) * smile.CAMERA.solid_angle(y)
    return (values @ weight) @ weight


#: Two ways that share no node.
WAYS = {
    "exact": {"parts": 5, "order": 3, "samples": 150, "panels": 8, "nodes": 10},
    "check": {"parts": 4, "order": 3, "samples": 180, "panels": 9, "nodes": 8},
}
#: Where they differ by more, relative to the largest pixel, parts agreed by chance: they are made
#: anew from smaller ones.
DOUBTFUL = 1e-6
SMALLER = 3


def both(chosen: np.ndarray, smaller: int = 1) -> dict[str, np.ndarray]:
    """The pixels that are chosen, both ways, with parts so many times smaller."""
    images = {}
    for name, way in WAYS.items():
        start = time.monotonic()
        images[name], count = image(chosen, **(way | {"parts": smaller * way["parts"]}))
        seconds = time.monotonic() - start
        print(f"{name}: {chosen.sum()} pixels, {count:,} lines, {seconds:.0f} s", flush=True)
    return images


def main() -> None:
    """Makes both images, prints how they agree, and writes them to their file."""
    images = both(np.ones(smile.SCENE.shape, dtype=bool))
    off = np.abs(images["check"] - images["exact"]) > DOUBTFUL * images["exact"].max()
    again = both(off, SMALLER)
    images = {name: np.where(off, again[name], image) for name, image in images.items()}
    print(f"they differ by {relative_error(images['check'], images['exact']):.1e}")
    np.savez(smile.IMAGES, **images)


if __name__ == "__main__":
    main()
