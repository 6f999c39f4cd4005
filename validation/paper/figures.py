# SPDX-License-Identifier: MIT
"""The figures of the paper from our runs, in its arrangement, two that it only describes, two of our idealisations."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pysprings.core.written import own_folder
from pysprings.results import plots
from pysprings.results.parts import path_data, section_data
from validation.paper import curves as drawn, measures
from validation.paper.cases import DEPTHS, END, PATH, SHOWN
from validation.paper.idealisations import BESIDE

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from validation.paper.runs import Run

FOLDER = "figures"
Runs = Mapping[str, "Run"]


@dataclass(frozen=True)
class Drawing:
    """A figure: file name, caption, the runs it needs, how far they must have come [m], and how it is drawn."""

    stem: str
    caption: str
    needs: tuple[str, ...]
    draw: Callable[[Runs], Figure]
    u: float = 0.0
    tall: bool = False

    def possible(self, runs: Runs) -> bool:
        """Return whether the runs exist and have reached the range of the figure."""
        return all(name in runs and measures.reached(runs[name].path, self.u) for name in self.needs)


_FIELDS = ("normal_effective_stress", "shear_lateral", "pore_pressure")


def _path(runs: Runs, name: str) -> xr.Dataset:
    """Return a path with the words of its case in the place of its name and drainage."""
    return path_data(runs[name].result, PATH).assign_attrs(path="", drainage=runs[name].case.words)


def _rings(runs: Runs, name: str) -> xr.Dataset:
    """Return a path with its contact fields at the paper's depths, linear between the rings of the mesh."""
    path = _path(runs, name)
    fields = path[[field for field in _FIELDS if field in path]].interp(depth=list(DEPTHS))
    return path[["u", "rotation", "converged"]].merge(fields).assign_attrs(path.attrs)


def _plane(runs: Runs, name: str) -> xr.Dataset:
    section = section_data(runs[name].result)
    assert section is not None
    return section


def _sections(name: str, u: float) -> Callable[[Runs], Figure]:
    return lambda runs: plots.section_displacement(_plane(runs, name), _path(runs, name), displacement=u)


def _macro(runs: Runs) -> Figure:
    from pysprings.macro.comparison import curves
    from pysprings.springs.checks import open_springs

    springs = open_springs(runs["drained"].folder / "springs.nc")
    return plots.macro_against_full(_path(runs, "drained"), curves(springs, PATH))


def _rates(runs: Runs) -> Figure:
    def label(run: Run) -> str:
        rate = "drained" if run.case.rate is None else f"v = {1e3 * run.case.rate:g} mm/s"
        return f"{rate}, \N{GREEK SMALL LETTER MU} = {run.case.friction:g}"

    ours = {label(run): (_path(runs, name), run.case) for name, run in runs.items() if not run.case.changes}
    return drawn.rates_and_friction(ours)


def _idealisations(runs: Runs) -> Figure:
    words = {"drained": "rigid, Drucker-Prager"} | BESIDE
    there = {words[name]: _path(runs, name) for name in words if name in runs}
    return drawn.idealisations(there, DEPTHS[::3], measures.py_curve)


DRAWINGS = (
    Drawing("fig05_06_displacement_2.5mm", "Figures 5 and 6: lateral and vertical displacement in the symmetry plane, "
            "drained, 2.5 mm", ("drained",), _sections("drained", SHOWN), SHOWN, True),
    Drawing("fig05_06_displacement_20mm", "Figures 5 and 6 at the end: drained, 20 mm", ("drained",),
            _sections("drained", END), END, True),
    Drawing("fig08_normal_stress", "Figure 8: normal effective stress over initial, outside, drained, 2.5 mm",
            ("drained",), lambda r: plots.stress_rose(_rings(r, "drained"), displacement=SHOWN, depths=DEPTHS), SHOWN,
            True),
    Drawing("fig09_shear", "Figure 9: shear stress projected on the loading direction, over the initial normal stress, "
            "drained, 2.5 mm", ("drained",),
            lambda r: plots.shear_rose(_rings(r, "drained"), displacement=SHOWN, depths=DEPTHS), SHOWN, True),
    Drawing("fig10_load_drained", "Figure 10: load and its components, drained", ("drained",),
            lambda r: drawn.load_components(_path(r, "drained"))),
    Drawing("fig12_load_partially_drained", "Figure 12: load and its components, 0.05 mm/s", ("slow", "drained"),
            lambda r: drawn.load_components(_path(r, "slow"), _path(r, "drained"))),
    Drawing("fig13_pore_pressure_20mm", "Figure 13: change of pore pressure in the symmetry plane, 0.05 mm/s, 20 mm",
            ("slow",), lambda r: plots.section_pressure(_plane(r, "slow"), _path(r, "slow"), displacement=END), END),
    Drawing("fig14_normal_stress_partially_drained", "Figure 14: normal effective stress over initial, outside, "
            "0.05 mm/s, 2.5 mm", ("slow",),
            lambda r: plots.stress_rose(_rings(r, "slow"), displacement=SHOWN, depths=DEPTHS), SHOWN, True),
    Drawing("fig15_pore_pressure", "Figure 15: pore pressure over the initial normal stress, 0.05 mm/s, 2.5 mm",
            ("slow",), lambda r: plots.pressure_rose(_rings(r, "slow"), displacement=SHOWN, depths=DEPTHS,
                                                     normalised=True), SHOWN, True),
    Drawing("fig16_py", "Figure 16: p-y curves, drained (open) and at 0.05 mm/s (filled)", ("drained", "slow"),
            lambda r: drawn.py_by_drainage(_path(r, "drained"), _path(r, "slow"), DEPTHS, measures.py_curve)),
    Drawing("fig17_rate_and_friction", "Figure 17: load for rates and friction coefficients", ("drained",), _rates),
    Drawing("gap_map_20mm", "Gap over azimuth and depth, drained, 20 mm", ("drained",),
            lambda r: plots.gap_map(_path(r, "drained"), displacement=END), END),
    Drawing("gap_map_partially_drained_20mm", "Gap over azimuth and depth, 0.05 mm/s, 20 mm", ("slow",),
            lambda r: plots.gap_map(_path(r, "slow"), displacement=END), END),
    Drawing("macro_against_full", "Rigid body on the springs of the drained run against the full model", ("drained",),
            _macro, 0.0, True),
    Drawing("idealisations", "Rigid and elastic caisson, Drucker-Prager's cone and Van Eekelen's surface: load, "
            "p-y, drained", ("drained", "elastic-steel"), _idealisations),
    Drawing("ovalisation_20mm", "Elastic caisson: ovalisation and mean fibre of the skirt, drained, 20 mm",
            ("elastic-steel",), lambda r: plots.ovalisation(_path(r, "elastic-steel"), displacement=END), END),
)  # fmt: skip


def draw_all(runs: Runs) -> Iterator[tuple[Drawing, Figure]]:
    """Yield every figure that the runs allow, in the paper's order."""
    for drawing in DRAWINGS:
        if drawing.possible(runs):
            yield drawing, drawing.draw(runs)


def write_all(runs: Runs, out: Path) -> list[tuple[Drawing, Path]]:
    """Write the figures below a folder as PNG (and SVG where small); return drawings with their PNG files."""
    place = own_folder(out, FOLDER)
    place.mkdir(parents=True, exist_ok=True)
    return [(drawing, plots.save(figure, place / drawing.stem)[0]) for drawing, figure in draw_all(runs)]
