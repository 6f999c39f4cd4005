# SPDX-License-Identifier: MIT
"""Make the pages of docs/evidence from committed results: ``python -m benchmarks.evidence`` (`make evidence`).

A page is a template in ``benchmarks/evidence_pages`` whose tables come from ``data/evidence``; the generator computes
nothing and runs nothing. Each page names the command, version and date of the data that it shows. New results enter
with `benchmarks.evidence_store`.
"""

from __future__ import annotations

import argparse
import csv
import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from benchmarks.evidence_store import DATA, LINE, ORIGINS
from pysprings.core.files.storage import write_text
from pysprings.core.text import markdown_table

ROOT = Path(__file__).resolve().parents[1]
TEMPLATES = ROOT / "benchmarks" / "evidence_pages"
PAGES = ROOT / "docs" / "evidence"
MARK = "<!-- Made by `make evidence` from data/evidence. Do not edit. -->"


class Page:
    """What a template may call; it collects the origins of the data that the page shows."""

    def __init__(self, data: Path) -> None:
        self.data = data
        self.origins: dict[str, dict[str, str]] = json.loads((data / ORIGINS).read_text(encoding="utf-8"))
        self.used: list[str] = []

    def rows(self, name: str) -> list[list[str]]:
        """Return a data set as rows of text, the heads first; every row must be as long as the heads."""
        origin = max((known for known in self.origins if name.startswith(known)), key=len)
        if origin not in self.used:
            self.used.append(origin)
        with (self.data / f"{name}.csv").open(newline="", encoding="utf-8") as stream:
            rows = list(csv.reader(stream))
        if ragged := [row for row in rows if len(row) != len(rows[0])]:
            raise ValueError(f"{name}.csv: {len(ragged)} rows have not the {len(rows[0])} columns of the heads")
        return rows

    def table(self, name: str, columns: int | None = None, numbers: bool = False) -> str:
        """Return a data set as a table (a list if it is one): its first columns, or all."""
        heads, *rows = self.rows(name)
        if heads == [LINE]:
            return "\n".join(f"- {row[0]}" for row in rows)
        return markdown_table(heads[:columns], [row[:columns] for row in rows], numbers).rstrip("\n")

    def count(self, name: str, column: str = "", value: str = "") -> int:
        """Return how many rows a data set has, or how many have a value in a column."""
        heads, *rows = self.rows(name)
        return len(rows) if not column else sum(row[heads.index(column)] == value for row in rows)

    def figures(self, name: str) -> list[list[str]]:
        """Return file and caption of the pictures that a data set lists."""
        return self.rows(name)[1:]

    def origin(self) -> str:
        """Return the origins of everything that the page has shown, as a list."""
        lines = []
        for name in self.used:
            origin = self.origins[name]
            note = f" {origin['note']}" if origin["note"] else ""
            lines.append(f"- `{name}`: `{origin['command']}`, version {origin['version']}, {origin['date']}.{note}")
        return "\n".join(lines)


def render(template: str, data: Path = DATA) -> str:
    """Return the page of a template: its title, the origin of its data, its text."""
    page = Page(data)
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES), undefined=StrictUndefined, keep_trailing_newline=True, autoescape=False
    )
    calls: dict[str, Any] = {name: getattr(page, name) for name in ("table", "count", "figures")}
    title, _, text = environment.get_template(template).render(calls).partition("\n")
    return f"{MARK}\n\n{title}\n\nData on this page:\n\n{page.origin()}\n{text}"


def pages(data: Path = DATA) -> dict[str, str]:
    """Return file name -> text of all pages."""
    return {file.name: render(file.name, data) for file in sorted(TEMPLATES.glob("*.md"))}


def write_pages(text: str, folder: Path, make: Callable[[], Mapping[str, str]]) -> None:
    """Write the pages of a command that takes an output folder; print the file names."""
    parser = argparse.ArgumentParser(description=text)
    parser.add_argument("--out", type=Path, default=folder, help="folder of the pages")
    given = parser.parse_args()
    for name, page in make().items():
        print(write_text(page, given.out / name))


if __name__ == "__main__":
    write_pages(__doc__, PAGES, pages)
