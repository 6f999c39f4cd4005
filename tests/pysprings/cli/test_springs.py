# SPDX-License-Identifier: MIT
"""`springs` and `compare` on synthetic springs; `export` is in results/test_exporter_plugins.py."""

import json
from pathlib import Path

import pytest

from pysprings.core.storage import write_tree
from pysprings.macro.comparison import compare
from pysprings.springs.checks import extract_springs, open_springs, save_springs
from tests.support import tiny
from tests.support.commands import command


def test_springs_to_stdout(springs_file: Path) -> None:
    for result in (springs_file, springs_file.parent):
        done = command("springs", result)
        assert (done.code, done.err) == (0, "")
        assert done.out.startswith("path,family,depth_m,depth_top_m,depth_bottom_m,side,component,step,y_m,p_N_per_m")
    assert "pull" in json.loads(command("springs", springs_file, "--format", "json").out)["paths"]
    assert command("springs", springs_file, "--wide").out.startswith("path,step,converged,rotation_rad,w_m,y_m z=0 [")
    assert command("springs", springs_file, "--json").out == command("springs", springs_file, "--format", "json").out


def test_springs_to_files(springs_file: Path) -> None:
    for args in (
        ["--out", "a.csv"],
        ["--out", "b.xlsx"],
        ["--out", "c.nc"],
        ["--wide", "--out", "w.csv"],
        ["--format", "json", "--out", "d.txt"],
    ):
        done = command("springs", springs_file, *args)
        assert (done.code, done.out) == (0, args[-1] + "\n")
        assert Path(args[-1]).stat().st_size > 100
    assert open_springs("c.nc").equals(open_springs(springs_file))
    assert json.loads(Path("d.txt").read_text())


def test_springs_of_a_full_model_file() -> None:
    write_tree(tiny.result(), Path("full_model.nc"))
    save_springs(extract_springs(tiny.result()), Path("springs.nc"))
    from_model, from_springs = (command("springs", file) for file in ("full_model.nc", "springs.nc"))
    assert from_model.code == 0
    assert from_model.out == from_springs.out


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["no.nc"], "no.nc: no such file"),
        (["empty"], "empty: no springs.nc in this folder; is it a result of `pysprings run`?"),
        (["caisson.toml"], "caisson.toml: not a NetCDF-4 file (of a run: springs.nc or full_model.nc, or its folder)"),
        (["results", "--format", "xlsx"], "--out: the format xlsx needs a file"),
        (["results", "--format", "nc"], "--out: the format nc needs a file"),
        (
            ["results", "--out", "x.foo"],
            "x.foo: --out: no format is known for 'foo'; give --format csv|wide|xlsx|nc|json",
        ),
        (["results", "--wide", "--format", "json"], "--wide: is a form of csv, not of json"),
        (["results", "--format", "csv", "--out", "empty"], "empty: --out: is a folder, not a file"),
    ],
)
def test_springs_refuses(springs_file: Path, args: list[str], message: str) -> None:
    Path("empty").mkdir()
    Path("caisson.toml").write_text('title = "test"\n')
    done = command("springs", *args)
    assert (done.code, done.out, done.err) == (2, "", f"fatal: user input: {message}\n")


def test_compare(springs_file: Path) -> None:
    table = compare(open_springs(springs_file))
    rows = json.loads(command("compare", springs_file, "--json").out)["rows"]
    assert [(row["path"], row["springs"]) for row in rows] == [("pull", "py"), ("pull", "full")]
    for name in ("eta_large", "H_error_max_pct"):
        assert [row[name] for row in rows] == pytest.approx(table[name].tolist(), abs=1e-12)
    done = command("compare", springs_file.parent)
    assert (done.code, done.err) == (0, "")
    assert all(f"{row['eta_large']:.4f}" in done.out for row in rows)
