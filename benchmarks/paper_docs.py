# SPDX-License-Identifier: MIT
"""Write docs/paper.md and its pictures from the folder of a study.

``python -m benchmarks.paper_docs DIR`` after ``pysprings paper --sensitivity --out DIR``: see `make docs`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

from pysprings.markdown import markdown
from pysprings.paper import figures, idealisations, runs, study, text
from pysprings.plots.style import STYLE
from pysprings.storage import replacing, write_text

DPI = 75
HEAD = """# The paper, computed anew

B. Cerfontaine, R. Charlier and F. Collin (2018), *Modelling of the lateral loading of bucket foundations in sand using
hydro-mechanical interface elements*, NUMGE 2018, 1519-1528. Written by `make docs` from `pysprings paper --mesh {mesh}
--sensitivity`; all drawings are our own. Axes: the paper's y is the loading direction (x here), its z points up.

`pysprings paper` runs six pulls at the lid centre to 20 mm (drained, 0.05 and 0.5 mm/s, each with friction 0.5 and 0),
two more with elastic steel and with Van Eekelen's surface, draws the paper's figures, and sets each of its claims
beside our figure. A run that has ended is not run again, an interrupted one goes on.
Mesh `{mesh}`: {nodes} nodes, {elements} elements.

## Claims

{claims}
## What our idealisations change

{idealised}
## What decides them

Mesh `{sensitivity_mesh}`, one value changed at a time.

{sensitivity}
## Figures
"""


def write(source: Path, docs: Path, mesh: str) -> Path:
    """Write paper.md and the folder paper with its pictures below docs; return the page."""
    ended = runs.load_runs(source, mesh)
    if not ended:
        raise SystemExit(f"{source}: no runs of this version on the mesh {mesh}")
    table = study.read_sensitivity(source)
    compared = idealisations.compare({name: run.path for name, run in ended.items()})
    attrs = next(iter(ended.values())).result.attrs
    page = HEAD.format(
        mesh=mesh, nodes=f"{attrs['n_nodes']:,}", elements=f"{attrs['n_elements']:,}",
        claims=text.claims_markdown(study.read_claims(source)),
        idealised=f"{idealisations.NOTE}\n\n{markdown(*idealisations.rows_for_people(compared))}",
        sensitivity_mesh=mesh if table is None else table["mesh"].iloc[0],
        sensitivity="Not run." if table is None else text.sensitivity_markdown(table),
    )  # fmt: skip
    for drawing, figure in figures.draw_all(ended):
        _save(figure, docs / "paper" / f"{drawing.stem}.png")
        page += f"\n{drawing.caption}:\n\n![{drawing.caption}](paper/{drawing.stem}.png)\n"
    return write_text(page, docs / "paper.md")


def _save(figure: Figure, file: Path) -> None:
    """Write a small PNG."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with mpl.rc_context(STYLE), replacing(file) as temporary:
        figure.savefig(temporary, dpi=DPI)


def main() -> None:
    """Read the options, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="folder of `pysprings paper`")
    parser.add_argument("--mesh", default="medium", help="mesh preset of its runs")
    parser.add_argument("--docs", type=Path, default=Path("docs"), help="folder of the documentation")
    given = parser.parse_args()
    print(write(given.folder, given.docs, given.mesh))


if __name__ == "__main__":
    main()
