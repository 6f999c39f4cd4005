# SPDX-License-Identifier: MIT
"""Take pictures of the site, a report and a workbook: ``python -m tools.screenshots [RUN]`` (`make screenshots`).

Pages of the site in out/site (`make gallery` builds it with the pictures of the examples), of the report in the folder
of a run, and printed pages of its workbook go to docs/evidence/site, a PNG of less than 200 kB each. What is not there
is left as it is. Chromium draws pages, LibreOffice and pdftoppm (poppler-utils) print the workbook.
"""

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SITE = ROOT / "out" / "site"
PICTURES = ROOT / "docs" / "evidence" / "site"
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
COLOURS = 256  # of a picture


def browser() -> str:
    """Return the program."""
    found = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if found is None:
        raise SystemExit("no Chromium: apt-get install chromium")
    return found


def shoot(page: Path | str, target: Path, width: int = 1300, height: int = 1000) -> Path:
    """Write a picture of the top of an HTML page, a file or an address; return its path."""
    address = page if isinstance(page, str) else page.resolve().as_uri()
    with tempfile.TemporaryDirectory() as place:
        raw = Path(place) / "page.png"
        command = [browser(), "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
        command += [f"--window-size={width},{height}", f"--screenshot={raw}", WAIT, address]
        subprocess.run(command, check=True, capture_output=True, timeout=120)
        return shrink(raw, target)


def shrink(raw: Path, target: Path) -> Path:
    """Write a picture with few colours; return its path."""
    from PIL import Image

    target.parent.mkdir(parents=True, exist_ok=True)
    with Image.open(raw) as picture:
        picture.convert("RGB").quantize(COLOURS).save(target, optimize=True)
    if target.stat().st_size > MOST_BYTES:
        raise SystemExit(f"{target}: {target.stat().st_size} bytes, more than {MOST_BYTES}")
    return target


def shoot_explored(target: Path) -> Path:
    """Write a picture of the page of `pysprings explore`; return its path."""
    line = [sys.executable, "-m", "pysprings", "explore", "--atlas", "clay", "--port", "0"]
    with subprocess.Popen(line, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        try:
            return shoot(server.stdout.readline().strip(), target, 1280, 720)
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
            written.append(shrink(stem.with_suffix(".png"), PICTURES / f"{name}.png"))
    return written


def main(argv: Sequence[str] | None = None) -> int:
    """Take the pictures of what is there."""
    given = list(sys.argv[1:] if argv is None else argv)
    run = Path(given[0]) if given else ROOT / "out" / "fan"
    pages = {name: SITE / page for name, page in PAGES.items()} | {"report": run / "report.html"}
    written = [shoot(page, PICTURES / f"{name}.png") for name, page in pages.items() if page.exists()]
    written.append(shoot_explored(PICTURES / "explore.png"))
    if (run / "springs.xlsx").exists():
        written += shoot_workbook(run / "springs.xlsx")
    for file in written:
        print(file.relative_to(ROOT))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
