# SPDX-License-Identifier: MIT
"""Numba for the macro-model's loops, or not: one prediction in plain Python is over before Numba is loaded.

Where Numba is not installed (``requirements-predict.txt``) all of them are plain Python.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any, TypeVar, cast

F = TypeVar("F", bound=Callable[..., Any])

# Set before `pysprings.macro.solver` is imported; what is decorated then stays as it is.
PLAIN: ContextVar[bool] = ContextVar("plain", default=False)

# Options of `pysprings predict` that ask for many states: there Numba pays.
_MANY = ("--points", "--sequence")
_REMEMBERS = "memory"  # the spring set that takes many elements


def jitted(function: F) -> F:
    """Compile a function at its first call (kept between processes), or leave it as it is.

    Its file has everything that it is compiled from: it calls jitted functions of that file, and no others.
    """
    if PLAIN.get():
        return function
    try:
        from fe_engine.compiled import cached, digest
    except ModuleNotFoundError as missing:
        if missing.name != "numba":
            raise
        return function
    file = Path(function.__code__.co_filename)
    return cast(F, cached(function, file.parent, digest(file.parent, [file])))


@contextmanager
def compilation(begun: Callable[[], None]) -> Iterator[Callable[[], float]]:
    """Watch Numba in a block: `begun` is called when it first compiles a loop that is not kept.

    Yields a function that returns the seconds of wall time that compilation has taken.
    """
    from numba.core import event

    class Watch(event.TimingListener):
        def on_start(self, each: Any) -> None:
            if not (self.done or self._depth):
                begun()
            super().on_start(each)

    watch = Watch()
    with event.install_listener("numba:compile", watch):
        yield lambda: float(watch.duration) if watch.done else 0.0


def mark_of(kind: str) -> Path | None:
    """Return the file beside the kept loops that marks those of a kind of scene as made; None: none are kept."""
    from hashlib import sha256

    from fe_engine.compiled import HOME, engine_digest, folder_of

    folder = folder_of(HOME, engine_digest())
    return None if folder is None else folder / f"kind-{sha256(kind.encode()).hexdigest()[:16]}"


def choose_for_command(arguments: Sequence[str]) -> None:
    """Do without Numba when the command is one prediction or a usual curve (it takes 0.5 s to load and bind)."""
    many = any(argument.split("=")[0] in _MANY or argument.endswith(_REMEMBERS) for argument in arguments)
    command = next((argument for argument in arguments if not argument.startswith("-")), "")
    PLAIN.set(command == "predict" and not many)
