"""Draws found surfaces, a file of `emitree render --surfaces`: their triangles, and their cut.

python surfaces.py surfaces.npz picture.png
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import LogNorm
from mpl_toolkits.mplot3d.art3d import Poly3DCollection


def cut(position, triangles, value):
    """Where triangles cross the plane z = 0: segments (n, 2, 2) in x and y, and values (n,)."""
    height = position[triangles, 2]
    ends, values = [], []
    for first, second in ((0, 1), (1, 2), (2, 0)):
        a, b = height[:, first], height[:, second]
        crosses = (a < 0) != (b < 0)
        share = np.where(crosses, a / np.where(crosses, a - b, 1.0), np.nan)[:, None]
        start, end = position[triangles[:, first]], position[triangles[:, second]]
        ends.append((start + share * (end - start))[:, :2])
    ends, values = np.stack(ends, axis=1), value[triangles].mean(axis=1)
    crossed = (~np.isnan(ends[:, :, 0])).sum(axis=1) == 2
    segments = ends[crossed][~np.isnan(ends[crossed][:, :, 0])].reshape(-1, 2, 2)
    return segments, values[crossed]


def main(source, target):
    """Writes the picture of the surfaces in a file."""
    with np.load(source) as file:
        position, normal, jump = file["position"], file["normal"], file["jump"]
        uncertainty, triangles = file["uncertainty"], file["triangles"]
        length_unit, jump_unit = str(file["length_unit"]), str(file["jump_unit"])
    colours = {"norm": LogNorm(*np.quantile(jump, [0.01, 0.99])), "cmap": "viridis"}
    figure = plt.figure(figsize=(9.6, 4.8))

    space = figure.add_axes((0.02, 0.1, 0.54, 0.88), projection="3d")
    shown = Poly3DCollection(position[triangles], linewidths=0, antialiaseds=False)
    light = np.abs(normal[triangles].mean(axis=1) @ np.array([0.3, -0.8, 0.52]))
    faces = plt.get_cmap("viridis")(colours["norm"](jump[triangles].mean(axis=1)))
    faces[:, :3] *= (0.55 + 0.45 * light)[:, None]
    shown.set_facecolor(faces)
    space.add_collection3d(shown)
    low, high = position.min(axis=0), position.max(axis=0)
    space.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    space.set_box_aspect(high - low, zoom=0.95)
    space.view_init(elev=30, azim=-110)
    unit = f" [{length_unit}]" if length_unit else ""
    space.set(xlabel="x" + unit, ylabel="y" + unit, zlabel="z" + unit)
    space.locator_params(nbins=5)

    plane = figure.add_axes((0.6, 0.12, 0.26, 0.78))
    segments, jumps = cut(position, triangles, jump)
    lines = LineCollection(segments, array=jumps, linewidths=2, **colours)
    plane.add_collection(lines)
    plane.set(xlabel="x" + unit, ylabel="y" + unit, aspect="equal")
    plane.autoscale_view()
    title = f"z = 0, wrong by about {np.median(uncertainty):.2g} {length_unit}"
    plane.set_title(title, fontsize=10)
    label = "jump of the rate" + (f" [{jump_unit}]" if jump_unit else "")
    figure.colorbar(lines, cax=figure.add_axes((0.88, 0.12, 0.02, 0.78)), label=label)
    figure.savefig(target, dpi=80)


if __name__ == "__main__":
    main(*sys.argv[1:])
