# SPDX-License-Identifier: MIT
"""A picture of any quantity of a study over one axis or two."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pysprings.core.errors import refused
from pysprings.results.plots.style import STYLE
from pysprings.scene.fields import suggestion
from pysprings.studies.sweep.dataset import scalars

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def axis_names(data: xr.Dataset) -> list[str]:
    """Return the axes of a study whose values are numbers."""
    return [name for name in str(data.attrs["axes"]).split(", ") if data[name].dtype.kind == "f"]


def draw(data: xr.Dataset, quantity: str, over: Sequence[str] = ()) -> Figure:
    """Return a picture of a quantity (`K_H`, `H_largest:ray_0`) over one axis or two; by default the first ones.

    Cases of a sample are points, whatever their other values are. Of a grid the other axes stand at the middle value,
    which the title names.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    known, axes = scalars(data), axis_names(data)
    if quantity not in known:
        raise refused(
            "--picture", f"no quantity '{quantity}'{suggestion(quantity, list(known))}; there are: {', '.join(known)}"
        )
    chosen = list(over) or axes[:2]
    if not chosen or len(chosen) > 2 or not set(chosen) <= set(axes):
        raise refused("--over", f"expected one axis or two of: {', '.join(axes) or 'none with numbers'}")
    values, others = _on(known[quantity], chosen, data)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.4, 4.6), layout="constrained")
        plot = figure.add_subplot()
        label = f"{quantity} [{values.attrs.get('units', '1')}]"
        x = data[chosen[0]]
        if len(chosen) == 1:
            _curve(plot, x, values, label)
        else:
            _map(figure, plot, (x, data[chosen[1]]), values, label)
        plot.set_xlabel(_label(x))
        plot.set_title("\n".join(filter(None, (str(data.attrs["title"]), others))), fontsize=9)
    return figure


def _on(values: xr.DataArray, chosen: Sequence[str], data: xr.Dataset) -> tuple[xr.DataArray, str]:
    """Return a quantity over the chosen axes, and what the other ones were held at."""
    if "case" in values.dims:
        return values, f"{values.sizes['case']} cases; their other values differ" if len(axis_names(data)) > 2 else ""
    fixed = {str(dim): data.sizes[dim] // 2 for dim in values.dims if dim not in chosen}
    words = [
        f"{dim} = {_text(data[dim].values[k])} {data[dim].attrs.get('units', '')}".rstrip() for dim, k in fixed.items()
    ]
    return values.isel(fixed), ", ".join(words)


def _text(value: Any) -> str:
    return value if isinstance(value, str) else f"{float(value):.4g}"


def _label(axis: xr.DataArray) -> str:
    unit = axis.attrs.get("units", "1")
    return str(axis.name) if unit == "1" else f"{axis.name} [{unit}]"


def _curve(plot: Any, x: xr.DataArray, values: xr.DataArray, label: str) -> None:
    style = "o" if "case" in values.dims else "o-"
    plot.plot(x.values, values.values, style, ms=4)
    plot.set_ylabel(label)


def _map(figure: Figure, plot: Any, axes: tuple[xr.DataArray, xr.DataArray], values: xr.DataArray, label: str) -> None:
    """Draw a quantity as colour: points of a sample, or fields of a grid with the points that it is known at."""
    x, y = axes
    if "case" in values.dims:
        good = np.isfinite(values.values)
        plot.plot(x.values[~good], y.values[~good], "x", color="0.6", ms=5, label="no result")
        drawn = plot.scatter(x.values[good], y.values[good], c=values.values[good], s=40)
        if not good.all():
            plot.legend(fontsize=8)
    else:
        table = values.transpose(str(y.name), str(x.name)).values
        drawn = plot.pcolormesh(x.values, y.values, np.ma.masked_invalid(table), shading="nearest")
    figure.colorbar(drawn, ax=plot, label=label)
    plot.set_ylabel(_label(y))
