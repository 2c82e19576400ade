"""How results are shown in notebooks."""

import base64
import io
import re

import numpy as np
import pytest
from models import peak, spectral_peak

import emitree
from emitree._display_places import places_png

CUBE = emitree.Canonical()


def opacity(png):
    """The opacity of each pixel of a PNG, the highest row first, 0 to 1."""
    image = pytest.importorskip("matplotlib.image")
    return image.imread(io.BytesIO(png))[:, :, 3]


def test_places_are_seen_along_their_shortest_side():
    corner = np.array([[0.0, 5.0, 0.0]] * 3)
    position = np.concatenate([corner, [[4.0, 5.1, 2.0]]])
    png, axis = places_png(position)
    found = opacity(png)
    assert axis == "y" and found.shape == (40, 80)
    # x is to the right, z up.
    assert found[-1, 0] == 1.0 and 0.2 < found[0, -1] < 0.9 and np.count_nonzero(found) == 2


@pytest.mark.parametrize("position", [np.zeros((0, 3)), np.ones((1, 3)), np.full((2, 3), np.nan)])
def test_few_places(position):
    png, _ = places_png(position)
    assert np.count_nonzero(opacity(png)) == np.isfinite(position[:, 0]).sum()


def test_plans_and_surfaces():
    plan = emitree.render(peak, CUBE, (8, 12)).plan
    text = plan._repr_html_()
    assert f"<td>{len(plan):,}</td>" in text and "<td>8 &times; 12</td>" in text
    base64.b64decode(re.search(r"base64,([^\"]+)", text)[1], validate=True)

    def ball(position, direction):
        return np.where(np.linalg.norm(position - 0.5, axis=1) < 0.3, 2.0, 0.5)

    surfaces = emitree.render(ball, CUBE, (32, 32)).surfaces
    text = surfaces._repr_html_()
    assert f"<th>triangles</th><td>{len(surfaces.triangles):,}</td>" in text and "(median)" in text
    assert "<th>jump</th><td>1.5 to 1.5</td>" in text


def test_cubes_have_their_spectrum():
    cube = emitree.render(spectral_peak, CUBE, (6, 8), energy={"min": 1, "max": 3, "bins": 4})
    text = cube._repr_html_()
    assert "<td>1 to 3 keV, 4 bins</td>" in text
    points = re.search(r'points="([^"]+)"', text)[1].split()
    heights = [1 - float(point.split(",")[1]) / 60 for point in points[::2]]
    means = cube.image.mean(axis=(1, 2))
    assert len(points) == 8 and np.allclose(heights, means / means.max(), atol=1e-3)


def test_components_have_their_names():
    both = emitree.render({"x < 1": "x", "y": "y"}, CUBE, (4, 4))
    text = both._repr_html_()
    assert "<b>x &lt; 1</b>" in text and "<b>y</b>" in text and text.count("<img ") == 2
