# SPDX-License-Identifier: MIT
"""pysprings: p-y springs of suction caissons from a 3D finite-element model, and predictions made with them.

Names below load on first use, so that `import pysprings` and the command's `--help` stay fast.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pysprings.comparison import compare
    from pysprings.extract import extract_springs
    from pysprings.full_model import run
    from pysprings.macro import curve, impose, model_of, predict, predict_batch, sequence, stiffness
    from pysprings.macro_six import stiffness_six
    from pysprings.scene import Scene, load_scene
    from pysprings.springs import open_springs
    from pysprings.tables import open_table

__version__ = "0.1.0"

__all__ = [
    "Scene",
    "__version__",
    "compare",
    "curve",
    "extract_springs",
    "impose",
    "load_scene",
    "model_of",
    "open_springs",
    "open_table",
    "predict",
    "predict_batch",
    "run",
    "sequence",
    "stiffness",
    "stiffness_six",
]

_HOMES = {
    "Scene": "scene",
    "load_scene": "scene",
    "extract_springs": "extract",
    "open_springs": "springs",
    "open_table": "tables",
    "predict": "macro",
    "curve": "macro",
    "stiffness": "macro",
    "sequence": "macro",
    "predict_batch": "macro",
    "model_of": "macro",
    "impose": "macro",
    "stiffness_six": "macro_six",
    "run": "full_model",
    "compare": "comparison",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
