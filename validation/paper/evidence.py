# SPDX-License-Identifier: MIT
"""Store the paper's figures and tables as evidence, from the folder of a study.

``python -m validation.paper.evidence DIR`` after ``python -m validation.paper --sensitivity --out DIR``
(`make paper-evidence`). Tables go to ``data/evidence``, pictures to ``docs/evidence/paper``; the page shows them.
"""

import argparse
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

from pysprings.core.storage import replacing
from pysprings.results.plots.style import STYLE
from tools.evidence_store import DATA, LINE, store, tables_in, to_csv
from validation.paper import figures, idealisations, runs, study, text

DPI = 75
PICTURES = Path(__file__).resolve().parents[2] / "docs" / "evidence" / "paper"


def write(source: Path, mesh: str, data: Path = DATA, pictures: Path = PICTURES) -> list[Path]:
    """Store tables and pictures of a study; return the paths of the tables."""
    ended = runs.load_runs(source, mesh)
    if not ended:
        raise SystemExit(f"{source}: no runs of this version on the mesh {mesh}")
    drawn = list(figures.draw_all(ended))
    for drawing, figure in drawn:
        _save(figure, pictures / f"{drawing.stem}.png")
    heads, rows = idealisations.rows_for_people(idealisations.compare({name: run.path for name, run in ended.items()}))
    ((_, claims),) = tables_in(text.claims_markdown(study.read_claims(source)))
    tables = {
        "paper-claims": claims,
        "paper-idealisations": [heads, *rows],
    }
    attrs = next(iter(ended.values())).result.attrs
    note = f"Mesh `{mesh}`: {attrs['n_nodes']:,} nodes, {attrs['n_elements']:,} elements"
    readings = study.read_sensitivity(source)
    if readings is not None:
        names = ("paper-sensitivity-drained", "paper-sensitivity-water")
        tables |= zip(names, (table for _, table in tables_in(text.sensitivity_markdown(readings))), strict=False)
        tables["paper-conclusion"] = [[LINE], [text.conclusion(readings)]]
        note += f"; sensitivities on `{readings['mesh'].iloc[0]}`"
    texts = {stem: to_csv(table) for stem, table in tables.items()}
    return store("paper", texts, f"make paper MESH={mesh} SENSITIVITY=1", f"{note}.", data)


def _save(figure: Figure, file: Path) -> None:
    """Write a small PNG."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with mpl.rc_context(STYLE), replacing(file) as temporary:
        figure.savefig(temporary, dpi=DPI)


def main() -> None:
    """Read the options, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="folder of the study")
    parser.add_argument("--mesh", default="medium", help="mesh preset of its runs")
    given = parser.parse_args()
    for path in write(given.folder, given.mesh):
        print(path)


if __name__ == "__main__":
    main()
