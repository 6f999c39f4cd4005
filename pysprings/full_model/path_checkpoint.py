# SPDX-License-Identifier: MIT
"""A path in checkpoints: what it has gathered, and where it stands between two increments."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from fe_engine.errors import NotConverged
from fe_engine.linear.preconditioner import Origin
from fe_engine.solve.step_size import StepSize
from fe_engine.solve.stepping import Position
from pysprings.core.words import StopReason
from pysprings.full_model.cavitation import Margin
from pysprings.full_model.checkpoint import Cost, Saved
from pysprings.full_model.run_record import Ending, Status

Row = dict[str, Any]
Attempt = tuple[str, float, NotConverged]  # stage, fraction of it that was aimed at, error

_FIELD, _ROW, _LAST, _FACTORS = "field/", "row/", "last/", "factors/"  # names of arrays in a file


@dataclass(frozen=True)
class Gathered:
    """Rows, iterations and balances of a path, whole or as far as it went.

    Attributes
    ----------
    rows : one a step, with the same names.
    record : one entry per iteration; ``given_up`` the failed attempts; ``limits`` what limited each step.
    cavitation : margin of the first step whose water would cavitate.
    energy : totals of the energy balance.
    cost : of the path until then.
    """

    path: str
    ending: Ending
    rows: list[Row]
    record: list[Row]
    given_up: list[Attempt]
    limits: list[str]
    cavitation: Margin | None
    energy: Any
    n_steps: int
    cost: Cost

    def saved(self) -> Saved:
        """Return the content of a checkpoint file."""
        meta = {
            "path": self.path,
            "ending": asdict(self.ending),
            "n_rows": len(self.rows),
            "record": self.record,
            "given_up": [(stage, fraction, _plain(error)) for stage, fraction, error in self.given_up],
            "limits": self.limits,
            "cavitation": None if self.cavitation is None else asdict(self.cavitation),
            "energy": self.energy,
            "n_steps": self.n_steps,
            "cost": asdict(self.cost),
        }
        names = self.rows[0] if self.rows else {}
        return Saved(meta, {_ROW + name: np.array([row[name] for row in self.rows]) for name in names})

    @classmethod
    def of(cls, saved: Saved) -> Gathered:
        """Return what a checkpoint file holds."""
        meta, columns = saved.meta, _part(saved, _ROW)
        ending = meta["ending"]
        reason = None if ending["reason"] is None else StopReason(ending["reason"])
        return cls(
            path=meta["path"],
            ending=Ending(Status(ending["status"]), reason, ending["why"], ending["failure"]),
            rows=[{name: values[k] for name, values in columns.items()} for k in range(meta["n_rows"])],
            record=meta["record"],
            given_up=[(stage, fraction, NotConverged(**error)) for stage, fraction, error in meta["given_up"]],
            limits=meta["limits"],
            cavitation=None if meta["cavitation"] is None else _margin(meta["cavitation"]),
            energy=meta["energy"],
            n_steps=meta["n_steps"],
            cost=Cost(**meta["cost"]),
        )


@dataclass(frozen=True)
class Standing:
    """State of a path after a step, from which it goes on: copies of its changing fields.

    Attributes
    ----------
    stage, time : number of the stage, and time [s] since the start of the path.
    fields : committed state.
    position : where the driver goes on in the stage; ``force`` and ``stiffness`` are the driver's.
    factors : what the factors of the linear solver were made from; None where nothing is kept.
    water : totals of the water balance; None when drained.
    """

    stage: int
    time: float
    fields: Mapping[str, np.ndarray]
    position: Position
    force: np.ndarray | None
    stiffness: float | None
    factors: Origin | None
    water: Any

    def saved(self, gathered: Gathered) -> Saved:
        """Return the content of a checkpoint file, together with what the path has gathered until then."""
        at, whole = self.position, gathered.saved()
        meta = whole.meta | {
            "stage": self.stage, "time": self.time, "stiffness": self.stiffness, "water": self.water,
            "force": self.force, "start": at.start, "done": at.done, "next": asdict(at.next),
            "last_size": None if at.last is None else at.last[0],
        }  # fmt: skip
        arrays = whole.arrays | {_FIELD + name: values for name, values in self.fields.items()}
        if at.last is not None:
            arrays |= {_LAST + "free": at.last[1], _LAST + "border": at.last[2]}
        if self.factors is not None:
            arrays |= {_FACTORS + name: values for name, values in vars(self.factors).items()}
        return Saved(meta, arrays)

    @classmethod
    def of(cls, saved: Saved) -> Standing | None:
        """Return what a checkpoint file holds; None for that of a path that has ended."""
        meta = saved.meta
        if "stage" not in meta:
            return None
        position = Position(np.array(meta["start"]), meta["done"], StepSize(**meta["next"]))
        if meta["last_size"] is not None:
            last = _part(saved, _LAST)
            position = replace(position, last=(meta["last_size"], last["free"], last["border"]))
        factors = _part(saved, _FACTORS)
        return cls(
            stage=meta["stage"],
            time=meta["time"],
            fields=_part(saved, _FIELD),
            position=position,
            force=None if meta["force"] is None else np.array(meta["force"]),
            stiffness=meta["stiffness"],
            factors=Origin(**factors) if factors else None,
            water=None if meta["water"] is None else tuple(meta["water"]),
        )


def _part(saved: Saved, prefix: str) -> dict[str, np.ndarray]:
    """Return the arrays of a file whose names have a prefix, without it."""
    return {name.removeprefix(prefix): values for name, values in saved.arrays.items() if name.startswith(prefix)}


def _margin(margin: Mapping[str, Any]) -> Margin:
    x, y, z = margin["place"]
    return Margin(margin["margin"], margin["pressure"], (x, y, z))


def _plain(error: NotConverged) -> dict[str, Any]:
    return {"reason": error.reason, "place": error.place, "history": error.history}
