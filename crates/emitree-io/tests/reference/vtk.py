"""Small grids in the legacy format of VTK, as PyVista writes them, and in XML, as VTK does.

    pip install pyvista
    python vtk.py                   # writes the files into vtk/ beside this file

The data are those of grids.py, g = 100 z + 10 y + x of the indices.
"""

from pathlib import Path

import numpy as np
import pyvista
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter, vtkXMLRectilinearGridWriter

FOLDER = Path(__file__).with_suffix("")
X, Y, Z = np.array([-1.0, 0.0, 2.0, 6.0]), np.array([0.0, 0.5, 2.0]), np.array([10.0, 20.0])
G = np.tensordot([100.0, 10.0, 1.0], np.indices((2, 3, 4)), 1).ravel()  # x varies fastest

#: Files in XML: the mode of data, whether appended data are in base64, the compressor, the bits of
#: lengths, and whether numbers are big-endian.
XML = {
    "text": ("Ascii", False, None, 32, False),
    "base64": ("Binary", False, None, 64, False),
    "base64_zlib": ("Binary", False, "ZLib", 32, False),
    "appended": ("Appended", False, None, 64, True),
    "appended_zlib": ("Appended", False, "ZLib", 64, False),
    "appended_base64": ("Appended", True, None, 32, True),
    "appended_base64_zlib": ("Appended", True, "ZLib", 64, False),
}


def save_xml(grid, path, mode, in_base64, compressor, bits, is_big_endian):
    """Writes a grid in XML, compressed in blocks of few numbers."""
    is_image = path.suffix == ".vti"
    writer = vtkXMLImageDataWriter() if is_image else vtkXMLRectilinearGridWriter()
    writer.SetInputData(grid)
    writer.SetFileName(str(path))
    getattr(writer, f"SetDataModeTo{mode}")()
    writer.SetEncodeAppendedData(in_base64)
    getattr(writer, f"SetCompressorTypeTo{compressor}")()
    getattr(writer, f"SetHeaderTypeToUInt{bits}")()
    writer.SetByteOrder(0 if is_big_endian else 1)
    writer.SetBlockSize(56)
    assert writer.Write()


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
    for name, options in XML.items():
        save_xml(rectilinear, FOLDER / f"{name}.vtr", *options)
    save_xml(cells, FOLDER / "cells.vti", *XML["appended_zlib"])
    # The extent of an image need not begin at 0.
    part = pyvista.ImageData(pyvista.ImageData(dimensions=(9, 9, 9), spacing=(0.5, 1, 2)))
    part.extent = (-2, 1, 0, 2, 0, 1)
    part.origin = (0, 0, 5)
    part.point_data["g"] = G
    save_xml(part, FOLDER / "uniform.vti", *XML["base64_zlib"])
    save_xml(part, FOLDER / "lz4.vti", "Appended", False, "LZ4", 64, False)


if __name__ == "__main__":
    main()
