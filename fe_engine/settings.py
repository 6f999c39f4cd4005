# SPDX-License-Identifier: MIT
"""Environment variables that Numba reads when it is loaded, judged before."""

from __future__ import annotations

import os

from fe_engine.errors import SettingError

MOST_THREADS = 4096


def refuse_bad_settings() -> None:
    """Raise SettingError where NUMBA_NUM_THREADS is not a number of threads."""
    text = os.environ.get("NUMBA_NUM_THREADS")
    if text is None:
        return
    try:
        number = int(text)
    except ValueError:
        number = 0
    if not 1 <= number <= MOST_THREADS:
        raise SettingError(
            f"NUMBA_NUM_THREADS: {text!r} is not a number of threads: a whole number, 1 to {MOST_THREADS}"
        )
