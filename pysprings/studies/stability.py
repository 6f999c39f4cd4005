# SPDX-License-Identifier: MIT
"""The catalogue of stiff and extreme cases, run: how each one ends, at which cost and error; its picture.

The cases are the paper's caisson with a few values far from usual.
"""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from pydantic import ValidationError

from pysprings.core.columns import Column, Table
from pysprings.core.errors import Problem, PyspringsError, UserInputError
from pysprings.core.progress import Progress
from pysprings.core.text import suggestion
from pysprings.core.words import StopReason
from pysprings.core.workers import Task, run_tasks
from pysprings.full_model.compute import compute
from pysprings.full_model.run_record import RunRecord
from pysprings.results.plots.style import BLUE, GREEN, GREY, ORANGE, VERMILLION, new_figure, styled

if TYPE_CHECKING:
    from pysprings.scene.model import Scene


REACH = 20e-3  # m
_NOTHING: Mapping[str, Any] = MappingProxyType({})


@dataclass(frozen=True)
class Case:
    """One case: its group and name, what is stretched, and the changes to the paper's scene (SI, as in the scene).

    ``changes`` maps sections to values; ``path`` replaces values of the path, a pull at the lid centre to REACH.
    ``hard`` cases are also run on the ``paper`` mesh where one asks for them.
    """

    group: str
    name: str
    what: str
    changes: Mapping[str, Any] = field(default_factory=lambda: _NOTHING)
    path: Mapping[str, Any] = field(default_factory=lambda: _NOTHING)
    hard: bool = False

    @property
    def _clay(self) -> bool:
        """Whether all its ground is undrained clay, which shares weight and surcharge alone with the paper's sand."""
        from pysprings.scene.soils import SOIL_LAWS

        soil = self.changes.get("soil", {})
        usual = soil.get("yield_surface", "drucker-prager")
        layers = soil.get("layers") or soil.get("layer") or [{}]
        return all(SOIL_LAWS[layer.get("law") or usual].total_stress for layer in layers)

    def scene(self, mesh: str, reach: float = REACH, discretisation: str = "hex8") -> Scene:
        """Return the scene of the case, pulled as far as ``reach`` (m) where the case sets no displacement of its own.

        Raises UserInputError or ValueError where the input is refused.
        """
        from pysprings.scene.model import Scene
        from pysprings.scene.sections import PAPER, PAPER_SOIL

        coupled = self.changes.get("drainage", {}).get("mode", "drained") == "coupled"
        path = {"name": "path", "kind": "pull", "lateral_displacement": reach} | ({"rate": 0.05e-3} if coupled else {})
        path = {key: value for key, value in (path | dict(self.path)).items() if value is not None}
        output = {"interface_fields": False, "section": False, "figures": False}
        given: dict[str, Any] = {"title": self.what, "domain": PAPER, "output": output, "path": [path]}
        given |= {"soil": PAPER_SOIL, "mesh": {"preset": mesh, "discretisation": discretisation}}
        changed = {name: given.get(name, {}) | dict(values) for name, values in self.changes.items()}
        if self._clay:
            own = {key: PAPER_SOIL[key] for key in ("effective_unit_weight", "surcharge")}
            changed["soil"] = own | self.changes["soil"]
        return Scene.model_validate(given | changed)


_SOFT = {"top": 5e3, "gradient": 2e3}
_CLAY = {
    "yield_surface": "tresca", "undrained_shear_strength": _SOFT, "rigidity_ratio": 200.0,
    "effective_unit_weight": 6e3, "surcharge": 0.0,
}  # fmt: skip
_SIDES = ("outside", "inside", "lid", "tip")
_BUCKET = {
    "adhesion_factor": 0.65,
    "opening": {"outside": "vented", "inside": "sealed", "lid": "sealed", "tip": "sealed"},
}


def _clay(interface: Mapping[str, Any] | None = None, **soil: Any) -> dict[str, Any]:
    """Return soft clay with some values changed, and its interface."""
    return {"soil": {**_CLAY, **soil}, "interface": {**_BUCKET, **(interface or {})}}


def _layers(*layers: Mapping[str, Any], interface: Mapping[str, Any] | None = None, **soil: Any) -> dict[str, Any]:
    """Return layers, sand where they say nothing else."""
    changes = {"soil": {"layers": tuple(dict(each) for each in layers), **soil}}
    return changes | ({"interface": dict(interface)} if interface else {})


def _steps(depths: Sequence[float], moduli: Sequence[float]) -> tuple[dict[str, Any], ...]:
    return tuple({"top": z, "young_modulus": young} for z, young in zip(depths, moduli, strict=True))


_STIFF = {"law": "tresca", "undrained_shear_strength": 50e3, "rigidity_ratio": 200.0}
_WEAK = {"law": "tresca", "undrained_shear_strength": 1e3, "rigidity_ratio": 200.0}
_TWENTY = _steps([0.5 * n for n in range(20)], [20e6 * (1.0 + 9.0 * (n % 2)) for n in range(20)])

GROUND_CASES = (
    Case("ground", "layer-5cm", "5 cm of E 5 MPa at 2 m", _layers(
        *_steps([0.0, 2.0, 2.05], [200e6, 5e6, 200e6])), hard=True),
    Case("ground", "boundary-at-tip", "E 20 over 400 MPa at the tip", _layers(*_steps([0.0, 4.0], [20e6, 400e6]))),
    Case("ground", "boundary-1mm-below-tip", "E 20 over 400 MPa 1 mm below the tip", _layers(
        *_steps([0.0, 4.001], [20e6, 400e6])), hard=True),
    Case("ground", "twenty-layers", "twenty layers of 0.5 m, E 20 and 200 MPa", _layers(*_TWENTY)),
    Case("ground", "stiffness-1e4", "E 1 MPa over 10 GPa at 2 m", _layers(*_steps([0.0, 2.0], [1e6, 10e9])), hard=True),
    Case("ground", "stiff-crust", "E 1 GPa over 1 MPa at 1 m", _layers(*_steps([0.0, 1.0], [1e9, 1e6]))),
    Case("clay", "soft-clay", "su = 5 + 2 z kPa", _clay(), hard=True),
    Case("clay", "su-0-at-mudline", "su = 2 z kPa", _clay(undrained_shear_strength={"top": 0.0, "gradient": 2e3}),
         hard=True),
    Case("clay", "su-1kPa-over-1MPa", "su 1 kPa over 1 MPa at 2 m", _layers(
        {"top": 0.0, **_WEAK}, {"top": 2.0, **_WEAK, "undrained_shear_strength": 1e6}, interface=_BUCKET), hard=True),
    Case("clay", "alpha-0", "alpha = 0", _clay({"adhesion_factor": 0.0})),
    Case("clay", "alpha-1-bonded", "alpha = 1, bonded", _clay({"adhesion_factor": 1.0, "opening": "bonded"})),
    Case("clay", "vented", "vented everywhere", _clay({"opening": "vented"})),
    Case("clay", "nu-0.4999", "nu = 0.4999", _clay(poisson_ratio=0.4999), hard=True),
    Case("clay", "von-mises", "von Mises", _clay(yield_surface="von-mises")),
    Case("clay", "half-strength-at-5-percent", "half of su at a shear strain of 5 %", _clay(
        strain_at_half_strength=0.05)),
    Case("clay", "rigidity-1e4", "G/su = 10,000", _clay(rigidity_ratio=1e4)),
    Case("clay", "clay-K0-0.5", "K0 = 0.5", _clay(K0=0.5)),
    Case("clay", "api", "alpha of API RP 2GEO", _clay({"adhesion_factor": "api"})),
    Case("clay", "clay-push-0.8m", "pull to a tenth of D", _clay(), {"lateral_displacement": 0.8}, hard=True),
    Case("clay", "clay-beyond-capacity", "load 20 MN at mudline", _clay(), {
        "kind": "load", "lateral_displacement": None, "lateral_force": 20e6}),
    Case("clay", "clay-pull-out", "pulled out by 0.2 m", _clay(), {
        "kind": "vertical", "lateral_displacement": None, "vertical_displacement": -0.2}),
    Case("clay", "sand-over-clay", "2 m of sand over clay of su 50 kPa", _layers(
        {"top": 0.0}, {"top": 2.0, **_STIFF}, interface=_BUCKET), hard=True),
    Case("clay", "sand-over-clay-undrained", "2 m of undrained sand over clay", _layers(
        {"top": 0.0}, {"top": 2.0, **_STIFF}, interface=_BUCKET) | {"drainage": {"mode": "undrained"}}, hard=True),
    Case("clay", "sand-over-clay-coupled", "2 m of coupled sand over clay", _layers(
        {"top": 0.0}, {"top": 2.0, **_STIFF}, interface=_BUCKET) | {"drainage": {"mode": "coupled"}}),
    Case("clay", "clay-over-coupled-sand", "clay of su 5 kPa over confined coupled sand", _layers(
        {"top": 0.0, **_WEAK, "undrained_shear_strength": 5e3}, {"top": 2.0}, interface=_BUCKET) | {
        "drainage": {"mode": "coupled"}}),
    Case("ground", "drained-seam", "10 cm that drain, in undrained sand at 2 m", _layers(
        {"top": 0.0}, {"top": 2.0, "drainage": "drained"}, {"top": 2.1}) | {"drainage": {"mode": "undrained"}}),
    Case("clay", "clay-over-sand", "2 m of clay of su 1 kPa over sand", _layers(
        {"top": 0.0, **_WEAK}, {"top": 2.0}, interface=_BUCKET)),
    Case("clay", "clay-with-friction", "su beside a friction angle", _clay(friction_angle_final=0.6)),
    Case("clay", "weightless-api", "alpha of API RP 2GEO without weight", _clay(
        {"adhesion_factor": "api"}, effective_unit_weight=0.0)),
)  # fmt: skip


_DEG = math.pi / 180.0


def _penalty(normal: float, shear: float) -> dict[str, Any]:
    return {"interface": {"normal_stiffness": normal, "shear_stiffness": shear}}


def _water(**changes: Any) -> dict[str, Any]:
    return {"drainage": {"mode": "coupled"}, **changes}


def _caisson(length: float, radius: float, depth: float) -> dict[str, Any]:
    return {"caisson": {"skirt_length": length}, "domain": {"radius": radius, "depth": depth}}


def _turns(n: int, amplitude: float) -> tuple[str, ...]:
    """Return cycles of +- amplitude (mm) and back to zero, for a path that starts at +amplitude."""
    there_and_back = (f"{-amplitude:g} mm", f"{amplitude:g} mm")
    return (*there_and_back * n, "0 mm")


CASES = (
    Case("as it is", "paper", "the paper's caisson, drained", hard=True),
    Case("as it is", "paper-coupled", "the paper's caisson, 0.05 mm/s", _water(), hard=True),
    Case("penalty", "penalty-1e7", "K_N = K_T = 1e7 N/m3", _penalty(1e7, 1e7)),
    Case("penalty", "penalty-1e8", "K_N = K_T = 1e8 N/m3", _penalty(1e8, 1e8)),
    Case("penalty", "penalty-1e11", "K_N = K_T = 1e11 N/m3", _penalty(1e11, 1e11)),
    Case("penalty", "penalty-3e11", "K_N = K_T = 3e11 N/m3", _penalty(3e11, 3e11)),
    Case("penalty", "penalty-1e12", "K_N = K_T = 1e12 N/m3", _penalty(1e12, 1e12), hard=True),
    Case("penalty", "penalty-1e14", "K_N = K_T = 1e14 N/m3", _penalty(1e14, 1e14), hard=True),
    Case("penalty", "normal-over-shear", "K_N = 1e12, K_T = 1e8 N/m3", _penalty(1e12, 1e8)),
    Case("penalty", "shear-over-normal", "K_N = 1e8, K_T = 1e12 N/m3", _penalty(1e8, 1e12)),
    Case("penalty", "penalty-1e12-coupled", "K_N = K_T = 1e12 N/m3, coupled", _water(**_penalty(1e12, 1e12))),
    Case("friction", "smooth", "mu = 0", {"interface": {"friction_coefficient": 0.0}}, hard=True),
    Case("friction", "almost-smooth", "mu = 1e-4", {"interface": {"friction_coefficient": 1e-4}}),
    Case("friction", "rough", "mu = 2", {"interface": {"friction_coefficient": 2.0}}, hard=True),
    Case("soil", "phi-45", "phi_f = 45 deg", {"soil": {"friction_angle_final": 45 * _DEG}}),
    Case("soil", "no-hardening", "phi_i = phi_f = 30 deg", {"soil": {"friction_angle_initial": 30 * _DEG}}),
    Case("soil", "hardening-1e-6", "B_phi = 1e-6", {"soil": {"hardening_parameter": 1e-6}}),
    Case("soil", "hardening-1", "B_phi = 1", {"soil": {"hardening_parameter": 1.0}}),
    Case("soil", "associated", "psi = phi_f = 30 deg", {"soil": {"dilation_angle": 30 * _DEG}}, hard=True),
    Case("soil", "contractant", "psi = -5 deg", {"soil": {"dilation_angle": -5 * _DEG}}),
    Case("soil", "no-stress-at-mudline", "c = 0, surcharge = 0", {"soil": {"surcharge": 0.0}}, hard=True),
    Case("soil", "cohesion-1MPa", "c = 1 MPa", {"soil": {"cohesion": 1e6}}),
    Case("soil", "soft", "E = 1 MPa", {"soil": {"young_modulus": 1e6}}),
    Case("soil", "rock", "E = 100 GPa", {"soil": {"young_modulus": 100e9}}),
    Case("soil", "nu-0", "nu = 0", {"soil": {"poisson_ratio": 0.0}}),
    Case("soil", "nu-0.499", "nu = 0.499", {"soil": {"poisson_ratio": 0.499}}, hard=True),
    Case("soil", "K0-0.3", "K0 = 0.3 at phi_i = 5 deg", {"soil": {"K0": 0.3}}),
    Case("soil", "K0-0.3-strong", "K0 = 0.3 at phi_i = phi_f = 40 deg", {
        "soil": {"K0": 0.3, "friction_angle_initial": 40 * _DEG, "friction_angle_final": 40 * _DEG}}),
    Case("soil", "K0-3", "K0 = 3 at phi_i = 5 deg", {"soil": {"K0": 3.0}}),
    Case("soil", "K0-3-strong", "K0 = 3 at phi_i = phi_f = 30 deg", {
        "soil": {"K0": 3.0, "friction_angle_initial": 30 * _DEG}}),
    Case("soil", "van-eekelen", "Van Eekelen's surface", {"soil": {"yield_surface": "van-eekelen"}}, hard=True),
    Case("soil", "van-eekelen-dilates", "Van Eekelen's surface, psi = 10 deg", {
        "soil": {"yield_surface": "van-eekelen", "dilation_angle": 10 * _DEG}}),
    Case("water", "k-1e-14", "k = 1e-14 m/s", _water(soil={"hydraulic_conductivity": 1e-14}), hard=True),
    Case("water", "k-1", "k = 1 m/s", _water(soil={"hydraulic_conductivity": 1.0})),
    Case("water", "rate-1e-10", "1e-10 m/s", _water(), {"rate": 1e-10}),
    Case("water", "rate-1", "1 m/s", _water(), {"rate": 1.0}),
    Case("water", "aperture-1e-9", "D_0 = 1e-9 m", _water(interface={"residual_aperture": 1e-9})),
    Case("water", "aperture-1e-3", "D_0 = 1e-3 m", _water(interface={"residual_aperture": 1e-3})),
    Case("water", "transfer-1e-18", "T_w = 1e-18 m/(Pa s)", _water(interface={"transversal_conductivity": 1e-18}),
         hard=True),
    Case("water", "transfer-1e-10", "T_w = 1e-10 m/(Pa s)", _water(interface={"transversal_conductivity": 1e-10})),
    Case("water", "transfer-1e-3", "T_w = 1e-3 m/(Pa s)", _water(interface={"transversal_conductivity": 1e-3})),
    Case("water", "incompressible", "incompressible water, nu = 0.499",
         {"drainage": {"mode": "coupled", "water_bulk_modulus": "incompressible"}, "soil": {"poisson_ratio": 0.499}}),
    Case("water", "undrained", "undrained", {"drainage": {"mode": "undrained"}}),
    Case("water", "first-step-1e-9s", "first step 1e-9 s", _water(solver={"first_step_fraction": 2.5e-12})),
    Case("water", "first-step-1000s", "first step 1,000 s", _water(solver={"first_step_fraction": 0.05}),
         {"rate": 1e-6}),
    Case("water", "shallow-sea", "1 m/s in 1 m of water", {"drainage": {"mode": "coupled", "water_depth": 1.0}},
         {"rate": 1.0}),
    Case("shape", "L/D-0.1", "L/D 0.1", _caisson(0.78, 24.0, 12.0)),
    Case("shape", "L/D-1", "L/D 1", _caisson(7.8, 24.0, 20.0)),
    Case("shape", "L/D-3", "L/D 3", _caisson(23.4, 40.0, 50.0)),
    Case("shape", "skirt-5mm", "skirt 5 mm thick", {"caisson": {"skirt_thickness": 5e-3}}, hard=True),
    Case("shape", "skirt-0.5m", "skirt 0.5 m thick", {"caisson": {"skirt_thickness": 0.5}}),
    Case("shape", "tight-domain", "domain 4.8 m x 4.5 m", {"domain": {"radius": 4.8, "depth": 4.5}}),
    Case("shape", "needles", "8 cells around, domain of 200 m", {
        "domain": {"radius": 200.0, "depth": 12.0}, "mesh": {"azimuth": 8}}),
    Case("shape", "pancakes", "domain 5 m x 200 m", {"domain": {"radius": 5.0, "depth": 200.0}}),
    Case("path", "push-0.5m", "pull to 0.5 m", {}, {"lateral_displacement": 0.5}, hard=True),
    Case("path", "reversal", "20 mm, back to -20 mm", {}, {"then": ("-20 mm",), "role": "held-back"}),
    Case("path", "ten-cycles", "ten cycles of 5 mm", {},
         {"lateral_displacement": 5e-3, "then": _turns(10, 5.0), "role": "held-back"}, hard=True),
    Case("path", "ten-cycles-coupled", "ten cycles of 5 mm, 0.5 mm/s", _water(), {
        "lateral_displacement": 5e-3, "rate": 0.5e-3, "role": "held-back",
        "then": tuple(f"{part} at 0.5 mm/s" for part in _turns(10, 5.0))}),
    Case("path", "beyond-capacity", "load 20 MN at mudline", {}, {
        "kind": "load", "lateral_displacement": None, "lateral_force": 20e6}, hard=True),
    Case("path", "pull-out", "vertical load of -20 MN, upwards", {"caisson": {"vertical_load": -20e6}}),
    Case("path", "push-down", "vertical load of 200 MN", {"caisson": {"vertical_load": 200e6}}),
    Case("path", "high-arm", "load 1,000 m above mudline", {}, {"arm": 1000.0}),
    Case("path", "rotation", "rotation of 1 deg", {}, {
        "kind": "rotation", "lateral_displacement": None, "rotation": _DEG}),
    *GROUND_CASES,
)  # fmt: skip


COLOURS = {"converged": BLUE, "warned": GREEN, "stopped": ORANGE, "refused": GREY, "unexplained": VERMILLION}
MARKERS = {"converged": "o", "warned": "D", "stopped": "s", "refused": "x", "unexplained": "*"}
_ROW = 0.21  # inches


@styled
def catalogue(table: pd.DataFrame) -> Figure:
    """Draw the table of `pysprings.studies.stability.run_cases`: a row a case, from the first at the top."""
    figure = new_figure(10.0, 1.6 + _ROW * len(table))
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=(1.0, 1.0))
    row = np.arange(len(table))
    _iterations(left, table, row)
    _cut_backs(right, table, row)
    left.set_yticks(row, [f"{case}" for case in table["case"]], fontsize=8)
    left.set_ylim(len(table) - 0.5, -0.5)
    for axes in (left, right):
        for start in _group_starts(table):
            axes.axhline(start - 0.5, color=GREY, lw=0.6)
    used = [outcome for outcome in COLOURS if (table["outcome"] == outcome).any()]
    handles = [Line2D([], [], color=COLOURS[o], marker=MARKERS[o], ls="", label=o) for o in used]
    figure.legend(handles=handles, loc="outside upper right", ncols=len(handles))
    figure.suptitle("Stiff and extreme cases", x=0.01, ha="left")
    return figure


def _iterations(axes: Axes, table: pd.DataFrame, row: np.ndarray) -> None:
    """Draw median (mark) and largest number (end of the line) of Newton iterations of the increments."""
    columns = (table[name].tolist() for name in ("outcome", "median_iterations", "max_iterations", "increments"))
    for y, outcome, median, most, increments in zip(row, *columns, strict=True):
        if increments:
            axes.plot([median, most], [y, y], color=COLOURS[outcome], lw=1.0)
        axes.plot(median if increments else 0.0, y, MARKERS[outcome], color=COLOURS[outcome], ms=5)
    axes.set_xlim(-0.5, None)
    axes.set_xlabel("Newton iterations of an increment: median, most")


def _cut_backs(axes: Axes, table: pd.DataFrame, row: np.ndarray) -> None:
    share = 100.0 * table["cut_backs"] / table["increments"].clip(lower=1)
    axes.barh(row, share.clip(upper=100.0), color=[COLOURS[outcome] for outcome in table["outcome"]], height=0.6)
    for y, cuts, increments in zip(row, table["cut_backs"].tolist(), table["increments"].tolist(), strict=True):
        if increments:
            axes.text(min(share.iloc[y], 100.0) + 1.0, y, f"{cuts} of {increments}", va="center", fontsize=7)
    axes.set_xlim(0.0, 118.0)
    axes.set_xlabel("steps cut, % of the increments")


def _group_starts(table: pd.DataFrame) -> list[int]:
    """Return the rows where another group of cases begins."""
    group = table["group"].to_numpy()
    return [int(k) + 1 for k in np.flatnonzero(group[1:] != group[:-1])]


CONVERGED, WARNED, STOPPED, REFUSED, UNEXPLAINED = "converged", "warned", "stopped", "refused", "unexplained"
OUTCOMES = (CONVERGED, WARNED, STOPPED, REFUSED, UNEXPLAINED)


@dataclass(frozen=True)
class Outcome:
    """How a case ended.

    ``outcome`` is one of OUTCOMES, ``detail`` the warning, the named reason, or the message of the refusal. ``u_mm``
    and ``H_kN`` are the end of what converged. Imbalances are relative to the largest term of the energy, and to the
    water that has moved; ``condition`` is an estimate from below.
    """

    group: str
    case: str
    what: str
    outcome: str
    detail: str = ""
    u_mm: float | None = None
    H_kN: float | None = None
    increments: int = 0
    cut_backs: int = 0
    median_iterations: float | None = None
    max_iterations: int | None = None
    worst_residual: float | None = None
    energy_imbalance: float | None = None
    water_imbalance: float | None = None
    condition: float | None = None
    factorisations: int = 0
    wall_s: float = 0.0


def cases_named(names: Sequence[str]) -> list[Case]:
    """Return the cases of these names or groups, all where none is given; UserInputError names what there is."""
    known = {case.name for case in CASES} | {case.group for case in CASES} | {"hard"}
    unknown = [name for name in names if name not in known]
    if unknown:
        groups = ", ".join(dict.fromkeys(case.group for case in CASES))
        text = f"; there are {', '.join(case.name for case in CASES)}; and the groups {groups}, hard"
        raise UserInputError(
            [Problem(key=f"--case {name}", message=f"no such case{suggestion(name, known)}{text}") for name in unknown]
        )
    requested = set(names)
    return [c for c in CASES if not requested or {c.name, c.group} & requested or (c.hard and "hard" in requested)]


def run_case(case: Case, mesh: str = "coarse", refinement: float = 1.0, reach: float = REACH) -> Outcome:
    """Run one case; errors that a scene can cause become an outcome, any other is a bug and is raised."""
    start = time.perf_counter()
    head: dict[str, Any] = {"group": case.group, "case": case.name, "what": case.what}
    try:
        scene = case.scene(mesh, reach).replace(mesh={"refinement": refinement})
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a run's own warnings are in its record
            result = compute(scene)
    except (UserInputError, ValidationError) as error:
        return Outcome(**head, outcome=REFUSED, detail=_refusal(error))
    except PyspringsError as error:
        return Outcome(**head, outcome=UNEXPLAINED, detail=str(error), wall_s=time.perf_counter() - start)
    if result.record.stopped_by is StopReason.INTERRUPTED:
        raise KeyboardInterrupt
    return Outcome(
        **head, **_ending(result.record), **_figures(result.record), wall_s=round(time.perf_counter() - start, 1)
    )


def run_cases(
    cases: Iterable[Case], mesh: str, refinement: float = 1.0, report: Callable[[Outcome], None] = lambda _: None,
    reach: float = REACH, jobs: int = 1,
) -> pd.DataFrame:  # fmt: skip
    """Run cases, to ``reach`` (m) where they set no displacement; return a row each (see `Outcome`).

    ``jobs`` are worker processes (1: none), in which cases share the machine: their times grow. ``report`` is given the
    rows in their order. KeyboardInterrupt passes through: it has what ended before.
    """
    tasks = [Task(case.name, case_in_worker, (case.name, mesh, refinement, reach)) for case in cases]
    ended: dict[str, Outcome] = {}
    rows: list[Outcome] = []

    def done(task: Task, answer: Outcome | Exception) -> None:
        if isinstance(answer, Exception):
            raise answer
        ended[task.name] = answer
        while len(rows) < len(tasks) and tasks[len(rows)].name in ended:
            rows.append(ended[tasks[len(rows)].name])
            report(rows[-1])

    run_tasks(tasks, jobs, done)
    return table_of(rows)


def case_in_worker(name: str, mesh: str, refinement: float, reach: float, _: Progress) -> Outcome:
    """Run the case of a name as a task (`core.workers`)."""
    (case,) = [case for case in CASES if case.name == name]
    return run_case(case, mesh, refinement, reach)


def table_of(rows: Iterable[Outcome]) -> pd.DataFrame:
    """Return outcomes as a table."""
    return pd.DataFrame([asdict(row) for row in rows], columns=[each.name for each in fields(Outcome)])


def summary(table: pd.DataFrame) -> dict[str, Any]:
    """Return counts of the outcomes; median iterations and share of cut-backs over the cases that reached their end."""
    done = table[table["outcome"].isin((CONVERGED, WARNED))]
    increments = int(done["increments"].sum())
    return {
        **{outcome: int((table["outcome"] == outcome).sum()) for outcome in OUTCOMES},
        "median_iterations": float(done["median_iterations"].median()) if len(done) else None,
        "increments": increments,
        "cut_backs": int(done["cut_backs"].sum()),
        "cut_backs_over_increments": float(done["cut_backs"].sum() / increments) if increments else None,
        "worst_energy_imbalance": float(done["energy_imbalance"].max()) if len(done) else None,
    }


def _refusal(error: UserInputError | ValidationError) -> str:
    if isinstance(error, ValidationError):
        errors = error.errors(include_url=False, include_context=False, include_input=False)
        return "; ".join(
            f"{'.'.join(str(part) for part in each['loc'])}: {each['msg']}".lstrip(": ") for each in errors
        )
    return "\n".join(error.lines)


def _ending(record: RunRecord) -> dict[str, Any]:
    """Return outcome and detail of a run that wrote a record."""
    if record.reached:
        detail = "; ".join(record.warnings)
        return {"outcome": WARNED if detail else CONVERGED, "detail": detail}
    named = any(reason.explains for reason in record.reasons)
    return {"outcome": STOPPED if named else UNEXPLAINED, "detail": "; ".join(record.short)}


def _figures(record: RunRecord) -> dict[str, Any]:
    solver = record.solver
    figures: dict[str, Any] = {"condition": solver.condition_estimate, "factorisations": solver.factorisations}
    for path in record.paths.values():
        figures |= {
            "u_mm": 1e3 * path.end["u"],
            "H_kN": 1e-3 * path.end["H"],
            "increments": path.increments,
            "cut_backs": path.cut_backs,
            "median_iterations": path.median_iterations,
            "max_iterations": path.max_iterations,
            "worst_residual": path.worst_residual,
            "energy_imbalance": path.energy["imbalance_over_largest_term"],
            "water_imbalance": (path.water or {}).get("worst_imbalance_over_exchanged"),
        }
    return figures


COLUMNS = (
    Column("case", "case", words=True),
    Column("outcome", "outcome", words=True),
    Column("u [mm]", "u_mm", ".2f"),
    Column("H [kN]", "H_kN", ",.0f"),
    Column("increments", "increments", "d"),
    Column("cut", "cut_backs", "d"),
    Column("median", "median_iterations", ".0f"),
    Column("most", "max_iterations", ".0f"),
    Column("residual", "worst_residual", ".0e"),
    Column("energy", "energy_imbalance", ".0e"),
    Column("water", "water_imbalance", ".0e"),
    Column("condition", "condition", ".0e"),
    Column("wall [s]", "wall_s", ".0f"),
)
_DETAIL = Column("warning or reason", "detail", words=True)
_WIDTHS = (22, 11, *(max(9, len(column.head)) for column in COLUMNS[2:]))  # lines are printed one by one


def heading() -> str:
    """Return the two head lines."""
    return _padded([column.head for column in COLUMNS]) + "\n" + "  ".join("-" * width for width in _WIDTHS)


def line(row: dict[str, Any]) -> str:
    """Return one case, with its warning or reason below, if any."""
    text = _padded([column.cell(row) for column in COLUMNS])
    return f"{text}\n    {row['detail']}" if row["detail"] else text


def closing(summary: dict[str, Any]) -> str:
    """Return the counts, and two measures of the difficulty of the cases."""
    counts = ", ".join(
        f"{summary[name]} {name}" for name in ("converged", "warned", "stopped", "refused", "unexplained")
    )
    if not summary["increments"]:
        return counts
    share = 100.0 * summary["cut_backs_over_increments"]
    return (
        f"{counts}\nover the cases that reached their end: median of iterations {summary['median_iterations']:.0f}, "
        f"{summary['cut_backs']} steps cut in {summary['increments']} increments ({share:.0f} %), "
        f"energy imbalance at most {summary['worst_energy_imbalance']:.0e}"
    )


def to_markdown(table: pd.DataFrame) -> str:
    """Return the table for a document, one line a case."""
    return Table.of((*COLUMNS, _DETAIL), table.to_dict("records")).markdown()


def _padded(cells: list[str]) -> str:
    sides = [str.ljust if column.words else str.rjust for column in COLUMNS]
    return "  ".join(side(cell, width) for side, cell, width in zip(sides, cells, _WIDTHS, strict=True)).rstrip()
