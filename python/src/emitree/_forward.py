"""A forward model: from parameters to an image, its Jacobian and its likelihood, for fits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from emitree import _options
from emitree._cameras import Camera
from emitree._cash import cash, counts_as, deviance_residuals
from emitree._counting import Counting
from emitree._function import Floats
from emitree._jacobian import STEPS_ARE_OF_LOS, Derivatives, ModelOf, refuse_other_unit
from emitree._native import RenderError
from emitree._neighbourhood import (
    neighbourhood,
    plan_of_all,
    rendering_of_one,
    serves,
)
from emitree._parameters import (
    checked_amount,
    checked_bounds,
    checked_parameters,
    checked_ranges,
    checked_sigma,
    default_ranges,
)
from emitree._plan import Plan
from emitree._result import Rendering

#: The most evaluations of a renewal, by default, in those of the first rendering: a search that
#: tries parameters far off is not to spend most of its evaluations there.
RENEWAL_LIMIT = 3


class Forward:
    """A model of an image: from parameters to expected counts, for any optimizer or sampler.

    A plan, a fixed set of points, gives the images of all parameters in a neighbourhood by a linear
    map: the statistic is as smooth in the parameters as the rates are. The plan is that of the
    emission at the first parameters. Samples show whether it meets the tolerance also where each of
    them alone is changed by `trust`; if not, it is that of a mixture of these emissions. Where the
    parameters are further than `trust` from all those at which a plan was checked, the nearest plan
    is checked there, and where each parameter is changed by `trust` from there. If it does not
    suffice, a new plan is made (a renewal). The former ones are kept for their neighbourhoods.
    `rendering` estimates the error at any parameters, such as the best ones.

    Only plans of products of functions (smooth emissions, method "vol") can be compared with
    samples. Others are those of the emission at the centre alone; they serve within `trust` without
    a check, and are made anew beyond.

    If the emission jumps at surfaces that the first rendering has found (`Rendering.surfaces`),
    there is no plan: each image is rendered anew, to the tolerance, and the derivatives are those
    of `jacobian` with surfaces that move. The statistic then has jitter as large as the error of
    the images, which `fit_counts` takes into account; optimizers that need each step to decrease
    the statistic do not. Where no surfaces are found, `jacobian` raises `RenderError`.

    At a change of plans the image of the same parameters changes, by less than the sum of both
    errors. The statistic has a small step there: values before and after it are not of the same
    function. Most optimizers pass it, as the next gradient is that of the new plan. One that ends
    at it (a line search without progress) is started again from where it ended. After `freeze`
    there are no checks and no changes, and the statistic is smooth everywhere.

    model: model(*theta) returns a function of (position, direction[, energy]), as of `render`.
    camera, shape, options: as of `render`.
    bounds: the least and largest value of each parameter (p, 2), None for no limit; others raise
        `ValueError`.
    ranges: the range (p,) over which each parameter changes the image considerably; by default the
        first value of each, or its bounds if they are narrower.
    trust: the distance, as a fraction of `ranges`, within which a check is valid.
    background: what is added to the image, a number or an array of the shape of the image [counts].
    exposure: what the image is multiplied with before, a number or an array: area times time.
    linear: numbers of the parameters that the rates are proportional to; they need no check and
        their derivatives no evaluations.
    derivative, difference_steps: as of `jacobian`.
    renewal_limit: the most evaluations of the rendering of a renewal; by default 3 times those of
        the first. Where they do not suffice, the plan is the best so far, and `unconverged` has the
        parameters: an optimizer may try some that are far off.
    on_renewal: a function of (theta, plan) that is called after each renewal.

    Plans are pickled without their setup: a `Forward` for other processes is frozen before.

    >>> import emitree, numpy as np
    >>> def ball(height, width):
    ...     return lambda r, d: height * np.exp(-((r - 0.5) ** 2).sum(axis=1) / width**2)
    >>> forward = emitree.Forward(ball, emitree.Canonical(), (8, 8), background=0.1, linear=[0])
    >>> counts = forward((500.0, 0.3))
    >>> forward.renewals, forward.jacobian((500.0, 0.3)).shape
    (0, (2, 8, 8))
    >>> from scipy.optimize import least_squares
    >>> residuals, slopes = forward.cash_residuals, forward.cash_residuals_jacobian
    >>> found = least_squares(residuals, (450.0, 0.31), slopes, args=(counts,), x_scale="jac")
    >>> bool(np.allclose(found.x, (500, 0.3), rtol=1e-4))
    True
    """

    def __init__(
        self,
        model: ModelOf,
        camera: Camera,
        shape: Sequence[int] | int,
        *,
        bounds: Sequence[Sequence[float | None]] | None = None,
        ranges: Any = None,
        trust: float = 0.1,
        background: Any = 0.0,
        exposure: Any = 1.0,
        linear: Sequence[int] = (),
        derivative: ModelOf | str | None = None,
        difference_steps: Any = None,
        renewal_limit: int | None = None,
        on_renewal: Callable[[Floats, Plan], Any] | None = None,
        **options: Any,
    ) -> None:
        if np.ndim(options.get("steps", 0)) == 1:
            raise TypeError(STEPS_ARE_OF_LOS)
        if not 0 < trust:
            raise ValueError(f"`trust` is {trust}: expected a positive number")
        refuse_other_unit(model, camera)
        self._model = model
        self._camera = camera
        self._shape = shape
        self._options = options
        self._bounds = checked_bounds(bounds)
        self._ranges = checked_ranges(ranges, self._bounds)
        self._trust = trust
        self._background = checked_amount("background", background)
        self._exposure = checked_amount("exposure", exposure)
        self._linear = tuple(linear)
        self._derivative = derivative
        self._difference_steps = difference_steps
        self._renewal_limit = _options.count("renewal_limit", renewal_limit, "evaluations")
        self._on_renewal = on_renewal
        self._derivatives: Derivatives | None = None
        self._plans: list[_Served] = []
        self._present: _Served | None = None
        self._latest: tuple[bytes, Floats] | None = None
        #: The parameters and the rendering that was made last, if it is one of found surfaces.
        self._by_surfaces: tuple[bytes, Rendering] | None = None
        #: How often g was evaluated, everything counted; a point of a derivative counts as one.
        self.evaluations = 0
        #: How often the plan was checked at parameters far from the former ones.
        self.checks = 0
        #: How often a new plan was made after the first.
        self.renewals = 0
        #: Parameters whose plan was not found to meet the tolerance there and in all directions.
        self.unconverged: list[Floats] = []
        #: Whether checks and renewals are off.
        self.frozen = False

    def __call__(self, theta: Any) -> Floats:
        """The expected counts, exposure * image + background, of the shape of the image.

        Where the tolerance is not met within the limits of the options, `unconverged` has theta.

        Raises `ValueError` if a parameter is not finite or not within its bounds, `RenderError` if
        the tolerance is not met at the first parameters, and what the model raises.
        """
        return self._expected(self._checked_theta(theta))

    def jacobian(self, theta: Any) -> Floats:
        """The derivatives of the expected counts by the parameters, (p, *image.shape)."""
        parameters = self._checked_theta(theta)
        plan, image = self._image(parameters)
        differentiated = self._differentiated(parameters)
        if plan is not None:
            return self._exposure * differentiated.images(plan, parameters, image)
        assert self._by_surfaces is not None
        rendering = self._by_surfaces[1]
        if rendering.surfaces is None:
            raise RenderError(
                f"no surfaces were found at theta = {parameters.tolist()}, where the rates jump: "
                "expected parameters nearer to the first ones, or a larger `max_evaluations`"
            )
        return self._exposure * differentiated.images_by_surfaces(rendering, parameters)

    def residuals(self, theta: Any, data: Any, sigma: Any = 1.0) -> Floats:
        """(expected - data) / sigma, (pixels,), for `scipy.optimize.least_squares`.

        data: the measured image; pixels that are NaN there or in the image give 0.
        sigma: its standard deviations, a number or an array, positive.
        """
        measured, deviation = self._measured(data), checked_sigma(sigma)
        found = (self(theta) - measured) / deviation
        return np.where(np.isnan(found), 0.0, found).ravel()

    def residuals_jacobian(self, theta: Any, data: Any, sigma: Any = 1.0) -> Floats:
        """The derivatives (pixels, p) of `residuals`, for `jac` of `least_squares`."""
        measured, deviation = self._measured(data), checked_sigma(sigma)
        found = self.jacobian(theta) / deviation
        found = np.where(np.isnan(measured) | np.isnan(found), 0.0, found)
        return found.reshape(len(found), -1).T.copy()

    def cash(self, theta: Any, counts: Any) -> float:
        """The statistic of Cash (1979), 2 sum(mu - n log(mu)), of counts n and expected counts mu.

        It is -2 log L of Poisson distributions but for a constant: parameters within one standard
        deviation are those with at most 1 more than the least. Pixels that are NaN do not count.
        Below mu = 1e-9 the logarithm is continued by its quadratic Taylor polynomial, so that the
        statistic is finite and smooth where the image is not positive.
        """
        return cash(self(theta), self._counts(counts))[0]

    def cash_gradient(self, theta: Any, counts: Any) -> Floats:
        """The derivatives (p,) of `cash` by the parameters."""
        return self.cash_and_gradient(theta, counts)[1]

    def cash_and_gradient(self, theta: Any, counts: Any) -> tuple[float, Floats]:
        """`cash` and `cash_gradient`: what `scipy.optimize.minimize` takes with `jac=True`."""
        parameters, observed = self._checked_theta(theta), self._counts(counts)
        statistic, slope = cash(self._expected(parameters), observed)
        derivatives = self.jacobian(parameters).reshape(len(parameters), -1)
        seen = slope.ravel() != 0
        return statistic, derivatives[:, seen] @ slope.ravel()[seen]

    def cash_residuals(self, theta: Any, counts: Any) -> Floats:
        """Residuals (pixels,) whose squares add up to `cash`, but for a constant.

        They are the signed roots of the deviance, sign(mu - n) sqrt(2 (mu - n + n log(n / mu))).
        With them `scipy.optimize.least_squares` finds the least Cash statistic in few steps, none
        of them far. Pixels that are NaN give 0; mu counts as 1e-9 at least.
        """
        return deviance_residuals(self(theta), self._counts(counts))[0].ravel()

    def cash_residuals_jacobian(self, theta: Any, counts: Any) -> Floats:
        """The derivatives (pixels, p) of `cash_residuals`, for `jac` of `least_squares`."""
        parameters, observed = self._checked_theta(theta), self._counts(counts)
        _, slope = deviance_residuals(self._expected(parameters), observed)
        derivatives = np.where(slope == 0, 0.0, slope * self.jacobian(parameters))
        return derivatives.reshape(len(parameters), -1).T.copy()

    def rendering(self, theta: Any) -> Rendering:
        """The image at some parameters by the present plan, with the estimate of its error.

        It is that of the model, without exposure and background; nothing is renewed. `converged` is
        False if the plan does not suffice there.
        """
        parameters = self._checked_theta(theta)
        if self._present is not None:
            return self._present.plan.render(self._emission(parameters))
        first = self._rendered(parameters)
        if self._by_surfaces is not None:
            return first
        return self._first(parameters, first).render(self._emission(parameters))

    def has_derivatives(self, theta: Any) -> bool:
        """Whether there are derivatives: of images of surfaces, only where these were found.

        Where they are not the image does not meet the tolerance, or takes many evaluations.
        """
        parameters = self._checked_theta(theta)
        plan, _ = self._image(parameters)
        if plan is not None:
            return True
        assert self._by_surfaces is not None
        return self._by_surfaces[1].surfaces is not None

    def within_bounds(self, theta: Floats) -> Floats:
        """The nearest parameters within the bounds."""
        return theta if self._bounds is None else np.clip(theta, *self._bounds.T)

    def freeze(self) -> Forward:
        """Ends checks and renewals: from now on there is one plan, and one smooth statistic.

        It returns the same `Forward`. Far from the parameters where the plan was checked the errors
        may be larger than the tolerance, which `rendering` tells.

        Raises `ValueError` before the first parameters.
        """
        if self._present is None:
            raise ValueError("there is no plan to freeze: expected an image before")
        self.frozen = True
        return self

    def thaw(self) -> Forward:
        """Checks and renews again, after `freeze`; it returns the same `Forward`."""
        self.frozen = False
        return self

    @property
    def plan(self) -> Plan | None:
        """The present plan; None before the first parameters."""
        return None if self._present is None else self._present.plan

    def __getstate__(self) -> dict[str, Any]:
        """What is pickled: without the function that is told of renewals."""
        by_surfaces = self._by_surfaces
        if by_surfaces is not None:
            # A copied rendering has no setup: it is made anew.
            by_surfaces = b"", by_surfaces[1]
        return self.__dict__ | {"_on_renewal": None, "_by_surfaces": by_surfaces}

    def _checked_theta(self, theta: Any) -> Floats:
        parameters = checked_parameters(theta)
        for name, limits in (("bounds", self._bounds), ("ranges", self._ranges)):
            if limits is not None and len(limits) != len(parameters):
                raise ValueError(
                    f"`{name}` are those of {len(limits)} parameters: expected {len(parameters)}, "
                    "as many as in `theta`"
                )
        if self._bounds is not None:
            for number, (value, (low, high)) in enumerate(
                zip(parameters, self._bounds, strict=True)
            ):
                if not low <= value <= high:
                    raise ValueError(
                        f"parameter {number} of `theta` is {value}: expected {low} to {high}, its "
                        "`bounds`"
                    )
        self._differentiated(parameters)
        return parameters

    def _differentiated(self, theta: Floats) -> Derivatives:
        if self._derivatives is None:
            count, steps, linear = len(theta), self._difference_steps, self._linear
            derivative = self._derivative
            if callable(derivative):
                derivative = self._counting(derivative)
            self._derivatives = Derivatives(
                self._counting(self._model), count, derivative, steps, linear
            )
        if len(theta) != self._derivatives.count:
            raise ValueError(
                f"`theta` has {len(theta)} parameters: expected {self._derivatives.count}, as "
                "before"
            )
        return self._derivatives

    def _counting(self, model: ModelOf) -> ModelOf:
        """A model that counts its evaluations."""
        return Counting(self, model)

    def _emission(self, theta: Floats) -> Callable[..., Any]:
        return self._differentiated(theta).emission(theta)

    def _expected(self, theta: Floats) -> Floats:
        _, image = self._image(theta)
        return self._exposure * image + self._background

    def _image(self, theta: Floats) -> tuple[Plan | None, Floats]:
        """The plan for some parameters, and their image by it; no plan if it is one of surfaces."""
        key = theta.tobytes()
        first = self._rendered(theta) if self._present is None else None
        if first is not None and self._by_surfaces is not None:
            return None, first.image
        plan = self._plan_for(theta, first)
        if self._latest is None or self._latest[0] != key:
            self._latest = (key, plan.apply(plan.rates(self._emission(theta))))
        return plan, self._latest[1]

    def _rendered(self, theta: Floats) -> Rendering:
        """The rendering at some parameters, which is kept if it, or one before, has surfaces."""
        key = theta.tobytes()
        if self._by_surfaces is not None and self._by_surfaces[0] == key:
            return self._by_surfaces[1]
        found = rendering_of_one(self._emission(theta), self._camera, self._shape, self._options)
        if found.surfaces is not None or self._by_surfaces is not None:
            self._by_surfaces = (key, found)
            if not found.converged:
                self.unconverged.append(theta.copy())
        return found

    def _plan_for(self, theta: Floats, first: Rendering | None) -> Plan:
        """The plan for some parameters: the present one, as long as it was checked near them.

        first: the rendering at these parameters, if there is no plan.
        """
        if self._present is None:
            return self._first(theta, first)
        if self.frozen or self._is_near(self._present, theta):
            return self._present.plan
        near = min(self._plans, key=lambda served: self._distance(served, theta))
        if not self._is_near(near, theta):
            near = self._checked_there(near, theta)
        if near is not self._present:
            self._latest = None
        self._present = near
        return near.plan

    def _first(self, theta: Floats, rendering: Rendering | None) -> Plan:
        """The plan of the first parameters, of which there may be a rendering."""
        if self._ranges is None:
            self._ranges = default_ranges(theta, self._bounds, self._linear)
        self._present, first = self._made(theta, self._options, rendering)
        if not first.converged:
            raise RenderError(
                f"the tolerance is not met at theta = {theta.tolist()}: the estimated error is "
                f"{first.estimated_error} of the largest pixel; expected a larger "
                "`max_evaluations` or `tolerance`"
            )
        if self._renewal_limit is None:
            self._renewal_limit = RENEWAL_LIMIT * first.evaluations
        return self._present.plan

    def _checked_there(self, near: _Served, theta: Floats) -> _Served:
        """A plan for some parameters: the near one if it serves them, or a new one."""
        self.checks += 1
        if serves(near.plan, self._neighbourhood(theta)):
            near.checked.append(theta.copy())
            return near
        limits = [self._renewal_limit, self._options.get("max_evaluations")]
        limit = min(limit for limit in limits if limit is not None)
        served, _ = self._made(theta, self._options | {"max_evaluations": limit})
        self.renewals += 1
        if self._on_renewal is not None:
            self._on_renewal(theta.copy(), served.plan)
        return served

    def _made(
        self, theta: Floats, options: dict[str, Any], first: Rendering | None = None
    ) -> tuple[_Served, Rendering]:
        """A new plan for some parameters, and the rendering that it is of."""
        emissions = self._neighbourhood(theta)
        if first is None:
            first = rendering_of_one(self._emission(theta), self._camera, self._shape, options)
        if first.surfaces is not None:
            raise RenderError(
                f"the rates jump at surfaces at theta = {theta.tolist()}, and did not at the first "
                "parameters: expected a `Forward` whose first parameters have these surfaces"
            )
        found = plan_of_all(emissions, self._camera, self._shape, options, first)
        if not found.suffices:
            self.unconverged.append(theta.copy())
        served = _Served(found.plan, [theta.copy()])
        self._plans.append(served)
        return served, found.first

    def _neighbourhood(self, theta: Floats) -> list[Any]:
        """The emissions at some parameters and where each of them alone is changed by `trust`."""
        assert self._ranges is not None
        distances = self._trust * self._ranges
        distances[list(self._linear)] = 0.0
        return neighbourhood(self._emission, theta, distances, self._bounds)

    def _distance(self, served: _Served, theta: Floats) -> float:
        """The distance to the nearest parameters at which a plan was checked, in `ranges`."""
        assert self._ranges is not None
        distances = abs(np.array(served.checked) - theta) / self._ranges
        distances[:, list(self._linear)] = 0.0
        return float(distances.max(axis=1).min())

    def _is_near(self, served: _Served, theta: Floats) -> bool:
        return self._distance(served, theta) <= self._trust

    def _measured(self, data: Any) -> Floats:
        measured = np.asarray(data, dtype=np.float64)
        shape = measured.shape
        if self.plan is not None:
            shape = self.plan.shape
        elif self._by_surfaces is not None:
            shape = self._by_surfaces[1].image.shape
        if measured.shape != shape:
            raise ValueError(f"the data have the shape {measured.shape}: expected {shape}")
        return measured

    def _counts(self, counts: Any) -> Floats:
        measured = self._measured(counts)
        return counts_as(measured, measured.shape)


@dataclass(frozen=True)
class _Served:
    """A plan, and the parameters at which it was checked."""

    plan: Plan
    checked: list[Floats]
