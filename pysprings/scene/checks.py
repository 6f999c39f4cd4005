# SPDX-License-Identifier: MIT
"""Values of a scene that are right one by one but not together."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from pysprings.core.path_kinds import PATH_KINDS, UNITS, VERTICAL
from pysprings.core.units import show
from pysprings.scene.positions import KeyPath

if TYPE_CHECKING:
    from pysprings.scene.model import Caisson, Domain, Path, Scene, Soil, Solver

MIN_RADIUS_RATIO = 1.02  # domain radius over caisson radius: room for a graded mesh around the skirt
MIN_DEPTH_RATIO = 1.02  # domain depth over skirt length: room for a graded mesh below the tip

MOST_CONTRACTION = 0.95  # of the shear modulus, lost to plastic contraction at constant volume
# Van Eekelen's surface: its exponent, and the friction (rad) up to which its section is convex (`fe_engine.soil.lode`)
_EXPONENT = -0.229
_MOST_FRICTION = math.radians(46.5)
_ANGLES = tuple(math.pi / 3.0 * i / 60.0 for i in range(61))  # Lode angles, from compression to extension


class Clash(NamedTuple):
    """Keys (as in TOML) whose values do not go together, the one to blame first, and why."""

    keys: tuple[KeyPath, ...]
    message: str


def clashes(scene: Scene) -> Iterator[Clash]:
    """Give everything that does not go together in a scene whose single values are valid."""
    yield from _caisson(scene.caisson)
    yield from _domain(scene.domain, scene.caisson)
    yield from _soil(scene.soil)
    yield from _initial_state(scene.soil, scene.domain)
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


def _series(scene: Scene) -> Iterator[Clash]:
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
    if scene.drainage.mode != "drained":
        yield Clash((("drainage", "mode"), chosen), 'must be "drained" with discretisation = "fourier"')


def _soil(soil: Soil) -> Iterator[Clash]:
    final = f"friction_angle_final ({show(soil.friction_angle_final, 'deg')})"
    for name in ("friction_angle_initial", "dilation_angle"):
        value = getattr(soil, name)
        if value > soil.friction_angle_final:
            keys = ("soil", name), ("soil", "friction_angle_final")
            yield Clash(keys, f"{show(value, 'deg')} must not be more than {final}")
    if soil.yield_surface == "elastic":
        return
    if soil.friction_angle_final == 0.0 and soil.cohesion == 0.0:
        keys = ("soil", "friction_angle_final"), ("soil", "cohesion")
        yield Clash(keys, "a soil without friction and cohesion has no strength")
    if soil.yield_surface == "van-eekelen" and soil.friction_angle_final > _MOST_FRICTION:
        keys = ("soil", "friction_angle_final"), ("soil", "yield_surface")
        limit = f"Van Eekelen's surface is convex up to {show(_MOST_FRICTION, 'deg')}"
        yield Clash(keys, f"{show(soil.friction_angle_final, 'deg')} is too much: {limit}")
        return
    yield from _contraction(soil)


def _contraction(soil: Soil) -> Iterator[Clash]:
    """Check that a contracting soil (dilation angle < 0) stays stable when its volume is held.

    The multiplier of the cone has the slope -(G + 9 K m m_psi) without hardening (`fe_engine.soil.plasol`): where it
    is not negative, the soil loses all strength at constant volume, and the return to the cone has two answers or none.
    """
    if _lost(soil, soil.dilation_angle) <= MOST_CONTRACTION:
        return
    low, high = soil.dilation_angle, 0.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _lost(soil, middle) > MOST_CONTRACTION else (low, middle)
    angle = math.degrees(high)
    keys = tuple(("soil", name) for name in ("dilation_angle", "poisson_ratio", "friction_angle_final"))
    with_these = f"Poisson ratio {soil.poisson_ratio:g} and {show(soil.friction_angle_final, 'deg')} of friction"
    yield Clash(keys, f"{show(soil.dilation_angle, 'deg')} is unstable: with {with_these} at least {angle:.2f} deg")


def _lost(soil: Soil, psi: float) -> float:
    """Share of the shear modulus that plastic flow with this dilation angle (rad) takes at constant volume.

    -9 (K/G) m m_psi on the cone; on Van Eekelen's surface, where both slopes shrink by their sections, with -T T_psi of
    the flow across the meridian plane, at the worst Lode angle (`fe_engine.soil.van_eekelen`).
    """
    nu, phi = soil.poisson_ratio, soil.friction_angle_final
    cone = -6.0 * (1.0 + nu) / (1.0 - 2.0 * nu) * cone_slope(phi) * cone_slope(psi)
    if soil.yield_surface != "van-eekelen":
        return cone
    worst = 0.0
    for angle in _ANGLES:
        (rho, turn), (rho_psi, turn_psi) = _section(phi, angle), _section(psi, angle)
        worst = max(worst, cone * rho * rho_psi - turn * turn_psi)
    return worst


def _section(phi: float, lode_angle: float) -> tuple[float, float]:
    """Radius of Van Eekelen's section over that in compression, and -d(its logarithm)/d(Lode angle)."""
    b = math.tanh(math.atanh(math.sin(phi) / 3.0) / _EXPONENT)
    along = 1.0 + b * math.cos(3.0 * lode_angle)
    return (along / (1.0 + b)) ** _EXPONENT, 3.0 * _EXPONENT * b * math.sin(3.0 * lode_angle) / along


def cone_slope(angle: float) -> float:
    """Slope m of the Drucker-Prager cone, 2 sin(phi)/(sqrt(3) (3 - sin(phi))); that of its potential for psi."""
    sine = math.sin(angle)
    return 2.0 * sine / (math.sqrt(3.0) * (3.0 - sine))


def _initial_state(soil: Soil, domain: Domain) -> Iterator[Clash]:
    """Check that the geostatic stress is inside the initial yield surface.

    With compression positive and the vertical stress s: II = |1 - K0| s/sqrt(3), I = (1 + 2 K0) s, and the
    surface is II = m I + 6 c cos(phi)/(sqrt(3) (3 - sin(phi))), m = 2 sin(phi)/(sqrt(3) (3 - sin(phi))). Van Eekelen's
    surface is the same for K0 < 1 (compression); for K0 > 1 (extension) m and the cohesive part are less by
    (3 - sin(phi))/(3 + sin(phi)).
    """
    if soil.yield_surface == "elastic":
        return
    names = (
        "K0",
        "friction_angle_initial",
        "cohesion",
        "surcharge",
        "effective_unit_weight",
        "yield_surface",
    )
    keys = (*(("soil", name) for name in names), ("domain", "depth"))
    bottom = soil.surcharge + soil.effective_unit_weight * domain.depth
    if bottom == 0.0 and soil.cohesion == 0.0:
        blame = (("soil", "surcharge"), *keys)
        yield Clash(blame, "a soil without weight, surcharge and cohesion has no strength")
    sine, slope = math.sin(soil.friction_angle_initial), cone_slope(soil.friction_angle_initial)
    strength = 6.0 * soil.cohesion * math.cos(soil.friction_angle_initial) / (math.sqrt(3.0) * (3.0 - sine))
    less = _section(soil.friction_angle_initial, math.pi / 3.0)[0] if soil.yield_surface == "van-eekelen" else 1.0
    reaches = math.sqrt(3.0) * slope, math.sqrt(3.0) * slope * less
    if soil.K0 > 1.0:
        slope, strength = less * slope, less * strength
    shear, pressure = abs(1.0 - soil.K0) / math.sqrt(3.0), 1.0 + 2.0 * soil.K0
    worst = max((shear - slope * pressure) * vertical for vertical in (soil.surcharge, bottom))
    if worst > strength + 1e-9 * bottom:
        angle = show(soil.friction_angle_initial, "deg")
        allowed = f"({angle}{_range(*reaches, soil)})"
        yield Clash(keys, f"{soil.K0:g} puts the initial stress outside the initial yield surface {allowed}")


def _range(compression: float, extension: float, soil: Soil) -> str:
    """Say which K0 a cohesionless soil allows; sqrt(3) m in compression and in extension."""
    if soil.cohesion:
        return f", cohesion {show(soil.cohesion, 'kPa')}"
    low, high = (1.0 - compression) / (1.0 + 2.0 * compression), (1.0 + extension) / (1.0 - 2.0 * extension)
    return f" allows {low:.3f} to {high:.3f}"


def _solver(solver: Solver) -> Iterator[Clash]:
    first, largest = solver.first_step_fraction, solver.max_step_fraction
    if first is not None and largest is not None and first > largest:
        keys = ("solver", "first_step_fraction"), ("solver", "max_step_fraction")
        yield Clash(keys, f"{first:g} must not be more than max_step_fraction ({largest:g})")


def _paths(paths: tuple[Path, ...]) -> Iterator[Clash]:
    if not paths:
        yield Clash((("path",),), "at least one [[path]] is needed: it says how the caisson is moved")
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
    if path.kind == VERTICAL and path.heave == "fixed":
        yield Clash(((*here, "heave"), (*here, "kind")), 'a path of kind "vertical" moves the caisson up or down')
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
