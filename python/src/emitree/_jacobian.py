"""Derivatives of an image by the parameters of its emission, all on one mesh."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import wraps
from typing import Any

import numpy as np

from emitree._cameras import Camera
from emitree._emissions import Expression, Model
from emitree._function import Floats
from emitree._moving_surfaces import MovingSurfaces
from emitree._neighbourhood import plan_of_all, rendering_of_one
from emitree._parameters import checked_parameters
from emitree._plan import Plan
from emitree._points import Points
from emitree._result import Rendering
from emitree._scene import length_unit_of

#: The steps of central differences, relative to each parameter: their error is about the square.
RELATIVE_STEP = 1e-4

#: The changes whose images a plan of derivatives serves, relative to each parameter: they are as
#: large as the image, as a change by a third is.
_CHANGE = 0.3

#: The first change of a parameter by which displacements of surfaces are searched for, relative to
#: it; it is then made such that surfaces move as far as `_displacements` needs.
FIRST_CHANGE = 1e-2

#: The error text for the former name of `difference_steps`.
STEPS_ARE_OF_LOS = (
    "`steps` has a number for each parameter: expected `difference_steps`, as `steps` is an option "
    "of method `los`"
)

#: A function of parameters that returns an emission: a function of (position, direction[, energy]).
ModelOf = Callable[..., Any]


def jacobian(
    model: ModelOf | Expression | Model,
    theta: Any,
    camera: Camera | None = None,
    shape: Sequence[int] | int | None = None,
    *,
    plan: Plan | None = None,
    derivative: ModelOf | str | None = None,
    difference_steps: Any = None,
    linear: Sequence[int] = (),
    **options: Any,
) -> Jacobian:
    """The image of a model and its derivatives by the parameters: (image, (p, *image.shape)).

    The image and all derivatives have the same points and weights, so no difference of two images
    contains their errors. The points are those of the image at theta; samples show whether they
    suffice for each derivative, and if not, they are those of a mixture of g and its derivatives
    (smooth emissions of method "vol"). Then the image and each derivative meet the tolerance, each
    relative to its own largest pixel. `estimated_errors` of the result has these errors, and
    `converged` is False where no such points are found; for other methods, and with a `plan`, the
    derivatives are not compared with samples.

    model: model(*theta) returns a function of (position, direction[, energy]), as of `render`; or
        an `Expression` or a `Model`, whose derivatives are exact.
    theta: the parameters (p,); of an `Expression`, the names of the constants that are parameters,
        and of a `Model` the names of parameters.
    camera, shape, options: as of `render`; needed without `plan`.
    plan: a `Plan` that serves theta; by default that of a rendering at theta.
    derivative: how g is differentiated; one of
        * None: central differences at the same points, 2 evaluations at each point and parameter;
          exact derivatives for an `Expression`, a `Model`, and any `model` with a method
          `derivative`, as those of `Expression.model`, `Fields.model` and `Model.model`;
        * a function: derivative(*theta) returns a function of (position, direction[, energy]) that
          gives (n, p), the derivatives of the rates by all parameters;
        * "jax": forward differentiation of model(*theta), written in `jax.numpy`, in 64 bits.
    difference_steps: the steps (p,) of the differences; by default 1e-4 of each parameter, or 1e-4
        if it is 0.
    linear: numbers of the parameters that the rates are proportional to. They cost no evaluation
        unless they are 0.

    Where a rate jumps at a surface that moves with a parameter, the derivative of the image has a
    part that no derivative of rates has: the jump times the speed of the surface. If the rendering
    has found the surfaces (`Rendering.surfaces`), this part follows from their displacements, which
    are found by bisection, some 10,000 evaluations for each parameter, after some 100,000 that move
    all vertices onto the surfaces; the other part is that of quadrature between the surfaces, some
    30,000 points. Such derivatives are not compared with samples: of a ball they are within 6 % in
    the mean square.

    If it has found none, or with a `plan`, the parameters of a `Model` that move such surfaces
    (`Model.model(names).moves_jumps`) are refused, unless `derivative` or `difference_steps` is
    given: with `derivative=model.derivative` that part is left out, and differences have it as far
    as surfaces pass points of the plan between the two values.

    Raises `ValueError` if a parameter is not finite, if it moves surfaces of a `Model`, or if a
    number of steps or of derivatives is not that of the parameters; `TypeError` if the model
    returns no function; and what `render` and `Rendering.plan` raise.

    >>> import emitree, numpy as np
    >>> def ball(height, width):
    ...     return lambda r, d: height * np.exp(-((r - 0.5) ** 2).sum(axis=1) / width**2)
    >>> theta = (2.0, 0.2)
    >>> image, derivatives = emitree.jacobian(
    ...     ball, theta, emitree.Canonical(), (8, 8), linear=[0], tolerance=1e-3
    ... )
    >>> derivatives.shape, bool(np.allclose(derivatives[0], image / 2))
    ((2, 8, 8), True)
    >>> glow = emitree.Expression("h * exp(-r^2 / w^2)", constants={"h": 2.0, "w": 0.5})
    >>> emitree.jacobian(glow, ["h", "w"], emitree.Canonical(), (8, 8)).derivatives.shape
    (2, 8, 8)
    """
    if isinstance(model, Expression | Model):
        of_names = model.model([theta] if isinstance(theta, str) else theta)
        model, theta = of_names, of_names.theta
    refuse_other_unit(model, camera)
    parameters = checked_parameters(theta)
    if np.ndim(options.get("steps", 0)) == 1:
        raise TypeError(STEPS_ARE_OF_LOS)
    differentiated = Derivatives(model, len(parameters), derivative, difference_steps, linear)
    errors: list[float | None] = [None] * len(parameters)
    converged = None
    if plan is None:
        if camera is None or shape is None:
            raise TypeError("expected `camera` and `shape`, or a `plan`")
        emission = differentiated.emission(parameters)
        first = rendering_of_one(emission, camera, shape, options)
        if first.surfaces is not None:
            derivatives = differentiated.images_by_surfaces(first, parameters)
            return Jacobian(first.image, derivatives, errors, None)
        changes = differentiated.changes(parameters)
        emissions = [emission, *changes.values()]
        found = plan_of_all(emissions, camera, shape, options, first)
        plan, converged = found.plan, found.suffices if found.plan.is_of_products else None
        of_image, *of_changes = (
            None if rendering is None else rendering.estimated_error
            for rendering in found.compared(emissions)
        )
        for number, error in zip(changes, of_changes, strict=True):
            errors[number] = error
        for number in linear:
            # This derivative is the image times a number.
            errors[number] = of_image
    else:
        named = options | {"camera": camera, "shape": shape}
        given = [name for name, value in named.items() if value is not None]
        if given:
            raise TypeError(f"`{given[0]}` is given beside a `plan`: expected one of them")
    image = plan.apply(plan.rates(differentiated.emission(parameters)))
    derivatives = differentiated.images(plan, parameters, image)
    return Jacobian(image, derivatives, errors, converged)


@dataclass(frozen=True, eq=False)
class Jacobian:
    """The image of a model and its derivatives, with their errors.

    It is a pair too: image, derivatives = emitree.jacobian(…).

    >>> import emitree, numpy as np
    >>> def shell(radius):
    ...     return lambda r, d: np.exp(-50 * (np.linalg.norm(r - 0.5, axis=1) - radius) ** 2)
    >>> found = emitree.jacobian(shell, [0.3], emitree.Canonical(), (16, 16))
    >>> image, derivatives = found
    >>> found.derivatives is derivatives, found.converged, len(found.estimated_errors)
    (True, True, 1)
    """

    #: The image.
    image: Floats
    #: The derivatives (p, *image.shape).
    derivatives: Floats
    #: The estimated error of each derivative, relative to its own largest pixel; None if it was not
    #: compared with samples.
    estimated_errors: list[float | None]
    #: Whether the points serve the image and all derivatives, to the tolerance; None if the
    #: derivatives were not compared with samples.
    converged: bool | None

    def __iter__(self) -> Iterator[Floats]:
        """The image and the derivatives."""
        return iter((self.image, self.derivatives))

    def __len__(self) -> int:
        """Two: the image and the derivatives."""
        return 2

    def __getitem__(self, number: int) -> Floats:
        """The image, 0, or the derivatives, 1."""
        return (self.image, self.derivatives)[number]


class Derivatives:
    """The derivatives of a model by `count` parameters; arguments as of `jacobian`."""

    def __init__(
        self,
        model: ModelOf,
        count: int,
        derivative: ModelOf | str | None,
        difference_steps: Any,
        linear: Sequence[int],
    ) -> None:
        steps = difference_steps
        if isinstance(derivative, str) and derivative != "jax":
            raise ValueError(f'`derivative` is {derivative!r}: expected a function, "jax" or None')
        if derivative is not None and steps is not None:
            raise ValueError(
                "`difference_steps` are of differences: expected no `derivative` beside them"
            )
        if steps is not None and np.shape(steps) != (count,):
            raise ValueError(
                f"`difference_steps` have the shape {np.shape(steps)}: expected ({count},)"
            )
        for number in linear:
            if not 0 <= number < count:
                raise ValueError(f"`linear` has the parameter {number}: expected 0 to {count - 1}")
        of_model = getattr(model, "derivative", None)
        #: Whether they are those that the model itself has.
        self.is_of_model = derivative is None and steps is None and callable(of_model)
        if self.is_of_model:
            derivative = of_model
        self.model = _in_64_bits(model) if derivative == "jax" else model
        self.count = count
        self.derivative = derivative
        self.steps = None if steps is None else np.asarray(steps, dtype=np.float64)
        if self.steps is not None and not np.all(np.isfinite(self.steps) & (self.steps != 0)):
            raise ValueError(
                f"`difference_steps` are {steps}: expected finite numbers that are not 0"
            )
        self.linear = tuple(linear)
        #: The changes of parameters by which displacements of surfaces were found the last time.
        self._by_surfaces: dict[int, float] = {}

    def emission(self, theta: Floats) -> Callable[..., Any]:
        """The emission at some parameters."""
        emission = self.model(*theta.tolist())
        if isinstance(emission, str) or not callable(emission):
            raise TypeError(f"`model` returned {emission!r}: expected a function")
        return emission  # type: ignore[no-any-return]

    def changes(self, theta: Floats) -> dict[int, Callable[..., Any]]:
        """The derivatives of g times changes of parameters, by their numbers, but linear ones."""
        numbers = [number for number in range(self.count) if number not in self.linear]
        return {number: self._change(theta, number) for number in numbers}

    def _change(self, theta: Floats, number: int) -> Callable[..., Any]:
        if self.is_of_model:
            self._refuse_jumps()
            assert callable(self.derivative)
            derivatives = self.derivative(*theta.tolist())
            size = _CHANGE * (abs(theta[number]) or 1.0)
            return lambda *arguments: size * derivatives(*arguments)[:, number]
        (above, below), width = self._moved(theta, number)
        scale = _CHANGE * (abs(theta[number]) or 1.0) / width

        def change(*arguments: Any) -> Any:
            return scale * (above(*arguments) - below(*arguments))

        return change

    def _moved(
        self, theta: Floats, number: int, share: float = 1.0
    ) -> tuple[list[Callable[..., Any]], float]:
        """The emissions one step above and below a parameter, and the distance between them.

        share: the share of the usual step.
        """
        if self.steps is not None:
            step = float(self.steps[number])
        else:
            step = RELATIVE_STEP * (abs(float(theta[number])) or 1.0)
        emissions, places = [], []
        for moved_by in (share * step, -share * step):
            moved = theta.copy()
            moved[number] += moved_by
            places.append(float(moved[number]))
            emissions.append(self.emission(moved))
        return emissions, places[0] - places[1]

    def images(self, plan: Plan, theta: Floats, image: Floats) -> Floats:
        """The derivatives (p, *image.shape) of the image at some parameters."""
        found = np.empty((self.count, *plan.shape))
        others = [number for number in range(self.count) if number not in self.linear]
        for number in self.linear:
            found[number] = self._of_amplitude(plan, theta, image, number)
        if others and self.derivative is not None:
            self._refuse_jumps()
            found[others] = plan.apply(self._given(plan.points, theta)[:, others])
        elif others:
            for number in others:
                found[number] = self._difference(plan, theta, number)
        return found

    def images_by_surfaces(self, rendering: Rendering, theta: Floats) -> Floats:
        """The derivatives (p, *image.shape) of the image of a rendering that has found surfaces."""
        found = np.zeros((self.count, *rendering.image.shape))
        for number in self.linear:
            if theta[number] == 0:
                raise ValueError(
                    f"the parameter {number} is `linear` and 0: expected another number, as there "
                    "are no surfaces without it"
                )
            found[number] = rendering.image / theta[number]
        others = [number for number in range(self.count) if number not in self.linear]
        if not others:
            return found
        moving = MovingSurfaces(rendering, self.emission(theta))
        found[others] = moving.smooth(self._between(moving, theta)[:, others])
        names, moves = getattr(self.model, "names", ()), getattr(self.model, "moves_jumps", None)
        for number in others:
            if moves is not None and names and names[number] not in moves:
                continue
            size = abs(float(theta[number])) or 1.0
            first = self._by_surfaces.get(number, FIRST_CHANGE * size)
            speed, change = moving.speed(self._changed(theta, number), first)
            self._by_surfaces[number] = change
            found[number] += moving.image(speed)
        return found

    def _changed(self, theta: Floats, number: int) -> Callable[[float], Callable[..., Any]]:
        """The emission as a function of the change of a parameter."""

        def changed(by: float) -> Callable[..., Any]:
            moved = theta.copy()
            moved[number] += by
            return self.emission(moved)

        return changed

    def _between(self, moving: MovingSurfaces, theta: Floats) -> Floats:
        """The derivatives (n, p) of the rates at points between surfaces."""
        points = moving.pieces.points
        if self.derivative is not None:
            return self._given(points, theta)
        found = np.zeros((len(points), self.count))
        for number in range(self.count):
            if number not in self.linear:
                (above, below), width = self._moved(theta, number)
                difference = moving.rates(above, points) - moving.rates(below, points)
                found[:, number] = difference / width
                large = abs(difference) > 0.25 * moving.least_jump
                if large.any():
                    found[large, number] = self._nearby(moving, points, large, theta, number)
        return found

    def _nearby(
        self, moving: MovingSurfaces, points: Points, chosen: Any, theta: Floats, number: int
    ) -> Floats:
        """The derivatives of the rates at points with a large difference, from a smaller step.

        A difference that stays large is that of a surface between both, which is counted as such.
        """
        energy = None if points.energy is None else points.energy[chosen]
        points = Points(points.position[chosen], points.direction[chosen], energy)
        (above, below), width = self._moved(theta, number, share=1 / 16)
        difference = moving.rates(above, points) - moving.rates(below, points)
        difference[abs(difference) > 0.25 * moving.least_jump] = 0.0
        return difference / width

    def _of_amplitude(self, plan: Plan, theta: Floats, image: Floats, number: int) -> Floats:
        if theta[number] != 0:
            return image / theta[number]
        one = theta.copy()
        one[number] = 1.0
        return plan.apply(plan.rates(self.emission(one)))

    def _difference(self, plan: Plan, theta: Floats, number: int) -> Floats:
        (above, below), width = self._moved(theta, number)
        return plan.apply((plan.rates(above) - plan.rates(below)) / width)

    def _refuse_jumps(self) -> None:
        """Raises `ValueError` if a surface at which g jumps moves with a parameter."""
        moving = getattr(self.model, "moves_jumps", ()) if self.is_of_model else ()
        parameters = getattr(self.model, "names", ())
        linear = [parameters[number] for number in self.linear] if moving else []
        names = ", ".join(f"`{name}`" for name in moving if name not in linear)
        if names:
            raise ValueError(
                f"the rates jump at a surface that moves with {names}: their derivatives are not "
                "those of the image, and the rendering has found no such surfaces; expected other "
                "parameters, `difference_steps`, or "
                "`derivative=model.derivative` without that part"
            )

    def _given(self, points: Points, theta: Floats) -> Floats:
        arrays = (points.position, points.direction, points.energy)
        given = [array for array in arrays if array is not None]
        if self.derivative == "jax":
            values = _jax_derivatives(self.model, theta, given)
        else:
            assert callable(self.derivative)
            values = self.derivative(*theta.tolist())(*given)
        found = np.asarray(values, dtype=np.float64)
        if found.shape != (len(points), self.count):
            raise ValueError(
                f"the derivatives have the shape {found.shape}: expected "
                f"({len(points)}, {self.count}), one for each point and parameter"
            )
        if not np.isfinite(found).all():
            point, number = np.argwhere(~np.isfinite(found))[0]
            raise ValueError(
                f"the derivative by parameter {number} at {points.position[point].tolist()} is "
                f"{found[point, number]}: expected a finite number"
            )
        return found


def refuse_other_unit(model: Any, camera: Camera | None) -> None:
    """Raises `SceneError` if a published model has another length unit than the camera."""
    in_length_unit = getattr(model, "in_length_unit", None)
    if callable(in_length_unit) and camera is not None:
        in_length_unit(length_unit_of(camera, []))


def _jax_derivatives(model: ModelOf, theta: Floats, given: list[Floats]) -> Any:
    """The derivatives (n, p) of the rates, by forward differentiation."""
    import jax

    with _64_bits():
        arrays = [jax.numpy.asarray(array) for array in given]
        derivatives = jax.jacfwd(lambda parameters: model(*parameters)(*arrays))(
            jax.numpy.asarray(theta)
        )
        return np.asarray(derivatives)


def _in_64_bits(model: ModelOf) -> ModelOf:
    """A model of `jax.numpy` whose rates are computed in 64 bits."""

    @wraps(model)
    def model_of(*theta: Any) -> Any:
        with _64_bits():
            emission = model(*theta)

        @wraps(emission)
        def rates(*arrays: Any) -> Any:
            with _64_bits():
                found = emission(*arrays)
                # Arrays of 64 bits are not for the arithmetic outside.
                return np.asarray(found) if isinstance(arrays[0], np.ndarray) else found

        return rates

    return model_of


def _64_bits() -> AbstractContextManager[Any]:
    """Arithmetic of JAX in 64 bits, in this thread."""
    try:
        import jax
    except ImportError as error:
        raise ImportError('jax is missing: expected it for `derivative` "jax"') from error
    if hasattr(jax, "enable_x64"):
        return jax.enable_x64(True)  # type: ignore[no-any-return]
    from jax.experimental import enable_x64

    return enable_x64()  # type: ignore[no-any-return]
