# SPDX-License-Identifier: MIT
"""What computed a result: versions of the libraries whose rounding is in it, and numbers of threads."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numba
import numpy as np
import scipy

from fe_engine.linear.backends import Backend, Pardiso

Environment = dict[str, str]


def environment_of(backend: Backend) -> Environment:
    """Return versions and numbers of threads by name, as run.json and checkpoints hold them."""
    versions = {
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "numba": numba.__version__,
        "threads of numba": str(numba.get_num_threads()),
    }
    if isinstance(backend, Pardiso):
        versions |= {"MKL": backend.version(), "threads of MKL": str(backend.threads())}
    return versions


def differences(before: Iterable[Mapping[str, str]], now: Mapping[str, str]) -> list[str]:
    """Return a sentence on each environment, of parts of a run, that was another than that of ``now``."""
    texts = []
    for other in before:
        names = [name for name in {**other, **now} if other.get(name) != now.get(name)]
        if names:
            changes = ", ".join(f"{name} {other.get(name, 'unknown')} (here {now.get(name, 'none')})" for name in names)
            texts.append(f"a part of this run was computed with {changes}: last digits may differ from a run in one go")
    return list(dict.fromkeys(texts))
