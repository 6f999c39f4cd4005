# SPDX-License-Identifier: MIT
"""Build the documentation site: ``make site``.

Pages are Markdown files that a repository browser shows as well. The list of links of each ``index.md`` is its table of
contents (`adapt`). Names of other projects link to their sites by their own inventories, or, where the network
does not reach these, by the short list in ``other_projects.txt``.
"""

from __future__ import annotations

import csv
import json
import os
import re
import sys
import zlib
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

from pysprings import __version__  # noqa: E402

project = "pysprings"
author = copyright = "pysprings contributors"
version = release = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.intersphinx",
    "numpydoc",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
myst_heading_anchors = 4
copybutton_exclude = ".linenos, .gp, .go"

default_role = "code"  # names in docstrings

autosummary_generate = True
autodoc_typehints = "none"
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_xref_param_type = True

# `make gallery` runs the examples whose text has changed; other builds keep their pages, or make them without pictures
RUN = os.environ.get("GALLERY") == "1"
exclude_patterns = ["gallery/sg_execution_times.rst", "sg_execution_times.rst"]
sphinx_gallery_conf = {
    "examples_dirs": str(HERE.parent / "examples"),
    "gallery_dirs": str(HERE / "gallery"),
    "filename_pattern": "/plot_",
    "plot_gallery": str(RUN),
    "image_scrapers": ("gallery_pictures",),
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "write_computation_times": False,
    "remove_config_comments": True,
    "download_all_examples": False,
    "show_signature": False,
}

html_theme = "pydata_sphinx_theme"
html_title = "pysprings"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "navbar_align": "left",
    "header_links_before_dropdown": 9,
    "logo": {"text": f"pysprings {version}"},
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
}


# --- links to other projects ---


def inventories(listed: Path, folder: Path) -> dict[str, tuple[str, tuple[None, str]]]:
    """Write the listed names as inventories of Sphinx (version 2); return the mapping: theirs first, then these."""
    sites: dict[str, tuple[str, list[str]]] = {}
    lines = [line.split() for line in listed.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    for first, *rest in lines:
        if len(rest) == 1:
            name, names = first, []
            sites[name] = (rest[0], names)
        else:
            role, page = rest
            names.append(f"{first} {role} 1 {page} -\n")
    folder.mkdir(parents=True, exist_ok=True)
    for name, (_, names) in sites.items():
        head = f"# Sphinx inventory version 2\n# Project: {name}\n# Version: \n# The remainder is compressed by zlib.\n"
        (folder / f"{name}.inv").write_bytes(head.encode() + zlib.compress("".join(names).encode()))
    return {name: (site, (None, str(folder / f"{name}.inv"))) for name, (site, _) in sites.items()}


intersphinx_mapping = inventories(HERE / "other_projects.txt", HERE.parent / "out" / "inventories")
intersphinx_timeout = 3  # s
intersphinx_disabled_reftypes = ["std:*"]

# --- what the repository and the site do differently ---

LINK = re.compile(r"^(?:- |\| ).*?\[[^\]]+\]\(([^)\s#:]+)\.(?:md|rst)\)", re.M)
# a file of the repository -> its page on the site
OUTSIDE = {
    "CHANGELOG.md": "/develop/changes.md",
    "CONTRIBUTING.md": "/develop/contributing.md",
    "THIRD-PARTY.md": "/reference/licences.md",
    "examples/README.rst": "/gallery/index.rst",
}


DATA = HERE.parent / "data" / "evidence"
STORED = re.compile(r"^\[([\w-]+)\]\((?:\.\./)+data/evidence/\1\.csv\)$", re.M)
NUMBER = re.compile(r"[-+<>~]*[\d.,]*\d(e[-+]?\d+)?( %)?|-?")


def table(name: str) -> str:
    """Return a stored table in Markdown, columns of numbers set to the right; a list where it has one column `line`."""
    with (DATA / f"{name}.csv").open(newline="", encoding="utf-8") as stream:
        heads, *rows = list(csv.reader(stream))
    if heads == ["line"]:
        return "\n".join(f"- {row[0]}" for row in rows)
    right = [all(NUMBER.fullmatch(row[k]) for row in rows) for k in range(len(heads))]
    lines = [heads, ["--:" if side else "---" for side in right], *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def with_tables(text: str) -> str:
    """Return a page with the tables that its lines link to, and their origins below its title."""
    known, used = json.loads((DATA / "origins.json").read_text(encoding="utf-8")), dict[str, None]()
    for name in STORED.findall(text):
        used[max((each for each in known if name.startswith(each)), key=len)] = None
    if not used:
        return text
    origins = [
        f"- `{name}`: `{known[name]['command']}`, version {known[name]['version']}, {known[name]['date']}. "
        f"{known[name]['note']}".rstrip()
        for name in used
    ]
    title, _, rest = STORED.sub(lambda match: table(match[1]), text).partition("\n")
    return "\n".join([title, "", "Data on this page:", "", *origins, rest])


def adapt(app: Any, docname: str, source: list[str]) -> None:
    """Lead links to files beside docs/ to pages of the site; append the contents that the links of an index make."""
    source[0] = with_tables(source[0])
    source[0] = source[0].replace("[origins](../../data/evidence/origins.json)", "`data/evidence/origins.json`")
    for file, page in OUTSIDE.items():
        source[0] = re.sub(rf"\]\((?:\.\./)+{re.escape(file)}\)", f"]({page})", source[0])
    if docname.rpartition("/")[2] == "index" and not docname.startswith("gallery/"):
        pages = "\n".join(dict.fromkeys(LINK.findall(source[0])))
        source[0] += f"\n```{{toctree}}\n:hidden:\n\n{pages}\n```\n"


def setup(app: Any) -> None:
    """Connect what adapts the pages."""
    app.connect("source-read", adapt)
