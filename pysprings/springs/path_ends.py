# SPDX-License-Identifier: MIT
"""How the paths of a full model ended, as springs keep it: the end of what they can answer for.

Attributes of a path: `end` is "reached" (the path came to its aim), "limit load" (the soil carries no more, or the
motion under a given load is at the limit of the scene; `end_reason` is the criterion) or "stopped" (`end_reason` is the
cause); `end_H_N`, `end_M_Nm`, `end_u_m` and `end_rotation_rad` are those of its last converged step. Tables do not have
them: the end is "not known", unless the path is marked as partial.

The equations do not include cavitation. A path whose water would cavitate is known up to the step before
(`before_cavitation`): what it carries beyond is no load of springs and no capacity.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from pysprings.core.loads import NO_LOAD, loads_in_words
from pysprings.core.text import with_prefix
from pysprings.core.words import StopReason

REACHED, LIMIT_LOAD, STOPPED, UNKNOWN = "reached", str(StopReason.LIMIT_LOAD), "stopped", "not known"
ENDS = (REACHED, LIMIT_LOAD, STOPPED)
NUMBERS = MappingProxyType({"H": "end_H_N", "M": "end_M_Nm", "u": "end_u_m", "rotation": "end_rotation_rad"})
KEYS = ("end", "end_reason", *NUMBERS.values())
MESH_ERROR = "mesh_error_pct"  # of a path: estimate of the error of its load that the mesh makes [%]
MARGIN = "cavitation_margin"
FEWEST = 2  # states of a path that springs are made from
RESIDUAL = 1e-3  # of V: H and M [N, N m] of a vertical path are what the iteration leaves of zero
_NOT_RECORDED = "reason not recorded"


@dataclass(frozen=True, slots=True)
class PathEnd:
    """End of one path: how (`ENDS`, or "not known"), why it stopped, its last state, V [N] at its start.

    The last state has H [N], M [N m], u [m] and rotation [rad]; NaN where it is not recorded. `mesh_error` is the
    estimate of the error of the path's load that its mesh makes [%]; NaN without one.
    """

    path: str
    how: str
    why: str = ""
    H: float = np.nan
    M: float = np.nan
    V: float = np.nan
    u: float = np.nan
    rotation: float = np.nan
    mesh_error: float = np.nan

    @property
    def failed(self) -> bool:
        """True where the full model found no state beyond the end."""
        return self.how in (LIMIT_LOAD, STOPPED)

    @property
    def reason(self) -> str:
        """Why it stopped, without the place and the residuals of the last attempt."""
        return self.why.partition(" (")[0]

    def attributes(self) -> dict[str, float]:
        """Return the last state by the names that files have."""
        return {key: float(getattr(self, name)) for name, key in NUMBERS.items()}

    def __str__(self) -> str:
        return f"path '{self.path}' {self.words}"

    @property
    def words(self) -> str:
        """How it ended, with the last state and the reason, as the rest of a sentence on the path."""
        words = {LIMIT_LOAD: "met a limit load of the full model", STOPPED: "stopped", REACHED: "reached its aim"}
        size = max(abs(self.H), abs(self.M))
        least = np.fmax(NO_LOAD, RESIDUAL * abs(self.V))
        known = np.isfinite([self.H, self.M]).all() and size >= least  # a vertical path has neither
        loads = f" at {loads_in_words(self.H, self.M)}" if known else ""
        loads += f" (u = {self.u:.4g} m, rotation = {self.rotation:.4g} rad)" if known and np.isfinite(self.u) else ""
        why = f" ({self.reason})" if self.reason and self.failed else ""
        return f"{words.get(self.how, 'ended in a way that is not known')}{loads}{why}"


def end_attrs(reason: StopReason | None, why: str, path: xr.Dataset) -> dict[str, Any]:
    """Return the attributes of a path that stopped for a reason (None: it came to its aim), and why in one line."""
    how = REACHED if reason is None else LIMIT_LOAD if reason.is_limit else STOPPED
    return {"end": how, "end_reason": why} | end_numbers(path)


def before_cavitation(path: xr.Dataset) -> xr.Dataset:
    """Return the steps of a path before its water would cavitate, two at the least, with the end there.

    The margin itself is left out. A path without a margin, or whose water never would, has all of its steps.
    """
    if MARGIN not in path.variables:  # one of a table has no steps, which curves share, either
        return path
    count, known = steps_before_cavitation(path), path.drop_vars(MARGIN)
    if count == path.sizes["step"]:
        return known
    cut = known.isel(step=slice(max(count, FEWEST)))
    w, V = (float(cut.variables[name].values[-1]) for name in ("w", "V"))
    why = f"the water would cavitate beyond, at w = {w:.4g} m, V = {with_prefix(V, 'N')}"
    return cut.assign_attrs({"end": STOPPED, "end_reason": why} | end_numbers(cut))


def steps_before_cavitation(path: xr.Dataset) -> int:
    """Return the number of steps of a path before its water would cavitate; all where no margin is recorded."""
    if MARGIN not in path.variables:
        return path.sizes["step"]
    beyond = np.flatnonzero(path.variables[MARGIN].values < 0.0)
    return int(beyond[0]) if beyond.size else path.sizes["step"]


def earlier_end(shorter: xr.Dataset, whole: xr.Dataset, other: xr.Dataset, name: str) -> dict[str, Any]:
    """Return the attributes of a path made of two, as far as the shorter one; `name` is of the other."""
    source = whole if shorter.sizes["step"] == whole.sizes["step"] else other
    attrs = {key: source.attrs[key] for key in ("end", "end_reason") if key in source.attrs}
    if source is other and attrs.get("end_reason"):
        attrs["end_reason"] = f"as path '{name}': {attrs['end_reason']}"
    return attrs | end_numbers(shorter) if attrs else {}


def end_numbers(path: xr.Dataset) -> dict[str, float]:
    """Return the attributes of the last converged step of a path."""
    known = path.variables
    good = np.flatnonzero(known["converged"].values == 1)
    return {key: float(known[name].values[good[-1]]) for name, key in NUMBERS.items()} if good.size else {}


def end_of(name: str, path: xr.Dataset) -> PathEnd:
    """Return how a path of springs ended."""
    attrs = path.attrs
    how, why = text_of(attrs.get("end")), text_of(attrs.get("end_reason"))
    if how not in ENDS:
        stopped = attrs.get("status", "complete") != "complete"
        how, why = (STOPPED, _NOT_RECORDED) if stopped else (UNKNOWN, "")
    last = {quantity: float(attrs.get(key, np.nan)) for quantity, key in NUMBERS.items()}
    start = float(path.variables["V"].values[0]) if "V" in path else np.nan
    return PathEnd(name, how, why, V=start, mesh_error=float(attrs.get(MESH_ERROR, np.nan)), **last)


def end_faults(attrs: dict[Any, Any]) -> Iterator[tuple[str, str]]:
    """Yield (attribute, message) for what is wrong with the end that a path of a file states."""
    if "end" in attrs and text_of(attrs["end"]) not in ENDS:
        yield "end", f"attribute must be one of {', '.join(ENDS)}"
    for key in NUMBERS.values():
        if not is_number(attrs.get(key, 0.0)):
            yield key, "not a number"
    if attrs.get("end") == LIMIT_LOAD and not {"end_H_N", "end_M_Nm"} <= set(attrs):
        yield "end_H_N", "a limit load needs the loads at the end (end_H_N, end_M_Nm)"


def is_number(value: Any) -> bool:
    """Return whether an attribute is one finite number."""
    return isinstance(value, int | float | np.number) and bool(np.isfinite(value))


def text_of(value: Any) -> str:
    """Return an attribute that should be a text; empty where it is something else."""
    return value if isinstance(value, str) else ""
