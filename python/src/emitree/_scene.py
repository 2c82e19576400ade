"""From keywords to a scene: the text of a scene file is written, and the one reader checks it all.

So every camera, emission and option of the command is there, with the same words and messages.
"""

from __future__ import annotations

import json
import math
import os
import tempfile
from collections.abc import Mapping
from typing import Any

import numpy as np

from emitree import _native, _units
from emitree._cameras import Camera
from emitree._emissions import Expression, Model, Tree
from emitree._energies import energy_table
from emitree._exposure import exposure_table
from emitree._function import name_of
from emitree._grid import Aliases, Grid
from emitree._instrument import instrument_table

#: What reports call a scene that was made from keywords.
NAME = "emitree"


def toml(value: Any) -> str:
    """A value as TOML writes it.

    >>> toml({"a": [1.0, float("inf")], "b": "c"})
    '{ a = [1.0, inf], b = "c" }'
    """
    value = _units.plain(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else f"{value:f}"
    if isinstance(value, str):
        return json.dumps(value).replace("\x7f", "\\u007f")
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    if isinstance(value, Mapping):
        items = ", ".join(f"{_key(key)} = {toml(item)}" for key, item in value.items())
        return f"{{ {items} }}"
    raise TypeError(f"{value!r} is {type(value).__name__}: expected numbers, texts, lists, tables")


def _key(key: str) -> str:
    bare = key.isascii() and key.replace("_", "").replace("-", "").isalnum()
    return key if bare else json.dumps(key)


def _named(table: str, key: str, value: Any) -> str:
    """A value as TOML writes it; an error names its key."""
    try:
        return toml(value)
    except TypeError as error:
        raise _native.SceneError(f"`{table}.{key}`: {error}") from None


def document(tables: Mapping[str, Any]) -> str:
    """The text of a scene: one table after the other, lists as tables of the same name."""
    lines: list[str] = []
    for name, table in tables.items():
        several = isinstance(table, list)
        for one in table if several else [table]:
            lines.append(f"[[{name}]]" if several else f"[{name}]")
            lines.extend(f"{_key(key)} = {_named(name, key, value)}" for key, value in one.items())
            lines.append("")
    return "\n".join(lines)


def emission_table(
    emission: Any, folder: str, length_unit: str | None, unit: str | None
) -> tuple[dict[str, Any], Aliases]:
    """The table `[emission]`, a function by its name; and what temporary files are called."""
    if isinstance(emission, str):
        return Expression(emission).table(), []
    if isinstance(emission, Grid):
        return emission.table(folder, length_unit, unit)
    if isinstance(emission, Expression | Model | Tree):
        return emission.table(), []
    if callable(emission):
        return {"function": name_of(emission)}, []
    raise TypeError(
        f"the emission is {type(emission).__name__}: expected a function f(position, direction), a "
        "text with a formula, or an emitree.Expression, Model, Grid or Tree"
    )


def absorption_table(
    absorption: Any, folder: str, length_unit: str | None
) -> tuple[dict[str, Any], Aliases]:
    """The table `[absorption]`; numbers are in one over the length unit."""
    if absorption is None:
        return {}, []
    unit = None if length_unit is None else f"{length_unit}-1"
    own = os.path.join(folder, "absorption")
    os.mkdir(own)
    try:
        table, aliases = emission_table(absorption, own, length_unit, unit)
    except TypeError as error:
        message = str(error).replace("the emission is", "the absorption is")
        raise TypeError(message) from None
    return {"unit": unit} | table, aliases


def image_table(camera: Camera, shape: Any) -> dict[str, Any]:
    """The table `[image]` of a shape (height, width); of a sky, also nside alone."""
    sides = np.asarray(shape).tolist()
    if camera._is_sky:
        if isinstance(sides, list) and len(sides) == 2 and sides[0] == 12 * sides[1]:
            sides = sides[1]
        if not isinstance(sides, int):
            raise _native.SceneError(f"`shape` is {shape}: expected nside, or (12 nside, nside)")
        return {"nside": sides}
    if not (isinstance(sides, list) and len(sides) == 2):
        raise _native.SceneError(f"`shape` is {shape}: expected (height, width)")
    return {"width": sides[1], "height": sides[0]}


def compose(
    emission: Any,
    camera: Camera,
    shape: Any,
    *,
    unit: Any = None,
    image_unit: Any = None,
    quantity: str | None = None,
    energy: Any = None,
    exposure: Any = None,
    bounds: Any = None,
    occulters: Any = (),
    edges: Any = (),
    singularities: Any = (),
    seeds: Any = (),
    instrument: Any = None,
    absorption: Any = None,
    render: Mapping[str, Any],
    build: Mapping[str, Any] | None = None,
) -> _native.Scene:
    """The scene of these keywords, read and checked."""
    given = [bounds] if bounds is not None else []
    shapes = [*given, *occulters, *edges, *singularities]
    length_unit = length_unit_of(camera, shapes)
    projection = camera.table(length_unit)
    if length_unit is not None:
        projection["length_unit"] = length_unit
    image = image_table(camera, shape)
    image |= {"unit": _units.to_text(image_unit), "quantity": quantity}
    with tempfile.TemporaryDirectory(prefix="emitree-") as folder:
        of_rates = _units.to_text(unit)
        of_emission, aliases = emission_table(emission, folder, length_unit, of_rates)
        of_emission = {"unit": of_rates} | of_emission
        of_absorption, of_coefficient = absorption_table(absorption, folder, length_unit)
        render, of_maps = with_maps(render, folder)
        aliases = [*aliases, *of_coefficient, *of_maps]
        tables: dict[str, Any] = {
            "emission": of_emission,
            "absorption": of_absorption,
            "projection": projection,
            "sky": camera.sky.table if camera.sky is not None else None,
            "image": image,
            "energy": energy_table(energy),
            "time": exposure_table(exposure, length_unit),
            "instrument": instrument_table(instrument),
            "bounds": bounds.table(length_unit) if bounds is not None else None,
            "occulter": [body.table(length_unit) for body in occulters],
            "edge": [edge.table(length_unit) for edge in edges],
            "singularity": [of.table(length_unit) for of in singularities],
            "seed": [seed_table(seed, length_unit) for seed in seeds],
            "render": render,
            "build": build,
        }
        text = document({name: _given(table) for name, table in tables.items() if table})
        try:
            return _native.Scene.parse(NAME, text, aliases)
        except _native.SceneError as error:
            if isinstance(emission, Grid) and "it has no array `values`" in str(error):
                raise _native.SceneError(f"{error}; `variable` chooses one") from None
            raise


def _given(table: Any) -> Any:
    if isinstance(table, list):
        return table
    return {key: value for key, value in table.items() if value is not None}


def length_unit_of(camera: Camera, shapes: list[Any]) -> str | None:
    """The length unit that is named, or else that of the first quantity."""
    if camera.length_unit is not None:
        return _units.to_text(camera.length_unit)
    lengths = [value for thing in (camera, *shapes) for value in thing.lengths()]
    return _units.to_text(_units.first_unit(lengths))


def seed_table(seed: Any, length_unit: str | None) -> dict[str, Any]:
    """A table `[[seed]]` of (position, radius)."""
    position, radius = seed
    return {
        "position": _units.plain(_units.value_in(position, length_unit, "position")),
        "radius": _units.plain(_units.value_in(radius, length_unit, "radius")),
    }


def is_scene_file(emission: Any) -> bool:
    """Whether an emission is the name of a scene file."""
    if isinstance(emission, os.PathLike):
        return True
    return isinstance(emission, str) and emission.endswith(".toml")


def open_scene(path: Any, changes: Mapping[str, Any]) -> _native.Scene:
    """The scene file at `path` with values replaced."""
    with tempfile.TemporaryDirectory(prefix="emitree-") as folder:
        changes, aliases = with_maps(changes, folder)
        given = [(key, toml(value)) for key, value in changes.items() if value is not None]
        return _native.Scene.open(path, given, aliases)


#: Keys of `[render]` that name files of maps.
_MAPS = ("weights", "mask")


def with_maps(table: Mapping[str, Any], folder: str) -> tuple[dict[str, Any], Aliases]:
    """The keys of `[render]` with the names of files for arrays of weights, and their aliases."""
    found, aliases = dict(table), Aliases()
    for key, value in table.items():
        name = key.removeprefix("render.")
        if value is None:
            continue
        if name in _MAPS:
            found[key], of_map = _map_file(name, value, os.path.join(folder, f"{name}.npy"))
            aliases += of_map
        elif name == "sums":
            found[key], of_maps = _sums_table(value, folder)
            aliases += of_maps
    return found, aliases


def _map_file(name: str, value: Any, file: str) -> tuple[str, Aliases]:
    """The file of a map, which is written if the map is an array."""
    if isinstance(value, str | os.PathLike):
        return os.path.abspath(value), Aliases()
    try:
        array = np.ascontiguousarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise _native.SceneError(
            f"`{name}` is {type(value).__name__}: expected an array (height, width) of numbers"
        ) from None
    np.save(file, array)
    alias = f"array of shape {array.shape}"
    return file, Aliases([(file, alias), (json.dumps(file)[1:-1], alias)])


def _sums_table(sums: Any, folder: str) -> tuple[dict[str, Any], Aliases]:
    """The table `render.sums`: each mask that is an array has a file."""
    if not isinstance(sums, Mapping):
        raise _native.SceneError(
            f"`sums` is {type(sums).__name__}: expected a dictionary of regions by name"
        )
    found, aliases = {}, Aliases()
    for number, (name, value) in enumerate(sums.items()):
        table = dict(value) if isinstance(value, Mapping) else {"mask": value}
        if "mask" in table:
            file = os.path.join(folder, f"sum-{number}.npy")
            table["mask"], of_map = _map_file(f"sums.{name}.mask", table["mask"], file)
            aliases += of_map
        found[name] = table
    return found, aliases
