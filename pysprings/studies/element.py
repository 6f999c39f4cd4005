# SPDX-License-Identifier: MIT
"""Laboratory tests on a layer of a scene: tables of data, keys fitted to them, curves, their files and picture.

A fit is least squares with the bounds of each key (scipy, trust region).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pysprings.core.arrays import Array
from pysprings.core.errors import refused as refused_argument
from pysprings.core.storage import write_text
from pysprings.core.tables import Column, Table, one_table
from pysprings.core.tables.headings import ANY, TEXT
from pysprings.core.units import read, si_of
from pysprings.core.words import ElementTest
from pysprings.model.element import KINDS, TOTAL, Curve, drainage_of, element_test, specimen
from pysprings.results.plots.files import redraw
from pysprings.results.plots.style import BLUE, GREEN, KPA, ORANGE, PURPLE, VERMILLION, new_figure, plain, styled
from pysprings.scene.by_depth import ByDepth
from pysprings.scene.fields import Interval
from pysprings.scene.ground import Stratum
from pysprings.scene.sections import plain_field
from pysprings.scene.soils import LAW_KEYS, SOIL_LAWS

# kind of test -> its strain, and what is measured over it: the first is needed, a fit uses those that are there
MEASURED: dict[ElementTest, tuple[str, tuple[str, ...]]] = {
    "triaxial": ("axial_strain", ("q_Pa", "volumetric_strain", "pore_pressure_Pa")),
    "triaxial-extension": ("axial_strain", ("q_Pa", "volumetric_strain", "pore_pressure_Pa")),
    "dss": ("shear_strain", ("shear_stress_Pa", "volumetric_strain", "pore_pressure_Pa", "axial_stress_Pa")),
    "oedometer": ("axial_strain", ("axial_stress_Pa",)),
}
_PASCALS = {
    "q_Pa": ("q", "deviator stress", "deviatoric stress"), "p_Pa": ("p", "p'", "mean effective stress"),
    "shear_stress_Pa": ("tau", "shear stress"), "pore_pressure_Pa": ("u", "pore pressure", "excess pore pressure"),
    "axial_stress_Pa": ("vertical stress", "axial stress", "vertical effective stress"),
    "radial_stress_Pa": ("radial stress",),
    "stress_Pa": ("stress", "consolidation stress", "cell pressure", "confining pressure"),
}  # fmt: skip
_STRAINS = {
    "axial_strain": ("axial strain", "eps1", "epsa", "vertical strain"), "shear_strain": ("shear strain", "gamma"),
    "volumetric_strain": ("volumetric strain", "epsv", "volume strain"),
}  # fmt: skip
COLUMNS = (
    Column("test", TEXT, ("name",)),
    *(Column(name, "Pa", names, "kPa") for name, names in _PASCALS.items()),
    *(Column(name, "1", names, percent=0.01) for name, names in _STRAINS.items()),
    *(Column(name, ANY, skipped="follows from others") for name in ("e", "void ratio", "step", "drainage")),
    Column("mobilised_angle_rad", "rad", ("mobilised angle",), skipped="follows from others"),
)


@dataclass(frozen=True)
class LabTest:
    """A measured test: its name, its consolidation stress (Pa), and columns in SI by their names in `MEASURED`."""

    name: str
    stress: float
    columns: Mapping[str, Array]

    def last_strain(self, kind: ElementTest) -> float:
        """Return the size of the largest strain."""
        return float(np.abs(self.columns[MEASURED[kind][0]]).max())


def read_tests(file: Path, kind: ElementTest, stress: float | None) -> list[LabTest]:
    """Return the tests of a table: rows of one name, or of one consolidation stress, are one test.

    ``stress`` (Pa) is that of a table without a column of it. Compression is positive.

    Raises UserInputError: one problem per thing that is wrong with the table; units, signs and loops among them.
    """
    strain, measured = MEASURED[kind]
    table = one_table(file, COLUMNS, "a laboratory test")
    for name in (strain, measured[0]):
        if name not in table:
            shown = next(each.shown for each in COLUMNS if each.name == name)
            table.fault(None, None, f"no column '{shown}': a {kind} test needs it")
    if "stress_Pa" not in table and stress is None:
        table.fault(None, None, "no column 'stress [kPa]' of the consolidation stress: add it, or give one --stress")
    for name in (strain, "volumetric_strain"):
        table.fault_without_unit(name, exact=True)
    table.faults.stop()
    values = {name: table.numbers(name, most=False) for name in (strain, *measured) if name in table}
    stresses = table.numbers("stress_Pa") if "stress_Pa" in table else np.full(len(table), stress)
    names = table.texts("test") if "test" in table else [f"{each / 1e3:.6g} kPa" for each in stresses]
    for k in np.flatnonzero(~(stresses > 0.0)).tolist():
        table.fault(k, "stress_Pa", "a consolidation stress must be positive")
    for k in np.flatnonzero(np.isnan(values[strain]) | np.isnan(values[measured[0]])).tolist():
        table.fault(k, strain, "needs a number here and for the stress")
    tests = []
    for name in dict.fromkeys(names):
        rows = np.array([each == name for each in names])
        if rows.sum() < 3 or np.ptp(values[strain][rows]) == 0.0:
            table.fault(int(np.argmax(rows)), None, f"test '{name}' has fewer than 3 rows of different strain")
        if np.ptp(stresses[rows]) > 0.0:
            table.fault(int(np.argmax(rows)), "stress_Pa", f"test '{name}' has several consolidation stresses")
        tests.append(LabTest(name, float(stresses[rows][0]), {key: each[rows] for key, each in values.items()}))
        _check(table, np.flatnonzero(rows), tests[-1], kind)
    table.faults.stop()
    return tests


MOST_STRESS = 200.0  # of a measured stress over that of consolidation
_FALL = 0.02  # of the largest strain: a reading that scatters


def _check(table: Table, rows: NDArray[np.intp], test: LabTest, kind: ElementTest) -> None:
    """Note strains, signs and stresses of a test that have another unit or sign, loops, and two tests in one."""
    name, (first, *_) = MEASURED[kind]
    turn = -1.0 if kind == "triaxial-extension" else 1.0
    strain, stress = np.abs(test.columns[name]), turn * test.columns[first]
    if not (np.isfinite([strain, stress]).all() and test.stress > 0.0):
        return  # noted already
    if strain.max() > 1.0:
        text = f"a strain of {100.0 * strain.max():.4g} %, beyond 100 %: is the unit right, [%] or [-]?"
        table.fault(int(rows[strain.argmax()]), name, text)
    if name == "axial_strain" and "volumetric_strain" in test.columns and turn * test.columns[name].sum() < 0.0:
        k = int(strain.argmax())
        text = f"{100.0 * test.columns[name][k]:.4g} %: axial and volumetric strain are positive in compression"
        table.fault(int(rows[k]), name, text)
    if stress.min() < -0.1 * max(float(stress.max()), 0.0):
        sign = "negative in extension" if turn < 0.0 else "positive in compression"
        value = f"{1e-3 * test.columns[first][stress.argmin()]:.4g} kPa"
        text = f"{value}: this stress is {sign}; leave out rows without a value"
        table.fault(int(rows[stress.argmin()]), first, text)
    elif kind != "oedometer" and not 1.0 / MOST_STRESS < (share := stress.max() / test.stress) < MOST_STRESS:
        text = f"{1e-3 * stress.max():.4g} kPa is {share:.3g} times the consolidation stress: are the units right?"
        table.fault(int(rows[stress.argmax()]), first, text)
    back = np.maximum.accumulate(strain) - strain > _FALL * strain.max()
    if back.any() and (np.diff(strain) > 0.0).any():
        k = int(back.argmax())
        text = f"the strain falls to {100.0 * strain[k]:.4g} %: two tests need a column 'test', and loops are left out"
        table.fault(int(rows[k]), name, text)


def residuals(test: LabTest, curve: Curve | None, kind: ElementTest, drainage: str) -> list[Array]:
    """Return computed less measured values, an array (n,) a column, each over the column's largest and sqrt(n).

    Of volumetric strain at least 1 % counts as the largest, of an undrained test the pore pressure in its place, of a
    law in total stress the first column of `MEASURED` alone. A curve that ends early, or is None, is 100 % away from
    the values beyond.
    """
    strain, measured = MEASURED[kind]
    columns = {} if curve is None else curve.columns()
    at, left_out = np.abs(test.columns[strain]), "volumetric_strain" if drainage == "undrained" else "pore_pressure_Pa"
    counted, out = measured[:1] if drainage == TOTAL else measured, []
    for name in (each for each in counted if each in test.columns and each != left_out):
        good = np.isfinite(test.columns[name])
        value, least = test.columns[name][good], 0.01 if name == "volumetric_strain" else 1.0
        scale = max(float(np.abs(value).max(initial=0.0)), least)
        away = np.full(len(value), scale)
        if curve is not None:
            reached = at[good] <= np.abs(columns[strain][-1]) * (1.0 + 1e-6)
            found = np.interp(at[good], np.abs(columns[strain]), columns[name])
            away = np.where(reached, found - value, away)
        out.append(away / scale / np.sqrt(max(len(value), 1)))
    return out


_SPAN = 1.0e3  # a key moves by this factor at most
_STEP = 1.0e-3  # of finite differences: increments of a test follow the strains of its schedule
_AT_BOUND = 1.0e-3
_KNOWN = 1.0e-5  # least change of the residuals with a key, its logarithm or its unit: next to none is rounding
_PART = 1.0e-2  # of a key in a combination of keys that changes nothing


@dataclass(frozen=True)
class Fitted:
    """A key with its value before and after in ``unit``, standard error, and whether it ended at a bound.

    error : NaN where the data do not determine the key.
    at_bound : its range ends there, or the checks of the law refuse what is beyond.
    """

    key: str
    unit: str
    before: float
    value: float
    error: float
    at_bound: bool


@dataclass(frozen=True)
class Fit:
    """Fitted keys; root mean square residuals before and after, of the largest measured value; correlations (n, n).

    Correlations of keys that the data do not determine are NaN.
    """

    keys: tuple[Fitted, ...]
    before: float
    after: float
    correlation: Array
    values: dict[str, Any]
    converged: bool


def known_keys(stratum: Stratum) -> list[str]:
    """Return the keys of a layer that can be fitted: its numbers that its law uses."""
    law = SOIL_LAWS[stratum.law]
    values = law.derived(stratum, np.array(stratum.top)) | stratum.values
    own = [name for name in (*law.stiffnesses, "poisson_ratio", *law.keys) if name in values]
    return [name for name in dict.fromkeys(own) if _number(values[name]) is not None]


def _number(value: Any) -> float | None:
    """Return the number that scales a value: itself, or the reference of one by depth or stress."""
    if isinstance(value, ByDepth):
        return value.reference
    return value if isinstance(value, float) else None


def _with(value: Any, number: float) -> Any:
    return replace(value, reference=number) if isinstance(value, ByDepth) else number


def bounds_of(key: str, start: float) -> tuple[float, float]:
    """Return the bounds of a key in SI: its interval, and a factor of 1000 about a positive start."""
    scale = _unit_of(key)[1]
    low, high = (scale * float(each) for each in Interval(plain_field(key).interval).bounds)
    if low >= 0.0 and start > 0.0:
        low, high = max(low, start / _SPAN), min(high, start * _SPAN)
    return low, high


def fit(
    stratum: Stratum, kind: ElementTest, depth: float, undrained: bool, tests: Sequence[LabTest], keys: Sequence[str]
) -> Fit:
    """Fit keys of a layer to tests of one kind; ``keys`` are some of `known_keys`, with numbers within their bounds.

    Positive keys move by their logarithm, others in their unit about 1, so that a key that starts from 0 has a step of
    differences. Values that the checks of the law refuse, or that stop a test, count as
    100 % away from each measured value.

    Raises UserInputError: no more measured values beyond the first strain than keys.
    """
    from scipy.optimize import least_squares

    strain, measured = MEASURED[kind]
    known = (np.isfinite(test.columns[name]) & (test.columns[strain] != 0.0)
             for test in tests for name in measured if name in test.columns)  # fmt: skip
    if (count := int(sum(each.sum() for each in known))) <= len(keys):
        raise refused_argument("--fit", f"{len(keys)} keys need more measured values beyond a strain of 0 than {count}")
    values = SOIL_LAWS[stratum.law].derived(stratum, np.array(depth)) | stratum.values
    start = np.array([_number(values[key]) for key in keys], dtype=float)
    low, high = np.array([bounds_of(key, value) for key, value in zip(keys, start, strict=True)]).T
    logs, unit = (low > 0.0) & (start > 0.0), np.array([_unit_of(key)[1] for key in keys])

    def coordinates(x: Array) -> Array:
        return np.where(logs, np.log(np.where(logs, x, 1.0)), 1.0 + x / unit)

    def numbers(c: Array) -> Array:
        return np.where(logs, np.exp(np.where(logs, c, 0.0)), (c - 1.0) * unit)

    def changed_to(c: Array) -> dict[str, Any]:
        return {key: _with(values[key], float(x)) for key, x in zip(keys, numbers(c), strict=True)}

    def misfit(c: Array) -> Array:
        return _misfit(stratum, kind, depth, undrained, tests, changed_to(c))

    def is_beyond(c: Array) -> bool:
        points = (specimen(stratum, KINDS[kind], test.stress, depth, changed_to(c)) for test in tests)
        inside = (bounds[0] < c) & (c < bounds[1])
        return not inside.all() or any(refused(point, depth) for point in points)

    first, bounds = misfit(coordinates(start)), (coordinates(low), coordinates(high))
    found = least_squares(misfit, coordinates(start), bounds=bounds, diff_step=_STEP, x_scale="jac")
    span, after = bounds[1] - bounds[0], numbers(found.x)
    steps = np.diag(np.fmax(_AT_BOUND * np.where(logs, span, np.fmin(span, 1.0)), _STEP * np.abs(found.x)))
    near = [(is_beyond(found.x - step), is_beyond(found.x + step)) for step in steps]
    variance = (found.fun @ found.fun) / max(len(found.fun) - len(keys), 1)
    spread, correlation = _errors(_slopes(found, misfit, steps, near), variance)
    error = spread * np.where(logs, after, unit)
    fitted = []
    for key, before, value, off, at_bound in zip(keys, start, after, error, near, strict=True):
        own, scale = _unit_of(key)
        fitted.append(Fitted(key, own, before / scale, value / scale, off / scale, any(at_bound)))
    return Fit(tuple(fitted), float(np.linalg.norm(first)), float(np.linalg.norm(found.fun)), correlation,
               changed_to(found.x), found.status > 0)  # fmt: skip


def _slopes(found: Any, misfit: Callable[[Array], Array], steps: Array, beyond: list[tuple[bool, bool]]) -> Array:
    """Return the slopes (m, n) of the residuals where a search ended; those of a key at a bound by a step inwards.

    A difference across a bound, beyond which the law refuses all, is none of the data.
    """
    slopes = np.array(found.jac)
    for k, (below, above) in enumerate(beyond):
        if below != above:
            inward = steps[k] if below else -steps[k]
            slopes[:, k] = (misfit(found.x + inward) - found.fun) / inward[k]
    return slopes


def _errors(jac: Array, variance: float) -> tuple[Array, Array]:
    """Return standard errors (n,) and correlations (n, n) of coordinates; NaN of those that change no residual.

    A combination of keys that changes none leaves all of them open.
    """
    _, sizes, turns = np.linalg.svd(jac, full_matrices=False)
    known = sizes > _KNOWN
    covariance = variance * (turns[known].T / sizes[known] ** 2) @ turns[known]
    covariance[(np.abs(turns[~known]) > _PART).any(axis=0)] = np.nan
    spread = np.sqrt(np.diag(covariance))
    with np.errstate(divide="ignore", invalid="ignore"):
        return spread, covariance / np.outer(spread, spread)


def _unit_of(key: str) -> tuple[str, float]:
    """Return the unit of a key and its size in SI."""
    unit = plain_field(key).unit
    return unit, 1.0 if unit == "1" else read(f"1 {unit}", si_of(unit))


def _misfit(
    stratum: Stratum,
    kind: ElementTest,
    depth: float,
    undrained: bool,
    tests: Sequence[LabTest],
    changed: dict[str, Any],
) -> Array:
    """Return the differences of all tests; their length is the root mean square over columns and tests."""
    parts = []
    for test in tests:
        point = specimen(stratum, KINDS[kind], test.stress, depth, changed)
        last = test.last_strain(kind)
        curve = None if refused(point, depth) else element_test(point, KINDS[kind], depth, undrained, last)
        parts += residuals(test, curve, kind, drainage_of(stratum, undrained))
    return np.concatenate(parts) / np.sqrt(len(parts))


def refused(stratum: Stratum, depth: float) -> list[str]:
    """Return what the checks of the law find wrong with the values of a layer at a depth (m)."""
    z = np.array(depth)
    values = {name: float(stratum.value(name, z)) for name in (*stratum.values, "young_modulus")}
    soil = dict.fromkeys(LAW_KEYS) | values | stratum.tables | {"surcharge": stratum.above}
    found = SOIL_LAWS[stratum.law].faults(SimpleNamespace(**soil), (stratum.above, stratum.above))
    return [f"{'.'.join(map(str, clash.keys[0]))}: {clash.message}" for clash in found]


# column -> its axis, and the factor to the unit there
_AXES = {
    "axial_strain": ("axial strain [%]", 100.0), "shear_strain": ("shear strain [%]", 100.0),
    "volumetric_strain": ("volumetric strain [%], compression positive", 100.0),
    "q_Pa": ("deviator stress q [kPa]", KPA), "p_Pa": ("mean effective stress p' [kPa]", KPA),
    "shear_stress_Pa": ("shear stress [kPa]", KPA), "axial_stress_Pa": ("axial effective stress [kPa]", KPA),
    "pore_pressure_Pa": ("excess pore pressure [kPa]", KPA),
}  # fmt: skip
_IN_TOTAL = {"p_Pa": "mean total stress p [kPa]", "axial_stress_Pa": "axial total stress [kPa]"}
_COLOURS = (BLUE, VERMILLION, GREEN, ORANGE, PURPLE)


def _label(column: str, curves: Sequence[Curve]) -> str:
    """Return the axis of a column: a law in total stress has no effective one."""
    total = all(curve.drainage == TOTAL for curve in curves)
    return _IN_TOTAL.get(column, _AXES[column][0]) if total else _AXES[column][0]


@styled
def element_picture(
    curves: Sequence[Curve], names: Sequence[str], tests: Sequence[LabTest], kind: ElementTest, title: str
) -> Figure:
    """Draw curves (lines) beside the tests of the same place in the list (dots)."""
    strain, measured = MEASURED[kind]
    wet = any(curve.drainage == "undrained" for curve in curves)
    path = ("axial_stress_Pa", measured[0]) if kind == "dss" else ("p_Pa", "q_Pa")
    panels = ((strain, measured[0]), (strain, "pore_pressure_Pa" if wet else "volumetric_strain"), path)
    figure = new_figure(13.0, 4.6)
    for axes, (x, y) in zip(figure.subplots(1, 3), panels, strict=True):
        for k, (curve, name) in enumerate(zip(curves, names, strict=True)):
            columns, colour = curve.columns(), _COLOURS[k % len(_COLOURS)]
            axes.plot(_AXES[x][1] * columns[x], _AXES[y][1] * columns[y], color=colour, label=plain(name))
            if tests and {x, y} <= set(tests[k].columns):
                data = tests[k].columns
                every = slice(None, None, max(len(data[x]) // 60, 1))
                points = _AXES[x][1] * data[x][every], _AXES[y][1] * data[y][every]
                axes.plot(*points, linestyle="", marker="o", markersize=3.0, color=colour, alpha=0.6)
        axes.set(xlabel=_label(x, curves), ylabel=_label(y, curves))
        axes.margins(x=0.02)
        if np.ptp(axes.get_ylim()) == 0.0:
            axes.set_ylim(-1.0, 1.0)
    figure.axes[0].legend(fontsize=8)
    figure.suptitle(plain(title + ("; dots: data" if tests else "")))
    return figure


@dataclass(frozen=True)
class Request:
    """Tests that are asked for: of a layer with values at a depth (m), from consolidation stresses (Pa), or of data.

    ``stresses`` without any: the stress of the layer there. ``strain``: the last one; None is that of the kind, or of
    the data. ``keys`` are fitted to the data.
    """

    stratum: Stratum
    kind: ElementTest
    depth: float
    undrained: bool = False
    stresses: tuple[float, ...] = ()
    strain: float | None = None
    tests: tuple[LabTest, ...] = ()
    keys: tuple[str, ...] = ()


@dataclass(frozen=True)
class Outcome:
    """Curves by test, with their names and the fit of keys."""

    request: Request
    names: list[str]
    curves: list[Curve]
    fit: Fit | None

    @property
    def stopped(self) -> list[str]:
        """Sentences on tests that did not reach their last strain."""
        return [f"{name}: {each.stopped}" for name, each in zip(self.names, self.curves, strict=True) if each.stopped]

    @property
    def stress(self) -> str:
        """Which stress `peak_Pa` and `end_Pa` of the rows are, in words."""
        return _label(MEASURED[self.request.kind][1][0], self.curves).removesuffix(" [kPa]")

    @cached_property
    def rows(self) -> list[dict[str, Any]]:
        """Rows of the summary, in SI: largest stress and where, the state at the end, distance from data."""
        request, out = self.request, []
        strain, measured = MEASURED[request.kind]
        for k, (name, curve) in enumerate(zip(self.names, self.curves, strict=True)):
            stress = (columns := curve.columns())[measured[0]]
            at = int(np.argmax(np.abs(stress)))
            row = {"test": name, "drainage": curve.drainage, "stress_Pa": curve.consolidation, "stopped": curve.stopped}
            row |= {"peak_Pa": stress[at], "strain_at_peak": columns[strain][at], "end_Pa": stress[-1]}
            if not request.stratum.total_stress:
                row |= {"mobilised_angle_deg": np.degrees(np.nanmax(columns["mobilised_angle_rad"]))}
                row |= {"pore_pressure_Pa": columns["pore_pressure_Pa"][-1]}
            row |= {"volumetric_strain": columns["volumetric_strain"][-1]}
            if request.tests:
                parts = residuals(request.tests[k], curve, request.kind, curve.drainage)
                row["away"] = float(np.sqrt(np.mean([each @ each for each in parts])))
            out.append({key: float(value) if isinstance(value, np.floating) else value for key, value in row.items()})
        return out

    def table(self) -> pd.DataFrame:
        """Return all states in SI, one a row."""
        frames = []
        for name, curve in zip(self.names, self.curves, strict=True):
            frame = pd.DataFrame(curve.columns())
            frames.append(frame.assign(test=name, drainage=curve.drainage, stress_Pa=curve.consolidation))
        frame = pd.concat(frames, ignore_index=True)
        return frame[["test", "drainage", "stress_Pa", *self.curves[0].columns()]]


def run(request: Request) -> Outcome:
    """Fit keys where any are asked for, and run the tests with what was fitted.

    Raises UserInputError: a consolidation stress is outside the law's strength, or its initial yield surface.
    """
    kind, fitted = KINDS[request.kind], None
    if request.keys:
        fitted = fit(request.stratum, request.kind, request.depth, request.undrained, request.tests, request.keys)
        request = replace(request, stratum=replace(request.stratum, values=request.stratum.values | fitted.values))
    curves, names = [], []
    for stress, name, last in _asked(request):
        point = specimen(request.stratum, kind, stress, request.depth)
        if wrong := refused(point, request.depth):
            at = "; ".join([f"consolidated under {point.above / 1e3:.6g} kPa at K0", *wrong])
            raise refused_argument("--data" if request.tests else "--stress", at)
        curves.append(element_test(point, kind, request.depth, request.undrained, last))
        names.append(name or f"{curves[-1].consolidation / 1e3:.6g} kPa")
    return Outcome(request, names, curves, fitted)


def _asked(request: Request) -> list[tuple[float | None, str, float | None]]:
    """Return consolidation stress, name and last strain of each test."""
    if request.tests:
        return [(test.stress, test.name, request.strain or test.last_strain(request.kind)) for test in request.tests]
    return [(stress, "", request.strain) for stress in request.stresses or (None,)]


def write(outcome: Outcome, folder: Path, formats: Sequence[str]) -> list[Path]:
    """Write element.csv and the picture; return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    file, request = folder / "element.csv", outcome.request
    write_text(outcome.table().to_csv(index=False, float_format="%.9g", lineterminator="\n"), file)
    title = f"{KINDS[request.kind].name}, layer {request.stratum.name}, law {request.stratum.law}"

    def draw() -> Any:
        return element_picture(outcome.curves, outcome.names, request.tests, request.kind, title)

    return [file, *redraw(draw, folder / "element", formats)]
