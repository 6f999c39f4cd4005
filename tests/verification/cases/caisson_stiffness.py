# SPDX-License-Identifier: MIT
"""Elastic stiffness of a rigid caisson at mudline: H = K_H u + K_C rotation, M = K_C u + K_M rotation.

K_free = K_H - K_C^2/K_M is the stiffness of a free-head pull. The reference is a caisson of no thickness,
R = 3.9 m, L = 4 m, in elastic soil (E 200 MPa, nu 0.3) of 24 x 12 m with a roller at the side; `axisymmetric` finds
its bonded values again with elements of order 4. Ours has a skirt of 1 mm here, and the skirt of 0.1 m is shown beside
it. Values come from the tangent of the border dofs at the initial state, and from small displacements run through the
tool.

Smooth skirt: no friction on both walls and the tip. The tip of a caisson without thickness bears nothing, whereas
a tip of 1 mm bears K_N times its area, which is felt once the walls are smooth (K_M + 3 %): there its normal
penalty is taken away as well. "Contact kept" is a normal penalty that is
rigid beside the soil (1e13 N/m3); the row with 1e10 N/m3 stands beside it.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.optimize import brentq

from fe_engine.assembly.system import System
from fe_engine.contact.coulomb import KN, MU
from fe_engine.linear.solver import LinearSolver
from fe_engine.settings import Settings
from fe_engine.solve.newton import Newton
from fe_engine.state import State
from pysprings import Scene
from pysprings.full_model.compute import run
from pysprings.model.build import build_model
from pysprings.model.contact import SURFACE
from tests.support import tiny
from tests.verification import axisymmetric
from tests.verification.rows import Row

NAMES = ("K_H", "K_C", "K_M", "K_free")
UNITS = ("MN/m", "MN", "MN m", "MN/m")
# K_H, K_C, K_M, K_free in MN and m
REFERENCE = {
    "bonded": (4072.0, -10386.0, 89868.0, 2872.0),
    "K_N = K_T = 1e10 N/m3": (4051.0, -10295.0, 88840.0, 2858.0),
    "K_N = K_T = 1e9 N/m3": (3913.0, -9802.0, 82876.0, 2753.0),
    "smooth skirt, lid bonded": (3210.0, -8699.0, 41545.0, 1389.0),
    "domain 48 x 24 m, bonded": (3413.0, -8940.0, 84265.0, 2464.0),
    "half-space, bonded": (2892.0, -7702.0, 80933.0, 2159.0),
}
BONDED = 1.0e13
_FAMILY = (1.0, 1.5, 2.0)
_SOURCE = "axisymmetric FE, thickness 0"
_HALF_SPACE = "boundary method, as Doherty, Houlsby & Deeks 2005"
# A penalty (N/m3) that is taken away, without a division by zero
_NOTHING = 1.0


@dataclass(frozen=True)
class Variant:
    """What distinguishes one row's caisson, lengths in m and penalties in N/m3."""

    preset: str = "paper"
    thickness: float = 1.0e-3
    penalty: float = 1.0e10
    radius: float = 24.0
    refinement: float = 1.0
    smooth: bool = False


def elastic_scene(variant: Variant, **sections) -> Scene:
    """The paper's caisson in elastic soil."""
    base = {
        "soil": {"yield_surface": "elastic"},
        "caisson": {"skirt_thickness": variant.thickness},
        "interface": {"normal_stiffness": variant.penalty, "shear_stiffness": variant.penalty},
        "domain": {"radius": variant.radius, "depth": 0.5 * variant.radius},
        "mesh": {"discretisation": "hex8", "preset": variant.preset, "refinement": variant.refinement},
    }
    return tiny.sand(**base).replace(**sections)


@cache
def matrix(variant: Variant) -> np.ndarray:
    """Tangent stiffness (3, 3) of the whole caisson over (u, w, rotation) at the initial state, N and m."""
    model = build_model(elastic_scene(variant)).model
    if variant.smooth:
        for name in ("outer", "inner", "tip"):
            model.contact[model.stations.surface == SURFACE[name], MU] = 0.0
        model.contact[model.stations.surface == SURFACE["tip"], KN] = _NOTHING
    system = System(model)
    solver = LinearSolver("auto", system.pattern.n_free)
    stiffness = 2.0 * Newton(system, solver, Settings()).border_stiffness(State(model))
    solver.close()
    return stiffness


def four(variant: Variant) -> np.ndarray:
    """K_H, K_C, K_M and K_free in MN and m."""
    k = matrix(variant) / 1e6
    return np.array([k[0, 0], k[0, 2], k[2, 2], k[0, 0] - k[0, 2] * k[2, 0] / k[2, 2]])


def _compare(case: str, ours: np.ndarray, reference, source: str, tolerance: float | None) -> list[Row]:
    numbers = zip(NAMES, UNITS, ours, reference, strict=True)
    return [Row(case, name, unit, float(a), float(b), source, tolerance) for name, unit, a, b in numbers]


@cache
def rows() -> tuple[Row, ...]:
    """The reference; coarse mesh: symmetry of the stiffness, and the same stiffness out of small displacements run."""
    coarse = Variant("coarse")
    k = matrix(coarse)
    case = "rigid caisson, elastic, coarse mesh"
    beside = _compare(case, four(coarse), REFERENCE["K_N = K_T = 1e10 N/m3"], _SOURCE, 0.05)
    symmetry = Row(case, "K_C from H over K_C from M", "", k[0, 2] / k[2, 0], 1.0, "symmetry", 1e-8)
    return (*_oracle(), *beside, symmetry, *_run())


def _oracle() -> list[Row]:
    """The reference itself, by elements that share nothing with ours."""
    k = np.array(axisymmetric.stiffness(3.9, 4.0, 24.0, 12.0, 200e6 / 2.6, 0.3)) / 1e6
    return _compare("reference by axisymmetric elements of order 4, bonded", k, REFERENCE["bonded"], _SOURCE, 1e-3)


def _run() -> list[Row]:
    """Stiffness out of a translation, a rotation and a free-head pull of 1e-7 m, which neither slip nor open."""
    size = 1e-7
    paths = [
        {"name": "translation", "kind": "translation", "lateral_displacement": size},
        {"name": "rotation", "kind": "rotation", "rotation": size},
        {"name": "pull", "kind": "pull", "lateral_displacement": size},
    ]
    quiet = {"interface_fields": False, "section": False}
    steps = {"tolerance": 1e-10, "first_step_fraction": 0.5, "max_step_fraction": 0.5}
    result = run(elastic_scene(Variant("coarse"), paths=paths, solver=steps, output=quiet))
    assert result.attrs["status"] == "complete"
    last = {path["name"]: result[f"paths/{path['name']}"].isel(step=-1) for path in paths}
    value = {name: {key: float(data[key]) for key in ("H", "M", "u", "rotation")} for name, data in last.items()}
    shift, turn, pull = (value[path["name"]] for path in paths)
    ours = np.array([
        shift["H"] / shift["u"], turn["H"] / turn["rotation"], turn["M"] / turn["rotation"], pull["H"] / pull["u"]
    ]) / 1e6  # fmt: skip
    case = "small displacements run by the tool, coarse mesh"
    mutual = shift["M"] / shift["u"] / (turn["H"] / turn["rotation"])
    initial = result["stiffness_initial"].values
    return [
        *_compare(case, ours, four(Variant("coarse")), "tangent stiffness, ours", 1e-7),
        Row(case, "K_C from M in translation over K_C from H in rotation", "", mutual, 1.0, "symmetry", 1e-8),
        Row(case, "K_free by rotation/u of the pull", "MN/m",
            (initial[0, 0] + initial[0, 2] * pull["rotation"] / pull["u"]) / 1e6, ours[3], "the pull's own load", 1e-7),
    ]  # fmt: skip


@cache
def slow_rows() -> tuple[Row, ...]:
    """The paper mesh against the reference, the presets, the order of convergence, and large domains."""
    return (*_paper(), *_presets(), *_convergence(), *_large_domains())


def _paper() -> list[Row]:
    """Each row of the reference table for 24 x 12 m, then the real thickness."""
    wanted = {
        "bonded": (Variant(penalty=BONDED), 0.015),
        "K_N = K_T = 1e10 N/m3": (Variant(), 0.01),
        "K_N = K_T = 1e9 N/m3": (Variant(penalty=1e9), 0.015),
        "smooth skirt, lid bonded": (Variant(penalty=BONDED, smooth=True), 0.015),
    }
    found = []
    for name, (variant, tolerance) in wanted.items():
        found += _compare(f"rigid caisson, {name}", four(variant), REFERENCE[name], _SOURCE, tolerance)
    smooth = "smooth skirt, lid bonded"
    found += _compare(
        f"rigid caisson, {smooth}, K_N = 1e10", four(Variant(smooth=True)), REFERENCE[smooth], _SOURCE, 0.015
    )
    variants = [variant for variant, _ in wanted.values()]
    asymmetry = max(abs(matrix(variant)[0, 2] / matrix(variant)[2, 0] - 1.0) for variant in variants)
    text = "K_C from H over K_C from M, less 1"
    found.append(Row.error("rigid caisson, all of these", text, asymmetry, "symmetry", 1e-8))
    thick, thin = four(Variant(thickness=0.1)), four(Variant())
    return found + _compare("skirt of 0.1 m, K_N = K_T = 1e10", thick, thin, "ours with 1 mm", None)


def _presets() -> list[Row]:
    """Distance of coarse and medium from the reference."""
    name = "K_N = K_T = 1e10 N/m3"
    return [
        row
        for preset, tolerance in (("coarse", 0.05), ("medium", 0.03))
        for row in _compare(f"preset {preset}, {name}", four(Variant(preset)), REFERENCE[name], _SOURCE, tolerance)
    ]


def _convergence() -> list[Row]:
    """Order p and limit of K = K_0 + C h^p through one family of meshes.

    The stress at the tip of a thin skirt is singular as r^-1/2, so an energy converges between first and second
    order in the cell size.
    """
    h = 1.0 / np.array(_FAMILY)
    k = np.array([four(Variant("coarse", refinement=factor)) for factor in _FAMILY])
    found = [_limit(h, column) for column in k.T]
    case = "preset coarse, cells / 1, 1.5, 2, K_N = K_T = 1e10"
    limits = np.array([limit for _, limit in found])
    reference = REFERENCE["K_N = K_T = 1e10 N/m3"]
    orders = [
        Row(case, f"order in h of {name}", "", order, 1.5, "first to second: singular tip", 1.0 / 3.0)
        for name, (order, _) in zip(NAMES, found, strict=True)
    ]
    return orders + _compare(f"{case}, limit", limits, reference, _SOURCE, 0.005)


def _limit(h: np.ndarray, value: np.ndarray) -> tuple[float, float]:
    """Order and limit of a quantity from three cell sizes."""
    ratio = (value[0] - value[1]) / (value[1] - value[2])
    order = brentq(lambda p: (h[0] ** p - h[1] ** p) / (h[1] ** p - h[2] ** p) - ratio, 0.05, 8.0)
    slope = (value[1] - value[2]) / (h[1] ** order - h[2] ** order)
    return order, value[2] - slope * h[2] ** order


def _large_domains() -> list[Row]:
    """Domains of twice, four and eight times the paper's, and their limit: the effect falls as 1/radius."""
    sizes = (48.0, 96.0, 192.0)
    found = {radius: four(Variant(penalty=BONDED, radius=radius)) for radius in sizes}
    reference = REFERENCE["half-space, bonded"]
    limit = 2.0 * found[192.0] - found[96.0]
    name = "domain 48 x 24 m, bonded"
    return [
        *_compare(f"rigid caisson, {name}", found[48.0], REFERENCE[name], _SOURCE, 0.015),
        *_compare("domain 96 x 48 m, bonded, beside the half-space", found[96.0], reference, _HALF_SPACE, None),
        *_compare("domain 192 x 96 m, bonded, beside the half-space", found[192.0], reference, _HALF_SPACE, None),
        *_compare("limit of large domains, bonded", limit, reference, _HALF_SPACE, 0.02),
    ]
