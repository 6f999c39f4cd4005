# SPDX-License-Identifier: MIT
"""How the paths of a full model ended, as springs keep it: the end of what they can answer for.

Attributes of a path: `end` is "reached" (the path came to its aim), "limit load" (the soil carries no more) or
"stopped" (`end_reason` is the cause); `end_H_N` and `end_M_Nm` are the loads of its last converged step. Files of
earlier versions and tables do not have them: the end is "not known", unless the path is marked as partial.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from pysprings.core.stop_reasons import StopReason
from pysprings.springs.numbers import is_number, text_of

REACHED, LIMIT_LOAD, STOPPED, UNKNOWN = "reached", str(StopReason.LIMIT_LOAD), "stopped", "not known"
ENDS = (REACHED, LIMIT_LOAD, STOPPED)
KEYS = ("end", "end_reason", "end_H_N", "end_M_Nm")
_MOST_LETTERS = 120  # of a reason in a message
_NOT_RECORDED = "reason not recorded"


@dataclass(frozen=True, slots=True)
class PathEnd:
    """End of one path: how (`ENDS`, or "not known"), why it stopped, H [N] and M [N m] there, V [N] at its start."""

    path: str
    how: str
    why: str = ""
    H: float = np.nan
    M: float = np.nan
    V: float = np.nan

    @property
    def failed(self) -> bool:
        """True where the full model found no state beyond the end."""
        return self.how in (LIMIT_LOAD, STOPPED)

    def __str__(self) -> str:
        words = {LIMIT_LOAD: "met a limit load of the full model", STOPPED: "stopped", REACHED: "reached its aim"}
        loads = f" at H = {self.H:.4g} N with M = {self.M:.4g} N m" if np.isfinite([self.H, self.M]).all() else ""
        why = f" ({self.why[:_MOST_LETTERS]})" if self.why and self.failed else ""
        return f"path '{self.path}' {words.get(self.how, 'ended in a way that is not known')}{loads}{why}"


def end_attrs(reason: StopReason | None, why: str, path: xr.Dataset) -> dict[str, Any]:
    """Return the attributes of a path that stopped for a reason (None: it came to its aim), and why in one line."""
    how = REACHED if reason is None else LIMIT_LOAD if reason is StopReason.LIMIT_LOAD else STOPPED
    return {"end": how, "end_reason": why} | _last_loads(path)


def earlier_end(shorter: xr.Dataset, whole: xr.Dataset, other: xr.Dataset) -> dict[str, Any]:
    """Return the attributes of a path made of two, which goes as far as the shorter one."""
    source = whole if shorter.sizes["step"] == whole.sizes["step"] else other
    attrs = {key: source.attrs[key] for key in ("end", "end_reason") if key in source.attrs}
    return attrs | _last_loads(shorter) if attrs else {}


def _last_loads(path: xr.Dataset) -> dict[str, float]:
    good = np.flatnonzero(path["converged"].values == 1)
    return {f"end_{name}_{unit}": float(path[name].values[good[-1]]) for name, unit in _LOADS} if good.size else {}


_LOADS = (("H", "N"), ("M", "Nm"))


def end_of(name: str, path: xr.Dataset) -> PathEnd:
    """Return how a path of springs ended."""
    attrs = path.attrs
    how, why = text_of(attrs.get("end")), text_of(attrs.get("end_reason"))
    if how not in ENDS:
        stopped = attrs.get("status", "complete") != "complete"
        how, why = (STOPPED, _NOT_RECORDED) if stopped else (UNKNOWN, "")
    H, M = (float(attrs.get(f"end_{load}_{unit}", np.nan)) for load, unit in _LOADS)
    return PathEnd(name, how, why, H, M, float(path["V"].values[0]) if "V" in path else np.nan)


def end_faults(attrs: dict[Any, Any]) -> Iterator[tuple[str, str]]:
    """Yield (attribute, message) for what is wrong with the end that a path of a file states."""
    if "end" in attrs and text_of(attrs["end"]) not in ENDS:
        yield "end", f"attribute must be one of {', '.join(ENDS)}"
    for key in ("end_H_N", "end_M_Nm"):
        if not is_number(attrs.get(key, 0.0)):
            yield key, "not a number"
    if attrs.get("end") == LIMIT_LOAD and not {"end_H_N", "end_M_Nm"} <= set(attrs):
        yield "end_H_N", "a limit load needs the loads at the end (end_H_N, end_M_Nm)"
