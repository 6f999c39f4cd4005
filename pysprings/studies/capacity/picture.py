# SPDX-License-Identifier: MIT
"""The envelopes in the plane of H and M: full model, macro-model, load cases."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pysprings.core.columns import Column, Row, Table
from pysprings.core.storage import write_text
from pysprings.results.plots import style
from pysprings.results.plots.overview import SMALLEST
from pysprings.results.plots.style import BLUE, GREEN, GREY, INK, MN, VERMILLION, new_figure, plain, styled, zero_lines
from pysprings.results.report.inputs import input_tables
from pysprings.results.report.page import Picture, page_html, picture_uri
from pysprings.scene.model import Scene
from pysprings.springs.path_ends import MESH_ERROR
from pysprings.studies.capacity.envelope import closed
from pysprings.studies.capacity.plan import CHARACTERISTIC, TORSION_ALONE
from pysprings.studies.capacity.points import Capacity

_WIDTH = 5.6  # inch of a panel


@styled
def envelopes(table: pd.DataFrame, scene: Scene, cases: pd.DataFrame | None = None) -> Figure:
    """Draw a panel for each vertical load: full model (line and dots), macro-model (crosses), load cases (squares).

    An open dot is a run that stopped before failure: the capacity is further out. The lower half of the plane is the
    mirror image of the upper one. Below are torsion and the size of the load in the plane, where torsion was asked for.
    """
    loads, rows = table["V_N"].drop_duplicates().tolist(), 1 + int((table["torsion_deg"] > 0.0).any())
    figure = new_figure(1.2 + _WIDTH * len(loads), 5.4 * rows)
    panels = figure.subplots(rows, len(loads), squeeze=False)
    for axes, load in zip(panels[0], loads, strict=True):
        own = table[(table["V_N"] == load) & (table["torsion_deg"] == 0.0)]
        for strength, part in own.groupby("strength", sort=False):
            _envelope(axes, part, str(strength))
        if cases is not None:
            _cases(axes, cases[(cases["V_of_envelope_N"] == load) & (cases["T_Nm"] == 0.0)], "H_N", "M_Nm")
        axes.set(title=f"V = {MN * load:.3g} MN", xlabel="H [MN]", ylabel="M about the lid centre at mudline [MN m]")
        zero_lines(axes)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.1))
    for axes, load in zip(panels[1:].ravel(), loads, strict=False):
        diameter = scene.caisson.outer_diameter
        _torsion(axes, table[table["V_N"] == load], diameter)
        if cases is not None:
            own = cases[(cases["V_of_envelope_N"] == load) & (cases["T_Nm"] != 0.0)]
            size, torsion = np.hypot(own["H_N"], own["M_Nm"] / diameter), own["T_Nm"].abs()
            _cases(axes, own.assign(size_N=size, T_Nm=torsion), "size_N", "T_Nm")
        axes.legend(loc="upper right")
    style.set_title(figure, plain(f"Capacity: {scene.title}"), {})
    return figure


def _torsion(axes: Axes, table: pd.DataFrame, diameter: float) -> None:
    """Draw T over the size of (H, M/D), a line for each direction in the plane, up to T alone where that is known."""
    lines = ("-", "--")
    for number, (strength, part) in enumerate(table.groupby("strength", sort=False)):
        alone = part[part["torsion_deg"] >= math.degrees(TORSION_ALONE)]
        for colour, (direction, own) in enumerate(part.drop(alone.index).groupby("direction_deg")):
            ring = pd.concat([own.sort_values("torsion_deg"), alone])
            axes.plot(
                MN * np.hypot(ring["H_N"], ring["M_Nm"] / diameter), MN * ring["T_Nm"], color=f"C{colour}",
                linestyle=lines[number], marker="o", markersize=4, label=f"{direction:g} deg, {strength} strength",
            )  # fmt: skip
            for _, open_ in ring[ring["is_capacity"] == 0].iterrows():
                place = (MN * math.hypot(open_["H_N"], open_["M_Nm"] / diameter), MN * open_["T_Nm"])
                axes.plot(*place, "o", color=f"C{colour}", markerfacecolor="white", markersize=6, zorder=3)
    axes.set(xlabel="size of (H, M/D) [MN]", ylabel="T [MN m]", xlim=(0.0, None), ylim=(0.0, None))


def _envelope(axes: Axes, part: pd.DataFrame, strength: str) -> None:
    characteristic = strength == CHARACTERISTIC
    colour = BLUE if characteristic else GREEN
    ring = closed(part)
    H, M = (np.concatenate([ring[name], -ring[name].iloc[1:]]) for name in ("H_N", "M_Nm"))
    axes.plot(MN * H, MN * M, color=colour, linewidth=1.2, label=f"full model, {strength} strength", zorder=2)
    for known, face in ((1, colour), (0, "white")):
        dots = part[part["is_capacity"] == known]
        label = "" if known else "stopped before failure: capacity is larger"
        axes.plot(
            MN * dots["H_N"], MN * dots["M_Nm"], "o", color=colour, markerfacecolor=face, markersize=6, zorder=3,
            label=label if len(dots) and label else None,
        )  # fmt: skip
    for end, mark in (("range", "v"), ("", "x")):
        springs = part[part["H_macro_N"].notna() & (part["criterion_macro"].str.contains("range") == bool(end))]
        if len(springs):
            words = "macro-model, end of its range" if end else f"macro-model, {strength} strength"
            across, along = MN * springs["H_macro_N"], MN * springs["M_macro_Nm"]
            axes.plot(
                across, along, mark, color=VERMILLION if characteristic else GREY, linestyle="none", markersize=7,
                markeredgewidth=1.6, label=words, zorder=4,
            )  # fmt: skip


def _cases(axes: Axes, cases: pd.DataFrame, across: str, along: str) -> None:
    cases = cases.drop_duplicates("name")
    for off, colour, face, words in ((0, INK, INK, "load cases"), (1, GREY, "white", "load cases of another V")):
        own = cases[cases["off_load"] == off]
        if len(own):
            look: Any = {"color": colour, "markerfacecolor": face, "markersize": 5, "linestyle": "none"}
            axes.plot(MN * own[across], MN * own[along], "s", label=words, **look)
    for row in cases.to_dict("records"):
        place = (MN * row[across], MN * row[along])
        axes.annotate(plain(row["name"]), place, textcoords="offset points", xytext=(6, 2), fontsize=8)


def write_page(out: Path, outcome: Capacity) -> Path:
    """Write report.html into the folder of a study; return its path."""
    drawn = [file for file in (out / "capacity.svg", out / "capacity.png") if file.exists()][:1]
    cases = outcome.cases
    html = page_html(
        "capacity.html.j2",
        title=outcome.scene.title,
        factors=str(outcome.request.factors),
        closing=closing(outcome.table) if len(outcome.table) else "",
        remarks=outcome.remarks,
        criteria=criteria(outcome),
        pictures_drawn=[Picture("Envelopes of H and M", picture_uri(file.read_bytes(), file.suffix)) for file in drawn],
        capacity=table_of(outcome),
        cases=None if cases is None else table_of_cases(cases),
        inputs=input_tables(outcome.scene.to_toml()),
    )
    return write_text(html, out / "report.html")


NOISE = 1e-4  # share of the load: what the tolerance of the solver leaves of zero


def _mega(source: str) -> Callable[[Row], float]:
    """Return the reading of a load in mega-units; what the tolerance of the solver has left of zero is 0."""

    def value(row: Row) -> float:
        noise = NOISE * abs(row["size_N"]) if "size_N" in row and source != "V_N" else 1.0
        return 0.0 if abs(row[source]) <= noise else float(1e-6 * row[source])

    return value


def _motion(source: str) -> Callable[[Row], float]:
    """Return the reading of a motion in SI; what rounding has left of zero is 0."""
    return lambda row: 0.0 if abs(row[source]) < SMALLEST else float(row[source])


TORSION = (
    Column("torsion [deg]", "torsion_deg"),
    Column("T [MN m]", _mega("T_Nm")),
    Column("twist [deg]", _motion("twist_rad"), 3, math.degrees(1.0)),
)
FULL = (
    Column("strength", "strength", words=True),
    Column("V [MN]", _mega("V_N")),
    Column("direction [deg]", "direction_deg"),
    TORSION[0],
    Column("H [MN]", _mega("H_N")),
    Column("M [MN m]", _mega("M_Nm")),
    TORSION[1],
    Column("criterion", "criterion", words=True),
    Column("u [mm]", _motion("u_m"), factor=1e3),
    Column("rotation [deg]", _motion("rotation_rad"), 3, math.degrees(1.0)),
    TORSION[2],
)
ERROR = Column("mesh error [%]", MESH_ERROR, 2)
MACRO = (
    Column("macro-model H [MN]", _mega("H_macro_N")),
    Column("M [MN m]", _mega("M_macro_Nm")),
    Column("criterion", lambda row: row["criterion_macro"] or "-", words=True),
    Column("difference [%]", "difference_pct", "+.1f"),
)


def _remark(row: Row) -> str:
    off = bool(row["off_load"])
    unknown = bool(np.isnan(row["utilisation"])) and not off
    texts = [
        "no envelope at this V" * off,
        "no capacity in its direction" * unknown,
        "upper bound" * row["upper_bound"],
    ]
    texts.append(row["remarks"])
    return ", ".join(filter(None, texts))


CASES = (
    Column("case", "name", words=True),
    Column("limit state", "limit_state", words=True),
    Column("strength", "strength", words=True),
    Column("H [MN]", _mega("H_N")),
    Column("M [MN m]", _mega("M_Nm")),
    TORSION[1],
    Column("V [MN]", _mega("V_N")),
    Column("utilisation", "utilisation", 3),
    Column("", _remark, words=True),
)
CRITERIA = (
    "Capacity is the largest load along its direction. peak: the load falls behind it; plateau: 1 % more displacement "
    "adds less than 0.02 % to the load at the end; displacement limit: the largest load up to the limit of motion "
    "({motion}), where it still grows; stopped before failure: the run ended earlier, or the water would cavitate, the "
    "capacity is larger."
)
DIRECTIONS = "direction: angle in the plane of H and M/D; M is about the lid centre at mudline, M = H arm."
WITH_TORSION = (
    " torsion: angle of the load out of that plane towards T/D; at 90 it is T alone. Springs have no such capacity."
)
OF_MESH = " mesh error: what is left of it, of loads from two meshes, with torsion of one; '-': of one mesh, not known."


def criteria(outcome: Capacity) -> str:
    """Return what makes a load the capacity."""
    limit = outcome.scene.limit
    share = f"{100.0 * limit.displacement_over_diameter:g} % of the diameter"
    return CRITERIA.format(motion=f"{share} or {math.degrees(limit.rotation):g} deg")


def table_of(outcome: Capacity) -> Table:
    """Return the capacities as a table; without the columns of torsion or of a macro-model where there is none."""
    rows = outcome.table.to_dict("records")
    both, turned = any(row["criterion_macro"] for row in rows), any(row["torsion_deg"] for row in rows)
    every = (*FULL, ERROR, *MACRO * both)
    columns = tuple(each for each in every if turned or each not in TORSION)
    return Table.of(columns, rows, note=DIRECTIONS + WITH_TORSION * turned + OF_MESH, wide=True)


def table_of_cases(cases: pd.DataFrame) -> Table:
    """Return the load cases as a table; without the column of torsion where there is none."""
    rows = cases.to_dict("records")
    turned = any(row["T_Nm"] for row in rows)
    every = (*CASES[:-1], ERROR, CASES[-1])
    return Table.of([each for each in every if turned or each not in TORSION], rows, wide=True)


def closing(table: pd.DataFrame) -> str:
    """Return a sentence on the difference of the models; empty where none is known."""
    known = table["difference_pct"].dropna()
    if not len(known):
        return ""
    return (
        f"macro-model against full model in {len(known)} of {(table['torsion_deg'] == 0.0).sum()} directions: "
        f"{known.min():+.1f} to {known.max():+.1f} %"
    )
