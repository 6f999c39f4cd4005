# SPDX-License-Identifier: MIT
"""Spring sets that uniaxial springs can represent, their errors on the paths of the full model, and their export.

Virtual springs represent a fan: a lateral spring at depth z of a rigid body reads u - z rotation. With z = -L
tan(angle) it reads the component of (u, rotation L) in a direction; a rotational spring reads -90 deg. The springs
stand at depths where there may be no skirt: they represent the foundation as a whole, not its parts. Each direction has
a sum of curves k q/(1 + (|q|/d)^4)^(1/4), k >= 0, and a straight line, in several planes (`uniaxial_curve.spread`). k
comes from non-negative least squares over the loads of the fan, relative errors, with the initial stiffness as heavy
rows.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from pysprings.core.arrays import Array
from pysprings.core.errors import refused
from pysprings.core.loads import close_loads
from pysprings.core.path_kinds import HELD_BACK
from pysprings.core.text import percent
from pysprings.core.variables import known_torsion
from pysprings.macro import measures
from pysprings.macro.comparison import along_path
from pysprings.macro.curve_table import Row, SpringTable, leading, stack
from pysprings.macro.fan import FanTable
from pysprings.macro.model import MacroModel
from pysprings.macro.solver import row_values
from pysprings.results.exporters import uniaxial_curve
from pysprings.results.exporters.base import RINGS, VIRTUAL, ZONE, Options, Source
from pysprings.results.exporters.header import header, springs_at, torsion_words
from pysprings.results.exporters.uniaxial_curve import FAR, KNOTS, SCALES, SIZES, Spring, Table
from pysprings.springs.path import SpringPath
from pysprings.springs.springs import Springs
from pysprings.springs.sums import slice_heights
from pysprings.springs.tip_zone import reslice

DIRECTIONS = np.radians(np.arange(80.0, -91.0, -10.0))  # from the highest to the deepest
STEP = np.radians(5.0)  # between the states of the fit
HEAVY = 3.0  # weight of the initial stiffness, of which there are few rows
PULLS = np.radians(80.0)  # motions of pulls: from a translation to nearly a rotation
LEAST = 1e-6  # springs with less than this share of the stiffness are left out

STRATA, DEEPEST = 24, 2.0  # of a pile that stands for the foundation; its length over that of the skirt
WEIGHT = 3.0  # of pulls on it: default scene, u up to half of the largest load, 3 % off (1: 7), beyond 8 % (10: 10)
OPPOSED = (
    "not for loads near the depth of the tip and below (M against H): in the default scene, L 4 m, u under one 3 m "
    "below mudline is off by 19 %, at 5 m by 90 %"
)

# measures of a path, and the words before them
_CHECKED = {
    "H_error_max_pct": "H", "M_error_max_pct": "M", "rotation_error_max_pct": "rotation at equal u",
    "u_error_max_pct": "u at equal load", "u_error_half_pct": "u up to half of the largest load",
}  # fmt: skip


def virtual_table(
    model: MacroModel, planes: int = 2, directions: Array = DIRECTIONS, pulls: float = 1.0
) -> SpringTable:
    """Return the laws of the springs at virtual depths, in each plane, of a model on a fan: see `uniaxial`."""
    table = model.table
    assert isinstance(table, FanTable)
    reach = float(table.range.max())
    weights = _fit(model, table, reach, planes, directions, pulls)
    rows = [_row(angle, each, reach, table.length) for angle, each in zip(directions, weights, strict=True)]
    total = max(float(each.sum()) for each in weights)
    return stack([row for row, each in zip(rows, weights, strict=True) if each.sum() > LEAST * total])


def _fit(
    model: MacroModel, table: FanTable, reach: float, planes: int, directions: Array, pulls: float
) -> Array:  # fmt: skip
    """Return the stiffness (directions, scales) [N/m] of the curves."""
    from scipy.optimize import nnls

    states = _states(table)
    L = table.length
    loads = np.array([model.reactions(u, v / L)[0] / [1.0, L] for u, v in states])
    along = np.stack([np.cos(directions), np.sin(directions)])  # (2, directions)
    forces = uniaxial_curve.in_planes(states @ along, reach, planes)  # (states, directions, scales)
    turned = np.arctan2(states[:, 1], states[:, 0]) % np.pi
    weight = np.where(turned <= PULLS, pulls, 1.0) / np.linalg.norm(loads, axis=1)
    columns = np.einsum("id,sdk->sidk", along, forces) * weight[:, None, None, None]
    K = model.reactions(0.0, 0.0)[1] / [[1.0, L], [L, L * L]]
    size = np.linalg.norm(K)
    initial = 0.5 * planes * np.einsum("id,jd,k->ijdk", along, along, np.ones(SCALES.size)) / size
    heavy = HEAVY * np.sqrt(pulls * len(states) / 4.0)
    n = directions.size * SCALES.size
    left = np.concatenate([columns.reshape(-1, n), heavy * initial.reshape(-1, n)])
    right = np.concatenate([(loads * weight[:, None]).ravel(), heavy * (K / size).ravel()])
    scale = np.linalg.norm(left, axis=0)
    k: Array = nnls(left / scale, right, maxiter=30 * n)[0] / scale
    return k.reshape(directions.size, SCALES.size)


def _states(table: FanTable) -> Array:
    """Return states (n, 2) = (u, rotation L) [m] in half the plane, each up to the range of the fan there."""
    angles = -np.arange(-0.5 * np.pi, 0.5 * np.pi, STEP) - STEP
    ends = np.array([[np.cos(a), np.sin(a) / table.length] for a in angles])
    used = table.support(ends)[0]
    states: Array = (ends * [1.0, table.length] / used[:, None])[:, None, :] * SIZES[:, None]
    return states.reshape(-1, 2)


def _row(angle: float, weights: Array, reach: float, length: float) -> Row:
    """Return the spring of a direction: lateral at depth -L tan(angle), or rotational at -90 deg."""
    q = KNOTS * reach  # component of (u, rotation L) in the direction
    r = uniaxial_curve.curves(q, reach) @ weights
    if abs(np.cos(angle)) < 1e-6:
        return Row("virtual", 0.0, "rotation", (0.0, 1.0), (0.0, 1.0), q / length, r * length)
    depth = float(-length * np.tan(angle))
    return Row("virtual", depth, "y", (1.0, -depth), (1.0, -depth), q / np.cos(angle), r * np.cos(angle))


PLANES = 8  # of virtual springs
ROUNDING = 1e-6  # u over that of the rotation: less is no displacement


@dataclass(frozen=True, slots=True, eq=False)
class Uniaxial:
    """Uniaxial springs of a caisson.

    model : macro-model of a motion along a plane; its lateral springs all read the displacement that they act against.
    rows : laws of the lateral and rotational springs in each plane.
    planes : number of vertical planes, at equal angles.
    springs : lateral, rotational and vertical springs; the last act from the state at rest on.
    lost : sentences on what the springs do not represent.
    """

    model: MacroModel
    rows: SpringTable
    planes: int
    springs: tuple[Spring, ...]
    lost: tuple[str, ...]

    @property
    def between(self) -> MacroModel:
        """Macro-model of a motion in the middle between two planes."""
        return self.model.on_rows(uniaxial_curve.together(self.rows, self.planes, between=True))


def uniaxial(
    springs: Springs, kind: str | None = None, V: float | None = None, planes: int = 0, slices: str = RINGS,
    directions: Array = DIRECTIONS, pulls: float = 1.0,
) -> Uniaxial:  # fmt: skip
    """Return the uniaxial springs of a set: "virtual" (of a fan; the default with one), "pisa", "full" or "py".

    Springs at real depths stand in the slices of the mesh ("rings"), or in those of `reslice` with the last fifth of
    the skirt as one ("zone", or blank). V [N] selects the lateral springs of several vertical loads. `planes` is the
    number of vertical planes in which springs stand, even; 0 for that of the set: 8 of virtual springs, 2 of others,
    which are exact along both. `directions` (n,) [rad] are those that virtual springs read;
    in their fit motions of pulls have the weight `pulls`.

    Raises UserInputError: the springs do not give the set, or there are none of a full model.
    """
    chosen = kind or (VIRTUAL if springs.has_fan else "full")
    planes = planes or (PLANES if chosen == VIRTUAL else 2)
    if planes < 2 or planes % 2:
        raise refused("--option planes", f"{planes} is not an even number of planes")
    if slices == ZONE and chosen == VIRTUAL:
        raise refused(
            "--option slices", "virtual springs have no slices: springs=pisa, full or py stand at real depths"
        )
    if slices != RINGS and chosen != VIRTUAL:
        springs = Springs.of(reslice(springs.tree))
    model = MacroModel.from_springs(springs, "fan" if chosen == VIRTUAL else chosen, V=V)
    if chosen == VIRTUAL:
        made, lost = (
            virtual_table(model, planes, directions, pulls),
            ["lateral springs stand at virtual depths: they represent the whole foundation"],
        )
    else:
        assert isinstance(model.table, SpringTable)
        made, lost = _represent(model.table, model.origin)
        made = uniaxial_curve.spread(_loaded(made), planes)
    if not made.name:
        raise refused("springs", f"the set '{chosen}' has no springs")
    own = replace(model.on_rows(uniaxial_curve.together(made, planes)), spring_set=chosen)
    heights = dict(zip(model.origin.depth.tolist(), slice_heights(model.origin.recorded).tolist(), strict=True))
    return Uniaxial(own, made, planes, (*lateral(made, heights), *_vertical(own)), tuple(lost))


def on_a_pile(springs: Springs, V: float | None) -> tuple[Uniaxial, float]:
    """Return the virtual springs of a fan in strata of a rigid pile below mudline, and the length of the pile [m].

    Each lateral spring stands in the middle of its stratum, whose height it has; strata that need none have none. One
    spring turns against the rotation. V [N] selects the lateral springs of several vertical loads.
    """
    middles = -np.arctan(DEEPEST * (np.arange(STRATA) + 0.5) / STRATA)
    made = uniaxial(springs, VIRTUAL, V, 2, directions=np.append(middles, -0.5 * np.pi), pulls=WEIGHT)
    length, h = DEEPEST * springs.length, DEEPEST * springs.length / STRATA
    return replace(made, springs=tuple(
        replace(each, depth=h * (each.depth // h + 0.5), height=h) if each.direction == "lateral" else each
        for each in made.springs
    )), length  # fmt: skip


def _represent(rows: SpringTable, path: SpringPath) -> tuple[SpringTable, list[str]]:
    """Return the rows that read what they act against, the others as springs on the lid; and what is lost.

    The action of the others along the path is kept: their force over u, their moment over the rotation.
    """
    cross = np.abs(rows.a[:, 0] * rows.b[:, 1] - rows.a[:, 1] * rows.b[:, 0])
    own = cross <= 1e-9 * np.linalg.norm(rows.a, axis=1) * np.linalg.norm(rows.b, axis=1)
    if own.all():
        return rows, []
    parts = [_part(rows, int(j)) for j in np.flatnonzero(own)]
    states = np.stack([path.u - path.u[0], path.rotation - path.rotation[0]])
    others = ~own
    forces = row_values(rows.q[others], rows.r[others], rows.slope[others], rows.count[others], rows.a[others] @ states)
    action = rows.b[others].T @ forces
    names = ", ".join(sorted({f"{rows.name[j]} at {rows.depth[j]:.3g} m" for j in np.flatnonzero(others)}))
    lost = [f"springs that read another displacement stand on the lid, exact on path '{path.name}' alone: {names}"]
    reach = float(np.hypot(states[0], path.length * states[1]).max())
    for name, q, r, a in (("H_rest", states[0], action[0], (1.0, 0.0)), ("M_rest", states[1], action[1], (0.0, 1.0))):
        if leading(q, r, reach if a[0] else reach / path.length, resists=False) == q.size:
            parts.append(Row(name, 0.0, "u" if a[0] else "rotation", a, a, q, r))
        elif np.abs(r).max() > 0.0:
            lost.append(
                f"their {'force' if a[0] else 'moment'} is left out: its displacement does not grow on the path"
            )
    return stack(parts), lost


def _part(rows: SpringTable, j: int) -> Row:
    n = int(rows.count[j])
    (a0, a1), (b0, b1) = rows.a[j].tolist(), rows.b[j].tolist()
    return Row(
        rows.name[j], float(rows.depth[j]), rows.carrier[j], (a0, a1), (b0, b1),
        rows.q[j, :n], rows.r[j, :n], bool(rows.natural[j]), bool(rows.cut[j]),
    )  # fmt: skip


def _loaded(rows: SpringTable) -> SpringTable:
    """Return the rows without those that carry nothing."""
    carry = [_part(rows, j) for j in range(len(rows.name)) if rows.r[j, : rows.count[j]].any()]
    return rows if len(carry) == len(rows.name) else stack(carry)


def lateral(rows: SpringTable, heights: Mapping[float, float]) -> Iterator[Spring]:
    """Yield the lateral and rotational springs of a plane; heights [m] of the slices by their depth."""
    for j, name in enumerate(rows.name):
        sideways = bool(rows.a[j, 0] != 0.0)
        k = 0 if sideways else 1
        depth = float(-rows.a[j, 1] / rows.a[j, 0]) if sideways else float(rows.depth[j])
        end, factor = float(rows.range[j] / abs(rows.a[j, k])), float(rows.b[j, k])

        def force(x: Array, j: int = j, k: int = k, factor: float = factor) -> Array:
            one = slice(j, j + 1)
            q = np.ascontiguousarray(np.atleast_1d(x)[None] * rows.a[j, k])
            return factor * row_values(rows.q[one], rows.r[one], rows.slope[one], rows.count[one], q)[0]

        height = heights.get(float(rows.depth[j]), 0.0) if name in ("p", "m") else 0.0
        yield Spring(name, "lateral" if sideways else "rotation", depth, height, -end, end, force)


def _vertical(model: MacroModel) -> Iterator[Spring]:
    """Yield the vertical spring: the change of V [N] over the change of w [m] from rest, elastic where not known."""
    vertical = model.vertical
    if model.stiffness_initial is None:
        return
    stiffness, reach = float(model.stiffness_initial[1, 1]), 1e-3
    down, up = (None, None) if vertical is None else (vertical.branch(1.0), vertical.branch(-1.0))

    def force(x: Array) -> Array:
        values = stiffness * np.atleast_1d(x)
        for branch in (down, up):
            if branch is not None:
                own = branch.sign * values > 0.0
                values[own] = branch.at(np.abs(np.atleast_1d(x)[own]), [-1])[0] - branch.r[-1, 0]
        return values

    low, high = -(up.end[0] if up else reach), down.end[0] if down else reach
    yield Spring("V", "vertical", 0.0, 0.0, low, high, force)


# --- tables, and what they cost ---


def tables(made: Uniaxial, points: int) -> list[Table]:
    """Return every spring as a table of at most `points` points within its range, with two far ones."""
    return [uniaxial_curve.with_far(uniaxial_curve.table(spring, points)) for spring in made.springs]


def with_tables(made: Uniaxial, given: list[Table]) -> MacroModel:
    """Return the model on the straight lines of tables (`straight_lines`)."""
    rows = []
    for each in given:
        if each.spring.odd:
            lateral, depth = each.spring.direction == "lateral", each.spring.depth
            a = (1.0, -depth) if lateral else (0.0, 1.0)
            q, f = each.within()
            rows.append(Row(each.spring.name, depth, "y" if lateral else "rotation", a, a, q[q >= 0.0], f[q >= 0.0]))
    return made.model.on_rows(uniaxial_curve.together(stack(rows, straight=True), made.planes))


def _is_under(path: SpringPath, V: float) -> bool:
    """Return whether springs at V [N] hold on the whole of a path."""
    return bool(close_loads(path.given_loads, V).all())


def errors_by_role(springs: Springs, model: MacroModel, what: str) -> list[str]:
    """Return a sentence for calibration and held-back paths: largest errors beside the full model, and their paths.

    Paths at another V than that of the springs, or under one that changes, count for nothing here.
    """
    worst: dict[str, dict[str, tuple[float, str]]] = {}
    V, elsewhere = springs.path().load, False
    for path in springs.paths.values():
        if path.is_vertical:
            continue
        if not _is_under(path, V):
            elsewhere |= path.role == HELD_BACK
            continue
        answer = along_path(path, model)
        n = answer.sizes["step"]
        errors = measures.errors(path, answer, measures.abscissa(path)[:n], path.rules.answers)
        errors |= measures.at_equal_load(path, answer)
        if np.abs(path.u).max() < ROUNDING * springs.length * np.abs(path.rotation).max():
            errors["u_error_max_pct"] = errors["u_error_half_pct"] = np.nan  # a rotation about the lid centre
        of_role = worst.setdefault(path.role, {})
        for key, words in _CHECKED.items():
            error = float(errors[key])
            if np.isfinite(error) and abs(error) >= abs(of_role.get(words, (0.0, ""))[0]):
                of_role[words] = error, path.name
        if n < path.n:
            of_role[f"no equilibrium beyond state {n} of {path.name}"] = 0.0, ""
        if beyond := int(answer["extrapolated"].sum()):
            of_role[f"{beyond} of {n} states of {path.name} beyond the range of the springs"] = 0.0, ""
    lines = []
    for role, each in worst.items():
        parts = [f"{words} {error + 0.0:+.2f} % ({path})" if path else words for words, (error, path) in each.items()]
        lines.append(f"{what}, {role} paths, largest: {', '.join(parts) or 'no state'}")
    unchecked = elsewhere and HELD_BACK not in worst
    return [*lines, *[f"{what}: no path is held back at V = {1e-3 * V:.6g} kN"] * unchecked]


def change_by_tables(springs: Springs, smooth: MacroModel, straight: MacroModel) -> str:
    """Return a sentence on what tables change on all paths: loads at recorded motions, motions under these loads."""
    motion, load = np.zeros(2), np.zeros(2)
    for path in springs.paths.values():
        if path.is_vertical or path.n < 3:
            continue
        for step in (path.n // 4, path.n // 2, path.n - 1):
            a, b = (model.reactions(path.u[step], path.rotation[step])[0] for model in (smooth, straight))
            load = np.maximum(load, _relative(a, b, smooth.length))
            both = [model.response.solve_cases(a[None]) for model in (smooth, straight)]
            if all(reached[0] for _, _, reached in both):
                (x,), (y,) = (states for states, _, _ in both)
                motion = np.maximum(motion, _relative(x, y, 1.0 / smooth.length))
    H, M, u, rotation = 100.0 * np.concatenate([load, motion])
    return (
        f"the tables change H by at most {percent(H)} and M by {percent(M)} at the recorded motions, "
        f"u by {percent(u)} and rotation by {percent(rotation)} under the recorded loads"
    )


def _relative(a: Array, b: Array, length: float) -> Array:
    """Return |b - a|/|a| of (force, moment) or (u, rotation); a small part counts beside 5 % of the larger one."""
    scale = np.array([1.0, length])
    return np.abs(b - a) / scale / np.maximum(np.abs(a) / scale, 0.05 * np.abs(a / scale).max())


def other_planes(springs: Springs, made: Uniaxial) -> str:
    """Return a sentence on motions in other directions: loads between two planes beside those along one."""
    worst, between = 0.0, made.between
    for path in springs.paths.values():
        if path.is_vertical:
            continue
        for step in (path.n // 4, path.n // 2, path.n - 1):
            x = path.u[step], path.rotation[step]
            a, b = made.model.reactions(*x)[0], between.reactions(*x)[0]
            scale = np.array([1.0, made.model.length])
            worst = max(worst, float(np.linalg.norm((b - a) / scale) / np.linalg.norm(a / scale)))
    angle = 180.0 / made.planes
    return (
        f"springs stand in {made.planes} vertical planes, each {angle:g} degrees from the next, and act independently: "
        f"at {0.5 * angle:g} degrees from a plane the loads of a motion differ from those along it by up to "
        f"{percent(100.0 * worst)} (a quarter, half and the end of each path)"
    )


def masing(q: Array, f: Array, x: Array) -> Array:
    """Return the reactions (n,) along displacements x (n,) that start at rest (Masing 1926; Iwan 1967).

    The curve through the points q >= 0, f is a sum of sliders in parallel, each elastic up to one of its points.
    """
    slope = np.diff(f) / np.diff(q)
    stiffness, limit = slope - np.append(slope[1:], 0.0), q[1:]
    spring, out = np.zeros(limit.size), np.empty(x.size)
    for i, move in enumerate(np.diff(x, prepend=0.0)):
        spring = np.clip(spring + move, -limit, limit)
        out[i] = stiffness @ spring
    return out


def errors_on_reversals(springs: Springs, made: Uniaxial, tables: list[Table]) -> list[str]:
    """Return a sentence for each lateral path that turns back: H and M of Masing's rule beside the full model.

    Paths at another V than that of the springs, or under one that changes, count for nothing here.
    """
    lines, V = [], springs.path().load
    for path in springs.paths.values():
        if path.is_vertical or not path.turns_back or not _is_under(path, V):
            continue
        u, rotation = path.u - path.u[0], path.rotation - path.rotation[0]
        found = masing_loads(made, tables, u, rotation)
        parts = []
        for key, own in zip("HM", found, strict=True):
            exact = path[key] - path[key][0]
            parts.append(f"{key} by {100.0 * np.abs(own - exact).max() / max(np.abs(exact).max(), 1e-300):.0f} %")
        lines.append(
            f"Masing's rule on path {path.name} ({path.role}): off by {' and '.join(parts)} of the largest load"
        )
    return lines or ["the springs hold no path that turns back: the error of Masing's rule is not known for them"]


def masing_loads(made: Uniaxial, tables: list[Table], u: Array, rotation: Array) -> tuple[Array, Array]:
    """Return H [N] and M [N m] (n,) along a motion in one of the planes, from rest, by Masing's rule."""
    H, M = np.zeros_like(u), np.zeros_like(u)
    for each in tables:
        if not each.spring.odd:
            continue
        q, f = each.q[each.q >= 0.0], each.f[each.q >= 0.0]
        lateral = each.spring.direction == "lateral"
        read = u - each.spring.depth * rotation if lateral else rotation
        force = sum(n * c * masing(q, f, c * read) for c, n in zip(*uniaxial_curve.cosines(made.planes), strict=True))
        H += force if lateral else 0.0
        M += -force * each.spring.depth if lateral else force
    return H, M


def no_heave(springs: Springs) -> str:
    """Return a sentence on the w of the paths of lateral springs, which uniaxial springs do not have."""
    ways = [np.zeros(1)]
    ways += [path.w - path.w[0] for path in springs.paths.values() if path.calibrates and not path.is_vertical]
    w = 1e3 * np.concatenate(ways)
    change = f"by {w.min():.2g} to {w.max():+.2g} mm"
    return f"lateral motion does not change w: on the paths of the lateral springs it does, {change}"


FEWEST = 5
UNITS = "m, rad, N, N m; reactions are those of a spring, p times the height of its slice"
ELASTIC = "nonlinear elastic (monotonic backbone): no hysteresis, no memory; not for cyclic degradation"
NOT_ODD = "vertical spring: change of V from the state at rest; lateral springs do not depend on V"
BEHIND = (
    f"behind their range springs go on with their last slope to {FAR:g} times the range: no load that the full model "
    "has carried"
)


@dataclass(frozen=True, slots=True, eq=False)
class Prepared:
    """Header lines, tables, sentences on what is lost, and the springs behind them: uniaxial ones, and the spring set.

    angles (planes,) are those of the planes of lateral and rotational springs from x towards y [rad].
    """

    head: list[str]
    tables: list[Table]
    lost: list[str]
    made: Uniaxial
    springs: Springs
    angles: tuple[float, ...]
    torsion: float


def prepare(source: Source, given: Options, target: str, frame: str) -> Prepared:
    """Return the tables of an export for a program (``target``) and its axes (``frame``), which the header names.

    A far point stands behind each end of a table, for programs that extrapolate badly.
    """
    points = int(given["points"])
    if points < FEWEST:
        raise refused("--option points", f"{points} is not from {FEWEST} to any number")
    springs, load = springs_at(source, given)
    made = uniaxial(springs, given["springs"] or None, load, int(given["planes"]), str(given["slices"]))
    rows = tables(made, points)
    torsion, first = known_torsion(springs.attrs), float(given["azimuth"] or 0.0)
    lost = [f"springs '{made.model.spring_set}'", *made.lost, ELASTIC, NOT_ODD, no_heave(springs)]
    lost += [other_planes(springs, made), BEHIND, torsion_words(torsion, springs)]
    lost += [
        f"tables of at most {points} points: {100.0 * max(row.error for row in rows):.2g} % from the curves at most",
        change_by_tables(springs, made.model, with_tables(made, rows)),
        *errors_by_role(springs, made.model, f"error of these springs beside {springs.reference}"),
    ]
    angles = tuple(first + np.pi / made.planes * k for k in range(made.planes))
    head = [*header(source, target, frame, UNITS, at=springs), *lost]
    return Prepared(head, rows, lost, made, springs, angles, torsion or 0.0)


Terms = dict[str, float]


def read_by(spring: Spring, angle: float) -> Terms:
    """Return the displacement that a spring reads as factors of ux, uy, uz, rx, ry, rz of the lid, z up.

    angle [rad] is that of its plane from x towards y; the point at a depth moves by u + rotation x (0, 0, -depth).
    """
    c, s = float(np.cos(angle)), float(np.sin(angle))
    if spring.direction == "vertical":
        terms = {"uz": -1.0}
    elif spring.direction == "rotation":
        terms = {"ry": c, "rx": -s}
    else:
        terms = {"ux": c, "uy": s, "ry": -spring.depth * c, "rx": spring.depth * s}
    return {name: factor for name, factor in terms.items() if abs(factor) > 1e-12}
