"""The exact image of `zodi` by quadrature: `python -m peers.zodi_exact` writes zodi_exact.npz.

Lines of sight are cut where the rate has kinks, in the planes of the cloud and of the ring, and
into short panels near the Earth, where the ring and the inner edges of the bands are. Pixels are
means over order x order Gauss nodes, more finely near the ecliptic. The two ways share no panel.
"""

import time

import numpy as np

from . import gauss, zodi
from .scene import relative_error

#: Panels end at these distances [AU], counted as shares of the line beyond the first ones.
NEAR = 1.6
#: How many lines are integrated at once.
TOGETHER = 400
#: Two ways: lines through a pixel along each axis, panels near and far, nodes in each panel.
WAYS = {
    "exact": {"order": 4, "near": 20, "far": 8, "nodes": 12},
    "check": {"order": 3, "near": 17, "far": 7, "nodes": 10},
}
#: Centre, inclination and node [degrees] of the planes with kinks: the cloud's, the ring's.
PLANES = (
    ((0.011887800744346281, 0.0054765064662263777, -0.0021530908020710744), 2.03351881, 77.6579556),
    ((0.0, 0.0, 0.0), 0.48707166, 22.27897968),
)


def radiances(directions: np.ndarray, near: int, far: int, nodes: int) -> np.ndarray:
    """The integrals (n,) along lines of sight with directions (n, 3)."""
    end = zodi.CAMERA.lengths(directions)
    short = np.minimum(NEAR, end)
    share_near, share_far = np.linspace(0, 1, near + 1), np.linspace(0, 1, far + 1)[1:]
    borders = [short[:, None] * share_near, short[:, None] + (end - short)[:, None] * share_far]
    for centre, inclination, node in PLANES:
        inclination, node = np.radians(inclination), np.radians(node)
        sine = np.sin(inclination)
        normal = np.array([np.sin(node) * sine, -np.cos(node) * sine, np.cos(inclination)])
        height = (np.array(zodi.EARTH) - centre) @ normal
        with np.errstate(divide="ignore"):
            crossing = -height / (directions @ normal)
        # Where it is not on the line, an end of it stands for it: a panel of no length.
        borders.append(np.clip(crossing, 0, end)[:, None])
    borders = np.sort(np.concatenate(borders, axis=1), axis=1)
    node, weight = gauss.nodes(nodes)
    length = np.diff(borders, axis=1)
    s = borders[:, :-1, None] + length[..., None] * node
    places = (start + s * directions[:, axis, None, None] for axis, start in enumerate(zodi.EARTH))
    return np.einsum("ij,ijk,k->i", length, zodi.rate(*places), weight)


def image(order: int, **lines: int) -> np.ndarray:
    """The means over pixels of order x order lines."""
    camera, (height, width) = zodi.CAMERA, zodi.SCENE.shape
    node, weight = gauss.panels(width, order)[0], gauss.nodes(order)[1]
    found = np.empty((height, width))
    for row in range(height):
        y = (row + gauss.nodes(order)[0]) / height
        directions = camera.directions(node, y[:, None]).reshape(-1, 3)
        parts = np.array_split(directions, max(1, len(directions) // TOGETHER))
        values = np.concatenate([radiances(part, **lines) for part in parts])
        values = values.reshape(order, width, order) * camera.solid_angle(y)[:, None, None]
        found[row] = np.einsum("iaj,i,j->a", values, weight, weight)
    return found / camera.pixel_angles(zodi.SCENE.shape)


def main() -> None:
    """Makes both images, prints how they agree, and writes them to their file."""
    images = {}
    for name, way in WAYS.items():
        start = time.monotonic()
        images[name] = image(**way)
        print(f"{name}: {time.monotonic() - start:.0f} s", flush=True)
    print(f"they differ by {relative_error(images['check'], images['exact']):.1e}")
    # Half the digits are enough, and the file is small.
    np.savez_compressed(zodi.IMAGES, **{k: v.astype(np.float32) for k, v in images.items()})


if __name__ == "__main__":
    main()
