# SPDX-License-Identifier: MIT
"""Soil with pore water beside soil without: sand over clay in total stress, in bricks and in Fourier series.

Column: a layer that is drained at its top consolidates over one without water under the same load. In one dimension the
lower one settles at once by q h/E_oed and is an impervious base: the upper one is Terzaghi's (see `terzaghi`).

Caisson: sand that has no time to drain and clay in total stress of the same G are the same undrained soil, whose
stiffness is known (see `caisson_water`). Yielding push: slow enough it is that of drained sand over clay, fast enough
that of undrained sand over clay, and the balance of the water holds.
"""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import xarray as xr

from fe_engine.fourier_model import FourierModel
from fe_engine.model import Model
from fe_engine.solve.newton import Newton
from pysprings import Scene
from pysprings.full_model.compute import compute
from pysprings.scene.sections import PAPER
from tests.support import tiny
from tests.verification.blocks import YOUNG, loaded, make_newton
from tests.verification.cases import caisson_water, series_water, terzaghi
from tests.verification.rows import Row
from tests.verification.water import consolidation, consolidation_time, follow, oedometric_modulus, shear_modulus

WET = 0.5 * terzaghi.HEIGHT  # m, upper half of the column
TIMES = {0.05: 40, 0.197: 60, 0.5: 100, 1.0: 200}
MESHES = {"bricks": "hex8", "series": "fourier"}
_NAMES = {0: "U", 1: "p/q at the boundary"}
BOUNDARY = 2.0  # m, between sand and clay beside the caisson


def half_wet(model: Model | FourierModel) -> None:
    """Take the water out of the lower half of a column."""
    water, mesh = model.water, model.mesh
    assert water is not None
    elements = mesh.hexes if isinstance(model, Model) else mesh.quads[:, :4]  # type: ignore[union-attr]
    wet = mesh.nodes[elements].mean(axis=1)[:, -1] < WET
    depth = mesh.nodes[:, -1] if isinstance(model, Model) else mesh.nodes[mesh.corners, -1]  # type: ignore[union-attr]
    model.water = replace(water, wet=wet, fixed=water.fixed | (depth > WET * 1.001))  # type: ignore[assignment]


def column(name: str) -> dict[float, tuple[float, float]]:
    """U of the wet half and p/q at its base at the time factors."""
    newton, load, border = _bricks() if name == "bricks" else _series()
    stages = consolidation(load, consolidation_time(WET), TIMES)
    model = newton.system.model
    depth = model.mesh.nodes[:, -1] if name == "bricks" else model.mesh.nodes[model.mesh.corners, -1]
    base, unit = int(np.argmin(np.abs(depth - WET))), terzaghi.LOAD * WET / oedometric_modulus()
    found = []
    for state, _ in follow(newton, stages):
        pressure = float(np.atleast_1d(state.committed.pressure[base])[0])
        found.append((float(state.committed.border[border]) / unit - 1.0, pressure / terzaghi.LOAD))
    return dict(zip(TIMES, found[1:], strict=True))


def _bricks() -> tuple[Newton, Any, int]:
    newton = terzaghi.make_column(terzaghi.CELLS)
    half_wet(newton.system.model)
    return make_newton(newton.system.model), loaded([terzaghi.LOAD * terzaghi.WIDTH**2]), 0


def _series() -> tuple[Newton, Any, int]:
    newton = series_water.make_column()
    half_wet(newton.system.model)
    return series_water.newton_of(newton.system.model), series_water.plate_load(), 1


def sand_over_clay(discretisation: str, mode: str, **sections: Any) -> Scene:
    """Return the paper's caisson in 2 m of sand over clay in total stress."""
    mesh = {"preset": "coarse", "discretisation": discretisation} | sections.pop("mesh", {})
    mesh |= {"harmonics": 3} if discretisation == "fourier" and "harmonics" not in mesh else {}
    return tiny.sand(
        domain=PAPER, mesh=mesh, drainage={"mode": mode} | sections.pop("drainage", {}),
        output={"figures": False}, **sections,
    )  # fmt: skip


def stiffness(name: str, preset: str) -> float:
    """K_free in MN/m of sand at once over clay of the same G, both elastic."""
    clay = {"law": "tresca", "undrained_shear_strength": 1e8, "shear_modulus": shear_modulus(), "poisson_ratio": 0.4999}
    sand = {"law": "elastic", "young_modulus": YOUNG, "poisson_ratio": 0.3}
    mesh = {"preset": preset} | ({"harmonics": 1} if name == "series" else {})
    scene = sand_over_clay(
        MESHES[name], "undrained", mesh=mesh, drainage={"water_bulk_modulus": "incompressible"},
        caisson={"skirt_thickness": 1e-3},
        soil={"layers": [{"top": 0.0, **sand}, {"top": BOUNDARY, **clay}]},
        interface={
            "normal_stiffness": 1e11, "shear_stiffness": 1e11, "friction_coefficient": 5.0, "adhesion_factor": 1.0,
            "opening": "bonded",
        },
        paths=[{"name": "pull", "kind": "pull", "lateral_displacement": 1e-7}],
        solver={"first_step_fraction": 1.0, "max_step_fraction": 1.0},
    )  # fmt: skip
    k = compute(scene).recorded()["stiffness_initial"].values / 1e6
    return float(k[0, 0] - k[0, 2] * k[2, 0] / k[2, 2])


@cache
def push(name: str, mode: str, rate: float = 1e-4) -> xr.Dataset:
    """Pull the caisson by 5 mm in 2 m of sand over clay of su 30 kPa, at a rate (m/s)."""
    sand = {"top": 0.0, "friction_angle_initial": "auto", "young_modulus": 40e6, "K0": 0.5}
    clay = {"top": BOUNDARY, "law": "tresca", "undrained_shear_strength": 30e3, "rigidity_ratio": 200.0}
    sides = {"outside": "vented", "inside": "sealed", "lid": "sealed", "tip": "sealed"}
    path = {"name": "pull", "kind": "pull", "lateral_displacement": 5e-3} | (
        {"rate": rate} if mode == "coupled" else {}
    )
    scene = sand_over_clay(
        MESHES[name], mode, soil={"layers": [sand, clay]}, paths=[path],
        interface={"adhesion_factor": 0.65, "opening": sides},
    )  # fmt: skip
    return compute(scene).recorded()["paths/pull"].to_dataset()


@cache
def rows() -> tuple[Row, ...]:
    """Columns, and the stiffness of the caisson on `medium`."""
    return tuple(row for name in MESHES for row in (*column_rows(name), stiffness_row(name)))


@cache
def push_rows() -> tuple[Row, ...]:
    """Yielding pushes in sand over clay."""
    return tuple(row for name in MESHES for row in _push_rows(name))


def column_rows(name: str) -> list[Row]:
    """Consolidation of the wet half beside Terzaghi's series."""
    case, source = f"wet over dry column, {name}", "Terzaghi 1923, impervious base"
    return [
        Row(case, f"{_NAMES[k]} at T = {t:g}", "", values[k], terzaghi.closed_form(t)[k], source, 0.01)
        for t, values in column(name).items()
        for k in _NAMES
    ]


def stiffness_row(name: str) -> Row:
    """Undrained sand over total-stress clay of the same G beside the one undrained soil."""
    case = f"undrained sand over clay of the same G, {name}, medium"
    exact = caisson_water.UNDRAINED["K_free"]
    return Row(case, "K_free", "MN/m", stiffness(name, "medium"), exact, "axisymmetric FE, mixed, nu = 0.5", 0.02)


def _push_rows(name: str) -> list[Row]:
    case, source = f"2 m of sand over clay, pull, coarse, {name}", "each term on its own"
    ends = {mode: float(push(name, mode)["H"][-1]) for mode in ("drained", "undrained")}
    slow, fast, paced = (push(name, "coupled", rate) for rate in (1e-8, 10.0, 1e-4))
    moved = float((np.abs(paced["water_imbalance"][1:]) / paced["water_moved"][1:]).max())
    return [
        Row.error(case, "H at 1e-5 mm/s over drained, less 1", float(slow["H"][-1]) / ends["drained"] - 1.0,
                  "ours, drained", 1e-3),
        Row.error(case, "H at 10 m/s over undrained, less 1", float(fast["H"][-1]) / ends["undrained"] - 1.0,
                  "ours, undrained", 0.02),
        Row.error(case, "water: imbalance over what has moved, largest", moved, source, 1e-8),
        Row(case, "H at 0.1 mm/s over drained", "", float(paced["H"][-1]) / ends["drained"], 1.0, "shown", None),
        Row(case, "H undrained over drained", "", ends["undrained"] / ends["drained"], 1.0, "shown", None),
    ]  # fmt: skip
