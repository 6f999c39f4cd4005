# SPDX-License-Identifier: MIT
"""The interactive parts of a report: numbers of the run, the script that draws them, and plotly, inside the page.

The page holds one copy of plotly.js, compressed; the browser unpacks it. Where plotly is not installed, scripts are
off, or the page is printed, the pictures of matplotlib stand in the same places.
"""

import base64
import gzip
import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core.path_kinds import driven, has_free_head
from pysprings.results.analysis.parts import converged
from pysprings.springs.path import paths_of
from pysprings.springs.sums import by_depth
from pysprings.springs.tip_zone import edge_rings

MOST_STEPS = 25  # of a path that the sliders show
MOST_PATHS = 24
MOST_DEPTHS = 4  # of the contact stresses
LIMITS = (0.25, 0.5)  # deg: usual tolerances of tilt
_DIGITS = 4
_SCALES = {"u": 1e3, "w": 1e3, "rotation": 180.0 / np.pi, "H": 1e-6, "V": 1e-6, "M": 1e-6}


@dataclass(frozen=True)
class Live:
    """Texts of the interactive parts: data and script of the page, plotly.js (gzip, base64), the sources allowed."""

    data: str
    script: str
    library: str
    sources: str


def live_parts(result: xr.DataTree) -> Live | None:
    """Return the interactive parts of the report of a result; None without plotly or without a path to draw."""
    library = _library()
    paths = [_path(name, path.recorded) for name, path in [*paths_of(result).items()][:MOST_PATHS]]
    drawn = [path for path in paths if len(path["u"]) > 1]
    if library is None or not drawn:
        return None
    size = {key: float(result.attrs.get(f"{key}_m", np.nan)) for key in ("outer_diameter", "skirt_length")}
    known = {key: value for key, value in size.items() if np.isfinite(value)}
    data = json.dumps({"size": known, "limits": LIMITS, "paths": drawn}, separators=(",", ":"), allow_nan=False)
    script = files("pysprings.results.report").joinpath("templates/report.js").read_text(encoding="utf-8")
    packed, digest = library
    own = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return Live(data.replace("<", "\\u003c"), script, packed, f"'sha256-{own}' 'sha256-{digest}'")


@lru_cache(maxsize=1)
def _library() -> tuple[str, str] | None:
    """Return plotly.js as text of the page, and its SHA-256 in base64; None where plotly is not installed."""
    found = find_spec("plotly")
    if found is None or not found.submodule_search_locations:
        return None
    file = Path(found.submodule_search_locations[0]) / "package_data" / "plotly.min.js"
    if not file.exists():
        return None
    content = file.read_text(encoding="utf-8").encode()
    digest = base64.b64encode(hashlib.sha256(content).digest()).decode()
    return base64.b64encode(gzip.compress(content, 6, mtime=0)).decode("ascii"), digest


def _path(name: str, path: xr.Dataset) -> dict[str, Any]:
    """Return the converged states of one path for the page, at most `MOST_STEPS` of them."""
    good = np.flatnonzero(converged(path))
    steps = np.unique(np.linspace(0, good.size - 1, min(good.size, MOST_STEPS)).astype(int)) if good.size else good
    chosen = path.isel(step=good[steps])
    free = has_free_head(path.attrs) and "arm_m" in path.attrs and "arm_from_m" not in path.attrs
    data: dict[str, Any] = {
        "name": name,
        "role": str(path.attrs.get("role", "")),
        "vertical": driven(path.attrs) == "w",
    }
    data |= {"arm": float(path.attrs["arm_m"])} if free else {}
    data |= {key: _round(factor * chosen[key].values) for key, factor in _SCALES.items()}
    if chosen.sizes["step"]:
        data |= {"depth": _round(path["depth"].values), "edge": edge_rings(path).tolist()}
        data |= {"y": _round(1e3 * chosen["y"].transpose("step", "depth").values)}
        data |= {key: _round(1e-3 * by_depth(chosen, key).T) for key in ("p", "m", "t")}
        data |= _stress(chosen)
    return data


def _stress(path: xr.Dataset) -> Mapping[str, Any]:
    """Return p'_N [kPa] by side, step, depth and azimuth [deg], at some depths; empty where it was not kept."""
    if "normal_effective_stress" not in path or driven(path.attrs) == "w":
        return {}
    n = path.sizes["depth"]
    rings = np.unique(np.linspace(0, n - 1, min(n, MOST_DEPTHS)).astype(int))
    order = np.argsort(path["azimuth"].values)
    field = path["normal_effective_stress"].isel(depth=rings, azimuth=order)
    field = field.transpose("side", "step", "depth", "azimuth")
    stress = {str(side): _round(1e-3 * field.values[k], 3) for k, side in enumerate(field["side"].values)}
    azimuth = np.degrees(path["azimuth"].values[order])
    return {"stress": stress, "azimuth": _round(azimuth), "rings": _round(path["depth"].values[rings])}


def _round(values: NDArray[np.float64], digits: int = _DIGITS) -> Any:
    """Return numbers as nested lists with this many digits; rounding errors beside the largest become 0."""
    values = np.nan_to_num(np.asarray(values, dtype=float))
    least = 1e-9 * float(np.abs(values).max(initial=0.0))
    return _digits(np.where(np.abs(values) > least, values, 0.0), digits)


def _digits(values: NDArray[np.float64], digits: int) -> Any:
    if values.ndim == 1:
        return [float(f"{value:.{digits}g}") for value in values.tolist()]
    return [_digits(row, digits) for row in values]
