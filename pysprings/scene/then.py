# SPDX-License-Identifier: MIT
"""What follows on a load path after its first part: rests, other vertical loads, further end values with their pace.

Under given loads, and after a swipe, an entry may be a pair: "1 MN, 4 MN m" are H and M about the lid centre,
"5 mm, 2 mrad" are u and rotation. "12 mm towards 90 deg" moves the lid centre on by 12 mm in another direction, from +x
towards +y. "V 3 MN" is a vertical load: the quantity that the path imposes stays meanwhile.
"""

import re
from dataclasses import dataclass
from typing import Any, NamedTuple

from pydantic import ValidationInfo

from pysprings.core.path_kinds import PATH_KINDS
from pysprings.core.units import quoted
from pysprings.scene.fields import Quantity, QuantityList, refuse

_EXAMPLES = ("rest 2 hour", "20 mm at 0.5 mm/s", "0 mm in 10 min", "V 3 MN in 10 min")


class Then(NamedTuple):
    """What follows on a path: a new end value (None: it stays), with its velocity (SI) or its time in s.

    second : the other end value of a pair, M [N m] or rotation [rad]; None: in proportion to the first one.
    load : new vertical load [N], positive down; with neither an end value nor a load it is a rest.
    towards : direction [rad, from +x towards +y] in which the lid centre moves on by the value.
    """

    value: float | None
    rate: float | None = None
    time: float | None = None
    second: float | None = None
    load: float | None = None
    towards: float | None = None


_THEN = re.compile(r"(?P<value>.+?)(?: towards (?P<towards>.+?))?(?: (?P<how>at|in) (?P<pace>.+))?")
_RATE = Quantity("mm/s", "[1e-9, 1e4]", "", "0.05 mm/s")
_RATES = {name: _RATE for name, kind in PATH_KINDS.items() if kind.paces == ("rate", "duration")}
_LOAD = Quantity("MN", "[-1e4, 1e4]", "", "3 MN")
_DIRECTION = Quantity("deg", "[-360, 360]", "", "90 deg")
_TIME = Quantity("s", "[1e-6, 1e12]", "", "2 hour")
_SECOND = {
    name: Quantity("MN*m", "[-1e6, 1e6]", "", "4 MN m") if kind.force else Quantity("deg", "[-30, 30]", "", "2 mrad")
    for name, kind in PATH_KINDS.items()
    if kind.pairs
}


@dataclass(frozen=True)
class ThenList(QuantityList):
    """What follows one after the other: "rest 2 hour", "20 mm at 0.5 mm/s", "0 mm in 10 min", "V 3 MN"."""

    @property
    def _expected(self) -> str:
        return f"a list such as [{', '.join(quoted(text) for text in _EXAMPLES[:2])}]"

    def _read(self, entry: Any, kind: str, quantity: Quantity, info: ValidationInfo) -> Then:
        if isinstance(entry, Then):
            return entry
        if isinstance(entry, list | tuple) and 3 <= len(entry) <= 6:  # a scene of Python, dumped and validated again
            return Then(*entry)
        if not isinstance(entry, str):
            raise refuse(f"expected a text such as {quoted(_EXAMPLES[0])}, got {quoted(entry)}")
        words = " ".join(entry.split())
        if words == "rest":
            raise refuse(f"a rest needs its time: {quoted(_EXAMPLES[0])}")
        if words == "V":
            raise refuse('a vertical load needs its value: "V 3 MN"')
        if words.startswith("rest "):
            return Then(None, None, _TIME.validate(words[5:], info))
        match = _THEN.fullmatch(words)
        if match is None:
            raise refuse(f"expected a text such as {quoted(_EXAMPLES[0])}, got {quoted(entry)}")
        if words.startswith("V "):
            return self._load(match, info)
        if match["towards"] is not None:
            return self._on(match, kind, quantity, info)
        value, second = self._values(match["value"], kind, quantity, info)
        pace = match["pace"]
        if match["how"] == "in":
            return Then(value, None, _TIME.validate(pace, info), second)
        if match["how"] == "at" and kind not in _RATES:
            raise refuse(f'a path of kind "{kind}" has no velocity: write "... in 10 min"')
        return Then(value, None if pace is None else _RATES[kind].validate(pace, info), None, second)

    @staticmethod
    def _on(match: re.Match[str], kind: str, quantity: Quantity, info: ValidationInfo) -> Then:
        """Return a part in another direction."""
        if not PATH_KINDS[kind].turns:
            raise refuse(f'a path of kind "{kind}" cannot go on in another direction')
        value, time = quantity.validate(match["value"], info), None
        if match["how"] == "at":
            raise refuse('a part in another direction has no velocity: write "... in 10 min"')
        if match["how"] == "in":
            time = _TIME.validate(match["pace"], info)
        if value <= 0.0:
            raise refuse("the distance to go on must be positive: the direction gives its sign")
        return Then(value, time=time, towards=_DIRECTION.validate(match["towards"], info))

    @staticmethod
    def _load(match: re.Match[str], info: ValidationInfo) -> Then:
        """Return a part with another vertical load."""
        if match["how"] == "at":
            raise refuse('a vertical load has no velocity: write "V 3 MN in 10 min"')
        time = None if match["how"] is None else _TIME.validate(match["pace"], info)
        return Then(None, time=time, load=_LOAD.validate(match["value"][2:], info))

    @staticmethod
    def _values(text: str, kind: str, quantity: Quantity, info: ValidationInfo) -> tuple[float, float | None]:
        """Return the end value, and the second one of a pair."""
        first, comma, rest = (part.strip() for part in text.partition(", "))
        if not comma and kind in _SECOND and not PATH_KINDS[kind].force:
            raise refuse(f'a path of kind "{kind}" goes on with u and rotation: "5 mm, 2 mrad"')
        if not comma:
            return quantity.validate(text, info), None
        if kind not in _SECOND:
            raise refuse(f'a path of kind "{kind}" goes on with one value, such as {quoted(quantity.example)}')
        return quantity.validate(first, info), _SECOND[kind].validate(rest, info)

    def _show(self, kind: str, then: Then) -> str:
        if then.load is not None:
            text = f"V {_LOAD.in_toml(then.load)}"
        elif then.value is None:
            return f"rest {_TIME.in_toml(then.time)}"
        else:
            text = str(dict(self.quantities)[kind].in_toml(then.value))
        if then.towards is not None:
            text += f" towards {_DIRECTION.in_toml(then.towards)}"
        if then.second is not None:
            text += f", {_SECOND[kind].in_toml(then.second)}"
        if then.rate is not None:
            return f"{text} at {_RATES[kind].in_toml(then.rate)}"
        return text if then.time is None else f"{text} in {_TIME.in_toml(then.time)}"

    def schema(self) -> dict[str, Any]:
        examples = [list(_EXAMPLES)]
        return {"description": self.text, "type": "array", "items": {"type": "string"}, "examples": examples}
