# SPDX-License-Identifier: MIT
"""The workbook on paper: pages of LibreOffice, and charts that no page break cuts."""

import re
import shutil
import subprocess
from pathlib import Path

import openpyxl
import pytest

from pysprings.results.exporters import export
from tests.support import synthetic

OFFICE = shutil.which("soffice") or shutil.which("libreoffice")
PATHS = tuple(synthetic.Path(f"pull_{k}", arm=2.0 * k, size=8e-3, steps=60) for k in range(4))
MOST_PAGES = 3 + len(PATHS) + 7 + 3  # about, charts, data, stiffness


@pytest.fixture(scope="module")
def workbook(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("book") / "springs.xlsx"
    return Path(export(synthetic.make_springs(PATHS), "xlsx", file).files[0])


@pytest.mark.slow
def test_a_chart_lies_within_a_page_and_each_path_has_its_own(workbook: Path) -> None:
    sheet = openpyxl.load_workbook(workbook)["charts"]
    breaks = [0, *(each.id for each in sheet.row_breaks.brk)]
    pages = []
    for chart in sheet._charts:
        first, last = chart.anchor._from.row, chart.anchor.to.row
        page = sum(each <= first for each in breaks)
        assert last < [*breaks, 10**6][page]
        pages.append(page)
    assert len(pages) == 5 * len(PATHS)
    assert sorted(set(pages)) == list(range(1, len(PATHS) + 1))


@pytest.mark.slow
def test_a_long_sheet_prints_its_first_rows_and_states_it(workbook: Path) -> None:
    rows = 61 * len(PATHS)  # the initial state, too
    for name, head, number in (("p-y", 3, rows), ("base", 3, rows), ("tidy", 1, None)):
        sheet = openpyxl.load_workbook(workbook)[name]
        assert sheet.print_area.rpartition("$")[2] == str(head + 45)
        assert sheet.sheet_properties.pageSetUpPr.fitToPage
        assert sheet.page_setup.fitToHeight is None  # one page, the default of the format
        foot = sheet.oddFooter.left.text
        assert f"the first 45 of {number or sheet.max_row - head} rows are printed" in foot


@pytest.mark.slow
@pytest.mark.skipif(OFFICE is None, reason="no LibreOffice")
def test_it_opens_and_prints_on_few_pages(workbook: Path, tmp_path: Path) -> None:
    own = f"-env:UserInstallation={(tmp_path / 'own').as_uri()}"
    command = [str(OFFICE), own, "--headless", "--convert-to", "pdf", "--outdir", str(tmp_path), str(workbook)]
    subprocess.run(command, check=True, capture_output=True, timeout=300)
    pages = len(re.findall(rb"/Type\s*/Page\b", (tmp_path / "springs.pdf").read_bytes()))
    assert 12 <= pages <= MOST_PAGES
