# SPDX-License-Identifier: MIT
"""Spring files, damaged, through `pysprings predict, compare, springs`: a finite answer, or a refusal."""

from pathlib import Path

import pytest
import xarray as xr
from hypothesis import given, strategies as st

from tests.fuzz.judge import run
from tests.fuzz.mutate import QUICK, Op, budget
from tests.fuzz.netcdf import (
    IN_PLACE,
    base_file,
    copy_of,
    new_file,
    raw_ops,
    save,
    spoil_bytes,
    spoil_in_place,
    spoiled_trees,
)

TREES, BYTES = "spring files (NetCDF), damaged as data", "spring files (NetCDF), damaged as bytes"
PREDICT = [
    ["predict", "--H", "100 kN", "--arm", "2 m", "--json"],
    ["predict", "--u-max", "5 mm", "--points", "5", "--json"],
    ["predict", "--u", "1 mm", "--rotation", "0.1 mrad", "--json"],
    ["predict", "--H", "100 kN", "--springs", "full", "--strict", "--json"],
    ["predict", "--H", "100 kN", "--springs", "pisa", "--stiffness", "--json"],
    ["predict", "--H", "100 kN", "--springs", "py", "--path", "pull", "--json"],
    ["predict", "--H", "100 kN", "--V", "3 MN", "--json"],
    ["predict", "--H", "100 kN", "--rate", "1 mm/s", "--json"],
    ["springs", "--format", "csv"],
    ["springs", "--json"],
]
SLOWER = [["compare"], ["compare", "--json"], ["springs", "--out", "out.xlsx"], ["springs", "--out", "out.nc"]]
questions = st.integers(0, 11).flatmap(lambda n: st.sampled_from(PREDICT if n else SLOWER))


def ask(kind: str, folder: Path, file: Path, asked: list[str]) -> None:
    command, *options = [str(folder / word) if word.startswith("out.") else word for word in asked]
    run(kind, folder, command, file, *options)


def ask_of_bytes(folder: Path, todo: list[Op], in_place: str, asked: list[str]) -> None:
    file = copy_of(base_file(folder), new_file(folder))
    if in_place:
        spoil_in_place(file, in_place, todo[0][2])
    else:
        spoil_bytes(file, todo)
    ask(BYTES, folder, file, asked)


in_place = st.integers(0, 7).flatmap(lambda n: st.just("") if n else st.sampled_from(IN_PLACE))


@pytest.mark.long
@budget(1100)
@given(data=spoiled_trees(), asked=questions)
def test_many_spoiled_trees(tmp_path: Path, data: dict[str, xr.Dataset], asked: list[str]) -> None:
    file = new_file(tmp_path)
    if save(data, file):
        ask(TREES, tmp_path, file, asked)


@budget(QUICK)
@given(todo=raw_ops, place=in_place, asked=questions)
def test_spoiled_bytes(tmp_path: Path, todo: list[Op], place: str, asked: list[str]) -> None:
    ask_of_bytes(tmp_path, todo, place, asked)


@pytest.mark.long
@budget(1000)
@given(todo=raw_ops, place=in_place, asked=questions)
def test_many_spoiled_bytes(tmp_path: Path, todo: list[Op], place: str, asked: list[str]) -> None:
    ask_of_bytes(tmp_path, todo, place, asked)
