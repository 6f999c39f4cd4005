# SPDX-License-Identifier: MIT
"""The claims: verdicts follow the figures, and turn when the figures do."""

from collections.abc import Callable

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from tests.support import synthetic
from validation.paper import claims, claims_drained, text
from validation.paper.findings import AGREES, DIFFERS, PARTLY, UNKNOWN, Finding
from validation.paper.runs import path_of

NAMES = ("drained", "drained-smooth", "slow", "slow-smooth", "fast", "fast-smooth")


@pytest.fixture(scope="module")
def base() -> xr.Dataset:
    """A path on invented reactions, with a plug that follows and a wedge that rises."""
    tree = synthetic.make_result((synthetic.Path("pull", size=20e-3, steps=40),))
    tree.attrs |= {"outer_diameter_m": 7.8, "skirt_length_m": 4.0}
    path = path_of(tree)
    front = (path["section_x"] > 3.8).astype(float)
    return path.assign(section_uz=path["section_uz"] * (1.0 - front) - 0.1 * path["u"] * front)


@pytest.fixture
def paths(base: xr.Dataset) -> dict[str, xr.Dataset]:
    found = {name: base.copy(deep=True) for name in NAMES}
    for name in NAMES:
        if name.endswith("smooth"):
            found[name]["H"] = 0.5 * found[name]["H"]
        if not name.startswith("drained"):
            found[name]["H"] = found[name]["H"] * (1.0 + np.maximum(base["u"] - 2e-3, 0.0) * 5.0)
            found[name]["F_pw"] = -1e7 * base["u"]
            found[name]["pore_pressure"] = found[name]["pore_pressure"] - 1e6 * base["u"]
            found[name]["p"] = found[name]["p"] * (1.0 + 0.1 * (base["depth"] > 0.5))
    return found


def verdict(paths: dict[str, xr.Dataset], number: int) -> str:
    return claims.CLAIMS[number - 1].measure(paths).verdict


def test_there_are_thirteen_and_each_has_a_criterion() -> None:
    assert [claim.number for claim in claims.CLAIMS] == list(range(1, 14))
    assert all(claim.criterion and claim.words and set(claim.needs) <= set(NAMES) for claim in claims.CLAIMS)


@pytest.mark.parametrize(
    ("holds", "expected"),
    [
        ((True, True), AGREES),
        ((True, False), PARTLY),
        ((False, False), DIFFERS),
        ((True, None), UNKNOWN),
        ((), UNKNOWN),
    ],
)
def test_verdicts(holds: tuple[bool | None, ...], expected: str) -> None:
    assert Finding("", holds).verdict == expected


def test_a_missing_run_is_named_and_nothing_is_claimed(paths: dict[str, xr.Dataset]) -> None:
    table = claims.assess({"drained": paths["drained"]}).set_index("number")
    assert table.loc[12, "verdict"] == UNKNOWN
    assert table.loc[12, "figure"] == "needs the run slow, fast"
    assert table.loc[4, "verdict"] != UNKNOWN
    assert (claims.assess({})["verdict"] == UNKNOWN).all()


def test_a_run_that_stopped_early_is_said(paths: dict[str, xr.Dataset]) -> None:
    short = {name: path.isel(step=slice(0, 5)) for name, path in paths.items()}
    table = claims.assess(short)
    assert (table["verdict"] == UNKNOWN).sum() >= 12
    assert table["figure"].str.contains("-: a run stopped before it", regex=False).any()
    assert not table["figure"].str.contains(r"\bnan\b").any()


def _turn(name: str, change: Callable[[xr.Dataset], xr.Dataset]) -> Callable[[dict[str, xr.Dataset]], None]:
    def apply(paths: dict[str, xr.Dataset]) -> None:
        paths[name] = change(paths[name])

    return apply


def _at_azimuth(name: str, station: int, values: float) -> Callable[[xr.Dataset], xr.Dataset]:
    def change(path: xr.Dataset) -> xr.Dataset:
        field = path[name].copy()
        field[{"azimuth": station, "step": slice(1, None)}] = values
        return path.assign({name: field})

    return change


# number of a claim, a change of the invented runs, the verdict that it must give
TURNS = [
    (1, _turn("drained", lambda p: p.assign(H=1e9 * np.minimum(p["u"], 2e-3) + 1e7 * p["u"])), AGREES),
    (1, _turn("drained", lambda p: p.assign(H=1e9 * p["u"] ** 0.5)), DIFFERS),
    (2, _turn("drained", lambda p: p.assign(normal_effective_stress=1.5 * p["normal_effective_stress"][0] + 0 * p[
        "normal_effective_stress"] - 0.5 * p["normal_effective_stress"][0] * (p["u"] == 0.0))), AGREES),
    (2, _turn("drained", lambda p: p.assign(normal_effective_stress=p["normal_effective_stress"][0] + 0 * p[
        "normal_effective_stress"])), DIFFERS),
    (4, _turn("drained", _at_azimuth("shear_lateral", 0, 5e5)), DIFFERS),
    (12, _turn("fast", lambda p: p.assign(H=1.5 * p["H"])), DIFFERS),
    (12, _turn("fast", lambda p: p.assign(H=1.1 * p["H"])), AGREES),
    (13, lambda paths: None, AGREES),
    (13, _turn("drained-smooth", lambda p: p.assign(H=1.9 * p["H"])), PARTLY),
    (8, lambda paths: None, AGREES),
    (8, _turn("slow", lambda p: p.assign(H=1.2 * p["H"])), PARTLY),
    (9, lambda paths: None, AGREES),
    (9, _turn("slow", lambda p: p.assign(F_pw=-p["F_pw"])), PARTLY),
    (9, _turn("slow", lambda p: p.assign(F_pw=0 * p["F_pw"], pore_pressure=0 * p["pore_pressure"])), DIFFERS),
]  # fmt: skip


@pytest.mark.parametrize(("number", "turn", "expected"), TURNS, ids=[f"{t[0]}-{t[2]}" for t in TURNS])
def test_verdicts_turn_with_the_figures(
    paths: dict[str, xr.Dataset], number: int, turn: Callable[[dict[str, xr.Dataset]], None], expected: str
) -> None:
    turn(paths)
    assert verdict(paths, number) == expected


def test_a_gap_behind_is_found(paths: dict[str, xr.Dataset]) -> None:
    drained = paths["drained"]
    for name, value in (("normal_effective_stress", 0.0), ("shear_lateral", 0.0), ("shear_vertical", 0.0)):
        drained = _at_azimuth(name, -1, value)(drained)
    gap = drained["gap"] * 0.0
    gap[{"azimuth": -1, "side": 0}] = (np.maximum(drained["u"] - 1e-3, 0.0) * (1.0 - drained["depth"] / 5.0)).transpose(
        "step", "depth"
    )
    paths["drained"] = drained.assign(gap=gap)
    assert verdict(paths, 3) == AGREES
    paths["drained"] = drained.assign(gap=gap[{"depth": slice(None, None, -1)}].assign_coords(depth=gap["depth"]))
    assert verdict(paths, 3) == PARTLY


def test_the_plug_follows_by_its_share(base: xr.Dataset) -> None:
    assert claims_drained.plug_motion(base) == pytest.approx(1.0, abs=1e-9)
    assert claims_drained.plug_motion(base.assign(section_ux=0.5 * base["section_ux"])) == pytest.approx(0.5, abs=1e-9)
    # shares that fall with depth: least squares over the nodes of the axis, from mudline to tip, by their spacing
    z = np.unique(base["section_depth"].values[base["section_depth"].values <= 4.0])
    u, rotation = (float(np.interp(2.5e-3, base["u"], base[name])) for name in ("u", "rotation"))
    assert len(z) > 4 and z[-1] == 4.0
    rigid, share = 0.0, 0.0
    for k, depth in enumerate(z):
        spacing = (z[min(k + 1, len(z) - 1)] - z[max(k - 1, 0)]) / (1 if k in (0, len(z) - 1) else 2)
        motion = u - rotation * depth
        rigid, share = rigid + spacing * motion**2, share + spacing * motion**2 * (1.0 - 0.1 * depth)
    falling = base.assign(section_ux=base["section_ux"] * (1.0 - 0.1 * base["section_depth"]))
    assert claims_drained.plug_motion(falling) == pytest.approx(share / rigid, rel=1e-9)


def test_soil_in_front(base: xr.Dataset) -> None:
    still = base.assign(section_ux=0.0 * base["section_ux"] + base["u"] * (1.0 - base["section_depth"] / 12.0))
    assert claims_drained.front_motion(still, 3.9, 3.0) == pytest.approx(2.5e-3 * 0.75, rel=1e-6)
    assert claims_drained.front_heave(base, 3.9) == pytest.approx(0.25e-3, rel=1e-6)


def test_table_for_people(paths: dict[str, xr.Dataset]) -> None:
    table = claims.assess(paths)
    lines = text.claim_lines(table)
    assert lines[0].lstrip().startswith("1  ")
    counts = pd.Series(table["verdict"]).value_counts()
    assert lines[-1] == ", ".join(f"{counts[name]} {name}" for name in counts.index)
    page = text.claims_markdown(table)
    assert page.count("\n") == 15
    assert all(line.count(" | ") == 5 for line in page.splitlines()[2:])
