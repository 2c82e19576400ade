"""Images of optically thin volume emissions, with as few evaluations of the emission as possible.

An emission rate g(r, d) is given as a function on arrays, a formula, a model, a grid or a tree.
Each pixel of a camera is its integral along the line of sight. `render` computes the image to a
tolerance:

>>> import emitree, numpy as np
>>> def corona(position, direction):
...     return np.exp(-np.linalg.norm(position, axis=1))
>>> camera = emitree.Perspective(
...     position=(10, 0, 0), target=(0, 0, 0), field_of_view=(40, 30), near=0, far=20
... )
>>> rendering = emitree.render(corona, camera, (60, 80), tolerance=0.01)
>>> rendering.converged and rendering.estimated_error < 0.01
True

Images are arrays of shape (height, width) whose row 0 is the lowest y and whose column 0 is the
lowest x: seen from the observer, x points to the right and y up. Angles are in degrees, lengths in
the camera's `length_unit`; astropy quantities are taken too.
"""

from emitree._amr import AmrGrid, Block
from emitree._basis import RadialFunctions, Voxels
from emitree._build_tree import build_tree
from emitree._cameras import (
    Box,
    Camera,
    Canonical,
    Ellipsoid,
    Equirectangular,
    Fisheye,
    Healpix,
    Orthographic,
    Perspective,
    Plane,
    Polar,
    SingularAxis,
    SingularPoint,
    Sphere,
)
from emitree._components import Components
from emitree._emissions import Expression, Model, Tree
from emitree._energies import Energies
from emitree._exposure import Exposure
from emitree._fields import Fields
from emitree._forward import Forward
from emitree._grid import Grid
from emitree._instrument import Instrument
from emitree._jacobian import Jacobian, jacobian
from emitree._large_grid import LargeGrid
from emitree._line_integrals import LineIntegrals, line_integrals
from emitree._lines import Lines
from emitree._meshes import from_pyvista
from emitree._native import EmissionError, RenderError, SceneError, __version__
from emitree._on_workers import on_workers
from emitree._particles import Particles
from emitree._plan import Plan
from emitree._points import Points
from emitree._progressive import Frame, progressive
from emitree._render import render
from emitree._result import Rendering
from emitree._row_by_row import render_to_fits
from emitree._scoring import Fit, fit_counts
from emitree._sensitivity import sensitivity
from emitree._sensitivity_matrix import Sensitivity
from emitree._session import Session
from emitree._sky import Sky
from emitree._sparse import SparseMatrix
from emitree._spectrum import Spectrum
from emitree._splines import BSplines
from emitree._sums import RegionSum
from emitree._surfaces import Surfaces
from emitree._sweep import Sweep, sweep
from emitree._table import Table
from emitree._view import view
from emitree._wcs_camera import WcsCamera
from emitree._yt import from_yt

#: The former name of `Plan`.
Mesh = Plan

__all__ = [
    "AmrGrid",
    "BSplines",
    "Block",
    "Box",
    "Camera",
    "Canonical",
    "Components",
    "Ellipsoid",
    "EmissionError",
    "Energies",
    "Equirectangular",
    "Exposure",
    "Expression",
    "Fields",
    "Fisheye",
    "Fit",
    "Forward",
    "Frame",
    "Grid",
    "Healpix",
    "Instrument",
    "Jacobian",
    "LargeGrid",
    "LineIntegrals",
    "Lines",
    "Mesh",
    "Model",
    "Orthographic",
    "Particles",
    "Perspective",
    "Plan",
    "Plane",
    "Points",
    "Polar",
    "RadialFunctions",
    "RegionSum",
    "RenderError",
    "Rendering",
    "SceneError",
    "Sensitivity",
    "Session",
    "SingularAxis",
    "SingularPoint",
    "Sky",
    "SparseMatrix",
    "Spectrum",
    "Sphere",
    "Surfaces",
    "Sweep",
    "Table",
    "Tree",
    "Voxels",
    "WcsCamera",
    "__version__",
    "build_tree",
    "fit_counts",
    "from_pyvista",
    "from_yt",
    "jacobian",
    "line_integrals",
    "on_workers",
    "progressive",
    "render",
    "render_to_fits",
    "sensitivity",
    "sweep",
    "view",
]
