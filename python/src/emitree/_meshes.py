"""Data of PyVista and VTK: grids, and meshes of cells in which points are located."""

from __future__ import annotations

import contextlib
import importlib
import os
import warnings
from typing import Any

import numpy as np

from emitree._cameras import Box
from emitree._function import Floats
from emitree._grid import Grid
from emitree._native import SceneError
from emitree._tetrahedra import Tetrahedra, flat

_ASSOCIATIONS = ("point", "cell")
#: The number of tetrahedra among VTK's types of cells.
_VTK_TETRA = 10


def from_pyvista(
    dataset: Any, field: str | None = None, *, association: str | None = None
) -> Grid | CellData:
    """The emission of a field of a PyVista or VTK dataset.

    dataset: a dataset of PyVista, or of VTK, with points in the length unit of the camera; or the
        name of a file of one that PyVista reads (.vti, .vtr, .vts, .vtu, .vtk and others). Data at
        the points of an `ImageData` or a `RectilinearGrid` become a `Grid`. All else becomes a
        function for `render`: an `UnstructuredGrid`, of whose cells those with a volume are used, a
        `StructuredGrid`, data of cells, and images whose axes are turned. Data at points are linear
        in each tetrahedron, and trilinear in each hexahedron of a mesh of hexahedra alone; a mesh
        with cells of other shapes (wedges, pyramids, polyhedra) is split into tetrahedra. Data of
        cells are constant in each. The emission is isotropic, and 0 outside of all cells; `bounds`
        of the function is the box around them, which `render` uses unless it is given others.
    field: the name of an array with one number for each point or cell; it may be omitted if there
        is only one.
    association: "point" or "cell", where arrays of both have this name.

    VTK finds the cell of a point. The emission jumps on the surface of a mesh unless it falls to 0
    there: if that is a sphere or an ellipsoid, it can be declared as `edges` of `render`, which
    saves evaluations. Tetrahedra that touch share whole faces.

    Raises `SceneError` if there is no such field, if it has several components or values that are
    not finite, or if no cell has a volume; `ImportError` without PyVista.

    Source of the shape functions: W. Schroeder, K. Martin and B. Lorensen, The Visualization
    Toolkit, 4th ed. (2006), Kitware, ISBN 978-1-930934-19-1, chapter 8.

    >>> import emitree
    >>> import numpy as np, pyvista  # doctest: +SKIP
    >>> tetrahedra = pyvista.Sphere().delaunay_3d()  # doctest: +SKIP
    >>> tetrahedra["rate"] = 1 + tetrahedra.points[:, 2]  # doctest: +SKIP
    >>> emission = emitree.from_pyvista(tetrahedra, "rate")  # doctest: +SKIP
    >>> camera = emitree.Orthographic(
    ...     position=(9, 0, 0), target=(0, 0, 0), extent=(2, 2)
    ... )  # doctest: +SKIP
    >>> rendering = emitree.render(emission, camera, (32, 32))  # doctest: +SKIP
    """
    pyvista = _pyvista()
    if isinstance(dataset, str | os.PathLike):
        dataset = _read(pyvista, os.fspath(dataset))
    data = _dataset(pyvista, dataset)
    name, of = _chosen(data, field, association)
    values = _values(data, name, of)
    if of == "point" and _is_grid(pyvista, data):
        return _grid(data, values)
    return CellData(_with_volume(pyvista, data, name, of, values), of)


class CellData:
    """A field of a mesh as an emission, a function of (position, direction): see `from_pyvista`.

    mesh: a dataset of PyVista all of whose cells have a volume, with the field as its array "rate".
    association: "point" or "cell".
    """

    def __init__(self, mesh: Any, association: str) -> None:
        self._mesh = mesh
        self._association = association
        self._probe: Any = None
        self._tetrahedra: Tetrahedra | None = None
        cells = _tetrahedra_of(mesh)
        if cells is not None:
            self._tetrahedra = Tetrahedra(np.asarray(mesh.points, dtype=np.float64), cells)
            mesh.cell_data["cell"] = np.arange(mesh.n_cells, dtype=np.float64)
        data = mesh.point_data if association == "point" else mesh.cell_data
        self._values = np.array(data["rate"])

    def __repr__(self) -> str:
        return f"CellData({self._mesh.n_cells} cells, data of {self._association}s)"

    def __getstate__(self) -> dict[str, Any]:
        # Filters of VTK cannot be pickled: workers of an executor make their own.
        return self.__dict__ | {"_probe": None}

    @property
    def bounds(self) -> Box:
        """The box around all cells."""
        ends = np.array(self._mesh.bounds, dtype=np.float64).reshape(3, 2)
        return Box(min=tuple(ends[:, 0].tolist()), max=tuple(ends[:, 1].tolist()))

    def __call__(self, position: Any, direction: Any = None, energy: Any = None) -> Floats:
        """The rates (n,) at positions (n, 3), in all directions and at all energies."""
        rates, is_inside = self._at(position)
        return np.where(is_inside, rates, 0.0)

    def is_inside(self, position: Any) -> Any:
        """Whether positions (n, 3) are in one of the cells."""
        return self._at(position)[1]

    def _at(self, position: Any) -> tuple[Floats, Any]:
        """Values (n,), and whether points are in a cell."""
        points = np.ascontiguousarray(position, dtype=np.float64)
        if len(points) == 0:
            return np.zeros(0), np.zeros(0, dtype=bool)
        if self._probe is None:
            self._probe = _probe(self._mesh)
        self._probe.SetInputDataObject(_pyvista().PolyData(points))
        self._probe.Update()
        found = _pyvista().wrap(self._probe.GetOutput()).point_data
        is_inside = np.asarray(found["vtkValidPointMask"]) > 0
        if self._tetrahedra is None:
            return np.asarray(found["rate"], dtype=np.float64), is_inside
        # VTK takes points outside of a cell, by a thousandth of its size, as points of the cell.
        guess = np.where(is_inside, np.asarray(found["cell"]), -1.0).astype(np.int64)
        cell, coordinates = self._tetrahedra.located(points, guess)
        if self._association == "cell":
            rates = self._values[cell]
        else:
            rates = self._tetrahedra.interpolated(self._values, cell, coordinates)
        return rates, cell >= 0


def _pyvista() -> Any:
    try:
        return importlib.import_module("pyvista")
    except ImportError as error:
        raise ImportError(
            "pyvista is missing: expected it for `from_pyvista`; `pip install pyvista` installs it"
        ) from error


def _probe(mesh: Any) -> Any:
    """A filter that interpolates a mesh at points, and keeps its locator."""
    core = importlib.import_module("vtkmodules.vtkFiltersCore")
    locators = importlib.import_module("vtkmodules.vtkCommonDataModel")
    probe = core.vtkProbeFilter()
    probe.SetSourceData(mesh)
    # By its name before VTK 9.7, which warns of it.
    modern = getattr(probe, "SetCellLocator", None)
    (modern or probe.SetCellLocatorPrototype)(locators.vtkStaticCellLocator())
    # The tolerance that it computes takes points as inside that are far outside of curved cells.
    probe.ComputeToleranceOff()
    probe.SetTolerance(1e-9 * mesh.length)
    return probe


def _read(pyvista: Any, path: str) -> Any:
    """The dataset in a file."""
    if not os.path.isfile(path):
        raise SceneError(f"`dataset` is {path!r}, which is no file: expected one of VTK")
    # VTK only warns of a file that it cannot read.
    catcher = getattr(pyvista, "VtkErrorCatcher", None)
    errors = contextlib.nullcontext() if catcher is None else catcher(raise_errors=True)
    try:
        with warnings.catch_warnings(), errors:
            warnings.simplefilter("ignore")
            return pyvista.read(path)
    except Exception as error:
        first = (str(error).strip().splitlines() or [type(error).__name__])[0]
        raise SceneError(
            f"`dataset` is the file {path!r}: expected one that PyVista reads, such as .vtu "
            f"({first})"
        ) from error


def _dataset(pyvista: Any, dataset: Any) -> Any:
    try:
        data = pyvista.wrap(dataset)
    except (NotImplementedError, TypeError, ValueError):
        data = None
    if isinstance(data, pyvista.MultiBlock):
        raise SceneError(
            f"`dataset` is a MultiBlock of {data.n_blocks} blocks: expected one of its blocks, or "
            "`dataset.combine()`"
        )
    is_of_vtk = isinstance(data, pyvista.DataSet) and not isinstance(dataset, np.ndarray)
    if not is_of_vtk:
        raise SceneError(
            f"`dataset` is {type(dataset).__name__}: expected a dataset of PyVista or VTK, such as "
            "ImageData, RectilinearGrid, StructuredGrid or UnstructuredGrid"
        )
    return data


def _chosen(data: Any, field: str | None, association: str | None) -> tuple[str, str]:
    """The name of a field, and whether it is of points or cells."""
    if association is not None and association not in _ASSOCIATIONS:
        raise SceneError(f"`association` is {association!r}: expected 'point' or 'cell'")
    names = {"point": list(data.point_data.keys()), "cell": list(data.cell_data.keys())}
    candidates = [
        (name, of)
        for of in _ASSOCIATIONS
        if association in (None, of)
        for name in names[of]
        if field == name or (field is None and not name.startswith("vtk"))
    ]
    if len(candidates) == 1:
        return candidates[0]
    there = "; ".join(f"of {of}s {', '.join(names[of]) or 'none'}" for of in _ASSOCIATIONS)
    if field is None:
        raise SceneError(f"`field` is not given: expected one of the arrays ({there})")
    if candidates:
        raise SceneError(
            f"`field` {field!r} is an array of points and one of cells: expected `association`, "
            "'point' or 'cell'"
        )
    of_kind = "" if association is None else f" of {association}s"
    raise SceneError(f"`field` is {field!r}: expected one of the arrays{of_kind} ({there})")


def _values(data: Any, name: str, of: str) -> Floats:
    array = np.asarray((data.point_data if of == "point" else data.cell_data)[name])
    if array.ndim != 1 or array.dtype.kind not in "fiub":
        raise SceneError(
            f"`field` {name!r} has the shape {array.shape} and the type {array.dtype}: expected "
            f"({len(array)},), one real number for each {of}"
        )
    values = array.astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        raise SceneError(
            f"`field` {name!r} is {values[bad[0]]} at {of} {bad[0]}: expected finite numbers"
        )
    return values


def _is_grid(pyvista: Any, data: Any) -> bool:
    if isinstance(data, pyvista.ImageData):
        return bool(np.array_equal(data.direction_matrix, np.eye(3))) and min(data.dimensions) > 1
    return isinstance(data, pyvista.RectilinearGrid) and min(data.dimensions) > 1


def _grid(data: Any, values: Floats) -> Grid:
    axes = (np.asarray(nodes, dtype=np.float64) for nodes in _nodes(data))
    x, y, z = axes
    # The first index of VTK is the fastest.
    return Grid(values=values.reshape(data.dimensions, order="F"), x=x, y=y, z=z)


def _nodes(data: Any) -> Any:
    grid = data.cast_to_rectilinear_grid() if hasattr(data, "spacing") else data
    return grid.x, grid.y, grid.z


def _with_volume(pyvista: Any, data: Any, name: str, of: str, values: Floats) -> Any:
    """The cells of three dimensions alone, with the field as "rate"."""
    mesh = data.copy(deep=False)
    mesh.clear_data()
    (mesh.point_data if of == "point" else mesh.cell_data)["rate"] = values
    dimensions = _cell_dimensions(pyvista, data)
    has_volume = dimensions == 3
    if not has_volume.any():
        raise SceneError(
            f"`dataset` is a {type(data).__name__} of {data.n_cells} cells without a volume: "
            "expected cells such as tetrahedra, hexahedra, wedges or voxels"
        )
    if not has_volume.all():
        mesh = mesh.extract_cells(np.flatnonzero(has_volume))
    if _is_mixed(pyvista, mesh):
        # VTK takes points beside a wedge as inside: up to as many as are in it.
        mesh = mesh.triangulate()
    cells = _tetrahedra_of(mesh)
    if cells is not None:
        is_flat = flat(np.asarray(mesh.points, dtype=np.float64), cells)
        if is_flat.all():
            raise SceneError("all cells of `dataset` are flat: expected cells with a volume")
        if is_flat.any():
            mesh = mesh.extract_cells(np.flatnonzero(~is_flat))
    return mesh


def _is_mixed(pyvista: Any, mesh: Any) -> bool:
    """Whether a mesh has cells that are neither tetrahedra alone nor hexahedra alone."""
    if not isinstance(mesh, pyvista.UnstructuredGrid):
        return False
    kinds, shapes = set(mesh.celltypes.tolist()), pyvista.CellType
    return not (kinds <= {shapes.TETRA} or kinds <= {shapes.HEXAHEDRON, shapes.VOXEL})


def _tetrahedra_of(mesh: Any) -> Any:
    """The corners (m, 4) of a mesh of tetrahedra; None of any other."""
    kinds = getattr(mesh, "celltypes", np.zeros(0))
    if len(kinds) == 0 or (kinds != _VTK_TETRA).any():
        return None
    return np.asarray(mesh.cell_connectivity).reshape(-1, 4)


def _cell_dimensions(pyvista: Any, data: Any) -> Any:
    """The number of dimensions of each cell (n,)."""
    if data.n_cells == 0:
        return np.zeros(0, dtype=np.int64)
    if not isinstance(data, pyvista.UnstructuredGrid):
        return np.full(data.n_cells, data.GetCell(0).GetCellDimension())
    types, first, kind = np.unique(data.celltypes, return_index=True, return_inverse=True)
    of_type = [data.GetCell(int(cell)).GetCellDimension() for cell in first]
    assert len(types) == len(of_type)
    return np.array(of_type)[kind]
