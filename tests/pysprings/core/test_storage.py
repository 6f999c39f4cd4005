# SPDX-License-Identifier: MIT
"""Files are whole or absent, come back as they were, and foreign files are refused in one line."""

import errno
import os
import signal
import subprocess
import sys

import netCDF4
import numpy as np
import pytest
import xarray as xr
from xarray.backends.locks import CombinedLock
from xlsxwriter.exceptions import FileCreateError

from pysprings.cli.support import interruptible
from pysprings.core.errors import ResourceError, UserInputError
from pysprings.core.storage import leftovers, read_tree, replacing, write_attribute, write_text, write_tree
from tests.support.commands import command
from tests.support.synthetic import make_result, make_springs


def test_result_comes_back_identical(tmp_path):
    tree = make_result()
    assert read_tree(write_tree(tree, tmp_path / "full_model.nc")).identical(tree)


def test_plain_xarray_reads_the_file_and_keeps_seconds(tmp_path):
    file = write_tree(make_result(), tmp_path / "full_model.nc")
    with xr.open_dataset(file, group="paths/pull") as data:
        assert data["time"].dtype.kind == "f"
        assert float(data["depth"][-1]) == 4.0


def test_a_file_that_another_reader_holds_open_is_read(tmp_path):
    """The second open file crashed Python (netCDF 4.10.1): as where a notebook has it open in xarray."""
    file = write_tree(make_springs(), tmp_path / "springs.nc")
    script = (
        "import sys, netCDF4\nfrom pysprings.core.storage import read_tree\n"
        "with netCDF4.Dataset(sys.argv[1]):\n    trees = [read_tree(sys.argv[1]) for _ in range(5)]\n"
    )
    assert subprocess.run([sys.executable, "-c", script, str(file)]).returncode == 0


def test_indexes_of_texts_have_the_type_that_xarray_gives_them(tmp_path):
    file = write_tree(make_result(), tmp_path / "full_model.nc")
    with xr.open_datatree(file, engine="netcdf4", decode_timedelta=False) as tree:
        for node in tree.load().subtree:
            own, others = (
                {n: v.dtype for n, v in each.variables.items()} for each in (read_tree(file)[node.path], node)
            )
            assert own == others


def test_large_arrays_are_compressed_and_coordinates_have_no_fill_value(tmp_path):
    tree = make_springs()
    tree["paths/pull"]["long"] = xr.DataArray(np.zeros(2048), dims="station")
    file = write_tree(tree, tmp_path / "springs.nc")
    with netCDF4.Dataset(file) as data:
        group = data["paths/pull"]
        assert group["long"].filters()["zlib"] and not group["H"].filters()["zlib"]
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


def test_a_workbook_on_a_full_disk_is_an_error_of_the_system(tmp_path):
    with pytest.raises(OSError, match=r"No space left on device: '.*a\.xlsx'"), replacing(tmp_path / "a.xlsx"):
        raise FileCreateError(OSError(errno.ENOSPC, "No space left on device"))
    with pytest.raises(PermissionError) as refused, replacing(tmp_path / "b.csv") as temporary:
        raise PermissionError(errno.EACCES, "Permission denied", str(temporary))
    assert refused.value.filename == str(tmp_path / "b.csv")  # not the file beside it


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


# --- files that have changed since they were written ---


def _flipped(file, position):
    data = bytearray(file.read_bytes())
    data[position] ^= 16
    file.write_bytes(data)
    return file


def _refused(file):
    with pytest.raises(UserInputError) as caught:
        read_tree(file)
    (problem,) = caught.value.problems
    return problem.message


def test_one_wrong_bit_is_told_before_hdf5_sees_it(tmp_path, monkeypatch):
    whole = write_tree(make_springs(), tmp_path / "springs.nc").read_bytes()
    monkeypatch.setattr(netCDF4, "Dataset", None)
    for position in np.random.default_rng(0).integers(8, len(whole) - 84, 200):  # behind the signature
        (tmp_path / "springs.nc").write_bytes(whole)
        assert "its bytes have changed" in _refused(_flipped(tmp_path / "springs.nc", position))


@pytest.mark.parametrize("cut", [84, 85, 500, 5000, 30000])
def test_a_file_cut_short_is_refused(tmp_path, cut):
    file = write_tree(make_springs(), tmp_path / "springs.nc")
    file.write_bytes(file.read_bytes()[:-cut])
    assert "broken or incomplete NetCDF file" in _refused(file)


@pytest.mark.filterwarnings("ignore:.*no checksum at its end")
def test_a_file_without_its_last_line_is_whole(tmp_path):
    tree = make_springs()
    file = write_tree(tree, tmp_path / "springs.nc")
    whole = file.read_bytes()
    for cut in (1, 40, 83):
        file.write_bytes(whole[:-cut])
        assert read_tree(file).identical(tree)


def test_a_file_that_another_program_has_changed_or_written_is_read_with_a_warning(tmp_path):
    file = write_tree(make_springs(), tmp_path / "springs.nc")
    with netCDF4.Dataset(file, "a") as data:
        data["paths/pull/u"][3] = 0.1
        data.setncattr("remark", "x" * 5000)
    with pytest.warns(UserWarning, match=r"springs\.nc: no checksum at its end: written or changed by another program"):
        tree = read_tree(file)
    assert float(tree["paths/pull/u"][3]) == 0.1
    tree.to_netcdf(tmp_path / "c.nc", engine="netcdf4")
    with pytest.warns(UserWarning, match="taken as it is"):
        read_tree(tmp_path / "c.nc")
    assert read_tree(write_tree(tree, tmp_path / "b.nc")).identical(tree)


@pytest.mark.filterwarnings("ignore:.*no checksum at its end")
def test_strict_refuses_a_file_that_another_program_has_changed(tmp_path):
    file = write_tree(make_springs(), tmp_path / "springs.nc")
    with netCDF4.Dataset(file, "a") as data:
        data["stiffness_initial"][0, 0] = 2.0 * data["stiffness_initial"][0, 0]
    strict = command("predict", file, "--H", "1 kN", "--strict")
    assert strict.code == 2 and "--strict: no checksum at its end" in strict.err


# --- full disks ---


def test_a_full_disk_is_a_resource_that_is_missing(tmp_path):
    """A limit on the size of files stands for the disk; the old file and no other stays."""
    resource = pytest.importorskip("resource")
    old = write_text("old", tmp_path / "springs.nc")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (8192, before[1]))
    try:
        with pytest.raises(ResourceError, match=r"springs\.nc: cannot be written \(.*MB are free on the disk.*\)"):
            write_tree(make_springs(), old)
        with pytest.raises(OSError, match=r"springs\.nc"):
            write_text("x" * 10000, old)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert old.read_text() == "old"
    assert [file.name for file in tmp_path.iterdir()] == ["springs.nc"]


@pytest.mark.skipif(os.name == "nt", reason="signals are different there")
@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_waits_until_a_file_is_whole(tmp_path, monkeypatch, kind):
    """One that comes while xarray takes its locks would leave them taken; a reader holds one of its own."""

    groups = []

    def killed(function, then):
        return lambda *arguments, **options: (os.kill(os.getpid(), kind), then(), function(*arguments, **options))[2]

    monkeypatch.setattr(CombinedLock, "__enter__", killed(CombinedLock.__enter__, list))
    monkeypatch.setattr(xr, "decode_cf", killed(xr.decode_cf, lambda: groups.append(1)))
    for call in (lambda: write_tree(make_springs(), tmp_path / "a.nc"), lambda: read_tree(tmp_path / "a.nc")):
        with interruptible(), pytest.raises(KeyboardInterrupt):
            call()
    monkeypatch.undo()
    assert len(groups) == len(list(make_springs().subtree))  # read to the end
    write_attribute("title", "another", tmp_path / "a.nc")
    again = read_tree(tmp_path / "a.nc")
    assert again.attrs["title"] == "another"
    xr.testing.assert_equal(again, make_springs())


def test_temporary_files_of_the_dead_are_known_by_their_names(tmp_path):
    with replacing(tmp_path / "springs.nc") as temporary:
        temporary.write_text("half")
        for name in (".hidden", ".profile.tmp", "a.tmp.nc"):
            (tmp_path / name).write_text("somebody's")
        assert leftovers(tmp_path) == [temporary]
