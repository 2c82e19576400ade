"""How renderings are shown: datasets of xarray, plots of matplotlib, HTML."""

from __future__ import annotations

import base64
import html
from typing import TYPE_CHECKING, Any

import numpy as np

from emitree import _native
from emitree._display_places import span_html, table_html
from emitree._function import Floats

if TYPE_CHECKING:
    from emitree._result import Rendering


def xarray_of(rendering: Rendering, found: _native.Rendered) -> Any:
    """The dataset of `Rendering.to_xarray`."""
    import xarray

    dims, coords = [], {}
    if found.energies is not None:
        edges, of_edges = found.energies
        third = "energy" if rendering.energies is not None else "time"
        dims.append(third)
        coords[third] = (third, 0.5 * (edges[1:] + edges[:-1]), {"units": of_edges})
    axes = found.axes()
    for dim, axis in zip(("y", "x"), reversed(axes), strict=False):
        name, unit, places = axis
        coords[dim] = (dim, places, {"long_name": name, "units": unit or "1"})
    dims += ["y", "x"] if axes else ["face_row", "column"]
    values = {"image": rendering.image} | (
        {} if rendering.error is None else {"error": rendering.error}
    )
    attributes = {"units": rendering.unit or "1"}
    variables = {name: (dims, array, attributes) for name, array in values.items()}
    about = {key: rendering.report[key] for key in ("evaluations", "method", "version")}
    return xarray.Dataset(variables, coords, about)


def plotted(
    rendering: Rendering, found: _native.Rendered, ax: Any, bin: int | None, options: dict[str, Any]
) -> Any:
    """The axes of `Rendering.plot`."""
    import matplotlib.pyplot as plt

    axes = found.axes()
    if ax is None:
        _, ax = plt.subplots()
    if not axes:
        image, unit = found.picture(400), found.flat_unit
    elif rendering.image.ndim == 3 and bin is not None:
        image, unit = rendering.image[bin], rendering.unit
    else:
        image, unit = rendering.flat_image, found.flat_unit
    options = {"origin": "lower", "interpolation": "nearest", **options}
    if axes:
        options.setdefault("extent", [end for axis in axes for end in _ends(axis[2])])
        for axis, label in zip(axes, (ax.set_xlabel, ax.set_ylabel), strict=True):
            label(axis[0] + (f" [{axis[1]}]" if axis[1] else ""))
    else:
        ax.set_axis_off()
    shown = ax.imshow(image, **options)
    ax.figure.colorbar(shown, ax=ax, label=rendering.report["image"]["quantity"] + _bracketed(unit))
    return ax


def html_of(rendering: Rendering, png: bytes) -> str:
    """The HTML of a rendering in notebooks."""
    image = base64.b64encode(png).decode()
    low, high = rendering.report["image"]["min"], rendering.report["image"]["max"]
    error = rendering.estimated_error
    rows = {
        "shape": " &times; ".join(map(str, rendering.image.shape)),
        rendering.report["image"][
            "quantity"
        ]: f"{low:.4g} to {high:.4g} {html.escape(rendering.unit)}",
        "method": rendering.report["method"],
        "evaluations": f"{rendering.evaluations:,}",
        "error": "not estimated" if error is None else f"{error:.2e} of the largest value",
        "converged": "yes" if rendering.converged else "<b>no</b>",
    }
    if rendering.energies is not None:
        rows["energies"] = _bins_html(rendering.energies, rendering.energy_unit or "")
        rows["spectrum"] = _steps_svg(rendering, rendering.energies)
    if rendering.times is not None:
        rows["times"] = _bins_html(rendering.times, "s")
        if len(rendering.times) > 2:
            rows["light curve"] = _steps_svg(rendering, rendering.times)
    style = "height:12em;image-rendering:pixelated"
    return (
        '<div style="display:flex;gap:1em;align-items:center">'
        f'<img alt="the image" style="{style}" src="data:image/png;base64,{image}">'
        f"{table_html(rows)}</div>"
    )


def _bins_html(edges: Floats, unit: str) -> str:
    """The range of bins, and how many there are."""
    low, high = edges[[0, -1]].tolist()
    bins = len(edges) - 1
    return f"{span_html(low, high, unit)}, {bins} bin{'s' if bins > 1 else ''}"


def _steps_svg(rendering: Rendering, edges: Floats) -> str:
    """The mean over the pixels in each bin, as steps."""
    image = rendering.image.reshape(len(rendering.image), -1)
    means = image[:, ~np.isnan(image).any(axis=0)].mean(axis=1) if image.size else np.zeros(0)
    if not np.isfinite(means).all() or len(means) == 0:
        return "no values"
    width, height = 160, 60
    low, high = min(0.0, float(means.min())), float(means.max())
    x = (edges - edges[0]) / np.ptp(edges) * width
    y = height * (1 - (means - low) / (high - low if high > low else 1.0))
    steps = np.stack([np.repeat(x, 2)[1:-1], np.repeat(y, 2)], axis=1)
    points = " ".join(f"{across:.1f},{down:.1f}" for across, down in steps)
    title = f"the mean over the pixels, up to {high:.4g} {html.escape(rendering.unit)}".rstrip()
    return (
        f'<svg width="{width}" height="{height + 2}" viewBox="0 -1 {width} {height + 2}" '
        'role="img">'
        f"<title>{title}</title>"
        f'<polyline points="{points}" fill="none" stroke="currentColor"/></svg>'
    )


def _ends(places: Floats) -> tuple[float, float]:
    """The outer borders of equally spaced pixels with these centres."""
    if len(places) == 1:
        return float(places[0]) - 0.5, float(places[0]) + 0.5
    half = 0.5 * float(np.diff(places).mean())
    return float(places[0]) - half, float(places[-1]) + half


def _bracketed(unit: str) -> str:
    return f" [{unit}]" if unit else ""
