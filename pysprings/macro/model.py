# SPDX-License-Identifier: MIT
"""The rigid caisson on its springs: built once from a spring set, then asked for reactions, tangents and paths."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core import variables
from pysprings.macro.curve_table import SpringTable
from pysprings.macro.fan import FanTable
from pysprings.macro.history import Control, ending, equations
from pysprings.macro.memory.model import MemoryModel
from pysprings.macro.sets import AnySprings, choose_set, typed
from pysprings.macro.solver import FAN, ROWS, SpringArrays, follow, reactions, solve_cases, tangents
from pysprings.macro.spread import Spread, build_spread
from pysprings.macro.spring_sets import Built, SpringSet
from pysprings.macro.user_curves import CurveSprings
from pysprings.macro.vertical import VerticalTable, build_vertical
from pysprings.springs.path import SpringPath
from pysprings.springs.path_ends import UNKNOWN, PathEnd
from pysprings.springs.springs import Springs
from pysprings.springs.sums import balance

Array = NDArray[np.float64]

NO_VERTICAL = "a table without a vertical path has no vertical springs: w and V are left out"
OF_ATLAS = "springs of the {} ({} full models), not of a full model of this caisson; deviations are standard ones"
NO_ENDS = "springs of an earlier version: how their paths ended is not known, loads beyond a limit load are not refused"


@dataclass(frozen=True, eq=False)
class MacroModel:
    """A rigid caisson on the springs of one path, or of a fan of paths; built once, asked often.

    Attributes
    ----------
    table
        The springs as interpolation tables.
    spring_set
        Name of the spring set: see `pysprings.macro.spring_sets`.
    origin
        The path that the springs come from; the first ray of a fan; a path without states for free curves.
    stiffness_initial
        (3, 3) initial tangent of the full model for (u, w, rotation); None for springs of a table without a vertical
        path: their answers have no w and V.
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
        Vertical loads [N] that an elastic vertical stiffness may answer: see `pysprings.macro.ends`.
    behind
        The paths themselves.
    memory
        Elements that remember, which answer sequences from rest in place of the table; None for all other sets.
    spread
        Standard deviation of a fan of an atlas; None for all other springs.
    """

    table: SpringTable | FanTable
    spring_set: str
    origin: SpringPath
    stiffness_initial: Array | None
    attrs: dict[str, Any]
    remarks: tuple[str, ...] = ()
    vertical: VerticalTable | None = None
    settled: float = 0.0
    ends: Mapping[str, PathEnd] = field(default_factory=dict)
    sources: tuple[str, ...] = ()
    elastic_loads: tuple[float, float] = (-np.inf, np.inf)
    behind: tuple[SpringPath, ...] = ()
    memory: MemoryModel | None = None
    spread: Spread | None = None

    @classmethod
    def from_springs(
        cls, springs: AnySprings, springs_kind: str | None = None, path: str | None = None, V: float | None = None
    ) -> MacroModel:
        """Build the model from springs: their fan where they have one, else all springs of the first calibration path.

        springs_kind is a name of `SPRING_SETS`; path selects the path of a set of one path ("full", "py"). p-y curves
        without companions give "py" with a remark. V [N] selects among springs at several vertical loads
        (`pysprings.springs.between`; None: the load of the scene).
        """
        given = typed(springs)
        if isinstance(given, CurveSprings):
            return cls._from_curves(given, springs_kind, path)
        chosen = given if path is not None else given.at(V=V)
        spring_set = choose_set(chosen, springs_kind, path)
        built = spring_set.build(chosen, path)
        vertical, settled = build_vertical(chosen), 0.0
        if vertical is not None and chosen.blended_loads is not None:
            w, load = built.memory.rest if built.memory else (float(built.origin.w[0]), built.origin.load)
            settled = vertical.displacement(load)[0] - w
        ends = dict(given.ends) | dict(chosen.ends)  # a path between two loads ends with the shorter one
        attrs = {str(name): value for name, value in chosen.attrs.items()}
        remarks = tuple(_remarks(chosen, spring_set, built, ends))
        spread = build_spread(chosen, built.table) if isinstance(built.table, FanTable) else None
        return cls(
            built.table, spring_set.name, built.origin, chosen.stiffness, attrs, remarks, vertical, settled, ends,
            built.sources, _elastic_loads(given), tuple(chosen.paths[name] for name in built.sources),
            built.memory, spread,
        )  # fmt: skip

    @classmethod
    def _from_curves(cls, springs: CurveSprings, springs_kind: str | None, path: str | None) -> MacroModel:
        chosen = choose_set(springs, springs_kind, path)
        name, curves = springs.pick(path)
        attrs = {"title": f"table {springs.source}", "skirt_length_m": curves.length}
        remarks = tuple(filter(None, (chosen.remark, curves.note, NO_VERTICAL)))
        ends = {each: PathEnd(each, UNKNOWN) for each in springs.sets}
        table = curves.table(chosen.companions)
        return cls(table, chosen.name, springs.origin(name), None, attrs, remarks, ends=ends)

    @property
    def length(self) -> float:
        """Skirt length [m]."""
        return self.origin.length

    @property
    def rest_load(self) -> float:
        """Vertical load [N] of the state at rest: of the vertical springs, else of the lateral ones."""
        return self.origin.load if self.vertical is None else self.vertical.rest[1]

    @cached_property
    def balance(self) -> float:
        """Largest share of the load that is missing in the sums of the reactions, of the paths of the springs.

        NaN for springs that are not those of recorded paths.
        """
        lost = [
            max(balance(path.dataset).values())
            for path in self.behind
            if all(key in path for key in ("H", "V", "M", "H_lid"))
        ]
        return max(lost, default=float("nan"))

    @cached_property
    def arrays(self) -> SpringArrays:
        """The springs as the solver reads them."""
        return SpringArrays(FAN if isinstance(self.table, FanTable) else ROWS, *self.table.solver_arrays)

    def reactions(self, u: float, rotation: float) -> tuple[Array, Array]:
        """Return the loads (H [N], M [N m]) that hold a state, and their tangent (2, 2) to (u, rotation)."""
        force, tangent = np.zeros(2), np.zeros((2, 2))
        reactions(self.arrays, float(u), float(rotation), force, tangent)
        return force, tangent

    def tangents(self, states: Array, down: Array | None = None, V: float | Array | None = None) -> xr.DataArray:
        """Return the tangent stiffness at mudline at states (n, 2) = (u, rotation), with dimension step.

        Springs with memory go through the states one after the other, from rest, under V [N], one number or one each.

        u and rotation come from the springs; w, uncoupled, is `down` (n,) where it is given, else the elastic stiffness
        of the full model; springs from a table have none, and the matrix is (2, 2) for (u, rotation). Units: N/m
        for displacements, N m/rad for rotation, N/rad = N m/m between them.
        """
        if self.memory is not None:
            lateral = self.memory.tangents(states, V)
        else:
            lateral = np.zeros((len(states), 2, 2))
            tangents(self.arrays, np.ascontiguousarray(states, dtype=float), lateral)
        dofs = list(variables.DOFS) if self.stiffness_initial is not None else ["u", "rotation"]
        matrix = lateral
        if self.stiffness_initial is not None:
            matrix = np.zeros((len(states), 3, 3))
            matrix[:, ::2, ::2], matrix[:, 1, 1] = lateral, self.stiffness_initial[1, 1] if down is None else down
        described = variables.GROUPS["prediction"]
        coords = {name: (name, dofs, described[name].attributes()) for name in ("dof", "dof_conjugate")}
        attrs = described["stiffness"].attributes() | {"springs": self.spring_set}
        return xr.DataArray(matrix, coords, described["stiffness"].dims, attrs=attrs)

    def tangent_stiffness(self, u: float = 0.0, rotation: float = 0.0) -> xr.DataArray:
        """Return the tangent stiffness (3, 3) at mudline for (u, w, rotation) at a state: see `tangents`."""
        return self.tangents(np.array([[u, rotation]])).isel(step=0, drop=True)

    def solve(
        self,
        control: Control,
        targets: Array,
        arm: float = 0.0,
        start: tuple[Array, Array] | None = None,
        V: float | Array | None = None,
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
            State (u, rotation) to start from instead of the origin, and its target (springs with memory: on the fan).
        V
            Vertical load [N], one a target: springs with memory follow it, where they have rays on which it changes.

        Returns
        -------
        tuple
            States (k, 2) = (u, rotation), loads (k, 2) = (H, M), and a message with the place where it ended
            when k < n.
        """
        if self.memory is not None and start is None:
            return self.memory.solve(control, targets, arm, V)
        state, first = start or (np.zeros(2), np.zeros(2))
        way = np.concatenate([[first], np.asarray(targets, dtype=float)])
        drive, aims = equations(control, way, arm, self.table.load_scale)
        out = np.zeros((2, *aims.shape))
        with np.errstate(all="ignore"):  # an iterate that runs away is given up, with or without Numba
            n, at0, at1 = follow(self.arrays, drive, state, aims, out[0], out[1])
        states, loads = out[0, 1:n], out[1, 1:n]
        return states, loads, "" if n == len(aims) else ending(control, (at0, at1), aims[n], states, loads)

    def solve_cases(self, control: Control, targets: Array, arm: float = 0.0) -> tuple[Array, Array, NDArray[np.int8]]:
        """Return states, loads (n, 2) and a mark reached (n,) of independent targets, each from the origin."""
        drive, aims = equations(control, np.asarray(targets, dtype=float), arm, self.table.load_scale)
        states, loads, reached = np.zeros(aims.shape), np.zeros(aims.shape), np.zeros(len(aims), dtype=np.int8)
        solve_cases(self.arrays, drive, np.ascontiguousarray(aims), states, loads, reached)
        return states, loads, reached


def _remarks(springs: Springs, chosen: SpringSet, built: Built, ends: Mapping[str, PathEnd]) -> Iterator[str]:
    """Yield the sentences that go with every answer."""
    if chosen.remark:
        yield chosen.remark
    if springs.stiffness is None:
        yield NO_VERTICAL
    yield from built.remarks
    if springs.of_atlas:
        yield OF_ATLAS.format(springs.attrs["source"], springs.attrs.get("atlas_cases", "?"))
        if mesh := str(springs.attrs.get("atlas_mesh", "")):
            yield mesh
    if springs.of_full_model and any(ends[name].how == UNKNOWN for name in built.sources):
        yield NO_ENDS


def _elastic_loads(springs: Springs) -> tuple[float, float]:
    """Return the vertical loads [N] that an elastic vertical stiffness may answer (`pysprings.macro.ends`)."""
    loads = [each.V for each in springs.load_sets] or [springs.path().load]
    return min(loads) - abs(min(loads)), max(loads) + abs(max(loads))
