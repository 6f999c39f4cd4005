# SPDX-License-Identifier: MIT
"""Registries: named cases of one kind, such as exporters or pictures, to which other packages add theirs (light)."""

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Generic, Protocol, TypeVar

from pysprings.core.errors import refused
from pysprings.core.text import suggestion

_NAME = re.compile(r"[a-z][a-z0-9_-]*")


class Named(Protocol):
    """A case of a registry."""

    @property
    def name(self) -> str:
        """Word that selects the case: lower-case letters, digits, `-` and `_`."""


Item = TypeVar("Item", bound=Named)


class Registry(Generic[Item]):
    """Cases of one kind by name, in order of registration.

    kind : What a case is, for messages: "exporter".
    items : Cases of this package.
    """

    def __init__(self, kind: str, items: Iterable[Item] = ()) -> None:
        self.kind = kind
        self._items: dict[str, Item] = {}
        for item in items:
            self.register(item)

    def register(self, item: Item) -> Item:
        """Add a case and return it.

        Raises ValueError: the name is taken, or is not a word of lower-case letters, digits, `-` and `_`.
        """
        if not _NAME.fullmatch(item.name):
            raise ValueError(f"{self.kind} {item.name!r}: a name has lower-case letters, digits, '-' and '_' only")
        if item.name in self._items:
            raise ValueError(f"{self.kind} {item.name!r} is registered already")
        self._items[item.name] = item
        return item

    def remove(self, name: str) -> None:
        """Remove a case."""
        del self._items[name]

    @contextmanager
    def added(self, item: Item) -> Iterator[Item]:
        """Register a case for the duration of a block."""
        self.register(item)
        try:
            yield item
        finally:
            self.remove(item.name)

    def __iter__(self) -> Iterator[Item]:
        return iter(tuple(self._items.values()))

    def __len__(self) -> int:
        return len(self._items)

    def __contains__(self, name: object) -> bool:
        return any(item.name == name for item in self)

    def __getitem__(self, name: str) -> Item:
        """Return the case of a name; KeyError for an unknown one."""
        return self._items[name]

    def names(self) -> list[str]:
        """Return the names of all cases."""
        return [item.name for item in self]

    def find(self, name: str, key: str) -> Item:
        """Return the case of a name that a user has given under a key (UserInputError for an unknown one)."""
        try:
            return self[name]
        except KeyError:
            names = self.names()
            message = f"'{name}' is not one of {', '.join(names)}{suggestion(name, names)}"
            raise refused(key, message) from None
