# SPDX-License-Identifier: MIT
"""Take pictures of pages in a headless Chromium: ``python -m benchmarks.screenshots`` (`make screenshots`).

Pages of the site in out/site (`make gallery` builds it with the pictures of the examples) go to docs/evidence/site, a
PNG of less than 200 kB each.
"""

from __future__ import annotations

import shutil
import subprocess
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
MOST_BYTES = 200_000
COLOURS = 128  # of a picture


def browser() -> str:
    """Return the program."""
    found = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if found is None:
        raise SystemExit("no Chromium: apt-get install chromium")
    return found


def shoot(page: Path, target: Path, width: int = 1300, height: int = 1000) -> Path:
    """Write a picture of the top of an HTML page; return its path."""
    from PIL import Image

    if not page.exists():
        raise SystemExit(f"{page}: no such page; run make gallery")
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as place:
        raw = Path(place) / "page.png"
        command = [browser(), "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
        command += [f"--window-size={width},{height}", f"--screenshot={raw}", page.resolve().as_uri()]
        subprocess.run(command, check=True, capture_output=True, timeout=120)
        with Image.open(raw) as picture:
            picture.convert("RGB").quantize(COLOURS).save(target, optimize=True)
    if target.stat().st_size > MOST_BYTES:
        raise SystemExit(f"{target}: {target.stat().st_size} bytes, more than {MOST_BYTES}")
    return target


def main(argv: Sequence[str] | None = None) -> int:
    """Take all pictures."""
    for name, page in PAGES.items():
        print(shoot(SITE / page, PICTURES / f"{name}.png").relative_to(ROOT))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
