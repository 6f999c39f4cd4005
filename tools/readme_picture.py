# SPDX-License-Identifier: MIT
"""Draw the picture of the README, store the errors of the fan: ``python -m tools.readme_picture DIR``.

DIR is a run of the template `fan` on the mesh `coarse` (`make figure`). The picture compares the full model with the
macro-model on a held-back pull: the fan of the calibration paths, and the p-y springs alone.
"""

import argparse
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

import pysprings
from pysprings.core.storage import replacing
from pysprings.results.plots.style import STYLE
from tools.evidence_store import store, to_csv

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "load_displacement.png"
PATH = "pull_1_D"
ARM = 7.8  # m, height of the load of that path above mudline
SETS = {"fan": ("macro-model, fan of load paths", "tab:green", "--"), "py": ("p-y springs alone", "tab:red", ":")}

ERRORS = ("H_error_max_pct", "rotation_error_max_pct")
ALONE = ("H, p-y alone [%]", "rotation, p-y alone [%]")

BENT = {
    "climb": "1 MN at mudline, then raised to one diameter (`arm_from`)",
    "swipe": "lid centre moved by 5 mm and held, caisson turned back by 2 mrad (`swipe`)",
}


def draw(folder: Path, path: str = PATH, arm: float = ARM) -> Figure:
    """Return load over displacement of a path, full model and macro-model, and the rotation that belongs to it."""
    table = pd.read_csv(folder / "load_displacement.csv")
    full = table[(table["path"] == path) & (table["converged"] == 1)]
    if full.empty:
        raise SystemExit(f"{folder}: no converged rows of the path {path}")
    springs = pysprings.open_springs(folder / "springs.nc")
    figure = Figure(figsize=(8.0, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(1e3 * full["u_m"], 1e-3 * full["H_N"], "o-", color="black", markersize=3, label="full model")
    right.plot(1e3 * full["u_m"], 1e3 * full["rotation_rad"], "o-", color="black", markersize=3)
    for name, (label, colour, dash) in SETS.items():
        curve = pysprings.curve(springs, u_max=float(full["u_m"].max()), arm=arm, springs_kind=name)
        u = 1e3 * np.asarray(curve["u"])
        left.plot(u, 1e-3 * np.asarray(curve["H"]), dash, color=colour, linewidth=2.2, label=label)
        right.plot(u, 1e3 * np.asarray(curve["rotation"]), dash, color=colour, linewidth=2.2)
    left.set(xlabel="u of the lid centre [mm]", ylabel="lateral load H [kN]", xlim=(0, None), ylim=(0, None))
    right.set(xlabel="u of the lid centre [mm]", ylabel="rotation [mrad]", xlim=(0, None))
    left.legend(loc="upper left", fontsize=8)
    return figure


def errors(folder: Path) -> list[list[str]]:
    """Return the table of errors of the held-back pulls under the vertical load of the scene, heads first."""
    table = pd.read_csv(folder / "compare.csv")
    pulls = table[(table["role"] == "held-back") & (table["kind"] == "pull") & (table["off_load_states"] == 0)]
    rows = [["load height [m]", "H [%]", "rotation [%]", "eta small", "eta large", "u at equal load [%]", *ALONE]]
    for arm, part in pulls.groupby("arm_m"):
        fan, alone = (part[part["springs"] == each].iloc[0] for each in SETS)
        rows.append([
            f"{arm:g}", *(f"{fan[column]:+.2f}" for column in ERRORS), f"{fan['eta_small']:.3f}",
            f"{fan['eta_large']:.3f}",
            f"{fan['u_error_max_pct']:+.2f}", *(f"{alone[column]:+.0f}" for column in ERRORS),
        ])  # fmt: skip
    return rows


def unproportional(folder: Path) -> list[list[str]]:
    """Return the errors of the fan on paths whose H and M do not grow in proportion, heads first."""
    table = pd.read_csv(folder / "compare.csv")
    rows = [["path at constant V", "H, over its largest", "M, over its largest"]]
    for name, words in BENT.items():
        (row,) = table[(table["path"] == name) & (table["springs"] == "fan")].to_dict(orient="records")
        rows.append([words, *(f"{abs(row[f'{load}_error_max_pct']):.0f} %" for load in "HM")])
    return rows


def main() -> None:
    """Read the options, write the picture and the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="folder of a run of the template `fan`")
    parser.add_argument("--out", type=Path, default=PICTURE, help="picture to write")
    given = parser.parse_args()
    with mpl.rc_context(STYLE), replacing(given.out) as temporary:
        draw(given.folder).savefig(temporary, dpi=100, format="png")
    print(given.out)
    tables = {"fan-coarse": to_csv(errors(given.folder)), "fan-unproportional": to_csv(unproportional(given.folder))}
    for path in store("fan", tables, "make figure", "Mesh `coarse`."):
        print(path)


if __name__ == "__main__":
    main()
