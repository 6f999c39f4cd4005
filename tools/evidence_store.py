# SPDX-License-Identifier: MIT
"""Store results as evidence: ``python -m tools.evidence_store NAME FILE --command "..." [--note ...]``.

FILE is a CSV file, or a Markdown document whose tables and lists are stored one by one. The data go to
``data/evidence/NAME.csv``, or ``NAME-SECTION.csv`` for a section of a document; the command, the version and the
date go to ``data/evidence/origins.json``. Pages of docs/evidence link to these files, and
the site shows them as tables.
"""

import argparse
import csv
import io
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path

from pysprings.core.storage import write_text
from pysprings.core.version import __version__

DATA = Path(__file__).resolve().parents[1] / "data" / "evidence"
ORIGINS = "origins.json"
LINE = "line"  # head of the only column of a stored list
Table = list[list[str]]


def tables_in(text: str) -> Iterator[tuple[str, Table]]:
    """Yield (slug of the section, table with its heads) for tables and lists of a Markdown document."""
    section, rows = "", list[list[str]]()
    for line in [*text.splitlines(), ""]:
        if line.startswith("|"):
            rows.append([cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1]])
        elif line.startswith("- "):
            rows = rows or [[LINE], [""]]
            rows.append([line[2:].strip()])
        elif rows:
            yield section, [rows[0], *rows[2:]]
            rows = []
        if line.startswith("## "):
            section = re.sub(r"[^a-z0-9]+", "-", line[3:].lower()).strip("-")


def to_csv(rows: Sequence[Sequence[str]]) -> str:
    """Return rows as CSV text."""
    stream = io.StringIO()
    csv.writer(stream, lineterminator="\n").writerows(rows)
    return stream.getvalue()


def read_tables(name: str, source: Path) -> dict[str, str]:
    """Return stem -> CSV text of a CSV file, or of the tables and lists of a Markdown document."""
    text = source.read_text(encoding="utf-8")
    if source.suffix == ".csv":
        return {name: text}
    tables: dict[str, str] = {}
    for section, table in tables_in(text):
        first = stem = "-".join(filter(None, (name, section)))
        count = 1
        while stem in tables:
            count += 1
            stem = f"{first}-{count}"
        tables[stem] = to_csv(table)
    return tables


def store(name: str, tables: Mapping[str, str], command: str, note: str = "", data: Path = DATA) -> list[Path]:
    """Write tables (stem -> CSV text) and their origin below ``data``; return the paths of the tables."""
    file = data / ORIGINS
    origins = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    date = datetime.now(UTC).date().isoformat()
    origins[name] = {"command": command, "version": __version__, "date": date, "note": note}
    write_text(json.dumps(dict(sorted(origins.items())), indent=1) + "\n", file)
    return [write_text(rows, data / f"{stem}.csv") for stem, rows in tables.items()]


def main() -> None:
    """Read the options, store."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", help="name of the data set")
    parser.add_argument("file", type=Path, help="CSV file or Markdown document")
    parser.add_argument("--command", required=True, help="the command that made the file")
    parser.add_argument("--note", default="", help="a sentence about the conditions, such as the machine")
    given = parser.parse_args()
    tables = read_tables(given.name, given.file)
    if not tables:
        raise SystemExit(f"{given.file}: no table and no list")
    print(*store(given.name, tables, given.command, given.note), sep="\n")


if __name__ == "__main__":
    main()
