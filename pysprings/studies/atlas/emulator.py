# SPDX-License-Identifier: MIT
"""What emulators of the full models of a study share: the scenes they cover, what they expect of one, its springs."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pysprings.core.errors import Problem, UserInputError
from pysprings.scene.changes import Change
from pysprings.studies.atlas.data import Estimate, Grid

if TYPE_CHECKING:
    import xarray as xr

    from pysprings.scene.model import Scene

Array = NDArray[np.float64]
_ROUNDING = 1e-6


@dataclass(frozen=True, eq=False, kw_only=True)
class Emulator(Grid):
    """Springs of any caisson between the full models of a study."""

    @cached_property
    def box(self) -> Array:
        """Least and largest inputs (2, d) of the full models."""
        return np.stack([self.inputs.min(axis=0), self.inputs.max(axis=0)])

    @cached_property
    def _scale(self) -> tuple[Array, Array]:
        even = self.family.even(self.inputs)
        return even.min(axis=0), even.max(axis=0) - even.min(axis=0)

    def point(self, inputs: Array) -> Array:
        """Return inputs (..., d) in their even form, 0 to 1 between the full models."""
        low, span = self._scale
        return np.asarray((self.family.even(inputs) - low) / span)

    def scene(self, D: float | None = None, L: float | None = None, changes: Sequence[Change] = ()) -> Scene:
        """Return the base scene with another diameter and skirt length [m] and other values.

        Short names of the family stand for keys. What is covered in proportion follows, where it is not given.
        """
        given = [self.named(change) for change in changes]
        sizes = {"outer_diameter": D, "skirt_length": L}
        given += [Change(("caisson", key), f"{value:.12g} m") for key, value in sizes.items() if value is not None]
        scene, there = self.text.scene(given), {change.keys for change in given}
        more = [
            Change((each.section, each.key), f"{each.value(self.base) * each.size(scene) / each.unit[1]:.12g} "
                                             f"{each.unit[0]}")
            for each in self.family.scaled
            if (each.section, each.key) not in there
        ]  # fmt: skip
        return self.text.scene([*given, *more])

    def named(self, change: Change) -> Change:
        """Return a change with its key in full where it has a short name of the family."""
        name = ".".join(change.keys)
        return Change(tuple(self.family.short.get(name, name).split(".")), change.value)

    def estimate(self, scene: Scene, extrapolate: bool = False) -> Estimate:
        """Return what is expected of a scene.

        Raises
        ------
        UserInputError
            The scene is none of the family, or outside the box of the full models, unless ``extrapolate``.
        """
        self.family.check(scene, self.base)
        inputs = self.family.read(scene)
        outside = [*self._outside_box(inputs)]
        if outside and not extrapolate:
            raise UserInputError([Problem(key=key, message=text) for key, text in outside])
        texts = [f"{key}: {text}" for key, text in outside] or [*self._outside_hull(inputs)]
        return self._expected(scene, inputs, tuple(texts))

    def covers(self, scene: Scene) -> bool:
        """Return whether a scene is inside the box of the full models. Raises UserInputError for another family."""
        self.family.check(scene, self.base)
        return not self._outside_box(self.family.read(scene))

    @abstractmethod
    def _expected(self, scene: Scene, inputs: Array, outside: tuple[str, ...]) -> Estimate:
        """Return the estimate of a scene that is covered."""

    def springs(self, scene: Scene, extrapolate: bool = False) -> xr.DataTree:
        """Return springs of a scene, as `pysprings.extract_springs` does for a full model; see `estimate`."""
        from pysprings.studies.atlas.springs import spring_tree

        return spring_tree(self, scene, self.estimate(scene, extrapolate))

    def _outside_box(self, inputs: Array) -> list[tuple[str, str]]:
        low, high = self.box
        slack = _ROUNDING * (high - low)
        return [
            (label, f"{value:.4g} is outside the atlas ({a:.4g} to {b:.4g})")
            for label, value, a, b, room in zip(self.family.labels, inputs, low, high, slack, strict=True)
            if not a - room <= value <= b + room
        ]

    def _outside_hull(self, inputs: Array) -> list[str]:
        """Return a sentence for inputs that no mixture of the full models has; none inside their convex hull."""
        from scipy.optimize import linprog

        known, point = self.point(self.inputs), self.point(inputs)
        rows = np.vstack([known.T, np.ones(len(known))])
        inside = linprog(np.zeros(len(known)), A_eq=rows, b_eq=np.append(point, 1.0), method="highs").status == 0
        text = "in a corner of the atlas, outside the convex hull of its full models: the standard deviation is larger"
        return [] if inside else [text]
