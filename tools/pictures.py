# SPDX-License-Identifier: MIT
"""Pictures of the documentation: ``python -m tools.pictures figure|small|screenshots [RUN]`` (`make figure`).

figure: RUN is the template `fan` on the mesh `coarse`. Draws the picture of the README, full model beside macro-model
on a held-back pull (the fan of the calibration paths, and the p-y springs alone), and the small pictures; stores the
errors of the fan as evidence. small: the small pictures of docs/reference/pictures.md that RUN holds data for.

screenshots: pages of the site in out/site (`make gallery` builds it with the pictures of the examples), the page of
`explore`, the report of RUN and printed pages of its workbook, in docs/evidence/site, a PNG of less than 200 kB each.
What is not there is left as it is. Chromium draws pages, LibreOffice and pdftoppm (poppler-utils) print the workbook.
"""

import argparse
import shutil
import subprocess
import sys
import tempfile
from io import BytesIO
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from PIL import Image

import pysprings
from pysprings.core.storage import replacing
from pysprings.results.plots.draw import drawable
from pysprings.results.plots.style import STYLE
from tools.evidence_store import store

ROOT = Path(__file__).resolve().parents[1]
README, SMALL = ROOT / "docs" / "load_displacement.png", ROOT / "docs" / "reference" / "pictures"
PATH, ARM = "pull_1_D", 7.8  # of the picture of the README; m, height of its load above mudline
SETS = {"fan": ("macro-model, fan of load paths", "tab:green", "--"), "py": ("p-y springs alone", "tab:red", ":")}
ERRORS = {"H": "H_error_max_pct", "rotation": "rotation_error_max_pct"}
BENT = {
    "climb": "1 MN at mudline, then raised to one diameter (`arm_from`)",
    "swipe": "lid centre moved by 5 mm and held, caisson turned back by 2 mrad (`swipe`)",
}

SITE, SHOTS = ROOT / "out" / "site", ROOT / "docs" / "evidence" / "site"
PAGES = {
    "landing": "index.html",
    "ten-minutes": "start/first-run.html",
    "tutorial-clay": "tutorials/clay.html",
    "gallery": "gallery/index.html",
    "function": "reference/api/pysprings.predict.html",
}
SHEETS = {"workbook-about": 1, "workbook-charts": 6}  # name -> printed page
MOST_BYTES = 200_000
WAIT = "--virtual-time-budget=15000"  # ms, for what a page asks of its server


def load_displacement(folder: Path) -> Figure:
    """Return load and rotation over displacement of the path of the README, full model and macro-model."""
    table = pd.read_csv(folder / "load_displacement.csv")
    full = table[(table["path"] == PATH) & (table["converged"] == 1)]
    if full.empty:
        raise SystemExit(f"{folder}: no converged rows of the path {PATH}")
    springs = pysprings.open_springs(folder / "springs.nc")
    figure = Figure(figsize=(8.0, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(1e3 * full["u_m"], 1e-3 * full["H_N"], "o-", color="black", markersize=3, label="full model")
    right.plot(1e3 * full["u_m"], 1e3 * full["rotation_rad"], "o-", color="black", markersize=3)
    for name, (label, colour, dash) in SETS.items():
        curve = pysprings.curve(springs, u_max=float(full["u_m"].max()), arm=ARM, springs_kind=name)
        u = 1e3 * np.asarray(curve["u"])
        left.plot(u, 1e-3 * np.asarray(curve["H"]), dash, color=colour, linewidth=2.2, label=label)
        right.plot(u, 1e3 * np.asarray(curve["rotation"]), dash, color=colour, linewidth=2.2)
    left.set(xlabel="u of the lid centre [mm]", ylabel="lateral load H [kN]", xlim=(0, None), ylim=(0, None))
    right.set(xlabel="u of the lid centre [mm]", ylabel="rotation [mrad]", xlim=(0, None))
    left.legend(loc="upper left", fontsize=8)
    return figure


def errors(table: pd.DataFrame) -> pd.DataFrame:
    """Return the errors of the held-back pulls under the vertical load of the scene."""
    pulls = table[(table["role"] == "held-back") & (table["kind"] == "pull") & (table["off_load_states"] == 0)]
    rows = []
    for arm, part in pulls.groupby("arm_m"):
        fan, alone = (part[part["springs"] == each].iloc[0] for each in SETS)
        row = {"load height [m]": f"{arm:g}"} | {f"{name} [%]": f"{fan[key]:+.2f}" for name, key in ERRORS.items()}
        row |= {f"eta {size}": f"{fan[f'eta_{size}']:.3f}" for size in ("small", "large")}
        row |= {"u at equal load [%]": f"{fan['u_error_max_pct']:+.2f}"}
        rows.append(row | {f"{name}, p-y alone [%]": f"{alone[key]:+.0f}" for name, key in ERRORS.items()})
    return pd.DataFrame(rows)


def unproportional(table: pd.DataFrame) -> pd.DataFrame:
    """Return the errors of the fan on paths whose H and M do not grow in proportion."""
    rows = []
    for name, words in BENT.items():
        (found,) = table[(table["path"] == name) & (table["springs"] == "fan")].to_dict(orient="records")
        sizes = {f"{load}, over its largest": f"{abs(found[f'{load}_error_max_pct']):.0f} %" for load in "HM"}
        rows.append({"path at constant V": words} | sizes)
    return pd.DataFrame(rows)


def figure(run: Path) -> list[Path]:
    """Write the pictures and tables of a run of the template `fan`; return their paths."""
    with mpl.rc_context(STYLE), replacing(README) as temporary:
        load_displacement(run).savefig(temporary, dpi=100, format="png")
    compared = pd.read_csv(run / "compare.csv")
    frames = {"fan-coarse": errors(compared), "fan-unproportional": unproportional(compared)}
    tables = {name: frame.to_csv(index=False, lineterminator="\n") for name, frame in frames.items()}
    return [README, *small(run), *store("fan", tables, "make figure", "Mesh `coarse`.")]


def small(run: Path) -> list[Path]:
    """Write the small pictures of a run; return their paths."""
    tree, written = pysprings.open_result(run), []
    for name in drawable(tree):
        stream = BytesIO()
        pysprings.plots.draw(tree, name).savefig(stream, format="png", dpi=100)
        written.append(shrink(stream, SMALL / f"{name}.png", 560, 64))
    return written


def shrink(raw: BytesIO | Path, target: Path, most: int = 10_000, colours: int = 256) -> Path:
    """Write a picture of at most so many pixels a side and so many colours; return its path."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with Image.open(raw) as picture:
        small = picture.convert("RGB")
        small.thumbnail((most, most))
        small.quantize(colours).save(target, optimize=True)
    if target.stat().st_size > MOST_BYTES:
        raise SystemExit(f"{target}: {target.stat().st_size} bytes, more than {MOST_BYTES}")
    return target


def shoot(page: Path | str, name: str, width: int = 1300, height: int = 1000) -> Path:
    """Write a picture of the top of an HTML page, a file or an address; return its path."""
    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if browser is None:
        raise SystemExit("no Chromium: apt-get install chromium")
    address = page if isinstance(page, str) else page.resolve().as_uri()
    with tempfile.TemporaryDirectory() as place:
        raw = Path(place) / "page.png"
        command = [browser, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
        command += [f"--window-size={width},{height}", f"--screenshot={raw}", WAIT, address]
        subprocess.run(command, check=True, capture_output=True, timeout=120)
        return shrink(raw, SHOTS / f"{name}.png")


def shoot_explored() -> Path:
    """Write a picture of the page of `pysprings explore`; return its path."""
    line = [sys.executable, "-m", "pysprings", "explore", "--atlas", "clay", "--port", "0"]
    with subprocess.Popen(line, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        try:
            return shoot(server.stdout.readline().strip(), "explore", 1280, 720)
        finally:
            server.terminate()


def shoot_workbook(file: Path) -> list[Path]:
    """Write pictures of pages of a workbook as LibreOffice prints it; return their paths."""
    written = []
    with tempfile.TemporaryDirectory() as place:
        own = f"-env:UserInstallation={(Path(place) / 'own').as_uri()}"
        command = ["soffice", own, "--headless", "--convert-to", "pdf", "--outdir", place, str(file)]
        subprocess.run(command, check=True, capture_output=True, timeout=300)
        for name, page in SHEETS.items():
            stem = Path(place) / name
            one = ["pdftoppm", "-r", "80", "-f", str(page), "-singlefile", "-png"]
            subprocess.run([*one, str(Path(place) / f"{file.stem}.pdf"), str(stem)], check=True, timeout=120)
            written.append(shrink(stem.with_suffix(".png"), SHOTS / f"{name}.png"))
    return written


def screenshots(run: Path) -> list[Path]:
    """Take the pictures of what is there; return their paths."""
    pages = {name: SITE / page for name, page in PAGES.items()} | {"report": run / "report.html"}
    written = [*(shoot(page, name) for name, page in pages.items() if page.exists()), shoot_explored()]
    workbook = run / "springs.xlsx"
    return written + (shoot_workbook(workbook) if workbook.exists() else [])


def main() -> None:
    """Draw, and print the paths of what was written."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("figure", "small", "screenshots"))
    parser.add_argument("run", type=Path, nargs="?", default=ROOT / "out" / "fan", help="folder of a run")
    given = parser.parse_args()
    for file in {"figure": figure, "small": small, "screenshots": screenshots}[given.what](given.run.resolve()):
        print(file.relative_to(ROOT))


if __name__ == "__main__":
    main()
