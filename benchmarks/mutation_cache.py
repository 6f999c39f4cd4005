# SPDX-License-Identifier: MIT
"""Compiled loops that a change cannot be part of, handed to the tests of a mutant: they need not be compiled anew.

The engine keeps its loops in a folder named by the digest of all its sources, which each mutant changes. A loop holds
code of its own file and of those that this file imports (`TestMap.loops`); the others are as they were.
"""

from __future__ import annotations

import shutil
from pathlib import Path

from numba.core.caching import UserProvidedCacheLocator

from benchmarks.mutation_map import TestMap
from fe_engine.compiled import digest, folder_of

PACKAGE = "fe_engine"


def kept_loops(root: Path) -> Path:
    """Return the folder in which the engine below ``root`` keeps its loops; one that does not exist if it has none."""
    sources = digest(root / PACKAGE, (root / PACKAGE).rglob("*.py"))
    return folder_of(root / PACKAGE, sources) or root / f"{PACKAGE}-none"


def cached_loops(kept: Path, cache: Path) -> Path:
    """Return the folder below a cache in which loops of the same sources lie as in the folder ``kept``."""
    return cache / kept.name


def give_loops(kept: Path, root: Path, copy: Path, tests: TestMap, changed: str, cache: Path) -> int:
    """Copy the loops of unchanged code to a cache; return the number of files.

    Parameters
    ----------
    kept : folder of compiled loops of the sources below ``root``.
    copy : folder with a copy of these sources, one of which, ``changed``, is changed.
    cache : what NUMBA_CACHE_DIR will be.
    """
    digits = len(kept.name) - len(PACKAGE) - 1
    home = cache / f"{PACKAGE}-{digest(copy / PACKAGE, (copy / PACKAGE).rglob('*.py'))[:digits]}"
    given = 0
    for file, parts in tests.loops.items():
        source, target = kept / numba_folder(root / file), home / numba_folder(copy / file)
        if changed not in parts and source.is_dir():
            target.mkdir(parents=True, exist_ok=True)
            for loop in source.glob(f"{Path(file).stem}.*"):
                shutil.copy2(loop, target / loop.name)
                given += 1
    return given


def numba_folder(source: Path) -> str:
    """Return the name of the folder in which Numba keeps the loops of a file."""
    name: str = UserProvidedCacheLocator.get_suitable_cache_subpath(str(source))
    return name
