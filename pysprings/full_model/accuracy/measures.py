# SPDX-License-Identifier: MIT
"""Errors of a run beside a reference, each one number in percent (see `MEASURES`), and the reference itself.

A quantity Q on meshes of cell size h1 > h2 > h3 is taken as Q = Q* + C h^p (Richardson 1911). The order p solves

    (Q1 - Q2)/(Q2 - Q3) = (h1^p - h2^p)/(h2^p - h3^p)

(Roache 1994, for unequal ratios of h). Of a curve, the left side is the ratio of the differences in the sense of least
squares, d12.d23/d23.d23, one order for the whole curve.

Curves: runs of one scene on other meshes, or with other steps, stop at other states and have other depths. They are
compared at POINTS equally spaced displacements from 0 (not counted) to the end that all of them reach, and p(y) at as
many values of y in SLICES equal slices of the skirt. Between recorded steps the curves are monotone cubic (Fritsch &
Carlson 1980, SciPy's PchipInterpolator): straight lines between the steps of one run and the steps of another would
differ by more than the meshes do. A path that turns back (`then`) is compared up to where it turns. What drives a path
and what answers depends on its kind (`core.path_kinds`). A path on which H and M do not grow in proportion (a swipe, a
load that climbs) is followed along |u| + |rotation| L, as in `macro.comparison`.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pysprings.core.arrays import Array
from pysprings.core.path_kinds import PATH_KINDS, direction_of_load, kind_of
from pysprings.macro.measures import eta
from pysprings.springs.path import RecordedPath, paths_of
from pysprings.springs.tip_zone import distributed_like, on_line

# The contact pressure is sought down to this share of the skirt: at its tip the exact one is singular in elastic soil,
# and the largest value there depends on how fine the mesh is, without a limit.
PRESSURE_DOWN_TO = 0.9
_PRESSURE_DEPTHS = 19


def driver_of(path: xr.Dataset, length: float) -> Array:
    """Return the size of what drives a path, (step,): m, or rad on a rotation path; L = ``length`` in m."""
    kind = kind_of(path.attrs)
    if along := direction_of_load(path.attrs):
        conjugate = along[0] * path["u"].values + along[1] * path["rotation"].values
        return np.abs(conjugate - conjugate[0])
    if kind.bends:
        return np.abs(path["u"].values) + length * np.abs(path["rotation"].values)
    return np.abs(path[kind.drives].values - path[kind.drives].values[0])


def load_of(path: xr.Dataset) -> Array:
    """Return the load that answers what is driven, (step,): H [N], M [N m] of a rotation, change of V [N].

    Of a load that keeps its direction it is its size [N].

    Of a translation with a rotation in proportion to u it is H + M rotation/u, the work of both loads over u: H alone
    may cross zero on such a path.
    """
    kind = kind_of(path.attrs)
    if along := direction_of_load(path.attrs):
        return (along[0] * path["H"].values + along[1] * path["M"].values) / (along[0] ** 2 + along[1] ** 2)
    values: Array = path[kind.load].values
    if kind.load == "V":
        return values - values[0]
    return values + _turn(path) * path["M"].values if kind.straight and kind.drives == "u" else values


def _turn(path: xr.Dataset) -> float:
    """Return the rotation over u (rad/m) of a straight path that moves the lid centre."""
    u, rotation = path["u"].values[-1], path["rotation"].values[-1]
    return float(rotation / u) if u else 0.0


def other_of(path: xr.Dataset) -> Array | None:
    """Return the second answer, (step,): the rotation of a free head [rad], else M [N m], H [N] of a rotation.

    None of vertical paths, and of a load that keeps its direction.
    """
    name = None if direction_of_load(path.attrs) else kind_of(path.attrs).companion
    return None if name is None else path[name].values


def pressure_of(path: xr.Dataset, length: float) -> Array | None:
    """Return the largest effective contact pressure on the skirt, (step,) Pa, to 0.9 of its length; None: not kept.

    Pressure is positive; the largest is over both sides, all azimuths and _PRESSURE_DEPTHS depths, the same on every
    mesh. Linear between the depths of the rings.
    """
    if "normal_effective_stress" not in path:
        return None
    share = _linear_shares(path["depth"].values, np.linspace(0.0, PRESSURE_DOWN_TO * length, _PRESSURE_DEPTHS))
    stress = path["normal_effective_stress"].transpose("step", "side", "azimuth", "depth").values
    return np.asarray((stress @ share).max(axis=(1, 2, 3)), dtype=float)


def slice_curves(path: xr.Dataset, length: float, n: int) -> tuple[Array, Array]:
    """Return y [m] and p [N/m] of n equal slices of the skirt, (n, step) each.

    p is the force on the slice over its height. The force above a depth is known at the bounds of the rings; between
    them it is a cubic spline, so that sums of p dz stay what they are and slices may end inside a ring. y is that of
    the middle of the slice.
    """
    from scipy.interpolate import CubicSpline

    edges = np.linspace(0.0, length, n + 1)
    bounds = path["depth_bounds"].values
    forces = path["p"].transpose("depth", "step").values * np.diff(bounds, axis=1)
    above = np.concatenate([np.zeros_like(forces[:1]), np.cumsum(forces, axis=0)])
    force = CubicSpline(np.append(bounds[:, 0], bounds[-1, 1]), above)
    p = np.diff(force(np.clip(edges, bounds[0, 0], bounds[-1, 1])), axis=0) / np.diff(edges)[:, None]
    y = path["y"].transpose("depth", "step").values
    middle = [on_line(path["depth"].values, y - y[:, :1], z) for z in 0.5 * (edges[1:] + edges[:-1])]
    return np.stack(middle), p


def on_finer_slices(path: xr.Dataset, finer: xr.Dataset, length: float) -> xr.Dataset:
    """Return p and y of a path in the slices of a finer mesh, where p varies in each of its own as on that mesh.

    A spline through few slices overshoots where p jumps from layer to layer. Without two states of the finer mesh that
    move on the path is returned as it is.
    """
    of = driver_of(finer, length) if finer.sizes["step"] else np.zeros(0)
    on = leading(of)
    if on.size < 2:
        return path
    like = _between(of[on], finer["p"].transpose("step", "depth").values[on], driver_of(path, length)).T
    bounds, slices = path["depth_bounds"].values, finer["depth_bounds"].values
    p = distributed_like(like, slices, path["p"].transpose("depth", "step").values, bounds)
    y = path["y"].transpose("depth", "step").values
    y = np.stack([on_line(path["depth"].values, y, z) for z in finer["depth"].values])
    values = {"p": (("depth", "step"), p), "y": (("depth", "step"), y), "depth_bounds": (("depth", "side"), slices)}
    return xr.Dataset(values, {"depth": finer["depth"].values})


def _linear_shares(depth: Array, at: Array) -> Array:
    """Return the shares (depth, at) of values by depth in those at other depths: linear between, constant beyond."""
    return np.stack([np.interp(at, depth, row) for row in np.eye(depth.size)])


def initial_stiffness(stiffness: Array, path: xr.Dataset) -> float:
    """Return the slope of the load over what is driven at rest, from the stiffness (3, 3) in u, w, rotation.

    H/u [N/m] under a load at its arm (at the first one, of a load that climbs), or of a swipe with the ratio of
    rotation and u of its first step; (H + M rotation/u)/u of a translation; M/rotation [N m/rad] about the lid centre;
    V/w [N/m]; of a load that keeps its direction, its size over the displacement conjugate to it [N/m].
    """
    kind, heave_free = PATH_KINDS[str(path.attrs["kind"])], path.attrs.get("heave", "free") == "free"
    if kind.drives == "w":
        return float(stiffness[1, 1])
    K = stiffness[np.ix_([0, 2], [0, 2])]
    if heave_free:  # w follows so that V stays
        K = K - np.outer(stiffness[[0, 2], 1], stiffness[1, [0, 2]]) / stiffness[1, 1]
    if along := direction_of_load(path.attrs):
        return float(1.0 / (along @ np.linalg.solve(K, along)))
    if kind.free_head:
        arm = float(path.attrs.get("arm_from_m", path.attrs["arm_m"]))
        return float(1.0 / np.linalg.solve(K, np.array([1.0, arm]))[0])
    if kind.drives == "rotation":
        return float(K[1, 1])
    if kind.straight:
        turn = _turn(path)
        return float(K[0, 0] + (K[0, 1] + K[1, 0]) * turn + K[1, 1] * turn**2)
    u, rotation = path["u"].values[1], path["rotation"].values[1]
    return float(K[0, 0] + K[0, 1] * (rotation / u if u else 0.0))


def first_secant(stiffness: Array, path: xr.Dataset) -> float | None:
    """Return the secant of the first increment over the initial stiffness (`initial_stiffness`).

    None of a path that bends, and of one without an increment.
    """
    driven = path[kind_of(path.attrs).drives].values
    if kind_of(path.attrs).bends or driven.size < 2 or driven[1] == driven[0]:
        return None
    secant = (load_of(path)[1] - load_of(path)[0]) / (driven[1] - driven[0])
    return float(secant) / initial_stiffness(stiffness, path)


POINTS = 40
_IMPOSED = {"twist": ("rot_z",), "pull": ("u_x", "u_y")}  # motions along which paths off a plane are compared
_ALL_BUT_W = ("u_x", "u_y", "rot_x", "rot_y", "rot_z")
SLICES = 8
# A slice is left out where its y stays below this share of the largest: p(y) there is that of the point of rotation.
SMALL_Y = 0.05

LOAD, OTHER, PY, STIFFNESS, PRESSURE = "load", "rotation", "py", "stiffness", "pressure"
QUANTITIES = (LOAD, PY, OTHER, STIFFNESS, PRESSURE)


@dataclass(frozen=True)
class Curve:
    """A path of one run: ``x`` (n,) what drives it, from 0 and growing; by state (n,) or slice and state (k, n).

    ``by_x`` maps LOAD, OTHER and PRESSURE to their values, without those that the path does not have; y [m] and
    p [N/m] are means of the slices; ``stiffness`` is the slope of the load at rest.
    """

    x: Array
    by_x: Mapping[str, Array]
    y: Array
    p: Array
    stiffness: float


@dataclass(frozen=True)
class Grid:
    """Where runs are compared on a path: ``x`` (POINTS,), and ``y`` (k, POINTS), NaN in slices that are left out."""

    x: Array
    y: Array


Sample = dict[str, Array]
"""Values of the quantities on a grid; NaN where a slice is left out."""


def curves_of(
    result: xr.DataTree, of_mesh: bool = False, finer: Mapping[str, RecordedPath] = MappingProxyType({})
) -> dict[str, Curve]:
    """Return the curves of a full-model result, by path; paths without two states that move on are left out.

    ``of_mesh``: those of its own mesh, not the extrapolated ones (`springs.path.paths_of`). ``finer``: paths of a finer
    mesh, in whose slices p is taken (`on_finer_slices`).
    """
    curves = {}
    for name, recorded in paths_of(result, of_mesh).items():
        path = recorded.dataset
        if path.sizes["step"] < 2:  # stopped during its dead load or in its first step
            continue
        length = float(result.attrs["skirt_length_m"])
        x = driver_of(path, length)
        rising = leading(x)
        if rising.size < 2:
            continue
        sliced = on_finer_slices(path, finer[name].dataset, length) if name in finer else path
        y, p = slice_curves(sliced, length, SLICES)
        y = np.zeros_like(y) if recorded.is_vertical else y  # to rounding: no p(y)
        by_x = {LOAD: load_of(path), OTHER: other_of(path), PRESSURE: pressure_of(path, length)}
        curves[name] = Curve(
            x[rising],
            {key: values[rising] for key, values in by_x.items() if values is not None},
            y[:, rising],
            p[:, rising],
            initial_stiffness(result.dataset["stiffness_initial"].values, path),
        )
    return curves


def leading(x: Array) -> NDArray[np.int_]:
    """Return the numbers of the states that lead on from the first one; states that repeat a value are skipped.

    >>> leading(np.array([0.0, 1.0, 1.0, 2.0, 1.5, 3.0])).tolist()
    [0, 1, 3]
    """
    rising = [0]
    for k in range(1, x.size):
        if x[k] > x[rising[-1]]:
            rising.append(k)
        elif x[k] < x[rising[-1]]:
            break
    return np.array(rising, dtype=int)


def common_grid(curves: Sequence[Curve]) -> Grid:
    """Return the points where all of these runs of one path have a value."""
    end = min(float(curve.x[-1]) for curve in curves)
    share = np.arange(1, POINTS + 1) / POINTS
    ends = np.array([_y_ends(curve) for curve in curves])  # (runs, k)
    reach = np.abs(ends).min(axis=0)
    same_sign = np.abs(np.sign(ends).sum(axis=0)) == len(curves)
    usable = same_sign & (reach >= SMALL_Y * reach.max(initial=0.0)) & (reach > 0.0)
    y = np.where(usable, np.sign(ends[0]) * reach, np.nan)[:, None] * share
    return Grid(end * share, y)


def sampled(curve: Curve, grid: Grid) -> Sample:
    """Return the quantities of a run on a grid that its curves reach."""
    values = {name: _between(curve.x, values, grid.x) for name, values in curve.by_x.items()}
    values[PY] = np.full(grid.y.shape, np.nan)
    for k, y in enumerate(grid.y):
        if np.isfinite(y).all():
            sign = np.sign(y[-1])
            rising = leading(sign * curve.y[k])
            values[PY][k] = _between(sign * curve.y[k, rising], curve.p[k, rising], sign * y)
    values[STIFFNESS] = np.array([curve.stiffness])
    return values


def common_grids(runs: Mapping[str, Mapping[str, Curve]]) -> dict[str, Grid]:
    """Return {path: grid} of runs {run: {path: curve}}, for the paths that all of them have."""
    paths = [name for name in next(iter(runs.values())) if all(name in curves for curves in runs.values())]
    return {path: common_grid([curves[path] for curves in runs.values()]) for path in paths}


def samples(
    runs: Mapping[str, Mapping[str, Curve]], grids: Mapping[str, Grid] | None = None
) -> dict[str, dict[str, Sample]]:
    """Return {path: {run: sample}} of runs {run: {path: curve}} on grids that all reach (None: the common ones)."""
    return {
        path: {run: sampled(curves[path], grid) for run, curves in runs.items()}
        for path, grid in (common_grids(runs) if grids is None else grids).items()
    }


def off_plane_error(fine: xr.Dataset, coarse: xr.Dataset, length: float, radius: float) -> float:
    """Return the difference of two runs of a path off a plane [%]; NaN without two states that move on.

    It is the largest one of the vectors (H_x, H_y, M_x/L, M_y/L, T/R) after equal ways, over the largest vector, at the
    states of the finer mesh; straight lines between those of the other one pass corners, where both have a state.
    """
    (x, loads), (other, others) = (_way_and_loads(path, length, radius) for path in (fine, coarse))
    if min(x.size, other.size) < 2:
        return float("nan")
    met = x <= other[-1] * (1.0 + 1e-9)
    theirs = np.stack([np.interp(x[met], other, column) for column in others.T], axis=1)
    sizes = [np.linalg.norm(each, axis=1).max() for each in (theirs - loads[met], loads[met])]
    return float(100.0 * sizes[0] / sizes[1]) if sizes[1] else float("nan")


def _way_and_loads(path: xr.Dataset, length: float, radius: float) -> tuple[Array, Array]:
    """Return the way along what a path off a plane imposes [m], rising, and its loads (step, 5) [N]; L and R in m."""
    sizes = {"rot_x": length, "rot_y": length, "rot_z": radius, "M_x": length, "M_y": length, "T": radius}
    names = _IMPOSED.get(str(path.attrs["kind"]), _ALL_BUT_W)
    motion = np.stack([path[name].values * sizes.get(name, 1.0) for name in names], axis=1)
    steps = np.linalg.norm(np.diff(motion, axis=0), axis=1)
    loads = [path[name].values / sizes.get(name, 1.0) for name in ("H_x", "H_y", "M_x", "M_y", "T")]
    on = np.append(True, steps > 0.0)
    return np.append(0.0, np.cumsum(steps))[on], np.stack(loads, axis=1)[on]


def _y_ends(curve: Curve) -> Array:
    """Return the end (k,) of the first stretch of y that leads away from 0, with its sign; 0 without one."""
    ends = np.zeros(len(curve.y))
    for k, y in enumerate(curve.y):
        sign = np.sign(y[1] - y[0])
        ends[k] = y[leading(sign * y)[-1]] if sign else 0.0
    return ends


def _between(x: Array, values: Array, at: Array) -> Array:
    """Return the monotone cubic through (x, values) at points within their range (rounding beyond it is cut)."""
    from scipy.interpolate import PchipInterpolator

    return np.asarray(PchipInterpolator(x, values)(np.clip(at, x[0], x[-1])), dtype=float)


LOWEST, HIGHEST = 0.5, 4.0  # orders that are believed
NEEDED = 3  # meshes


@dataclass(frozen=True)
class Reference:
    """Limit of a quantity on ever finer meshes: values, and ``beside``, whose distance from them is their uncertainty.

    ``order`` is None where the finest mesh is taken as it is; ``note`` is the cause. ``beside`` is the finest mesh if
    the values are extrapolated from it, else the mesh before it.
    """

    values: Array
    beside: Array
    order: float | None
    note: str

    @property
    def extrapolated(self) -> bool:
        """Whether the values are better than those of the finest mesh."""
        return self.order is not None


def cell_size(unknowns: float, harmonics: int | None = None) -> float:
    """Return the size h of the cells of a mesh with so many unknowns, up to a factor.

    unknowns^(-1/3) of bricks; (unknowns/(N + 1))^(-1/2) of a section with N harmonics.
    """
    if harmonics is not None:
        return (float(unknowns) / (harmonics + 1)) ** -0.5
    return float(unknowns) ** (-1.0 / 3.0)


def order_from(ratio: float, h: Sequence[float]) -> float:
    """Return the order p of three cell sizes h (falling) whose differences have this ratio; NaN outside the range."""
    from scipy.optimize import brentq

    h1, h2, h3 = (value / h[2] for value in h)

    def excess(p: float) -> float:
        return float((h1**p - h2**p) / (h2**p - h3**p)) - ratio

    if not excess(LOWEST) <= 0.0 <= excess(HIGHEST):
        return float("nan")
    return float(brentq(excess, LOWEST, HIGHEST, xtol=1e-12))


def extrapolate(values: Sequence[Array], h: Sequence[float]) -> Reference:
    """Return what values (one array a mesh, the finest last; NaN is left out) tend to as h (falling) goes to 0."""
    finest = values[-1]
    if len(values) == 1:
        return Reference(finest, np.full_like(finest, np.nan), None, "one mesh: nothing to compare it with")
    if len(values) < NEEDED:
        return Reference(finest, values[-2], None, f"{len(values)} meshes: no order, the finest mesh as it is")
    q1, q2, q3 = values[-3:]
    d12, d23 = q1 - q2, q2 - q3
    counted = np.isfinite(d12) & np.isfinite(d23)
    size = float(d23[counted] @ d23[counted])
    if size == 0.0:
        return Reference(finest, q2, None, "the two finest meshes agree: the finest mesh as it is")
    ratio = float(d12[counted] @ d23[counted]) / size
    if ratio <= 0.0:
        return Reference(finest, q2, None, "the differences change sign: the finest mesh as it is")
    p = order_from(ratio, h[-3:])
    if np.isnan(p):
        text = f"the order is not in [{LOWEST:g}, {HIGHEST:g}] (differences {ratio:.3g} to 1): the finest mesh as it is"
        return Reference(finest, q2, None, text)
    return Reference(q3 - d23 / ((h[-2] / h[-1]) ** p - 1.0), q3, p, f"extrapolated with order {p:.2f}")


def _largest(answer: Array, reference: Array) -> float:
    """Return the largest difference over the largest size of the reference; NaN on either side is left out."""
    counted = np.isfinite(answer) & np.isfinite(reference)
    size = np.abs(reference[counted]).max(initial=0.0)
    return float(np.abs(answer - reference)[counted].max() / size) if size else float("nan")


def _rms(answer: Array, reference: Array) -> float:
    """Return the root mean square of the differences over the largest size of the reference; NaN is left out."""
    counted = np.isfinite(answer) & np.isfinite(reference)
    size = np.abs(reference[counted]).max(initial=0.0)
    return float(np.sqrt(np.mean((answer - reference)[counted] ** 2)) / size) if size else float("nan")


def _area(answer: Array, reference: Array) -> float:
    """Return 1 - eta of curves on equally spaced displacements that start at 0."""
    start = [0.0]
    return 1.0 - eta(np.arange(reference.size + 1.0), np.append(start, reference), np.append(start, answer))


class Measure(NamedTuple):
    """How an error is taken: the quantity it belongs to, the head of its column, its words, its value (1, not %)."""

    quantity: str
    head: str
    words: str
    value: Callable[[Array, Array], float]


MEASURES = {
    "load_max": Measure(LOAD, "load max", "load: largest difference over the largest load", _largest),
    "load_area": Measure(LOAD, "load area", "load: area between the curves over the area below (1 - eta)", _area),
    "py_rms": Measure(
        PY, "p-y rms", "p(y): root mean square difference over slices and steps, over the largest p", _rms
    ),
    "py_max": Measure(PY, "p-y max", "p(y): largest difference over the largest p", _largest),
    "rotation_max": Measure(
        OTHER,
        "rotation",
        "rotation (M of a translation, H of a rotation): largest difference over the largest",
        _largest,
    ),
    "stiffness": Measure(STIFFNESS, "stiffness", "initial stiffness", _largest),
    "pressure_max": Measure(
        PRESSURE,
        "pressure",
        "peak contact pressure (to 0.9 of the skirt): largest difference over the largest",
        _largest,
    ),
}


def errors(answer: Sample, reference: Mapping[str, Array]) -> dict[str, float]:
    """Return the errors [%] of a sample beside the values of a reference on the same grid; NaN of what is not there."""
    percent = {}
    for name, measure in MEASURES.items():
        known = measure.quantity in answer and measure.quantity in reference
        value = measure.value(answer[measure.quantity], reference[measure.quantity]) if known else float("nan")
        percent[name] = 100.0 * value
    return percent


def reference_of(series: Sequence[Sample], h: Sequence[float]) -> dict[str, Reference]:
    """Return what each quantity that all samples have tends to, on ever finer meshes with cell sizes h."""
    names = [name for name in series[-1] if all(np.isfinite(sample.get(name, np.nan)).any() for sample in series)]
    return {name: extrapolate([sample[name] for sample in series], h) for name in names}


def uncertainty(reference: Mapping[str, Reference]) -> dict[str, float]:
    """Return the uncertainty [%] of a reference, by measure: what it has been corrected by, or the last difference."""
    beside = {name: each.beside for name, each in reference.items()}
    return errors(beside, {name: each.values for name, each in reference.items()})


def worst(by_path: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Return the largest of each measure over paths; NaN where no path has it."""
    largest = {}
    for name in MEASURES:
        values = [each[name] for each in by_path if np.isfinite(each[name])]
        largest[name] = max(values, default=float("nan"))
    return largest
