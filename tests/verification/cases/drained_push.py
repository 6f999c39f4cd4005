# SPDX-License-Identifier: MIT
"""The paper's drained caisson pulled at the lid centre: balance, front stress, friction, steps (coarse mesh).

Balance is asked of three figures that come about apart from each other: the load that Newton needed to impose the
displacement, the springs that the tool stores (p, m and t by depth, tip and lid), and the force on the rim of the
domain, integrated from the soil stresses by a plain loop here.
"""

from functools import cache

import numpy as np
import xarray as xr

from fe_engine.elements import hex8
from fe_engine.model import Model
from fe_engine.state import Fields
from tests.verification.pushes import Push, Stop, push, push_scene
from tests.verification.rows import Row

END = 2.5e-3
STOPS = (0.5e-3, 1.0e-3)
_PAPER = "Cerfontaine et al. 2018"
_EXACT = "equilibrium"
_SUPERLINEAR = "1 is linear, 2 quadratic; friction has kinks"
_CASE = "drained push, coarse mesh"


@cache
def design_push() -> Push:
    """The push that the cases share: default settings, to 2.5 mm."""
    return push(push_scene(END, STOPS))


@cache
def long_push() -> Push:
    """The same to 5 mm, where the skirt's inner edge begins to open."""
    return push(push_scene(5.0e-3, (END,)))


@cache
def first_increment() -> Push:
    """0.25 mm in one increment from the initial state, where first yield and first slip come together."""
    return push(push_scene(0.25e-3, solver={"first_step_fraction": 1.0, "max_step_fraction": 1.0}))


@cache
def rows() -> tuple[Row, ...]:
    """Balance, front stress, iterations and the first increment."""
    run = design_push()
    data = run.dataset()
    return (*_balance(run, data), *_front(data), *_newton(run), *_one_increment())


@cache
def slow_rows() -> tuple[Row, ...]:
    """Runs beside the design push: half and quarter steps, and no friction."""
    return (*_steps(), *_friction())


def _balance(run: Push, data: xr.Dataset) -> list[Row]:
    """Largest error of H, V and M over all stops, relative to the applied H (and H L for the moment)."""
    stops = [run.at[u] for u in sorted(run.at)]
    springs = from_springs(data)[1:] - [0.0, 2.0 * run.built.balanced_load, 0.0]
    rim = np.array([on_the_rim(run.built.model, stop.state) for stop in stops])
    applied = np.array([stop.load for stop in stops])
    length = float(data["depth"][-1])
    scale = applied[:, :1] * [1.0, 1.0, length]
    case, last = "balance at 0.5, 1, 2.5 mm, coarse mesh", springs[-1, 0] / 1e6
    found = [Row(case, "p(z) dz + tip + lid at 2.5 mm", "MN", last, applied[-1, 0] / 1e6, "applied load", 1e-6)]
    for name, ours in (("springs", springs), ("domain's rim", rim)):
        error = np.abs((ours - applied) / scale).max(axis=0)
        for key, label, value in zip("HVM", ("H", "H", "H L"), error, strict=True):
            found.append(Row.error(case, f"{key} of {name} less applied, over {label}", float(value), _EXACT, 1e-6))
    return found


def from_springs(data: xr.Dataset) -> np.ndarray:
    """H, V, M (step, 3) of the whole caisson about the lid centre, summed from the stored springs."""
    depth = data["depth"]
    height = data["depth_bounds"].diff("bound").isel(bound=0)
    each = data[["t", "m"]].sum("side")
    length = float(depth[-1])
    lateral = (data["p"] * height).sum("depth") + data["H_tip"] + data["H_lid"]
    vertical = (each["t"] * height).sum("depth") + data["V_tip"] + data["V_lid"]
    moment = ((each["m"] - data["p"] * depth) * height).sum("depth")
    moment = moment - length * data["H_tip"] + data["M_tip"] + data["M_lid"]
    return np.stack([lateral.values, vertical.values, moment.values], axis=1)


def on_the_rim(model: Model, state: Fields) -> np.ndarray:
    """H, V, M (3,) that the soil hands on to the side and bottom of the whole domain: int B^T d(sigma) dV there."""
    mesh = model.mesh
    gradient, volume, mean = hex8.geometry(mesh.nodes, mesh.hexes)
    xx, yy, zz, xy, yz, zx = np.moveaxis(state.stress - model.initial_stress, -1, 0)
    tensor = np.stack([np.stack(row, axis=-1) for row in ((xx, xy, zx), (xy, yy, yz), (zx, yz, zz))], axis=-2)
    pressure = (xx + yy + zz) / 3.0
    force = np.einsum("eg,egij,egaj->eai", volume, tensor, gradient)
    # mean dilatation: the volumetric part works on the element's mean gradient (Hughes 1980)
    force += np.einsum("eg,eg,egai->eai", volume, pressure, mean[:, None] - gradient)
    nodal = np.zeros(mesh.nodes.shape)
    np.add.at(nodal, mesh.hexes, force)
    rim = np.unique(np.concatenate([mesh.node_sets["side"], mesh.node_sets["bottom"]]))
    x, _, z = mesh.nodes[rim].T
    fx, _, fz = -2.0 * nodal[rim].T
    return np.array([fx.sum(), fz.sum(), np.sum(fx * z - fz * x)])


def _front(data: xr.Dataset) -> list[Row]:
    """Front normal effective stress at 2.5 mm over initial; mudline and tip are singular and not judged."""
    stress = data["normal_effective_stress"].sel(side="outside").isel(azimuth=0)
    ratio = stress.isel(step=-1) / stress.isel(step=0)
    depth, ends = data["depth"].values, (0, data.sizes["depth"] - 1)
    return [
        Row(
            _CASE, f"front p'_N at 2.5 mm over initial, depth {z:.2f} m", "", float(value), 1.5,
            f"{_PAPER}: about 50 % above", None if k in ends else 0.2,
        )
        for k, (z, value) in enumerate(zip(depth, ratio.values, strict=True))
    ]  # fmt: skip


def _newton(run: Push) -> list[Row]:
    """Iterations per increment, cut-backs, and the order of the last three residuals of each increment."""
    orders = []
    for step in run.steps:
        e = [row["residual"] for row in step.increment.record[-3:]]
        if len(e) == 3 and 0.0 < e[2] < e[1] < e[0] < 0.1:
            orders.append(np.log(e[2] / e[1]) / np.log(e[1] / e[0]))
    median = float(np.median([step.increment.iterations for step in run.steps]))
    return [
        Row.at_most(_CASE, "median iterations per increment", median, 5.0, "aim of the project"),
        Row.at_most(_CASE, "cut-backs", len(run.driver.given_up), 0.0, "aim of the project"),
        Row.at_least(_CASE, "order of the last iterations, median", float(np.median(orders)), 1.3, _SUPERLINEAR),
    ]


def _one_increment() -> list[Row]:
    run = first_increment()
    case = "first increment, 0.25 mm in one step"
    return [
        Row.error(case, "cut-backs", len(run.driver.given_up), "converges at default settings", 0.0),
        Row.at_most(case, "iterations", run.steps[0].increment.iterations, 25.0, "a plain prototype"),
    ]


def _steps() -> list[Row]:
    """Load, heave and rotation at 2.5 mm with the largest step halved twice."""
    halved = [push(push_scene(END, STOPS, solver={"max_step_fraction": largest})) for largest in (0.025, 0.0125)]
    runs = [design_push(), *halved]
    values = np.array([[run.end.load[0], *run.end.state.border[1:]] for run in runs])
    case = "drained push, steps of at most 5 %"
    names = ("H at 2.5 mm", "heave at 2.5 mm", "rotation at 2.5 mm")
    units, scales = ("MN", "mm", "mrad"), (1e-6, 1e3, 1e3)
    found = []
    for k, (name, unit, scale) in enumerate(zip(names, units, scales, strict=True)):
        ours, half, quarter = scale * values[:, k]
        found.append(Row(case, name, unit, ours, half, "ours, steps halved", 2e-3))
        found.append(Row(case, name, unit, ours, quarter, "ours, steps halved twice", 4e-3))
    return found


def _friction() -> list[Row]:
    """Load without friction over load with mu = 0.5."""
    smooth = push(push_scene(5.0e-3, (END,), interface={"friction_coefficient": 0.0}))
    rough = long_push()
    return [
        Row(_CASE, f"H(mu = 0)/H(mu = 0.5) at {1e3 * u:g} mm", "", _lateral(smooth.at[u]) / _lateral(rough.at[u]), 0.5,
            f"{_PAPER}: half", tolerance)
        for u, tolerance in ((END, None), (5.0e-3, 0.1))
    ]  # fmt: skip


def _lateral(stop: Stop) -> float:
    return float(stop.load[0])
