# SPDX-License-Identifier: MIT
"""Files are whole or absent, come back as they were, and foreign files are refused in one line."""

from __future__ import annotations

import netCDF4
import pytest
import xarray as xr

from pysprings.errors import UserInputError
from pysprings.storage import read_tree, replacing, write_text, write_tree
from tests.pysprings.synthetic import make_result, make_springs


def test_result_comes_back_identical(tmp_path):
    tree = make_result()
    assert read_tree(write_tree(tree, tmp_path / "full_model.nc")).identical(tree)


def test_plain_xarray_reads_the_file_and_keeps_seconds(tmp_path):
    file = write_tree(make_result(), tmp_path / "full_model.nc")
    with xr.open_dataset(file, group="paths/pull") as data:
        assert data["time"].dtype.kind == "f"
        assert float(data["depth"][-1]) == 4.0


def test_compressed_and_coordinates_without_fill_value(tmp_path):
    file = write_tree(make_springs(), tmp_path / "springs.nc")
    with netCDF4.Dataset(file) as data:
        group = data["paths/pull"]
        assert group["p"].filters()["zlib"]
        assert "_FillValue" not in group["depth"].ncattrs()
        assert "_FillValue" not in group["depth_bounds"].ncattrs()
        assert group["depth"].bounds == "depth_bounds"


def test_attributes_netcdf_cannot_hold_are_made_plain(tmp_path):
    tree = xr.DataTree(xr.Dataset(attrs={"flag": True, "nothing": None}))
    assert read_tree(write_tree(tree, tmp_path / "a.nc")).attrs == {"flag": 1, "nothing": ""}


def test_failed_write_keeps_the_old_file(tmp_path):
    target = write_text("old", tmp_path / "table.csv")
    with pytest.raises(RuntimeError), replacing(target) as temporary:
        temporary.write_text("half")
        raise RuntimeError
    assert target.read_text() == "old"
    assert [file.name for file in tmp_path.iterdir()] == ["table.csv"]


def _truncated(tmp_path):
    file = write_tree(make_springs(), tmp_path / "cut.nc")
    file.write_bytes(file.read_bytes()[:5000])
    return file


def _text(tmp_path):
    return write_text("depth,p\n", tmp_path / "table.nc")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda folder: folder / "none.nc", "no such file"),
        (lambda folder: folder, "is a folder"),
        (_text, "not a NetCDF-4 file"),
        (_truncated, "broken or incomplete NetCDF file"),
    ],
)
def test_foreign_and_broken_files_are_refused(tmp_path, make, words):
    file = make(tmp_path)
    with pytest.raises(UserInputError) as caught:
        read_tree(file)
    (problem,) = caught.value.problems
    assert problem.file == str(file)
    assert words in problem.message
