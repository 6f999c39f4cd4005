# SPDX-License-Identifier: MIT
"""Kinds of load path: what each imposes, what answers, and which keys of a scene it uses. A new kind is one entry here.

Degrees of freedom of the caisson: u, w, rotation; loads H, V, M in the same order. A path that leaves one plane moves
it in six: `MOTIONS`, `LOADS`.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

Dof = Literal["u", "w", "rotation"]
MOTIONS = ("u_x", "u_y", "w", "rot_x", "rot_y", "rot_z")
LOADS = ("H_x", "H_y", "V", "M_x", "M_y", "T")
VERTICAL, TWIST = "vertical", "twist"
# keys of a scene that hold an imposed quantity, and the unit in which messages show it
UNITS = {
    "lateral_displacement": "mm",
    "rotation": "deg",
    "vertical_displacement": "mm",
    "lateral_force": "MN",
    "twist": "mrad",
    "radius": "mm",
}


@dataclass(frozen=True, slots=True)
class PathKind:
    """One kind of load path.

    imposed : key of the scene with the imposed quantity.
    drives : degree of freedom that grows along the path.
    load, companion : load that answers `drives`; second answer of the accuracy study (None: there is none).
    answers : answers whose errors the comparison reports.
    holds : degrees of freedom that are imposed; none where a force is given.
    uses, needs : further keys of the scene that apply; those of them that must be given.
    paces : keys that can give the path its time.
    force : the path is driven by a given force.
    free_head : the load acts at a height (`arm`), and the rotation is free.
    straight : rotation/u is constant along the path, so that it can be a ray of a fan.
    in_turn : the imposed quantity comes first, then the rotation at its end value.
    bends : H and M need not keep their ratio, or u need not grow: the path is followed along |u| + |rotation| L, and
        cannot calibrate springs.
    conjugate : the load keeps its direction (`load_angle`), and the displacement conjugate to it is imposed.
    limited : the path ends where the caisson has moved too far for a foundation.
    pairs : what follows (`then`) may give two end values: "H, M" under given loads, "u, rotation" of imposed motions.
    space : the path leaves the plane of one load.
    turns : what follows may lead on in another direction ("12 mm towards 90 deg").
    """

    imposed: str
    drives: Dof
    load: str
    companion: str | None
    answers: tuple[str, ...]
    holds: tuple[Dof, ...]
    uses: frozenset[str] = field(default_factory=frozenset)
    needs: tuple[str, ...] = ()
    paces: tuple[str, ...] = ("rate", "duration")
    force: bool = False
    free_head: bool = False
    straight: bool = False
    in_turn: bool = False
    bends: bool = False
    conjugate: bool = False
    limited: bool = False
    pairs: bool = False
    space: bool = False
    turns: bool = False


PATH_KINDS: Mapping[str, PathKind] = {
    "pull": PathKind(
        "lateral_displacement", "u", "H", "rotation", ("H", "rotation"), ("u",), frozenset({"arm", "rate"}),
        free_head=True, turns=True,
    ),
    "translation": PathKind(
        "lateral_displacement", "u", "H", "M", ("H", "M"), ("u", "rotation"), frozenset({"rotation", "rate"}),
        straight=True, turns=True,
    ),
    "rotation": PathKind(
        "rotation", "rotation", "M", "H", ("H", "M"), ("u", "rotation"), paces=("duration",), straight=True
    ),
    "swipe": PathKind(
        "lateral_displacement", "u", "H", "M", ("H", "M"), ("u", "rotation"), frozenset({"rotation", "rate"}),
        needs=("rotation",), paces=("rate",), in_turn=True, bends=True, pairs=True,
    ),
    "load": PathKind(
        "lateral_force", "u", "H", "rotation", ("H", "rotation"), (), frozenset({"arm", "arm_from"}),
        paces=("duration",), force=True, free_head=True, limited=True, pairs=True,
    ),
    "probe": PathKind(
        "lateral_displacement", "u", "H", "M", ("H", "M"), ("u",), frozenset({"load_angle", "rate"}),
        needs=("load_angle",), paces=("rate",), bends=True, conjugate=True, limited=True,
    ),
    VERTICAL: PathKind(
        "vertical_displacement", "w", "V", None, ("V",), ("u", "w", "rotation"), frozenset({"rate"})
    ),
    "twist": PathKind("twist", "rotation", "T", None, ("T",), ("rotation",), paces=("duration",), space=True),
    "circle": PathKind("radius", "u", "H", None, ("H",), ("u", "rotation"), paces=("duration",), space=True),
    "motion": PathKind("", "u", "H", None, ("H",), ("u", "rotation"), paces=("duration",), space=True),
}  # fmt: skip


# Roles of paths: springs are made from the first, their memory from the first two; the third is for checks alone
CALIBRATION, MEMORY, HELD_BACK = "calibration", "memory", "held-back"
ROLES = (CALIBRATION, MEMORY, HELD_BACK)
# Attributes of a recorded path: number of parts after the first one; 1 where these have two end values each
PARTS, PAIRS = "then_parts", "then_pairs"


def bends(attrs: Mapping[object, object]) -> bool:
    """Return whether H and M change their ratio on a path with these attributes: a swipe, a load that climbs."""
    return PATH_KINDS[str(attrs["kind"])].bends or "arm_from_m" in attrs or PAIRS in attrs


def direction_of_load(attrs: Mapping[Any, Any]) -> tuple[float, float] | None:
    """Return H and M [m] over the size of the load on a path that keeps the direction of its load; None of others."""
    if not PATH_KINDS[str(attrs["kind"])].conjugate:
        return None
    return math.cos(float(attrs["load_angle_rad"])), float(attrs["load_lever_m"])


def turns_back(attrs: Mapping[object, object]) -> bool:
    """Return whether a path with these attributes has further parts after its first one (`then`)."""
    return int(str(attrs.get(PARTS, 0))) > 0


def kind_of(attrs: Mapping[object, object]) -> PathKind:
    """Return the kind of a path with these attributes; a load that climbs answers as a swipe does."""
    kind = PATH_KINDS[str(attrs["kind"])]
    return PATH_KINDS["swipe"] if bends(attrs) else kind


def driven(attrs: Mapping[Any, Any]) -> Dof:
    """Return the degree of freedom that grows along a path with these attributes; u of lateral paths from a table."""
    kind = PATH_KINDS.get(str(attrs.get("kind")))
    return kind.drives if kind else "u"


def beam_order(attrs: Mapping[Any, Any]) -> tuple[bool, bool, bool]:
    """Return a key that sorts lateral paths by their use for a beam: a pure translation first, held-back paths last."""
    pure = attrs.get("kind") == "translation" and abs(float(attrs.get("end_rotation_rad", 0.0))) < 1e-12
    return attrs.get("role") != CALIBRATION, turns_back(attrs), not pure


def has_free_head(attrs: Mapping[Any, Any]) -> bool:
    """Return whether the load of a path with these attributes acts at a height, and the rotation is free."""
    kind = PATH_KINDS.get(str(attrs.get("kind")))
    return kind is not None and kind.free_head


def height_of_load(attrs: Mapping[Any, Any]) -> float | None:
    """Return the height [m] above mudline where the load of a path acts; None without a free head, or if it changes."""
    return float(attrs["arm_m"]) if has_free_head(attrs) and "arm_m" in attrs and not bends(attrs) else None


def is_straight(attrs: Mapping[object, object]) -> bool:
    """Return whether a path keeps its direction: by its kind, or marked so (paths read from a table have no kind)."""
    kind = PATH_KINDS.get(str(attrs["kind"]))
    return bool(kind and kind.straight) or bool(attrs.get("straight"))
