# SPDX-License-Identifier: MIT
"""Registers of laws: names and integer codes for Python, one compiled chain of calls for the loops.

A loop calls ``chain(code, ...)``, an if-chain over the codes whose branches are direct calls. Numba keeps such loops
between processes, which it does not with functions that are handed in.

A law from outside the package is added before the first import of a module that compiles loops (`fe_engine.assembly`):

    from fe_engine.soil.laws import SOIL_LAWS
    SOIL_LAWS.add(LAW)

Its source then belongs to the digest that names the folder of kept loops.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

from fe_engine.compiled import HOME, include, lean
from fe_engine.errors import ModelError


class Named(Protocol):
    """What a register asks of a law."""

    @property
    def name(self) -> str:
        """Name by which the law is found, unique among the laws of its kind."""


Law = TypeVar("Law", bound=Named)


class Register(Generic[Law]):
    """Laws of one kind, in the order of their codes."""

    def __init__(self, kind: str, *laws: Law) -> None:
        self.kind = kind
        self._laws: list[Law] = list(laws)
        self._closed = False

    def __iter__(self) -> Iterator[Law]:
        return iter(self._laws)

    def __len__(self) -> int:
        return len(self._laws)

    def __getitem__(self, name: str) -> Law:
        """Return the law of that name; raise ModelError where none is registered."""
        for law in self._laws:
            if law.name == name:
                return law
        raise ModelError(f"{self.kind} {name!r} is not registered ({', '.join(law.name for law in self._laws)} are)")

    def code(self, law: Law) -> int:
        """Return the integer code of a law; raise ModelError where it is not registered."""
        for code, other in enumerate(self._laws):
            if other is law:
                return code
        raise ModelError(f"{self.kind} {law.name!r} is not registered")

    def add(self, law: Law, *sources: Path) -> None:
        """Add a law from outside the package.

        Parameters
        ----------
        law : the law; its jitted functions have the signatures that its class describes.
        sources : files that it is compiled from, beside those of the functions themselves.

        Raises ModelError where the name is taken, or where loops have been made without the law.
        """
        if any(other.name == law.name for other in self._laws):
            raise ModelError(f"{self.kind} {law.name!r} is registered already")
        if self._closed:
            raise ModelError(f"{self.kind} {law.name!r} comes too late: add laws before importing fe_engine.assembly")
        functions = [value for value in vars(law).values() if callable(value)]
        files = {Path(inspect.getfile(getattr(each, "py_func", each))) for each in functions} | set(sources)
        include(file for file in files if not file.is_relative_to(HOME))
        self._laws.append(law)

    def chain(
        self, name: str, arguments: str, module: str, codes: Sequence[int] | None = None, default: Any = None
    ) -> Any:
        """Return a jitted function ``name(code, arguments)`` that calls the function ``name`` of the law of that code.

        No law can be added afterwards. ``module`` is the module that keeps the function. ``codes``: those of the laws
        that are called, by default all; the function then has a name of its own. Others are not compiled. ``default``
        stands in for laws whose ``name`` is None.
        """
        self._closed = True
        wanted = [code for code in range(len(self._laws)) if codes is None or code in codes]
        choices = {code: getattr(self._laws[code], name) or default for code in wanted}
        return _chain(name if codes is None else f"{name}_{suffix(codes)}", arguments, choices, module)


def suffix(codes: Iterable[int]) -> str:
    """Return what the names of functions end with that are compiled for the laws of these codes."""
    return "_".join(map(str, codes))


def _chain(name: str, arguments: str, choices: Mapping[int, Callable[..., Any]], module: str) -> Any:
    *first, last = choices
    lines = [f"def {name}(code, {arguments}):"]
    for code in first:
        lines += [f"    if code == {code}:", f"        return choice_{code}({arguments})"]
    lines.append(f"    return choice_{last}({arguments})")
    space: dict[str, Any] = {f"choice_{code}": choice for code, choice in choices.items()}
    space["__name__"] = module
    exec(compile("\n".join(lines), __file__, "exec"), space)
    return lean(space[name])
