# SPDX-License-Identifier: MIT
"""pysprings: p-y springs of suction caissons from a 3D finite-element model, and predictions made with them.

Names below load on first use, so that `import pysprings` and the command's `--help` stay fast.
"""

from __future__ import annotations

import inspect
import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pysprings.compare import compare
    from pysprings.extract import extract_springs
    from pysprings.macro import curve, predict
    from pysprings.run import run
    from pysprings.scene import Scene, load_scene
    from pysprings.springs import open_springs

__version__ = "0.1.0"

__all__ = [
    "Scene",
    "__version__",
    "compare",
    "curve",
    "extract_springs",
    "load_scene",
    "open_springs",
    "predict",
    "run",
]

_HOMES = {
    "Scene": "scene",
    "load_scene": "scene",
    "extract_springs": "extract",
    "open_springs": "springs",
    "predict": "macro",
    "curve": "macro",
}
_CALLABLE_MODULES = ("run", "compare")


def __getattr__(name: str) -> Any:
    if name in _CALLABLE_MODULES:
        return import_module(f"{__name__}.{name}")
    if name not in _HOMES:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


class _CallableModule(ModuleType):
    """A module called like its main function: `pysprings.run(scene)` is `pysprings.run.run(scene)`."""

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        return self._main(*args, **kwargs)

    @property
    def _main(self) -> Any:
        return getattr(self, self.__name__.rpartition(".")[2])

    @property
    def __signature__(self) -> inspect.Signature:
        return inspect.signature(self._main)


class _Package(ModuleType):
    """This package: the import system puts the modules `run` and `compare` where users expect functions."""

    def __setattr__(self, name: str, value: Any) -> None:
        if name in _CALLABLE_MODULES and isinstance(value, ModuleType):
            value.__class__ = _CallableModule
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
