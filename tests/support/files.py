# SPDX-License-Identifier: MIT
"""Read what a run leaves: its record, all bytes of its folder, its report."""

import json
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import xarray as xr

import pysprings.results.folder
from pysprings.results.exporters.csv import write_frame


def record_of(result: xr.DataTree) -> dict[str, Any]:
    """Return the record that a result carries."""
    record: dict[str, Any] = json.loads(result.attrs["run_json"])
    return record


def read_record(folder: Path) -> dict[str, Any]:
    """Return run.json of a folder."""
    record: dict[str, Any] = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    return record


def contents(folder: Path) -> dict[str, bytes]:
    """Return path within the folder -> bytes, of every file."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def fail_comparison(patch: pytest.MonkeyPatch, error: BaseException) -> None:
    """Have a run raise an error where it writes its comparison."""

    def fails(frame: pd.DataFrame, file: Path) -> Path:
        if file.name == "compare.csv":
            raise error
        return write_frame(frame, file)

    patch.setattr(pysprings.results.folder, "write_frame", fails)


class Page(HTMLParser):
    """Tags with their attributes, and the text, of a page; tags that do not close are an error."""

    VOID = ("meta", "img", "br", "link", "input", "hr")

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.open: list[str] = []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data

    @property
    def pictures(self) -> list[str]:
        """Alternative texts of the pictures."""
        return [str(attrs["alt"]) for tag, attrs in self.tags if tag == "img"]

    def row(self, first: str) -> str:
        """Return the text of the row that starts with these words."""
        lines = [" ".join(line.split()) for line in self.text.split("\n")]
        return next(line for line in lines if line.startswith(first))


class Outline(HTMLParser):
    """A page as lines: a line for each tag with its attributes, cells of a row beside each other, texts as they are."""

    CELLS, HIDDEN = ("td", "th"), ("style", "script")

    def __init__(self, text: str) -> None:
        super().__init__()
        self.lines: list[str] = []
        self.hidden = 0
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.hidden += tag in self.HIDDEN
        words = [f"{key}={str(value).partition(',')[0]!r}" for key, value in attrs]
        name = " ".join([tag, *words])
        if tag in self.CELLS:
            self.lines[-1] += f" |{'' if name == 'td' else f'[{name}]'} "
        else:
            self.lines.append(f"<{name}> ")

    def handle_endtag(self, tag: str) -> None:
        self.hidden -= tag in self.HIDDEN

    def handle_data(self, data: str) -> None:
        if not self.hidden and data.strip():
            self.lines[-1] += " ".join(data.split())


def read_report(folder: Path) -> Page:
    """Return report.html of a folder."""
    return Page((folder / "report.html").read_text(encoding="utf-8"))
