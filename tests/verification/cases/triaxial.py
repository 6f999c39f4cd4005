# SPDX-License-Identifier: MIT
"""Drained triaxial tests on one hexahedron: hardening sand in compression, the limits in extension.

Isotropic start at the cell pressure s3, axial strain imposed, lateral stress constant. With q = s1 - s3,
M = 6 sin phi/(3 - sin phi) and e the equivalent plastic strain, the flow keeps its direction, so that

    q = M(e) s3/(1 - M(e)/3),  axial strain = q/E + e (1 - M_psi/3),  volumetric = q (1 - 2 nu)/E - M_psi e,

however the strain is divided into steps. Each tabulated state is therefore reached in one step from the
start; a run in many steps checks that it is the same state.
"""

from functools import cache

import numpy as np

from fe_engine.conventions import XX, ZZ
from tests.verification.blocks import (
    POISSON,
    YOUNG,
    block_model,
    border_force,
    box,
    followers,
    imposed,
    make_newton,
    run,
    sand,
    van_eekelen_sand,
)
from tests.verification.rows import Row, worst

S3 = 100.0e3
# equivalent plastic strain: phi (degrees), q/s3, axial strain, as printed in the reference table
TABLE = {
    0.0: (5.000, 0.1910, 0.000095),
    0.0005: (7.273, 0.2899, 0.000645),
    0.0025: (13.333, 0.5995, 0.002800),
    0.005: (17.500, 0.8600, 0.005430),
    0.02: (25.000, 1.4639, 0.020732),
    0.10: (28.810, 1.8603, 0.100930),
}
_SOURCE = "closed form, PLASOL (Barnichon 1998) with Eq. 11 of Cerfontaine et al. 2018"
_CASE = "triaxial compression"


def friction_angle(e: np.ndarray | float) -> np.ndarray | float:
    """Mobilised friction angle in degrees after the equivalent plastic strain e."""
    return 5.0 + 25.0 * e / (0.005 + e)


def slope(angle: float) -> float:
    """M of an angle in degrees in the p-q plane."""
    sine = np.sin(np.radians(angle))
    return 6.0 * sine / (3.0 - sine)


def closed_form(e: float, psi: float = 0.0) -> tuple[float, float, float]:
    """Return q (Pa), axial and volumetric strain (compression positive) after e."""
    m, m_psi = slope(friction_angle(e)), slope(psi)
    q = m * S3 / (1.0 - m / 3.0)
    return q, q / YOUNG + e * (1.0 - m_psi / 3.0), q * (1.0 - 2.0 * POISSON) / YOUNG - m_psi * e


def compress(strain: float, psi: float = 0.0, steps: int = 1, material=None) -> dict[str, float]:
    """Impose an axial strain (compression positive) on the element; return q, e, volumetric strain and force."""
    mesh = box((1, 1, 1))
    fixed = mesh.nodes == 0.0
    top = np.flatnonzero(mesh.nodes[:, ZZ] == 0.0)
    fixed[:, 2] = mesh.nodes[:, 2] == 1.0
    model = block_model(mesh, material or sand(5.0, 30.0, psi), fixed, 1, S3)
    model.followers = followers(top, 2, 0)
    newton = make_newton(model)
    fractions = tuple(np.arange(1, steps + 1) / steps)
    state, _ = run(newton, imposed([strain], fractions))
    stress = state.committed.stress.mean(axis=(0, 1))
    move = state.committed.displacement
    return {
        "q": stress[XX] - stress[ZZ],
        "e": float(state.committed.history.mean()),
        "volumetric": strain - move[:, 0].max() - move[:, 1].max(),
        "force": float(border_force(newton, state)[0]),
        "spread": float(np.ptp(state.committed.stress, axis=(0, 1)).max()),
    }


@cache
def rows() -> tuple[Row, ...]:
    """Triaxial compression with psi = 0 and 10 degrees, and the limit in extension."""
    return (*map(_state, TABLE), *_worst(0.0), *_worst(10.0), *_steps(), *_extension(), *_van_eekelen())


def _state(e: float) -> Row:
    q, strain, _ = closed_form(e)
    name = f"q/s3 at e = {e:g}, axial strain {strain:.6f}"
    return Row(_CASE, name, "", compress(strain)["q"] / S3, q / S3, _SOURCE, 1e-6)


def _worst(psi: float) -> list[Row]:
    """Largest relative errors over the table's states beyond first yield; psi in degrees."""
    states = np.array([e for e in TABLE if e])
    exact = np.array([closed_form(e, psi) for e in states])
    found = [compress(strain, psi) for _, strain, _ in exact]
    ours = {name: np.array([one[name] for one in found]) for name in found[0]}
    ratios = {
        "q": ours["q"] / exact[:, 0],
        "equivalent plastic strain": ours["e"] / states,
        "friction angle": friction_angle(ours["e"]) / friction_angle(states),
        "volumetric strain": ours["volumetric"] / exact[:, 2],
        "force on the top": ours["force"] / exact[:, 0],
    }
    case = f"{_CASE}, psi = {psi:g} deg"
    return [
        Row.error(case, f"largest relative error of {name}", worst(ratio, 1.0), _SOURCE, 1e-6)
        for name, ratio in ratios.items()
    ]


def _steps() -> list[Row]:
    """The same strain in one step and in forty."""
    _, strain, _ = closed_form(0.02, 10.0)
    one, many = compress(strain, 10.0), compress(strain, 10.0, steps=40)
    return [Row(_CASE, "q in 40 steps over q in one", "", many["q"] / one["q"], 1.0, "proportional flow", 1e-9)]


def _extension() -> list[Row]:
    """Axial unloading to the limit of a perfectly plastic Drucker-Prager cone at 30 degrees."""
    ours = compress(-5.0e-3, material=sand(30.0))
    m = slope(30.0)
    return [
        Row("triaxial extension, 30 deg", "q/s_r at the limit", "", -ours["q"] / S3, m / (1.0 + m / 3.0),
            "Drucker-Prager closed form, 0.857", 1e-6)
    ]  # fmt: skip


def _van_eekelen() -> list[Row]:
    """Compression as on the cone, and the limit in extension, which has the same friction angle."""
    case, exact = "triaxial compression, Van Eekelen, psi = 10 deg", np.array([closed_form(e, 10.0) for e in TABLE])
    found = [compress(strain, 10.0, material=van_eekelen_sand(5.0, 30.0, 10.0)) for strain in exact[1:, 1]]
    rows = [
        Row.error(case, f"largest relative error of {name}", worst(ours / exact[1:, i], 1.0), _SOURCE, 1e-6)
        for i, name, ours in (
            (0, "q", np.array([one["q"] for one in found])),
            (2, "volumetric strain", np.array([one["volumetric"] for one in found])),
        )
    ]
    for psi in (0.0, 10.0):
        ours = compress(-5.0e-3, material=van_eekelen_sand(30.0, psi=psi))
        limit = 2.0 * np.sin(np.radians(30.0)) / (1.0 + np.sin(np.radians(30.0)))
        name = f"triaxial extension, Van Eekelen, 30 deg, psi {psi:g} deg"
        source = "Mohr-Coulomb closed form, 0.667"
        rows.append(Row(name, "q/s_r at the limit", "", -ours["q"] / S3, limit, source, 1e-6))
    return rows
