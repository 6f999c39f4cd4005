# SPDX-License-Identifier: MIT
"""Elastic caisson, push with contact and macro-model in pysprings, OpenSees, CalculiX and Kratos, in one go.

    make bench-peers

Answer, time and memory of each program, and what it lacks, as Markdown; missing programs are listed. The first two are
in `problem` (one mesh for all). The springs of the macro-model are those of a run of the template `fan` (RESULT), as
`pysprings export` writes them; each program carries H at one height. Times are those of a whole process on one thread,
its start included, but for `predict`, whose compiled loops are loaded.
"""

import argparse
import tempfile
from pathlib import Path

from benchmarks.peers import finite, macro
from benchmarks.peers.timed import versions
from pysprings import open_springs
from pysprings.results.exporters import Source


def show(title: str, words: str, heads: list[str], rows: list[list[str]]) -> None:
    """Print a section with a table."""
    print(f"## {title}\n\n{words}\n")
    for cells in (heads, ["---"] * len(heads), *rows):
        print(f"| {' | '.join(cells)} |")
    print(flush=True)


def main() -> None:
    """Print the answers of all programs that are there, and the missing ones."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("result", type=Path, nargs="?", help="folder of a run of the template fan, or its springs.nc")
    given = parser.parse_args()
    there = versions()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        rows = finite.table("elastic", there, folder)
        show("Elastic", f"Stiffness H/u, M/u of a bonded caisson; {finite.sizes(folder)}.", finite.HEADS, rows)
        for case, words in (("smooth", "without friction"), ("rough", "friction 0.3")):
            rows = finite.table(case, there, folder)
            show(case.title(), f"Push of 2 mm with contact, {words}.", finite.HEADS, rows)
        if given.result is None or not given.result.exists():
            print("The macro-model is left out: there is no run of the template fan (`make figure`).")
        else:
            file = given.result / "springs.nc" if given.result.is_dir() else given.result
            rows = macro.table(Source(open_springs(file)), there, folder)
            words = f"H = {macro.H / 1e6:g} MN at {macro.ARM:g} m, tables of {macro.POINTS} points."
            show("Macro", words, macro.HEADS, rows)
    missing = [name for name, version in there.items() if version is None]
    print(f"missing: {', '.join(missing) or 'none'}")


if __name__ == "__main__":
    main()
