# SPDX-License-Identifier: MIT
"""Springs with memory in all directions: motions and loads in six degrees of freedom along sequences, or step by step.

Motions are (u_x, u_y, rot_x, rot_y, rot_z), loads (H_x, H_y, M_x, M_y, T), in the axes of the field: right-handed with
z up, H_x to M_y about the lid centre. w is an answer, V is constant. Elements of torsion share no friction with lateral
ones: where both loads act the answer is marked.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core import variables
from pysprings.core.arguments import check_arrays
from pysprings.core.arrays import Array, Integers, Marks
from pysprings.core.errors import BeyondSprings, Problem, refused
from pysprings.core.loads import in_plane, same_loads
from pysprings.core.text import with_prefix
from pysprings.core.units import quoted
from pysprings.macro.answer import origin_of, rate_marks
from pysprings.macro.capacity import past_limits
from pysprings.macro.fan import WIDEST
from pysprings.macro.fan_springs import sector_notes
from pysprings.macro.model import elastic_loads, rate_words
from pysprings.macro.solver import Drive
from pysprings.macro.space import SpaceControl
from pysprings.macro.vertical import VerticalTable, build_vertical, covered
from pysprings.macro.vertical_answer import beyond_springs, no_equilibrium, past_elastic
from pysprings.macro.ways import RANGE_SLACK
from pysprings.memory.build import build_memory
from pysprings.memory.calibration import NO_FARTHER, ElementSet, SpaceElements, beyond_way
from pysprings.memory.elements import SPACE, SPACE_STATES, advance, follow, tangents
from pysprings.memory.model import divided_way, followed, joined
from pysprings.memory.offered import Offered, elastic_motions, evened
from pysprings.memory.shares import loads_of
from pysprings.memory.space import SHARE_NOTHING
from pysprings.memory.stepper import StepMarks, check_step, load_mark, rate_mark
from pysprings.springs.path import SPACE_LOADS, SPACE_TURNS, STRAIGHT, SpringPath, in_planes, out_of_planes
from pysprings.springs.path_ends import PathEnd
from pysprings.springs.springs import Springs

BOTH_ACT = 0.02  # share of the load above which torsion and lateral loads act together
MISSING = (
    "no complete path that leaves the plane calibrates them: one plane does not show how the soil reacts to loads from "
    "several sides. "
    "Run the scene with `[springs] memory = true` and `directions = true`"
)
APART = "torsion and lateral loads act together in {} of {} states: " + SHARE_NOTHING
HEAVE = "w out of one plane is that at V of the springs, {}, and of another V beside; a twist leaves it as it is"


@dataclass(frozen=True, eq=False)
class SpaceSprings:
    """Elements in space (`pysprings.memory.space`) that carry a rigid caisson.

    elements : calibrated elements.
    length, reach : skirt length, and size of the largest motion of the rays [m].
    largest : largest step of a motion [m].
    V : vertical load [N] of the paths of the calibration.
    origin : a path with the depths of the reactions.
    vertical : vertical springs; None where there are none: then w under another V is elastic, by K [N/m].
    ends, elastic_loads : as those of `pysprings.macro.model.MacroModel`.
    load_scale : sizes of H [N] and M [N m], for tolerances.
    attrs : attributes of the springs.
    rays : angles in (u, rotation L) [rad], in order, and ranges [m] of the rays (n, 2).
    rate : that of the paths [m/s, of rho]; None where the springs do not depend on one.
    """

    elements: SpaceElements
    length: float
    reach: float
    largest: float
    V: float
    load_scale: tuple[float, float]
    origin: SpringPath
    attrs: Mapping[Any, Any]
    vertical: VerticalTable | None
    K: float
    ends: Mapping[str, PathEnd]
    elastic_loads: tuple[float, float]
    rays: Array
    rate: float | None = None

    @classmethod
    def of(cls, springs: Springs | xr.DataTree) -> "SpaceSprings":
        """Return the elements in space of springs at the load at rest, stored or calibrated.

        Raises UserInputError where no path leaves the plane, or no ray turns back.
        """
        given = Springs.of(springs).at()
        if all(path.kind == "twist" for path in given.turning):
            raise refused("springs", MISSING)
        planar = build_memory(given)
        size = planar.table.load_scale
        found = cls.from_elements(planar.elements, given, planar.V, (float(size[0]), float(size[1])))
        return replace(found, rate=planar.rate)

    @classmethod
    def from_elements(
        cls, elements: ElementSet, springs: Springs, V: float, load_scale: tuple[float, float]
    ) -> "SpaceSprings":
        """Return the springs of a set of elements. Raises UserInputError where it has none in space."""
        if elements.space is None:
            raise refused("springs", MISSING)
        size = springs.length, elements.reach, elements.largest
        ends = ((angle, springs.paths[name]) for name, angle in springs.rays.items())
        rays = sorted((angle, float(np.hypot(path.u[-1], path.turn[-1]))) for angle, path in ends)
        table = build_vertical(springs)
        if table is not None:
            K = table.stiffness
        else:
            K = np.nan if springs.stiffness is None else float(springs.stiffness[1, 1])
        return cls(
            elements.space, *size, V, load_scale, springs.path(), springs.attrs, table, K, springs.ends,
            elastic_loads(springs), np.array(rays),
        )  # fmt: skip

    @property
    def has_torsion(self) -> bool:
        """Whether a twist is among the paths: else the caisson does not turn about its axis."""
        return self.elements.twist > 0.0

    def motions_of(self, turns: Array) -> Array:
        """Return the motions (n, 5) of elements [m] of (u_x, u_y, rot_x, rot_y, rot_z) (n, 5)."""
        return np.ascontiguousarray(in_planes(turns, self.length, self.elements.radius))

    def loads_of(self, pushes: Array) -> Array:
        """Return the loads (n, 5) of elements [N] of (H_x, H_y, M_x, M_y, T) (n, 5)."""
        return np.ascontiguousarray(in_planes(pushes, 1.0 / self.length, 1.0 / self.elements.radius))

    def turns_of(self, motions: Array) -> Array:
        """Return (u_x, u_y, rot_x, rot_y, rot_z) (n, 5) of motions (n, 5) of elements."""
        return out_of_planes(motions, self.length, self.elements.radius)

    def pushes_of(self, loads: Array) -> Array:
        """Return (H_x, H_y, M_x, M_y, T) (n, 5) of loads (n, 5) of elements."""
        return out_of_planes(loads, 1.0 / self.length, 1.0 / self.elements.radius)

    def solve(self, control: SpaceControl, targets: Array) -> tuple[Array, Array, str]:
        """Follow targets (n, 5), SPACE_TURNS ("state") or SPACE_LOADS ("load"), from rest.

        Returns motions and loads (k, 5) of the steps reached, and a message on where it ended when k < n.
        """
        rows = self.checked(targets)
        if control not in ("load", "state"):
            raise refused("control", f"expected 'load' or 'state', not {quoted(str(control))}")
        aims = self.loads_of(rows) if control == "load" else self.motions_of(rows)
        motions, loads, _ = followed(self.elements.rows, self.drive(control), self.largest, aims)
        n = len(motions)
        where = f"macro-model: no equilibrium on the way to row {n + 1} of the sequence; {NO_FARTHER}"
        message = "" if n == len(aims) else where
        return self.turns_of(motions), self.pushes_of(loads), message

    def checked(self, targets: Array) -> Array:
        """Return targets (n, 5) as they are; refuse other shapes, what is not finite, and torsion without elements."""
        check_arrays(targets=targets)
        rows = np.asarray(targets, dtype=float)
        if rows.ndim != 2 or rows.shape[1] != SPACE or not len(rows):
            raise refused("targets", f"must have the shape (n, {SPACE}), not {rows.shape}")
        if not self.has_torsion and rows[:, 4].any():
            raise refused("targets", "the springs have no twist among their paths: they carry no torsion")
        return rows

    def drive(self, control: SpaceControl) -> Drive:
        """Return the equations of a control in motions and loads of elements.

        Without elements of torsion the caisson does not turn about its axis.
        """
        size = max(self.load_scale[0], self.load_scale[1] / self.length)
        held = np.full(SPACE, control == "state")
        held[4] |= not self.has_torsion
        scale = np.where(held, self.reach, size)
        return Drive(np.diag(held.astype(float)), np.diag((~held).astype(float)), scale)

    def tangents(self, turns: Array) -> Array:
        """Return the tangents (n, 5, 5) of SPACE_LOADS to SPACE_TURNS along motions (n, 5), from rest on."""
        motions = self.motions_of(np.asarray(turns, dtype=float))
        loads, out = np.zeros(motions.shape), np.zeros((len(motions), SPACE, SPACE))
        tangents(self.elements.rows, motions, self.largest, loads, out)
        return self.in_turns(out)

    def in_turns(self, found: Array) -> Array:
        """Return tangents (..., 5, 5) of elements as those of SPACE_LOADS to SPACE_TURNS."""
        return self.pushes_of(np.swapaxes(self.pushes_of(found), -1, -2)).swapaxes(-1, -2)

    def reactions(self, turns: Array) -> Array:
        """Return p in the planes of x and y by depth, (2, depth, n) [N/m], along motions (n, 5) from rest on."""
        choice, own = Offered.of_space(self.elements.rows), self.elements
        e = elastic_motions(choice, self.motions_of(turns), self.largest)
        shape = len(turns), 2 * len(choice.rows)
        return np.stack([
            own.p_loads @ loads_of(choice.rows, one).T + own.p_elastic @ one.reshape(shape).T
            for one in (e[:, :, :2], e[:, :, 2:])
        ])  # fmt: skip

    def heave(self, turns: Array) -> Array:
        """Return w (n,) [m] under the V of the springs along motions (n, 5) from rest on; a twist changes nothing."""
        own, choice = self.elements, Offered.of_space(self.elements.rows)
        moved = evened(choice, self.motions_of(turns), self.largest, own.growth) @ own.even[0]
        return float(self.origin["w"][0]) + moved

    def _settled(self, V: Array) -> tuple[Array, NDArray[np.int8], list[str], str]:
        """Return w (n,) [m] of vertical loads (n,) [N] less that at V of the springs, and what does not carry them.

        That is marks (n,) and sentences of V beyond the vertical springs, and a message on V that no w carries.
        """
        if self.vertical is None:
            past, sentences = past_elastic(self, V, ~same_loads(V, self.V))
            return (V - self.V) / self.K, past.astype(np.int8), sentences, ""
        w, _, used, own = self.vertical.history(V)
        past = np.nan_to_num(used, nan=np.inf) > 1.0 + RANGE_SLACK
        change: Array = w - self.vertical.displacement(self.V)
        return change, past.astype(np.int8), beyond_springs(self, V, own), no_equilibrium(self, V[np.isnan(own)])

    def range_used(self, turns: Array) -> Array:
        """Return the size of motions (n, 5) over that of the rays beside, or of the twist where that is more."""
        motions = self.motions_of(turns)
        used: Array = np.linalg.norm(motions[:, :4], axis=1) / self.beside(turns)[1]
        return np.maximum(used, np.abs(motions[:, 4]) / self.elements.twist) if self.elements.twist else used

    def beside(self, turns: Array) -> tuple[Array, Array]:
        """Return the angle [rad] between the rays beside the leading motion in (u, rotation L), and their range [m].

        The leading motion of motions (n, 5) in one plane is theirs; of others it is their largest part. The range is
        that of the shorter ray; on a ray the range is its own, and the angle 0.
        """
        q = self.motions_of(turns)[:, :4]
        u, lean = q[:, ::2], q[:, 1::2]
        leading = 0.5 * np.arctan2(2.0 * (u * lean).sum(axis=1), (u**2).sum(axis=1) - (lean**2).sum(axis=1))
        (first, *_), ends = self.rays[0], np.vstack([self.rays, self.rays[:1] + [np.pi, 0.0]])
        angle = (leading - first) % np.pi + first
        place = np.clip(np.searchsorted(ends[:, 0], angle, side="right"), 1, len(self.rays))
        low, high = ends[place - 1], ends[place]
        apart = np.abs(np.stack([angle - low[:, 0], high[:, 0] - angle]))
        on_ray = (apart.min(axis=0) < STRAIGHT) | ~q.any(axis=1)
        own = np.where(apart[0] < apart[1], low[:, 1], high[:, 1])
        reach = np.where(on_ray, own, np.minimum(low[:, 1], high[:, 1]))
        return np.where(on_ray, 0.0, high[:, 0] - low[:, 0]), reach

    def _between(self, control: SpaceControl, targets: Array, turns: Array) -> tuple[Array, Integers]:
        """Return motions (m, 5) on the way to motions (n, 5) that targets lead to, and which of them are those."""
        motions, straight = self.motions_of(turns), (turns, np.arange(len(turns)))
        divided = divided_way(np.asarray(targets, dtype=float)[: len(turns)], motions, self.largest)
        if control == "state" or divided is None:
            return straight
        return joined(self.solve(control, divided[0])[0], turns, divided[1]) or straight

    def _refusals(self, pushes: Array, V: Array | None) -> list[str]:
        """Return sentences on loads (n, 5), H and M in the plane of H, and V (n,) [N] beyond limit loads."""
        force, moment = pushes[:, :2], pushes[:, 2:4]
        plane = in_plane(force, np.stack([moment[:, 1], -moment[:, 0]], axis=1))
        down = np.full(len(pushes), self.V) if V is None else V[: len(pushes)]
        return past_limits(self, np.stack([plane.H, plane.M], axis=1), down)[1]

    def torsion_apart(self, pushes: Array) -> Marks:
        """Return where both torsion and a lateral load act, for loads (n, 5)."""
        loads = self.loads_of(pushes)
        lateral, twist = np.linalg.norm(loads[:, :4], axis=1), np.abs(loads[:, 4])
        return np.minimum(lateral, twist) > BOTH_ACT * np.maximum(lateral, twist)

    def answer(
        self, control: SpaceControl, targets: Array, V: Array | None = None, time: Array | None = None
    ) -> xr.Dataset:
        """Return the states along a sequence in six degrees of freedom as a dataset by step, marked.

        V (n,) [N] marks states at another vertical load than that of the springs, time (n,) [s] steps at another rate.
        """
        turns, pushes, message = self.solve(control, targets)
        own, way, ends = with_prefix(self.V, "N", 6), *self._between(control, targets, turns)
        n, used = len(turns), self.range_used(turns)
        values: dict[str, Any] = dict(zip((*SPACE_TURNS, *SPACE_LOADS), (*turns.T, *pushes.T), strict=True))
        values |= {"w": self.heave(way)[ends], "converged": np.ones(n, dtype=np.int8), "range_used": used}
        values |= {"extrapolated": np.logical_or.accumulate(used > 1.0 + RANGE_SLACK).astype(np.int8)}
        apart = self.torsion_apart(pushes)
        values["torsion_apart"] = apart.astype(np.int8)
        sector, _ = self.beside(turns)
        aside = sector > WIDEST + RANGE_SLACK
        values["off_path"] = np.logical_or.accumulate(aside).astype(np.int8)
        warnings = [*([APART.format(apart.sum(), n)] if apart.any() else []), *sector_notes(sector, aside)]
        warnings += beyond_way(self.motions_of(turns)[:, :4], self.elements.way)
        text = f"beyond the range of the paths behind the springs: {used.max(initial=0.0):.3g} times (limit 1)"
        beyond = [text] if values["extrapolated"].any() else []
        if V is not None:
            off = np.logical_or.accumulate(~covered(self.vertical, V[:n], np.full(n, self.V)))
            change, far, sentences, lost = self._settled(V[:n])
            beyond, message = beyond + sentences, " ".join(filter(None, (message, lost)))
            values |= {"V": V[:n], "w": values["w"] + change, "off_load": off.astype(np.int8)}
            values["extrapolated"] |= far
            text = f"{off.sum()} of {n} states are under another V than {own}, or come after one"
            warnings += [text] if off.any() else []
        if time is not None:
            timed, off_rates = rate_marks(self.rate, np.diff(self.motions_of(turns), axis=0, prepend=0.0), time[:n])
            values, warnings = values | timed, warnings + off_rates
        values |= zip(("p_x", "p_y"), self.reactions(way)[:, :, ends], strict=True)
        values["depth_bounds"] = self.origin["depth_bounds"]
        attrs = origin_of(self.attrs) | {
            "springs": "memory", "control": control, "question": "sequence",
            "status": "partial" if message else "complete", "message": message, "warnings": warnings,
            "beyond_range": beyond, "refusals": self._refusals(targets[: n + 1] if control == "load" else pushes, V),
            "remarks": [HEAVE.format(own), *rate_words(self.rate, self.vertical)],
        }  # fmt: skip
        coords = {"step": np.arange(n)} | variables.described({"depth": self.origin.depth}, "space_prediction")
        return xr.Dataset(variables.described(values, "space_prediction"), coords, attrs)


class SpaceStepper:
    """A state of springs in space that goes on step by step, for time stepping.

    `advance` finds a trial state from the committed one, `commit` keeps it; without `commit` the next `advance` starts
    from the same committed state.

    state : (elements, 5) committed numbers of the elements.
    motion, load : committed (u_x, u_y, rot_x, rot_y, rot_z) and (H_x, H_y, M_x, M_y, T), in m, rad, N, N m.
    way : committed motions added up [m].
    """

    def __init__(self, model: SpaceSprings) -> None:
        self.model = model
        self.state = np.zeros((len(model.elements.rows), SPACE_STATES))
        self.motion, self.load, self.way = np.zeros(SPACE), np.zeros(SPACE), 0.0
        self._trial = self.state.copy(), self.motion.copy(), self.load.copy()
        self._conditions: tuple[float | None, float | None] = None, None

    @classmethod
    def of(cls, springs: Springs | xr.DataTree) -> Self:
        """Return a stepper at rest on springs in space, at the vertical load at rest. Raises as `SpaceSprings.of`."""
        return cls(SpaceSprings.of(springs))

    def advance(
        self,
        *,
        motion: Array | None = None,
        load: Array | None = None,
        V: float | None = None,
        duration: float | None = None,
    ) -> Array:
        """Go to a motion, or under a load, (5,); return the other one (5,).

        `marks` compares V [N] and the duration [s] of the step with those of the springs; they change nothing else.

        Raises BeyondSprings: the elements do not carry the load.
        Raises UserInputError: neither, or both, are given.
        """
        check_step(motion, load, V, duration)
        model, drive = self.model, self.model.drive("load" if motion is None else "state")
        aim, start = (load, self.load) if motion is None else (motion, self.motion)
        way = np.stack([start, model.checked(np.asarray(aim)[None])[0]])
        way = model.loads_of(way) if motion is None else model.motions_of(way)
        state, at = self.state.copy(), model.motions_of(self.motion[None])[0]
        found, carried = np.zeros(way.shape), np.zeros(way.shape)
        n, _ = follow(model.elements.rows, drive, model.largest, at, state, way, found, carried)
        if n < 2:
            raise BeyondSprings([Problem(key="springs", message="the elements do not carry the load of this step")])
        self._trial = state, model.turns_of(found[1:])[0], model.pushes_of(carried[1:])[0]
        self._conditions = V, duration
        return self._trial[1 if motion is None else 2].copy()

    @property
    def tangent(self) -> Array:
        """Tangent (5, 5) of the loads to the motion at the end of the last trial step, where that is not divided."""
        model, F, K, state = self.model, np.zeros(SPACE), np.zeros((SPACE, SPACE)), self.state.copy()
        start, end = model.motions_of(np.stack([self.motion, self._trial[1]]))
        advance(model.elements.rows, start, end, state, F, K)
        return model.in_turns(K)

    @property
    def marks(self) -> StepMarks:
        """What of the last trial state the springs do not cover."""
        model, (_, turn, push), (V, duration) = self.model, self._trial, self._conditions
        sector, _ = model.beside(turn[None])
        return StepMarks(
            range_used=float(model.range_used(turn[None])[0]),
            off_path=bool(sector[0] > WIDEST + RANGE_SLACK),
            off_load=load_mark(model.vertical, V, model.V),
            off_rate=rate_mark(model.rate, float(np.linalg.norm(self._moved)), duration),
            way_used=(self.way + self._further) / model.elements.way,
            torsion_apart=bool(model.torsion_apart(push[None])[0]),
        )

    @property
    def _moved(self) -> Array:
        return self.model.motions_of((self._trial[1] - self.motion)[None])[0]

    @property
    def _further(self) -> float:
        return float(np.linalg.norm(self._moved[:4]))  # a twist moves no lateral element

    def commit(self) -> None:
        """Keep the last trial state."""
        state, motion, load = self._trial
        self.way += self._further
        self.state, self.motion, self.load = state.copy(), motion.copy(), load.copy()
