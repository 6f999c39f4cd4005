# SPDX-License-Identifier: MIT
"""Expansion of a spherical cavity in perfectly plastic, cohesionless sand (30 degrees, psi 0 and 30 degrees).

The law "sand" has two perfectly plastic limits once its strength is mobilised and never fades: I_R 0, which shears at
phi_crit without dilation, and I_R 4, which has phi_crit + 12 deg and M_psi = D = 1.2/1.4.

A sector of small solid angle: one row of hexahedra along the radius, whose nodes move radially only (their
dofs are radial and two fixed tangential ones). All stresses stay on the compression meridian. With
N = (1 + sin phi)/(1 - sin phi) and compression positive, for a plastic zone a < r < b around a cavity of
radius a in a medium at the isotropic pressure p0 (small strains):

    at b        s_r = p_y = 3 N p0/(N + 2),   u(b)/b = (p_y - p0)/(4 G)
    a < r < b   s_r = p_y (b/r)^(2 - 2/N),    s_t = s_r/N
    flow        de_r + k de_t = 0 (plastic),  k = (1 - M_psi/3)/(1/2 + M_psi/3),  M_psi = 6 sin psi/(3 - sin psi)

The elastic strains are known from the stresses, so (r^k u)' is, and u(a) follows in closed form.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from fe_engine.elements import hex8
from fe_engine.elements.interface import nodal_stations
from fe_engine.material import Material
from fe_engine.mesh import Mesh
from fe_engine.model import Model
from fe_engine.soil import plasol, sand as by_density
from tests.verification.blocks import (
    POISSON,
    YOUNG,
    block_model,
    border_force,
    followers,
    imposed,
    loaded,
    make_newton,
    run,
    sand,
    van_eekelen_sand,
)
from tests.verification.rows import Row, fitted_rate

P0, PHI = 100.0e3, np.radians(30.0)
# Far enough for the fixed outer surface to change u/a by (b/R)^3 < 2e-6
OUTER_RADIUS = 250.0
CELLS, ANGLE = 160, 0.002
# b/a: p (kPa), u/a for psi 0 and psi 30 degrees, as printed in the reference table
TABLE = {
    1.5: (309.07, 9.9935e-4, 8.2484e-4),
    2.0: (453.57, 2.65286e-3, 1.72661e-3),
    3.0: (778.82, 9.9824e-3, 4.4780e-3),
}
_SOURCE = "closed form for a cohesionless Mohr-Coulomb medium (as Carter, Booker & Yeung 1986, small strain)"


def closed_form(b: float, psi: float) -> tuple[float, float]:
    """Pressure in the cavity (Pa) and u/a for a plastic radius of b cavity radii; psi in degrees."""
    shear = YOUNG / (2.0 * (1.0 + POISSON))
    n = (1.0 + np.sin(PHI)) / (1.0 - np.sin(PHI))
    m_psi = 6.0 * np.sin(np.radians(psi)) / (3.0 - np.sin(np.radians(psi)))
    k = (1.0 - m_psi / 3.0) / (0.5 + m_psi / 3.0)
    first = 3.0 * n * P0 / (n + 2.0)
    power = 2.0 - 2.0 / n
    # e_r + k e_t (compression) = A s_r(r) - B p0 with e_r = (s_r - 2 nu s_t)/E, e_t = ((1 - nu) s_t - nu s_r)/E
    a_term = (1.0 - 2.0 * POISSON / n + k * ((1.0 - POISSON) / n - POISSON)) / YOUNG
    b_term = (1.0 - 2.0 * POISSON) * (1.0 + k) / YOUNG
    # u' + k u/r = -(A s_r - B p0): integrate (r^k u)' from a = 1 to b
    stress_part = a_term * first * b**power * (b ** (k + 1.0 - power) - 1.0) / (k + 1.0 - power)
    start_part = b_term * P0 * (b ** (k + 1.0) - 1.0) / (k + 1.0)
    at_b = b ** (k + 1.0) * (first - P0) / (4.0 * shear)
    return float(first * b**power), float(at_b + stress_part - start_part)


@dataclass(frozen=True)
class Sector:
    """The model, the area (m2) that turns the force on the wall into a pressure, and the cell size ratio - 1."""

    model: Model
    area: float
    size: float
    is_sphere: bool = True


def make_sector(cells: int, psi: float, angle: float = ANGLE, material: Material | None = None) -> Sector:
    """Sector of half angle ``angle`` (rad) with cells in geometric progression from r = 1 m."""
    radius = np.geomspace(1.0, OUTER_RADIUS, cells + 1)
    tangent = np.tan(angle) * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    ray = np.column_stack([tangent, np.ones(4)])
    ray /= np.linalg.norm(ray, axis=1)[:, None]
    nodes = (radius[:, None, None] * ray).reshape(-1, 3)
    first = 4 * np.arange(cells)[:, None]
    mesh = Mesh(nodes, first + np.arange(8))
    mesh.check()
    fixed = np.zeros(nodes.shape, dtype=bool)
    fixed[:, 1:] = True
    fixed[-4:] = True
    model = block_model(mesh, material or sand(30.0, psi=psi), fixed, 1, P0)
    model.frames = {node: _radial_frame(nodes[node]) for node in range(len(nodes))}
    wall = np.arange(4)
    model.followers = followers(wall, 0, 0)
    _, _, area = nodal_stations(nodes, wall[None], nodes / np.linalg.norm(nodes, axis=1)[:, None])
    return Sector(model, float(area.sum()), radius[1] - 1.0)


def _radial_frame(position: np.ndarray) -> np.ndarray:
    """Rows (3, 3): the radial direction and two directions across it."""
    radial = position / np.linalg.norm(position)
    across = np.cross([0.0, 1.0, 0.0], radial)
    across /= np.linalg.norm(across)
    return np.array([radial, across, np.cross(radial, across)])


def expand(sector: Sector, displacement: float) -> tuple[float, float]:
    """Impose u (m) at the wall of the cavity of 1 m; return its pressure (Pa) and the plastic radius (m)."""
    newton = make_newton(sector.model, 1e-9)
    state, _ = run(newton, imposed([displacement], (0.1, 0.3, 0.6, 1.0)))
    pressure = P0 + float(border_force(newton, state)[0]) / sector.area
    mesh = sector.model.mesh
    plastic = state.committed.history[..., plasol.KAPPA] > 0.0
    radius = np.linalg.norm(hex8.gauss_positions(mesh.nodes, mesh.hexes), axis=2)
    return pressure, float(radius[plastic].max(initial=0.0))


def inflate(sector: Sector, pressure: float) -> float:
    """Impose the pressure (Pa) in the cavity of 1 m; return the displacement of its wall (m)."""
    newton = make_newton(sector.model, 1e-9)
    parts = np.linspace(0.0, 1.0, 7)[1:]
    stages = [loaded([part * (pressure - P0) * sector.area]) for part in parts]
    state, _ = run(newton, *stages)
    return float(state.committed.border[0])


def errors(cells: int, psi: float, b: float, angle: float = ANGLE) -> tuple[float, float]:
    """Relative errors of p at equal u/a and of u/a at equal p, at a plastic radius of b."""
    pressure, displacement = closed_form(b, psi)
    sector = make_sector(cells, psi, angle)
    return expand(sector, displacement)[0] / pressure - 1.0, inflate(sector, pressure) / displacement - 1.0


@cache
def rows() -> tuple[Row, ...]:
    """Pressure, displacement and plastic radius at b/a = 1.5, 2, 3, for psi 0 and 30 degrees, and the rates."""
    plain = (row for psi in (0.0, 30.0) for row in (*_values(_name(psi), psi, make_sector(CELLS, psi)), *rates(psi)))
    return (*plain, *_van_eekelen(), *_by_density())


def _by_density() -> list[Row]:
    """The law "sand" at I_R 0 and 4 with all of its strength mobilised, phi 30 deg in both."""
    found = []
    for index, density, critical, psi in (0, 0.01, 30.0, 0.0), (4, 10.0, 18.0, float(np.degrees(np.arcsin(0.375)))):
        packed = by_density.pack(YOUNG, POISSON, np.radians(critical), density, 10.0, 4.0, 1e-3, 1e9, 0.0, 0.04)
        sector = make_sector(CELLS, psi, material=Material(by_density.LAW, packed))
        found += _values(f"spherical cavity, law sand, I_R {index}, phi 30, psi {psi:.3g} deg", psi, sector)
    return found


def _van_eekelen() -> list[Row]:
    """Van Eekelen's surface: all stresses are on the compression meridian, which is the cone's."""
    rows = []
    for psi in (0.0, 30.0):
        cone, other = (make_sector(CELLS, psi, material=law(30.0, psi=psi)) for law in (sand, van_eekelen_sand))
        name = f"p at the u/a of b/a = 3 over the cone's, psi {psi:g} deg"
        ratio = expand(other, closed_form(3.0, psi)[1])[0] / expand(cone, closed_form(3.0, psi)[1])[0]
        rows.append(Row("spherical cavity, phi 30, Van Eekelen", name, "", ratio, 1.0, "the cone's figure", 1e-6))
    return rows


def _name(psi: float) -> str:
    return f"spherical cavity, phi 30, psi {psi:g} deg"


def _values(case: str, psi: float, sector: Sector) -> list[Row]:
    """Pressure at equal displacement and the reverse, and the plastic radius."""
    found, missed = [], []
    for b in TABLE:
        pressure, displacement = closed_form(b, psi)
        ours, radius = expand(sector, displacement)
        missed.append(abs(radius / b - 1.0) / sector.size)
        found += [
            Row(case, f"p at the u/a of b/a = {b:g}", "kPa", ours / 1e3, pressure / 1e3, _SOURCE, 0.01),
            Row(case, f"u/a at the p of b/a = {b:g}", "", inflate(sector, pressure), displacement, _SOURCE, 0.01),
        ]
    return [*found, Row.error(case, "plastic radius, largest error in cells", max(missed), _SOURCE, 1.0)]


@cache
def rates(psi: float) -> list[Row]:
    """Order of convergence in the cell size at b/a = 2, and the effect of the sector's angle."""
    case = _name(psi)
    cells = (40, 80, 160)
    sizes = [make_sector(n, psi).size for n in cells]
    found = np.array([errors(n, psi, 2.0) for n in cells])
    wide = errors(CELLS, psi, 2.0, 2.0 * ANGLE)
    return [
        Row(case, "order in h of the error of p", "", fitted_rate(sizes, found[:, 0]), 2.0, "second order", 0.15),
        Row(case, "order in h of the error of u/a", "", fitted_rate(sizes, found[:, 1]), 2.0, "second order", 0.15),
        Row.error(case, "change of p when the sector is twice as wide", wide[0] - found[-1, 0], "no effect", 1e-3),
        Row.error(case, "change of u/a when the sector is twice as wide", wide[1] - found[-1, 1], "no effect", 1e-3),
    ]
