# SPDX-License-Identifier: MIT
"""Values of a scene that are right one by one but not together."""

import math
from collections.abc import Iterator

from pysprings.core.loads import same_load
from pysprings.core.path_kinds import CALIBRATION, LOADS, MEMORY, MOTIONS, PATH_KINDS, UNITS
from pysprings.core.units import quoted, show
from pysprings.scene import layers
from pysprings.scene.design_load import design_clashes
from pysprings.scene.fan import space_paths
from pysprings.scene.interface import drainage_clashes, interface_clashes
from pysprings.scene.positions import Clash, KeyPath
from pysprings.scene.scene_sections import SceneSections
from pysprings.scene.sections import Caisson, Extent, Path, Soil, Solver, Springs
from pysprings.scene.soils import SOIL_LAWS

MIN_RADIUS_RATIO = 1.02  # domain radius over caisson radius: room for a graded mesh around the skirt
_MAY_BE_ZERO = ("arm_from", "load_angle")  # None where not given
MIN_DEPTH_RATIO = 1.02  # domain depth over skirt length: room for a graded mesh below the tip
_REACH = ("springs", "reach")
MOST_REACH = 0.5  # of the fan, over the skirt length: rad of its rotation
_MOST_VISCOUS = 1.0e-5  # viscous displacement over outer diameter


def clashes(scene: SceneSections) -> Iterator[Clash]:
    """Give everything that does not go together in a scene whose single values are valid."""
    yield from _caisson(scene.caisson)
    extent = scene.extent
    yield from _domain(extent, scene.caisson)
    lacking = [*layers.missing(scene.soil, scene.drainage.mode)]
    yield from _ground(scene.soil, extent, lacking)
    if lacking:
        scene = scene.model_copy(update={"soil": layers.with_stand_ins(scene.soil)})
    yield from drainage_clashes(scene)
    if not [*layers.layer_order(scene.soil, extent)]:
        yield from interface_clashes(scene)
    yield from _series(scene)
    yield from _solver(scene.solver)
    yield from _viscous(scene.solver, scene.caisson)
    if scene.drainage.mode == "coupled" and scene.springs.reach is not None and not scene.springs.rates:
        yield Clash((("springs", "rates"), _REACH), 'drainage.mode = "coupled" needs them, such as ["0.05 mm/s"]')
    of_fan = [*_far(scene.springs, scene.caisson), *_twice(scene.springs, scene.caisson)]
    yield from of_fan or _load_paths(scene)
    yield from space_clashes(scene)
    yield from _changing_loads(scene)
    yield from design_clashes(scene.design)


def dotted(path: KeyPath) -> str:
    """Return a key path as people write it: `path[0].arm`, quoted where a name is not plain."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            plain = part.replace("_", "").replace("-", "").isalnum() and part.isascii() and len(part) <= 60
            text += ("." if text else "") + (part if plain else quoted(part))
    return text


def _caisson(caisson: Caisson) -> Iterator[Clash]:
    if caisson.skirt_thickness >= 0.5 * caisson.outer_diameter:
        keys = ("caisson", "skirt_thickness"), ("caisson", "outer_diameter")
        yield Clash(keys, f"must be less than half of outer_diameter ({show(caisson.outer_diameter, 'm')})")


def _domain(domain: Extent, caisson: Caisson) -> Iterator[Clash]:
    radius = 0.5 * caisson.outer_diameter
    if domain.radius <= MIN_RADIUS_RATIO * radius:
        keys = ("domain", "radius"), ("caisson", "outer_diameter")
        limit = f"{MIN_RADIUS_RATIO:g} times the caisson's radius ({show(radius, 'm')})"
        yield Clash(keys, f"{show(domain.radius, 'm')} must be more than {limit}")
    if domain.depth <= MIN_DEPTH_RATIO * caisson.skirt_length:
        keys = ("domain", "depth"), ("caisson", "skirt_length")
        limit = f"{MIN_DEPTH_RATIO:g} times caisson.skirt_length ({show(caisson.skirt_length, 'm')})"
        yield Clash(keys, f"{show(domain.depth, 'm')} must be more than {limit}")


def _series(scene: SceneSections) -> Iterator[Clash]:
    """Check what a Fourier series can carry."""
    mesh, chosen = scene.mesh, ("mesh", "discretisation")
    if scene.discretisation == "hex8":
        for key in ("harmonics", "halvings"):
            if getattr(mesh, key):
                yield Clash((("mesh", key), chosen), 'are those of discretisation = "fourier"')
        return
    if mesh.azimuth is not None:
        yield Clash((("mesh", "azimuth"), chosen), "counts bricks; a series has mesh.harmonics")
    if scene.drainage.stabilisation != 1.0:
        yield Clash((("drainage", "stabilisation"), chosen), "is one of bricks; pressures of a series need none")


def _ground(soil: Soil, domain: Extent, lacking: list[Clash]) -> Iterator[Clash]:
    """Check keys, order and values by depth of the layers; where they are right, the soil of each.

    ``lacking`` names the values that are missing: others stand in for them where the rest is checked.
    """
    checked = layers.with_stand_ins(soil) if lacking else soil
    wrong = [
        *layers.key_clashes(soil),
        *lacking,
        *layers.layer_order(soil, domain),
        *layers.values_inside(checked, domain),
    ]
    wrong += [] if wrong else [*layers.open_ends(soil, domain)]
    yield from wrong
    if wrong:
        return
    seen = set()
    for uniform, vertical, number in layers.uniform_soils(soil, domain):
        for clash in SOIL_LAWS[uniform.yield_surface].faults(uniform, vertical):
            named = layers.in_layer(clash, soil, number)
            if (number, named.keys) not in seen:  # one of the two ends of a layer is enough
                seen.add((number, named.keys))
                yield named


def _solver(solver: Solver) -> Iterator[Clash]:
    first, largest = solver.first_step_fraction, solver.max_step_fraction
    if first is not None and largest is not None and first > largest:
        keys = ("solver", "first_step_fraction"), ("solver", "max_step_fraction")
        yield Clash(keys, f"{first:g} must not be more than max_step_fraction ({largest:g})")


def _viscous(solver: Solver, caisson: Caisson) -> Iterator[Clash]:
    """Refuse a relaxation whose overstress is a part of the answer: several per cent of the load at this bound."""
    most = _MOST_VISCOUS * caisson.outer_diameter
    if solver.viscous_displacement is not None and solver.viscous_displacement > most:
        keys = ("solver", "viscous_displacement"), ("caisson", "outer_diameter")
        bound = f"{_MOST_VISCOUS:g} of outer_diameter ({show(most, 'mm')})"
        text = f"{show(solver.viscous_displacement, 'mm')} is more than {bound}: the overstress would carry load"
        yield Clash(keys, text)


def _paths(paths: tuple[Path, ...]) -> Iterator[Clash]:
    seen: dict[str, int] = {}
    for index, path in enumerate(paths):
        first = seen.setdefault(path.name.lower(), index)
        if first != index:
            keys = ("path", index, "name"), ("path", first, "name")
            yield Clash(keys, f"'{path.name}' is the name of path[{first}] too (case does not count)")
        yield from _path(index, path)


def _path(index: int, path: Path) -> Iterator[Clash]:
    here: KeyPath = ("path", index)
    if path.in_space:
        yield from space_path(here, path)
        if path.kind == "twist" and path.twist:
            yield from _stops(here, "twist", path.twist, path.report_at)
        return
    kind = PATH_KINDS[path.kind]
    imposed = kind.imposed
    for name in (*UNITS, "arm", "arm_from", "load_angle", "rate"):
        value = getattr(path, name)
        given = value is not None if name in _MAY_BE_ZERO else value
        if given and name != imposed and name not in kind.uses:
            yield Clash(((*here, name), (*here, "kind")), f'a path of kind "{path.kind}" does not use it')
    if kind.drives == "w" and path.direction is not None:
        yield Clash(((*here, "direction"), (*here, "kind")), f'a path of kind "{path.kind}" does not use it')
    if kind.drives == "w" and path.heave == "fixed":
        yield Clash(((*here, "heave"), (*here, "kind")), f'a path of kind "{path.kind}" moves the caisson up or down')
    if path.rate is not None and path.duration is not None:
        yield Clash(((*here, "duration"), (*here, "rate")), "give rate or duration, not both")
    yield from _role(here, path)
    yield from _vertical_loads(here, path)
    if kind.bends:
        yield from _bent(here, path)
    if path.arm_from is not None and path.role == "calibration":
        text = 'springs are made from paths of one direction only: a load that climbs needs role = "held-back"'
        yield Clash(((*here, "role"), (*here, "arm_from")), text)
    target = getattr(path, imposed)
    if target is None:
        yield Clash((here, (*here, "kind"), (*here, imposed)), f'a path of kind "{path.kind}" needs {imposed}')
    elif target == 0.0:
        yield Clash(((*here, imposed), (*here, "kind")), "must not be zero")
    else:
        yield from _stops(here, imposed, target, path.report_at)


def _role(here: KeyPath, path: Path) -> Iterator[Clash]:
    """Check that springs are made from monotonic paths, and their memory from straight ones that turn back."""
    keys = (*here, "then"), (*here, "role")
    if path.then and path.role == CALIBRATION:
        text = 'springs are made from monotonic paths only: a path with `then` needs role = "held-back"'
        yield Clash(keys, text)
    elif path.role == MEMORY and not (PATH_KINDS[path.kind].straight and path.then):
        text = 'role = "memory" is for a translation or rotation that turns back: then = ["-8 mm", "8 mm"]'
        yield Clash((keys[1], keys[0], (*here, "kind")), text)


def _vertical_loads(here: KeyPath, path: Path) -> Iterator[Clash]:
    """Check that the vertical load is given on a path that changes it."""
    for entry, then in enumerate(path.then):
        where = (*here, "then", entry), (*here, "then")
        if then.load is None:
            continue
        if PATH_KINDS[path.kind].drives == "w":
            text = f'a path of kind "{path.kind}" imposes w: it cannot have a vertical load'
            yield Clash((*where, (*here, "kind")), text)
        elif path.heave == "fixed":
            yield Clash((*where, (*here, "heave")), 'heave = "fixed" imposes w: it cannot have a vertical load')


def _changing_loads(scene: SceneSections) -> Iterator[Clash]:
    """Check that a path of the memory on which V changes has springs under several vertical loads beside it."""
    for index, path in enumerate(scene.paths):
        changes = [entry for entry, then in enumerate(path.then) if then.load is not None]
        if path.role == MEMORY and changes and (scene.springs.rates or not scene.springs.vertical_loads):
            here: KeyPath = ("path", index)
            text = (
                'a path of role = "memory" that changes the vertical load needs [springs] vertical_loads, without '
                'rates; else give it role = "held-back"'
            )
            yield Clash(((*here, "then", changes[0]), (*here, "then"), (*here, "role")), text)


def _load_paths(scene: SceneSections) -> Iterator[Clash]:
    """Check the paths; what is wrong with one of the fan is wrong with its reach."""
    own, coupled = len(scene.paths), scene.drainage.mode == "coupled"
    plane, turning = scene.load_paths, space_paths(scene.springs, scene.caisson)
    of_fan = (*plane[sum(not path.in_space for path in scene.paths) :], *turning)
    for clash in (*_paths((*scene.paths, *of_fan)), *(_times(scene.paths) if coupled else ())):
        keys = (key if key[0] != "path" or int(key[1]) < own else _REACH for key in clash.keys)
        yield Clash(tuple(dict.fromkeys(keys)), clash.message)


def _far(springs: Springs, caisson: Caisson) -> Iterator[Clash]:
    """Refuse a reach whose rotation no path may have."""
    if springs.reach is not None and springs.reach > (most := MOST_REACH * caisson.skirt_length):
        text = f"{show(springs.reach, 'mm')} must be at most half of skirt_length ({show(most, 'mm')})"
        yield Clash((_REACH, ("caisson", "skirt_length")), text)


def _twice(springs: Springs, caisson: Caisson) -> Iterator[Clash]:
    """Refuse a ray, a rate or a vertical load that the fan has already: its paths would run twice."""
    rest = () if isinstance(caisson.vertical_load, str) else (caisson.vertical_load,)
    lists = (("rays", "deg", math.isclose, ()), ("rates", "mm/s", math.isclose, ()),
             ("vertical_loads", "MN", same_load, rest))  # fmt: skip
    for name, unit, same, before in lists:
        values = *before, *getattr(springs, name)
        for k, value in enumerate(values):
            if any(same(value, other) for other in values[:k]):
                keys = ("springs", name, k - len(before)), ("springs", name)
                of = " (that of [caisson] counts)" if before else ""
                yield Clash(keys, f"{show(value, unit)} is given twice{of}: its paths would run twice")


def _times(paths: tuple[Path, ...]) -> Iterator[Clash]:
    """Check that every part of every path has its time."""
    for index, path in enumerate(paths):
        here: KeyPath = ("path", index)
        mode = ("drainage", "mode")
        if path.rate is None and path.duration is None:
            allowed = "duration" if path.in_space else " or ".join(PATH_KINDS[path.kind].paces)
            yield Clash((here, (*here, "kind"), mode), f'drainage.mode = "coupled" needs {allowed} here')
        for entry, then in enumerate(path.then):
            if then.rate is None and then.time is None:
                paces = '"... in 10 min" or "... at 0.05 mm/s"' if then.load is None else '"V ... in 10 min"'
                text = f'drainage.mode = "coupled" needs a time: {paces}'
                yield Clash(((*here, "then", entry), (*here, "then"), mode), text)


def _bent(here: KeyPath, path: Path) -> Iterator[Clash]:
    """Check what a path on which H and M change their ratio needs beside what it imposes."""
    where, kind = (*here, "kind"), PATH_KINDS[path.kind]
    for name in kind.needs:
        if getattr(path, name) is None or (name not in _MAY_BE_ZERO and not getattr(path, name)):
            yield Clash(((*here, name), where), f'a path of kind "{path.kind}" needs a {name}')
    if path.role == "calibration":
        text = f'springs are made from paths of one direction only: a {path.kind} needs role = "held-back"'
        yield Clash(((*here, "role"), where), text)
    for name in ("duration",) if kind.pairs else ("then", "duration"):
        if getattr(path, name):
            yield Clash(((*here, name), where), f'a path of kind "{path.kind}" does not use it')


def _stops(here: KeyPath, imposed: str, target: float, stops: tuple[float, ...]) -> Iterator[Clash]:
    """Check that the values where a step must land lead from 0 to the target."""
    previous, unit = 0.0, UNITS[imposed]
    for entry, stop in enumerate(stops):
        keys = (*here, "report_at", entry), (*here, imposed), (*here, "kind"), (*here, "report_at")
        if not 0.0 < stop / target <= 1.0:
            yield Clash(keys, f"{show(stop, unit)} is not on the way from 0 to {imposed} ({show(target, unit)})")
        elif abs(stop) <= abs(previous):
            yield Clash(keys, f"{show(stop, unit)} must be further than the value before it ({show(previous, unit)})")
        previous = stop


# --- paths that leave the plane of one load: which keys they use, and where they cannot be computed ---

TURNS = tuple(name for name in MOTIONS if name != "w")  # motions of a path of kind "motion": w is free, or held
_USES = {
    "twist": ("twist", "report_at", "then"),
    "circle": ("radius", "direction"),
    "motion": TURNS,
    "load": LOADS,
    "pull": ("lateral_displacement", "arm", "direction", "then"),
    "translation": ("lateral_displacement", "direction", "then"),
    "probe": ("lateral_displacement", "load_angle", "torsion_angle", "direction"),
}
_ANGLES = ("load_angle", "torsion_angle", "direction")
_KEYS = (*UNITS, "arm", "arm_from", *_ANGLES, "rate", "report_at", "then", *TURNS, *LOADS)


def space_clashes(scene: SceneSections) -> Iterator[Clash]:
    """Check that the model of a scene carries its paths that leave a plane."""
    for index, path in enumerate(scene.paths):
        if path.in_space:
            here: KeyPath = ("path", index)
            for key, text in off_plane_refusals(scene, whole=True):
                yield Clash((here, key), f"path '{path.name}' leaves the plane of one load: {text}")
    if scene.springs.reach is not None and scene.springs.directions:
        if not scene.springs.memory:
            keys = ("springs", "directions"), ("springs", "memory")
            yield Clash(keys, "springs with memory alone answer in all directions: memory = true is needed, too")
        for key, text in off_plane_refusals(scene):
            yield Clash((("springs", "directions"), key), f"its paths leave the plane of one load: {text}")


def off_plane_refusals(scene: SceneSections, whole: bool = False) -> Iterator[tuple[KeyPath, str]]:
    """Yield what of a scene's model carries no path that leaves the plane of one load: key, and why.

    ``whole``: whether pore water and an elastic caisson may take part, which springs in space were not tried with.
    """
    if scene.discretisation != "fourier":
        yield ("mesh", "discretisation"), 'bricks have half of a caisson; it needs mesh.discretisation = "fourier"'
    if not whole and scene.drainage.mode != "drained":
        yield ("drainage", "mode"), 'it needs drainage.mode = "drained" (undrained clay: law "tresca" or "von-mises")'
    if not whole and scene.caisson.behaviour != "rigid":
        yield ("caisson", "behaviour"), 'it needs caisson.behaviour = "rigid"'
    if scene.output.paraview:
        yield ("output", "paraview"), "output.paraview writes the half of a caisson"


def space_path(here: KeyPath, path: Path) -> Iterator[Clash]:
    """Check one path that leaves a plane."""
    kind, where = path.kind, (*here, "kind")
    uses = _USES.get(kind, ())
    for name in _KEYS:
        value = getattr(path, name)
        if name not in uses and value not in (None, ()) and (value or name != "arm"):
            yield Clash(((*here, name), where), f'a path of kind "{kind}" that leaves a plane does not use it')
    if not uses:
        return
    if path.role == CALIBRATION:
        text = 'fans are made from paths in one plane: this path needs role = "memory" or "held-back"'
        yield Clash(((*here, "role"), where), text)
    ends = [getattr(path, name) for name in uses if name not in ("report_at", "then", "arm", *_ANGLES)]
    if not any(ends):
        named = uses[0] if len(ends) == 1 else f"one of {', '.join(uses)} other than zero"
        yield Clash((here, where), f'a path of kind "{kind}" needs {named}')
    for name in PATH_KINDS[kind].needs:
        if getattr(path, name) is None:
            yield Clash((here, where), f'a path of kind "{kind}" needs a {name}')
    if path.heave == "fixed" and path.V is not None:
        yield Clash(((*here, "V"), (*here, "heave")), 'heave = "fixed" imposes w: it cannot have a vertical load')
    for entry, then in enumerate(path.then):
        if then.value is None or (kind != "twist" and then.towards is None):
            form = "20 mrad" if kind == "twist" else "12 mm towards 90 deg"
            text = f'a path that leaves a plane goes on with "{form}" alone'
            yield Clash(((*here, "then", entry), (*here, "then")), text)
