# SPDX-License-Identifier: MIT
"""The command line: streams, exit codes, messages. The solver is replaced by small fakes."""

from __future__ import annotations

import json
import subprocess
import sys
import types
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.main import get_command

from fe_engine.errors import MeshError, NotConverged
from pysprings import __version__
from pysprings.cli import app
from pysprings.core.errors import ResourceError, RunIncomplete
from pysprings.core.files import storage
from pysprings.core.text import number
from pysprings.scene.load import SECTIONS, Scene, load_scene
from pysprings.scene.template_names import template_names
from pysprings.scene.toml import field_of
from pysprings.springs.file import open_springs, save_springs
from tests.support import synthetic
from tests.support.commands import command, environment, run_python


@pytest.fixture(autouse=True)
def _in_a_new_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def scene_file() -> Path:
    file = Path("caisson.toml")
    file.write_text('title = "test"\n[soil]\nK0 = 0.9\n')
    return file


def fake(monkeypatch: pytest.MonkeyPatch, module: str, **functions: Any) -> None:
    """Put a module with these functions in the place of a real one."""
    replacement = types.ModuleType(module)
    vars(replacement).update(functions)
    monkeypatch.setitem(sys.modules, module, replacement)


# --- the whole command ---


@pytest.mark.parametrize("args", [["--help"], ["--version"], ["run", "--help"], ["predict", "--help"]])
def test_help_loads_nothing_heavy(args: list[str]) -> None:
    """typer itself may bring pydantic; everything else heavy, and our own models, must stay out."""
    heavy = {"numpy", "scipy", "pandas", "xarray", "numba", "matplotlib", "pint", "netCDF4", "fe_engine"}
    code = (
        f"import sys; sys.argv = ['pysprings', *{args!r}]\n"
        "from pysprings.cli.app import main\n"
        "try: main()\n"
        "except SystemExit as end: assert not end.code, end.code\n"
        f"print(sorted({heavy!r} & set(sys.modules)), file=sys.stderr)\n"
        "print([name for name in sys.modules if name.startswith('pysprings.scene.load')], file=sys.stderr)\n"
    )
    done = run_python("-c", code)
    assert done.returncode == 0, done.stderr
    assert done.stderr == "[]\n[]\n"


def test_python_dash_m_and_version() -> None:
    done = run_python("-m", "pysprings", "--version")
    assert (done.returncode, done.stdout.splitlines()[0], done.stderr) == (0, f"pysprings {__version__}", "")


def test_help_tells_the_exit_codes() -> None:
    text = " ".join(command("--help").out.split())
    assert "2 user input" in text
    assert "130" in text


@pytest.mark.parametrize("name", sorted(get_command(app.app).commands))
def test_help_shows_every_bracket_of_its_texts(name: str) -> None:
    """rich reads `[word]` as markup and leaves it out: every text must arrive whole."""
    env = {"COLUMNS": "2000", "TERMINAL_WIDTH": "2000"}
    shown = command(name, "--help", env=env).out
    known = get_command(app.app).commands[name]
    texts = [known.help, *(text for param in known.params if (text := getattr(param, "help", None)))]
    assert len(texts) > 1
    for text in texts:
        for line in text.replace("\\[", "[").splitlines():
            assert line.strip() in shown


def test_help_lists_templates_and_says_what_the_spring_sets_are() -> None:
    listed = " ".join(command("init", "--help").out.replace("│", " ").split())
    names = template_names()
    assert len(names) > 1
    assert all(name in listed for name in names)
    said = " ".join(command("predict", "--help").out.replace("│", " ").split())
    for name in app.SpringSet:
        assert f"{name.value} (" in said


def test_wrong_usage_is_exit_2() -> None:
    assert command("check").code == 2
    assert command("nonsense").code == 2
    assert command("run", "x.toml", "--mesh", "huge").code == 2


def test_presets_are_those_of_the_scene() -> None:
    assert [item.value for item in app.Preset] == list(field_of(SECTIONS["mesh"].model_fields["preset"]).words)


# --- init ---


def test_init_writes_scene_and_schema() -> None:
    done = command("init")
    assert (done.code, done.out) == (0, "caisson.toml\npysprings.schema.json\n")
    assert load_scene("caisson.toml") == Scene()
    assert Path("caisson.toml").read_text().startswith("#:schema ./pysprings.schema.json\n")
    assert json.loads(Path("pysprings.schema.json").read_text())["title"] == "pysprings scene"


def test_init_makes_folders() -> None:
    assert command("init", "a/b/c.toml").code == 0
    assert Path("a/b/c.toml").exists()
    assert Path("a/b/pysprings.schema.json").exists()


def test_init_never_overwrites_without_force() -> None:
    Path("caisson.toml").write_text("mine")
    Path("pysprings.schema.json").write_text("mine too")
    done = command("init")
    assert (done.code, done.out) == (2, "")
    message = "caisson.toml: exists already; choose another name, or --force to replace it"
    assert done.err == f"fatal: user input: {message}\n"
    assert Path("caisson.toml").read_text() == "mine"
    assert command("init", "other.toml").out == "other.toml\n"
    assert Path("pysprings.schema.json").read_text() == "mine too"
    assert command("init", "--force").code == 0
    assert load_scene("caisson.toml") == Scene()
    assert Path("pysprings.schema.json").read_text() != "mine too"


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (
            ["--template", "paper-draind"],
            "--template: no template 'paper-draind' (did you mean 'paper-drained'?)",
        ),
        (["--template", "x"], "--template: no template 'x' (there is: fan, paper-drained, paper-partially-drained)"),
        (
            ["pysprings.schema.json"],
            "pysprings.schema.json: is the name of the schema; choose another for the scene",
        ),
        (["file/x.toml"], "file: cannot be written (File exists)"),
    ],
)
def test_init_refuses(args: list[str], message: str) -> None:
    Path("file").write_text("")
    done = command("init", *args)
    assert (done.code, done.out, done.err) == (2, "", f"fatal: user input: {message}\n")


# --- check ---

ABOUT = {
    "mesh": {"nodes": np.int64(1848), "largest_aspect_ratio": 28.4164},
    "unknowns": 12345,
    "memory_GB": 0.28149,
    "time_s": np.float64("nan"),
    "left_out": [
        {"what": "water", "why": "drained", "saved": {"basis": "a guess", "unknowns": 1234, "time_share": 0.62}},
        {"what": "sunshine", "why": "it is dark", "saved": {}},
    ],
}


def test_check_prints_a_table(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    fake(monkeypatch, "pysprings.model.forecast.estimate", describe=lambda scene: ABOUT)
    done = command("check", scene_file)
    assert (done.code, done.err) == (0, "")
    for text in (
        "caisson.toml: test",
        "1,848",
        "28.42",
        "12,345",
        "memory, estimated [GB]",
        "- water: drained\n  saves 1,234 unknowns, 62 % of the time (a guess)\n- sunshine: it is dark\n",
    ):
        assert text in done.out
    assert "pull (pull, calibration)" in done.out


def test_check_json_is_one_document(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    fake(monkeypatch, "pysprings.model.forecast.estimate", describe=lambda scene: ABOUT)
    done = command("check", scene_file, "--json")
    data = json.loads(done.out)
    assert data["mesh"]["nodes"] == 1848
    assert data["time_s"] is None
    assert data["left_out"] == ABOUT["left_out"]
    assert data["scene_sha256"] == load_scene(scene_file).sha256


def test_check_with_another_mesh(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    fake(monkeypatch, "pysprings.model.forecast.estimate", describe=lambda scene: {"preset": scene.mesh.preset})
    assert "fine" in command("check", scene_file, "--mesh", "fine").out


def test_check_refuses_a_scene_with_every_problem() -> None:
    Path("bad.toml").write_text("[soil]\npoisson_ratio = 0.6\n[interface]\nfriction_coeficient = 0.5\n")
    done = command("check", "bad.toml")
    assert (done.code, done.out) == (2, "")
    assert done.err == (
        "fatal: user input: bad.toml:2:17: soil.poisson_ratio: 0.6 is not in [0, 0.5)\n"
        "fatal: user input: bad.toml:4:1: interface.friction_coeficient: unknown key "
        "(did you mean 'friction_coefficient'?)\n"
    )


# --- run ---


CUT_BACK = {
    "stage": "path",
    "load_fraction": 0.125,
    "reason": "the residual stalls",
    "place": "node 7",
    "iterations": 9,
    "last_residuals": [0.1],
}
RECORD = {
    "mesh": {"nodes": 1848, "unknowns": 4631},
    "solver": {"linear": "pardiso", "factorisations": 190},
    "paths": {
        "pull": {
            "status": "complete",
            "increments": 39,
            "iterations": 149,
            "median_iterations": 4.0,
            "max_iterations": 11,
            "cut_backs": 20,
            "iterations_in_cut_backs": 51,
            "cut_backs_at": [CUT_BACK] * 20,
            "worst_residual": 9e-7,
            "last_residual_ratio": 1e-4,
            "order_of_last_iterations": 1.875,
            "contact_rings": {
                "alternation": 0.0125,
                "alternation_at": "",
                "second_difference": 0.75,
                "second_difference_at": "outside, azimuth 90°, depth 0.00 m, step 39",
                "isolated_open": 0,
            },
        }
    },
    "phases": {"mesh": {"wall_s": 0.399, "cpu_s": 0.275}},
    "wall_s": 85.283,
    "peak_memory_bytes": 447963136,
}


def fake_run(monkeypatch: pytest.MonkeyPatch, end: BaseException | None = None, status: str = "complete") -> list[Any]:
    """Put a run that writes synthetic springs in the place of the real one; return its calls."""
    calls = []

    def run_to_folder(
        scene: Scene, out: Path, mesh: str | None = None, progress: Any = None, resume: bool = False
    ) -> Path:
        calls.append((scene, out, mesh))
        progress("pull", 0.0, "start")
        progress("pull", 1.0, "end")
        if status == "removed":
            (out / "run.json").unlink()
        elif status != "unsaved":
            storage.write_text(json.dumps(RECORD | {"status": status}), out / "run.json")
        if end is not None:
            raise end
        save_springs(synthetic.make_springs(), out / "springs.nc")
        files = ["figures/pull_py.png", "figures/pull_py.svg"]
        storage.write_text(json.dumps(RECORD | {"status": status, "balance": {}, "files": files}), out / "run.json")
        for name in ("pull_py.svg", "pull_py.png"):
            storage.write_text("", out / "figures" / name)
        return out

    fake(monkeypatch, "pysprings.results.folder", run_to_folder=run_to_folder)
    return calls


def test_run_prints_where_results_are_and_the_comparison(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    calls = fake_run(monkeypatch)
    done = command("run", scene_file, "--mesh", "medium")
    assert done.code == 0
    assert calls == [(load_scene(scene_file), Path("out/caisson"), "medium")]
    for text in ("results in out/caisson (complete)", "out/caisson/springs.nc", "eta", "4,631 unknowns"):
        assert text in done.out
    lines = [line.split() for line in done.out.splitlines()]
    assert ["out/caisson/figures/pull_py", "picture", "(png,", "svg)"] in lines
    assert ["pull", "complete", "39", "149", "4", "11", "20", "9e-07", "0.0001", "1.875"] in lines
    assert ["mesh", "0.40", "0.28"] in lines
    assert ["total", "85.28", "-"] in lines
    assert done.err == "pull   0 % start\npull 100 % end\n"


def test_run_prints_cost_cut_backs_and_the_contact_measure(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    fake_run(monkeypatch)
    out = command("run", scene_file).out
    lines = out.splitlines()
    assert lines.count("pull: at 12.5 % of the path after 9 iterations: the residual stalls (node 7)") == 12
    assert "... and 8 more in run.json" in lines
    assert (
        "pull: alternation 0.0125, largest second difference 0.75 (outside, azimuth 90°, depth 0.00 m, step 39) "
        "of the ring's mean; open stations between two loaded ones: 0"
    ) in lines
    assert (
        "1,848 nodes, 4,631 unknowns; 200 Newton iterations, those in cut-backs included; "
        "190 factorisations (pardiso); peak memory 448 MB"
    ) in lines


def test_run_json(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    fake_run(monkeypatch)
    data = json.loads(command("run", scene_file, "--out", "here", "--json").out)
    assert data["run"]["status"] == "complete"
    assert data["files"] == ["figures/pull_py.png", "figures/pull_py.svg", "run.json", "springs.nc"]
    assert {row["springs"] for row in data["compare"]["rows"]} == {"py", "full"}


def test_run_refuses_results_that_are_there(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    calls = fake_run(monkeypatch)
    folder = Path("results")
    folder.mkdir()
    (folder / "run.json").write_text("precious")
    done = command("run", scene_file, "--out", folder)
    assert (done.code, done.out, calls) == (2, "", [])
    assert done.err == (
        "fatal: user input: results: --out: holds results already (run.json); "
        "choose another folder, or --force to replace\n"
    )
    assert [path.name for path in folder.iterdir()] == ["run.json"]
    assert (folder / "run.json").read_text() == "precious"
    assert command("run", scene_file, "--out", folder, "--force").code == 0
    assert len(calls) == 1


def test_run_takes_a_folder_with_other_files(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    fake_run(monkeypatch)
    Path("case").mkdir()
    Path("case/scene.toml").write_text(scene_file.read_text())
    assert command("run", "case/scene.toml", "--out", "case").code == 0


def test_a_refused_scene_leaves_results_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = fake_run(monkeypatch)
    Path("bad.toml").write_text("[soil]\nK0 = -1\n")
    Path("results").mkdir()
    Path("results/run.json").write_text("precious")
    done = command("run", "bad.toml", "--out", "results", "--force")
    assert (done.code, calls) == (2, [])
    assert Path("results/run.json").read_text() == "precious"
    assert command("run", "bad.toml").code == 2
    assert not Path("out").exists()


def test_a_mesh_that_is_refused_leaves_no_new_folder(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    fake_run(monkeypatch, MeshError("inverted element 7"), status="unsaved")
    Path("mine").mkdir()
    for folder in ("new/folder", "mine"):
        assert command("run", scene_file, "--out", folder).code == 2
    assert not Path("new").exists()
    assert Path("mine").exists()


def test_run_refuses_a_file_and_a_place_it_cannot_write(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    fake_run(monkeypatch)
    done = command("run", scene_file, "--out", scene_file)
    assert (done.code, done.err) == (2, "fatal: user input: caisson.toml: --out: is a file, not a folder\n")
    done = command("run", scene_file, "--out", scene_file / "x")
    assert (done.code, done.err) == (
        2,
        "fatal: user input: caisson.toml/x: --out: cannot be created (Not a directory)\n",
    )


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (
            RunIncomplete("pull: stopped at 3 mm", "out/caisson"),
            3,
            "fatal: not converged: pull: stopped at 3 mm\nwhat converged is kept in out/caisson\n",
        ),
        (NotConverged("no balance", "node 3"), 3, "fatal: not converged: no balance (node 3)\n"),
        (MeshError("inverted element 7"), 2, "fatal: user input: mesh: inverted element 7\n"),
        (ResourceError("pardiso is not installed"), 4, "fatal: resources: pardiso is not installed\n"),
        (
            MemoryError(),
            4,
            "fatal: resources: out of memory; try a smaller mesh (`pysprings check` estimates)\n",
        ),
        (
            OSError(28, "No space left on device", "x.nc"),
            4,
            "fatal: resources: x.nc: No space left on device\n",
        ),
        (
            ZeroDivisionError("a\nb"),
            1,
            "fatal: bug: ZeroDivisionError: a\\nb\nplease report it; `pysprings --debug ...` shows where\n",
        ),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, Exception) else "",
)
def test_errors_of_a_run(
    monkeypatch: pytest.MonkeyPatch, scene_file: Path, error: Exception, code: int, message: str
) -> None:
    fake_run(monkeypatch, error, status="unsaved")
    done = command("run", scene_file)
    assert (done.code, done.out) == (code, "")
    assert done.err.removeprefix("pull   0 % start\npull 100 % end\n") == message


def test_interrupted_run_says_what_is_kept(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    fake_run(monkeypatch, KeyboardInterrupt(), status="interrupted")
    done = command("run", scene_file)
    assert done.code == 130
    assert done.out.startswith("results in out/caisson (interrupted)\n")
    assert done.err.endswith("\ninterrupted\n")


def test_partial_run_prints_its_record_and_no_comparison(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    """Not even when an earlier run left springs in the same folder."""
    assert fake_run(monkeypatch) == []
    assert command("run", scene_file).code == 0
    fake_run(monkeypatch, RunIncomplete("pull: stopped at 3 mm", "out/caisson"), status="partial")
    done = command("run", scene_file, "--force")
    assert done.code == 3
    assert done.out.startswith("results in out/caisson (partial)\n")
    assert "eta" not in done.out
    assert "fatal: not converged: pull: stopped at 3 mm\n" in done.err
    data = json.loads(command("run", scene_file, "--force", "--json").out)
    assert (data["run"]["status"], data["compare"]) == ("partial", None)


def test_an_old_record_does_not_pass_for_a_new_one(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    fake_run(monkeypatch)
    assert command("run", scene_file).code == 0
    fake_run(monkeypatch, KeyboardInterrupt(), status="unsaved")
    done = command("run", scene_file, "--force")
    assert (done.code, done.out) == (130, "")
    fake_run(monkeypatch, KeyboardInterrupt(), status="removed")  # cleared away, and nothing written yet
    done = command("run", scene_file, "--force")
    assert (done.code, done.out) == (130, "")


def test_debug_shows_the_traceback(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    fake_run(monkeypatch, ZeroDivisionError("oops"))
    result = command("--debug", "run", str(scene_file))
    assert result.code == 1
    assert "Traceback" in result.err
    assert result.err.endswith("fatal: bug: ZeroDivisionError: oops\nplease report it\n")


def test_warnings_are_one_line_each(monkeypatch: pytest.MonkeyPatch, scene_file: Path) -> None:
    def describe(scene: Scene) -> dict[str, Any]:
        warnings.warn("30,000 unknowns with SuperLU", stacklevel=1)
        return {}

    fake(monkeypatch, "pysprings.model.forecast.estimate", describe=describe)
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        assert command("check", scene_file).err == "warning: 30,000 unknowns with SuperLU\n"


# --- springs, predict, compare, on synthetic springs ---


@pytest.fixture
def springs_file() -> Path:
    return save_springs(synthetic.make_springs(), Path("results/springs.nc"))


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


def test_springs_of_a_full_model_file(monkeypatch: pytest.MonkeyPatch, springs_file: Path) -> None:
    from pysprings.core.files.storage import write_tree

    fake(monkeypatch, "pysprings.springs.extract", extract_springs=lambda result: synthetic.make_springs())
    write_tree(synthetic.make_result(), Path("full_model.nc"))
    assert command("springs", "full_model.nc").out == command("springs", springs_file).out


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["no.nc"], "no.nc: no such file"),
        (["empty"], "empty: no springs.nc in this folder; is it a result of `pysprings run`?"),
        (["caisson.toml"], "caisson.toml: not a NetCDF-4 file"),
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
def test_springs_refuses(springs_file: Path, scene_file: Path, args: list[str], message: str) -> None:
    Path("empty").mkdir()
    done = command("springs", *args)
    assert (done.code, done.out, done.err) == (2, "", f"fatal: user input: {message}\n")


def fake_macro(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Put a macro-model that records its arguments in the place of the real one."""
    import xarray as xr

    seen: dict[str, Any] = {}

    def answer(_springs: Any, **given: Any) -> xr.Dataset:
        seen.update(given)
        values = {
            "u": [0.0, 1e-3],
            "w": [0.0, -1e-5],
            "rotation": [0.0, -1e-4],
            "H": [0.0, 2e6],
            "V": [1e6, 1e6],
        }
        return xr.Dataset({name: ("step", value) for name, value in values.items()} | {"M": ("step", [0.0, -16e6])})

    import pysprings.macro.predict

    monkeypatch.setattr(pysprings.macro.predict, "predict", answer)
    monkeypatch.setattr(pysprings.macro.predict, "curve", answer)
    return seen


def test_predict_passes_si_values_on(monkeypatch: pytest.MonkeyPatch, springs_file: Path) -> None:
    seen = fake_macro(monkeypatch)
    assert command("predict", springs_file, "--H", "2 MN", "--arm", "8 m", "--V", "500 kN").code == 0
    assert (seen["H"], seen["arm"], seen["M"], seen["V"], seen["springs_kind"]) == (
        2e6,
        8.0,
        None,
        5e5,
        None,
    )
    assert command("predict", springs_file, "--H", "-200 kN", "--M", "-3 MN m", "--springs", "py").code == 0
    assert (seen["H"], seen["arm"], seen["M"], seen["springs_kind"]) == (-2e5, None, -3e6, "py")
    assert command("predict", springs_file, "--u-max", "5 mm", "--arm", "-2 m", "--points", "7").code == 0
    assert (seen["u_max"], seen["arm"], seen["n"]) == (5e-3, -2.0, 7)


def test_predict_prints_a_table_with_units(monkeypatch: pytest.MonkeyPatch, springs_file: Path) -> None:
    fake_macro(monkeypatch)
    lines = command("predict", springs_file, "--H", "2 MN", "--arm", "8 m").out.splitlines()
    assert lines[0].split() == [
        "u",
        "[mm]",
        "w",
        "[mm]",
        "rotation",
        "[deg]",
        "H",
        "[kN]",
        "V",
        "[kN]",
        "M",
        "[kN",
        "m]",
    ]
    assert lines[2].split() == ["1", "-0.01", "-0.0057296", "2000", "1000", "-16000"]
    assert len(lines) == 3
    assert len(command("predict", springs_file, "--u-max", "5 mm").out.splitlines()) == 4


def test_predict_on_real_springs(springs_file: Path) -> None:
    data = json.loads(command("predict", springs_file, "--H", "1 MN", "--json").out)
    (state,) = data["states"]
    assert state["H"] == pytest.approx(1e6)
    assert state["u"] > 0
    assert state["rotation"] < 0
    assert data["units"]["rotation"] == "radian"
    curve = json.loads(command("predict", springs_file.parent, "--u-max", "4 mm", "--points", "5", "--json").out)
    assert [row["u"] for row in curve["states"]] == pytest.approx([0, 1e-3, 2e-3, 3e-3, 4e-3])


@pytest.mark.parametrize(
    ("args", "messages"),
    [
        ([], ['--H: missing: give a load such as --H "2 MN", or --u-max "5 mm" for a curve']),
        (["--H", "2"], ['--H: expected a quantity with unit such as "2 MN", got "2"']),
        (
            ["--H", "2 MPa", "--arm", "3"],
            [
                '--H: "2 MPa" is a pressure or stress; expected a force such as "2 MN"',
                '--arm: expected a quantity with unit such as "8 m", got "3"',
            ],
        ),
        (["--H", "2 MN", "--M", "3 MN"], ['--M: "3 MN" is a force; expected a moment such as "-3 MN m"']),
        (
            ["--H", "2 MN", "--u-max", "5 mm"],
            ["--u-max: give either --H or --u-max: the load is an answer of the curve"],
        ),
        (
            ["--H", "2 MN", "--arm", "1 m", "--M", "1 MN m"],
            ["--M: give either --arm or --M, not both (M = -H*arm)"],
        ),
        (
            ["--u-max", "5 mm", "--M", "1 MN m"],
            ["--M: a curve needs the height of the load: give --arm instead"],
        ),
        (["--H", "1 MN", "--path", "nope"], ["path: no path 'nope'; the springs have: pull"]),
    ],
)
def test_predict_refuses(springs_file: Path, args: list[str], messages: list[str]) -> None:
    done = command("predict", springs_file, *args)
    assert (done.code, done.out) == (2, "")
    assert done.err == "".join(f"fatal: user input: {message}\n" for message in messages)


def test_predict_strict_refuses_what_the_springs_do_not_cover(springs_file: Path) -> None:
    done = command("predict", springs_file, "--H", "9e9 N", "--strict")
    assert (done.code, done.out) == (2, "")
    assert done.err.startswith("fatal: user input: strict: ")
    assert "beyond the range of path 'pull'" in done.err
    assert len(done.err.splitlines()) == 1
    assert command("predict", springs_file, "--u-max", "2 mm", "--strict").code == 0


def test_fan_is_the_default_where_there_is_one(springs_file: Path) -> None:
    rays = (synthetic.Path("push", "translation"), synthetic.Path("turn", "rotation", 1e-3))
    fan = save_springs(synthetic.make_springs(rays), Path("fan/springs.nc"))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # two rays are 90 degrees apart
        data = json.loads(command("predict", fan, "--H", "1 MN", "--json").out)
        assert data["attributes"]["springs"] == "fan"
        one = json.loads(command("predict", fan, "--H", "1 MN", "--springs", "full", "--json").out)
        assert one["attributes"]["path"] == "push"
    strict = command("predict", fan, "--H", "1 MN", "--strict")
    assert (strict.code, strict.out) == (2, "")
    assert "between calibration paths 90 degrees apart" in strict.err
    assert len(strict.err.splitlines()) == 1
    rows = json.loads(command("compare", fan, "--springs", "fan", "--json").out)["rows"]
    assert [(row["path"], row["springs"]) for row in rows] == [("push", "fan"), ("turn", "fan")]
    none = command("predict", springs_file, "--H", "1 MN", "--springs", "fan")
    assert (none.code, len(none.err.splitlines())) == (2, 1)
    assert "a fan needs at least 2 calibration paths" in none.err
    there = command("compare", springs_file, "--springs", "fan")
    assert (there.code, there.err) == (
        2,
        "fatal: user input: springs_kind: no springs 'fan' here; there are: py, full\n",
    )


def test_predict_beyond_the_springs_warns(springs_file: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        done = command("predict", springs_file, "--H", "9e9 N")
    assert done.code == 0
    assert done.err.startswith("warning: ")
    assert "beyond the range of path 'pull'" in done.err


def test_compare(springs_file: Path) -> None:
    done = command("compare", springs_file.parent)
    assert (done.code, done.err) == (0, "")
    assert "eta" in done.out
    data = json.loads(command("compare", springs_file, "--json").out)
    assert {(row["path"], row["springs"]) for row in data["rows"]} == {("pull", "py"), ("pull", "full")}


def test_reader_that_stops_early_is_no_error(springs_file: Path) -> None:
    command = f"'{sys.executable}' -m pysprings springs '{springs_file}' | head -n 1; echo ${{PIPESTATUS[0]}}"
    env = environment()
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, env=env, timeout=60, check=True)
    assert done.stdout.splitlines()[1] == "0"
    assert done.stderr == ""


def test_numbers_for_people() -> None:
    values = (1848, np.int64(12345), 0.28149, 1.5e6, True, "x", 2e20)
    shown = ["1,848", "12,345", "0.2815", "1,500,000", "yes", "x", "2e+20"]
    assert [number(value) for value in values] == shown
