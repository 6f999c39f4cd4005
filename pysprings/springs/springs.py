# SPDX-License-Identifier: MIT
"""`Springs`: a set of springs with typed attributes, built once from the tree that a file opens as.

Its load paths, rays, sets at several vertical loads and sets at several rates are found once. `at` returns the springs
at a rate or a vertical load, `path` one load path.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from pysprings.core.arguments import check_numbers
from pysprings.core.arrays import Array
from pysprings.core.errors import refused
from pysprings.core.loads import same_load
from pysprings.core.path_kinds import MEMORY
from pysprings.core.text import suggestion
from pysprings.springs import path_sets
from pysprings.springs.checks import check_schema, validate_springs
from pysprings.springs.path import SpacePath, SpringPath, is_rate, paths_of, pure_of, rays_of, space_paths_of
from pysprings.springs.path_ends import PathEnd

OF_ATLAS = "springs of the {} ({} full models), not of a full model of this caisson; standard deviations; w has none"
SPREAD = "atlas"  # group of the standard deviation that springs of an atlas have
_DIMS = ("mode", "ray", "knot")


def check_spread(data: xr.Dataset) -> xr.Dataset:
    """Return the group of the standard deviation as it is.

    `H_mode` [N] and `M_mode` [N m] (mode, ray, knot): loads along each ray of independent modes of one standard
    deviation; `rho` [m] (knot): the motions, which are those of the paths. `turn` (knot): standard deviation over the
    rotation of what straight rays do not say of the rotation under a load.

    Raises UserInputError where something is missing or not finite.
    """
    for name in ("H_mode", "M_mode"):
        if name not in data or data[name].dims != _DIMS:
            raise refused(f"{SPREAD}/{name}", f"missing, or not by {', '.join(_DIMS)}")
    for name in ("rho", "turn"):
        if name not in data or data[name].dims != ("knot",) or "ray" not in data.coords:
            raise refused(f"{SPREAD}/{name}", "missing, or not by knot")
    for name in ("H_mode", "M_mode", "rho", "turn"):
        if not np.isfinite(data[name].values).all():
            raise refused(f"{SPREAD}/{name}", "not finite")
    return data


FEWEST_RAYS = 2  # of a fan
KEPT = 64  # derived springs at the most: every vertical load of a table of loads has its own


def memory_groups(tree: xr.DataTree) -> list[str]:
    """Return the names of the groups of a tree with calibrated elements: "memory", "memory_load_1_rate_1" ..."""
    further = (f"{MEMORY}_rate_", f"{MEMORY}_load_")
    return [name for name in tree.children if name == MEMORY or name.startswith(further)]


@dataclass(frozen=True, eq=False)
class Springs:
    """The springs of a caisson. Nothing of them may be changed: what is derived is computed once and kept.

    Attributes
    ----------
    root : initial stiffness, and attributes: geometry of the caisson, and where the springs come from.
    paths : load paths by name, in the order of the file.
    memory : calibrated elements of springs with memory (`pysprings.memory`) by name of their group, one for each
        vertical load and rate; empty where none are stored.
    space : paths that leave the plane of one load, by name; those of the role "memory" calibrate springs with memory.
    spread : standard deviation of springs of an atlas (`check_spread`); None for those of a full model.
    whole : springs at all vertical loads, of springs at one of several; else None.
    every_rate : springs at all rates, of springs at one; else None.
    parts : springs at the two rates that springs at a rate lie between, each with its share; else empty.
    """

    root: xr.Dataset
    paths: Mapping[str, SpringPath]
    memory: Mapping[str, xr.Dataset] = field(default_factory=dict)
    space: Mapping[str, SpacePath] = field(default_factory=dict)
    spread: xr.Dataset | None = None
    whole: Springs | None = None
    every_rate: Springs | None = None
    parts: tuple[tuple[Springs, float], ...] = ()
    _derived: dict[Hashable, Springs] = field(default_factory=dict, repr=False)

    @classmethod
    def of(cls, source: Springs | xr.DataTree) -> Springs:
        """Return the springs of a tree (`open_springs`, `extract_springs`, `open_table`); `Springs` as they are.

        The arrays are those of the tree, not copies: build the springs anew after a change of the tree. Raises
        UserInputError for a tree of another version, or of something else.
        """
        if isinstance(source, Springs):
            return source
        given: Any = source
        if not isinstance(given, xr.DataTree):
            words = f"a {type(source).__name__} holds none: open them first (`open_springs`, `open_table`)"
            raise refused("springs", words)
        if "schema" in source.attrs:  # tables have none
            check_schema(source)
        root = source.to_dataset(inherit=False)
        paths = {each.name: SpringPath(each.name, each.recorded, each.length) for each in paths_of(source).values()}
        stored = {name: source.children[name].to_dataset(inherit=False) for name in memory_groups(source)}
        spread = check_spread(source.children[SPREAD].to_dataset(inherit=False)) if SPREAD in source.children else None
        return cls(root, paths, stored, space_paths_of(source), spread)

    @cached_property
    def tree(self) -> xr.DataTree:
        """The springs as a tree, as `save_springs` writes it."""
        groups = {"/": self.root} | {f"/paths/{name}": path.recorded for name, path in self.paths.items()}
        groups |= {f"/{name}": elements for name, elements in self.memory.items()}
        groups |= {f"/space/{name}": path.recorded for name, path in self.space.items()}
        groups |= {} if self.spread is None else {f"/{SPREAD}": self.spread}
        return xr.DataTree.from_dict(groups, name="springs")

    def _repr_html_(self) -> str:
        """Show the springs in a notebook."""
        from pysprings.springs.card import springs_card

        return springs_card(self)

    # --- attributes ---

    @property
    def attrs(self) -> dict[Any, Any]:
        """Attributes of the root as the file holds them."""
        return self.root.attrs

    @property
    def length(self) -> float:
        """Skirt length [m]."""
        return float(self.attrs["skirt_length_m"])

    @property
    def diameter(self) -> float:
        """Outer diameter [m]; a table does not have it."""
        return float(self.attrs["outer_diameter_m"])

    @property
    def drainage(self) -> str:
        """ "drained", "coupled", "undrained" or "total-stress" (clay; with sand: "drained, total-stress").

        "from a table" where nothing is recorded of it.
        """
        return str(self.attrs.get("drainage", "from a table"))

    @property
    def of_full_model(self) -> bool:
        """True for springs of a full model, false for those of a table."""
        return "schema" in self.attrs

    @property
    def of_atlas(self) -> bool:
        """True for springs of an atlas."""
        return self.spread is not None

    @property
    def reference(self) -> str:
        """Words for what the paths are recorded from."""
        if self.blended_loads is not None:
            low, high = (1e-3 * V for V in self.blended_loads)
            return f"the paths between those at V = {low:.6g} and {high:.6g} kN (no full model)"
        return f"the rays of the {self.attrs['source']}" if self.of_atlas else "the full model"

    @property
    def atlas_words(self) -> tuple[str, ...]:
        """Sentences that go with every use of springs of an atlas; none of others."""
        if not self.of_atlas:
            return ()
        words = OF_ATLAS.format(self.attrs["source"], self.attrs.get("atlas_cases", "?"))
        return tuple(filter(None, (words, *(str(self.attrs.get(name, "")) for name in ("atlas_mesh", "remarks")))))

    @property
    def first_steps(self) -> bool:
        """True where the initial stiffness is that of the first recorded steps of a table."""
        return "first_steps" in self.attrs

    @property
    def blended_loads(self) -> tuple[float, float] | None:
        """The two vertical loads [N] between which the springs are interpolated; None where they are not."""
        loads = self.attrs.get("blended_loads_N")
        return None if loads is None else (float(loads[0]), float(loads[1]))

    @property
    def stiffness(self) -> Array | None:
        """Initial stiffness (3, 3) for (u, w, rotation) [N/m, N, N m]; None where that of w is not known."""
        matrix: Array = self.root.variables["stiffness_initial"].values
        return matrix if matrix.shape == (3, 3) else None

    @property
    def lateral_stiffness(self) -> Array:
        """Initial stiffness (2, 2) for (u, rotation)."""
        matrix: Array = self.root.variables["stiffness_initial"].values
        return matrix[np.ix_([0, -1], [0, -1])]

    # --- paths ---

    def path(self, name: str | None = None) -> SpringPath:
        """Return a path; without a name the first lateral calibration path, else the first lateral one, or the first.

        Raises UserInputError for an unknown name.
        """
        if name is None:
            lateral = [path for path in self.paths.values() if not path.is_vertical]
            ranked = [*(path for path in lateral if path.calibrates), *lateral, *self.paths.values()]
            name = ranked[0].name if ranked else None
        if name is None or name not in self.paths:
            meant = suggestion(str(name), self.paths)
            raise refused("path", f"no path '{name}'{meant}; the springs have: {', '.join(self.paths) or 'none'}")
        return self.paths[name]

    @cached_property
    def lateral(self) -> tuple[SpringPath, ...]:
        """Lateral calibration paths."""
        return tuple(path for path in self.paths.values() if path.calibrates and not path.is_vertical)

    @cached_property
    def remembering(self) -> tuple[SpringPath, ...]:
        """Paths that turn back at the vertical load of the main paths: the memory of springs comes from them.

        Of springs between two vertical loads those at both.
        """
        main = self.paths[self.main_paths[0]].load if self.main_paths else self.rest_load
        loads, turning = self.blended_loads or (main,), [path for path in self.paths.values() if path.remembers]
        own = [path for path in turning if not path.load_changes]
        return tuple(path for path in own if any(same_load(path.load, load) for load in loads))

    @cached_property
    def turning(self) -> tuple[SpacePath, ...]:
        """Complete paths of the role "memory" that leave the plane, at the vertical load of the main paths."""
        main = self.paths[self.main_paths[0]].load if self.main_paths else self.rest_load
        found = (path for path in self.space.values() if path.remembers and path.attrs.get("status") == "complete")
        return tuple(path for path in found if same_load(path.load, main))

    @cached_property
    def changing(self) -> tuple[SpringPath, ...]:
        """Paths of the role "memory" on which the vertical load changes, of all vertical loads."""
        paths = (self.whole or self).paths.values()
        return tuple(path for path in paths if path.remembers and path.load_changes)

    @cached_property
    def vertical(self) -> tuple[SpringPath, ...]:
        """Vertical calibration paths."""
        return tuple(path for path in self.paths.values() if path.calibrates and path.is_vertical)

    @cached_property
    def ends(self) -> Mapping[str, PathEnd]:
        """How each path ended."""
        return {name: path.end for name, path in self.paths.items()}

    @cached_property
    def rest_load(self) -> float:
        """Vertical load [N] at rest: the scene's, or that of the first calibration path."""
        known = self.attrs.get("vertical_load_N")
        return float(known) if known is not None else self.path().load

    @cached_property
    def load_sets(self) -> tuple[path_sets.LoadSet, ...]:
        """Lateral calibration paths by vertical load, lightest first."""
        return path_sets.load_sets(self.lateral)

    @cached_property
    def main_paths(self) -> tuple[str, ...]:
        """Lateral calibration paths at the vertical load at rest."""
        return path_sets.nearest(self.load_sets, self.rest_load).paths if self.load_sets else ()

    @cached_property
    def rate_sets(self) -> tuple[path_sets.RateSet, ...]:
        """Lateral calibration paths by rate, slowest first; none where the springs do not depend on a rate."""
        return path_sets.rate_sets(self.lateral) if "coupled" in self.drainage.split(", ") else ()

    def paces(self, names: Iterable[str]) -> str:
        """Return the rates of the lateral ones of paths in words, where the springs are at several; else nothing."""
        own = (self.paths[name] for name in names if name in self.paths)
        known = [path.rate for path in own if path.rate and not path.is_vertical]
        if len(self.rate_sets) < 2 or not known:
            return ""
        ends = dict.fromkeys(f"{1e3 * each:.2g}" for each in (min(known), max(known)))
        return f" at {' to '.join(ends)} mm/s (of rho)"

    @cached_property
    def rays(self) -> Mapping[str, float]:
        """Rays among the main paths by increasing angle [rad]; close ones count once."""
        return rays_of(self.paths[name] for name in self.main_paths)

    @property
    def has_fan(self) -> bool:
        """True where the springs have the rays that a fan needs."""
        return len(self.rays) >= FEWEST_RAYS

    @cached_property
    def pure_paths(self) -> tuple[str, str] | None:
        """The rays that are a pure translation and a pure rotation; None where one of them is missing."""
        return pure_of(self.rays)

    # --- derived springs ---

    def at(self, *, rate: float | None = None, V: float | None = None) -> Springs:
        """Return the springs at a rate [m/s, of rho] and a vertical load [N], as one set of lateral paths.

        A rate must be in the range of the sets; V None is the load at rest, and beyond the range of the loads the
        nearest set answers.

        Raises UserInputError: the springs do not depend on a rate, or not in this range, or two sets have no path in
        common; no finite number.
        """
        check_numbers(V=V)
        return (self if rate is None else self.at_rate(rate)).at_load(self.rest_load if V is None else V)

    def at_rate(self, rate: float) -> Springs:
        """Return the springs at a rate [m/s, of rho], at all their vertical loads. Raises as `at` does."""
        if not rate > 0.0:
            raise refused("rate", f"{1e3 * rate:g} mm/s is not positive")
        if not self.rate_sets:
            raise refused("rate", f"the springs are {self.drainage}: they do not depend on a rate")
        return self._cached(("rate", rate), lambda: self._made_at_rate(rate))

    def at_load(self, V: float) -> Springs:
        """Return the springs at a vertical load [N], as one set of lateral paths."""
        if len(self.load_sets) < 2:
            return self
        V = float(V)  # of an array of no dimension, too
        return self._cached(("load", V), lambda: self._made_at_load(V))

    def answering(self, path: SpringPath) -> Springs:
        """Return the springs that answer one of their paths: at its rate and vertical load, as far as these are known.

        Of several rates a calibration path is answered at that of its own set, any other at its own, or at the nearest
        one of the sets. A calibration path alone at its load is held back there: it is answered by itself.
        """
        springs = self._at_rate_of(path).at_load(path.load)
        if path.name in springs.paths:
            return springs
        own = SpringPath(path.name, path.dataset.assign_attrs(role="held-back"), path.length)

        def beside() -> Springs:
            made = springs.with_paths([*springs.paths.values(), own])
            return replace(made, whole=springs.whole, every_rate=springs.every_rate, parts=springs.parts)

        return springs._cached(("beside", path.name), beside)

    def with_paths(self, paths: Iterable[SpringPath], **attrs: Any) -> Springs:
        """Return springs with other paths, and some attributes of the root changed; they are derived from no others."""
        root, own = self.root.assign_attrs(attrs), {path.name: path for path in paths}
        return replace(self, root=root, paths=own, whole=None, every_rate=None, parts=(), _derived={})

    def _at_rate_of(self, path: SpringPath) -> Springs:
        sets = self.rate_sets
        if len(sets) < 2:
            return self
        own = [each for each in sets if path.name in each.paths]
        rate = path.rate or sets[0].rate
        return self.at_rate(own[0].rate if own else min(max(rate, sets[0].rate), sets[-1].rate))

    def _made_at_rate(self, rate: float) -> Springs:
        lateral, mix = path_sets.at_rate(self.paths, self.rate_sets, rate)
        vertical = self._vertical_at_rate(rate)
        turning = [path for path in self.paths.values() if path.remembers and path.rate and is_rate(path.rate, rate)]
        springs = self.with_paths([*lateral.values(), *vertical, *turning], rate_m_per_s=rate)
        validate_springs(springs.tree, balanced=False)  # as balanced as what they are made of
        shares = () if mix is None else ((mix.first, 1.0 - mix.share), (mix.second, mix.share))
        parts = tuple((self.at_rate(each), share) for each, share in shares)
        return replace(springs, every_rate=self.every_rate or self, parts=parts)

    def _vertical_at_rate(self, rate: float) -> Iterable[SpringPath]:
        """Return the vertical paths at a rate [m/s], or at the nearest one that they have."""
        sets = path_sets.rate_sets(self.vertical)
        if len(sets) < 2:
            return self.vertical
        return path_sets.at_rate(self.paths, sets, min(max(rate, sets[0].rate), sets[-1].rate))[0].values()

    def _made_at_load(self, V: float) -> Springs:
        main = path_sets.nearest(self.load_sets, self.rest_load)
        lateral, mix = path_sets.at_load(self.paths, self.load_sets, main, V)
        dropped = {path.name for path in self.lateral} - set(lateral)
        paths = [lateral.get(name, path) for name, path in self.paths.items() if name not in dropped]
        attrs = {} if mix is None else {"blended_loads_N": [mix.first, mix.second], "vertical_load_N": V}
        parts = tuple((each.at_load(V), share) for each, share in self.parts)
        return replace(self.with_paths(paths, **attrs), whole=self, every_rate=self.every_rate, parts=parts)

    def _cached(self, key: Hashable, make: Callable[[], Springs]) -> Springs:
        """Return derived springs, made at the first call; the last `KEPT` ones are kept."""
        if key not in self._derived:
            if len(self._derived) >= KEPT:
                del self._derived[next(iter(self._derived))]
            self._derived[key] = make()
        return self._derived[key]
