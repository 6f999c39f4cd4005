# SPDX-License-Identifier: MIT
"""Spring files: reading and writing, each with the check of what the file must hold."""

from __future__ import annotations

import os
from pathlib import Path

import xarray as xr

from pysprings.core.files.storage import read_tree, write_tree
from pysprings.springs.checks import validate_springs


def open_springs(path: str | os.PathLike[str]) -> xr.DataTree:
    """Read and validate a spring file.

    Raises
    ------
    UserInputError
        The file is missing, broken, of another kind or version, or lacks something; every fault is listed.
    """
    tree = read_tree(path)
    validate_springs(tree, file=path)
    return tree


def save_springs(tree: xr.DataTree, path: str | os.PathLike[str]) -> Path:
    """Validate a spring set and write it as NetCDF, atomically; return its path."""
    validate_springs(tree)
    return write_tree(tree, path)
