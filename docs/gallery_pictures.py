# SPDX-License-Identifier: MIT
"""The picture of a block of an example: what it has left under the name ``figure``.

Figures of `pysprings.plots` do not go through pyplot, where Sphinx-Gallery looks for them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from weakref import WeakSet

from matplotlib import pyplot
from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

SHOWN: WeakSet[Figure] = WeakSet()


def pictures(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the figure of a block where it is a new one; return the text that shows it."""
    figure = block_vars["example_globals"].get("figure")
    pyplot.close("all")
    if not isinstance(figure, Figure) or figure in SHOWN:
        return ""
    SHOWN.add(figure)
    file = next(block_vars["image_path_iterator"])
    figure.savefig(file, dpi=110)
    return str(figure_rst([file], gallery_conf["src_dir"]))


def _get_sg_image_scraper() -> Callable[..., str]:
    return pictures
