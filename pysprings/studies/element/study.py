# SPDX-License-Identifier: MIT
"""Laboratory tests on a layer of a scene: what is asked for, the curves, their files and picture."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pysprings.core.files.storage import write_text
from pysprings.core.words import ElementTest
from pysprings.model.element import KINDS, Curve, element_test, specimen
from pysprings.results.plots.files import redraw
from pysprings.results.plots.style import BLUE, GREEN, KPA, ORANGE, PURPLE, VERMILLION, new_figure, plain, styled
from pysprings.scene.ground import Stratum
from pysprings.studies.element.data import MEASURED, LabTest, residuals
from pysprings.studies.element.fit import Fit, fit

# column -> its axis, and the factor to the unit there
_AXES = {
    "axial_strain": ("axial strain [%]", 100.0), "shear_strain": ("shear strain [%]", 100.0),
    "volumetric_strain": ("volumetric strain [%], compression positive", 100.0),
    "q_Pa": ("deviator stress q [kPa]", KPA), "p_Pa": ("mean effective stress p' [kPa]", KPA),
    "shear_stress_Pa": ("shear stress [kPa]", KPA), "axial_stress_Pa": ("axial effective stress [kPa]", KPA),
    "pore_pressure_Pa": ("excess pore pressure [kPa]", KPA),
}  # fmt: skip
_COLOURS = (BLUE, VERMILLION, GREEN, ORANGE, PURPLE)


@styled
def element_picture(
    curves: Sequence[Curve], names: Sequence[str], tests: Sequence[LabTest], kind: ElementTest, title: str
) -> Figure:
    """Draw curves (lines) beside the tests of the same place in the list (dots)."""
    strain, measured = MEASURED[kind]
    wet = any(curve.drainage == "undrained" for curve in curves)
    path = ("axial_stress_Pa", measured[0]) if kind == "dss" else ("p_Pa", "q_Pa")
    panels = ((strain, measured[0]), (strain, "pore_pressure_Pa" if wet else "volumetric_strain"), path)
    figure = new_figure(13.0, 4.6)
    for axes, (x, y) in zip(figure.subplots(1, 3), panels, strict=True):
        for k, (curve, name) in enumerate(zip(curves, names, strict=True)):
            columns, colour = curve.columns(), _COLOURS[k % len(_COLOURS)]
            axes.plot(_AXES[x][1] * columns[x], _AXES[y][1] * columns[y], color=colour, label=plain(name))
            if tests and {x, y} <= set(tests[k].columns):
                data = tests[k].columns
                every = slice(None, None, max(len(data[x]) // 60, 1))
                points = _AXES[x][1] * data[x][every], _AXES[y][1] * data[y][every]
                axes.plot(*points, linestyle="", marker="o", markersize=3.0, color=colour, alpha=0.6)
        axes.set(xlabel=_AXES[x][0], ylabel=_AXES[y][0])
        axes.margins(x=0.02)
        if np.ptp(axes.get_ylim()) == 0.0:
            axes.set_ylim(-1.0, 1.0)
    figure.axes[0].legend(fontsize=8)
    figure.suptitle(plain(title + ("; dots: data" if tests else "")))
    return figure


@dataclass(frozen=True)
class Request:
    """Tests that are asked for: of a layer with values at a depth (m), from consolidation stresses (Pa), or of data.

    ``stresses`` without any: the stress of the layer there. ``strain``: the last one; None is that of the kind, or of
    the data. ``keys`` are fitted to the data.
    """

    stratum: Stratum
    kind: ElementTest
    depth: float
    undrained: bool = False
    stresses: tuple[float, ...] = ()
    strain: float | None = None
    tests: tuple[LabTest, ...] = ()
    keys: tuple[str, ...] = ()


@dataclass(frozen=True)
class Outcome:
    """Curves by test, with their names and the fit of keys."""

    request: Request
    names: list[str]
    curves: list[Curve]
    fit: Fit | None

    @property
    def stopped(self) -> list[str]:
        """Sentences on tests that did not reach their last strain."""
        return [f"{name}: {each.stopped}" for name, each in zip(self.names, self.curves, strict=True) if each.stopped]

    @cached_property
    def rows(self) -> list[dict[str, Any]]:
        """Rows of the summary, in SI: largest stress and where, the state at the end, distance from data."""
        request, out = self.request, []
        strain, measured = MEASURED[request.kind]
        for k, (name, curve) in enumerate(zip(self.names, self.curves, strict=True)):
            columns = curve.columns()
            at = int(np.argmax(np.abs(columns[measured[0]])))
            row = {"test": name, "drainage": curve.drainage, "stress": curve.consolidation, "stopped": curve.stopped}
            row |= {"peak": columns[measured[0]][at], "at": columns[strain][at], "end": columns[measured[0]][-1]}
            if not request.stratum.total_stress:
                row |= {"angle": np.degrees(columns["mobilised_angle_rad"].max())}
            row |= {"volume": columns["volumetric_strain"][-1], "pressure": columns["pore_pressure_Pa"][-1]}
            if request.tests:
                parts = residuals(request.tests[k], curve, request.kind, request.undrained)
                row["away"] = float(np.sqrt(np.mean([each @ each for each in parts])))
            out.append({key: float(value) if isinstance(value, np.floating) else value for key, value in row.items()})
        return out

    def table(self) -> pd.DataFrame:
        """Return all states in SI, one a row."""
        frames = []
        for name, curve in zip(self.names, self.curves, strict=True):
            frame = pd.DataFrame(curve.columns())
            frames.append(frame.assign(test=name, drainage=curve.drainage, stress_Pa=curve.consolidation))
        frame = pd.concat(frames, ignore_index=True)
        return frame[["test", "drainage", "stress_Pa", *self.curves[0].columns()]]


def run(request: Request) -> Outcome:
    """Fit keys where any are asked for, and run the tests with what was fitted."""
    kind, fitted = KINDS[request.kind], None
    if request.keys:
        fitted = fit(request.stratum, request.kind, request.depth, request.undrained, request.tests, request.keys)
        request = replace(request, stratum=replace(request.stratum, values=request.stratum.values | fitted.values))
    curves, names = [], []
    for stress, name, last in _asked(request):
        point = specimen(request.stratum, kind, stress, request.depth)
        curves.append(element_test(point, kind, request.depth, request.undrained, last))
        names.append(name or f"{curves[-1].consolidation / 1e3:.6g} kPa")
    return Outcome(request, names, curves, fitted)


def _asked(request: Request) -> list[tuple[float | None, str, float | None]]:
    """Return consolidation stress, name and last strain of each test."""
    if request.tests:
        key = MEASURED[request.kind][0]
        lasts = [float(np.abs(test.columns[key]).max()) for test in request.tests]
        return [
            (test.stress, test.name, request.strain or last) for test, last in zip(request.tests, lasts, strict=True)
        ]
    return [(stress, "", request.strain) for stress in request.stresses or (None,)]


def write(outcome: Outcome, folder: Path, formats: Sequence[str]) -> list[Path]:
    """Write element.csv and the picture; return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    file, request = folder / "element.csv", outcome.request
    write_text(outcome.table().to_csv(index=False, float_format="%.9g", lineterminator="\n"), file)
    title = f"{KINDS[request.kind].name}, layer {request.stratum.name}, law {request.stratum.law}"

    def draw() -> Any:
        return element_picture(outcome.curves, outcome.names, request.tests, request.kind, title)

    return [file, *redraw(draw, folder / "element", formats)]
