# SPDX-License-Identifier: MIT
"""Results of a run from its folder."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from pysprings.core.errors import refused
from pysprings.full_model.run_record import ATTRIBUTE, SCHEMA

if TYPE_CHECKING:
    import xarray as xr


OTHER_SIGNS = "its moments and rotations have other signs; make it again with `pysprings run`"  # of earlier versions


def open_result(path: str | os.PathLike[str]) -> xr.DataTree:
    """Read the result of a full model: ``full_model.nc``, or the folder of a run that holds it.

    Raises
    ------
    UserInputError
        The file is missing, broken, or no result of a full model.
    """
    from pysprings.core.files.storage import read_tree

    file = Path(path)
    file = file / "full_model.nc" if file.is_dir() else file
    tree = read_tree(file)
    if tree.attrs.get("schema") != SCHEMA:
        if ATTRIBUTE not in tree.attrs:
            raise refused(None, "is no result of a full model (springs: open_springs)", file)
        raise refused("schema", f"a result of another version, not {SCHEMA}: {OTHER_SIGNS}", file)
    return tree
