"""A plan: the points of a rendering, and the linear map from rates there to the image."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from emitree import _native, _plan_file, _progress
from emitree._display_places import extent_html, places_html, span_html
from emitree._factors import Factors, factors
from emitree._files import written
from emitree._function import Floats, as_rates
from emitree._libraries import library_of, scipy
from emitree._point_rates import rates_at
from emitree._points import Points
from emitree._sparse import SparseMatrix, compressed_rows

if TYPE_CHECKING:
    from emitree._result import Rendering
    from emitree._setup import Setup


@dataclass(frozen=True)
class _Stored:
    """The map of a plan that was loaded or unpickled: its matrix alone."""

    matrix: SparseMatrix
    #: Whether each value of the image is a number; the others are NaN.
    seen: NDArray[np.bool_]

    def apply(self, rates: Floats) -> Floats:
        return np.where(self.seen, self.matrix.times(rates).reshape(self.seen.shape), np.nan)


class Plan:
    """The points of a rendering, and the linear map from the rates there to its image.

    With the rates of its own emission `apply` returns the image of the rendering, to rounding. It
    is linear, so the image of a model at fixed points is as smooth in the parameters as its rates
    are. For another emission its error is that of the same points and weights for that one, which
    `apply` does not estimate: `render` does, and `refine` renders anew where it is too large.

    A plan comes from `Rendering.plan`, `Session.mesh` or `Plan.load`. A pickled plan, like a saved
    one, has its matrix and not how it was rendered: `render` and `refine` then raise `ValueError`.

    >>> import emitree, numpy as np
    >>> def ball(width):
    ...     return lambda r, d: np.exp(-((r - 0.5) ** 2).sum(axis=1) / width**2)
    >>> session = emitree.Session(emitree.Canonical(), (16, 16))
    >>> while points := session.ask():
    ...     session.tell(ball(0.2)(points.position, points.direction))
    >>> plan = session.mesh()
    >>> image = plan.apply(plan.rates(ball(0.201)))
    >>> image.shape, bool(abs(image - session.rendering().image).max() < 0.01)
    ((16, 16), True)
    """

    def __init__(
        self,
        native: _native.Mesh | _Stored,
        points: Points,
        shape: tuple[int, ...],
        unit: str | None,
        setup: Setup | None,
    ) -> None:
        self._native = native
        self._unit = unit
        self._setup = setup
        #: Arrays of other libraries by their names, types and devices, for `apply`.
        self.constants: dict[Any, Any] = {}
        #: The points at which rates are needed; none is there twice.
        self.points = points
        #: The shape of the image (height, width), or of the cube (bins, height, width).
        self.shape = shape

    @classmethod
    def of_mesh(cls, native: _native.Mesh, setup: Setup | None, unit: str | None) -> Plan:
        """The plan of a mesh of the compiled part; `Rendering.plan` and `Session.mesh` use it."""
        values = native.apply(np.zeros(len(native)))
        shape = values.shape if native.is_cube else values.shape[1:]
        return cls(native, Points(*native.points()), shape, unit, setup)

    def __len__(self) -> int:
        """The number of points."""
        return len(self.points)

    def __repr__(self) -> str:
        return f"<Plan: {len(self)} points, shape {self.shape}>"

    def _repr_html_(self) -> str:
        rows = {"points": f"{len(self):,}", "image": " &times; ".join(map(str, self.shape))}
        rows |= extent_html(self.positions, "")
        if self.energies is not None and len(self.energies):
            rows["energies"] = span_html(self.energies.min(), self.energies.max(), "")
        return places_html(self.positions, rows)

    @property
    def positions(self) -> Floats:
        """The positions of the points (n, 3), in the camera's length unit."""
        return self.points.position

    @property
    def directions(self) -> Floats:
        """The directions at the points (n, 3), unit vectors to the observer."""
        return self.points.direction

    @property
    def energies(self) -> Floats | None:
        """The energies of the points (n,), in the unit of the bins; None without bins."""
        return self.points.energy

    def rates(self, emission: Callable[..., Any]) -> Floats:
        """The rates (n,) of a function at the points, in the unit of the rendering.

        emission: a function of (position, direction), or of (position, direction, energy) if the
            points have energies, as of `render`.

        Raises `TypeError` if it is no function, `ValueError` if it does not return n numbers, and
        any exception of the function.
        """
        return self.rates_at(emission, self.points)

    def rates_at(self, emission: Callable[..., Any], points: Points) -> Floats:
        """The rates (n,) of a function at other points, as by `rates`."""
        return rates_at(emission, points, self._setup, self._unit)

    def apply(self, rates: Any) -> Any:
        """The image, of the shape `shape`, for rates (n,) at the points, in the unit of the rates.

        With rates (n, k) it is k images, (k, *shape). Pixels where the camera has no image are NaN.

        Of a JAX array or a PyTorch tensor it is one of the same library on the same device, which
        has derivatives: `jax.grad`, `jvp`, `vmap` and `jit`, or `backward`, include it. It has the
        precision of the rates, 32 bits by default in both libraries. The first such call computes
        one image for each line of sight or pivot, and keeps their `factors`.

        Raises `ValueError` if there are not n rates.

        >>> import emitree, numpy as np
        >>> session = emitree.Session(emitree.Canonical(), (4, 6), method="los", steps=8)
        >>> while points := session.ask():
        ...     session.tell(points.position[:, 0])
        >>> plan = session.mesh()
        >>> bool(np.allclose(plan.apply(np.ones(len(plan))), 1))
        True
        """
        library = library_of(rates)
        if library is not None:
            return library.apply(self, rates)
        if np.ndim(rates) == 2:
            columns = np.asarray(rates).T
            images = [self.apply(np.ascontiguousarray(column)) for column in columns]
            return np.array(images).reshape((len(images), *self.shape))
        values = self._native.apply(as_rates(rates, len(self), self._unit))
        return values.reshape(self.shape)

    def adjoint(self, image: Any) -> Floats:
        """The transpose of the map: from an image, of the shape `shape`, to a vector (n,).

        It is `matrix().T @ image.ravel()`, and the gradient of (image * apply(rates)).sum() by the
        rates. Pixels where the camera has no image count as 0. The first call computes the matrix.

        Raises `ValueError` if the shape is another.

        >>> import emitree, numpy as np
        >>> session = emitree.Session(emitree.Canonical(), (4, 6), method="los", steps=8)
        >>> while points := session.ask():
        ...     session.tell(points.position[:, 0])
        >>> plan = session.mesh()
        >>> gradient = plan.adjoint(np.ones((4, 6)))
        >>> bool(np.isclose(gradient @ plan.positions[:, 0], 24 * 0.5))
        True
        """
        values = np.asarray(image, dtype=np.float64)
        if values.shape != self.shape:
            raise ValueError(f"`image` has the shape {values.shape}: expected {self.shape}")
        return self._rows.transpose_times(np.where(self.seen, values, 0.0).ravel())

    def matrix(self) -> Any:
        """The whole map as one `scipy.sparse.csr_array`, (pixels, points).

        Times the rates it is the image, ravelled. It takes an image for each node, and is for small
        images. Rows of pixels without an image are empty; `apply` has NaN there. It is computed
        once.

        Raises `ImportError` without scipy.
        """
        return self._matrix

    @cached_property
    def _matrix(self) -> Any:
        sparse = scipy("sparse")
        rows = self._rows
        return sparse.csr_array((rows.data, rows.indices, rows.indptr), shape=rows.shape)

    @cached_property
    def _rows(self) -> SparseMatrix:
        native = self._native
        return native.matrix if isinstance(native, _Stored) else compressed_rows(native.matrix())

    @cached_property
    def seen(self) -> NDArray[np.bool_]:
        """Whether each value of the image is a number, of the shape `shape`; the others are NaN."""
        return ~np.isnan(self.apply(np.zeros(len(self))))

    @cached_property
    def factors(self) -> Factors:
        """The map as a product of two matrices, for `apply` on devices; computed once."""
        native, count, pixels = self._native, len(self), int(np.prod(self.shape))
        if isinstance(native, _Stored):
            return factors(native.matrix.column, count, pixels)
        rates = np.zeros(count)

        def column_of(point: int) -> Floats:
            rates[point] = 1.0
            values = native.apply(rates)
            rates[point] = 0.0
            return values

        return factors(column_of, count, pixels, self.weights)

    def check_count(self, shape: tuple[int, ...]) -> None:
        """Raises `ValueError` unless the shape is that of rates (n,) or (n, k)."""
        if shape[:1] != (len(self),) or len(shape) > 2:
            raise ValueError(f"the rates have the shape {shape}: expected ({len(self)},)")

    @cached_property
    def operator(self) -> Any:
        """The map as a `scipy.sparse.linalg.LinearOperator`, (pixels, points).

        `matvec` is `apply`, ravelled, with 0 in pixels without an image; `rmatvec` is `adjoint`.

        Raises `ImportError` without scipy.
        """
        return scipy("sparse.linalg").LinearOperator(
            shape=(int(np.prod(self.shape)), len(self)),
            matvec=lambda rates: np.where(self.seen, self.apply(np.ravel(rates)), 0.0).ravel(),
            rmatvec=lambda image: self.adjoint(np.reshape(image, self.shape)),
            dtype=np.float64,
        )

    @property
    def weights(self) -> SparseMatrix:
        """The weights of the rates in the values at nodes: lines of sight, cells or pivots.

        Raises `ValueError` of a loaded plan, which has the matrix alone.
        """
        if isinstance(self._native, _Stored):
            raise ValueError("the plan was loaded or unpickled: expected `matrix` instead")
        return compressed_rows(self._native.weights())

    @cached_property
    def is_of_products(self) -> bool:
        """Whether the points are those of products of functions (smooth emissions, method "vol").

        Only these can be checked by `render` and used by `refine`; with others `render` raises
        `SceneError`, and `refine` renders in full.
        """
        if isinstance(self._native, _Stored) or self._setup is None:
            return False
        # A node of products is one point; lines and cells have several.
        indptr = self._native.weights()[0]
        method = self._setup.options.get("method") or "vol"
        return bool(method == "vol" and np.diff(indptr).max(initial=0) <= 1)

    def with_options(self, options: Mapping[str, Any]) -> Plan:
        """The same plan with other options of the method, as of `render`, for `render`, `refine`.

        Raises `ValueError` of a loaded plan, which is not rendered.
        """
        if self._setup is None:
            raise ValueError("the plan was loaded or unpickled: expected one of `render`")
        setup = replace(self._setup, options={**self._setup.options, **options})
        return Plan(self._native, self.points, self.shape, self._unit, setup)

    def with_points_of(self, other: Plan) -> Plan:
        """The points of another plan of the same view, with the options of this one."""
        return Plan(other._native, other.points, other.shape, self._unit, self._setup)

    def render(
        self, emission: Any, *, executor: Any = None, progress: _progress.Progress = False
    ) -> Rendering:
        """The rendering of another emission at exactly these points, with its error estimate.

        Camera, shape and options are those of the plan's rendering. Nothing is added to the points;
        some more samples estimate the error. `converged` is False if the plan does not suffice to
        the tolerance.

        emission, executor, progress: as of `render`.

        Raises `ValueError` of a loaded plan, `SceneError` of one that `is_of_products` is not true
        of, and what `render` raises.
        """
        return self._rendered(emission, True, None, executor, progress)

    def refine(
        self,
        emission: Any,
        *,
        max_evaluations: int | None = None,
        executor: Any = None,
        progress: _progress.Progress = False,
    ) -> Rendering:
        """The rendering of another emission that starts from this plan and meets the tolerance.

        Where the plan suffices its points are used, and those that show the error; else it is a
        rendering from nothing. `plan` of the result is the plan of these points. This plan
        stays as it is.

        emission, executor, progress: as of `render`.
        max_evaluations: the most evaluations of this rendering, instead of the plan's limit.

        Raises `ValueError` of a loaded plan, and what `render` raises.
        """
        return self._rendered(emission, False, max_evaluations, executor, progress)

    def _rendered(
        self,
        emission: Any,
        is_fixed: bool,
        max_evaluations: int | None,
        executor: Any,
        progress: _progress.Progress,
    ) -> Rendering:
        from emitree._render import rendered_from

        if isinstance(self._native, _Stored) or self._setup is None:
            raise ValueError(
                "the plan was loaded, unpickled or made of a scene file, and does not contain how "
                "it was rendered: expected one of `render` with a camera, or `emitree.render` for "
                "a new one"
            )
        return rendered_from(
            self._native,
            is_fixed,
            self._setup,
            emission,
            max_evaluations=max_evaluations,
            executor=executor,
            progress=progress,
        )

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Writes points and matrix to a file, NumPy's .npz.

        The file is whole or absent: one that is replaced stays until the other is complete.

        Raises `FileExistsError` if there is such a file and not `overwrite`.
        """
        written(_plan_file.encoded(self._content()), path, overwrite)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Plan:
        """A plan from a file of `save`.

        Raises `FileNotFoundError` if there is no file, `ValueError` if it is not that of a plan.
        """
        return _of_content(_plan_file.content(path))

    def _content(self) -> _plan_file.Content:
        return _plan_file.Content(self.points, self._rows, self.seen, self._unit)

    def __reduce__(self) -> tuple[Callable[..., Plan], tuple[_plan_file.Content]]:
        return _of_content, (self._content(),)

    def __copy__(self) -> Plan:
        return self

    def __deepcopy__(self, memo: Any) -> Plan:
        return self


def _of_content(content: _plan_file.Content) -> Plan:
    """The plan of a file or a pickle."""
    stored = _Stored(content.matrix, content.seen)
    return Plan(stored, content.points, content.seen.shape, content.unit, None)
