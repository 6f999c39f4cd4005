# SPDX-License-Identifier: MIT
"""Every number of the tables, files and sheets that users read, against plain loops over the stations of a mesh."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pandas as pd
import pytest
import xarray as xr

from pysprings.macro.comparison import compare
from pysprings.results.exporters.tables import LOAD_DISPLACEMENT, PY_COLUMNS
from pysprings.springs.checks import extract_springs, open_springs, save_springs
from tests.support import raw_caisson as rc, written
from tests.support.raw_caisson import GROWTH, LENGTH, PATHS, STEPS, raw

WORDS = {"outside": ("outside",), "inside": ("inside",), "net": ("outside", "inside")}
PARTS = {"normal": ("normal",), "shear": ("shear",), "water": ("water",), "total": ("normal", "shear", "water")}
MOTION = ("u", "w", "rotation")


def converged(path: str, step: int) -> int:
    return int((path, step) != ("slide", STEPS - 1))


@pytest.fixture(scope="module")
def springs() -> xr.DataTree:
    return extract_springs(rc.result())


@pytest.fixture(scope="module")
def folder(springs: xr.DataTree, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder: Path = tmp_path_factory.mktemp("numbers")
    written.all_tables(folder, springs, rc.result(), compare(springs))
    written.workbook(folder / "springs.xlsx", springs)
    return folder


def close(found: Any, expected: Any, size: float = 1.0, what: str = "") -> None:
    """Equal to nine digits, of a quantity whose rounding is beside ``size``."""
    np.testing.assert_allclose(
        np.asarray(found, dtype=float), np.asarray(expected, dtype=float), rtol=1e-8, atol=1e-9 * size, err_msg=what
    )


@cache
def slices() -> dict[float, tuple[float, float, list[tuple[float, float, float]]]]:
    """Top, bottom and (ring, share, arm) of the slices of tables by depth: those of the rings, the last fifth as one.

    A thin rest above it joins the slice above.
    """
    zone, out = 0.8 * LENGTH, {}
    tops = [top for top, _ in map(rc.slice_of, rc.depths()) if top <= zone - 0.05 * LENGTH]
    for top, bottom in zip([*tops, zone], [*tops[1:], zone, LENGTH], strict=True):
        cut = {z: (max(top, rc.slice_of(z)[0]), min(bottom, rc.slice_of(z)[1])) for z in rc.depths()}
        cut = {z: each for z, each in cut.items() if each[1] - each[0] > 1e-9}
        whole = [z for z, each in cut.items() if np.allclose(each, (top, bottom)) and np.allclose(rc.slice_of(z), each)]
        at = whole[0] if whole else 0.5 * (top + bottom)
        parts = [
            (z, (low - high) / (bottom - top), 0.5 * (low + high) + z - np.mean(rc.slice_of(z)) - at)
            for z, (high, low) in cut.items()
        ]
        out[at] = top, bottom, parts
    return out


def in_slice(now: dict, side: str, at: float) -> dict[str, float]:
    """Return the reactions of a side in a slice: means of its rings; m takes the moment of p about its depth."""
    rings = [(now["ring"][side, z], share, arm) for z, share, arm in slices()[at][2]]
    out = {key: sum(share * ring[key] for ring, share, _ in rings) for key in (*PARTS["total"], "m", "t")}
    out["m"] -= sum(share * arm * sum(ring[key] for key in PARTS["total"]) for ring, share, arm in rings)
    return out


# --- load_displacement.csv ---


def load_row(path: str, step: int) -> dict[str, Any]:
    now, first = raw(path, step), raw(path, 0)
    row: dict[str, Any] = {"path": path, "step": step, "time_s": 60.0 * GROWTH[step]}
    row |= {"u_m": now["motion"]["u"], "w_m": now["motion"]["w"], "rotation_rad": now["motion"]["rotation"]}
    row |= {"H_N": now["total"]["H"], "V_N": now["total"]["V"], "M_Nm": now["total"]["M"]}
    row |= {f"H_{face}_N": now["on"][face]["H"] for face in ("outer", "inner", "lid", "tip")}
    row |= {"F_pw_N": now["motion"]["F_pw"], "converged": converged(path, step)}
    row |= {
        f"F_{word}_N": now["on"][face]["V"] - first["on"][face]["V"]
        for word, face in (("in", "inner"), ("out", "outer"))
    }
    return row


def test_every_column_of_load_displacement(folder: Path) -> None:
    table = pd.read_csv(folder / "load_displacement.csv")
    expected = pd.DataFrame([load_row(path, step) for path in PATHS for step in range(STEPS)])
    assert set(table.columns) == set(expected.columns) == {"path", "step", *LOAD_DISPLACEMENT}
    assert table["path"].tolist() == expected["path"].tolist()
    for name in LOAD_DISPLACEMENT:
        scale = 1e6 if name.endswith(("_N", "_Nm")) else 1.0
        close(table[name], expected[name], scale if scale > 1.0 else 1e-3, name)
    different = expected.drop(columns=["path", "step", "converged"]).T.round(12).drop_duplicates()
    assert len(different) == expected.shape[1] - 3  # no two columns are alike: one cannot stand for another


# --- py.csv and py_wide.csv ---


def long_rows(path: str) -> Iterator[dict[str, Any]]:
    for step in range(STEPS):
        now = raw(path, step)
        u, w, rotation = (now["motion"][key] for key in MOTION)
        body = {"path": path, "step": step, "rotation_rad": rotation, "w_m": w, "converged": converged(path, step)}
        for z, (top, bottom, _) in slices().items():
            place = body | {"depth_m": z, "depth_top_m": top, "depth_bottom_m": bottom, "y_m": u - rotation * z}
            for side, sides in WORDS.items():
                rings = [in_slice(now, one, z) for one in sides]
                m, t = (sum(ring[key] for ring in rings) for key in ("m", "t"))
                if path == "down":
                    yield place | {"family": "tz", "side": side, "t_N_per_m": t}
                    continue
                yield place | {"family": "mtheta", "side": side, "m_Nm_per_m": m, "t_N_per_m": t}
                for component, parts in PARTS.items():
                    p = sum(ring[part] for ring in rings for part in parts)
                    yield place | {"family": "py", "side": side, "component": component, "p_N_per_m": p}
        for family, face, z in (("base", "tip", LENGTH), ("lid", "lid", 0.0)):
            place = body | {"depth_m": z, "depth_top_m": z, "depth_bottom_m": z, "y_m": u - rotation * z}
            loads = now["on"][face]
            yield place | {"family": family, "H_N": loads["H"], "V_N": loads["V"], "M_Nm": loads["M"]}


WIDE = {"y_m": (), "p_N_per_m": PARTS["total"], "m_Nm_per_m": ("m",), "t_N_per_m": ("t",)}
NAMES = ["path", "family", "depth_m", "side", "component", "step"]


def test_every_row_of_py_csv(folder: Path) -> None:
    table = pd.read_csv(folder / "py.csv")
    rows = [row for path in PATHS for row in long_rows(path)]
    expected = pd.DataFrame(rows).reindex(columns=PY_COLUMNS)
    assert len(table) == len(expected) > 500
    sort = {"by": NAMES, "na_position": "first", "ignore_index": True}
    found, wanted = (each.sort_values(**sort) for each in (table.round({"depth_m": 9}), expected.round({"depth_m": 9})))
    for name in NAMES:
        assert found[name].fillna("").tolist() == wanted[name].fillna("").tolist(), name
    for name in PY_COLUMNS:
        if name not in NAMES:
            size = 1e6 if "N" in name else 1e-3
            close(found[name].fillna(-1.0), wanted[name].astype(float).fillna(-1.0), size, name)


def test_every_column_of_py_wide_csv(folder: Path) -> None:
    table = pd.read_csv(folder / "py_wide.csv")
    assert table[["path", "step"]].values.tolist() == [[path, step] for path in PATHS for step in range(STEPS)]
    seen = ["path", "step"]
    for column, key in (("rotation_rad", "rotation"), ("w_m", "w")):
        close(table[column], [raw(p, s)["motion"][key] for p in PATHS for s in range(STEPS)], 1e-3, column)
        seen.append(column)
    assert table["converged"].tolist() == [converged(p, s) for p in PATHS for s in range(STEPS)]
    down = np.array([p == "down" for p in PATHS for _ in range(STEPS)])
    for z, (top, bottom, _) in slices().items():
        states = [(raw(p, s), raw(p, s)["motion"]) for p in PATHS for s in range(STEPS)]
        for quantity, parts in WIDE.items():
            heading = f"{quantity} z={z:g} [{top:g}..{bottom:g}]"
            expected = np.array([
                sum(in_slice(now, side, z)[part] for side in WORDS["net"] for part in parts)
                if parts else body["u"] - body["rotation"] * z for now, body in states
            ])  # fmt: skip
            there = ~down | (quantity == "t_N_per_m")
            assert table[heading].notna().tolist() == there.tolist()
            close(table[heading][there], expected[there], 1e6 if parts else 1e-3, heading)
            seen.append(heading)
    for face in ("tip", "lid"):
        for load, unit in (("H", "N"), ("V", "N"), ("M", "Nm")):
            column = f"{load}_{face}_{unit}"
            close(table[column], [raw(p, s)["on"][face][load] for p in PATHS for s in range(STEPS)], 1e6, column)
            seen.append(column)
    assert sorted([*seen, "converged"]) == sorted(table.columns)


# --- the workbook ---


@pytest.fixture(scope="module")
def book(folder: Path) -> Any:
    return openpyxl.load_workbook(folder / "springs.xlsx")


def columns_of(sheet: Any) -> dict[tuple[str, Any], list[Any]]:
    """Values of a sheet by heading and depth, below its three heading rows."""
    found = {}
    for cells in sheet.iter_cols(values_only=True):
        depth = cells[0] if isinstance(cells[0], int | float) else None
        assert (cells[2], depth) not in found
        found[cells[2], depth] = list(cells[3:])
    return found


def by_step(read: Any, paths: Any = PATHS) -> list[float]:
    """A quantity of every path and step, in the order of the sheets."""
    return [read(raw(path, step)) for path in paths for step in range(STEPS)]


def expected_sheet(name: str) -> dict[tuple[str, Any], tuple[list[float], str]]:
    """Heading and depth -> values in kN, m, mm, mrad, and the defined name of the column."""
    out: dict[tuple[str, Any], tuple[list[float], str]] = {}
    paths = ["down"] if name == "t-z" else list(PATHS)

    def motion(key: str, scale: float = 1e3) -> list[float]:
        return by_step(lambda one: scale * one["motion"][key], paths)

    def ring(side: str, z: float, parts: tuple[str, ...]) -> list[float]:
        return by_step(
            lambda one: 1e-3 * sum(in_slice(one, each, z)[part] for each in WORDS[side] for part in parts), paths
        )

    for k, z in enumerate(slices(), start=1):
        if name == "p-y":
            y = by_step(lambda one, z=z: 1e3 * (one["motion"]["u"] - one["motion"]["rotation"] * z))
            out["y [mm]", z] = y, f"y_{k}"
            for side in WORDS:
                out[f"p {side} [kN/m]", z] = ring(side, z, PARTS["total"]), f"p_{k}" if side == "net" else ""
        elif name == "m-theta":
            for side in WORDS:
                out[f"m {side} [kN m/m]", z] = ring(side, z, ("m",)), f"m_{k}" if side == "net" else ""
            out["t net [kN/m]", z] = ring("net", z, ("t",)), f"t_{k}"
        elif name == "t-z":
            for side in WORDS:
                out[f"t {side} [kN/m]", z] = ring(side, z, ("t",)), f"tz_{k}" if side == "net" else ""
    if name == "m-theta":
        out |= {("rotation [mrad]", None): (motion("rotation"), "theta"), ("w [mm]", None): (motion("w"), "")}
    if name == "t-z":
        out["w [mm]", None] = motion("w"), "w_tz"
        out["V [kN]", None] = by_step(lambda one: 1e-3 * one["total"]["V"], paths), "V_tz"
        for face in ("tip", "lid"):
            out[f"V {face} [kN]", None] = by_step(lambda one, f=face: 1e-3 * one["on"][f]["V"], paths), ""
    if name in ("base", "lid"):
        face, z = ("tip", LENGTH) if name == "base" else ("lid", 0.0)
        y = by_step(lambda one: 1e3 * (one["motion"]["u"] - one["motion"]["rotation"] * z))
        out |= {("y [mm]", z): (y, f"y_{name}"), ("w [mm]", z): (motion("w"), "")}
        out["rotation [mrad]", z] = motion("rotation"), ""
        for load, unit in (("H", "kN"), ("V", "kN"), ("M", "kN m")):
            values = by_step(lambda one, load=load: 1e-3 * one["on"][face][load])
            out[f"{load} [{unit}]", z] = values, f"{load}_{name}"
    if name == "load-displacement":
        for key, unit in (("u", "mm"), ("w", "mm"), ("rotation", "mrad")):
            out[f"full model {key} [{unit}]", None] = motion(key), key
        for load, unit in (("H", "kN"), ("V", "kN"), ("M", "kN m")):
            values = by_step(lambda one, load=load: 1e-3 * one["total"][load])
            out[f"full model {load} [{unit}]", None] = values, load
    return out


@pytest.mark.parametrize("name", ["p-y", "m-theta", "t-z", "base", "lid", "load-displacement"])
def test_every_column_of_a_sheet(book: Any, name: str) -> None:
    found, expected = columns_of(book[name]), expected_sheet(name)
    paths = ["down"] if name == "t-z" else list(PATHS)
    assert found.pop(("path", None)) == [path for path in paths for _ in range(STEPS)]
    assert found.pop(("step", None)) == [step for _ in paths for step in range(STEPS)]
    assert found.pop(("converged (1 = yes)", None)) == [converged(path, k) for path in paths for k in range(STEPS)]
    found = {key: values for key, values in found.items() if not str(key[0]).startswith("macro-model")}
    assert set(found) == set(expected) and expected
    heads = [book[name].cell(row, column).value for row, column in ((1, 1), (2, 1), (3, 1), (3, 2))]
    assert heads == ["depth [m]", "slice [m]", "path", "step"]
    for key, (values, defined) in expected.items():
        close(found[key], values, 1e3, f"{name}: {key}")
        for k, path in enumerate(paths if defined else ()):
            ((sheet, cells),) = book.defined_names[f"{defined}.{path}"].destinations
            named = [cell.value for row in book[sheet][cells] for cell in row]
            close(named, values[k * STEPS : (k + 1) * STEPS], 1e3, f"{defined}.{path}")
    for column in book[name].iter_cols(min_col=3, values_only=True):
        if isinstance(column[0], float | int) and name in ("p-y", "m-theta", "t-z"):
            assert column[1] in [f"{top:.3f} - {bottom:.3f}" for at, (top, bottom, _) in slices().items()
                                 if abs(at - column[0]) < 1e-4]  # fmt: skip


def py_alone(path: str, step: int) -> tuple[float, float]:
    """H (kN) and M (kN m) of the p-y curves alone: the changes of p from the initial state, where a ring has moved."""
    force = moment = 0.0
    for z in (z for z in rc.depths() if path != "turn" or z > 0.0):
        top, bottom = rc.slice_of(z)
        change = raw(path, step)["net"][z]["p"] - raw(path, 0)["net"][z]["p"]
        force, moment = force + 1e-3 * change * (bottom - top), moment - 1e-3 * change * (bottom - top) * z
    return force, moment


def test_macro_columns_of_the_workbook(book: Any) -> None:
    """Springs of the path itself give its loads back, as changes; p-y alone gives sums of p; the rest is blank."""
    found, n = columns_of(book["load-displacement"]), STEPS - 1
    for k, path in enumerate(("slide", "turn")):
        steps = range(n) if path == "slide" else range(STEPS)
        first = k * STEPS
        start = raw(path, 0)["total"]
        for load, unit in (("H", "kN"), ("M", "kN m")):
            change = [1e-3 * (raw(path, step)["total"][load] - start[load]) for step in steps]
            alone = [py_alone(path, step)[load == "M"] for step in steps]
            for spring_set, expected in (("full", change), ("fan", change), ("py", alone)):
                cells = found[f"macro-model, {spring_set} springs: {load} [{unit}]", None][first : first + STEPS]
                close(cells[: len(steps)], expected, 1e3, f"{path} {spring_set} {load}")
                assert cells[len(steps) :] == [None] * (STEPS - len(steps))
        rotation = [1e3 * raw(path, step)["motion"]["rotation"] for step in steps]
        cells = found["macro-model, full springs: rotation [mrad]", None][first : first + len(steps)]
        close(cells, rotation, 1.0, "rotation")
    down = list(PATHS).index("down") * STEPS
    for (heading, _), values in found.items():
        if str(heading).startswith("macro-model"):
            assert values[down : down + STEPS] == [None] * STEPS, heading


def test_stiffness_sheet_of_a_matrix_that_is_not_symmetric(book: Any) -> None:
    """Both sheets hold the matrix as it is; (x, ry) and (y, -rx) alike."""
    k = rc.STIFFNESS / 1e3
    six = np.zeros((6, 6))
    for axis, turn, sign in ((0, 4, 1.0), (1, 3, -1.0)):
        six[axis, axis], six[turn, turn] = k[0, 0], k[2, 2]
        six[axis, turn], six[turn, axis] = sign * k[0, 2], sign * k[2, 0]
    six[2, 2] = k[1, 1]
    for name, expected in (("K_6x6", six), ("K_3x3", rc.STIFFNESS / 1e3)):
        ((sheet, cells),) = book.defined_names[name].destinations
        close([[cell.value or 0.0 for cell in row] for row in book[sheet][cells]], expected, 1e3, name)


def test_lengths_and_ranges_of_the_workbook(book: Any) -> None:
    lines = {str(row[0]): row[1] for row in book["About"].iter_rows(values_only=True) if row[0]}
    for name, value in (("outer diameter [m]", 7.8), ("skirt length [m]", 4.0), ("skirt thickness [m]", 0.1)):
        assert lines[name] == pytest.approx(value)
        ((sheet, cells),) = book.defined_names[name.rpartition(" ")[0].replace(" ", "_")].destinations
        assert book[sheet][cells].value == pytest.approx(value)
    turn, slide, down = (lines[f"path {name}"] for name in ("turn", "slide", "down"))
    H = max(abs(raw("turn", step)["total"]["H"]) for step in range(STEPS))
    V = raw("turn", 0)["total"]["V"]
    assert f"|u| to 0 mm, |rotation| to 1.2 mrad, |H| to {1e-3 * H:.5g} kN, V {1e-3 * V:.5g} kN" in turn
    assert f"|u| to {6.0 * GROWTH[STEPS - 2]:.4g} mm" in slide  # its last step did not converge
    ends = [1e-3 * raw("down", step)["total"]["V"] for step in (0, STEPS - 1)]
    assert f"w from 0 to 8 mm, V from {ends[0]:.5g} to {ends[1]:.5g} kN" in down


# --- springs.nc ---


def test_every_variable_of_the_springs(springs: xr.DataTree, tmp_path: Path) -> None:
    tree = open_springs(save_springs(springs, tmp_path / "springs.nc"))
    close(tree["stiffness_initial"], rc.STIFFNESS, 1e9)
    for name in PATHS:
        path = tree[f"paths/{name}"].to_dataset(inherit=False)
        seen = {"depth", "side", "component", "step"}
        np.testing.assert_allclose(path["depth"], rc.depths(), atol=1e-9)
        close(path["depth_bounds"], [rc.slice_of(z) for z in rc.depths()])
        close(path["time"], rc.times())
        assert path["converged"].values.tolist() == [converged(name, step) for step in range(STEPS)]
        for step in range(STEPS):
            now, here = raw(name, step), path.isel(step=step)
            scalars = dict(now["motion"]) | now["total"]
            scalars |= {f"{load}_{face}": now["on"][face][load] for load in "HVM" for face in ("tip", "lid")}
            scalars.pop("F_pw")
            for key, value in scalars.items():
                close(here[key], value, 1e6 if key[0] in "HVM" else 1e-3, key)
            for k, z in enumerate(rc.depths()):
                close(here["y"][k], now["motion"]["u"] - now["motion"]["rotation"] * z, 1e-3)
                for side in ("outside", "inside"):
                    ring, at = now["ring"][side, z], here.isel(depth=k).sel(side=side)
                    close(at["p_component"].sel(component=list(PARTS)[:3]), [ring[p] for p in list(PARTS)[:3]], 1e6)
                    close([at["m"], at["t"]], [ring["m"], ring["t"]], 1e6)
            seen |= set(scalars)
        margin = "cavitation_margin"  # its numbers: test_user_fields.py
        seen |= {"depth_bounds", "time", "converged", "y", "p", "p_component", "m", "t", margin}
        assert seen == set(path.variables)


# --- compare.csv ---


def area_under(x: list[float], y: list[float]) -> float:
    return sum(0.5 * (y[k] + y[k - 1]) * (x[k] - x[k - 1]) for k in range(1, len(x)))


def up_to(end: float, x: list[float], y: list[float]) -> tuple[list[float], list[float]]:
    """A curve of straight lines, cut off at x = end."""
    k = next(i for i, value in enumerate(x) if value > end)
    share = (end - x[k - 1]) / (x[k] - x[k - 1])
    return [*x[:k], end], [*y[:k], y[k - 1] + share * (y[k] - y[k - 1])]


def test_columns_of_compare_csv(folder: Path) -> None:
    """Of a path answered by its own p-y curves: sums of p beside the loads; of its full springs: no error at all."""
    table = pd.read_csv(folder / "compare.csv").set_index(["path", "springs"])
    steps = range(STEPS - 1)
    x = [raw("slide", step)["motion"]["u"] for step in steps]
    H, M, py_H, py_M = ([], [], [], [])
    for step in steps:
        total, alone = raw("slide", step)["total"], py_alone("slide", step)
        H, M = [*H, total["H"]], [*M, total["M"]]
        py_H, py_M = [*py_H, 1e3 * alone[0]], [*py_M, 1e3 * alone[1]]
    own = table.loc["slide", "py"]
    for load, full, macro in (("H", H, py_H), ("M", M, py_M)):
        errors = [100.0 * (macro[k] / full[k] - 1.0) for k in steps if k and x[k] >= 0.01 * x[-1]]
        close(own[f"{load}_error_end_pct"], errors[-1], 1e2)
        close(own[f"{load}_error_max_pct"], max(errors, key=abs), 1e2)
        unit = {"H": "N", "M": "Nm"}[load]
        close([own[f"{load}_end_full_{unit}"], own[f"{load}_end_macro_{unit}"]], [full[-1], macro[-1]], 1e6)
    apart = [abs(a - b) for a, b in zip(H, py_H, strict=True)]
    close(own["eta_large"], 1.0 - area_under(x, apart) / area_under(x, [abs(value) for value in H]))
    small = 7.8 / 1e4
    both = [up_to(small, x, curve) for curve in (H, py_H)]
    grid = both[0][0]
    apart = [abs(a - b) for a, b in zip(both[0][1], both[1][1], strict=True)]
    close(own["eta_small"], 1.0 - area_under(grid, apart) / area_under(grid, [abs(v) for v in both[0][1]]), 1.0)
    close(own["small_at"], small)
    known = {"role": "calibration", "kind": "translation", "springs_from": "slide", "status": "complete",
             "states": STEPS - 2, "skip_below": 0.01, "depths": len(rc.depths()), "extrapolated_states": 0,
             "off_path_states": 0, "off_load_states": 0}  # fmt: skip
    assert {key: own[key] for key in known} == known
    assert np.isnan(own["arm_m"])  # an imposed motion has no height of the load
    close(own["V_N"], raw("slide", 0)["total"]["V"], 1e6)
    close([own["u_end_full_m"], own["u_end_macro_m"]], [x[-1], x[-1]], 1e-3)
    assert np.isnan(own["rotation_point_full_m"]) and np.isnan(own["rotation_error_max_pct"])
    for path in ("slide", "turn"):
        for spring_set in ("full", "fan"):
            row = table.loc[path, spring_set]
            close([row["H_error_max_pct"], row["M_error_max_pct"], row["w_error_max_m"]], [0.0, 0.0, 0.0], 10.0)
            close([row["eta_large"], row["eta_small"]], [1.0, 1.0])
    assert table.loc["turn", "full"]["rotation_point_full_m"] == 0.0
    close(table.loc["turn", "full"]["small_at"], small / LENGTH)
    swept = table.loc["swept", "fan"]
    close(swept["rotation_point_full_m"], PATHS["swept"][0][0] / PATHS["swept"][0][2])
    down, last = table.loc["down", "vertical"], [raw("down", step)["total"]["V"] for step in (0, STEPS - 1)]
    close([down["V_end_full_N"], down["V_end_macro_N"], down["V_N"]], [last[1], last[1], last[0]], 1e6)
    close([down["w_end_full_m"], down["w_end_macro_m"]], [8e-3, 8e-3], 1e-3)
    assert down["springs_from"] == "down" and abs(down["V_error_max_pct"]) < 1e-6
