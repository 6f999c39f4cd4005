# SPDX-License-Identifier: MIT
"""Springs at a vertical load: sets of lateral paths at several dead loads, and the paths between two sets.

A dead load presses lid and tip on the soil: it changes contact and friction, and with them every lateral reaction. The
vertical load of a path is V at its start. Lateral calibration paths of the same V are one set; the main set has the
vertical load of the scene. Between two sets every reaction is interpolated at the same state, linearly in V,

    r(state, V) = (1 - s) r_a(state) + s r_b(state),   s = (V - V_a)/(V_b - V_a),

so that the sums of reactions stay the loads. Beyond the lightest and the heaviest set the nearest one answers, and the
answer is marked.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from pysprings.springs.alike import same_load
from pysprings.springs.path import SpringPath
from pysprings.springs.rates import Between, blend, one_rate, pairs

# Sets are interpolated where they have this many directions in common
FEWEST_PAIRS = 2
Paths = Mapping[str, SpringPath]


@dataclass(frozen=True, slots=True)
class LoadSet:
    """Lateral calibration paths at one vertical load [N]."""

    V: float
    paths: tuple[str, ...]


def load_sets(paths: Iterable[SpringPath]) -> tuple[LoadSet, ...]:
    """Return the sets of lateral calibration paths by vertical load, lightest first."""
    groups: list[tuple[float, list[str]]] = []
    for path in paths:
        own = [names for other, names in groups if same_load(path.load, other)]
        if own:
            own[0].append(path.name)
        else:
            groups.append((path.load, [path.name]))
    return tuple(LoadSet(V, tuple(names)) for V, names in sorted(groups, key=lambda group: group[0]))


def nearest(sets: Sequence[LoadSet], V: float) -> LoadSet:
    """Return the set whose vertical load is nearest to V [N]."""
    return min(sets, key=lambda each: abs(each.V - V))


def at_load(
    paths: Paths, sets: Sequence[LoadSet], main: LoadSet, V: float
) -> tuple[dict[str, SpringPath], Between | None]:
    """Return the lateral paths at a vertical load V [N], and what they lie between.

    They are those of the set at that load (None), between the two sets around it, or those of the nearest set (None).
    Only sets count that have the directions of the main one.
    """
    alike = [each for each in sets if each is main or _alike(paths, main, each)]
    near = nearest(alike, V)
    if same_load(near.V, V) or not alike[0].V < V < alike[-1].V:
        return {name: paths[name] for name in near.paths}, None
    above = next(k for k, each in enumerate(alike) if V < each.V)
    light, heavy = alike[above - 1], alike[above]
    share = (V - light.V) / (heavy.V - light.V)
    return {a.name: blend(a, b, share) for a, b in _pairs(paths, light, heavy)}, Between(light.V, heavy.V, share)


def _alike(paths: Paths, main: LoadSet, other: LoadSet) -> bool:
    return len(_pairs(paths, main, other)) >= min(FEWEST_PAIRS, len(main.paths))


def _pairs(paths: Paths, first: LoadSet, second: LoadSet) -> list[tuple[SpringPath, SpringPath]]:
    return pairs([paths[name] for name in first.paths], [paths[name] for name in second.paths], one_rate)
