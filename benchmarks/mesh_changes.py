# SPDX-License-Identifier: MIT
"""Meshes that differ in one thing: counts and keys of a mesh changed for one run, and what groups of them tend to."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import xarray as xr

from benchmarks.kept_runs import result_of
from pysprings import Scene
from pysprings.full_model.accuracy import measures
from pysprings.full_model.accuracy.curves import Sample
from pysprings.full_model.accuracy.richardson import Reference
from pysprings.full_model.accuracy.settings import read_mesh
from pysprings.model import fourier_mesh, mesh

_PRESETS = {"bricks": mesh.PRESETS, "series": fourier_mesh.PRESETS}


class Change(NamedTuple):
    """What is changed of a mesh: keys of [mesh] and [solver] of the scene, counts of the preset.

    ``size`` is that of the cells that a limit is found from (1 without the change). Runs are kept by ``words``, so that
    they say what is changed of the counts.
    """

    words: str
    mesh: Mapping[str, Any] = {}
    solver: Mapping[str, Any] = {}
    counts: Mapping[str, Any] = {}
    size: float = 1.0


class Family(NamedTuple):
    """A mesh, and groups of changes of it that a limit is found from, each from coarse to fine.

    ``sections`` have ever smaller cells in a plane through the axis, those across the tip among them. ``around``
    are more cells around or more harmonics, beside its first member; ``extrapolated``: whether it has an order. ``lid``
    are ever smaller cells below mudline on the coarsest section; all sections have a first one of the same size then.
    """

    mesh: str
    sections: Sequence[Change]
    around: Sequence[Change]
    extrapolated: bool
    lid: Sequence[Change] = ()

    @property
    def changes(self) -> list[Change]:
        """All changes, each once."""
        return list({change.words: change for change in (*self.sections, *self.around, *self.lid)}.values())

    @property
    def groups(self) -> list[tuple[Sequence[Change], bool]]:
        """Groups beside the sections, and whether each has an order."""
        return [(self.around, self.extrapolated), (self.lid, True)]


# Bricks with cells beside and across the tip that are smaller than the skirt is thick: the field there varies over the
# thickness, and cells that are larger have no order.
TIP = {"plug": 8, "outer": 16, "tip": 4, "skirt": 16, "below": 14, "wall": 0.02, "toe": 0.02}
BRICKS, SERIES = "medium", "fourier-coarse@5"
# First cells below mudline over the skirt length. Below a lid that has lifted off water flows along the wall: cells
# there are a group of their own, and all sections have the first size. Half of a size takes so many more.
LID_BRICKS, LID_SERIES = (0.02, 0.04, 0.01), (1.0 / 12.0, 0.16, 0.04)
_MORE_BRICKS, _MORE_SERIES = 2.5, 1.0
BRICK_SECTIONS, SERIES_SECTIONS = (0.5, 0.75, 1.0, 1.5), (2.0, 3.0, 4.0)
_FINE_TIP = "fine beside the tip"
_MEDIUM_LID = mesh.PRESETS["medium"].mudline


def bricks(section: float, around: int = 12, lid: float | None = None) -> Change:
    """Return bricks of a section so many times as fine, with so many cells around half the caisson.

    lid: first cell below mudline over the skirt length (None: that of `medium` over the section).
    """
    words = f"bricks {_FINE_TIP}{_lid_words(lid)}, section {section:g}, {around} around"
    counts = TIP | ({} if lid is None else _lid_counts(lid * section, _MEDIUM_LID, TIP["skirt"], _MORE_BRICKS))
    return Change(words, {"refinement": section, "azimuth": around}, counts=counts, size=1.0 / section)


def series(section: float, harmonics: int = 5, lid: float | None = None) -> Change:
    """Return series of a section so many times as fine as `coarse`, with N harmonics; lid: see `bricks`."""
    words = f"series{_lid_words(lid)}, section {section:g}, N {harmonics}"
    coarse = fourier_mesh.PRESETS["coarse"]
    counts = {} if lid is None else _lid_counts(lid * section, coarse.mudline, coarse.skirt, _MORE_SERIES)
    return Change(words, {"refinement": section, "harmonics": harmonics}, counts=counts, size=1.0 / section)


def _lid_words(lid: float | None) -> str:
    return "" if lid is None else f", first cell {lid:.3g} L"


def _lid_counts(first: float, usual: float, skirt: float, more: float) -> dict[str, Any]:
    """Return the first cell below mudline of a preset, and cells down the skirt: so many more for half the size."""
    return {"mudline": first, "skirt": round(skirt + more * max(0.0, math.log2(usual / first)))}


def families(
    of_bricks: Sequence[float] = BRICK_SECTIONS, of_series: Sequence[float] = SERIES_SECTIONS, lid: bool = False
) -> dict[str, Family]:
    """Return both families on these sections; cells around, and harmonics, are changed on the coarsest.

    lid: with cells below the lid as a group of their own.
    """
    first, other = of_bricks[0], of_series[0]
    one, two = (LID_BRICKS[0], LID_SERIES[0]) if lid else (None, None)
    ring = [bricks(first, n, one)._replace(size=12.0 / n) for n in (8, 12, 24)]
    waves = [series(other, n, two)._replace(size=6.0 / (n + 1)) for n in (5, 8, 11)]
    below = [bricks(first, 12, cell)._replace(size=cell) for cell in sorted(LID_BRICKS, reverse=True)]
    under = [series(other, 5, cell)._replace(size=cell) for cell in sorted(LID_SERIES, reverse=True)]
    return {
        "bricks": Family(BRICKS, [bricks(f, 12, one) for f in of_bricks], ring, True, below if lid else ()),
        "series": Family(SERIES, [series(f, 5, two) for f in of_series], waves, False, under if lid else ()),
    }


@dataclass(frozen=True)
class Limit:
    """What a family tends to: ``values``, and ``beside``, a sample a group, whose distances are its uncertainty.

    ``notes`` say how the limit of each group was found.
    """

    values: Sample
    beside: tuple[Sample, ...]
    notes: tuple[str, ...]


def together(family: Family, each: Mapping[str, Sample]) -> Limit:
    """Return the limit of the sections in ``each``, and what other groups add where all their members are there.

    A sample of ``each`` is that of the words of a change.
    """
    sections = [change for change in family.sections if change.words in each]
    groups = [_reference(sections, each)]
    values = {key: found.values.copy() for key, found in groups[0].items()}
    notes = [_note(sections, groups[0])]
    for group, extrapolated in family.groups:
        if group and all(change.words in each for change in group):
            plain = each[family.sections[0].words]
            # without an order the finest stands for the limit, the one before it for its doubt
            groups.append(_reference(group if extrapolated else group[-2:], each))
            values |= {key: values[key] + one.values - plain[key] for key, one in groups[-1].items() if key in values}
            notes.append(_note(group, groups[-1]))
    beside = tuple({key: values[key] - found.values + found.beside for key, found in group.items()} for group in groups)
    return Limit(values, beside, tuple(notes))


def _reference(changes: Sequence[Change], each: Mapping[str, Sample]) -> dict[str, Reference]:
    return measures.reference_of([each[change.words] for change in changes], [change.size for change in changes])


def _note(changes: Sequence[Change], found: Mapping[str, Reference]) -> str:
    fitted = {key: each for key, each in found.items() if each.order is not None and each.values.size > 1}
    orders = [f"{key} {each.order:.1f}" for key, each in fitted.items()]
    return f"{changes[-1].words}: " + (f"orders {', '.join(orders)}" if orders else "as it is")


@contextmanager
def counted(kind: str, preset: str, counts: Mapping[str, Any]) -> Iterator[None]:
    """Give a preset other counts while the context lasts."""
    changed: Any = replace(_PRESETS[kind][preset], **counts)
    with mock.patch.dict(_PRESETS[kind], {preset: changed}):
        yield


def run(name: str, change: Change, scene: Scene, folder: Path | None) -> xr.DataTree:
    """Return the result of a scene on a mesh with a change."""
    setting = read_mesh(name)
    base = setting.scene(scene)
    own = {"preset": setting.mesh, "refinement": setting.refinement, "discretisation": setting.discretisation,
           "harmonics": setting.harmonics} | dict(change.mesh)  # fmt: skip
    solver = {"tolerance": base.solver.tolerance} | dict(change.solver)
    changed = base.replace(mesh=own, solver=solver, title=change.words)  # runs are kept by what is in the scene
    with counted("bricks" if setting.discretisation == "hex8" else "series", setting.mesh, change.counts):
        return result_of(changed, folder)
