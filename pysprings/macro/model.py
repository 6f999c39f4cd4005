# SPDX-License-Identifier: MIT
"""The rigid caisson on its springs: built once from a spring set, then asked for reactions, tangents and paths."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core import variables
from pysprings.macro.answer import answer_dataset
from pysprings.macro.control import Control, ending, equations
from pysprings.macro.curve_table import SpringTable
from pysprings.macro.fan import FanTable
from pysprings.macro.history import turns
from pysprings.macro.limit import Limit, range_limit
from pysprings.macro.sets import Springs, choose_set
from pysprings.macro.solver import FAN, ROWS, follow, reactions, solve_cases, tangents
from pysprings.macro.user_curves import CurveSprings
from pysprings.macro.vertical import VerticalTable, build_vertical
from pysprings.springs.dataset import get_path, path_dataset, path_load, path_names
from pysprings.springs.dead_loads import at_load, load_sets
from pysprings.springs.path_ends import UNKNOWN, PathEnd, end_of

Array = NDArray[np.float64]

NO_VERTICAL = "a table without a vertical path has no vertical springs: w and V are left out"
NO_ENDS = "springs of an earlier version: how their paths ended is not known, loads beyond a limit load are not refused"


@dataclass(frozen=True, slots=True)
class MacroModel:
    """A rigid caisson on the springs of one path, or of a fan of paths; built once, asked often.

    Attributes
    ----------
    table
        The springs as interpolation tables.
    spring_set
        Name of the spring set: see `spring_sets`.
    origin
        Converged steps of the path the springs come from; of the first ray of a fan.
    stiffness_initial
        (3, 3) initial tangent of the full model for (u, w, rotation); None where the springs come from a table:
        then nothing is known of w and V.
    attrs
        Attributes of the spring set (geometry, provenance).
    remarks
        Sentences that go with every answer.
    vertical
        Vertical springs; None where there are none: then w under another V is elastic.
    settled
        What is missing in w [m] of lateral springs that lie between two vertical loads: their settlement is that of
        the vertical springs.
    ends, sources
        How the paths of the springs ended, by name, and the names of those that the lateral springs come from.
    elastic_loads
        Vertical loads [N] that an elastic vertical stiffness may answer: see `macro_ends`.
    """

    table: SpringTable | FanTable
    spring_set: str
    origin: xr.Dataset
    stiffness_initial: Array | None
    attrs: dict[str, Any]
    remarks: tuple[str, ...] = ()
    vertical: VerticalTable | None = None
    settled: float = 0.0
    ends: Mapping[str, PathEnd] = field(default_factory=dict)
    sources: tuple[str, ...] = ()
    elastic_loads: tuple[float, float] = (-np.inf, np.inf)

    @classmethod
    def from_springs(
        cls, springs: Springs, springs_kind: str | None = None, path: str | None = None, V: float | None = None
    ) -> MacroModel:
        """Build the model from springs: their fan where they have one, else all springs of the first calibration path.

        springs_kind is a name of `SPRING_SETS`; path selects the path of a set of one path ("full", "py"). p-y curves
        without companions give "py" with a remark. V [N] selects among springs at several vertical loads
        (`pysprings.springs.dead_loads`; None: the load of the scene).
        """
        ends, elastic = _known(springs)
        if path is None and isinstance(springs, xr.DataTree):
            springs = at_load(springs, V)
            ends |= _known(springs)[0]  # a path between two loads ends with the shorter one
        chosen = choose_set(springs, springs_kind, path)
        remarks: tuple[str, ...] = (chosen.remark,) if chosen.remark else ()
        if isinstance(springs, CurveSprings):
            name, curves = springs.pick(path)
            attrs = {"title": f"table {springs.source}", "skirt_length_m": curves.length}
            remarks += tuple(filter(None, (curves.note, NO_VERTICAL)))
            return cls(curves.table(chosen.companions), chosen.name, springs.origin(name), None, attrs, remarks)
        built = chosen.build(springs, path)
        stiffness = springs.dataset["stiffness_initial"].values
        known = stiffness if stiffness.shape == (3, 3) else None
        if known is None:
            remarks += (NO_VERTICAL,)
        remarks += built.remarks
        attrs = {str(name): value for name, value in springs.attrs.items()}
        vertical, settled = build_vertical(springs), 0.0
        if vertical is not None and "blended_loads_N" in attrs:
            settled = vertical.displacement(path_load(built.origin))[0] - float(built.origin["w"][0])
        if "schema" in attrs and any(ends[name].how == UNKNOWN for name in built.sources):
            remarks += (NO_ENDS,)
        return cls(
            built.table, chosen.name, built.origin, known, attrs, remarks, vertical, settled, ends, built.sources,
            elastic,
        )  # fmt: skip

    @property
    def length(self) -> float:
        """Skirt length [m]."""
        return float(self.attrs["skirt_length_m"])

    @property
    def rest_load(self) -> float:
        """Vertical load [N] of the state at rest: of the vertical springs, else of the lateral ones."""
        return path_load(self.origin) if self.vertical is None else self.vertical.rest[1]

    @property
    def _springs(self) -> tuple[int, Array, Array, Array, Array, Array, NDArray[np.int64]]:
        return FAN if isinstance(self.table, FanTable) else ROWS, *self.table.solver_arrays

    def reactions(self, u: float, rotation: float) -> tuple[Array, Array]:
        """Return the loads (H [N], M [N m]) that hold a state, and their tangent (2, 2) to (u, rotation)."""
        force, tangent = np.zeros(2), np.zeros((2, 2))
        reactions(*self._springs, float(u), float(rotation), force, tangent)
        return force, tangent

    def tangents(self, states: Array, down: Array | None = None) -> xr.DataArray:
        """Return the tangent stiffness at mudline at states (n, 2) = (u, rotation), with dimension step.

        u and rotation come from the springs; w, uncoupled, is `down` (n,) where it is given, else the elastic stiffness
        of the full model; springs from a table do not know it, and the matrix is (2, 2) for (u, rotation). Units: N/m
        for displacements, N m/rad for rotation, N/rad = N m/m between them.
        """
        lateral = np.zeros((len(states), 2, 2))
        tangents(*self._springs, np.ascontiguousarray(states, dtype=float), lateral)
        dofs = list(variables.DOFS) if self.stiffness_initial is not None else ["u", "rotation"]
        matrix = lateral
        if self.stiffness_initial is not None:
            matrix = np.zeros((len(states), 3, 3))
            matrix[:, ::2, ::2], matrix[:, 1, 1] = lateral, self.stiffness_initial[1, 1] if down is None else down
        known_as = variables.GROUPS["prediction"]
        coords = {name: (name, dofs, known_as[name].attributes()) for name in ("dof", "dof_conjugate")}
        attrs = known_as["stiffness"].attributes() | {"springs": self.spring_set}
        return xr.DataArray(matrix, coords, known_as["stiffness"].dims, attrs=attrs)

    def tangent_stiffness(self, u: float = 0.0, rotation: float = 0.0) -> xr.DataArray:
        """Return the tangent stiffness (3, 3) at mudline for (u, w, rotation) at a state: see `tangents`."""
        return self.tangents(np.array([[u, rotation]])).isel(step=0, drop=True)

    def solve(
        self, control: Control, targets: Array, arm: float = 0.0, start: tuple[Array, Array] | None = None
    ) -> tuple[Array, Array, str]:
        """Follow the equilibrium from the origin through targets.

        Parameters
        ----------
        control
            "displacement" (u with the load at height arm), "rotation" (rotation with the load at height arm),
            "load" (H, M) or "state" (u and rotation imposed).
        targets
            (n, 2): (u, -), (rotation, -), (H, M) or (u, rotation); the - columns are not read.
        arm
            Height of the load above mudline [m].
        start
            State (u, rotation) to start from instead of the origin, and its target.

        Returns
        -------
        tuple
            States (k, 2) = (u, rotation), loads (k, 2) = (H, M), and a message that says where it ended
            when k < n.
        """
        state, first = start or (np.zeros(2), np.zeros(2))
        way = np.concatenate([[first], np.asarray(targets, dtype=float)])
        G, C, scale, aims = equations(control, way, arm, self.table.load_scale)
        out = np.zeros((2, *aims.shape))
        with np.errstate(all="ignore"):  # an iterate that runs away is given up, with or without Numba
            n, at0, at1 = follow(*self._springs, G, C, scale, state, aims, out[0], out[1])
        states, loads = out[0, 1:n], out[1, 1:n]
        return states, loads, "" if n == len(aims) else ending(control, (at0, at1), aims[n], states, loads)

    def solve_cases(self, control: Control, targets: Array, arm: float = 0.0) -> tuple[Array, Array, NDArray[np.int8]]:
        """Return states, loads (n, 2) and a mark reached (n,) of independent targets, each from the origin."""
        G, C, scale, aims = equations(control, np.asarray(targets, dtype=float), arm, self.table.load_scale)
        states, loads, reached = np.zeros(aims.shape), np.zeros(aims.shape), np.zeros(len(aims), dtype=np.int8)
        solve_cases(*self._springs, G, C, scale, np.ascontiguousarray(aims), states, loads, reached)
        return states, loads, reached

    def trace(self, control: Control, targets: Array, arm: float = 0.0, V: float | Array | None = None) -> xr.Dataset:
        """Return the answer to `solve` as a dataset by step, with marks for what the springs do not support.

        A path that ends early holds the steps reached; `status` is then "partial" and `message` says where.
        V [N] is one number, or one a target.
        """
        targets = np.asarray(targets, dtype=float)
        states, loads, message = self.solve(control, targets, arm)
        down = V[: len(states)] if isinstance(V, np.ndarray) else V

        def limit(first: int) -> Limit:
            return range_limit(self, control, targets[: first + 1], arm, states[:first])

        drive = {"control": control, "arm_m": float(arm)}
        aim = targets[len(states)] if control == "load" and len(states) < len(targets) else None
        turned = turns(control, targets[: len(states)], self.length, down, self.rest_load)
        return answer_dataset(self, states, loads, down, drive, message, limit, turned, aim)


def _known(springs: Springs) -> tuple[dict[str, PathEnd], tuple[float, float]]:
    """How the paths of springs ended, and the vertical loads [N] for an elastic stiffness (`macro_ends`)."""
    if isinstance(springs, CurveSprings):
        return {name: PathEnd(name, UNKNOWN) for name in springs.sets}, (-np.inf, np.inf)
    ends = {name: end_of(name, path_dataset(springs, name)) for name in path_names(springs)}
    loads = [each.V for each in load_sets(springs)] or [path_load(get_path(springs))]
    return ends, (min(loads) - abs(min(loads)), max(loads) + abs(max(loads)))
