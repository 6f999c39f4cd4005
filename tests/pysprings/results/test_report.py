# SPDX-License-Identifier: MIT
"""The report stands alone, escapes what comes from a scene, and its checks see an error that is put in."""

import base64
import gzip
import hashlib
import json
import re
import tomllib
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pysprings.core.columns import Table
from pysprings.core.storage import write_tree
from pysprings.core.text import number
from pysprings.full_model.run_record import CutBack, PathFigures, RunRecord, Status
from pysprings.macro.comparison import compare
from pysprings.results.report import inputs, page as report, validity
from pysprings.results.report.inputs import ReportData, ReportTable
from pysprings.results.report.load_cases import spring_tables
from pysprings.results.report.page import REPORT_TABLES, live_parts
from pysprings.scene.load import parse_scene
from pysprings.scene.template import template_names, template_text
from pysprings.springs.tip_zone import on_slices
from tests.support import fans, synthetic, tiny
from tests.support.commands import run_python
from tests.support.files import Page
from tests.support.place import ROOT

SKETCH = ROOT / "pysprings" / "results" / "report" / "templates" / "axes.svg"
PATHS = (synthetic.Path("pull", size=2e-2), synthetic.Path("turn", "rotation", size=4e-3))
HOSTILE = "<script>alert('x')</script> & \"quoted\" <img src=x onerror=y>"
RUN = RunRecord.from_dict(
    {
        "status": "complete",
        "phases": {"mesh": {"wall_s": 0.2, "cpu_s": 0.3}, "factorisation": {"wall_s": 12.5, "cpu_s": 24.0}},
        "wall_s": 33.25,
        "peak_memory_bytes": 512_000_000,
        "solver": {"linear": "superlu", "factorisations": 77},
        "mesh": {"min_scaled_jacobian": 0.31},
        "failures": [],
        "left_out": [
            {"what": "installation", "why": "the caisson is wished in place", "saved": {}},
            {
                "what": "half",
                "why": "symmetry",
                "saved": {"basis": "counts", "unknowns": 4251, "memory_bytes": 40118655},
            },
        ],
    }
)
PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNkYPhfDwAChwGA60e6kgAAAABJRU5ErkJggg=="
)


@pytest.fixture(scope="module")
def result() -> xr.DataTree:
    return synthetic.make_result(PATHS)


@pytest.fixture(scope="module")
def springs() -> xr.DataTree:
    return synthetic.make_springs(PATHS)


@pytest.fixture
def pictures(tmp_path: Path) -> list[Path]:
    names = (
        "mesh.png",
        "pull_py.png",
        "pull_newton.png",
        "pull_gap_2.5mm.png",
        "pull_gap_last.png",
        "turn_py.png",
        "other.png",
    )
    for name in names:
        (tmp_path / name).write_bytes(PIXEL)
    return [tmp_path / name for name in names]


def hostile(result: xr.DataTree) -> xr.DataTree:
    tree = result.copy()
    scene = f'title = {json.dumps(HOSTILE)}\n[caisson]\n"{"<b>key</b>"}" = {json.dumps(HOSTILE)}\n'
    tree.attrs = {
        **result.attrs,
        "title": HOSTILE,
        "scene_toml": scene,
        "solver": HOSTILE,
        "scene_sha256": HOSTILE,
        "pysprings_version": HOSTILE,
        "mesh_preset": HOSTILE,
    }
    tree["paths/pull"].attrs |= {"status": HOSTILE, "role": HOSTILE, "kind": HOSTILE}
    return tree


def test_hostile_text_is_escaped_everywhere(result: xr.DataTree, springs: xr.DataTree) -> None:
    cut_back = CutBack("dead load", 0.0625, HOSTILE, HOSTILE, 9, [0.0123, 0.5])
    run = RunRecord(
        Status.PARTIAL,
        paths={"pull": PathFigures(cut_backs_at=[cut_back])},
        failures=[HOSTILE],
        warnings=[HOSTILE],
        python=HOSTILE,
        environment={HOSTILE: HOSTILE},
        phases={HOSTILE: {HOSTILE: 1.0}},
        left_out=[{"what": HOSTILE, "why": HOSTILE, "saved": {"unknowns": 1, "basis": HOSTILE}}],
    )
    compare = pd.DataFrame([{"path": HOSTILE, "springs": HOSTILE, "status": HOSTILE}])
    text = report.render(ReportData(hostile(result), springs, compare, run))
    page = Page(text)
    assert "script" not in {tag for tag, _ in page.tags}
    assert not any("onerror" in attrs for _, attrs in page.tags)
    assert "b" not in {tag for tag, _ in page.tags}
    assert page.text.count(HOSTILE) >= 15
    assert "<b>key</b>" in page.text


def test_the_page_needs_nothing_beside_it(result: xr.DataTree, springs: xr.DataTree, pictures: list[Path]) -> None:
    page = Page(report.render(ReportData(result, springs, None, RUN), pictures))
    sources = [attrs["src"] for tag, attrs in page.tags if tag == "img"]
    assert len(sources) == 1 + 3  # the sketch, and of the known pictures one of each kind that the report shows
    assert all(source is not None and source.startswith("data:image/") for source in sources)
    assert [base64.b64decode(str(source).partition("base64,")[2]) == PIXEL for source in sources].count(True) == 3
    assert not {"script", "link", "iframe"} & {tag for tag, _ in page.tags}
    assert any("default-src 'none'" in str(attrs.get("content")) for tag, attrs in page.tags if tag == "meta")


def test_a_picture_of_each_kind_stands_in_its_part(result: xr.DataTree, pictures: list[Path]) -> None:
    page = Page(report.render(ReportData(result), figures=[*pictures[::-1]]))
    assert page.pictures == [
        "p-y curves by depth, path pull",
        "Gap opening, at the last converged step, path pull",
        "Axes and signs of the caisson",
        "Mesh in the symmetry plane",
    ]


@pytest.mark.parametrize(("kind", "shown"), [("pull", "tug"), ("translation", "pull_of_a_name")])
def test_states_are_those_of_a_free_head_whatever_its_name(kind: str, shown: str, tmp_path: Path) -> None:
    paths = {"pull_of_a_name": {"kind": "rotation"}, "tug": {"kind": kind}}
    files = [tmp_path / f"{name}_gap_last.png" for name in paths]
    for file in files:
        file.write_bytes(PIXEL)
    (gap,) = report.pictures_by_part(files, paths)["states"]
    assert gap.caption.endswith(f", path {shown}")


def test_the_summary_is_first_and_every_link_of_the_contents_has_its_part(
    result: xr.DataTree, springs: xr.DataTree
) -> None:
    run = replace(RUN, summary={"loads": "H 4 MN"})
    page = Page(report.render(ReportData(result, springs, None, run)))
    assert "Macro-model against full model" not in page.text and validity.compare_table(pd.DataFrame()) is None
    heads = [
        page.text.rindex(word)
        for word in ("Summary", "H 4 MN", "Contents", "Springs from one path", "Appendix: numerics\n")
    ]
    assert heads == sorted(heads)
    links = [str(attrs["href"]).lstrip("#") for tag, attrs in page.tags if tag == "a"]
    assert len(links) >= 5 and set(links) <= {attrs.get("id") for _, attrs in page.tags}


def test_interactive_parts_hold_one_library_and_allow_no_other_script(result: xr.DataTree) -> None:
    pytest.importorskip("plotly")
    hostile_result = result.copy()
    hostile_result["paths/pull"].attrs["role"] = "</script><script>alert(1)</script>"
    live = live_parts(hostile_result)
    assert live is not None
    page = Page(report.render(ReportData(hostile_result), live=live))
    scripts = [attrs for tag, attrs in page.tags if tag == "script"]
    assert [attrs.get("id") for attrs in scripts] == ["run-data", "library", None]
    (policy,) = [str(attrs["content"]) for tag, attrs in page.tags if "content" in attrs and "http-equiv" in attrs]
    assert policy.count("'sha256-") == 2 and "script-src 'sha256-" in policy
    digest = base64.b64encode(hashlib.sha256(gzip.decompress(base64.b64decode(live.library))).digest()).decode()
    assert digest in policy
    data = json.loads(live.data)
    (pull,) = [path for path in data["paths"] if path["name"] == "pull"]
    assert pull["role"] == "</script><script>alert(1)</script>" and "<" not in live.data
    assert pull["H"][-1] == pytest.approx(1e-6 * float(result["paths/pull"]["H"][-1]), rel=1e-3)
    assert np.shape(pull["p"]) == (len(pull["u"]), len(pull["depth"])) and pull["edge"][-1]


def test_svg_is_taken_where_there_is_one(result: xr.DataTree, pictures: list[Path], tmp_path: Path) -> None:
    (tmp_path / "mesh.svg").write_bytes(SKETCH.read_bytes())
    page = Page(report.render(ReportData(result), figures=[tmp_path / "mesh.svg", *pictures]))
    (mesh,) = [attrs for tag, attrs in page.tags if tag == "img" and attrs["alt"] == "Mesh in the symmetry plane"]
    assert str(mesh["src"]).startswith("data:image/svg+xml")


def test_inputs_show_every_key_with_its_unit_defaults_included(result: xr.DataTree) -> None:
    tables = {
        table.title: dict(table.rows)
        for table in inputs.input_tables(
            tiny.grounded('title = "t"\n[soil]\nyoung_modulus = "150 MPa"\n')
            + '[[path]]\nname = "push"\nkind = "pull"\nlateral_displacement = "3 mm"\n'
            + '[design]\nlateral_force = "1 MN"\ntilt = "0.028647889756541162 deg"\n'  # of 0.5 mrad
        )
    }
    assert tables["scene"] == {"title": "t"}
    assert tables["soil"]["young_modulus"] == "150 MPa"
    assert tables["caisson"]["outer_diameter"] == "7.8 m"
    assert tables["path 1"]["lateral_displacement"] == "3 mm"
    assert tables["design"]["tilt"] == "0.0286479 deg"
    assert inputs.input_tables("not = [toml") == []


@pytest.mark.parametrize(
    ("variable", "load"), [("H_lid", "H"), ("t", "V"), ("M_tip", "M"), ("m", "M"), ("H_tip", "M"), ("p", "H")]
)
def test_equilibrium_check_sees_a_wrong_force(springs: xr.DataTree, variable: str, load: str) -> None:
    def missing(tree: xr.DataTree) -> dict[tuple[str, str], float]:
        return {(row[0], row[1]): float(row[3]) for row in validity.equilibrium_table(tree).rows}

    assert len(missing(springs)) == 6
    assert max(missing(springs).values()) < 1e-12
    wrong = springs.copy(deep=True)
    wrong["paths/pull"][variable][..., -1] += 2000.0
    assert missing(wrong)["pull", load] > 1e-6
    assert missing(wrong)["turn", load] < 1e-12
    wrong["paths/pull"]["converged"][-1] = 0  # an unconverged step takes no part
    assert missing(wrong)["pull", load] < 1e-12


def test_numbers_stand_at_the_right_and_words_at_the_left(result: xr.DataTree, springs: xr.DataTree) -> None:
    rows = [("a", "1,234", "-", "H 1.2e-05 kN", "13 of 200"), ("b", "-0.5", "", "-", "2")]
    heads = ("name", "p [kN/m]", "none", "H", "stations")
    assert Table("t", heads, rows).numeric == [False, True, False, True, False]
    assert not any(Table("t", heads, rows, head=False).numeric)
    page = Page(report.render(ReportData(result, springs, None, RUN)))
    cells = [attrs for tag, attrs in page.tags if tag == "td"]
    assert 50 < sum(attrs.get("class") == "number" for attrs in cells) < len(cells)


@pytest.mark.parametrize("name", template_names())
def test_inputs_are_the_keys_of_the_scene_file(name: str) -> None:
    scene = parse_scene(template_text(name))
    shown = {table.title: dict(table.rows) for table in inputs.input_tables(template_text(name))}
    plain = tomllib.loads(re.sub(r"^# ", "", scene.to_toml(), flags=re.M))
    assert shown.pop("scene") == {"title": scene.title}
    paths = plain.pop("path", [])
    assert [shown.pop(f"path {k}")["name"] for k in range(1, len(paths) + 1)] == [path["name"] for path in paths]
    del plain["title"]
    layers = plain["soil"].pop("layer", [])
    assert [shown.pop(f"soil.layer {k}").keys() for k in range(1, len(layers) + 1)] == [each.keys() for each in layers]
    assert {key: set(rows) for key, rows in shown.items()} == {key: set(section) for key, section in plain.items()}
    assert shown["soil"] == plain["soil"] | shown["soil"]


def test_a_table_from_outside(result: xr.DataTree, springs: xr.DataTree) -> None:
    def build(data: ReportData) -> list[Table | None]:
        return [Table("Toy", ("path", "steps"), [(data.path, str(data.paths[data.path].sizes["step"]))]), None]

    with REPORT_TABLES.added(ReportTable("toy", "path", build)):
        page = Page(report.render(ReportData(result, springs, None, RUN)))
    assert {"pull21", "turn21"} <= set(page.text.split("\n"))
    assert page.text.count("Toy") == 2
    assert "Toy" not in Page(report.render(ReportData(result, springs, None, RUN))).text


def test_loads_at_a_tilt_are_interpolated_and_a_tilt_not_reached_is_a_dash(result: xr.DataTree) -> None:
    tree = result.copy(deep=True)
    path = tree["paths/pull"]
    n = path.sizes["step"]
    path["rotation"][:] = -np.radians(np.linspace(0.0, 0.4, n))
    path["H"][:] = np.linspace(0.0, 8e6, n)
    table = validity.tilt_table(ReportData(tree).paths)
    assert table is not None and [row[0] for row in table.rows] == ["pull"]
    assert list(table.rows[0][2:4]) == ["0.4", "5000"] and list(table.rows[0][5:]) == ["-", "-"]
    path["V"][n // 2 :] = 2.0 * float(path["V"][0])
    table = validity.tilt_table(ReportData(tree).paths)
    assert table is not None and table.rows[0][0] == "pull (V changes)"
    path.attrs["then_pairs"] = 1  # H and M then change on their own
    assert validity.tilt_table(ReportData(tree).paths) is None


def test_validity_states_the_calibrated_range(result: xr.DataTree, springs: xr.DataTree) -> None:
    sentences = " ".join(validity.validity(result))
    path = result["paths/pull"]
    assert "Path pull (pull, calibration): V 2000 kN, u from 0 to 20 mm" in sentences
    tree = result.copy(deep=True)
    tree["paths/pull"]["converged"][:] = 0
    assert "Path pull (pull, calibration): no converged step." in validity.validity(tree)
    ratio = float(path["rotation"][-1] * 4.0 / path["u"][-1])
    assert f"rotation·L/u = {ratio:.2f} at its end" in sentences
    tree["paths/turn"]["u"][:] = 1e-17  # imposed as 0, met to rounding
    (turn,) = (each for each in validity.validity(tree) if each.startswith("Path turn "))
    assert turn == "Path turn (rotation, calibration): V 2000 kN, u from 0 to 0 mm, rotation from 0 to 4 mrad."


def test_a_report_ends_where_the_water_would_cavitate(result: xr.DataTree, springs: xr.DataTree) -> None:
    """Range, table of the springs and loads at a tilt are those of the steps before."""
    trees, k = [tree.copy(deep=True) for tree in (result, springs)], 7
    for tree in trees:
        path = tree["paths/pull"].to_dataset(inherit=False)
        margin = np.where(np.arange(path.sizes["step"]) < k, 1e5, -1e3)
        tree["paths/pull"] = path.assign(cavitation_margin=("step", margin, {"units": "Pa"}))
    last = trees[0]["paths/pull"].to_dataset().isel(step=k - 1)
    pull = validity.validity(trees[0])[0]
    assert f"u from 0 to {1e3 * float(last['u']):.3g} mm" in pull and "the water would cavitate beyond" in pull
    (table,) = spring_tables(trees[1])
    assert table.title.startswith("Path pull") and table.rows[-2][5] == f"H {number(float(last['H_tip']) * 1e-3)} kN"
    ends = validity.end_table(ReportData(trees[0]).paths)
    assert ends is not None and [row[2] for row in ends.rows] == ["complete, beyond cavitation", "complete"]
    tilts = validity.tilt_table(ReportData(trees[0]).paths)
    assert tilts is not None and tilts.rows[0][2] == f"{np.degrees(float(last['rotation'])):.3g}"


def test_the_estimated_error_is_printed_with_what_it_comes_from() -> None:
    found = {
        "unknowns": [4000, 1500], "cell_ratio": 1.3867, "safety": 1.5, "order": {"load_max": 1.7, "py_rms": 1.2},
        "difference_pct": {"load_max": 4.0}, "estimate_pct": {"load_max": 8.12},
    }  # fmt: skip
    table = validity.estimate_table(RunRecord(error_estimate=found))
    assert table is not None
    assert table.rows == [("load, largest difference / largest load", "4", "1.7", "8.1")]
    assert "(1500 beside 4000 unknowns, ratio of cell sizes r = 1.39): safety factor 1.5 times" in table.note
    series = found | {"harmonics": [3, 5], "harmonics_pct": {"load_max": 0.25}}
    table = validity.estimate_table(RunRecord(error_estimate=series))
    assert table is not None and "3 and 5 harmonics there is added: load, largest difference" in table.note
    corrected = series | {"extrapolated": {"paths": ["a"], "left": {"load_max": 0.35}, "harmonics_added": ["a"]}}
    note = validity.estimate_table(RunRecord(error_estimate=corrected)).note
    assert "leaves these shares of the difference: 0.35 (load max)" in note and "in their reactions 0.5 of it:" in note
    corrected["extrapolated"] |= {"least": {"vertical_max": 4.0}, "halved": ["down", "up"]}
    note = validity.estimate_table(RunRecord(error_estimate=corrected)).note
    assert (
        "V of down, up is 0.5 of what halved elements at the tip change, 1 % at least. Other V is 4 % at least" in note
    )
    assert "0.25 %" in table.note
    none = validity.estimate_table(RunRecord(error_estimate={"estimate_pct": {}, "why_not": "no path in common"}))
    assert none is not None and none.rows == [("no estimate: no path in common",)]
    assert validity.estimate_table(RunRecord()) is None and validity.estimate_table(None) is None


def test_write_report_reads_the_folder_of_a_run(result: xr.DataTree, springs: xr.DataTree, tmp_path: Path) -> None:
    from pysprings.core.storage import write_tree
    from pysprings.springs.checks import save_springs

    own = result.copy()
    own.attrs["run_json"] = RUN.as_json()
    write_tree(own, tmp_path / "full_model.nc")
    save_springs(springs, tmp_path / "springs.nc")
    (tmp_path / "run.json").write_text(RUN.as_json(), encoding="utf-8")
    pd.DataFrame([{"path": "pull", "springs": "py", "eta_large": 0.25}]).to_csv(tmp_path / "compare.csv", index=False)
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "mesh.png").write_bytes(PIXEL)
    file = report.write_report(tmp_path)
    page = Page(file.read_text(encoding="utf-8"))
    assert file == tmp_path / "report.html"
    assert page.row("pullpy") == "pullpy0.2500"
    assert len([tag for tag, _ in page.tags if tag == "img"]) == 2
    assert {each.name for each in tmp_path.iterdir()} == {
        "full_model.nc",
        "springs.nc",
        "run.json",
        "compare.csv",
        "figures",
        "report.html",
    }


# ---------------------------------------------------------------- the sketch


def test_sketch_is_valid_svg_with_the_signs() -> None:
    root = ET.fromstring(SKETCH.read_text(encoding="utf-8"))
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    words = " ".join("".join(text.itertext()) for text in root.iter("{http://www.w3.org/2000/svg}text"))
    for rule in ("u_x(z) = u − rotation·z", "M = H·h", "H = Σ p dz + H_tip + H_lid", "compression positive", "θ = 0"):
        assert rule in words
    _, _, width, height = (float(v) for v in root.attrib["viewBox"].split())
    for text in root.iter("{http://www.w3.org/2000/svg}text"):
        assert 0 <= float(text.attrib["x"]) <= width
        assert 0 <= float(text.attrib["y"]) <= height


def test_the_picture_in_the_docs_is_the_current_sketch() -> None:
    assert (ROOT / "docs" / "axes.svg").read_bytes() == SKETCH.read_bytes(), f"copy {SKETCH}"


def test_springs_by_depth_with_tip_and_lid(result: xr.DataTree, springs: xr.DataTree) -> None:
    table = spring_tables(springs)[0]
    path = on_slices(springs["paths/pull"].to_dataset())
    assert table.title == "Path pull: pull, calibration"
    assert len(table.rows) == path.sizes["depth"] + 2
    bounds = np.diff(path["depth_bounds"].values, axis=1)[:, 0]
    p = path["p"].values[:, -1]
    assert f"p carries {100.0 * (p @ bounds) / float(path['H'][-1]):.0f} % of H" in table.note
    net = p[3] * 1e-3
    outside, inside, total = (float(cell) for cell in table.rows[3][3:6])
    assert total == pytest.approx(net, rel=1e-3)
    assert outside + inside == pytest.approx(total, rel=2e-3)
    assert table.rows[-1][0] == "lid"
    assert table.rows[-2][5] == f"H {number(float(path['H_tip'][-1]) * 1e-3)} kN"
    assert "p net [kN/m]" in report.render(ReportData(result, springs))
    assert spring_tables(None) == []


def test_the_table_of_springs_shows_the_path_that_a_beam_takes() -> None:
    """A pure translation for calibration, wherever it stands in the file; never a held-back or a vertical path."""
    tree = fans.fan_springs(fans.potential)
    names = list(tree["paths"].children)
    held = tree[f"paths/{names[0]}"].to_dataset().assign_attrs(role="held-back", kind="translation")
    groups = {"/": tree.to_dataset(inherit=False), "/paths/held": held}
    for name in reversed(names):
        path = tree[f"paths/{name}"].to_dataset()
        groups[f"/paths/{name}"] = path.assign_attrs(end_rotation_rad=float(path["rotation"][-1]))
    (table,) = spring_tables(xr.DataTree.from_dict(groups), compare(tree))
    path = tree["paths"].children[table.title.removeprefix("Path ").split(":")[0]]
    assert path.attrs["role"] == "calibration" and abs(float(path["rotation"][-1])) < 1e-9 < abs(float(path["u"][-1]))
    rows = compare(tree).set_index(["path", "springs"])["H_error_max_pct"]
    assert f"its p-y curves alone are off the load of path {path.name} by {rows[path.name, 'py']:+.0f} %" in table.note
    groups = {name: each.assign_attrs(role="held-back") for name, each in groups.items()}
    assert spring_tables(xr.DataTree.from_dict(groups)) == []


@pytest.mark.slow
def test_without_pictures_it_loads_no_matplotlib(result: xr.DataTree, tmp_path: Path) -> None:
    write_tree(result, tmp_path / "full_model.nc")
    code = (
        "import sys; from pysprings.results.report.page import write_report\n"
        f"write_report({str(tmp_path)!r})\n"
        "print('matplotlib' in sys.modules, 'jinja2' in sys.modules)"
    )
    done = run_python("-c", code)
    assert done.stdout.split() == ["False", "True"], done.stderr


def test_words_between_backticks_are_code_and_no_backtick_is_left(result: xr.DataTree, springs: xr.DataTree) -> None:
    assert report.marked("run `predict <OUT>` & go") == "run <code>predict &lt;OUT&gt;</code> &amp; go"
    text = report.render(ReportData(result, springs))
    assert "<code>predict</code>" in text and "<code>--extrapolate</code>" in text
    assert "`" not in text


def test_figures_fill_the_width_of_a_printed_page(result: xr.DataTree) -> None:
    style = report.render(ReportData(result)).split("@media print {")[1].split("</style>")[0]
    (rule,) = re.findall(r"^\s*figure img \{(.*?)\}", style, re.M)
    assert "width: 100%" in rule and "object-fit: contain" in rule
