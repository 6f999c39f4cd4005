# SPDX-License-Identifier: MIT
"""Undrained clay in total stress: cavities, a disc, a pile, pull-out of a vented caisson, flow around a pile.

All elements overshoot a collapse load, in proportion to the size of the cells beside the edge: factors on two meshes,
whose cells differ by a factor of two, are shown with their limit for cells of no size, which is 2 fine - coarse.
"""

from functools import cache

import numpy as np

from fe_engine.elements import hex8
from fe_engine.elements.interface import nodal_stations
from fe_engine.material import Material
from fe_engine.mesh import Mesh
from fe_engine.soil import mobilised, tresca, von_mises
from fe_engine.soil.law import SoilLaw
from pysprings.full_model.compute import compute
from tests.support import tiny
from tests.verification.blocks import block_model, border_force, followers, imposed, make_newton, run
from tests.verification.cases.cavity import Sector, make_sector
from tests.verification.clay_caissons import Clay, about_tip, probe, push
from tests.verification.clay_shapes import Disc, Pile, disc_factor, disc_moment, pile_factor
from tests.verification.rows import Row, fitted_rate

SU, RIGIDITY, POISSON, PRESSURE = 20.0e3, 100.0, 0.4999, 100.0e3
OUTER_RADIUS, CELLS = 250.0, 160
# b/a: (p - p0)/su of a spherical and of a cylindrical cavity, as printed in the reference
SPHERE = {1.0: 1.33333, 1.5: 2.95519, 2.0: 4.10592, 3.0: 5.72778}
CYLINDER = {1.5: 1.81093, 2.0: 2.38629, 3.0: 3.19722}
_CAVITY = "closed form, nu 0.5 (Gibson & Anderson 1961; Hill 1950)"


def sphere_closed_form(b: float) -> tuple[float, float]:
    """Return (p - p0)/su and u/a of a spherical cavity whose plastic radius is b cavity radii."""
    return 4.0 / 3.0 + 4.0 * np.log(b), b**3 / (3.0 * RIGIDITY)


def cylinder_closed_form(b: float) -> tuple[float, float]:
    """Return (p - p0)/su and u/a of a cylindrical cavity in plane strain; see `sphere_closed_form`."""
    return 1.0 + 2.0 * np.log(b), b**2 / (2.0 * RIGIDITY)


def material(law: SoilLaw, strength: float = SU) -> Material:
    """Perfectly plastic clay of a strength (Pa); G follows SU, whatever the strength of the law means."""
    young = 2.0 * (1.0 + POISSON) * RIGIDITY * SU
    return Material(law, mobilised.pack(young, POISSON, strength))


def sphere(law: SoilLaw, strength: float, cells: int = CELLS) -> Sector:
    """Sector of a spherical cavity of 1 m, free at the outside."""
    sector = make_sector(cells, 0.0, material=material(law, strength))
    sector.model.fixed[-4:, 0] = False
    return sector


def cylinder(law: SoilLaw, strength: float, cells: int = CELLS, angle: float = 0.01) -> Sector:
    """Sector of a cylindrical cavity of 1 m in plane strain, half its angle given (rad), free at the outside."""
    radius = np.geomspace(1.0, OUTER_RADIUS, cells + 1)
    ray = np.array([[np.cos(a), np.sin(a), z] for z in (0.0, 0.02) for a in (-angle, angle)])
    order = [0, 1, 3, 2]  # around the face
    scale = np.stack([radius, radius, np.ones_like(radius)], axis=1)
    nodes = (scale[:, None, :] * ray[order]).reshape(-1, 3)
    first = 4 * np.arange(cells)[:, None]
    mesh = Mesh(nodes, first + np.arange(8))
    mesh.check()
    fixed = np.zeros(nodes.shape, dtype=bool)
    fixed[:, 1:] = True
    model = block_model(mesh, material(law, strength), fixed, 1, PRESSURE)
    model.frames = {node: _around_axis(nodes[node]) for node in range(len(nodes))}
    wall = np.arange(4)
    model.followers = followers(wall, 0, 0)
    normals = np.array([_around_axis(each)[0] for each in nodes])
    _, _, area = nodal_stations(nodes, wall[None], normals)
    return Sector(model, float(area.sum()), radius[1] - 1.0, is_sphere=False)


def _around_axis(position: np.ndarray) -> np.ndarray:
    """Rows (3, 3): the direction away from the z axis, the one around it, and z."""
    x, y = position[:2] / np.hypot(*position[:2])
    return np.array([[x, y, 0.0], [-y, x, 0.0], [0.0, 0.0, 1.0]])


def expand(sector: Sector, displacement: float) -> tuple[float, float]:
    """Impose u (m) at the wall of a cavity of 1 m; return (p - p0)/SU and the plastic radius (m)."""
    newton = make_newton(sector.model, 1e-9)
    state, _ = run(newton, imposed([displacement], tuple(np.linspace(0.0, 1.0, 9)[1:])))
    mesh = sector.model.mesh
    points = hex8.gauss_positions(mesh.nodes, mesh.hexes)
    radius = np.linalg.norm(points if sector.is_sphere else points[..., :2], axis=2)
    plastic = state.committed.history[..., mobilised.KAPPA] > 0.0
    pressure = float(border_force(newton, state)[0]) / sector.area / SU
    return pressure, float(radius[plastic].max(initial=0.0))


@cache
def cavity_rows() -> tuple[Row, ...]:
    """Pressures at the displacement of each plastic radius, both laws, and the order in the size of the cells."""
    strength = 2.0 / np.sqrt(3.0) * SU  # von Mises with su of triaxial compression
    spheres = {"Tresca": sphere(tresca.LAW, SU), "von Mises, triaxial su": sphere(von_mises.LAW, strength)}
    cylinders = {"Tresca": cylinder(tresca.LAW, SU), "von Mises, plane strain su": cylinder(von_mises.LAW, SU)}
    found = []
    for shape, sectors, closed, table in (
        ("spherical", spheres, sphere_closed_form, SPHERE), ("cylindrical", cylinders, cylinder_closed_form, CYLINDER),
    ):  # fmt: skip
        for law, sector in sectors.items():
            for b in table:
                wanted, displacement = closed(b)
                name = f"(p - p0)/su at the u/a of b/a = {b:g}"
                ours = expand(sector, displacement)[0]
                found.append(Row(f"{shape} cavity, {law}", name, "", ours, wanted, _CAVITY, 0.01))
    return (*found, *_order())


def _order() -> list[Row]:
    """Order in h of the error of the pressure at b/a = 2."""
    found = []
    cases = ("spherical", sphere, sphere_closed_form), ("cylindrical", cylinder, cylinder_closed_form)
    for shape, make, closed in cases:
        wanted, displacement = closed(2.0)
        sectors = [make(tresca.LAW, SU, cells) for cells in (20, 40, 80)]
        errors = [expand(each, displacement)[0] - wanted for each in sectors]
        order = fitted_rate([each.size for each in sectors], errors)
        found.append(Row.at_least(f"{shape} cavity, Tresca", "order in h of the error of p", order, 1.0, "first order"))
    return found


# V/(A su_m) on the surface, rough and smooth
CIRCLE = {
    (0.0, True): 6.05, (0.0, False): 5.69, (2.0, True): 7.63, (2.0, False): 6.73, (5.0, True): 9.24, (5.0, False): 7.96,
}  # fmt: skip
_CIRCLE = {
    True: "exact (Cox, Eason & Hopkins 1961) at kappa 0, quadratic elements at kappa 2 and 5",
    False: "method of characteristics",
}


@cache
def circle_rows() -> tuple[Row, ...]:
    """Limit for cells of no size, and the overshoot of both meshes; discs that slide."""
    found = []
    for (kappa, rough), wanted in CIRCLE.items():
        case = f"circle on clay, kappa {kappa:g}, {'rough' if rough else 'smooth'}"
        coarse, fine = (disc_factor(Disc(cells, kappa, rough)) for cells in (20.0, 40.0))
        found += [
            Row(case, "V/(A su_m), edge cells D/20", "", coarse, wanted, _CIRCLE[rough], None),
            Row(case, "V/(A su_m), edge cells D/40", "", fine, wanted, _CIRCLE[rough], None),
            Row(case, "V/(A su_m), limit", "", 2.0 * fine - coarse, wanted, _CIRCLE[rough], 0.01),
        ]
    for kappa in (0.0, 2.0):
        ours = disc_factor(Disc(20.0, kappa, harmonics=1), "u")
        found.append(Row(f"disc slides on clay, kappa {kappa:g}", "H/(A su_m)", "", ours, 1.0, "equilibrium", 1e-4))
    return tuple(found)


@cache
def circle_order_rows() -> tuple[Row, ...]:
    """Three meshes: order of the overshoot, and the limit of the finer two."""
    found = []
    for (kappa, rough), wanted in CIRCLE.items():
        case = f"circle on clay, kappa {kappa:g}, {'rough' if rough else 'smooth'}, edge cells D/20, 40, 80"
        factors = np.array([disc_factor(Disc(cells, kappa, rough)) for cells in (20.0, 40.0, 80.0)])
        order = float(np.log2((factors[0] - factors[1]) / (factors[1] - factors[2])))
        found += [
            Row(case, "order in h of V", "", order, 1.0, "first order", 0.3),
            Row(case, "V/(A su_m), limit", "", 2.0 * factors[2] - factors[1], wanted, _CIRCLE[rough], 0.005),
        ]
    return tuple(found)


@cache
def disc_moment_rows() -> tuple[Row, ...]:
    """Couple of a rough disc under a share of V_ult over that without V, edge cells D/40: shown beside fitted loci."""
    disc, found = Disc(40.0, harmonics=_HARMONICS), []
    alone = disc_moment(disc, 0.0)
    for share in (0.5, 0.75):
        case, kept = f"disc turns on clay, V/V_ult {share:g}", disc_moment(disc, share) / alone
        locus, formula = float(np.sqrt(1.0 - share**2)), 1.0 - share**2.12
        found += [
            Row(case, "M over M at V = 0", "", kept, locus, "fitted locus (Taiebat & Carter 2000)", None),
            Row(case, "M over M at V = 0", "", kept, formula, _FORMULA, None),
        ]
    return tuple(found)


def pile_lower_bound(alpha: float) -> float:
    """Return the lower bound of the load over su and D (Randolph & Houlsby 1984)."""
    d = np.arcsin(alpha)
    return float(np.pi + 2.0 * d + 2.0 * np.cos(d) + 4.0 * (np.cos(0.5 * d) + np.sin(0.5 * d)))


# alpha: load over su and D, source, tolerance of the limit
FLOW = {
    0.0: (9.20117, "exact (Geotechnique 2026)", 0.02),
    0.5: (10.820, "lower bound (Randolph & Houlsby 1984)", 0.03),
    0.65: (11.215, "lower bound (Randolph & Houlsby 1984)", 0.03),
    1.0: (11.9400, "exact (Randolph & Houlsby 1984)", 0.02),
}


@cache
def pile_rows() -> tuple[Row, ...]:
    """A pile pushed through a slice of bricks, 16 and 32 cells around the half."""
    found = []
    for alpha, (wanted, source, tolerance) in FLOW.items():
        case = f"flow around a pile, alpha {alpha:g}"
        coarse, fine = (pile_factor(Pile(around, alpha)) for around in (16, 32))
        found += [
            Row(case, "H/(su D), 16 cells around", "", coarse, wanted, source, None),
            Row(case, "H/(su D), 32 cells around", "", fine, wanted, source, None),
            Row(case, "H/(su D), limit", "", 2.0 * fine - coarse, wanted, source, tolerance),
        ]
    return tuple(found)


OUTSIDE, INSIDE = 0.65, 0.4


@cache
def pull_out_rows() -> tuple[Row, ...]:
    """A vented caisson is pulled out of clay without strength at mudline: alpha su acts on both walls, all over.

    It is pulled by 30 mm, which mobilises the walls; farther up the plug of bricks goes with a part of the inner one.
    """
    found = []
    meshes = {"fourier": {"preset": "medium"}, "hex8": {"preset": "coarse", "azimuth": 28}}
    for discretisation, mesh in meshes.items():
        scene = tiny.sand(
            caisson={"outer_diameter": 8.0, "skirt_length": 6.0, "skirt_thickness": 0.03},
            domain={"radius": 32.0, "depth": 24.0},
            soil={
                "yield_surface": "tresca", "undrained_shear_strength": {"top": 0.0, "gradient": 2e3},
                "rigidity_ratio": 200.0, "effective_unit_weight": 10e3, "surcharge": 0.0,
            },
            interface={
                "adhesion_factor": {"outside": OUTSIDE, "inside": INSIDE, "lid": 0.0, "tip": 0.0},
                "opening": {"outside": "vented", "inside": "vented", "lid": "vented", "tip": "bonded"},
            },
            mesh={"discretisation": discretisation, **mesh},
            paths=[{"name": "up", "kind": "vertical", "vertical_displacement": -0.03}],
            output={"interface_fields": False, "section": False, "figures": False},
        )  # fmt: skip
        end = compute(scene).tree["paths/up"].isel(step=-1)
        mean = 2e3 * 3.0
        case = f"pull-out of a vented caisson, {discretisation}"
        for name, alpha, diameter in (("outer", OUTSIDE, 8.0), ("inner", INSIDE, 7.94)):
            wanted = np.pi * diameter * 6.0 * alpha * mean
            ours = -float(end[f"V_{name}"])
            found.append(Row(case, f"force on the {name} wall", "kN", ours / 1e3, wanted / 1e3, "equilibrium", 0.01))
    return tuple(found)


# (d/D, kappa): factors by load, an independent computation: Fourier series, quadratic elements, exact Tresca
CAISSONS = {
    (0.25, 0.0): {"NcV": 8.66, "NcH": 2.89, "NcM": 1.03, "H, mudline": 3.16, "H, rotation held": 3.24},
    (0.25, 6.0): {"NcV": 10.63, "NcH": 2.51, "NcM": 0.94, "H, mudline": 2.30, "H, rotation held": 2.55},
    (0.5, 0.0): {"NcV": 10.55, "NcH": 4.19, "NcM": 1.53, "H, mudline": 4.82, "H, rotation held": 5.92},
    (0.5, 6.0): {"NcV": 11.22, "NcH": 3.35, "NcM": 1.15, "H, mudline": 2.86, "H, rotation held": 4.00},
}
_CAISSON = "independent series computation (0.5 to 1 %)"
_HARMONICS = 3


def caisson_name(embedment: float, kappa: float) -> str:
    """Return the name of a caisson in the table."""
    return f"caisson bonded to clay, d/D {embedment:g}, kappa {kappa:g}"


@cache
def caisson_case(embedment: float, kappa: float, load: str) -> tuple[Row, ...]:
    """A collapse load on meshes with cells of D/20 and D/40 at toe and walls, and its limit."""
    wanted = CAISSONS[embedment, kappa][load]
    harmonics = 1 if load == "NcV" else _HARMONICS
    coarse, fine = (push(Clay(embedment, kappa, cells, harmonics), load).factor for cells in (20.0, 40.0))
    case = f"{caisson_name(embedment, kappa)}, {load}"
    return (
        Row(case, "factor, cells of D/20", "", coarse, wanted, _CAISSON, None),
        Row(case, "factor, cells of D/40", "", fine, wanted, _CAISSON, None),
        Row(case, "factor, limit", "", 2.0 * fine - coarse, wanted, _CAISSON, 0.03),
    )


@cache
def preset_case(embedment: float, kappa: float, preset: str) -> tuple[Row, ...]:
    """All collapse loads of a caisson on a preset of the tool: how much too strong its mesh is."""
    case = f"{caisson_name(embedment, kappa)}, preset {preset}"
    found = []
    for load, wanted in CAISSONS[embedment, kappa].items():
        clay = Clay(embedment, kappa, 0.0, 1 if load == "NcV" else _HARMONICS, preset)
        found.append(Row(case, load, "", push(clay, load).factor, wanted, _CAISSON, None))
    return tuple(found)


# about the tip: H/(A su_0) and M/(A D su_0) of a rotation about it, V = 0; M of a caisson that turns is positive here
ABOUT_TIP = (4.75, 2.41)
# (d/D, kappa) of the envelope, V_ult/(A su_0), and directions atan(M/(H D)) in degrees, M about the lid centre
ENVELOPE, V_ULT = (0.5, 0.0), CAISSONS[0.5, 0.0]["NcV"]
DIRECTIONS = (90.0, 67.5, 45.0, 22.5, 0.0, -22.5, -45.0, -67.5)
_FORMULA = "fitted formula (Vulpe, Gourvenec & Power 2014)"
_A, _B = 1.6090, -0.5989


def formula_load(direction: float, share: float) -> float:
    """Return the load R/(A su_0), H = R cos, M = R D sin, on the fitted envelope under V = share V_ult."""
    limits, (c, s) = CAISSONS[ENVELOPE], (np.cos(np.radians(direction)), np.sin(np.radians(direction)))
    load = np.linspace(0.0, 8.0, 80001)
    h = load * c / (limits["NcH"] * (1.0 - share**4.69))
    m = load * (ENVELOPE[0] * c + s) / (limits["NcM"] * (1.0 - share**2.12))  # about the tip
    beyond = np.abs(h) ** _A + np.abs(m) ** _A + 2.0 * _B * h * m >= 1.0
    return float(load[np.argmax(beyond)])


@cache
def envelope_case(share: float) -> tuple[Row, ...]:
    """Loads in eight directions under V = share V_ult, on meshes with cells of D/20 and D/40, and their limit."""
    found = []
    for direction in DIRECTIONS:
        wanted = formula_load(direction, share)
        coarse, fine = (
            float(np.hypot(*probe(Clay(*ENVELOPE, cells, _HARMONICS), direction, share * V_ULT)))
            for cells in (20.0, 40.0)
        )
        case = f"{caisson_name(*ENVELOPE)}, V/V_ult {share:g}, {direction:g} deg"
        found += [
            Row(case, "R/(A su), cells of D/20", "", coarse, wanted, _FORMULA, None),
            Row(case, "R/(A su), cells of D/40", "", fine, wanted, _FORMULA, None),
            Row(case, "R/(A su), limit", "", 2.0 * fine - coarse, wanted, _FORMULA, None),
        ]
    return tuple(found)


@cache
def about_tip_case() -> tuple[Row, ...]:
    """The caisson rotates about its tip: cells of D/20 and D/40, and their limit."""
    coarse, fine = (np.array(about_tip(Clay(*ENVELOPE, cells, _HARMONICS))) for cells in (20.0, 40.0))
    case = f"{caisson_name(*ENVELOPE)}, rotation about the tip"
    found = []
    for name, a, b, wanted in zip(("H/(A su)", "M/(A D su)"), coarse, fine, ABOUT_TIP, strict=True):
        found += [
            Row(case, f"{name}, cells of D/20", "", a, wanted, _CAISSON, None),
            Row(case, f"{name}, cells of D/40", "", b, wanted, _CAISSON, None),
            Row(case, f"{name}, limit", "", 2.0 * b - a, wanted, _CAISSON, 0.05),
        ]
    return tuple(found)
