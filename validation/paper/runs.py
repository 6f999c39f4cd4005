# SPDX-License-Identifier: MIT
"""The paper's runs, each in a folder of its own: ended runs stay, interrupted ones are resumed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pysprings.core.errors import RunIncomplete
from pysprings.studies import stored_runs
from pysprings.studies.stored_runs import Whole, has_ended, record_of, run_folder, why_stopped
from validation.paper.cases import CASES, PATH, Case

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.core.progress import Progress
    from pysprings.full_model.run_record import RunRecord

_COUPLED = 1.6  # cost of a run with water over that of a drained one


@dataclass(frozen=True)
class Run:
    """A run as it ended: its case, its folder, its path (converged steps), full model, record."""

    case: Case
    folder: Path
    result: xr.DataTree
    path: xr.Dataset
    record: RunRecord

    @property
    def complete(self) -> bool:
        """Whether the run reached its end."""
        return self.record.reached

    @property
    def remark(self) -> str:
        """Reason of a run that stopped early; empty for a complete one."""
        if self.complete:
            return ""
        return f"{self.case.name}: stopped at u = {1e3 * float(self.path['u'].values[-1]):.3g} mm"


def run_all(out: Path, mesh: str, report: Progress, cases: Sequence[Case] = CASES) -> list[str]:
    """Run every case below a folder that has not ended there; return the reasons of runs that stopped early.

    KeyboardInterrupt passes through: the same call goes on.
    """
    from pysprings.results.folder import run_or_go_on

    whole = Whole({case.name: 1.0 if case.drained else _COUPLED for case in cases}, report, paths=(PATH,))
    stopped = []
    for case in cases:
        scene, folder = case.scene(mesh), run_folder(out, case.name)
        worked, why = not has_ended(folder, scene), ""
        if worked:
            try:
                run_or_go_on(scene, folder, whole.of(case.name))
            except RunIncomplete as error:
                why = str(error)
        why = why or why_stopped(record_of(folder, scene))
        if why:
            stopped.append(f"{case.name}: {why}")
        whole.ended(case.name, worked)
    return stopped


def forget(out: Path, cases: Sequence[Case] = CASES) -> None:
    """Mark every run below a folder to be repeated; results stay until there are new ones."""
    for case in cases:
        stored_runs.forget(run_folder(out, case.name))


def load_runs(out: Path, mesh: str, cases: Sequence[Case] = CASES) -> dict[str, Run]:
    """Read the runs below a folder that belong to this mesh and version and have a converged step, by name."""
    from pysprings.results.layout import open_result
    from pysprings.springs.path import paths_of

    runs = {}
    for case in cases:
        folder = run_folder(out, case.name)
        record = record_of(folder, case.scene(mesh))
        if record is None or not (folder / "full_model.nc").exists():
            continue
        result = open_result(folder)
        known = paths_of(result)
        if PATH in known and known[PATH].n > 1:
            runs[case.name] = Run(case, folder, result, path_of(result), record)
    return runs


def path_of(result: xr.DataTree) -> xr.Dataset:
    """Return the path of a run (converged steps) with the nodes of the symmetry plane and the size of the caisson."""
    from pysprings.results.parts import section_data, settings
    from pysprings.springs.path import paths_of

    path = paths_of(result)[PATH].dataset
    plane = section_data(result)
    if plane is not None and "section_ux" in path:
        path = path.assign({name: plane[name] for name in ("section_x", "section_depth")})
    return path.assign_attrs({**settings(result), **path.attrs})
