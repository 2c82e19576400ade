"""How an emission before a camera is rendered: keywords of `render` as a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from emitree import _native, _options, _units
from emitree._amr import AmrGrid
from emitree._cameras import Box, Camera, Ellipsoid, Sphere
from emitree._emissions import Model
from emitree._energies import energy_table
from emitree._fields import Fields
from emitree._function import Function
from emitree._grid import Grid
from emitree._particles import Particles
from emitree._scene import compose, length_unit_of, open_scene
from emitree._several import Several


@dataclass(frozen=True)
class Setup:
    """How an emission before a camera was rendered: all but the emission, for others like it."""

    camera: Camera
    shape: Sequence[int] | int
    #: Keywords of `render` that define the scene and its method.
    options: Mapping[str, Any]
    quantities: bool = False
    batch_size: int | None = None
    threads: int | None = None

    @property
    def unit(self) -> str | None:
        """The unit of the rates."""
        return _units.to_text(self.options.get("unit"))


#: Keywords of `render` that belong to the camera; all others are of the table `[render]`.
OF_VIEW = frozenset(
    [
        "absorption",
        "energy",
        "exposure",
        "unit",
        "image_unit",
        "quantity",
        "bounds",
        "occulters",
        "edges",
        "singularities",
        "seeds",
        "instrument",
    ]
)


def is_function(emission: Any) -> bool:
    """Whether an emission is rendered by calls: a function, and not what a scene has by itself."""
    return callable(emission) and not isinstance(emission, str | Grid | Model)


def with_own(emission: Any, options: Mapping[str, Any]) -> dict[str, Any]:
    """Keywords of `render`, with the bounds, unit and seeds of an emission, if none are given.

    A function may have an attribute `bounds`; an AMR grid has a unit, too, particles have seeds,
    and fields have edges.
    """
    found = dict(options)
    bounds = getattr(emission, "bounds", None) if is_function(emission) else None
    if found.get("bounds") is None and isinstance(bounds, Box | Ellipsoid | Sphere):
        found["bounds"] = bounds
    if found.get("unit") is None and isinstance(emission, AmrGrid):
        found["unit"] = emission.unit
    if isinstance(emission, Fields) and len(found.get("edges", ())) == 0:
        radii = {body.radius for body in found.get("occulters", ()) if isinstance(body, Sphere)}
        found["edges"] = [edge for edge in emission.edges if edge.radius not in radii]
    is_by_vol = found.get("method") in (None, "vol")
    if isinstance(emission, Particles) and is_by_vol and len(found.get("seeds", ())) == 0:
        found["seeds"] = emission.seeds
    return found


def in_length_unit(emission: Any, unit: str | None) -> Any:
    """An emission as a function of positions in a unit, if it has a length unit of its own."""
    if isinstance(emission, Several):
        functions = [in_length_unit(function, unit) for function in emission.functions]
        return Several(functions, emission.names)
    own = getattr(emission, "in_length_unit", None)
    return own(unit) if callable(own) else emission


def before_camera(emission: Any, camera: Camera, shapes: Sequence[Any]) -> Any:
    """Fields as functions of positions in the length unit of a camera, or else of shapes."""
    if not isinstance(emission, Fields):
        return emission
    return emission.in_length_unit(length_unit_of(camera, list(shapes)))


def unit_of_positions(setup: Setup) -> str | None:
    """The length unit of a setup, if it has one."""
    bounds = setup.options.get("bounds")
    return length_unit_of(setup.camera, [] if bounds is None else [bounds])


def scene_of_camera(
    emission: Any, camera: Camera, shape: Sequence[int] | int, options: Mapping[str, Any]
) -> _native.Scene:
    """The scene of an emission before a camera, with keywords of `render` as options."""
    of_view = {key: value for key, value in options.items() if key in OF_VIEW}
    settings = {key: value for key, value in options.items() if key not in OF_VIEW}
    of_scene = values_of(settings, of_view.get("image_unit"))
    # Of `los`, uniform steps and a tolerance exclude each other.
    method, steps = of_scene.get("method"), of_scene.get("steps")
    if (
        of_scene.get("tolerance") is None
        and of_scene.get("rtol") is None
        and of_scene.get("atol") is None
        and method != "paper"
        and not (method == "los" and steps is not None)
    ):
        of_scene["tolerance"] = 0.01
    scene = compose(emission, camera, shape, **of_view, render=of_scene)
    refuse_unused(scene, settings, of_view.get("energy"), of_view.get("seeds", ()), None)
    return scene


def values_of(settings: Mapping[str, Any], image_unit: Any) -> dict[str, Any]:
    """Settings as the table `[render]` has them."""
    values = dict(settings)
    if _units.is_quantity(values.get("atol")):
        if image_unit is None:
            atol = values["atol"]
            raise _native.SceneError(f"`atol` is {atol}: expected an `image_unit` too")
        values["atol"] = _units.value_in(values["atol"], _units.to_text(image_unit), "atol")
    values["max_seconds"] = _units.value_in(values.get("max_seconds"), "s", "max_seconds")
    feature = values.get("smallest_feature")
    values["smallest_feature"] = _units.length_text(feature, "smallest_feature")
    return values


def refuse_unused(
    scene: _native.Scene,
    settings: Mapping[str, Any],
    energy: Any,
    seeds: Sequence[Any],
    changes: Mapping[str, Any] | None,
) -> None:
    """Refuses keywords without effect; those of a scene file that is changed are reported only."""
    given = {key for key, value in settings.items() if value is not None}
    given |= {"seeds"} if len(seeds) else set()
    given |= {key.removeprefix("render.") for key in changes or ()}
    _options.refuse_unused(scene.method, scene.ignored, given)
    table = energy_table(energy) or {}
    if table.get("lines") and scene.method != "vol":
        raise _native.SceneError(
            f"`energy.lines` is given, and method `{scene.method}` does not use it: expected none, "
            "or method `vol`"
        )


def opened_scene(
    path: Any, shape: Any, settings: Mapping[str, Any], changes: Mapping[str, Any] | None
) -> _native.Scene:
    """The scene of a file with changes."""
    given = {key: value for key, value in settings.items() if value is not None}
    values: dict[str, Any] = {f"render.{key}": value for key, value in given.items()}
    if shape is not None:
        height, width = shape
        values |= {"image.height": height, "image.width": width}
    return open_scene(path, values | dict(changes or {}))


def function_in(
    emission: Any, scene: _native.Scene, unit: Any, quantities: bool, takes_components: bool = False
) -> Function | None:
    """A function as the emission of a scene; None of other emissions."""
    if not is_function(emission):
        return None
    energies = scene.energies
    return Function(
        in_length_unit(emission, scene.length_unit),
        unit=_units.to_text(unit),
        length_unit=scene.length_unit,
        energy_unit=energies[1] if energies else None,
        quantities=quantities,
        takes_components=takes_components,
    )


def absorption_in(absorption: Any, scene: _native.Scene, quantities: bool) -> Function | None:
    """A function as the absorption coefficient of a scene, in one over its length unit."""
    unit = scene.length_unit
    return function_in(absorption, scene, None if unit is None else f"{unit}-1", quantities)


def function_of(emission: Callable[..., Any], setup: Setup | None, unit: str | None) -> Function:
    """A function as the emission of a setup; of none, one of plain arrays."""
    if setup is None:
        return Function(emission, unit=unit)
    if not setup.quantities:
        return Function(in_length_unit(emission, unit_of_positions(setup)), unit=unit)
    scene = scene_of_camera(emission, setup.camera, setup.shape, setup.options)
    function = function_in(emission, scene, unit, True)
    assert function is not None
    return function
