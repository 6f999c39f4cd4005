# SPDX-License-Identifier: MIT
"""The report in a real browser: what its scripts draw, what they complain of, and the pages that it prints on."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

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


def test_it_prints_pictures_on_few_pages(report: Path, tmp_path: Path) -> None:
    file = tmp_path / "report.pdf"
    browse(f"--user-data-dir={tmp_path / 'own'}", "--no-pdf-header-footer", f"--print-to-pdf={file}", report.as_uri())
    pages = len(re.findall(rb"/Type\s*/Page\b", file.read_bytes()))
    assert 4 <= pages <= 12
