# SPDX-License-Identifier: MIT
"""pysprings: p-y springs of suction caissons from a 3D finite-element model, and predictions made with them.

The public names stand in the stub beside this file; each loads on first use, so that `import pysprings` and the
command's `--help` stay fast. All other modules are private. Trees of xarray have ``tree.pysprings`` (pictures, a view
for notebooks) from the first use of a name that loads xarray, or at once where xarray is loaded already.
"""

import sys
from importlib import import_module
from typing import Any

import lazy_loader

from pysprings.core.version import __version__ as __version__

_load, _names, __all__ = lazy_loader.attach_stub(__name__, __file__)


def _add_accessor() -> None:
    if "xarray" in sys.modules:
        import_module("pysprings.results.accessor")


def __getattr__(name: str) -> Any:
    value = _load(name)
    _add_accessor()
    return value


def __dir__() -> list[str]:
    return [*_names(), "__version__"]


_add_accessor()
