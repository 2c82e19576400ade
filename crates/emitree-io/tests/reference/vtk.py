"""Small grids in the legacy format of VTK, as PyVista writes them.

    pip install pyvista
    python vtk.py                   # writes the files into vtk/ beside this file

The data are those of grids.py, g = 100 z + 10 y + x of the indices.
"""

from pathlib import Path

import numpy as np
import pyvista

FOLDER = Path(__file__).with_suffix("")
X, Y, Z = np.array([-1.0, 0.0, 2.0, 6.0]), np.array([0.0, 0.5, 2.0]), np.array([10.0, 20.0])
G = np.tensordot([100.0, 10.0, 1.0], np.indices((2, 3, 4)), 1).ravel()  # x varies fastest


def main():
    FOLDER.mkdir(exist_ok=True)
    rectilinear = pyvista.RectilinearGrid(X, Y, Z)
    rectilinear.point_data["g"] = G.astype(np.float32)
    rectilinear.point_data["the velocity"] = np.stack([G, 2 * G, 3 * G], axis=1)
    rectilinear.cell_data["others"] = np.arange(6)
    rectilinear.field_data["TIME"] = [2.5]
    uniform = pyvista.ImageData(dimensions=(4, 3, 2), spacing=(0.5, 1, 2), origin=(-1, 0, 5))
    uniform.point_data["g"] = G
    cells = pyvista.ImageData(dimensions=(4, 3, 3), spacing=(0.5, 1, 2))
    cells.cell_data["of cells"] = np.arange(12)
    cells.save(FOLDER / "cells.vtk")
    for name, grid in {"rectilinear": rectilinear, "uniform": uniform}.items():
        grid.save(FOLDER / f"{name}_binary.vtk", binary=True)
        grid.save(FOLDER / f"{name}_text.vtk", binary=False)


if __name__ == "__main__":
    main()
