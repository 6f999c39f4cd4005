# SPDX-License-Identifier: MIT
"""Values of a scene that are right one by one but not together."""

from __future__ import annotations

from collections.abc import Iterator

from pysprings.core.path_kinds import PATH_KINDS, UNITS
from pysprings.core.units import show
from pysprings.scene.clash import Clash
from pysprings.scene.interface import drainage_clashes, interface_clashes
from pysprings.scene.law_keys import key_clashes
from pysprings.scene.layers import in_layer, layer_order, uniform_soils, values_inside
from pysprings.scene.positions import KeyPath
from pysprings.scene.sections import Caisson, Domain, Path, SceneSections, Soil, Solver
from pysprings.scene.soil_laws import SOIL_LAWS

MIN_RADIUS_RATIO = 1.02  # domain radius over caisson radius: room for a graded mesh around the skirt
MIN_DEPTH_RATIO = 1.02  # domain depth over skirt length: room for a graded mesh below the tip


def clashes(scene: SceneSections) -> Iterator[Clash]:
    """Give everything that does not go together in a scene whose single values are valid."""
    yield from _caisson(scene.caisson)
    yield from _domain(scene.domain, scene.caisson)
    yield from _ground(scene.soil, scene.domain)
    yield from drainage_clashes(scene)
    if not [*layer_order(scene.soil, scene.domain)]:
        yield from interface_clashes(scene)
    yield from _series(scene)
    yield from _solver(scene.solver)
    yield from _paths(scene.paths)
    if scene.drainage.mode == "coupled":
        yield from _times(scene.paths)


def dotted(path: KeyPath) -> str:
    """Return a key path as people write it: `path[0].arm`, quoted where a name is not plain."""
    from pysprings.core.units import quoted

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


def _domain(domain: Domain, caisson: Caisson) -> Iterator[Clash]:
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
    if mesh.discretisation == "hex8":
        if mesh.harmonics is not None:
            yield Clash((("mesh", "harmonics"), chosen), 'are those of discretisation = "fourier"')
        return
    if mesh.azimuth is not None:
        yield Clash((("mesh", "azimuth"), chosen), "counts bricks; a series has mesh.harmonics")
    if scene.caisson.behaviour != "rigid":
        yield Clash((("caisson", "behaviour"), chosen), 'must be "rigid" with discretisation = "fourier"')
    if scene.drainage.stabilisation != 1.0:
        yield Clash((("drainage", "stabilisation"), chosen), "is one of bricks; pressures of a series need none")


def _ground(soil: Soil, domain: Domain) -> Iterator[Clash]:
    """Check keys and order of the layers; where they are right, the values of each."""
    wrong = [*key_clashes(soil), *([*layer_order(soil, domain)] or values_inside(soil, domain))]
    yield from wrong
    if wrong:
        return
    seen = set()
    for uniform, vertical, number in uniform_soils(soil, domain):
        law = SOIL_LAWS[uniform.yield_surface]
        for clash in (*law.clashes(uniform), *law.initial(uniform, vertical)):
            named = in_layer(clash, soil, number)
            if (number, named.keys) not in seen:  # one of the two ends of a layer is enough
                seen.add((number, named.keys))
                yield named


def _solver(solver: Solver) -> Iterator[Clash]:
    first, largest = solver.first_step_fraction, solver.max_step_fraction
    if first is not None and largest is not None and first > largest:
        keys = ("solver", "first_step_fraction"), ("solver", "max_step_fraction")
        yield Clash(keys, f"{first:g} must not be more than max_step_fraction ({largest:g})")


def _paths(paths: tuple[Path, ...]) -> Iterator[Clash]:
    if not paths:
        yield Clash((("path",),), "at least one [[path]] is needed: it defines how the caisson is moved")
    seen: dict[str, int] = {}
    for index, path in enumerate(paths):
        first = seen.setdefault(path.name.lower(), index)
        if first != index:
            keys = ("path", index, "name"), ("path", first, "name")
            yield Clash(keys, f"'{path.name}' is the name of path[{first}] too (case does not count)")
        yield from _path(index, path)


def _path(index: int, path: Path) -> Iterator[Clash]:
    here: KeyPath = ("path", index)
    kind = PATH_KINDS[path.kind]
    imposed = kind.imposed
    for name in (*UNITS, "arm", "arm_from", "rate"):
        given = path.arm_from is not None if name == "arm_from" else getattr(path, name)
        if given and name != imposed and name not in kind.uses:
            yield Clash(((*here, name), (*here, "kind")), f'a path of kind "{path.kind}" does not use it')
    if kind.drives == "w" and path.heave == "fixed":
        yield Clash(((*here, "heave"), (*here, "kind")), f'a path of kind "{path.kind}" moves the caisson up or down')
    if path.rate is not None and path.duration is not None:
        yield Clash(((*here, "duration"), (*here, "rate")), "give rate or duration, not both")
    if path.then and path.role == "calibration":
        text = 'springs are made from monotonic paths only: a path with `then` needs role = "held-back"'
        yield Clash(((*here, "then"), (*here, "role")), text)
    if kind.bends:
        yield from _bent(here, path)
    if path.arm_from is not None and path.then:
        yield Clash(((*here, "then"), (*here, "arm_from")), "a load that climbs (arm_from) has nothing after it")
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


def _times(paths: tuple[Path, ...]) -> Iterator[Clash]:
    """Check that every part of every path has its time."""
    for index, path in enumerate(paths):
        here: KeyPath = ("path", index)
        mode = ("drainage", "mode")
        if path.rate is None and path.duration is None:
            allowed = " or ".join(PATH_KINDS[path.kind].paces)
            yield Clash((here, (*here, "kind"), mode), f'drainage.mode = "coupled" needs {allowed} here')
        for entry, then in enumerate(path.then):
            if then.rate is None and then.time is None:
                text = 'drainage.mode = "coupled" needs a time: "... in 10 min" or "... at 0.05 mm/s"'
                yield Clash(((*here, "then", entry), (*here, "then"), mode), text)


def _bent(here: KeyPath, path: Path) -> Iterator[Clash]:
    """Check what a path on which H and M change their ratio needs beside what it imposes."""
    where, kind = (*here, "kind"), PATH_KINDS[path.kind]
    for name in kind.needs:
        if not getattr(path, name):
            yield Clash(((*here, name), where), f'a path of kind "{path.kind}" needs a {name}')
    if path.role == "calibration":
        text = f'springs are made from paths of one direction only: a {path.kind} needs role = "held-back"'
        yield Clash(((*here, "role"), where), text)
    for name in ("then", "duration"):
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
