# SPDX-License-Identifier: MIT
"""Draw the small pictures of docs/reference/pictures.md: ``python -m tools.thumbnails RESULT``.

RESULT is the folder of a run. Pictures that this result does not hold the data for stay as they are.
"""

import sys
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

WIDTH, COLOURS = 560, 64  # px; of a picture
FOLDER = Path(__file__).resolve().parents[1] / "docs" / "reference" / "pictures"


def main(argv: Sequence[str] | None = None) -> int:
    """Draw what the result allows."""
    from PIL import Image

    from pysprings import open_result, plots
    from pysprings.results.plots.draw import drawable

    (folder,) = sys.argv[1:] if argv is None else argv
    tree = open_result(folder)
    FOLDER.mkdir(exist_ok=True)
    for name in drawable(tree):
        stream = BytesIO()
        plots.draw(tree, name).savefig(stream, format="png", dpi=100)
        with Image.open(stream) as picture:
            small = picture.convert("RGB")
            small.thumbnail((WIDTH, WIDTH))
            small.quantize(COLOURS).save(FOLDER / f"{name}.png", optimize=True)
        print(FOLDER / f"{name}.png")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
