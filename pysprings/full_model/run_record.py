# SPDX-License-Identifier: MIT
"""The record of a run: status, cost and convergence, typed; `run.json` and the attribute `run_json` hold it as JSON.

A field that is None is null in JSON, or is left out where it is marked as optional.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Self

from pysprings.core.words import SOLVED, StopReason
from pysprings.core.written import WRITING, is_unfinished

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.scene.model import Scene

ATTRIBUTE = "run_json"  # of the root of a full-model result
FILE = "run.json"  # in the folder of a run


class Status(StrEnum):
    """How a run, or one of its paths, ended."""

    COMPLETE = "complete"
    LIMIT_LOAD = "limit load"  # of a path under a given load: the soil carries no more, or the motion is at its limit
    PARTIAL = "partial"
    INTERRUPTED = "interrupted"
    WRITING = WRITING  # until every file of the run is written


@dataclass(frozen=True, slots=True)
class Ending:
    """How a path ended; unless it has, it is interrupted.

    reason, why : why it stopped, and the same in one line that begins with the reason; none where it came to its aim.
    failure : sentence for the record; empty where the path came to its aim or to its limit load, or was interrupted.
    """

    status: Status = Status.INTERRUPTED
    reason: StopReason | None = StopReason.INTERRUPTED
    why: str = "interrupted"
    failure: str = ""


COMPLETE = Ending(Status.COMPLETE, None, "")


OPTIONAL = MappingProxyType({"optional": True})  # metadata of a field that JSON leaves out where it is None


class _Part:
    """A dataclass that JSON objects are made of; ``_typed`` makes the fields that are more than numbers and texts."""

    _typed: ClassVar[Mapping[str, Callable[[Any], Any]]] = {}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
        """Return the part of plain data; keys of other versions are left out, missing ones have their default.

        Raises ValueError, TypeError, AttributeError: the data are not those of such a part.
        """
        if not isinstance(data, Mapping):
            raise TypeError(f"{cls.__name__} is made of an object, not of {type(data).__name__}")
        names = [each.name for each in dataclasses.fields(cls)]  # type: ignore[arg-type]
        values = {name: data[name] for name in names if name in data}
        typed = {name: read(values[name]) for name, read in cls._typed.items() if values.get(name) is not None}
        return cls(**values | typed)

    def as_dict(self) -> dict[str, Any]:
        """Return plain data, in the order of the fields."""
        fields = dataclasses.fields(self)  # type: ignore[arg-type]  # of the dataclasses below
        values = {each.name: (getattr(self, each.name), "optional" in each.metadata) for each in fields}
        return {name: _plain(value) for name, (value, left_out) in values.items() if not (left_out and value is None)}


def _plain(value: Any) -> Any:
    if isinstance(value, _Part):
        return value.as_dict()
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    return [_plain(each) for each in value] if isinstance(value, list | tuple) else value


@dataclass(frozen=True, slots=True)
class MeshFigures(_Part):
    """Mesh of a run: preset, discretisation, series of a Fourier model, sizes, quality."""

    preset: str = ""
    discretisation: str = ""
    harmonics: int | None = field(default=None, metadata=OPTIONAL)
    azimuths: int | None = field(default=None, metadata=OPTIONAL)
    contact_azimuths: int | None = field(default=None, metadata=OPTIONAL)
    nodes: int = 0
    elements: int = 0
    unknowns: int = 0
    steel_elements: int = 0
    interface_stations: int = 0
    min_scaled_jacobian: float = 0.0
    max_aspect: float = 0.0


@dataclass(slots=True)
class SolverFigures(_Part):
    """Linear solver and Newton's method: settings, and what they needed in all.

    unit_s is the time [s] of one factorisation and solve of the last tangent, measured on demand, and
    peak_before_unit_bytes the peak of the memory before that.
    """

    linear: str = ""
    tolerance: float | None = None
    max_iterations: int = 0
    factorisations: int = 0
    solves: int = 0
    worst_linear_residual: float = 0.0
    condition_estimate: float | None = None
    peak_before_unit_bytes: int | None = field(default=None, metadata=OPTIONAL)
    unit_s: float | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True, slots=True)
class CutBack(_Part):
    """An attempt that was given up: stage, fraction of it that was aimed at, reason, place, last residuals."""

    stage: str
    load_fraction: float
    reason: str
    place: str
    iterations: int
    last_residuals: list[float] = field(default_factory=list)


def significant(
    first: Sequence[float], second: Sequence[float], length: float = 1.0
) -> tuple[list[float], list[float]]:
    """Return both with 0 for values that are none beside the largest; the second count times a length."""
    least = SOLVED * max(map(abs, [*first, *(length * each for each in second)]))
    return (
        [each if abs(each) > least else 0.0 for each in first],
        [each if length * abs(each) > least else 0.0 for each in second],
    )


_VERTICAL = 1.0e-6  # H [N] and M [N m] of a vertical load, beside V, are rounding


@dataclass(frozen=True, slots=True)
class LimitLoad(_Part):
    """Limit load of a path: loads of the whole caisson and motion in its last converged state, and the criterion.

    Off a plane H, M, u and rotation are sizes of the horizontal vectors, beside T and the twist.
    """

    H_N: float
    V_N: float
    M_Nm: float
    u_m: float
    w_m: float
    rotation_rad: float
    criterion: str
    T_Nm: float | None = field(default=None, metadata=OPTIONAL)
    twist_rad: float | None = field(default=None, metadata=OPTIONAL)

    @classmethod
    def at(cls, end: Mapping[str, float], criterion: str) -> Self:
        """Return the limit load of a path with this end (`PathFigures.end`)."""
        names = {"H_N": "H", "V_N": "V", "M_Nm": "M", "u_m": "u", "w_m": "w", "rotation_rad": "rotation"}
        if "u_x" in end:  # sizes of the horizontal vectors
            pairs = {"H": ("H_x", "H_y"), "M": ("M_x", "M_y"), "u": ("u_x", "u_y"), "rotation": ("rot_x", "rot_y")}
            end = {**end, **{name: math.hypot(*(end[key] for key in pair)) for name, pair in pairs.items()}}
            names |= {"T_Nm": "T", "twist_rad": "rot_z"}
        return cls(**{name: end[key] for name, key in names.items()}, criterion=criterion)

    @property
    def is_vertical(self) -> bool:
        """Whether V alone is at its limit."""
        return max(abs(self.H_N), abs(self.M_Nm), abs(self.T_Nm or 0.0)) < _VERTICAL * abs(self.V_N)

    def __str__(self) -> str:
        if self.is_vertical:
            return f"V = {1e-3 * self.V_N:.5g} kN at w = {1e3 * self.w_m:.4g} mm ({self.criterion})"
        (H, V), (M, T) = significant((self.H_N, self.V_N), (self.M_Nm, self.T_Nm or 0.0))
        (u,), (turn, twist) = significant((self.u_m,), (self.rotation_rad, self.twist_rad or 0.0))
        loads, motions = f"H = {1e-3 * H:.5g} kN, M = {1e-3 * M:.5g} kN m, V = {1e-3 * V:.5g} kN", ""
        if self.T_Nm is not None:
            loads, motions = f"{loads}, T = {1e-3 * T:.5g} kN m", f", twist = {math.degrees(twist):.4g} deg"
        motions = f"u = {1e3 * u:.4g} mm, rotation = {math.degrees(turn) + 0.0:.4g} deg{motions}"
        return f"{loads} at {motions} ({self.criterion})"


@dataclass(frozen=True, slots=True)
class PathFigures(_Part):
    """Figures of a path: how it ended, increments, iterations, cut-backs, order of convergence, balances.

    reason : why the path stopped; None where it came to its aim.
    limit_load : where it stopped at its limit load.
    increments_of_dead_load : those of them before the path, where its caisson carries more or less than the balance.
    steps_limited_by : counts by what limited the size of a step (`fe_engine.solve.step_size.LIMITS`).
    end : u, w [m], rotation [rad], H, V [N], M [N m] at the last step; off a plane those of `MOTIONS` and `LOADS`.
    contact_rings : see `pysprings.full_model.record`.
    water : volumes [m3] and range of the pressures [Pa]; None when drained.
    energy : terms of the balance [J].
    """

    status: Status = Status.INTERRUPTED
    reason: StopReason | None = field(default=None, metadata=OPTIONAL)
    limit_load: LimitLoad | None = field(default=None, metadata=OPTIONAL)
    increments: int = 0
    increments_of_dead_load: int | None = field(default=None, metadata=OPTIONAL)
    iterations: int = 0
    median_iterations: float = 0.0
    max_iterations: int = 0
    cut_backs: int = 0
    iterations_in_cut_backs: int = 0
    cut_backs_at: list[CutBack] = field(default_factory=list)
    steps_limited_by: dict[str, int] = field(default_factory=dict)
    worst_residual: float = 0.0
    order_of_last_iterations: float | None = None
    last_residual_ratio: float | None = None
    end: dict[str, float] = field(default_factory=dict)
    contact_rings: dict[str, Any] | None = None
    water: dict[str, float] | None = field(default=None, metadata=OPTIONAL)
    energy: dict[str, float] = field(default_factory=dict)

    def ending_at(self, path: xr.Dataset) -> PathFigures:
        """Return the figures with the last state, and the limit load there, of other values of the path."""
        end = {name: float(path[name].values[-1]) for name in self.end}
        limit = None if self.limit_load is None else LimitLoad.at(end, self.limit_load.criterion)
        return dataclasses.replace(self, end=end, limit_load=limit)

    _typed: ClassVar[Mapping[str, Callable[[Any], Any]]] = {
        "status": Status,
        "reason": StopReason,
        "limit_load": LimitLoad.from_dict,
        "cut_backs_at": lambda cuts: [CutBack.from_dict(each) for each in cuts],
    }


@dataclass(frozen=True, slots=True)
class CheckpointCost(_Part):
    """Checkpoints of paths, at their ends and once a minute: how many, wall seconds, share of the time of the paths."""

    written: int
    wall_s: float
    share_of_wall: float


@dataclass(slots=True)
class RunRecord(_Part):
    """Status, convergence and cost of a run.

    stopped_by : why the run ended before its paths did; None where it did not.
    failures, warnings : sentences on paths that stopped, and on what was computed.
    schema : of the full-model result.
    resumed : time and place of each continuation.
    environment : versions of the libraries and numbers of threads.
    ranges_sha256 : that which the runs of all estimates of a scene share; None of a scene without ranges.
    left_out : what the scene leaves out, and why.
    defaulted, remarks : values that the scene does not give, and what is unlikely in it (`pysprings.scene.defaults`).
    phases : wall and CPU seconds by phase; wall_s and cpu_s are their sums.
    stiffness_initial : of the whole caisson at mudline: dofs, the matrix in N, m, rad, and the torsional stiffness.
    summary : the run in ten lines, by heading (`pysprings.results.summary`).
    error_estimate, target_error, balance, files : what was asked for, or written, beside the computation.
    not_made : parts that follow the results (error estimate, pictures, report) and were not made, by name, and why.
    """

    status: Status = Status.INTERRUPTED
    stopped_by: StopReason | None = None
    failures: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    version: str = ""
    schema: str = ""
    started_utc: str = ""
    resumed: list[dict[str, str]] = field(default_factory=list)
    python: str = ""
    platform: str = ""
    environment: dict[str, str] = field(default_factory=dict)
    scene_sha256: str = ""
    ranges_sha256: str | None = field(default=None, metadata=OPTIONAL)
    scene_toml: str = ""
    mesh: MeshFigures = field(default_factory=MeshFigures)
    solver: SolverFigures = field(default_factory=SolverFigures)
    paths: dict[str, PathFigures] = field(default_factory=dict)
    left_out: list[dict[str, Any]] = field(default_factory=list)
    defaulted: list[dict[str, Any]] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    checkpoints: CheckpointCost | None = field(default=None, metadata=OPTIONAL)
    phases: dict[str, dict[str, float]] = field(default_factory=dict)
    wall_s: float = 0.0
    cpu_s: float = 0.0
    peak_memory_bytes: int = 0
    error_estimate: dict[str, Any] | None = field(default=None, metadata=OPTIONAL)
    target_error: dict[str, Any] | None = field(default=None, metadata=OPTIONAL)
    stiffness_initial: dict[str, Any] | None = field(default=None, metadata=OPTIONAL)
    balance: dict[str, dict[str, float]] | None = field(default=None, metadata=OPTIONAL)
    files: list[str] | None = field(default=None, metadata=OPTIONAL)
    summary: dict[str, str] | None = field(default=None, metadata=OPTIONAL)
    not_made: dict[str, str] = field(default_factory=dict)
    _typed: ClassVar[Mapping[str, Callable[[Any], Any]]] = {
        "status": Status,
        "stopped_by": StopReason,
        "mesh": MeshFigures.from_dict,
        "solver": SolverFigures.from_dict,
        "paths": lambda paths: {name: PathFigures.from_dict(path) for name, path in paths.items()},
        "checkpoints": CheckpointCost.from_dict,
    }

    @classmethod
    def read(cls, folder: Path) -> RunRecord | None:
        """Return the record of `run.json` in a folder; None if there is none or it is broken."""
        try:
            return cls.from_text((folder / FILE).read_text(encoding="utf-8"))
        except (OSError, ValueError, TypeError, AttributeError):
            return None

    @classmethod
    def has_whole_results(cls, folder: Path) -> bool:
        """Return whether the results in a folder are whole, whatever follows them is missing."""
        record = None if not is_unfinished(folder) else cls.read(folder)
        return not is_unfinished(folder) or (record is not None and bool(record.not_made))

    @classmethod
    def of(cls, result: xr.DataTree) -> RunRecord | None:
        """Return the record that a full-model result carries; None without one."""
        text = result.root.attrs.get(ATTRIBUTE)
        return None if text is None else cls.from_text(text)

    @classmethod
    def from_text(cls, text: str) -> RunRecord:
        """Return the record of a JSON text."""
        return cls.from_dict(json.loads(text))

    def is_of(self, scene: Scene) -> bool:
        """Return whether the run is that of a scene, maybe with the harmonics that its series chose.

        A scene with harmonics of its own is that of a run with the same number only.
        """
        chosen = self.mesh.harmonics if scene.mesh.harmonics is None else None
        same = [scene] if chosen is None else [scene, scene.replace(mesh={"harmonics": chosen})]
        return self.scene_sha256 in [each.sha256 for each in same]

    @property
    def complete(self) -> bool:
        """True if all paths came to their ends, or to their limit loads, and every file is written."""
        return self.status is Status.COMPLETE

    @property
    def reached(self) -> bool:
        """True if all paths came to their aims, pull-out among them, and every file is written."""
        return self.complete and all(limit.is_vertical for limit in self.limit_loads.values())

    @property
    def short(self) -> list[str]:
        """Sentences on the paths that did not come to their aims: failures, then limit loads."""
        limits = (f"path '{name}' ended at its limit load: {at}" for name, at in self.limit_loads.items())
        return [*self.failures, *limits]

    @property
    def left_to_make(self) -> str:
        """One line on what was not made; empty where everything was."""
        parts = [f"{name} ({why})" for name, why in self.not_made.items()]
        return f"not made: {', '.join(parts)}; --resume makes what is missing" if parts else ""

    @property
    def limit_loads(self) -> dict[str, LimitLoad]:
        """Limit loads by path, of those that met one."""
        return {name: path.limit_load for name, path in self.paths.items() if path.limit_load is not None}

    @property
    def reasons(self) -> list[StopReason]:
        """Reasons of the paths that stopped."""
        return [path.reason for path in self.paths.values() if path.reason is not None]

    def as_json(self) -> str:
        """Return the record as JSON text on one line."""
        return json.dumps(self.as_dict())


@dataclass(frozen=True, slots=True)
class Computed:
    """A full-model result and the record of its run."""

    tree: xr.DataTree
    record: RunRecord

    @property
    def interrupted(self) -> bool:
        """True where the run ended before its paths did."""
        return self.record.status is Status.INTERRUPTED

    @property
    def unfinished(self) -> bool:
        """True where the run, or a part that follows its results, can go on from checkpoints."""
        return self.interrupted or bool(self.record.not_made)

    def recorded(self) -> xr.DataTree:
        """Return the tree with the record as its attribute `run_json`."""
        self.tree.attrs[ATTRIBUTE] = self.record.as_json()
        return self.tree
