# SPDX-License-Identifier: MIT
"""Springs at a vertical load: sets of lateral paths at several dead loads, and what lies between them.

A dead load presses lid and tip on the soil: it changes contact and friction, and with them every lateral reaction. The
vertical load of a path is V at its start. Lateral calibration paths of the same V are one set; the main set has the
vertical load of the scene. Between two sets every reaction is interpolated at the same state, linearly in V,

    r(state, V) = (1 - s) r_a(state) + s r_b(state),   s = (V - V_a)/(V_b - V_a),

so that the sums of reactions stay the loads. Beyond the lightest and the heaviest set the nearest one answers, and the
answer says so.
"""

from __future__ import annotations

from dataclasses import dataclass

import xarray as xr

from pysprings.springs import rates
from pysprings.springs.alike import same_load
from pysprings.springs.dataset import get_path, is_vertical, path_dataset, path_load, path_names

# Sets are interpolated where they have this many directions in common
FEWEST_PAIRS = 2


@dataclass(frozen=True, slots=True)
class LoadSet:
    """Lateral calibration paths at one vertical load [N]."""

    V: float
    paths: tuple[str, ...]


def rest_load(springs: xr.DataTree) -> float:
    """Return the vertical load [N] of the springs: the scene's, or that of the first calibration path."""
    known = springs.attrs.get("vertical_load_N")
    return float(known) if known is not None else path_load(get_path(springs))


def main_paths(springs: xr.DataTree) -> tuple[str, ...]:
    """Return the lateral calibration paths at the vertical load of the springs, in their order."""
    sets = load_sets(springs)
    return _nearest(sets, rest_load(springs)).paths if sets else ()


def load_sets(springs: xr.DataTree) -> list[LoadSet]:
    """Return the sets of lateral calibration paths by vertical load, lightest first."""
    groups: list[tuple[float, list[str]]] = []
    for name in path_names(springs, "calibration"):
        if is_vertical(springs, name):
            continue
        V = path_load(path_dataset(springs, name))
        own = [names for other, names in groups if same_load(V, other)]
        if own:
            own[0].append(name)
        else:
            groups.append((V, [name]))
    return [LoadSet(V, tuple(names)) for V, names in sorted(groups, key=lambda group: group[0])]


def at_load(springs: xr.DataTree, V: float | None = None) -> xr.DataTree:
    """Return springs at a vertical load [N] (None: that of the springs), as one set of lateral paths.

    Those of the set at that load, between the two sets around it, or those of the nearest set. Sets serve that have the
    directions of the main one. Vertical and held-back paths stay as they are.
    """
    sets = load_sets(springs)
    if len(sets) < 2:
        return springs
    wanted, main = rest_load(springs) if V is None else V, _nearest(sets, rest_load(springs))
    length = float(springs.attrs["skirt_length_m"])
    sets = [each for each in sets if each is main or _alike(springs, main, each, length)]
    near = _nearest(sets, wanted)
    if same_load(near.V, wanted) or not sets[0].V < wanted < sets[-1].V:
        return _tree(springs, sets, {name: path_dataset(springs, name) for name in near.paths})
    above = next(k for k, each in enumerate(sets) if wanted < each.V)
    light, heavy = sets[above - 1], sets[above]
    share = (wanted - light.V) / (heavy.V - light.V)
    blended = {
        a: rates.blend(get_path(springs, a), get_path(springs, b), share, length)
        for a, b in _pairs(springs, light, heavy, length)
    }
    tree = _tree(springs, sets, blended)
    tree.attrs |= {"blended_loads_N": [light.V, heavy.V], "vertical_load_N": wanted}
    return tree


def for_path(springs: xr.DataTree, path: xr.Dataset) -> xr.DataTree:
    """Return the springs that answer a path of the same run: at its rate and vertical load, as far as they know."""
    found = at_load(rates.for_path(springs, path), path_load(path))
    name = path.attrs["path"]
    if name not in path_names(found):  # a calibration path that stands alone at its load is answered by itself
        groups = {f"/paths/{each}": path_dataset(found, each) for each in path_names(found)}
        own = path.assign_attrs(role="held-back")
        found = xr.DataTree.from_dict({"/": found.to_dataset(inherit=False), **groups, f"/paths/{name}": own})
    return found


def _nearest(sets: list[LoadSet], V: float) -> LoadSet:
    return min(sets, key=lambda each: abs(each.V - V))


def _alike(springs: xr.DataTree, main: LoadSet, other: LoadSet, length: float) -> bool:
    return len(_pairs(springs, main, other, length)) >= min(FEWEST_PAIRS, len(main.paths))


def _pairs(springs: xr.DataTree, first: LoadSet, second: LoadSet, length: float) -> list[tuple[str, str]]:
    return rates.pairs(springs, first.paths, second.paths, length, by_load=True)


def _tree(springs: xr.DataTree, sets: list[LoadSet], lateral: dict[str, xr.Dataset]) -> xr.DataTree:
    """Springs whose lateral calibration paths are the given ones; all others stay."""
    root = springs.to_dataset(inherit=False)
    root.attrs = dict(springs.attrs)
    dropped = {name for each in load_sets(springs) for name in each.paths} - set(lateral)
    kept = {name: path_dataset(springs, name) for name in path_names(springs) if name not in dropped}
    paths = {name: lateral.get(name, path) for name, path in kept.items()}
    return xr.DataTree.from_dict({"/": root} | {f"/paths/{name}": path for name, path in paths.items()}, name="springs")
