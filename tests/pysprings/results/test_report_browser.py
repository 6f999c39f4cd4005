# SPDX-License-Identifier: MIT
"""The report in a real browser: what its scripts draw, what they complain of, and the pages that it prints on."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from pysprings.full_model.run_record import RunRecord
from pysprings.macro.comparison import compare
from pysprings.results.plots import save_all
from pysprings.results.report.page import write_report
from pysprings.scene.template import template_text
from tests.support import synthetic

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
pytestmark = [pytest.mark.slow, pytest.mark.skipif(BROWSER is None, reason="no Chromium")]
PATHS = (synthetic.Path("pull", arm=8.0, size=8e-3, steps=8), synthetic.Path("turn", "rotation", size=2e-3, steps=6))


def browse(*options: str) -> subprocess.CompletedProcess[str]:
    """Run the browser without a window, with a folder of its own."""
    command = [str(BROWSER), "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=20000", *options]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run")
    result, springs = synthetic.make_result(PATHS), synthetic.make_springs(PATHS)
    result.attrs |= {"outer_diameter_m": 7.8, "skirt_length_m": 4.0}
    result.attrs["scene_toml"] = template_text("paper-drained")
    figures = save_all(result, springs, folder / "figures")
    return write_report(folder, result, springs, figures=figures)


def test_the_parts_are_drawn_without_a_complaint(report: Path, tmp_path: Path) -> None:
    pytest.importorskip("plotly")
    done = browse(f"--user-data-dir={tmp_path}", "--enable-logging=stderr", "--dump-dom", report.as_uri())
    assert re.search(r'<body class="live" data-drawn="(\d+)"', done.stdout)
    # p-y and profiles, load and moment, tilt, contact stress and the moved caisson
    assert int(re.search(r'data-drawn="(\d+)"', done.stdout)[1]) == 7  # type: ignore[index]
    traces = done.stdout.count('class="trace scatter')
    assert traces > 20
    assert not [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    assert report.stat().st_size < 5e6


@pytest.fixture(scope="module")
def report_of_a_fan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The default scene has eight rays, two vertical paths and five pulls; as many lateral paths here."""
    folder = tmp_path_factory.mktemp("fan")
    paths = [synthetic.Path(f"pull_{k}", arm=float(k), size=8e-3, steps=8) for k in range(15)]
    result, springs = synthetic.make_result(tuple(paths)), synthetic.make_springs(tuple(paths))
    result.attrs |= {"outer_diameter_m": 7.8, "skirt_length_m": 4.0, "scene_toml": template_text("caisson")}
    figures = save_all(result, springs, folder / "figures")
    return write_report(folder, result, springs, compare(springs), figures=figures)


def printed(page: Path, folder: Path) -> Path:
    """Print a page as a browser does; return the PDF."""
    file = folder / "report.pdf"
    browse(f"--user-data-dir={folder / 'own'}", "--no-pdf-header-footer", f"--print-to-pdf={file}", page.as_uri())
    return file


@pytest.mark.parametrize("name", ["report", "report_of_a_fan"])
def test_it_prints_pictures_on_few_pages(name: str, request: pytest.FixtureRequest, tmp_path: Path) -> None:
    page = request.getfixturevalue(name)
    file = printed(page, tmp_path)
    pages = len(re.findall(rb"/Type\s*/Page\b", file.read_bytes()))
    assert 4 <= pages <= 12
    assert page.stat().st_size < 5e6


@pytest.mark.skipif(shutil.which("pdftotext") is None, reason="no pdftotext")
def test_the_widest_table_is_whole_on_paper(report_of_a_fan: Path, tmp_path: Path) -> None:
    file = printed(report_of_a_fan, tmp_path)
    box = subprocess.run(["pdftotext", "-bbox", str(file), "-"], capture_output=True, text=True, check=True).stdout
    width = max(float(each) for each in re.findall(r'<page width="([\d.]+)"', box))
    right = [float(each) for each in re.findall(r'<word [^>]*xMax="([\d.]+)"', box)]
    assert len(right) > 500
    assert max(right) < width - 28.0  # pt: inside the margin of 14 mm


@pytest.mark.skipif(shutil.which("pdftotext") is None, reason="no pdftotext")
def test_values_of_inputs_are_not_cut_beside_long_keys(tmp_path: Path) -> None:
    """A default whose key fills the column leaves room for a number and a word in one line."""
    values = {"interface.transversal_conductivity": "1e-08 m/(Pa s)", "interface.normal_stiffness": "2.925e+09 N/m^3",
              "interface.opening": "vented in part"}  # fmt: skip
    run = RunRecord(defaulted=[{"key": key, "value": value, "unit": ""} for key, value in values.items()])
    page = write_report(tmp_path, synthetic.make_result(PATHS), synthetic.make_springs(PATHS), run=run)
    file = printed(page, tmp_path)
    words = subprocess.run(["pdftotext", str(file), "-"], capture_output=True, text=True, check=True).stdout.split()
    assert {"1e-08", "2.925e+09", "N/m^3", "vented"} <= set(words)
