# SPDX-License-Identifier: MIT
"""What hostile input once got through, one test each: names, titles, sizes, archives, attributes."""

import re
import zipfile
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import openpyxl
import pytest

from pysprings import open_table
from pysprings.cli import support
from pysprings.core.columns import Table
from pysprings.core.errors import UserInputError
from pysprings.core.storage import write_tree
from pysprings.core.tables import files as reader
from pysprings.core.units import LARGEST, fault, unit_of_column
from pysprings.results.exporters.tables import PY_COLUMNS
from pysprings.results.folder import run_to_folder
from pysprings.results.report.inputs import ReportData
from pysprings.results.report.page import render
from pysprings.springs.checks import name_fault, open_springs
from tests.fuzz.tables import MINIMAL
from tests.support import synthetic, tiny, written
from tests.support.commands import command
from tests.support.watch import watched

HOSTILE = "=cmd|' /C calc'!A0 ../../x <script>alert(1)</script> & \"q\" \u202e\U0001f4a9 $x_{"


# --- texts ---


@pytest.mark.parametrize("figures", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_hostile_title_does_nothing(tmp_path: Path, figures: bool) -> None:
    """A whole run: nothing outside its folder, no markup in the report, no formula in the workbook."""
    out = tmp_path / "out"
    tiny.result()  # what is compiled is compiled
    scene = tiny.scene(title=HOSTILE, output={"figures": figures}, solver={"linear": "superlu"})
    with watched(out):
        run_to_folder(scene, out)  # not with Pardiso, which asks a linker where its library is
    assert list(tmp_path.iterdir()) == [out]
    page = (out / "report.html").read_text(encoding="utf-8")
    scripts = re.findall(r"<script[^>]*>", page)
    assert scripts == [
        '<script type="application/json" id="run-data">',
        '<script type="application/octet-stream" id="library">',
        "<script>",
    ]  # those of the report itself, which its content policy names by their digests
    assert "script-src " in page and "sha256-" in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in page
    book = openpyxl.load_workbook(out / "springs.xlsx")
    cells = [cell for sheet in book.worksheets for row in sheet.iter_rows() for cell in row]
    assert any(cell.value == HOSTILE for cell in cells)
    assert not [cell for cell in cells if cell.data_type == "f" and cell.value == HOSTILE]


def test_a_workbook_keeps_texts_that_look_like_formulas(tmp_path: Path) -> None:
    """Springs made in Python may have any names; those of a file are refused."""
    springs = synthetic.make_springs((synthetic.Path("=1+1", steps=3),), synthetic.Caisson(rings=3))
    written.workbook(tmp_path / "s.xlsx", springs)
    book = openpyxl.load_workbook(tmp_path / "s.xlsx")
    cells = [cell for cell in book["p-y"]["A"] if cell.value == "=1+1"]
    assert cells
    assert {cell.data_type for cell in cells} == {"s"}


def test_a_workbook_leaves_no_file_elsewhere(tmp_path: Path) -> None:
    with watched(tmp_path):
        written.workbook(tmp_path / "s.xlsx", synthetic.make_springs(caisson=synthetic.Caisson(rings=3)))
    assert [file.name for file in tmp_path.iterdir()] == ["s.xlsx"]


def test_a_title_does_not_steer_the_terminal(tmp_path: Path) -> None:
    (tmp_path / "c.toml").write_text(tiny.grounded('title = "a\u202eb"\n'), encoding="utf-8")
    done = command("check", tmp_path / "c.toml")
    assert done.code == 0
    assert "a\\u202eb" in done.out
    assert all(line.isprintable() for line in done.out.splitlines())


def test_messages_and_tables_do_not_steer_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    support.to_stderr("a\x1b[31mb\nc")
    support.print_table(Table("", ["x"], [["\x1b[2J"]]))
    captured = capsys.readouterr()
    assert captured.err == "a\\x1b[31mb\nc\n"
    assert captured.out.splitlines()[-1] == "\\x1b[2J"


def test_attributes_of_a_result_are_escaped_in_the_report() -> None:
    result = synthetic.make_result((synthetic.Path(steps=3),), synthetic.Caisson(rings=3))
    result.attrs["title"] = "</title><script>1</script>"
    assert "<script>" not in render(ReportData(result))


@pytest.mark.parametrize("name", ["=1+1", "@x", "+1", "-x", "..", "a/b", "a\x1bb", "x" * 61, " a"])
def test_names_that_others_misread_are_refused(tmp_path: Path, name: str) -> None:
    """In a table by its line, in a spring file by its group (where NetCDF can hold the name at all)."""
    assert name_fault(name)
    quoted = '"' + name + '"'
    (tmp_path / "t.csv").write_text("path," + MINIMAL.replace("\n", f"\n{quoted},").removesuffix(f"{quoted},"))
    (tmp_path / "t.csv").write_text("\n".join(
        f"{'path' if number == 0 else quoted},{line}" for number, line in enumerate(MINIMAL.splitlines())
    ))  # fmt: skip
    if name == " a":  # blanks around a cell do not count
        open_table(tmp_path / "t.csv")
    else:
        with pytest.raises(UserInputError, match=r"t\.csv:2: path: .*a path's name"):
            open_table(tmp_path / "t.csv")
    if "/" in name or name == "..":
        return
    springs = synthetic.make_springs((synthetic.Path(name, steps=3),), synthetic.Caisson(rings=3))
    try:
        file = write_tree(springs, tmp_path / "s.nc")
    except Exception:
        return
    with pytest.raises(UserInputError, match="a path's name"):
        open_springs(file)


@pytest.mark.parametrize("name", ["pull", "H-M 1", "1", "Zug 20 mm", "décharge"])
def test_other_names_are_welcome(name: str) -> None:
    assert name_fault(name) == ""


# --- sizes ---


@pytest.mark.parametrize(
    ("cell", "column", "words"),
    [
        ("1e308", "depth_m", "is not in [-1e+05, 1e+05] m"),
        ("1e308", "y_m", "is not in [-1e+05, 1e+05] m"),
        ("-1e300", "p_N_per_m", "is not in [-1e+15, 1e+15] N/m"),
        ("1e-320", "y_m", "is too small: at least 1e-60 m, or 0"),
        ("inf", "p_N_per_m", "is not a finite number"),
    ],
)
def test_numbers_that_nothing_has_are_refused_with_the_range(
    tmp_path: Path, cell: str, column: str, words: str
) -> None:
    rows = [line.split(",") for line in MINIMAL.splitlines()]
    rows[2][rows[0].index(column)] = cell
    (tmp_path / "t.csv").write_text("\n".join(",".join(row) for row in rows))
    with pytest.raises(UserInputError) as caught:
        open_table(tmp_path / "t.csv")
    assert f't.csv:3: {column}: "{cell}" {words}' in str(caught.value)


def test_every_column_has_a_unit_with_a_limit() -> None:
    for name in PY_COLUMNS:
        assert unit_of_column(name) in LARGEST
    assert (unit_of_column("m_Nm_per_m"), unit_of_column("M_Nm"), unit_of_column("step")) == ("N m/m", "N m", "1")
    assert fault(0.0, "m") == fault(-1e5, "m") == fault(1e-60, "rad") == ""


@pytest.mark.parametrize("option", ["--H", "--u-max", "--rotation", "--V"])
def test_options_beyond_sense_are_refused(tmp_path: Path, option: str) -> None:
    (tmp_path / "t.csv").write_text(MINIMAL)
    unit = {"--u-max": "m", "--rotation": "rad"}.get(option, "N")
    done = command("predict", tmp_path / "t.csv", option, f"1e200 {unit}")
    assert done.code == 2
    assert done.err.startswith(f'fatal: user input: {option}: "1e200 {unit}" is not in [')


def test_a_table_that_is_too_large_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "t.csv").write_text(MINIMAL)
    monkeypatch.setattr(reader, "MOST_BYTES", 50)
    with pytest.raises(UserInputError, match=r"t\.csv: is too large for a table \(0 MB, at most 0\)"):
        open_table(tmp_path / "t.csv")


def workbook(file: Path, *rows: list[Any]) -> Path:
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append(row)
    book.save(file)
    return file


def test_an_archive_that_unpacks_without_end_is_refused(tmp_path: Path) -> None:
    """60 MB of blanks in 60 kB."""
    file = workbook(tmp_path / "t.xlsx", ["depth_m"])
    with zipfile.ZipFile(file, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("xl/more.xml", b" " * 60_000_000)
    assert file.stat().st_size < 100_000
    with pytest.raises(UserInputError, match=r"too large for a table \(60 MB when unpacked, at most 50\)"):
        open_table(file)


@pytest.mark.parametrize(
    ("row", "column", "words"),
    [(1_000_000, 1, "has more than 200,000 lines"),
     (9_000, 16_384, "has more than 5,000,000 cells up to its last column, 16,384: delete what is beside")],
)  # fmt: skip
def test_a_sheet_without_end_is_refused(tmp_path: Path, row: int, column: int, words: str) -> None:
    """One cell in the last line of a sheet: a million lines to a reader; one in its corner took a minute and more."""
    book = openpyxl.Workbook()
    book.active.cell(row=row, column=column, value="x")
    book.save(tmp_path / "t.xlsx")
    with pytest.raises(UserInputError, match=words):
        open_table(tmp_path / "t.xlsx")


# --- spring files ---


def spoiled(tmp_path: Path, spoil: Any) -> str:
    """Return what is said of a spring file."""
    springs = synthetic.make_springs((synthetic.Path("pull", steps=3),), synthetic.Caisson(rings=3))
    spoil(springs)
    with pytest.raises(UserInputError) as caught:
        open_springs(write_tree(springs, tmp_path / "s.nc"))
    return str(caught.value)


def attribute(path: str, name: str, value: Any) -> Any:
    return lambda springs: springs[path].attrs.update({name: value})


def scaled(path: str, factor: float) -> Any:
    def spoil(springs: Any) -> None:
        springs[path].values *= factor

    return spoil


def texts(path: str) -> Any:
    def spoil(springs: Any) -> None:
        group, name = path.rsplit("/", 1)
        data = springs[group].to_dataset(inherit=False)
        old = data[name]
        data[name] = (old.dims, np.full(old.shape, "x", dtype=object), old.attrs)
        springs[group].dataset = data

    return spoil


def without_dofs(springs: Any) -> None:
    springs.dataset = springs.to_dataset(inherit=False).isel(dof=slice(0))


def infinitely_deep(springs: Any) -> None:
    data = springs["/paths/pull"].to_dataset(inherit=False)
    depth = np.append(data["depth"].values[:-1], np.inf)
    springs["/paths/pull"].dataset = data.assign_coords(depth=("depth", depth, data["depth"].attrs))


def without_depths(springs: Any) -> None:
    data = springs["/paths/pull"].to_dataset(inherit=False)
    springs["/paths/pull"].dataset = data.isel(depth=slice(0))


def negative_k_v(springs: Any) -> None:
    springs["stiffness_initial"].values[1, 1] *= -1.0


def strong_coupling(springs: Any) -> None:
    springs["stiffness_initial"].values[0, 2] *= 1e3
    springs["stiffness_initial"].values[2, 0] *= 1e3


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (attribute("/", "schema", np.arange(3)), "another version"),
        (attribute("/", "outer_diameter_m", -7.8), "outer_diameter_m: -7.8 is not positive"),
        (attribute("/paths/pull", "kind", np.arange(3)), "paths/pull/kind: attribute must be one of pull"),
        (attribute("/paths/pull", "arm_m", "8 m"), "paths/pull/arm_m: missing attribute, or not a number"),
        (attribute("/paths/pull", "arm_m", np.arange(2.0)), "paths/pull/arm_m: missing attribute, or not a number"),
        (attribute("/paths/pull", "rate_m_per_s", "fast"), "paths/pull/rate_m_per_s: not a number"),
        (attribute("/paths/pull", "status", "\x1b[31m"), "a text with a line end or a control character"),
        (scaled("/paths/pull/p", 1e30), "N m-1"),
        (scaled("/paths/pull/H", 1e300), "paths/pull/H: "),
        (scaled("/paths/pull/H", 1e-310), "paths/pull/H: "),
        (texts("/paths/pull/u"), "paths/pull/u: holds no numbers"),
        (without_dofs, "stiffness_initial: must be 3 by 3"),
        (lambda springs: springs["paths/pull/u"].attrs.update(units=np.arange(2)), "paths/pull/u: units"),
        (infinitely_deep, "depth_bounds: must hold a finite"),
        (without_depths, "depth_bounds: must hold a finite"),
        (lambda springs: springs["paths/pull/u"].attrs.update(units=5000 * "x"), "xxx...' instead of"),
        (negative_k_v, "stiffness_initial: does not resist every motion"),
        (strong_coupling, "stiffness_initial: does not resist every motion"),
        (scaled("/stiffness_initial", 1e30), "stiffness_initial: "),
    ],
)
def test_spring_files_are_what_they_should_be(tmp_path: Path, spoil: Any, words: str) -> None:
    assert words in spoiled(tmp_path, spoil)


def test_a_record_without_p_is_refused(tmp_path: Path) -> None:
    springs = synthetic.make_springs(
        (synthetic.Path("a", steps=3), synthetic.Path("b", steps=3)), synthetic.Caisson(rings=3)
    )
    file, *_ = written.tables(tmp_path, springs)
    lines = [line for line in file.read_text().splitlines() if not line.startswith("b,py,")]
    file.write_text("\n".join(lines))
    with pytest.raises(UserInputError, match="family: path 'b' has no p-y curves"):
        open_table(file)


def test_springs_that_never_serve_carry_no_load(tmp_path: Path) -> None:
    """A path on which nothing moves laterally has no p-y curve at all."""
    from pysprings import predict
    from pysprings.macro.predict import PredictionNotConverged

    springs = synthetic.make_springs((synthetic.Path("pull", steps=3),), synthetic.Caisson(rings=3))
    for name in ("u", "rotation", "y"):
        springs[f"paths/pull/{name}"].values[...] = 0.0
    with pytest.raises(PredictionNotConverged):
        predict(springs, H=1e5, springs_kind="py")


@pytest.fixture
def springs_nc(tmp_path: Path) -> Path:
    return write_tree(synthetic.make_springs(caisson=synthetic.Caisson(rings=3)), tmp_path / "s.nc")


@pytest.mark.parametrize(("shape", "size"), [((2**28,), "2.15 GB"), ((2**40, 2**40), "9.67e+15 GB")])
def test_a_spring_file_that_unpacks_without_end_is_refused(springs_nc: Path, shape: tuple[int, ...], size: str) -> None:
    """What was never written takes no room on a disk; it takes none in memory either."""
    resource = pytest.importorskip("resource")
    with netCDF4.Dataset(springs_nc, "a") as root:
        names = [f"huge{number}" for number in range(len(shape))]
        for name, length in zip(names, shape, strict=True):
            root.createDimension(name, length)
        root["paths/pull"].createVariable("hv", "f8", names, chunksizes=(1024,) * len(shape))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    done = command("compare", springs_nc)
    assert done.code == 2
    assert done.err.startswith(f"fatal: user input: {springs_nc}: {size} when unpacked from 0.")
    assert "never written" in done.err
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 300_000  # kB


def test_a_spring_set_is_not_larger_than_hundreds_of_paths(springs_nc: Path) -> None:
    """160 MB of zeros that were written: 0.5 MB on the disk, as small as deflate makes them."""
    with netCDF4.Dataset(springs_nc, "a") as root:
        root.createDimension("huge", 20_000_000)
        variable = root.createVariable("huge", "f8", ("huge",), zlib=True)
        variable[:] = 0.0
    done = command("compare", springs_nc)
    assert done.code == 2
    assert "160 MB when unpacked; a set of springs has at most 100 MB" in done.err


def test_a_file_with_too_much_in_its_header_is_refused(springs_nc: Path) -> None:
    with netCDF4.Dataset(springs_nc, "a") as root:
        for number in range(201):
            root["paths"].createVariable(f"v{number}", "f8", ())
    done = command("compare", springs_nc)
    assert done.code == 2
    assert done.err == f"fatal: user input: {springs_nc}: holds 201 variables in '/paths', at most 200\n"


@pytest.mark.filterwarnings("ignore:.*no checksum at its end")
def test_the_first_problems_of_many_are_shown(springs_nc: Path) -> None:
    """Empty groups lack every variable of a path."""
    with netCDF4.Dataset(springs_nc, "a") as root:
        for number in range(100):
            root.createGroup(f"paths/x{number}")
    done = command("compare", springs_nc)
    lines = [line for line in done.err.splitlines() if line.startswith("fatal: ")]
    assert done.code == 2
    assert len(lines) == 21
    assert re.fullmatch(r"fatal: user input: and \d,\d{3} more problems", lines[-1])


# --- names of files ---


@pytest.mark.parametrize("name", ["CON", "nul", "Prn", "AUX", "COM1", "lpt9", "com0"])
def test_names_that_are_devices_are_refused(tmp_path: Path, name: str) -> None:
    text = tiny.grounded(f'[[path]]\nname = "{name}"\nkind = "pull"\nlateral_displacement = "1 mm"\n')
    (tmp_path / "c.toml").write_text(text, encoding="utf-8")
    done = command("check", tmp_path / "c.toml")
    assert done.code == 2
    place = f"{tmp_path / 'c.toml'}:2:8: path[0].name"
    assert (
        done.err
        == f'fatal: user input: {place}: "{name}" names files, too, and Windows takes such a file for a device\n'
    )
    assert name_fault(name)


@pytest.mark.parametrize("name", ["CON.x", "nul .csv", "a.", "a "])
def test_names_of_other_files_that_windows_refuses(name: str) -> None:
    assert "Windows refuses" in name_fault(name)


@pytest.mark.parametrize("name", ["CONE", "com", "COM10", "lpt-1", "aux2"])
def test_names_like_those_of_devices_are_welcome(name: str) -> None:
    assert name_fault(name) == ""
    assert tiny.scene(paths=({**tiny.PULL, "name": name},)).paths[0].name == name


TOO_LONG = [
    ("run", "FILE", "--out", "LONG"), ("predict", "LONG", "--H", "1 MN"), ("check", "LONG"), ("init", "LONG"),
    ("export", "LONG", "--to", "csv"),
]  # fmt: skip


@pytest.mark.parametrize("asked", TOO_LONG, ids=lambda asked: asked[0])
def test_paths_that_are_too_long_are_the_users(tmp_path: Path, asked: tuple[str, ...]) -> None:
    words = {"FILE": tiny.write(tiny.scene(), tmp_path / "c.toml"), "LONG": tmp_path / ("x" * 300)}
    done = command(*(words.get(word, word) for word in asked))
    assert done.code == 2, done.err
    assert done.err.startswith("fatal: user input: ")


def test_a_message_does_not_quote_a_whole_file() -> None:
    from pysprings.core.errors import Problem

    line = str(Problem("f", 1, 2, "k" * 5000, "m" * 5000))
    assert len(line) < 1050
    assert line.endswith("mmm...")
