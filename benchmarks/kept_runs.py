# SPDX-License-Identifier: MIT
"""Runs that a study keeps in a folder, so that the same command goes on where it was stopped."""

from pathlib import Path

import xarray as xr

from pysprings import Scene
from pysprings.core import version
from pysprings.core.storage import read_tree, write_tree
from pysprings.full_model.compute import compute


def result_of(scene: Scene, folder: Path | None) -> xr.DataTree:
    """Return the result of a scene, whole or as far as it came; from the folder if this version has run it before."""
    file = None if folder is None else folder / f"{scene.sha256[:16]}.nc"
    if file is not None and file.exists():
        tree = read_tree(file)
        if tree.attrs["pysprings_version"] == version.__version__:
            return tree
    done = compute(scene)
    if done.interrupted:
        raise KeyboardInterrupt
    tree = done.recorded()
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_tree(tree, file)
    return tree
