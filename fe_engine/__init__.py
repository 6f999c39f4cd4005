# SPDX-License-Identifier: MIT
"""Finite elements for soil-structure interaction; knows nothing of caissons or files."""

from pathlib import Path


def _drop_stale_kernels(package: Path) -> None:
    """Delete compiled kernels older than any source: numba looks only at the file a kernel stands in.

    A changed law would otherwise live on inside the loops that were compiled with it.
    """
    try:
        newest = max(source.stat().st_mtime for source in package.rglob("*.py"))
        for index in package.rglob("__pycache__/*.nbi"):
            if index.stat().st_mtime < newest:
                index.unlink(missing_ok=True)
    except OSError:  # an installation that cannot be written to keeps its cache elsewhere
        return


_drop_stale_kernels(Path(__file__).parent)
