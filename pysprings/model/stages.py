# SPDX-License-Identifier: MIT
"""Load paths of a scene -> stages of the engine (for half a caisson)."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from fe_engine.fourier_model import SectionMesh
from fe_engine.mesh import Mesh
from fe_engine.model import Stage
from pysprings.core.path_kinds import LOADS, MOTIONS, PATH_KINDS
from pysprings.core.variables import DOFS
from pysprings.model.build import extra_load as extra_load_of
from pysprings.model.water import mudline_time
from pysprings.scene.model import Scene
from pysprings.scene.sections import Path
from pysprings.scene.soils import SOIL_LAWS

# The first step is this fraction of the diameter (0.02 mm for 7.8 m): well inside first yield and first slip,
# where most points switch regime and nothing can be extrapolated yet. In a soil that yields earlier than sand it is
# this share of the strain at which the stress beside the tip changes by itself.
_FIRST_STEP, _FIRST_STRAIN = 2.5e-6, 0.01
_LARGEST_STEP = 0.05
# Steps of a rest, which grow geometrically between these fractions
_FIRST_OF_REST, _LARGEST_OF_REST = 1.0e-4, 0.2
# First and largest step of a vertical load, as fractions of its change
_FIRST_OF_LOAD, _LARGEST_OF_LOAD = 0.1, 0.25
# Viscous displacement over the diameter of paths in soil that localises, once an increment has failed: rounding decides
# where it does. It adds less than 0.1 % to loads. Vertical paths localise beside the whole skirt and need more:
# without it pull-out on `medium` takes 180 s for 2 s
_LOCALISES, _LOCALISES_ALONG_SKIRT = 3.0e-8, 1.0e-7


# A dead load has acted for so long (s) that its pore pressures are gone
_LONG_AGO = 1.0e12


def dead_load_stage(extra_load: float, dofs: Sequence[str] = DOFS) -> Stage:
    """Return the vertical load (N, of the model) beyond the one that balances the initial contact stresses; drained."""
    return Stage(
        name="dead load",
        control=np.zeros((0, len(dofs))),
        target=np.zeros(0),
        load=np.zeros((len(dofs), 0)),
        force=np.array([extra_load if dof == "w" else 0.0 for dof in dofs]),
        first_fraction=_FIRST_OF_LOAD,
        max_fraction=_LARGEST_OF_LOAD,
        duration=_LONG_AGO,
    )


def path_stages(
    scene: Scene, path: Path, extra_load: float, undrained_time: float = 0.0, rest: float = 0.0, balanced: float = 0.0
) -> list[Stage]:
    """Return the stages of a path in sequence: quantities imposed at the lid centre, their forces, their time.

    Every stage of an undrained path takes ``undrained_time`` (s), in which nothing flows. ``rest`` is the vertical
    displacement (m) under the dead load: what is imposed vertically counts from there. ``balanced`` is the vertical
    load (N, of the model) that the initial contact stresses balance: vertical loads of parts of the path count from it.
    Those of a path that leaves a plane are of the whole caisson, others of its half.
    """
    if path.in_space:
        stages = space_stages(scene, path, extra_load, balanced)
    else:
        stages = _stages(scene, path, extra_load)
        stages += _further(scene, path, stages[-1], balanced)
    if scene.drainage.mode == "undrained":
        stages = [replace(stage, duration=undrained_time) for stage in stages]
    stages = _viscous(scene, path, stages)
    w = (MOTIONS if path.in_space else DOFS).index("w")
    return [replace(stage, target=stage.target + rest * stage.control[:, w]) for stage in stages] if rest else stages


def fast_paths(scene: Scene, mesh: Mesh | SectionMesh) -> list[str]:
    """Return a sentence on coupled paths that end before water crosses the first element below mudline; none if none.

    Zero pressure at mudline drains this element however short the time, since pressures are linear in it.
    """
    if scene.drainage.mode != "coupled":
        return []
    crossing = mudline_time(scene, mesh)
    lasting = {path.name: sum(stage.duration for stage in path_stages(scene, path, 0.0)) for path in scene.all_paths}
    fast = [f"'{name}' ({time:.2g} s)" for name, time in lasting.items() if 0.0 < time < crossing]
    if not fast:
        return []
    return [
        f"{', '.join(fast)}: faster than water crosses the element below mudline ({crossing:.2g} s), which drains "
        'all the same: H and M are off by up to 1 % at small motions; drainage.mode = "undrained" is the fast limit'
    ]


def viscous_displacement(scene: Scene, path: Path) -> float | None:
    """Return the imposed motion (m) in which the soil relaxes on a path; None where it has no viscosity.

    Without one in the scene, paths in soil with friction have a small one.
    """
    given, strata = scene.solver.viscous_displacement, scene.ground.strata
    if given is not None or PATH_KINDS[path.kind].force:
        return given
    if not any(SOIL_LAWS[each.law].yields and not each.total_stress for each in strata):
        return None
    share = _LOCALISES_ALONG_SKIRT if PATH_KINDS[path.kind].drives == "w" else _LOCALISES
    return share * scene.caisson.outer_diameter


def _viscous(scene: Scene, path: Path, stages: list[Stage]) -> list[Stage]:
    """Return the stages of a path with the relaxation time of the soil; only imposed motions take time."""
    relaxing = viscous_displacement(scene, path)
    if relaxing is None:
        return stages
    viscous, start = [], np.zeros(len(stages[0].target))
    for stage in stages:
        moved = np.linalg.norm((stage.target - start) * lengths_of(scene, stage.control))
        viscous.append(replace(stage, lag=relaxing / float(moved)) if moved else stage)
        start = stage.target
    return viscous


def _stages(scene: Scene, path: Path, extra_load: float) -> list[Stage]:
    """Return the stages of the first part of a path that starts at w = 0, not yet with the time of undrained ones."""
    if PATH_KINDS[path.kind].in_turn:
        return _stages_in_turn(scene, path, extra_load)
    if path.arm_from is not None:
        return _climbing_stages(scene, path, extra_load)
    end = imposed_end(path)
    duration = _time(path.rate, path.duration, 0.0, end)
    return [_stage(scene, path, path.name, (0.0, end), path.report_at, extra_load, duration)]


def _further(scene: Scene, path: Path, before: Stage, balanced: float) -> Iterator[Stage]:
    """Yield the stages of what follows (`then`) after the last stage of the first part."""
    start, extra_load = imposed_end(path), float(before.force[1])
    for number, then in enumerate(path.then, 1):
        if then.load is not None:
            extra_load = extra_load_of(then.load, balanced)
        end = start if then.value is None else then.value
        duration = _time(then.rate, then.time, start, end)
        stage = _stage(scene, path, f"{path.name}, then {number}", (start, end), (), extra_load, duration)
        if then.value is None:  # whatever is imposed stays
            stage = replace(stage, target=before.target, force=np.array([before.force[0], extra_load, before.force[2]]))
            if then.load is not None:
                stage = replace(stage, first_fraction=_FIRST_OF_LOAD, max_fraction=_LARGEST_OF_LOAD)
        elif then.second is not None:
            stage = _with_second(scene, path, stage, before, then.second)
        yield stage
        before, start = stage, end


def _with_second(scene: Scene, path: Path, stage: Stage, before: Stage, second: float) -> Stage:
    """Return a stage that leads to a second end value, too: M [N m] under given loads, else rotation [rad]."""
    target, force, travel = stage.target, stage.force, 1.0
    if PATH_KINDS[path.kind].force:
        force = np.array([*force[:2], 0.5 * second])
    else:
        target = np.array([target[0], second, *target[2:]])
        travel = float(np.abs(target[:2] - before.target[:2]) @ [1.0, scene.caisson.skirt_length])
    small, large = _step_fractions(scene, path, travel)
    return replace(stage, target=target, force=force, first_fraction=small, max_fraction=large)


def _stages_in_turn(scene: Scene, path: Path, extra_load: float) -> list[Stage]:
    """Return a translation, then a rotation at its displacement; the tip turns at the rate of the lid."""
    u, turn, length = imposed_end(path), _need(path.rotation), scene.caisson.skirt_length
    first = _stage(scene, path, path.name, (0.0, u), path.report_at, extra_load, _time(path.rate, None, 0.0, u))
    small, large = _step_fractions(scene, path, turn * length)
    second = replace(
        first, name=f"{path.name}, then turned", target=np.array([u, turn, *first.target[2:]]), stops=(1.0,),
        duration=_time(path.rate, None, 0.0, turn * length), first_fraction=small, max_fraction=large,
    )  # fmt: skip
    return [first, second]


def _climbing_stages(scene: Scene, path: Path, extra_load: float) -> list[Stage]:
    """Return a load that grows at its first height, and then climbs to its last one: M grows under constant H and V."""
    grows = path.model_copy(update={"arm": path.arm_from, "arm_from": None})
    (first,) = _stages(scene, grows, extra_load)
    moment = 0.5 * imposed_end(path) * (path.arm - _need(path.arm_from))
    force = first.force + np.array([0.0, 0.0, moment])
    second = replace(first, name=f"{path.name}, then climbing", force=force, stops=(1.0,))
    return [first, second]


def _stage(
    scene: Scene, path: Path, name: str, ends: tuple[float, float],
    report_at: tuple[float, ...], extra_load: float, duration: float,
) -> Stage:  # fmt: skip
    """Return one stage, which leads the imposed quantity of the path from the first to the second of its ``ends``."""
    rows, patterns = _imposed(scene, path)
    targets = _targets(path, ends[1])
    force = np.array([0.0, extra_load, 0.0])
    if PATH_KINDS[path.kind].force:
        force += 0.5 * ends[1] * np.array([1.0, 0.0, path.arm])
    if path.heave == "fixed":
        rows.append([0.0, 1.0, 0.0])
        targets.append(0.0)
        patterns.append([0.0, 1.0, 0.0])
    first, largest = _step_fractions(scene, path, ends[1] - ends[0])
    return Stage(
        name=name,
        control=np.array(rows).reshape(-1, 3),
        target=np.array(targets),
        load=np.array(patterns).reshape(-1, 3).T,
        force=force,
        stops=tuple(sorted({abs(value / ends[1]) for value in report_at} | {1.0})),
        first_fraction=first,
        max_fraction=largest,
        duration=duration,
    )


def _time(rate: float | None, time: float | None, start: float, end: float) -> float:
    """Return the time (s) of a part of a path; 0 if none is imposed (drained)."""
    if time is not None:
        return time
    return 0.0 if rate is None else abs(end - start) / rate


def imposed_end(path: Path) -> float:
    """Return the end value of the imposed quantity: displacement (m), rotation (rad) or lateral force (N)."""
    return _need(getattr(path, PATH_KINDS[path.kind].imposed))


def _imposed(scene: Scene, path: Path) -> tuple[list, list]:
    """Return the rows of the control and the force patterns that impose them, in (u, w, rotation)."""
    kind = PATH_KINDS[path.kind]
    if kind.conjugate:
        angle = _need(path.load_angle)
        along = [math.cos(angle), 0.0, scene.caisson.outer_diameter * math.sin(angle)]
        return [along], [list(along)]
    rows = [np.eye(3)[DOFS.index(dof)].tolist() for dof in kind.holds]
    return rows, [[1.0, 0.0, path.arm]] if kind.free_head and rows else [list(row) for row in rows]


def _targets(path: Path, end: float) -> list[float]:
    """Return the end values of what `_imposed` controls, when the imposed quantity of the path is at ``end``."""
    kind = PATH_KINDS[path.kind]
    targets = {dof: end if dof == kind.drives else 0.0 for dof in kind.holds}
    if kind.straight and kind.drives == "u":
        targets["rotation"] = (path.rotation or 0.0) * end / imposed_end(path)
    return list(targets.values())


def _step_fractions(scene: Scene, path: Path, travel: float) -> tuple[float, float]:
    """Return the first and largest step as fractions of a stage that moves on by ``travel``, at lid or tip."""
    if travel == 0.0:  # a rest: water moves fast at first, and ever more slowly
        return _FIRST_OF_REST, _LARGEST_OF_REST
    kind = PATH_KINDS[path.kind]
    turned = abs(path.rotation / imposed_end(path)) if kind.straight and path.rotation else 0.0
    scale = max(float(kind.drives != "rotation"), turned * scene.caisson.skirt_length)
    return _fractions(scene, 0.0 if kind.force else abs(travel) * scale)


def _fractions(scene: Scene, reach: float) -> tuple[float, float]:
    """Return the first and largest step as fractions of a stage that displaces by ``reach`` (m); 0: not known."""
    first = scene.solver.first_step_fraction
    if first is None:
        first = min(1.0, _first_strain(scene) * scene.caisson.outer_diameter / reach) if reach else 0.01
    return first, max(first, scene.solver.max_step_fraction or _LARGEST_STEP)


def _first_strain(scene: Scene) -> float:
    """Return the first step over the diameter, reduced for soil that would yield at once (stiff at low stress).

    Soil without stress and strength gives no measure.
    """
    ground, depth = scene.ground, np.array(scene.caisson.skirt_length)
    strength = float(ground.strength(depth))
    stress = strength if bool(ground.in_total_stress(depth)) else float(ground.vertical_stress(depth)) + strength
    reduced = _FIRST_STRAIN * stress / float(ground.value("young_modulus", depth))
    return min(_FIRST_STEP, reduced) if reduced > 0.0 else _FIRST_STEP


def _need(value: float | None) -> float:
    """Return a value that the checks of the scene guarantee."""
    assert value is not None
    return value


# --- how far small strains and rotations reach: motions beyond it are computed, and named ---

# Geometry and contact faces stay where they were: a motion of this share of the skirt length, or a rotation of as many
# radians (which moves the tip as far), is beyond what that describes.
LARGEST_SHARE = 0.1
LARGEST_ROTATION = 0.1


def large_motion(path: str, displacement: float, rotation: float, length: float) -> str:
    """Return a sentence where a displacement (m) or rotation (rad) of a path is large beside the skirt; else ""."""
    parts = []
    if abs(displacement) > LARGEST_SHARE * length:
        share = abs(displacement) / length
        parts.append(f"a displacement of {abs(displacement):.3g} m, {share:.0%} of the skirt length")
    if abs(rotation) > LARGEST_ROTATION:
        parts.append(f"a rotation of {abs(rotation):.3g} rad")
    if not parts:
        return ""
    limit = f"limit {LARGEST_SHARE:.0%} of the skirt length, {LARGEST_ROTATION:g} rad"
    return f"path '{path}': {' and '.join(parts)} is beyond small strains ({limit}): the answer is a guess there"


def scene_warnings(scene: Scene) -> list[str]:
    """Return a sentence for each path of a scene that imposes a large motion."""
    radius, length = 0.5 * scene.caisson.outer_diameter, scene.caisson.skirt_length
    texts = (large_motion(path.name, *imposed_motion(path, radius), length) for path in scene.all_paths)
    return [text for text in texts if text]


def imposed_motion(path: Path, radius: float = 0.0) -> tuple[float, float]:
    """Return the largest displacement (m) and rotation (rad) that a path imposes; 0 where it imposes a force.

    A twist displaces the wall at the ``radius`` (m).
    """
    kind = PATH_KINDS[path.kind]
    if path.in_space:
        return space_motion(path, radius)
    if kind.force:
        return 0.0, 0.0
    first = abs(getattr(path, kind.imposed) or 0.0)
    largest = max([first, *(abs(then.value) for then in path.then if then.value is not None)])
    if kind.drives == "rotation":
        return 0.0, largest
    turn = max([abs(path.rotation or 0.0), *(abs(then.second) for then in path.then if then.second is not None)])
    return largest, turn * (largest / first if kind.straight and first else 1.0)


# --- paths that leave the plane of one load, in the order of `path_kinds.MOTIONS`: w down, rotations right-handed ---

# A circle is a polygon with so many sides: its radius is 0.1 % less in their middles
CHORDS = 72
_W = MOTIONS.index("w")
_HELD = ("u_x", "u_y", "rot_x", "rot_y", "rot_z")


def space_points(path: Path) -> tuple[tuple[str, ...], np.ndarray]:
    """Return the motions that a path imposes, and their values (n, nc) [m, rad] at the ends of its parts.

    Under given loads there are none (n = 1); a probe imposes one of no name, that of `_along_load`.
    """
    if path.given(LOADS):
        return (), np.zeros((1, 0))
    if path.kind == "probe":
        return ("",), np.array([[path.lateral_displacement]])
    if path.kind == "twist":
        return ("rot_z",), np.array([[path.twist], *([each.value] for each in path.then)])
    if path.kind == "motion":
        ends = path.given(MOTIONS)
        return _HELD, np.array([[ends.get(name, 0.0) for name in _HELD]])
    angle = path.direction or 0.0
    first = (path.radius if path.kind == "circle" else path.lateral_displacement) or 0.0
    at = [first * np.array([math.cos(angle), math.sin(angle)])]
    for then in path.then:
        at.append(
            at[-1] + (then.value or 0.0) * np.array([math.cos(then.towards or 0.0), math.sin(then.towards or 0.0)])
        )
    if path.kind == "circle":
        turned = angle + 2.0 * np.pi * np.arange(1, CHORDS + 1) / CHORDS
        at += list(first * np.stack([np.cos(turned), np.sin(turned)], axis=1))
    if path.kind == "pull":
        return _HELD[:2], np.array(at)
    return _HELD, np.hstack([np.array(at), np.zeros((len(at), 3))])


def space_stages(scene: Scene, path: Path, dead: float, balanced: float) -> list[Stage]:
    """Return the stages of a path that starts at w = 0, one after the other.

    dead, balanced : vertical load (N) beyond the one that balances the initial contact stresses, and that one.
    """
    held, points = space_points(path)
    rows = [np.eye(6)[MOTIONS.index(name)] if name else _along_load(scene, path) for name in held]
    patterns = [row.copy() for row in rows]
    if path.kind == "pull":  # H at the height of the arm: M_y = H_x h, M_x = -H_y h
        patterns[0][MOTIONS.index("rot_y")], patterns[1][MOTIONS.index("rot_x")] = path.arm, -path.arm
    force = np.zeros(6)
    force[_W] = dead
    for name, value in path.given(LOADS).items():
        force[LOADS.index(name)] = value - (balanced if name == "V" else 0.0)
    if path.heave == "fixed":
        rows, patterns = [*rows, np.eye(6)[_W]], [*patterns, np.eye(6)[_W]]
        points = np.hstack([points, np.zeros((len(points), 1))])
    control, load = np.array(rows).reshape(-1, 6), np.array(patterns).reshape(-1, 6).T
    lengths, stages, before = lengths_of(scene, control), [], np.zeros(points.shape[1])
    for number, (point, time) in enumerate(zip(points, _times(path, len(points)), strict=True)):
        name = path.name if number == 0 else f"{path.name}, then {number}"
        stage = Stage(name, control, point, load, force, duration=time)
        if path.kind == "circle" and number:  # a side
            stage = replace(stage, first_fraction=0.5, max_fraction=1.0, continues=number > 1)
        else:
            small, large = _fractions(scene, float(np.linalg.norm((point - before) * lengths)))
            stage = replace(stage, first_fraction=small, max_fraction=large)
        stages.append(stage)
        before = point
    stops = {abs(value / points[0, 0]) for value in path.report_at} | {1.0}
    return [replace(stages[0], stops=tuple(sorted(stops))), *stages[1:]]


def _along_load(scene: Scene, path: Path) -> np.ndarray:
    """Return the load (6,) of a probe over R: H = R cos(b) cos(a), M = R D cos(b) sin(a), T = R D sin(b), z up.

    a is `load_angle`, b `torsion_angle`; H acts in `direction`, and M bends in its plane.
    """
    a, b, plan = _need(path.load_angle), _need(path.torsion_angle), path.direction or 0.0
    along, diameter = np.array([math.cos(plan), math.sin(plan)]), scene.caisson.outer_diameter
    force, moment = math.cos(b) * math.cos(a) * along, diameter * math.cos(b) * math.sin(a) * along
    return np.array([*force, 0.0, -moment[1], moment[0], diameter * math.sin(b)])


def _times(path: Path, parts: int) -> list[float]:
    """Return the time (s) of each part of a path, 0 where none is given; a circle goes at one velocity."""
    if path.kind == "circle":
        side = 2.0 * math.sin(math.pi / CHORDS)  # over the radius
        pace = (path.duration or 0.0) / (1.0 + (parts - 1) * side)
        return [pace, *[pace * side] * (parts - 1)]
    return [path.duration or 0.0, *(then.time or 0.0 for then in path.then)]


def lengths_of(scene: Scene, control: np.ndarray) -> np.ndarray:
    """Return the lengths (nc,) that turn what rows of a control (nc, nb) impose into displacements of lid, tip or wall.

    They are 1 of displacements; skirt length of rotations; radius (m) of a twist.
    """
    length, radius = scene.caisson.skirt_length, 0.5 * scene.caisson.outer_diameter
    shifts, sizes = {3: (2, [1.0, 1.0, length]), 6: (3, [1.0, 1.0, 1.0, length, length, radius])}[control.shape[1]]
    return np.where((control[:, :shifts] == 0.0).all(axis=1), control @ sizes, 1.0)


def space_motion(path: Path, radius: float) -> tuple[float, float]:
    """Return the largest displacement (m) and rotation (rad) that a path imposes; a twist at the wall (radius, m)."""
    held, points = space_points(path)
    if not held or PATH_KINDS[path.kind].force:
        return 0.0, 0.0
    sizes = dict.fromkeys(_HELD, np.zeros(1)) | {name: np.abs(points[:, k]) for k, name in enumerate(held)}
    moved, turned = (np.hypot(sizes[x], sizes[y]).max() for x, y in (("u_x", "u_y"), ("rot_x", "rot_y")))
    return float(max(moved, radius * sizes["rot_z"].max())), float(turned)
