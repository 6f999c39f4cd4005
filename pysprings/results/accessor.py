# SPDX-License-Identifier: MIT
"""``tree.pysprings`` of results and springs: a compact view for notebooks, typed springs, and pictures.

Registered with the first use of a name of `pysprings`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import xarray as xr

from pysprings.core.errors import refused
from pysprings.core.text import suggestion
from pysprings.springs.springs import Springs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ALSO = ("status", "ground", "loads", "tilt", "mesh error", "warnings")  # lines of the summary of a run


@xr.register_datatree_accessor("pysprings")
class Accessor:
    """What `pysprings` adds to a result (`run`, `open_result`) or to springs (`open_springs`, ...)."""

    def __init__(self, tree: xr.DataTree) -> None:
        self._tree = tree

    @cached_property
    def springs(self) -> Springs:
        """The springs with typed attributes; made from the result where the tree is one."""
        from pysprings.results.plots.draw import is_result
        from pysprings.springs.checks import extract_springs

        return Springs.of(extract_springs(self._tree) if is_result(self._tree) else self._tree)

    def beam(self, depths: Sequence[float] | None = None, **options: Any) -> xr.Dataset:
        """Return one set of curves for beam programs at depths [m], see `pysprings.beam`."""
        from pysprings.results.exporters.beam import beam

        return beam(self.springs, depths, **options)

    @property
    def plot(self) -> Pictures:
        """Pictures by name: ``tree.pysprings.plot.py("pull")``; `pysprings.plots.draw` has the arguments."""
        return Pictures(self._tree)

    def _repr_html_(self) -> str:
        from pysprings.results.plots.draw import is_result
        from pysprings.springs.card import springs_card

        if "skirt_length_m" not in self._tree.attrs:
            return self._tree._repr_html_()
        shown = Springs.of(self._tree)
        return springs_card(shown, "Result", _summary(self._tree)) if is_result(self._tree) else springs_card(shown)


class Pictures:
    """The pictures of a tree, each a method: its path first, options by keyword."""

    def __init__(self, tree: xr.DataTree) -> None:
        self._tree = tree

    def __getattr__(self, name: str) -> Callable[..., Figure]:
        from pysprings.results.plots import PICTURES
        from pysprings.results.plots.draw import draw

        known = {each.replace("-", "_"): each for each in PICTURES.names()}
        if name not in known:
            raise AttributeError(f"no picture '{name}'{suggestion(name, known)}; there are: {', '.join(known)}")
        return partial(draw, self._tree, known[name])

    def __dir__(self) -> list[str]:
        from pysprings.results.plots.draw import drawable

        return [name.replace("-", "_") for name in drawable(self._tree)]

    def __repr__(self) -> str:
        return f"pictures: {', '.join(dir(self))}"

    def __call__(self, *_: Any, **__: Any) -> Figure:
        """Refuse a call without a name."""
        raise refused("picture", f"name one: {', '.join(f'plot.{name}()' for name in dir(self))}")


def _summary(result: xr.DataTree) -> dict[str, str]:
    """Return lines of the summary of a run that its paths do not show."""
    from pysprings.full_model.run_record import RunRecord
    from pysprings.results.summary import summary

    record = RunRecord.of(result)
    if record is None:
        return {}
    lines = {"status": str(record.status), **summary(result, record)}
    return {name: lines[name] for name in ALSO if name in lines}
