# SPDX-License-Identifier: MIT
"""Run the commands of the tutorials and the first-run page, store what they print: ``python -m tools.tutorials``.

Each page is run in a folder of its own with the files `data/tutorials/PAGE-*`, its scenes (blocks that begin with
``title``) under the name that its commands have. What the commands print goes to ``data/tutorials/PAGE.txt``;
`tests/docs/test_numbers.py` compares the numbers of the pages with it. Ten minutes; ``--only PAGE`` runs one.
"""

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
STORED = ROOT / "data" / "tutorials"
PAGES = {
    page.stem: page
    for page in (ROOT / "docs/start/first-run.md", *sorted((ROOT / "docs/tutorials").glob("*.md")))
    if page.stem != "index"
}
# beside the commands of a page: where its numbers of other files come from
MORE = {
    "sand": ["compare sand", 'predict sand --H "800 kN" --arm "20 m"'],
    "clay": ["compare clay"],
    "layered": ['predict layered --H "2 MN" --arm "10 m"'],
    "partially-drained": ["compare slow"],
}


def blocks(page: Path, language: str) -> list[str]:
    """Return the code blocks of a language."""
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S)


def commands(name: str) -> list[str]:
    """Return the command lines of a page, without the name of the program, and the further ones."""
    lines = [line.strip() for block in blocks(PAGES[name], "bash") for line in block.splitlines()]
    return [line.removeprefix("pysprings ") for line in lines if line.startswith("pysprings ")] + MORE.get(name, [])


def printed(name: str) -> str:
    """Return what the commands of a page print, each behind its line; a run with its table of loads."""
    lines = commands(name)
    with tempfile.TemporaryDirectory() as folder:
        scenes = [block for block in blocks(PAGES[name], "toml") if block.startswith("title")]
        files = [word for line in lines for word in line.split() if word.endswith(".toml")]
        for file in STORED.glob(f"{name}-*"):
            shutil.copy(file, folder)
        for text in scenes:
            (Path(folder) / files[0]).write_text(text, encoding="utf-8")
        parts = []
        for line in lines:
            done = subprocess.run(
                f"{sys.executable} -m pysprings {line}", shell=True, cwd=folder, capture_output=True, text=True
            )
            if done.returncode:
                raise SystemExit(f"{name}: {line}: exit {done.returncode}\n{done.stderr}")
            progress = re.compile(r"^.*\d+ ?%.*step \d+.*$", re.M)
            parts.append(f"$ pysprings {line}\n{done.stdout}{progress.sub('', done.stderr)}")
        for file in sorted(Path(folder).glob("*/load_displacement.csv")):
            parts.append(f"$ {file.parent.name}/load_displacement.csv\n{_ends(file)}")
    return re.sub(r"\n{3,}", "\n\n", "\n".join(parts))


def _ends(file: Path) -> str:
    """Return the rows of a table of loads at 2.5 mm and at the end of each path."""
    import pandas as pd

    table = pd.read_csv(file)
    parts = (part for _, part in table.groupby("path", sort=False))
    rows = [part.iloc[[int((part["u_m"] - 2.5e-3).abs().argmin()), -1]] for part in parts]
    return pd.concat(rows)[["path", "u_m", "H_N", "M_Nm", "F_pw_N"]].to_csv(index=False, float_format="%.5g")


def main() -> None:
    """Run the pages and store what they print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", choices=PAGES)
    given = parser.parse_args()
    for name in [given.only] if given.only else PAGES:
        (STORED / f"{name}.txt").write_text(printed(name), encoding="utf-8")
        print(STORED / f"{name}.txt", flush=True)


if __name__ == "__main__":
    main()
