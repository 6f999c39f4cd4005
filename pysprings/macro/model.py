# SPDX-License-Identifier: MIT
"""The rigid caisson on its springs: which spring sets there are, and the model, built once and asked often."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
import xarray as xr

from pysprings.core import variables
from pysprings.core.arrays import Array
from pysprings.core.errors import refused
from pysprings.core.loads import close_loads, same_load
from pysprings.core.text import number
from pysprings.macro.curve_table import FAMILIES, CurveSprings, SpringTable
from pysprings.macro.fan import FanTable
from pysprings.macro.response import Level, Response, RowSprings
from pysprings.macro.spring_sets import SPRING_SETS, SpringSet
from pysprings.macro.vertical import VerticalTable, build_vertical
from pysprings.macro.ways import Control
from pysprings.springs.path import TOGETHER, SpringPath, is_rate
from pysprings.springs.path_ends import UNKNOWN, PathEnd
from pysprings.springs.springs import Springs
from pysprings.springs.sums import balance

Typed = Springs | CurveSprings
AnySprings = Typed | xr.DataTree

NO_VERTICAL = "a table without a vertical path has no vertical springs: w and V are left out"
AT_RATE = "water flows in the ground: the springs are those of {:.3g} mm/s (of rho); what takes longer drains more"
APART = (
    "curves of a table act apart from each other, as in a beam program: how far that is from a full model is not known "
    "here (a table of `springs --for beam` states its error in its first lines)"
)
NO_ENDS = "springs of an earlier version: how their paths ended is not known, loads beyond a limit load are not refused"


@dataclass(frozen=True, eq=False)
class MacroModel:
    """A rigid caisson on the springs of one path, or of a fan of paths; built once, asked often.

    response : The lateral springs, and how they answer.
    spring_set : Name of the spring set: see `pysprings.macro.spring_sets`.
    stiffness_initial : (3, 3) initial tangent of the full model for (u, w, rotation); None for springs of a table
        without a vertical path: their answers have no w and V.
    attrs : Attributes of the spring set (geometry, provenance).
    remarks : Sentences that go with every answer.
    vertical : Vertical springs; None where there are none: then w under another V is elastic.
    settled : What is missing in w [m] of lateral springs under another vertical load than the vertical ones start
        at: their settlement is that of the vertical springs, whatever it was where the load was there from the start.
    ends : How the paths of the springs ended, by name.
    elastic_loads : Vertical loads [N] that an elastic vertical stiffness may answer: see `pysprings.macro.capacity`.
    behind : The paths that the lateral springs come from.
    rate : That of the lateral springs [m/s, of rho]; None where they do not depend on one.
    whole : The springs at all vertical loads that the lateral ones are of; None of tables.
    """

    response: Response
    spring_set: str
    stiffness_initial: Array | None
    attrs: dict[str, Any]
    remarks: tuple[str, ...] = ()
    vertical: VerticalTable | None = None
    settled: float = 0.0
    ends: Mapping[str, PathEnd] = field(default_factory=dict)
    elastic_loads: tuple[float, float] = (-np.inf, np.inf)
    behind: tuple[SpringPath, ...] = ()
    rate: float | None = None
    whole: Springs | None = None

    @classmethod
    def from_springs(
        cls, springs: AnySprings, springs_kind: str | None = None, path: str | None = None, V: float | None = None
    ) -> Self:
        """Build the model from springs: their fan where they have one, else all springs of the first calibration path.

        springs_kind is a name of `SPRING_SETS`; path selects the path of a set of one path ("full", "py"). p-y curves
        without companions give "py" with a remark. V [N] selects among springs at several vertical loads
        (`pysprings.springs.path_sets`; None: the load of the scene).
        """
        given = typed(springs)
        if isinstance(given, CurveSprings):
            return cls._from_curves(given, springs_kind, path)
        chosen = given if path is not None else given.at(V=V)
        spring_set = choose_set(chosen, springs_kind, path)
        response = spring_set.build(chosen, path)
        vertical = build_vertical(chosen.answering(response.origin))  # of one path at its rate
        settled = 0.0 if vertical is None else vertical.lacking(*response.rest)
        ends = dict(given.ends) | dict(chosen.ends)  # a path between two loads ends with the shorter one
        attrs = {str(name): value for name, value in chosen.attrs.items()}
        rate = _rate_of(chosen, response)
        remarks = tuple(_remarks(chosen, spring_set, response, ends, rate_words(rate, vertical)))
        return cls(
            response, spring_set.name, chosen.stiffness, attrs, remarks, vertical, settled, ends,
            elastic_loads(given), tuple(chosen.paths[name] for name in response.sources), rate, given,
        )  # fmt: skip

    @classmethod
    def _from_curves(cls, springs: CurveSprings, springs_kind: str | None, path: str | None) -> Self:
        chosen = choose_set(springs, springs_kind, path)
        name, curves = springs.pick(path)
        attrs = {"title": f"table {springs.source}", "skirt_length_m": curves.length}
        remarks = tuple(filter(None, (chosen.remark or APART, curves.note, NO_VERTICAL)))
        ends = {each: PathEnd(each, UNKNOWN) for each in springs.sets}
        rows = RowSprings(curves.table(chosen.companions), springs.origin(name))
        return cls(rows, chosen.name, None, attrs, remarks, ends=ends)

    def on_rows(self, table: SpringTable) -> Self:
        """Return the caisson on other rows, in place of its lateral springs."""
        return replace(self, response=RowSprings(table, self.origin, self.response.sources))

    def under(self, V: float) -> "MacroModel":
        """Return the fan of the same springs at a vertical load [N]; at its own, and without others, the model."""
        if self.whole is None or same_load(V, self.origin.load):
            return self
        return MacroModel.from_springs(self.whole, "fan", V=V)

    @property
    def table(self) -> SpringTable | FanTable:
        """The backbones of the lateral springs as interpolation tables."""
        return self.response.table

    @property
    def origin(self) -> SpringPath:
        """Path that gives depths and the state at rest; without states for free curves."""
        return self.response.origin

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

    def reactions(self, u: float, rotation: float) -> tuple[Array, Array]:
        """Return the loads (H [N], M [N m]) that hold a state, and their tangent (2, 2) to (u, rotation)."""
        return self.response.loads_at(u, rotation)

    def tangents(self, states: Array, down: Array | None = None, V: Level = None) -> xr.DataArray:
        """Return the tangent stiffness at mudline at states (n, 2) = (u, rotation), with dimension step.

        Springs with memory go through the states one after the other, from rest, under V [N], one number or one each.

        u and rotation come from the springs; w, uncoupled, is `down` (n,) where it is given, else the elastic stiffness
        of the full model; springs from a table have none, and the matrix is (2, 2) for (u, rotation). Units: N/m
        for displacements, N m/rad for rotation, N/rad = N m/m between them.
        """
        lateral = self.response.tangents(states, V)
        dofs = list(variables.DOFS) if self.stiffness_initial is not None else ["u", "rotation"]
        matrix = lateral
        if self.stiffness_initial is not None:
            matrix = np.zeros((len(states), 3, 3))
            matrix[:, ::2, ::2], matrix[:, 1, 1] = lateral, self.stiffness_initial[1, 1] if down is None else down
        coords = variables.described({"dof": dofs, "dof_conjugate": dofs}, "prediction")
        known = variables.GROUPS["prediction"]["stiffness"]
        return xr.DataArray(matrix, coords, known.dims, attrs=known.attributes() | {"springs": self.spring_set})

    def tangent_stiffness(self, u: float = 0.0, rotation: float = 0.0) -> xr.DataArray:
        """Return the tangent stiffness (3, 3) at mudline for (u, w, rotation) at a state: see `tangents`."""
        return self.tangents(np.array([[u, rotation]])).isel(step=0, drop=True)

    def solve(self, control: Control, targets: Array, arm: float = 0.0, V: Level = None) -> tuple[Array, Array, str]:
        """Follow the equilibrium from the origin through targets.

        Returns states (k, 2) = (u, rotation), loads (k, 2) = (H, M), and a message on where it ended when k < n.

        control : "displacement" (u with the load at height arm), "rotation" (rotation with the load at height arm),
            "load" (H, M) or "state" (u and rotation imposed).
        targets : (n, 2): (u, -), (rotation, -), (H, M) or (u, rotation); the - columns are not read.
        arm : Height of the load above mudline [m].
        V : Vertical load [N], one a target: springs with memory follow it, where they have rays on which it changes.
        """
        return self.response.solve(control, targets, arm, V)


def _remarks(
    springs: Springs, chosen: SpringSet, response: Response, ends: Mapping[str, PathEnd], of_rate: list[str]
) -> Iterator[str]:
    """Yield the sentences that go with every answer."""
    if chosen.remark:
        yield chosen.remark
    if springs.stiffness is None:
        yield NO_VERTICAL
    yield from response.remarks
    yield from of_rate
    rates = [float(part.attrs["rate_m_per_s"]) for part, _ in springs.parts]
    own = float(springs.attrs.get("rate_m_per_s", np.nan))
    if rates and all(max(each / own, own / each) > TOGETHER for each in rates):
        span = " and ".join(number(1e3 * each) for each in rates)
        yield f"the rate is between those of the springs, {span} mm/s, more than half a decade from both: interpolated"
    if (loads := springs.blended_loads) and not close_loads(np.array(loads), response.origin.load).any():
        span = " and ".join(number(1e-6 * V) for V in loads)
        yield f"V is between the springs at {span} MN, more than 10 % from both: interpolated"
    yield from springs.atlas_words
    if springs.of_full_model and any(ends[name].how == UNKNOWN for name in response.sources):
        yield NO_ENDS


def rate_words(rate: float | None, vertical: VerticalTable | None) -> list[str]:
    """Return the sentences on the rates [m/s] of lateral springs (None: they depend on none) and of vertical ones."""
    if rate is None:
        return []
    paces = {each.rate for each in (vertical.branches if vertical else ()) if each.rate}
    others = dict.fromkeys(number(1e3 * pace) for pace in sorted(paces) if not is_rate(pace, rate))
    apart = f"vertical springs, what they add to w, and the largest V are those of {', '.join(others)} mm/s (of w)"
    return [AT_RATE.format(1e3 * rate), *[apart] * bool(others)]


def _rate_of(springs: Springs, response: Response) -> float | None:
    """Return the rate [m/s, of rho] of springs of a coupled run: that asked for, or the mean of their paths."""
    if not springs.rate_sets:
        return None
    rates = [rate for name in response.sources if (rate := springs.paths[name].rate)]
    mean = float(np.exp(np.mean(np.log(rates)))) if rates else None
    return float(springs.attrs["rate_m_per_s"]) if "rate_m_per_s" in springs.attrs else mean


def elastic_loads(springs: Springs) -> tuple[float, float]:
    """Return the vertical loads [N] that an elastic vertical stiffness may answer (`pysprings.macro.capacity`)."""
    loads = [each.V for each in springs.load_sets] or [springs.path().load]
    return min(loads) - abs(min(loads)), max(loads) + abs(max(loads))


def typed(springs: AnySprings) -> Typed:
    """Return a tree as `Springs`; all others as they are."""
    return springs if isinstance(springs, CurveSprings) else Springs.of(springs)


def spring_sets(springs: AnySprings) -> list[str]:
    """Return the names of the spring sets that springs can give.

    "full" needs the companions of p, "pisa" a pure translation and a pure rotation, a fan two rays at least.
    """
    given = typed(springs)
    lost = missing_companions(given)
    return [each.name for each in SPRING_SETS if not (lost and each.companions) and _is_ready(given, each)]


def missing_companions(springs: Typed, path: str | None = None) -> list[str]:
    """Return the families (mtheta, base, lid) that the springs do not have; a spring file has them all."""
    if isinstance(springs, CurveSprings):
        return springs.pick(path)[1].missing()
    name = path if path in springs.paths else next(iter(springs.paths), None)
    return [] if name is None or "m" in springs.paths[name] else list(FAMILIES)


def choose_set(springs: Typed, name: str | None, path: str | None) -> SpringSet:
    """Return the spring set of a name (None: a fan, else the full set, else p-y alone).

    Raises UserInputError: the name is unknown, or the springs cannot give the set.
    """
    lost = missing_companions(springs, path)
    if name is None:
        if len(lost) == len(FAMILIES):
            return SPRING_SETS["py"]
        rays = not isinstance(springs, CurveSprings) and springs.has_fan
        name = "fan" if path is None and not lost and rays else "full"
    chosen = SPRING_SETS.find(name, "springs_kind")
    if chosen.companions and lost:
        message = (
            f"the set '{name}' needs the companions of p: {', '.join(lost)} missing "
            "(give zeros if there are none, or ask for the springs 'py')"
        )
        raise refused("springs", message)
    if isinstance(springs, CurveSprings):
        if not chosen.curves:
            raise refused("springs", f"the set '{name}' needs recorded paths: rows with step, y_m and rotation_rad")
    elif chosen.several:
        _check_several(springs, chosen, path)
    return chosen


def _check_several(springs: Springs, chosen: SpringSet, path: str | None) -> None:
    """Refuse one path, or paths of several rates, for a set that several paths make together."""
    if path is not None:
        raise refused("path", f"{chosen.several}: ask for the springs 'full' or 'py'")
    if len(springs.rate_sets) > 1:
        have = ", ".join(f"{1e3 * each.rate:.4g}" for each in springs.rate_sets)
        raise refused(
            "rate", f"the calibration paths have several rates ({have} mm/s, of rho): give one in their range"
        )


def _is_ready(springs: Typed, each: SpringSet) -> bool:
    if isinstance(springs, CurveSprings):
        return each.curves
    return each.ready(springs) and not (each.several and len(springs.rate_sets) > 1)
